//! The command `wireloom`: reads files, prints, writes results. What it knows about harnesses it asks of the façade.
//!
//! | code | meaning |
//! | --- | --- |
//! | 0 | done; for `run`: every increment converged |
//! | 1 | the input was refused: the scenario, the imported file or the command line |
//! | 2 | `run` did not converge or was interrupted (everything computed is written all the same), or `compare` met a run that did not converge |
//! | 3 | a file or folder could not be read or written, is damaged, or another run is writing there; or a plugin failed |

mod arguments;
mod bench;
mod check;
mod compare;
mod devices;
mod diagnostics;
mod differences;
mod extremes;
mod failure;
mod folder;
mod import;
mod interrupt;
mod length;
mod load;
mod operations;
mod own;
mod place;
mod plugin;
mod plugin_check;
mod plugin_check_joint;
mod plugin_fault;
mod plugin_new;
mod plugins;
mod program;
mod progress;
mod redirect;
mod results;
mod run;
mod saved;
mod size;
mod studio;
mod studio_state;
mod summary;
mod sweep;
mod swept;
mod terminal;
mod variants;
mod vocabulary;

use arguments::{Arguments, Command, Format};
use clap::Parser;
use failure::{Failure, Outcome};
use plugins::Trust;
use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(wish) => {
            // Help and version are wishes fulfilled; anything else is refused input, whose code clap does not know.
            let _ = wish.print();
            return ExitCode::from(if wish.use_stderr() { failure::REFUSED } else { 0 });
        }
    };
    let mut out = terminal::Output::stdout();
    let ended = follow(&arguments.command, &mut out).and_then(|outcome| {
        out.flush().map_err(Failure::standard_output)?;
        Ok(outcome)
    });
    match ended {
        Ok(outcome) => ExitCode::from(outcome.code()),
        Err(failure) => {
            diagnostics::show(&failure, &mut std::io::stderr());
            ExitCode::from(failure.code())
        }
    }
}

fn follow(command: &Command, out: &mut dyn Write) -> Result<Outcome, Failure> {
    match command {
        Command::Run(arguments) => run::run(arguments, out),
        Command::Check { files, allowed } => check::check(files, &Trust::to_look(allowed), out),
        Command::Studio(arguments) => studio::studio(arguments, out),
        Command::Compare(arguments) => compare::compare(arguments, out),
        Command::Sweep(arguments) => sweep::sweep(arguments, out),
        Command::Report { results, output } => sweep::report(results, output.as_deref(), out),
        Command::Schema => {
            let schema = wireloom::scenario::schema(&wireloom::registry());
            writeln!(out, "{schema:#}").map_err(Failure::standard_output)?;
            Ok(Outcome::Done)
        }
        Command::Plugin { task } => plugin::plugin(task, out),
        Command::PluginFault(fault) => Err(plugin_fault::report(fault)),
        Command::Models { allowed } => vocabulary::list(allowed, out),
        Command::Devices => devices::list(out),
        Command::Explain { key, allowed } => vocabulary::explain_key(key, allowed, out),
        Command::Import { format: Format::Kbl(arguments) } => import::kbl(arguments, out),
        Command::Bench(arguments) => bench::bench(arguments, out),
    }
}
