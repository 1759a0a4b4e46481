//! Transfer of a checkpoint to the same harness with other constraints or steps: a harness grasped between two
//! equilibria gets a station that it did not have before.

use crate::start::prolongation;
use crate::steps::checkpoint::Checkpoint;
use wireloom_core::conditions::Conditions;
use wireloom_core::conditions::ConstraintState;
use wireloom_core::conditions::RodState;
use wireloom_core::conditions::Sliding;
use wireloom_core::network::Branch;
use wireloom_core::{Network, Rotation, State};

/// Largest difference of equal nodes, as a fraction of their branch.
const SAME_NODE: f64 = 1e-9;

/// Checkpoint transferred to another harness.
#[derive(Clone, Debug, PartialEq)]
pub enum Transferred {
    /// The same equilibrium, to the bit.
    Same(Box<Checkpoint>),
    /// Near an equilibrium, which must be found first:
    /// [`balance`](crate::steps::interactive::InteractiveDriver::balance).
    Approximate(Box<Checkpoint>),
}

/// Transfers a checkpoint to another harness with the same branches and joints. Constraints are identified by their
/// names, and those of the same name by their order. `None` if the state depends on its history in a way that cannot be
/// transferred: an active constraint is missing; the mesh differs, and moves along the cables, may be in contact or has
/// rods that remember; or stations differ, and friction acts.
///
/// # Panics
/// If the checkpoint is not one of `from`.
pub fn transfer(checkpoint: &Checkpoint, from: &Network, to: &Network) -> Option<Transferred> {
    let obstacles = |network: &Network| network.obstacles.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    let loads = |network: &Network| network.loads.iter().map(|load| load.name.clone()).collect::<Vec<_>>();
    if obstacles(from) != obstacles(to)
        || loads(from) != loads(to)
        || from.mechanisms != to.mechanisms
        || !prolongation::same_graph(from, to)
    {
        return None;
    }
    let same_nodes = from.branches.iter().zip(&to.branches).all(|(a, b)| {
        let (old, new) = (a.rod.mesh().arc_lengths(), b.rod.mesh().arc_lengths());
        old.len() == new.len() && old.iter().zip(&new).all(|(a, b)| (a - b).abs() <= SAME_NODE * new[new.len() - 1])
    });
    let contact_possible = !from.obstacles.is_empty() || from.contact.cables;
    let state = match same_nodes {
        true => state_on_same_nodes(from, &checkpoint.state, to),
        false if contact_possible || remembers(from) || !prolongation::alike(from, to) => return None,
        false => prolongation::prolonged(from, &checkpoint.state, to),
    };
    let conditions = conditions(&checkpoint.conditions, from, to, &state)?;
    let stations =
        |network: &Network| network.branches.iter().map(|b| b.rod.mesh().stations.clone()).collect::<Vec<_>>();
    let same = same_nodes && stations(from) == stations(to);
    if !same && has_friction(from, &checkpoint.conditions) {
        return None;
    }
    let checkpoint = Box::new(Checkpoint { conditions, state, ..checkpoint.clone() });
    Some(if same { Transferred::Same(checkpoint) } else { Transferred::Approximate(checkpoint) })
}

/// Whether any rod remembers.
fn remembers(network: &Network) -> bool {
    network.branches.iter().any(|branch| !branch.rod.memory().is_empty())
}

/// States of the rods on a mesh with the same nodes, of which others may be stations: a new station divides a coupling
/// into two of the same curvature and memory; where one is gone, two become one with the mean memory of its length.
fn rod_states(own: &Conditions, from: &Network, to: &Network) -> Option<Vec<RodState>> {
    let branches = own.rods.iter().zip(from.branches.iter().zip(&to.branches));
    let state = |(own, (old, new)): (&RodState, (&Branch, &Branch))| {
        let (before, mesh) = (old.rod.mesh(), new.rod.mesh());
        let (count, new_count) = (before.coupling_lengths.len(), mesh.coupling_lengths.len());
        let width = own.memory.len() / count.max(1);
        if width * new_count != new.rod.memory().len() {
            return None;
        }
        let mut memory = Vec::with_capacity(width * new_count);
        for (c, &node) in mesh.coupling_nodes.iter().enumerate().filter(|_| width > 0) {
            let second = c > 0 && mesh.coupling_nodes[c - 1] == node;
            let alone = !second && mesh.coupling_nodes.get(c + 1) != Some(&node);
            let all = before.coupling_nodes.partition_point(|k| *k < node)
                ..before.coupling_nodes.partition_point(|k| *k <= node);
            let part = match all.len() {
                0 => return None,
                2 if alone => all,
                2 if second => all.end - 1..all.end,
                _ => all.start..all.start + 1,
            };
            let length: f64 = before.coupling_lengths[part.clone()].iter().sum();
            let share = |k: usize| if part.len() == 1 { 1.0 } else { before.coupling_lengths[k] / length };
            memory.extend((0..width).map(|i| part.clone().map(|k| share(k) * own.memory[k * width + i]).sum::<f64>()));
        }
        Some(RodState { memory, dissipated: own.dissipated })
    };
    branches.map(state).collect()
}

/// Whether friction acts anywhere: its forces depend on the history, and so on the stations.
fn has_friction(network: &Network, conditions: &Conditions) -> bool {
    let friction = conditions.contact.records.iter().any(|record| record.anchor.is_some());
    friction || network.slides.iter().any(|site| site.friction > 0.0 && conditions.active[site.constraint])
}

/// State on a mesh with the same nodes, of which others are stations.
fn state_on_same_nodes(from: &Network, state: &State, to: &Network) -> State {
    let mut transferred = State::origin(to);
    for (old, new) in from.branches.iter().zip(&to.branches) {
        transferred.points[new.points.clone()].copy_from_slice(&state.points[old.points.clone()]);
        transferred.compensation[new.points.clone()].copy_from_slice(&state.compensation[old.points.clone()]);
        let (mesh, before) = (new.rod.mesh(), old.rod.mesh());
        let frames = &state.frames[old.frames.clone()];
        let segment = |j: usize| frames[before.segment_frames[j]];
        for (j, &c) in mesh.segment_frames.iter().enumerate() {
            transferred.frames[new.frames.start + c] = segment(j);
        }
        for (&node, &c) in mesh.stations.iter().zip(&mesh.station_frames) {
            let last = mesh.segments();
            transferred.frames[new.frames.start + c] = match before.station_frame(node) {
                Some(own) => frames[own],
                None if node == 0 => segment(0),
                None if node == last => segment(last - 1),
                None => halfway(&segment(node - 1), &segment(node)),
            };
        }
        if old.mesh_moves {
            let lengths = &state.rest_lengths[old.points.start..old.points.end - 1];
            transferred.rest_lengths[new.points.start..new.points.end - 1].copy_from_slice(lengths);
            mesh.couple(lengths, &mut transferred.coupling_lengths[new.frames.start..new.frames.end - 1]);
        }
    }
    for (old, new) in from.joints.iter().zip(&to.joints) {
        transferred.points[new.point] = state.points[old.point];
        transferred.compensation[new.point] = state.compensation[old.point];
        if let (Some(old), Some(new)) = (old.frame, new.frame) {
            transferred.frames[new] = state.frames[old];
        }
    }
    to.follow_ties(&mut transferred);
    transferred
}

fn halfway(a: &Rotation, b: &Rotation) -> Rotation {
    a * (a.inverse() * b).powf(0.5)
}

/// Conditions of the other harness; constraints that only it has are inactive.
fn conditions(own: &Conditions, from: &Network, to: &Network, state: &State) -> Option<Conditions> {
    let of = counterparts(from, to);
    let stays = |f: usize| of.contains(&Some(f));
    if (0..from.constraints.len()).any(|f| own.active[f] && !stays(f)) {
        return None;
    }
    let mut new = Conditions { rotation: own.rotation, ..Conditions::new(to, own.gravity, state) };
    if remembers(from) || remembers(to) {
        new.rods = rod_states(own, from, to)?;
    }
    if !to.joints.iter().zip(&own.joints).all(|(joint, own)| own.fits(joint)) {
        return None;
    }
    new.joints.clone_from(&own.joints);
    new.load_factors.clone_from(&own.load_factors);
    new.temperatures.clone_from(&own.temperatures);
    (new.time, new.committed_time) = (own.time, own.committed_time);
    new.mechanisms.clone_from(&own.mechanisms);
    new.contact.clone_from(&own.contact);
    for (f, constraint) in to.constraints.iter().enumerate() {
        let Some(old) = of[f] else {
            new.active[f] = false;
            new.constraints[f] = ConstraintState::begin(constraint, state);
            continue;
        };
        let kept = &own.constraints[old];
        if kept.multipliers.len() != constraint.residuals.len() || kept.memory.len() != constraint.model.memory().len()
        {
            return None;
        }
        new.active[f] = own.active[old];
        new.targets[f] = own.targets[old];
        new.constraints[f] = kept.clone();
    }
    for (k, site) in to.slides.iter().enumerate() {
        let before = from.slides.iter().position(|slide| Some(slide.constraint) == of[site.constraint]);
        new.sliding[k] = before.map_or(Sliding::Stuck, |before| own.sliding[before]);
    }
    Some(new)
}

/// Index in `from` of every constraint of `to`: the one of the same name, and of several of one name the one of the
/// same number.
fn counterparts(from: &Network, to: &Network) -> Vec<Option<usize>> {
    let number = |network: &Network, f: usize| {
        let name = &network.constraints[f].name;
        network.constraints[..f].iter().filter(|other| other.name == *name).count()
    };
    let same = |f: usize| {
        let (name, which) = (&to.constraints[f].name, number(to, f));
        from.constraints.iter().enumerate().filter(|(_, other)| other.name == *name).map(|(old, _)| old).nth(which)
    };
    (0..to.constraints.len()).map(same).collect()
}
