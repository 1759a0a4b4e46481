//! Benchmark of a device: drag steps by cycles of Newton's method, next to the model of [`wireloom_shaders::cost`] and
//! to `newton` on one core, and the time of each stage of the first cycle. Prints a line of JSON for the device and for
//! each case.
//!
//! `cargo bench -p wireloom-gpu` uses the fastest device, `cargo bench -p wireloom-gpu -- NAME` another one (`wireloom
//! devices` lists them). `wireloom bench --device NAME` compares whole runs on a device with one CPU core.
#![allow(clippy::print_stdout, reason = "a benchmark prints what it found")]

use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::error::Error;
use std::time::{Duration, Instant};
use wireloom_core::{Minimiser, Pose, Problem, Registry, State, Vector, minimiser};
use wireloom_gpu::Gpu;
use wireloom_gpu::flatten::Flattening;
use wireloom_gpu::session::Session;
use wireloom_shaders::Real;
use wireloom_shaders::harness::{Algorithm, Stop};
use wireloom_shaders::layout::Phase;
use wireloom_shaders::memory::{Memory, TopologyMismatch, pack};
use wireloom_shaders::plan::Plan;
use wireloom_solve::minimisers::newton::Newton;
use wireloom_testkit::conformance::networks::{Sample, cable, y_harness};

/// Number of measurements of each case, at least two; the median is reported.
const REPEATS: usize = 5;
/// Time for which a case runs before it is measured.
const WARM_UP: Duration = Duration::from_millis(500);
/// Number of cycles of a submission.
const CYCLES: usize = 4;
/// The constraint that moves.
const END: usize = 1;
/// Way from the rest shape to the bent one from which the steps start, m, in so many increments.
const BENT: (Vector, usize) = (Vector::new(-0.1, 0.05, 0.0), 15);
/// Displacement of the end in a step, m.
const STEP: Vector = Vector::new(5e-3, 0.0, 0.0);

fn main() -> Result<(), Box<dyn Error>> {
    let selector = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let gpu = Gpu::open(selector.as_deref())?;
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    // A software device only shows that the benchmark runs; its times mean nothing for a GPU.
    let (lengths, many) =
        if gpu.info.kind == "software" { (&[100, 1_000][..], 8) } else { (&[1_000, 10_000, 100_000][..], 4_096) };
    let mut cases = Vec::new();
    for &segments in lengths {
        for leaf in [4, 8, 16] {
            cases.push((format!("a cable of {segments} segments"), cable(&registry, segments), 1, leaf));
        }
    }
    for leaf in [8, 32, usize::MAX] {
        cases.push(("three branches of 60 segments".to_owned(), y_harness(&registry, "cosserat", 60), many, leaf));
    }
    let reals = if gpu.info.double { &[Real::F64, Real::F32][..] } else { &[Real::F32] };
    let device = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "device": gpu.info.name,
        "sort": gpu.info.kind,
        "by": gpu.info.backend,
        "driver": gpu.info.driver,
    });
    println!("{device}");
    for (what, sample, variants, leaf) in &cases {
        for &real in reals {
            let case = measure(&gpu, what, sample, (*variants, *leaf), real)
                .unwrap_or_else(|error| json!({ "what": what, "variants": variants, "error": error.to_string() }));
            println!("{case}");
        }
    }
    Ok(())
}

/// The harness with its end moved, in equilibrium.
fn bent(sample: &Sample) -> (Problem<'_>, State) {
    let (mut problem, mut state, mut newton) = (sample.problem(), sample.state.clone(), Newton::new());
    let (way, increments) = BENT;
    for _ in 0..increments {
        let target = problem.conditions().targets[END];
        let position = target.position + way / increments as f64;
        problem.set_target(END, Pose { position, ..target });
        newton.minimise(&mut problem, &mut state, &minimiser::Stop { force_tolerance: 1e-8, max_iterations: 1_000 });
    }
    (problem, state)
}

/// Moves one end, by a different distance for each variant, and minimises all variants.
fn measure(
    gpu: &Gpu,
    what: &str,
    sample: &Sample,
    (variants, leaf): (usize, usize),
    real: Real,
) -> Result<Value, Box<dyn Error>> {
    let (mut problem, state) = bent(sample);
    let flattening = Flattening::new(&sample.network);
    let (scales, target) = (problem.least_scales(), problem.conditions().targets[END]);
    let moved = |variant: usize| {
        let way = STEP * ((variant + 1) as f64 / variants as f64);
        Pose { position: target.position + way, ..target }
    };
    let mut harnesses = Vec::new();
    for variant in 0..variants {
        problem.set_target(END, moved(variant));
        problem.update_held(&state);
        harnesses.push(flattening.harness(&problem, &state));
    }
    let plan = Plan::new(harnesses[0].topology(), leaf);
    let shape = flattening.shape(&state);
    let stop = Stop {
        force_scale: scales.force,
        moment_scale: scales.moment,
        length_scale: scales.length,
        tolerance: if real == Real::F64 { 1e-8 } else { 1e-3 },
        max_iterations: 200,
        algorithm: Algorithm::Newton,
    };
    let mut memory = Memory::new(&plan, variants);
    let session = Session::new(gpu, real, &plan, &memory)?;
    let begin = |memory: &mut Memory| {
        (0..variants).for_each(|variant| memory.begin(variant, &stop, real, harnesses[variant].moves()));
        let packed: Result<Vec<_>, _> =
            harnesses.par_iter().map(|harness| pack(&plan, harness, &shape, real)).collect();
        let packed = packed?;
        session.upload(gpu, memory, &packed.iter().map(Vec::as_slice).collect::<Vec<_>>());
        Ok::<_, TopologyMismatch>(())
    };
    let mut once = || {
        let clock = Instant::now();
        begin(&mut memory)?;
        let submitted = Instant::now();
        let mut cycles = 0;
        while memory.control.iter().any(|control| control.phase != Phase::Done as u32) {
            session.run(gpu, CYCLES, &mut memory, variants).ok_or_else(|| gpu.failure().unwrap_or_default())?;
            cycles += CYCLES;
        }
        Ok::<_, Box<dyn Error>>((clock.elapsed().as_secs_f64(), submitted.elapsed().as_secs_f64(), cycles))
    };
    // Shaders are compiled, and an idle card raises its clock.
    let clock = Instant::now();
    while clock.elapsed() < WARM_UP {
        once()?;
    }
    let measured = (0..REPEATS).map(|_| once()).collect::<Result<Vec<_>, _>>()?;
    let (in_all, on_device) = (median(measured.iter().map(|m| m.0)), median(measured.iter().map(|m| m.1)));
    let cycles = measured[0].2;
    let needed = memory.control.iter().map(|control| control.cycles).max();
    let largest_residual = memory.control.iter().map(|control| control.residual).fold(0.0, f64::max);
    // Cycles after the last one needed move almost no data: all variants are finished.
    let working: f64 = memory.control.iter().map(|control| f64::from(control.cycles)).sum();
    let traffic = plan.traffic();
    let bytes = working * (traffic.numbers * real.bytes() as u64) as f64;
    let mut stages: BTreeMap<&str, (usize, f64)> = BTreeMap::new();
    begin(&mut memory)?;
    for (stage, seconds) in session.time_cycle(gpu).unwrap_or_default() {
        let (dispatches, all) = stages.entry(stage.name()).or_default();
        *dispatches += 1;
        *all += 1e6 * seconds;
    }
    // A sample of the variants, one after the other.
    let on_one_core = median((0..REPEATS).map(|repeat| {
        let (mut own, mut newton) = (state.clone(), Newton::new());
        problem.set_target(END, moved((variants - 1) * repeat / (REPEATS - 1)));
        let clock = Instant::now();
        let stop = minimiser::Stop { force_tolerance: stop.tolerance, max_iterations: 200 };
        newton.minimise(&mut problem, &mut own, &stop);
        clock.elapsed().as_secs_f64()
    })) * variants as f64;
    Ok(json!({
        "what": what,
        "variants": variants,
        "leaf": leaf.min(plan.len()),
        "precision": if real == Real::F64 { "f64" } else { "f32" },
        "seconds": in_all,
        "seconds_on_the_device": on_device,
        "seconds_per_cycle": on_device / cycles as f64,
        "newton_on_one_core_seconds": on_one_core,
        "times_faster": on_one_core / in_all,
        "times_faster_on_the_device": on_one_core / on_device,
        "largest_residual": largest_residual,
        "cycles_submitted": cycles,
        "cycles_needed": needed,
        "dispatches_per_cycle": traffic.dispatches,
        "walk_per_cycle": traffic.walk,
        "bytes_per_cycle_and_variant": traffic.numbers * real.bytes() as u64,
        "bytes_per_second": bytes / on_device,
        "stages_of_the_first_cycle": stages
            .into_iter()
            .map(|(stage, (dispatches, us))| json!({ "stage": stage, "dispatches": dispatches, "us": us }))
            .collect::<Vec<_>>(),
    }))
}

fn median(times: impl Iterator<Item = f64>) -> f64 {
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
