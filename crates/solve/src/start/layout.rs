//! Initial layout of the harness: its rest shape, or the curves along which it was drawn.

use nalgebra::Unit;
use wireloom_core::conditions::Conditions;
use wireloom_core::network::{AttachedConstraint, BranchEnd, Joint, Place};
use wireloom_core::problem::Problem;
use wireloom_core::rotation::{columns, shortest, twist_angle};
use wireloom_core::steps::Schedule;
use wireloom_core::terms::contact::Penetration;
use wireloom_core::{Matrix, Network, Pose, Rotation, State, Vector};

/// Length (m) below which a vector has no direction.
const NO_DIRECTION: f64 = 1e-9;
/// Weight of the rotation that selects an undetermined turn: small beside the weight 1 of each direction.
const SELECTION_WEIGHT: f64 = 1e-3;

/// Deepest penetration of an obstacle by a harness laid out along drawn paths or by `initial`, if it is not to be
/// resolved ([`wireloom_core::obstacle::ContactSettings::resolve`]). Penetrations of a layout found by the program are
/// always resolved.
pub fn inside(network: &Network, schedule: &Schedule) -> Option<Penetration> {
    let drawn = schedule.initial.is_some() || network.branches.iter().any(|branch| !branch.path.is_empty());
    if network.obstacles.is_empty() || network.contact.resolve || !drawn {
        return None;
    }
    let state = place(network, schedule);
    Problem::new(network, Conditions::new(network, schedule.gravity, &state)).deepest_penetration(&state)
}

/// Initial state: each piece along the drawn paths if all its branches have one, else in its rest shape, placed by
/// `initial` or by the piece's best constraint.
pub fn place(network: &Network, schedule: &Schedule) -> State {
    let mut state = State::origin(network);
    let (piece, pieces) = network.pieces();
    for p in 0..pieces {
        let branches: Vec<usize> = (0..network.branches.len()).filter(|&b| piece[b] == p).collect();
        match schedule.initial {
            Some(initial) if piece[initial.branch] == p => {
                lay_rest_shape(network, initial.branch, initial.pose, &mut state);
            }
            _ if branches.iter().all(|&b| network.branches[b].path.len() >= 2) => {
                lay_along_paths(network, &branches, &mut state);
            }
            _ => lay_at_constraint(network, &branches, &mut state),
        }
    }
    network.follow_ties(&mut state);
    state
}

/// Rest shape of a branch that starts at the origin.
struct RestShape {
    points: Vec<Vector>,
    frames: Vec<Rotation>,
    /// Pose of its end.
    end: Pose,
}

impl RestShape {
    /// Rest shape of a branch: where a constraint takes hold of it must not depend on the mesh, so its stations lie on
    /// the arc itself. At an end without a station the segment's frame differs from the end's frame by the rest
    /// curvature over half a segment.
    fn new(network: &Network, branch: usize) -> Self {
        let rod = &network.branches[branch].rod;
        let mesh = rod.mesh();
        let n = mesh.segments();
        let couplings = mesh.coupling_lengths.len();
        let half_beside = |coupling: usize, segment: usize| -> Rotation {
            if couplings == 0 {
                return Rotation::identity();
            }
            let fraction = 0.5 * mesh.rest_lengths[segment] / mesh.coupling_lengths[coupling];
            Rotation::from_scaled_axis(rod.rest_rotation(coupling).scaled_axis() * fraction)
        };
        let at_start = mesh.station_frame(0).is_none();
        let mut frames = vec![if at_start { half_beside(0, 0) } else { Rotation::identity() }];
        for c in 0..couplings {
            frames.push(frames[c] * rod.rest_rotation(c));
        }
        // κ° of a segment, by the couplings beside it.
        let curvature = |j: usize| {
            let frame = mesh.segment_frames[j];
            let beside = [frame.checked_sub(1), Some(frame).filter(|c| *c < couplings)].into_iter().flatten();
            let own = |c: usize| rod.rest_rotation(c).scaled_axis() / mesh.coupling_lengths[c];
            let count = beside.clone().count().max(1) as f64;
            beside.map(own).sum::<Vector>() / count
        };
        let mut points = vec![Vector::zeros()];
        for (j, l) in mesh.rest_lengths.iter().enumerate() {
            points.push(points[j] + frames[mesh.segment_frames[j]] * chord(&curvature(j), *l));
        }
        let end_point = points[n];
        // Nodes without a station stand for points beside the centre line (see `wireloom_core::rod`).
        for i in (1..n).filter(|i| mesh.station_frame(*i).is_none()) {
            let (l, kappa) = (0.5 * (mesh.rest_lengths[i - 1] + mesh.rest_lengths[i]), curvature(i));
            let frame =
                frames[mesh.segment_frames[i]] * Rotation::from_scaled_axis(kappa * (-0.5 * mesh.rest_lengths[i]));
            points[i] -= frame * kappa.cross(&Vector::z()) * (l * l / 24.0);
        }
        let mut orientation = frames[frames.len() - 1];
        if mesh.station_frame(n).is_none() {
            orientation *= half_beside(couplings.saturating_sub(1), n - 1);
        }
        let end = Pose { position: end_point, orientation };
        Self { points, frames, end }
    }
}

/// From the start to the end of an arc of length l (m) with this curvature κ (1/m), in the axes of the frame at its
/// middle: `∫ exp([κ]ₓ u) e3 du = l e3 + κ × (κ × e3) (l − (2/|κ|) sin(|κ| l/2))/|κ|²`.
fn chord(kappa: &Vector, l: f64) -> Vector {
    let angle = 0.5 * kappa.norm() * l;
    // (x − sin x)/x³, of a small x by its series.
    let factor = if angle < 0.1 { 1.0 / 6.0 - angle * angle / 120.0 } else { (angle - angle.sin()) / angle.powi(3) };
    Vector::z() * l + kappa.cross(&kappa.cross(&Vector::z())) * (factor * l.powi(3) / 4.0)
}

/// Lays a piece in its rest shape, joint by joint, with the start of `first` at `pose`.
fn lay_rest_shape(network: &Network, first: usize, pose: Pose, state: &mut State) {
    let mut laid = vec![false; network.branches.len()];
    let mut hubs: Vec<Option<Pose>> = vec![None; network.joints.len()];
    let mut open = vec![(first, pose)];
    while let Some((b, start)) = open.pop() {
        if std::mem::replace(&mut laid[b], true) {
            continue;
        }
        let branch = &network.branches[b];
        let RestShape { points, frames, end: last } = RestShape::new(network, b);
        for (i, x) in branch.points.clone().zip(&points) {
            state.points[i] = start.position + start.orientation * x;
        }
        for (c, q) in branch.frames.clone().zip(&frames) {
            state.frames[c] = start.orientation * q;
        }
        for (end, station) in [(branch.start, start), (branch.end, start.compose(&last))] {
            let BranchEnd::Joint { joint, arm } = end else { continue };
            let (index, joint) = (joint, &network.joints[joint]);
            if let Some(hub) = hubs[index] {
                // The branch closes a loop: distribute the gap over it.
                let gap = hub.compose(&arm_pose(joint, arm)).position - station.position;
                let at_start = joint.arms[arm].starts_here;
                let n = points.len() - 1;
                for (k, i) in branch.points.clone().enumerate() {
                    let t = if at_start { n - k } else { k } as f64 / n as f64;
                    state.points[i] += gap * t;
                }
                continue;
            }
            let hub = station.compose(&arm_pose(joint, arm).inverse());
            hubs[index] = Some(hub);
            state.points[joint.point] = hub.position;
            if let Some(frame) = joint.frame {
                state.frames[frame] = hub.orientation;
            }
            for (a, &other) in joint.branches.iter().enumerate().filter(|(_, other)| !laid[**other]) {
                let end = hub.compose(&arm_pose(joint, a));
                let start = if joint.arms[a].starts_here {
                    end
                } else {
                    end.compose(&RestShape::new(network, other).end.inverse())
                };
                open.push((other, start));
            }
        }
    }
}

/// Pose of an arm's end in the joint's frame.
fn arm_pose(joint: &Joint, arm: usize) -> Pose {
    let offset = if joint.frame.is_some() { joint.arms[arm].offset } else { Vector::zeros() };
    Pose { position: offset, orientation: joint.arms[arm].rest }
}

/// Lays a piece in its rest shape at the constraint with the most data on its pose.
fn lay_at_constraint(network: &Network, branches: &[usize], state: &mut State) {
    let on_piece = |constraint: &&AttachedConstraint| match constraint.place {
        Place::Node { branch, .. } => branches.contains(&branch),
        Place::Joint(j) => network.joints[j].branches.iter().any(|b| branches.contains(b)),
    };
    let constraints: Vec<&AttachedConstraint> =
        network.constraints.iter().filter(|f| f.from_start).filter(on_piece).collect();
    let rank = |constraint: &AttachedConstraint| {
        (
            constraint.position.is_some(),
            constraint.orientation.is_some(),
            constraint.tangent.is_some(),
            matches!(constraint.place, Place::Node { node: 0, .. }),
        )
    };
    // Reversed, as max_by_key takes the last of equals; the first one of the scenario is wanted.
    let Some(best) = constraints.iter().rev().max_by_key(|f| rank(f)) else {
        lay_rest_shape(network, branches[0], Pose::identity(), state);
        return;
    };
    let first = match best.place {
        Place::Node { branch, .. } => branch,
        Place::Joint(j) => network.joints[j].branches[0],
    };
    lay_rest_shape(network, first, Pose::identity(), state);
    network.follow_ties(state);
    // Present and wanted pose of the constraint's station; without a given direction the harness points from this
    // constraint to the mean of the others.
    let at = state.pose(&best.site);
    let position = best.position.unwrap_or_else(Vector::zeros);
    let others: Vec<Vector> = constraints.iter().filter(|f| f.name != best.name).filter_map(|f| f.position).collect();
    let orientation = match (best.orientation, best.tangent) {
        (Some(q), _) => q,
        (None, Some(t)) => shortest(&columns(&at.orientation)[2], &t) * at.orientation,
        (None, None) => {
            let mean = others.iter().sum::<Vector>() / others.len().max(1) as f64;
            let centre = |b: &usize| state.points[network.branches[*b].points.clone()].iter().sum::<Vector>();
            let nodes: usize = branches.iter().map(|b| network.branches[*b].points.len()).sum();
            let body = branches.iter().map(centre).sum::<Vector>() / nodes as f64 - at.position;
            let wanted = if others.is_empty() { Vector::x() } else { mean - position };
            if body.norm() > NO_DIRECTION && wanted.norm() > NO_DIRECTION {
                shortest(&body, &wanted) * at.orientation
            } else {
                at.orientation
            }
        }
    };
    let transform = Pose { position, orientation }.compose(&at.inverse());
    for &b in branches {
        let branch = &network.branches[b];
        for x in &mut state.points[branch.points.clone()] {
            *x = transform.position + transform.orientation * *x;
        }
        for q in &mut state.frames[branch.frames.clone()] {
            *q = transform.orientation * *q;
        }
        for end in [branch.start, branch.end] {
            if let BranchEnd::Joint { joint, arm: 0 } = end {
                let joint = &network.joints[joint];
                let pose = Pose { position: state.points[joint.point], orientation: Rotation::identity() };
                state.points[joint.point] = transform.compose(&pose).position;
                if let Some(frame) = joint.frame {
                    state.frames[frame] = transform.orientation * state.frames[frame];
                }
            }
        }
    }
}

/// Point at arc length fraction `t` of a polyline, and the direction there.
fn along(path: &[Vector], t: f64) -> (Vector, Vector) {
    let length: f64 = path.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
    let mut left = t * length;
    for w in path.windows(2) {
        let edge = (w[1] - w[0]).norm();
        if left <= edge && edge > 0.0 {
            return (w[0] + (w[1] - w[0]) * (left / edge), w[1] - w[0]);
        }
        left -= edge;
    }
    let n = path.len();
    (path[n - 1], path[n - 1] - path[n - 2])
}

/// Lays a piece along its drawn centre lines. Frames follow them without twist from the start of each branch, and are
/// then twisted uniformly to match the frame at its end, if that is known.
fn lay_along_paths(network: &Network, branches: &[usize], state: &mut State) {
    let mut hubs = vec![Rotation::identity(); network.joints.len()];
    for (j, joint) in network.joints.iter().enumerate() {
        if !branches.contains(&joint.branches[0]) {
            continue;
        }
        let tangent = |a: usize| -> Vector {
            let path = &network.branches[joint.branches[a]].path;
            along(path, if joint.arms[a].starts_here { 0.0 } else { 1.0 }).1
        };
        hubs[j] = best_turn((0..joint.arms.len()).map(|a| (columns(&joint.arms[a].rest)[2], tangent(a))));
        let (path, first) = (&network.branches[joint.branches[0]].path, joint.arms[0].starts_here);
        let end = if first { path[0] } else { path[path.len() - 1] };
        state.points[joint.point] = end - hubs[j] * arm_pose(joint, 0).position;
        if let Some(frame) = joint.frame {
            state.frames[frame] = hubs[j];
        }
    }
    for &b in branches {
        let branch = &network.branches[b];
        let mesh = branch.rod.mesh();
        let n = mesh.segments();
        let known = |end: BranchEnd, node: usize| -> Option<Rotation> {
            match end {
                BranchEnd::Joint { joint, arm } => Some(hubs[joint] * network.joints[joint].arms[arm].rest),
                BranchEnd::Free => network
                    .constraints
                    .iter()
                    .find(|f| f.from_start && f.place == Place::Node { branch: b, node })
                    .and_then(|f| f.orientation),
            }
        };
        let s = mesh.arc_lengths();
        let length = mesh.length();
        for (i, s) in branch.points.clone().zip(&s) {
            state.points[i] = along(&branch.path, s / length).0;
        }
        // Fractions of the branch's length at which its frames are.
        let places: Vec<f64> = mesh.frame_places(&s).into_iter().map(|place| place / length).collect();
        let mut q = known(branch.start, 0).unwrap_or_else(Rotation::identity);
        let mut frames: Vec<Rotation> = Vec::with_capacity(places.len());
        for &t in &places {
            q = shortest(&columns(&q)[2], &along(&branch.path, t).1) * q;
            frames.push(q);
        }
        if let Some(end) = known(branch.end, n) {
            let twist = twist_angle(&(q.inverse() * end));
            for (q, t) in frames.iter_mut().zip(&places) {
                *q *= Rotation::from_axis_angle(&Vector::z_axis(), twist * t);
            }
        }
        for (c, q) in branch.frames.clone().zip(frames) {
            state.frames[c] = q;
        }
    }
}

/// Rotation that best maps the first of each pair of directions to the second (Kabsch 1976).
fn best_turn(pairs: impl Iterator<Item = (Vector, Vector)>) -> Rotation {
    let (mut sum, mut some) = (Matrix::zeros(), None);
    for (from, to) in pairs {
        if let (Some(from), Some(to)) = (from.try_normalize(1e-12), to.try_normalize(1e-12)) {
            sum += to * from.transpose();
            some.get_or_insert((from, to));
        }
    }
    let Some((from, to)) = some else { return Rotation::identity() };
    // The turn about a straight harness is undetermined: a small multiple of one solution selects it.
    sum += *shortest(&from, &to).to_rotation_matrix().matrix() * SELECTION_WEIGHT;
    let svd = sum.svd(true, true);
    let (Some(u), Some(vt)) = (svd.u, svd.v_t) else { return Rotation::identity() };
    let sign = (u * vt).determinant().signum();
    let r = u * Matrix::from_diagonal(&Vector::new(1.0, 1.0, sign)) * vt;
    let q = Rotation::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(r));
    Unit::new_normalize(q.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A constraint that takes hold of a bent cable at rest once held it where a polygon ended, 0.5 mm beside the arc.
    #[test]
    fn a_rest_shape_follows_its_arc_not_a_polygon() {
        let kappa = Vector::new(0.4, 3.0, -1.1);
        for (l, within) in [(0.9, 1e-12), (0.01, 1e-16)] {
            // The integral of the tangent by Simpson's rule.
            let steps = 4000;
            let at = |k: usize| Rotation::from_scaled_axis(kappa * (l * (k as f64 / steps as f64 - 0.5))) * Vector::z();
            let weight = |k: usize| if k == 0 || k == steps { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
            let sum: Vector = (0..=steps).map(|k| at(k) * weight(k)).sum();
            let error = (chord(&kappa, l) - sum * (l / (3 * steps) as f64)).norm();
            assert!(error < within, "{error:e}");
        }
    }
}
