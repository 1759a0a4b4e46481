//! Result of a branch at a state: centre line, frames, forces, moments and bend radii at its nodes.

use crate::report::nodes;
use crate::report::result::{joint_shift, mean_length, mean_rotation, others};
use std::f64::consts::TAU;
use wireloom_core::equilibrium::{BranchResult, FrictionResult, NodeSides};
use wireloom_core::joint::JointShape;
use wireloom_core::network::{Branch, BranchEnd, Joint};
use wireloom_core::problem::Problem;
use wireloom_core::rod::Mesh;
use wireloom_core::terms::gravity;
use wireloom_core::{BranchShape, Mounting, Rotation, State, Vector};

/// Curvatures below this fraction of 1/L count as straight.
const STRAIGHT: f64 = 1e-9;

/// Result of a branch; `touching` marks the points in contact ([`Problem::touching_points`]).
pub fn result(problem: &Problem<'_>, index: usize, state: &State, touching: &[bool]) -> BranchResult {
    let parts = Parts::new(problem, index, state);
    let (branch, mesh, n) = (parts.branch, parts.mesh(), parts.mesh().segments());
    let touching = &touching[branch.points.clone()];
    let mut result = parts.begin(state.arc_lengths(problem.network, index));
    let mut nodes = parts.at_couplings(&mut result);
    parts.move_to_centre_line(touching, &mut result.position);
    let ends = [0, 1].map(|end| parts.end_at_joint((problem, state), end, touching, &mut result, &mut nodes));
    for (node, own) in nodes.iter().enumerate() {
        result.frame.push(parts.frame(node, &ends));
        result.force.push(parts.force(node, own.side));
    }
    if parts.refines && !touching.contains(&true) {
        let segments = nodes::Segments { shape: &parts.shape, forces: &parts.middle_forces, shifts: &parts.shifts };
        let through = ends.each_ref().map(|end| end.is_some_and(|end| end.runs_through));
        nodes::refine(
            branch,
            &segments,
            through,
            |j| parts.loads[j],
            &mut result,
            |node, moment| {
                // The same all along a branch.
                let rest = parts.shape.extra_curvature.first().map_or(parts.rest(), |extra| parts.rest() + extra);
                nodes[node].curvature = rest + parts.bent_by(node.min(n - 1), &moment);
            },
        );
    }
    if branch.has_axial_law() || branch.sections.only().is_none() {
        let strain = |node: usize| {
            let strains = [node.saturating_sub(1), node.min(n - 1)];
            let [before, after] = strains.map(|segment| branch.strain_under(segment, result.tension_at(node)).0);
            if after.abs() > before.abs() { after } else { before }
        };
        result.strain = Some((0..=n).map(strain).collect());
    }
    result.twist_turns = twist(mesh, &parts.shape, nodes.iter().map(|own| own.curvature.z).collect()) / TAU;
    result.bend_radius = nodes.iter().map(|own| parts.bend_radius(&own.curvature)).collect();
    if !parts.shape.memory.is_empty() {
        let set = nodes.iter().map(|own| parts.unloaded(own.coupling) - parts.rest()).collect();
        let [dissipated, dissipated_in_all] = problem.conditions().rods[index].dissipated;
        result.friction = Some(FrictionResult { set, dissipated, dissipated_in_all });
    }
    result
}

/// What is known of a node.
#[derive(Clone, Copy)]
struct Node {
    /// Curvature, 1/m.
    curvature: Vector,
    /// Side of the node whose curvature, moment and force are reported.
    side: Side,
    /// Coupling that is reported.
    coupling: usize,
}

/// Side of a node.
#[derive(Clone, Copy)]
enum Side {
    Before,
    After,
    Both,
}

/// End of a branch at a joint without a station.
#[derive(Clone, Copy)]
struct EndAtJoint {
    /// Frame there.
    frame: Rotation,
    /// Whether the rod runs through the joint.
    runs_through: bool,
}

/// What the result of a branch is made of.
struct Parts<'a> {
    branch: &'a Branch,
    shape: BranchShape<'a>,
    /// Curvature at rest, 1/m; `None`: it is not known.
    rest: Option<Vector>,
    /// Load per length of each segment, N/m.
    loads: Vec<Vector>,
    /// Force of each segment, N.
    forces: Vec<Vector>,
    /// Force at the middle of each segment, and that less the one of the segment, N.
    middle_forces: Vec<Vector>,
    shifts: Vec<Vector>,
    /// Moment of each coupling, N m.
    moments: Vec<Vector>,
    /// Whether nodes are refined: differences across a few nodes know little of a few segments, also where their span
    /// goes on beyond a joint.
    refines: bool,
}

impl<'a> Parts<'a> {
    fn new(problem: &'a Problem<'_>, index: usize, state: &'a State) -> Self {
        let branch = &problem.network.branches[index];
        let shape = problem.shape(state, index);
        let mesh = branch.rod.mesh();
        let n = mesh.segments();
        let mut forces = vec![Vector::zeros(); n];
        branch.rod.forces(&shape, &mut forces);
        let mut moments = vec![Vector::zeros(); mesh.coupling_lengths.len()];
        branch.rod.moments(&shape, &mut moments);
        let loads: Vec<Vector> = (0..n).map(|j| problem.force_per_length(state, index, j)).collect();
        let lengths = gravity::middle_shifts(mesh, shape.rest_lengths);
        let shifts: Vec<Vector> = loads.iter().zip(lengths).map(|(load, length)| load * length).collect();
        Self {
            branch,
            shape,
            rest: branch.rod.linear_law().map(|law| law.curvature),
            loads,
            middle_forces: forces.iter().zip(&shifts).map(|(n, shift)| n + shift).collect(),
            forces,
            shifts,
            moments,
            refines: branch.rod.couples_pairs() && n >= Mesh::FINE,
        }
    }

    fn mesh(&self) -> &'a Mesh {
        self.branch.rod.mesh()
    }

    /// Curvature at rest, or 0 where it is not known, 1/m.
    fn rest(&self) -> Vector {
        self.rest.unwrap_or_default()
    }

    /// Curvature beyond that at rest by a moment (N m, body axes), 1/m.
    fn bent_by(&self, segment: usize, moment: &Vector) -> Vector {
        self.branch.sections.of(segment).curvature_under(moment)
    }

    /// Bend radius (m) of a curvature (1/m).
    fn bend_radius(&self, kappa: &Vector) -> f64 {
        let bend = kappa.xy().norm();
        if bend * self.mesh().length() > STRAIGHT { 1.0 / bend } else { f64::INFINITY }
    }

    /// Frame of a segment.
    fn segment_frame(&self, j: usize) -> Rotation {
        self.shape.frames[self.mesh().segment_frames[j]]
    }

    /// Memory of a coupling.
    fn memory_of(&self, coupling: usize) -> &[f64] {
        let width = self.shape.memory.len() / self.shape.coupling_lengths.len();
        &self.shape.memory[coupling * width..(coupling + 1) * width]
    }

    /// Curvature of a coupling that no moment bends, 1/m.
    fn unloaded(&self, coupling: usize) -> Vector {
        self.branch.rod.curvature_under(&Vector::zeros(), self.memory_of(coupling), 0.0).unwrap_or_default()
    }

    /// The result with what is known of all nodes: sections, the nodes themselves.
    fn begin(&self, s: Vec<f64>) -> BranchResult {
        let (branch, n) = (self.branch, self.mesh().segments());
        BranchResult {
            name: branch.name.clone(),
            diameter: branch.sections.diameter(),
            bend_radius_limit: branch.sections.bend_radius_limit(),
            axial_stiffness: branch.sections.at_end(true).axial_stiffness,
            sections: branch.sections.results(&s),
            strain: None,
            s,
            position: self.shape.points.iter().zip(self.shape.compensation).map(|(x, c)| x + c).collect(),
            frame: Vec::with_capacity(n + 1),
            force: Vec::with_capacity(n + 1),
            moment: vec![Vector::zeros(); n + 1],
            bend_radius: Vec::new(),
            sides: Vec::new(),
            twist_turns: 0.0,
            error: None,
            deviation: None,
            friction: None,
        }
    }

    /// Curvature of a coupling, 1/m. The one beside a station lies in the middle of half a segment; the moment is that
    /// at the station.
    fn curvature(&self, c: usize) -> Vector {
        let (shape, mesh) = (&self.shape, self.mesh());
        match (mesh.station_frame(mesh.coupling_nodes[c]), self.rest) {
            (Some(frame), Some(rest)) => {
                let moment = shape.frames[frame].inverse() * self.moments[c];
                let elastic = || rest + self.bent_by(mesh.coupling_segment(c), &moment);
                let kappa = self.branch.rod.curvature_under(&moment, self.memory_of(c), shape.duration);
                let kappa = kappa.unwrap_or_else(elastic);
                shape.extra_curvature.get(c).map_or(kappa, |extra| kappa + extra)
            }
            _ => (shape.frames[c].inverse() * shape.frames[c + 1]).scaled_axis() / shape.coupling_lengths[c],
        }
    }

    /// Curvatures of the nodes, from their couplings; writes moments, and both sides of inner stations. There a
    /// constraint makes forces and moments jump: the tighter side is reported.
    fn at_couplings(&self, result: &mut BranchResult) -> Vec<Node> {
        let mesh = self.mesh();
        let n = mesh.segments();
        let mut nodes = vec![Node { curvature: Vector::zeros(), side: Side::Both, coupling: 0 }; n + 1];
        for (c, &moment) in self.moments.iter().enumerate() {
            let node = mesh.coupling_nodes[c];
            let kappa = self.curvature(c);
            let inner = node > 0 && node < n && mesh.station_frame(node).is_some();
            let second = c > 0 && mesh.coupling_nodes[c - 1] == node;
            if inner {
                let radius = self.bend_radius(&kappa);
                match result.sides.last_mut().filter(|_| second) {
                    Some(sides) => (sides.moment[1], sides.bend_radius[1]) = (moment, radius),
                    None => result.sides.push(NodeSides {
                        node,
                        force: [self.force_at_end(node - 1), self.force_at_start(node)],
                        moment: [moment; 2],
                        bend_radius: [radius; 2],
                    }),
                }
            }
            if !second || kappa.xy().norm() > nodes[node].curvature.xy().norm() {
                let side = match (inner, second) {
                    (false, _) => Side::Both,
                    (true, false) => Side::Before,
                    (true, true) => Side::After,
                };
                nodes[node] = Node { curvature: kappa, side, coupling: c };
                result.moment[node] = moment;
            }
        }
        nodes
    }

    /// Moves nodes to the centre line: edges are tangent to it at their midpoints (frames are not, as the cable
    /// shears), and nodes without a station are off it by ℓ² x″/24. In contact the polygon itself is reported, as its
    /// nodes touch.
    fn move_to_centre_line(&self, touching: &[bool], positions: &mut [Vector]) {
        let (mesh, lengths) = (self.mesh(), self.shape.rest_lengths);
        let tangents = nodes::middle_tangents(self.branch, &self.shape);
        for node in (1..mesh.segments()).filter(|&node| mesh.station_frame(node).is_none() && !touching[node]) {
            let length = lengths[node - 1] + lengths[node];
            positions[node] += (tangents[node] - tangents[node - 1]) * (length / 48.0);
        }
    }

    /// The start (0) or end (1) of the branch, if it is at a joint without stations. It has no coupling of the rod: the
    /// moment there is that of the joint, and frame and curvature follow from it, or with two arms from the segments on
    /// both sides.
    fn end_at_joint(
        &self,
        (problem, state): (&Problem<'_>, &State),
        end: usize,
        touching: &[bool],
        result: &mut BranchResult,
        nodes: &mut [Node],
    ) -> Option<EndAtJoint> {
        let n = self.mesh().segments();
        let (at, node, segment, sign) =
            if end == 0 { (self.branch.start, 0, 0, 1.0) } else { (self.branch.end, n, n - 1, -1.0) };
        let BranchEnd::Joint { joint, arm } = at else { return None };
        let memory = &problem.conditions().joints[joint].memory;
        let joint = &problem.network.joints[joint];
        if joint.model.mounting() != Mounting::Point {
            return None;
        }
        let q = self.segment_frame(segment);
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
            result.moment[if end == 0 { 1 } else { n - 1 }] += frame * moment * sign;
        }
        if joint.arms.len() == 2 {
            let (curvature, end) = self.between_two_arms((problem, state), joint, (arm, end), (&q, &frames));
            nodes[node].curvature = curvature;
            return Some(end);
        }
        let moment = q.inverse() * moment;
        let kappa = self.bent_by(segment, &moment) + joint.arms[arm].curvature;
        nodes[node].curvature = kappa;
        let frame = q * Rotation::from_scaled_axis(kappa * (-0.5 * sign * self.shape.rest_lengths[segment]));
        Some(EndAtJoint { frame, runs_through: false })
    }

    /// Curvature (1/m) and frame at a joint of two arms, of the start (0) or end (1) of the branch; `q` is the frame of
    /// its segment there, `frames` are those that the joint couples.
    fn between_two_arms(
        &self,
        (problem, state): (&Problem<'_>, &State),
        joint: &Joint,
        (arm, end): (usize, usize),
        (q, frames): (&Rotation, &[Rotation]),
    ) -> (Vector, EndAtJoint) {
        let sign = if end == 0 { 1.0 } else { -1.0 };
        let beyond = mean_rotation(others(joint, arm, state)) * joint.arms[arm].rest;
        let bent = |a: &Rotation, b: &Rotation| if end == 0 { b.inverse() * a } else { a.inverse() * b };
        let kappa = bent(q, &beyond).scaled_axis() / mean_length(joint);
        let frame = halfway(&beyond, q, 0.5);
        let [_, _, seconds @ ..] = frames else { return (kappa, EndAtJoint { frame, runs_through: false }) };
        let (Some(own), Some(other)) = (seconds.get(arm), seconds.get(1 - arm)) else {
            return (kappa, EndAtJoint { frame, runs_through: false });
        };
        let [here, across] = [arm, 1 - arm].map(|arm| &joint.arms[arm]);
        let own_length = end_coupling(&self.shape, here.starts_here);
        let other_shape = state.branch(problem.network, joint.branches[1 - arm]);
        let other_length = end_coupling(&other_shape, across.starts_here);
        let other = other * across.rest.inverse() * here.rest;
        let [own, other] =
            [bent(own, q).scaled_axis() / own_length, bent(&beyond, &other).scaled_axis() / other_length];
        let middle = mean_length(joint);
        let places = [0.5 * sign * (own_length + middle), 0.0, -0.5 * sign * (middle + other_length)];
        let rate = nodes::slope(places, [own, kappa, other], 0.0);
        let turn = Rotation::from_scaled_axis(rate * (here.segment_length * across.segment_length / -8.0));
        (kappa, EndAtJoint { frame: frame * turn, runs_through: true })
    }

    /// Frame of a node.
    fn frame(&self, node: usize, ends: &[Option<EndAtJoint>; 2]) -> Rotation {
        let (mesh, lengths) = (self.mesh(), self.shape.rest_lengths);
        let n = mesh.segments();
        let at_end =
            |end: usize, segment: usize| ends[end].map_or_else(|| self.segment_frame(segment), |end| end.frame);
        match (mesh.station_frame(node), node) {
            (Some(c), _) => self.shape.frames[c],
            (None, 0) => at_end(0, 0),
            (None, node) if node == n => at_end(1, n - 1),
            (None, node) => {
                let [before, after] = [lengths[node - 1], lengths[node]];
                halfway(&self.segment_frame(node - 1), &self.segment_frame(node), before / (before + after))
            }
        }
    }

    /// Force at the start of a segment, N: between nodes it changes by the weight and the loads along it, n' + f = 0.
    fn force_at_start(&self, j: usize) -> Vector {
        self.middle_forces[j] + self.loads[j] * (0.5 * self.shape.rest_lengths[j])
    }

    /// Force at the end of a segment, N.
    fn force_at_end(&self, j: usize) -> Vector {
        self.middle_forces[j] - self.loads[j] * (0.5 * self.shape.rest_lengths[j])
    }

    /// Force of a node, N. Moments of coarse spans are in balance with the forces of segments as they are.
    fn force(&self, node: usize, side: Side) -> Vector {
        let (mesh, lengths) = (self.mesh(), self.shape.rest_lengths);
        let is_fine = |j: usize| self.refines && mesh.is_fine(j);
        let inner = |j: usize| if is_fine(j) { self.middle_forces[j] } else { self.forces[j] };
        match (node, side) {
            (0, _) | (_, Side::After) => self.force_at_start(node),
            (_, Side::Before) => self.force_at_end(node - 1),
            (node, _) if node == mesh.segments() => self.force_at_end(node - 1),
            (node, Side::Both) => {
                let [before, after] = [lengths[node - 1], lengths[node]];
                (inner(node - 1) * after + inner(node) * before) / (before + after)
            }
        }
    }
}

/// Length of the first or last coupling of a branch, m.
fn end_coupling(shape: &BranchShape<'_>, first: bool) -> f64 {
    shape.coupling_lengths[if first { 0 } else { shape.coupling_lengths.len() - 1 }]
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

/// Rotation at fraction `t` between `a` and `b`.
fn halfway(a: &Rotation, b: &Rotation, t: f64) -> Rotation {
    a.try_slerp(b, t, 1e-12).unwrap_or(*a)
}
