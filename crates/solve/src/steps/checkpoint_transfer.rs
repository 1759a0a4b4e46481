//! A checkpoint of a harness for the same harness with other constraints, or with its steps changed: where one takes hold of it between two
//! equilibria, it gets a station that it did not have before.

use crate::start::prolongation;
use crate::steps::checkpoint::Checkpoint;
use wireloom_core::conditions::Conditions;
use wireloom_core::conditions::ConstraintState;
use wireloom_core::conditions::Sliding;
use wireloom_core::{Network, Rotation, State};

/// Nodes are the same where they differ by less than this fraction of their branch.
const SAME_NODE: f64 = 1e-9;

/// How a checkpoint of one harness is one of another.
#[derive(Clone, Debug, PartialEq)]
pub enum Changed {
    /// It is balanced there too, to the bit.
    Same(Box<Checkpoint>),
    /// It has to be brought into balance first: [`crate::steps::interactive::Hands::balance`].
    Nearly(Box<Checkpoint>),
}

/// The checkpoint for another harness, which has the same branches and joints. Constraints are told by their names, and those of one name by their
/// order. `None` where that harness would have to know how it came there: where a constraint that acts is gone, or the mesh is another one and
/// moves along the cables, or the harness touches something; where friction holds it and stations are others.
///
/// # Panics
/// If the checkpoint is not one of `from`.
pub fn changed(checkpoint: &Checkpoint, from: &Network, to: &Network) -> Option<Changed> {
    let obstacles = |network: &Network| network.obstacles.iter().map(|o| o.name.clone()).collect::<Vec<_>>();
    let loads = |network: &Network| network.loads.iter().map(|load| load.name.clone()).collect::<Vec<_>>();
    if obstacles(from) != obstacles(to) || loads(from) != loads(to) || !prolongation::same_graph(from, to) {
        return None;
    }
    let same_nodes = from.branches.iter().zip(&to.branches).all(|(a, b)| {
        let (old, new) = (a.rod.mesh().arc_lengths(), b.rod.mesh().arc_lengths());
        old.len() == new.len() && old.iter().zip(&new).all(|(a, b)| (a - b).abs() <= SAME_NODE * new[new.len() - 1])
    });
    let touches = !from.obstacles.is_empty() || from.contact.cables;
    let state = match same_nodes {
        true => on_the_same_nodes(from, &checkpoint.state, to),
        false if touches || !prolongation::alike(from, to) => return None,
        false => prolongation::prolonged(from, &checkpoint.state, to),
    };
    let conditions = conditions(&checkpoint.conditions, from, to, &state)?;
    let stations =
        |network: &Network| network.branches.iter().map(|b| b.rod.mesh().stations.clone()).collect::<Vec<_>>();
    let same = same_nodes && stations(from) == stations(to);
    if !same && is_bound(from, &checkpoint.conditions) {
        return None;
    }
    let checkpoint = Box::new(Checkpoint { conditions, state, ..checkpoint.clone() });
    Some(if same { Changed::Same(checkpoint) } else { Changed::Nearly(checkpoint) })
}

/// Whether friction holds it anywhere: a harness with other stations would have come to hold otherwise.
fn is_bound(network: &Network, conditions: &Conditions) -> bool {
    let friction = conditions.contact.records.iter().any(|record| record.anchor.is_some());
    friction || network.slides.iter().any(|site| site.friction > 0.0 && conditions.active[site.constraint])
}

/// The state on a mesh with the same nodes, some of which are stations there that were none, or the other way round.
fn on_the_same_nodes(from: &Network, state: &State, to: &Network) -> State {
    let mut carried = State::origin(to);
    for (old, new) in from.branches.iter().zip(&to.branches) {
        carried.points[new.points.clone()].copy_from_slice(&state.points[old.points.clone()]);
        carried.compensation[new.points.clone()].copy_from_slice(&state.compensation[old.points.clone()]);
        let (mesh, before) = (new.rod.mesh(), old.rod.mesh());
        let frames = &state.frames[old.frames.clone()];
        let segment = |j: usize| frames[before.segment_frames[j]];
        for (j, &c) in mesh.segment_frames.iter().enumerate() {
            carried.frames[new.frames.start + c] = segment(j);
        }
        for (&node, &c) in mesh.stations.iter().zip(&mesh.station_frames) {
            let last = mesh.segments();
            carried.frames[new.frames.start + c] = match before.station_frame(node) {
                Some(own) => frames[own],
                None if node == 0 => segment(0),
                None if node == last => segment(last - 1),
                None => half_way(&segment(node - 1), &segment(node)),
            };
        }
        if old.mesh_moves {
            let lengths = &state.rest_lengths[old.points.start..old.points.end - 1];
            carried.rest_lengths[new.points.start..new.points.end - 1].copy_from_slice(lengths);
            mesh.couple(lengths, &mut carried.coupling_lengths[new.frames.start..new.frames.end - 1]);
        }
    }
    for (old, new) in from.joints.iter().zip(&to.joints) {
        carried.points[new.point] = state.points[old.point];
        carried.compensation[new.point] = state.compensation[old.point];
        if let (Some(old), Some(new)) = (old.frame, new.frame) {
            carried.frames[new] = state.frames[old];
        }
    }
    to.follow_ties(&mut carried);
    carried
}

fn half_way(a: &Rotation, b: &Rotation) -> Rotation {
    a * (a.inverse() * b).powf(0.5)
}

/// What acts on the other harness; constraints that it alone has do not.
fn conditions(own: &Conditions, from: &Network, to: &Network, state: &State) -> Option<Conditions> {
    let of = counterparts(from, to);
    let stays = |f: usize| of.contains(&Some(f));
    if (0..from.constraints.len()).any(|f| own.active[f] && !stays(f)) {
        return None;
    }
    let mut new = Conditions { gravity: own.gravity, ..Conditions::new(to, own.gravity, state) };
    new.load_factors.clone_from(&own.load_factors);
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

/// For each constraint of `to` which of `from` it is: the one of the same name, and of those of one name the one of the same number.
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
