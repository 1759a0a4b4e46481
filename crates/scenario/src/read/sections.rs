//! Reads sections: measured values, and values that follow from their wires by the rule of [`crate::bundle`].

use super::entry::{Entry, NameOrEntry};
use super::library::{self, Library};
use super::names::Names;
use crate::bundle::{Bundle, Covered, Covering, Wire, Wires};
use crate::format::units::unit_of;
use crate::scenario::ByRule;
use crate::span::Span;
use wireloom_core::Section;
use wireloom_core::identity::Identified;
use wireloom_core::section::{FrictionElement, SectionFriction};

/// Keys of a section that are measured values; in a section of wires they replace those of the rule.
const MEASURED: [&str; 7] = [
    "diameter",
    "linear_density",
    "axial_stiffness",
    "bending_stiffness",
    "torsion_stiffness",
    "min_bend_radius",
    "max_tension",
];

/// Largest number of elements of friction in bending, and in torsion.
const MOST_ELEMENTS: usize = 8;

/// A section, and its values by the rule if it has wires.
pub(crate) fn section<'a>(
    name: &'a str,
    entry: &Entry<'a>,
    library: &Library,
    names: &mut Names<'a>,
) -> (Section, Option<ByRule>) {
    let index = names.sections.len();
    names.sections.insert(name, index);
    names.identify(entry, Identified::Section, Some(name));
    let by_rule = by_rule(index, entry, library);
    let bundle = by_rule.as_ref().map(|by_rule| &by_rule.bundle);
    let or_rule = |measured: Option<f64>, rule: fn(&Bundle) -> f64| measured.or(bundle.map(rule)).unwrap_or(1.0);
    let axial_stiffness = or_rule(entry.number("axial_stiffness"), |bundle| bundle.axial_stiffness);
    let section = Section {
        name: name.to_owned(),
        diameter: or_rule(entry.number("diameter"), |bundle| bundle.diameter),
        linear_density: or_rule(entry.number("linear_density"), |bundle| bundle.linear_density),
        axial_stiffness,
        // GA = EA/(2(1 + ν)), ν = 0.3
        shear_stiffness: entry.one_or_two("shear_stiffness").unwrap_or([axial_stiffness / 2.6; 2]),
        bending_stiffness: entry
            .one_or_two("bending_stiffness")
            .or(bundle.map(|bundle| [bundle.bending.taken; 2]))
            .unwrap_or([1.0; 2]),
        torsion_stiffness: or_rule(entry.number("torsion_stiffness"), |bundle| bundle.torsion.taken),
        min_bend_radius: entry.number("min_bend_radius").or(bundle.map(|bundle| bundle.min_bend_radius)),
        min_bend_radius_moving: entry.number("min_bend_radius_moving"),
        max_tension: entry.number("max_tension").or(bundle.and_then(|bundle| bundle.max_tension)),
        max_torsion: entry.number("max_torsion"),
        thermal_expansion: entry.number("thermal_expansion").unwrap_or(0.0),
        thermal_curvature: entry.vector("thermal_curvature").unwrap_or_default(),
        friction: entry.entry("friction").map(|entry| friction(&entry)).unwrap_or_default(),
        set: None,
    };
    let set = entry.entry("set").and_then(|entry| set(&entry, section.bending_stiffness));
    let section = Section { set, ..section };
    (section, by_rule)
}

/// Friction within a section.
fn friction(entry: &Entry<'_>) -> SectionFriction {
    let elements = |key: &str| -> Vec<Option<FrictionElement>> {
        let all = entry.entries(key);
        if all.len() > MOST_ELEMENTS {
            let message = format!("{} has {} elements in `{key}`", entry.label, all.len());
            entry.fault_at(key, message, format!("give {MOST_ELEMENTS} at most: a few follow any measured curve"));
        }
        let element = |one: &Entry<'_>| {
            let (stiffness, moment) = (one.number("stiffness"), one.number("moment"));
            Some(FrictionElement { stiffness: stiffness?, moment: moment? })
        };
        all.iter().map(element).collect()
    };
    let [bending, torsion] = ["bending", "torsion"].map(elements);
    if bending.is_empty() && torsion.is_empty() {
        let help = "write such as bending = [{ stiffness = \"0.02 N m^2\", moment = \"0.05 N m\" }]";
        entry.fault_here(format!("{} has no elements", entry.label), help);
    }
    let [bending, torsion] = [bending, torsion].map(|all| all.into_iter().flatten().collect());
    SectionFriction { bending, torsion }
}

/// The part of the bending stiffness that yields: `EI (1 − h)`, at the moment that it has at the yield curvature.
fn set(entry: &Entry<'_>, bending_stiffness: [f64; 2]) -> Option<FrictionElement> {
    let (limit, hardening) = (entry.number("yield_curvature"), entry.number("hardening"));
    let [one, other] = bending_stiffness;
    if one != other {
        let message = format!("{} has no direction, but there are two bending stiffnesses", entry.label);
        entry.fault_here(message, "give one bending_stiffness, or leave `set` out");
        return None;
    }
    let stiffness = one * (1.0 - hardening?);
    Some(FrictionElement { stiffness, moment: stiffness * limit? })
}

/// Values of a section by the rule; `None` if it has no wires, or some of them are faulty.
fn by_rule(section: usize, entry: &Entry<'_>, library: &Library) -> Option<ByRule> {
    let (wires, coverings) = (wires(entry, library), coverings(entry, library));
    let (packing, cohesion) = (entry.number("packing"), entry.number("cohesion"));
    let (wires, coverings) = (wires?, coverings?);
    let contents: Vec<Wires<'_>> = wires.iter().map(|(wire, count)| Wires { wire, count: *count }).collect();
    let covered: Vec<Covered<'_>> = coverings.iter().map(|(_, covered)| *covered).collect();
    let bundle = Bundle::new(&contents, &covered, packing, cohesion);
    let values = [
        ("diameter", bundle.diameter),
        ("linear_density", bundle.linear_density),
        ("axial_stiffness", bundle.axial_stiffness),
        ("bending_stiffness", bundle.bending.slip),
        ("bending_stiffness", bundle.bending.bonded),
        ("torsion_stiffness", bundle.torsion.slip),
        ("torsion_stiffness", bundle.torsion.bonded),
        ("min_bend_radius", bundle.min_bend_radius),
    ];
    for (key, value) in values.into_iter().chain(bundle.max_tension.map(|tension| ("max_tension", tension))) {
        let Some((quantity, bound)) = entry.keys.get(key).and_then(|key| key.form.bound()) else { continue };
        if !(bound.minimum..=bound.maximum).contains(&value) {
            let unit = unit_of(quantity);
            let message = format!("the wires of {} give it a `{key}` of {value:.3e} {unit}", entry.label);
            let help = format!(
                "it must be {}: correct their diameters, counts, moduli or measured values",
                bound.words(quantity)
            );
            entry.fault_at("wires", message, help);
            return None;
        }
    }
    let narrow = coverings.iter().filter_map(|(name, Covered { covering, .. })| {
        let inner = covering.inner_diameter.filter(|inner| *inner < bundle.wires_diameter)?;
        Some(format!(
            "\"{name}\" is {:.1} mm wide inside, the wires are {:.1} mm thick",
            inner * 1e3,
            bundle.wires_diameter * 1e3
        ))
    });
    Some(ByRule {
        section,
        coverings: coverings.iter().map(|(name, _)| (*name).to_owned()).collect(),
        remarks: narrow.collect(),
        measured: MEASURED.iter().filter(|key| entry.has(key)).map(|key| (*key).to_owned()).collect(),
        bundle,
    })
}

fn wires<'l>(entry: &Entry<'_>, library: &'l Library) -> Option<Vec<(&'l Wire, usize)>> {
    let entries = entry.entries("wires");
    if entries.is_empty() && entry.has("wires") {
        let message = format!("{} has `wires`, but none in it", entry.label);
        entry.fault_at("wires", message, "write such as wires = [{ type = \"FLRY-B 0.5\", count = 24 }]");
    }
    let one = |wires: &Entry<'_>| {
        let count = if wires.has("count") { wires.count("count") } else { Some(1) };
        let name = wires.word("type")?;
        let wire = library::find(&library.wires, "wire type", name, entry, wires.span_of("type"))?;
        Some((wire, count?))
    };
    let all: Vec<Option<_>> = entries.iter().map(one).collect();
    all.into_iter().collect::<Option<Vec<_>>>().filter(|wires| !wires.is_empty())
}

/// The coverings with their names.
fn coverings<'a, 'l>(entry: &Entry<'a>, library: &'l Library) -> Option<Vec<(&'a str, Covered<'l>)>> {
    let find = |name: &'a str, span: Span| -> Option<&'l Covering> {
        library::find(&library.coverings, "covering", name, entry, span)
    };
    let one = |item: NameOrEntry<'a>| match item {
        NameOrEntry::Name(name, span) => Some((name, Covered { covering: find(name, span)?, fraction: 1.0 })),
        NameOrEntry::Entry(covered) => {
            let fraction = if covered.has("share") { covered.number("share") } else { Some(1.0) };
            let name = covered.word("type")?;
            Some((name, Covered { covering: find(name, covered.span_of("type"))?, fraction: fraction? }))
        }
    };
    let all: Vec<Option<_>> = entry.names_or_entries("covering").into_iter().map(one).collect();
    all.into_iter().collect()
}
