//! Dead moments in the linear solve: an antisymmetric block on each loaded frame, by Woodbury's identity.
//!
//! A moment M about an axis fixed in space has no potential; its tangent is `S = −½ [Rᵀ M]ₓ` on the loaded frame
//! R ([`Problem::dead_moments`]). With `E` the columns of the identity for the loaded frames and `A` the factorised
//! symmetric matrix, the tangent of the residual is `K = A + E S Eᵀ`. With `C = A⁻¹ E` (three right-hand sides per
//! frame) and `u₀` the step of A, prescribed motion included, the step of K is `u = u₀ − C S v`, `v = Eᵀ u`
//! from `(I + Eᵀ C S) v = Eᵀ u₀` (Woodbury 1950). A need not be positive definite.

use crate::linear::border::Border;
use crate::linear::matrix::BlockMatrix;
use nalgebra::{DMatrix, DVector, Dyn, LU};
use wireloom_core::problem::Problem;
use wireloom_core::rotation::skew;
use wireloom_core::{Matrix, State, Tangent, Vector};

/// Workspace of the correction.
#[derive(Default)]
pub struct DeadMoments {
    /// Loaded frames, each with its block S, N m.
    loaded: Vec<(usize, Matrix)>,
    /// C, three columns for each loaded frame.
    columns: Vec<Tangent>,
    /// One column of E.
    unit: Option<Tangent>,
    /// I + Eᵀ C S.
    inner: Option<LU<f64, Dyn, Dyn>>,
}

impl DeadMoments {
    /// Evaluates the moments at `state`. `matrix` is factorised; if constraints slide, `border` was completed with it.
    pub fn prepare(
        &mut self,
        matrix: &BlockMatrix,
        border: &Border,
        problem: &Problem<'_>,
        state: &State,
        rhs: &mut [Vector],
    ) {
        self.loaded.clear();
        for (frame, moment) in problem.dead_moments() {
            let block = skew(&state.frames[*frame].inverse_transform_vector(moment)) * -0.5;
            match self.loaded.iter_mut().find(|(known, _)| known == frame) {
                Some((_, sum)) => *sum += block,
                None => self.loaded.push((*frame, block)),
            }
        }
        let count = 3 * self.loaded.len();
        self.columns.resize_with(count.max(self.columns.len()), || Tangent::zeros(problem.network));
        let unit = self.unit.get_or_insert_with(|| Tangent::zeros(problem.network));
        for (k, column) in self.columns.iter_mut().enumerate().take(count) {
            let frame = self.loaded[k / 3].0;
            // The right-hand side is minus the gradient.
            unit.frames[frame][k % 3] = -1.0;
            matrix.right_hand_side(problem, unit, None, rhs);
            matrix.solve(rhs);
            column.clear();
            matrix.step(problem, state, rhs, None, column);
            if problem.has_slides() {
                border.complete_again(unit, column);
            }
            unit.frames[frame][k % 3] = 0.0;
        }
        let mut inner = DMatrix::identity(count, count);
        for (i, (frame, _)) in self.loaded.iter().enumerate() {
            for (j, (_, block)) in self.loaded.iter().enumerate() {
                let c = Matrix::from_fn(|row, column| self.columns[3 * j + column].frames[*frame][row]);
                let mut place = inner.fixed_view_mut::<3, 3>(3 * i, 3 * j);
                place += c * block;
            }
        }
        self.inner = Some(inner.lu());
    }

    /// Completes `step`, which is u₀, to u; NaN if K is singular.
    pub fn complete(&self, step: &mut Tangent) {
        let Some(inner) = &self.inner else { return };
        let mut v = DVector::from_fn(3 * self.loaded.len(), |k, _| step.frames[self.loaded[k / 3].0][k % 3]);
        if !inner.solve_mut(&mut v) {
            v.fill(f64::NAN);
        }
        for (i, (_, block)) in self.loaded.iter().enumerate() {
            let reactions = block * v.fixed_rows::<3>(3 * i);
            for (k, s) in reactions.iter().enumerate() {
                step.add_scaled(-s, &self.columns[3 * i + k]);
            }
        }
    }

    /// Whether K has a negative determinant, A having `negative` negative pivots. An odd number of real eigenvalues of
    /// K is negative then.
    pub fn turns_determinant(&self, negative: usize) -> bool {
        let sign = self.inner.as_ref().map_or(1.0, LU::determinant);
        (negative % 2 == 1) == (sign > 0.0)
    }
}
