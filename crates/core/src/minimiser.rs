//! Trait of a minimiser, its stopping criteria and its report.

use crate::build_error::BuildError;
use crate::status::Status;
use crate::{Network, Problem, State};

/// Stopping criteria.
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

/// Report of a minimiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Its own status; only the certificate may report convergence to users.
    pub status: Status,
    /// Number of iterations: linear systems solved, or line searches made.
    pub iterations: usize,
    /// Number of these iterations made by another minimiser, to finish what this one could not certify (for example in
    /// single precision).
    pub polish: usize,
    /// Matrices factorised.
    pub factorisations: usize,
    /// Energy-and-gradient evaluations.
    pub evaluations: usize,
    /// Largest residual relative to the scales.
    pub residual: f64,
    /// Whether the energy was convex at every state on the way; `false` also where that is not known.
    pub convex: bool,
}

impl Report {
    /// Report of a minimiser before its first iteration.
    pub fn begun(status: Status) -> Self {
        Self {
            status,
            iterations: 0,
            polish: 0,
            factorisations: 0,
            evaluations: 0,
            residual: f64::INFINITY,
            convex: false,
        }
    }
}

/// Minimiser: moves a state to an equilibrium with descending energy.
///
/// Contract: on entry the state may violate prescribed degrees of freedom; on return it satisfies them exactly and its
/// energy is not above that of the first state that did. Its status is not trusted: the certificate recomputes
/// convergence. After the first call on a problem, calls on the same network do not allocate.
pub trait Minimiser {
    /// Kind name.
    fn name(&self) -> &str;
    /// Moves `state` to an equilibrium of `problem`, or as near to it as possible.
    fn minimise(&mut self, problem: &mut Problem<'_>, state: &mut State, stop: &Stop) -> Report;
    /// Discards the data kept from earlier calls: the next call gives the same bits as that of a new minimiser.
    fn forget(&mut self);
    /// Checks whether it supports this harness; called before a run begins.
    ///
    /// # Errors
    /// Names the part it does not support, and suggests a correction.
    fn accepts(&self, _network: &Network) -> Result<(), BuildError> {
        Ok(())
    }
    /// Device that it computes on, if not the processor: name and floating-point precision.
    fn device(&self) -> Option<String> {
        None
    }
    /// Message of a fatal fault, if one has occurred (a lost device): the run then ends with the finished increments.
    fn fault(&self) -> Option<String> {
        None
    }
}
