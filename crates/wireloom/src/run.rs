//! From a built scenario to its equilibria.

use wireloom_core::equilibrium::{Run, StepResult};
use wireloom_scenario::Built;
use wireloom_solve::steps::checkpoint::{IncrementObserver, Observer, Resumed};
use wireloom_solve::{Control, Progress};

/// Carries out the steps of a built scenario. `observer` is called at the end of every increment and may stop the run;
/// what has been computed is kept. Not converging is a status of the run, not an error. See the [first page](crate) for
/// an example.
pub fn run(built: Built, observer: &mut dyn FnMut(&Progress, &StepResult) -> Control) -> Run {
    run_observed(built, None, &mut IncrementObserver(observer))
}

/// Carries out a built scenario as [`run`] does, with an observer that may keep checkpoints. With `resumed` it
/// continues a run from one of them, to the same bits as without an interruption. See [`session`](crate::session) for
/// an example.
///
/// # Panics
/// If the checkpoint is not one of a run of the same scenario; see
/// [`Checkpoint::fits`](wireloom_solve::steps::checkpoint::Checkpoint::fits).
pub fn run_observed(built: Built, resumed: Option<Resumed>, observer: &mut dyn Observer) -> Run {
    let Built { network, coarse, schedule, mut minimiser, stop, notes, .. } = built;
    let minimiser = minimiser.as_mut();
    let mut run = wireloom_solve::carry_out(&network, coarse.as_ref(), minimiser, &stop, &schedule, resumed, observer);
    run.notes.splice(0..0, notes);
    run
}
