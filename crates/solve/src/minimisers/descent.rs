//! Minimisers that go by gradients: what `lbfgs` and `ncg` have in common.
//!
//! Per iteration: a direction from the gradient, a metric and what was learnt on the way ([`Method`]), a line search
//! ([`crate::line_search`]), and what was learnt carried to the new state ([`crate::transport`]).
//!
//! The metric ([`Metric`]) is by default the Hessian of the first state, factorised, and taken anew every few iterations or where a step had to be
//! short. With it the first step carries the prescribed motion, as in [`crate::newton`], and after every step the points follow
//! the frames into balance ([`crate::condensation`]): what is minimised is then the energy of the frames alone. Without it the
//! methods are those of the textbooks, in metres and radians.

use super::step_control::{LARGEST_TURN, SMALL_TURN, condensed_force};
use super::trace::trace;
use crate::minimisers::condensation::Condensation;
use crate::minimisers::convergence::{ConvergenceMonitor, Termination};
use crate::minimisers::line_search::{self, Wolfe};
use crate::minimisers::preconditioner::{Metric, Preconditioner};
use crate::minimisers::transport::{carry, slope};
use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::problem::Problem;
use wireloom_core::registry::{BuildError, Form, MinimiserKind, Parameter, Parameters, Quantity, Value};
use wireloom_core::status::Status;
use wireloom_core::{Network, State, Tangent, Vector};

/// Iterations without progress at round-off after which the state is called stalled: with a metric, and without, where a method
/// that gets anywhere gets there slowly.
const STALLED_AFTER: [usize; 2] = [4, 500];
/// A step shorter than this fraction of the one the metric asked for says that the metric is no good here.
const SHORT: f64 = 0.25;
/// Where nothing is known of lengths yet, no point is moved farther than this fraction of the longest branch.
const FIRST_MOVE: f64 = 0.01;

/// How the next direction is made of the gradient, the metric and what was learnt.
pub(crate) trait Method: Send {
    /// Name of the minimiser.
    const NAME: &'static str;
    /// Makes room for what is learnt on a network.
    fn ready(&mut self, network: &Network);
    /// Forgets what was learnt.
    fn restart(&mut self);
    /// Whether nothing is known.
    fn is_blank(&self) -> bool;
    /// Carries what it knows along the accepted `α step`, and learns from the gradient at its end; `before` is that at its beginning, carried.
    fn learn(&mut self, step: &Tangent, alpha: f64, gradient: &Tangent, before: &Tangent);
    /// The direction for a free gradient; `solve` gives `−M⁻¹` of what it is called with.
    fn direction(&mut self, gradient: &Tangent, solve: &mut dyn FnMut(&Tangent, &mut Tangent), step: &mut Tangent);
    /// Whether its directions have a length of their own where there is no metric.
    fn knows_lengths(&self) -> bool;
    /// The metric becomes another one.
    fn metric_changes(&mut self);
}

/// What can be chosen for either method.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Choices {
    pub metric: Metric,
    /// Iterations after which the metric is taken anew.
    pub refresh: usize,
    /// σ of the line search.
    pub slope: f64,
}

impl Choices {
    /// Their declaration; `slope` is the default of σ.
    pub(crate) fn parameters(slope: f64) -> Vec<Parameter> {
        let optional = |name: &str, doc: &str, form, default| Parameter {
            name: name.into(),
            doc: doc.into(),
            form,
            default: Some(default),
            required: false,
        };
        let fraction =
            Form::Number { quantity: Quantity::Dimensionless, minimum: 1e-3, exclusive: false, maximum: 0.99 };
        vec![
            optional(
                "preconditioner",
                "metric in which it goes downhill: the factorised Hessian, or none (the textbook method)",
                Form::Choice(Metric::WORDS.map(Into::into).into()),
                Value::Word("hessian".into()),
            ),
            optional(
                "refresh",
                "iterations after which the preconditioner is taken anew",
                Form::Count { minimum: 1 },
                Value::Count(REFRESH),
            ),
            optional(
                "slope",
                "fraction of the first slope that may be left at the end of a line search (strong Wolfe condition)",
                fraction,
                Value::Number(slope),
            ),
        ]
    }

    /// From values that were checked against the declaration.
    pub(crate) fn from(parameters: &Parameters, slope: f64) -> Self {
        Self {
            metric: parameters.word("preconditioner").and_then(Metric::from_word).unwrap_or(Metric::Hessian),
            refresh: parameters.count("refresh").unwrap_or(REFRESH),
            slope: parameters.number("slope").unwrap_or(slope),
        }
    }
}

/// Default of `refresh`: a factorisation costs some three evaluations.
const REFRESH: usize = 8;

/// A kind of minimiser with one more parameter than those that all have.
pub(crate) fn kind<M: Method + 'static>(
    doc: &str,
    slope: f64,
    own: Parameter,
    method: impl Fn(&Parameters) -> M + Send + Sync + 'static,
) -> MinimiserKind {
    let mut parameters = Choices::parameters(slope);
    parameters.push(own);
    MinimiserKind {
        name: M::NAME.into(),
        doc: doc.into(),
        parameters,
        build: Box::new(move |(), given| {
            Ok(Box::new(Descent { method: method(given), choices: Choices::from(given, slope), workspace: None }))
        }),
    }
}

/// A minimiser that goes by gradients; keeps its workspace from call to call.
pub(crate) struct Descent<M> {
    method: M,
    choices: Choices,
    workspace: Option<Box<Workspace>>,
}

/// Everything that is allocated once.
struct Workspace {
    network: u64,
    preconditioner: Preconditioner,
    /// Brings points into balance, where the metric is the Hessian.
    condensation: Option<Condensation>,
    gradient: Tangent,
    /// Its free part.
    free: Tangent,
    before: Tangent,
    trial_gradient: Tangent,
    step: Tangent,
    motion: Tangent,
    trial: State,
    condensed_force: f64,
    evaluations: usize,
}

impl Workspace {
    fn new(problem: &Problem<'_>, metric: Metric) -> Self {
        let network = problem.network;
        Self {
            network: network.id,
            preconditioner: Preconditioner::new(problem, metric),
            condensation: (metric == Metric::Hessian).then(|| Condensation::new(problem)),
            gradient: Tangent::zeros(network),
            free: Tangent::zeros(network),
            before: Tangent::zeros(network),
            trial_gradient: Tangent::zeros(network),
            step: Tangent::zeros(network),
            motion: Tangent::zeros(network),
            trial: State::origin(network),
            condensed_force: 0.0,
            evaluations: 0,
        }
    }

    /// Energy and gradient at the trial, whose held freedoms are put in place and whose points are condensed; infinite where a cable would go
    /// through an obstacle on the way there, or where all is to stop.
    fn evaluate(&mut self, problem: &mut Problem<'_>, from: Option<&State>) -> f64 {
        problem.place_held(&mut self.trial);
        let barred = from.is_some_and(|from| problem.collision_free_fraction(from, &self.trial, None) < 1.0);
        if barred || problem.monitor.is_stopped() {
            return f64::INFINITY;
        }
        self.evaluations += 1;
        let energy = problem.gradient(&self.trial, &mut self.trial_gradient);
        let Some(condensation) = &mut self.condensation else { return energy };
        if !condensation.condense(problem, &mut self.trial, &self.trial_gradient, self.condensed_force) {
            return energy;
        }
        self.evaluations += 1;
        let condensed = problem.gradient(&self.trial, &mut self.trial_gradient);
        if condensed <= energy
            && from.is_none_or(|from| problem.collision_free_fraction(from, &self.trial, None) == 1.0)
        {
            return condensed;
        }
        condensation.undo(&mut self.trial);
        problem.gradient(&self.trial, &mut self.trial_gradient)
    }

    /// Energy and slope at `state ⊕ α step`.
    fn try_step(&mut self, problem: &mut Problem<'_>, state: &State, alpha: f64) -> (f64, f64) {
        problem.retract(state, &self.step, alpha, &mut self.trial);
        let energy = self.evaluate(problem, Some(state));
        (energy, slope(&self.trial_gradient, &self.step, alpha))
    }

    /// Takes the trial as the new state.
    fn accept(&mut self, problem: &mut Problem<'_>, state: &mut State) {
        std::mem::swap(state, &mut self.trial);
        std::mem::swap(&mut self.gradient, &mut self.trial_gradient);
        problem.update_held(state);
    }

    fn residual(&mut self, problem: &Problem<'_>) -> f64 {
        self.free.copy_from(&self.gradient);
        problem.free_part(&mut self.free);
        problem.residual(&self.free)
    }

    /// The next direction, in `step`; gives the slope along it.
    fn direction(&mut self, method: &mut impl Method, problem: &mut Problem<'_>, state: &State, metric: bool) -> f64 {
        let Self { preconditioner, gradient, free, step, .. } = self;
        // Whether a slide stands at a stop is told by the whole gradient.
        let from = if metric && method.is_blank() { gradient } else { free };
        method.direction(from, &mut |g, step| preconditioner.solve(problem, state, g, step), step);
        self.free.dot(&self.step)
    }

    fn largest_turn(&self) -> f64 {
        self.step.frames.iter().map(Vector::norm_squared).fold(0.0, f64::max).sqrt()
    }

    fn largest_move(&self) -> f64 {
        self.step.points.iter().map(Vector::norm_squared).fold(0.0, f64::max).sqrt()
    }

    /// Largest fraction of the step that may be taken.
    fn longest(&self, problem: &Problem<'_>, state: &State) -> f64 {
        let turn = self.largest_turn();
        let fraction = if turn > 0.0 { LARGEST_TURN / turn } else { f64::INFINITY };
        fraction.min(if problem.has_slides() {
            problem.largest_slide_fraction(state, &self.step)
        } else {
            f64::INFINITY
        })
    }

    /// The first step of an increment, with the metric of the old state: the whole of it, or of it and shorter ones that of least energy.
    /// Returns the energy after it.
    fn predict(&mut self, problem: &mut Problem<'_>, state: &mut State) -> f64 {
        problem.gradient(state, &mut self.gradient);
        self.preconditioner.make(problem, state);
        let Self { preconditioner, gradient, motion, step, .. } = self;
        preconditioner.solve_moving(problem, state, gradient, Some(motion), step);
        let longest = self.longest(problem, state).min(1.0);
        let fractions: &[f64] =
            if longest == 1.0 && self.largest_turn() < SMALL_TURN { &[1.0] } else { &[1.0, 0.5, 0.25, 0.125] };
        let mut best = (f64::INFINITY, 0.0);
        for fraction in fractions {
            let (energy, _) = self.try_step(problem, state, fraction * longest);
            if energy < best.0 {
                best = (energy, fraction * longest);
            }
        }
        if fractions.len() > 1 || best.1 == 0.0 {
            best.0 = self.try_step(problem, state, best.1).0;
        }
        self.accept(problem, state);
        best.0
    }
}

impl<M: Method> Minimiser for Descent<M> {
    fn name(&self) -> &str {
        M::NAME
    }

    fn accepts(&self, network: &Network) -> Result<(), BuildError> {
        let Some(load) = network.dead_moment() else { return Ok(()) };
        let what =
            format!("load `{}` is a dead moment, which has no potential: {} goes by the energy", load.name, M::NAME);
        Err(BuildError::new(what, "take minimiser.kind = \"newton\", which solves for the balance itself").at("kind"))
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        let network = problem.network;
        if self.workspace.as_ref().is_none_or(|ws| ws.network != network.id) {
            self.workspace = Some(Box::new(Workspace::new(problem, self.choices.metric)));
            self.method.ready(network);
        }
        let ws = self.workspace.as_mut().expect("made above");
        if network.is_shared() {
            // Among the threads of the pool, so that handing them work costs little.
            let (method, choices) = (&mut self.method, &self.choices);
            rayon::scope(|_| descend(ws, method, choices, problem, state, stop))
        } else {
            descend(ws, &mut self.method, &self.choices, problem, state, stop)
        }
    }

    /// Nothing is remembered from call to call.
    fn forget(&mut self) {}
}

/// See [`Minimiser::minimise`].
fn descend(
    ws: &mut Workspace,
    method: &mut impl Method,
    choices: &Choices,
    problem: &mut Problem<'_>,
    state: &mut State,
    stop: &Stop,
) -> Report {
    method.restart();
    let metric = choices.metric == Metric::Hessian;
    let patience = STALLED_AFTER[usize::from(!metric)];
    (ws.evaluations, ws.preconditioner.factorisations) = (0, 0);
    let length = problem.scales().length;
    problem.update_held(state);
    ws.condensed_force = condensed_force(problem, stop);
    ws.preconditioner.weigh(problem);
    let moves = problem.motion(state, &mut ws.motion);
    let mut report = Report::begun(Status::Failed);
    let mut energy;
    if moves && metric {
        energy = ws.predict(problem, state);
        report.iterations += 1;
        if energy.is_infinite() {
            // What is held goes through an obstacle, or drags a cable through one: the increment is too large.
            if problem.monitor.is_stopped() {
                report.status = Status::Interrupted;
            }
            return report;
        }
    } else {
        ws.trial.copy_from(state);
        energy = ws.evaluate(problem, None);
        ws.accept(problem, state);
    }
    // Iterations since the metric was taken: none was yet.
    let mut age = choices.refresh;
    let mut last = None;
    let mut monitor = ConvergenceMonitor::new(stop, patience);
    monitor.begin(ws.residual(problem));
    if report.iterations > 0 {
        trace(problem, &report, [energy, monitor.residual, 1.0, 0.0], ws.preconditioner.factorisations);
    }
    report.status = loop {
        if problem.monitor.iterate(monitor.residual) {
            break Status::Interrupted;
        }
        if let Termination::Stop(status) = monitor.termination(report.iterations) {
            break status;
        }
        if age >= choices.refresh {
            if metric {
                ws.preconditioner.make(problem, state);
                method.metric_changes();
            }
            age = 0;
        }
        let first_slope = ws.direction(method, problem, state, metric);
        report.iterations += 1;
        if !first_slope.is_finite() {
            break Status::Failed;
        }
        let noise = problem.energy_noise(&ws.gradient);
        let first = match last {
            _ if metric || (method.knows_lengths() && !method.is_blank()) => 1.0,
            Some((alpha, slope)) => alpha * slope / first_slope,
            None => (FIRST_MOVE * length / ws.largest_move()).min(1.0),
        };
        let longest = ws.longest(problem, state);
        let wolfe = Wolfe { slope: choices.slope, noise };
        let mut end = (f64::NAN, f64::NAN);
        let found = (first_slope < 0.0).then(|| {
            line_search::search((energy, first_slope), first, longest, wolfe, |alpha| {
                end = ws.try_step(problem, state, alpha);
                end
            })
        });
        let Some(alpha) = found.flatten() else {
            trace(problem, &report, [energy, monitor.residual, 0.0, 0.0], ws.preconditioner.factorisations);
            if !method.is_blank() || age > 0 {
                // What was learnt does not lead down any more: begin anew from here.
                method.restart();
                age = choices.refresh;
                continue;
            }
            if -first_slope > noise {
                break Status::Failed;
            }
            monitor.stall();
            continue;
        };
        last = Some((alpha, first_slope));
        let turn = alpha * ws.largest_turn();
        energy = end.0;
        ws.before.copy_from(&ws.free);
        carry(&mut ws.before, &ws.step, alpha);
        ws.accept(problem, state);
        monitor.moved(turn, -first_slope > noise, ws.residual(problem));
        trace(problem, &report, [energy, monitor.residual, alpha, 0.0], ws.preconditioner.factorisations);
        method.learn(&ws.step, alpha, &ws.free, &ws.before);
        age = if metric && alpha < SHORT { choices.refresh } else { age + 1 };
    };
    report.residual = monitor.residual;
    report.factorisations = ws.preconditioner.factorisations;
    report.evaluations = ws.evaluations;
    report
}
