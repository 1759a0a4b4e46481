//! The function to be minimised: the energy of a network under conditions, as the sum of its [`crate::terms`].

use crate::conditions::{
    Against, Conditions, ConstraintState, ContactPoint, ContactRecord, FrictionAnchor, RodState, Sliding, System,
};
use crate::constitutive::{ConstitutiveLaws, Derivatives};
use crate::constraint::Action;
use crate::equilibrium::{Energy, PartFamily, SlideResult};
use crate::network::AttachedConstraint;
use crate::prescribed::{Held, Prescribed};
use crate::rod::{BranchHessian, BranchShape};
use crate::rotation::{columns, lever_hessian};
use crate::scales::{ENERGY_NOISE, LocalScale, LocalScales, Scales, rigidity};
use crate::terms::constraints::{ConstraintResidual, ConstraintTerm, Convex, Reaction};
use crate::terms::contact::{Contact, ContactTerm, ContactViolation, HeldOverlap, ObstacleLoad, Penetration};
use crate::terms::friction::{Anchoring, FrictionTerm};
use crate::terms::gravity;
use crate::terms::joints::JointTerm;
use crate::terms::loads::{self, LoadTangent, LoadTerm, SegmentTangent};
use crate::terms::rods::RodTerm;
use crate::terms::sliding::{SlideHessian, SlideStop, SlidingTerm};
use crate::terms::slope::Contradiction;
use crate::variable::{Block, Variable};
use crate::{Matrix, Monitor, Network, Pose, State, Tangent, Vector};
use std::collections::BTreeMap;

/// Second derivatives of the elastic energy, part by part, as [`Problem::hessian`] fills them.
pub struct Hessian {
    /// Second derivatives of each branch.
    pub branches: Vec<BranchHessian>,
    /// The k × k table of [`crate::JointModel::add_hessian`] of each joint.
    pub joints: Vec<Vec<Matrix>>,
    /// Blocks of contact, friction and constraints; see [`Problem::hessian_blocks`].
    pub blocks: Vec<Block>,
    /// Second derivative of each tie in the rotation of its hub, N m.
    pub ties: Vec<Matrix>,
}

impl Hessian {
    /// All zero.
    pub fn new(network: &Network) -> Self {
        Self {
            branches: network.branches.iter().map(|b| BranchHessian::new(b.rod.as_ref())).collect(),
            joints: network.joints.iter().map(|j| vec![Matrix::zeros(); j.coupled_frames.len().pow(2)]).collect(),
            blocks: Vec::new(),
            ties: vec![Matrix::zeros(); network.ties.len()],
        }
    }
}

/// A network under conditions: the sum of the terms of its energy, in the variables that constraints leave free.
pub struct Problem<'n> {
    /// The harness.
    pub network: &'n Network,
    /// Monitor of the solver, by which other threads may stop it.
    pub monitor: Monitor,
    conditions: Conditions,
    rods: RodTerm,
    joints: JointTerm,
    constraints: ConstraintTerm,
    sliding: SlidingTerm,
    contact: ContactTerm,
    friction: FrictionTerm,
    loads: LoadTerm,
    prescribed: Prescribed,
    /// Force at each tied point in the last gradient, N, world.
    tie_forces: Vec<Vector>,
    /// Scales of the branches without weight and contact.
    rigidity: Vec<LocalScale>,
    scales: LocalScales,
    /// Sum of the absolute values of the parts of the energy in the last gradient, J.
    magnitude: f64,
}

impl<'n> Problem<'n> {
    /// A network under conditions.
    pub fn new(network: &'n Network, conditions: Conditions) -> Self {
        let mut problem = Self {
            network,
            monitor: Monitor::default(),
            rods: RodTerm::new(network),
            joints: JointTerm::new(network),
            constraints: ConstraintTerm::default(),
            sliding: SlidingTerm::default(),
            contact: ContactTerm::new(network, &conditions),
            friction: FrictionTerm::default(),
            loads: LoadTerm::new(network),
            prescribed: Prescribed::default(),
            conditions,
            tie_forces: vec![Vector::zeros(); network.ties.len()],
            rigidity: rigidity(network),
            scales: LocalScales::default(),
            magnitude: 0.0,
        };
        problem.update_loads();
        problem.sliding.update(System { network, conditions: &problem.conditions });
        problem
    }

    /// The network and its conditions.
    pub fn system(&self) -> System<'_> {
        System { network: self.network, conditions: &self.conditions }
    }

    /// The conditions.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// Changes the conditions; [`Self::set_target`] moves a constraint at less cost.
    pub fn change(&mut self, change: impl FnOnce(&mut Conditions)) {
        change(&mut self.conditions);
        self.update_loads();
        self.sliding.update(System { network: self.network, conditions: &self.conditions });
    }

    fn update_loads(&mut self) {
        let system = System { network: self.network, conditions: &self.conditions };
        self.loads.update(system);
        self.rods.update(system);
        let scales = self.scales();
        self.constraints.penalty_unit = scales.force * scales.length;
    }
}

/// The sum of the terms.
impl Problem<'_> {
    /// Energy by effect, J.
    pub fn energy(&mut self, state: &State) -> Energy {
        let system = System { network: self.network, conditions: &self.conditions };
        let mut energy = Energy::default();
        self.rods.energy(system, state, &mut energy);
        energy.joint = self.joints.energy(system, state);
        energy.load = self.loads.energy(system, state);
        energy.gravity = self.loads.energy_with_weight(state) - energy.load;
        gravity::moving_weights(system, state, |point, force| energy.gravity -= force.dot(&state.points[point]));
        if self.conditions.rotation.is_moving() {
            energy.gravity += gravity::centrifugal_energy(system, state);
        }
        energy.constraint = self.constraints.energy(system, state) + self.contact_energy(state);
        energy
    }

    /// Energy of contact and friction, J.
    fn contact_energy(&mut self, state: &State) -> f64 {
        if self.contact.is_idle() {
            return 0.0;
        }
        let system = System { network: self.network, conditions: &self.conditions };
        self.contact.energy(system, state) + self.friction.energy(&self.contact, system, state)
    }

    /// Forgets what is known of earlier evaluations: the next one is from scratch. It changes no result.
    pub fn forget(&mut self) {
        self.rods.forget();
    }

    /// ∂E/∂x (N), ∂E/∂θ (N m) and ∂E/∂s (N) in the independent variables (tied entries are zero). In the
    /// held variables the gradient is the reaction of the constraint. Returns the energy, J, to which loads without
    /// a potential do not contribute.
    pub fn gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        let network = self.network;
        let system = System { network, conditions: &self.conditions };
        for joint in &network.joints {
            gradient.points[joint.point] = Vector::zeros();
            if let Some(frame) = joint.frame {
                gradient.frames[frame] = Vector::zeros();
            }
        }
        let mut energy = self.rods.gradient(system, state, gradient);
        let mut magnitude = energy;
        self.loads.force_gradient(state, gradient, &mut energy, &mut magnitude);
        gravity::moving_weights(system, state, |point, force| {
            gradient.points[point] -= force;
            let work = force.dot(&state.points[point]);
            energy -= work;
            magnitude += work.abs();
        });
        gravity::centrifugal_gradient(system, state, gradient, &mut energy, &mut magnitude);
        if !network.slides.is_empty() {
            energy += self.sliding.gradient(system, &self.rods, state, gradient);
        }
        self.loads.add_without_potential(state, gradient);
        self.joints.gradient(system, state, gradient, &mut energy);
        if !self.contact.is_idle() {
            let contact = self.contact.gradient(system, state, gradient);
            energy += contact + self.friction.gradient(&self.contact, system, state, gradient);
        }
        for (tie, force) in network.ties.iter().zip(&mut self.tie_forces) {
            *force = gradient.points[tie.point];
        }
        network.pull_back(state, gradient);
        let constraints = self.constraints.gradient(system, state, gradient);
        self.magnitude = magnitude + constraints.abs();
        energy + constraints
    }

    /// Second derivatives at `state`. `forces` (N, body frame; one vector for each branch, one entry for each segment)
    /// replaces the rods' own forces in the geometric stiffness; see [`crate::RodSegment::hessian`]. Call after
    /// [`Self::gradient`] at the same state.
    pub fn hessian(&mut self, state: &State, forces: Option<&[Vec<Vector>]>, hessian: &mut Hessian) {
        let system = System { network: self.network, conditions: &self.conditions };
        self.rods.hessian(system, state, forces, &mut hessian.branches);
        self.joints.hessian(system, state, &mut hessian.joints);
        for ((tie, force), h) in self.network.ties.iter().zip(&self.tie_forces).zip(&mut hessian.ties) {
            if let Some(hub) = tie.hub_frame {
                *h = lever_hessian(&state.frames[hub], force, &tie.offset);
            }
        }
        self.hessian_blocks(state, false, &mut hessian.blocks);
    }

    /// Second derivatives of contact, friction and the constraints at `state`, in the independent variables, both
    /// triangles. With `convex` those of [`Self::make_convex`].
    pub fn hessian_blocks(&mut self, state: &State, convex: bool, blocks: &mut Vec<Block>) {
        blocks.clear();
        let system = System { network: self.network, conditions: &self.conditions };
        if !self.contact.is_idle() {
            self.contact.hessian(system, state, convex, blocks);
            self.friction.hessian(&self.contact, system, state, convex, blocks);
        }
        if !convex {
            gravity::centrifugal_blocks(system, state, blocks);
        }
        let convex = convex.then(|| {
            let scales = Scales::of(system);
            Convex { stiffness: scales.force / scales.length }
        });
        self.constraints.hessian(system, state, convex, blocks);
    }

    /// Replaces the second derivatives of constraints and contact by those of a convex model: negative eigenvalues of
    /// the second derivatives of potentials, and of μ c″ of equations, change their sign (Dauphin and others 2014),
    /// and every station gets a small translational stiffness. `hessian` is that of `state`. Returns whether the blocks
    /// changed. If a matrix is not positive definite because of a constraint (a compressed strut, a penalty far from
    /// its equation, a component connected by a constraint alone), no shift of the rotational blocks makes it so.
    pub fn make_convex(&mut self, state: &State, hessian: &mut Hessian) -> bool {
        if hessian.blocks.is_empty() {
            return false;
        }
        let exact = std::mem::take(&mut hessian.blocks);
        self.hessian_blocks(state, true, &mut hessian.blocks);
        exact != hessian.blocks
    }

    /// Second derivatives of the energy at `state` in the edges of a branch, N/m; see
    /// [`crate::RodSegment::edge_stiffness`].
    pub fn edge_stiffness(&self, state: &State, branch: usize, stiffness: &mut [Matrix]) {
        self.rods.edge_stiffness(self.system(), state, branch, stiffness);
    }
}

/// Prescribed directions and retraction.
impl Problem<'_> {
    /// Held variables, as found by [`Self::update_held`].
    pub fn held(&self) -> &[Held] {
        self.prescribed.held()
    }

    /// Finds the held directions at `state`, and the scales of residuals. Allocates only if there are more of them than
    /// ever before.
    pub fn update_held(&mut self, state: &State) {
        let system = System { network: self.network, conditions: &self.conditions };
        self.prescribed.update(system, state);
        self.contact.update_held(system);
        self.sliding.update_travel(self.network, state);
        self.update_local_scales();
    }

    /// See [`Prescribed::place`].
    pub fn place_held(&self, state: &mut State) {
        self.prescribed.place(self.system(), state);
    }

    /// See [`Prescribed::motion`].
    pub fn motion(&self, state: &State, motion: &mut Tangent) -> bool {
        self.prescribed.motion(self.system(), state, motion)
    }

    /// Removes the held directions from a gradient: the free part, which vanishes at an equilibrium.
    pub fn free_part(&self, gradient: &mut Tangent) {
        self.prescribed.project(gradient);
        self.sliding.project(self.system(), gradient);
    }

    /// `to = from ⊕ α step`: [`Network::retract`], and the mesh moves along the cable where constraints slide.
    pub fn retract(&self, from: &State, step: &Tangent, alpha: f64, to: &mut State) {
        self.sliding.retract(self.system(), from, step, alpha, to);
    }
}

/// Rest curvature and loads.
impl Problem<'_> {
    /// Curvature added to the rest curvature, indexed by the first frame of each coupling, 1/m; empty: none.
    pub fn extra_curvature(&self) -> &[Vector] {
        self.rods.extra_curvature()
    }

    /// See [`RodTerm::hold_drawn_shape`].
    pub fn hold_drawn_shape(&mut self, state: &State) {
        self.rods.hold_drawn_shape(System { network: self.network, conditions: &self.conditions }, state);
    }

    /// See [`RodTerm::set_drawn_fraction`].
    pub fn set_drawn_fraction(&mut self, fraction: f64) {
        self.rods.set_drawn_fraction(System { network: self.network, conditions: &self.conditions }, fraction);
    }

    /// See [`LoadTerm::forces`].
    pub fn dead_forces(&self) -> &[Vector] {
        self.loads.forces()
    }

    /// Whether all loads that act have a potential.
    pub fn has_potential(&self) -> bool {
        self.loads.has_potential()
    }

    /// See [`LoadTerm::tangents`].
    pub fn load_tangents(&self, state: &State) -> Vec<LoadTangent> {
        self.loads.tangents(state)
    }

    /// See [`LoadTerm::segment_tangents`].
    pub fn segment_tangents(&self, state: &State) -> Vec<SegmentTangent> {
        self.loads.segment_tangents(state)
    }

    /// Weight, centrifugal force and loads along a segment per unstressed length, N/m, world axes.
    pub fn force_per_length(&self, state: &State, branch: usize, segment: usize) -> Vector {
        let own = &self.network.branches[branch];
        let mut acceleration = self.conditions.gravity;
        let rotation = &self.conditions.rotation;
        if rotation.is_moving() {
            let points = &state.points[own.points.start + segment..][..2];
            acceleration += rotation.pull(&((points[0] + points[1]) * 0.5));
        }
        acceleration * own.sections.of(segment).linear_density
            + loads::along_segment(self.system(), state, branch, segment)
    }

    /// Sets the active fraction of the loads without a potential, 0 to 1: the initial equilibrium is found without
    /// them.
    pub fn set_fraction_without_potential(&mut self, fraction: f64) {
        self.loads.set_fraction(fraction);
        self.update_loads();
    }

    /// Work over a step of the loads without a potential, J, to first order.
    pub fn work_without_potential(&self, state: &State, step: &Tangent, alpha: f64) -> f64 {
        self.loads.work_without_potential(state, step, alpha)
    }
}

/// Constraints.
impl Problem<'_> {
    /// Starts a constraint at `state`: its target is the pose of its first station, and its memory is the initial one.
    pub fn begin_constraint(&mut self, c: usize, state: &State) {
        let constraint = &self.network.constraints[c];
        let own = ConstraintState::begin(constraint, state);
        self.conditions.targets[c] = constraint.model.target(&own.base, own.progress);
        self.conditions.constraints[c] = own;
    }

    /// Moves the target of a constraint; see [`ConstraintState::base`].
    pub fn set_target(&mut self, c: usize, base: Pose) {
        let own = &mut self.conditions.constraints[c];
        own.base = base;
        self.conditions.targets[c] = self.network.constraints[c].model.target(&base, own.progress);
    }

    /// Sets the values of the joints of a mechanism. What is mounted on its bodies is moved by [`Self::set_target`] and
    /// [`Self::set_obstacle`].
    pub fn set_mechanism(&mut self, mechanism: usize, values: Vec<f64>) {
        self.conditions.mechanisms[mechanism] = values;
    }

    /// Sets the progress of a constraint through the step in which it began to act, 0 to 1.
    pub fn set_progress(&mut self, c: usize, progress: f64) {
        let own = &mut self.conditions.constraints[c];
        own.progress = progress;
        self.conditions.targets[c] = self.network.constraints[c].model.target(&own.base, progress);
    }

    /// Reaction of a constraint on the harness at `state`, at all its stations and along its span; see
    /// [`Self::reaction`].
    pub fn reactions(&self, c: usize, state: &State, gradient: &Tangent) -> Reaction {
        match self.network.constraints[c].model.action() {
            Action::Prescribed(_) => {
                let station = self.prescribed.reaction(self.system(), c, state, gradient);
                Reaction { stations: vec![station], span: vec![] }
            }
            _ => self.constraints.reaction(self.system(), c, state),
        }
    }

    /// Names and values (SI) of the outputs of a constraint that acts, with the tensions beside its stations (N).
    pub fn outputs(&self, c: usize, state: &State, tensions: Vec<[f64; 2]>) -> Vec<(String, f64)> {
        self.constraints.outputs(self.system(), c, state, tensions)
    }

    /// Force (N) and moment about the held point (N m), world axes, of a constraint on the harness at its first
    /// station; without stations the resultant force on its span. `gradient` is the whole gradient at `state`; the held
    /// directions must be up to date ([`Self::update_held`]).
    pub fn reaction(&self, c: usize, state: &State, gradient: &Tangent) -> (Vector, Vector) {
        let reaction = self.reactions(c, state, gradient);
        reaction.stations.first().copied().unwrap_or_else(|| (reaction.span.iter().sum(), Vector::zeros()))
    }

    /// All equations and inequalities of the constraints that act, evaluated at `state`.
    pub fn constraint_residuals(&self, state: &State) -> Vec<ConstraintResidual> {
        self.constraints.residuals(self.system(), state)
    }

    /// The residual with the largest violation at `state`, among the constraints that act; `None` where there are no
    /// residuals.
    pub fn worst_residual(&self, state: &State) -> Option<ConstraintResidual> {
        let mut worst: Option<ConstraintResidual> = None;
        for residual in self.constraint_residuals(state) {
            // NaN counts as the largest.
            if worst.is_none_or(|worst| residual.violation > worst.violation || residual.violation.is_nan()) {
                worst = Some(residual);
            }
        }
        worst
    }

    /// Sets multiplier and penalty of a residual.
    pub fn set_multiplier(&mut self, residual: &ConstraintResidual, multiplier: f64, penalty: f64) {
        let own = &mut self.conditions.constraints[residual.constraint];
        own.multipliers[residual.residual] = multiplier;
        own.penalties[residual.residual] = penalty;
    }

    /// Copies multipliers and penalties of constraints from other conditions.
    pub fn set_multipliers(&mut self, other: &Conditions) {
        for (own, other) in self.conditions.constraints.iter_mut().zip(&other.constraints) {
            own.multipliers.clone_from(&other.multipliers);
            own.penalties.clone_from(&other.penalties);
        }
    }

    /// Shape of one branch with its memory, as the energy sees it.
    pub fn shape<'s>(&'s self, state: &'s State, branch: usize) -> BranchShape<'s> {
        self.rods.shape(self.system(), state, branch)
    }

    /// Updates the memories of rods and joints at the equilibrium that ends an increment, before its result is made: so
    /// the result follows from the memory that is kept, as it does in a resumed run.
    pub fn commit_rods_and_joints(&mut self, state: &State) {
        for (b, memory, dissipated) in self.rods.memories(self.system(), state) {
            let total = self.conditions.rods[b].dissipated[1] + dissipated;
            self.conditions.rods[b] = RodState { memory, dissipated: [dissipated, total] };
        }
        let system = System { network: self.network, conditions: &self.conditions };
        for (j, own) in self.joints.memories(system, state) {
            self.conditions.joints[j] = own;
        }
        self.conditions.committed_time = self.conditions.time;
    }

    /// What rods and joints have dissipated in an increment that began with these conditions, where their memories were
    /// updated within it, too.
    pub fn sum_dissipated(&mut self, began: &Conditions) {
        let sum = |own: &mut [f64; 2], began: &[f64; 2]| {
            let ([last, total], before) = (*own, began[1]);
            // Nothing but `last` may have been added.
            if before + last != total {
                *own = [total - before, before + (total - before)];
            }
        };
        for (own, began) in self.conditions.rods.iter_mut().zip(&began.rods) {
            sum(&mut own.dissipated, &began.dissipated);
        }
        for (own, began) in self.conditions.joints.iter_mut().zip(&began.joints) {
            own.dissipated.iter_mut().zip(&began.dissipated).for_each(|(own, began)| sum(own, began));
        }
    }

    /// Updates friction anchors and the memories of all constraints that act, at the equilibrium that ends an
    /// increment, with the tensions beside the stations of each constraint (N).
    pub fn commit(&mut self, state: &State, tensions: impl Fn(&AttachedConstraint) -> Vec<[f64; 2]>) {
        self.commit_contacts(state);
        for (c, memory) in self.constraints.memories(self.system(), state, tensions) {
            self.conditions.constraints[c].memory = memory;
        }
    }

    /// First part (family, index) at fault, and the message: the part reports it, or its memory is not finite.
    pub fn part_at_fault(&self) -> Option<(PartFamily, usize, String)> {
        let not_finite = |memory: &[f64]| {
            let lost = memory.iter().any(|x| !x.is_finite());
            lost.then(|| "what it remembers is not a finite number".to_owned())
        };
        for (b, branch) in self.network.branches.iter().enumerate() {
            let fault = branch.rod.constitutive().and_then(ConstitutiveLaws::fault);
            if let Some(message) = fault.or_else(|| not_finite(&self.conditions.rods[b].memory)) {
                return Some((PartFamily::Rod, b, message));
            }
        }
        for (j, joint) in self.network.joints.iter().enumerate() {
            if let Some(message) = joint.model.fault().or_else(|| not_finite(&self.conditions.joints[j].memory)) {
                return Some((PartFamily::Joint, j, message));
            }
        }
        for (c, constraint) in self.system().acting() {
            let own = &self.conditions.constraints[c];
            if let Some(message) = constraint.model.fault().or_else(|| not_finite(&own.memory)) {
                return Some((PartFamily::Constraint, c, message));
            }
        }
        None
    }

    /// [`Self::part_at_fault`]; with `lost` also a constraint that has returned a non-finite number since the last
    /// call.
    pub fn fault(&mut self, lost: bool) -> Option<(PartFamily, usize, String)> {
        let lost = self.constraints.non_finite.take().filter(|_| lost);
        if let Some(found) = self.part_at_fault() {
            return Some(found);
        }
        let c = lost?;
        Some((PartFamily::Constraint, c, "it gave a number that is not finite for a harness that is".to_owned()))
    }

    /// First part (family, index) whose first derivatives at `state` contradict its values, or second ones its first,
    /// and the message.
    pub fn contradiction(&mut self, state: &State) -> Option<(PartFamily, usize, String)> {
        let system = System { network: self.network, conditions: &self.conditions };
        let rod = self.rods.contradiction(system, state).map(|(b, which, found)| (PartFamily::Rod, b, which, found));
        let rod_or_joint = rod.or_else(|| {
            let (j, which, found) = self.joints.contradiction(system, state)?;
            Some((PartFamily::Joint, j, which, found))
        });
        let found = rod_or_joint.or_else(|| {
            let (c, which, found) = self.constraints.contradiction(system, state)?;
            Some((PartFamily::Constraint, c, which, found))
        });
        found.map(|(family, index, which, Contradiction { claimed, found })| {
            let (derivatives, values) = match which {
                Derivatives::First => ("first derivatives", "values"),
                Derivatives::Second => ("second derivatives", "first derivatives"),
            };
            let message = format!(
                "its {derivatives} are not those of its {values}: along one line they give a slope of {claimed:.6e}, \
                 differences of its {values} {found:.6e}"
            );
            (family, index, message)
        })
    }
}

/// Sliding constraints.
impl Problem<'_> {
    /// The term of sliding.
    pub fn sliding(&self) -> &SlidingTerm {
        &self.sliding
    }

    /// Sets the state of a sliding constraint (index in [`Network::slides`]).
    pub fn set_sliding(&mut self, slide: usize, sliding: Sliding) {
        self.conditions.sliding[slide] = sliding;
    }

    /// Whether any sliding constraint acts.
    pub fn has_slides(&self) -> bool {
        !self.sliding.is_idle()
    }

    /// See [`SlidingTerm::stop`].
    pub fn slide_stop(&self, slide: usize, gradient: &Tangent) -> Option<SlideStop> {
        self.sliding.stop(self.system(), slide, gradient)
    }

    /// See [`SlidingTerm::slips`].
    pub fn slips(&self, slide: usize) -> bool {
        self.sliding.slips(self.system(), slide)
    }

    /// See [`SlidingTerm::slips_backward`].
    pub fn slips_backward(&self, slide: usize, before: &State, state: &State) -> bool {
        self.sliding.slips_backward(self.system(), slide, before, state)
    }

    /// See [`SlidingTerm::result`].
    pub fn slide_result(&self, slide: usize, state: &State, gradient: &Tangent) -> SlideResult {
        self.sliding.result(self.system(), slide, state, gradient)
    }

    /// See [`SlidingTerm::largest_fraction`].
    pub fn largest_slide_fraction(&self, state: &State, step: &Tangent) -> f64 {
        self.sliding.largest_fraction(self.system(), state, step)
    }

    /// See [`SlidingTerm::hessian`].
    pub fn slide_hessian(&mut self, state: &State, gradient: &Tangent, hessian: &mut SlideHessian) {
        let system = System { network: self.network, conditions: &self.conditions };
        self.sliding.hessian(system, &self.rods, state, gradient, hessian);
    }

    /// Force of a sliding constraint across the cable, N: the normal force of its friction.
    pub fn slide_pressure(&self, slide: usize, state: &State, gradient: &Tangent) -> f64 {
        let c = self.network.slides[slide].constraint;
        let (force, _) = self.reaction(c, state, gradient);
        let tangent = columns(&state.pose(&self.network.constraints[c].site).orientation)[2];
        (force - tangent * tangent.dot(&force)).norm()
    }
}

/// Contact and friction.
impl Problem<'_> {
    /// The term of contact.
    pub fn contact(&self) -> &ContactTerm {
        &self.contact
    }

    /// Sets whether cables touch obstacles.
    pub fn set_obstacles_act(&mut self, act: bool) {
        self.contact.set_obstacles_act(act);
    }

    /// Evaluates contact and friction at `state`.
    pub fn find_contacts(&mut self, state: &State) {
        self.contact_energy(state);
    }

    /// See [`ContactTerm::violation`].
    pub fn contact_violation(&mut self, state: &State) -> Option<f64> {
        let system = System { network: self.network, conditions: &self.conditions };
        self.contact.violation(system, state)
    }

    /// See [`ContactTerm::worst_violation`].
    pub fn worst_contact(&mut self, state: &State) -> Option<ContactViolation> {
        let system = System { network: self.network, conditions: &self.conditions };
        self.contact.worst_violation(system, state)
    }

    /// Friction anchor of a contact at `state`, given the records so far; `None` where the partner is smooth.
    pub fn friction_anchor(&self, state: &State, contact: &Contact) -> Option<FrictionAnchor> {
        Anchoring { contact: &self.contact, system: self.system(), state }.anchor(contact)
    }

    /// Replaces the contact records, sorted by contact point and partner.
    pub fn set_contact_records(&mut self, records: Vec<ContactRecord>) {
        self.conditions.contact.records = records;
    }

    /// Takes x″ of the centre lines, by which cables are beside their chords where they touch, from `state`.
    pub fn update_bends(&mut self, state: &State) {
        self.conditions.contact.bends = ContactTerm::bends(self.system(), state);
    }

    /// Finds the segments that cross at `state`, at which contact was evaluated last.
    pub fn update_crossings(&mut self, state: &State) {
        self.conditions.contact.crossings = self.contact.crossings(self.system(), state);
    }

    /// Adds contact points where the penetration at `state` between two of them exceeds the tolerance. Returns whether
    /// any were added.
    pub fn refine_contact_points(&mut self, state: &State) -> bool {
        let system = System { network: self.network, conditions: &self.conditions };
        let mut deeper = self.contact.deeper_places(system, state);
        let followed = self.contact.followed(system, state);
        if followed.is_some() {
            // What is deeper than a place far from its contact point may be nearer than that place once it has moved.
            deeper.retain(|point| point.follows.is_none());
        }
        if deeper.is_empty() && followed.is_none() {
            return false;
        }
        if let Some(followed) = followed {
            self.conditions.contact.extra = followed;
        }
        self.conditions.contact.extra.extend(deeper);
        self.update_crossings(state);
        self.contact.set_extra(&self.conditions.contact.extra);
        true
    }

    /// Updates the friction anchors, and removes added contact points and crossings that are no longer needed.
    pub fn commit_contacts(&mut self, state: &State) {
        if self.contact.is_idle() {
            return;
        }
        self.find_contacts(state);
        let near = self.contact.near_segments();
        self.conditions.contact.crossings.retain(|own| own.acts && near.contains(&own.segments));
        let anchoring = Anchoring { contact: &self.contact, system: self.system(), state };
        let followed = |record: &ContactRecord| ContactRecord {
            anchor: record.anchor.map(|anchor| anchoring.follow(record, &anchor)),
            ..*record
        };
        let mut records: Vec<ContactRecord> = self.conditions.contact.records.iter().map(followed).collect();
        // Raised penalties are kept only where there is a force.
        let own = self.contact.own_points();
        let needed = |k: usize| records.iter().any(|record| record.point as usize == own + k);
        let kept: Vec<usize> = (0..self.conditions.contact.extra.len()).filter(|&k| needed(k)).collect();
        if kept.len() < self.conditions.contact.extra.len() {
            for record in &mut records {
                if let Some(k) = (record.point as usize).checked_sub(own) {
                    let place = kept.iter().position(|&old| old == k).expect("contact points of records are kept");
                    record.point = (own + place) as u32;
                }
            }
            let extra: Vec<ContactPoint> = kept.iter().map(|&k| self.conditions.contact.extra[k]).collect();
            self.contact.set_extra(&extra);
            self.conditions.contact.extra = extra;
        }
        self.conditions.contact.records = records;
        let system = System { network: self.network, conditions: &self.conditions };
        self.conditions.contact.overlaps = self.contact.remaining_overlaps(system, state);
    }

    /// Copies records, added contact points, arcs, permitted overlaps and whether friction acts from other conditions,
    /// but not the poses of obstacles.
    pub fn set_contacts(&mut self, other: &Conditions) {
        self.conditions.contact.friction = other.contact.friction;
        self.conditions.contact.records.clone_from(&other.contact.records);
        // The records may couple segments that are not coupled now.
        if self.conditions.contact.bound_cables().next().is_some() {
            self.contact.search_pairs_again();
        }
        self.conditions.contact.overlaps.clone_from(&other.contact.overlaps);
        self.conditions.contact.bends.clone_from(&other.contact.bends);
        self.conditions.contact.crossings.clone_from(&other.contact.crossings);
        if self.conditions.contact.extra != other.contact.extra {
            self.conditions.contact.extra.clone_from(&other.contact.extra);
            self.contact.set_extra(&other.contact.extra);
        }
    }

    /// Permits the overlaps of cables at `state`.
    pub fn allow_overlaps(&mut self, state: &State) {
        let system = System { network: self.network, conditions: &self.conditions };
        self.conditions.contact.overlaps = self.contact.overlaps(system, state);
    }

    /// See [`ContactTerm::held_overlaps`].
    pub fn held_overlaps(&self) -> &[HeldOverlap] {
        self.contact.held_overlaps()
    }

    /// Enables friction.
    pub fn enable_friction(&mut self) {
        self.conditions.contact.friction = true;
    }

    /// Moves an obstacle.
    pub fn set_obstacle(&mut self, obstacle: usize, pose: Pose) {
        if self.conditions.contact.poses[obstacle] != pose {
            self.conditions.contact.poses[obstacle] = pose;
            self.contact.search_again();
        }
    }

    /// Discards what the search for contacts knows of earlier states: where large multipliers act across gaps, it
    /// depends on the way to the present state.
    pub fn search_contacts_again(&mut self) {
        self.contact.search_again();
        self.contact.search_pairs_again();
    }

    /// See [`ContactTerm::pattern`].
    pub fn contact_pattern(&self) -> (u64, &[Vec<Variable>]) {
        self.contact.pattern()
    }

    /// See [`ContactTerm::deepest_penetration`].
    pub fn deepest_penetration(&mut self, state: &State) -> Option<Penetration> {
        let system = System { network: self.network, conditions: &self.conditions };
        self.contact.deepest_penetration(system, state)
    }

    /// See [`ContactTerm::collision_free_fraction`].
    pub fn collision_free_fraction(&mut self, from: &State, to: &State, poses: Option<&[Pose]>) -> f64 {
        let system = System { network: self.network, conditions: &self.conditions };
        self.contact.collision_free_fraction(system, from, to, poses)
    }

    /// Evaluates contact at `state`; see [`ContactTerm::touching_points`].
    pub fn touching_points(&mut self, state: &State) -> Vec<bool> {
        self.find_contacts(state);
        self.contact.touching_points(self.system())
    }

    /// Load of every obstacle on the harness at `state`.
    pub fn obstacle_loads(&mut self, state: &State) -> Vec<ObstacleLoad> {
        self.find_contacts(state);
        self.contact.obstacle_loads(self.system(), |contact| self.friction.force_on(contact))
    }

    /// Sums of the sizes of contact forces; see [`ContactTerm::forces_by_branch`].
    pub fn contact_forces(&mut self, state: &State) -> BTreeMap<(usize, Against), f64> {
        self.find_contacts(state);
        self.contact.forces_by_branch(|contact| self.friction.force_on(contact))
    }
}

/// Scales of residuals.
impl Problem<'_> {
    /// Scales of the whole harness.
    pub fn scales(&self) -> Scales {
        Scales::of(self.system())
    }

    fn update_local_scales(&mut self) {
        let contact = &self.contact;
        let pushes = self.conditions.contact.records.iter().flat_map(|record| {
            let own = contact.branch_of(record);
            [Some(own), record.partner.branch()].into_iter().flatten().map(|b| (b, record.multiplier))
        });
        let gravity = self.conditions.gravity.norm();
        self.scales.find(self.network, &self.rigidity, gravity, pushes, self.loads.moments());
    }

    /// Least scales of any part; see [`LocalScales::least`].
    pub fn least_scales(&self) -> Scales {
        self.scales.least()
    }

    /// Scale of each branch, as found by [`Self::update_held`].
    pub fn local_scales(&self) -> &[LocalScale] {
        &self.scales.branches
    }

    /// See [`LocalScales::residual`]; `free` is a gradient without its held part ([`Self::free_part`]).
    pub fn residual(&self, free: &Tangent) -> f64 {
        self.scales.residual(self.network, free)
    }

    /// See [`LocalScales::whole_residual`].
    pub fn whole_residual(&self, free: &Tangent) -> f64 {
        self.scales.whole_residual(self.network, free)
    }

    /// Round-off of a change of the energy (J), at the state of the whole `gradient` evaluated last: a fraction of the
    /// sum of the parts of the energy plus the largest product of a reaction or contact force with the length of the
    /// harness, through which it is transmitted.
    pub fn energy_noise(&self, gradient: &Tangent) -> f64 {
        let length = self.rigidity.iter().map(|scale| scale.length).fold(0.0, f64::max);
        let reactions = self.held().iter().map(|held| match held.variable {
            Variable::Point(i) => gradient.points[i].norm() * length,
            Variable::Frame(c) => gradient.frames[c].norm(),
        });
        let pushes = self.conditions.contact.records.iter().map(|record| record.multiplier * length);
        ENERGY_NOISE * (self.magnitude + reactions.chain(pushes).fold(0.0, f64::max))
    }
}
