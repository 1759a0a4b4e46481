//! `wireloom import step`: a STEP file to meshes and the obstacles that place them.

use crate::arguments::StepArguments;
use crate::failure::{Failure, Outcome};
use crate::files::folder::Folder;
use crate::files::load;
use crate::interrupt;
use crate::print::progress::Bar;
use std::io::{self, Write};
use std::path::Path;
use wireloom::step::{Reader, StepError, Surroundings, surroundings};

/// The part of a scenario with the obstacles.
const OBSTACLES: &str = "obstacles.toml";

/// Imports a STEP file.
pub fn step(arguments: &StepArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let StepArguments { file, output, deflection, without, time_limit } = arguments;
    interrupt::listen();
    let bytes = load::bytes(file)?;
    let reader = Reader::from_environment(interrupt::monitor().clone()).with_time_limit(time_limit.as_secs().max(1));
    let bar = Bar::new(format!("reading {}", file.display()), true);
    let assembly = match reader.read(&bytes, *deflection) {
        Err(StepError::Interrupted) => {
            drop(bar);
            writeln!(out, "interrupted; nothing is written").map_err(Failure::standard_output)?;
            return Ok(Outcome::NotConverged);
        }
        read => read.map_err(|error| failure(file, &error))?,
    };
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let found = surroundings(&assembly, without, *deflection, &slashes(output)?, &name);
    let found = found.map_err(|error| failure(file, &error))?;
    drop(bar);
    let Surroundings { meshes, triangles, bodies, obstacles, notes } = found;
    let notes: String = notes.iter().map(|note| format!("found: {note}\n")).collect();
    // If standard error is closed, the import goes on.
    let _ = io::stderr().write_all(notes.as_bytes());
    let mut folder = Folder::create(output)?;
    folder.clear()?;
    for (name, bytes) in &meshes {
        folder.write(name, |file| file.write_all(bytes))?;
    }
    folder.write(OBSTACLES, |file| file.write_all(obstacles.as_bytes()))?;
    let count = |n: usize, what: &str| if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") };
    let meshes = match meshes.len() {
        1 => "1 mesh".to_owned(),
        n => format!("{n} meshes"),
    };
    let path = output.join(OBSTACLES);
    writeln!(
        out,
        "wrote {} ({}, {meshes}, {})",
        path.display(),
        count(bodies, "obstacle"),
        count(triangles, "triangle")
    )
    .and_then(|()| match reader.cache() {
        Some(cache) => writeln!(out, "what was read is kept in {}", cache.display()),
        None => Ok(()),
    })
    .map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}

/// The path with `/` between its folders, as scenarios have it.
fn slashes(path: &Path) -> Result<String, Failure> {
    let parts: Option<Vec<&str>> = path.iter().map(|part| part.to_str()).collect();
    let parts = parts.ok_or_else(|| Failure::Input(format!("{} is not UTF-8 text", path.display())))?;
    Ok(parts.join("/").replacen("//", "/", 1))
}

/// A failure, with the place in the file and the remedy.
fn failure(file: &Path, error: &StepError) -> Failure {
    let line = error.line().map(|line| format!(":{line}")).unwrap_or_default();
    let words = format!("{}{line}: {error}\n  help: {}", file.display(), error.help());
    if error.is_refusal() { Failure::Input(words) } else { Failure::Missing(words) }
}
