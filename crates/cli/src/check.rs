//! `wireloom check`: all faults of scenarios, and nothing else.

use crate::failure::{Failure, Outcome};
use crate::plugins::Trust;
use crate::{load, size, summary};
use std::io::Write;
use std::path::PathBuf;

/// Checks every file, whatever is wrong with those before it.
pub fn check(files: &[PathBuf], trust: &Trust, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut refusals = vec![];
    for file in files {
        match load::scenario(file, &[], trust) {
            Ok(load::Loaded { scenario, built, .. }) => {
                let steps = size::counted(scenario.steps.len(), "step", "steps");
                let mut print = || {
                    writeln!(out, "{}: OK ({}, {steps})", file.display(), size::words(&built.network))?;
                    let mut notes = built.notes.iter().chain(&built.sections);
                    notes.try_for_each(|note| writeln!(out, "note: {}", summary::printable(note)))
                };
                print().map_err(Failure::standard_output)?;
            }
            Err(Failure::Refused(more)) => refusals.extend(more),
            Err(other) => return Err(other),
        }
    }
    if refusals.is_empty() { Ok(Outcome::Done) } else { Err(Failure::Refused(refusals)) }
}
