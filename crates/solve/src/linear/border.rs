//! Border of the factorised matrix: one column for the arc length of each sliding constraint.
//!
//! With `A` the matrix of points and frames, `B` one column for each running constraint and `D` the second derivatives
//! with respect to the arc lengths, `[A B; Bᵀ D] [u; σ] = −[g; g_s]` is solved by the Schur complement
//! `S = D − Bᵀ A⁻¹ B`, `S σ = −g_s − Bᵀ u₀`, `u = u₀ − A⁻¹ B σ`, with `u₀` the step at fixed
//! arc lengths. The inertia of the bordered matrix is that of A plus that of S (Haynsworth 1968).

use crate::linear::assembly::System;
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use wireloom_core::problem::Problem;
use wireloom_core::terms::sliding::SlideHessian;
use wireloom_core::{State, Tangent};

/// Eigenvalues of S are replaced by at least this fraction of the largest one: smaller ones are inaccurate.
const FLAT: f64 = 1e-10;

/// Accuracy of S relative to its largest term: S is a difference of second derivatives of the size of EA/ℓ.
const ROUND_OFF: f64 = 1e-12;

/// Workspace of the border.
#[derive(Default)]
pub struct Border {
    hessian: SlideHessian,
    /// −A⁻¹ B.
    columns: Vec<Tangent>,
    /// Eigenvalues of S of the last [`Self::inertia`].
    schur: Option<SymmetricEigen<f64, nalgebra::Dyn>>,
    /// Eigenvalues of S of the last [`Self::step`]; `None` if no constraint runs.
    factor: Option<SymmetricEigen<f64, nalgebra::Dyn>>,
}

/// Inertia of a symmetric matrix: signs of its eigenvalues.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inertia {
    /// Number of negative eigenvalues.
    pub negative: usize,
    /// Number of eigenvalues that are zero up to round-off.
    pub flat: usize,
}

impl Inertia {
    /// Whether all eigenvalues are positive.
    pub fn is_positive(self) -> bool {
        self.negative + self.flat == 0
    }

    /// Whether no eigenvalue is negative.
    pub fn is_not_negative(self) -> bool {
        self.negative == 0
    }
}

impl Border {
    /// Eigenvalues of S; computes the columns −A⁻¹ B. The matrix is factorised, `gradient` is the whole gradient at
    /// `state`.
    fn schur(
        &mut self,
        system: &mut System,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
    ) -> Option<SymmetricEigen<f64, nalgebra::Dyn>> {
        problem.slide_hessian(state, gradient, &mut self.hessian);
        let count = self.hessian.running.len();
        if count == 0 {
            return None;
        }
        self.columns.resize_with(count.max(self.columns.len()), || Tangent::zeros(problem.network));
        for (mixed, column) in self.hessian.mixed.iter().zip(&mut self.columns).take(count) {
            system.step(problem, state, mixed, None, column);
        }
        let entry = |i: usize, k: usize| self.hessian.own[i * count + k] + self.hessian.mixed[i].dot(&self.columns[k]);
        Some(SymmetricEigen::new(DMatrix::from_fn(count, count, |i, k| 0.5 * (entry(i, k) + entry(k, i)))))
    }

    /// Inertia of S; eigenvalues within the round-off of its terms count as flat.
    pub fn inertia(
        &mut self,
        system: &mut System,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
    ) -> Inertia {
        self.schur = self.schur(system, problem, state, gradient);
        let Some(schur) = &self.schur else { return Inertia::default() };
        let zero = ROUND_OFF * self.hessian.own.iter().fold(0.0_f64, |a, d| a.max(d.abs()));
        let count = |is: fn(f64, f64) -> bool| schur.eigenvalues.iter().filter(|e| is(**e, zero)).count();
        Inertia { negative: count(|e, zero| e < -zero), flat: count(|e, zero| e.abs() <= zero) }
    }

    /// Discards the eigenvalues of the last [`Self::inertia`].
    pub fn forget(&mut self) {
        self.schur = None;
    }

    /// Direction of the least eigenvalue of the last [`Self::inertia`], with points and frames. Returns whether that
    /// eigenvalue is negative.
    pub fn negative_direction(&self, step: &mut Tangent) -> bool {
        let Some(schur) = &self.schur else { return false };
        let least = schur.eigenvalues.imin();
        if schur.eigenvalues[least] >= 0.0 {
            return false;
        }
        step.clear();
        for (k, &slide) in self.hessian.running.iter().enumerate() {
            let sigma = schur.eigenvectors[(k, least)];
            step.add_scaled(sigma, &self.columns[k]);
            step.slides[slide] = sigma;
        }
        true
    }

    /// Newton step of all variables, as [`System::step`]. Negative eigenvalues of S are replaced by their magnitudes,
    /// so that the step leads downhill.
    pub fn step(
        &mut self,
        system: &mut System,
        problem: &mut Problem<'_>,
        state: &State,
        gradient: &Tangent,
        motion: Option<&Tangent>,
        step: &mut Tangent,
    ) {
        system.step(problem, state, gradient, motion, step);
        if problem.has_slides() {
            self.factor = self.schur(system, problem, state, gradient);
            self.complete(gradient, step);
        }
    }

    /// [`Self::step`] for another right-hand side, with the same matrix and the same running constraints.
    pub fn step_again(
        &self,
        system: &mut System,
        problem: &Problem<'_>,
        state: &State,
        gradient: &Tangent,
        motion: Option<&Tangent>,
        step: &mut Tangent,
    ) {
        system.step(problem, state, gradient, motion, step);
        if problem.has_slides() {
            self.complete(gradient, step);
        }
    }

    /// Completes `step`, which is u₀, to the step of all variables.
    fn complete(&self, gradient: &Tangent, step: &mut Tangent) {
        step.slides.fill(0.0);
        let Some(schur) = &self.factor else { return };
        let largest = schur.eigenvalues.amax();
        let count = self.hessian.running.len();
        let residual =
            DVector::from_fn(count, |k, _| -gradient.slides[self.hessian.running[k]] - self.hessian.mixed[k].dot(step));
        let mut along = schur.eigenvectors.tr_mul(&residual);
        for (a, e) in along.iter_mut().zip(&schur.eigenvalues) {
            *a /= e.abs().max(FLAT * largest);
        }
        let sigma = &schur.eigenvectors * along;
        for (k, &slide) in self.hessian.running.iter().enumerate() {
            step.add_scaled(sigma[k], &self.columns[k]);
            step.slides[slide] = sigma[k];
        }
    }
}
