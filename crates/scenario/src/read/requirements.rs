//! Reads requirements and markers.

use super::entry::Entry;
use super::names::{Names, lookup, register};
use super::places::attachment;
use crate::attachment::At;
use crate::fault::did_you_mean;
use crate::format::limits::{ANY, Bound, NON_NEGATIVE};
use crate::scenario::{Branch, Constraint, Required};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use toml::de::DeValue;
use wildmatch::WildMatch;
use wireloom_core::Quantity;
use wireloom_core::obstacle::ContactSettings;
use wireloom_core::requirement::{Marker, Measure, Motion, Origin, Part, Requirement, Severity};
use wireloom_core::steps::{Operation, Step};

/// What requirements refer to.
pub(crate) struct Named<'n, 'a> {
    pub names: &'n Names<'a>,
    pub branches: &'n [Branch],
    pub constraints: &'n [Constraint],
    pub steps: &'n [Step],
    pub contact: ContactSettings,
}

/// Families of parts.
#[derive(Clone, Copy, PartialEq)]
enum Family {
    Branch,
    Constraint,
    Obstacle,
}

impl Family {
    fn word(self) -> &'static str {
        match self {
            Family::Branch => "branch",
            Family::Constraint => "constraint",
            Family::Obstacle => "obstacle",
        }
    }
}

/// The families that have a quantity; the first is the one meant where `of` is left out.
fn families(measure: Measure) -> &'static [Family] {
    match measure {
        Measure::Force | Measure::Moment | Measure::InsertionForce => &[Family::Constraint],
        Measure::ContactForce | Measure::Clearance => &[Family::Obstacle, Family::Branch],
        _ => &[Family::Branch],
    }
}

/// A requirement; `None` if it is faulty.
pub(crate) fn requirement<'a>(
    entry: &Entry<'a>,
    index: usize,
    known: &Named<'_, 'a>,
    taken: &mut BTreeMap<&'a str, usize>,
) -> Option<Required> {
    let before = entry.reader.fault_count();
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, taken, name, index));
    let word = entry.choice("quantity");
    let measure = word.and_then(|word| Measure::ALL.into_iter().find(|measure| measure.word() == word));
    let steps = steps(entry, known.steps);
    let motion = entry.choice("motion").and_then(|word| Motion::ALL.into_iter().find(|motion| motion.word() == word));
    let severity = entry.choice("severity").and_then(|word| Severity::ALL.into_iter().find(|s| s.word() == word));
    let because = entry.word("because").map(str::to_owned);
    let measure = measure?;
    let [min, max] = ["min", "max"].map(|key| limit(entry, key, measure));
    if !entry.has("min") && !entry.has("max") {
        let message = format!("{} has neither `min` nor `max`", entry.label);
        entry.fault_here(message, format!("add a limit{}", example(measure)));
    }
    if let (Some(min), Some(max)) = (min, max)
        && min > max
    {
        let message = format!("{} has min = {min} above max = {max}: no value keeps both", entry.label);
        entry.fault_at("min", message, "give the smaller one as `min`");
    }
    let (of, against) = parts(entry, measure, known)?;
    if motion.is_some_and(|motion| motion != Motion::Any) && !of.iter().all(|part| matches!(part, Part::Branch { .. }))
    {
        let message = format!("{} has `motion`, but is not about branches", entry.label);
        entry.fault_at("motion", message, "leave it out");
    }
    if measure == Measure::Deviation {
        refuse_undrawn(entry, &of, known);
    }
    if measure == Measure::InsertionForce {
        refuse_unmated(entry, &of, known);
    }
    if entry.reader.fault_count() > before {
        return None;
    }
    let requirement = Requirement {
        name: name?.to_owned(),
        origin: Origin::Scenario,
        measure,
        of,
        against,
        min,
        max,
        steps,
        motion: motion.unwrap_or_default(),
        severity: severity.unwrap_or_default(),
        because,
    };
    Some(Required { requirement, spans: entry.spans() })
}

/// The steps in which a requirement counts.
fn steps(entry: &Entry<'_>, steps: &[Step]) -> Option<Vec<usize>> {
    if !entry.has("steps") {
        return None;
    }
    // A scenario without steps has one of this name.
    let known: BTreeMap<&str, usize> = match steps {
        [] => [("equilibrium", 0)].into(),
        steps => steps.iter().enumerate().map(|(k, step)| (step.name.as_str(), k)).collect(),
    };
    let named = entry.names("steps");
    if named.is_empty() {
        entry.fault_at("steps", "`steps` is empty: it would never be checked", "leave it out for all steps");
    }
    Some(named.into_iter().filter_map(|(name, span)| lookup(entry, "step", &known, name, span).copied()).collect())
}

/// Quantity and limits of the values of a measure.
fn quantity(measure: Measure) -> (Quantity, Bound) {
    match measure {
        Measure::BendRadius | Measure::Deviation | Measure::Overlap => (Quantity::Length, NON_NEGATIVE),
        Measure::Clearance | Measure::Slack => (Quantity::Length, ANY),
        Measure::Tension | Measure::Compression | Measure::Buckling => (Quantity::Force, ANY),
        Measure::Force | Measure::InsertionForce | Measure::ContactForce => (Quantity::Force, NON_NEGATIVE),
        Measure::Moment => (Quantity::Moment, NON_NEGATIVE),
        Measure::Strain => (Quantity::Dimensionless, ANY),
        Measure::Reach | Measure::Turns => (Quantity::Dimensionless, NON_NEGATIVE),
        Measure::Torsion => (Quantity::Curvature, NON_NEGATIVE),
    }
}

/// A limit in the unit of the measure.
fn limit(entry: &Entry<'_>, key: &str, measure: Measure) -> Option<f64> {
    let node = entry.node(key)?;
    let (quantity, bound) = quantity(measure);
    // A plain number of turns is what it says; with a unit it is an angle.
    if measure == Measure::Turns && matches!(node.get_ref(), DeValue::String(_)) {
        return entry.reader.number(key, node, Quantity::Angle, bound).map(|angle| angle / TAU);
    }
    entry.reader.number(key, node, quantity, bound)
}

/// ", such as min = …" for a measure.
fn example(measure: Measure) -> &'static str {
    match measure {
        Measure::BendRadius => ", such as min = \"45 mm\"",
        Measure::Clearance => ", such as min = \"10 mm\"",
        Measure::Slack => ", such as min = \"5 mm\"",
        Measure::Deviation | Measure::Overlap => ", such as max = \"20 mm\"",
        Measure::Moment => ", such as max = \"0.5 N m\"",
        Measure::Strain => ", such as max = \"0.2 %\"",
        Measure::Torsion => ", such as max = \"180 deg/m\"",
        Measure::Turns => ", such as max = 1.5",
        Measure::Reach => ", such as max = 0.98",
        _ => ", such as max = \"40 N\"",
    }
}

/// The parts of a requirement, and those against which they are measured.
fn parts(entry: &Entry<'_>, measure: Measure, known: &Named<'_, '_>) -> Option<(Vec<Part>, Vec<Part>)> {
    let pairs = matches!(measure, Measure::Clearance | Measure::ContactForce);
    if entry.has("between") {
        if entry.has("of") {
            let message = format!("{} has `of` beside `between`", entry.label);
            entry.fault_at("of", message, "give either `of` or `between`");
        }
        if !pairs {
            let message = format!("{} has `between`, but a {} is of one part", entry.label, measure.title());
            entry.fault_at("between", message, "write of = { branch = \"…\" } or the like");
            return None;
        }
        let two = entry.entries("between");
        let [one, other] = two.as_slice() else {
            let message = format!("`between` of {} has {} parts", entry.label, two.len());
            entry.fault_at("between", message, "give two: [{ branch = \"…\" }, { obstacle = \"…\" }]");
            return None;
        };
        let (mut one, mut other) = (part(one, known)?, part(other, known)?);
        // Obstacles come second.
        if one.0 == Family::Obstacle {
            std::mem::swap(&mut one, &mut other);
        }
        let allowed = match (one.0, other.0) {
            (Family::Branch, Family::Branch | Family::Obstacle) => true,
            (Family::Constraint, Family::Obstacle) => measure == Measure::Clearance,
            _ => false,
        };
        if !allowed {
            let (one, other) = (one.0.word(), other.0.word());
            let message = format!("{} is between a {one} and a {other}", entry.label);
            let help = "a clearance is between a branch or a constraint and an obstacle, or between two branches; a \
                        contact force between a branch and an obstacle or another branch";
            entry.fault_at("between", message, help);
            return None;
        }
        if measure == Measure::ContactForce && other.0 == Family::Branch && !known.contact.cables {
            let message = format!("{}: cables do not touch each other in this scenario", entry.label);
            entry.fault_at("between", message, "write [contact] with cables = true");
        }
        if measure == Measure::Clearance && refuse_common(entry, &one.1, &other.1, known) {
            return None;
        }
        return Some((one.1, other.1));
    }
    let all = |family| all(family, known);
    let Some(of) = entry.entry("of") else {
        if entry.has("of") {
            return None;
        }
        let family = families(measure)[0];
        let parts = all(family);
        if parts.is_empty() {
            let message = format!("{} has no `of`, and there is no {} in this scenario", entry.label, family.word());
            entry.fault_here(message, "say what it is about, such as of = { branch = \"…\" }");
            return None;
        }
        return Some((parts, Vec::new()));
    };
    let (family, parts) = part(&of, known)?;
    if !families(measure).contains(&family) {
        let words: Vec<String> = families(measure).iter().map(|family| format!("{} = \"…\"", family.word())).collect();
        let message = format!("{} is about a {}, which has no {}", entry.label, family.word(), measure.title());
        entry.fault_at("of", message, format!("write {{ {} }}", words.join(" } or { ")));
        return None;
    }
    // An obstacle alone: all branches together, or the nearest of them.
    if !pairs || family == Family::Obstacle {
        return Some((parts, Vec::new()));
    }
    let obstacles = all(Family::Obstacle);
    if obstacles.is_empty() {
        let message = format!("{} is about a branch alone, and there are no obstacles", entry.label);
        entry.fault_at(
            "of",
            message,
            "say what it is measured from: between = [{ branch = \"…\" }, { branch = \"…\" }]",
        );
        return None;
    }
    Some((parts, obstacles))
}

/// Refuses a clearance between parts that all have cable in common, between which there is no distance. Groups of
/// branches may overlap: a branch is then measured from the others.
fn refuse_common(entry: &Entry<'_>, one: &[Part], other: &[Part], known: &Named<'_, '_>) -> bool {
    let common = |(a, b): (&Part, &Part)| match (*a, *b) {
        (Part::Branch { branch, from, to }, Part::Branch { branch: second, from: start, to: end }) => {
            let own = &known.branches[branch];
            let (from, to) = (from.max(start), to.min(end).min(own.length));
            (branch == second && from < to).then_some((&own.name, from, to))
        }
        _ => None,
    };
    let pairs = one.iter().flat_map(|a| other.iter().map(move |b| (a, b)));
    let Some(all) = pairs.map(common).collect::<Option<Vec<_>>>() else { return false };
    let Some((name, from, to)) = all.first() else { return false };
    let message = format!(
        "the parts of {} have branch \"{name}\" from s = {from} m to {to} m in common: there is no clearance between \
         them",
        entry.label
    );
    entry.fault_at("between", message, "name parts without common cable: other branches, or other `from` and `to`");
    true
}

/// All parts of a family.
fn all(family: Family, known: &Named<'_, '_>) -> Vec<Part> {
    match family {
        Family::Branch => (0..known.branches.len()).map(Part::whole).collect(),
        Family::Constraint => (0..known.constraints.len()).map(Part::Constraint).collect(),
        Family::Obstacle => known.names.obstacles.values().copied().map(Part::Obstacle).collect(),
    }
}

/// The parts that an entry names, all of one family; `None`, with a fault, if there are none.
fn part(entry: &Entry<'_>, known: &Named<'_, '_>) -> Option<(Family, Vec<Part>)> {
    let keys = ["branch", "branches", "constraint", "constraints", "obstacle", "obstacles"];
    let given: Vec<&str> = keys.into_iter().filter(|key| entry.has(key)).collect();
    let [key] = given.as_slice() else {
        let found = if given.is_empty() { "names nothing".to_owned() } else { format!("has {}", given.join(" and ")) };
        entry.fault_here(
            format!("{} {found}", entry.label),
            "write one of { branch = \"…\" }, { branches = \"…*\" }, \
            { constraint = \"…\" }, { constraints = \"…*\" }, { obstacle = \"…\" }, { obstacles = \"…*\" }",
        );
        return None;
    };
    let (from, to) = (entry.number("from"), entry.number("to"));
    if *key != "branch" && (entry.has("from") || entry.has("to")) {
        entry.fault_here(format!("{} has `from` or `to` without `branch`", entry.label), "leave them out");
        return None;
    }
    let name = entry.word(key)?;
    let (family, one) = match *key {
        "branch" | "branches" => (Family::Branch, *key == "branch"),
        "constraint" | "constraints" => (Family::Constraint, *key == "constraint"),
        _ => (Family::Obstacle, *key == "obstacle"),
    };
    // A name may be taken again by a later constraint.
    let names: Vec<&str> = match family {
        Family::Branch => known.branches.iter().map(|branch| branch.name.as_str()).collect(),
        Family::Constraint => known.constraints.iter().map(|constraint| constraint.name.as_str()).collect(),
        Family::Obstacle => {
            let mut names: Vec<(&str, usize)> =
                known.names.obstacles.iter().map(|(name, k)| (name.as_ref(), *k)).collect();
            names.sort_by_key(|(_, k)| *k);
            names.into_iter().map(|(name, _)| name).collect()
        }
    };
    let pattern = WildMatch::new(name);
    let fits = |other: &str| if one { other == name } else { pattern.matches(other) };
    let indices: Vec<usize> = (0..names.len()).filter(|k| fits(names[*k])).collect();
    if indices.is_empty() {
        let (message, help) = if one {
            (format!("unknown {key} \"{name}\" in {}", entry.label), did_you_mean(name, names.iter().copied()))
        } else {
            let some: Vec<&str> = names.iter().copied().take(6).collect();
            (format!("no {} has a name like \"{name}\"", family.word()), format!("there are {}", some.join(", ")))
        };
        entry.fault_at(key, message, help);
        return None;
    }
    let parts = indices.into_iter().map(|k| match family {
        Family::Branch => Part::Branch { branch: k, from: from.unwrap_or(0.0), to: to.unwrap_or(f64::INFINITY) },
        Family::Constraint => Part::Constraint(k),
        Family::Obstacle => Part::Obstacle(k),
    });
    let parts: Vec<Part> = parts.collect();
    if let [Part::Branch { branch, from, to }] = parts.as_slice() {
        let length = known.branches[*branch].length;
        if to <= from || *from >= length || (to.is_finite() && *to > length * (1.0 + 1e-9)) {
            let message = format!("{} is not a part of branch \"{name}\", which is {length} m long", entry.label);
            entry.fault_here(message, "give `from` before `to`, both on the branch");
            return None;
        }
    }
    Some((family, parts))
}

/// Refuses a deviation from a centre line that is not drawn.
fn refuse_undrawn(entry: &Entry<'_>, of: &[Part], known: &Named<'_, '_>) {
    for part in of {
        let Part::Branch { branch, .. } = *part else { continue };
        let branch = &known.branches[branch];
        if branch.drawn().is_empty() {
            let message = format!("{}: branch \"{}\" has no drawn centre line", entry.label, branch.name);
            entry.fault_at("of", message, "draw it: add `path` or `drawn` to the branch");
            return;
        }
    }
}

/// Refuses the insertion force of constraints none of which is ever pushed in.
fn refuse_unmated(entry: &Entry<'_>, of: &[Part], known: &Named<'_, '_>) {
    let mated = |f: usize| {
        let mut operations = known.steps.iter().flat_map(|step| &step.operations);
        operations.any(|operation| matches!(operation, Operation::Mate { constraint, .. } if *constraint == f))
    };
    if !of.iter().any(|part| matches!(part, Part::Constraint(f) if mated(*f))) {
        let message = format!("{}: no step pushes this constraint in", entry.label);
        entry.fault_at("of", message, "push it in by [[steps.mate]]");
    }
}

/// A marker; `None` if it is faulty.
pub(crate) fn marker<'a>(
    entry: &Entry<'a>,
    index: usize,
    names: &Names<'a>,
    taken: &mut BTreeMap<&'a str, usize>,
) -> Option<Marker> {
    let name = entry.word("name").filter(|name| register(entry, entry.keys.what, taken, name, index));
    let (branch, s) = match attachment(&entry.entry("at")?, names, false)?.0 {
        At::Branch { branch, s } => (branch, s),
        At::Joint(joint) => {
            // The end there of the first branch that meets at it.
            let named = names.joints.iter().find(|(_, index)| **index == joint).map(|(name, _)| *name)?;
            let (branch, starts_here) = *names.vertices.get(named)?.ends.first()?;
            (branch, if starts_here { 0.0 } else { (*names.lengths.get(branch)?)? })
        }
    };
    Some(Marker { name: name?.to_owned(), branch, s })
}
