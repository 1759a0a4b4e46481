//! Requirements that no harness can keep together with the limits of its parts.

use crate::build::requirements::of_parts;
use crate::fault::Fault;
use crate::scenario::Scenario;
use wireloom_core::Network;
use wireloom_core::requirement::{Origin, Part, Requirement};

/// Refuses every requirement of the file that contradicts a limit of a part it is about.
pub(crate) fn refuse_contradictions(scenario: &Scenario, network: &Network) -> Vec<Fault> {
    let limits = of_parts(scenario, network);
    let mut faults = Vec::new();
    for own in &scenario.requirements {
        let requirement = &own.requirement;
        let same = |limit: &&Requirement| {
            limit.measure == requirement.measure
                && (meet(&limit.of, &requirement.of) || meet(&limit.of, &requirement.against))
        };
        for limit in limits.iter().filter(same) {
            let (key, asked, least, bound) = match (requirement.min, requirement.max, limit.min, limit.max) {
                (_, Some(asked), Some(least), _) if asked < least => ("max", asked, least, "at least"),
                (Some(asked), _, _, Some(most)) if asked > most => ("min", asked, most, "at most"),
                _ => continue,
            };
            let part = match limit.origin {
                Origin::Section => "section",
                Origin::Constraint => "constraint",
                _ => "obstacle",
            };
            let (measure, unit) = (requirement.measure.title(), requirement.measure.unit());
            faults.push(Fault {
                span: own.spans.of(Some(key)),
                message: format!(
                    "requirement \"{}\" asks for a {measure} of {key} = {asked} {unit}, but {part} \"{}\" allows \
                     {bound} {least} {unit}: no harness keeps both",
                    requirement.name, limit.name
                ),
                help: format!("change `{key}`, or the limit of the {part}"),
            });
        }
    }
    faults
}

/// Whether two lists have a part in common.
fn meet(one: &[Part], other: &[Part]) -> bool {
    let same = |a: &Part, b: &Part| match (*a, *b) {
        (Part::Branch { branch: a, .. }, Part::Branch { branch: b, .. }) => a == b,
        (a, b) => a == b,
    };
    one.iter().any(|a| other.iter().any(|b| same(a, b)))
}
