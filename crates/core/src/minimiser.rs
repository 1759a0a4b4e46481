//! The trait of a minimiser, and what it says when it is done.

use crate::build_error::BuildError;
use crate::status::Status;
use crate::{Network, Problem, State};

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Largest residual force relative to the force scale, and moment relative to the moment scale.
    pub force_tolerance: f64,
    /// Iterations allowed.
    pub max_iterations: usize,
}

impl Default for Stop {
    fn default() -> Self {
        Self { force_tolerance: 1e-6, max_iterations: 200 }
    }
}

/// What a minimiser did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// How it ended, in its own view; only the certificate may call it converged to users.
    pub status: Status,
    /// Linear systems solved (or line searches made).
    pub iterations: usize,
    /// How many of them another minimiser made, to finish what this one could not certify (in single precision, say).
    pub polish: usize,
    /// Matrices factorised.
    pub factorisations: usize,
    /// Energy-and-gradient evaluations.
    pub evaluations: usize,
    /// Largest residual relative to the scales.
    pub residual: f64,
}

impl Report {
    /// Of a minimiser that has done nothing yet.
    pub fn begun(status: Status) -> Self {
        Self { status, iterations: 0, polish: 0, factorisations: 0, evaluations: 0, residual: f64::INFINITY }
    }
}

/// Moves a state downhill to an equilibrium.
///
/// Contract: on entry the state may violate prescribed freedoms; on return it satisfies them exactly
/// and its energy is not above that of the first state that did. It never grades its own work: what
/// it calls converged is recomputed by the certificate. After the first call on a problem, calls on the
/// same network do not allocate.
pub trait Minimiser {
    /// Kind name.
    fn name(&self) -> &str;
    /// Carries `state` to an equilibrium of `problem`, or as near as it gets.
    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report;
    /// Forgets what it remembers of earlier calls: the next one gives the same bits as that of a new minimiser.
    fn forget(&mut self);
    /// Whether it can work on this harness; asked before a run begins.
    ///
    /// # Errors
    /// The part it has no law for, by name, and what would be right.
    fn accepts(&self, _network: &Network) -> Result<(), BuildError> {
        Ok(())
    }
    /// What it computes on, where that is not the processor: the device's name and the precision of its numbers.
    fn device(&self) -> Option<String> {
        None
    }
    /// Why nothing it says may be relied on any more, if so (a device that was lost); the run then ends, and keeps what is
    /// finished.
    fn fault(&self) -> Option<String> {
        None
    }
}
