//! Summary of a sweep: verdicts, requirements with their drivers, ranges of results, points without a result.

use crate::print::table::{Columns, ROWS};
use crate::print::text::{counted, printable};
use std::io::{self, Write};
use std::path::Path;
use wireloom::export::sheet;
use wireloom::export::table::Table;
use wireloom::export::table::statistics::{Requirement, Yield, converged_numbers, summary};

/// Results whose ranges are shown: columns, and their units.
pub const RANGES: [(&str, &str); 3] = [("energy.total", "J"), ("min_bend_radius", "m"), ("max_force", "N")];
/// Messages of points without a result that are shown.
const REASONS: usize = 3;
/// Drivers of a requirement that are shown.
const DRIVERS: usize = 2;

/// Prints it; `file`: the scenario.
pub fn print(table: &Table, file: &Path, out: &mut dyn Write) -> io::Result<()> {
    let found = summary(table);
    let words: Vec<String> = found.statuses.iter().map(|(status, n)| format!("{n} {status}")).collect();
    writeln!(out, "{}: {}", counted(table.rows(), "point", "points"), words.join(", "))?;
    let Yield { passed, failed, unresolved, without, .. } = found.yields;
    if found.requirements.is_empty() {
        writeln!(out, "no requirements: nothing was checked")?;
    } else {
        let nothing = if without > 0 { format!(", {without} without a result") } else { String::new() };
        writeln!(out, "{passed} pass, {failed} fail, {unresolved} unresolved{nothing}")?;
        // Combinations share their samples: together they are no random sample.
        writeln!(out, "{}", yield_words(&found.yields, found.sampled && found.combinations.is_empty()))?;
        for (name, yields) in found.combinations.iter().take(ROWS) {
            writeln!(out, "  {}: {}", printable(name), yield_words(yields, found.sampled))?;
        }
    }
    writeln!(out)?;
    print_requirements(&found.requirements, out)?;
    if let Some(k) = found.worst.filter(|_| failed + unresolved > 0) {
        writeln!(out, "the worst point: wireloom run {} --point {k}\n", printable(&file.display().to_string()))?;
    }
    match table.numbers("polish").iter().flatten().filter(|polish| **polish > 0.0).count() {
        0 => {}
        polished => writeln!(out, "{polished} of them finished on the CPU, to the same tolerance\n")?,
    }
    let mut columns = Columns::new(["result", ">points", ">minimum", ">mean", ">maximum"]);
    for (name, unit) in RANGES {
        let numbers: Vec<f64> = converged_numbers(table, name).into_iter().flatten().collect();
        if numbers.is_empty() {
            continue;
        }
        let (least, greatest) =
            numbers.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        let cell = |number: f64| format!("{number:.5}");
        columns.row([format!("{name} [{unit}]"), numbers.len().to_string(), cell(least), cell(mean), cell(greatest)]);
    }
    columns.print(out)?;
    if found.yields.not_converged > 0 {
        writeln!(out, "results are those of points that converged: {} did not\n", found.yields.not_converged)?;
    }
    let reasons = table.words("message").iter().enumerate().filter_map(|(k, message)| Some((k, message.as_ref()?)));
    for (k, message) in reasons.take(REASONS) {
        let status = table.words("status")[k].as_deref().unwrap_or_default();
        writeln!(out, "point {k} {}: {}", printable(status), printable(message))?;
    }
    Ok(())
}

/// "yield 62.0 %, with 95 % confidence 55.1 % to 68.5 %".
fn yield_words(yields: &Yield, sampled: bool) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    if !sampled {
        return format!("{} of the points pass", percent(yields.share()));
    }
    let (low, high) = yields.interval();
    format!("yield {}, with 95 % confidence {} to {}", percent(yields.share()), percent(low), percent(high))
}

fn print_requirements(requirements: &[Requirement], out: &mut dyn Write) -> io::Result<()> {
    let headings = ["requirement", ">fails", ">unresolved", ">worst", ">margin", ">point", "step, place", "driven by"];
    let mut columns = Columns::new(headings);
    for requirement in requirements.iter().take(ROWS) {
        let worst = requirement.worst.as_ref();
        let margin = worst.and_then(|worst| worst.margin).map(|margin| format!("{:+.1} %", 100.0 * margin));
        let place = worst.map(|worst| [worst.step.as_str(), &worst.place].join(", "));
        let drivers = requirement.drivers.iter().take(DRIVERS);
        let drivers: Vec<String> =
            drivers.map(|driver| format!("{} ({:+.2})", driver.key, driver.correlation)).collect();
        columns.row([
            requirement.name.clone(),
            requirement.fails.to_string(),
            requirement.unresolved.to_string(),
            worst.map(|worst| sheet::value(requirement.measure, worst.value)).unwrap_or_default(),
            margin.unwrap_or_default(),
            worst.map(|worst| worst.point.to_string()).unwrap_or_default(),
            place.unwrap_or_default(),
            drivers.join(", "),
        ]);
    }
    columns.print(out)?;
    if requirements.len() > ROWS {
        writeln!(out, "and {} more requirements in the table\n", requirements.len() - ROWS)?;
    }
    if requirements.iter().any(|requirement| !requirement.drivers.is_empty()) {
        writeln!(out, "in brackets: rank correlation of the worst value with the key\n")?;
    }
    Ok(())
}
