//! Runs that are observed, stopped and resumed, and harnesses that are driven interactively.
//!
//! [`run_observed`](crate::run_observed) calls an [`Observer`] at the end of every increment and gives it a
//! [`Checkpoint`] from which the run can be resumed to the same bits. A [`Monitor`] stops a run from any thread.
//!
//! A [`Session`] is a harness that is moved by hand, each time to a new equilibrium, while its scenario is recorded. It
//! consists of a [`DrivenHarness`], which carries out one increment at a time from any checkpoint, and of motions of
//! constraints ([`drag`]). [`transfer`] transfers a checkpoint to the same harness with other constraints.
//!
//! ```
//! use wireloom::session::{Checkpoint, Observer, Progress, Resumed};
//! use wireloom::{Control, StepResult};
//!
//! /// Stops after the first increment that is kept, and keeps what is needed to go on.
//! #[derive(Default)]
//! struct StopsOnce {
//!     checkpoint: Option<Checkpoint>,
//!     steps: Vec<StepResult>,
//! }
//!
//! impl Observer for StopsOnce {
//!     fn increment(&mut self, _: &Progress, end: &StepResult, kept: bool) -> Control {
//!         if kept {
//!             self.steps.push(end.clone());
//!         }
//!         if self.steps.len() == 1 { Control::Stop } else { Control::Continue }
//!     }
//!     fn checkpoint(&mut self, checkpoint: &Checkpoint) {
//!         self.checkpoint = Some(checkpoint.clone());
//!     }
//! }
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let registry = wireloom::registry();
//! let built = || wireloom::load(&text, &registry).expect("no faults").1;
//! let whole = wireloom::run(built(), &mut |_, _| Control::Continue);
//!
//! let mut observer = StopsOnce::default();
//! wireloom::run_observed(built(), None, &mut observer);
//! let checkpoint = observer.checkpoint.take().expect("one is given at the start");
//! observer.steps.truncate(checkpoint.kept());
//! let resumed = Resumed { checkpoint, steps: std::mem::take(&mut observer.steps) };
//! let rest = wireloom::run_observed(built(), Some(resumed), &mut StopsOnce::default());
//! assert_eq!(rest.steps[0].branches, whole.steps[0].branches);
//! # Ok::<(), std::io::Error>(())
//! ```

mod by_hand;
pub mod drag;
mod error;
mod harness;

pub use by_hand::{Session, attachment, joint_motion, unused_name};
pub use error::{Refusal, SessionError};
pub use harness::DrivenHarness;
pub use wireloom_core::Monitor;
pub use wireloom_solve::steps::Interruption;
pub use wireloom_solve::steps::checkpoint::{Checkpoint, IncrementObserver, Observer, Resumed};
pub use wireloom_solve::steps::checkpoint_transfer::{Transferred, transfer};
pub use wireloom_solve::steps::interactive::{Ended, InteractiveDriver};
pub use wireloom_solve::{Control, Progress};
