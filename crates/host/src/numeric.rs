//! Numeric derivatives for plugins that give none: fourth-order central differences along `x + δ` and `q ∘ exp(θ)`.

use wireloom_core::constraint::ConstraintView;
use wireloom_core::{Matrix, Pose, Rotation, Vector};

/// Step, m and rad. A longer step suffers from the fifth derivative of shapes that bend within millimetres, a shorter
/// one from round-off.
const STEP: f64 = 1e-4;

/// Stencil `(8 (f(h) − f(−h)) − (f(2h) − f(−2h))) / 12 h`: offsets and weights.
const STENCIL: [(f64, f64); 4] = [(1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0)];

/// The situation with one variable perturbed: stations first, then span nodes.
struct Perturbed<'s, 'a> {
    at: &'s ConstraintView<'a>,
    stations: Vec<Pose>,
    span: Vec<Vector>,
}

impl<'s, 'a> Perturbed<'s, 'a> {
    fn new(at: &'s ConstraintView<'a>) -> Self {
        Self { at, stations: at.stations.to_vec(), span: at.span.to_vec() }
    }

    /// Calls with entry `axis` of a vector perturbed by `h`. Vectors: `x` and θ of each station, then `x` of each
    /// node.
    fn call<R>(&mut self, vector: usize, axis: usize, h: f64, call: impl FnOnce(&ConstraintView<'_>) -> R) -> R {
        let of_stations = 2 * self.stations.len();
        let mut step = Vector::zeros();
        step[axis] = h;
        if vector >= of_stations {
            self.span[vector - of_stations] += step;
        } else if vector.is_multiple_of(2) {
            self.stations[vector / 2].position += step;
        } else {
            self.stations[vector / 2].orientation *= Rotation::from_scaled_axis(step);
        }
        let result = call(&ConstraintView { stations: &self.stations, span: &self.span, ..*self.at });
        self.stations.copy_from_slice(self.at.stations);
        self.span.copy_from_slice(self.at.span);
        result
    }
}

/// Gradient of an energy.
pub fn gradient(
    at: &ConstraintView<'_>,
    energy: &dyn Fn(&ConstraintView<'_>) -> f64,
    stations: &mut [Vector],
    span: &mut [Vector],
) {
    let mut moved = Perturbed::new(at);
    for (vector, to) in stations.iter_mut().chain(span).enumerate() {
        *to = Vector::from_fn(|axis, _| {
            let terms = STENCIL.map(|(place, weight)| weight * moved.call(vector, axis, place * STEP, energy));
            terms.iter().sum::<f64>() / (12.0 * STEP)
        });
    }
}

/// Computes first derivatives with respect to stations and nodes.
type Gradient<'g> = dyn Fn(&ConstraintView<'_>, &mut [Vector], &mut [Vector]) + 'g;

/// Symmetric part of the derivative of a gradient.
pub fn hessian(at: &ConstraintView<'_>, gradient: &Gradient<'_>, stations: &mut [Matrix], span: &mut [Matrix]) {
    let (m, k) = (at.stations.len(), at.span.len());
    let mut moved = Perturbed::new(at);
    let (mut x, mut s) = (vec![Vector::zeros(); 2 * m], vec![Vector::zeros(); k]);
    stations.fill(Matrix::zeros());
    span.fill(Matrix::zeros());
    for column in 0..2 * m + k {
        for axis in 0..3 {
            for (place, weight) in STENCIL {
                moved.call(column, axis, place * STEP, |at| gradient(at, &mut x, &mut s));
                let weight = weight / (12.0 * STEP);
                if column < 2 * m {
                    // Symmetrise: half to the block, half to its transpose.
                    for (row, x) in x.iter().enumerate() {
                        for entry in 0..3 {
                            stations[row * 2 * m + column][(entry, axis)] += 0.5 * weight * x[entry];
                            stations[column * 2 * m + row][(axis, entry)] += 0.5 * weight * x[entry];
                        }
                    }
                } else {
                    let node = column - 2 * m;
                    for entry in 0..3 {
                        span[node][(entry, axis)] += 0.5 * weight * s[node][entry];
                        span[node][(axis, entry)] += 0.5 * weight * s[node][entry];
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
    let mut moved = Perturbed::new(at);
    let mut c = vec![0.0; all];
    stations.fill(Vector::zeros());
    span.fill(Vector::zeros());
    for column in 0..2 * m + k {
        for axis in 0..3 {
            for (place, weight) in STENCIL {
                moved.call(column, axis, place * STEP, |at| residuals(at, &mut c));
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
