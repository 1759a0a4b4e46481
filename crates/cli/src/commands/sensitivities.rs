//! `wireloom sensitivities`: derivatives of results by numbers of a scenario.

use crate::arguments::SensitivitiesArguments;
use crate::failure::{Failure, Outcome};
use crate::files::folder;
use crate::files::load::{self, Beside};
use crate::interrupt;
use crate::plugin::trust::Trust;
use crate::print::sensitivities;
use std::io::{self, Write};
use wireloom::sensitivity::{NoAnswer, Question, Source, Study};

/// Carries out the scenario up to a step, and prints derivatives at its end.
pub fn sensitivities(arguments: &SensitivitiesArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let SensitivitiesArguments { file, of, by, step, json, out: path, allowed } = arguments;
    let loaded = load::scenario(file, &[], &Trust::to_run(allowed))?;
    let text = loaded.texts[0].1.as_str();
    let files = Beside::of(file);
    interrupt::listen();
    let monitor = interrupt::monitor().clone();
    let source = Source { monitor, ..Source::new(text, &files, &loaded.registry) };
    let question = Question { of, by, step: step.as_deref() };
    let found = match Study::new(source).and_then(|mut study| study.answer(&question)) {
        Ok(found) => found,
        Err(NoAnswer::Faults(faults)) => {
            return Err(Failure::Refused(vec![load::refusal(file, text.to_owned(), faults)]));
        }
        Err(NoAnswer::Part(fault)) => return Err(Failure::Part(fault)),
        Err(refused @ NoAnswer::Question(_)) => return Err(Failure::Input(refused.to_string())),
        Err(none @ (NoAnswer::NotConverged { .. } | NoAnswer::NotDifferentiable { .. } | NoAnswer::Stopped)) => {
            // Standard output is for derivatives alone.
            let _ = writeln!(io::stderr(), "{none}");
            return Ok(Outcome::NotConverged);
        }
    };
    let print = |out: &mut dyn Write| {
        if *json {
            serde_json::to_writer_pretty(&mut *out, &found)?;
            writeln!(out)
        } else {
            sensitivities::print(&found, out)
        }
    };
    match path {
        Some(path) => folder::write(path, |out| print(out))?,
        None => print(out).map_err(Failure::standard_output)?,
    }
    Ok(Outcome::Done)
}
