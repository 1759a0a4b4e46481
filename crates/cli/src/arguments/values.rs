//! Values on the command line.

use crate::failure::Failure;
use std::ops::Range;
use wireloom::scenario::Setting;

/// A length in m from `10 mm`, `0.01 m` or `0.01`; above zero.
pub fn length(text: &str) -> Result<f64, String> {
    length_in(text, 1.0)
}

/// A length in m from `0.1 mm`, or from `0.1`, which is in mm; above zero.
pub fn millimetres(text: &str) -> Result<f64, String> {
    length_in(text, 1000.0)
}

/// Width and height in m from `4000x1600`, which is in mm, or `4 m x 1.6 m`.
pub fn board(text: &str) -> Result<[f64; 2], String> {
    let Some((width, height)) = text.split_once(['x', '×']) else {
        return Err(format!("`{text}` is no width and height: write such as 4000x1600 (mm) or \"4 m x 1.6 m\""));
    };
    let size = [millimetres(width)?, millimetres(height)?];
    too_large(size)?;
    Ok(size)
}

/// Largest side of a board, m: beyond it the numbers of a PDF are coarser than 0.01 mm, and its pages are very many.
const LARGEST_BOARD: f64 = 100.0;

/// Refuses a board that is too large to be drawn.
pub fn too_large([width, height]: [f64; 2]) -> Result<(), String> {
    if width.max(height) <= LARGEST_BOARD {
        return Ok(());
    }
    Err(format!("a board of {width:.1} m x {height:.1} m cannot be drawn; {LARGEST_BOARD} m is the longest side"))
}

/// A length in m; a number without a unit is divided by `plain`.
fn length_in(text: &str, plain: f64) -> Result<f64, String> {
    let text = text.trim();
    let split = text.find(|c: char| c.is_alphabetic() && c != 'e' && c != 'E').unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    // A divisor, so that 10 mm is the double nearest to 0.01 m.
    let divisor = match unit.trim() {
        "" => plain,
        "m" => 1.0,
        "dm" => 10.0,
        "cm" => 100.0,
        "mm" => 1000.0,
        other => return Err(format!("unknown unit `{other}`; lengths are in m, dm, cm or mm")),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value / divisor),
        Ok(value) => Err(format!("{value} is not above zero")),
        Err(_) => Err(format!("`{text}` is not a length like `10 mm`")),
    }
}

/// A ratio from `2 %` or `0.02`; between 0 and 1.
pub fn ratio(text: &str) -> Result<f64, String> {
    let number = text.trim();
    let (number, divisor) = number.strip_suffix('%').map_or((number, 1.0), |number| (number.trim(), 100.0));
    match number.parse::<f64>() {
        Ok(value) if value > 0.0 && value < divisor => Ok(value / divisor),
        Ok(value) => Err(format!("{value} is not between 0 and {divisor}")),
        Err(_) => Err(format!("`{text}` is not a ratio like `2 %`")),
    }
}

/// A range of points from `0..64`.
pub fn range(text: &str) -> Result<Range<usize>, String> {
    let help = || format!("`{text}` is no range of points: write 0..64, where 64 does not count");
    let (start, end) = text.split_once("..").ok_or_else(help)?;
    let number = |text: &str| text.trim().parse().map_err(|_| help());
    Ok(number(start)?..number(end)?)
}

/// A setting from KEY=VALUE.
pub fn setting(set: &str) -> Result<Setting, Failure> {
    let Some((key, value)) = set.split_once('=') else {
        return Err(Failure::Input(format!("--set {set} has no value: write KEY=VALUE")));
    };
    Ok(Setting::new(key.trim(), value.trim()))
}

#[cfg(test)]
mod tests {
    use super::{board, length, millimetres, range, ratio};

    #[test]
    fn boards_have_a_width_and_a_height() {
        for text in ["4000x1600", "4 m x 1.6 m", "4000 mm × 160 cm"] {
            assert_eq!(board(text), Ok([4.0, 1.6]), "{text}");
        }
        for text in ["", "4000", "4000x", "x1600", "4000x-1", "0x10", "4000xlarge", "1x2x3", "inf x 1", "200 m x 1 m"] {
            assert!(board(text).is_err(), "{text}");
        }
    }

    #[test]
    fn ranges_have_two_ends() {
        assert_eq!((range("0..64"), range(" 64 .. 128 ")), (Ok(0..64), Ok(64..128)));
        for text in ["", "7", "0-64", "..64", "0..", "-1..3", "0..=64", "a..b", "0...64"] {
            assert!(range(text).is_err(), "{text}");
        }
    }

    #[test]
    fn ratios_are_numbers_or_percent() {
        for text in ["2 %", "2%", "0.02", " 2e-2 "] {
            assert_eq!(ratio(text), Ok(0.02), "{text}");
        }
        for text in ["", "%", "0", "-1 %", "100 %", "2", "nan", "2 mm"] {
            assert!(ratio(text).is_err(), "{text}");
        }
    }

    #[test]
    fn lengths_have_units() {
        for text in ["10 mm", "10mm", "1 cm", "0.01", "1e-2 m", " 0.01 m "] {
            assert_eq!(length(text), Ok(0.01), "{text}");
        }
        assert_eq!((millimetres("0.1"), millimetres("0.1 mm"), millimetres("1e-4 m")), (Ok(1e-4), Ok(1e-4), Ok(1e-4)));
        for text in ["", "mm", "-1 mm", "0", "10 km", "1 2 mm", "inf", "nan"] {
            assert!(length(text).is_err(), "{text}");
        }
    }
}
