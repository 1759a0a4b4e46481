//! Columns that a sweep asks for: quantities of the last equilibrium of a point, of the end of a step, or their least
//! and greatest values over all increments.

use wireloom_core::equilibrium::{BranchResult, ConstraintResult, StepResult};
use wireloom_core::rotation::columns as axes;
use wireloom_core::{Network, Rotation, Vector};
use wireloom_export::ending::BranchEnd;
use wireloom_scenario::Stretch;
use wireloom_scenario::sweep::{At, Body, Measured, Output, When};
use wireloom_solve::Progress;

/// Arc lengths that differ by less than this fraction of the branch are the same.
const SAME_PLACE: f64 = 1e-9;

/// Names of an output's columns.
pub(crate) fn columns(output: &Output) -> Vec<String> {
    let name = &output.name;
    let components =
        |what: &str, axes: &[&str]| axes.iter().map(|axis| format!("{what}_{axis}.{name}")).collect::<Vec<_>>();
    let with_norm = |what: &str| [vec![format!("{what}.{name}")], components(what, &["x", "y", "z"])].concat();
    match output.measured {
        Measured::Position(_) => components("position", &["x", "y", "z"]),
        Measured::Orientation(_) => components("orientation", &["w", "x", "y", "z"]),
        Measured::Angle(_) => vec![format!("angle.{name}")],
        Measured::Force(..) | Measured::Reaction(_) => with_norm("force"),
        Measured::Moment(..) | Measured::ReactionMoment(_) => with_norm("moment"),
        Measured::Tension(..) => vec![format!("tension.{name}")],
        Measured::BendRadius(_) => vec![format!("bend_radius.{name}")],
        Measured::Slack(_) => vec![format!("slack.{name}")],
        Measured::Turns(_) => vec![format!("turns.{name}")],
        Measured::Clearance(..) => vec![format!("clearance.{name}")],
        Measured::ContactForce(_) => vec![format!("contact_force.{name}")],
        Measured::Output(..) => vec![format!("output.{name}")],
    }
}

/// Recorder of the outputs of a point.
pub(super) struct Recorder<'o> {
    outputs: &'o [Output],
    /// Values so far of each output; empty where there are none.
    values: Vec<Vec<f64>>,
}

impl<'o> Recorder<'o> {
    pub fn new(outputs: &'o [Output]) -> Self {
        Self { outputs, values: vec![Vec::new(); outputs.len()] }
    }

    /// Takes the end of an increment; extremes are those of equilibria.
    pub fn add(&mut self, network: &Network, progress: &Progress, end: &StepResult) {
        let balanced = end.status.is_balanced();
        for (output, so_far) in self.outputs.iter().zip(&mut self.values) {
            match output.at {
                When::End => {}
                When::Step(step) => {
                    if progress.step_index == step && progress.increment == progress.increments {
                        *so_far = values(&output.measured, network, end);
                    }
                }
                When::Min | When::Max => {
                    if balanced {
                        let now = values(&output.measured, network, end);
                        keep(so_far, now, output);
                    }
                }
            }
        }
    }

    /// The values of all columns at the end of the run; NaN: there is none.
    pub fn finish(self, network: &Network, end: &StepResult) -> Vec<f64> {
        let all = self.outputs.iter().zip(self.values).flat_map(|(output, so_far)| {
            let values = if output.at == When::End { values(&output.measured, network, end) } else { so_far };
            let columns = columns(output).len();
            if values.len() == columns { values } else { vec![f64::NAN; columns] }
        });
        all.collect()
    }
}

/// Keeps the least or greatest values: of a position each coordinate's own, of a vector with a size the vector of that
/// size.
fn keep(so_far: &mut Vec<f64>, now: Vec<f64>, output: &Output) {
    let better = |new: f64, old: f64| match output.at {
        _ if old.is_nan() => !new.is_nan(),
        When::Min => new < old,
        _ => new > old,
    };
    if so_far.len() != now.len() {
        *so_far = now;
    } else if matches!(output.measured, Measured::Position(_)) {
        for (old, new) in so_far.iter_mut().zip(now) {
            if better(new, *old) {
                *old = new;
            }
        }
    } else if better(now[0], so_far[0]) {
        *so_far = now;
    }
}

/// Values of a quantity in an equilibrium; NaN where what is measured is not there.
pub(crate) fn values(measured: &Measured, network: &Network, end: &StepResult) -> Vec<f64> {
    let with_norm = |v: Vector| vec![v.norm(), v.x, v.y, v.z];
    let missing = || Vector::repeat(f64::NAN);
    let position = |branch: usize, s: f64| BranchEnd::of(&end.branches[branch]).position_at(s);
    match *measured {
        Measured::Position(ref body) => match *body {
            Body::Place(At::Joint(joint)) => end.joints[joint].position,
            Body::Place(At::Branch { branch, s }) => position(branch, s),
            Body::Part(Stretch { branch, from, .. }) => position(branch, from),
            Body::Constraint(ref name) => constraint(end, name).map_or_else(missing, |found| found.position),
            Body::Obstacle(obstacle) => end.obstacles[obstacle].pose.position,
        }
        .as_slice()
        .to_vec(),
        Measured::Orientation(ref body) => {
            let rotation = match *body {
                Body::Place(At::Joint(joint)) => Some(end.joints[joint].orientation),
                Body::Place(At::Branch { branch, s }) => Some(frame(&end.branches[branch], s)),
                Body::Part(Stretch { branch, from, .. }) => Some(frame(&end.branches[branch], from)),
                Body::Constraint(ref name) => constraint(end, name).map(|found| found.orientation),
                Body::Obstacle(obstacle) => Some(end.obstacles[obstacle].pose.orientation),
            };
            rotation.map_or(vec![f64::NAN; 4], |q| {
                // Of the two quaternions of a rotation the one with w ≥ 0, so that columns do not jump.
                let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
                [q.w, q.i, q.j, q.k].map(|x| sign * x).to_vec()
            })
        }
        Measured::Angle(places) => {
            let [a, b] = places.map(|(branch, s)| tangent(&end.branches[branch], s));
            vec![a.cross(&b).norm().atan2(a.dot(&b))]
        }
        Measured::Force(branch, s) => with_norm(between(&end.branches[branch], |b| &b.force, s)),
        Measured::Moment(branch, s) => with_norm(between(&end.branches[branch], |b| &b.moment, s)),
        Measured::Tension(branch, s) => {
            let branch = &end.branches[branch];
            vec![between(branch, |b| &b.force, s).dot(&tangent(branch, s))]
        }
        Measured::Reaction(ref body) => with_norm(match *body {
            Body::Constraint(ref name) => constraint(end, name).map_or_else(missing, |found| found.force),
            Body::Obstacle(obstacle) => end.obstacles[obstacle].force,
            Body::Place(_) | Body::Part(_) => missing(),
        }),
        Measured::ReactionMoment(ref body) => with_norm(match *body {
            Body::Constraint(ref name) => constraint(end, name).map_or_else(missing, |found| found.moment),
            Body::Obstacle(obstacle) => end.obstacles[obstacle].moment,
            Body::Place(_) | Body::Part(_) => missing(),
        }),
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
        Measured::Turns(branch) => vec![end.branches[branch].twist_turns],
        Measured::Clearance(part, ref other) => {
            let of = |Stretch { branch, from, to }: Stretch| (branch, from, to);
            vec![match *other {
                Body::Part(other) => wireloom_solve::clearance_of_branches(network, end, [of(part), of(other)]),
                Body::Obstacle(obstacle) => wireloom_solve::clearance_from_obstacle(network, end, of(part), obstacle),
                Body::Place(_) | Body::Constraint(_) => f64::NAN,
            }]
        }
        Measured::ContactForce(obstacle) => vec![end.obstacles[obstacle].contact_force],
        Measured::Output(ref of, ref output) => {
            let outputs = constraint(end, of).map_or(&[][..], |found| &found.outputs);
            vec![outputs.iter().find(|(name, _)| name == output).map_or(f64::NAN, |(_, value)| *value)]
        }
    }
}

fn constraint<'r>(end: &'r StepResult, name: &str) -> Option<&'r ConstraintResult> {
    end.constraints.iter().find(|constraint| constraint.name == name)
}

/// Unit vector along a branch at an arc length.
fn tangent(branch: &BranchResult, s: f64) -> Vector {
    let tangents: Vec<Vector> = branch.frame.iter().map(|frame| axes(frame)[2]).collect();
    interpolated(&branch.s, &tangents, s).normalize()
}

/// Frame of the nearest node.
fn frame(branch: &BranchResult, s: f64) -> Rotation {
    branch.frame[nearest(&branch.s, s)]
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
