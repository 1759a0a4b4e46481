//! Perturbed states, assembled matrices, and their comparison with differences of the gradient.

use nalgebra::{DMatrix, DVector};
use wireloom_core::constraint::Limits;
use wireloom_core::network::{ConstraintPlan, NodeRange, Place};
use wireloom_core::problem::Hessian;
use wireloom_core::variable::Variable;
use wireloom_core::{Constraint, Problem, Registry, State, Tangent, Vector};
use wireloom_solve::linear::assembly::Assembly;
use wireloom_solve::linear::matrix::BlockMatrix;
use wireloom_solve::linear::symbolic::Structure;
use wireloom_testkit::conformance::networks::Sample;
use wireloom_testkit::conformance::numeric::{
    assert_matrix_near, random_rotation, random_turn, random_vector, symmetric,
};

pub(crate) fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    registry
}

/// State with random displacements, so that no entry vanishes by symmetry.
pub(crate) fn perturbed(sample: &Sample) -> State {
    let mut rng = fastrand::Rng::with_seed(5);
    let mut state = sample.state.clone();
    let common = random_rotation(&mut rng);
    for x in &mut state.points {
        *x = common * (*x + random_vector(&mut rng, 1e-3));
    }
    for q in &mut state.frames {
        *q = common * *q * random_turn(&mut rng, 0.2);
    }
    sample.network.follow_ties(&mut state);
    state
}

/// Dense copy of an assembled matrix, in elimination order.
pub(crate) fn dense(matrix: &BlockMatrix) -> DMatrix<f64> {
    let s = &matrix.structure;
    let mut dense = DMatrix::zeros(3 * s.len(), 3 * s.len());
    for p in 0..s.len() {
        dense.fixed_view_mut::<3, 3>(3 * p, 3 * p).copy_from(&matrix.diagonal[p]);
        for slot in s.pattern.starts[p] as usize..s.pattern.starts[p + 1] as usize {
            let row = 3 * s.pattern.rows[slot] as usize;
            dense.fixed_view_mut::<3, 3>(row, 3 * p).copy_from(&matrix.below[slot]);
            dense.fixed_view_mut::<3, 3>(3 * p, row).copy_from(&matrix.below[slot].transpose());
        }
    }
    dense
}

/// Matrix assembled at a state, without a shift, and its right-hand side.
pub(crate) fn assembled(sample: &Sample, state: &State) -> (BlockMatrix, Vec<Vector>) {
    let mut problem = sample.problem();
    let mut gradient = Tangent::zeros(&sample.network);
    problem.update_held(state);
    problem.gradient(state, &mut gradient);
    let mut hessian = Hessian::new(&sample.network);
    problem.hessian(state, None, &mut hessian);
    let mut matrix = BlockMatrix::new(Structure::new(&sample.network, &[]), &sample.network);
    Assembly::new(&sample.network, &matrix.structure).run(&mut matrix, &sample.network, state, &hessian);
    matrix.eliminate_prescribed(&problem);
    let mut rhs = vec![Vector::zeros(); matrix.structure.len()];
    matrix.right_hand_side(&problem, &gradient, None, &mut rhs);
    (matrix, rhs)
}

/// Compares the assembled matrix with symmetrised differences of the gradient, in the independent variables.
pub(crate) fn check_assembled(name: &str, sample: &Sample) {
    let network = &sample.network;
    let mut problem = sample.problem();
    let state = perturbed(sample);
    let mut gradient = Tangent::zeros(network);
    problem.gradient(&state, &mut gradient);
    let mut hessian = Hessian::new(network);
    problem.hessian(&state, None, &mut hessian);
    let mut matrix = BlockMatrix::new(Structure::new(network, problem.contact_pattern().1), network);
    Assembly::new(network, &matrix.structure).run(&mut matrix, network, &state, &hessian);
    let (got, variables) = (dense(&matrix), matrix.structure.variables.clone());
    let (h, mut trial) = (1e-5, state.clone());
    let columns: Vec<_> = (0..3 * variables.len())
        .map(|i| {
            let mut step = Tangent::zeros(network);
            match variables[i / 3] {
                Variable::Point(p) => step.points[p][i % 3] = 1.0,
                Variable::Frame(c) => step.frames[c][i % 3] = 1.0,
            }
            let mut at = |alpha: f64| {
                network.retract(&state, &step, alpha, &mut trial);
                problem.gradient(&trial, &mut gradient);
                let entries = variables.iter().flat_map(|v| match v {
                    Variable::Point(p) => gradient.points[*p].iter().copied(),
                    Variable::Frame(c) => gradient.frames[*c].iter().copied(),
                });
                DVector::from_vec(entries.collect())
            };
            (at(h) - at(-h)) / (2.0 * h)
        })
        .collect();
    let want = symmetric(&DMatrix::from_columns(&columns));
    // Positions in tenths of a millimetre: their stiffness is then no larger than that of turns.
    let scale = DVector::from_fn(got.nrows(), |i, _| match variables[i / 3] {
        Variable::Point(_) => 1e-4,
        Variable::Frame(_) => 1.0,
    });
    let scale = DMatrix::from_diagonal(&scale);
    let want = &scale * want * &scale;
    assert_matrix_near(name, &(&scale * got * &scale), &want, 1e-7 * want.amax());
}

/// Largest residual force on a free point.
pub(crate) fn largest_free_force(gradient: &Tangent, problem: &Problem<'_>) -> f64 {
    let mut free = gradient.clone();
    problem.free_part(&mut free);
    free.points.iter().map(|force| force.norm()).fold(0.0, f64::max)
}

pub(crate) fn plan(model: Box<dyn Constraint>, stations: Vec<Place>, span: Option<NodeRange>) -> ConstraintPlan {
    ConstraintPlan {
        name: String::new(),
        kind: String::new(),
        model,
        outputs: Vec::new(),
        stations,
        span,
        position: None,
        tangent: None,
        orientation: None,
        mount: None,
        slide: None,
        limits: Limits::default(),
        nearest: false,
        from_start: true,
    }
}
