#import bindings

// What the descent goes by; see solve::newton for their stories.
const LARGEST_TURN: real = real(1.0);
const FIRST_SHIFT: real = real(1e-6);
const RAISE: real = real(8.0);
const RAISE_AFTER_SEARCH: real = real(16.0);
const LOWER: real = real(0.1);
const LARGEST_SHIFT: real = real(1e6);
const ARMIJO: real = real(1e-4);
const SHORTEST: real = real(1e-10);
const LAST_TURN: real = real(1e-3);
const POLISHES: u32 = 3u;
const SETTLED_SHARE: real = real(0.1);
// Steps of the gradient method from one factorisation to the next.
const REFRESH: u32 = 20u;
// Share of a step below which the metric has become too old.
const OLD: real = real(0.25);
// Numbers from here on count as infinite: their squares may be.
const HUGE: real = real(1e18);

const CONVERGED: u32 = 1u;
const STALLED: u32 = 2u;
const ITERATION_LIMIT: u32 = 3u;
const FAILED: u32 = 4u;

// False for what is not a number, too.
fn is_finite(x: real) -> bool {
    return abs(x) < HUGE;
}

fn end(variant: u32, outcome: u32) {
    control[variant].outcome = outcome;
    control[variant].phase = DONE;
}
