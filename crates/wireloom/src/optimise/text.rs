//! Writes numbers into the text of a scenario as its author would: in the unit that stands there, with few digits.

use wireloom_core::{Registry, Value};
use wireloom_scenario::{Fault, number_at, record};

/// Largest number of digits behind the point.
const DIGITS: f64 = 15.0;

/// The text with a number (SI) for a key, rounded to `resolution` but not out of `[from, to]`; and the number that is
/// written.
///
/// # Errors
/// If the text has no number there.
pub(super) fn with_number(
    text: &str,
    key: &str,
    number: f64,
    resolution: f64,
    [from, to]: [f64; 2],
    registry: &Registry,
) -> Result<(String, f64), Fault> {
    let put = |value: Value| -> Result<(String, f64), Fault> {
        let text = record::with_value(text, key, &value, registry)?;
        let number = number_at(&text, key, registry)?.value;
        Ok((text, number))
    };
    let fits = |found: f64| (found - number).abs() <= resolution && (from..=to).contains(&found);
    let old = record::value_at(text, key)?;
    // Units are proportional to SI units, except that a value of zero does not show the factor.
    let (word, factor) = match old.as_str() {
        Some(word) => {
            let digits = word.trim_start().find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)));
            let (own, unit) = word.trim_start().split_at(digits.unwrap_or(word.trim_start().len()));
            let factor = own.parse().ok().map(|own: f64| number_at(text, key, registry).map(|n| n.value / own));
            (Some(unit), factor.transpose()?.filter(|factor| factor.is_finite() && *factor != 0.0))
        }
        None => (None, Some(1.0)),
    };
    if let Some(factor) = factor {
        let rounded = rounded(number / factor, resolution / factor.abs());
        let value = match word {
            Some(unit) => Value::Word(format!("{rounded}{unit}")),
            None => Value::Number(rounded.parse().unwrap_or(number)),
        };
        let (text, found) = put(value)?;
        if fits(found) {
            return Ok((text, found));
        }
    }
    put(Value::Number(number))
}

/// A number rounded to a resolution, without zeros at its end.
fn rounded(number: f64, resolution: f64) -> String {
    let digits = (1.0 - resolution.log10()).ceil().clamp(0.0, DIGITS) as usize;
    let text = format!("{number:.digits$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_unit_and_the_comments_beside_them() {
        let text = "a = \"600 mm\" # of copper\nb = 0.5 # m\nc = \"0 deg\"\n";
        let registry = Registry::default();
        let with = |key: &str, number: f64, range| with_number(text, key, number, 1e-6, range, &registry).unwrap();
        let (own, found) = with("a", 0.612_345_67, [0.5, 0.7]);
        assert!(own.contains("a = \"612.3457 mm\" # of copper"), "{own}");
        assert!((found - 0.612_345_7).abs() < 1e-15);
        assert!(with("b", 0.25, [0.0, 1.0]).0.contains("b = 0.25 # m"));
        // Its factor does not show.
        assert!(with("c", 0.125, [0.0, 1.0]).0.contains("c = 0.125"));
        // Rounding does not lead out of the range.
        let (_, found) = with("b", 1.0 / 3.0, [0.0, 1.0 / 3.0]);
        assert!(found <= 1.0 / 3.0);
    }
}
