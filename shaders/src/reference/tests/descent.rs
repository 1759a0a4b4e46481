//! Complete minimisations with the CPU reference.

use super::harnesses::{Builder, cable, fork, ring};
use crate::harness::{Algorithm, Hold, Shape, Stop, Variable};
use crate::layout::{Control, Outcome, Phase};
use crate::memory::{Buffer, Memory, pack, unpack_shape};
use crate::plan::Plan;
use crate::{Real, reference};

const STOP: Stop = Stop {
    force_scale: 0.3,
    moment_scale: 0.3,
    length_scale: 1.0,
    tolerance: 1e-9,
    max_iterations: 200,
    algorithm: Algorithm::Newton,
};

/// Both free ends of the first and the last branch are held.
fn plugged(mut builder: Builder) -> Builder {
    let ends: Vec<_> = [builder.harness.station_segments.first(), builder.harness.station_segments.last()]
        .into_iter()
        .flatten()
        .flat_map(|s| s.ends)
        .filter(|end| end.station.is_some_and(|station| station.offset == [0.0; 3] && station.blend == 0.125))
        .collect();
    for end in ends {
        builder.hold(Variable::Point(end.point));
        builder.hold(Variable::Frame(end.station.expect("filtered").frame));
    }
    builder
}

fn descend(plan: &Plan, harnesses: &[(&Builder, &Shape)]) -> Memory {
    descend_by(Algorithm::Newton, plan, harnesses)
}

fn descend_by(algorithm: Algorithm, plan: &Plan, harnesses: &[(&Builder, &Shape)]) -> Memory {
    let mut memory = Memory::new(plan, harnesses.len());
    for (variant, (builder, shape)) in harnesses.iter().enumerate() {
        memory.set_harness(plan, variant, &builder.harness).expect("its own links");
        memory.set_shape(plan, variant, shape);
        memory.begin(variant, &Stop { algorithm, ..STOP }, Real::F64, builder.harness.moves());
    }
    reference::descend(&mut memory, plan, 2000);
    memory
}

fn converged(control: &Control<f64>) -> bool {
    control.outcome == Outcome::Converged as u32 && control.residual <= STOP.tolerance && control.negative == 0
}

/// Iterations, factorisations and evaluations of each harness, independent of the order of elimination.
const WORK: [[u32; 3]; 4] = [[6, 6, 17], [15, 31, 31], [8, 17, 20], [10, 23, 22]];

#[test]
fn harnesses_come_to_rest_and_any_leaf_finds_the_same() {
    for (h, builder) in [cable(1, 30), fork(2, 10, false), fork(3, 10, true), ring(4, 6)].into_iter().enumerate() {
        let builder = plugged(builder);
        let mut found: Vec<Shape> = vec![];
        let mut work = vec![];
        for leaf in [4, usize::MAX] {
            let plan = Plan::new(builder.harness.topology(), leaf);
            let memory = descend(&plan, &[(&builder, &builder.shape)]);
            assert!(converged(&memory.control[0]), "harness {h}, leaf {leaf}: {:?}", memory.control[0]);
            let control = &memory.control[0];
            work.push([control.iterations, control.factorisations, control.evaluations]);
            found.push(memory.shape(&plan, 0));
        }
        assert_eq!(work, [WORK[h]; 2], "harness {h}");
        let off = found[0].points.iter().flatten().zip(found[1].points.iter().flatten());
        let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-7, "harness {h}: {off} m apart");
    }
}

#[test]
fn variants_of_a_batch_are_what_they_are_alone() {
    let builders: Vec<Builder> = (0..5)
        .map(|k| {
            let mut builder = plugged(fork(2, 8, true));
            for s in &mut builder.harness.couplings {
                s.stiffness[0] *= 1.0 + 0.2 * f64::from(k);
            }
            builder
        })
        .collect();
    let plan = Plan::new(builders[0].harness.topology(), usize::MAX);
    let all: Vec<(&Builder, &Shape)> = builders.iter().map(|builder| (builder, &builder.shape)).collect();
    let batch = descend(&plan, &all);
    for (variant, one) in all.iter().enumerate() {
        let alone = descend(&plan, &[*one]);
        assert!(converged(&alone.control[0]), "{:?}", alone.control[0]);
        assert_eq!(batch.control[variant], alone.control[0], "variant {variant}");
        assert_eq!(batch.shape(&plan, variant), alone.shape(&plan, 0), "variant {variant}");
    }
    // The same, uploaded and read back as with a device.
    for real in [Real::F64, Real::F32] {
        let mut read = Memory::new(&plan, builders.len());
        let packed = builders
            .iter()
            .flat_map(|builder| pack(&plan, &builder.harness, &builder.shape, real).expect("the same links"));
        read.load(Buffer::Transfer, real, &packed.collect::<Vec<u8>>());
        read.control.iter_mut().for_each(|control| control.phase = Phase::Linearise as u32);
        reference::run(&mut read, &plan.unpack());
        for (variant, builder) in builders.iter().enumerate() {
            read.begin(variant, &STOP, Real::F64, builder.harness.moves());
        }
        reference::descend(&mut read, &plan, 2000);
        reference::run(&mut read, &plan.pack_shape());
        let bytes = read.bytes(Buffer::Transfer, real);
        let each = bytes.chunks_exact(plan.shape_length() as usize * real.bytes());
        for (variant, bytes) in (0..builders.len()).zip(each) {
            let own = unpack_shape(&plan, bytes, real);
            let batch = batch.shape(&plan, variant);
            let off = own.points.iter().flatten().zip(batch.points.iter().flatten());
            let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off <= if real == Real::F64 { 0.0 } else { 1e-6 }, "variant {variant}: {off}");
        }
    }
}

#[test]
fn a_moved_end_takes_the_harness_along() {
    let mut builder = plugged(cable(1, 60));
    let plan = Plan::new(builder.harness.topology(), 8);
    let memory = descend(&plan, &[(&builder, &builder.shape)]);
    builder.shape = memory.shape(&plan, 0);
    let mut work = vec![];
    for step in 0..3 {
        for hold in builder.harness.holds.iter_mut().filter(|hold| hold.variable == Variable::Point(60)) {
            hold.motion = [0.0, -0.005, 0.0];
            hold.target[1] -= 0.005;
        }
        let memory = descend(&plan, &[(&builder, &builder.shape)]);
        assert!(converged(&memory.control[0]), "step {step}: {:?}", memory.control[0]);
        builder.shape = memory.shape(&plan, 0);
        assert_eq!(builder.shape.points[60][1], builder.harness.holds[2].target[1]);
        work.push((memory.control[0].iterations, memory.control[0].evaluations));
    }
    assert_eq!(work, [(3, 5), (3, 6), (3, 6)]);
}

#[test]
fn the_gradient_method_finds_what_newton_finds() {
    let mut work = vec![];
    for (h, builder) in [cable(1, 30), fork(2, 10, false), fork(3, 10, true), ring(4, 6)].into_iter().enumerate() {
        let builder = plugged(builder);
        let plan = Plan::new(builder.harness.topology(), 8);
        let [newton, gradient] = [Algorithm::Newton, Algorithm::Gradient]
            .map(|algorithm| descend_by(algorithm, &plan, &[(&builder, &builder.shape)]));
        let control = &gradient.control[0];
        assert_eq!(control.outcome, Outcome::Converged as u32, "harness {h}: {control:?}");
        work.push([control.iterations, control.factorisations, control.evaluations]);
        let (newton, gradient) = (newton.shape(&plan, 0), gradient.shape(&plan, 0));
        let off = newton.points.iter().flatten().zip(gradient.points.iter().flatten());
        let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-6, "harness {h}: {off} m apart");
    }
    assert_eq!(work, [[22, 3, 69], [41, 22, 100], [22, 3, 68], [26, 17, 68]]);
}

#[test]
fn what_is_held_in_part_is_free_in_the_rest() {
    let mut builder = cable(1, 20);
    builder.shake(0.02);
    let plugged = &mut builder;
    plugged.hold(Variable::Point(0));
    plugged.hold(Variable::Frame(0));
    // The other end can move in a plane and rotate about its axis, and has not reached its target.
    let (point, frame) = (Variable::Point(20), Variable::Frame(plugged.harness.frames as u32 - 1));
    let normal = nalgebra::Vector3::new(0.6, 0.0, 0.8);
    let basis = [[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]];
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let rotated = nalgebra::UnitQuaternion::from_euler_angles(0.3, 1.2, 0.1);
    let rest = [0.0; 3];
    builder.harness.holds.extend([
        Hold { variable: point, basis, count: 1, target: [0.95, 0.3, 0.0, 0.0], motion: rest },
        Hold { variable: frame, basis: axes, count: 2, target: rotated.coords.into(), motion: rest },
    ]);
    let plan = Plan::new(builder.harness.topology(), 8);
    let memory = descend(&plan, &[(&builder, &builder.shape)]);
    assert!(converged(&memory.control[0]), "{:?}", memory.control[0]);
    let shape = memory.shape(&plan, 0);
    let gap = nalgebra::Vector3::from(shape.points[20]) - nalgebra::Vector3::new(0.95, 0.3, 0.0);
    assert!(gap.dot(&normal).abs() < 1e-14, "{gap}");
    assert!(gap.norm() > 1e-3, "the plane was left to it: {gap}");
    let last = nalgebra::Unit::new_normalize(nalgebra::Quaternion::from(shape.frames[builder.harness.frames - 1]));
    let axis = nalgebra::Vector3::z();
    assert!((last * axis - rotated * axis).norm() < 1e-14);
    assert!(last.angle_to(&rotated) > 1e-2, "the twist was left to it");
}

/// All results of a stage are rounded to f32, as on a device; within a stage the reference uses f64.
#[test]
fn numbers_of_single_precision_come_near_to_balance() {
    let mut work = vec![];
    for (h, builder) in [cable(1, 30), fork(2, 10, false), fork(3, 10, true), ring(4, 6)].into_iter().enumerate() {
        let builder = plugged(builder);
        let plan = Plan::new(builder.harness.topology(), 8);
        let mut memory = Memory::new(&plan, 1);
        memory.set_harness(&plan, 0, &builder.harness).expect("its own links");
        memory.set_shape(&plan, 0, &builder.shape);
        memory.begin(0, &Stop { tolerance: 1e-6, ..STOP }, Real::F32, builder.harness.moves());
        while memory.control[0].outcome == Outcome::None as u32 {
            for dispatch in plan.cycle() {
                reference::run(&mut memory, dispatch);
                for which in Buffer::ALL {
                    let bytes = memory.bytes(which, Real::F32);
                    memory.load(which, Real::F32, &bytes);
                }
            }
        }
        let control = &memory.control[0];
        // EA ε over the force scale is 900 N × 6e-8 / 0.3 N = 1.8e-4; the result is better because of the
        // condensation.
        assert!(control.residual < 2e-5 && control.outcome != Outcome::Failed as u32, "harness {h}: {control:?}");
        work.push(control.iterations);
    }
    assert_eq!(work, [5, 14, 8, 10]);
}
