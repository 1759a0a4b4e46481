//! VEC to plain values in SI: the contents of the file, without any decision.

use crate::curve::Vector;
use crate::document::{Component, Document, Fixing, Format, Node, Segment};
use crate::elements::{Chosen, Elements, Names};
use crate::error::ImportError;
use crate::findings::Findings;
use crate::options::{Arrangement, Options};
use crate::unit::Quantity;
use crate::vec::element;
use crate::vec::places::{Geometry, Placed};
use crate::xml::{Read, VEC, Xml, child, child_text, children, id, missing, position, text, xml};
use roxmltree::NodeId;
use std::collections::{HashMap, HashSet};
use wireloom_core::identity::Identity;

mod coverings;
mod flat;
mod geometry;
mod modules;
mod parts;
mod placements;
mod tolerances;
mod units;
mod usage;
mod wires;
mod wiring;

pub(super) use modules::contents;

/// Versions whose files are read.
const VERSIONS: [&str; 8] = ["1.2.0", "1.2.1", "1.2.2", "2.0.0", "2.0.1", "2.0.2", "2.1.0", "2.2.0"];

/// Namespace of all of them.
const NAMESPACE: &str = "http://www.prostep.org/ecad-if/2011/vec";

/// Reads a VEC text. Faults of the topology and unreadable numbers are errors, everything else a finding.
pub(super) fn read(text: &str, options: &Options, findings: &mut Findings) -> Result<Document, ImportError> {
    let file = xml(text, &VEC)?;
    let read = Read::with_classes(&file);
    let root = Xml::root(&file, &read);
    let names = Names { value: "ValueComponent", unit: "UnitComponent", segment: "TopologySegment" };
    let classes = classes(root);
    let mut reader = Reader {
        file: Elements::of(text, root, names, findings)?,
        specifications: specifications(&classes),
        classes,
        identities: HashMap::new(),
        copper: HashMap::new(),
        chosen: Chosen::default(),
    };
    let version = reader.read_version(root);
    reader.choose(&options.selection)?;
    reader.read_units(root);
    let routes = reader.read_routes();
    let with_wires = routes.iter().flat_map(|route| &route.segments).copied();
    let of_topology = reader.segments_of_topology();
    let of_harness = reader.file.of_harness(root, of_topology, &options.selection, with_wires)?;
    let geometry = reader.read_geometry()?;
    let placed = reader.read_placements(&of_harness)?;
    let (ids, index) = reader.ends(&of_harness)?;
    let (mut segments, segment_index) = reader.read_segments(&of_harness, &index, &geometry, &placed)?;
    let nodes = reader.read_nodes(&ids, &segments, &geometry, &placed, options.arrangement)?;
    let wires = reader.read_wires(routes, &mut segments, &segment_index)?;
    reader.read_tolerances(&mut segments)?;
    reader.read_bending_restrictions(&mut segments, &segment_index)?;
    reader.note_covered(&segments, &placed)?;
    let (listed, wiring) = (reader.read_listed(&placed), reader.read_wiring());
    let name = reader.name();
    let elements = reader.elements(root);
    let (format, drawn) = (Format::Vec(version), !geometry.nodes.is_empty());
    Ok(Document { format, drawn, name, nodes, segments, wires, listed, wiring, elements })
}

/// Elements with an id, by their class and by their name where it differs, in the order of the file.
type Classes<'a, 'i> = HashMap<&'a str, Vec<Xml<'a, 'i>>>;

fn classes<'a, 'i>(root: Xml<'a, 'i>) -> Classes<'a, 'i> {
    let mut classes: Classes = HashMap::new();
    for node in root.descendants().filter(|node| node.attribute("id").is_some()) {
        for kind in node.kinds() {
            classes.entry(kind).or_default().push(node);
        }
    }
    classes
}

/// Specifications by the ids of the parts that they describe.
fn specifications<'a, 'i>(classes: &Classes<'a, 'i>) -> HashMap<&'a str, Vec<Xml<'a, 'i>>> {
    let mut of: HashMap<&str, Vec<Xml>> = HashMap::new();
    for own in classes.iter().filter(|(class, _)| class.ends_with("Specification")).flat_map(|(_, nodes)| nodes) {
        for part in crate::xml::words(*own, "DescribedPart") {
            of.entry(part).or_default().push(*own);
        }
    }
    for all in of.values_mut() {
        all.sort_by_key(|own| own.id().get_usize());
        // Each is there by its class and as a `Specification`.
        all.dedup_by_key(|own| own.id());
    }
    of
}

struct Reader<'a, 'i, 'f> {
    file: Elements<'a, 'i, 'f>,
    classes: Classes<'a, 'i>,
    specifications: HashMap<&'a str, Vec<Xml<'a, 'i>>>,
    /// Identities of parts, as far as they were asked for.
    identities: HashMap<NodeId, Identity>,
    /// Areas of the conductors of cables, as far as they were asked for, m².
    copper: HashMap<NodeId, f64>,
    /// The parts of the modules that are imported.
    chosen: Chosen<'a>,
}

impl<'a, 'i> Reader<'a, 'i, '_> {
    /// The elements of a class, or of a name.
    fn all(&self, class: &str) -> Vec<Xml<'a, 'i>> {
        self.classes.get(class).into_iter().flatten().map(|node| node.seen()).collect()
    }

    /// The version that the file states; one that is not known is told.
    fn read_version(&mut self, root: Xml<'a, 'i>) -> String {
        let known = VERSIONS.join(", ");
        if root.tag_name().namespace() != Some(NAMESPACE) {
            let (line, column) = position(root);
            let found = root.tag_name().namespace().unwrap_or_default();
            self.file.findings.add(format!(
                "{line}:{column}: the namespace of VecContent is `{found}`, not `{NAMESPACE}`; read nevertheless"
            ));
        }
        let holder = child(root, "VecVersion");
        let version = holder.and_then(text).unwrap_or_default();
        let (line, column) = position(holder.unwrap_or(root));
        if version.is_empty() {
            let what = format!("{line}:{column}: VecContent has no VecVersion; read as VEC 1.2 to 2.2 ({known})");
            self.file.findings.add(what);
        } else if !VERSIONS.contains(&version) {
            self.file.findings.add(format!(
                "{line}:{column}: VecVersion is `{version}`, which is not known (known: {known}); read as far as it is \
                 like these"
            ));
        }
        version.to_owned()
    }

    /// Name of the harness: description or number of the part, or of the document, in which its topology stands.
    fn name(&mut self) -> Option<String> {
        let topology = *self.classes.get("TopologySegment")?.first()?;
        let document = topology.ancestors().find(|node| node.name() == "DocumentVersion")?;
        let mut parts = crate::xml::words(document, "ReferencedPart").filter_map(|id| self.file.ids.get(id).copied());
        let part = parts.next();
        part.into_iter().for_each(|part| self.file.keep(part));
        let described = |node: Xml<'a, 'i>| element::localized(node, "Description");
        part.and_then(described)
            .or_else(|| part.and_then(|part| child_text(part, "PartNumber")))
            .or_else(|| described(document))
            .or_else(|| child_text(document, "DocumentNumber"))
            .map(str::to_owned)
    }

    /// The segments of all topologies but those that others instantiate, as those of assemblies.
    fn segments_of_topology(&mut self) -> Vec<Xml<'a, 'i>> {
        let mut segments = self.all("TopologySegment");
        let instantiated: HashSet<&str> =
            segments.iter().filter_map(|own| child_text(*own, "InstantiatedSegment")).collect();
        for part in segments.extract_if(.., |own| own.attribute("id").is_some_and(|id| instantiated.contains(id))) {
            self.file.keep(part);
            let id = part.attribute("id").unwrap_or_default();
            self.file.findings.add_to("segments are those of a part, which others instantiate; these are taken", id);
        }
        let topologies: HashSet<NodeId> =
            segments.iter().filter_map(|own| own.parent()).map(|topology| topology.id()).collect();
        if topologies.len() > 1 {
            self.file.findings.add(format!("the file has {} topologies; all are taken together", topologies.len()));
        }
        segments
    }

    /// Ids of the nodes at which segments end, in the order of the file, and their indices.
    fn ends(&mut self, segments: &[Xml<'a, 'i>]) -> Result<(Vec<Xml<'a, 'i>>, HashMap<&'a str, usize>), ImportError> {
        let ends = |own: Xml<'a, 'i>| ["StartNode", "EndNode"].map(|name| child_text(own, name)).into_iter().flatten();
        let read: HashSet<&str> = segments.iter().flat_map(|own| ends(*own)).collect();
        let of_all: HashSet<&str> = self.all("TopologySegment").into_iter().flat_map(ends).collect();
        let (mut nodes, mut index) = (Vec::new(), HashMap::new());
        for node in self.all("TopologyNode") {
            let Some(id) = node.attribute("id") else { continue };
            if read.contains(id) {
                index.insert(id, nodes.len());
                nodes.push(node);
            } else if !of_all.contains(id) {
                self.file.findings.add_to("no segment ends at a node; left out", id);
            }
        }
        Ok((nodes, index))
    }

    fn read_segments(
        &mut self,
        of_harness: &[Xml<'a, 'i>],
        nodes: &HashMap<&'a str, usize>,
        geometry: &Geometry<'a, 'i>,
        placed: &Placed<'a, 'i>,
    ) -> Result<(Vec<Segment>, HashMap<&'a str, usize>), ImportError> {
        let (mut segments, mut index) = (Vec::new(), HashMap::new());
        for &segment in of_harness {
            let id = id(segment)?;
            self.file.mark(segment);
            let mut ends = [0; 2];
            for (end, name) in ends.iter_mut().zip(["StartNode", "EndNode"]) {
                let right = "a segment runs from one node to another";
                let node = self.file.required(segment, name, &["TopologyNode"], right)?;
                *end = (node.attribute("id").and_then(|id| nodes.get(id)).copied())
                    .ok_or_else(|| missing(segment, name, right))?;
            }
            if ends[0] == ends[1] {
                let (line, column) = position(segment);
                let node = child_text(segment, "StartNode").unwrap_or_default().to_owned();
                return Err(ImportError::Ring { line, column, id, node });
            }
            let area = match child(segment, "CrossSectionAreaInformation") {
                Some(information) => self.file.value(information, "Area", Quantity::Area)?,
                None => None,
            };
            let lengths = self.read_lengths(segment)?;
            let key = segment.attribute("id").unwrap_or_default();
            index.insert(key, segments.len());
            segments.push(Segment {
                label: child_text(segment, "Identification").unwrap_or(&id).to_owned(),
                ends,
                virtual_length: lengths.drawn,
                physical_length: lengths.built,
                tolerance: lengths.tolerance,
                area,
                bend_radius: None,
                moving_bend_radius: None,
                curves: geometry.curves.get(key).cloned().unwrap_or_default(),
                fixings: self.read_fixings(placed, geometry, key)?,
                coverings: self.read_coverings(placed, key)?,
                wires: Vec::new(),
                id,
            });
        }
        Ok((segments, index))
    }

    /// The nodes at which segments end, with their places.
    fn read_nodes(
        &mut self,
        elements: &[Xml<'a, 'i>],
        segments: &[Segment],
        geometry: &Geometry<'a, 'i>,
        placed: &Placed<'a, 'i>,
        arrangement: Arrangement,
    ) -> Result<Vec<Node>, ImportError> {
        let positions: Vec<Vector> = if geometry.nodes.is_empty() {
            self.without_geometry(elements, segments, arrangement)?
        } else {
            let position = |node: &Xml<'a, 'i>| {
                let known = node.attribute("id").and_then(|id| geometry.nodes.get(id)).copied();
                let right = "a GeometryNode3D with a ReferenceNode says where a node lies, and other nodes have one";
                known.ok_or_else(|| missing(*node, "GeometryNode3D", right))
            };
            elements.iter().map(position).collect::<Result<_, _>>()?
        };
        let mut nodes = Vec::new();
        for (&node, position) in elements.iter().zip(positions) {
            let id = id(node)?;
            self.file.mark(node);
            let mut components: Vec<Component> = Vec::new();
            for own in placed.at_nodes.get(id.as_str()).into_iter().flatten() {
                components.extend(self.component(own, geometry)?);
            }
            let label = child_text(node, "Identification").unwrap_or(&id).to_owned();
            nodes.push(Node { label, position, components, id });
        }
        Ok(nodes)
    }

    /// Places for a harness that has lengths only, which a board then replaces.
    fn without_geometry(
        &mut self,
        elements: &[Xml<'a, 'i>],
        segments: &[Segment],
        arrangement: Arrangement,
    ) -> Result<Vec<Vector>, ImportError> {
        let first = self.all("TopologySegment").into_iter().next();
        let (line, column) = first.map(position).unwrap_or_default();
        if arrangement != Arrangement::Board {
            return Err(ImportError::NoGeometry { line, column });
        }
        for segment in segments.iter().filter(|own| own.physical_length.or(own.virtual_length).is_none()) {
            let Some(node) = self.file.ids.get(segment.id.as_str()) else { continue };
            let right = "a file without 3D geometry has the length of every segment";
            return Err(missing(*node, "LengthInformation", right));
        }
        self.file.findings.add("the file has no 3D geometry; the harness lies on the board by its lengths alone");
        Ok(flat::positions(elements.len(), segments))
    }

    /// Fixings along a segment.
    fn read_fixings(
        &mut self,
        placed: &Placed<'a, 'i>,
        geometry: &Geometry<'a, 'i>,
        segment: &str,
    ) -> Result<Vec<Fixing>, ImportError> {
        let mut fixings = Vec::new();
        for own in placed.along.get(segment).into_iter().flatten() {
            fixings.extend(self.fixing(own, geometry)?);
        }
        Ok(fixings)
    }
}
