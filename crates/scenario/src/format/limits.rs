//! Limits of numbers: what no harness has is refused.

use super::units::{self, plain};
use wireloom_core::Quantity;

/// Limits of a number. Those of what it measures hold besides: see [`Bound::of`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bound {
    /// Least value.
    pub minimum: f64,
    /// Whether the least value itself is barred.
    pub exclusive: bool,
    /// Greatest value.
    pub maximum: f64,
}

impl Bound {
    /// These limits for a quantity: what is physically implausible is beyond them.
    pub fn of(self, quantity: Quantity) -> Self {
        let units::Words { smallest, largest, .. } = units::words(quantity);
        let maximum = self.maximum.min(largest);
        if self.exclusive && self.minimum == 0.0 {
            return Self { minimum: smallest, exclusive: false, maximum };
        }
        Self { minimum: self.minimum.max(-largest), maximum, ..self }
    }

    /// `from 1e-10 to 100000 m`, of limits that are those [`of`](Bound::of) the quantity.
    pub fn words(self, quantity: Quantity) -> String {
        let (least, greatest, unit) = (plain(self.minimum), plain(self.maximum), units::words(quantity).unit);
        let from = if self.exclusive { "above" } else { "from" };
        format!("{from} {least} to {greatest} {unit}").trim_end().to_owned()
    }
}

/// Between these, both included.
pub(super) const fn within(minimum: f64, maximum: f64) -> Bound {
    Bound { minimum, exclusive: false, maximum }
}

/// Any number.
pub(crate) const ANY: Bound = within(f64::NEG_INFINITY, f64::INFINITY);
/// Above zero.
pub(crate) const POSITIVE: Bound = Bound { minimum: 0.0, exclusive: true, maximum: f64::INFINITY };
/// Zero or above.
pub(crate) const NON_NEGATIVE: Bound = within(0.0, f64::INFINITY);
/// Above zero, at most one.
pub(crate) const POSITIVE_FRACTION: Bound = Bound { maximum: 1.0, ..POSITIVE };
/// Poisson's ratio of what is not unusual.
pub(super) const POISSON: Bound = within(0.0, 0.5);
/// Between zero and one.
pub(crate) const FRACTION: Bound = within(0.0, 1.0);
/// Across a cable, a wire or a layer, m: a kilometre-wide harness may have cables of some ten metres, none has more.
pub(super) const DIAMETER: Bound = Bound { maximum: 1e3, ..POSITIVE };
/// Along a branch, m: the longest cables that are laid in one piece.
pub(super) const SPAN_LENGTH: Bound = Bound { maximum: 1e5, ..POSITIVE };
/// Coefficients of friction: more than this holds fast.
pub(super) const FRICTION_COEFFICIENT: Bound = within(0.0, 1e3);
/// Turns about a tangent in one step, either way: each takes several equilibria.
pub(crate) const TURNS: Bound = within(-1e3, 1e3);
/// Factors of loads.
pub(crate) const LOAD_FACTOR: Bound = within(-1e9, 1e9);
/// Residual force relative to the load scale. Below is the round-off of forces that almost cancel; above, what is called balanced is
/// visibly not.
pub(super) const TOLERANCE: Bound = within(1e-15, 1e-2);
/// How long a call may take, s: a millisecond to a day.
pub(super) const SECONDS: Bound = within(1e-3, 86400.0);

/// The most segments of a harness or iterations that are taken for meant.
pub const MAX_COUNT: usize = 1_000_000;
/// The most increments of a step: each is an equilibrium, and a thousand of them take a second at best.
pub(super) const MAX_INCREMENTS: usize = 100_000;
