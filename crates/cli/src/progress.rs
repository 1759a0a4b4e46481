//! A progress bar on standard error: in a terminal, and for long work only.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::Duration;
use wireloom::solve::Progress;

/// Work that ends sooner needs no bar.
const PATIENCE: Duration = Duration::from_millis(700);
const REFRESH: Duration = Duration::from_millis(100);

/// The bar of a run.
pub struct Bar(ProgressBar);

impl Bar {
    /// A bar over so many increments, of which some are done; `shown`: unless the user wants none.
    pub fn new(increments: usize, done: usize, shown: bool) -> Self {
        let bar = ProgressBar::with_draw_target(Some(increments as u64), ProgressDrawTarget::hidden());
        let style = "{bar:20} {pos}/{len} in {elapsed}, about {eta} left: {wide_msg}";
        bar.set_style(ProgressStyle::with_template(style).expect("a template of known keys"));
        bar.set_position(done as u64);
        bar.reset_eta();
        bar.set_message("bringing the fixings to their places");
        if shown && std::io::stderr().is_terminal() {
            let late = bar.clone();
            std::thread::spawn(move || {
                std::thread::sleep(PATIENCE);
                if !late.is_finished() {
                    late.set_draw_target(ProgressDrawTarget::stderr());
                    late.enable_steady_tick(REFRESH);
                }
            });
        }
        Self(bar)
    }

    /// One more is done.
    pub fn one(&self) {
        self.0.inc(1);
    }

    /// One increment is done.
    pub fn advance(&self, progress: &Progress) {
        self.0.inc(1);
        if self.0.message() != progress.step {
            self.0.set_message(progress.step.clone());
        }
    }

    /// Says something that is to stay.
    pub fn say(&self, words: &str) {
        self.0.set_message(words.to_owned());
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
