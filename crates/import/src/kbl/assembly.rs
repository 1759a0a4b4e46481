//! The way from the board into the vehicle, as steps that a user edits.

use super::harness::{Harness, Place};
use super::options::Order;
use super::tree::Tree;
use std::collections::HashSet;

/// How far, m of cable, anything may hang from the nearest hand while the harness is carried.
const REACH: f64 = 0.75;

/// Increments of the way into the vehicle, and of the way of one connector or clip from where it hangs to its place.
const CARRY_INCREMENTS: usize = 8;
const INSTALL_INCREMENTS: usize = 2;

/// The steps of an assembly.
pub(super) struct Assembly {
    /// Joints that hands hold while the harness is carried, by vertex.
    pub hands: Vec<usize>,
    /// Fixings in the order in which they are installed, by index, each with the hands that let go with it.
    pub installs: Vec<Install>,
    /// Hands that let go at the end.
    pub last: Vec<usize>,
}

pub(super) struct Install {
    /// Index of the constraint.
    pub constraint: usize,
    /// Vertices.
    pub let_go: Vec<usize>,
}

impl Assembly {
    pub const CARRY_INCREMENTS: usize = CARRY_INCREMENTS;
    pub const INSTALL_INCREMENTS: usize = INSTALL_INCREMENTS;
}

/// Plans the assembly: the hands carry the harness to the vehicle; then one fixing after the other is brought home from where it hangs; a
/// hand lets go when all that lies beyond it is home.
///
/// Every motion is straight. Then nothing is overstretched on the way that is not at its end: with d(t) = (1 − t) d₀ + t d₁ the vector
/// between two points that move (or stand) at the same time, |d(t)| ≤ (1 − t) |d₀| + t |d₁|, and both ends are within the cable's length.
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
    // Vertices beyond which a fixing lies that is installed later: from there on towards the root all hands are spoken for.
    let mut before: HashSet<usize> = HashSet::new();
    for &constraint in queue.iter().rev() {
        let mut let_go = Vec::new();
        let mut at = Some(tree.outer_vertex(harness, harness.constraints[constraint].at));
        while let Some(vertex) = at.filter(|vertex| before.insert(*vertex)) {
            if held.contains(&vertex) {
                let_go.push(vertex);
            }
            at = tree.parent[vertex].map(|(_, before)| before);
        }
        let_go.sort_unstable();
        installs.push(Install { constraint, let_go });
    }
    installs.reverse();
    let last = hands.iter().copied().filter(|hand| !before.contains(hand)).collect();
    Assembly { hands, installs, last }
}

/// As few joints as can be such that nothing is further than `REACH` from a hand or a root along the cable, as far as joints are that
/// dense: from the ends inward, a joint is held where its own outer part would come to hang lower from the next joint inward.
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
            // The branch itself hangs between two hands.
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
