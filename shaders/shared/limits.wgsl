#import bindings

// Constants of the minimisation; `reference::shared::limits` describes them, solve::newton gives the reasons.
const MAX_ROTATION: real = real(1.0);
const FIRST_SHIFT: real = real(1e-6);
const SHIFT_INCREASE: real = real(8.0);
const SHIFT_INCREASE_AFTER_SEARCH: real = real(16.0);
const SHIFT_DECREASE: real = real(0.1);
const MAX_SHIFT: real = real(1e6);
const ARMIJO: real = real(1e-4);
const MIN_STEP: real = real(1e-10);
const RESOLVED_ROTATION: real = real(1e-3);
const MAX_POLISHING_STEPS: u32 = 3u;
const CONDENSED_FRACTION: real = real(0.1);
// Number of steps of the gradient method between factorisations.
const MAX_METRIC_AGE: u32 = 20u;
// Step length below which the preconditioner is out of date.
const MIN_REUSED_STEP: real = real(0.25);
// Larger numbers count as infinite, because their squares may be.
const OVERFLOW: real = real(1e18);

const CONVERGED: u32 = 1u;
const STALLED: u32 = 2u;
const ITERATION_LIMIT: u32 = 3u;
const FAILED: u32 = 4u;

// Also false for NaN.
fn is_finite(x: real) -> bool {
    return abs(x) < OVERFLOW;
}

fn end(variant: u32, outcome: u32) {
    control[variant].outcome = outcome;
    control[variant].phase = DONE;
}
