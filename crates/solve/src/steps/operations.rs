//! Results of the operations of a step: places of grasps and clips, forces of carrying and mating.

use wireloom_core::equilibrium::OperationResult;
use wireloom_core::network::Place;
use wireloom_core::problem::Problem;
use wireloom_core::steps::Operation;
use wireloom_core::{State, Vector};

/// A result has the kind of its operation.
const MADE_FROM_IT: &str = "a result is made from its operation";

/// Results of the operations at the beginning of a step.
pub(crate) fn begin(operations: &[Operation], problem: &Problem<'_>, state: &State) -> Vec<OperationResult> {
    let network = problem.network;
    let name = |constraint: usize| network.constraints[constraint].name.clone();
    let place = |constraint: usize| match network.constraints[constraint].place {
        Place::Node { branch, node } => {
            Some((network.branches[branch].name.clone(), state.arc_lengths(network, branch)[node]))
        }
        Place::Joint(_) => None,
    };
    let result = |operation: &Operation| match operation {
        Operation::Grasp { constraint } => {
            OperationResult::Grasp { constraint: name(*constraint), place: place(*constraint) }
        }
        Operation::Carry { constraints } => {
            OperationResult::Carry { constraints: constraints.iter().map(|f| name(*f)).collect(), force: 0.0 }
        }
        Operation::Mate { constraint, limit, .. } => OperationResult::Mate {
            constraint: name(*constraint),
            insertion_force: None,
            own: network.constraints[*constraint].limits.insertion_force,
            limit: *limit,
        },
        Operation::Clip { constraint } => {
            let own = &network.constraints[*constraint];
            let here = state.pose(&own.site).position;
            let seat = problem.conditions().given_position(network, *constraint);
            let reach = seat.map_or(0.0, |seat| (seat - here).norm());
            OperationResult::Clip { constraint: name(*constraint), place: place(*constraint), reach }
        }
    };
    operations.iter().map(result).collect()
}

/// Updates the results with the equilibrium at fraction `t` of the step; `reaction` is the force (N) of a constraint on
/// the harness, in the axes in which the operation gives its direction.
pub(crate) fn update(
    operations: &[Operation],
    results: &mut [OperationResult],
    t: f64,
    reaction: impl Fn(usize) -> Vector,
) {
    for (operation, result) in operations.iter().zip(results) {
        match operation {
            Operation::Carry { constraints } => {
                let OperationResult::Carry { force, .. } = result else { unreachable!("{MADE_FROM_IT}") };
                *force = constraints.iter().map(|f| reaction(*f).norm()).fold(*force, f64::max);
            }
            Operation::Mate { constraint, direction, push_from, .. } => {
                let OperationResult::Mate { insertion_force: largest, own, .. } = result else {
                    unreachable!("{MADE_FROM_IT}")
                };
                if t >= *push_from {
                    let needed = reaction(*constraint).dot(direction) + own.unwrap_or(0.0);
                    *largest = Some(largest.unwrap_or(0.0).max(needed));
                }
            }
            // Their results are known at the beginning of the step.
            Operation::Grasp { .. } | Operation::Clip { .. } => {}
        }
    }
}
