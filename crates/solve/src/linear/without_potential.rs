//! Loads without a potential in the linear solve.
//!
//! Their tangent is not symmetric. With `A` the factorised symmetric matrix of everything else, the tangent of the
//! residual is `K = A + P + B`: P of the loads at places ([`Problem::load_tangents`]), B of the forces per length
//! ([`Problem::segment_tangents`]). A need not be positive definite.
//!
//! P has few columns. It is `P = Σ F_i S_i E_iᵀ` with `E` the columns of the identity for the frames that the loads
//! turn with (or, for dead moments, act on) and `F` those for the variables that they act on. With `C = A⁻¹ F` (three
//! right-hand sides per block) and `u₀` the step of A, prescribed motion included, the step of A + P is
//! `u = u₀ − Σ C_i S_i v_i`, `v = Eᵀ u` from `v + Eᵀ Σ C_i S_i v_i = Eᵀ u₀` (Woodbury 1950).
//!
//! B has a column for every loaded frame. The step of K solves `u + (A + P)⁻¹ B u = u` of A + P by GMRES without
//! restart (Saad and Schultz 1986, GMRES: a generalized minimal residual algorithm for solving nonsymmetric linear
//! systems). `(A + P)⁻¹ B` is the response of the harness to changes of the load, a smooth operator: few iterations do.

use crate::linear::assembly::System;
use crate::linear::border::Border;
use nalgebra::{DMatrix, DVector, Dyn, LU};
use wireloom_core::problem::Problem;
use wireloom_core::terms::loads::{LoadTangent, SegmentTangent};
use wireloom_core::variable::Variable;
use wireloom_core::{Matrix, State, Tangent};

/// Largest number of GMRES iterations.
const ITERATIONS: usize = 60;
/// Residual of GMRES, relative to the right-hand side, at which it ends: the residual of Newton's method is exact
/// whatever is left.
const ACCURACY: f64 = 1e-10;

/// Workspace of the correction.
#[derive(Default)]
pub struct WithoutPotential {
    /// Blocks S of P.
    at_places: Vec<LoadTangent>,
    /// Blocks of B.
    along: Vec<SegmentTangent>,
    /// C, three columns for each block of P.
    columns: Vec<Tangent>,
    /// One column of F, or B times a step.
    forces: Option<Tangent>,
    /// I + Eᵀ C S.
    inner: Option<LU<f64, Dyn, Dyn>>,
    /// Basis of the Krylov space.
    basis: Vec<Tangent>,
}

impl WithoutPotential {
    /// Evaluates the loads at `state`. The matrix is factorised; if constraints slide, the border took a step with it.
    pub fn prepare(&mut self, system: &mut System, border: &Border, problem: &Problem<'_>, state: &State) {
        self.along = problem.segment_tangents(state);
        self.at_places.clear();
        for own in problem.load_tangents(state) {
            match self.at_places.iter_mut().find(|known| (known.row, known.frame) == (own.row, own.frame)) {
                Some(known) => known.block += own.block,
                None => self.at_places.push(own),
            }
        }
        let count = 3 * self.at_places.len();
        self.columns.resize_with(count.max(self.columns.len()), || Tangent::zeros(problem.network));
        let unit = self.forces.get_or_insert_with(|| Tangent::zeros(problem.network));
        unit.clear();
        for (k, column) in self.columns.iter_mut().enumerate().take(count) {
            let entry = |unit: &mut Tangent, value: f64| match self.at_places[k / 3].row {
                Variable::Point(i) => unit.points[i][k % 3] = value,
                Variable::Frame(c) => unit.frames[c][k % 3] = value,
            };
            // The right-hand side is minus the gradient.
            entry(unit, -1.0);
            border.step_again(system, problem, state, unit, None, column);
            entry(unit, 0.0);
        }
        let mut inner = DMatrix::identity(count, count);
        for (i, row) in self.at_places.iter().enumerate() {
            for (j, own) in self.at_places.iter().enumerate() {
                let c = Matrix::from_fn(|r, column| self.columns[3 * j + column].frames[row.frame][r]);
                let mut place = inner.fixed_view_mut::<3, 3>(3 * i, 3 * j);
                place += c * own.block;
            }
        }
        // An empty matrix has no factor.
        self.inner = (count > 0).then(|| inner.lu());
    }

    /// Completes `step`, which is u₀, to the step of K; NaN if A + P is singular. The matrix, the border and the state
    /// are those of [`Self::prepare`].
    pub fn complete(
        &mut self,
        system: &mut System,
        border: &Border,
        problem: &Problem<'_>,
        state: &State,
        step: &mut Tangent,
    ) {
        self.complete_at_places(step);
        if !self.along.is_empty() {
            self.complete_along(system, border, problem, state, step);
        }
    }

    /// The step of A + P from that of A.
    fn complete_at_places(&self, step: &mut Tangent) {
        let Some(inner) = &self.inner else { return };
        let mut v = DVector::from_fn(3 * self.at_places.len(), |k, _| step.frames[self.at_places[k / 3].frame][k % 3]);
        if !inner.solve_mut(&mut v) {
            v.fill(f64::NAN);
        }
        for (i, own) in self.at_places.iter().enumerate() {
            let reactions = own.block * v.fixed_rows::<3>(3 * i);
            for (k, s) in reactions.iter().enumerate() {
                step.add_scaled(-s, &self.columns[3 * i + k]);
            }
        }
    }

    /// The step of K from that of A + P, by GMRES: Arnoldi's method with modified Gram–Schmidt orthogonalisation, and
    /// Givens rotations.
    fn complete_along(
        &mut self,
        system: &mut System,
        border: &Border,
        problem: &Problem<'_>,
        state: &State,
        step: &mut Tangent,
    ) {
        let mut basis = std::mem::take(&mut self.basis);
        let mut apply = |v: &Tangent, image: &mut Tangent| {
            self.changed_forces(problem, state, v);
            let forces = self.forces.as_ref().expect("made by prepare");
            border.step_again(system, problem, state, forces, None, image);
            self.complete_at_places(image);
            // A Newton step has minus the forces on its right-hand side.
            negate(image);
            image.add_scaled(1.0, v);
        };
        let room = |basis: &mut Vec<Tangent>, k: usize| {
            if basis.len() <= k {
                basis.resize_with(k + 1, || Tangent::zeros(problem.network));
            }
        };
        // The first guess is the step of A + P itself.
        room(&mut basis, 0);
        apply(step, &mut basis[0]);
        negate(&mut basis[0]);
        basis[0].add_scaled(1.0, step);
        let allowed = ACCURACY * norm(step);
        let mut left = norm(&basis[0]);
        if left > allowed {
            scale(&mut basis[0], 1.0 / left);
        }
        // Columns of the triangular factor, rotations, and the rotated right-hand side.
        let (mut triangle, mut rotations, mut right) = (Vec::<Vec<f64>>::new(), Vec::<[f64; 2]>::new(), vec![left]);
        while left > allowed && triangle.len() < ITERATIONS && !problem.monitor.is_stopped() {
            let k = triangle.len();
            room(&mut basis, k + 1);
            let (known, next) = basis.split_at_mut(k + 1);
            let next = &mut next[0];
            apply(&known[k], next);
            let mut column = Vec::with_capacity(k + 2);
            for vector in known.iter() {
                let along = vector.dot(next);
                next.add_scaled(-along, vector);
                column.push(along);
            }
            let beyond = norm(next);
            for (row, [c, s]) in rotations.iter().enumerate() {
                let [a, b] = [column[row], column[row + 1]];
                column[row] = c * a + s * b;
                column[row + 1] = c * b - s * a;
            }
            let length = column[k].hypot(beyond);
            if length == 0.0 || !length.is_finite() {
                break;
            }
            let [c, s] = [column[k] / length, beyond / length];
            column[k] = length;
            rotations.push([c, s]);
            right.push(-s * right[k]);
            right[k] *= c;
            triangle.push(column);
            left = right[k + 1].abs();
            if beyond == 0.0 {
                break;
            }
            scale(next, 1.0 / beyond);
        }
        for k in (0..triangle.len()).rev() {
            let weight = right[k] / triangle[k][k];
            right[k] = weight;
            for row in 0..k {
                right[row] -= triangle[k][row] * weight;
            }
            step.add_scaled(weight, &basis[k]);
        }
        self.basis = basis;
    }

    /// B times a step, in the independent variables.
    fn changed_forces(&mut self, problem: &Problem<'_>, state: &State, step: &Tangent) {
        let forces = self.forces.as_mut().expect("made by prepare");
        forces.clear();
        for own in &self.along {
            for (point, block) in &own.blocks {
                forces.points[*point] += block * step.frames[own.frame];
            }
        }
        problem.network.pull_back(state, forces);
    }

    /// Whether K has a negative determinant, A having `negative` negative pivots; `None` if it is not known. An odd
    /// number of real eigenvalues of K is negative then.
    pub fn turns_determinant(&self, negative: usize) -> Option<bool> {
        if !self.along.is_empty() {
            return None;
        }
        let sign = self.inner.as_ref().map_or(1.0, LU::determinant);
        Some((negative % 2 == 1) == (sign > 0.0))
    }
}

fn norm(step: &Tangent) -> f64 {
    step.dot(step).sqrt()
}

fn scale(step: &mut Tangent, factor: f64) {
    step.points.iter_mut().chain(&mut step.frames).for_each(|v| *v *= factor);
    step.slides.iter_mut().for_each(|s| *s *= factor);
}

fn negate(step: &mut Tangent) {
    scale(step, -1.0);
}
