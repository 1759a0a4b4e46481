#import bindings

// What the descent goes by; see solve::newton for their stories.
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
// Steps of the gradient method from one factorisation to the next.
const MAX_METRIC_AGE: u32 = 20u;
// Share of a step below which the metric has become too old.
const MIN_REUSED_STEP: real = real(0.25);
// Numbers from here on count as infinite: their squares may be.
const OVERFLOW: real = real(1e18);

const CONVERGED: u32 = 1u;
const STALLED: u32 = 2u;
const ITERATION_LIMIT: u32 = 3u;
const FAILED: u32 = 4u;

// False for what is not a number, too.
fn is_finite(x: real) -> bool {
    return abs(x) < OVERFLOW;
}

fn end(variant: u32, outcome: u32) {
    control[variant].outcome = outcome;
    control[variant].phase = DONE;
}
