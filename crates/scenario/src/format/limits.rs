//! Limits of numbers: values that no harness has are refused.

use super::units::{self, plain};
use wireloom_core::Quantity;

/// Limits of a number. The limits of its quantity apply too: see [`Bound::of`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bound {
    /// Least value.
    pub minimum: f64,
    /// Whether the least value itself is excluded.
    pub exclusive: bool,
    /// Greatest value.
    pub maximum: f64,
}

impl Bound {
    /// These limits within the physically plausible limits of a quantity.
    pub fn of(self, quantity: Quantity) -> Self {
        let units::Words { smallest, largest, .. } = units::words(quantity);
        let maximum = self.maximum.min(largest);
        if self.exclusive && self.minimum == 0.0 {
            return Self { minimum: smallest, exclusive: false, maximum };
        }
        Self { minimum: self.minimum.max(-largest), maximum, ..self }
    }

    /// `from 1e-10 to 100000 m`, for limits returned by [`of`](Bound::of).
    pub fn words(self, quantity: Quantity) -> String {
        let (least, greatest, unit) = (plain(self.minimum), plain(self.maximum), units::words(quantity).unit);
        let from = if self.exclusive { "above" } else { "from" };
        format!("{from} {least} to {greatest} {unit}").trim_end().to_owned()
    }
}

/// Limits that are both included.
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
/// Poisson's ratio of ordinary materials.
pub(super) const POISSON: Bound = within(0.0, 0.5);
/// Between zero and one.
pub(crate) const FRACTION: Bound = within(0.0, 1.0);
/// Diameters of cables, wires and layers, m: a harness of a kilometre may have cables of some ten metres.
pub(super) const DIAMETER: Bound = Bound { maximum: 1e3, ..POSITIVE };
/// Lengths of branches, m: the longest cables that are laid in one piece.
pub(super) const SPAN_LENGTH: Bound = Bound { maximum: 1e5, ..POSITIVE };
/// Stiffness beyond a yield point relative to that before it: 0 and 1 are other laws.
pub(super) const HARDENING: Bound = within(1e-3, 0.999);
/// Stiffness before slip relative to that after it: with 1 nothing slips.
pub(super) const STIFF_RATIO: Bound = within(1.001, 1e6);
/// Coefficients of friction: beyond this nothing slips.
pub(super) const FRICTION_COEFFICIENT: Bound = within(0.0, 1e3);
/// Drag coefficients: those of bluff bodies are about 1.
pub(super) const DRAG_COEFFICIENT: Bound = within(1e-3, 1e3);
/// Turns about a tangent in one step, in either direction: each needs several equilibria.
pub(crate) const TURNS: Bound = within(-1e3, 1e3);
/// Factors of loads.
pub(crate) const LOAD_FACTOR: Bound = within(-1e9, 1e9);
/// Residual force relative to the load scale. Smaller values are below the round-off of forces that almost cancel; with
/// larger ones the shape is visibly not in equilibrium.
pub(super) const TOLERANCE: Bound = within(1e-15, 1e-2);
/// Relative accuracies of a mesh: beyond them no mesh is fine enough, or every mesh is.
pub(super) const ACCURACY: Bound = within(1e-5, 0.5);
/// Time limits of a call, s: a millisecond to a day.
pub(super) const SECONDS: Bound = within(1e-3, 86400.0);

/// Largest number of segments of a harness, of iterations and the like; a larger one is taken for a mistake.
pub const MAX_COUNT: usize = 1_000_000;
/// Largest number of increments of a step: each is an equilibrium, and a thousand of them take at least a second.
pub(super) const MAX_INCREMENTS: usize = 100_000;
