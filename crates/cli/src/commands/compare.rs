//! `wireloom compare`: differences between results of several runs.

mod variants;

use crate::arguments::CompareArguments;
use crate::commands::import::HarnessFormat;
use crate::failure::{Failure, Outcome};
use crate::files::folder;
use crate::files::load::{self, Loaded};
use crate::files::results::{FIELDS, RESULT};
use crate::plugin::trust::Trust;
use crate::print::differences;
use crate::print::progress::Bar;
use crate::program::{PROGRAM, machine, now};
use crate::trace::Trace;
use crate::{interrupt, size};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use variants::Variant;
use wireloom::compare::{Case, Comparison, Ending, Trend, convergence};
use wireloom::export::json;
use wireloom::export::report::{ComparisonPage, write_comparison};
use wireloom::plugins::open_regular_file;
use wireloom::session::{Monitor, Observer, Progress};
use wireloom::{Control, Run, Status, StepResult};

/// Compares folders with results and scenarios, which are carried out, or one scenario with several settings.
pub fn compare(arguments: &CompareArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let variants = variants::variants(arguments)?;
    let trust = Trust::to_run(&arguments.allowed);
    let refused = |message: &str| Err(Failure::Input(message.into()));
    if !arguments.variants.is_empty() && !matches!(&arguments.inputs[..], [file] if HarnessFormat::of(file).is_some()) {
        return refused("--variants chooses modules of one KBL or VEC file (.kbl, .xml, .vec)");
    }
    let bar = Bar::new("reading", !arguments.quiet && arguments.trace.verbose == 0);
    let mut trace = Trace::begin(&arguments.trace)?;
    let mut wanted = arguments.inputs.len().max(variants.len());
    let cases = match (&arguments.inputs[..], variants.len()) {
        ([file], _) if let Some(format) = HarnessFormat::of(file) => {
            let all = variants::of_file(file, format, &arguments.variants)?;
            wanted = all.len() * variants.len().max(1);
            if wanted < 2 {
                return refused("nothing to compare it with: give two or more --variants");
            }
            let trials = all.into_iter().map(|(name, text)| (name, Some(text)));
            tried(file, &trials.collect::<Vec<_>>(), &variants, &trust, &bar)?
        }
        ([file], 0 | 1) => {
            // A value that is wrong is told before that one is not enough.
            if let [Variant { settings, .. }] = &variants[..]
                && is_scenario(file)
            {
                load::scenario(file, settings, &trust)?;
            }
            return refused(
                "nothing to compare it with: \
                 give two or more folders or scenarios, or options such as --segments 20,40,80",
            );
        }
        ([file], _) if is_scenario(file) => tried(file, &[(String::new(), None)], &variants, &trust, &bar)?,
        (_, 0) => gathered(&arguments.inputs, &trust, &bar)?,
        _ => return refused("options such as --segments need one scenario (.toml), not results or several scenarios"),
    };
    drop(bar);
    trace.finish()?;
    let interrupted = cases.len() < wanted;
    if interrupted && !arguments.json {
        writeln!(out, "interrupted: {} of {wanted} runs are complete\n", cases.len())
            .map_err(Failure::standard_output)?;
    }
    if cases.is_empty() {
        return Ok(Outcome::NotConverged);
    }
    // The reference is the finest mesh, otherwise the first.
    let finest = arguments.segments.iter().take(cases.len()).enumerate().max_by_key(|(_, n)| **n);
    let only = variants.len() == arguments.segments.len();
    let reference = (!variants.is_empty()).then(|| finest.filter(|_| only).map_or(0, |(k, _)| k));
    let comparison = Comparison::of(&cases, reference, arguments.tolerance);
    let trends = trends(arguments, &cases);
    let alike = [&arguments.joint, &arguments.rod, &arguments.set].iter().all(|tried| tried.is_empty())
        && arguments.segments.is_empty()
        && !arguments.inputs.iter().any(|input| HarnessFormat::of(input).is_some());
    // Results are printed before the file is written, which may fail.
    let print = |mut out: &mut dyn Write| {
        if arguments.json {
            json::write_comparison(&cases, &comparison, &mut out)
        } else {
            differences::print(&cases, &comparison, &trends, alike, out)
        }
    };
    match &arguments.out {
        Some(path) => folder::write(path, |out| print(out))?,
        None => print(out).map_err(Failure::standard_output)?,
    }
    if let Some(path) = &arguments.report {
        let page = ComparisonPage {
            title: &title(arguments),
            cases: &cases,
            comparison: &comparison,
            trends: &trends,
            alike,
            program: PROGRAM,
            machine: &machine(),
            written: &now(),
        };
        folder::write(path, |out| write_comparison(&page, out))?;
    }
    let converged = cases.iter().all(|case| case.ending.converged);
    Ok(if converged && !interrupted { Outcome::Done } else { Outcome::NotConverged })
}

/// Title of the page: the scenario, or all results.
fn title(arguments: &CompareArguments) -> String {
    match &arguments.inputs[..] {
        [file] => file.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        inputs => names(inputs).join(", "),
    }
}

pub fn is_scenario(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "toml")
}

/// Convergence under mesh refinement, where three or more meshes are compared and nothing else.
fn trends(arguments: &CompareArguments, cases: &[Case]) -> Vec<Trend> {
    if arguments.segments.len() < 3 || arguments.segments.len() != cases.len() {
        return vec![];
    }
    let mut meshes: Vec<(usize, &Ending)> =
        arguments.segments.iter().copied().zip(cases.iter().map(|case| &case.ending)).collect();
    meshes.sort_by_key(|(segments, _)| *segments);
    convergence(&meshes)
}

/// Each of the texts, or that of the file, with each of the variants, until an interruption. All are checked before the
/// first is carried out.
fn tried(
    file: &Path,
    texts: &[(String, Option<String>)],
    variants: &[Variant],
    trust: &Trust,
    bar: &Bar,
) -> Result<Vec<Case>, Failure> {
    let as_it_is = [Variant::default()];
    let variants = if variants.is_empty() { &as_it_is[..] } else { variants };
    let mut loaded = Vec::new();
    for (name, text) in texts {
        for variant in variants {
            let text = text.clone().map_or_else(|| load::text(file), Ok)?;
            let names = [name.as_str(), &variant.name].into_iter().filter(|name| !name.is_empty());
            loaded
                .push((names.collect::<Vec<_>>().join(", "), load::scenario_of(file, text, &variant.settings, trust)?));
        }
    }
    let cases = loaded.into_iter().map(|(name, loaded)| {
        let ended = carry_out(loaded, &name, bar)?;
        ended.map(|run| case(name, Ending::of(&run))).transpose()
    });
    until_interrupted(cases)
}

/// Results of folders and of scenarios, until an interruption. All are read before the first is carried out.
fn gathered(inputs: &[PathBuf], trust: &Trust, bar: &Bar) -> Result<Vec<Case>, Failure> {
    let given = inputs.iter().map(|input| {
        bar.say(format!("reading {}", input.display()));
        Ok(if is_scenario(input) {
            Given::Scenario(Box::new(load::scenario(input, &[], trust)?))
        } else {
            Given::Result(Box::new(read(input)?))
        })
    });
    let given = given.collect::<Result<Vec<_>, Failure>>()?;
    let cases = given.into_iter().zip(names(inputs)).map(|(given, name)| {
        let ended = match given {
            Given::Scenario(loaded) => carry_out(*loaded, &name, bar)?.map(|run| Ending::of(&run)),
            Given::Result(ending) => Some(*ending),
        };
        ended.map(|ending| case(name, ending)).transpose()
    });
    until_interrupted(cases)
}

/// An input.
enum Given {
    Scenario(Box<Loaded>),
    Result(Box<Option<Ending>>),
}

/// The cases before the first `None`.
fn until_interrupted(cases: impl Iterator<Item = Result<Option<Case>, Failure>>) -> Result<Vec<Case>, Failure> {
    cases.map_while(Result::transpose).collect()
}

fn case(name: String, ending: Option<Ending>) -> Result<Case, Failure> {
    let Some(ending) = ending else {
        return Err(Failure::Input(format!("{name}: the run has no equilibrium")));
    };
    Ok(Case { name, ending })
}

/// The last equilibrium of a `result.json`, or of that of a folder.
fn read(path: &Path) -> Result<Option<Ending>, Failure> {
    let file = result_of(path);
    let fields = || open_regular_file(&file.with_file_name(FIELDS), u64::MAX);
    json::read_with(load::open(&file)?, fields).map_err(no_result(&file))
}

/// The result in a folder, or the file itself.
pub fn result_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(RESULT) } else { path.to_owned() }
}

/// A result that could not be read.
pub fn no_result(file: &Path) -> impl Fn(io::Error) -> Failure {
    move |error| match error.kind() {
        io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => {
            Failure::Input(format!("{} is no result of `wireloom run`: {error}", file.display()))
        }
        _ => Failure::io("read", file)(error),
    }
}

/// Carries out a scenario; nothing is written. `None` where it was interrupted.
pub fn carry_out(loaded: Loaded, name: &str, bar: &Bar) -> Result<Option<Run>, Failure> {
    let loaded = loaded.with_mesh(bar)?;
    let increments = size::increments(&loaded.built);
    let large = size::estimate(&loaded.built.network, increments)?.map(|words| format!(" ({words})"));
    bar.count(format!("{name}{}", large.unwrap_or_default()), "increments", increments, 0);
    let span = tracing::info_span!("case", name);
    let run = span.in_scope(|| wireloom::run_observed(loaded.built, None, &mut Watcher(bar)));
    if run.status() == Status::Interrupted {
        return Ok(None);
    }
    if let Some(fault) = run.fault() {
        return Err(Failure::Part(fault.clone()));
    }
    Ok(Some(run))
}

/// Shows the progress of a run.
struct Watcher<'a>(&'a Bar);

impl Observer for Watcher<'_> {
    fn increment(&mut self, _: &Progress, _: &StepResult, _: bool) -> Control {
        self.0.one();
        Control::Continue
    }

    fn monitor(&self) -> Monitor {
        interrupt::monitor().clone()
    }
}

/// The shortest suffixes of the paths that differ, without `.toml` and `result.json`.
fn names(paths: &[PathBuf]) -> Vec<String> {
    let parts: Vec<Vec<String>> = paths
        .iter()
        .map(|path| {
            let path = if path.ends_with(RESULT) { path.parent().unwrap_or(path) } else { path };
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
