//! `wireloom run`: from a scenario to its results.

use crate::arguments::RunArguments;
use crate::extremes::Extremes;
use crate::failure::{Failure, Outcome};
use crate::folder::Folder;
use crate::progress::Bar;
use crate::results::Results;
use crate::{interrupt, load, size, summary};
use std::io::Write;
use std::path::{Path, PathBuf};
use wireloom::core::{Run, Status};
use wireloom::scenario::Built;
use wireloom::solve::Control;

/// Where results go that nobody gave a place.
const OUT: &str = "out";

/// Carries out a scenario. The folder is tried before the work begins; nothing is printed before the files are
/// written.
pub fn run(arguments: &RunArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let registry = wireloom::registry();
    let (scenario, built) = load::scenario(&arguments.file, arguments.minimiser.as_deref(), &registry)?;
    let folder = Folder::create(&arguments.out.clone().unwrap_or_else(|| default_folder(&arguments.file)))?;
    let mut results = Results::new(folder, scenario.output);
    let (size, notes) = (size::words(&built.network), built.notes.len());
    let (run, extremes) = follow(built, &mut results, !arguments.quiet)?;
    results.finish(&run)?;
    if !arguments.quiet {
        let mut print = || {
            writeln!(out, "{}: {} ({size})\n", summary::printable(&run.scenario), run.status.word())?;
            summary::print(&run, &extremes, notes, out)?;
            writeln!(out, "wrote {}", results.words())
        };
        print().map_err(Failure::standard_output)?;
    }
    Ok(if run.status == Status::Converged { Outcome::Done } else { Outcome::NotConverged })
}

/// The run, watched. A file that cannot be written stops it; the run as far as it went is then still written, if that
/// can be.
fn follow(built: Built, results: &mut Results, shown: bool) -> Result<(Run, Extremes), Failure> {
    let increments: usize = built.schedule.steps.iter().map(|step| step.increments).sum();
    let bar = Bar::new(increments.max(1), shown);
    let mut extremes = Extremes::default();
    let mut failure = None;
    interrupt::listen();
    let run = wireloom::run(built, &mut |progress, end| {
        bar.advance(progress);
        extremes.see(end);
        failure = results.increment(progress, end).err();
        if interrupt::asked() {
            bar.say("interrupted");
        }
        if failure.is_some() || interrupt::asked() { Control::Stop } else { Control::Continue }
    });
    match failure {
        None => Ok((run, extremes)),
        Some(failure) => {
            // The first failure is the one to report.
            let _ = results.finish(&run);
            Err(failure)
        }
    }
}

/// `out/first` for `scenarios/first.toml`.
fn default_folder(file: &Path) -> PathBuf {
    Path::new(OUT).join(file.file_stem().unwrap_or_default())
}
