//! Whether the derivatives of a part agree with what they are derived from: one slope along one line, against
//! differences.
//!
//! Plugins are other people's code. A gradient that is not that of the energy leads to a state that looks balanced and
//! is not, second derivatives that are not those of the forces to one that looks stable and is not. So one slope of
//! both is compared for every part at each equilibrium, along another line at each. It is enough that the differences
//! of one step agree: long steps meet curvature, short ones rounding. A slope that is small beside its own change over
//! a step is not judged by that step: a spring at rest has none. At a kink, any slope between those of both sides is
//! one. Second derivatives of parts that remember are not judged: what slips is at its limit where an increment ends,
//! next to where they jump, and its elements jump on different sides of a line.

use crate::Vector;
use rustc_hash::FxHasher;
use std::hash::Hasher;

/// Steps of the differences, in m, rad, or both.
const STEPS: [f64; 5] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7];
/// Error of a slope that is accepted, relative to the sum of the absolute values of its parts and to its change over
/// the step: far above that of differences, and below what changes a result visibly.
const TOLERANCE: f64 = 1e-3;
/// Rounding errors of a value that are accepted.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// A slope that its part contradicts, in units of the part's value per m or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contradiction {
    /// By the derivatives.
    pub claimed: f64,
    /// By differences of the values.
    pub found: f64,
}

/// Slope along a line, summed over its components.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Slope {
    /// Sum.
    pub claimed: f64,
    /// Sum of the absolute values.
    pub size: f64,
}

impl Slope {
    /// Adds ∂/∂x along d.
    pub fn add(&mut self, derivative: &Vector, d: &Vector) {
        let parts = derivative.component_mul(d);
        self.claimed += parts.sum();
        self.size += parts.abs().sum();
    }

    /// Compares it with differences of `value(t)`, t along the line.
    pub fn contradiction(self, mut value: impl FnMut(f64) -> f64) -> Option<Contradiction> {
        let Self { claimed, size } = self;
        let middle = value(0.0);
        let (mut found, mut sides) = (f64::NAN, [f64::NAN; 2]);
        let mut deviations = [f64::NAN; STEPS.len()];
        for (deviation, h) in deviations.iter_mut().zip(STEPS) {
            let (ahead, behind) = (value(h), value(-h));
            let slope = (ahead - behind) / (2.0 * h);
            let rounding = ROUND_OFF * middle.abs().max(ahead.abs()).max(behind.abs()) / h;
            // Beyond the values that it can take a part may give no number.
            if !slope.is_finite() {
                continue;
            }
            let change = (ahead - 2.0 * middle + behind).abs() / h;
            if (slope - claimed).abs() <= TOLERANCE * (size + change) + rounding {
                return None;
            }
            *deviation = (slope - claimed).abs();
            (found, sides) = (slope, [(ahead - middle) / h, (middle - behind) / h]);
        }
        // Where a slope is next to nothing, as the stiffness of a spring with a force of x³ at rest, differences tend
        // to it with the square of the step.
        let [_, _, before, _, last] = deviations;
        if last <= TOLERANCE * before {
            return None;
        }
        let [low, high] = [sides[0].min(sides[1]), sides[0].max(sides[1])];
        let slack = TOLERANCE * size;
        let at_kink = high - low > slack && (low - slack..=high + slack).contains(&claimed);
        (found.is_finite() && !at_kink).then_some(Contradiction { claimed, found })
    }
}

/// A line along which slopes are compared: the same for a part in the same state, another one in any other state. Along
/// one and the same line a wrong derivative that is normal to it would never be found.
#[derive(Clone, Copy)]
pub(crate) struct Line {
    seed: u64,
}

impl Line {
    /// The line of a part in the state of these numbers.
    pub fn at<'x>(state: impl IntoIterator<Item = &'x f64>) -> Self {
        let mut hasher = FxHasher::default();
        state.into_iter().for_each(|x| hasher.write_u64(x.to_bits()));
        Self { seed: hasher.finish() }
    }

    /// Vector k of it, with components between -1 and 1.
    pub fn along(self, k: usize) -> Vector {
        let mut random = fastrand::Rng::with_seed(self.seed.wrapping_add(k as u64));
        Vector::from_fn(|_, _| 2.0 * random.f64() - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(claimed: f64, value: impl FnMut(f64) -> f64) -> Option<Contradiction> {
        Slope { claimed, size: claimed.abs() }.contradiction(value)
    }

    #[test]
    fn true_slopes_of_stiff_soft_offset_and_sharply_curved_energies_are_accepted() {
        assert_eq!(check(3.0, |t| 3.0 * t), None);
        assert_eq!(check(3e-9, |t| 3e-9 * t + 1.0), None);
        assert_eq!(check(2e6, |t| 1e6 * (1.0 + t).powi(2)), None);
        assert_eq!(check(1e4, |t| (1e4 * t).sin()), None);
        let rounded = |x: f64| 5e-5 * (x * x + 1e-10).sqrt();
        assert_eq!(check(5e-5 * 1e-5 / 2e-10_f64.sqrt(), |t| rounded(1e-5 + t)), None);
        assert_eq!(check(0.0, |_| 1e3), None);
    }

    #[test]
    fn a_spring_at_its_rest_length_is_accepted_although_its_energy_is_not_even() {
        let length = |t: f64| ((0.3 + t).powi(2) + (0.8 * t).powi(2)).sqrt();
        for off in [0.0, 1e-15, -1e-10] {
            let energy = |t: f64| 0.5 * 4e3 * (length(t) - 0.3 - off).powi(2);
            assert_eq!(check(-4e3 * off, energy), None, "{off}");
        }
        // As it is taut, by nothing yet; as it is slack.
        assert_eq!(check(0.0, |t| 0.5 * t.max(0.0).powi(2)), None);
        assert_eq!(check(0.0, |t| 0.5 * (t - 0.1).max(0.0).powi(2)), None);
    }

    #[test]
    fn any_slope_between_those_of_a_kink_is_one_and_others_are_not() {
        assert_eq!(check(0.0, f64::abs), None);
        assert_eq!(check(1.0, f64::abs), None);
        assert_eq!(check(1.5, f64::abs), Some(Contradiction { claimed: 1.5, found: 0.0 }));
    }

    #[test]
    fn doubled_missing_and_reversed_slopes_are_found() {
        let energy = |t: f64| 0.5 * 40.0 * (0.02 + t).powi(2);
        for lie in [2.0, 0.0, -1.0, 1.01] {
            let found = Slope { claimed: lie * 0.8, size: 0.8 }.contradiction(energy).expect("a lie");
            assert!((found.found - 0.8).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn a_force_that_begins_with_the_third_power_has_no_stiffness_at_rest() {
        assert_eq!(check(0.0, |t| 4e3 * t.powi(3)), None);
        assert!(check(0.04, |t| 4e3 * t.powi(3)).is_some());
        assert!(check(0.0, |t| 4e3 * t.powi(3) + 4e-3 * t).is_some());
    }

    #[test]
    fn a_lie_that_one_line_does_not_see_is_seen_along_another() {
        // The energy is |x|², its gradient is wrong across the line of the first state.
        let from = Line::at(&[0.0]).along(0);
        let across = from.cross(&Vector::x()).normalize();
        let seen = |state: f64| {
            let (at, d) = (Vector::new(0.3, -0.2, 0.5), Line::at(&[state]).along(0));
            let mut slope = Slope::default();
            slope.add(&(at * 2.0 + across), &d);
            slope.contradiction(|t| (at + d * t).norm_squared()).is_some()
        };
        assert!(!seen(0.0));
        let others = (1..=20).filter(|k| seen(0.01 * f64::from(*k))).count();
        assert!(others >= 18, "a line that is nearly normal to it is rare: {others} of 20");
    }

    #[test]
    fn values_beyond_which_there_is_none_are_left_out() {
        assert_eq!(check(2e5, |t| if t < -5e-6 { f64::NAN } else { 1e5 * (1.0 + t).powi(2) }), None);
    }
}
