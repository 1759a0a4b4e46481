//! How large a harness is, in words.

use wireloom::core::Network;

/// `3 branches, 1 joint, 4 fixings, 143 nodes`.
pub fn words(network: &Network) -> String {
    let nodes: usize = network.branches.iter().map(|branch| branch.rod.mesh().segments() + 1).sum();
    let parts = [
        counted(network.branches.len(), "branch", "branches"),
        counted(network.joints.len(), "joint", "joints"),
        counted(network.fixings.len(), "fixing", "fixings"),
        counted(nodes, "node", "nodes"),
    ];
    parts.join(", ")
}

/// A number and its noun.
pub fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
