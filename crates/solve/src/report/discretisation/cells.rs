//! What a scheme of fourth order leaves of the energy of bending and twist, to leading order.
//!
//! The mean curvature of a cell follows from its rotation vector by the first commutator of the Magnus expansion
//! (`models::variation`), the variation of curvature within it by differences. With `m = C (κ − κ°)` and derivatives by
//! the arc length, what is left of a span of cells of length ℓ is
//!
//! ```text
//! D = ℓ⁴ ∫ f ds + ℓ⁴ [−b],        b at the start of the span, −b at its end
//! f = −(1/180) κ″·Cκ″ + (1/45) Cκ′·(κ×κ″) + (1/60) m·(κ′×κ″) − (1/180) m·(κ×(κ×κ″)) + (1/360) m·(κ′×(κ×κ′))
//!     − (1/720) m·(κ×(κ×(κ×κ′))) − (3/640) |κ|⁴ m·κ
//! b = (23/5760) (Cκ′·κ″ − m·(κ×κ″)) − (25/5760) (Cκ′·(κ×κ′) − m·(κ×(κ×κ′)))
//! ```
//!
//! Derived by expansion of the rotation vectors of three neighbouring cells (at a station: of the half cell and the
//! next two) to the order ℓ⁵ and comparison with `½ ∫ (κ − κ°)·C (κ − κ°) ds`, integrated by parts. The last term of f
//! belongs to the law of a coupling, whose curvature is the angle over the length but for `φ⁴·3/640`.

use wireloom_core::{Matrix, Vector};

/// Error of the law of a coupling relative to its curvature, for the angle of a cell to the fourth power.
const LAW: f64 = 3.0 / 640.0;

/// Curvature with its derivatives, 1/m, 1/m², 1/m³, at rest, and C, N m².
pub(super) struct Curvature {
    /// κ.
    pub own: Vector,
    /// κ′.
    pub rate: Vector,
    /// κ″.
    pub second: Vector,
    /// κ°.
    pub rest: Vector,
    /// C.
    pub stiffness: Matrix,
}

/// Derivatives by κ, κ′ and κ″.
type Derivatives = [Vector; 3];

impl Curvature {
    /// Of f.
    pub fn of_cells(&self) -> Derivatives {
        let Self { own: k, rate: k1, second: k2, rest, stiffness } = self;
        let c = |v: &Vector| stiffness * v;
        let m = c(&(k - rest));
        let (across, along) = (k.cross(k1), k.cross(k2));
        let (twice, moment) = (k.cross(&across), m.cross(k));
        let square = k.norm_squared();
        let by_moment = k1.cross(k2) / 60.0 - k.cross(&along) / 180.0 + k1.cross(&across) / 360.0
            - k.cross(&twice) / 720.0
            - k * (LAW * square * square);
        let by_own = c(&by_moment) + k2.cross(&c(k1)) / 45.0 - (along.cross(&m) + k2.cross(&moment)) / 180.0
            + k1.cross(&m.cross(k1)) / 360.0
            - (twice.cross(&m) + across.cross(&moment) + k1.cross(&moment.cross(k))) / 720.0
            - (m * (square * square) + k * (4.0 * square * m.dot(k))) * LAW;
        let by_rate = c(&along) / 45.0 + k2.cross(&m) / 60.0 + (across.cross(&m) + m.cross(k1).cross(k)) / 360.0
            - moment.cross(k).cross(k) / 720.0;
        let by_second = c(k1).cross(k) / 45.0 + m.cross(k1) / 60.0 - moment.cross(k) / 180.0 - c(k2) / 90.0;
        [by_own, by_rate, by_second]
    }

    /// Of b.
    pub fn at_station(&self) -> Derivatives {
        let Self { own: k, rate: k1, second: k2, rest, stiffness } = self;
        let c = |v: &Vector| stiffness * v;
        let m = c(&(k - rest));
        let (across, along, moment) = (k.cross(k1), k.cross(k2), m.cross(k));
        let [first, other] = [23.0 / 5760.0, 25.0 / 5760.0];
        let by_own = (c(&along) + k2.cross(&m)) * -first
            + (c(&k.cross(&across)) + across.cross(&m) + k1.cross(&moment) - k1.cross(&c(k1))) * other;
        let by_rate = c(k2) * first - (c(&across) + c(k1).cross(k) - moment.cross(k)) * other;
        let by_second = (c(k1) - moment) * first;
        [by_own, by_rate, by_second]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(x: &Curvature) -> f64 {
        let Curvature { own: k, rate: k1, second: k2, rest, stiffness } = x;
        let c = |v: &Vector| stiffness * v;
        let m = c(&(k - rest));
        -k2.dot(&c(k2)) / 180.0 + c(k1).dot(&k.cross(k2)) / 45.0 + m.dot(&k1.cross(k2)) / 60.0
            - m.dot(&k.cross(&k.cross(k2))) / 180.0
            + m.dot(&k1.cross(&k.cross(k1))) / 360.0
            - m.dot(&k.cross(&k.cross(&k.cross(k1)))) / 720.0
            - LAW * k.norm().powi(4) * m.dot(k)
    }

    fn station(x: &Curvature) -> f64 {
        let Curvature { own: k, rate: k1, second: k2, rest, stiffness } = x;
        let c = |v: &Vector| stiffness * v;
        let m = c(&(k - rest));
        (c(k1).dot(k2) - m.dot(&k.cross(k2))) * 23.0 / 5760.0
            - (c(k1).dot(&k.cross(k1)) - m.dot(&k.cross(&k.cross(k1)))) * 25.0 / 5760.0
    }

    /// Central differences of polynomials: only round-off is between them.
    #[test]
    fn derivatives_are_those_of_the_formulas() {
        let at = || Curvature {
            own: Vector::new(1.3, -0.7, 0.4),
            rate: Vector::new(-0.2, 2.1, 0.9),
            second: Vector::new(0.8, 0.3, -1.7),
            rest: Vector::new(0.5, 0.1, -0.2),
            stiffness: Matrix::new(2.0, 0.2, -0.1, 0.2, 0.3, 0.15, -0.1, 0.15, 0.7),
        };
        type Value = fn(&Curvature) -> f64;
        for (value, derivatives) in [(cells as Value, at().of_cells()), (station, at().at_station())] {
            for (which, derivative) in derivatives.iter().enumerate() {
                for axis in 0..3 {
                    let moved = |by: f64| {
                        let mut x = at();
                        [&mut x.own, &mut x.rate, &mut x.second][which][axis] += by;
                        value(&x)
                    };
                    let step = 1e-5;
                    let difference = (moved(step) - moved(-step)) / (2.0 * step);
                    assert!(
                        (difference - derivative[axis]).abs() < 1e-9,
                        "{which} {axis}: {difference} {derivative:?}"
                    );
                }
            }
        }
    }
}
