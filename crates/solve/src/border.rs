//! Arc lengths of fixings that slide, as a border around the factorised matrix.
//!
//! With `A` the matrix of points and frames, `B` one column for each running fixing and `D` the second derivatives in the arc lengths
//! alone, `[A B; Bᵀ D] [u; σ] = −[g; g_s]` is solved by `S = D − Bᵀ A⁻¹ B`, `S σ = −g_s − Bᵀ u₀`, `u = u₀ − A⁻¹ B σ` with `u₀`
//! the step at fixed arc lengths. The inertia of the whole is that of A and S together (Haynsworth 1968).

use crate::matrix::BlockMatrix;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use wireloom_core::problem::Problem;
use wireloom_core::sliding::SlideHessian;
use wireloom_core::{State, Tangent, Vector};

/// Curvatures of S below this share of its largest are not trusted.
const FLAT: f64 = 1e-10;

/// Workspace of the border.
#[derive(Default)]
pub struct Border {
    hessian: SlideHessian,
    /// −A⁻¹ B.
    columns: Vec<Tangent>,
}

impl Border {
    /// S, the columns −A⁻¹ B being made on the way. `matrix` is factorised, `gradient` the whole gradient at `state`.
    fn schur(
        &mut self,
        matrix: &BlockMatrix,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
        rhs: &mut [Vector],
    ) -> Option<SymmetricEigen<f64, nalgebra::Dyn>> {
        problem.slide_hessian(state, gradient, &mut self.hessian);
        let count = self.hessian.running.len();
        if count == 0 {
            return None;
        }
        self.columns.resize_with(count.max(self.columns.len()), || Tangent::zeros(problem.network));
        for (mixed, column) in self.hessian.mixed.iter().zip(&mut self.columns).take(count) {
            matrix.right_hand_side(problem, mixed, None, rhs);
            matrix.solve(rhs);
            column.clear();
            matrix.step(problem, state, rhs, None, column);
        }
        let entry = |i: usize, k: usize| self.hessian.own[i * count + k] + self.hessian.mixed[i].dot(&self.columns[k]);
        Some(SymmetricEigen::new(DMatrix::from_fn(count, count, |i, k| 0.5 * (entry(i, k) + entry(k, i)))))
    }

    /// Number of directions in the arc lengths along which the energy falls, points and frames following.
    pub fn negative(
        &mut self,
        matrix: &BlockMatrix,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
        rhs: &mut [Vector],
    ) -> usize {
        let schur = self.schur(matrix, problem, state, gradient, rhs);
        schur.map_or(0, |schur| schur.eigenvalues.iter().filter(|e| **e < 0.0).count())
    }

    /// Turns `step`, which is u₀, into the step of everything. Where S is not positive its directions are turned over, so that the
    /// step leads downhill.
    pub fn complete(
        &mut self,
        matrix: &BlockMatrix,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
        rhs: &mut [Vector],
        step: &mut Tangent,
    ) {
        step.slides.fill(0.0);
        let Some(schur) = self.schur(matrix, problem, state, gradient, rhs) else { return };
        let largest = schur.eigenvalues.amax();
        let count = self.hessian.running.len();
        let residual =
            DVector::from_fn(count, |k, _| -gradient.slides[self.hessian.running[k]] - self.hessian.mixed[k].dot(step));
        let mut along = schur.eigenvectors.tr_mul(&residual);
        for (a, e) in along.iter_mut().zip(&schur.eigenvalues) {
            *a /= e.abs().max(FLAT * largest);
        }
        let sigma = schur.eigenvectors * along;
        for (k, &slide) in self.hessian.running.iter().enumerate() {
            step.add_scaled(sigma[k], &self.columns[k]);
            step.slides[slide] = sigma[k];
        }
    }
}
