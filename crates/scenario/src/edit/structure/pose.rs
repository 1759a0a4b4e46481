//! The pose of an obstacle as its entry has it.

use super::entries::set;
use super::lengths::length_like;
use crate::edit::record;
use toml_edit::{Array, Item, TableLike, Value};
use wireloom_core::{Rotation, Vector};

/// Writes a position, rounded to a micrometre, in the units that it has.
pub(super) fn set_position(entry: &mut dyn TableLike, position: &Vector) {
    let before = entry.get("position").and_then(Item::as_array);
    let written = |axis: usize, metres: f64| {
        let metres = (metres * 1e6).round() / 1e6 + 0.0;
        length_like(before.and_then(|list| list.get(axis)).and_then(Value::as_str), metres)
    };
    let list: Array = position.iter().enumerate().map(|(axis, metres)| written(axis, *metres)).collect();
    set(entry, "position", Value::Array(list));
}

/// Writes an orientation in place of the directions of its axes, rounded to a part in 10⁷.
pub(super) fn set_orientation(entry: &mut dyn TableLike, orientation: &Rotation) {
    // A quaternion and its negative are the same rotation: the one that people write.
    let sign = if orientation.w < 0.0 { -1.0 } else { 1.0 };
    let parts = [orientation.w, orientation.i, orientation.j, orientation.k];
    let rounded = parts.map(|x| (sign * x * 1e7).round() / 1e7 + 0.0);
    for axis in ["tangent", "up"] {
        entry.remove(axis);
    }
    set(entry, "orientation", record::list(&rounded));
}
