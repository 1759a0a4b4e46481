//! What the operations of a step come to: where hands and clips took hold, which forces they needed.

use wireloom_core::equilibrium::OperationResult;
use wireloom_core::network::Place;
use wireloom_core::problem::Problem;
use wireloom_core::steps::Operation;
use wireloom_core::{Network, State, Vector};

/// The operations of a step as it begins.
pub(crate) fn begin(operations: &[Operation], problem: &Problem<'_>, state: &State) -> Vec<OperationResult> {
    let network = problem.network;
    let name = |fixing: usize| network.fixings[fixing].name.clone();
    let place = |fixing: usize| match network.fixings[fixing].place {
        Place::Node { branch, node } => {
            Some((network.branches[branch].name.clone(), state.arc_lengths(network, branch)[node]))
        }
        Place::Joint(_) => None,
    };
    let result = |operation: &Operation| match operation {
        Operation::Grasp { fixing } => OperationResult::Grasp { constraint: name(*fixing), place: place(*fixing) },
        Operation::Carry { fixings } => {
            OperationResult::Carry { constraints: fixings.iter().map(|f| name(*f)).collect(), force: 0.0 }
        }
        Operation::Mate { fixing, limit, .. } => {
            OperationResult::Mate { constraint: name(*fixing), insertion_force: None, limit: *limit }
        }
        Operation::Clip { fixing } => {
            let own = &network.fixings[*fixing];
            let here = state.pose(&own.site).position;
            let reach = own.position.map_or(0.0, |seat| (seat - here).norm());
            OperationResult::Clip { constraint: name(*fixing), place: place(*fixing), reach }
        }
    };
    operations.iter().map(result).collect()
}

/// Looks at the equilibrium at share `t` of the step; `reaction` is the force (N) that a fixing exerts on the harness.
pub(crate) fn watch(
    operations: &[Operation],
    results: &mut [OperationResult],
    network: &Network,
    t: f64,
    reaction: impl Fn(usize) -> Vector,
) {
    for (operation, result) in operations.iter().zip(results) {
        match (operation, result) {
            (Operation::Carry { fixings }, OperationResult::Carry { force, .. }) => {
                *force = fixings.iter().map(|f| reaction(*f).norm()).fold(*force, f64::max);
            }
            (
                Operation::Mate { fixing, direction, push_from, .. },
                OperationResult::Mate { insertion_force: largest, .. },
            ) if t >= *push_from => {
                let own = network.fixings[*fixing].limits.insertion_force.unwrap_or(0.0);
                let needed = reaction(*fixing).dot(direction) + own;
                *largest = Some(largest.unwrap_or(0.0).max(needed));
            }
            _ => {}
        }
    }
}
