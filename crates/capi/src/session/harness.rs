//! A harness built from a text, with its solver.

use crate::failure::{Failure, WireloomCode};
use std::cell::RefCell;
use wireloom::harness::{Network, Schedule, Step};
use wireloom::result::Status;
use wireloom::scenario::{Built, Scenario};
use wireloom::session::{Checkpoint, Ended, InteractiveDriver, Interruption, Monitor, Transferred, transfer};
use wireloom::{Registry, StepResult, mesh};

/// A harness and its solver.
pub struct Harness {
    pub network: Network,
    pub schedule: Schedule,
    pub driver: RefCell<InteractiveDriver>,
    coarse: Option<Network>,
}

impl Harness {
    pub fn new(built: Built, monitor: &Monitor) -> Self {
        let Built { network, coarse, schedule, minimiser, stop, .. } = built;
        let driver = InteractiveDriver::new(minimiser, stop, schedule.clearances, monitor.clone());
        Self { network, schedule, coarse, driver: RefCell::new(driver) }
    }

    /// The same scenario with other constraints, on the mesh of this harness.
    pub fn with_own_mesh(
        &self,
        (mut scenario, built): (Scenario, Built),
        registry: &Registry,
        text: &str,
    ) -> Result<Built, Failure> {
        if scenario.accuracy.is_none() {
            return Ok(built);
        }
        mesh::keep_nodes(&mut scenario, &self.network);
        scenario.build(registry).map_err(|faults| Failure::refused(text, &faults))
    }

    /// The initial equilibrium.
    pub fn start(&self) -> Result<Ended, Failure> {
        let started = self.driver.borrow_mut().start(&self.network, self.coarse.as_ref(), &self.schedule);
        balanced(started.map_err(interrupted)?)
    }

    /// The next increment of a step.
    pub fn advance(&self, step: &Step, from: &Checkpoint) -> Result<Ended, Failure> {
        balanced(self.driver.borrow_mut().advance(&self.network, step, from).map_err(interrupted)?)
    }

    /// One more increment of a step without a planned end.
    pub fn advance_open(&self, step: &Step, from: &Checkpoint) -> Result<Ended, Failure> {
        balanced(self.driver.borrow_mut().advance_open(&self.network, step, from).map_err(interrupted)?)
    }

    /// A checkpoint of another harness on this one, in equilibrium; `None` if that needs the history.
    pub fn transferred(&self, other: &Harness, checkpoint: &Checkpoint, end: &StepResult) -> Option<Checkpoint> {
        let nodes = self.network.branches.iter().map(|branch| branch.rod.mesh().nodes());
        if !end.branches.iter().map(|branch| branch.s.len()).eq(nodes) {
            return None;
        }
        match transfer(checkpoint, &other.network, &self.network)? {
            Transferred::Same(checkpoint) => Some(*checkpoint),
            Transferred::Approximate(checkpoint) => self.driver.borrow_mut().balance(&self.network, *checkpoint),
        }
    }

    /// Lengths of the longest branch and of all together, m.
    pub fn lengths(&self) -> (f64, f64) {
        let lengths = self.network.branches.iter().map(|branch| branch.rod.mesh().length());
        (lengths.clone().fold(0.0, f64::max), lengths.sum())
    }
}

fn interrupted(interruption: Interruption) -> Failure {
    match interruption {
        Interruption::Stopped => Failure::new(WireloomCode::Cancelled, "it was cancelled", "reset the cancel handle"),
        Interruption::Fault(fault) => Failure::new(WireloomCode::Part, fault.to_string(), ""),
    }
}

/// An end from which another increment may follow.
fn balanced(ended: Ended) -> Result<Ended, Failure> {
    if matches!(ended.end.status, Status::Converged | Status::Stalled) {
        return Ok(ended);
    }
    let message = format!("no equilibrium was found: {}", ended.end.status.word());
    Err(Failure::request(
        message,
        "the harness is as it was at the last equilibrium; move in smaller steps, or elsewhere",
    ))
}
