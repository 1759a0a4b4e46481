//! The function to be minimised: energy, gradient and Hessian of a network under conditions, and which
//! freedoms the fixings leave.

use crate::constraint::{Action, RotationHold};
use crate::contact::{Against, ContactState, Contacts};
use crate::equilibrium::Energy;
use crate::fixings::{Block, Exerted, FixingState, Room};
use crate::network::WORTHWHILE;
use crate::rod::{BranchHessian, BranchShape};
use crate::rotation::{columns, nearer_sign, shortest};
use crate::scales::{LocalScale, LocalScales, rigidity};
use crate::sliding::{ActiveSlide, LengthTerms, Sliding};
use crate::{Matrix, Monitor, Network, Pose, Rotation, State, Tangent, Vector};
use serde::{Deserialize, Serialize};

/// Share of the weight of a segment beside a station that its other node carries for it: of what the staggered scheme
/// differs from the rod, that takes out the boundary term `−(ℓ²/24) [ρ g·t]` of each span.
pub const STATION_SHIFT: f64 = 1.0 / 24.0;

/// What acts on the harness at one moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conditions {
    /// Gravity, m/s².
    pub gravity: Vector,
    /// Factor of each load.
    pub load_factors: Vec<f64>,
    /// Which fixings act.
    pub active: Vec<bool>,
    /// Where each fixing holds (or pulls) its first station.
    pub targets: Vec<Pose>,
    /// What each fixing carries along.
    pub fixings: Vec<FixingState>,
    /// How each fixing of [`Network::slides`] slides, while it acts.
    pub sliding: Vec<Sliding>,
    /// Where obstacles stand, and what touches them.
    pub contact: ContactState,
}

/// An independent variable: three numbers of a [`Tangent`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Variable {
    /// Position of a point.
    Point(usize),
    /// Rotation of a frame.
    Frame(usize),
}

/// A variable of which some or all directions are prescribed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// The variable.
    pub variable: Variable,
    /// Orthonormal columns: world axes for points, body axes for frames. The held directions come first.
    pub basis: Matrix,
    /// For each held direction (so many are held) the fixing that holds it.
    pub fixing: [usize; 3],
    /// How many of the basis' directions are held.
    pub count: usize,
}

/// Second derivatives of the elastic energy, part by part, as [`Problem::hessian`] fills them.
pub struct Hessian {
    /// Each branch.
    pub branches: Vec<BranchHessian>,
    /// For each joint with energy the k × k table of [`crate::JointModel::add_hessian`].
    pub joints: Vec<Vec<Matrix>>,
    /// Of all fixings that pull or set equations; see [`Problem::fixing_hessian`].
    pub fixings: Vec<Block>,
    /// For each tie the second derivative in the rotation of its hub.
    pub ties: Vec<Matrix>,
}

impl Hessian {
    /// Room for the Hessian of a network.
    pub fn new(network: &Network) -> Self {
        Self {
            branches: network.branches.iter().map(|b| BranchHessian::new(b.rod.mesh())).collect(),
            joints: network.joints.iter().map(|j| vec![Matrix::zeros(); j.arm_frames.len().pow(2)]).collect(),
            fixings: Vec::new(),
            ties: vec![Matrix::zeros(); network.ties.len()],
        }
    }
}

/// A network under conditions.
pub struct Problem<'n> {
    /// The harness.
    pub network: &'n Network,
    /// Through it others may stop what works on the problem.
    pub monitor: Monitor,
    pub(crate) conditions: Conditions,
    /// Dead force at every point, N; without the weight of branches whose mesh may move along them.
    dead: Vec<Vector>,
    /// The fixings that slide, and act.
    pub(crate) slides: Vec<ActiveSlide>,
    /// Scratch.
    pub(crate) length_terms: LengthTerms,
    /// Dead moment (world) by independent frame, N m.
    dead_moments: Vec<(usize, Vector)>,
    /// Share of the dead moments that acts.
    moment_share: f64,
    held: Vec<Held>,
    /// Curvature that was drawn beyond that at rest, by first frame of each coupling, 1/m; empty where none is held.
    drawn: Vec<Vector>,
    /// The share of it that counts as rest curvature.
    extra_curvature: Vec<Vector>,
    /// Force at each tied point in the last gradient, N, world.
    tie_forces: Vec<Vector>,
    /// Scratch: energies of the branches, frames and gradients of the arms of a joint.
    energies: Vec<f64>,
    arm_frames: Vec<Rotation>,
    arm_gradients: Vec<Vector>,
    pub(crate) fixing_room: Room,
    /// ρ per unit of penalty of a residual whose scale is 1, J.
    pub(crate) penalty_unit: f64,
    /// A fixing that has said what is not finite of a harness that is.
    pub(crate) odd: Option<usize>,
    pub(crate) contacts: Contacts,
    /// Scales of the branches without weight and contact.
    pub(crate) rigidity: Vec<LocalScale>,
    pub(crate) local: LocalScales,
    /// What the energy was summed up from in the last gradient, each part without its sign, J.
    pub(crate) magnitude: f64,
}

impl<'n> Problem<'n> {
    /// A network under conditions.
    pub fn new(network: &'n Network, conditions: Conditions) -> Self {
        let arms = network.joints.iter().map(|j| j.arm_frames.len()).max().unwrap_or(0);
        let contacts = Contacts::new(network, &conditions);
        let mut problem = Self {
            network,
            monitor: Monitor::default(),
            conditions,
            contacts,
            dead: vec![Vector::zeros(); network.points],
            slides: Vec::new(),
            length_terms: LengthTerms::default(),
            dead_moments: Vec::with_capacity(network.loads.len()),
            moment_share: 1.0,
            held: Vec::new(),
            drawn: Vec::new(),
            extra_curvature: Vec::new(),
            tie_forces: vec![Vector::zeros(); network.ties.len()],
            energies: vec![0.0; network.branches.len()],
            arm_frames: Vec::with_capacity(arms),
            arm_gradients: vec![Vector::zeros(); arms],
            fixing_room: Room::default(),
            penalty_unit: 0.0,
            odd: None,
            rigidity: rigidity(network),
            local: LocalScales::default(),
            magnitude: 0.0,
        };
        problem.lump_dead_loads();
        problem.find_slides();
        problem
    }

    /// The conditions.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// Changes what acts; see [`Self::set_target`] for the cheap way to move a fixing.
    pub fn change(&mut self, change: impl FnOnce(&mut Conditions)) {
        change(&mut self.conditions);
        self.lump_dead_loads();
        self.find_slides();
    }

    /// Dead force at every point of the state, N: weight and loads; of points that ride on a joint, too. Without the weight of branches
    /// whose mesh may move along them.
    pub fn dead_forces(&self) -> &[Vector] {
        &self.dead
    }

    /// What is added to the rest curvature, by first frame of each coupling, 1/m; empty: nothing.
    pub fn extra_curvature(&self) -> &[Vector] {
        &self.extra_curvature
    }

    /// How a fixing that slides (index in [`Network::slides`]) does so from now on.
    pub fn set_sliding(&mut self, slide: usize, sliding: Sliding) {
        self.conditions.sliding[slide] = sliding;
    }

    /// Gravity lumped at nodes and dead loads.
    fn lump_dead_loads(&mut self) {
        let mut dead = std::mem::take(&mut self.dead);
        dead.fill(Vector::zeros());
        for (b, branch) in self.network.branches.iter().enumerate().filter(|(_, branch)| !branch.mesh_moves) {
            self.for_weights(b, &branch.rod.mesh().rest_lengths, |point, force| dead[point] += force);
        }
        self.dead = dead;
        self.dead_moments.clear();
        let g = self.conditions.gravity;
        for joint in &self.network.joints {
            self.dead[joint.point] += g * joint.mass;
        }
        for (load, factor) in self.network.loads.iter().zip(&self.conditions.load_factors) {
            self.dead[load.point] += load.force * *factor;
            let moment = load.moment * (*factor * self.moment_share);
            if let Some(frame) = load.site.frame
                && moment != Vector::zeros()
            {
                self.dead_moments.push((frame, moment));
            }
        }
        let scales = self.scales();
        self.penalty_unit = scales.force * scales.length;
    }

    /// Takes the curvature and twist that the branches have at `state` for their rest curvature, until
    /// [`Self::set_drawn_share`] takes it away again: from what was drawn, small steps then lead to the harness as it is.
    pub fn hold_drawn_shape(&mut self, state: &State) {
        self.drawn = vec![Vector::zeros(); self.network.frames];
        for branch in &self.network.branches {
            for c in 0..branch.rod.mesh().coupling_lengths.len() {
                let lambda = &state.coupling_lengths[branch.frames.start + c];
                let frames = &state.frames[branch.frames.start + c..];
                let now = (frames[0].inverse() * frames[1]).scaled_axis();
                let rest = branch.rod.rest_rotation(c).scaled_axis();
                self.drawn[branch.frames.start + c] = (now - rest) / *lambda;
            }
        }
        self.extra_curvature.clone_from(&self.drawn);
    }

    /// Share of the drawn curvature that counts as rest curvature, 1 to 0; at 0 it is forgotten.
    pub fn set_drawn_share(&mut self, share: f64) {
        if share == 0.0 {
            self.drawn.clear();
            self.extra_curvature.clear();
        }
        for (extra, drawn) in self.extra_curvature.iter_mut().zip(&self.drawn) {
            *extra = drawn * share;
        }
    }

    /// The shape of one branch.
    #[inline]
    pub(crate) fn shape<'s>(&'s self, state: &'s State, branch: usize) -> BranchShape<'s> {
        let frames = self.network.branches[branch].frames.clone();
        BranchShape {
            extra_curvature: self.extra_curvature.get(frames).unwrap_or_default(),
            ..state.branch(self.network, branch)
        }
    }

    /// Energy by effect, J.
    pub fn energy(&mut self, state: &State) -> Energy {
        let mut energy = Energy::default();
        for b in 0..self.network.branches.len() {
            let rod = self.network.branches[b].rod.energy(&self.shape(state, b));
            energy.stretch += rod.stretch;
            energy.shear += rod.shear;
            energy.bend += rod.bend;
            energy.twist += rod.twist;
        }
        for joint in &self.network.joints {
            self.arm_frames.clear();
            self.arm_frames.extend(joint.arm_frames.iter().map(|&c| state.frames[c]));
            energy.joint += joint.model.energy(&self.arm_frames);
        }
        for (load, factor) in self.network.loads.iter().zip(&self.conditions.load_factors) {
            energy.load -= factor * load.force.dot(&state.points[load.point]);
        }
        let dead: f64 = self.dead.iter().zip(&state.points).map(|(f, x)| -f.dot(x)).sum();
        energy.gravity = dead - energy.load;
        self.for_moving_weights(state, |point, force| energy.gravity -= force.dot(&state.points[point]));
        energy.constraint = self.fixing_energy(state) + self.find_contacts(state);
        energy
    }

    /// The weight of branches whose mesh may move along them, as it is lumped at `state`.
    fn for_moving_weights(&self, state: &State, mut add: impl FnMut(usize, Vector)) {
        for (b, _) in self.network.branches.iter().enumerate().filter(|(_, branch)| branch.mesh_moves) {
            self.for_weights(b, state.branch(self.network, b).rest_lengths, &mut add);
        }
    }

    /// ∂E/∂x (N), ∂E/∂θ (N m) and ∂E/∂s (N) in the independent variables (tied entries are zero), held ones included: there
    /// it is what the fixing exerts on the harness. Returns the energy, J; dead moments do no work in it.
    pub fn gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        let mut energy = 0.0;
        for joint in &self.network.joints {
            gradient.points[joint.point] = Vector::zeros();
            if let Some(frame) = joint.frame {
                gradient.frames[frame] = Vector::zeros();
            }
        }
        let mut energies = std::mem::take(&mut self.energies);
        self.branch_gradients(state, 0, &mut energies, &mut gradient.points, &mut gradient.frames);
        // In this order, whoever was done first: the sum is the same for any number of threads.
        energy += energies.iter().sum::<f64>();
        self.energies = energies;
        let mut magnitude = energy;
        for ((g, x), f) in gradient.points.iter_mut().zip(&state.points).zip(&self.dead) {
            *g -= f;
            let work = f.dot(x);
            energy -= work;
            magnitude += work.abs();
        }
        self.for_moving_weights(state, |point, force| {
            gradient.points[point] -= force;
            let work = force.dot(&state.points[point]);
            energy -= work;
            magnitude += work.abs();
        });
        if !self.network.slides.is_empty() {
            energy += self.slide_gradient(state, gradient);
        }
        for (frame, moment) in &self.dead_moments {
            gradient.frames[*frame] -= state.frames[*frame].inverse_transform_vector(moment);
        }
        for joint in &self.network.joints {
            if joint.arm_frames.is_empty() {
                continue;
            }
            self.arm_frames.clear();
            self.arm_frames.extend(joint.arm_frames.iter().map(|&c| state.frames[c]));
            let arms = &mut self.arm_gradients[..joint.arm_frames.len()];
            arms.fill(Vector::zeros());
            energy += joint.model.add_gradient(&self.arm_frames, arms);
            for (&c, g) in joint.arm_frames.iter().zip(arms) {
                gradient.frames[c] += *g;
            }
        }
        energy += self.contact_gradient(state, gradient);
        for (tie, force) in self.network.ties.iter().zip(&mut self.tie_forces) {
            *force = gradient.points[tie.point];
        }
        self.network.pull_back(state, gradient);
        let fixings = self.fixing_gradient(state, gradient);
        self.magnitude = magnitude + fixings.abs();
        energy + fixings
    }

    /// Energies and gradients of as many branches as `energies` has room for, from `first` on; `points` and `frames` begin with theirs.
    fn branch_gradients(
        &self,
        state: &State,
        first: usize,
        energies: &mut [f64],
        points: &mut [Vector],
        frames: &mut [Vector],
    ) {
        let branches = &self.network.branches[first..first + energies.len()];
        let (Some(start), Some(end)) = (branches.first(), branches.last()) else { return };
        let all = start.points.start..end.points.end;
        if branches.len() > 1 && all.len() >= 2 * WORTHWHILE {
            let half = branches.partition_point(|branch| branch.points.end <= all.start + all.len() / 2);
            let half = half.clamp(1, branches.len() - 1);
            let (energies, other_energies) = energies.split_at_mut(half);
            let (points, other_points) = points.split_at_mut(branches[half].points.start - all.start);
            let (frames, other_frames) = frames.split_at_mut(branches[half].frames.start - start.frames.start);
            rayon::join(
                || self.branch_gradients(state, first, energies, points, frames),
                || self.branch_gradients(state, first + half, other_energies, other_points, other_frames),
            );
            return;
        }
        let (mut points, mut frames) = (points, frames);
        for (k, (branch, energy)) in branches.iter().zip(energies).enumerate() {
            let (own_points, later_points) = points.split_at_mut(branch.points.len());
            let (own_frames, later_frames) = frames.split_at_mut(branch.frames.len());
            *energy = branch.rod.gradient(&self.shape(state, first + k), own_points, own_frames);
            (points, frames) = (later_points, later_frames);
        }
    }

    /// Second derivatives at `state`. `forces` (N, body frame; one vector for each branch, one entry for each segment)
    /// replaces the rods' own forces in the geometric stiffness; see [`crate::RodSegment::hessian`]. Call after
    /// [`Self::gradient`] at the same state.
    pub fn hessian(&mut self, state: &State, forces: Option<&[Vec<Vector>]>, hessian: &mut Hessian) {
        let this = &*self;
        this.network.for_branches(&mut hessian.branches, |b, branch, room| {
            branch.rod.hessian(&this.shape(state, b), forces.map(|f| f[b].as_slice()), room);
        });
        for (joint, table) in self.network.joints.iter().zip(&mut hessian.joints) {
            table.fill(Matrix::zeros());
            self.arm_frames.clear();
            self.arm_frames.extend(joint.arm_frames.iter().map(|&c| state.frames[c]));
            joint.model.add_hessian(&self.arm_frames, table);
        }
        for ((tie, force), h) in self.network.ties.iter().zip(&self.tie_forces).zip(&mut hessian.ties) {
            if let Some(hub) = tie.hub_frame {
                *h = lever_hessian(&state.frames[hub], force, &tie.offset);
            }
        }
        self.fixing_hessian(state, false, &mut hessian.fixings);
    }

    /// Second derivatives of the energy at `state` in the edges of a branch, N/m; see [`crate::RodSegment::edge_stiffness`].
    pub fn edge_stiffness(&self, state: &State, branch: usize, stiffness: &mut [Matrix]) {
        self.network.branches[branch].rod.edge_stiffness(&self.shape(state, branch), stiffness);
    }

    /// Which variables are held, as [`Self::update_held`] found them.
    pub fn held(&self) -> &[Held] {
        &self.held
    }

    /// Finds the held directions at `state`, and what residuals are measured by. Allocates only when there are more of them than ever before.
    pub fn update_held(&mut self, state: &State) {
        let mut held = std::mem::take(&mut self.held);
        held.clear();
        for (f, fixing) in self.network.fixings.iter().enumerate() {
            if !self.conditions.active[f] {
                continue;
            }
            let Action::Prescribed(hold) = fixing.constraint.action() else { continue };
            if hold.position {
                let variable = Variable::Point(fixing.site.point);
                match hold.rails.as_slice() {
                    [] => {
                        for d in [Vector::x(), Vector::y(), Vector::z()] {
                            add_direction(&mut held, variable, f, &d);
                        }
                    }
                    [a] => {
                        let b = crate::rotation::orthogonal(a);
                        add_direction(&mut held, variable, f, &b);
                        add_direction(&mut held, variable, f, &a.cross(&b));
                    }
                    [a, b, ..] => add_direction(&mut held, variable, f, &a.cross(b)),
                }
            }
            let Some(frame) = fixing.site.frame else { continue };
            let variable = Variable::Frame(frame);
            let local = &fixing.site.local.orientation;
            let mut add = |d: Vector| add_direction(&mut held, variable, f, &(local * d));
            match &hold.rotation {
                RotationHold::Free => {}
                RotationHold::Tangent => {
                    add(Vector::x());
                    add(Vector::y());
                }
                RotationHold::All => {
                    add(Vector::x());
                    add(Vector::y());
                    add(Vector::z());
                }
                RotationHold::Twist => {
                    // Gradient of the twist angle α = 2 atan2(z, w) of p = q̄_target q.
                    let p = self.conditions.targets[f].orientation.inverse() * (state.frames[frame] * local);
                    let (w, v) = (p.w, p.imag());
                    add(Vector::new(v.z * v.x - w * v.y, w * v.x + v.z * v.y, w * w + v.z * v.z).normalize());
                }
                RotationHold::Hinge(axis) => {
                    let axis = (state.frames[frame] * local).inverse_transform_vector(axis);
                    let b = crate::rotation::orthogonal(&axis);
                    add(b);
                    add(axis.cross(&b));
                }
            }
        }
        for h in &mut held {
            complete_basis(h);
        }
        self.held = held;
        self.note_held_near();
        self.update_room(state);
        self.update_local_scales();
    }

    fn update_local_scales(&mut self) {
        let pushes = self.conditions.contact.marks.iter().flat_map(|mark| {
            let other = match mark.against {
                Against::Cable { branch, .. } => Some(branch as usize),
                Against::Obstacle { .. } => None,
            };
            let own = self.contacts.branch_of(mark);
            [Some(own), other].into_iter().flatten().map(|b| (b, mark.multiplier))
        });
        self.local.find(self.network, &self.rigidity, self.conditions.gravity.norm(), pushes, &self.dead_moments);
    }

    /// The orientation a fixing gives a station that is at `q`: its target, but for what it leaves free.
    fn placed(&self, fixing: usize, rotation: &RotationHold, q: &Rotation) -> Rotation {
        let target = &self.conditions.targets[fixing].orientation;
        match rotation {
            RotationHold::Free => *q,
            RotationHold::All => *target,
            RotationHold::Tangent => shortest(&columns(q)[2], &columns(target)[2]) * q,
            RotationHold::Twist => {
                let alpha = crate::rotation::twist_angle(&(target.inverse() * q));
                q * Rotation::from_axis_angle(&Vector::z_axis(), -alpha)
            }
            RotationHold::Hinge(axis) => {
                let r = q * target.inverse();
                let phi = 2.0 * r.imag().dot(axis).atan2(r.w);
                Rotation::from_axis_angle(axis, phi) * target
            }
        }
    }

    /// Puts every held freedom exactly where its fixing wants it, and what is tied to a joint with it.
    pub fn place_held(&self, state: &mut State) {
        for (f, fixing) in self.network.fixings.iter().enumerate() {
            if !self.conditions.active[f] {
                continue;
            }
            let Action::Prescribed(hold) = fixing.constraint.action() else { continue };
            if let Some(frame) = fixing.site.frame
                && hold.rotation != RotationHold::Free
            {
                let local = &fixing.site.local.orientation;
                let station = state.frames[frame] * local;
                let placed = self.placed(f, &hold.rotation, &station) * local.inverse();
                state.frames[frame] = nearer_sign(placed, &state.frames[frame]);
            }
            if hold.position {
                let lever =
                    fixing.site.frame.map_or_else(Vector::zeros, |c| state.frames[c] * fixing.site.local.position);
                let target = self.conditions.targets[f].position - lever;
                let i = fixing.site.point;
                if hold.rails.is_empty() {
                    state.points[i] = target;
                    state.carry[i] = Vector::zeros();
                } else {
                    let gap = target - state.points[i];
                    let along: Vector = hold.rails.iter().map(|d| d * d.dot(&gap)).sum();
                    state.points[i] += gap - along;
                }
            }
        }
        self.network.follow_ties(state);
    }

    /// How the held freedoms must move from `state` to where their fixings want them (to first order; zero
    /// elsewhere). Returns whether anything must move.
    pub fn motion(&self, state: &State, motion: &mut Tangent) -> bool {
        motion.clear();
        for (f, fixing) in self.network.fixings.iter().enumerate() {
            if !self.conditions.active[f] {
                continue;
            }
            let Action::Prescribed(hold) = fixing.constraint.action() else { continue };
            if let Some(frame) = fixing.site.frame
                && hold.rotation != RotationHold::Free
            {
                let local = &fixing.site.local.orientation;
                let station = state.frames[frame] * local;
                let turn = station.inverse() * self.placed(f, &hold.rotation, &station);
                motion.frames[frame] += local * turn.scaled_axis();
            }
            if hold.position {
                let at = state.pose(&fixing.site).position;
                let gap = self.conditions.targets[f].position - at;
                let along: Vector = hold.rails.iter().map(|d| d * d.dot(&gap)).sum();
                motion.points[fixing.site.point] += gap - along;
            }
        }
        let mut moves = false;
        for h in &self.held {
            let held_part =
                |d: &Vector| -> Vector { (0..h.count).map(|k| h.basis.column(k) * h.basis.column(k).dot(d)).sum() };
            let d = match h.variable {
                Variable::Point(i) => &mut motion.points[i],
                Variable::Frame(c) => &mut motion.frames[c],
            };
            *d = held_part(d);
            moves |= d.amax() > 1e-14;
        }
        moves
    }

    /// Removes the held directions from a gradient: what is left must vanish.
    pub fn free_part(&self, gradient: &mut Tangent) {
        for h in &self.held {
            let g = match h.variable {
                Variable::Point(i) => &mut gradient.points[i],
                Variable::Frame(c) => &mut gradient.frames[c],
            };
            for k in 0..h.count {
                let d: Vector = h.basis.column(k).into();
                *g -= d * d.dot(g);
            }
        }
        self.free_slides(gradient);
    }

    /// What fixing `f` exerts on the harness at `state`; see [`Self::reaction`].
    pub fn exerted(&self, f: usize, state: &State, gradient: &Tangent) -> Exerted {
        match self.network.fixings[f].constraint.action() {
            Action::Prescribed(_) => Exerted { stations: vec![self.held_reaction(f, state, gradient)], span: vec![] },
            _ => self.pull(f, state),
        }
    }

    /// What fixing `f` exerts on the harness: force (N) and moment about the held point (N m), world axes, at its first station; where it has
    /// none the force on its span. `gradient` is the whole gradient at `state`; the held directions must be up to date.
    pub fn reaction(&self, f: usize, state: &State, gradient: &Tangent) -> (Vector, Vector) {
        let exerted = self.exerted(f, state, gradient);
        exerted.stations.first().copied().unwrap_or_else(|| (exerted.span.iter().sum(), Vector::zeros()))
    }

    /// What a fixing that prescribes exerts.
    fn held_reaction(&self, f: usize, state: &State, gradient: &Tangent) -> (Vector, Vector) {
        let fixing = &self.network.fixings[f];
        let (mut force, mut moment) = (Vector::zeros(), Vector::zeros());
        for h in &self.held {
            for k in (0..h.count).filter(|&k| h.fixing[k] == f) {
                let d: Vector = h.basis.column(k).into();
                match h.variable {
                    Variable::Point(i) => force += d * d.dot(&gradient.points[i]),
                    Variable::Frame(c) => moment += state.frames[c] * (d * d.dot(&gradient.frames[c])),
                }
            }
        }
        let lever = fixing.site.frame.map_or_else(Vector::zeros, |c| state.frames[c] * fixing.site.local.position);
        (force, moment - lever.cross(&force))
    }

    /// Whether dead moments act.
    pub fn has_dead_moments(&self) -> bool {
        !self.dead_moments.is_empty()
    }

    /// The dead moments that act: the independent frame that takes each of them, and the moment, N m, world axes.
    ///
    /// A moment M about an axis fixed in space has no potential. It adds `−Rᵀ M` to the gradient; the derivative of that along
    /// `q ∘ exp(θ)`, pulled back to θ as all second derivatives are, is `−½ [Rᵀ M]ₓ`: antisymmetric, so that [`Self::hessian`] has nothing of it.
    pub fn dead_moments(&self) -> &[(usize, Vector)] {
        &self.dead_moments
    }

    /// Share of the dead moments that acts from now on, 0 to 1: the start of a harness is looked for without them.
    pub fn set_moment_share(&mut self, share: f64) {
        self.moment_share = share;
        self.lump_dead_loads();
    }

    /// Work of the dead moments over a step, J, to first order.
    pub fn moment_work(&self, state: &State, step: &Tangent, alpha: f64) -> f64 {
        self.dead_moments.iter().map(|(c, m)| alpha * m.dot(&(state.frames[*c] * step.frames[*c]))).sum()
    }
}

/// Second derivative in θ of `f · R exp(θ) o`: with `f_b = Rᵀ f` it is `sym(f_b oᵀ) − (f_b·o) I`.
pub(crate) fn lever_hessian(q: &Rotation, force: &Vector, offset: &Vector) -> Matrix {
    let f = q.inverse_transform_vector(force);
    let outer = f * offset.transpose();
    (outer + outer.transpose()) * 0.5 - Matrix::identity() * f.dot(offset)
}

/// Adds a held direction to a variable, unless it is held already.
fn add_direction(held: &mut Vec<Held>, variable: Variable, fixing: usize, direction: &Vector) {
    let index = held.iter().position(|h| h.variable == variable).unwrap_or_else(|| {
        held.push(Held { variable, basis: Matrix::zeros(), fixing: [usize::MAX; 3], count: 0 });
        held.len() - 1
    });
    let h = &mut held[index];
    let rest = (0..h.count).fold(*direction, |d, k| {
        let c: Vector = h.basis.column(k).into();
        d - c * c.dot(&d)
    });
    // Directions held twice (checked to agree) count once.
    if h.count < 3
        && let Some(d) = rest.try_normalize(1e-6)
    {
        h.basis.set_column(h.count, &d);
        h.fixing[h.count] = fixing;
        h.count += 1;
    }
}

/// Fills the free columns of a basis.
fn complete_basis(h: &mut Held) {
    let column = |k: usize, b: &Matrix| -> Vector { b.column(k).into() };
    if h.count == 1 {
        let b = crate::rotation::orthogonal(&column(0, &h.basis));
        h.basis.set_column(1, &b);
    }
    if h.count < 3 {
        let c = column(0, &h.basis).cross(&column(1, &h.basis));
        h.basis.set_column(2, &c);
    }
}
