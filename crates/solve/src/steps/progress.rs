//! Progress of a run, and its control.

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
