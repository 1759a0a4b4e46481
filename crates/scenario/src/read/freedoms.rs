//! Freedoms of joints of mechanisms: their quantities, and their values in words.

use wireloom_core::Quantity;
use wireloom_core::mechanism::JointKind;

/// Limits of a freedom that has none.
pub(crate) const UNLIMITED: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Quantity of a freedom of a joint.
pub(crate) fn quantity(kind: &JointKind, freedom: usize) -> Quantity {
    if kind.is_length(freedom) { Quantity::Length } else { Quantity::Angle }
}

/// A value of a freedom of a joint in words.
pub(crate) fn shown(kind: &JointKind, freedom: usize, value: f64) -> String {
    if kind.is_length(freedom) { format!("{:.3} mm", 1e3 * value) } else { format!("{:.3} deg", value.to_degrees()) }
}
