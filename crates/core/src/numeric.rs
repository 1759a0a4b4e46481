//! Numeric derivatives for parts that give none: central differences along `x + δ` and `q ∘ exp(θ)`, of fourth order
//! for first derivatives and those of a gradient, of second order for second derivatives of an energy.
//!
//! [`Numeric`] makes a potential or a joint of an energy alone:
//!
//! ```
//! use wireloom_core::constraint::{ConstraintView, Potential};
//! use wireloom_core::numeric::{ConstraintEnergy, Numeric};
//! use wireloom_core::{Pose, Vector};
//!
//! /// A spring of stiffness 100 N/m from a station to its target.
//! struct Spring;
//!
//! impl ConstraintEnergy for Spring {
//!     fn energy(&self, at: &ConstraintView<'_>) -> f64 {
//!         50.0 * (at.stations[0].position - at.targets[0].position).norm_squared()
//!     }
//! }
//!
//! let (target, mut station) = (Pose::identity(), Pose::identity());
//! station.position.x = 0.02;
//! let (stations, targets) = (&[station][..], &[target][..]);
//! let (span, span_lengths, memory, tensions) = (&[], &[], &[], &[]);
//! let at = ConstraintView { stations, targets, span, span_lengths, progress: 1.0, memory, tensions };
//! let mut slopes = [Vector::zeros(); 2];
//! Numeric(Spring).gradient(&at, &mut slopes, &mut []);
//! assert!((slopes[0] - Vector::new(2.0, 0.0, 0.0)).norm() < 1e-9);
//! ```

use crate::constraint::{ConstraintView, Potential};
use crate::joint::{JointModel, JointShape, Mounting};
use crate::{Matrix, Pose, Rotation, Vector};

/// What is said of a part whose derivatives are numeric.
pub const NOTE: &str = "its derivatives are taken numerically";

/// Energy of a constraint, of which the gradient may be known; otherwise as a [`Potential`].
pub trait ConstraintEnergy: Send + Sync {
    /// Energy, J.
    fn energy(&self, at: &ConstraintView<'_>) -> f64;
    /// First derivatives, as [`Potential::gradient`] gives them, and the energy, J; `None`: they are not known.
    fn gradient(&self, _at: &ConstraintView<'_>, _stations: &mut [Vector], _span: &mut [Vector]) -> Option<f64> {
        None
    }
}

/// Energy of a joint, of which the gradient may be known; otherwise as a [`JointModel`].
pub trait JointEnergy: Send + Sync {
    /// Connection of the arms, but [`Mounting::Pose`], which has no energy.
    fn mounting(&self) -> Mounting;
    /// Energy, J.
    fn energy(&self, shape: &JointShape<'_>) -> f64;
    /// Writes ∂E/∂θ_a (N m, body frame a), and returns the energy, J; `None`: they are not known.
    fn gradient(&self, _shape: &JointShape<'_>, _gradient: &mut [Vector]) -> Option<f64> {
        None
    }
    /// Initial memory; see [`JointModel::memory`].
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Updates the memory; see [`JointModel::commit`].
    fn commit(&self, _shape: &JointShape<'_>, _memory: &mut [f64], _dissipated: &mut [f64]) {}
    /// Message of a fatal fault; see [`JointModel::fault`].
    fn fault(&self) -> Option<String> {
        None
    }
    /// Remarks for the user; see [`JointModel::notes`].
    fn notes(&self) -> Vec<String> {
        vec![NOTE.to_owned()]
    }
}

/// A part with all derivatives, made of an energy; those that it does not give are differences. Its calls allocate.
pub struct Numeric<T>(pub T);

impl<T: ConstraintEnergy> Potential for Numeric<T> {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        self.0.energy(at)
    }

    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], span: &mut [Vector]) -> f64 {
        self.0.gradient(at, stations, span).unwrap_or_else(|| {
            gradient(at, &|at| self.0.energy(at), stations, span);
            self.0.energy(at)
        })
    }

    fn hessian(&self, at: &ConstraintView<'_>, stations: &mut [Matrix], span: &mut [Matrix]) {
        let mut of_stations = vec![Vector::zeros(); 2 * at.stations.len()];
        let mut of_span = vec![Vector::zeros(); at.span.len()];
        if self.0.gradient(at, &mut of_stations, &mut of_span).is_none() {
            hessian_of_energy(at, &|at| self.0.energy(at), stations, span);
            return;
        }
        let slopes = |at: &ConstraintView<'_>, stations: &mut [Vector], span: &mut [Vector]| {
            self.0.gradient(at, stations, span);
        };
        hessian(at, &slopes, stations, span);
    }
}

impl<T: JointEnergy> JointModel for Numeric<T> {
    fn mounting(&self) -> Mounting {
        self.0.mounting()
    }

    fn energy(&self, shape: &JointShape<'_>) -> f64 {
        self.0.energy(shape)
    }

    fn add_gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> f64 {
        let mut own = vec![Vector::zeros(); shape.frames.len()];
        let energy = self.0.gradient(shape, &mut own).unwrap_or_else(|| {
            gradient_of_frames(shape, &|shape| self.0.energy(shape), &mut own);
            self.0.energy(shape)
        });
        gradient.iter_mut().zip(own).for_each(|(to, own)| *to += own);
        energy
    }

    fn add_hessian(&self, shape: &JointShape<'_>, hessian: &mut [Matrix]) {
        if self.0.gradient(shape, &mut vec![Vector::zeros(); shape.frames.len()]).is_none() {
            add_hessian_of_energy_of_frames(shape, &|shape| self.0.energy(shape), hessian);
            return;
        }
        let slopes = |shape: &JointShape<'_>, to: &mut [Vector]| {
            self.0.gradient(shape, to);
        };
        add_hessian_of_frames(shape, &slopes, hessian);
    }

    fn memory(&self) -> Vec<f64> {
        self.0.memory()
    }

    fn commit(&self, shape: &JointShape<'_>, memory: &mut [f64], dissipated: &mut [f64]) {
        self.0.commit(shape, memory, dissipated);
    }

    fn fault(&self) -> Option<String> {
        self.0.fault()
    }

    fn notes(&self) -> Vec<String> {
        self.0.notes()
    }
}

/// Step, m and rad. A longer step suffers from the higher derivatives of shapes that bend within millimetres, a shorter
/// one from round-off.
const STEP: f64 = 1e-4;

/// Stencil `(8 (f(h) − f(−h)) − (f(2h) − f(−2h))) / 12 h`: offsets and weights.
const STENCIL: [(f64, f64); 4] = [(1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)];

/// Signs of the stencil `(f(h, h) − f(h, −h) − f(−h, h) + f(−h, −h)) / 4 h²`.
const CROSS: [(f64, f64); 4] = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];

/// Sum of the displacements of one vector among entries: index of a vector, axis and length.
fn displacement(entries: &[(usize, usize, f64)], vector: usize) -> Vector {
    let mut by = Vector::zeros();
    entries.iter().filter(|(own, ..)| *own == vector).for_each(|&(_, axis, h)| by[axis] += h);
    by
}

/// What a constraint sees, displaced: `x` and θ of each station, then `x` of each node of the span.
struct Displaced<'s, 'a> {
    at: &'s ConstraintView<'a>,
    stations: Vec<Pose>,
    span: Vec<Vector>,
}

impl<'s, 'a> Displaced<'s, 'a> {
    fn new(at: &'s ConstraintView<'a>) -> Self {
        Self { at, stations: at.stations.to_vec(), span: at.span.to_vec() }
    }

    /// Calls with these entries displaced.
    fn call<R>(&mut self, entries: &[(usize, usize, f64)], call: impl FnOnce(&ConstraintView<'_>) -> R) -> R {
        let of_stations = 2 * self.stations.len();
        for &(vector, ..) in entries {
            let by = displacement(entries, vector);
            if vector >= of_stations {
                self.span[vector - of_stations] = self.at.span[vector - of_stations] + by;
            } else if vector.is_multiple_of(2) {
                self.stations[vector / 2].position = self.at.stations[vector / 2].position + by;
            } else {
                let turn = Rotation::from_scaled_axis(by);
                self.stations[vector / 2].orientation = self.at.stations[vector / 2].orientation * turn;
            }
        }
        let result = call(&ConstraintView { stations: &self.stations, span: &self.span, ..*self.at });
        self.stations.copy_from_slice(self.at.stations);
        self.span.copy_from_slice(self.at.span);
        result
    }
}

/// The frames of a joint, turned.
struct Turned<'f> {
    from: &'f JointShape<'f>,
    frames: Vec<Rotation>,
}

impl<'f> Turned<'f> {
    fn new(from: &'f JointShape<'f>) -> Self {
        Self { from, frames: from.frames.to_vec() }
    }

    /// Calls with these entries of the frames' rotation vectors displaced.
    fn call<R>(&mut self, entries: &[(usize, usize, f64)], call: impl FnOnce(&JointShape<'_>) -> R) -> R {
        for &(frame, ..) in entries {
            self.frames[frame] = self.from.frames[frame] * Rotation::from_scaled_axis(displacement(entries, frame));
        }
        let result = call(&JointShape { frames: &self.frames, ..*self.from });
        self.frames.copy_from_slice(self.from.frames);
        result
    }
}

/// First derivatives of a function of displaced entries, with respect to those of one vector.
fn slope(vector: usize, mut energy: impl FnMut(&[(usize, usize, f64)]) -> f64) -> Vector {
    Vector::from_fn(|axis, _| {
        let terms = STENCIL.map(|(place, weight)| weight * energy(&[(vector, axis, place * STEP)]));
        terms.iter().sum::<f64>() / (12.0 * STEP)
    })
}

/// Second derivatives of a function of displaced entries: the block of two vectors. `rest`: its value undisplaced.
fn block(a: usize, b: usize, rest: f64, mut energy: impl FnMut(&[(usize, usize, f64)]) -> f64) -> Matrix {
    let mut block = Matrix::zeros();
    for i in 0..3 {
        for j in 0..if a == b { i + 1 } else { 3 } {
            block[(i, j)] = if (a, i) == (b, j) {
                let [forth, back] = [STEP, -STEP].map(|h| energy(&[(a, i, h)]));
                (forth - 2.0 * rest + back) / (STEP * STEP)
            } else {
                let terms = CROSS.map(|(s, t)| s * t * energy(&[(a, i, s * STEP), (b, j, t * STEP)]));
                terms.iter().sum::<f64>() / (4.0 * STEP * STEP)
            };
            if a == b {
                block[(j, i)] = block[(i, j)];
            }
        }
    }
    block
}

/// Gradient of an energy.
pub fn gradient(
    at: &ConstraintView<'_>,
    energy: &dyn Fn(&ConstraintView<'_>) -> f64,
    stations: &mut [Vector],
    span: &mut [Vector],
) {
    let mut displaced = Displaced::new(at);
    for (vector, to) in stations.iter_mut().chain(span).enumerate() {
        *to = slope(vector, |entries| displaced.call(entries, energy));
    }
}

/// Second derivatives of an energy.
pub fn hessian_of_energy(
    at: &ConstraintView<'_>,
    energy: &dyn Fn(&ConstraintView<'_>) -> f64,
    stations: &mut [Matrix],
    span: &mut [Matrix],
) {
    let (of_stations, rest) = (2 * at.stations.len(), energy(at));
    let mut displaced = Displaced::new(at);
    for a in 0..of_stations {
        for b in 0..=a {
            let found = block(a, b, rest, |entries| displaced.call(entries, energy));
            stations[a * of_stations + b] = found;
            stations[b * of_stations + a] = found.transpose();
        }
    }
    for (node, to) in span.iter_mut().enumerate() {
        let vector = of_stations + node;
        *to = block(vector, vector, rest, |entries| displaced.call(entries, energy));
    }
}

/// Computes first derivatives with respect to stations and nodes.
type Gradient<'g> = dyn Fn(&ConstraintView<'_>, &mut [Vector], &mut [Vector]) + 'g;

/// Symmetric part of the derivative of a gradient.
pub fn hessian(at: &ConstraintView<'_>, gradient: &Gradient<'_>, stations: &mut [Matrix], span: &mut [Matrix]) {
    let (m, k) = (at.stations.len(), at.span.len());
    let mut displaced = Displaced::new(at);
    let (mut x, mut s) = (vec![Vector::zeros(); 2 * m], vec![Vector::zeros(); k]);
    stations.fill(Matrix::zeros());
    span.fill(Matrix::zeros());
    for column in 0..2 * m + k {
        for axis in 0..3 {
            for (place, weight) in STENCIL {
                // A gradient may add to what is there.
                x.fill(Vector::zeros());
                s.fill(Vector::zeros());
                displaced.call(&[(column, axis, place * STEP)], |at| gradient(at, &mut x, &mut s));
                // Symmetrise: half to the block, half to its transpose.
                let half = 0.5 * weight / (12.0 * STEP);
                if column < 2 * m {
                    for (row, x) in x.iter().enumerate() {
                        for entry in 0..3 {
                            stations[row * 2 * m + column][(entry, axis)] += half * x[entry];
                            stations[column * 2 * m + row][(axis, entry)] += half * x[entry];
                        }
                    }
                } else {
                    let node = column - 2 * m;
                    for entry in 0..3 {
                        span[node][(entry, axis)] += half * s[node][entry];
                        span[node][(axis, entry)] += half * s[node][entry];
                    }
                }
            }
        }
    }
}

/// Gradient ∂E/∂θ of an energy of the frames of a joint.
pub fn gradient_of_frames(shape: &JointShape<'_>, energy: &dyn Fn(&JointShape<'_>) -> f64, gradient: &mut [Vector]) {
    let mut turned = Turned::new(shape);
    for (frame, to) in gradient.iter_mut().enumerate() {
        *to = slope(frame, |entries| turned.call(entries, energy));
    }
}

/// Adds the second derivatives of an energy of the frames of a joint to the blocks b ≤ a of a k × k table.
pub fn add_hessian_of_energy_of_frames(
    shape: &JointShape<'_>,
    energy: &dyn Fn(&JointShape<'_>) -> f64,
    hessian: &mut [Matrix],
) {
    let (k, rest) = (shape.frames.len(), energy(shape));
    let mut turned = Turned::new(shape);
    for a in 0..k {
        for b in 0..=a {
            hessian[a * k + b] += block(a, b, rest, |entries| turned.call(entries, energy));
        }
    }
}

/// Adds the symmetric part of the derivative of a gradient in the frames of a joint to the blocks b ≤ a of a k × k
/// table.
pub fn add_hessian_of_frames(
    shape: &JointShape<'_>,
    gradient: &dyn Fn(&JointShape<'_>, &mut [Vector]),
    hessian: &mut [Matrix],
) {
    let k = shape.frames.len();
    let (mut turned, mut slopes) = (Turned::new(shape), vec![Vector::zeros(); k]);
    for column in 0..k {
        for axis in 0..3 {
            for (place, weight) in STENCIL {
                slopes.fill(Vector::zeros());
                turned.call(&[(column, axis, place * STEP)], |shape| gradient(shape, &mut slopes));
                let half = 0.5 * weight / (12.0 * STEP);
                for (row, slope) in slopes.iter().enumerate() {
                    for entry in 0..3 {
                        if row >= column {
                            hessian[row * k + column][(entry, axis)] += half * slope[entry];
                        }
                        if row <= column {
                            hessian[column * k + row][(axis, entry)] += half * slope[entry];
                        }
                    }
                }
            }
        }
    }
}

/// Jacobian of residuals: the first `r` belong to the stations, the rest in equal numbers to each node.
pub fn jacobian(
    at: &ConstraintView<'_>,
    r: usize,
    residuals: &dyn Fn(&ConstraintView<'_>, &mut [f64]),
    all: usize,
    stations: &mut [Vector],
    span: &mut [Vector],
) {
    let (m, k) = (at.stations.len(), at.span.len());
    let of_node = (all - r).checked_div(k).unwrap_or(0);
    let mut displaced = Displaced::new(at);
    let mut c = vec![0.0; all];
    stations.fill(Vector::zeros());
    span.fill(Vector::zeros());
    for column in 0..2 * m + k {
        for axis in 0..3 {
            for (place, weight) in STENCIL {
                displaced.call(&[(column, axis, place * STEP)], |at| residuals(at, &mut c));
                let weight = weight / (12.0 * STEP);
                if column < 2 * m {
                    for (row, c) in c[..r].iter().enumerate() {
                        stations[row * 2 * m + column][axis] += weight * c;
                    }
                } else {
                    let first = (column - 2 * m) * of_node;
                    for (to, c) in span[first..first + of_node].iter_mut().zip(&c[r + first..]) {
                        to[axis] += weight * c;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRETCHING: f64 = 300.0;
    const BENDING: f64 = 0.4;

    /// Two stations that attract each other and their directions d3, and nodes that stay near the origin. `bool`:
    /// whether the gradient is known.
    struct Pair(bool);

    /// −∂(d3_a · d3_b)/∂θ_a.
    fn turning(a: &Rotation, b: &Rotation) -> Vector {
        -Vector::z().cross(&(a.inverse() * (b * Vector::z())))
    }

    impl ConstraintEnergy for Pair {
        fn energy(&self, at: &ConstraintView<'_>) -> f64 {
            let [a, b] = [&at.stations[0], &at.stations[1]];
            let near: f64 = at.span.iter().map(|x| 0.25 * x.norm_squared().powi(2)).sum();
            let cosine = (a.orientation * Vector::z()).dot(&(b.orientation * Vector::z()));
            0.5 * STRETCHING * (a.position - b.position).norm_squared() + BENDING * (1.0 - cosine) + near
        }

        fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], span: &mut [Vector]) -> Option<f64> {
            let [a, b] = [&at.stations[0], &at.stations[1]];
            let force = STRETCHING * (a.position - b.position);
            let moments = [turning(&a.orientation, &b.orientation), turning(&b.orientation, &a.orientation)];
            let slopes = [force, BENDING * moments[0], -force, BENDING * moments[1]];
            stations.iter_mut().zip(slopes).for_each(|(to, slope)| *to += slope);
            span.iter_mut().zip(at.span).for_each(|(to, x)| *to += x * x.norm_squared());
            self.0.then(|| ConstraintEnergy::energy(self, at))
        }
    }

    impl JointEnergy for Pair {
        fn mounting(&self) -> Mounting {
            Mounting::Point
        }

        fn energy(&self, JointShape { frames, .. }: &JointShape<'_>) -> f64 {
            BENDING * (1.0 - (frames[0] * Vector::z()).dot(&(frames[1] * Vector::z())))
        }

        fn gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> Option<f64> {
            let frames = shape.frames;
            let moments = [turning(&frames[0], &frames[1]), turning(&frames[1], &frames[0])];
            gradient.iter_mut().zip(moments).for_each(|(to, moment)| *to = BENDING * moment);
            self.0.then(|| JointEnergy::energy(self, shape))
        }
    }

    fn frames() -> [Rotation; 2] {
        [Vector::new(0.3, -0.8, 1.1), Vector::new(-0.5, 0.2, 2.0)].map(Rotation::from_scaled_axis)
    }

    /// Largest difference of two lists of blocks.
    fn apart<const N: usize>(left: &[nalgebra::SMatrix<f64, 3, N>], right: &[nalgebra::SMatrix<f64, 3, N>]) -> f64 {
        left.iter().zip(right).map(|(left, right)| (left - right).amax()).fold(0.0, f64::max)
    }

    #[test]
    fn derivatives_of_a_constraint_by_differences_are_the_exact_ones() {
        let [first, second] = frames();
        let position = Vector::new(0.1, 0.2, -0.3);
        let stations = [Pose { position, orientation: first }, Pose { position: 2.0 * position, orientation: second }];
        let span = [position, -1.5 * position];
        let at = ConstraintView {
            stations: &stations,
            targets: &stations,
            span: &span,
            span_lengths: &[0.1; 2],
            progress: 1.0,
            memory: &[],
            tensions: &[],
        };
        let derivatives = |pair: Pair| {
            let (mut slopes, mut along) = ([Vector::zeros(); 4], [Vector::zeros(); 2]);
            let (mut table, mut blocks) = ([Matrix::zeros(); 16], [Matrix::zeros(); 2]);
            let potential = Numeric(pair);
            potential.gradient(&at, &mut slopes, &mut along);
            potential.hessian(&at, &mut table, &mut blocks);
            (slopes, along, table, blocks)
        };
        let (exact, numeric) = (derivatives(Pair(true)), derivatives(Pair(false)));
        assert!(apart(&exact.0, &numeric.0) < 1e-9 * STRETCHING, "{:?}\n{:?}", exact.0, numeric.0);
        assert!(apart(&exact.1, &numeric.1) < 1e-9, "{:?}\n{:?}", exact.1, numeric.1);
        // Round-off of the energy, some 1e-15 J, over the square of the step; and the square of the step itself.
        assert!(apart(&exact.2, &numeric.2) < 1e-6 * STRETCHING, "{:?}\n{:?}", exact.2, numeric.2);
        assert!(apart(&exact.3, &numeric.3) < 1e-6, "{:?}\n{:?}", exact.3, numeric.3);
    }

    #[test]
    fn derivatives_of_a_joint_by_differences_are_the_exact_ones() {
        let derivatives = |pair: Pair| {
            let (mut slopes, mut table) = ([Vector::repeat(1.0); 2], [Matrix::repeat(2.0); 4]);
            let joint = Numeric(pair);
            let shape = JointShape { frames: &frames(), memory: &[] };
            joint.add_gradient(&shape, &mut slopes);
            joint.add_hessian(&shape, &mut table);
            (slopes, table)
        };
        let (exact, numeric) = (derivatives(Pair(true)), derivatives(Pair(false)));
        assert!(apart(&exact.0, &numeric.0) < 1e-9, "{:?}\n{:?}", exact.0, numeric.0);
        assert!(apart(&exact.1, &numeric.1) < 1e-7, "{:?}\n{:?}", exact.1, numeric.1);
        // The block above the diagonal is not asked for.
        assert_eq!(numeric.1[1], Matrix::repeat(2.0));
    }
}
