//! `wireloom bench`: drag-step times on the machine at hand.

use crate::failure::{Failure, Outcome};
use crate::summary::{Columns, time};
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;
use wireloom::bench::{Case, Installation};

/// Measures all cases and prints them.
pub fn bench(as_json: bool, harness: Option<&Path>, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut cases = wireloom::bench::all();
    let mut installed = None;
    if let Some(path) = harness {
        let kbl = crate::load::text(path)?;
        let refused = |message: String| Failure::Input(format!("{}: {message}", path.display()));
        cases.push(wireloom::bench::drag_installed(&kbl).map_err(refused)?);
        installed = Some(wireloom::bench::install(&kbl).map_err(refused)?);
    }
    let print = match as_json {
        true => writeln!(out, "{:#}", document(&cases, installed.as_ref())),
        false => table(&cases, installed.as_ref(), out),
    };
    print.map_err(Failure::standard_output)?;
    let sound = cases.iter().all(|case| case.failures == 0) && installed.is_none_or(|all| all.failures == 0);
    Ok(if sound { Outcome::Done } else { Outcome::NotConverged })
}

fn table(cases: &[Case], installed: Option<&Installation>, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "wireloom {} on {}", env!("CARGO_PKG_VERSION"), machine())?;
    if cfg!(debug_assertions) {
        writeln!(out, "This build checks itself as it goes: a release build is faster.")?;
    }
    writeln!(out, "One step moves one end by 5 mm and is solved to a relative residual of 1e-8; medians.\n")?;
    let mut table = Columns::new([
        "case",
        ">segments",
        ">threads",
        ">step",
        ">out",
        ">back",
        ">per segment",
        ">iterations",
        ">largest residual",
        ">failures",
    ]);
    for case in cases {
        table.row([
            case.case.to_owned(),
            case.segments.to_string(),
            case.threads.to_string(),
            precise(case.seconds_per_step),
            precise(case.seconds_out),
            precise(case.seconds_back),
            format!("{:.0} ns", 1e9 * case.seconds_per_step / case.segments as f64),
            format!("{:.2}", case.iterations_per_step),
            format!("{:.0e}", case.residual),
            case.failures.to_string(),
        ]);
    }
    table.print(out)?;
    if let Some(all) = installed {
        let Installation { nodes, steps, increments, failures, iterations, seconds } = all;
        writeln!(
            out,
            "\nFrom the board into the vehicle: {nodes} nodes, {steps} steps, {increments} increments ({failures} not converged), {iterations} iterations, {}{}",
            time(*seconds),
            peak_memory().map_or_else(String::new, |bytes| format!(", {} MB at most", bytes / 1_000_000)),
        )?;
    }
    Ok(())
}

/// Most memory this process has had so far, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
}

/// Three digits.
fn precise(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.3} ms", 1e3 * seconds) } else { time(seconds) }
}

fn document(cases: &[Case], installed: Option<&Installation>) -> Value {
    let cases: Vec<Value> = cases
        .iter()
        .map(|case| {
            json!({
                "case": case.case,
                "segments": case.segments,
                "threads": case.threads,
                "seconds_per_step": case.seconds_per_step,
                "seconds_out": case.seconds_out,
                "seconds_back": case.seconds_back,
                "iterations_per_step": case.iterations_per_step,
                "factorisations_per_step": case.factorisations_per_step,
                "residual": case.residual,
                "failures": case.failures,
            })
        })
        .collect();
    let mut document = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "machine": machine(),
        "optimised": !cfg!(debug_assertions),
        "cases": cases,
    });
    if let Some(all) = installed {
        document["installation"] = json!({
            "nodes": all.nodes,
            "steps": all.steps,
            "increments": all.increments,
            "failures": all.failures,
            "iterations": all.iterations,
            "seconds": all.seconds,
            "peak_memory": peak_memory(),
        });
    }
    document
}

/// Processor, number of cores, system: as far as they can be told.
pub fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let processor = processor.unwrap_or_else(|| std::env::consts::ARCH.to_owned());
    format!("{processor}, {}, {}", crate::size::counted(cores, "core", "cores"), std::env::consts::OS)
}
