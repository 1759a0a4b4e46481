//! Factorisation and solution against a dense solver.

use super::harnesses::{Builder, cable, fork, ring, whole};
use crate::cost::Traffic;
use crate::harness::{Algorithm, Stop, Variable};
use crate::memory::Memory;
use crate::plan::Plan;
use crate::{Real, Stage, reference};
use nalgebra::{DMatrix, DVector};

const STOP: Stop = Stop {
    force_scale: 1.0,
    moment_scale: 1.0,
    length_scale: 1.0,
    tolerance: 1e-9,
    max_iterations: 50,
    algorithm: Algorithm::Newton,
};

fn prepare(builder: &Builder, leaf: usize) -> (Plan, Memory) {
    let plan = Plan::new(builder.harness.topology(), leaf);
    let mut memory = Memory::new(&plan, 1);
    memory.set_harness(&plan, 0, &builder.harness).expect("its own links");
    memory.set_shape(&plan, 0, &builder.shape);
    memory.begin(0, &STOP, Real::F64, false);
    memory.control[0].phase = 0;
    (plan, memory)
}

fn harnesses() -> Vec<Builder> {
    let mut all = vec![cable(1, 40), fork(2, 12, false), fork(3, 12, true), ring(4, 9), ring(5, 1)];
    for (k, builder) in all.iter_mut().enumerate() {
        builder.hold(Variable::Point(0));
        builder.hold(Variable::Frame(0));
        // Some of them far from a stable state.
        builder.shake(if k % 2 == 0 { 0.05 } else { 0.6 });
    }
    all
}

#[test]
fn solutions_are_those_of_a_dense_solve_for_any_leaf() {
    for (h, builder) in harnesses().iter().enumerate() {
        for leaf in [1, 6, usize::MAX] {
            let (plan, mut memory) = prepare(builder, leaf);
            let (mut dense, mut rhs) = (DMatrix::zeros(0, 0), DVector::zeros(0));
            for dispatch in plan.cycle().iter().take_while(|d| d.stage != Stage::SumStep) {
                if dispatch.stage == Stage::Factorise && dense.is_empty() {
                    dense = whole(&plan, &memory);
                    rhs = DVector::from_column_slice(&memory.vectors[..3 * plan.len()]);
                }
                reference::run(&mut memory, dispatch);
                if dispatch.stage == Stage::CheckInertia {
                    let negative = dense.clone().symmetric_eigenvalues().iter().filter(|x| **x < 0.0).count();
                    assert_eq!(memory.control[0].negative as usize, negative, "harness {h}, leaf {leaf}");
                    memory.control[0].phase = 2;
                }
            }
            let solution = DVector::from_column_slice(&memory.vectors[..3 * plan.len()]);
            let left = (&dense * &solution - &rhs).amax();
            assert!(left < 1e-9 * (dense.amax() * solution.amax()), "harness {h}, leaf {leaf}: {left}");
        }
    }
}

#[test]
fn small_leaves_make_few_levels() {
    let levels = |n: usize, leaf: usize| Plan::new(cable(1, n).harness.topology(), leaf).elimination.levels.len();
    assert_eq!([16, 128, 1024].map(|n| levels(n, 8)), [4, 7, 10]);
    assert_eq!([16, 128, 1024].map(|n| levels(n, usize::MAX)), [1, 1, 1]);
    let fork = Plan::new(fork(1, 60, false).harness.topology(), usize::MAX);
    assert_eq!(fork.elimination.levels.len(), 2);
}

#[test]
fn a_cycle_moves_what_is_written_down() {
    let traffic = |builder: Builder, leaf| Plan::new(builder.harness.topology(), leaf).traffic();
    let of = |dispatches, numbers, walk| Traffic { dispatches, numbers, walk };
    assert_eq!(
        [
            traffic(cable(1, 1000), 8),
            traffic(cable(1, 10_000), 8),
            traffic(fork(1, 60, false), usize::MAX),
            traffic(fork(1, 60, true), usize::MAX),
        ],
        [of(84, 2_210_282, 1455), of(105, 21_826_075, 1934), of(42, 224_165, 2138), of(42, 225_289, 3595)]
    );
}
