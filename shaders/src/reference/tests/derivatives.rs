//! First and second derivatives of every law, after assembly, against finite differences.

use super::harnesses::{Builder, cable, fork, ring, whole};
use crate::harness::{Algorithm, Hold, Shape, Stop, Variable};
use crate::layout::Phase;
use crate::memory::Memory;
use crate::plan::Plan;
use crate::{Real, Stage, reference};
use nalgebra::{DMatrix, DVector, Quaternion, Unit, UnitQuaternion, Vector3};

const STOP: Stop = Stop {
    force_scale: 1.0,
    moment_scale: 1.0,
    length_scale: 1.0,
    tolerance: 1e-9,
    max_iterations: 50,
    algorithm: Algorithm::Newton,
};

fn harnesses() -> Vec<Builder> {
    let mut all = vec![cable(1, 5), fork(2, 3, false), fork(3, 3, true), ring(4, 3), ring(5, 1)];
    all.iter_mut().for_each(|builder| builder.shake(0.4));
    all
}

fn prepare(builder: &Builder, leaf: usize) -> (Plan, Memory) {
    let plan = Plan::new(builder.harness.topology(), leaf);
    let mut memory = Memory::new(&plan, 1);
    memory.set_harness(&plan, 0, &builder.harness).expect("its own links");
    memory.set_shape(&plan, 0, &builder.shape);
    (plan, memory)
}

/// Energy, J, and gradient at a state, in elimination order.
fn measure(plan: &Plan, memory: &mut Memory, shape: &Shape) -> (f64, DVector<f64>) {
    memory.set_shape(plan, 0, shape);
    memory.begin(0, &STOP, Real::F64, false);
    memory.control[0].phase = Phase::Search as u32;
    for dispatch in plan.cycle().iter().take_while(|d| d.stage != Stage::RecordTrial) {
        reference::run(memory, dispatch);
    }
    let p = plan.offsets;
    let energy = (0..p.totals).map(|k| memory.vectors[(p.totals_vectors + 7 * k) as usize]).sum();
    let slot = (memory.control[0].current + 1) % 3;
    let first = (p.gradient_vectors + slot * 3 * p.variables) as usize;
    (energy, DVector::from_column_slice(&memory.vectors[first..first + 3 * p.variables as usize]))
}

/// The state with one number of a step in elimination order changed.
fn moved(plan: &Plan, shape: &Shape, k: usize, by: f64) -> Shape {
    let mut shape = shape.clone();
    match plan.variables[k / 3] {
        Variable::Point(i) => shape.points[i as usize][k % 3] += by,
        Variable::Frame(c) => {
            let mut theta = Vector3::zeros();
            theta[k % 3] = by;
            let q = Unit::new_normalize(Quaternion::from(shape.frames[c as usize]));
            shape.frames[c as usize] = (q * UnitQuaternion::from_scaled_axis(theta)).coords.into();
        }
    }
    shape
}

/// The assembled matrix, both triangles.
fn matrix(plan: &Plan, memory: &mut Memory, shape: &Shape) -> DMatrix<f64> {
    memory.set_shape(plan, 0, shape);
    memory.begin(0, &STOP, Real::F64, false);
    memory.control[0].phase = Phase::Linearise as u32;
    for dispatch in plan.cycle().iter().take_while(|d| d.stage != Stage::Factorise) {
        reference::run(memory, dispatch);
    }
    whole(plan, memory)
}

#[test]
fn gradients_are_the_derivatives_of_energies() {
    for (h, builder) in harnesses().iter().enumerate() {
        let (plan, mut memory) = prepare(builder, 4);
        let (_, gradient) = measure(&plan, &mut memory, &builder.shape);
        let step = 1e-6;
        for k in 0..3 * plan.len() {
            let [after, before] =
                [step, -step].map(|by| measure(&plan, &mut memory, &moved(&plan, &builder.shape, k, by)).0);
            let slope = (after - before) / (2.0 * step);
            assert!(
                (slope - gradient[k]).abs() < 1e-6 * gradient.amax(),
                "harness {h}, {:?} {}: {slope} and {}",
                plan.variables[k / 3],
                k % 3,
                gradient[k]
            );
        }
    }
}

#[test]
fn matrices_are_the_derivatives_of_gradients() {
    for (h, builder) in harnesses().iter().enumerate() {
        let (plan, mut memory) = prepare(builder, 4);
        let matrix = matrix(&plan, &mut memory, &builder.shape);
        let step = 1e-6;
        let n = 3 * plan.len();
        let mut slopes = DMatrix::zeros(n, n);
        for k in 0..n {
            let [after, before] =
                [step, -step].map(|by| measure(&plan, &mut memory, &moved(&plan, &builder.shape, k, by)).1);
            slopes.set_column(k, &((after - before) / (2.0 * step)));
        }
        // For rotations only the symmetric part of the moment's derivative is a second derivative of the energy.
        let slopes = (&slopes + slopes.transpose()) * 0.5;
        let (row, column) = (&matrix - &slopes).iamax_full();
        assert!(
            (&matrix - &slopes).amax() < 1e-6 * matrix.amax(),
            "harness {h}: {:?} {} and {:?} {}: {} and {}",
            plan.variables[row / 3],
            row % 3,
            plan.variables[column / 3],
            column % 3,
            matrix[(row, column)],
            slopes[(row, column)]
        );
    }
}

#[test]
fn the_first_right_hand_side_carries_the_prescribed_motion() {
    for builder in &mut harnesses() {
        let (plan, mut memory) = prepare(builder, 4);
        let free = matrix(&plan, &mut memory, &builder.shape);
        let (_, gradient) = measure(&plan, &mut memory, &builder.shape);
        // Held directions of two points and a frame, in oblique bases.
        let basis = |seed: u64| -> [[f64; 3]; 3] {
            let turn =
                UnitQuaternion::from_scaled_axis(super::harnesses::random(&mut fastrand::Rng::with_seed(seed), 2.0));
            (*turn.to_rotation_matrix().matrix()).into()
        };
        let frame =
            builder.harness.station_segments[0].ends.iter().find_map(|end| end.station).expect("a station").frame;
        let point = Variable::Point(builder.harness.points as u32 - 1);
        let mut motion = DVector::zeros(3 * plan.len());
        let mut held = vec![];
        let whole_point = Variable::Point(0);
        for (variable, count, basis) in
            [(point, 1, basis(7)), (Variable::Frame(frame), 2, basis(8)), (whole_point, 3, basis(9))]
        {
            let mut own = Vector3::zeros();
            for (k, column) in basis.iter().enumerate().take(count) {
                own += Vector3::from(*column) * (0.01 + 0.02 * k as f64);
                held.push((plan.place(variable) as usize, Vector3::from(*column)));
            }
            motion.fixed_rows_mut::<3>(3 * plan.place(variable) as usize).copy_from(&own);
            let hold = Hold { variable, basis, count: count as u32, target: [0.0; 4], motion: own.into() };
            builder.harness.holds.push(hold);
        }
        let (plan, mut memory) = prepare(builder, 4);
        assert!(builder.harness.moves());
        memory.begin(0, &STOP, Real::F64, true);
        let of_solve = [Stage::AssembleMatrix, Stage::AssembleRightHandSide];
        for dispatch in plan.cycle().iter().take_while(|d| d.stage != Stage::SumStep) {
            if of_solve.contains(&dispatch.stage) || dispatch.stage.name().starts_with("linearise") {
                reference::run(&mut memory, dispatch);
            }
        }
        let held_matrix = whole(&plan, &memory);
        let rhs = DVector::from_column_slice(&memory.vectors[..3 * plan.len()]);
        let solution = held_matrix.lu().solve(&rhs).expect("a regular matrix");
        // The same step from the equation: H u + g has components in held directions only, and there u is the motion.
        for dispatch in plan.cycle().iter().skip_while(|d| d.stage != Stage::SumStep).take(1) {
            memory.vectors[..solution.len()].copy_from_slice(solution.as_slice());
            memory.control[0].phase = Phase::Solve as u32;
            let chunks = *dispatch;
            reference::run(&mut memory, &chunks);
        }
        let first = plan.offsets.descent_vectors as usize;
        let step = DVector::from_column_slice(&memory.vectors[first..first + solution.len()]);
        let mut left = &free * &step + &gradient;
        for (place, direction) in &held {
            let mut own = left.fixed_rows_mut::<3>(3 * place);
            let along = direction.dot(&own);
            own -= direction * along;
            let of_step: Vector3<f64> = step.fixed_rows::<3>(3 * place).into();
            let of_motion: Vector3<f64> = motion.fixed_rows::<3>(3 * place).into();
            assert!(
                (direction.dot(&of_step) - direction.dot(&of_motion)).abs() < 1e-12,
                "{direction} {of_step} {of_motion}"
            );
        }
        assert!(left.amax() < 1e-7 * gradient.amax().max((&free * &step).amax()), "{}", left.amax());
    }
}
