//! `wireloom run`: carries out a scenario, or resumes an interrupted run.

mod job;
mod watcher;

use crate::arguments::RunArguments;
use crate::extremes::Extremes;
use crate::failure::{Failure, Outcome};
use crate::files::load::{Beside, Loaded};
use crate::files::page;
use crate::files::results::Results;
use crate::files::swept::Swept;
use crate::plugin::crash::CrashReport;
use crate::plugin::load::record;
use crate::plugin::trust::Trust;
use crate::print::progress::Bar;
use crate::print::summary;
use crate::size::increments;
use crate::trace::Trace;
use crate::{interrupt, size};
use job::Job;
use std::io::{self, Write};
use std::path::Path;
use watcher::Watcher;
use wireloom::export::format::Surroundings;
use wireloom::scenario::settings::Setting;
use wireloom::sensitivity::{self, Source};
use wireloom::{Registry, Run, Status, result};
use wireloom_studio::replay::Recorder;

/// A run that has ended, and whose files are written.
pub struct Finished {
    pub run: Run,
    /// Nodes and parts of the harness, in words.
    pub size: String,
    /// Number of its notes that were known before it began.
    pub built: usize,
    extremes: Extremes,
    /// The files, and what can be done with them: a line each.
    pub files: Vec<String>,
}

impl Finished {
    /// How the command ends.
    pub fn outcome(self) -> Result<Outcome, Failure> {
        match self.run.outcome {
            result::Outcome::Fault(fault) => Err(Failure::Part(fault)),
            result::Outcome::Graded(Status::Converged) => Ok(Outcome::Done),
            result::Outcome::Graded(_) => Ok(Outcome::NotConverged),
        }
    }
}

/// Carries out a scenario, or resumes a run. Nothing is printed before the files are written.
pub fn run(arguments: &RunArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let finished = finished(arguments, out)?;
    if !arguments.quiet {
        let Finished { run, size, built, extremes, files } = &finished;
        let mut print = || {
            summary::print(run, size, extremes, *built, out)?;
            files.iter().try_for_each(|line| writeln!(out, "{line}"))
        };
        print().map_err(Failure::standard_output)?;
    }
    finished.outcome()
}

/// Carries out a scenario, or resumes a run, and writes its files. The folder is tested before the work begins.
pub fn finished(arguments: &RunArguments, out: &mut dyn Write) -> Result<Finished, Failure> {
    let trust = Trust::to_run(&arguments.allowed);
    let what = arguments.resume.as_deref().or(arguments.file.as_deref()).unwrap_or(Path::new(""));
    let bar = Bar::new(format!("reading {}", what.display()), !arguments.quiet);
    let job = match &arguments.resume {
        Some(folder) => Job::resume(folder, &trust, &bar)?,
        None => Job::begin(arguments, &trust, &bar)?,
    };
    drop(bar);
    if let Some(words) = job.size.as_ref().filter(|_| !arguments.quiet) {
        // If standard error is closed, nothing is lost.
        let _ = writeln!(io::stderr(), "{words}");
    }
    let mut trace = Trace::begin(&arguments.trace)?;
    let ended = carry_out(arguments, job, out);
    // Of a run that failed there is a trace, too.
    let traced = trace.finish();
    ended.and_then(|finished| traced.map(|()| finished))
}

/// Finds what lengths and places do to the requirements; a note says why where that is not known.
fn find_sensitivities(run: &mut Run, file: &Path, text: String, (registry, settings): (&Registry, &[Setting])) {
    if !settings.is_empty() {
        let why =
            "sensitivities of the requirements are those of the file, and values were set beside it: none were found";
        run.notes.push(why.to_owned());
        return;
    }
    let files = Beside::of(file);
    let source = Source { monitor: interrupt::monitor().clone(), ..Source::new(text, &files, registry) };
    sensitivity::add_sensitivities(run, source);
}

/// Carries out a run that is ready to begin.
fn carry_out(arguments: &RunArguments, job: Job, out: &mut dyn Write) -> Result<Finished, Failure> {
    let shown = !arguments.quiet && arguments.trace.verbose == 0;
    let bar = Bar::new("finding the initial equilibrium", shown);
    let provenance = job.loaded.provenance();
    let Job {
        file,
        loaded: Loaded { scenario, built, texts, plugins, registry, settings, .. },
        folder,
        keeper,
        standing,
        resumed,
        ..
    } = job;
    let place = folder.path().to_path_buf();
    let steps: Vec<String> = built.schedule.steps.iter().map(|step| step.name.clone()).collect();
    let time_limit = wireloom::scenario::plugins(&texts[0].1).time_limit;
    let crash_report = (!plugins.is_empty()).then(|| CrashReport::new(&place, steps.clone(), time_limit));
    let (size, notes) = (size::words(&built.network), built.notes.len());
    let text = scenario.output.sensitivities.then(|| texts[0].1.clone());
    let scene = page::keep_scene(folder.own(), &built)?;
    bar.count("finding the initial equilibrium", "increments", increments(&built), standing.times.len());
    let mut watcher = Watcher {
        bar,
        steps,
        swept: Swept::of(&scenario.output, &built),
        extremes: standing.extremes,
        results: Results::new(
            folder,
            scenario.output,
            texts,
            provenance,
            Surroundings::of_run(built.network.obstacles.clone(), &built.schedule),
            built.schedule.identities.clone(),
            standing.times,
        ),
        keeper,
        page: arguments.page.as_ref().map(|_| Recorder::new(scene)),
        failure: None,
        crash_report,
    };
    let mut run = wireloom::run_observed(built, resumed, &mut watcher);
    run.plugins = plugins.iter().map(record).collect();
    run.notes.extend(wireloom::plugins::notes());
    let Watcher { bar, extremes, mut results, swept, keeper, page, failure, .. } = watcher;
    bar.say("comparing with the drawn start");
    run.drawn_start = wireloom::compare_with_drawn_start(&scenario, &run, &registry, interrupt::monitor());
    if let Some(text) = text {
        bar.say("finding what lengths and places do");
        find_sensitivities(&mut run, &file, text, (&registry, &settings));
    }
    bar.say("writing the results");
    let (mut failure, mut surface) = (failure, None);
    if let Some(swept) = swept.as_ref().filter(|_| failure.is_none()) {
        match swept.surface(&keeper, results.times().len(), interrupt::monitor()) {
            Ok(Some(made)) => surface = Some(made),
            // The surface needs the whole run.
            Ok(None) if run.status() == Status::Converged => {
                run.outcome = result::Outcome::Graded(Status::Interrupted);
            }
            Ok(None) => {}
            Err(error) => failure = Some(error),
        }
    }
    // All results so far are written, if possible. The first failure is reported.
    let surface = surface.as_ref();
    let finished = results.finish(&run, surface.map(|(surface, _)| surface));
    if let Some(failure) = failure.or(finished.err()) {
        if !arguments.quiet {
            // The failure is more important than one of this line.
            let _ =
                writeln!(out, "results so far are kept: `wireloom run --resume {}` resumes the run", place.display());
        }
        return Err(failure);
    }
    let remark = swept.zip(surface).and_then(|(swept, (_, cell))| swept.remark(*cell));
    if let (Some(path), Some(page)) = (&arguments.page, page) {
        page::write_page(path, &page.finish(&run))?;
    }
    drop(bar);
    let interrupted = run.status() == Status::Interrupted;
    if !interrupted {
        keeper.clear()?;
    }
    let page =
        arguments.page.as_ref().map(|page| format!("wrote {}: the run, to be played in a browser", page.display()));
    let trace = arguments.trace.file.as_ref();
    let trace = trace.map(|file| format!("wrote {}: the trace of the solver", file.display()));
    let resume = interrupted.then(|| format!("`wireloom run --resume {}` resumes the run", place.display()));
    let wrote = Some(format!("wrote {}", results.words()));
    let files = [remark, wrote, page, trace, resume].into_iter().flatten().collect();
    Ok(Finished { run, size, built: notes, extremes, files })
}
