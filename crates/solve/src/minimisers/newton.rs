//! Minimiser `newton`: Newton's method with the full Hessian.
//!
//! Per iteration: second derivatives, factorisation along the graph, step, and a line search in which the points follow
//! the frames ([`super::condensation`]).
//!
//! - If the Hessian is not positive definite, the diagonal of the frames is shifted until it is (Levenberg), so that
//!   every step leads downhill from any start. A step with the shift σ W is an implicit step, of length 1, of the
//!   overdamped motion `σ W θ̇ = −∂E/∂θ` with the points in equilibrium (pseudo-transient continuation:
//!   Kelley and Keyes 1998): so a harness that has lost its equilibrium moves as in a viscous fluid, in steps as long
//!   as the descent allows.
//! - The first step of an increment contains the prescribed motion in its right-hand side.
//! - Contacts that close or open along a step are part of its model ([`ActiveSet`]).
//! - After whole steps (small ones only, where `restoration` is not possible) the axial and shear forces in the
//!   geometric stiffness are those predicted by the last linear step (mixed integration points: Magisano, Leonetti,
//!   Garcea 2017).
//! - A prescribed motion can compress segments far beyond what bending carries. A step from there leaves the forces out
//!   of the geometric stiffness: it relaxes the compression.
//! - Steps that would only stretch the cable are followed by a restoration of lengths (`restoration`).
//! - Under loads without a potential steps are those of the residual (`residual_step`), downhill only if those fail.

mod residual_step;
mod restoration;

use super::step_control::{
    ACTIVE_SET_UPDATES, FIRST_SHIFT, LARGEST_TURN, RAISE, SMALL_TURN, condensed_force, in_pool, raised,
};
use super::trace::trace;
use crate::contact::active_set::ActiveSet;
use crate::linear::assembly::System;
use crate::linear::border::Border;
use crate::linear::without_potential::WithoutPotential;
use crate::minimisers::condensation::Condensation;
use crate::minimisers::convergence::{ConvergenceMonitor, PROGRESS, Termination};
use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::registry::MinimiserKind;
use wireloom_core::status::Status;
use wireloom_core::{State, Tangent, Vector};

/// Factor by which the shift is lowered after a successful step.
const LOWER: f64 = 0.1;
/// Shift far above what bending needs: a matrix that is not positive definite with it has compressed segments.
const COMPRESSED: f64 = 10.0;
/// Least shift of a step that relaxes compressed segments: without one it would follow soft directions far.
const RELAXING: f64 = 1.0;
/// Shift above which the minimiser fails if no step lowers the energy.
const LARGEST_SHIFT: f64 = 1e6;
/// Factor by which the shift is raised after a failed line search.
const RAISE_AFTER_FAILURE: f64 = 16.0;
/// Step length below which the shift is raised by [`RAISE_AFTER_SHORT_STEP`]: the model was inaccurate.
const SHORT_STEP: f64 = 0.25;
/// See [`SHORT_STEP`].
const RAISE_AFTER_SHORT_STEP: f64 = 4.0;
/// Least shift, in units of the negative curvature along the step before. A step with the shift σ makes a direction of
/// curvature −μ grow by `σ/(σ − μ)`: below μ the matrix is not positive definite, just above it the step is cut.
const ABOVE_NEGATIVE: f64 = 3.0;
/// Shift below which it becomes zero.
const NO_SHIFT: f64 = 0.1 * FIRST_SHIFT;
/// Limits of the factor by which the line search shortens a step to the minimum of the parabola.
const SHORTENING: [f64; 2] = [0.1, 0.5];
/// Factor by which it shortens a step if the parabola is not finite.
const BACKTRACK: f64 = 0.25;
/// Step length below which the line search has failed: round-off of the state dominates.
const SHORTEST_STEP: f64 = 1e-10;
/// Least decrease of the energy, as a fraction of the linear one (Armijo).
const ARMIJO: f64 = 1e-4;
/// A step with the factor of the step before, in which the harness turned by θ (rad), leaves θ times the residual, or
/// this many times as much at worst.
const KEPT: f64 = 100.0;
/// Number of iterations without progress at round-off after which the minimiser has stalled.
const STALLED_AFTER: usize = 4;
/// Number of step lengths, each half of the one before, of which the first step of an increment takes the one of least
/// energy.
const PREDICTION_TRIALS: usize = 4;

/// The kind `newton`.
pub fn kind() -> MinimiserKind {
    MinimiserKind {
        name: "newton".into(),
        doc: "Newton on the full Hessian with a direct factorisation along the graph; descends from any start".into(),
        parameters: vec![],
        build: Box::new(|(), _| Ok(Box::new(Newton::new()))),
    }
}

/// Newton's method, with its workspace.
#[derive(Default)]
pub struct Newton {
    workspace: Option<Box<Workspace>>,
}

impl Newton {
    /// Minimiser without a workspace; the first call allocates it.
    pub fn new() -> Self {
        Self::default()
    }
}

/// Data that is allocated once per network.
struct Workspace {
    network: u64,
    system: System,
    condensation: Condensation,
    border: Border,
    without: WithoutPotential,
    active_set: ActiveSet,
    hessian: Hessian,
    gradient: Tangent,
    /// Gradient of the model with the active set of contact ([`ActiveSet`]).
    model: Tangent,
    free: Tangent,
    trial_gradient: Tangent,
    step: Tangent,
    motion: Tangent,
    trial: State,
    /// The state that `restoration` steps from, and the step and the gradient that it puts back.
    restored: Option<Box<State>>,
    whole_step: Tangent,
    first_gradient: Tangent,
    /// Predicted forces, by branch and segment.
    forces: Vec<Vec<Vector>>,
    /// Constraints that were active when the matrix was factorised, if the factor is unshifted and positive definite.
    factor_of: Option<Vec<bool>>,
    /// Force (N) below which a point counts as condensed.
    condensed_force: f64,
    factorisations: usize,
    evaluations: usize,
    /// Whether the second derivatives were positive definite wherever they were evaluated.
    convex: bool,
}

impl Workspace {
    /// `None` if a stop was requested: finding the patterns of a large harness takes a while.
    fn new(problem: &Problem<'_>) -> Option<Self> {
        let network = problem.network;
        let system = System::new(problem);
        if problem.monitor.is_stopped() {
            return None;
        }
        let condensation = Condensation::new(problem);
        Some(Self {
            network: network.id,
            system,
            condensation,
            hessian: Hessian::new(network),
            gradient: Tangent::zeros(network),
            model: Tangent::zeros(network),
            active_set: ActiveSet::new(network),
            free: Tangent::zeros(network),
            trial_gradient: Tangent::zeros(network),
            step: Tangent::zeros(network),
            motion: Tangent::zeros(network),
            trial: State::origin(network),
            restored: Some(Box::new(State::origin(network))),
            whole_step: Tangent::zeros(network),
            first_gradient: Tangent::zeros(network),
            forces: network.branches.iter().map(|b| vec![Vector::zeros(); b.rod.mesh().segments()]).collect(),
            border: Border::default(),
            without: WithoutPotential::default(),
            factor_of: None,
            condensed_force: 0.0,
            factorisations: 0,
            evaluations: 0,
            convex: true,
        })
    }

    /// Workspace for a problem; `None` as for [`Self::new`].
    fn ready<'w>(slot: &'w mut Option<Box<Self>>, problem: &Problem<'_>) -> Option<&'w mut Self> {
        if problem.monitor.is_stopped() {
            return None;
        }
        if slot.as_ref().is_none_or(|ws| ws.network != problem.network.id) {
            *slot = Self::new(problem).map(Box::new);
        }
        slot.as_deref_mut()
    }

    /// Evaluates and factorises the second derivatives at `state` (where `gradient` was evaluated last), with the first
    /// shift from `sigma` on that makes them positive definite. Before the first shift constraints are made convex, and
    /// where even the shift [`COMPRESSED`] would not do, the geometric stiffness is left out: the step relaxes the
    /// compression. Returns the shift.
    fn assemble(&mut self, problem: &mut Problem<'_>, state: &State, mixed: bool, mut sigma: f64) -> f64 {
        problem.hessian(state, mixed.then_some(self.forces.as_slice()), &mut self.hessian);
        let (mut judged, mut convex) = (!Self::restores(problem), false);
        while !self.factorise(problem, state, sigma) && sigma.is_finite() && !problem.monitor.is_stopped() {
            self.convex = false;
            let first = !std::mem::replace(&mut judged, true);
            if first && (sigma >= COMPRESSED || !self.factorise(problem, state, COMPRESSED)) {
                self.forces.iter_mut().flatten().for_each(|force| *force = Vector::zeros());
                problem.hessian(state, Some(self.forces.as_slice()), &mut self.hessian);
                sigma = sigma.max(RELAXING);
                continue;
            }
            if std::mem::replace(&mut convex, true) || !problem.make_convex(state, &mut self.hessian) {
                sigma = raised(sigma, RAISE);
            }
        }
        sigma
    }

    /// Assembles and factorises the present Hessian with a shift. Returns whether it is positive definite; otherwise
    /// there is a factor only under loads without a potential.
    fn factorise(&mut self, problem: &Problem<'_>, state: &State, sigma: f64) -> bool {
        self.system.fill(problem, state, &self.hessian);
        let System { matrix, weights, .. } = &mut self.system;
        if sigma > 0.0 {
            matrix.shift(sigma, weights);
        }
        matrix.eliminate_prescribed(problem);
        self.factorisations += 1;
        let positive = if problem.has_potential() { matrix.factorise_if_positive() } else { matrix.factorise() == 0 };
        if positive && sigma == 0.0 {
            let active = &problem.conditions().active;
            match &mut self.factor_of {
                Some(known) if known.len() == active.len() => known.copy_from_slice(active),
                slot => *slot = Some(active.clone()),
            }
        } else {
            self.factor_of = None;
        }
        positive
    }

    /// Solves for the step at `state`, with the active set of contact; with `moving` it contains the prescribed motion.
    /// `sigma` is the shift that the matrix was assembled with at `state`; `None` if the matrix is that of an earlier
    /// state.
    fn solve(&mut self, problem: &mut Problem<'_>, state: &State, moving: bool, mut sigma: Option<f64>) {
        self.begin_active_set(problem);
        self.solve_once(problem, state, moving);
        if self.active_set.is_idle() {
            return;
        }
        for left in (0..ACTIVE_SET_UPDATES).rev() {
            let Self { active_set, gradient, step, model, hessian, .. } = self;
            let from = (!moving).then_some(&*gradient);
            let changed = active_set.update(problem, state, from, step, model, &mut hessian.blocks);
            if !changed || left == 0 || problem.monitor.is_stopped() {
                return;
            }
            match sigma {
                Some(sigma) => {
                    if !self.factorise(problem, state, sigma) && problem.has_potential() {
                        return;
                    }
                }
                None => {
                    sigma = Some(self.assemble(problem, state, false, 0.0));
                    self.begin_active_set(problem);
                }
            }
            self.solve_once(problem, state, moving);
        }
    }

    fn begin_active_set(&mut self, problem: &Problem<'_>) {
        self.active_set.begin(problem);
        if !self.active_set.is_idle() {
            self.model.copy_from(&self.gradient);
        }
    }

    /// Solves for the step with the present matrix and the gradient of the model.
    fn solve_once(&mut self, problem: &mut Problem<'_>, state: &State, moving: bool) {
        let motion = moving.then_some(&self.motion);
        let Self { system, border, without, active_set, gradient, model, step, .. } = self;
        let forces = if active_set.is_idle() { gradient } else { model };
        border.step(system, problem, state, forces, motion, step);
        if !problem.has_potential() {
            without.prepare(system, border, problem, state);
            without.complete(system, border, problem, state, step);
        }
    }

    /// Largest step length of the line search.
    fn longest(&self, problem: &Problem<'_>, state: &State) -> f64 {
        let turn = self.largest_turn();
        let fraction: f64 = if turn > LARGEST_TURN { LARGEST_TURN / turn } else { 1.0 };
        fraction.min(problem.largest_slide_fraction(state, &self.step))
    }

    /// Energy and gradient at `state ⊕ α step` with the points condensed, in `trial` and `trial_gradient`.
    fn try_step(&mut self, problem: &mut Problem<'_>, state: &State, alpha: f64) -> f64 {
        problem.retract(state, &self.step, alpha, &mut self.trial);
        problem.place_held(&mut self.trial);
        if problem.collision_free_fraction(state, &self.trial, None) < 1.0 || problem.monitor.is_stopped() {
            // A cable would pass through an obstacle, or a stop was requested.
            return f64::INFINITY;
        }
        self.evaluations += 1;
        let mut energy = problem.gradient(&self.trial, &mut self.trial_gradient);
        if self.condensation.condense(problem, &mut self.trial, &self.trial_gradient, self.condensed_force) {
            self.evaluations += 1;
            let condensed = problem.gradient(&self.trial, &mut self.trial_gradient);
            if condensed <= energy && problem.collision_free_fraction(state, &self.trial, None) == 1.0 {
                energy = condensed;
            } else {
                self.condensation.undo(&mut self.trial);
                problem.gradient(&self.trial, &mut self.trial_gradient);
            }
        }
        energy - problem.work_without_potential(state, &self.step, alpha)
    }

    /// Backtracking line search (Armijo) along the step from `state` with `energy` (J), its `slope` along the step and
    /// its `noise`; the step was made with the shift `sigma`. A whole step with a shift that fails is restored
    /// (`restoration`); if that fails, the next trial is the minimum of the parabola through value, slope and trial.
    /// Returns step length and energy of the accepted trial.
    fn line_search(
        &mut self,
        problem: &mut Problem<'_>,
        state: &State,
        [energy, slope, noise]: [f64; 3],
        [residual, sigma]: [f64; 2],
    ) -> Option<(f64, f64)> {
        let mut alpha = self.longest(problem, state);
        loop {
            let trial = self.try_step(problem, state, alpha);
            // If the change of the energy is lost in round-off, the residual decides.
            let lower = trial <= energy + ARMIJO * alpha * slope + noise;
            if lower || (-slope <= noise && self.trial_residual(problem) <= PROGRESS * residual) {
                return Some((alpha, trial));
            }
            if alpha == 1.0
                && sigma > 0.0
                && Self::restores(problem)
                && let Some(restored) = self.restore(problem, state, sigma, [trial, energy + ARMIJO * slope])
            {
                return Some((alpha, restored));
            }
            let parabola = -0.5 * slope * alpha * alpha / (trial - energy - slope * alpha);
            let [least, largest] = SHORTENING;
            alpha =
                if parabola.is_finite() { parabola.clamp(least * alpha, largest * alpha) } else { BACKTRACK * alpha };
            if alpha < SHORTEST_STEP || problem.monitor.is_stopped() {
                return None;
            }
        }
    }

    /// Accepts the trial as the new state; `trial` keeps the old one.
    fn accept(&mut self, state: &mut State) {
        std::mem::swap(state, &mut self.trial);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
    }

    fn residual(&mut self, problem: &Problem<'_>) -> f64 {
        self.free.copy_from(&self.gradient);
        problem.free_part(&mut self.free);
        problem.residual(&self.free)
    }

    /// Residual at the trial.
    fn trial_residual(&mut self, problem: &Problem<'_>) -> f64 {
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        let residual = self.residual(problem);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        // The slope needs the free part of the gradient at the state.
        self.residual(problem);
        residual
    }

    fn largest_turn(&self) -> f64 {
        self.step.frames.iter().map(Vector::norm_squared).fold(0.0, f64::max).sqrt()
    }

    /// Negative curvature −sᵀHs / sᵀWs along the step s with the shift `sigma`, 0 if there is none: from
    /// `sᵀ(H + σW)s = −gᵀs`, where gᵀs is the `slope` (J). Steps with models of their own
    /// ([`restores`](Self::restores)) do not tell it.
    fn negative_curvature(&self, problem: &Problem<'_>, slope: f64, sigma: f64) -> f64 {
        if sigma == 0.0 || !Self::restores(problem) {
            return 0.0;
        }
        (sigma + slope / self.system.weighted_square(&self.step)).max(0.0)
    }

    fn slope(&self) -> f64 {
        // Tied entries of the gradient are zero.
        self.free.dot(&self.step)
    }
}

impl Minimiser for Newton {
    fn name(&self) -> &str {
        "newton"
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        let Some(ws) = Workspace::ready(&mut self.workspace, problem) else {
            return Report::begun(Status::Interrupted);
        };
        in_pool(problem.network, || descend(ws, problem, state, stop))
    }

    fn forget(&mut self) {
        if let Some(ws) = &mut self.workspace {
            ws.factor_of = None;
        }
    }
}

/// See [`Minimiser::minimise`].
fn descend(ws: &mut Workspace, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
    (ws.factorisations, ws.evaluations) = (0, 0);
    ws.convex = problem.has_potential();
    problem.update_held(state);
    ws.condensed_force = condensed_force(problem, stop);
    ws.system.update_weights(problem);
    let moving = problem.motion(state, &mut ws.motion);
    let mut report = Report::begun(Status::Failed);
    let mut mixed = false;
    let mut energy;
    if moving {
        (energy, mixed) = predict(ws, problem, state);
        report.iterations += 1;
        if energy.is_infinite() {
            trace(problem, &report, [energy, f64::NAN, 1.0, 0.0], ws.factorisations);
            // The prescribed motion moves a cable through an obstacle: the increment is too large.
            ws.factor_of = None;
            if problem.monitor.is_stopped() {
                report.status = Status::Interrupted;
            }
            return report;
        }
        problem.update_held(state);
    } else {
        problem.place_held(state);
        ws.evaluations += 1;
        energy = problem.gradient(state, &mut ws.gradient);
    }
    let (mut sigma, mut reaches) = (0.0_f64, false);
    let mut monitor = ConvergenceMonitor::new(stop, STALLED_AFTER);
    monitor.begin(ws.residual(problem));
    if moving {
        trace(problem, &report, [energy, monitor.residual, 1.0, 0.0], ws.factorisations);
    }
    report.status = loop {
        if problem.monitor.iterate(monitor.residual) {
            break Status::Interrupted;
        }
        match monitor.termination(report.iterations) {
            Termination::Stop(status) => break status,
            Termination::Refine => sigma = 0.0,
            Termination::Continue => {}
        }
        if mixed {
            // The trial keeps the state before the step.
            predict_forces(problem, &ws.trial, &ws.step, &mut ws.forces);
        }
        if !problem.has_potential() {
            report.iterations += 1;
            if let Some(step) = ws.residual_step(problem, state, mixed) {
                mixed = step.mixed;
                energy = step.energy;
                monitor.moved(step.turn, step.visible, ws.residual(problem));
                trace(problem, &report, [energy, monitor.residual, step.alpha, 0.0], ws.factorisations);
                continue;
            }
            trace(problem, &report, [energy, monitor.residual, 0.0, 0.0], ws.factorisations);
        }
        // The factor of the step before will do for one more, if that is expected to be the last.
        let keeps = std::mem::replace(&mut reaches, false);
        if !keeps {
            sigma = ws.assemble(problem, state, mixed, sigma);
        }
        ws.solve(problem, state, false, (!keeps).then_some(sigma));
        report.iterations += 1;
        let slope = ws.slope();
        if !slope.is_finite() {
            trace(problem, &report, [energy, monitor.residual, 0.0, sigma], ws.factorisations);
            break Status::Failed;
        }
        let negative = ws.negative_curvature(problem, slope, sigma);
        let noise = problem.energy_noise(&ws.gradient);
        let found = ws.line_search(problem, state, [energy, slope, noise], [monitor.residual, sigma]);
        let Some((alpha, trial)) = found else {
            trace(problem, &report, [energy, monitor.residual, 0.0, sigma], ws.factorisations);
            if mixed {
                mixed = false;
            } else if -slope <= noise {
                monitor.stall();
            } else if sigma < LARGEST_SHIFT {
                sigma = raised(sigma, RAISE_AFTER_FAILURE);
            } else {
                break Status::Failed;
            }
            continue;
        };
        mixed = alpha == 1.0 && (Workspace::restores(problem) || ws.largest_turn() < SMALL_TURN);
        let turn = alpha * ws.largest_turn();
        energy = trial + problem.work_without_potential(state, &ws.step, alpha);
        ws.accept(state);
        problem.update_held(state);
        monitor.moved(turn, -slope > noise, ws.residual(problem));
        trace(problem, &report, [energy, monitor.residual, alpha, sigma], ws.factorisations);
        let quadratic = !keeps && alpha == 1.0 && ws.factor_of.is_some() && problem.has_potential();
        reaches = quadratic && KEPT * turn * monitor.residual <= stop.force_tolerance;
        sigma = next_shift(sigma, alpha, negative);
    };
    if report.status != Status::Converged {
        // The next call may begin at another state.
        ws.factor_of = None;
    }
    report.residual = monitor.residual;
    report.factorisations = ws.factorisations;
    report.evaluations = ws.evaluations;
    report.convex = ws.convex;
    report
}

/// Predicts the forces after a step from the state `before` to first order, for the next geometric stiffness.
fn predict_forces(problem: &Problem<'_>, before: &State, step: &Tangent, forces: &mut [Vec<Vector>]) {
    problem.network.for_branches(forces, |b, branch, forces| {
        let shape = problem.shape(before, b);
        let points = &step.points[branch.points.clone()];
        let frames = &step.frames[branch.frames.clone()];
        branch.rod.predicted_forces(&shape, points, frames, forces);
    });
}

/// Shift for the next iteration, after a step of length `alpha` with the shift `sigma` along which there was a
/// `negative` curvature.
fn next_shift(sigma: f64, alpha: f64, negative: f64) -> f64 {
    let lowered = (LOWER * sigma).max(ABOVE_NEGATIVE * negative);
    let next = if alpha < SHORT_STEP { RAISE_AFTER_SHORT_STEP * sigma } else { lowered };
    if next < NO_SHIFT { 0.0 } else { next }
}

/// First step of an increment, with the tangent at the old state and the prescribed motion. If it is large, the whole
/// step and shorter ones (with the full prescribed motion in each) are tried, and the one of least energy is taken.
/// Returns the energy and whether the step was small.
fn predict(ws: &mut Workspace, problem: &mut Problem<'_>, state: &mut State) -> (f64, bool) {
    problem.gradient(state, &mut ws.gradient);
    let known = ws.factor_of.as_ref() == Some(&problem.conditions().active);
    let sigma = (!known).then(|| {
        if !problem.has_potential() {
            // Without a potential the matrix need not be positive definite; see [`residual_step`].
            problem.hessian(state, None, &mut ws.hessian);
            ws.factorise(problem, state, 0.0);
            return 0.0;
        }
        ws.assemble(problem, state, false, 0.0)
    });
    ws.solve(problem, state, true, sigma);
    if ws.largest_turn() < SMALL_TURN && problem.largest_slide_fraction(state, &ws.step) == 1.0 {
        let energy = ws.try_step(problem, state, 1.0);
        if energy.is_finite() {
            ws.accept(state);
            return (energy, true);
        }
    }
    let mut best = (f64::INFINITY, 0.0);
    let mut alpha = ws.longest(problem, state);
    for _ in 0..PREDICTION_TRIALS {
        let energy = ws.try_step(problem, state, alpha);
        if energy < best.0 {
            best = (energy, alpha);
        }
        alpha *= 0.5;
    }
    if best.0.is_infinite() {
        // No step has a finite energy: apply the prescribed motion only.
        ws.step.clear();
    }
    let energy = ws.try_step(problem, state, best.1);
    ws.accept(state);
    (energy, false)
}
