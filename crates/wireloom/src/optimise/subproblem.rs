//! The step of the sequential method: a quadratic program with linearised requirements in a trust region.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use nalgebra::{DMatrix, DVector};

/// A value with its gradient by the scaled variables.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    pub value: f64,
    pub gradient: DVector<f64>,
}

impl Linear {
    /// Its linear model at a distance.
    fn at(&self, step: &DVector<f64>) -> f64 {
        self.value + self.gradient.dot(step)
    }
}

/// A model of the merit function near a point,
///
/// `φ(d) = g·d + ½ dᵀ B d + Σ_j w_j max_k (h_jk + ∇h_jk·d) + μ Σ_i max(0, −c_i − ∇c_i·d)`,
///
/// with the smooth part of the objective, weighted worst values, and requirements `c ≥ 0` with the penalty μ.
pub(super) struct Model {
    /// Smooth part of the objective.
    pub smooth: Linear,
    /// Worst values, with their weights: the largest of each list counts.
    pub worst: Vec<(f64, Vec<Linear>)>,
    /// Requirements, kept where they are not negative.
    pub requirements: Vec<Linear>,
    /// Approximation of the Hessian of the Lagrangian; positive semidefinite.
    pub hessian: DMatrix<f64>,
    /// Penalty μ.
    pub penalty: f64,
}

/// A step, with the multipliers of the linear models that led to it.
pub(super) struct Proposal {
    /// Step of the scaled variables.
    pub step: DVector<f64>,
    /// Decrease of the merit function that the model promises.
    pub decrease: f64,
    /// Sum of the violations that it leaves.
    pub violation: f64,
    /// Of each worst value those of its list: they add up to its weight.
    pub of_worst: Vec<Vec<f64>>,
    /// Of the requirements.
    pub of_requirements: Vec<f64>,
}

impl Model {
    /// The value of the model at a step.
    fn at(&self, step: &DVector<f64>) -> f64 {
        let worst = self
            .worst
            .iter()
            .map(|(weight, list)| weight * list.iter().map(|linear| linear.at(step)).fold(f64::NEG_INFINITY, f64::max));
        let violation = self.violation(step);
        let curved = 0.5 * step.dot(&(&self.hessian * step));
        self.smooth.at(step) + worst.sum::<f64>() + self.penalty * violation + curved
    }

    /// Sum of the violations at a step.
    fn violation(&self, step: &DVector<f64>) -> f64 {
        self.requirements.iter().map(|linear| (-linear.at(step)).max(0.0)).sum()
    }

    /// The step between `lower` and `upper` (of each component) that minimises the model; `None` if the program could
    /// not be solved.
    ///
    /// Unknowns are the step d, a bound t of each worst value, and a violation s of each requirement:
    ///
    /// minimise `g·d + ½ dᵀ B d + Σ w_j t_j + μ Σ s_i` so that `h_jk + ∇h_jk·d ≤ t_j`, `c_i + ∇c_i·d + s_i ≥ 0`,
    /// `s ≥ 0`.
    pub fn minimise(&self, lower: &DVector<f64>, upper: &DVector<f64>) -> Option<Proposal> {
        let n = self.smooth.gradient.len();
        let unknowns = n + self.worst.len() + self.requirements.len();
        let mut cost = vec![0.0; unknowns];
        cost[..n].copy_from_slice(self.smooth.gradient.as_slice());
        for (j, (weight, _)) in self.worst.iter().enumerate() {
            cost[n + j] = *weight;
        }
        cost[n + self.worst.len()..].fill(self.penalty);
        // Rows of A z + slack = b with slack ≥ 0.
        let (mut rows, mut bounds): (Vec<Vec<(usize, f64)>>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut row = |entries: Vec<(usize, f64)>, bound: f64| {
            rows.push(entries);
            bounds.push(bound);
        };
        for (j, (_, list)) in self.worst.iter().enumerate() {
            for linear in list {
                let mut entries: Vec<(usize, f64)> = linear.gradient.iter().copied().enumerate().collect();
                entries.push((n + j, -1.0));
                row(entries, -linear.value);
            }
        }
        let first = n + self.worst.len();
        for (i, linear) in self.requirements.iter().enumerate() {
            let mut entries: Vec<(usize, f64)> = linear.gradient.iter().map(|x| -x).enumerate().collect();
            entries.push((first + i, -1.0));
            row(entries, linear.value);
        }
        for i in 0..self.requirements.len() {
            row(vec![(first + i, -1.0)], 0.0);
        }
        for k in 0..n {
            row(vec![(k, 1.0)], upper[k]);
            row(vec![(k, -1.0)], -lower[k]);
        }
        let solution = solve(&self.hessian, &cost, &rows, &bounds)?;
        let step = DVector::from_fn(n, |k, _| solution.0[k].clamp(lower[k], upper[k]));
        let mut multipliers = solution.1.into_iter();
        let of_worst = self.worst.iter().map(|(_, list)| multipliers.by_ref().take(list.len()).collect()).collect();
        let of_requirements = multipliers.take(self.requirements.len()).collect();
        let decrease = self.at(&DVector::zeros(n)) - self.at(&step);
        let violation = self.violation(&step);
        Some(Proposal { step, decrease, violation, of_worst, of_requirements })
    }
}

/// Solution and multipliers of the quadratic program `½ xᵀ B x + cost·x` with `rows · x ≤ bounds`; B is that of the
/// first unknowns.
fn solve(
    hessian: &DMatrix<f64>,
    cost: &[f64],
    rows: &[Vec<(usize, f64)>],
    bounds: &[f64],
) -> Option<(Vec<f64>, Vec<f64>)> {
    let entries = rows.iter().enumerate().flat_map(|(i, row)| row.iter().map(move |(k, x)| (i, *k, *x)));
    let matrix = compressed(rows.len(), cost.len(), entries);
    let n = hessian.nrows();
    // Of a symmetric matrix the solver takes the upper triangle.
    let upper = (0..n).flat_map(|k| (0..=k).map(move |i| (i, k, hessian[(i, k)])));
    let hessian = compressed(cost.len(), cost.len(), upper);
    let settings = DefaultSettingsBuilder::default().verbose(false).build().ok()?;
    let cones = [NonnegativeConeT(rows.len())];
    let mut solver = DefaultSolver::new(&hessian, cost, &matrix, bounds, &cones, settings).ok()?;
    solver.solve();
    let solved = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    let solution = solver.solution;
    (solved && solution.x.iter().all(|x| x.is_finite())).then_some((solution.x, solution.z))
}

/// A matrix in compressed columns.
fn compressed(rows: usize, columns: usize, entries: impl Iterator<Item = (usize, usize, f64)>) -> CscMatrix<f64> {
    let mut by_column = vec![Vec::new(); columns];
    for (i, k, x) in entries {
        by_column[k].push((i, x));
    }
    let mut starts = vec![0];
    let (mut places, mut values) = (Vec::new(), Vec::new());
    for column in by_column {
        for (i, x) in column {
            places.push(i);
            values.push(x);
        }
        starts.push(places.len());
    }
    CscMatrix::new(rows, columns, starts, places, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(value: f64, gradient: &[f64]) -> Linear {
        Linear { value, gradient: DVector::from_column_slice(gradient) }
    }

    /// minimise 1.5 x + max(1 − x − y, 2 y − x) + ½ y² so that ½ + x + y ≥ 0, within ±1.
    #[test]
    fn the_step_satisfies_the_conditions_of_an_optimum() {
        let model = Model {
            smooth: linear(0.0, &[1.5, 0.0]),
            worst: vec![(1.0, vec![linear(1.0, &[-1.0, -1.0]), linear(0.0, &[-1.0, 2.0])])],
            requirements: vec![linear(0.5, &[1.0, 1.0])],
            hessian: DMatrix::from_diagonal(&DVector::from_column_slice(&[0.0, 1.0])),
            penalty: 10.0,
        };
        let bound = DVector::from_element(2, 1.0);
        let found = model.minimise(&-&bound, &bound).expect("it has a solution");
        // With multipliers a, b of the worst values and m of the requirement: 1.5 − (a + b) − m = 0, a + b = 1, so
        // m = ½ and x + y = −½. From y − a + 2 b − m = 0 follows y = 3 a − 1.5. With a = 1, y would be beyond the kink
        // at 1/3, so both worst values are active there, with a = 11/18.
        assert!((found.step[1] - 1.0 / 3.0).abs() < 1e-6, "{}", found.step);
        assert!((found.step[0] + 0.5 + 1.0 / 3.0).abs() < 1e-6, "{}", found.step);
        assert!((found.of_requirements[0] - 0.5).abs() < 1e-6, "{:?}", found.of_requirements);
        assert!((found.of_worst[0].iter().sum::<f64>() - 1.0).abs() < 1e-6, "{:?}", found.of_worst);
        assert!(found.decrease > 0.0);
    }
}
