//! Balance of a whole harness, from its result alone: whatever a solver says of itself, forces and moments on a body at
//! rest add up to nothing.

use wireloom_core::equilibrium::StepResult;
use wireloom_core::load::{Axes, LoadAction};
use wireloom_core::network::LoadSite;
use wireloom_core::{Network, Rotation, Vector};

/// Resultant of all forces and moments that act on a harness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Imbalance {
    /// Force, as a share of the sum of all magnitudes and of EI/L², which a cable bears by bending.
    pub force: f64,
    /// Moment about the middle of the harness, as a share of that sum times the longest branch.
    pub moment: f64,
}

/// Adds up weight, loads (with their first factors), and what constraints and obstacles exert. Weight acts halfway
/// between nodes, so the moment of a curved cable is right to the square of its segments.
pub fn imbalance(network: &Network, gravity: &Vector, step: &StepResult) -> Imbalance {
    // Where a force acts, the force, and the moment about that place.
    let mut acting: Vec<(Vector, Vector, Vector)> = Vec::new();
    for (branch, result) in network.branches.iter().zip(&step.branches) {
        for (j, (s, x)) in result.s.windows(2).zip(result.position.windows(2)).enumerate() {
            let weight = gravity * (branch.sections.of(j).linear_density * (s[1] - s[0]));
            acting.push(((x[0] + x[1]) * 0.5, weight, Vector::zeros()));
        }
    }
    for (joint, result) in network.joints.iter().zip(&step.joints) {
        acting.push((result.position, gravity * joint.mass, Vector::zeros()));
    }
    for load in &network.loads {
        match &load.action {
            LoadAction::At { place: LoadSite { point, .. }, load: own } => {
                let of_branch =
                    network.branches.iter().zip(&step.branches).find(|(branch, _)| branch.points.contains(point));
                let of_joint = || network.joints.iter().zip(&step.joints).find(|(joint, _)| joint.point == *point);
                let (at, frame) = of_branch
                    .map(|(branch, result)| (point - branch.points.start, result))
                    .map(|(node, result)| (result.position[node], result.frame[node]))
                    .or_else(|| of_joint().map(|(_, result)| (result.position, result.orientation)))
                    .expect("a load acts on a node or a joint");
                let turn = if own.axes() == Axes::Frame { frame } else { Rotation::identity() };
                let [force, moment] = own.on(&frame).map(|v| turn * v * load.factor);
                acting.push((at, own.dead_force() * load.factor + force, moment));
            }
            LoadAction::Along { spans, load: own } => {
                for span in spans {
                    let (branch, result) = (&network.branches[span.branch], &step.branches[span.branch]);
                    for j in span.nodes.start..span.nodes.end - 1 {
                        let (a, b) = (result.frame[j], result.frame[j + 1]);
                        let halfway = a * (a.inverse() * b).powf(0.5);
                        let per_length = own.dead_force() + own.on(&halfway, branch.sections.of(j).diameter);
                        let at = (result.position[j] + result.position[j + 1]) * 0.5;
                        acting.push((at, per_length * load.factor * (result.s[j + 1] - result.s[j]), Vector::zeros()));
                    }
                }
            }
        }
    }
    for constraint in &step.constraints {
        if constraint.stations.is_empty() {
            acting.push((constraint.position, constraint.force, constraint.moment));
        }
        acting.extend(constraint.stations.iter().map(|station| (station.position, station.force, station.moment)));
    }
    acting.extend(step.obstacles.iter().map(|obstacle| (obstacle.pose.position, obstacle.force, obstacle.moment)));

    let nodes: Vec<&Vector> = step.branches.iter().flat_map(|branch| &branch.position).collect();
    let middle = nodes.iter().copied().sum::<Vector>() / nodes.len() as f64;
    let force: Vector = acting.iter().map(|(_, force, _)| force).sum();
    let moment: Vector = acting.iter().map(|(at, force, moment)| (at - middle).cross(force) + moment).sum();
    let length = step.branches.iter().filter_map(|branch| branch.s.last()).fold(0.0_f64, |a, b| a.max(*b));
    let sections = network.branches.iter().flat_map(|branch| branch.sections.iter());
    let bends = sections.map(|section| section.bend_diagonal().max()).fold(0.0, f64::max);
    let scale = acting.iter().map(|(_, force, _)| force.norm()).sum::<f64>() + bends / length.powi(2);
    Imbalance { force: force.norm() / scale, moment: moment.norm() / (scale * length) }
}
