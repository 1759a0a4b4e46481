//! Sections from the wires and coverings of a segment, by the rule of [`wireloom_scenario::bundle`].
//!
//! KBL and VEC describe wires and coverings, not mechanics: they contain no EI, GJ or EA. What they state
//! of them (copper area, outside diameter, mass, bend radius; mass and sizes of tubes) is written into the scenario
//! as types of its own. Each is *like* one of the library, which gives the other values:
//!
//! | in the file | like | replaced values |
//! | --- | --- | --- |
//! | wire | the FLRY-B nearest in copper area | strands (if the area is 10 % off), diameter, mass, bend radius |
//! | covering | by its type and description, see [`COVERINGS`] | mass; of tubes also the diameters in the description |

use super::document;
use super::findings::Findings;
use super::names::Names;
use std::collections::HashMap;
use std::f64::consts::PI;
use wireloom_scenario::bundle::{Bundle, Covered, Covering, Layer, Wire, Wires};
use wireloom_scenario::{shipped_coverings, shipped_wires};

/// Words of a covering's type and description (in lower case), all of which must occur, and the covering of the library
/// that replaces it. The first row that fits counts. Tapes are half lap unless they say otherwise.
const COVERINGS: &[(&[&str], &str)] = &[
    (&["wellrohr"], CORRUGATED),
    (&["wellschlauch"], CORRUGATED),
    (&["corrugated"], CORRUGATED),
    (&["convolute"], CORRUGATED),
    (&["schrumpf", "kleber"], "heat-shrink, adhesive-lined"),
    (&["shrink", "adhesive"], "heat-shrink, adhesive-lined"),
    (&["schrumpf"], "heat-shrink"),
    (&["shrink"], "heat-shrink"),
    (&["geflecht"], "braided sleeve"),
    (&["braid"], "braided sleeve"),
    (&["vlies", "spiral"], "fleece tape, spaced"),
    (&["vlies"], "fleece tape, half lap"),
    (&["fleece"], "fleece tape, half lap"),
    (&["gewebe"], "cloth tape, half lap"),
    (&["cloth"], "cloth tape, half lap"),
    (&["spot", "tape"], "pvc tape, spots"),
    (&["spiral", "tape"], "pvc tape, spaced"),
    (&["spaced", "tape"], "pvc tape, spaced"),
    (&["tape"], "pvc tape, half lap"),
    (&["klebeband"], "pvc tape, half lap"),
    (&["schlauch"], SMOOTH),
    (&["rohr"], SMOOTH),
    (&["tube"], SMOOTH),
    (&["tubing"], SMOOTH),
];
/// Prefix of corrugated tubes, of which the one with the nearest inner diameter is taken.
const CORRUGATED: &str = "corrugated tube NW ";
/// Prefix of smooth tubes, likewise.
const SMOOTH: &str = "pvc tube ";

/// Default outer diameter of a wire: D = 2 mm √(A/mm²), within 15 % of the tables from 0.35 to 25 mm².
fn usual_diameter(area: f64) -> f64 {
    2.0 * area.sqrt()
}

/// A type of wire or covering that the scenario names.
pub(super) struct Type<T> {
    /// Name in the scenario: that of the library, or of a type of the scenario.
    pub name: String,
    /// Keys and values of its table in the scenario, as TOML; empty for one of the library.
    pub keys: Vec<(&'static str, String)>,
    pub of_rule: T,
}

/// All types of a harness.
#[derive(Default)]
pub(super) struct Types {
    pub wires: Vec<Type<Wire>>,
    pub coverings: Vec<Type<Covering>>,
    known: HashMap<String, usize>,
    wire_names: Names,
    covering_names: Names,
}

/// Wires and coverings of a part of a segment: equal ones have one section.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Makeup {
    /// Indices of types of wires, increasing, and their numbers.
    pub wires: Vec<(usize, usize)>,
    /// Indices of types of coverings, from the inside.
    pub coverings: Vec<usize>,
    /// Least bend radius beside those of wires and coverings, µm.
    pub bend_radius: Option<u64>,
    /// Least bend radius while it moves, µm.
    pub moving_bend_radius: Option<u64>,
}

impl Makeup {
    /// A radius in µm.
    pub fn micrometres(radius: f64) -> u64 {
        (radius * 1e6).round() as u64
    }

    /// A radius of a make-up in mm, with its unit.
    pub fn written(radius: u64) -> String {
        with_unit(radius as f64 * 1e-6, "mm")
    }
}

/// A number rounded to `digits` significant digits.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// A length in mm, a density in g/m: with its unit, to six digits.
fn with_unit(value: f64, unit: &str) -> String {
    format!("\"{} {unit}\"", rounded(value * 1e3, 6))
}

impl Types {
    /// No types; the names of the library are reserved.
    pub fn new() -> Self {
        let mut types = Self::default();
        shipped_wires().for_each(|(name, _)| drop(types.wire_names.take("", name)));
        shipped_coverings().for_each(|(name, _)| drop(types.covering_names.take("", name)));
        types
    }

    /// Index of the type of a wire of the file.
    pub fn wire(&mut self, file: &document::Wire, findings: &mut Findings) -> usize {
        // Neither area nor diameter: the 0.5 mm² that the document reports.
        let area = file.copper_area.unwrap_or_else(|| file.outside_diameter.map_or(0.5e-6, |d| 0.25 * d * d));
        let off = |wire: &Wire| (wire.conductor_area() / area).ln().abs();
        let of_library = shipped_wires().filter(|(name, _)| name.starts_with("FLRY-B"));
        let Some((like, shipped)) = of_library.min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b))) else {
            unreachable!("the library has FLRY-B wires")
        };
        let mut wire = shipped.clone();
        let mut keys = vec![("like", format!("\"{like}\""))];
        if off(shipped) > 0.1 {
            wire.strands = (area / (0.25 * PI * wire.strand.powi(2))).round().clamp(1.0, 1e6) as usize;
            wire.conductor_diameter = Wire::conductor_diameter_of(wire.strands, wire.strand);
            keys.push(("strands", wire.strands.to_string()));
            if wire.strands == 1 {
                // Thinner than a strand of the library: a single strand of this area.
                let strand = rounded((4.0 * area / PI).sqrt() * 1e3, 6) * 1e-3;
                (wire.strand, wire.conductor_diameter) = (strand, strand);
                keys.push(("strand", with_unit(strand, "mm")));
            }
        }
        let outside = file.outside_diameter.unwrap_or_else(|| usual_diameter(area));
        let least = 1.05 * wire.conductor_diameter;
        let outside = rounded(outside.max(least) * 1e3, 6) * 1e-3;
        if file.outside_diameter.is_some_and(|outside| outside < least) {
            findings.add_to(
                "wires are too thin for their copper; taken as thick as the copper with a thin insulation",
                format!("{} ({:.2} mm)", file.id, outside * 1e3),
            );
        }
        if (outside / wire.diameter() - 1.0).abs() > 1e-6 || keys.len() > 1 {
            wire.layers = vec![Layer { diameter: outside, ..shipped.layers[0] }];
            let diameter = with_unit(outside, "mm");
            keys.push(("layers", format!("[{{ material = \"pvc\", diameter = {diameter} }}]")));
        }
        if let Some(density) = file.linear_density {
            wire.measured.linear_density = Some(density);
            keys.push(("linear_density", with_unit(density, "g/m")));
        }
        if let Some(radius) = file.bend_radius {
            wire.measured.min_bend_radius = Some(radius);
            keys.push(("min_bend_radius", with_unit(radius, "mm")));
        }
        let label = format!("{} mm², {} mm", rounded(area * 1e6, 3), rounded(outside * 1e3, 3));
        let names = &mut self.wire_names;
        add(&mut self.wires, &mut self.known, names, like, &label, keys, wire)
    }

    /// Index of the type of a covering of the file; `None`, with a finding, if it is unknown and has no mass.
    pub fn covering(&mut self, file: &document::Covering, findings: &mut Findings) -> Option<usize> {
        let text = format!("{} {}", file.kind, file.description).to_lowercase();
        let label = if file.description.is_empty() { &file.kind } else { &file.description };
        let label: String = label.chars().map(|c| if c.is_control() { ' ' } else { c }).take(60).collect();
        let row = COVERINGS.iter().find(|(words, _)| words.iter().all(|word| text.contains(word)));
        let Some((_, like)) = row else {
            findings.add_to("coverings unlike any of the library; only their mass counts", format!("`{label}`"));
            file.linear_density?;
            return self.mass_only(file, &label);
        };
        let (like, shipped) = sized(like, file);
        let mut covering = shipped.clone();
        let mut keys = vec![("like", format!("\"{like}\""))];
        if shipped.inner_diameter.is_some() && (file.inner_diameter.is_some() || file.outer_diameter.is_some()) {
            keys.extend(tube(&mut covering, shipped, file));
        }
        if let Some(density) = file.linear_density {
            covering.measured.linear_density = Some(density);
            keys.push(("linear_density", with_unit(density, "g/m")));
        }
        if let Some(radius) = file.bend_radius {
            covering.measured.min_bend_radius = Some(radius);
            keys.push(("min_bend_radius", with_unit(radius, "mm")));
        }
        findings.add_to(
            "coverings are replaced by those of the library (tapes by half lap unless they say otherwise), with the \
             file's masses and diameters",
            format!("`{label}`: {like}"),
        );
        let names = &mut self.covering_names;
        Some(add(&mut self.coverings, &mut self.known, names, like, &label, keys, covering))
    }

    /// A thin covering with mass, but without stiffness or cohesion.
    fn mass_only(&mut self, file: &document::Covering, label: &str) -> Option<usize> {
        let (like, shipped) = shipped_coverings().find(|(name, _)| *name == "pvc tape, spots")?;
        let mut covering = shipped.clone();
        (covering.bending_share, covering.torsion_share) = (0.0, 0.0);
        covering.cohesion = wireloom_scenario::bundle::LOOSE;
        covering.measured.linear_density = file.linear_density;
        let keys = vec![
            ("like", format!("\"{like}\"")),
            ("bending_share", "0".to_owned()),
            ("torsion_share", "0".to_owned()),
            ("cohesion", covering.cohesion.to_string()),
            ("linear_density", with_unit(file.linear_density?, "g/m")),
        ];
        let names = &mut self.covering_names;
        Some(add(&mut self.coverings, &mut self.known, names, like, label, keys, covering))
    }

    /// The bundle of a make-up.
    pub fn bundle(&self, makeup: &Makeup) -> Bundle {
        let wires: Vec<Wires<'_>> =
            makeup.wires.iter().map(|&(kind, count)| Wires { wire: &self.wires[kind].of_rule, count }).collect();
        let coverings: Vec<Covered<'_>> = makeup
            .coverings
            .iter()
            .map(|&kind| Covered { covering: &self.coverings[kind].of_rule, fraction: 1.0 })
            .collect();
        let bundle = Bundle::new(&wires, &coverings, None, None);
        let least = makeup.bend_radius.map_or(0.0, |radius| radius as f64 * 1e-6);
        Bundle { min_bend_radius: bundle.min_bend_radius.max(least), ..bundle }
    }
}

/// Index of a type. A type without keys other than `like` is that of the library; equal ones are one.
fn add<T>(
    types: &mut Vec<Type<T>>,
    known: &mut HashMap<String, usize>,
    names: &mut Names,
    like: &str,
    label: &str,
    mut keys: Vec<(&'static str, String)>,
    of_rule: T,
) -> usize {
    let of_library = keys.len() == 1;
    // Types with the same label mostly differ in mass.
    let mass = keys.iter().find(|(key, _)| *key == "linear_density").map(|(_, mass)| mass.trim_matches('"'));
    let longer = mass.filter(|_| types.iter().any(|known| known.name == label)).map(|mass| format!("{label}, {mass}"));
    let identity = if of_library { like.to_owned() } else { format!("{label} {keys:?}") };
    *known.entry(identity).or_insert_with(|| {
        if of_library {
            keys.clear();
        }
        let name = if of_library { like.to_owned() } else { names.take("", longer.as_deref().unwrap_or(label)) };
        types.push(Type { name, keys, of_rule });
        types.len() - 1
    })
}

/// The covering of the library by name; of tubes the size nearest to the diameters that the file gives, 10 mm without
/// any.
fn sized(like: &str, file: &document::Covering) -> (&'static str, &'static Covering) {
    let all = shipped_coverings()
        .filter(|(name, _)| *name == like || [CORRUGATED, SMOOTH].contains(&like) && name.starts_with(like));
    let off = |covering: &Covering| {
        let [inner, outer] = [covering.inner_diameter.unwrap_or(1.0), around(covering)];
        match (file.inner_diameter, file.outer_diameter) {
            (Some(given), _) => (inner / given).ln().abs(),
            (None, Some(given)) => (outer / given).ln().abs(),
            (None, None) => (inner / 0.010).ln().abs(),
        }
    };
    all.min_by(|(_, a), (_, b)| off(a).total_cmp(&off(b))).unwrap_or_else(|| unreachable!("the library has no {like}"))
}

/// Outer diameter of a tube, m.
fn around(tube: &Covering) -> f64 {
    tube.outer_diameter.unwrap_or(tube.inner_diameter.unwrap_or(1.0) + 2.0 * tube.wall())
}

/// Gives a tube the diameters of the file; a missing one follows from the other as in the library.
fn tube(covering: &mut Covering, shipped: &Covering, file: &document::Covering) -> Vec<(&'static str, String)> {
    let ratio = around(shipped) / shipped.inner_diameter.unwrap_or(1.0);
    let inner = file.inner_diameter.or(file.outer_diameter.map(|outer| outer / ratio)).unwrap_or(0.010);
    let outer = file.outer_diameter.unwrap_or(inner * ratio);
    let (inner, outer) = (rounded(inner * 1e3, 6) * 1e-3, rounded(outer * 1e3, 6) * 1e-3);
    let mut keys = vec![("inner_diameter", with_unit(inner, "mm"))];
    covering.inner_diameter = Some(inner);
    // At least a thin wall, for any description.
    let most = 0.5 * (outer - inner).max(0.02 * inner);
    if shipped.outer_diameter.is_none() || covering.thickness > most {
        covering.thickness = most;
        keys.push(("thickness", with_unit(most, "mm")));
    }
    if shipped.outer_diameter.is_some() {
        let outer = outer.max(inner + 2.0 * covering.thickness);
        covering.outer_diameter = Some(outer);
        keys.push(("outer_diameter", with_unit(outer, "mm")));
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wire(area: f64, outside: Option<f64>, density: Option<f64>) -> document::Wire {
        document::Wire {
            id: "w".into(),
            copper_area: Some(area * 1e-6),
            outside_diameter: outside.map(|d| d * 1e-3),
            linear_density: density,
            bend_radius: None,
            moving_bend_radius: None,
        }
    }

    fn covering(kind: &str, description: &str) -> document::Covering {
        let at = document::Location::Relative(0.0);
        let (inner, outer) = document::diameters(description);
        document::Covering {
            id: "c".into(),
            kind: kind.into(),
            description: description.into(),
            linear_density: None,
            inner_diameter: inner,
            outer_diameter: outer,
            bend_radius: None,
            from: at,
            to: at,
        }
    }

    #[test]
    fn a_wire_is_like_the_one_nearest_in_copper() {
        let (mut types, mut findings) = (Types::new(), Findings::default());
        // All values of the file are those of the library: it is that wire.
        let plain = types.wire(&wire(0.5, Some(1.6), None), &mut findings);
        assert_eq!((types.wires[plain].name.as_str(), types.wires[plain].keys.len()), ("FLRY-B 0.5", 0));
        let heavy = types.wire(&wire(0.5, Some(1.7), Some(0.007)), &mut findings);
        let heavy_type = &types.wires[heavy];
        assert_eq!(heavy_type.name, "0.5 mm², 1.7 mm");
        assert_eq!(
            heavy_type.keys,
            [
                ("like", "\"FLRY-B 0.5\"".to_owned()),
                ("layers", "[{ material = \"pvc\", diameter = \"1.7 mm\" }]".to_owned()),
                ("linear_density", "\"7 g/m\"".to_owned())
            ]
        );
        assert_eq!(types.wire(&wire(0.5, Some(1.7), Some(0.007)), &mut findings), heavy);
        // Between sizes the strands make up the area; without a diameter the usual one is taken.
        let odd = types.wire(&wire(5.0, None, None), &mut findings);
        let odd = &types.wires[odd].of_rule;
        assert!((odd.conductor_area() * 1e6 - 5.0).abs() < 0.04 && (odd.diameter() - 4.472e-3).abs() < 1e-6, "{odd:?}");
        assert!(findings.list.is_empty());
        let fine = types.wire(&wire(0.01, Some(0.5), None), &mut findings);
        assert!((types.wires[fine].of_rule.conductor_area() * 1e6 - 0.01).abs() < 1e-6);
        // Types that differ only in mass have it in their names.
        let light = types.wire(&wire(0.5, Some(1.7), Some(0.006)), &mut findings);
        assert_eq!(types.wires[light].name, "0.5 mm², 1.7 mm, 6 g/m");
        // Thinner than its copper: reported.
        let thin = types.wire(&wire(4.0, Some(2.0), None), &mut findings);
        assert!(types.wires[thin].of_rule.diameter() > 2.6e-3);
        assert_eq!(findings.list.len(), 1);
    }

    #[test]
    fn what_a_file_leaves_out_is_near_the_wire_tables() {
        // Area mm², outside diameter mm: usual values of type B wires.
        for (area, diameter) in [(0.5, 1.6), (1.0, 2.1), (2.5, 3.0), (4.0, 3.7)] {
            assert!((usual_diameter(area * 1e-6) * 1e3 / diameter - 1.0).abs() < 0.15);
        }
    }

    #[test]
    fn coverings_are_known_by_their_words() {
        let (mut types, mut findings) = (Types::new(), Findings::default());
        let mut like = |kind: &str, description: &str| {
            let index = types.covering(&covering(kind, description), &mut findings)?;
            let found = &types.coverings[index];
            Some(found.keys.first().map_or(found.name.clone(), |(_, like)| like.trim_matches('"').to_owned()))
        };
        for (kind, description, expected) in [
            ("TAPE", "PVC-Folie", "pvc tape, half lap"),
            ("TAPE", "PET Vlies", "fleece tape, half lap"),
            ("TAPE", "", "pvc tape, half lap"),
            ("WELLROHR", "size 13.0 D(i)=12.9 D(a)=15.8", "corrugated tube NW 13"),
            ("", "Corrugated D(a)=10", "corrugated tube NW 7.5"),
            ("", "corrugated", "corrugated tube NW 10"),
            ("TUBE", "D(i)=6.1 D(a)=7.3", "pvc tube 6 mm"),
            ("", "Schrumpfschlauch mit Kleber", "heat-shrink, adhesive-lined"),
        ] {
            assert_eq!(like(kind, description).as_deref(), Some(expected), "{kind} {description}");
        }
        assert_eq!(like("", "foam block"), None);
        assert_eq!(findings.list.len(), 2);
    }

    #[test]
    fn tubes_have_the_diameters_of_the_file_and_a_wall() {
        let (mut types, mut findings) = (Types::new(), Findings::default());
        let mut tube = |kind: &str, description: &str| {
            let index = types.covering(&covering(kind, description), &mut findings).unwrap();
            let found = &types.coverings[index].of_rule;
            [found.inner_diameter.unwrap(), found.wall(), around(found)].map(|x| rounded(x * 1e3, 5))
        };
        assert_eq!(tube("WELLROHR", "D(i)=8.3 D(a)=13.4"), [8.3, 0.25, 13.4]);
        assert_eq!(tube("TUBE", "D(i)=6.1 D(a)=7.3"), [6.1, 0.6, 7.3]);
        // Meaningless diameters still give a wall.
        assert_eq!(tube("WELLROHR", "D(i)=8.3 D(a)=8"), [8.3, 0.083, 8.466]);
    }
}
