//! Results at a state: joints, obstacles, mechanisms, reactions of constraints; of branches see [`super::branch`].

use std::f64::consts::TAU;
use wireloom_core::equilibrium::{
    ArmFriction, BranchResult, ConstraintResult, JointResult, MarkerResult, MechanismResult, ObstacleResult,
    SpanResult, StationResult, TightestBend,
};
use wireloom_core::mechanism::Mechanism;
use wireloom_core::network::{AttachedConstraint, Branch, Joint, Place, Site, Span};
use wireloom_core::obstacle::Obstacle;
use wireloom_core::problem::Problem;
use wireloom_core::requirement::Marker;
use wireloom_core::rotation::{columns, twist_angle};
use wireloom_core::terms::constraints::Reaction;
use wireloom_core::terms::contact::ObstacleLoad;
use wireloom_core::variable::Variable;
use wireloom_core::{Mounting, Network, Pose, Rotation, State, Tangent, Vector};

/// Turns of the frames of a branch about its centre line, each from the one before.
pub(crate) fn twist_turns(frames: &[Rotation]) -> f64 {
    let angles = frames.windows(2).map(|pair| twist_angle(&(pair[0].inverse() * pair[1])));
    angles.sum::<f64>() / TAU
}

/// Result of the joint of this index; `touching` marks the points in contact ([`Problem::touching_points`]).
pub fn joint(problem: &Problem<'_>, index: usize, state: &State, touching: &[bool]) -> JointResult {
    let (joint, own) = (&problem.network.joints[index], &problem.conditions().joints[index]);
    let position = state.points[joint.point] + state.compensation[joint.point];
    let shift = || if touching[joint.point] { Vector::zeros() } else { joint_shift(problem, joint, state) };
    let (position, orientation) = match joint.frame {
        Some(frame) => (position, state.frames[frame]),
        None => (position + shift(), mean_rotation(others(joint, usize::MAX, state))),
    };
    let of_arm = |(a, &[dissipated, dissipated_in_all]): (usize, &[f64; 2])| {
        let (branch, starts_here) = (joint.arms[a].branch.clone(), joint.arms[a].starts_here);
        let set = joint.model.set(a, &own.memory)?;
        Some(ArmFriction { branch, starts_here, set, dissipated, dissipated_in_all })
    };
    let friction = own.dissipated.iter().enumerate().filter_map(of_arm).collect();
    JointResult { name: joint.name.clone(), position, orientation, friction }
}

/// Frame of a joint as defined by each of its arms except one.
pub(super) fn others<'a>(joint: &'a Joint, arm: usize, state: &'a State) -> impl Iterator<Item = Rotation> + 'a {
    let arms = joint.arm_frames.iter().zip(&joint.arms).enumerate().filter(move |(a, _)| *a != arm);
    arms.map(|(_, (&c, arm))| state.frames[c] * arm.rest.inverse())
}

/// Mean length of the segments at a joint, m.
pub(super) fn mean_length(joint: &Joint) -> f64 {
    joint.arms.iter().map(|arm| arm.segment_length).sum::<f64>() / joint.arms.len() as f64
}

/// Whether a rod runs through a joint: its two arms meet in a point without stations.
pub(super) fn runs_through(joint: &Joint) -> bool {
    joint.arms.len() == 2 && joint.model.mounting() == Mounting::Point
}

/// ℓ of the offset `ℓ² x″/24` of the centre line from the node of a joint, m. Zero where no rod runs through, and for a
/// held joint.
pub(super) fn shift_length(problem: &Problem<'_>, joint: &Joint) -> f64 {
    let held = problem.held().iter().any(|h| h.variable == Variable::Point(joint.point));
    if held || !runs_through(joint) { 0.0 } else { mean_length(joint) }
}

/// Offset `ℓ² x″/24` of the centre line from a two-arm joint, as at a node between segments, with x″ from the
/// outward tangents of the arms less those at rest.
pub(super) fn joint_shift(problem: &Problem<'_>, joint: &Joint, state: &State) -> Vector {
    let length = shift_length(problem, joint);
    if length == 0.0 {
        return Vector::zeros();
    }
    let mean = mean_rotation(others(joint, usize::MAX, state));
    let [into, out] = [0, 1].map(|arm| {
        let (arm, shape) = (&joint.arms[arm], state.branch(problem.network, joint.branches[arm]));
        // Both tangents point away from the joint.
        let (segment, sign) = if arm.starts_here { (0, 1.0) } else { (shape.rest_lengths.len() - 1, -1.0) };
        let tangent = shape.edge(segment) / shape.rest_lengths[segment];
        (tangent - columns(&(mean * arm.rest))[2]) * sign
    });
    (into + out) * (length / 24.0)
}

/// Normalised sum of quaternions with signs aligned to the first: the mean of nearby rotations.
pub(super) fn mean_rotation(mut rotations: impl Iterator<Item = Rotation>) -> Rotation {
    let Some(first) = rotations.next() else { return Rotation::identity() };
    let sum = rotations
        .fold(first.into_inner(), |sum, q| sum + if q.dot(&first) < 0.0 { -q.into_inner() } else { q.into_inner() });
    if sum.norm() > 1e-6 { Rotation::new_normalize(sum) } else { first }
}

/// Results of all obstacles: pose and load on the harness at `state`.
pub fn obstacles(problem: &mut Problem<'_>, state: &State) -> Vec<ObstacleResult> {
    let touching = problem.obstacle_loads(state);
    let network = problem.network;
    let poses = &problem.conditions().contact.poses;
    let result = |((obstacle, pose), touching): ((&Obstacle, &Pose), ObstacleLoad)| ObstacleResult {
        name: obstacle.name.clone(),
        pose: *pose,
        force: touching.force,
        moment: touching.moment,
        contact_force: touching.sizes,
        contacts: touching.points,
        depth: touching.depth,
    };
    network.obstacles.iter().zip(poses).zip(touching).map(result).collect()
}

/// Values of the joints of all mechanisms.
pub fn mechanisms(problem: &Problem<'_>) -> Vec<MechanismResult> {
    let result = |(mechanism, values): (&Mechanism, &Vec<f64>)| {
        let joint = |k: usize| (mechanism.joints[k].name.clone(), values[mechanism.freedoms_of(k)].to_vec());
        MechanismResult { name: mechanism.name.clone(), joints: (0..mechanism.joints.len()).map(joint).collect() }
    };
    problem.network.mechanisms.iter().zip(&problem.conditions().mechanisms).map(result).collect()
}

/// Tensions beside the stations of a constraint, N ([`wireloom_core::constraint::ConstraintView::tensions`]).
pub fn tensions(constraint: &AttachedConstraint, branches: &[BranchResult]) -> Vec<[f64; 2]> {
    let beside = |place: &Place| match *place {
        Place::Node { branch, node } => branches[branch].tensions_beside(node),
        Place::Joint(_) => [0.0; 2],
    };
    constraint.places.iter().map(beside).collect()
}

/// Results of all active constraints: pose and reactions on the harness; `branches` are the results of all branches.
pub fn constraints(
    problem: &Problem<'_>,
    state: &State,
    gradient: &Tangent,
    branches: &[BranchResult],
) -> Vec<ConstraintResult> {
    let active = problem.network.constraints.iter().enumerate().filter(|(f, _)| problem.conditions().active[*f]);
    active
        .map(|(f, constraint)| {
            let reactions = problem.reactions(f, state, gradient);
            let of_span = || (reactions.span.iter().sum(), Vector::zeros());
            let (force, moment) = reactions.stations.first().copied().unwrap_or_else(of_span);
            let mut pose = state.pose(&constraint.site);
            if let (None, Place::Node { branch, node }) = (constraint.site.frame, constraint.place) {
                pose.orientation = frame_at(&problem.network.branches[branch], state, node);
            }
            ConstraintResult {
                name: constraint.name.clone(),
                kind: constraint.kind.clone(),
                position: pose.position,
                orientation: pose.orientation,
                force,
                moment,
                stations: stations(constraint, &reactions, state),
                span: constraint.span.as_ref().map(|span| along(problem, span, &reactions.span, state)),
                slide: problem
                    .network
                    .slides
                    .iter()
                    .position(|site| site.constraint == f)
                    .map(|slide| problem.slide_result(slide, state, gradient)),
                outputs: problem.outputs(f, state, tensions(constraint, branches)),
            }
        })
        .collect()
}

/// Reactions of a constraint at each of its stations, if it has several.
fn stations(constraint: &AttachedConstraint, reactions: &Reaction, state: &State) -> Vec<StationResult> {
    if constraint.stations.len() < 2 {
        return Vec::new();
    }
    let result = |(site, &(force, moment)): (&Site, &(Vector, Vector))| StationResult {
        position: state.pose(site).position,
        force,
        moment,
    };
    constraint.stations.iter().zip(&reactions.stations).map(result).collect()
}

/// Reactions of a constraint along its span.
fn along(problem: &Problem<'_>, span: &Span, forces: &[Vector], state: &State) -> SpanResult {
    let branch = &problem.network.branches[span.branch];
    let s = state.arc_lengths(problem.network, span.branch);
    let s = &s[span.points.start - branch.points.start..span.points.end - branch.points.start];
    let largest = s.iter().zip(forces).max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
    let (largest_at, largest) = largest.map_or((s[0], Vector::zeros()), |(s, force)| (*s, *force));
    SpanResult {
        branch: branch.name.clone(),
        range: (s[0], s[s.len() - 1]),
        force: forces.iter().sum(),
        largest,
        largest_at,
    }
}

/// Frame of the segment at a node.
fn frame_at(branch: &Branch, state: &State, node: usize) -> Rotation {
    let mesh = branch.rod.mesh();
    let c = mesh.station_frame(node).unwrap_or_else(|| mesh.segment_frames[node.min(mesh.segments() - 1)]);
    state.frames[branch.frames.start + c]
}

/// Position on the centre line at an unstressed arc length, m: between nodes the cubic through both of them along their
/// tangents.
pub(crate) fn position_at(branch: &BranchResult, at: f64) -> Vector {
    let (s, x) = (&branch.s, &branch.position);
    let i = s.partition_point(|node| *node <= at).clamp(1, s.len() - 1) - 1;
    let t = ((at - s[i]) / (s[i + 1] - s[i])).clamp(0.0, 1.0);
    // dx/ds: along d3, as long as the segment is stretched.
    let stretched = (x[i + 1] - x[i]).norm();
    let [from, to] = [i, i + 1].map(|node| columns(&branch.frame[node])[2] * stretched);
    let (u, t2) = (1.0 - t, t * t);
    x[i] * (u * u * (1.0 + 2.0 * t)) + x[i + 1] * (t2 * (3.0 - 2.0 * t)) + from * (t * u * u) - to * (t2 * u)
}

/// Positions of the markers.
pub fn markers(network: &Network, branches: &[BranchResult]) -> Vec<MarkerResult> {
    let result = |marker: &Marker| MarkerResult {
        name: marker.name.clone(),
        position: position_at(&branches[marker.branch], marker.s),
    };
    network.markers.iter().map(result).collect()
}

/// Bend nearest to its limit, or farthest beyond it; without limits, the bend of least radius.
pub fn tightest_bend(branches: &[BranchResult]) -> Option<TightestBend> {
    let all = branches.iter().flat_map(|b| b.bends().map(move |bend| (b, bend)));
    all.filter(|(_, bend)| bend.radius.is_finite())
        .min_by(|(_, a), (_, b)| a.compare(b))
        .map(|(b, bend)| TightestBend { branch: b.name.clone(), s: bend.s, value: bend.radius, limit: bend.limit })
}

/// Largest move of any point of the branches, and the length of the branch that moves so far, m.
pub fn farthest_branch(network: &Network, from: &State, to: &State) -> (f64, f64) {
    let moves = network.branches.iter().map(|branch| {
        let points = branch.points.clone();
        let moved = points.map(|k| (to.points[k] - from.points[k]).norm()).fold(0.0, f64::max);
        (moved, branch.rod.mesh().length())
    });
    moves.fold((0.0, 0.0), |most, own| if own.0 > most.0 { own } else { most })
}

/// Largest move of any point, m.
pub fn farthest(from: &State, to: &State) -> f64 {
    from.points.iter().zip(&to.points).map(|(a, b)| (b - a).norm()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent(name: &str, limit: Option<f64>, radii: [f64; 2]) -> BranchResult {
        BranchResult {
            name: name.into(),
            diameter: 0.01,
            bend_radius_limit: limit,
            axial_stiffness: 1.0,
            sections: Vec::new(),
            strain: None,
            s: vec![0.0, 1.0],
            position: vec![Vector::zeros(), Vector::z()],
            frame: vec![Rotation::identity(); 2],
            force: vec![Vector::zeros(); 2],
            moment: vec![Vector::zeros(); 2],
            bend_radius: radii.to_vec(),
            sides: Vec::new(),
            twist_turns: 0.0,
            error: None,
            deviation: None,
            friction: None,
        }
    }

    #[test]
    fn the_tightest_bend_is_the_one_nearest_to_its_limit() {
        let branches = [
            bent("free", None, [0.01, 0.02]),
            bent("thick", Some(0.1), [f64::INFINITY, 0.09]),
            bent("thin", Some(0.01), [0.02, 0.03]),
        ];
        let worst = tightest_bend(&branches).expect("bends");
        assert_eq!((worst.branch.as_str(), worst.s, worst.value, worst.limit), ("thick", 1.0, 0.09, Some(0.1)));
        assert_eq!(tightest_bend(&branches[..1]).expect("bends").value, 0.01);
        assert_eq!(tightest_bend(&[bent("straight", Some(0.1), [f64::INFINITY; 2])]), None);
    }
}
