//! Wireloom: scenario text in, equilibria out.

pub mod bench;
mod provenance;
mod start;
pub mod sweep;
mod targets;

pub use provenance::{provenance, sha256};
pub use wireloom_contact as contact;
pub use wireloom_core as core;
pub use wireloom_export as export;
pub use wireloom_gpu as gpu;
pub use wireloom_host as host;
pub use wireloom_import as import;
pub use wireloom_models as models;
pub use wireloom_scenario as scenario;
pub use wireloom_solve as solve;
pub use wireloom_testkit as testkit;

use wireloom_core::Registry;

/// All built-in kinds; the minimiser `gpu` takes the fastest device of the machine, if it is asked for.
pub fn registry() -> Registry {
    registry_on(gpu::SharedDevice::for_single_runs(None))
}

/// All built-in kinds; `gpu` on a device of choice.
///
/// # Panics
/// Never: built-ins have names of their own.
pub fn registry_on(devices: gpu::SharedDevice) -> Registry {
    let mut registry = Registry::default();
    models::register(&mut registry);
    contact::register(&mut registry);
    solve::register(&mut registry);
    let gpu = gpu::kind(devices, || Box::new(solve::newton::Newton::new()));
    registry.add_minimiser(gpu).map_err(|_| "built-ins are registered first").unwrap();
    registry
}

use wireloom_core::equilibrium::{Run, StepResult};
use wireloom_scenario::{Built, Fault, Files, Scenario, Setting};
use wireloom_solve::checkpoint::{Observer, Resumed, Watching};
use wireloom_solve::{Control, Progress};

/// The text of a scenario that names no other files, checked and built.
///
/// # Errors
/// All faults of the text at once, each with its place.
pub fn load(text: &str, registry: &Registry) -> Result<(Scenario, Built), Vec<Fault>> {
    load_with_files(text, &scenario::NoFiles, registry)
}

/// A scenario's text, checked and built; the files it names are read through `files`.
///
/// # Errors
/// All faults of the text at once, each with its place.
pub fn load_with_files(text: &str, files: &dyn Files, registry: &Registry) -> Result<(Scenario, Built), Vec<Fault>> {
    load_with_settings(text, &[], files, registry)
}

/// A scenario's text in which `settings` take the place of what it says, checked and built.
///
/// # Errors
/// All faults at once; those of what is set have places after the end of the text: see [`scenario::settings::apart`].
pub fn load_with_settings(
    text: &str,
    settings: &[Setting],
    files: &dyn Files,
    registry: &Registry,
) -> Result<(Scenario, Built), Vec<Fault>> {
    let (scenario, built) = scenario::build_with_settings(text, settings, files, registry)?;
    let faults: Vec<Fault> =
        start::refuse_inside(&scenario, &built).into_iter().chain(targets::refuse_inside(&scenario, &built)).collect();
    if faults.is_empty() { Ok((scenario, built)) } else { Err(faults) }
}

/// Carries out a built scenario. The observer sees every increment's end and may stop the run; what was computed is
/// kept. Not converging is a status of the run, not an error.
///
/// ```
/// let text = r#"
/// schema = 1
/// name = "cable"
/// [sections.cable]
/// diameter = "6 mm"
/// linear_density = "50 g/m"
/// axial_stiffness = 1e4
/// bending_stiffness = 0.01
/// torsion_stiffness = 0.008
/// [[branches]]
/// name = "cable"
/// from = "A"
/// to = "B"
/// section = "cable"
/// length = "1 m"
/// segments = 40
/// [[constraints]]
/// name = "plug-A"
/// kind = "connector"
/// at = { end = "A" }
/// position = [0, 0, 0]
/// tangent = [1, 0, 0]
/// up = [0, 0, 1]
/// [[constraints]]
/// name = "plug-B"
/// kind = "connector"
/// at = { end = "B" }
/// position = ["600 mm", 0, 0]
/// tangent = [1, 0, 0]
/// up = [0, 0, 1]
/// "#;
/// let registry = wireloom::registry();
/// let (_, built) = wireloom::load(text, &registry).expect("no faults");
/// let run = wireloom::run(built, &mut |_, _| wireloom::solve::Control::Continue);
/// assert_eq!(run.status, wireloom::core::Status::Converged);
/// let cable = &run.steps[0].branches[0];
/// assert!(cable.position[20].z < -0.34, "it sags");
/// ```
pub fn run(built: Built, observer: &mut dyn FnMut(&Progress, &StepResult) -> Control) -> Run {
    run_observed(built, None, &mut Watching(observer))
}

/// As [`run`], with an observer who may keep checkpoints; from `resumed` it goes on with a run that one of them kept, to the
/// same bits as if there had been no interruption.
///
/// # Panics
/// If the checkpoint is not one of a run of the same scenario; see [`solve::checkpoint::Checkpoint::fits`].
pub fn run_observed(built: Built, resumed: Option<Resumed>, observer: &mut dyn Observer) -> Run {
    let Built { network, coarse, schedule, mut minimiser, stop, notes, .. } = built;
    let mut run = solve::carry_out(&network, coarse.as_ref(), minimiser.as_mut(), &stop, &schedule, resumed, observer);
    run.notes.splice(0..0, notes);
    run
}
