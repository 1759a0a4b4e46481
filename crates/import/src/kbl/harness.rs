//! What the file says, turned into branches, sections, joints and constraints.

use super::curve::{Curve, Fit, NODE_TOLERANCE, Vector};
use super::document::{Document, Segment, Wire};
use super::findings::Findings;
use super::fixings::Holding;
use super::section::{Makeup, Types, WHOLE};
use super::unit::Quantity;
use super::{ImportError, Options, anatomy};
use nalgebra::UnitQuaternion;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::f64::consts::PI;
use wireloom_scenario::MOST_SEGMENTS;
use wireloom_scenario::bundle::{Bundle, PACKING};

/// Longest label that serves as a name; a longer one gives way to the XML id.
const LONGEST_NAME: usize = 32;

/// What a scenario is written from. SI throughout.
pub(super) struct Harness {
    pub name: String,
    pub vertices: Vec<Vertex>,
    pub types: Types,
    pub sections: Vec<Section>,
    pub branches: Vec<Branch>,
    pub joints: Vec<Joint>,
    pub constraints: Vec<Constraint>,
}

/// Where branches end: a node of the file.
pub(super) struct Vertex {
    pub name: String,
    /// Where it is drawn in the vehicle, m.
    pub position: Vector,
}

pub(super) struct Section {
    pub name: String,
    pub makeup: Makeup,
    pub remark: String,
}

pub(super) struct Branch {
    pub name: String,
    /// Indices of the vertices it runs from and to.
    pub ends: [usize; 2],
    /// Index of the section.
    pub section: usize,
    /// m.
    pub length: f64,
    /// kg/m.
    pub linear_density: f64,
    /// Centre line from the first end to the second, m; empty where both ends are drawn at one point.
    pub path: Vec<Vector>,
    pub remark: String,
}

pub(super) struct Joint {
    /// Index of its vertex.
    pub vertex: usize,
    pub arms: Vec<Arm>,
    pub shares: Vec<Share>,
}

pub(super) struct Arm {
    /// Index of the branch.
    pub branch: usize,
    /// Frame of the branch (columns d1, d2, d3; d3 `from → to`) in world axes.
    pub orientation: UnitQuaternion<f64>,
}

/// Wires that two arms of a joint have in common.
pub(super) struct Share {
    /// Index of the arm of whose stiffness `share` is a fraction.
    pub first: usize,
    pub second: usize,
    pub share: f64,
    pub wires: usize,
}

/// Where something attaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// At a free end, by index of the vertex.
    End(usize),
    /// Along a branch, by index, at an arc length, m.
    Along { branch: usize, s: f64 },
    /// At a joint, by index of the vertex.
    Joint(usize),
}

/// What a fixing does to the harness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Holds an end: position, tangent and twist.
    Connector,
    /// Closes around the cable: position and tangent.
    Clip,
    /// Like a clip, but leaves the cable free along itself.
    Guide,
}

pub(super) struct Constraint {
    pub name: String,
    pub at: Place,
    pub role: Role,
    pub position: Vector,
    /// d3 along the branch, `from → to`.
    pub frame: UnitQuaternion<f64>,
    /// kg, of the connector.
    pub mass: f64,
    pub remark: String,
}

/// Gives out names, each once.
#[derive(Default)]
pub(super) struct Names {
    taken: HashSet<String>,
    /// The number that the next one of a name that is taken is tried with.
    next: HashMap<String, usize>,
}

/// What has no name of its own is called.
const NAMELESS: &str = "unnamed";

impl Names {
    /// The label, or the id where the label is long or has control characters; numbered where it is taken.
    pub fn take(&mut self, label: &str, id: &str) -> String {
        let fits = !label.is_empty() && label.chars().count() <= LONGEST_NAME && !label.chars().any(char::is_control);
        self.unique(if fits { label } else { id })
    }

    /// The name itself, or numbered where it is taken.
    pub fn unique(&mut self, name: &str) -> String {
        let name = if name.trim().is_empty() { NAMELESS } else { name };
        let mut unique = name.to_owned();
        if self.taken.contains(name) {
            let next = self.next.entry(name.to_owned()).or_insert(2);
            while self.taken.contains(&unique) {
                unique = format!("{name}-{next}");
                *next += 1;
            }
        }
        self.taken.insert(unique.clone());
        unique
    }
}

/// A branch while the harness is being put together.
pub(super) struct Laid {
    pub curve: Curve,
    pub length: f64,
    pub makeup: Makeup,
    pub bundle: Bundle,
}

/// Which arm of a vertex: a segment, and whether it starts there.
#[derive(Clone, Copy)]
pub(super) struct Incidence {
    pub segment: usize,
    pub starts: bool,
}

/// Decides everything the document leaves open, and reports each decision that a user may wish to know.
///
/// # Errors
/// Where it is larger than a scenario may be.
pub(super) fn assemble(
    document: &Document,
    options: &Options,
    findings: &mut Findings,
) -> Result<Harness, ImportError> {
    let mut types = Types::new();
    let wires: Vec<usize> = document.wires.iter().map(|wire| types.wire(wire, findings)).collect();
    let mut incidences: Vec<Vec<Incidence>> = document.nodes.iter().map(|_| Vec::new()).collect();
    for (index, segment) in document.segments.iter().enumerate() {
        incidences[segment.ends[0]].push(Incidence { segment: index, starts: true });
        incidences[segment.ends[1]].push(Incidence { segment: index, starts: false });
    }
    let laid = lay_all(document, &mut types, &wires, findings);
    refuse_too_large(document, &laid, options)?;

    let mut names = Names::default();
    let vertices: Vec<String> = document.nodes.iter().map(|node| names.take(&node.label, &node.id)).collect();
    let mut names = Names::default();
    let branch_names: Vec<String> =
        document.segments.iter().map(|segment| names.take(&segment.label, &segment.id)).collect();

    let (sections, section_of) = sections(document, &laid);
    let branches = document
        .segments
        .iter()
        .enumerate()
        .map(|(index, segment)| {
            let apart = (document.nodes[segment.ends[0]].position - document.nodes[segment.ends[1]].position).norm();
            let coincide = apart < 1e-9 && laid[index].curve.length < 1e-9;
            if coincide {
                findings.add_to("both ends are drawn at one point and there is no curve; no path", &segment.id);
            }
            Branch {
                name: branch_names[index].clone(),
                ends: segment.ends,
                section: section_of[index],
                length: laid[index].length,
                linear_density: laid[index].bundle.linear_density,
                path: if coincide { Vec::new() } else { laid[index].curve.path(options.max_segment) },
                remark: format!("{}: {}", segment.id, segment.label),
            }
        })
        .collect();

    let stiffness: Vec<f64> = wires.iter().map(|&kind| types.wires[kind].of_rule.bending_stiffness().taken).collect();
    let mut joints = Vec::new();
    for (node, arms) in incidences.iter().enumerate().filter(|(_, arms)| arms.len() >= 2) {
        let shares = anatomy::shares(document, &stiffness, &laid, node, arms, findings);
        let arms = arms
            .iter()
            .map(|arm| {
                let curve = &laid[arm.segment].curve;
                let s = if arm.starts { 0.0 } else { curve.length };
                Arm { branch: arm.segment, orientation: curve.frame(s) }
            })
            .collect();
        joints.push(Joint { vertex: node, arms, shares });
    }
    let holding = Holding { document, laid: &laid, incidences: &incidences };
    let constraints = holding.constraints(options.arrangement, findings);
    let name = options.name.as_ref().or(document.name.as_ref()).cloned().unwrap_or_else(|| "harness".to_owned());
    let vertices = vertices.into_iter().zip(&document.nodes);
    let vertices = vertices.map(|(name, node)| Vertex { name, position: node.position }).collect();
    Ok(Harness { name, vertices, types, sections, branches, joints, constraints })
}

/// Refuses a harness that has more segments than a scenario may, or a branch that is longer.
fn refuse_too_large(document: &Document, laid: &[Laid], options: &Options) -> Result<(), ImportError> {
    let [_, longest] = Quantity::Length.range();
    let segments: f64 = laid.iter().map(|laid| (laid.length / options.max_segment).ceil()).sum();
    let (longest_of, length) = laid
        .iter()
        .zip(&document.segments)
        .map(|(laid, segment)| (segment.id.as_str(), laid.length))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or_default();
    if segments > MOST_SEGMENTS as f64 || length > longest {
        let id = longest_of.to_owned();
        return Err(ImportError::TooLarge { id, length, max_segment: options.max_segment, segments });
    }
    Ok(())
}

/// Centre line, length and make-up of every segment; `wires` are the types of the document's wires.
fn lay_all(document: &Document, types: &mut Types, wires: &[usize], findings: &mut Findings) -> Vec<Laid> {
    let (mut arcs, mut lengths) = (0.0, 0.0);
    let laid = document
        .segments
        .iter()
        .map(|segment| {
            let [from, to] = segment.ends.map(|end| document.nodes[end].position);
            let stated = segment.physical_length.or(segment.virtual_length);
            let drawn = segment.virtual_length.or(segment.physical_length);
            let (curve, fit) = Curve::lay(&segment.curves, from, to, drawn);
            note_fit(segment, &curve, &fit, findings);
            if fit == Fit::Absent {
                findings.add_to("segments without usable centre curve; straight from node to node", &segment.id);
            }
            let length = stated.unwrap_or_else(|| {
                findings.add_to(
                    "no usable Virtual_length or Physical_length; the length of the drawn line is taken",
                    &segment.id,
                );
                // Nodes at one point and no curve: something that is at least a length.
                curve.length.max(NODE_TOLERANCE)
            });
            note_length(segment, (to - from).norm(), length, &curve, &fit, findings);
            if matches!(fit, Fit::Meets { .. } | Fit::Cut { .. }) && stated.is_some() {
                arcs += curve.length;
                lengths += length;
            }
            let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
            if segment.wires.is_empty() {
                findings.add_to(
                    "no wires are routed through segments; wires of 0.5 mm² that fill the drawn area are taken",
                    &segment.id,
                );
                let (kind, count) = stand_in(segment.area, types, findings);
                counts.insert(kind, count);
            }
            for &wire in &segment.wires {
                *counts.entry(wires[wire]).or_default() += 1;
            }
            let wires = counts.into_iter().collect();
            let makeup = Makeup { wires, coverings: coverings(segment, length, types, findings) };
            let bundle = types.bundle(&makeup);
            for (kind, _) in &makeup.coverings {
                let tube = &types.coverings[*kind];
                if tube.of_rule.inner_diameter.is_some_and(|inner| inner < bundle.wires_diameter) {
                    findings.add_to(
                        "tubes are narrower inside than all wires together that run through them; taken as wide as these",
                        format!("{} `{}` ({:.1} mm of wires)", segment.id, tube.name, bundle.wires_diameter * 1e3),
                    );
                }
            }
            let circle = |&(kind, count): &(usize, usize)| {
                count as f64 * 0.25 * PI * types.wires[kind].of_rule.diameter().powi(2)
            };
            let copper_and_insulation: f64 = makeup.wires.iter().map(circle).sum();
            if !segment.wires.is_empty() && segment.area.is_some_and(|area| area < copper_and_insulation) {
                findings.add_to(
                    "cross-sections are drawn smaller than their wires together; diameters are taken from the wires everywhere",
                    &segment.id,
                );
            }
            Laid { curve, length, makeup, bundle }
        })
        .collect();
    if lengths > 0.0 && !(0.5..2.0).contains(&(arcs / lengths)) {
        findings.add(format!(
            "drawn curves are {:.3} times as long as the stated lengths: coordinates are read as millimetres, \
             which this file may not mean",
            arcs / lengths
        ));
    }
    laid
}

fn note_fit(segment: &Segment, curve: &Curve, fit: &Fit, findings: &mut Findings) {
    let id = &segment.id;
    match fit {
        Fit::Cut { before, after } => findings.add_to(
            "centre curves are those of longer runs and do not end at the nodes; the piece between the nodes is cut out, what lies \
             before and after is left off",
            format!("{id} ({:.1} mm, off {:.1} and {:.1} mm)", curve.length * 1e3, before * 1e3, after * 1e3),
        ),
        Fit::Stale { miss } => findings.add_to(
            "stale centre curves, which miss their nodes and hold no piece that fits between them; straight from node to node",
            format!("{id} (by {:.1} mm)", miss * 1e3),
        ),
        Fit::Meets { .. } | Fit::Absent => {}
    }
}

/// Lengths that do not go with each other or with what is drawn: beyond 1 % and the tolerance.
fn note_length(segment: &Segment, chord: f64, length: f64, curve: &Curve, fit: &Fit, findings: &mut Findings) {
    let id = &segment.id;
    let differ = |a: f64, b: f64| (a - b).abs() > NODE_TOLERANCE.max(0.01 * b);
    if let (Some(physical), Some(drawn)) = (segment.physical_length, segment.virtual_length)
        && differ(physical, drawn)
    {
        findings.add_to(
            "Physical_length (taken) and Virtual_length differ",
            format!("{id} ({:.1} and {:.1} mm)", physical * 1e3, drawn * 1e3),
        );
    }
    if matches!(fit, Fit::Meets { .. }) && differ(curve.length, length) {
        findings.add_to(
            "branches are not as long as their drawn curves",
            format!("{id} ({:.1} mm, curve {:.1} mm)", length * 1e3, curve.length * 1e3),
        );
    }
    if chord > length * (1.0 + 1e-6) + 1e-6 {
        findings.add_to(
            "branches are shorter than their nodes are drawn apart; overstretched as drawn",
            format!("{id} ({:.2} mm, nodes {:.2} mm)", length * 1e3, chord * 1e3),
        );
    }
}

/// Wires of 0.5 mm² (1.6 mm outside) that fill a cross-section, where nothing is known of the real ones: type and count.
fn stand_in(area: Option<f64>, types: &mut Types, findings: &mut Findings) -> (usize, usize) {
    const DIAMETER: f64 = 1.6e-3;
    let (id, copper_area, outside_diameter) = (String::new(), Some(0.5e-6), Some(DIAMETER));
    let wire = Wire { id, copper_area, outside_diameter, linear_density: None, bend_radius: None };
    let one = 0.25 * PI * DIAMETER * DIAMETER;
    let count = (area.unwrap_or(one) * PACKING / one).round().clamp(1.0, 1000.0) as usize;
    (types.wire(&wire, findings), count)
}

/// What covers a segment of this length: types, tapes and other wraps before tubes, and the parts of it that they cover
/// together.
fn coverings(segment: &Segment, length: f64, types: &mut Types, findings: &mut Findings) -> Vec<(usize, u32)> {
    let mut covered: Vec<(usize, Vec<(f64, f64)>)> = Vec::new();
    for covering in &segment.coverings {
        let (a, b) = (covering.from.fraction(length), covering.to.fraction(length));
        let (low, high) = (a.min(b).clamp(0.0, 1.0), a.max(b).clamp(0.0, 1.0));
        // Digits of the file end at 10⁻⁶.
        if a.min(b) < -1e-5 || a.max(b) > 1.0 + 1e-5 {
            findings.add_to(
                "coverings reach beyond their segments; cut there",
                format!("{} `{}`", segment.id, covering.id),
            );
        }
        let Some(kind) = types.covering(covering, findings) else { continue };
        match covered.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, parts)) => parts.push((low, high)),
            None => covered.push((kind, vec![(low, high)])),
        }
    }
    covered.sort_by_key(|(kind, _)| !types.coverings[*kind].of_rule.wrap);
    let parts = covered.into_iter().map(|(kind, parts)| (kind, (union(parts) * f64::from(WHOLE)).round() as u32));
    parts.filter(|(_, parts)| *parts > 0).collect()
}

/// Length of the union of intervals.
fn union(mut parts: Vec<(f64, f64)>) -> f64 {
    parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut reached, mut sum) = (0.0_f64, 0.0);
    for (low, high) in parts {
        sum += (high - low.max(reached)).max(0.0);
        reached = reached.max(high);
    }
    sum
}

fn sections(document: &Document, laid: &[Laid]) -> (Vec<Section>, Vec<usize>) {
    let mut sections: Vec<Section> = Vec::new();
    let mut known: HashMap<&Makeup, usize> = HashMap::new();
    let mut names = Names::default();
    let section_of = document
        .segments
        .iter()
        .zip(laid)
        .map(|(segment, laid)| {
            *known.entry(&laid.makeup).or_insert_with(|| {
                let count = laid.bundle.wires;
                let plain = if count == 1 { "wire" } else { "wires" };
                let copper: f64 = segment.wires.iter().filter_map(|&wire| document.wires[wire].copper_area).sum();
                let remark = format!("{count} {plain}, {:.2} mm² copper", copper * 1e6);
                let name = names.take(&format!("{count}-{plain}"), "wires");
                sections.push(Section { name, makeup: laid.makeup.clone(), remark });
                sections.len() - 1
            })
        })
        .collect();
    (sections, section_of)
}

#[cfg(test)]
mod tests {
    use super::union;

    #[test]
    fn parts_that_overlap_count_once() {
        assert_eq!(union(vec![(0.5, 0.75), (0.0, 0.25), (0.125, 0.375), (0.5, 0.625)]), 0.625);
        assert_eq!(union(vec![]), 0.0);
    }
}
