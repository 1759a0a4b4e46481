//! Finite differences, random rotations and comparisons that the suites share.

use fastrand::Rng;
use nalgebra::{DMatrix, DVector, Quaternion, Unit};
use wireloom_core::{Rotation, Vector};

/// Derivative at 0 of a function of one variable: central, of fourth order in the step `h`.
pub fn derivative(h: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// Derivative at 0 of a vector function of one variable: central, of fourth order in the step `h`.
pub fn derivative_of_all(h: f64, mut f: impl FnMut(f64) -> DVector<f64>) -> DVector<f64> {
    ((f(h) - f(-h)) * 8.0 - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// Steps of [`agreeing`], m and rad: the first is for shapes that bend within centimetres, the last for those that bend
/// within a tenth of a millimetre. Shorter ones meet the rounding of the values.
const STEPS: [f64; 7] = [1e-3, 2.5e-4, 6e-5, 1.6e-5, 4e-6, 1e-6, 2.5e-7];

/// Derivatives by `differences` of a step, each by the step that comes nearest to `got`; shorter steps are tried as
/// long as one of them is further than `tolerance` of all from it. Differences of seven steps do not agree by chance
/// with a derivative that is wrong: their errors are far apart, and the tolerance is far below both.
pub fn agreeing(got: &DMatrix<f64>, tolerance: f64, mut differences: impl FnMut(f64) -> DMatrix<f64>) -> DMatrix<f64> {
    let mut best = differences(STEPS[0]);
    for h in &STEPS[1..] {
        let allowed = tolerance * (1.0 + best.amax());
        if got.iter().zip(&best).all(|(got, best)| (got - best).abs() <= allowed) {
            break;
        }
        for ((best, next), got) in best.iter_mut().zip(&differences(*h)).zip(got) {
            if (next - got).abs() < (*best - got).abs() || best.is_nan() {
                *best = *next;
            }
        }
    }
    best
}

/// A column of numbers as a matrix.
pub fn column(numbers: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_column_slice(numbers.len(), 1, numbers.as_slice())
}

/// All vectors, one after the other.
pub fn flat<'a>(vectors: impl IntoIterator<Item = &'a Vector>) -> DVector<f64> {
    DVector::from_vec(vectors.into_iter().flat_map(|v| [v.x, v.y, v.z]).collect())
}

/// `½(A + Aᵀ)`.
pub fn symmetric(a: &DMatrix<f64>) -> DMatrix<f64> {
    (a + a.transpose()) * 0.5
}

/// A number between −1 and 1.
pub fn uniform(rng: &mut Rng) -> f64 {
    2.0 * rng.f64() - 1.0
}

/// A vector in the cube of this half width.
pub fn random_vector(rng: &mut Rng, size: f64) -> Vector {
    Vector::from_fn(|_, _| size * uniform(rng))
}

/// A direction.
pub fn random_direction(rng: &mut Rng) -> Unit<Vector> {
    loop {
        let v = random_vector(rng, 1.0);
        if (0.1..1.0).contains(&v.norm()) {
            return Unit::new_normalize(v);
        }
    }
}

/// A turn by this angle (rad) about a random axis.
pub fn random_turn(rng: &mut Rng, angle: f64) -> Rotation {
    Rotation::from_axis_angle(&random_direction(rng), angle)
}

/// Any rotation.
pub fn random_rotation(rng: &mut Rng) -> Rotation {
    let angle = std::f64::consts::PI * rng.f64();
    random_turn(rng, angle)
}

/// `q ∘ exp(θ)`.
pub fn turned(q: &Rotation, theta: &Vector) -> Rotation {
    q * Rotation::from_scaled_axis(*theta)
}

/// Half a turn about d1: what happens to frames where a branch is run from its other end.
pub fn half_turn() -> Rotation {
    Unit::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0))
}

/// `−q`: the same rotation by the other of its two quaternions.
pub fn negated(q: &Rotation) -> Rotation {
    Unit::new_unchecked(-q.into_inner())
}

/// `diag(1, −1, −1) a`, the vector `a` in a frame turned by [`half_turn`].
pub fn half_turned(a: &Vector) -> Vector {
    Vector::new(a.x, -a.y, -a.z)
}

/// `diag(−1, 1, 1) κ`: the curvature of a branch run from its other end.
///
/// With `P` the half turn the relative rotation of neighbours becomes `P r̄ P`, whose imaginary part is `−P v`.
pub fn reversed_curvature(k: &Vector) -> Vector {
    Vector::new(-k.x, k.y, k.z)
}

/// Asserts that two numbers differ by no more than `tolerance`.
///
/// # Panics
/// If they do, or one is not finite.
#[track_caller]
pub fn assert_near(what: &str, got: f64, want: f64, tolerance: f64) {
    assert!((got - want).abs() <= tolerance, "{what}: {got:e} instead of {want:e} (±{tolerance:e})");
}

/// Asserts that two columns of numbers differ nowhere by more than `tolerance`.
///
/// # Panics
/// If they do, or one is not finite.
#[track_caller]
pub fn assert_all_near(what: &str, got: &DVector<f64>, want: &DVector<f64>, tolerance: f64) {
    assert_eq!(got.len(), want.len(), "{what}: lengths");
    for (i, (g, w)) in got.iter().zip(want).enumerate() {
        assert!((g - w).abs() <= tolerance, "{what}, entry {i}: {g:e} instead of {w:e} (±{tolerance:e})");
    }
}

/// Asserts that two matrices differ nowhere by more than `tolerance`.
///
/// # Panics
/// If they do, or one is not finite.
#[track_caller]
pub fn assert_matrix_near(what: &str, got: &DMatrix<f64>, want: &DMatrix<f64>, tolerance: f64) {
    assert_eq!(got.shape(), want.shape(), "{what}: shapes");
    for row in 0..got.nrows() {
        for column in 0..got.ncols() {
            let (g, w) = (got[(row, column)], want[(row, column)]);
            assert!(
                (g - w).abs() <= tolerance,
                "{what}, entry ({row}, {column}): {g:e} instead of {w:e} (±{tolerance:e})"
            );
        }
    }
}
