//! Reads the outputs of a sweep.

use super::entry::Entry;
use super::names::{Names, lookup};
use super::places::{attachment, stretch};
use crate::attachment::{At, Stretch};
use crate::fault::did_you_mean;
use crate::sweep::{Body, Measured, Output, When};
use toml::Spanned;
use toml::de::DeValue;
use wireloom_core::steps::Step;

/// Name of the only step of a scenario without steps.
const ONLY: &str = "equilibrium";

/// Reads an output; `None` if it is faulty.
pub(crate) fn output(name: &str, entry: &Entry<'_>, names: &Names<'_>, steps: &[Step]) -> Option<Output> {
    for (taken, what) in [
        (names.branches.contains_key(name), "branch"),
        (names.constraints.contains_key(name) || names.let_go.contains(name), "constraint"),
    ] {
        if taken {
            let message = format!("{} has the name of a {what}, which is that of other columns", entry.label);
            entry.fault_here(message, "give it another name");
            return None;
        }
    }
    let quantity = entry.choice("quantity")?;
    let at = at(entry, steps);
    let measured = measured(quantity, entry, names);
    let (at, measured) = (at?, measured?);
    if matches!((&measured, at), (Measured::Orientation(_), When::Min | When::Max)) {
        let message = format!("{}: an orientation has no least or greatest value", entry.label);
        entry.fault_at("at", message, "write at = \"end\", or the name of a step");
        return None;
    }
    Some(Output { name: name.to_owned(), measured, at })
}

/// Increment at which it is measured.
fn at(entry: &Entry<'_>, steps: &[Step]) -> Option<When> {
    if let Some(DeValue::Table(_)) = entry.table.get("at").map(Spanned::get_ref) {
        let message = format!("`at` of {} is a place, but says when it is measured", entry.label);
        entry.fault_at("at", message, "give the place by `of`, such as of = { end = \"…\" }");
        return None;
    }
    if !entry.has("at") {
        return Some(When::End);
    }
    Some(match entry.word("at")? {
        "end" => When::End,
        "min" => When::Min,
        "max" => When::Max,
        ONLY if steps.is_empty() => When::Step(0),
        name => match steps.iter().position(|step| step.name == name) {
            Some(step) => When::Step(step),
            None => {
                let known = ["end", "min", "max"].into_iter().chain(steps.iter().map(|step| step.name.as_str()));
                let message = format!("{} is measured at \"{name}\", which is no step", entry.label);
                entry.fault_at("at", message, did_you_mean(name, known));
                return None;
            }
        },
    })
}

/// Quantity and what it is measured of.
fn measured(quantity: &str, entry: &Entry<'_>, names: &Names<'_>) -> Option<Measured> {
    if matches!(quantity, "angle" | "clearance") {
        return between(quantity, entry, names);
    }
    if entry.has("between") {
        let message = format!("{} has `between`, but {quantity} is of one part", entry.label);
        entry.fault_at("between", message, "leave it out, and give the part by `of`");
        return None;
    }
    let Some(of) = entry.entry("of") else {
        if !entry.has("of") {
            let message = format!("{} does not say what is measured", entry.label);
            entry.fault_here(message, format!("add of = {}", example(quantity)));
        }
        return None;
    };
    let part = part(&of, names)?;
    if quantity != "output" && of.has("output") {
        let message = format!("{} has `output`, but measures {quantity}", entry.label);
        of.fault_at("output", message, "leave it out, or write quantity = \"output\"");
        return None;
    }
    let of_constraint_or_obstacle = matches!(part, Part::Body(Body::Constraint(_) | Body::Obstacle(_)));
    match (quantity, part) {
        ("position", Part::Body(body)) => Some(Measured::Position(body)),
        ("orientation", Part::Body(body)) => Some(Measured::Orientation(body)),
        ("force", Part::Body(body)) if of_constraint_or_obstacle => Some(Measured::Reaction(body)),
        ("moment", Part::Body(body)) if of_constraint_or_obstacle => Some(Measured::ReactionMoment(body)),
        ("force", Part::Body(Body::Place(At::Branch { branch, s }))) => Some(Measured::Force(branch, s)),
        ("moment", Part::Body(Body::Place(At::Branch { branch, s }))) => Some(Measured::Moment(branch, s)),
        ("tension", Part::Body(Body::Place(At::Branch { branch, s }))) => Some(Measured::Tension(branch, s)),
        ("force" | "moment" | "tension", Part::Body(Body::Place(At::Joint(_)))) => {
            let message = format!("{} is at a joint, where every branch has a {quantity} of its own", entry.label);
            of.fault_here(message, "give a place on one branch: of = { branch = \"…\", s = … }");
            None
        }
        ("bend_radius", Part::Stretch(stretch)) => Some(Measured::BendRadius(stretch)),
        ("slack", Part::Stretch(stretch)) => Some(Measured::Slack(stretch)),
        ("turns", Part::Stretch(stretch)) if !of.has("from") && !of.has("to") => Some(Measured::Turns(stretch.branch)),
        ("contact_force", Part::Body(Body::Obstacle(obstacle))) => Some(Measured::ContactForce(obstacle)),
        ("output", Part::Body(Body::Constraint(constraint))) if of.has("output") => {
            let output = of.word("output")?;
            // A constraint whose kind is faulty is not there.
            let known = names.outputs.get(constraint.as_str())?;
            if !known.iter().any(|name| name == output) {
                let message = format!("constraint \"{constraint}\" has no output \"{output}\"");
                let help = if known.is_empty() {
                    "its kind has none: outputs are those of plugins".to_owned()
                } else {
                    did_you_mean(output, known.iter().map(String::as_str))
                };
                of.fault_at("output", message, help);
                return None;
            }
            Some(Measured::Output(constraint, output.to_owned()))
        }
        _ => {
            let message = format!("{}: {quantity} is not measured of that", entry.label);
            of.fault_here(message, format!("write of = {}", example(quantity)));
            None
        }
    }
}

/// What a quantity is measured of, as an example.
fn example(quantity: &str) -> &'static str {
    match quantity {
        "bend_radius" | "slack" => "{ branch = \"…\" } or { branch = \"…\", from = …, to = … }",
        "turns" => "{ branch = \"…\" }",
        "contact_force" => "{ obstacle = \"…\" }",
        "output" => "{ constraint = \"…\", output = \"…\" }",
        "tension" => "{ branch = \"…\", s = … } or { end = \"…\" }",
        _ => "{ branch = \"…\", s = … }, { end = \"…\" }, { constraint = \"…\" } or { obstacle = \"…\" }",
    }
}

/// What is between two parts.
fn between(quantity: &str, entry: &Entry<'_>, names: &Names<'_>) -> Option<Measured> {
    let help = match quantity {
        "angle" => "between = [{ branch = \"…\", s = … }, { branch = \"…\", s = … }]",
        _ => "between = [{ branch = \"…\" }, { obstacle = \"…\" }]",
    };
    if entry.has("of") || !entry.has("between") {
        let message = format!("{}: {quantity} is measured between two parts", entry.label);
        entry.fault_here(message, format!("write {help}"));
        return None;
    }
    let two = entry.entries("between");
    let [one, other] = two.as_slice() else {
        let message = format!("`between` of {} has {} parts", entry.label, two.len());
        entry.fault_at("between", message, format!("write {help}"));
        return None;
    };
    let (one, other) = (part(one, names), part(other, names));
    match (quantity, one?, other?) {
        (
            "angle",
            Part::Body(Body::Place(At::Branch { branch: a, s: at_a })),
            Part::Body(Body::Place(At::Branch { branch: b, s: at_b })),
        ) => Some(Measured::Angle([(a, at_a), (b, at_b)])),
        ("clearance", Part::Stretch(a), Part::Stretch(b)) if a.branch != b.branch => {
            Some(Measured::Clearance(a, Body::Part(b)))
        }
        ("clearance", Part::Stretch(branch), Part::Body(obstacle @ Body::Obstacle(_)))
        | ("clearance", Part::Body(obstacle @ Body::Obstacle(_)), Part::Stretch(branch)) => {
            Some(Measured::Clearance(branch, obstacle))
        }
        _ => {
            let message = format!("{}: {quantity} is not measured between these", entry.label);
            entry.fault_at("between", message, format!("write {help}"));
            None
        }
    }
}

/// A part of the scenario that something is measured of.
enum Part {
    Body(Body),
    Stretch(Stretch),
}

/// The part that an entry names; `None`, with a fault, if it does not name one.
fn part(of: &Entry<'_>, names: &Names<'_>) -> Option<Part> {
    let given = ["end", "joint", "branch", "constraint", "obstacle"].into_iter().filter(|key| of.has(key));
    let given: Vec<&str> = given.collect();
    let ["end" | "joint" | "branch" | "constraint" | "obstacle"] = given.as_slice() else {
        let found = if given.is_empty() { "names nothing".to_owned() } else { format!("has {}", given.join(" and ")) };
        let help = "write one of { end = \"…\" }, { joint = \"…\" }, { branch = \"…\" }, { constraint = \"…\" }, \
                    { obstacle = \"…\" }";
        of.fault_here(format!("{} {found}", of.label), help);
        return None;
    };
    let stray = ["s", "from", "to"].into_iter().find(|key| of.has(key));
    if let (false, Some(stray)) = (of.has("branch"), stray) {
        of.fault_at(stray, format!("{} has `{stray}` but no `branch`", of.label), "leave it out");
        return None;
    }
    if of.has("s") && (of.has("from") || of.has("to")) {
        of.fault_at(
            "s",
            format!("{} has `s` beside `from` or `to`", of.label),
            "give a place, or a part of the branch",
        );
        return None;
    }
    if of.has("constraint") {
        let name = of.word("constraint")?;
        if !names.constraints.contains_key(name) && !names.let_go.contains(name) {
            let known = names.constraints.keys().chain(&names.let_go).copied();
            let message = format!("unknown constraint \"{name}\" in {}", of.label);
            of.fault_at("constraint", message, did_you_mean(name, known));
            return None;
        }
        return Some(Part::Body(Body::Constraint(name.to_owned())));
    }
    if of.has("obstacle") {
        let name = of.word("obstacle")?;
        let obstacle = lookup(of, "obstacle", &names.obstacles, name, of.span_of("obstacle"))?;
        return Some(Part::Body(Body::Obstacle(*obstacle)));
    }
    if of.has("branch") && !of.has("s") {
        return stretch(of, names).map(Part::Stretch);
    }
    attachment(of, names, false).map(|(at, _)| Part::Body(Body::Place(at)))
}
