//! The minimiser `gpu`: Newton's method entirely on the device.
//!
//! For each increment the conditions and the state are uploaded; one submission holds as many cycles as are probably
//! needed (a cycle is an iteration, or a shorter trial of its step); then the final state is read back. The host checks
//! its residual in f64. If it is above the tolerance and `polish` is set, a CPU minimiser continues, and the report
//! says so. The shaders have the scheme of second order: on meshes that are fine enough for the fourth
//! ([`wireloom_core::rod::Mesh::pairs`]) the CPU always makes the last iterations.

use crate::batch::{Batch, Job, Solution};
use crate::device::{Gpu, OpenError};
use crate::flatten::{self, Flattening};
use std::sync::{Arc, OnceLock};
use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::registry::{BuildError, Form, MinimiserKind, Parameter, Parameters, Value};
use wireloom_core::status::Status;
use wireloom_core::{Network, Problem, State, Tangent};
use wireloom_shaders::Real;
use wireloom_shaders::harness::{self, Algorithm};
use wireloom_shaders::layout::Outcome;
use wireloom_shaders::memory;

/// Largest number of variables that an invocation eliminates in sequence, if one harness is to use the whole device.
const LEAF: usize = 8;

/// Relative residual at which single precision stops: the CPU needs one or two more steps from there, which round-off
/// would hide from the device.
const SINGLE_TOLERANCE: f64 = 1e-4;

/// The device of a program: opened at its first use and shared by all minimisers.
#[derive(Clone)]
pub struct SharedDevice {
    selector: Option<String>,
    opened: Arc<OnceLock<Result<Arc<Gpu>, OpenError>>>,
    batch: Arc<Batch>,
}

impl SharedDevice {
    /// The device with this name or index (see [`Gpu::open`]), for one harness at a time.
    pub fn for_single_runs(selector: Option<&str>) -> Self {
        Self { selector: selector.map(str::to_owned), opened: Arc::default(), batch: Arc::new(Batch::new(LEAF)) }
    }

    /// The same device, for batches of many harnesses.
    pub fn for_batches(&self) -> Self {
        Self { batch: Arc::new(Batch::new(usize::MAX)), ..self.clone() }
    }

    /// The device, opened at the first call.
    ///
    /// # Errors
    /// Why it could not be opened; the same at every call.
    pub fn get(&self) -> Result<Arc<Gpu>, OpenError> {
        self.opened.get_or_init(|| Gpu::open(self.selector.as_deref()).map(Arc::new)).clone()
    }

    /// The batch of this device's harnesses.
    pub fn batch(&self) -> &Batch {
        &self.batch
    }
}

/// Creates the CPU minimiser that reduces the residual further.
pub type Polisher = fn() -> Box<dyn Minimiser>;

/// The kind `gpu` on this device.
pub fn kind(devices: SharedDevice, polisher: Polisher) -> MinimiserKind {
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
        doc:
            "Newton on a GPU, with a direct factorisation by levels of the graph; needs parts that the shaders support"
                .into(),
        parameters: vec![
            parameter(
                "precision",
                "precision on the device: auto is f64 if supported",
                choice(&["auto", "f64", "f32"]),
                Value::Word("auto".into()),
            ),
            parameter(
                "algorithm",
                "newton: a new matrix for every step; gradient: conjugate gradients, preconditioned by an older matrix",
                choice(&["newton", "gradient"]),
                Value::Word("newton".into()),
            ),
            parameter(
                "polish",
                "whether the CPU (newton) continues if the residual is above the tolerance",
                Form::Flag,
                Value::Flag(true),
            ),
        ],
        build: Box::new(move |(), parameters| build(&devices, parameters, polisher)),
    }
}

fn build(
    devices: &SharedDevice,
    parameters: &Parameters,
    polisher: Polisher,
) -> Result<Box<dyn Minimiser>, BuildError> {
    let gpu = devices.get().map_err(|error| BuildError::new(error.to_string(), error.help()).at("kind"))?;
    let real = match parameters.word("precision") {
        Some("f32") => Real::F32,
        Some("f64") if !gpu.info.double => {
            return Err(BuildError::new(
                format!("device `{}` has no double precision", gpu.info.name),
                "precision = \"auto\" uses what the device supports; the CPU continues from there",
            )
            .at("precision"));
        }
        _ if gpu.info.double => Real::F64,
        _ => Real::F32,
    };
    let algorithm = match parameters.word("algorithm") {
        Some("gradient") => Algorithm::Gradient,
        _ => Algorithm::Newton,
    };
    let polish = parameters.flag("polish") != Some(false);
    let batch = Arc::clone(&devices.batch);
    Ok(Box::new(GpuMinimiser::new(gpu, batch, real, polish.then(polisher)).with_algorithm(algorithm)))
}

/// Newton's method on a device; see the module.
pub struct GpuMinimiser {
    gpu: Arc<Gpu>,
    batch: Arc<Batch>,
    real: Real,
    algorithm: Algorithm,
    polisher: Option<Box<dyn Minimiser>>,
    workspace: Option<Workspace>,
    fault: Option<String>,
}

/// Data that depends on the network only.
struct Workspace {
    network: u64,
    flattening: Flattening,
    gradient: Tangent,
}

impl GpuMinimiser {
    /// On a device, in a supported precision; `polisher` reduces the residual further.
    pub fn new(gpu: Arc<Gpu>, batch: Arc<Batch>, real: Real, polisher: Option<Box<dyn Minimiser>>) -> Self {
        Self { gpu, batch, real, algorithm: Algorithm::Newton, polisher, workspace: None, fault: None }
    }

    /// Selects the algorithm.
    pub fn with_algorithm(self, algorithm: Algorithm) -> Self {
        Self { algorithm, ..self }
    }

    /// Minimises on the device.
    ///
    /// # Errors
    /// The failure of the device; the state is unchanged.
    fn descend(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Result<Report, String> {
        problem.update_held(state);
        let network = problem.network;
        let ws = self.workspace.take().filter(|ws| ws.network == network.id);
        let made = || Workspace {
            network: network.id,
            flattening: Flattening::new(network),
            gradient: Tangent::zeros(network),
        };
        let ws = self.workspace.insert(ws.unwrap_or_else(made));
        let scales = problem.least_scales();
        let tolerance = match (self.real, &self.polisher) {
            (Real::F32, Some(_)) => stop.force_tolerance.max(SINGLE_TOLERANCE),
            _ => stop.force_tolerance,
        };
        let harness = ws.flattening.harness(problem, state);
        let plan = self.batch.plan(harness.topology());
        let packed = memory::pack(&plan, &harness, &ws.flattening.shape(state), self.real);
        let job = Job {
            real: self.real,
            plan: Arc::clone(&plan),
            moves: harness.moves(),
            packed: packed.expect("the plan is that of its topology"),
            stop: harness::Stop {
                force_scale: scales.force,
                moment_scale: scales.moment,
                length_scale: scales.length,
                tolerance,
                max_iterations: u32::try_from(stop.max_iterations).unwrap_or(u32::MAX),
                algorithm: self.algorithm,
            },
            monitor: problem.monitor.clone(),
        };
        let Solution { control, state: found } = self.batch.descend(&self.gpu, job)?;
        ws.flattening.write_back(&memory::unpack_shape(&plan, &found, self.real), network, state);
        problem.update_held(state);
        problem.place_held(state);
        problem.gradient(state, &mut ws.gradient);
        problem.free_part(&mut ws.gradient);
        let residual = problem.residual(&ws.gradient);
        let ended = |outcome: Outcome| control.outcome == outcome as u32;
        let status = match () {
            () if problem.monitor.iterate(residual) => Status::Interrupted,
            () if !residual.is_finite() => Status::Failed,
            () if residual <= stop.force_tolerance => Status::Converged,
            // Converged as the device sees it; single precision does not see the remaining residual.
            () if ended(Outcome::Converged) || ended(Outcome::Stalled) => Status::Stalled,
            () if ended(Outcome::IterationLimit) => Status::IterationLimit,
            () => Status::Failed,
        };
        Ok(Report {
            status,
            iterations: control.iterations as usize,
            polish: 0,
            factorisations: control.factorisations as usize,
            evaluations: control.evaluations as usize,
            residual,
            convex: false,
        })
    }
}

impl Minimiser for GpuMinimiser {
    fn name(&self) -> &str {
        "gpu"
    }

    fn accepts(&self, network: &Network) -> Result<(), BuildError> {
        // The device has what the law of a rod says but for the parts of fourth order, which the CPU adds.
        let fine =
            network.branches.iter().find(|branch| branch.rod.couples_pairs() && !branch.rod.mesh().pairs.is_empty());
        if let (None, Some(branch)) = (&self.polisher, fine) {
            return Err(BuildError::new(
                format!("branch `{}` is of fourth order, the device computes with second order", branch.name),
                "polish = true: the CPU completes what the device finds",
            )
            .at("polish"));
        }
        flatten::accepts(network)
    }

    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report {
        let before = state.clone();
        let mut report = match self.descend(problem, state, stop) {
            Ok(report) => report,
            Err(failure) => {
                self.fault = Some(failure);
                return Report::begun(Status::Failed);
            }
        };
        let Some(polisher) = &mut self.polisher else { return report };
        // A lost device gives no state, and its last state may be a poor start: the CPU then starts from the beginning
        // of the increment.
        let from_device = report.status == Status::Stalled;
        for go_on in [from_device, false].into_iter().skip(usize::from(!from_device)) {
            if matches!(report.status, Status::Converged | Status::Interrupted) {
                break;
            }
            if !go_on {
                state.copy_from(&before);
            }
            // The result must not depend on earlier polishing.
            polisher.forget();
            let polish = polisher.minimise(problem, state, stop);
            report = Report {
                status: polish.status,
                iterations: report.iterations + polish.iterations,
                polish: report.polish + polish.iterations,
                factorisations: report.factorisations + polish.factorisations,
                evaluations: report.evaluations + polish.evaluations,
                residual: polish.residual,
                convex: report.convex && polish.convex,
            };
        }
        report
    }

    /// It stores nothing that an equilibrium depends on.
    fn forget(&mut self) {}

    fn device(&self) -> Option<String> {
        let precision = match self.real {
            Real::F32 => "f32",
            Real::F64 => "f64",
        };
        Some(format!("{}, {precision}", self.gpu.info.name))
    }

    fn fault(&self) -> Option<String> {
        self.fault.clone()
    }
}
