//! The run of a schedule: from the initial equilibrium through all increments of all steps.

use super::driver::{Driver, empty_run, is_balanced, unbalanced_start_note};
use super::progress::{Control, Interruption, Progress};
use crate::steps::checkpoint::{Observer, Resumed};
use std::borrow::Cow;
use std::time::Instant;
use wireloom_core::Network;
use wireloom_core::equilibrium::{Outcome, Run};
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::status::Status;
use wireloom_core::steps::{Schedule, Step};

/// Remark on forces in balance up to the round-off of stiff parts.
const ROUND_OFF: &str = "forces are in balance up to round-off, which is above force_tolerance: parts of the harness \
                         are very stiff beside what acts on them";

/// Steps of a schedule; one without motions where it has none.
pub fn steps_of(schedule: &Schedule) -> Cow<'_, [Step]> {
    if schedule.steps.is_empty() {
        vec![Step { name: "equilibrium".into(), increments: 1, ..Step::default() }].into()
    } else {
        schedule.steps.as_slice().into()
    }
}

/// Runs a schedule. With the same harness on a `coarse` mesh, the initial equilibrium is searched for there first. The
/// observer sees the end of every increment, may stop the run, and may keep checkpoints; `resumed` continues a run from
/// one of them. The status of the run is that of the first increment that did not converge.
///
/// # Panics
/// If the checkpoint does not fit the network ([`Checkpoint::fits`](crate::steps::checkpoint::Checkpoint::fits)) or the
/// schedule.
pub fn carry_out(
    network: &Network,
    coarse: Option<&Network>,
    minimiser: &mut dyn Minimiser,
    stop: &Stop,
    schedule: &Schedule,
    resumed: Option<Resumed>,
    observer: &mut dyn Observer,
) -> Run {
    let mut run = empty_run(schedule);
    let steps = &steps_of(schedule)[..];
    let monitor = observer.monitor();
    let mut clock = Instant::now();
    let (mut spent, mut first, mut done, mut resumed_plan) = (0.0, 0, 0, None);
    let mut driver = match resumed {
        None => {
            let mut driver = Driver::at_start(network, minimiser, stop, schedule, &monitor);
            let start = driver.find_start(coarse, schedule, &steps[0].name);
            let fault = driver.part_fault(&steps[0], 0);
            if start == Status::Interrupted || fault.is_some() {
                run.outcome = fault.map_or(Outcome::Graded(start.status()), Outcome::Fault);
                driver.log.write_to(network, &mut run);
                return run;
            }
            run.outcome = Outcome::Graded(start.status());
            if start != Status::Converged {
                run.notes.push(unbalanced_start_note(start));
            } else if !schedule.steps.is_empty() {
                run.notes.extend(driver.start_note());
            }
            run.notes.extend(driver.notes_on_start());
            driver
        }
        Some(Resumed { checkpoint, steps }) => {
            let (driver, position) = Driver::at_checkpoint(network, minimiser, stop, checkpoint, &monitor);
            (run.outcome, run.notes, run.steps) = (Outcome::Graded(position.status), position.notes, steps);
            run.steps.truncate(position.kept);
            (spent, first, done, resumed_plan) =
                (position.seconds, position.step_index, position.increment, position.plan);
            driver
        }
    };
    driver.guide = observer.guide();
    for (index, step) in steps.iter().enumerate().skip(first) {
        let _step = tracing::info_span!("step", index, name = step.name).entered();
        let plan = resumed_plan.take().unwrap_or_else(|| {
            driver.minimiser.forget();
            observer.checkpoint(&driver.checkpoint(&run, (index, 0), None, 0.0));
            driver.begin_step(step, index == 0, &mut run.notes)
        });
        // End of the last increment that is not kept by itself; it is kept if the run ends before the next one does.
        let mut latest = (done > 0 && !schedule.increments && !step.keeps(done)).then(|| {
            let status = driver.certify(Status::Stalled);
            driver.step_result(step, done, status, spent)
        });
        for increment in std::mem::take(&mut done) + 1..=step.increments {
            let fraction = |k: usize| k as f64 / step.increments as f64;
            let fractions = [fraction(increment - 1), fraction(increment)];
            let seconds = || spent + clock.elapsed().as_secs_f64();
            let place = (index, increment, increment == step.increments);
            let result = driver.run_increment((step, &plan), place, fractions, schedule.clearances, seconds);
            let end = match result {
                Ok(end) => end,
                Err(interruption) => {
                    run.steps.extend(latest);
                    run.outcome = match interruption {
                        Interruption::Stopped => Outcome::Graded(Status::Interrupted),
                        Interruption::Fault(fault) => Outcome::Fault(fault),
                    };
                    driver.log.write_to(network, &mut run);
                    return run;
                }
            };
            let status = end.status;
            let progress = Progress {
                step: step.name.clone(),
                step_index: index,
                steps: steps.len(),
                increment,
                increments: step.increments,
                iterations: driver.iterations,
            };
            let unbalanced = !is_balanced(status);
            let kept = schedule.increments || step.keeps(increment) || unbalanced;
            observer.state(&driver.state, &driver.errors);
            let stopped = observer.increment(&progress, &end, kept) == Control::Stop;
            if (index, increment) == (0, 1) || run.status() == Status::Converged {
                run.outcome = Outcome::Graded(status);
            }
            let complete = index + 1 == steps.len() && increment == step.increments;
            // An earlier failure takes precedence over the stop.
            if stopped && is_balanced(run.status()) && !complete {
                run.outcome = Outcome::Graded(Status::Interrupted);
            }
            latest = if kept || stopped {
                run.steps.push(end);
                None
            } else {
                Some(end)
            };
            if unbalanced || stopped {
                driver.log.write_to(network, &mut run);
                return run;
            }
            if driver.round_off && !run.notes.iter().any(|note| note == ROUND_OFF) {
                run.notes.push(ROUND_OFF.to_owned());
            }
            if increment < step.increments {
                driver.minimiser.forget();
                let seconds = spent + clock.elapsed().as_secs_f64();
                observer.checkpoint(&driver.checkpoint(&run, (index, increment), Some(&plan), seconds));
            }
        }
        let (iterations, factorisations) = (driver.iterations, driver.factorisations);
        tracing::info!(target: "wireloom::step", iterations, factorisations);
        (clock, spent) = (Instant::now(), 0.0);
        (driver.iterations, driver.polish, driver.factorisations) = (0, 0, 0);
    }
    driver.log.write_to(network, &mut run);
    run
}
