//! Columns that a sweep asks for: quantities of a point's last equilibrium.

use wireloom_core::Vector;
use wireloom_core::equilibrium::{BranchResult, StepResult};
use wireloom_export::ending::Ending;
use wireloom_scenario::Stretch;
use wireloom_scenario::sweep::{At, Measured, Output};

/// Arc lengths that differ by less than this fraction of the branch are the same.
const SAME_PLACE: f64 = 1e-9;

/// Names of an output's columns.
pub(super) fn columns(output: &Output) -> Vec<String> {
    let name = &output.name;
    let components = |what: &str| ["x", "y", "z"].map(|axis| format!("{what}_{axis}.{name}"));
    let with_norm = |what: &str| std::iter::once(format!("{what}.{name}")).chain(components(what)).collect();
    match output.measured {
        Measured::Position(_) => components("position").to_vec(),
        Measured::Force(..) => with_norm("force"),
        Measured::Moment(..) => with_norm("moment"),
        Measured::Tension(..) => vec![format!("tension.{name}")],
        Measured::BendRadius(_) => vec![format!("bend_radius.{name}")],
        Measured::Slack(_) => vec![format!("slack.{name}")],
    }
}

/// Values of an output's columns at the end of a run.
pub(super) fn values(output: &Output, ending: &Ending, end: &StepResult) -> Vec<f64> {
    let with_norm = |v: Vector| vec![v.norm(), v.x, v.y, v.z];
    let position = |branch: usize, s: f64| ending.branches[branch].position_at(s);
    match output.measured {
        Measured::Position(At::Joint(joint)) => end.joints[joint].position.as_slice().to_vec(),
        Measured::Position(At::Branch { branch, s }) => position(branch, s).as_slice().to_vec(),
        Measured::Force(branch, s) => with_norm(between(&end.branches[branch], |b| &b.force, s)),
        Measured::Moment(branch, s) => with_norm(between(&end.branches[branch], |b| &b.moment, s)),
        Measured::Tension(branch, s) => {
            let tangents = &ending.branches[branch].tangent;
            let branch = &end.branches[branch];
            let tangent = interpolated(&branch.s, tangents, s).normalize();
            vec![between(branch, |b| &b.force, s).dot(&tangent)]
        }
        Measured::BendRadius(Stretch { branch, from, to }) => {
            let branch = &end.branches[branch];
            let near = SAME_PLACE * branch.s[branch.s.len() - 1];
            let inside = |s: f64| from - near <= s && s <= to + near;
            let nodes = branch.s.iter().zip(&branch.bend_radius).filter(|(s, _)| inside(**s));
            let tightest = nodes.map(|(_, radius)| *radius).min_by(f64::total_cmp);
            // Between two nodes.
            vec![tightest.unwrap_or_else(|| branch.bend_radius[nearest(&branch.s, 0.5 * (from + to))])]
        }
        Measured::Slack(Stretch { branch, from, to }) => {
            vec![to - from - (position(branch, to) - position(branch, from)).norm()]
        }
    }
}

fn between(branch: &BranchResult, of: impl Fn(&BranchResult) -> &Vec<Vector>, s: f64) -> Vector {
    interpolated(&branch.s, of(branch), s)
}

/// Linear interpolation between nodes at arc lengths `all`.
fn interpolated(all: &[f64], values: &[Vector], s: f64) -> Vector {
    let i = all.partition_point(|node| *node <= s).clamp(1, all.len() - 1) - 1;
    let t = ((s - all[i]) / (all[i + 1] - all[i])).clamp(0.0, 1.0);
    values[i].lerp(&values[i + 1], t)
}

fn nearest(all: &[f64], s: f64) -> usize {
    let distance = |i: &usize| (all[*i] - s).abs();
    (0..all.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}
