//! The minimiser `newton`: Newton's method on the full Hessian.
//!
//! Per iteration: second derivatives, factorisation along the graph, step, line search, in which the points follow the frames
//! ([`crate::settle`]). Where the Hessian is not positive definite the frames' diagonal is shifted until it is (Levenberg), so
//! every step leads downhill from any start. A step with the shift σ W is an implicit step, of length 1, of the overdamped motion
//! `σ W θ̇ = −∂E/∂θ`, the points in balance (pseudo-transient continuation: Kelley and Keyes 1998): so a harness that has lost its
//! equilibrium falls as one in thick oil would, in steps as long as the descent allows. The first step of an increment carries the prescribed motion in its right-hand side.
//! What a step brings into contact, or takes out of it, is foreseen ([`Foresight`]).
//! After small steps the axial and shear forces in the geometric stiffness are those predicted by the last linear step
//! ("mixed integration points", Magisano, Leonetti, Garcea 2017).
//! Dead moments have no potential: with them steps are those of the residual (`leap`), downhill only where that fails.

mod leap;

use crate::border::Border;
use crate::dead_moments::DeadMoments;
use crate::gather::System;
use crate::judge::{Judge, PROGRESS, Verdict};
use crate::settle::Settle;
use wireloom_core::contact::Foresight;
use wireloom_core::minimiser::{Minimiser, Report, Status, Stop};
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::registry::MinimiserKind;
use wireloom_core::scales::LocalScale;
use wireloom_core::{State, Tangent, Vector};

/// Largest turn (rad) of any frame in one line-search step; beyond it the quadratic model says nothing.
pub(crate) const LARGEST_TURN: f64 = 1.0;
/// Largest turn (rad) of a step that counts as small: a linear prediction says something of what comes after it.
pub(crate) const SMALL_TURN: f64 = 0.3;
/// Share of the tolerance below which forces on points are not settled.
const SETTLED_SHARE: f64 = 0.1;
/// First shift of the frames' diagonal that is tried, in units of [`System::weights`]; one tenth of it is none.
const FIRST_SHIFT: f64 = 1e-6;
/// How many times larger the next shift is that is tried where the matrix is not positive definite yet.
pub(crate) const RAISE: f64 = 8.0;
/// By how much a shift is lowered after a step that it let succeed.
const LOWER: f64 = 0.1;
/// Shift at which a step that still does not lower the energy is given up.
const LARGEST_SHIFT: f64 = 1e6;
/// Share of the predicted decrease that a step must bring (Armijo).
const ARMIJO: f64 = 1e-4;
/// How often a step is solved for, where something else will touch than was taken to.
pub(crate) const FORESEEN: usize = 12;
/// Iterations without progress at round-off after which the state is called stalled.
const STALLED_AFTER: usize = 4;

/// The kind `newton`.
pub fn kind() -> MinimiserKind {
    MinimiserKind {
        name: "newton".into(),
        doc: "Newton on the full Hessian with a direct factorisation along the graph; descends from any start".into(),
        parameters: vec![],
        build: Box::new(|(), _| Ok(Box::new(Newton::new()))),
    }
}

/// Newton's method; keeps its workspace from call to call.
#[derive(Default)]
pub struct Newton {
    workspace: Option<Box<Workspace>>,
}

impl Newton {
    /// With no workspace yet: the first call makes it.
    pub fn new() -> Self {
        Self::default()
    }
}

/// Everything that is allocated once.
struct Workspace {
    network: u64,
    system: System,
    settle: Settle,
    border: Border,
    moments: DeadMoments,
    foresight: Foresight,
    hessian: Hessian,
    gradient: Tangent,
    /// That of the model in which what will touch does ([`Foresight`]).
    foreseen: Tangent,
    free: Tangent,
    trial_gradient: Tangent,
    step: Tangent,
    motion: Tangent,
    trial: State,
    /// Predicted forces, by branch and segment.
    forces: Vec<Vec<Vector>>,
    /// Where the matrix holds an unshifted, positive definite factor: the fixings that were active.
    factor_of: Option<Vec<bool>>,
    /// Force (N) below which a point counts as settled.
    settled_force: f64,
    factorisations: usize,
    evaluations: usize,
}

impl Workspace {
    /// `None` where somebody asked to stop: of a large harness each pattern takes a while.
    fn new(problem: &Problem<'_>) -> Option<Self> {
        let network = problem.network;
        let system = System::new(problem);
        if problem.monitor.is_stopped() {
            return None;
        }
        let settle = Settle::new(problem);
        Some(Self {
            network: network.id,
            system,
            settle,
            hessian: Hessian::new(network),
            gradient: Tangent::zeros(network),
            foreseen: Tangent::zeros(network),
            foresight: Foresight::new(network),
            free: Tangent::zeros(network),
            trial_gradient: Tangent::zeros(network),
            step: Tangent::zeros(network),
            motion: Tangent::zeros(network),
            trial: State::origin(network),
            forces: network.branches.iter().map(|b| vec![Vector::zeros(); b.rod.mesh().segments()]).collect(),
            border: Border::default(),
            moments: DeadMoments::default(),
            factor_of: None,
            settled_force: 0.0,
            factorisations: 0,
            evaluations: 0,
        })
    }

    /// The workspace for a problem; `None` as for [`Self::new`].
    fn ready<'w>(slot: &'w mut Option<Box<Self>>, problem: &Problem<'_>) -> Option<&'w mut Self> {
        if problem.monitor.is_stopped() {
            return None;
        }
        if slot.as_ref().is_none_or(|ws| ws.network != problem.network.id) {
            *slot = Self::new(problem).map(Box::new);
        }
        slot.as_deref_mut()
    }

    /// Second derivatives at `state` (where `gradient` was evaluated last), factorised with the first shift from `sigma` on that makes
    /// them positive definite, fixings being made convex before there is any. Returns that shift.
    fn assemble(&mut self, problem: &mut Problem<'_>, state: &State, mixed: bool, mut sigma: f64) -> f64 {
        problem.hessian(state, mixed.then_some(self.forces.as_slice()), &mut self.hessian);
        let mut convex = false;
        while self.factorise(problem, state, sigma) > 0 && sigma.is_finite() && !problem.monitor.is_stopped() {
            if std::mem::replace(&mut convex, true) || !problem.make_convex(state, &mut self.hessian) {
                sigma = raised(sigma, RAISE);
            }
        }
        sigma
    }

    /// Gathers and factorises the Hessian at hand with another shift.
    fn factorise(&mut self, problem: &Problem<'_>, state: &State, sigma: f64) -> usize {
        self.system.fill(problem, state, &self.hessian);
        let System { matrix, weights, .. } = &mut self.system;
        if sigma > 0.0 {
            matrix.shift(sigma, weights);
        }
        matrix.take_out(problem);
        self.factorisations += 1;
        let negative = matrix.factorise();
        if negative == 0 && sigma == 0.0 {
            let active = &problem.conditions().active;
            match &mut self.factor_of {
                Some(known) if known.len() == active.len() => known.copy_from_slice(active),
                slot => *slot = Some(active.clone()),
            }
        } else {
            self.factor_of = None;
        }
        negative
    }

    /// Solves for the step at `state`; with `moving` it carries the prescribed motion. `sigma` is the shift that the matrix was assembled with
    /// there; none where it is that of an earlier state. What the step brings into contact, or takes out of it, is foreseen.
    fn solve(&mut self, problem: &mut Problem<'_>, state: &State, moving: bool, mut sigma: Option<f64>) {
        self.begin_foresight(problem);
        self.solve_once(problem, state, moving);
        if self.foresight.is_idle() {
            return;
        }
        for left in (0..FORESEEN).rev() {
            let Self { foresight, gradient, step, foreseen, hessian, .. } = self;
            let from = (!moving).then_some(&*gradient);
            let changed = problem.foresee(state, foresight, from, step, foreseen, &mut hessian.fixings);
            if !changed || left == 0 || problem.monitor.is_stopped() {
                return;
            }
            match sigma {
                Some(sigma) => {
                    if self.factorise(problem, state, sigma) > 0 && !problem.has_dead_moments() {
                        return;
                    }
                }
                None => {
                    sigma = Some(self.assemble(problem, state, false, 0.0));
                    self.begin_foresight(problem);
                }
            }
            self.solve_once(problem, state, moving);
        }
    }

    fn begin_foresight(&mut self, problem: &Problem<'_>) {
        problem.begin_foresight(&mut self.foresight);
        if !self.foresight.is_idle() {
            self.foreseen.copy_from(&self.gradient);
        }
    }

    /// Solves for the step with the matrix at hand and the forces of the model.
    fn solve_once(&mut self, problem: &mut Problem<'_>, state: &State, moving: bool) {
        let motion = moving.then_some(&self.motion);
        let Self { system: System { matrix, rhs, .. }, border, moments, foresight, gradient, foreseen, step, .. } =
            self;
        let forces = if foresight.is_idle() { gradient } else { foreseen };
        matrix.right_hand_side(problem, forces, motion, rhs);
        matrix.solve(rhs);
        matrix.step(problem, state, rhs, motion, step);
        if problem.slides_any() {
            border.complete(matrix, problem, state, forces, rhs, step);
        }
        if problem.has_dead_moments() {
            moments.prepare(matrix, border, problem, state, rhs);
            moments.complete(step);
        }
    }

    /// Largest share of the step that the line search may take.
    fn longest(&self, problem: &Problem<'_>, state: &State) -> f64 {
        let turn = self.largest_turn();
        let share: f64 = if turn > LARGEST_TURN { LARGEST_TURN / turn } else { 1.0 };
        share.min(problem.largest_slide(state, &self.step))
    }

    /// Energy and gradient at `state ⊕ α step` with the points settled, in `trial` and `trial_gradient`.
    fn try_step(&mut self, problem: &mut Problem<'_>, state: &State, alpha: f64) -> f64 {
        problem.retract(state, &self.step, alpha, &mut self.trial);
        problem.place_held(&mut self.trial);
        if problem.free_share(state, &self.trial, None) < 1.0 || problem.monitor.is_stopped() {
            // A cable would go through an obstacle; or nobody wants to know any more.
            return f64::INFINITY;
        }
        self.evaluations += 1;
        let mut energy = problem.gradient(&self.trial, &mut self.trial_gradient);
        if self.settle.settle(problem, &mut self.trial, &self.trial_gradient, self.settled_force) {
            self.evaluations += 1;
            let settled = problem.gradient(&self.trial, &mut self.trial_gradient);
            if settled <= energy && problem.free_share(state, &self.trial, None) == 1.0 {
                energy = settled;
            } else {
                self.settle.undo(&mut self.trial);
                problem.gradient(&self.trial, &mut self.trial_gradient);
            }
        }
        energy - problem.moment_work(state, &self.step, alpha)
    }

    /// Takes the trial as the new state; `trial` keeps the old one.
    fn accept(&mut self, state: &mut State) {
        std::mem::swap(state, &mut self.trial);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
    }

    /// Forces to first order after the accepted step, for the next geometric stiffness. The state before it is in
    /// `trial` then.
    fn predict_forces(&mut self, problem: &Problem<'_>) {
        let (trial, step) = (&self.trial, &self.step);
        problem.network.for_branches(&mut self.forces, |b, branch, forces| {
            let shape = trial.branch(problem.network, b);
            let points = &step.points[branch.points.clone()];
            let frames = &step.frames[branch.frames.clone()];
            branch.rod.predicted_forces(&shape, points, frames, forces);
        });
    }

    fn residual(&mut self, problem: &Problem<'_>) -> f64 {
        self.free.copy_from(&self.gradient);
        problem.free_part(&mut self.free);
        problem.residual(&self.free)
    }

    /// The residual at the trial.
    fn trial_residual(&mut self, problem: &Problem<'_>) -> f64 {
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        let residual = self.residual(problem);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        // The slope goes by the free part of the gradient at the state.
        self.residual(problem);
        residual
    }

    fn largest_turn(&self) -> f64 {
        self.step.frames.iter().map(Vector::norm_squared).fold(0.0, f64::max).sqrt()
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
        if problem.network.is_shared() {
            // Among the threads of the pool, so that handing them work costs little.
            let span = tracing::Span::current();
            rayon::scope(|_| span.in_scope(|| descend(ws, problem, state, stop)))
        } else {
            descend(ws, problem, state, stop)
        }
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
    problem.update_held(state);
    ws.settled_force = settled_force(problem, stop);
    ws.system.weigh(problem);
    let moving = problem.motion(state, &mut ws.motion);
    let mut report = Report::begun(Status::Failed);
    let mut mixed = false;
    let mut energy;
    if moving {
        (energy, mixed) = predict(ws, problem, state);
        report.iterations += 1;
        if energy.is_infinite() {
            trace(&report, ws, problem, energy, f64::NAN, 1.0, 0.0);
            // What is held goes through an obstacle, or drags a cable through one: the increment is too large.
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
    let mut sigma = 0.0_f64;
    let mut judge = Judge::new(stop, STALLED_AFTER);
    judge.begin(ws.residual(problem));
    let mut told = 0;
    let mut length = 1.0;
    report.status = loop {
        if told < report.iterations {
            trace(&report, ws, problem, energy, judge.residual, length, sigma);
            told = report.iterations;
        }
        if problem.monitor.iterate(judge.residual) {
            break Status::Interrupted;
        }
        match judge.verdict(report.iterations) {
            Verdict::Over(status) => break status,
            Verdict::Polish => sigma = 0.0,
            Verdict::Step => {}
        }
        if mixed {
            ws.predict_forces(problem);
        }
        if problem.has_dead_moments() {
            report.iterations += 1;
            if let Some(leap) = leap::leap(ws, problem, state, mixed) {
                mixed = leap.mixed;
                energy = leap.energy;
                judge.moved(leap.turn, leap.visible, ws.residual(problem));
                continue;
            }
        }
        sigma = ws.assemble(problem, state, mixed, sigma);
        ws.solve(problem, state, false, Some(sigma));
        report.iterations += 1;
        let slope = ws.slope();
        let noise = problem.energy_noise(&ws.gradient);
        let mut alpha = ws.longest(problem, state);
        if !slope.is_finite() {
            break Status::Failed;
        }
        // Line search by halving, with the parabola through value, slope and trial where it helps.
        let accepted = loop {
            let trial = ws.try_step(problem, state, alpha);
            // Where round-off hides what the step does to the energy, the forces say whether it was a good one.
            let lower = trial <= energy + ARMIJO * alpha * slope + noise;
            if lower || (-slope <= noise && ws.trial_residual(problem) <= PROGRESS * judge.residual) {
                break Some(trial);
            }
            let parabola = -0.5 * slope * alpha * alpha / (trial - energy - slope * alpha);
            alpha = if parabola.is_finite() { parabola.clamp(0.1 * alpha, 0.5 * alpha) } else { 0.25 * alpha };
            if alpha < 1e-10 || problem.monitor.is_stopped() {
                break None;
            }
        };
        let Some(trial) = accepted else {
            if mixed {
                mixed = false;
                continue;
            }
            if -slope <= noise {
                judge.stall();
            } else if sigma < LARGEST_SHIFT {
                sigma = raised(sigma, 16.0);
            } else {
                break Status::Failed;
            }
            continue;
        };
        length = alpha;
        mixed = ws.largest_turn() < SMALL_TURN && alpha == 1.0;
        let turn = alpha * ws.largest_turn();
        energy = trial + problem.moment_work(state, &ws.step, alpha);
        ws.accept(state);
        problem.update_held(state);
        judge.moved(turn, -slope > noise, ws.residual(problem));
        if sigma > 0.0 {
            sigma *= if alpha < 0.25 { 4.0 } else { LOWER };
            if sigma < 0.1 * FIRST_SHIFT {
                sigma = 0.0;
            }
        }
    };
    if told < report.iterations {
        trace(&report, ws, problem, energy, judge.residual, length, sigma);
    }
    if report.status != Status::Converged {
        // Whoever goes on from here may go on from somewhere else.
        ws.factor_of = None;
    }
    report.residual = judge.residual;
    report.factorisations = ws.factorisations;
    report.evaluations = ws.evaluations;
    report
}

/// Tells whoever listens of an iteration.
fn trace(report: &Report, ws: &Workspace, problem: &Problem<'_>, energy: f64, residual: f64, step: f64, shift: f64) {
    tracing::debug!(
        target: "wireloom::iteration",
        iteration = report.iterations,
        energy,
        residual,
        step,
        shift,
        contacts = problem.conditions().contact.marks.len(),
        factorisations = ws.factorisations,
    );
}

/// A larger shift than `sigma`.
pub(crate) fn raised(sigma: f64, factor: f64) -> f64 {
    (factor * sigma).max(FIRST_SHIFT)
}

/// Force (N) below which a point counts as settled: a share of what the softest branch may have left.
pub(crate) fn settled_force(problem: &Problem<'_>, stop: &Stop) -> f64 {
    let allowed = |scale: &LocalScale| (stop.force_tolerance * scale.force).max(scale.round_off[0]);
    SETTLED_SHARE * problem.local_scales().iter().map(allowed).fold(f64::INFINITY, f64::min)
}

/// The first step of an increment: the tangent at the old state carries the prescribed motion. Where it turns anything
/// far, the whole step and shorter ones (the held freedoms always move all the way) are tried and the one of least energy is
/// taken. Returns the energy and whether the increment counts as small.
fn predict(ws: &mut Workspace, problem: &mut Problem<'_>, state: &mut State) -> (f64, bool) {
    problem.gradient(state, &mut ws.gradient);
    let known = ws.factor_of.as_ref() == Some(&problem.conditions().active);
    let sigma = (!known).then(|| {
        if problem.has_dead_moments() {
            // Their matrix need not be positive definite; see [`leap`].
            problem.hessian(state, None, &mut ws.hessian);
            ws.factorise(problem, state, 0.0);
            return 0.0;
        }
        ws.assemble(problem, state, false, 0.0)
    });
    ws.solve(problem, state, true, sigma);
    if ws.largest_turn() < SMALL_TURN && problem.largest_slide(state, &ws.step) == 1.0 {
        let energy = ws.try_step(problem, state, 1.0);
        if energy.is_finite() {
            ws.accept(state);
            return (energy, true);
        }
    }
    let mut best = (f64::INFINITY, 0.0);
    let mut alpha = ws.longest(problem, state);
    for _ in 0..4 {
        let energy = ws.try_step(problem, state, alpha);
        if energy < best.0 {
            best = (energy, alpha);
        }
        alpha *= 0.5;
    }
    if best.0.is_infinite() {
        // No step is worth anything: only what is held moves.
        ws.step.clear();
    }
    let energy = ws.try_step(problem, state, best.1);
    ws.accept(state);
    (energy, false)
}
