//! Requirements that are not kept at one equilibrium.

use super::sheet::Found;
use std::cmp::Ordering;
use wireloom_core::EventPlace;
use wireloom_core::equilibrium::Violation;
use wireloom_core::requirement::Requirement;

/// The worst value beyond its limit of each requirement and part, from what was `found` for each requirement.
pub(crate) fn violations(requirements: &[Requirement], found: &[Vec<Found>]) -> Vec<Violation> {
    let mut all = Vec::new();
    for (requirement, found) in requirements.iter().zip(found) {
        let mut own: Vec<Violation> = Vec::new();
        for found in found {
            for (bound, limit) in found.limits(requirement) {
                let beyond = Violation {
                    name: requirement.name.clone(),
                    measure: requirement.measure,
                    severity: requirement.severity,
                    value: found.value,
                    limit,
                    bound,
                    place: found.place.clone(),
                };
                // What is not a number is beyond any limit.
                if gap(&beyond) >= 0.0 {
                    continue;
                }
                match own.iter_mut().find(|other| part(&other.place) == part(&beyond.place)) {
                    Some(other) if is_worse(&beyond, other) => *other = beyond,
                    Some(_) => {}
                    None => own.push(beyond),
                }
            }
        }
        all.append(&mut own);
    }
    all
}

fn gap(violation: &Violation) -> f64 {
    let Violation { bound, value, limit, .. } = violation;
    bound.gap(*value, *limit)
}

fn is_worse(one: &Violation, other: &Violation) -> bool {
    let margin = |violation: &Violation| {
        let Violation { bound, value, limit, .. } = violation;
        let margin = bound.margin(*value, *limit).unwrap_or(gap(violation));
        if margin.is_nan() { f64::NEG_INFINITY } else { margin }
    };
    margin(one).total_cmp(&margin(other)) == Ordering::Less
}

/// Place without arc lengths.
fn part(place: &EventPlace) -> EventPlace {
    EventPlace { s: None, other_s: None, ..place.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::requirement::{Bound, Measure, Motion, Origin, Severity};

    fn found(value: f64, branch: &str, s: f64) -> Found {
        Found { value, error: None, limit: None, place: EventPlace::branch(branch, s) }
    }

    #[test]
    fn the_worst_place_of_each_branch_counts() {
        let bend = Requirement {
            name: "bend".into(),
            origin: Origin::Scenario,
            measure: Measure::BendRadius,
            of: Vec::new(),
            against: Vec::new(),
            min: Some(0.05),
            max: None,
            steps: None,
            motion: Motion::Any,
            severity: Severity::Must,
            because: None,
        };
        let all = [
            found(0.06, "a", 0.1),
            found(0.04, "a", 0.2),
            found(0.03, "a", 0.3),
            found(0.045, "b", 0.4),
            found(f64::NAN, "c", 0.5),
            found(f64::INFINITY, "d", 0.6),
        ];
        let found = violations(&[bend], &[all.to_vec()]);
        let places: Vec<_> = found.iter().map(|own| (own.place.branch.as_deref(), own.place.s)).collect();
        assert_eq!(places, [(Some("a"), Some(0.3)), (Some("b"), Some(0.4)), (Some("c"), Some(0.5))]);
        assert_eq!((found[0].value, found[0].limit, found[0].bound), (0.03, 0.05, Bound::Min));
    }
}
