//! Numbers with units: `"600 mm"`, `"0.5 N/mm"`, `"12 N mm²"`.
//!
//! A unit is a product or quotient of symbols, each with an SI prefix and an exponent; `/` divides by the one
//! symbol that follows it.

use wireloom_core::Quantity;

/// Exponents of m, kg, s, rad and K.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Dimension {
    metre: i32,
    kilogram: i32,
    second: i32,
    radian: i32,
    kelvin: i32,
}

const fn dimension(metre: i32, kilogram: i32, second: i32, radian: i32) -> Dimension {
    Dimension { metre, kilogram, second, radian, kelvin: 0 }
}

/// A dimension times this power of the temperature.
const fn with_kelvin(kelvin: i32, dimension: Dimension) -> Dimension {
    Dimension { kelvin, ..dimension }
}

/// Name, unit and limits of a quantity.
pub(crate) struct Words {
    /// Name with its article.
    pub name: &'static str,
    /// SI unit; empty for a pure number.
    pub unit: &'static str,
    /// Example of a value in a scenario.
    pub example: &'static str,
    /// Least size above zero that is physically plausible, SI.
    pub smallest: f64,
    /// Greatest size that is physically plausible, SI.
    pub largest: f64,
    dimension: Dimension,
    /// Dimension with the radian left out or added: `N m` for `N m/rad`, `rad/m` for `1/m`.
    alternative: Option<Dimension>,
}

/// Name, unit, example, plausible sizes and dimension of a quantity.
///
/// A size beyond these limits is a mistake, such as a wrong unit: no harness is thinner than an atom (1e-10 m) or
/// farther away than the circumference of the earth (4e7 m). The other limits admit harnesses of micrometres to
/// kilometres: axial stiffness scales with the second power of the size, bending stiffness with the fourth, and the
/// gravity that bends them alike with the inverse.
pub(crate) fn words(quantity: Quantity) -> Words {
    let of = |name, example, [smallest, largest]: [f64; 2], dimension| Words {
        name,
        unit: quantity.unit(),
        example,
        smallest,
        largest,
        dimension,
        alternative: None,
    };
    match quantity {
        Quantity::Dimensionless => of("a pure number", "0.5", [1e-15, 1e12], dimension(0, 0, 0, 0)),
        Quantity::Length => of("a length", "\"600 mm\"", [1e-10, 4e7], dimension(1, 0, 0, 0)),
        Quantity::Mass => of("a mass", "\"30 g\"", [1e-24, 1e12], dimension(0, 1, 0, 0)),
        Quantity::LinearDensity => of("a mass per length", "\"120 g/m\"", [1e-24, 1e7], dimension(-1, 1, 0, 0)),
        Quantity::Force => of("a force", "\"2 kN\"", [1e-20, 1e15], dimension(1, 1, -2, 0)),
        Quantity::Moment => of("a moment", "\"5 N mm\"", [1e-30, 1e18], dimension(2, 1, -2, 0)),
        Quantity::ForcePerLength => of("a force per length", "\"0.5 N/mm\"", [1e-20, 1e18], dimension(0, 1, -2, 0)),
        Quantity::MomentPerAngle => Words {
            alternative: Some(dimension(2, 1, -2, 0)),
            ..of("a moment per angle", "\"5 N mm/deg\"", [1e-30, 1e18], dimension(2, 1, -2, -1))
        },
        Quantity::BendingStiffness => {
            of("a bending stiffness", "\"12000 N mm^2\"", [1e-30, 1e18], dimension(3, 1, -2, 0))
        }
        Quantity::Curvature => Words {
            alternative: Some(dimension(-1, 0, 0, 1)),
            ..of("a curvature", "\"30 deg/m\"", [1e-10, 1e10], dimension(-1, 0, 0, 0))
        },
        Quantity::Angle => of("an angle", "\"30 deg\"", [1e-12, 1e4], dimension(0, 0, 0, 1)),
        Quantity::Acceleration => of("an acceleration", "\"9.81 m/s^2\"", [1e-12, 1e9], dimension(1, 0, -2, 0)),
        Quantity::Pressure => of("a pressure", "\"50 MPa\"", [1e-3, 1e15], dimension(-1, 1, -2, 0)),
        Quantity::Density => of("a density", "\"1.35 g/cm3\"", [1e-6, 1e6], dimension(-3, 1, 0, 0)),
        Quantity::Velocity => of("a velocity", "\"20 m/s\"", [1e-9, 1e5], dimension(1, 0, -1, 0)),
        Quantity::Temperature => {
            of("a temperature difference", "\"95 K\"", [1e-9, 1e5], with_kelvin(1, dimension(0, 0, 0, 0)))
        }
        Quantity::ThermalExpansion => {
            of("a thermal expansion", "\"17e-6 1/K\"", [1e-12, 1.0], with_kelvin(-1, dimension(0, 0, 0, 0)))
        }
        Quantity::ThermalCurvature => Words {
            alternative: Some(with_kelvin(-1, dimension(-1, 0, 0, 1))),
            ..of("a thermal curvature", "0.01", [1e-12, 1e6], with_kelvin(-1, dimension(-1, 0, 0, 0)))
        },
        Quantity::AngularSpeed => of("an angular speed", "\"3000 rpm\"", [1e-9, 1e6], dimension(0, 0, -1, 1)),
        Quantity::Time => of("a time", "\"2 h\"", [1e-9, 1e12], dimension(0, 0, 1, 0)),
        Quantity::Energy => of("an energy", "\"20 mJ\"", [1e-30, 1e18], dimension(2, 1, -2, 0)),
        Quantity::Area => of("an area", "\"40 mm^2\"", [1e-20, 1e15], dimension(2, 0, 0, 0)),
    }
}

const QUANTITIES: [Quantity; 22] = [
    Quantity::Dimensionless,
    Quantity::Length,
    Quantity::Mass,
    Quantity::LinearDensity,
    Quantity::Force,
    Quantity::Moment,
    Quantity::ForcePerLength,
    Quantity::MomentPerAngle,
    Quantity::BendingStiffness,
    Quantity::Curvature,
    Quantity::Angle,
    Quantity::Acceleration,
    Quantity::Pressure,
    Quantity::Density,
    Quantity::Velocity,
    Quantity::Temperature,
    Quantity::ThermalExpansion,
    Quantity::ThermalCurvature,
    Quantity::AngularSpeed,
    Quantity::Time,
    Quantity::Energy,
    Quantity::Area,
];

/// Name of a dimension, for messages.
fn describe(d: Dimension) -> String {
    if let Some(words) = QUANTITIES.into_iter().map(words).find(|w| w.dimension == d) {
        return words.name.to_owned();
    }
    format!("measured in {}", symbols(d))
}

/// Symbol, factor to SI, dimension, whether it takes prefixes.
const SYMBOLS: [(&str, f64, Dimension, bool); 19] = [
    ("m", 1.0, dimension(1, 0, 0, 0), true),
    ("g", 1e-3, dimension(0, 1, 0, 0), true),
    ("s", 1.0, dimension(0, 0, 1, 0), true),
    ("N", 1.0, dimension(1, 1, -2, 0), true),
    ("Pa", 1.0, dimension(-1, 1, -2, 0), true),
    ("J", 1.0, dimension(2, 1, -2, 0), true),
    ("rad", 1.0, dimension(0, 0, 0, 1), true),
    ("deg", std::f64::consts::PI / 180.0, dimension(0, 0, 0, 1), false),
    ("°", std::f64::consts::PI / 180.0, dimension(0, 0, 0, 1), false),
    ("turn", std::f64::consts::TAU, dimension(0, 0, 0, 1), false),
    ("turns", std::f64::consts::TAU, dimension(0, 0, 0, 1), false),
    ("K", 1.0, with_kelvin(1, dimension(0, 0, 0, 0)), false),
    ("min", 60.0, dimension(0, 0, 1, 0), false),
    ("h", 3600.0, dimension(0, 0, 1, 0), false),
    ("d", 86400.0, dimension(0, 0, 1, 0), false),
    ("rpm", std::f64::consts::TAU / 60.0, dimension(0, 0, -1, 1), false),
    ("%", 1e-2, dimension(0, 0, 0, 0), false),
    ("ppm", 1e-6, dimension(0, 0, 0, 0), false),
    ("1", 1.0, dimension(0, 0, 0, 0), false),
];

/// Prefix and power of ten.
const PREFIXES: [(&str, i32); 12] = [
    ("G", 9),
    ("M", 6),
    ("k", 3),
    ("h", 2),
    ("da", 1),
    ("d", -1),
    ("c", -2),
    ("m", -3),
    ("u", -6),
    ("µ", -6),
    ("μ", -6),
    ("n", -9),
];

/// Factor to SI and dimension of one symbol with or without prefix.
fn symbol(word: &str) -> Option<(f64, Dimension)> {
    if let Some((_, factor, dimension, _)) = SYMBOLS.iter().find(|(symbol, ..)| *symbol == word) {
        return Some((*factor, *dimension));
    }
    PREFIXES.iter().find_map(|(prefix, power)| {
        let rest = word.strip_prefix(prefix)?;
        let (_, factor, dimension, _) = SYMBOLS.iter().find(|(symbol, .., prefixed)| *prefixed && *symbol == rest)?;
        Some((factor * scale(*power), *dimension))
    })
}

/// 10^power, as exact as a literal.
fn scale(power: i32) -> f64 {
    if power < 0 { 1.0 / 10f64.powi(-power) } else { 10f64.powi(power) }
}

/// The length of the number at the beginning of `text`.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let whole = digits(end);
    end += whole;
    let mut fraction = 0;
    if bytes.get(end) == Some(&b'.') {
        fraction = digits(end + 1);
        end += 1 + fraction;
    }
    if whole + fraction == 0 {
        return 0;
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if end + 1 + sign < bytes.len() && digits(end + 1 + sign) > 0 {
            end += 1 + sign + digits(end + 1 + sign);
        }
    }
    end
}

/// The exponent at the beginning of `text` (`^2`, `^-1`, `2`, `²`, `⁻¹`; 1 if there is none) and the text after it.
fn exponent(text: &str) -> Option<(i32, &str)> {
    const SUPERSCRIPTS: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    let marked = text.strip_prefix('^');
    let body = marked.unwrap_or(text);
    let end = body
        .char_indices()
        .find(|(i, c)| {
            let sign = *i == 0 && (*c == '⁻' || (marked.is_some() && matches!(c, '-' | '+')));
            !(sign || c.is_ascii_digit() || SUPERSCRIPTS.contains(*c))
        })
        .map_or(body.len(), |(i, _)| i);
    if end == 0 {
        return marked.is_none().then_some((1, text));
    }
    let plain: String = body[..end]
        .chars()
        .map(|c| match SUPERSCRIPTS.chars().position(|s| s == c) {
            Some(digit) => char::from(b'0' + digit as u8),
            None if c == '⁻' => '-',
            None => c,
        })
        .collect();
    let value: i32 = plain.parse().ok()?;
    (value.abs() <= 9).then_some((value, &body[end..]))
}

/// A number as a scenario may write it, without many zeros.
pub(crate) fn plain(x: f64) -> String {
    if x == 0.0 || (1e-4..1e6).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") }
}

/// The SI unit of a quantity, or "a pure number".
pub fn unit_of(quantity: Quantity) -> &'static str {
    match words(quantity).unit {
        "" => "a pure number",
        unit => unit,
    }
}

/// The quantity that is measured in an SI unit, such as `N m^2`; `1`: a pure number. `None`: there is none, or the unit
/// is not of the SI.
pub fn quantity_in(text: &str) -> Option<Quantity> {
    let named = QUANTITIES.into_iter().find(|&quantity| words(quantity).unit == text);
    named.or_else(|| {
        let (factor, dimension) = unit(text).ok()?;
        let is_si = (factor - 1.0).abs() < 1e-12;
        QUANTITIES.into_iter().find(|&quantity| is_si && words(quantity).dimension == dimension)
    })
}

/// Factor to SI and dimension of a unit; the unknown part if it is not a unit.
fn unit(text: &str) -> Result<(f64, Dimension), String> {
    let (mut factor, mut total) = (1.0, Dimension::default());
    let mut rest = text.trim();
    let mut divide = false;
    while let Some(c) = rest.chars().next() {
        let after = &rest[c.len_utf8()..];
        if c.is_whitespace() || matches!(c, '*' | '·' | '⋅') {
            rest = after;
            continue;
        }
        if c == '/' {
            if divide {
                return Err(rest.to_owned());
            }
            divide = true;
            rest = after;
            continue;
        }
        let end = if c == '1' {
            1
        } else {
            rest.char_indices()
                .find(|(_, c)| !(c.is_alphabetic() || matches!(c, '°' | '%')))
                .map_or(rest.len(), |(i, _)| i)
        };
        let word = &rest[..end];
        let (value, one) = symbol(word).ok_or_else(|| if word.is_empty() { rest } else { word }.to_owned())?;
        let (power, following) = exponent(&rest[end..]).ok_or_else(|| rest.to_owned())?;
        let power = if divide { -power } else { power };
        factor *= if power < 0 { 1.0 / f64::powi(value, -power) } else { f64::powi(value, power) };
        total.metre += power * one.metre;
        total.kilogram += power * one.kilogram;
        total.second += power * one.second;
        total.radian += power * one.radian;
        total.kelvin += power * one.kelvin;
        divide = false;
        rest = following;
    }
    if divide { Err("/".to_owned()) } else { Ok((factor, total)) }
}

/// The value of a string with a unit, in SI.
///
/// # Errors
/// The fault, in words that follow the quoted text in a message.
pub(crate) fn parse(text: &str, quantity: Quantity) -> Result<f64, String> {
    let words = words(quantity);
    let trimmed = text.trim();
    let split = number_length(trimmed);
    let (number, rest) = trimmed.split_at(split);
    let Ok(number) = number.parse::<f64>() else {
        return Err(format!("is not {}", words.name));
    };
    if rest.trim().is_empty() && !words.unit.is_empty() {
        return Err("has no unit".to_owned());
    }
    let (factor, found) = unit(rest).map_err(|part| format!("has the unknown unit `{part}`"))?;
    if found != words.dimension && Some(found) != words.alternative {
        return Err(format!("is {}, not {}", describe(found), words.name));
    }
    // Dividing by an exact power of ten rounds once, as the literal in SI would.
    let value = if factor < 1.0 && (1.0 / factor).fract() == 0.0 { number / (1.0 / factor) } else { number * factor };
    if value.is_finite() { Ok(value) } else { Err("is too large".to_owned()) }
}

/// The value of a string with any unit, in SI, and that SI unit as [`parse`] reads it; empty for a pure number.
///
/// # Errors
/// The fault, in words that follow the quoted text in a message.
pub(crate) fn any(text: &str) -> Result<(f64, String), String> {
    let trimmed = text.trim();
    let (number, rest) = trimmed.split_at(number_length(trimmed));
    let number: f64 = number.parse().map_err(|_| "is no number".to_owned())?;
    let (factor, found) = unit(rest).map_err(|part| format!("has the unknown unit `{part}`"))?;
    let value = if factor < 1.0 && (1.0 / factor).fract() == 0.0 { number / (1.0 / factor) } else { number * factor };
    Ok((value, symbols(found)))
}

/// `kg m^2 s^-2`.
fn symbols(d: Dimension) -> String {
    let factors: Vec<String> =
        [("kg", d.kilogram), ("m", d.metre), ("s", d.second), ("rad", d.radian), ("K", d.kelvin)]
            .into_iter()
            .filter(|(_, exponent)| *exponent != 0)
            .map(|(symbol, exponent)| if exponent == 1 { symbol.to_owned() } else { format!("{symbol}^{exponent}") })
            .collect();
    factors.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_is_that_of_its_unit() {
        for quantity in QUANTITIES {
            let unit = if quantity == Quantity::Dimensionless { "1" } else { unit_of(quantity) };
            assert_eq!(quantity_in(unit), Some(quantity), "{unit}");
        }
        assert_eq!(quantity_in("N m^2"), Some(Quantity::BendingStiffness));
        assert_eq!((quantity_in("mm"), quantity_in("furlong"), quantity_in("m^7")), (None, None, None));
    }

    #[test]
    fn units_convert_to_si() {
        let cases = [
            ("600 mm", Quantity::Length, 0.6),
            ("600mm", Quantity::Length, 0.6),
            ("30 deg", Quantity::Angle, std::f64::consts::PI / 6.0),
            ("30°", Quantity::Angle, std::f64::consts::PI / 6.0),
            ("120 g/m", Quantity::LinearDensity, 0.12),
            ("0.5 N/mm", Quantity::ForcePerLength, 500.0),
            ("12 N mm^2", Quantity::BendingStiffness, 1.2e-5),
            ("12 N mm²", Quantity::BendingStiffness, 1.2e-5),
            ("12 N·mm2", Quantity::BendingStiffness, 1.2e-5),
            ("9.81 m/s^2", Quantity::Acceleration, 9.81),
            ("9.81 m s⁻²", Quantity::Acceleration, 9.81),
            ("-1.5e3 µm", Quantity::Length, -1.5e-3),
            ("3 1/m", Quantity::Curvature, 3.0),
            ("3 /m", Quantity::Curvature, 3.0),
            ("180 deg/m", Quantity::Curvature, std::f64::consts::PI),
            ("5 N m", Quantity::MomentPerAngle, 5.0),
            ("5 N m/rad", Quantity::MomentPerAngle, 5.0),
            ("2 kN", Quantity::Force, 2000.0),
            ("1 kg m/s^2", Quantity::Force, 1.0),
            ("50 %", Quantity::Dimensionless, 0.5),
            ("7 MPa mm^2", Quantity::Force, 7.0),
            ("50 MPa", Quantity::Pressure, 5e7),
            ("120 kN/mm²", Quantity::Pressure, 1.2e11),
            ("1.35 g/cm3", Quantity::Density, 1350.0),
            ("72 km/s", Quantity::Velocity, 72e3),
            ("95 K", Quantity::Temperature, 95.0),
            ("3000 rpm", Quantity::AngularSpeed, 100.0 * std::f64::consts::PI),
            ("30 turns/min", Quantity::AngularSpeed, std::f64::consts::PI),
            ("2 h", Quantity::Time, 7200.0),
            ("1.5 d", Quantity::Time, 129_600.0),
            ("20 ms", Quantity::Time, 0.02),
            ("17 ppm/K", Quantity::ThermalExpansion, 17e-6),
            ("17e-6 1/K", Quantity::ThermalExpansion, 17e-6),
            ("0.02 1/m/K", Quantity::ThermalCurvature, 0.02),
        ];
        for (text, quantity, expected) in cases {
            let value = parse(text, quantity).unwrap_or_else(|e| panic!("{text}: {e}"));
            assert!((value - expected).abs() <= 1e-15 * expected.abs(), "{text}: {value:e}, not {expected:e}");
        }
    }

    #[test]
    fn any_unit_becomes_an_si_unit_that_is_understood() {
        for (text, quantity) in [
            ("412 mm", Quantity::Length),
            ("3 kN", Quantity::Force),
            ("30 deg", Quantity::Angle),
            ("5 N mm/deg", Quantity::MomentPerAngle),
            ("1.35 g/cm3", Quantity::Density),
            ("7 MPa", Quantity::Pressure),
        ] {
            let (value, unit) = any(text).unwrap();
            assert_eq!(parse(&format!("{value:?} {unit}"), quantity), Ok(value), "{text}: {unit}");
            assert_eq!(parse(text, quantity), Ok(value));
        }
        assert_eq!(any("0.5"), Ok((0.5, String::new())));
        assert!(any("cosserat").is_err() && any("5 furlongs").is_err());
    }

    #[test]
    fn wrong_units_are_named() {
        let cases = [
            ("600 s", Quantity::Length, "is a time, not a length"),
            ("600 N", Quantity::Length, "is a force, not a length"),
            ("600", Quantity::Length, "has no unit"),
            ("600 mmm", Quantity::Length, "has the unknown unit `mmm`"),
            ("600 /", Quantity::Length, "has the unknown unit `/`"),
            ("600 m^", Quantity::Length, "has the unknown unit `m^`"),
            ("600 m^99999999999", Quantity::Length, "has the unknown unit `m^99999999999`"),
            ("long", Quantity::Length, "is not a length"),
            ("", Quantity::Length, "is not a length"),
            ("inf m", Quantity::Length, "is not a length"),
            ("1e308 km", Quantity::Length, "is too large"),
            ("5 N", Quantity::Moment, "is a force, not a moment"),
            ("120 °C", Quantity::Temperature, "has the unknown unit `°C`"),
            ("30 deg", Quantity::Dimensionless, "is an angle, not a pure number"),
        ];
        for (text, quantity, expected) in cases {
            assert_eq!(parse(text, quantity).unwrap_err(), expected, "{text}");
        }
    }
}
