//! Lengths as a text has them.

use crate::edit::record::number;
use crate::format::units;
use toml_edit::{Item, Value};

/// A length as it is written, m.
pub(super) fn metres(item: Option<&Item>) -> Option<f64> {
    item?.as_value().and_then(metres_of)
}

/// The same of a value.
pub(super) fn metres_of(value: &Value) -> Option<f64> {
    let plain = value.as_float().or_else(|| Some(value.as_integer()? as f64));
    plain.or_else(|| units::any(value.as_str()?).ok().map(|(metres, _)| metres))
}

/// A length in the unit of another one, if that is written as a string, rounded to a part in 10⁹ of a metre.
pub(super) fn length_like(other: Option<&str>, metres: f64) -> Value {
    let rounded = |x: f64, part: f64| (x * part).round() / part;
    let unit = other.map(|word| word.trim_start_matches(|c: char| !c.is_alphabetic()).trim());
    match unit.and_then(|unit| Some((unit, units::any(&format!("1 {unit}")).ok()?.0))) {
        Some((unit, factor)) => Value::from(format!("{} {unit}", rounded(metres / factor, 1e9 * factor))),
        None => number(rounded(metres, 1e9)),
    }
}
