//! Physical quantities, and the outputs that kinds of constraints declare.

/// Physical quantity of a number, which determines the units that a scenario may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A pure number.
    Dimensionless,
    /// m
    Length,
    /// kg
    Mass,
    /// kg/m
    LinearDensity,
    /// N
    Force,
    /// N m
    Moment,
    /// N/m
    ForcePerLength,
    /// N m/rad
    MomentPerAngle,
    /// N m²
    BendingStiffness,
    /// 1/m
    Curvature,
    /// rad
    Angle,
    /// m/s²
    Acceleration,
    /// Pa
    Pressure,
    /// kg/m³
    Density,
    /// m/s
    Velocity,
    /// K
    Temperature,
    /// 1/K
    ThermalExpansion,
    /// 1/(m K)
    ThermalCurvature,
    /// rad/s
    AngularSpeed,
    /// s
    Time,
    /// J
    Energy,
    /// m²
    Area,
}

impl Quantity {
    /// SI unit; empty for a pure number.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Dimensionless => "",
            Self::Length => "m",
            Self::Mass => "kg",
            Self::LinearDensity => "kg/m",
            Self::Force => "N",
            Self::Moment => "N m",
            Self::ForcePerLength => "N/m",
            Self::MomentPerAngle => "N m/rad",
            Self::BendingStiffness => "N m²",
            Self::Curvature => "1/m",
            Self::Angle => "rad",
            Self::Acceleration => "m/s²",
            Self::Pressure => "Pa",
            Self::Density => "kg/m³",
            Self::Velocity => "m/s",
            Self::Temperature => "K",
            Self::ThermalExpansion => "1/K",
            Self::ThermalCurvature => "1/(m K)",
            Self::AngularSpeed => "rad/s",
            Self::Time => "s",
            Self::Energy => "J",
            Self::Area => "m²",
        }
    }
}

/// A declared output of a kind of constraint: a quantity of its own that it reports at each equilibrium, or an event.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Name in results.
    pub name: String,
    /// One-line description.
    pub doc: String,
    /// Its quantity, in SI units.
    pub quantity: Quantity,
    /// Whether it is an event, such as that a clip has opened: it has a value only at the equilibria where it happens,
    /// and the run logs it.
    pub event: bool,
}
