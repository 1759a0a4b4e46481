//! `wireloom compare`: results of runs beside each other.

use crate::arguments::CompareArguments;
use crate::failure::{Failure, Outcome};
use crate::load::{self, Loaded};
use crate::progress::Bar;
use crate::{differences, interrupt, run};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use wireloom::core::Run;
use wireloom::export::comparison::{Case, Comparison};
use wireloom::export::ending::Ending;
use wireloom::export::json;
use wireloom::solve::Control;

/// Compares folders with results, and scenarios that are carried out for the purpose.
pub fn compare(arguments: &CompareArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    if arguments.inputs.len() < 2 {
        return Err(Failure::Input("nothing to compare it with: give two or more folders or scenarios".into()));
    }
    let registry = wireloom::registry();
    let names = names(&arguments.inputs);
    interrupt::listen();
    let mut cases = vec![];
    for (input, name) in arguments.inputs.iter().zip(names) {
        let ending = if input.extension().is_some_and(|extension| extension == "toml") {
            let loaded = load::scenario(input, None, &registry)?;
            Ending::of(&carry_out(loaded, !arguments.quiet))
        } else {
            read(input)?
        };
        if interrupt::asked() {
            return Err(Failure::Input("interrupted before all scenarios were carried out".into()));
        }
        let Some(ending) = ending else {
            return Err(Failure::Input(format!("{}: the run has come to no equilibrium", input.display())));
        };
        cases.push(Case { name, ending });
    }
    let comparison = Comparison::of(&cases, None, arguments.tolerance);
    differences::print(&cases, &comparison, out).map_err(Failure::standard_output)?;
    let converged = cases.iter().all(|case| case.ending.converged);
    Ok(if converged { Outcome::Done } else { Outcome::NotConverged })
}

/// The end of the run whose results lie in a folder, or in a file.
fn read(path: &Path) -> Result<Option<Ending>, Failure> {
    let file = if path.is_dir() { path.join(crate::results::RESULT) } else { path.to_owned() };
    let input = File::open(&file).map_err(Failure::io("read", &file))?;
    json::read(input).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
            Failure::Input(format!("{} is no result of `wireloom run`: {error}", file.display()))
        }
        _ => Failure::io("read", &file)(error),
    })
}

/// Carries a scenario out; nothing is written.
fn carry_out(loaded: Loaded, shown: bool) -> Run {
    let bar = Bar::new(run::increments(&loaded.built), 0, shown);
    wireloom::run(loaded.built, &mut |progress, _| {
        bar.advance(progress);
        if interrupt::asked() { Control::Stop } else { Control::Continue }
    })
}

/// The shortest ends of the paths that tell them apart, without `.toml` and `result.json`.
fn names(paths: &[PathBuf]) -> Vec<String> {
    let parts: Vec<Vec<String>> = paths
        .iter()
        .map(|path| {
            let path = if path.ends_with(crate::results::RESULT) { path.parent().unwrap_or(path) } else { path };
            path.with_extension("").components().map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
        })
        .collect();
    let last = |parts: &[String], n: usize| parts[parts.len().saturating_sub(n)..].join("/");
    let longest = parts.iter().map(Vec::len).max().unwrap_or(1);
    let tells = |n: &usize| {
        let names: std::collections::BTreeSet<String> = parts.iter().map(|parts| last(parts, *n)).collect();
        names.len() == parts.len()
    };
    match (1..=longest).find(tells) {
        Some(n) => parts.iter().map(|parts| last(parts, n)).collect(),
        None => paths.iter().enumerate().map(|(k, path)| format!("{} ({})", path.display(), k + 1)).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_as_short_as_may_be() {
        let names = |paths: &[&str]| names(&paths.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(names(&["out/a", "out/b/", "c.toml"]), ["a", "b", "c"]);
        assert_eq!(names(&["1/a/result.json", "2/a"]), ["1/a", "2/a"]);
        assert_eq!(names(&["a", "a"]), ["a (1)", "a (2)"]);
    }
}
