//! Trace of the minimisers: one event for each iteration.

use wireloom_core::Problem;
use wireloom_core::minimiser::Report;

/// Emits the event of an iteration: energy (J), residual, step length and shift after it; the length is 0 if no step
/// was found.
pub(super) fn trace(
    problem: &Problem<'_>,
    report: &Report,
    [energy, residual, step, shift]: [f64; 4],
    factorisations: usize,
) {
    tracing::debug!(
        target: "wireloom::iteration",
        iteration = report.iterations,
        energy,
        residual,
        step,
        shift,
        contacts = problem.contact().found().len(),
        factorisations,
    );
}
