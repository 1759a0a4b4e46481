//! Results at a state: internal forces, moments, bend radii, reactions.

use crate::report::nodes;
use std::f64::consts::TAU;
use wireloom_core::equilibrium::{
    ArmFriction, BranchResult, ConstraintResult, FrictionResult, JointResult, MarkerResult, MechanismResult, NodeSides,
    ObstacleResult, SpanResult, StationResult, TightestBend,
};
use wireloom_core::joint::JointShape;
use wireloom_core::mechanism::Mechanism;
use wireloom_core::network::{AttachedConstraint, Branch, BranchEnd, Joint, Place, Site, Span};
use wireloom_core::obstacle::Obstacle;
use wireloom_core::problem::Problem;
use wireloom_core::requirement::Marker;
use wireloom_core::rod::Mesh;
use wireloom_core::rotation::{columns, twist_angle};
use wireloom_core::terms::constraints::Reaction;
use wireloom_core::terms::contact::ObstacleLoad;
use wireloom_core::terms::gravity;
use wireloom_core::variable::Variable;
use wireloom_core::{BranchShape, Mounting, Network, Pose, Rotation, State, Tangent, Vector};

/// Curvatures below this fraction of 1/L count as straight.
const STRAIGHT: f64 = 1e-9;

/// Side of a node.
#[derive(Clone, Copy)]
enum Side {
    Before,
    After,
    Both,
}

/// Result of a branch; `touching` marks the points in contact ([`Problem::touching_points`]).
pub fn branch(problem: &Problem<'_>, index: usize, state: &State, touching: &[bool]) -> BranchResult {
    let network = problem.network;
    let branch = &network.branches[index];
    let shape = problem.shape(state, index);
    let mesh = branch.rod.mesh();
    let n = mesh.segments();
    let mut segment_forces = vec![Vector::zeros(); n];
    branch.rod.forces(&shape, &mut segment_forces);
    let mut coupling_moments = vec![Vector::zeros(); mesh.coupling_lengths.len()];
    branch.rod.moments(&shape, &mut coupling_moments);
    let weight = |j: usize| problem.force_per_length(state, index, j);
    // Differences across a few nodes know little of a few segments, also where their span goes on beyond a joint.
    let refines = branch.rod.couples_pairs() && n >= Mesh::FINE;
    let is_fine = |j: usize| refines && mesh.is_fine(j);
    let lengths = gravity::middle_shifts(mesh, shape.rest_lengths);
    let middle_shifts: Vec<Vector> = lengths.into_iter().enumerate().map(|(j, length)| weight(j) * length).collect();
    let middle_forces: Vec<Vector> = segment_forces.iter().zip(&middle_shifts).map(|(n, shift)| n + shift).collect();
    let length = mesh.length();

    let s = state.arc_lengths(network, index);
    let mut result = BranchResult {
        name: branch.name.clone(),
        diameter: branch.sections.diameter(),
        bend_radius_limit: branch.sections.bend_radius_limit(),
        axial_stiffness: branch.sections.at_end(true).axial_stiffness,
        sections: branch.sections.results(&s),
        strain: None,
        s,
        position: shape.points.iter().zip(shape.compensation).map(|(x, c)| x + c).collect(),
        frame: Vec::with_capacity(n + 1),
        force: Vec::with_capacity(n + 1),
        moment: vec![Vector::zeros(); n + 1],
        bend_radius: Vec::with_capacity(n + 1),
        sides: Vec::new(),
        twist_turns: 0.0,
        error: None,
        deviation: None,
        friction: None,
    };
    let rest = branch.rod.linear_law().map(|law| law.curvature);
    let bent_by = |segment: usize, moment: &Vector| branch.sections.of(segment).curvature_under(moment);
    let segment_frame = |j: usize| shape.frames[mesh.segment_frames[j]];
    // Curvature (1/m) at each node, and its side of the node. At an inner station, where a constraint makes forces and
    // moments jump, the tighter side is reported.
    let mut curvature = vec![(Vector::zeros(), Side::Both); n + 1];
    // Coupling of each node that is reported.
    let mut couplings = vec![0; n + 1];
    for (c, &lambda) in shape.coupling_lengths.iter().enumerate() {
        let node = mesh.coupling_nodes[c];
        let relative = shape.frames[c].inverse() * shape.frames[c + 1];
        // The coupling beside a station lies in the middle of half a segment; the moment is that at the station.
        let kappa = match (mesh.station_frame(node), rest) {
            (Some(frame), Some(rest)) => {
                let moment = shape.frames[frame].inverse() * coupling_moments[c];
                let elastic = || rest + bent_by(mesh.coupling_segment(c), &moment);
                let kappa = branch.rod.curvature_under(&moment, memory_of(&shape, c), shape.duration);
                let kappa = kappa.unwrap_or_else(elastic);
                shape.extra_curvature.get(c).map_or(kappa, |extra| kappa + extra)
            }
            _ => relative.scaled_axis() / lambda,
        };
        let inner = node > 0 && node < n && mesh.station_frame(node).is_some();
        let second = c > 0 && mesh.coupling_nodes[c - 1] == node;
        if inner {
            let (moment, radius) = (coupling_moments[c], bend_radius(&kappa, length));
            match result.sides.last_mut().filter(|_| second) {
                Some(sides) => (sides.moment[1], sides.bend_radius[1]) = (moment, radius),
                None => result.sides.push(NodeSides {
                    node,
                    force: [
                        middle_forces[node - 1] - weight(node - 1) * (0.5 * shape.rest_lengths[node - 1]),
                        middle_forces[node] + weight(node) * (0.5 * shape.rest_lengths[node]),
                    ],
                    moment: [moment; 2],
                    bend_radius: [radius; 2],
                }),
            }
        }
        if !second || kappa.xy().norm() > curvature[node].0.xy().norm() {
            let side = match (inner, second) {
                (false, _) => Side::Both,
                (true, false) => Side::Before,
                (true, true) => Side::After,
            };
            curvature[node] = (kappa, side);
            result.moment[node] = coupling_moments[c];
            couplings[node] = c;
        }
    }
    // Edges are tangent to the centre line at their midpoints (frames are not, as the cable shears); nodes without a
    // station are off the centre line by ℓ² x″/24. In contact the polygon itself is reported, as its nodes touch.
    let touching = &touching[branch.points.clone()];
    let tangents = nodes::middle_tangents(branch, &shape);
    for node in (1..n).filter(|&node| mesh.station_frame(node).is_none() && !touching[node]) {
        let length = shape.rest_lengths[node - 1] + shape.rest_lengths[node];
        result.position[node] += (tangents[node] - tangents[node - 1]) * (length / 48.0);
    }
    // Ends at a joint without stations have no coupling of the rod: the moment there is that of the joint, and frame
    // and curvature follow from it, or with two arms from the segments on both sides.
    let mut continued = [None, None];
    // Whether the rod runs through the joint there.
    let mut through = [false, false];
    for (k, (end, node)) in [(branch.start, 0), (branch.end, n)].into_iter().enumerate() {
        let BranchEnd::Joint { joint, arm } = end else { continue };
        let memory = &problem.conditions().joints[joint].memory;
        let joint = &network.joints[joint];
        if joint.model.mounting() != Mounting::Point {
            continue;
        }
        let (segment, sign) = if k == 0 { (0, 1.0) } else { (n - 1, -1.0) };
        let q = segment_frame(segment);
        let frames: Vec<Rotation> = joint.coupled_frames.iter().map(|&c| state.frames[c]).collect();
        let mut moments = vec![Vector::zeros(); frames.len()];
        joint.model.add_gradient(&JointShape { frames: &frames, memory }, &mut moments);
        let of_arm = frames.iter().zip(&moments).skip(arm).step_by(joint.arms.len());
        let moment = of_arm.map(|(frame, moment)| frame * moment).sum::<Vector>() * sign;
        if !touching[node] {
            result.position[node] += joint_shift(problem, joint, state);
        }
        result.moment[node] = moment;
        // Where the joint continues the rod, it has the variation of curvature to the coupling beside it.
        let second = joint.arms.len() + arm;
        if let (Some(frame), Some(moment)) = (frames.get(second), moments.get(second)) {
            result.moment[if k == 0 { 1 } else { n - 1 }] += frame * moment * sign;
        }
        let (kappa, frame) = if joint.arms.len() == 2 {
            let beyond = mean_rotation(others(joint, arm, state)) * joint.arms[arm].rest;
            let bent = |a: &Rotation, b: &Rotation| if k == 0 { b.inverse() * a } else { a.inverse() * b };
            let kappa = bent(&q, &beyond).scaled_axis() / mean_length(joint);
            let mut frame = halfway(&beyond, &q, 0.5);
            if let [_, _, seconds @ ..] = frames.as_slice()
                && let (Some(own), Some(other)) = (seconds.get(arm), seconds.get(1 - arm))
            {
                through[k] = true;
                let [here, across] = [arm, 1 - arm].map(|arm| &joint.arms[arm]);
                let own_length = end_coupling(&shape, here.starts_here);
                let other_shape = state.branch(network, joint.branches[1 - arm]);
                let other_length = end_coupling(&other_shape, across.starts_here);
                let other = other * across.rest.inverse() * here.rest;
                let [own, other] =
                    [bent(own, &q).scaled_axis() / own_length, bent(&beyond, &other).scaled_axis() / other_length];
                let middle = mean_length(joint);
                let places = [0.5 * sign * (own_length + middle), 0.0, -0.5 * sign * (middle + other_length)];
                let rate = nodes::slope(places, [own, kappa, other], 0.0);
                frame *= Rotation::from_scaled_axis(rate * (here.segment_length * across.segment_length / -8.0));
            }
            (kappa, frame)
        } else {
            let moment = q.inverse() * moment;
            let kappa = bent_by(segment, &moment) + joint.arms[arm].curvature;
            (kappa, q * Rotation::from_scaled_axis(kappa * (-0.5 * sign * shape.rest_lengths[segment])))
        };
        curvature[node].0 = kappa;
        continued[k] = Some(frame);
    }
    for (node, &(_, side)) in curvature.iter().enumerate() {
        let (l0, l1) = (
            if node > 0 { shape.rest_lengths[node - 1] } else { 0.0 },
            if node < n { shape.rest_lengths[node] } else { 0.0 },
        );
        let frame = match (mesh.station_frame(node), node) {
            (Some(c), _) => shape.frames[c],
            (None, 0) => continued[0].unwrap_or_else(|| segment_frame(0)),
            (None, node) if node == n => continued[1].unwrap_or_else(|| segment_frame(n - 1)),
            (None, node) => halfway(&segment_frame(node - 1), &segment_frame(node), l0 / (l0 + l1)),
        };
        result.frame.push(frame);
        // Between nodes the force changes by the weight and the loads along it: n' + f = 0. Moments of coarse spans are
        // in balance with the forces of segments as they are.
        let inner = |j: usize| if is_fine(j) { middle_forces[j] } else { segment_forces[j] };
        result.force.push(match (node, side) {
            (0, _) | (_, Side::After) => middle_forces[node] + weight(node) * (0.5 * l1),
            (_, Side::Before) => middle_forces[node - 1] - weight(node - 1) * (0.5 * l0),
            (node, _) if node == n => middle_forces[n - 1] - weight(n - 1) * (0.5 * l0),
            (node, Side::Both) => (inner(node - 1) * l1 + inner(node) * l0) / (l0 + l1),
        });
    }
    if refines && !touching.contains(&true) {
        let segments = nodes::Segments { shape: &shape, forces: &middle_forces, shifts: &middle_shifts };
        let rest = rest.unwrap_or_default();
        nodes::refine(branch, &segments, through, weight, &mut result, |node, moment| {
            // The same all along a branch.
            let rest = shape.extra_curvature.first().map_or(rest, |extra| rest + extra);
            curvature[node].0 = rest + bent_by(node.min(n - 1), &moment);
        });
    }
    if branch.has_axial_law() || branch.sections.only().is_none() {
        let strain = |node: usize| {
            let strains = [node.saturating_sub(1), node.min(n - 1)];
            let [before, after] = strains.map(|segment| branch.strain_under(segment, result.tension_at(node)).0);
            if after.abs() > before.abs() { after } else { before }
        };
        result.strain = Some((0..=n).map(strain).collect());
    }
    result.twist_turns = twist(mesh, &shape, curvature.iter().map(|(kappa, _)| kappa.z).collect()) / TAU;
    result.bend_radius = curvature.iter().map(|(kappa, _)| bend_radius(kappa, length)).collect();
    if !shape.memory.is_empty() {
        let unloaded = |c: &usize| branch.rod.curvature_under(&Vector::zeros(), memory_of(&shape, *c), 0.0);
        let set = couplings.iter().map(|c| unloaded(c).unwrap_or_default() - rest.unwrap_or_default()).collect();
        let [dissipated, dissipated_in_all] = problem.conditions().rods[index].dissipated;
        result.friction = Some(FrictionResult { set, dissipated, dissipated_in_all });
    }
    result
}

/// Bend radius (m) of a curvature (1/m) in a branch of this length (m).
fn bend_radius(kappa: &Vector, length: f64) -> f64 {
    let bend = kappa.xy().norm();
    if bend * length > STRAIGHT { 1.0 / bend } else { f64::INFINITY }
}

/// Length of the first or last coupling of a branch, m.
fn end_coupling(shape: &BranchShape<'_>, first: bool) -> f64 {
    shape.coupling_lengths[if first { 0 } else { shape.coupling_lengths.len() - 1 }]
}

/// Memory of a coupling.
fn memory_of<'s>(shape: &BranchShape<'s>, coupling: usize) -> &'s [f64] {
    let width = shape.memory.len() / shape.coupling_lengths.len();
    &shape.memory[coupling * width..(coupling + 1) * width]
}

/// `∫ κ3 ds` of a branch, rad; `at_nodes` is κ3 at its nodes, 1/m. A coupling measures the rotation vector λκ over its
/// cell; the mean curvature there is `κ − (λ²/12) κ × D` with the rate D (`models::variation`). Beside an end without a
/// station half a segment is left, over which κ3 is the parabola through the next three nodes.
fn twist(mesh: &Mesh, shape: &BranchShape<'_>, at_nodes: Vec<f64>) -> f64 {
    let lengths = shape.coupling_lengths;
    let kappa = |c: usize| (shape.frames[c].inverse() * shape.frames[c + 1]).scaled_axis() / lengths[c];
    let curvatures: Vec<Vector> = (0..lengths.len()).map(kappa).collect();
    let is_station = |frame: usize| mesh.station_frames.binary_search(&frame).is_ok();
    let cell = |c: usize| {
        let before = if c > 0 && !is_station(c) { c - 1 } else { c };
        let after = if c + 1 < lengths.len() && !is_station(c + 1) { c + 1 } else { c };
        let distance: f64 = (before..after).map(|k| 0.5 * (lengths[k] + lengths[k + 1])).sum();
        let change = curvatures[after] - curvatures[before];
        let rate = if distance > 0.0 { change / distance } else { change };
        lengths[c] * (curvatures[c].z - lengths[c].powi(2) / 12.0 * curvatures[c].cross(&rate).z)
    };
    let n = mesh.segments();
    let end = |node: usize, inwards: [usize; 2], segment: usize| match mesh.station_frame(node) {
        Some(_) => 0.0,
        None if n < 2 => 0.5 * shape.rest_lengths[segment] * at_nodes[node],
        None => {
            let [next, second] = inwards.map(|node| at_nodes[node]);
            shape.rest_lengths[segment] * (at_nodes[node] / 3.0 + next * (5.0 / 24.0) - second / 24.0)
        }
    };
    let ends = end(0, [1, 2], 0) + end(n, [n.saturating_sub(1), n.saturating_sub(2)], n - 1);
    (0..lengths.len()).map(cell).sum::<f64>() + ends
}

/// Turns of the frames of a branch about its centre line, each from the one before.
pub(crate) fn twist_turns(frames: &[Rotation]) -> f64 {
    let angles = frames.windows(2).map(|pair| twist_angle(&(pair[0].inverse() * pair[1])));
    angles.sum::<f64>() / TAU
}

/// Rotation at fraction `t` between `a` and `b`.
fn halfway(a: &Rotation, b: &Rotation, t: f64) -> Rotation {
    a.try_slerp(b, t, 1e-12).unwrap_or(*a)
}

/// Result of the joint of this index; see [`branch`].
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
fn joint_shift(problem: &Problem<'_>, joint: &Joint, state: &State) -> Vector {
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
