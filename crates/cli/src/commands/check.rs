//! `wireloom check`: all faults of scenarios.

use crate::failure::{Failure, Outcome};
use crate::files::load;
use crate::plugin::trust::Trust;
use crate::print::progress::Bar;
use crate::print::text::{counted, printable};
use crate::size;
use std::io::Write;
use std::path::PathBuf;

/// Checks every file, also after faults in others.
pub fn check(files: &[PathBuf], trust: &Trust, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut failures = vec![];
    for file in files {
        let bar = Bar::new(format!("checking {}", file.display()), true);
        let loaded = load::scenario(file, &[], trust);
        drop(bar);
        match loaded {
            Ok(load::Loaded { scenario, built, .. }) => {
                let steps = counted(scenario.steps.len(), "step", "steps");
                let mut print = || {
                    writeln!(out, "{}: OK ({}, {steps})", file.display(), size::words(&built.network))?;
                    let mut notes = built.notes.iter().chain(&built.sections);
                    notes.try_for_each(|note| writeln!(out, "note: {}", printable(note)))
                };
                print().map_err(Failure::standard_output)?;
            }
            Err(failure) => failures.push(failure),
        }
    }
    match failures.pop() {
        None => Ok(Outcome::Done),
        Some(only) if failures.is_empty() => Err(only),
        Some(last) => {
            failures.push(last);
            Err(Failure::Several(failures))
        }
    }
}
