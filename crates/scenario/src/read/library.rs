//! Wires, coverings, materials and types of fixings by name: those shipped with the program, then files that the
//! scenario names, then its own.

use super::constraints::{hold, limits};
use super::entry::Entry;
use super::files::NoFiles;
use super::fixing_types::{FixingType, PartNumbers, Types, squeezed};
use super::include::{include, included};
use super::kinds;
use crate::bundle::{Covering, LOOSE, Layer, Material, Measured, Wire};
use crate::fault::{Places, did_you_mean};
use crate::format::keys::LIBRARY_FILE;
use crate::span::Span;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;
use wireloom_core::Registry;
use wireloom_core::constraint::{Limits, Slide};

/// The shipped files, as messages call them, and their texts. Materials come first: the others name them.
const SHIPPED: [(&str, &str); 3] = [
    ("materials.toml", include_str!("../../library/materials.toml")),
    ("wires.toml", include_str!("../../library/wires.toml")),
    ("coverings.toml", include_str!("../../library/coverings.toml")),
];

/// The shipped file, as messages call it, and its text.
const SHIPPED_FIXING_TYPES: (&str, &str) = ("fixings.toml", include_str!("../../library/fixings.toml"));

/// Entries by name; `None` for a faulty one, whose fault has been noted.
type Named<T> = BTreeMap<String, Option<T>>;

/// The shipped library, read once.
static LIBRARY: LazyLock<Library> = LazyLock::new(Library::shipped);

/// The library: parts of sections, and types of fixings.
#[derive(Clone, Default)]
pub(crate) struct Library {
    materials: Named<Material>,
    pub wires: Named<Wire>,
    pub coverings: Named<Covering>,
    pub constraints: Types,
}

impl Library {
    /// Reads the shipped files.
    fn shipped() -> Self {
        let mut library = Self::default();
        let registry = Registry::default();
        for (name, text) in SHIPPED {
            let (_, faults) = included(name, text, &NoFiles, &registry, &LIBRARY_FILE, |entry| library.read(entry));
            debug_assert!(faults.is_empty(), "{name}: {faults:?}");
        }
        library
    }

    /// All entries that a scenario can name.
    pub fn of(root: &Entry<'_>) -> Self {
        let mut library = LIBRARY.clone();
        library.constraints = shipped_fixing_types(root.reader.registry);
        let mut from_files = BTreeSet::new();
        let files = root.entry("library").map(|entry| entry.names("files")).unwrap_or_default();
        let catalogue = root.word("catalogue").map(|path| (path, root.span_of("catalogue")));
        for (path, span) in files.into_iter().chain(catalogue) {
            include(root.reader, path, span, &LIBRARY_FILE, |entry| {
                for label in library.read(entry) {
                    if !from_files.insert(label.clone()) {
                        entry.fault_here(format!("another file has {label} too"), "leave it out of one of them");
                    }
                }
            });
        }
        library.read(root);
        library.refuse_doubled_parts(root);
        library
    }

    /// Refuses a part number that two types have.
    fn refuse_doubled_parts(&self, root: &Entry<'_>) {
        let mut known: BTreeMap<String, (&str, &PartNumbers)> = BTreeMap::new();
        for (name, of) in &self.constraints {
            for numbers in of.iter().flat_map(|of| &of.parts) {
                if let Some((other, first)) = known.insert(squeezed(&numbers.text), (name, numbers)) {
                    let key = if root.has("catalogue") { "catalogue" } else { "fixings" };
                    let span = if root.has(key) { root.span_of(key) } else { root.span_of("library") };
                    let message = format!(
                        "the part number \"{}\" is given twice: {} (\"{other}\") and {} (\"{name}\")",
                        numbers.text, first.place, numbers.place
                    );
                    root.reader.fault(span, message, "leave it out of one of them");
                }
            }
        }
    }

    /// Adds the entries of a file or scenario; returns their labels.
    fn read(&mut self, entry: &Entry<'_>) -> Vec<String> {
        let mut labels = Vec::new();
        for (name, material) in entry.named_entries("materials") {
            self.materials.insert(name.to_owned(), read_material(&material));
            labels.push(material.label);
        }
        for (name, wire) in entry.named_entries("wires") {
            self.wires.insert(name.to_owned(), self.read_wire(&wire));
            labels.push(wire.label);
        }
        for (name, covering) in entry.named_entries("coverings") {
            self.coverings.insert(name.to_owned(), self.read_covering(&covering));
            labels.push(covering.label);
        }
        let places = Places::of(entry.reader.text);
        for (name, constraint) in entry.named_entries("fixings") {
            self.constraints.insert(name.to_owned(), read_fixing_type((&entry.label, &places), name, &constraint));
            labels.push(constraint.label);
        }
        labels
    }

    /// The material that a key names; if the key is left out, `like`, or else the material named `default`.
    fn material(
        &self,
        entry: &Entry<'_>,
        key: &str,
        like: Option<Material>,
        default: Option<&str>,
    ) -> Option<Material> {
        match entry.word(key) {
            Some(name) => find(&self.materials, "material", name, entry, entry.span_of(key)).copied(),
            None if entry.has(key) => None,
            None => like.or_else(|| *self.materials.get(default?)?),
        }
    }

    fn read_wire(&self, entry: &Entry<'_>) -> Option<Wire> {
        let like = like(&self.wires, "wire type", entry)?;
        let like = like.as_ref();
        let strands = entry.count("strands").or(like.map(|like| like.strands));
        let strand = entry.number("strand").or(like.map(|like| like.strand));
        let conductor = self.material(entry, "conductor", like.map(|like| like.conductor), Some("copper"));
        let given = entry.number("conductor_diameter");
        let same = if entry.has("strands") || entry.has("strand") { None } else { like };
        let derived = || Some(Wire::conductor_diameter_of(strands?, strand?));
        let conductor_diameter = given.or(same.map(|like| like.conductor_diameter)).or_else(derived);
        if let (Some(strands), Some(strand), Some(given)) = (strands, strand, given)
            && given * given * (1.0 + 1e-9) < strands as f64 * strand * strand
        {
            let least = strand * (strands as f64).sqrt() * 1e3;
            let message = format!("{} has more strands than fit in its conductor", entry.label);
            let help = format!(
                "the metal alone fills a circle of {least:.3} mm; leave `conductor_diameter` out to have it derived"
            );
            entry.fault_at("conductor_diameter", message, help);
        }
        let layers = match like {
            Some(like) if !entry.has("layers") => Some(like.layers.clone()),
            _ => self.read_layers(entry),
        };
        if let (Some(layers), Some(conductor)) = (&layers, conductor_diameter) {
            refuse_thin_layers(entry, layers, conductor);
        }
        let measured = read_measured(entry).or(like.map(|like| like.measured).unwrap_or_default());
        Some(Wire {
            strands: strands?,
            strand: strand?,
            conductor: conductor?,
            conductor_diameter: conductor_diameter?,
            layers: layers?,
            measured,
        })
    }

    fn read_layers(&self, wire: &Entry<'_>) -> Option<Vec<Layer>> {
        let entries = wire.entries("layers");
        if entries.is_empty() && wire.has("layers") {
            wire.fault_at("layers", format!("{} has no layers", wire.label), "give at least its insulation");
        }
        let one = |entry: &Entry<'_>| {
            let material = self.material(entry, "material", None, None);
            let (diameter, fill) = (entry.number("diameter"), entry.number("fill").unwrap_or(1.0));
            let strand = entry.number("strand");
            Some(Layer { material: material?, diameter: diameter?, fill, strand })
        };
        let layers: Vec<Option<Layer>> = entries.iter().map(one).collect();
        layers.into_iter().collect::<Option<Vec<Layer>>>().filter(|layers| !layers.is_empty())
    }

    fn read_covering(&self, entry: &Entry<'_>) -> Option<Covering> {
        let like = like(&self.coverings, "covering", entry)?;
        let like = like.as_ref();
        let material = self.material(entry, "material", like.map(|like| like.material), None);
        let thickness = entry.number("thickness").or(like.map(|like| like.thickness));
        let inner_diameter = entry.number("inner_diameter").or(like.and_then(|like| like.inner_diameter));
        let outer_diameter = entry.number("outer_diameter").or(like.and_then(|like| like.outer_diameter));
        let or_like =
            |key: &str, of: fn(&Covering) -> f64, default: f64| entry.number(key).or(like.map(of)).unwrap_or(default);
        let covering = Covering {
            material: material?,
            thickness: thickness?,
            layers: entry.count("layers").or(like.map(|like| like.layers)).unwrap_or(1),
            wrap: entry.flag("wrap").or(like.map(|like| like.wrap)).unwrap_or(false),
            coverage: or_like("coverage", |like| like.coverage, 1.0),
            inner_diameter,
            outer_diameter,
            bending_share: or_like("bending_share", |like| like.bending_share, 1.0),
            torsion_share: or_like("torsion_share", |like| like.torsion_share, 1.0),
            cohesion: or_like("cohesion", |like| like.cohesion, LOOSE),
            measured: read_measured(entry).or(like.map(|like| like.measured).unwrap_or_default()),
        };
        refuse_thin_tube(entry, &covering);
        Some(covering)
    }
}

/// The shipped types whose kinds `registry` has.
pub(crate) fn shipped_fixing_types(registry: &Registry) -> Types {
    let (name, text) = SHIPPED_FIXING_TYPES;
    let read = |shipped: &Entry<'_>| {
        let places = Places::of(shipped.reader.text);
        let entries = shipped.named_entries("fixings");
        entries
            .iter()
            .filter_map(|(name, entry)| {
                Some(((*name).to_owned(), Some(read_fixing_type((&shipped.label, &places), name, entry)?)))
            })
            .collect()
    };
    included(name, text, &NoFiles, registry, &LIBRARY_FILE, read).0.unwrap_or_default()
}

/// A type out of a file or scenario, which messages call `file`, with the places of its text.
fn read_fixing_type((file, places): (&str, &Places<'_>), name: &str, entry: &Entry<'_>) -> Option<FixingType> {
    let before = entry.reader.fault_count();
    let kind = kinds::read(entry);
    if entry.reader.registry.constraint(name).is_some() {
        let message = format!("\"{name}\" is a built-in kind of constraint, and cannot be a type too");
        entry.fault_here(message, "give the type a name of its own");
    }
    let doc = entry.word("doc").unwrap_or_default().to_owned();
    let hold = hold(entry);
    let needs = entry.choices("needs").into_iter().map(str::to_owned).collect();
    let numbers = |(text, span): (&str, Span)| {
        let (line, column) = places.position(span.start);
        PartNumbers { text: text.to_owned(), place: format!("{file}:{line}:{column}") }
    };
    let parts = entry.names("parts").into_iter().map(numbers).collect();
    let (slides, friction) = (entry.flag("slide") == Some(true), entry.number("friction"));
    if entry.has("friction") && !slides {
        let message = format!("{} has `friction`, but the cable does not slide", entry.label);
        entry.fault_at("friction", message, "add slide = true, or leave `friction` out");
    }
    let slide = slides.then(|| Slide { friction: friction.unwrap_or(0.0) });
    let limits = limits(entry, &Limits::default());
    let kind = kind.filter(|_| entry.reader.fault_count() == before)?;
    Some(FixingType { doc, kind: kind.kind, parameters: kind.parameters, hold, slide, limits, needs, parts })
}

/// The one that an entry is like, if any; `None`, with a fault, if it is unknown.
fn like<T: Clone>(family: &Named<T>, what: &str, entry: &Entry<'_>) -> Option<Option<T>> {
    if !entry.has("like") {
        return Some(None);
    }
    find(family, what, entry.word("like")?, entry, entry.span_of("like")).cloned().map(Some)
}

/// Refuses layers whose diameters do not increase.
fn refuse_thin_layers(wire: &Entry<'_>, layers: &[Layer], conductor: f64) {
    let mut inside = conductor;
    for (k, layer) in layers.iter().enumerate() {
        if layer.diameter <= inside {
            let message = format!("layer {} of {} is not thicker than the one below it", k + 1, wire.label);
            let help = format!("give layers from the inside; this one needs more than {:.3} mm", inside * 1e3);
            wire.fault_at("layers", message, help);
        }
        inside = layer.diameter;
    }
}

/// Refuses a tube whose wall does not fit between its diameters.
fn refuse_thin_tube(entry: &Entry<'_>, covering: &Covering) {
    let Some(outer) = covering.outer_diameter else { return };
    let Some(inner) = covering.inner_diameter else {
        let message = format!("{} has `outer_diameter` but no `inner_diameter`", entry.label);
        entry.fault_at("outer_diameter", message, "give the inner diameter too, or leave this one out");
        return;
    };
    let least = inner + 2.0 * covering.wall();
    if outer < least * (1.0 - 1e-9) {
        let message = format!("{} has an outer diameter too small for its inner diameter and wall", entry.label);
        entry.fault_at("outer_diameter", message, format!("it must be at least {:.3} mm", least * 1e3));
    }
}
/// The wires that are shipped, by name.
pub fn shipped_wires() -> impl Iterator<Item = (&'static str, &'static Wire)> {
    LIBRARY.wires.iter().filter_map(|(name, wire)| Some((name.as_str(), wire.as_ref()?)))
}

/// The coverings that are shipped, by name.
pub fn shipped_coverings() -> impl Iterator<Item = (&'static str, &'static Covering)> {
    LIBRARY.coverings.iter().filter_map(|(name, covering)| Some((name.as_str(), covering.as_ref()?)))
}

/// Names and descriptions of the types of constraints that are shipped, as far as the registry has their kinds.
pub fn shipped_fixings(registry: &Registry) -> Vec<(String, String)> {
    shipped_fixing_types(registry).into_iter().filter_map(|(name, own)| Some((name, own?.doc))).collect()
}

/// Looks a name up; notes a fault if it is unknown. Returns `None` without a fault if it names a faulty entry.
pub(crate) fn find<'l, T>(
    family: &'l Named<T>,
    what: &str,
    name: &str,
    entry: &Entry<'_>,
    span: Span,
) -> Option<&'l T> {
    let found = family.get(name);
    if found.is_none() {
        let help = did_you_mean(name, family.keys().map(String::as_str));
        entry.reader.fault(span, format!("unknown {what} \"{name}\" in {}", entry.label), help);
    }
    found?.as_ref()
}

fn read_material(entry: &Entry<'_>) -> Option<Material> {
    let (modulus, poisson, density) = (entry.number("modulus"), entry.number("poisson"), entry.number("density"));
    Some(Material { modulus: modulus?, poisson: poisson?, density: density?, strength: entry.number("strength") })
}

fn read_measured(entry: &Entry<'_>) -> Measured {
    Measured {
        linear_density: entry.number("linear_density"),
        axial_stiffness: entry.number("axial_stiffness"),
        bending_stiffness: entry.number("bending_stiffness"),
        torsion_stiffness: entry.number("torsion_stiffness"),
        min_bend_radius: entry.number("min_bend_radius"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped_wire(name: &str) -> Wire {
        Library::shipped().wires[name].clone().expect("sound")
    }

    #[test]
    fn shipped_files_have_no_faults() {
        let registry = Registry::default();
        let mut library = Library::default();
        for (name, text) in SHIPPED {
            let (_, faults) = included(name, text, &NoFiles, &registry, &LIBRARY_FILE, |entry| library.read(entry));
            assert!(faults.is_empty(), "{name}\n{}", crate::render(text, &faults));
        }
        assert!(library.wires.len() > 35 && library.coverings.len() > 15, "{}", library.wires.len());
    }

    /// Masses follow from construction and densities; manufacturers' tables give these, g/m, with a tolerance of
    /// about 5 %.
    #[test]
    fn masses_are_those_of_makers_tables() {
        let tables = [
            ("FLRY-B 0.5", 6.6),
            ("FLRY-B 0.75", 9.0),
            ("FLRY-B 1.0", 11.5),
            ("FLRY-B 1.5", 16.5),
            ("FLRY-B 2.5", 26.5),
            ("FLRY-B 4.0", 42.0),
            ("FLRY-B 6.0", 61.0),
            ("M22759/16-20", 6.7),
            ("RG-58 C/U", 37.0),
            ("RG-174", 11.5),
            ("RG-316", 16.0),
        ];
        for (name, grams) in tables {
            let found = shipped_wire(name).linear_density() * 1e3;
            assert!((found / grams - 1.0).abs() < 0.12, "{name}: {found:.2} g/m, tables {grams}");
        }
    }

    /// Nominal copper areas, mm², are electrical ones: geometric areas lie within a few percent.
    #[test]
    fn conductors_have_the_area_of_their_name() {
        for (name, wire) in &Library::shipped().wires {
            let Some(area) = name.strip_prefix("FLRY-").and_then(|rest| rest[2..].parse::<f64>().ok()) else {
                continue;
            };
            let found = wire.as_ref().unwrap().conductor_area() * 1e6;
            assert!((found / area - 1.0).abs() < 0.10, "{name}: {found:.3} mm²");
        }
    }

    #[test]
    fn bounds_of_every_shipped_wire_are_in_order() {
        for (name, wire) in Library::shipped().wires {
            let wire = wire.unwrap();
            for x in [wire.bending_stiffness(), wire.torsion_stiffness()] {
                assert!(0.0 < x.slip && x.slip <= x.taken && x.taken <= x.bonded, "{name}: {x:?}");
            }
        }
    }
}
