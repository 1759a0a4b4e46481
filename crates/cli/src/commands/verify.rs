//! `wireloom verify`: carries out a scenario and prints the sheet of its requirements.

use crate::arguments::VerifyArguments;
use crate::commands::run;
use crate::failure::{Failure, Outcome};
use crate::print::{sheet, summary};
use std::io::Write;
use wireloom::export::json;
use wireloom::result::Verdict;

/// Carries out a scenario, writes its files, and prints the sheet. Whether the run converged comes before the verdict:
/// values of a run that did not come to its end are not those of the whole assembly.
pub fn verify(arguments: &VerifyArguments, mut out: &mut dyn Write) -> Result<Outcome, Failure> {
    let finished = run::finished(&arguments.run(), out)?;
    let verdict = finished.run.verdict();
    let printed = if arguments.json {
        json::write_sheet(&finished.run, &mut out)
    } else if arguments.quiet {
        Ok(())
    } else {
        sheet::print(&finished.run, out)
            .and_then(|()| summary::notes(&finished.run.notes, finished.built, out))
            .and_then(|()| finished.files.iter().try_for_each(|line| writeln!(out, "{line}")))
    };
    printed.map_err(Failure::standard_output)?;
    match finished.outcome()? {
        Outcome::Done if verdict != Verdict::Pass => Ok(Outcome::NotMet),
        outcome => Ok(outcome),
    }
}
