//! Gradient minimisers: common iteration of `lbfgs` and `ncg`.
//!
//! Per iteration: a direction from the gradient, a metric and the memory of the method ([`Method`]), a line search
//! ([`super::line_search`]), and the parallel transport of that memory to the new state ([`super::transport`]).
//!
//! The metric ([`Metric`]) is by default the factorised Hessian of the first state. It is recomputed every few
//! iterations and after short steps. With it the first step contains the prescribed motion, as in [`super::newton`],
//! and after every step the points are condensed ([`super::condensation`]), so that the energy is minimised over the
//! frames only. Without a metric the methods are those of the textbooks, in metres and radians.

use super::step_control::{LARGEST_TURN, SMALL_TURN, condensed_force, in_pool};
use super::trace::trace;
use crate::minimisers::condensation::Condensation;
use crate::minimisers::convergence::{ConvergenceMonitor, Termination};
use crate::minimisers::line_search::{self, Wolfe};
use crate::minimisers::preconditioner::{Metric, Preconditioner};
use crate::minimisers::transport::{slope, transport};
use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::problem::Problem;
use wireloom_core::registry::{BuildError, Form, MinimiserKind, Parameter, Parameters, Quantity, Value};
use wireloom_core::status::Status;
use wireloom_core::{Network, State, Tangent, Vector};

/// Number of iterations without progress at round-off after which the minimiser has stalled: with a metric, and
/// without, where convergence is slow.
const STALLED_AFTER: [usize; 2] = [4, 500];
/// Step length, relative to the step of the metric, below which the metric is recomputed.
const SHORT: f64 = 0.25;
/// Largest move of a point in the first trial without a known step length, as a fraction of the longest branch.
const FIRST_MOVE: f64 = 0.01;
/// Fractions of the longest step of which the first step of an increment takes the one of least energy. A short step in
/// the range of the linear model is taken as it is: see [`SMALL_TURN`].
const PREDICTION_FRACTIONS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];
/// Range of the option `slope`: near 0 a search takes many trials, at 1 any descent would be accepted.
const SLOPE_RANGE: [f64; 2] = [1e-3, 0.99];

/// Direction of a gradient method, from the gradient, the metric and the memory of previous steps.
pub(crate) trait Method: Send {
    /// Name of the minimiser.
    const NAME: &'static str;
    /// Allocates the memory for a network.
    fn allocate(&mut self, network: &Network);
    /// Clears the memory.
    fn restart(&mut self);
    /// Whether the memory is empty.
    fn is_blank(&self) -> bool;
    /// Transports the memory along the accepted `α step`, and adds the change of the gradient: `gradient` at the end
    /// of the step, `before` at its beginning, transported to the end.
    fn learn(&mut self, step: &Tangent, alpha: f64, gradient: &Tangent, before: &Tangent);
    /// Direction for a free gradient; `solve` applies `−M⁻¹`.
    fn direction(&mut self, gradient: &Tangent, solve: &mut dyn FnMut(&Tangent, &mut Tangent), step: &mut Tangent);
    /// Whether a step length of 1 is meaningful without a metric.
    fn knows_lengths(&self) -> bool;
    /// Called when the metric is recomputed.
    fn metric_changes(&mut self);
}

/// Options common to both methods.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    pub metric: Metric,
    /// Number of iterations after which the metric is recomputed.
    pub refresh: usize,
    /// σ of the line search.
    pub slope: f64,
}

impl Options {
    /// Declaration of the options; `slope` is the default of σ.
    pub(crate) fn parameters(slope: f64) -> Vec<Parameter> {
        let optional = |name: &str, doc: &str, form, default| Parameter {
            name: name.into(),
            doc: doc.into(),
            form,
            default: Some(default),
            required: false,
        };
        let fraction = Form::Number {
            quantity: Quantity::Dimensionless,
            minimum: SLOPE_RANGE[0],
            exclusive: false,
            maximum: SLOPE_RANGE[1],
        };
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

    /// Options from values that were checked against the declaration.
    pub(crate) fn from(parameters: &Parameters, slope: f64) -> Self {
        Self {
            metric: parameters.word("preconditioner").and_then(Metric::from_word).unwrap_or(Metric::Hessian),
            refresh: parameters.count("refresh").unwrap_or(REFRESH),
            slope: parameters.number("slope").unwrap_or(slope),
        }
    }
}

/// Default of `refresh`: a factorisation costs about three evaluations.
const REFRESH: usize = 8;

/// Kind of minimiser with the common options and one of its own.
pub(crate) fn kind<M: Method + 'static>(
    doc: &str,
    slope: f64,
    own: Parameter,
    method: impl Fn(&Parameters) -> M + Send + Sync + 'static,
) -> MinimiserKind {
    let mut parameters = Options::parameters(slope);
    parameters.push(own);
    MinimiserKind {
        name: M::NAME.into(),
        doc: doc.into(),
        parameters,
        build: Box::new(move |(), given| {
            Ok(Box::new(Descent { method: method(given), options: Options::from(given, slope), workspace: None }))
        }),
    }
}

/// Gradient minimiser, with its workspace.
pub(crate) struct Descent<M> {
    method: M,
    options: Options,
    workspace: Option<Box<Workspace>>,
}

/// Data that is allocated once per network.
struct Workspace {
    network: u64,
    preconditioner: Preconditioner,
    /// Static condensation of the points, if the metric is the Hessian.
    condensation: Option<Condensation>,
    gradient: Tangent,
    /// Free part of the gradient.
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

    /// Energy and gradient at the trial, with held freedoms at their targets and points condensed; infinite if a cable
    /// would pass through an obstacle between `from` and the trial, or if a stop was requested.
    fn evaluate(&mut self, problem: &mut Problem<'_>, from: Option<&State>) -> f64 {
        problem.place_held(&mut self.trial);
        let collides = from.is_some_and(|from| problem.collision_free_fraction(from, &self.trial, None) < 1.0);
        if collides || problem.monitor.is_stopped() {
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

    /// Computes the next direction, in `step`. Returns the slope along it.
    fn direction(&mut self, method: &mut impl Method, problem: &mut Problem<'_>, state: &State, metric: bool) -> f64 {
        let Self { preconditioner, gradient, free, step, .. } = self;
        // The whole gradient decides whether a slide is at its stop.
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

    /// First step of an increment, with the metric of the old state and the prescribed motion: the whole step if it is
    /// small, else the one of least energy among it and shorter ones. Returns the energy after it.
    fn predict(&mut self, problem: &mut Problem<'_>, state: &mut State) -> f64 {
        problem.gradient(state, &mut self.gradient);
        self.preconditioner.refresh(problem, state);
        let Self { preconditioner, gradient, motion, step, .. } = self;
        preconditioner.solve_moving(problem, state, gradient, Some(motion), step);
        let longest = self.longest(problem, state).min(1.0);
        let fractions: &[f64] =
            if longest == 1.0 && self.largest_turn() < SMALL_TURN { &[1.0] } else { &PREDICTION_FRACTIONS };
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
        let Some((load, why)) = network.load_without_potential() else { return Ok(()) };
        let what = format!("load `{}` {why}, which has no potential: {} goes by the energy", load.name, M::NAME);
        Err(BuildError::new(what, "take minimiser.kind = \"newton\", which solves for the balance itself").at("kind"))
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        let network = problem.network;
        if self.workspace.as_ref().is_none_or(|ws| ws.network != network.id) {
            self.workspace = Some(Box::new(Workspace::new(problem, self.options.metric)));
            self.method.allocate(network);
        }
        let ws = self.workspace.as_mut().expect("made above");
        in_pool(network, || descend(ws, &mut self.method, &self.options, problem, state, stop))
    }

    /// Does nothing: no memory is kept between calls.
    fn forget(&mut self) {}
}

/// See [`Minimiser::minimise`].
fn descend(
    ws: &mut Workspace,
    method: &mut impl Method,
    options: &Options,
    problem: &mut Problem<'_>,
    state: &mut State,
    stop: &Stop,
) -> Report {
    method.restart();
    let metric = options.metric == Metric::Hessian;
    let patience = STALLED_AFTER[usize::from(!metric)];
    (ws.evaluations, ws.preconditioner.factorisations) = (0, 0);
    let length = problem.scales().length;
    problem.update_held(state);
    ws.condensed_force = condensed_force(problem, stop);
    ws.preconditioner.update_weights(problem);
    let moves = problem.motion(state, &mut ws.motion);
    let mut report = Report::begun(Status::Failed);
    let mut energy;
    if moves && metric {
        energy = ws.predict(problem, state);
        report.iterations += 1;
        if energy.is_infinite() {
            // The prescribed motion moves a cable through an obstacle: the increment is too large.
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
    // Iterations since the metric was computed; it is not yet.
    let mut age = options.refresh;
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
        if age >= options.refresh {
            if metric {
                ws.preconditioner.refresh(problem, state);
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
        let wolfe = Wolfe { slope: options.slope, noise };
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
                // The memory or the metric does not lead downhill any more: restart from here.
                method.restart();
                age = options.refresh;
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
        transport(&mut ws.before, &ws.step, alpha);
        ws.accept(problem, state);
        monitor.moved(turn, -first_slope > noise, ws.residual(problem));
        trace(problem, &report, [energy, monitor.residual, alpha, 0.0], ws.preconditioner.factorisations);
        method.learn(&ws.step, alpha, &ws.free, &ws.before);
        age = if metric && alpha < SHORT { options.refresh } else { age + 1 };
    };
    report.residual = monitor.residual;
    report.factorisations = ws.preconditioner.factorisations;
    report.evaluations = ws.evaluations;
    report
}
