//! Every stage against its CPU reference: with the same input, dispatch by dispatch, the results are equal up to
//! round-off.

use super::common::registry;
use fastrand::Rng;
use libtest_mimic::Failed;
use std::sync::Arc;
use wireloom_core::rotation::turned;
use wireloom_core::{Pose, State, Vector};
use wireloom_gpu::Gpu;
use wireloom_gpu::flatten::{Flattening, accepts};
use wireloom_gpu::session::Session;
use wireloom_shaders::harness::{Algorithm, Stop};
use wireloom_shaders::layout::Phase;
use wireloom_shaders::memory::{Buffer, Memory};
use wireloom_shaders::plan::Plan;
use wireloom_shaders::{Real, reference};
use wireloom_testkit::conformance::networks::{Sample, cable, ring, sized_y_harness, y_harness};

/// Number of compared cycles: a first step that includes prescribed motion, and two more.
const CYCLES: usize = 3;

/// Harnesses with all types of parts, away from equilibrium.
fn samples() -> Vec<(&'static str, Sample)> {
    let registry = registry();
    vec![
        ("a cable", cable(&registry, 12)),
        ("arms in a point", y_harness(&registry, "cosserat", 6)),
        ("a hub with offsets", sized_y_harness(&registry, "rigid-body", 6, 0.02)),
        ("a compliant hub", y_harness(&registry, "compliant-hub", 6)),
        ("a ring", ring(&registry, "fused", 9, 4)),
    ]
}

fn disturbed(sample: &Sample, rng: &mut Rng) -> State {
    let mut state = sample.state.clone();
    let mut vector = |size: f64| Vector::from_fn(|_, _| size * (rng.f64() - 0.5));
    state.points.iter_mut().for_each(|x| *x += vector(2e-3));
    state.frames.iter_mut().for_each(|q| *q = turned(q, &vector(0.2)));
    sample.network.follow_ties(&mut state);
    state
}

/// In f64.
pub fn double(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    if !gpu.info.double {
        return Err("the device has no double precision: nothing to compare".into());
    }
    every_stage(gpu, Real::F64, 1e-11, Algorithm::Newton)?;
    every_stage(gpu, Real::F64, 1e-11, Algorithm::Gradient)
}

/// In f32; the reference computes in f64.
pub fn single(gpu: &Arc<Gpu>) -> Result<(), Failed> {
    every_stage(gpu, Real::F32, 2e-3, Algorithm::Newton)
}

fn every_stage(gpu: &Arc<Gpu>, real: Real, allowed: f64, algorithm: Algorithm) -> Result<(), Failed> {
    let mut rng = Rng::with_seed(3);
    for (name, sample) in samples() {
        assert_eq!(accepts(&sample.network), Ok(()), "{name}");
        let mut problem = sample.problem();
        let target = problem.conditions().targets[0];
        let moved = target.position + Vector::new(1e-3, 2e-3, -1e-3);
        problem.set_target(0, Pose { position: moved, ..target });
        let state = disturbed(&sample, &mut rng);
        problem.update_held(&state);
        let flattening = Flattening::new(&sample.network);
        let harness = flattening.harness(&problem, &state);
        let plan = Plan::new(harness.topology(), 4);
        let mut reference = Memory::new(&plan, 2);
        let scales = problem.least_scales();
        let stop = Stop {
            force_scale: scales.force,
            moment_scale: scales.moment,
            length_scale: scales.length,
            tolerance: 1e-8,
            max_iterations: 20,
            algorithm,
        };
        // Two variants with different states.
        for (variant, state) in [(0, state.clone()), (1, disturbed(&sample, &mut rng))] {
            let harness = flattening.harness(&problem, &state);
            reference.set_harness(&plan, variant, &harness)?;
            reference.set_shape(&plan, variant, &flattening.shape(&state));
            reference.begin(variant, &stop, real, harness.moves());
        }
        let session = Session::new(gpu, real, &plan, &reference)?;
        for cycle in 0..CYCLES {
            for (k, dispatch) in plan.cycle().iter().enumerate() {
                // Round to the device's precision.
                for which in Buffer::ALL {
                    let bytes = reference.bytes(which, real);
                    reference.load(which, real, &bytes);
                }
                session.upload_all(gpu, &reference);
                let mut device = reference.clone();
                if !session.step(gpu, k, &mut device) {
                    return Err(gpu.failure().unwrap_or_default().into());
                }
                let before = reference.clone();
                reference::run(&mut reference, dispatch);
                let place = format!("{name}, cycle {cycle}, {}", dispatch.stage.name());
                compare(&place, &before, &reference, &device, allowed)?;
            }
        }
        assert!(reference.control.iter().all(|control| control.phase != Phase::Done as u32 || control.iterations > 1));
    }
    Ok(())
}

/// Compares all buffers that a stage may write, including the parts that it must not change.
fn compare(place: &str, before: &Memory, reference: &Memory, device: &Memory, allowed: f64) -> Result<(), Failed> {
    let reals = |memory: &Memory| memory.control.iter().flat_map(|control| control.reals()).collect::<Vec<f64>>();
    let buffers = [
        ("state", &before.state, &reference.state, &device.state),
        ("parts", &before.parts, &reference.parts, &device.parts),
        ("blocks", &before.blocks, &reference.blocks, &device.blocks),
        ("vectors", &before.vectors, &reference.vectors, &device.vectors),
        ("control", &reals(before), &reals(reference), &reals(device)),
    ];
    for (buffer, before, reference, device) in buffers {
        let written = (0..reference.len()).filter(|&k| before[k].to_bits() != reference[k].to_bits());
        let scale = written.map(|k| reference[k].abs()).fold(0.0, f64::max);
        for (k, (a, b)) in reference.iter().zip(device).enumerate() {
            let near = (a - b).abs() <= allowed * scale || a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
            if !near {
                return Err(format!("{place}: {buffer}[{k}] is {b:e} on the device, {a:e} in the reference").into());
            }
        }
    }
    let words = |memory: &Memory| memory.control.iter().map(|control| control.words()).collect::<Vec<_>>();
    if words(reference) != words(device) {
        return Err(format!(
            "{place}: control is {:?} on the device, {:?} in the reference",
            device.control, reference.control
        )
        .into());
    }
    Ok(())
}
