//! The answer of `wireloom identify` in words.

use crate::print::table::Columns;
use crate::print::text::{number, printable, with_unit};
use std::io::{self, Write};
use std::path::PathBuf;
use wireloom::identify::{Estimate, Identified};

/// Noise of the residuals, relative to the one that was given, from which on the scenario does not explain the points.
const FAR_OFF: f64 = 2.0;

/// Prints the answer.
pub fn print(found: &Identified, measured: &[PathBuf], out: &mut dyn Write) -> io::Result<()> {
    let points: usize = found.configurations.iter().map(|own| own.points.len()).sum();
    let samples: usize = found.curves.iter().map(|own| own.samples.len()).sum();
    let of = match found.curves.len() {
        0 => format!("{points} points in {} configurations", found.configurations.len()),
        n => format!("{samples} samples of {n} curves"),
    };
    writeln!(out, "{}: {of}", printable(&found.scenario))?;
    for line in remarks(found) {
        writeln!(out, "{line}")?;
    }
    writeln!(out)?;
    let mut table = Columns::new(["key", ">start", ">value", ">deviation", ">95 % interval", "unit", "remark"]);
    for own in &found.parameters {
        let shown = |value: Option<f64>| value.map_or("none".to_owned(), number);
        let interval =
            own.interval.map_or("none".to_owned(), |[low, high]| format!("{} … {}", number(low), number(high)));
        table.row([
            own.key.clone(),
            number(own.start),
            shown(own.value),
            shown(own.deviation),
            interval,
            own.unit.clone(),
            remark(own),
        ]);
    }
    table.print(out)?;
    let n = found.parameters.len();
    let mut correlated = Columns::new(["key", "key", ">correlation"]);
    for (i, j) in (0..n).flat_map(|i| (0..i).map(move |j| (j, i))) {
        let keys = [i, j].map(|k| found.parameters[k].key.clone());
        let [other, one] = keys;
        correlated.row([one, other, format!("{:.2}", found.correlations[i][j])]);
    }
    correlated.print(out)?;
    if !found.curves.is_empty() {
        let mut table = Columns::new(["curve", ">samples", ">beyond the stroke", ">rms", ">of the load"]);
        for own in &found.curves {
            table.row([
                measured[own.table].display().to_string(),
                own.samples.len().to_string(),
                own.beyond.to_string(),
                with_unit(own.rms, "N"),
                format!("{:.1} %", 1e2 * own.relative),
            ]);
        }
        return table.print(out);
    }
    let mut table = Columns::new(["configuration", "step", "status", ">points", ">mean", ">rms", ">largest", "at"]);
    for own in &found.configurations {
        let largest = own.points.iter().max_by(|a, b| a.distance.total_cmp(&b.distance));
        let mm = |distance: f64| format!("{:.3} mm", 1e3 * distance);
        table.row([
            own.name.clone(),
            own.step.clone(),
            own.status.to_owned(),
            own.points.len().to_string(),
            mm(own.mean_distance),
            mm(own.rms_distance),
            mm(own.largest_distance),
            largest.map_or(String::new(), |point| point.marker.clone()),
        ]);
    }
    table.print(out)
}

/// What is to be known before the values are used: status, work, misfit, and what is not identifiable.
pub fn remarks(found: &Identified) -> Vec<String> {
    let Identified { iterations, solves, failed_solves, derivatives, derivatives_by_runs, .. } = found;
    let mut lines = vec![format!(
        "{} after {iterations} iterations, {solves} runs{}",
        found.status.words(),
        match failed_solves {
            0 => String::new(),
            n => format!(", of which {n} came to no equilibrium (the step was shortened)"),
        }
    )];
    if *derivatives_by_runs > 0 && found.curves.is_empty() {
        let missing = match found.derivatives_missing {
            0 => String::new(),
            n => format!("; {n} of these could not be computed"),
        };
        let why = found.by_runs_because.as_ref().map(|why| format!(" (the first one: {why})")).unwrap_or_default();
        lines.push(format!(
            "{derivatives_by_runs} of {derivatives} derivatives are differences of whole runs, as an equilibrium has \
             none{why}{missing}"
        ));
    }
    if let Some(noise) = found.noise {
        lines.push(match found.curves.is_empty() {
            true => format!("standard deviation of a measured coordinate: {}", with_unit(1e3 * noise, "mm")),
            false => format!("standard deviation of a measured load: {}", with_unit(noise, "N")),
        });
    }
    if let (Some(noise), Some(given)) = (found.noise, found.given_noise)
        && noise > FAR_OFF * given
    {
        lines.push(format!(
            "that is {:.1} times the noise that was given: the scenario misses something, or another fit is better",
            noise / given
        ));
    }
    if found.widened > 1.0 {
        let rho = found.neighbour_correlation.unwrap_or(0.0);
        lines.push(format!(
            "residuals of neighbouring points are correlated ({rho:.2}): the scenario misses something; deviations \
             are {:.1} times as large for it",
            found.widened
        ));
    }
    if !found.repeatable {
        lines.push(
            "carried out anew, the fitted scenario comes to other equilibria: its steps do not decide between several"
                .to_owned(),
        );
    }
    if !found.drawn.is_empty() {
        lines.push(format!(
            "it starts from a path through the measured points ({}): without it the scenario comes to other \
             equilibria, farther from them",
            found.drawn.iter().map(|name| printable(name).to_string()).collect::<Vec<_>>().join(", ")
        ));
    }
    let points = found.configurations.iter().flat_map(|own| own.points.iter().map(|point| point.weight));
    let samples = found.curves.iter().flat_map(|own| own.samples.iter().map(|sample| sample.weight));
    let weighted = points.chain(samples).filter(|weight| *weight < 1.0).count();
    match weighted {
        0 => {}
        1 => lines.push("1 point is far off, and counts less than the others".to_owned()),
        n => lines.push(format!("{n} points are far off, and count less than the others")),
    }
    for own in found.parameters.iter().filter(|own| !own.identifiable) {
        lines.push(format!("{}: {} (the fit ended at {})", printable(&own.key), remark(own), at_end(own)));
    }
    lines
}

fn at_end(own: &Estimate) -> String {
    with_unit(own.ended_at, &own.unit)
}

fn remark(own: &Estimate) -> String {
    match &own.reason {
        Some(reason) => format!("not identifiable: {reason}"),
        None if own.prior.from == "weak" => String::new(),
        None => format!("prior ({}): {} ± {}", own.prior.from, number(own.prior.value), number(own.prior.deviation)),
    }
}
