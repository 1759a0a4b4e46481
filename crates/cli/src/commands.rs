//! The subcommands, one file each.

mod bench;
mod check;
mod compare;
mod devices;
mod explain;
mod export;
mod formboard;
mod identify;
mod import;
mod models;
mod optimise;
mod plugin;
mod report;
mod run;
mod schema;
mod sensitivities;
mod studio;
mod sweep;
mod verify;

use crate::arguments::{Command, Format, HarnessFile};
use crate::failure::{Failure, Outcome};
use crate::plugin::fault;
use crate::plugin::trust::Trust;
use std::io::Write;

/// Carries out a subcommand.
pub fn carry_out(command: &Command, out: &mut dyn Write) -> Result<Outcome, Failure> {
    match command {
        Command::Run(arguments) => run::run(arguments, out),
        Command::Verify(arguments) => verify::verify(arguments, out),
        Command::Check { files, allowed } => check::check(files, &Trust::to_check(allowed), out),
        Command::Studio(arguments) => studio::studio(arguments, out),
        Command::Compare(arguments) => compare::compare(arguments, out),
        Command::Sweep(arguments) => sweep::sweep(arguments, out),
        Command::SweepProcess(arguments) => sweep::process::compute(arguments, out),
        Command::Sensitivities(arguments) => sensitivities::sensitivities(arguments, out),
        Command::Identify(arguments) => identify::identify(arguments, out),
        Command::Optimise(arguments) => optimise::optimise(arguments, out),
        Command::Report { results, output } => report::report(results, output.as_deref(), out),
        Command::Schema => schema::schema(out),
        Command::Plugin { task } => plugin::plugin(task, out),
        Command::PluginFault(fault) => fault::report(fault, out),
        Command::Models { allowed } => models::list(allowed, out),
        Command::Devices => devices::list(out),
        Command::Explain { key, allowed } => explain::explain(key, allowed, out),
        Command::Import { format: Format::Kbl(arguments) } => import::harness(arguments, &import::KBL, out),
        Command::Import { format: Format::Vec(arguments) } => import::harness(arguments, &import::VEC, out),
        Command::Import { format: Format::Step(arguments) } => import::step::step(arguments, out),
        Command::Export { format: HarnessFile::Kbl(arguments) } => export::kbl(arguments, out),
        Command::Formboard(arguments) => formboard::formboard(arguments, out),
        Command::Bench(arguments) => bench::bench(arguments, out),
    }
}
