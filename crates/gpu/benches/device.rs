//! Benchmark of a device: time of a cycle of Newton's method, next to the model of [`wireloom_shaders::cost`]. Prints
//! JSON with the name of the device.
//!
//! `cargo bench -p wireloom-gpu` uses the fastest device, `cargo bench -p wireloom-gpu -- NAME` another one (`wireloom
//! devices` lists them). `wireloom bench --device NAME` compares whole runs on a device with one CPU core.
#![allow(clippy::print_stdout, reason = "a benchmark prints what it found")]

use serde_json::{Value, json};
use std::error::Error;
use std::time::Instant;
use wireloom_core::{Pose, Registry, Vector};
use wireloom_gpu::Gpu;
use wireloom_gpu::flatten::Flattening;
use wireloom_gpu::session::Session;
use wireloom_shaders::Real;
use wireloom_shaders::harness::{Algorithm, Stop};
use wireloom_shaders::layout::Phase;
use wireloom_shaders::memory::Memory;
use wireloom_shaders::plan::Plan;
use wireloom_testkit::conformance::networks::{Sample, cable, y_harness};

/// Number of measurements of each case; the median is reported.
const REPEATS: usize = 5;
/// Number of cycles of a submission.
const CYCLES: usize = 16;
/// Displacement of an end, m.
const STEP: f64 = 5e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let selector = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let gpu = Gpu::open(selector.as_deref())?;
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    // A software device only shows that the benchmark runs; its times mean nothing for a GPU.
    let (lengths, many) = if gpu.info.kind == "software" { ([100, 1_000], 8) } else { ([1_000, 10_000], 10_000) };
    let cases = [
        (format!("a cable of {} segments", lengths[0]), cable(&registry, lengths[0]), 1, 8),
        (format!("a cable of {} segments", lengths[1]), cable(&registry, lengths[1]), 1, 8),
        ("three branches of 60 segments".to_owned(), y_harness(&registry, "cosserat", 60), many, usize::MAX),
    ];
    let reals = if gpu.info.double { &[Real::F64, Real::F32][..] } else { &[Real::F32] };
    let mut measured = Vec::new();
    for (what, sample, variants, leaf) in &cases {
        for &real in reals {
            measured.push(measure(&gpu, what, sample, (*variants, *leaf), real)?);
        }
    }
    let device = json!({
        "name": gpu.info.name,
        "sort": gpu.info.kind,
        "by": gpu.info.backend,
        "driver": gpu.info.driver,
    });
    println!("{:#}", json!({ "version": env!("CARGO_PKG_VERSION"), "device": device, "cases": measured }));
    Ok(())
}

/// Moves one end, by a different distance for each variant, and minimises all variants.
fn measure(
    gpu: &Gpu,
    what: &str,
    sample: &Sample,
    (variants, leaf): (usize, usize),
    real: Real,
) -> Result<Value, Box<dyn Error>> {
    let mut problem = sample.problem();
    let flattening = Flattening::new(&sample.network);
    let (scales, target) = (problem.least_scales(), problem.conditions().targets[1]);
    let mut harnesses = Vec::new();
    for variant in 0..variants {
        let way = STEP * (variant + 1) as f64 / variants as f64;
        problem.set_target(1, Pose { position: target.position - Vector::x() * way, ..target });
        problem.update_held(&sample.state);
        harnesses.push(flattening.harness(&problem, &sample.state));
    }
    let plan = Plan::new(harnesses[0].topology(), leaf);
    let shape = flattening.shape(&sample.state);
    let all: Vec<_> = harnesses.iter().map(|harness| (harness, &shape)).collect();
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
    let (mut all_told, mut on_device, mut cycles) = (Vec::new(), Vec::new(), 0);
    // The first run includes compilation.
    for _ in 0..=REPEATS {
        let clock = Instant::now();
        memory.set_all(&plan, &all)?;
        (0..variants).for_each(|variant| memory.begin(variant, &stop, real));
        session.upload(gpu, &memory);
        let submitted = Instant::now();
        cycles = 0;
        while memory.control.iter().any(|control| control.phase != Phase::Done as u32) {
            if !session.run(gpu, CYCLES, &mut memory) {
                return Err(gpu.failure().unwrap_or_default().into());
            }
            cycles += CYCLES;
        }
        on_device.push(submitted.elapsed().as_secs_f64());
        all_told.push(clock.elapsed().as_secs_f64());
    }
    let median = |times: &mut Vec<f64>| {
        times.remove(0);
        times.sort_by(f64::total_cmp);
        times[REPEATS / 2]
    };
    let (all_told, on_device) = (median(&mut all_told), median(&mut on_device));
    let needed = memory.control.iter().map(|control| control.cycles).max();
    // Cycles after the last one needed move almost no data: all variants are finished.
    let working: f64 = memory.control.iter().map(|control| f64::from(control.cycles)).sum();
    let traffic = plan.traffic();
    let bytes = working * (traffic.numbers * real.bytes() as u64) as f64;
    Ok(json!({
        "what": what,
        "variants": variants,
        "precision": if real == Real::F64 { "f64" } else { "f32" },
        "seconds": all_told,
        "seconds_on_the_device": on_device,
        "seconds_per_cycle": on_device / cycles as f64,
        "cycles_submitted": cycles,
        "cycles_needed": needed,
        "dispatches_per_cycle": traffic.dispatches,
        "walk_per_cycle": traffic.walk,
        "bytes_per_cycle_and_variant": traffic.numbers * real.bytes() as u64,
        "bytes_per_second": bytes / on_device,
    }))
}
