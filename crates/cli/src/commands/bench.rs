//! `wireloom bench`: times of starts, of drag steps on this machine, of all minimisers, of contact, and of a sweep of
//! many points.

mod start;

use crate::arguments::BenchArguments;
use crate::failure::{Failure, Outcome};
use crate::files::history::{DOCUMENT, History, SCHEMA};
use crate::print::table::Columns;
use crate::print::text::{counted, time};
use crate::program::{commit, fingerprint, machine, now};
use serde_json::{Value, json};
use start::Start;
use std::io::Write;
use wireloom::bench::{Case, ContactCost, Contender, Installation, MonteCarlo, OnDevice, Tilting};
use wireloom_studio::bench::Drag;

/// All measurements.
struct Measured {
    starts: Vec<Start>,
    cases: Vec<Case>,
    minimisers: Vec<Contender>,
    contact: ContactCost,
    monte_carlo: MonteCarlo,
    /// Interactive drags in the studio.
    drags: Vec<Drag>,
    installed: Option<Installation>,
    /// The same harness as it comes to rest among its own cables.
    among_cables: Option<Installation>,
}

/// Measures all cases, prints them, and appends them to the history.
pub fn bench(arguments: &BenchArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    // A history that cannot be written is reported before the work begins.
    let mut history = arguments.history.as_deref().map(History::open).transpose()?;
    let (document, outcome) = match &arguments.device {
        Some(device) => on_device(device, arguments, out)?,
        None => on_processor(arguments, out)?,
    };
    if let Some(history) = &mut history {
        history.append(&document)?;
    }
    Ok(outcome)
}

fn on_processor(arguments: &BenchArguments, out: &mut dyn Write) -> Result<(Value, Outcome), Failure> {
    let registry = wireloom::registry();
    // A file that cannot be read is reported before the work begins.
    let harness = arguments.harness.as_deref().map(|path| Ok((path, crate::files::load::text(path)?))).transpose()?;
    let mut measured = Measured {
        starts: start::measure()?,
        cases: wireloom::bench::all(),
        minimisers: wireloom::bench::minimisers(&registry, arguments.iterations as usize),
        contact: wireloom::bench::contact(&registry),
        monte_carlo: wireloom::bench::monte_carlo(arguments.points as usize, None, None, &registry),
        drags: vec![wireloom_studio::bench::cable(1_000).map_err(Failure::Input)?],
        installed: None,
        among_cables: None,
    };
    if let Some((path, kbl)) = harness {
        let refused = |message: String| Failure::Input(format!("{}: {message}", path.display()));
        measured.cases.push(wireloom::bench::drag_installed(&kbl).map_err(refused)?);
        measured.drags.push(wireloom_studio::bench::harness(&kbl).map_err(refused)?);
        measured.among_cables = Some(wireloom::bench::rest_among_cables(&kbl).map_err(refused)?);
        measured.installed = Some(wireloom::bench::install(&kbl).map_err(refused)?);
    }
    let document = document(figures(&measured));
    let print = match arguments.json {
        true => writeln!(out, "{document:#}"),
        false => table(&measured, out),
    };
    print.map_err(Failure::standard_output)?;
    // That other minimisers than `newton` do not converge is a result, no failure.
    let sound = measured.starts.iter().all(|start| start.failures == 0)
        && measured.cases.iter().all(|case| case.failures == 0)
        && measured.contact.touching.failures + measured.contact.alone.failures == 0
        && measured.monte_carlo.converged() == measured.monte_carlo.points
        && measured.drags.iter().all(|drag| drag.failures == 0)
        && [measured.among_cables, measured.installed].into_iter().flatten().all(|all| all.failures == 0);
    Ok((document, if sound { Outcome::Done } else { Outcome::NotConverged }))
}

/// Measures a device beside one core of the processor, as JSON.
fn on_device(device: &str, arguments: &BenchArguments, out: &mut dyn Write) -> Result<(Value, Outcome), Failure> {
    let measured = wireloom::bench::on_device(Some(device), arguments.points as usize).map_err(Failure::Input)?;
    let document = document(device_figures(&measured));
    writeln!(out, "{document:#}").map_err(Failure::standard_output)?;
    let sound = measured.drags.iter().all(|(gpu, newton)| gpu.failures + newton.failures == 0)
        && measured.batch.converged() == measured.batch.points;
    Ok((document, if sound { Outcome::Done } else { Outcome::NotConverged }))
}

/// A document: its form, the time, the program and the machine, then the figures.
fn document(figures: Value) -> Value {
    let mut document = json!({
        "document": DOCUMENT,
        "schema": SCHEMA,
        "time": now(),
        "version": env!("CARGO_PKG_VERSION"),
        "commit": commit(),
        "program_sha256": fingerprint(),
        "machine": machine(),
        "optimised": !cfg!(debug_assertions),
    });
    if let (Value::Object(all), Value::Object(figures)) = (&mut document, figures) {
        all.extend(figures);
    }
    document
}

fn device_figures(measured: &OnDevice) -> Value {
    let drags = measured.drags.iter().map(|(gpu, newton)| {
        json!({
            "segments": gpu.segments,
            "seconds_per_step": gpu.seconds_per_step,
            "iterations_per_step": gpu.iterations_per_step,
            "residual": gpu.residual,
            "failures": gpu.failures,
            "newton_seconds_per_step": newton.seconds_per_step,
        })
    });
    json!({
        "device": {
            "name": measured.device.name,
            "sort": measured.device.kind,
            "by": measured.device.backend,
            "driver": measured.device.driver,
            "double_precision": measured.device.double,
        },
        "drags": drags.collect::<Vec<Value>>(),
        "batch": {
            "points": measured.batch.points,
            "converged": measured.batch.converged(),
            "seconds": measured.batch.seconds,
            "newton_on_one_core": { "points": measured.one_core.points, "seconds": measured.one_core.seconds },
            "times_faster_than_one_core": measured.batch_ratio(),
        },
    })
}

fn table(measured: &Measured, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "wireloom {} on {}", env!("CARGO_PKG_VERSION"), machine())?;
    if cfg!(debug_assertions) {
        writeln!(out, "This build has debug assertions: a release build is faster.")?;
    }
    for Start { case, runs, seconds, fastest, failures } in &measured.starts {
        let command = if *case == "start" { "--version" } else { "run scenarios/first.toml" };
        let (median, fastest) = (precise(*seconds), precise(*fastest));
        writeln!(out, "wireloom {command}: {median}, at best {fastest} (of {runs} starts, {failures} failures)")?;
    }
    writeln!(out, "\nOne step moves one end by 5 mm and is solved to a relative residual of 1e-8; medians.\n")?;
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
    for case in &measured.cases {
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
    writeln!(out, "\nThe same step of 1,000 segments with each minimiser, to the same certificate.\n")?;
    minimisers(&measured.minimisers, out)?;
    let ContactCost { nodes, joints, triangles, touching, alone } = &measured.contact;
    let each = |way: &Tilting| {
        let n = way.increments as f64;
        format!("{} and {:.1} iterations an increment", precise(way.seconds / n), way.iterations as f64 / n)
    };
    writeln!(
        out,
        "\nA harness of {nodes} nodes and {joints} joints lies on an obstacle of {triangles} triangles while gravity \
         tilts: {}, {:.1} times as long as without it ({}); {} contact points in the end, {} increments not converged",
        each(touching),
        measured.contact.ratio(),
        each(alone),
        touching.contacts,
        touching.failures + alone.failures
    )?;
    writeln!(out, "\nTime from the target of a drag to its frame, in the studio over loopback.\n")?;
    drags(&measured.drags, out)?;
    let MonteCarlo { points, statuses, threads, seconds } = &measured.monte_carlo;
    let statuses: Vec<String> = statuses.iter().map(|(status, n)| format!("{n} {status}")).collect();
    let (threads, each) = (counted(*threads, "thread", "threads"), precise(seconds / *points as f64));
    let statuses = statuses.join(", ");
    writeln!(
        out,
        "\nA sweep of a Y harness over {points} points ({statuses}) on {threads}: {}, {each} a point",
        time(*seconds)
    )?;
    if let Some(all) = &measured.among_cables {
        writeln!(
            out,
            "\nInstalled, at rest with contact among all cables: {} nodes, {} iterations, {}{}",
            all.nodes,
            all.iterations,
            time(all.seconds),
            if all.failures > 0 { " (not converged)" } else { "" },
        )?;
    }
    if let Some(all) = &measured.installed {
        let Installation { nodes, steps, increments, failures, iterations, seconds } = all;
        writeln!(
            out,
            "\nFrom the board into the vehicle: {nodes} nodes, {steps} steps, {increments} increments \
             ({failures} not converged), {iterations} iterations, {}{}",
            time(*seconds),
            peak_memory().map_or_else(String::new, |bytes| format!(", {} MB at most", bytes / 1_000_000)),
        )?;
    }
    Ok(())
}

fn minimisers(all: &[Contender], out: &mut dyn Write) -> std::io::Result<()> {
    let mut table = Columns::new([
        "minimiser",
        "preconditioner",
        ">step",
        ">times newton",
        ">iterations",
        ">evaluations",
        ">factorisations",
        ">largest residual",
        "converged",
    ]);
    for Contender { minimiser, preconditioner, case, times_newton } in all {
        let at_least = if case.failures > 0 { "> " } else { "" };
        table.row([
            (*minimiser).to_owned(),
            preconditioner.unwrap_or("").to_owned(),
            format!("{at_least}{}", precise(case.seconds_per_step)),
            format!("{at_least}{times_newton:.1}"),
            format!("{:.1}", case.iterations_per_step),
            format!("{:.1}", case.evaluations_per_step),
            format!("{:.1}", case.factorisations_per_step),
            format!("{:.0e}", case.residual),
            if case.failures == 0 { "yes" } else { "no" }.to_owned(),
        ]);
    }
    table.print(out)
}

fn drags(all: &[Drag], out: &mut dyn Write) -> std::io::Result<()> {
    let mut table = Columns::new([">nodes", ">targets", ">median", ">slowest", ">a second", ">failures"]);
    for drag in all {
        table.row([
            drag.nodes.to_string(),
            drag.targets.to_string(),
            precise(drag.seconds),
            precise(drag.slowest),
            format!("{:.0}", drag.per_second),
            drag.failures.to_string(),
        ]);
    }
    table.print(out)
}

/// Peak memory of this process, bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
}

/// Three digits.
fn precise(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.3} ms", 1e3 * seconds) } else { time(seconds) }
}

fn figures(measured: &Measured) -> Value {
    let starts = measured.starts.iter().map(|start| {
        json!({
            "case": start.case,
            "runs": start.runs,
            "seconds": start.seconds,
            "fastest": start.fastest,
            "failures": start.failures,
        })
    });
    let case = |case: &Case| {
        json!({
            "case": case.case,
            "segments": case.segments,
            "threads": case.threads,
            "seconds_per_step": case.seconds_per_step,
            "seconds_out": case.seconds_out,
            "seconds_back": case.seconds_back,
            "iterations_per_step": case.iterations_per_step,
            "evaluations_per_step": case.evaluations_per_step,
            "factorisations_per_step": case.factorisations_per_step,
            "residual": case.residual,
            "failures": case.failures,
        })
    };
    let minimisers = measured.minimisers.iter().map(|contender| {
        let mut entry = case(&contender.case);
        entry["minimiser"] = contender.minimiser.into();
        entry["preconditioner"] = contender.preconditioner.into();
        entry["times_newton"] = contender.times_newton.into();
        entry
    });
    let tilting = |way: &Tilting| {
        json!({
            "increments": way.increments,
            "failures": way.failures,
            "iterations": way.iterations,
            "seconds": way.seconds,
            "contacts": way.contacts,
        })
    };
    let contact = json!({
        "nodes": measured.contact.nodes,
        "joints": measured.contact.joints,
        "triangles": measured.contact.triangles,
        "touching": tilting(&measured.contact.touching),
        "alone": tilting(&measured.contact.alone),
        "times_alone": measured.contact.ratio(),
    });
    let all = &measured.monte_carlo;
    let statuses: serde_json::Map<String, Value> =
        all.statuses.iter().map(|(status, n)| (status.clone(), (*n).into())).collect();
    let mut document = json!({
        "starts": starts.collect::<Vec<Value>>(),
        "cases": measured.cases.iter().map(case).collect::<Vec<Value>>(),
        "minimisers": minimisers.collect::<Vec<Value>>(),
        "contact": contact,
        "monte_carlo": {
            "points": all.points,
            "statuses": statuses,
            "threads": all.threads,
            "seconds": all.seconds,
        },
    });
    let drags = measured.drags.iter().map(|drag| {
        json!({
            "nodes": drag.nodes,
            "targets": drag.targets,
            "seconds": drag.seconds,
            "slowest": drag.slowest,
            "per_second": drag.per_second,
            "failures": drag.failures,
        })
    });
    document["hands"] = drags.collect::<Vec<Value>>().into();
    for (key, all) in [("among_cables", &measured.among_cables), ("installation", &measured.installed)] {
        let Some(all) = all else { continue };
        document[key] = json!({
            "nodes": all.nodes,
            "steps": all.steps,
            "increments": all.increments,
            "failures": all.failures,
            "iterations": all.iterations,
            "seconds": all.seconds,
        });
    }
    if measured.installed.is_some() {
        document["installation"]["peak_memory"] = peak_memory().into();
    }
    document
}
