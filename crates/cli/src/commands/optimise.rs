//! `wireloom optimise`: chooses numbers and words of a scenario so that its objective is smallest and its requirements
//! are kept.

use crate::arguments::OptimiseArguments;
use crate::failure::{Failure, Outcome};
use crate::files::folder::Folder;
use crate::files::load::{self, Beside};
use crate::interrupt;
use crate::plugin::trust::Trust;
use crate::print::optimise as print;
use crate::program::PROGRAM;
use serde_json::{Value, json};
use std::io::{self, Write};
use wireloom::export::{json, sha256};
use wireloom::optimise::{Design, Ending, NoOptimum, Optimisation, Search};
use wireloom::sensitivity::Source;

/// The designs, one a row.
const TABLE: &str = "designs.csv";
/// The best design, as a scenario.
const SCENARIO: &str = "optimum.toml";
/// How it was found, and its certificate.
const SUMMARY: &str = "optimum.json";

/// Searches, and writes every design as soon as it is known, then the best one with its certificate.
pub fn optimise(arguments: &OptimiseArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let OptimiseArguments { file, out: named, json: as_json, quiet, allowed } = arguments;
    let loaded = load::scenario(file, &[], &Trust::to_run(allowed))?;
    let text = loaded.texts[0].1.as_str();
    let files = Beside::of(file);
    interrupt::listen();
    let source = Source { monitor: interrupt::monitor().clone(), ..Source::new(text, &files, &loaded.registry) };
    let refused = |reason: NoOptimum| match reason {
        NoOptimum::Faults(faults) => Failure::Refused(vec![load::refusal(file, text.to_owned(), faults)]),
        other => Failure::Input(format!("{}: {other}", file.display())),
    };
    let search = Search::new(source).map_err(refused)?;
    let mut folder = Folder::of_results(named.as_deref(), file)?;
    folder.clear()?;
    let keys = search.keys();
    let (mut rows, mut failed): (Vec<Design>, _) = (Vec::new(), None);
    let show = !*quiet && !*as_json;
    let mut table = print::Table::new(&keys);
    let found = search.run(&mut |design| {
        rows.push(design.clone());
        let written = folder.write(TABLE, |out| table_of(&keys, &rows, out)).and_then(|()| {
            let shown = if show { table.row(design, out) } else { Ok(()) };
            shown.map_err(Failure::standard_output)
        });
        if let Err(failure) = written {
            // What cannot be written or shown ends the work.
            interrupt::stop();
            failed.get_or_insert(failure);
        }
    });
    if let Some(failure) = failed {
        return Err(failure);
    }
    let found = found.map_err(refused)?;
    if let Some(optimum) = &found.optimum {
        folder.write(SCENARIO, |out| out.write_all(optimum.text.as_bytes()))?;
    }
    let summary = summary(&loaded.scenario.name, &found)?;
    folder.write(SUMMARY, |out| {
        serde_json::to_writer_pretty(&mut *out, &summary)?;
        writeln!(out)
    })?;
    let printed = if *as_json {
        serde_json::to_writer_pretty(&mut *out, &summary).map_err(io::Error::from).and_then(|()| writeln!(out))
    } else if *quiet {
        Ok(())
    } else {
        let other = loaded.texts.len() > 1 || !loaded.hashed.is_empty();
        print::end(&found, folder.path(), other.then_some(file.as_path()), out)
    };
    printed.map_err(Failure::standard_output)?;
    Ok(match found.ending {
        Ending::Converged => Outcome::Done,
        Ending::Infeasible => Outcome::NotMet,
        Ending::Stuck | Ending::OutOfRuns | Ending::NoStart | Ending::Stopped => Outcome::NotConverged,
    })
}

/// The designs as CSV: a column for each variable, SI.
fn table_of(keys: &[String], rows: &[Design], out: &mut dyn Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    let before = ["run", "search", "kind"].into_iter();
    let after = ["objective", "tightest", "margin", "verdict", "failure"];
    table.write_record(before.chain(keys.iter().map(String::as_str)).chain(after))?;
    let number = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
    for row in rows {
        let Design { run, search, kind, values, failure, objective, tightest, margin, verdict } = row;
        let kind = print::word(*kind).to_owned();
        let before = [run.to_string(), search.to_string(), kind];
        let words = |word: &Option<String>| word.clone().unwrap_or_default();
        let after = [number(*objective), words(tightest), number(*margin), words(verdict), words(failure)];
        table.write_record(before.iter().chain(values).chain(&after))?;
    }
    table.flush()
}

/// What was found, with the certificate.
fn summary(scenario: &str, found: &Optimisation) -> Result<Value, Failure> {
    let optimum = found.optimum.as_ref().map(|optimum| {
        let certificate = optimum.certificate.as_ref().map(|run| {
            let mut sheet = Vec::new();
            json::write_sheet(run, &mut sheet)?;
            let sheet: Value = serde_json::from_slice(&sheet)?;
            Ok::<_, io::Error>(json!({
                "text": SCENARIO,
                "sha256": sha256(optimum.text.as_bytes()),
                "status": run.status().word(),
                "sheet": sheet,
            }))
        });
        let values = found.keys.iter().zip(&found.units).zip(&optimum.values);
        let values = values.map(|((key, unit), value)| json!({ "key": key, "value": value, "unit": unit }));
        Ok::<_, io::Error>(json!({
            "run": optimum.run,
            "objective": optimum.objective,
            "values": values.collect::<Vec<_>>(),
            "certificate": certificate.transpose()?,
        }))
    });
    let optimum = optimum.transpose().map_err(Failure::system("write the certificate"))?;
    Ok(json!({
        "schema": 1,
        "program": PROGRAM,
        "scenario": scenario,
        "ending": found.ending,
        "counts": found.counts,
        "optimum": optimum,
    }))
}
