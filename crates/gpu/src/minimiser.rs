//! The minimiser `gpu`: Newton's method with every number on the device.
//!
//! Per increment: the conditions and the state go up, one submission holds as many cycles as are likely to be needed (a cycle is an
//! iteration or a shorter trial of its step), and where every variable is comes back. The host grades what came back in f64; where that is not
//! balanced to the tolerance, and `polish` allows it, a minimiser of the CPU goes on from there, and the report says so.

use crate::device::{Gpu, OpenError};
use crate::flatten::{self, Flattening};
use crate::session::{Session, TooLarge};
use std::sync::{Arc, OnceLock};
use wireloom_core::minimiser::{Minimiser, Report, Status, Stop};
use wireloom_core::registry::{BuildError, Form, MinimiserKind, Parameter, Parameters, Value};
use wireloom_core::{Network, Problem, State, Tangent};
use wireloom_shaders::Real;
use wireloom_shaders::harness;
use wireloom_shaders::memory::Memory;
use wireloom_shaders::places::{Outcome, Phase};
use wireloom_shaders::plan::Plan;

/// Cycles of the first submission for a harness.
const FIRST_CYCLES: usize = 12;
/// Most cycles of one submission: at a few hundred dispatches each, far from what a driver takes for a hanging device.
const MOST_CYCLES: usize = 64;
/// Variables that one invocation eliminates: few, for one harness is to keep the whole device busy.
const LEAF: usize = 8;
/// More cycles than what was needed the last time.
const SPARE_CYCLES: usize = 2;

/// The device of a program: opened once, when it is first wanted, and shared by all minimisers.
#[derive(Clone, Default)]
pub struct Devices {
    wish: Option<String>,
    opened: Arc<OnceLock<Result<Arc<Gpu>, OpenError>>>,
}

impl Devices {
    /// The device of this name or number; see [`Gpu::open`].
    pub fn wishing(wish: Option<&str>) -> Self {
        Self { wish: wish.map(str::to_owned), opened: Arc::default() }
    }

    /// The device.
    ///
    /// # Errors
    /// What kept it from being opened, the same every time.
    pub fn get(&self) -> Result<Arc<Gpu>, OpenError> {
        self.opened.get_or_init(|| Gpu::open(self.wish.as_deref()).map(Arc::new)).clone()
    }
}

/// Makes the minimiser that finishes what the device could not.
pub type Polisher = fn() -> Box<dyn Minimiser>;

/// The kind `gpu`, on one of the machine's devices.
pub fn kind(devices: Devices, polisher: Polisher) -> MinimiserKind {
    let choice = |words: &[&str]| Form::Choice(words.iter().map(|word| (*word).to_owned()).collect());
    let parameter = |name: &str, doc: &str, form: Form, default: Value| Parameter {
        name: name.into(),
        doc: doc.into(),
        form,
        default: Some(default),
        required: false,
    };
    MinimiserKind {
        name: "gpu".into(),
        doc: "Newton on a GPU, with a direct factorisation in levels along the graph; needs laws that shaders know"
            .into(),
        parameters: vec![
            parameter(
                "precision",
                "numbers on the device: auto is f64 where it has it",
                choice(&["auto", "f64", "f32"]),
                Value::Word("auto".into()),
            ),
            parameter(
                "polish",
                "whether the CPU (newton) finishes what the device left above the tolerance",
                Form::Flag,
                Value::Flag(true),
            ),
        ],
        build: Box::new(move |(), parameters| build(&devices, parameters, polisher)),
    }
}

fn build(devices: &Devices, parameters: &Parameters, polisher: Polisher) -> Result<Box<dyn Minimiser>, BuildError> {
    let gpu = devices.get().map_err(|error| BuildError::new(error.to_string(), error.help()).at("kind"))?;
    let real = match parameters.word("precision") {
        Some("f32") => Real::F32,
        Some("f64") if !gpu.listed.double => {
            return Err(BuildError::new(
                format!("device `{}` has no double precision", gpu.listed.name),
                "precision = \"auto\" takes what the device has, and the CPU finishes",
            )
            .at("precision"));
        }
        _ if gpu.listed.double => Real::F64,
        _ => Real::F32,
    };
    let polish = parameters.flag("polish") != Some(false);
    Ok(Box::new(GpuMinimiser::new(gpu, real, polish.then(polisher))))
}

/// Newton's method on a device; see the page.
pub struct GpuMinimiser {
    gpu: Arc<Gpu>,
    real: Real,
    polisher: Option<Box<dyn Minimiser>>,
    workspace: Option<Box<Workspace>>,
    fault: Option<String>,
}

/// What is made once for a network.
struct Workspace {
    network: u64,
    flattening: Flattening,
    real: Real,
    plan: Plan,
    memory: Memory,
    session: Session,
    /// Cycles of the next submission.
    cycles: usize,
    gradient: Tangent,
}

impl GpuMinimiser {
    /// On a device, in a precision that it has; `polisher` finishes what it could not.
    pub fn new(gpu: Arc<Gpu>, real: Real, polisher: Option<Box<dyn Minimiser>>) -> Self {
        Self { gpu, real, polisher, workspace: None, fault: None }
    }

    /// Brings the state down on the device. `None`: the device failed.
    fn descend(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Option<Report> {
        problem.update_held(state);
        if self.workspace.as_ref().is_none_or(|ws| ws.network != problem.network.id) {
            match Workspace::new(&self.gpu, self.real, problem, state) {
                Ok(made) => self.workspace = Some(Box::new(made)),
                Err(error) => {
                    self.fault = Some(error.to_string());
                    return None;
                }
            }
        }
        let ws = self.workspace.as_mut().expect("made above");
        let report = ws.descend(&self.gpu, problem, state, stop);
        if report.is_none() {
            self.fault = self.gpu.failure();
        }
        report
    }
}

impl Workspace {
    fn new(gpu: &Gpu, real: Real, problem: &Problem<'_>, state: &State) -> Result<Self, TooLarge> {
        let network = problem.network;
        let flattening = Flattening::new(network);
        let harness = flattening.harness(problem, state);
        let plan = Plan::new(harness.links(), LEAF);
        let memory = Memory::new(&plan, 1);
        let session = Session::new(gpu, real, &plan, &memory)?;
        let gradient = Tangent::zeros(network);
        Ok(Self { network: network.id, flattening, real, plan, memory, session, cycles: FIRST_CYCLES, gradient })
    }

    fn descend(&mut self, gpu: &Gpu, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Option<Report> {
        let scales = problem.scales();
        let own = harness::Stop {
            force_scale: scales.force,
            moment_scale: scales.moment,
            length_scale: scales.length,
            tolerance: stop.force_tolerance,
            max_iterations: stop.max_iterations as u32,
        };
        let harness = self.flattening.harness(problem, state);
        self.memory.set_harness(&self.plan, 0, &harness).expect("the links of a network never change");
        self.memory.set_shape(&self.plan, 0, &self.flattening.shape(state));
        self.memory.begin(0, &own, self.real);
        self.session.upload(gpu, &self.memory);
        let mut cycles = self.cycles;
        loop {
            if !self.session.run(gpu, cycles, &mut self.memory) {
                return None;
            }
            if self.memory.control[0].phase == Phase::Done as u32 {
                break;
            }
            cycles = (2 * cycles).min(MOST_CYCLES);
        }
        let control = &self.memory.control[0];
        self.cycles = (control.evaluations as usize + SPARE_CYCLES).clamp(FIRST_CYCLES / 2, MOST_CYCLES);
        self.flattening.put(&self.memory.shape(&self.plan, 0), problem.network, state);
        problem.update_held(state);
        problem.place_held(state);
        problem.gradient(state, &mut self.gradient);
        problem.free_part(&mut self.gradient);
        let residual = problem.residual(&self.gradient, &scales);
        let ended = |outcome: Outcome| control.outcome == outcome as u32;
        let status = match () {
            () if !residual.is_finite() => Status::Failed,
            () if residual <= stop.force_tolerance => Status::Converged,
            // In its own view; single precision does not see what is left.
            () if ended(Outcome::Converged) || ended(Outcome::Stalled) => Status::Stalled,
            () if ended(Outcome::IterationLimit) => Status::IterationLimit,
            () => Status::Failed,
        };
        Some(Report {
            status,
            iterations: control.iterations as usize,
            polish: 0,
            factorisations: control.factorisations as usize,
            evaluations: control.evaluations as usize,
            residual,
        })
    }
}

impl Minimiser for GpuMinimiser {
    fn name(&self) -> &str {
        "gpu"
    }

    fn accepts(&self, network: &Network) -> Result<(), BuildError> {
        flatten::accepts(network)
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        let Some(mut report) = self.descend(problem, state, stop) else {
            let nothing = Report {
                status: Status::Failed,
                iterations: 0,
                polish: 0,
                factorisations: 0,
                evaluations: 0,
                residual: f64::INFINITY,
            };
            return nothing;
        };
        let left = stop.max_iterations.saturating_sub(report.iterations);
        if let (Some(polisher), true) = (&mut self.polisher, report.status != Status::Converged && left > 0) {
            // From nowhere but where the state is: the same bits whatever was polished before.
            polisher.forget();
            let polish = polisher.minimise(problem, state, &Stop { max_iterations: left, ..*stop });
            report = Report {
                status: polish.status,
                iterations: report.iterations + polish.iterations,
                polish: polish.iterations,
                factorisations: report.factorisations + polish.factorisations,
                evaluations: report.evaluations + polish.evaluations,
                residual: polish.residual,
            };
        }
        report
    }

    fn forget(&mut self) {
        if let Some(ws) = &mut self.workspace {
            ws.cycles = FIRST_CYCLES;
        }
    }

    fn fault(&self) -> Option<String> {
        self.fault.clone()
    }
}
