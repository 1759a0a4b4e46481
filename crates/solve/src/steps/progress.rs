//! Progress of a run, and its control.

use wireloom_core::equilibrium::PartFault;

/// Progress of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Name of the step.
    pub step: String,
    /// Index of the step, from 0.
    pub step_index: usize,
    /// Number of steps.
    pub steps: usize,
    /// Increment of the step, from 1.
    pub increment: usize,
    /// Increments of the step.
    pub increments: usize,
    /// Iterations in the step so far.
    pub iterations: usize,
}

/// Decision of an observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Continue the run.
    Continue,
    /// Stop the run after this increment, whose result is kept.
    Stop,
}

/// Reason why an increment did not end.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Interruption {
    /// A stop was requested.
    #[error("stopped")]
    Stopped,
    /// A part cannot continue.
    #[error("{0}")]
    Fault(PartFault),
}
