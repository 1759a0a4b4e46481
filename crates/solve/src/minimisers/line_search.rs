//! Line search by the strong Wolfe conditions.
//!
//! A step length α is accepted if `φ(α) ≤ φ(0) + δ α φ′(0)`, or `φ(α) ≤ φ(0) + ε` with ε the
//! round-off of φ, and `|φ′(α)| ≤ σ |φ′(0)|`: slopes stay accurate where differences of φ are lost in
//! round-off (Hager and Zhang 2005). Between a trial with a descending slope and one beyond the minimum the next trial
//! is the minimum of the cubic through both values and slopes (Nocedal and Wright, 2nd ed., 3.59).

/// δ: least decrease, as a fraction of the linear one.
const DECREASE: f64 = 1e-4;
/// Limits of the next trial, as fractions of the bracket.
const INSIDE: [f64; 2] = [0.1, 0.9];
/// Limits of the factor on the next trial while no bracket is found.
const FARTHER: [f64; 2] = [1.1, 5.0];
/// Largest number of trials in one search.
const TRIALS: usize = 30;
/// Upper end of the bracket, relative to the first trial, below which the search ends without a step.
const SHORTEST_BRACKET: f64 = 1e-12;

/// Parameters of the Wolfe conditions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wolfe {
    /// σ: fraction of the first slope that may remain.
    pub slope: f64,
    /// ε: round-off of the energy, J.
    pub noise: f64,
}

/// A trial.
#[derive(Clone, Copy, Debug)]
struct Trial {
    alpha: f64,
    energy: f64,
    slope: f64,
}

/// Finds α in (0, `longest`], beginning with `first`; `at` evaluates φ and φ′, and is called last with the α that
/// is returned. `None` if no trial lowered the energy.
pub(crate) fn search(
    (energy, slope): (f64, f64),
    first: f64,
    longest: f64,
    wolfe: Wolfe,
    mut at: impl FnMut(f64) -> (f64, f64),
) -> Option<f64> {
    let start = Trial { alpha: 0.0, energy, slope };
    let (mut low, mut beyond) = (start, None::<Trial>);
    let mut alpha = first.min(longest);
    for _ in 0..TRIALS {
        let (energy, slope) = at(alpha);
        let trial = Trial { alpha, energy, slope };
        let lower = energy <= start.energy + DECREASE * alpha * start.slope;
        let level = energy <= start.energy + wolfe.noise;
        let flat = slope.abs() <= wolfe.slope * start.slope.abs();
        if (lower || level) && flat {
            return Some(alpha);
        }
        if (lower || level) && slope < 0.0 {
            if alpha == longest {
                return Some(alpha);
            }
            low = trial;
        } else {
            beyond = Some(trial);
        }
        alpha = match &beyond {
            Some(beyond) => between(&low, beyond),
            None => (low.alpha * expansion(&start, &low)).min(longest),
        };
        if alpha == low.alpha || beyond.is_some_and(|beyond| beyond.alpha < SHORTEST_BRACKET * first) {
            break;
        }
    }
    (low.alpha > 0.0).then(|| {
        at(low.alpha);
        low.alpha
    })
}

/// Factor on α at which the slope vanishes by the secant from the start.
fn expansion(start: &Trial, low: &Trial) -> f64 {
    let secant = start.slope / (start.slope - low.slope);
    let [least, most] = FARTHER;
    if secant.is_finite() && secant > 0.0 { secant.clamp(least, most) } else { most }
}

/// Minimum of the cubic between two trials.
fn between(low: &Trial, beyond: &Trial) -> f64 {
    let width = beyond.alpha - low.alpha;
    let d1 = low.slope + beyond.slope - 3.0 * (beyond.energy - low.energy) / width;
    let square = d1 * d1 - low.slope * beyond.slope;
    let d2 = square.max(0.0).sqrt().copysign(width);
    let cubic = 1.0 - (beyond.slope + d2 - d1) / (beyond.slope - low.slope + 2.0 * d2);
    let fraction = if cubic.is_finite() { cubic } else { INSIDE[0] };
    low.alpha + width * fraction.clamp(INSIDE[0], INSIDE[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRICT: Wolfe = Wolfe { slope: 0.1, noise: 0.0 };

    /// Runs a search on φ. Returns α, φ′ there and the number of trials.
    fn on(phi: impl Fn(f64) -> (f64, f64), first: f64, longest: f64, wolfe: Wolfe) -> Option<(f64, f64, usize)> {
        let (mut trials, mut last) = (0, f64::NAN);
        let found = search(phi(0.0), first, longest, wolfe, |alpha| {
            trials += 1;
            last = alpha;
            phi(alpha)
        });
        found.map(|alpha| {
            assert_eq!(alpha, last, "the step returned was tried last");
            (alpha, phi(alpha).1, trials)
        })
    }

    #[test]
    fn a_parabola_takes_two_trials_from_anywhere() {
        let phi = |a: f64| ((a - 3.0).powi(2), 2.0 * (a - 3.0));
        for first in [0.5, 1.0, 2.9, 4.0, 9.0] {
            let (alpha, slope, trials) = on(phi, first, f64::INFINITY, STRICT).unwrap();
            assert!(slope.abs() <= 0.6, "{first}: {alpha}");
            assert!(trials <= 3, "{first}: {trials} trials");
        }
    }

    /// Moré and Thuente 1994, (5.1) with β = 2: flat far out, and (5.3)-like waves.
    #[test]
    fn wolfes_conditions_hold_on_functions_that_are_not_convex() {
        let flat = |a: f64| (-a / (a * a + 2.0), (a * a - 2.0) / (a * a + 2.0).powi(2));
        let waves = |a: f64| (-a + 0.3 * (8.0 * a).sin() + 0.1 * a * a, -1.0 + 2.4 * (8.0 * a).cos() + 0.2 * a);
        for first in [1e-3, 0.1, 1.0, 10.0, 1e3] {
            let (_, slope, _) = on(flat, first, f64::INFINITY, STRICT).unwrap();
            assert!(slope.abs() <= 0.1 * 0.5);
            if waves(0.0).1 < 0.0 {
                on(waves, first, f64::INFINITY, STRICT).unwrap();
            }
        }
    }

    #[test]
    fn the_step_is_no_longer_than_allowed() {
        let phi = |a: f64| (-a, -1.0);
        assert_eq!(on(phi, 1.0, 7.0, STRICT).unwrap().0, 7.0);
    }

    #[test]
    fn no_step_is_found_uphill_and_trials_that_are_not_finite_are_left() {
        assert!(on(|a| (a, -1.0), 1.0, 9.0, STRICT).is_none());
        let cliff = |a: f64| if a > 0.5 { (f64::NAN, f64::NAN) } else { ((a - 0.2).powi(2), 2.0 * (a - 0.2)) };
        let (alpha, ..) = on(cliff, 1.0, 9.0, STRICT).unwrap();
        assert!((alpha - 0.2).abs() < 0.05, "{alpha}");
    }

    /// With values that differ by round-off only.
    #[test]
    fn in_round_off_slopes_decide() {
        let phi = |a: f64| (1.0 + 1e-17 * ((1e4 * a).sin()), 1e-12 * (a - 0.3));
        let (alpha, slope, _) = on(phi, 1.0, 9.0, Wolfe { slope: 0.1, noise: 1e-14 }).unwrap();
        assert!(slope.abs() <= 0.1 * 0.3e-12, "{alpha}");
    }
}
