//! `wireloom run`: from a scenario to its results, at one go or with interruptions.

use crate::arguments::RunArguments;
use crate::arguments::values;
use crate::extremes::Extremes;
use crate::failure::{Failure, Outcome};
use crate::files::folder::Folder;
use crate::files::load::{self, Loaded};
use crate::files::page;
use crate::files::results::{self, Results};
use crate::files::saved::{self, Keeper, Origin, Standing};
use crate::files::swept::Swept;
use crate::plugin::crash::Worst;
use crate::plugin::load::record;
use crate::plugin::trust::Trust;
use crate::print::progress::Bar;
use crate::print::summary;
use crate::print::text::printable;
use crate::size::increments;
use crate::{interrupt, size};
use std::io::{self, Write};
use std::path::Path;
use wireloom::core::{Monitor, Status, StepResult};
use wireloom::scenario::{Scenario, Setting};
use wireloom::solve::steps::checkpoint::{Checkpoint, Observer, Resumed};
use wireloom::solve::{Control, Progress};
use wireloom_studio::replay::Recorder;

/// What a node takes in `result.json` and in what is kept for `--resume`, bytes; some less than it really does.
const BYTES_KEPT: usize = 350;
/// Likewise in what is kept of every increment to draw what is swept.
const BYTES_SWEPT: usize = 24;
/// Carries out a scenario, or goes on with it. The folder is tried before the work begins; nothing is printed before the files
/// are written.
pub fn run(arguments: &RunArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let trust = Trust::to_run(&arguments.allowed);
    let what = arguments.resume.as_deref().or(arguments.file.as_deref()).unwrap_or(Path::new(""));
    let bar = Bar::new(format!("reading {}", what.display()), !arguments.quiet);
    let job = match &arguments.resume {
        Some(folder) => Job::resume(folder, &trust)?,
        None => Job::begin(arguments, &trust)?,
    };
    drop(bar);
    if let Some(words) = job.size.as_ref().filter(|_| !arguments.quiet) {
        // Who does not listen misses nothing that matters.
        let _ = writeln!(io::stderr(), "{words}");
    }
    let bar = Bar::new("bringing the constraints to their places", !arguments.quiet);
    let provenance = job.loaded.provenance();
    let Job { loaded: Loaded { scenario, built, texts, plugins, .. }, folder, keeper, standing, resumed, .. } = job;
    let place = folder.path().to_path_buf();
    let steps: Vec<String> = built.schedule.steps.iter().map(|step| step.name.clone()).collect();
    let time_limit = wireloom::scenario::plugins(&texts[0].1).time_limit;
    let worst = (!plugins.is_empty()).then(|| Worst::new(&place, steps.clone(), time_limit));
    let (size, notes) = (size::words(&built.network), built.notes.len());
    let scene = page::keep_scene(folder.own(), &built)?;
    bar.count("bringing the constraints to their places", "increments", increments(&built), standing.times.len());
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
            results::surroundings(&built),
            standing.times,
        ),
        keeper,
        page: arguments.page.as_ref().map(|_| Recorder::new(scene)),
        failure: None,
        worst,
    };
    interrupt::listen();
    let mut run = wireloom::run_observed(built, resumed, &mut watcher);
    run.plugins = plugins.iter().map(record).collect();
    run.notes.extend(wireloom::host::notes());
    let Watcher { bar, extremes, mut results, swept, keeper, page, failure, .. } = watcher;
    bar.say("writing the results");
    let (mut failure, mut surface) = (failure, None);
    if let Some(swept) = swept.as_ref().filter(|_| failure.is_none()) {
        match swept.surface(&keeper, results.times().len(), interrupt::monitor()) {
            Ok(Some(made)) => surface = Some(made),
            // It is made of the whole run.
            Ok(None) if run.status == Status::Converged => run.status = Status::Interrupted,
            Ok(None) => {}
            Err(error) => failure = Some(error),
        }
    }
    // What is there is written, if that can be. The first failure is the one to report.
    let surface = surface.as_ref();
    let finished = results.finish(&run, surface.map(|(surface, _)| surface));
    if let Some(failure) = failure.or(finished.err()) {
        if !arguments.quiet {
            // The failure counts more than one to say this.
            let _ = writeln!(out, "what was computed is kept: `wireloom run --resume {}` goes on", place.display());
        }
        return Err(failure);
    }
    let remark = swept.zip(surface).and_then(|(swept, (_, cell))| swept.remark(*cell));
    if let (Some(path), Some(page)) = (&arguments.page, page) {
        page::write_page(path, &page.finish(&run))?;
    }
    drop(bar);
    let interrupted = run.status == Status::Interrupted;
    if !interrupted {
        keeper.clear()?;
    }
    if !arguments.quiet {
        let mut print = || {
            for plugin in &run.plugins {
                writeln!(out, "{}", printable(&plugin.to_string()))?;
            }
            writeln!(out, "{}: {} ({size})\n", printable(&run.scenario), run.status.word())?;
            summary::print(&run, &extremes, notes, out)?;
            if let Some(remark) = &remark {
                writeln!(out, "{remark}")?;
            }
            writeln!(out, "wrote {}", results.words())?;
            if let Some(page) = &arguments.page {
                writeln!(out, "wrote {}: the run to be watched in a browser", page.display())?;
            }
            if interrupted {
                writeln!(out, "`wireloom run --resume {}` goes on", place.display())?;
            }
            Ok(())
        };
        print().map_err(Failure::standard_output)?;
    }
    if let Some(fault) = run.fault {
        return Err(Failure::Part(fault));
    }
    Ok(if run.status == Status::Converged { Outcome::Done } else { Outcome::NotConverged })
}

/// All that a run needs.
struct Job {
    loaded: Loaded,
    /// What to expect of a large harness.
    size: Option<String>,
    folder: Folder,
    keeper: Keeper,
    standing: Standing,
    resumed: Option<Resumed>,
}

impl Job {
    fn begin(arguments: &RunArguments, trust: &Trust) -> Result<Self, Failure> {
        let file = arguments.file.as_deref().unwrap_or(Path::new(""));
        let mut loaded = load::scenario(file, &settings(file, arguments, trust)?, trust)?;
        loaded.scenario.output.report |= arguments.report;
        // What does not fit is refused before the results of a run before are cleared away.
        let size = size::foretell(&loaded.built.network, increments(&loaded.built))?;
        let mut folder = Folder::of_results(arguments.out.as_deref(), file)?;
        folder.clear()?;
        folder.has_room(bytes(&loaded))?;
        let origin = Origin::new(file, arguments, &loaded)?;
        let keeper = Keeper::begin(&folder, &origin)?;
        Ok(Self { loaded, size, folder, keeper, standing: Standing::default(), resumed: None })
    }

    fn resume(place: &Path, trust: &Trust) -> Result<Self, Failure> {
        let folder = saved::interrupted(place)?;
        let origin = Origin::read(&folder)?;
        let mut loaded = load::scenario(&origin.file, &origin.settings(), trust)?;
        loaded.scenario.output.report |= origin.report;
        origin.check(&loaded)?;
        let size = size::foretell(&loaded.built.network, increments(&loaded.built))?;
        let (keeper, standing, resumed) = Keeper::resume(&folder)?;
        results::check(&folder, &loaded.scenario.output, &loaded.built, standing.times.len())?;
        if resumed.as_ref().is_some_and(|resumed| !resumed.checkpoint.fits(&loaded.built.network)) {
            return Err(Failure::Input(format!(
                "the run in {} was begun by another build of this program: run the scenario anew",
                place.display()
            )));
        }
        Ok(Self { loaded, size, folder, keeper, standing, resumed })
    }
}

/// What the command line sets: a point of the sweep, a minimiser, keys.
fn settings(file: &Path, arguments: &RunArguments, trust: &Trust) -> Result<Vec<Setting>, Failure> {
    let mut settings = vec![];
    if let Some(k) = arguments.point {
        let scenario = load::scenario(file, &[], trust)?.scenario;
        let points = scenario.sweep.as_ref().map_or(0, |sweep| sweep.points);
        match &scenario.sweep {
            Some(sweep) if k < points => settings = sweep.settings(k),
            Some(_) => {
                return Err(Failure::Input(format!("there is no point {k}: the sweep has points 0 to {}", points - 1)));
            }
            None => return Err(Failure::Input(format!("{} has no [sweep], so it has no point {k}", file.display()))),
        }
    }
    settings.extend(arguments.minimiser.as_deref().map(Setting::minimiser));
    for set in &arguments.set {
        settings.push(values::setting(set)?);
    }
    Ok(settings)
}

/// What the results of a run take at least, bytes.
fn bytes(loaded: &Loaded) -> u64 {
    let Loaded { scenario: Scenario { output, .. }, built, .. } = loaded;
    let all = increments(built);
    let kept = if output.increments { all } else { built.schedule.steps.len().max(1) };
    let series: usize = results::asked(output).map(|format| all * format.bytes_per_node()).sum();
    let swept = if output.swept.is_some() { all } else { 0 };
    (built.network.points * (kept * BYTES_KEPT + series + swept * BYTES_SWEPT)) as u64
}

/// Watches a run and writes what it leaves on the way. A file that cannot be written stops it.
struct Watcher {
    bar: Bar,
    /// Names of the steps.
    steps: Vec<String>,
    extremes: Extremes,
    results: Results,
    swept: Option<Swept>,
    keeper: Keeper,
    /// Where the run is to become a page.
    page: Option<Recorder>,
    failure: Option<Failure>,
    /// Where a plugin may end the process.
    worst: Option<Worst>,
}

impl Watcher {
    fn attempt(&mut self, attempt: impl FnOnce(&mut Self) -> Result<(), Failure>) {
        if self.failure.is_none() {
            self.failure = attempt(self).err();
        }
    }
}

impl Observer for Watcher {
    fn increment(&mut self, progress: &Progress, end: &StepResult, kept: bool) -> Control {
        self.bar.one();
        if let Some(worst) = &self.worst {
            worst.after(progress);
        }
        self.extremes.see(end);
        if let Some(page) = &mut self.page {
            page.record(end);
        }
        self.attempt(|watcher| {
            watcher.results.increment(progress, end)?;
            if watcher.swept.is_some() {
                watcher.keeper.keep_lines(watcher.results.times().len(), &Swept::at(end))?;
            }
            if kept { watcher.keeper.keep(end) } else { Ok(()) }
        });
        if self.failure.is_some() { Control::Stop } else { Control::Continue }
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.bar.at(self.steps.get(checkpoint.done().0).map_or("equilibrium", String::as_str));
        if self.results.times().is_empty()
            && let Some(lines) = self.swept.as_ref().map(|swept| swept.at_start(checkpoint))
        {
            self.attempt(|watcher| watcher.keeper.keep_lines(0, &lines));
        }
        if self.keeper.is_due() {
            let standing = Standing {
                checkpoint: Some(checkpoint.clone()),
                extremes: self.extremes.clone(),
                times: self.results.times().to_vec(),
            };
            self.attempt(|watcher| watcher.keeper.stand(&standing));
        }
    }

    fn monitor(&self) -> Monitor {
        interrupt::monitor().clone()
    }
}
