//! The observer of a run.

use crate::extremes::Extremes;
use crate::failure::Failure;
use crate::files::results::Results;
use crate::files::saved::{Keeper, Standing};
use crate::files::swept::Swept;
use crate::interrupt;
use crate::plugin::crash::CrashReport;
use crate::print::progress::Bar;
use wireloom::session::{Checkpoint, Monitor, Observer, Progress};
use wireloom::{Control, StepResult};
use wireloom_studio::replay::Recorder;

/// Observer of a run: writes files and the record as increments end. A file that cannot be written stops the run.
pub struct Watcher {
    pub bar: Bar,
    /// Names of the steps.
    pub steps: Vec<String>,
    pub extremes: Extremes,
    pub results: Results,
    pub swept: Option<Swept>,
    pub keeper: Keeper,
    /// Recorder of the page, if one is asked for.
    pub page: Option<Recorder>,
    pub failure: Option<Failure>,
    /// Crash report, where there are plugins.
    pub crash_report: Option<CrashReport>,
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
        if let Some(crash_report) = &self.crash_report {
            crash_report.after(progress);
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
