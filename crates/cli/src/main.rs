//! The command `wireloom`: reads files, prints, writes results. Everything about harnesses is in the façade
//! `wireloom`.
//!
//! | code | meaning |
//! | --- | --- |
//! | 0 | done; for `run`: every increment converged |
//! | 1 | the input was refused: the scenario, the imported file or the command line |
//! | 2 | a run did not converge or was interrupted; all results so far are written |
//! | 3 | a file or folder could not be read or written, is damaged or in use by another run; or a plugin failed |
//! | 4 | `verify`: every increment converged, but a requirement that must be kept fails or is unresolved |

mod arguments;
mod commands;
mod extremes;
mod failure;
mod files;
mod interrupt;
mod messages;
mod plugin;
mod print;
mod program;
mod size;
mod trace;

use arguments::Arguments;
use clap::Parser;
use failure::Failure;
use plugin::{supervise, supervised};
use print::{diagnostics, terminal};
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(wish) => {
            // Help and version end with 0; anything else is refused input, whose exit code clap does not know.
            let _ = wish.print();
            return ExitCode::from(if wish.use_stderr() { failure::REFUSED } else { 0 });
        }
    };
    let mut out = terminal::Output::stdout();
    supervised::begin();
    let ended = supervise::carry_out(&arguments.command, &mut out).and_then(|elsewhere| {
        let code = match elsewhere {
            Some(code) => code,
            None => commands::carry_out(&arguments.command, &mut out)?.code(),
        };
        out.flush().map_err(Failure::standard_output)?;
        Ok(code)
    });
    let code = ended.unwrap_or_else(|failure| {
        diagnostics::show(&failure, &mut std::io::stderr());
        failure.code()
    });
    supervised::end();
    ExitCode::from(code)
}
