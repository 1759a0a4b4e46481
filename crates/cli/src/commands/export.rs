//! `wireloom export`: results back into harness files. Notes go to standard error.

use super::compare::{carry_out, is_scenario, no_result, result_of};
use crate::arguments::KblExportArguments;
use crate::failure::{Failure, Outcome};
use crate::files::folder;
use crate::files::load;
use crate::files::results::FIELDS;
use crate::plugin::trust::Trust;
use crate::print::exported;
use crate::print::progress::Bar;
use crate::print::text::found;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use wireloom::Run;
use wireloom::export::json::Opened;
use wireloom::kbl::{NotExported, export};
use wireloom::plugins::open_regular_file;

/// Writes a result into a copy of its KBL file.
pub fn kbl(arguments: &KblExportArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let KblExportArguments { result, output, tolerance, json, .. } = arguments;
    let bar = Bar::new(format!("reading {}", result.display()), !json);
    let Some(run) = ended(arguments, &bar)? else { return Ok(Outcome::NotConverged) };
    let original = original(arguments, &run)?;
    let text = load::text(&original)?;
    if let (Ok(from), Ok(to)) = (fs::canonicalize(&original), fs::canonicalize(output))
        && from == to
    {
        let place = output.display();
        return Err(Failure::Input(format!("{place} is the file that is read: give another name with --output")));
    }
    bar.say(format!("fitting {}", original.display()));
    let written = export(&text, &run, *tolerance).map_err(|reason| {
        let place = match reason {
            NotExported::OtherFile { .. } | NotExported::Export(_) => original.display(),
            _ => result.display(),
        };
        Failure::Input(format!("{place}: {reason}"))
    })?;
    folder::write(output, |file| file.write_all(written.text.as_bytes()))?;
    drop(bar);
    let notes: String = written.notes.iter().map(|own| found(&own.what, &own.items, " with --json")).collect();
    // If standard error is closed, the work goes on.
    let _ = io::stderr().write_all(notes.as_bytes());
    let print = if *json { exported::json } else { exported::print };
    print(&written, *tolerance, output, out).map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}

/// The run with its last equilibrium: read, or carried out. `None` where it was interrupted.
fn ended(arguments: &KblExportArguments, bar: &Bar) -> Result<Option<Run>, Failure> {
    let path = &arguments.result;
    if is_scenario(path) {
        let loaded = load::scenario(path, &[], &Trust::to_run(&arguments.allowed))?;
        return carry_out(loaded, &path.display().to_string(), bar);
    }
    let file = result_of(path);
    let fields = || open_regular_file(&file.with_file_name(FIELDS), u64::MAX);
    let mut opened = Opened::open(load::open(&file)?, fields).map_err(no_result(&file))?;
    let last = match opened.len().checked_sub(1) {
        Some(last) => opened.step(last).map_err(no_result(&file))?,
        None => None,
    };
    Ok(Some(Run { steps: last.into_iter().collect(), ..opened.run }))
}

/// The KBL file: as given, or that of the name that the scenario has, in the current folder or beside the result.
fn original(arguments: &KblExportArguments, run: &Run) -> Result<PathBuf, Failure> {
    if let Some(path) = &arguments.kbl {
        return Ok(path.clone());
    }
    let result = arguments.result.display();
    let Some(kbl) = &run.identities.kbl else {
        return Err(Failure::Input(format!("{result}: {}", NotExported::NoFile)));
    };
    let name = Path::new(&kbl.file).file_name().unwrap_or_default();
    let beside =
        if arguments.result.is_dir() { arguments.result.join(name) } else { arguments.result.with_file_name(name) };
    [PathBuf::from(name), beside].into_iter().find(|path| path.is_file()).ok_or_else(|| {
        let file = &kbl.file;
        Failure::Input(format!("{result}: `{file}` is neither here nor beside it: say with --kbl where it is"))
    })
}
