//! Progress of long work on standard error: a bar in a terminal, elsewhere a line every few seconds.

use crate::interrupt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Shortest time before a bar is shown.
const PATIENCE: Duration = Duration::from_millis(700);
/// Interval of redrawing.
const REFRESH: Duration = Duration::from_millis(100);
/// Interval of lines where there is no terminal: a log of a day stays small.
const PAUSE: Duration = Duration::from_secs(5);

/// Shows progress until it is dropped.
pub struct Bar {
    shared: Arc<Shared>,
    teller: Option<JoinHandle<()>>,
}

struct Shared {
    work: Mutex<Work>,
    over: Condvar,
}

/// The work at hand.
struct Work {
    words: String,
    /// Parts done, and all parts; none where they cannot be counted.
    parts: Option<(usize, usize)>,
    /// Parts done before this run.
    before: usize,
    /// Noun of the parts.
    unit: &'static str,
    began: Instant,
    over: bool,
}

impl Bar {
    /// Work that has begun, in words; `shown`: whether anything is printed.
    pub fn new(words: impl Into<String>, shown: bool) -> Self {
        let work = Work { words: words.into(), parts: None, before: 0, unit: "", began: Instant::now(), over: false };
        let shared = Arc::new(Shared { work: Mutex::new(work), over: Condvar::new() });
        let own = shared.clone();
        let tell = move || if io::stderr().is_terminal() { own.draw() } else { own.write() };
        // Without a thread nothing is shown; the work goes on.
        let teller = shown.then(|| thread::Builder::new().name("progress".to_owned()).spawn(tell).ok()).flatten();
        Self { shared, teller }
    }

    /// Sets the work at hand, in words.
    pub fn say(&self, words: impl Into<String>) {
        let mut work = self.shared.work();
        (work.words, work.parts) = (words.into(), None);
    }

    /// Starts counting parts (`unit`: their noun), some of which are done.
    pub fn count(&self, words: impl Into<String>, unit: &'static str, parts: usize, done: usize) {
        let mut work = self.shared.work();
        (work.words, work.unit, work.parts, work.before) = (words.into(), unit, Some((done, parts)), done);
        work.began = Instant::now();
    }

    /// Sets the part at hand, in words.
    pub fn at(&self, words: &str) {
        let mut work = self.shared.work();
        if work.words != words {
            words.clone_into(&mut work.words);
        }
    }

    /// Counts one part.
    pub fn one(&self) {
        if let Some((done, _)) = &mut self.shared.work().parts {
            *done += 1;
        }
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.shared.work().over = true;
        self.shared.over.notify_all();
        if let Some(teller) = self.teller.take() {
            // Its outcome does not matter.
            let _ = teller.join();
        }
    }
}

impl Shared {
    fn work(&self) -> MutexGuard<'_, Work> {
        // Nothing panics while it holds this.
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits; none where the work ends before.
    fn wait(&self, pause: Duration) -> Option<MutexGuard<'_, Work>> {
        let waited = self.over.wait_timeout_while(self.work(), pause, |work| !work.over);
        let (work, timed_out) = waited.unwrap_or_else(PoisonError::into_inner);
        timed_out.timed_out().then_some(work)
    }

    /// A bar in the terminal.
    fn draw(&self) {
        if self.wait(PATIENCE).is_none() {
            return;
        }
        let style = |template: &str| ProgressStyle::with_template(template).expect("a template of known keys");
        let counting = style("{bar:20} {pos}/{len} in {elapsed}, about {eta} left: {wide_msg}");
        let working = style("{spinner} {elapsed}: {wide_msg}");
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        let mut counted = None;
        while let Some(work) = self.wait(REFRESH) {
            let (words, parts, before) = (work.line(), work.parts, work.before);
            drop(work);
            let now = parts.map(|(_, all)| (all, before));
            if counted != Some(now) {
                bar.set_style(if parts.is_some() { counting.clone() } else { working.clone() });
                bar.reset();
                bar.set_position(before as u64);
                bar.reset_eta();
                counted = Some(now);
            }
            if let Some((done, all)) = parts {
                bar.set_length(all as u64);
                bar.set_position(done as u64);
            }
            bar.set_message(words);
            bar.tick();
        }
        bar.finish_and_clear();
    }

    /// Lines for a log.
    fn write(&self) {
        let began = Instant::now();
        while let Some(work) = self.wait(PAUSE) {
            let line = format!("{}: {}", time(began.elapsed()), work.whole_line());
            drop(work);
            // If standard error is closed, nothing is lost.
            let _ = writeln!(io::stderr(), "{line}");
        }
    }
}

impl Work {
    /// The work at hand, and iterations and residual of the solver.
    fn line(&self) -> String {
        if interrupt::asked() {
            return format!("{}: stopping, and keeping what is done", self.words);
        }
        match interrupt::monitor().seen() {
            (0, _) => self.words.clone(),
            (iterations, residual) if residual.is_finite() => {
                format!("{} ({iterations} iterations, residual {residual:.1e})", self.words)
            }
            (iterations, _) => format!("{} ({iterations} iterations)", self.words),
        }
    }

    /// The same with the parts done and the remaining time.
    fn whole_line(&self) -> String {
        let Some((done, all)) = self.parts else { return self.line() };
        let left = match done - self.before {
            0 => String::new(),
            new => {
                let each = self.began.elapsed().as_secs_f64() / new as f64;
                let left = Duration::try_from_secs_f64(each * (all - done.min(all)) as f64);
                left.map_or_else(|_| String::new(), |left| format!(", about {} left", time(left)))
            }
        };
        format!("{done} of {all} {}{left}: {}", self.unit, self.line())
    }
}

/// A duration, to the second.
fn time(duration: Duration) -> String {
    humantime::format_duration(Duration::from_secs(duration.as_secs())).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_says_how_far_the_work_is_and_how_long_it_will_take() {
        let began = Instant::now().checked_sub(Duration::from_secs(30)).expect("a machine that ran for a while");
        let mut work = Work { words: "draw".into(), parts: None, before: 10, unit: "increments", began, over: false };
        assert_eq!(work.whole_line(), "draw");
        work.parts = Some((10, 100));
        assert_eq!(work.whole_line(), "10 of 100 increments: draw");
        work.parts = Some((25, 100));
        assert_eq!(work.whole_line(), "25 of 100 increments, about 2m 30s left: draw");
    }
}
