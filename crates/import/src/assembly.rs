//! The plan of installation, from the board into the vehicle, as steps that a user may edit.

use super::harness::{Harness, Place};
use super::options::Order;
use super::tree::Tree;
use std::collections::HashSet;

/// Largest length of cable, m, between any place and the nearest hand while the harness is moved.
const REACH: f64 = 0.75;

/// Increments of the motion into the vehicle, and of the motion of one connector or clip to its seat.
const CARRY_INCREMENTS: usize = 8;
const INSTALL_INCREMENTS: usize = 2;

/// The steps of an assembly.
pub(super) struct Assembly {
    /// Joints that hands hold while the harness is moved, by vertex.
    pub hands: Vec<usize>,
    /// Constraints in the order of installation, each with the hands that are released with it.
    pub installs: Vec<Install>,
    /// Hands that are released at the end.
    pub last: Vec<usize>,
}

pub(super) struct Install {
    /// Index of the constraint.
    pub constraint: usize,
    /// Hands that are released, by vertex.
    pub released: Vec<usize>,
}

impl Assembly {
    pub const CARRY_INCREMENTS: usize = CARRY_INCREMENTS;
    pub const INSTALL_INCREMENTS: usize = INSTALL_INCREMENTS;
}

/// Plans the assembly: the hands move the harness to the vehicle; then one constraint after the other is moved to its
/// seat; a hand is released when everything beyond it is installed.
///
/// Every motion is straight, so a cable that is not overstretched at the beginning and the end is never
/// overstretched: the vector between two points that move (or stand) at the same time is
/// `d(t) = (1 − t) d₀ + t d₁`, hence `|d(t)| ≤ (1 − t) |d₀| + t |d₁|`.
pub(super) fn plan(harness: &Harness, tree: &Tree, order: Order) -> Assembly {
    let hands = hands(harness, tree);
    let held: HashSet<usize> = hands.iter().copied().collect();
    let is_root = |at: Place| matches!(at, Place::End(vertex) if tree.roots.contains(&vertex));
    let mut queue: Vec<usize> =
        (0..harness.constraints.len()).filter(|&index| !is_root(harness.constraints[index].at)).collect();
    match order {
        Order::Outward => {
            let distance = |index: &usize| tree.distance_to(harness, harness.constraints[*index].at);
            queue.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        }
        Order::Random(seed) => shuffle(&mut queue, seed),
    }
    let mut installs: Vec<Install> = Vec::new();
    // Vertices beyond which a later constraint lies: the hands from there on towards the root have their release.
    let mut before: HashSet<usize> = HashSet::new();
    for &constraint in queue.iter().rev() {
        let mut released = Vec::new();
        let mut at = Some(tree.outer_vertex(harness, harness.constraints[constraint].at));
        while let Some(vertex) = at.filter(|vertex| before.insert(*vertex)) {
            if held.contains(&vertex) {
                released.push(vertex);
            }
            at = tree.parent[vertex].map(|(_, before)| before);
        }
        released.sort_unstable();
        installs.push(Install { constraint, released });
    }
    installs.reverse();
    let last = hands.iter().copied().filter(|hand| !before.contains(hand)).collect();
    Assembly { hands, installs, last }
}

/// The fewest joints such that nothing is further than `REACH` from a hand or a root along the cable, as far as there
/// are joints: from the ends inward, a joint is held if its outer part would be further than that from the next joint
/// inward.
fn hands(harness: &Harness, tree: &Tree) -> Vec<usize> {
    let mut hangs = vec![0.0_f64; harness.vertices.len()];
    let mut hands = Vec::new();
    let joints: HashSet<usize> = harness.joints.iter().map(|joint| joint.vertex).collect();
    let is_joint = |vertex: usize| joints.contains(&vertex);
    for &vertex in tree.order.iter().rev() {
        let Some((branch, before)) = tree.parent[vertex] else { continue };
        let further = hangs[vertex] + harness.branches[branch].length;
        if further > REACH && is_joint(vertex) {
            hands.push(vertex);
            // The branch itself is between two hands.
            continue;
        }
        hangs[before] = hangs[before].max(further);
    }
    hands.reverse();
    hands
}

/// Fisher and Yates' shuffle with the generator SplitMix64 (Steele, Lea, Flood 2014).
fn shuffle(list: &mut [usize], seed: u64) {
    let mut state = seed;
    let mut below = |n: usize| {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    };
    for i in (1..list.len()).rev() {
        list.swap(i, below(i + 1));
    }
}
