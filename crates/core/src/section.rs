//! Cross-section of a branch.

use crate::curve::{Curve, mean_slope};
use crate::{Matrix, Rotation, Vector};
use nalgebra::SymmetricEigen;
use serde::{Deserialize, Serialize};

/// Cross-section of a branch. All values are per unstressed length, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Name in the scenario.
    pub name: String,
    /// Outer diameter, m.
    pub diameter: f64,
    /// Mass per length, kg/m.
    pub linear_density: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Shear stiffness GA along d1 and d2, N.
    pub shear_stiffness: [f64; 2],
    /// Bending stiffness EI about d1 and d2, N m²: C11 and C22 where bending is coupled.
    pub bending_stiffness: [f64; 2],
    /// Torsion stiffness GJ, N m².
    pub torsion_stiffness: f64,
    /// Stiffness C12, C13, C23 that couples bending about d1 with bending about d2, bending about d1 with twist, and
    /// bending about d2 with twist, N m²; see [`Section::bend_stiffness`]. A branch that is run from its other end has
    /// −C12 and −C13.
    pub coupling_stiffness: [f64; 3],
    /// Smallest bend radius allowed, m; the run reports smaller ones.
    pub min_bend_radius: Option<f64>,
    /// Smallest bend radius allowed while the branch moves, m: the dynamic one of data sheets.
    pub min_bend_radius_moving: Option<f64>,
    /// Largest tension allowed, N; of a bundle by default the tension that breaks its first conductor.
    pub max_tension: Option<f64>,
    /// Largest twist allowed beyond that at rest, either way, rad/m.
    pub max_torsion: Option<f64>,
    /// Axial strain without force per change of temperature, 1/K.
    pub thermal_expansion: f64,
    /// Curvature about d1 and d2, and twist, without moment per change of temperature, 1/(m K): layers that expand
    /// differently.
    pub thermal_curvature: Vector,
    /// Friction within the section, beside its elastic stiffness.
    pub friction: SectionFriction,
    /// Part of the bending stiffness that yields, if bends beyond a limit are permanent: the section then has linear
    /// kinematic hardening, with EI up to its limit and EI less this stiffness beyond.
    pub set: Option<FrictionElement>,
    /// Laws in place of EI and EA, and creep.
    pub laws: SectionLaws,
}

/// Laws of a section that are not linear, or depend on time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SectionLaws {
    /// Moment (N m) over curvature (1/m), alike in all directions, in place of EI; [`Section::bending_stiffness`] is
    /// then its slope at the origin.
    pub bending: Option<Curve>,
    /// Axial force over strain in place of EA; [`Section::axial_stiffness`] is then that of small tension.
    pub axial: Option<AxialLaw>,
    /// What relaxes.
    pub creep: SectionCreep,
    /// Part of the torsion stiffness that yields, as [`Section::set`] is of the bending stiffness.
    pub torsion_set: Option<FrictionElement>,
}

/// Axial force (N) over strain: `n = f(ε)` in tension, `n = −g(−ε)` in compression.
#[derive(Clone, Debug, PartialEq)]
pub struct AxialLaw {
    tension: Curve,
    compression: Curve,
    /// Whether it passes through points of a table.
    pub measured: bool,
}

impl AxialLaw {
    /// Strain over which a cable with another stiffness in compression becomes taut: from 0 on its stiffness grows
    /// linearly to that of tension. The force is then less by half of this strain times the change of stiffness, which
    /// is as if the cable were longer by 0.005 %. Newton's method needs a slope that is continuous.
    pub const TAUT: f64 = 1e-4;

    /// EA in tension, and another one in compression, N; neither is negative, and that in compression is the smaller.
    pub fn of_two(tension: f64, compression: f64) -> Self {
        let taut = [Self::TAUT, 0.5 * (tension + compression) * Self::TAUT];
        Self {
            tension: Curve::with_slopes(&[taut], &[compression, tension]),
            compression: Curve::straight(compression),
            measured: false,
        }
    }

    /// Through the origin and these points `[strain, force]`, both strictly increasing, at least one of them positive.
    /// Beyond the last point it goes on with the slope of the last chord, and in compression, where that has no points,
    /// with `compression` (N), or else the slope at the origin. `compression` is at most three times the slope of the
    /// first chord.
    pub fn through(points: &[[f64; 2]], compression: Option<f64>) -> Self {
        let tension: Vec<[f64; 2]> = points.iter().copied().filter(|[x, _]| *x > 0.0).collect();
        let below: Vec<[f64; 2]> = points.iter().rev().filter(|[x, _]| *x < 0.0).map(|[x, y]| [-x, -y]).collect();
        let chord = |[x, y]: [f64; 2]| [x, y / x];
        if let (Some(before), Some(after)) = (below.first(), tension.first()) {
            let slope = Some(mean_slope(chord(*before), chord(*after)));
            let [tension, compression] = [tension, below].map(|points| Curve::new(&points, slope));
            return Self { tension, compression, measured: true };
        }
        let tension = Curve::new(&tension, compression);
        let compression = Curve::straight(tension.slope(0.0));
        Self { tension, compression, measured: true }
    }

    /// Energy per length, J/m.
    pub fn energy(&self, strain: f64) -> f64 {
        if strain < 0.0 { self.compression.integral(-strain) } else { self.tension.integral(strain) }
    }

    /// Force, N.
    pub fn force(&self, strain: f64) -> f64 {
        if strain < 0.0 { -self.compression.value(-strain) } else { self.tension.value(strain) }
    }

    /// Derivative of the force in the strain, N.
    pub fn stiffness(&self, strain: f64) -> f64 {
        if strain < 0.0 { self.compression.slope(-strain) } else { self.tension.slope(strain) }
    }

    /// Strain under a force (N).
    pub fn strain(&self, force: f64) -> f64 {
        if force < 0.0 { -self.compression.inverse(-force) } else { self.tension.inverse(force) }
    }

    /// The greatest stiffness that it has, N.
    pub fn greatest_stiffness(&self) -> f64 {
        self.tension.greatest_slope().max(self.compression.greatest_slope())
    }
}

/// Creep of a section: a part of its stiffness relaxes with time (a generalised Maxwell model).
///
/// Each element is a spring in series with a dashpot, and all of them act in parallel with what lasts. At once the
/// section has the stiffness `C + Σ k`, after a long time C.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SectionCreep {
    /// Elements in bending, alike in all directions.
    pub bending: Vec<CreepElement>,
    /// Elements in torsion.
    pub torsion: Vec<CreepElement>,
}

impl SectionCreep {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.bending.is_empty() && self.torsion.is_empty()
    }
}

/// Element of creep: a spring in series with a dashpot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreepElement {
    /// k, N m²: stiffness of the spring.
    pub stiffness: f64,
    /// τ, s: the time in which its moment falls to 1/e at a curvature that is held.
    pub time: f64,
}

/// Friction within a section, of wires and coverings that slip on each other, or between an arm and its hub
/// (Prandtl–Ishlinskii model).
///
/// Each element is a spring in series with a slider, and all of them act in parallel with the elastic stiffness of the
/// section or the spring. While nothing slips it has the stiffness `C + Σ k`, once all slip it has C.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SectionFriction {
    /// Elements in bending. Each acts on the pair (κ1, κ2), alike in all directions, also where EI1 and EI2 differ: it
    /// slips where the length of its moment reaches its limit.
    pub bending: Vec<FrictionElement>,
    /// Elements in torsion.
    pub torsion: Vec<FrictionElement>,
}

impl SectionFriction {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.bending.is_empty() && self.torsion.is_empty()
    }

    /// Diagonal of the stiffness that it adds while nothing slips.
    pub fn diagonal(&self) -> Vector {
        let [bending, torsion] =
            [&self.bending, &self.torsion].map(|elements| elements.iter().map(|own| own.stiffness).sum::<f64>());
        Vector::new(bending, bending, torsion)
    }
}

/// Element of friction: a spring in series with a slider.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionElement {
    /// k, N m² (between an arm and its hub N m/rad): stiffness of the spring.
    pub stiffness: f64,
    /// M, N m: moment at which the slider slips.
    pub moment: f64,
}

impl FrictionElement {
    /// The element beside an elastic stiffness that makes it `ratio` times as stiff (above 1) up to this moment of both
    /// together.
    pub fn slipping_at(moment: f64, ratio: f64, elastic: f64) -> Self {
        Self { stiffness: (ratio - 1.0) * elastic, moment: moment * (1.0 - 1.0 / ratio) }
    }

    /// Curvature (1/m) or turn (rad) at which it begins to slip.
    pub fn limit(&self) -> f64 {
        self.moment / self.stiffness
    }
}

/// Smallest stiffness against a bending moment about any axis, with C (N m²) and no moment in twist, N m²: `m²/(m·κ)`
/// with `κ = C⁻¹ m`. 0 without a stiffness in every direction.
pub fn softest_bending(stiffness: &Matrix) -> f64 {
    let bent = |compliance: Matrix| compliance.fixed_view::<2, 2>(0, 0).into_owned().symmetric_eigenvalues().max();
    stiffness.try_inverse().map_or(0.0, |compliance| 1.0 / bent(compliance))
}

impl Section {
    /// Diagonal of the stretch-shear stiffness `diag(GA1, GA2, EA)`, N.
    pub fn stretch_diagonal(&self) -> Vector {
        Vector::new(self.shear_stiffness[0], self.shear_stiffness[1], self.axial_stiffness)
    }

    /// Diagonal of the bend-twist stiffness `diag(EI1, EI2, GJ)`, N m².
    pub fn bend_diagonal(&self) -> Vector {
        Vector::new(self.bending_stiffness[0], self.bending_stiffness[1], self.torsion_stiffness)
    }

    /// C of bending and twist, N m²: `m = C (κ − κ°)` in the axes d1, d2, d3.
    pub fn bend_stiffness(&self) -> Matrix {
        self.with_coupling(self.bend_diagonal())
    }

    /// C with this diagonal, N m².
    fn with_coupling(&self, diagonal: Vector) -> Matrix {
        let [c12, c13, c23] = self.coupling_stiffness;
        Matrix::new(diagonal.x, c12, c13, c12, diagonal.y, c23, c13, c23, diagonal.z)
    }

    /// Whether bending and twist are coupled.
    pub fn couples(&self) -> bool {
        self.coupling_stiffness != [0.0; 3]
    }

    /// Principal axes of bending and twist: Q and c with `C = Q diag(c) Qᵀ` (N m²), so that frames `q Q` have the
    /// stiffness diag(c). They are in the order in which they are nearest to d1, d2 and d3.
    pub fn principal_axes(&self) -> (Rotation, Vector) {
        if !self.couples() {
            return (Rotation::identity(), self.bend_diagonal());
        }
        let SymmetricEigen { eigenvectors, eigenvalues } = self.bend_stiffness().symmetric_eigen();
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let nearness = |order: &[usize; 3]| (0..3).map(|i| eigenvectors[(i, order[i])].abs()).sum::<f64>();
        let order = orders.into_iter().max_by(|a, b| nearness(a).total_cmp(&nearness(b))).unwrap_or([0, 1, 2]);
        let mut axes = Matrix::from_columns(&order.map(|k| eigenvectors.column(k)));
        for i in 0..3 {
            if axes[(i, i)] < 0.0 {
                axes.column_mut(i).neg_mut();
            }
        }
        if axes.determinant() < 0.0 {
            axes.column_mut(2).neg_mut();
        }
        let axes = nalgebra::Rotation3::from_matrix_unchecked(axes);
        (Rotation::from_rotation_matrix(&axes), Vector::from_iterator(order.map(|k| eigenvalues[k])))
    }

    /// Curvature and twist beyond those at rest (1/m) under a moment (N m, axes d1, d2, d3), of an elastic section.
    pub fn curvature_under(&self, moment: &Vector) -> Vector {
        if !self.couples() {
            return moment.component_div(&self.bend_diagonal());
        }
        let (axes, c) = self.principal_axes();
        axes * axes.inverse_transform_vector(moment).component_div(&c)
    }

    /// Diagonal of the bend-twist stiffness that is linear and lasts, N m²: of what neither slips, yields, relaxes nor
    /// has a curve.
    pub fn lasting_diagonal(&self) -> Vector {
        let [bending, torsion] = [self.set, self.laws.torsion_set].map(|set| set.map_or(0.0, |set| set.stiffness));
        let lasting = self.bend_diagonal() - Vector::new(bending, bending, torsion);
        if self.laws.bending.is_some() { Vector::new(0.0, 0.0, lasting.z) } else { lasting }
    }

    /// Stretch-shear stiffness that is linear, N: `diag(GA1, GA2, EA)`, with 0 in place of EA where there is an axial
    /// law.
    pub fn linear_stretch_diagonal(&self) -> Vector {
        let linear = self.stretch_diagonal();
        if self.laws.axial.is_some() { Vector::new(linear.x, linear.y, 0.0) } else { linear }
    }

    /// Axial strain under a tension (N).
    pub fn strain(&self, tension: f64) -> f64 {
        self.laws.axial.as_ref().map_or_else(|| tension / self.axial_stiffness, |law| law.strain(tension))
    }

    /// Derivative of the axial force in the strain at a tension (N), N.
    pub fn stiffness_at(&self, tension: f64) -> f64 {
        self.laws.axial.as_ref().map_or(self.axial_stiffness, |law| law.stiffness(law.strain(tension)))
    }

    /// All that slips or yields, beside [`Self::lasting_diagonal`].
    pub fn slipping(&self) -> SectionFriction {
        let SectionFriction { bending, torsion } = &self.friction;
        SectionFriction {
            bending: bending.iter().copied().chain(self.set).collect(),
            torsion: torsion.iter().copied().chain(self.laws.torsion_set).collect(),
        }
    }

    /// Whether it expands or bends with the temperature.
    pub fn feels_temperature(&self) -> bool {
        self.thermal_expansion != 0.0 || self.bends_with_temperature()
    }

    /// Whether it bends with the temperature.
    pub fn bends_with_temperature(&self) -> bool {
        self.thermal_curvature != Vector::zeros()
    }

    /// Whether it keeps a set: something in it slips, yields or relaxes.
    pub fn remembers(&self) -> bool {
        !self.friction.is_empty() || self.yields() || !self.laws.creep.is_empty()
    }

    /// Whether bends or twists beyond a limit are permanent.
    fn yields(&self) -> bool {
        self.set.is_some() || self.laws.torsion_set.is_some()
    }

    /// The keys of what it has beside linear stiffness, as scenarios have them.
    pub fn nonlinear_keys(&self) -> Vec<&'static str> {
        let has = [
            ("`friction`", !self.friction.is_empty()),
            ("`set`", self.yields()),
            ("`creep`", !self.laws.creep.is_empty()),
            ("a `bending_curve`", self.laws.bending.is_some()),
            ("an axial law", self.laws.axial.is_some()),
        ];
        has.into_iter().filter(|(_, has)| *has).map(|(key, _)| key).collect()
    }

    /// Whether moments are those of [`Self::bend_stiffness`] alone.
    pub fn bends_linearly(&self) -> bool {
        !self.remembers() && self.laws.bending.is_none()
    }

    /// Whether twist follows from the moment by C alone.
    pub fn twists_linearly(&self) -> bool {
        self.friction.torsion.is_empty() && self.laws.creep.torsion.is_empty() && self.laws.torsion_set.is_none()
    }

    /// C of bending and twist while nothing slips or relaxes, N m²: the stiffest that the section is.
    pub fn sticking_stiffness(&self) -> Matrix {
        self.with_coupling(self.sticking_diagonal())
    }

    /// Diagonal of [`Self::sticking_stiffness`], N m².
    pub fn sticking_diagonal(&self) -> Vector {
        let Self { friction, laws: SectionLaws { creep, bending: curve, .. }, .. } = self;
        let sum = |elements: &Vec<CreepElement>| elements.iter().map(|element| element.stiffness).sum::<f64>();
        let [bending, torsion] = [&creep.bending, &creep.torsion].map(sum);
        let elastic = match curve {
            Some(curve) => {
                let greatest = curve.greatest_slope();
                Vector::new(greatest, greatest, self.torsion_stiffness)
            }
            None => self.bend_diagonal(),
        };
        elastic + (friction.diagonal() + Vector::new(bending, bending, torsion))
    }

    /// The greatest axial stiffness that it has, N.
    pub fn greatest_axial_stiffness(&self) -> f64 {
        self.laws.axial.as_ref().map_or(self.axial_stiffness, AxialLaw::greatest_stiffness)
    }
}
