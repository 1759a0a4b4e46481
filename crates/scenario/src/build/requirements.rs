//! What is required of a harness: the entries of `[[requirements]]`, the limits of its parts, and what holds for every
//! harness.

use crate::scenario::{ByRule, Scenario, SectionPart};
use std::collections::BTreeMap;
use wireloom_core::Network;
use wireloom_core::requirement::{Measure, Motion, Origin, Part, Requirement, SOFT, Severity};
use wireloom_core::steps::Operation;

/// All requirements on the harness of a scenario, those of the file first.
pub(super) fn requirements(scenario: &Scenario, network: &Network) -> Vec<Requirement> {
    let mut all: Vec<Requirement> = scenario.requirements.iter().map(|own| own.requirement.clone()).collect();
    all.extend(of_parts(scenario, network));
    all.extend(always(network));
    all
}

fn requirement(name: &str, origin: Origin, measure: Measure, of: Vec<Part>) -> Requirement {
    Requirement {
        name: name.to_owned(),
        origin,
        measure,
        of,
        against: Vec::new(),
        min: None,
        max: None,
        steps: None,
        motion: Motion::Any,
        severity: Severity::Must,
        because: None,
    }
}

/// The limits of sections, constraints and obstacles, named after them.
pub(crate) fn of_parts(scenario: &Scenario, network: &Network) -> Vec<Requirement> {
    let mut all = Vec::new();
    let mut of_section = vec![Vec::new(); scenario.sections.len()];
    for (b, branch) in scenario.branches.iter().enumerate() {
        for SectionPart { section, range: [from, to] } in branch.section_spans() {
            let whole = branch.parts.is_empty();
            of_section[section].push(if whole { Part::whole(b) } else { Part::Branch { branch: b, from, to } });
        }
    }
    for (k, (section, of)) in scenario.sections.iter().zip(of_section).enumerate() {
        let own = |measure| requirement(&section.name, Origin::Section, measure, of.clone());
        if of.is_empty() {
            continue;
        }
        if section.min_bend_radius.is_some() {
            all.push(Requirement { min: section.min_bend_radius, ..own(Measure::BendRadius) });
        }
        if section.min_bend_radius_moving.is_some() {
            let moving = Requirement { motion: Motion::Moving, ..own(Measure::BendRadius) };
            all.push(Requirement { min: section.min_bend_radius_moving, ..moving });
        }
        if section.max_tension.is_some() {
            let measured = |rule: &&ByRule| rule.measured.iter().any(|key| key == "max_tension");
            let by_rule = scenario.by_rule.iter().find(|rule| rule.section == k).filter(|rule| !measured(rule));
            let because = by_rule.map(|_| "strength of its conductors".to_owned());
            all.push(Requirement { max: section.max_tension, because, ..own(Measure::Tension) });
        }
        if section.max_torsion.is_some() {
            all.push(Requirement { max: section.max_torsion, ..own(Measure::Torsion) });
        }
    }
    let insertion_limits = insertion_limits(scenario);
    for (f, constraint) in network.constraints.iter().enumerate() {
        let own = |measure| requirement(&constraint.name, Origin::Constraint, measure, vec![Part::Constraint(f)]);
        let limits = [
            (Measure::Force, constraint.limits.pull_out_force),
            (Measure::Moment, constraint.limits.max_moment),
            (Measure::InsertionForce, insertion_limits.get(&f).copied()),
        ];
        let given = limits.into_iter().filter(|(_, limit)| limit.is_some());
        all.extend(given.map(|(measure, max)| Requirement { max, ..own(measure) }));
    }
    for (o, obstacle) in network.obstacles.iter().enumerate() {
        let own = |measure| requirement(&obstacle.name, Origin::Obstacle, measure, vec![Part::Obstacle(o)]);
        if obstacle.min_clearance.is_some() {
            all.push(Requirement { min: obstacle.min_clearance, ..own(Measure::Clearance) });
        }
        if obstacle.max_contact_force.is_some() {
            all.push(Requirement { max: obstacle.max_contact_force, ..own(Measure::ContactForce) });
        }
    }
    all
}

/// The largest force with which each constraint may be pushed in; the smallest of several.
fn insertion_limits(scenario: &Scenario) -> BTreeMap<usize, f64> {
    let mut limits = BTreeMap::new();
    for operation in scenario.steps.iter().flat_map(|step| &step.operations) {
        if let Operation::Mate { constraint, limit: Some(limit), .. } = operation {
            let known = limits.entry(*constraint).or_insert(*limit);
            *known = limit.min(*known);
        }
    }
    limits
}

/// What holds for every harness: spans bridge what they are long enough for, and are not pressed straight beyond what
/// buckles them; cables do not pass through each other, and bodies not through what constraints hold.
fn always(network: &Network) -> Vec<Requirement> {
    let branches: Vec<Part> = (0..network.branches.len()).map(Part::whole).collect();
    let own = |name, measure| requirement(name, Origin::Always, measure, branches.clone());
    let thinnest = network.branches.iter().flat_map(|branch| branch.sections.iter()).map(|section| section.diameter);
    let thinnest = thinnest.fold(f64::INFINITY, f64::min);
    // All limits but the first depend on the span or on the pair; they are computed with the values.
    let mut all = vec![
        Requirement { max: Some(1.0), ..own("spans are long enough", Measure::Reach) },
        Requirement { max: Some(0.0), ..own("straight spans do not buckle", Measure::Buckling) },
        Requirement { max: Some(SOFT * thinnest), ..own("cables lie side by side", Measure::Overlap) },
    ];
    if !network.obstacles.is_empty() {
        let held = (0..network.constraints.len()).map(Part::Constraint).collect();
        let own = requirement("bodies are not driven into held cables", Origin::Always, Measure::Overlap, held);
        all.push(Requirement { max: Some(0.5 * thinnest), ..own });
    }
    all
}
