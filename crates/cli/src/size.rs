//! Size of a harness: nodes, memory, time.

use crate::failure::Failure;
use crate::print::text::counted;
use sysinfo::{MemoryRefreshKind, RefreshKind, System};
use wireloom::harness::Network;
use wireloom::scenario::Built;

/// Memory (bytes, at most) and time of an equilibrium (s) for each node, measured with cables of 10⁵ and 10⁶
/// segments.
const BYTES: u64 = 5_200;
const SECONDS: f64 = 2e-5;
/// Number of nodes from which the size is announced before the work begins.
const LARGE: usize = 100_000;

/// Memory and time of a large harness, in words; `None` for a small one.
///
/// # Errors
/// Where it does not fit into the memory that is left on this machine.
pub fn estimate(network: &Network, increments: usize) -> Result<Option<String>, Failure> {
    let nodes = nodes(network);
    if nodes < LARGE {
        return Ok(None);
    }
    let ram = RefreshKind::nothing().with_memory(MemoryRefreshKind::nothing().with_ram());
    // Where the system does not tell, the work begins.
    let left = System::new_with_specifics(ram).ok().and_then(|system| {
        let within = system.cgroup_limits().map_or(u64::MAX, |limits| limits.free_memory);
        Some(system.available_memory().min(within)).filter(|left| *left > 0)
    });
    estimated(nodes, increments, left).map(Some)
}

/// The same with this number of free bytes.
fn estimated(nodes: usize, increments: usize, left: Option<u64>) -> Result<String, Failure> {
    let needed = nodes as u64 * BYTES;
    let memory = format!("{nodes} nodes need about {:.1} GB of memory", needed as f64 / 1e9);
    match left {
        Some(left) if left < needed => Err(Failure::Input(format!(
            "{memory}, and {:.1} GB are free: fewer `segments`, or a larger `max_segment`, make it fit",
            left as f64 / 1e9
        ))),
        _ => {
            let each = (nodes as f64 * SECONDS).ceil();
            let increments = counted(increments, "increment", "increments");
            Ok(format!("{memory}; {increments} of {each:.0} s or more each"))
        }
    }
}

/// Number of increments of a run.
pub fn increments(built: &Built) -> usize {
    built.schedule.steps.iter().map(|step| step.increments).sum::<usize>().max(1)
}

fn nodes(network: &Network) -> usize {
    network.branches.iter().map(|branch| branch.rod.mesh().segments() + 1).sum()
}

/// `3 branches, 1 joint, 4 constraints, 143 nodes`.
pub fn words(network: &Network) -> String {
    let nodes = nodes(network);
    let parts = [
        counted(network.branches.len(), "branch", "branches"),
        counted(network.joints.len(), "joint", "joints"),
        counted(network.constraints.len(), "constraint", "constraints"),
        counted(nodes, "node", "nodes"),
    ];
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_refused_before_it_is_tried() {
        let refused = estimated(1_000_000, 3, Some(2 << 30)).expect_err("it does not fit").to_string();
        assert!(refused.contains("1000000 nodes need about 5.2 GB of memory, and 2.1 GB are free"), "{refused}");
        for left in [Some(6 << 30), None] {
            let told = estimated(1_000_000, 3, left).expect("it fits");
            assert_eq!(told, "1000000 nodes need about 5.2 GB of memory; 3 increments of 20 s or more each");
        }
    }
}
