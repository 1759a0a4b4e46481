//! Reads sections: measured values, and values that follow from their wires by the rule of [`crate::bundle`].

use super::entry::{Entry, NameOrEntry};
use super::library::{self, Library};
use super::names::Names;
use crate::bundle::{Bundle, Covered, Covering, Wire, Wires};
use crate::format::units::unit_of;
use crate::scenario::ByRule;
use crate::span::Span;
use wireloom_core::Section;
use wireloom_core::curve::Curve;
use wireloom_core::identity::{CoveringOfSection, CrossSection, Identified, WiresOfType};
use wireloom_core::section::{AxialLaw, CreepElement, FrictionElement, SectionCreep, SectionFriction, SectionLaws};

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

/// Curves that replace a stiffness.
const CURVES: [(&str, &str); 2] = [("axial_curve", "axial_stiffness"), ("bending_curve", "bending_stiffness")];

/// Least stiffness in compression as a fraction of that in tension. With none the places of the nodes along a slack
/// cable are not determined: nothing but this holds them apart.
const LEAST_COMPRESSION: f64 = 1e-4;

/// Least stiffness of a section in any direction of bending and twist, as a part of the greatest of EI and GJ.
const SOFTEST: f64 = 1e-9;

/// Keys of the friction of a section that let it slip in bending.
const SLIPPING: [&str; 3] = ["bending", "slip_moment", "stiff_ratio"];

/// Largest number of elements of friction or creep in bending, and in torsion.
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
    let friction_entry = entry.entry("friction");
    let slips = |own: &Entry<'_>| SLIPPING.iter().any(|key| own.has(key));
    let by_rule = by_rule((index, name), entry, library, friction_entry.as_ref().is_some_and(slips));
    let bundle = by_rule.as_ref().map(|by_rule| &by_rule.bundle);
    let or_rule = |measured: Option<f64>, rule: fn(&Bundle) -> f64| measured.or(bundle.map(rule)).unwrap_or(1.0);
    for (curve, stiffness) in CURVES {
        if entry.has(curve) && entry.has(stiffness) {
            let message = format!("{} has both `{curve}` and `{stiffness}`", entry.label);
            entry.fault_at(curve, message, "give one of them");
        }
    }
    let bending_curve = bending_curve(entry);
    let axial_points = axial_points(entry);
    let of_curve = axial_points.as_deref().and_then(stiffness_in_tension);
    let tension = of_curve.or(entry.number("axial_stiffness")).or(bundle.map(|bundle| bundle.axial_stiffness));
    let axial_stiffness = tension.unwrap_or(1.0);
    let section = Section {
        name: name.to_owned(),
        diameter: or_rule(entry.number("diameter"), |bundle| bundle.diameter),
        linear_density: or_rule(entry.number("linear_density"), |bundle| bundle.linear_density),
        axial_stiffness,
        // GA = EA/(2(1 + ν)), ν = 0.3
        shear_stiffness: entry.one_or_two("shear_stiffness").unwrap_or([axial_stiffness / 2.6; 2]),
        bending_stiffness: bending_curve
            .as_ref()
            .map(|curve| [curve.slope(0.0); 2])
            .or_else(|| entry.one_or_two("bending_stiffness"))
            .or(bundle.map(|bundle| [bundle.bending.taken; 2]))
            .unwrap_or([1.0; 2]),
        torsion_stiffness: or_rule(entry.number("torsion_stiffness"), |bundle| bundle.torsion.taken),
        coupling_stiffness: entry.vector("coupling_stiffness").unwrap_or_default().into(),
        min_bend_radius: entry.number("min_bend_radius").or(bundle.map(|bundle| bundle.min_bend_radius)),
        min_bend_radius_moving: entry.number("min_bend_radius_moving"),
        max_tension: entry.number("max_tension").or(bundle.and_then(|bundle| bundle.max_tension)),
        max_torsion: entry.number("max_torsion"),
        thermal_expansion: entry.number("thermal_expansion").unwrap_or(0.0),
        thermal_curvature: entry.vector("thermal_curvature").unwrap_or_default(),
        friction: SectionFriction::default(),
        set: None,
        laws: SectionLaws {
            bending: bending_curve,
            axial: axial_law(entry, axial_points.as_deref(), tension),
            creep: entry.entry("creep").map(|entry| creep(&entry)).unwrap_or_default(),
            torsion_set: None,
        },
    };
    refuse_unstable(entry, &section);
    let [set, torsion_set] = entry.entry("set").map(|entry| set(&entry, &section)).unwrap_or_default();
    let friction = friction_entry.as_ref().map(|own| section_friction(own, &section)).unwrap_or_default();
    let section = Section { friction, set, laws: SectionLaws { torsion_set, ..section.laws }, ..section };
    if let (Some(own), Some(by_rule)) = (&friction_entry, &by_rule) {
        refuse_beyond_bonded(own, &section, by_rule.bundle.bending.bonded);
    }
    (section, by_rule)
}

/// Refuses a coupling of known stiffnesses with which a bend or a twist costs no energy.
fn refuse_unstable(entry: &Entry<'_>, section: &Section) {
    let known = ["bending_stiffness", "torsion_stiffness"].into_iter().all(|key| entry.has(key) || entry.has("wires"));
    if !known || !section.couples() {
        return;
    }
    let least = section.bend_stiffness().symmetric_eigenvalues().min();
    if least <= SOFTEST * section.bend_diagonal().max() {
        let message = format!(
            "with this `coupling_stiffness` a bend or a twist of {} costs no energy: in one direction its stiffness is \
             {least:.2e} N m²",
            entry.label
        );
        let help = "[[EI1, C12, C13], [C12, EI2, C23], [C13, C23, GJ]] must be positive definite: give smaller ones";
        entry.fault_at("coupling_stiffness", message, help);
    }
}

/// Refuses friction with which wires that stick on each other are stiffer than bonded ones.
fn refuse_beyond_bonded(friction: &Entry<'_>, section: &Section, bonded: f64) {
    let [slipping, _] = section.bending_stiffness;
    let sticking = slipping + section.friction.diagonal().x;
    let Some(key) = SLIPPING.iter().rfind(|key| friction.has(key)).filter(|_| slipping < bonded) else { return };
    if sticking > bonded {
        let message = format!(
            "{} makes it {sticking:.2e} N m² stiff while its wires stick, and bonded to each other they have \
             {bonded:.2e} N m²",
            friction.label
        );
        let help = format!(
            "once they slip it has {slipping:.2e} N m²: `stiff_ratio` is at most {:.1}, and measured ones are 3 to 10",
            bonded / slipping
        );
        friction.fault_at(key, message, help);
    }
}

/// Moment over curvature.
fn bending_curve(entry: &Entry<'_>) -> Option<Curve> {
    let mut points = entry.curve("bending_curve")?;
    if points[0] == [0.0; 2] {
        points.remove(0);
    } else if points[0][0] <= 0.0 || points[0][1] <= 0.0 {
        let [x, y] = points[0];
        let message = format!("`bending_curve` begins at {x} 1/m with {y} N m");
        let help = "it is the size of the moment over that of the curvature, alike in all directions: begin at \
                    [0, 0], or at its first point from there";
        entry.fault_at("bending_curve", message, help);
        return None;
    }
    Some(Curve::new(&points, None))
}

/// Axial force over strain, without the origin.
fn axial_points(entry: &Entry<'_>) -> Option<Vec<[f64; 2]>> {
    let mut points = entry.curve("axial_curve")?;
    points.retain(|point| *point != [0.0; 2]);
    let off = points.iter().find(|[x, y]| x * y <= 0.0 || *x <= -1.0);
    if let Some([x, y]) = off {
        let message = format!("`axial_curve` has {y} N at a strain of {x}");
        let help = "it passes through [0, 0]: strains and forces are positive in tension, and negative in compression \
                    down to a strain of -1";
        entry.fault_at("axial_curve", message, help);
        return None;
    }
    if stiffness_in_tension(&points).is_none() {
        entry.fault_at("axial_curve", "`axial_curve` has no point in tension", "add points of positive strain");
        return None;
    }
    Some(points)
}

/// Slope of the first chord in tension, N.
fn stiffness_in_tension(points: &[[f64; 2]]) -> Option<f64> {
    points.iter().find(|[strain, _]| *strain > 0.0).map(|[strain, force]| force / strain)
}

/// The axial law, if that is not EA alone; `tension`: EA, unless it is faulty.
fn axial_law(entry: &Entry<'_>, points: Option<&[[f64; 2]]>, tension: Option<f64>) -> Option<AxialLaw> {
    let compression = entry.number("compression_stiffness");
    let tension = tension?;
    if let Some(compression) = compression {
        if points.is_some_and(|points| points[0][0] < 0.0) {
            let message = format!("{} has a `compression_stiffness` beside points of compression", entry.label);
            entry.fault_at("compression_stiffness", message, "leave it out: `axial_curve` has it");
            return None;
        }
        let [least, greatest] = [LEAST_COMPRESSION * tension, tension];
        if !(least..=greatest).contains(&compression) {
            let size = if compression < least { "small" } else { "large" };
            let message =
                format!("`compression_stiffness` = {compression} N is too {size} beside {tension} N in tension");
            let help = format!(
                "it must be from {least} N, so that the nodes of a slack cable have a place, to {greatest} N; what \
                 holds a slack cable up is its bending stiffness"
            );
            entry.fault_at("compression_stiffness", message, help);
            return None;
        }
    }
    match (points, compression) {
        (Some(points), _) => Some(AxialLaw::through(points, compression)),
        (None, Some(compression)) => Some(AxialLaw::of_two(tension, compression)),
        (None, None) => None,
    }
}

/// Elements of a list, each read by `element`.
fn list<T>(entry: &Entry<'_>, key: &str, element: impl Fn(&Entry<'_>) -> Option<T>) -> Vec<Option<T>> {
    let all = entry.entries(key);
    if all.len() > MOST_ELEMENTS {
        let message = format!("{} has {} elements in `{key}`", entry.label, all.len());
        entry.fault_at(key, message, format!("give {MOST_ELEMENTS} at most: a few follow any measured curve"));
    }
    all.iter().map(&element).collect()
}

/// Elements in bending and in torsion, each read by `element`, in an entry that must have some.
fn elements<T>(entry: &Entry<'_>, element: impl Fn(&Entry<'_>) -> Option<T>, example: &str) -> [Vec<T>; 2] {
    let both = ["bending", "torsion"].map(|key| list(entry, key, &element));
    if both.iter().all(Vec::is_empty) {
        entry.fault_here(format!("{} has no elements", entry.label), format!("write such as {example}"));
    }
    both.map(|all| all.into_iter().flatten().collect())
}

/// Element of friction.
fn friction_element(entry: &Entry<'_>) -> Option<FrictionElement> {
    let (stiffness, moment) = (entry.number("stiffness"), entry.number("moment"));
    Some(FrictionElement { stiffness: stiffness?, moment: moment? })
}

/// Friction between an arm and its hub.
pub(super) fn arm_friction(entry: &Entry<'_>) -> SectionFriction {
    let example = "bending = [{ stiffness = \"0.02 N m/rad\", moment = \"0.05 N m\" }]";
    let [bending, torsion] = elements(entry, friction_element, example);
    SectionFriction { bending, torsion }
}

/// Friction within a section: elements, or in bending the moment at which it slips, and how much stiffer it is before.
fn section_friction(entry: &Entry<'_>, section: &Section) -> SectionFriction {
    let given = ["slip_moment", "stiff_ratio"].map(|key| entry.has(key));
    let [slip, ratio] = [entry.number("slip_moment"), entry.number("stiff_ratio")];
    if given == [false; 2] {
        let example = "slip_moment = \"0.05 N m\", stiff_ratio = 3";
        let [bending, torsion] = elements(entry, friction_element, example);
        return SectionFriction { bending, torsion };
    }
    let torsion = list(entry, "torsion", friction_element).into_iter().flatten().collect();
    let refuse = |key: &str, message: &str, help: &str| {
        entry.fault_at(key, format!("{} {message}", entry.label), help);
    };
    let [one, other] = section.bending_stiffness;
    if given == [true, false] {
        if !entry.misspelt("stiff_ratio") {
            refuse("slip_moment", "has `slip_moment` but no `stiff_ratio`", "add the ratio, such as stiff_ratio = 3");
        }
    } else if given == [true; 2] && entry.has("bending") {
        let help = "give `bending`, or `slip_moment` with `stiff_ratio`: these stand for one element";
        refuse("slip_moment", "has both `slip_moment` and `bending`", help);
    } else if section.laws.bending.is_some() {
        let help = "give `bending_stiffness` in place of the curve, or elements in `bending` here";
        refuse("stiff_ratio", "has a ratio to the bending stiffness, but there is a `bending_curve`", help);
    } else if one != other {
        let help = "give one bending_stiffness, or elements in `bending` here";
        refuse("stiff_ratio", "has one ratio, but there are two bending stiffnesses", help);
    }
    let element = slip.zip(ratio).map(|(slip, ratio)| FrictionElement::slipping_at(slip, ratio, one));
    SectionFriction { bending: element.into_iter().collect(), torsion }
}

/// Creep within a section.
fn creep(entry: &Entry<'_>) -> SectionCreep {
    let element = |one: &Entry<'_>| {
        let (stiffness, time) = (one.number("stiffness"), one.number("time"));
        Some(CreepElement { stiffness: stiffness?, time: time? })
    };
    let [bending, torsion] = elements(entry, element, "bending = [{ stiffness = \"0.01 N m^2\", time = \"30 min\" }]");
    SectionCreep { bending, torsion }
}

/// The parts of the bending and of the torsion stiffness that yield: `C (1 − h)`, at the moment that they have at the
/// limit.
fn set(entry: &Entry<'_>, section: &Section) -> [Option<FrictionElement>; 2] {
    let yielding = |[limit, hardening]: [&str; 2], stiffness: f64| {
        let (at, beyond) = (entry.number(limit), entry.number(hardening));
        if entry.has(limit) != entry.has(hardening) && entry.has("yield_twist") {
            let [has, lacks] = if entry.has(limit) { [limit, hardening] } else { [hardening, limit] };
            let message = format!("{} has `{has}` but no `{lacks}`", entry.label);
            entry.fault_at(has, message, "give both, or neither: together they say what yields");
        }
        let stiffness = stiffness * (1.0 - beyond?);
        Some(FrictionElement { stiffness, moment: stiffness * at? })
    };
    let [one, other] = section.bending_stiffness;
    let bending = yielding(["yield_curvature", "hardening"], one);
    let torsion = yielding(["yield_twist", "torsion_hardening"], section.torsion_stiffness);
    let bends = entry.has("yield_curvature") || entry.has("hardening");
    if bends && section.laws.bending.is_some() {
        let message = format!("{} is a part of the bending stiffness, but there is a `bending_curve`", entry.label);
        entry.fault_here(message, "give `bending_stiffness` in place of the curve, or leave bends out of `set`");
        return [None, torsion];
    }
    if bends && one != other {
        let message = format!("{} has no direction, but there are two bending stiffnesses", entry.label);
        entry.fault_here(message, "give one bending_stiffness, or leave `set` out");
        return [None, torsion];
    }
    [bending, torsion]
}

/// Values of a section by the rule; `None` if it has no wires, or some of them are faulty. `slips`: what sticks in
/// bending is given by its friction, so it is not counted as cohesion too.
fn by_rule((section, name): (usize, &str), entry: &Entry<'_>, library: &Library, slips: bool) -> Option<ByRule> {
    let (wires, coverings) = (wires(entry, library), coverings(entry, library));
    let (packing, cohesion) = (entry.number("packing"), entry.number("cohesion"));
    let (wires, coverings) = (wires?, coverings?);
    let contents: Vec<Wires<'_>> = wires.iter().map(|(_, wire, count)| Wires { wire, count: *count }).collect();
    let covered: Vec<Covered<'_>> = coverings.iter().map(|(_, covered)| *covered).collect();
    let mut bundle = Bundle::new(&contents, &covered, packing, cohesion);
    if slips && !entry.has("cohesion") {
        bundle.bending = Bundle::new(&contents, &covered, packing, Some(0.0)).bending;
    }
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
    let wires = wires.iter().map(|&(name, wire, count)| WiresOfType {
        kind: name.to_owned(),
        count,
        diameter: wire.diameter(),
    });
    let mut within = bundle.wires_diameter;
    let coverings = coverings.iter().map(|(name, Covered { covering, fraction })| {
        let [inner, outer] = covering.diameters(within);
        within = outer;
        CoveringOfSection { name: (*name).to_owned(), share: *fraction, inner, outer }
    });
    Some(ByRule {
        section,
        made_of: CrossSection {
            section: name.to_owned(),
            wires: wires.collect(),
            wires_diameter: bundle.wires_diameter,
            coverings: coverings.collect(),
        },
        remarks: narrow.collect(),
        measured: MEASURED.iter().filter(|key| is_measured(entry, key)).map(|key| (*key).to_owned()).collect(),
        bundle,
    })
}

/// Whether a section gives a value itself, or a curve in its place.
fn is_measured(entry: &Entry<'_>, key: &str) -> bool {
    entry.has(key) || CURVES.iter().any(|(curve, stiffness)| *stiffness == key && entry.has(curve))
}

fn wires<'a, 'l>(entry: &Entry<'a>, library: &'l Library) -> Option<Vec<(&'a str, &'l Wire, usize)>> {
    let entries = entry.entries("wires");
    if entries.is_empty() && entry.has("wires") {
        let message = format!("{} has `wires`, but none in it", entry.label);
        entry.fault_at("wires", message, "write such as wires = [{ type = \"FLRY-B 0.5\", count = 24 }]");
    }
    let one = |wires: &Entry<'a>| {
        let count = if wires.has("count") { wires.count("count") } else { Some(1) };
        let name = wires.word("type")?;
        let wire = library::find(&library.wires, "wire type", name, entry, wires.span_of("type"))?;
        Some((name, wire, count?))
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
