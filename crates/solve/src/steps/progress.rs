//! Progress of a run, and control over it.

/// Progress of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Name of the step.
    pub step: String,
    /// Index of the step, from 0.
    pub step_index: usize,
    /// Number of steps.
    pub steps: usize,
    /// Increment of it, from 1.
    pub increment: usize,
    /// Increments of the step.
    pub increments: usize,
    /// Iterations spent in the step so far.
    pub iterations: usize,
}

/// Decision of an observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Stop here; what has been computed is kept.
    Stop,
}
