//! Units: every value refers to a `Unit` element of its file.

/// Quantity of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Length,
    Area,
    Mass,
    MassPerLength,
}

impl Quantity {
    /// The least and the greatest possible value, SI.
    pub fn range(self) -> [f64; 2] {
        match self {
            Quantity::Length => [1e-6, 1e5],
            Quantity::Area => [1e-12, 1.0],
            Quantity::Mass => [1e-9, 1e6],
            Quantity::MassPerLength => [1e-9, 100.0],
        }
    }

    pub fn word(self) -> &'static str {
        match self {
            Quantity::Length => "length",
            Quantity::Area => "area",
            Quantity::Mass => "mass",
            Quantity::MassPerLength => "mass per length",
        }
    }
}

/// A known unit: its quantity, and its size in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Unit {
    pub quantity: Quantity,
    pub size: f64,
}

impl Unit {
    /// From the parts of a `Unit` element: a free name, or an SI unit's name, prefix and dimension.
    pub fn parse(
        name: Option<&str>,
        si_name: Option<&str>,
        prefix: Option<&str>,
        dimension: Option<&str>,
    ) -> Option<Self> {
        match si_name {
            Some(si_name) => Self::si(si_name, prefix, dimension),
            None => Self::named(name?),
        }
    }

    /// The prefix belongs to the unit before it is squared: milli metre square is (10⁻³ m)².
    fn si(name: &str, prefix: Option<&str>, dimension: Option<&str>) -> Option<Self> {
        let prefix = size_of_prefix(prefix)?;
        let dimension = dimension.map(str::to_ascii_lowercase);
        let linear = matches!(dimension.as_deref(), None | Some("" | "/null" | "none"));
        match (name.to_ascii_lowercase().as_str(), dimension.as_deref()) {
            ("metre" | "meter", _) if linear => Some(Self { quantity: Quantity::Length, size: prefix }),
            ("metre" | "meter", Some("square")) => Some(Self { quantity: Quantity::Area, size: prefix * prefix }),
            ("gram" | "gramme", _) if linear => Some(Self { quantity: Quantity::Mass, size: 1e-3 * prefix }),
            _ => None,
        }
    }

    fn named(name: &str) -> Option<Self> {
        let name: String = name.chars().filter(|c| !c.is_whitespace() && *c != '_').collect::<String>().to_lowercase();
        let (quantity, size) = match name.as_str() {
            "m" | "metre" | "meter" => (Quantity::Length, 1.0),
            "cm" | "centimetre" | "centimeter" => (Quantity::Length, 1e-2),
            "mm" | "millimetre" | "millimeter" => (Quantity::Length, 1e-3),
            "m2" | "m²" | "squaremetre" | "squaremeter" => (Quantity::Area, 1.0),
            "mm2" | "mm²" | "squaremillimetre" | "squaremillimeter" => (Quantity::Area, 1e-6),
            "kg" | "kilogram" => (Quantity::Mass, 1.0),
            "g" | "gram" => (Quantity::Mass, 1e-3),
            "kg/m" | "kilogrampermetre" | "kilogrampermeter" => (Quantity::MassPerLength, 1.0),
            "g/m" | "kg/km" | "grampermetre" | "grampermeter" | "kilogramperkilometre" | "kilogramperkilometer" => {
                (Quantity::MassPerLength, 1e-3)
            }
            "g/mm" | "grampermillimetre" | "grampermillimeter" => (Quantity::MassPerLength, 1.0),
            _ => return None,
        };
        Some(Self { quantity, size })
    }
}

/// 10 to the power of a prefix of SI; 1 without one.
fn size_of_prefix(prefix: Option<&str>) -> Option<f64> {
    Some(match prefix.map(str::to_ascii_lowercase).as_deref() {
        None | Some("" | "/null" | "none") => 1.0,
        Some("mega") => 1e6,
        Some("kilo") => 1e3,
        Some("hecto") => 1e2,
        Some("deca") => 1e1,
        Some("deci") => 1e-1,
        Some("centi") => 1e-2,
        Some("milli") => 1e-3,
        Some("micro") => 1e-6,
        Some("nano") => 1e-9,
        _ => return None,
    })
}

/// A product of powers of units: the exponents of length and mass, and its size in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Product {
    length: i32,
    mass: i32,
    size: f64,
}

impl Product {
    /// Of nothing, or of pieces.
    pub const ONE: Self = Self { length: 0, mass: 0, size: 1.0 };

    fn length(size: f64) -> Self {
        Self { length: 1, mass: 0, size }
    }

    fn mass(size: f64) -> Self {
        Self { length: 0, mass: 1, size }
    }

    /// A unit of SI with its prefix.
    pub fn si(name: &str, prefix: Option<&str>) -> Option<Self> {
        let prefix = size_of_prefix(prefix)?;
        match name.to_ascii_lowercase().as_str() {
            "metre" | "meter" => Some(Self::length(prefix)),
            "gram" | "gramme" => Some(Self::mass(1e-3 * prefix)),
            _ => None,
        }
    }

    /// An imperial unit, or one of the United States, which are the same where they have the same name here.
    pub fn imperial(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "thou" => Some(Self::length(25.4e-6)),
            "inch" => Some(Self::length(0.0254)),
            "foot" => Some(Self::length(0.3048)),
            "yard" => Some(Self::length(0.9144)),
            "ounce" => Some(Self::mass(0.028_349_523_125)),
            "pound" => Some(Self::mass(0.453_592_37)),
            _ => None,
        }
    }

    /// By a free name.
    pub fn named(name: &str) -> Option<Self> {
        let Unit { quantity, size } = Unit::named(name)?;
        let (length, mass) = match quantity {
            Quantity::Length => (1, 0),
            Quantity::Area => (2, 0),
            Quantity::Mass => (0, 1),
            Quantity::MassPerLength => (-1, 1),
        };
        Some(Self { length, mass, size })
    }

    /// A power of it; `None` where that is no unit that is used.
    pub fn power(self, exponent: i32) -> Option<Self> {
        let [length, mass] = [self.length, self.mass].map(|own| own.checked_mul(exponent));
        let size = self.size.powi(exponent);
        (size.is_finite() && size > 0.0).then_some(Self { length: length?, mass: mass?, size })
    }

    pub fn times(self, other: Self) -> Option<Self> {
        let [length, mass] = [(self.length, other.length), (self.mass, other.mass)].map(|(a, b)| a.checked_add(b));
        Some(Self { length: length?, mass: mass?, size: self.size * other.size })
    }

    /// The unit that it is.
    pub fn unit(self) -> Option<Unit> {
        let quantity = match (self.length, self.mass) {
            (1, 0) => Quantity::Length,
            (2, 0) => Quantity::Area,
            (0, 1) => Quantity::Mass,
            (-1, 1) => Quantity::MassPerLength,
            _ => return None,
        };
        Some(Unit { quantity, size: self.size })
    }
}

#[cfg(test)]
mod tests {
    use super::{Product, Quantity, Unit};

    #[test]
    fn products_of_powers_are_units() {
        let metre = |prefix| Product::si("Metre", prefix).unwrap();
        let area = metre(Some("Milli")).power(2).and_then(Product::unit).unwrap();
        assert!(area.quantity == Quantity::Area && (area.size - 1e-6).abs() < 1e-20, "{area:?}");
        let per_metre = metre(None).power(-1).unwrap();
        let density = Product::si("Gram", Some("Kilo")).and_then(|mass| mass.times(per_metre)).and_then(Product::unit);
        assert_eq!(density, Some(Unit { quantity: Quantity::MassPerLength, size: 1.0 }));
        assert_eq!(Product::named("g/m").and_then(Product::unit), Unit::named("g/m"));
        assert_eq!(metre(None).power(3).and_then(Product::unit), None);
        assert_eq!(Product::si("Ampere", None), None);
    }

    #[test]
    fn the_prefix_is_squared_with_its_unit() {
        let unit = Unit::parse(None, Some("metre"), Some("milli"), Some("square")).unwrap();
        assert_eq!(unit.quantity, Quantity::Area);
        assert!((unit.size - 1e-6).abs() < 1e-20);
    }

    #[test]
    fn names_of_masses_per_length() {
        for (name, size) in [("GramPerMetre", 1e-3), ("g/m", 1e-3), ("kg/m", 1.0), ("kg / km", 1e-3)] {
            assert_eq!(
                Unit::parse(Some(name), None, None, None),
                Some(Unit { quantity: Quantity::MassPerLength, size })
            );
        }
    }

    #[test]
    fn what_is_not_known_is_not_guessed() {
        assert_eq!(Unit::parse(Some("ampere"), None, None, None), None);
        assert_eq!(Unit::parse(None, Some("metre"), Some("furlong"), None), None);
        assert_eq!(Unit::parse(None, Some("gram"), None, Some("square")), None);
        assert_eq!(Unit::parse(None, None, None, None), None);
    }
}
