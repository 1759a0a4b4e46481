//! Parts of branches on which a requirement is not kept, for pages that mark them.

use crate::frame::Stretch;
use wireloom::StepResult;
use wireloom::result::{BranchResult, EventPlace, Measure, Violation};

/// Fraction of the mean stretch of a span above which a place of it is stretched.
const STRETCHED: f64 = 0.5;

/// The parts of branches on which a cable is stretched, overloaded or in another one, of this violation: each reaches
/// half a segment beyond its nodes. The place of the violation where no node tells it; empty for other measures.
pub(crate) fn of(violation: &Violation, end: &StepResult) -> Vec<Stretch> {
    let Violation { measure, value, limit, place, .. } = violation;
    let EventPlace { branch, s, other_branch, other_s, .. } = place;
    let of_name = |name: &Option<String>| end.branches.iter().find(|own| Some(&own.name) == name.as_ref());
    let Some(own) = of_name(branch) else { return Vec::new() };
    let other = of_name(other_branch);
    let around = |branch: &BranchResult, s: Option<f64>| {
        let (first, last) = (branch.s[0], branch.s[branch.s.len() - 1]);
        let reach = s.map_or(f64::INFINITY, |_| own.diameter + other.map_or(0.0, |other| other.diameter));
        let s = s.unwrap_or(first);
        Stretch { branch: branch.name.clone(), from: (s - reach).max(first), to: (s + reach).min(last) }
    };
    let found = match measure {
        Measure::Tension => beyond(own, |i| own.tension_at(i) > *limit),
        Measure::Compression => beyond(own, |i| -own.tension_at(i) > *limit),
        Measure::Strain if value < limit => beyond(own, |i| own.strain_at(i) < *limit),
        Measure::Strain => beyond(own, |i| own.strain_at(i) > *limit),
        Measure::Reach => beyond(own, |i| own.strain_at(i) > STRETCHED * (value - 1.0)),
        Measure::Overlap => other.map(|other| around(other, *other_s)).into_iter().chain([around(own, *s)]).collect(),
        _ => return Vec::new(),
    };
    if found.is_empty() { vec![around(own, *s)] } else { found }
}

/// Runs of nodes that are beyond a limit.
fn beyond(branch: &BranchResult, is_beyond: impl Fn(usize) -> bool) -> Vec<Stretch> {
    let s = &branch.s;
    let last = s.len() - 1;
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for node in (0..=last).filter(|node| is_beyond(*node)) {
        match runs.last_mut() {
            Some([_, to]) if *to + 1 == node => *to = node,
            _ => runs.push([node, node]),
        }
    }
    let stretch = |[from, to]: [usize; 2]| Stretch {
        branch: branch.name.clone(),
        from: 0.5 * (s[from] + s[from.saturating_sub(1)]),
        to: 0.5 * (s[to] + s[(to + 1).min(last)]),
    };
    runs.into_iter().map(stretch).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom::{Control, Run};

    /// A cable of 1 m that is held at 0, 0.5 and 1 m, there at x = 0, 0.45 m and `x`; its wires bear 400 N.
    fn run(x: f64) -> Run {
        let held = |name: &str, kind: &str, at: &str, x: f64| {
            format!(
                "[[constraints]]\nname = \"{name}\"\nkind = \"{kind}\"\nat = {at}\nposition = [{x}, 0, 0]\n\
                 tangent = [1, 0, 0]\n"
            )
        };
        let text = [
            "schema = 1\nname = \"held\"\n[sections.s]\ndiameter = \"6 mm\"\nlinear_density = 0.05\n\
             axial_stiffness = 1e4\nbending_stiffness = 0.01\ntorsion_stiffness = 0.008\n\
             [[branches]]\nname = \"cable\"\nfrom = \"A\"\nto = \"B\"\nsection = \"s\"\nlength = 1\nsegments = 40\n\
             [[requirements]]\nname = \"wires\"\nquantity = \"tension\"\nof = { branch = \"cable\" }\nmax = 400\n",
            &held("a", "connector", "{ end = \"A\" }\nup = [0, 0, 1]", 0.0),
            &held("clip", "collar", "{ branch = \"cable\", s = 0.5 }", 0.45),
            &held("b", "connector", "{ end = \"B\" }\nup = [0, 0, 1]", x),
        ];
        let built = wireloom::load(&text.concat(), &wireloom::registry()).expect("no faults").1;
        wireloom::run(built, &mut |_, _| Control::Continue)
    }

    #[test]
    fn only_the_span_that_is_stretched_is_marked() {
        let run = run(1.0);
        let end = &run.steps[0];
        for measure in [Measure::Reach, Measure::Tension] {
            let violation = end.violations.iter().find(|own| own.measure == measure).expect("stretched by a tenth");
            let [stretch] = &of(violation, end)[..] else { panic!("{:?}", of(violation, end)) };
            assert_eq!(stretch.branch, "cable");
            // The clip lies at a node, whose force is the mean of both sides.
            let [from, to] = [stretch.from - 0.5, stretch.to - 1.0].map(f64::abs);
            assert!(from < 0.013 && to < 1e-9, "{measure:?}: {stretch:?}");
        }
        assert!(end.violations.iter().all(|own| own.measure != Measure::BendRadius));
    }

    #[test]
    fn a_violation_that_no_node_shows_is_marked_at_its_place() {
        let run = run(1.0);
        let end = &run.steps[0];
        let violation = end.violations.iter().find(|own| own.measure == Measure::Tension).expect("one");
        let at = |s| EventPlace { s, ..violation.place.clone() };
        let unknown = |s| of(&Violation { limit: f64::NAN, place: at(s), ..violation.clone() }, end);
        for (s, [from, to]) in [(Some(0.2), [0.194, 0.206]), (None, [0.0, 1.0])] {
            let [stretch] = &unknown(s)[..] else { panic!("{:?}", unknown(s)) };
            assert!((stretch.from - from).abs() < 1e-9 && (stretch.to - to).abs() < 1e-9, "{stretch:?}");
        }
    }
}
