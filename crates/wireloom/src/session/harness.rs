//! A harness that is driven one increment at a time, with its solver.

use super::error::SessionError;
use crate::load::load_with_files;
use crate::mesh::keep_nodes;
use std::cell::RefCell;
use wireloom_core::equilibrium::StepResult;
use wireloom_core::network::Network;
use wireloom_core::requirement::RequirementResult;
use wireloom_core::steps::{Schedule, Step};
use wireloom_core::{Monitor, Registry};
use wireloom_scenario::{Built, Fault, Files, Scenario};
use wireloom_solve::steps::checkpoint::Checkpoint;
use wireloom_solve::steps::checkpoint_transfer::{Transferred, transfer};
use wireloom_solve::steps::interactive::{Ended, InteractiveDriver};
use wireloom_solve::steps::nearby::{Moved, NotFound};
use wireloom_solve::steps::{Guide, Interruption};

/// A harness and its solver.
pub struct DrivenHarness {
    /// The scenario that it was built from.
    pub scenario: Scenario,
    /// The harness.
    pub network: Network,
    /// Its steps.
    pub schedule: Schedule,
    /// Notes for the engineer.
    pub notes: Vec<String>,
    coarse: Option<Network>,
    driver: RefCell<InteractiveDriver>,
}

impl DrivenHarness {
    /// The harness of a checked scenario; `monitor` stops its solver.
    pub fn new(scenario: Scenario, built: Built, monitor: &Monitor) -> Self {
        let Built { network, coarse, schedule, minimiser, stop, notes, .. } = built;
        let driver = RefCell::new(InteractiveDriver::new(minimiser, stop, schedule.clearances, monitor.clone()));
        Self { scenario, network, schedule, notes, coarse, driver }
    }

    /// The harness, whose planned increments end near the equilibria of `guide`.
    pub fn guided(self, guide: Option<Guide>) -> Self {
        Self { driver: RefCell::new(self.driver.into_inner().guided(guide)), ..self }
    }

    /// The harness of a text.
    ///
    /// # Errors
    /// All faults of the text.
    pub fn load(text: &str, files: &dyn Files, registry: &Registry, monitor: &Monitor) -> Result<Self, Vec<Fault>> {
        let (scenario, built) = load_with_files(text, files, registry)?;
        Ok(Self::new(scenario, built, monitor))
    }

    /// The same harness on the mesh of another one, where its mesh follows from an accuracy.
    ///
    /// # Errors
    /// Those of [`Scenario::build`].
    pub fn on_mesh_of(self, other: &Network, registry: &Registry, monitor: &Monitor) -> Result<Self, Vec<Fault>> {
        if self.scenario.accuracy.is_none() {
            return Ok(self);
        }
        let mut scenario = self.scenario;
        keep_nodes(&mut scenario, other);
        let built = scenario.build(registry)?;
        Ok(Self::new(scenario, built, monitor))
    }

    /// Computes the initial equilibrium.
    ///
    /// # Errors
    /// If no result is obtained.
    pub fn start(&self) -> Result<Ended, Interruption> {
        self.driver.borrow_mut().start(&self.network, self.coarse.as_ref(), &self.schedule)
    }

    /// Computes the next increment of a step.
    ///
    /// # Errors
    /// If no result is obtained.
    pub fn advance(&self, step: &Step, from: &Checkpoint) -> Result<Ended, Interruption> {
        self.driver.borrow_mut().advance(&self.network, step, from)
    }

    /// Computes one more increment of a step without a planned end.
    ///
    /// # Errors
    /// If no result is obtained.
    pub fn advance_open(&self, step: &Step, from: &Checkpoint) -> Result<Ended, Interruption> {
        self.driver.borrow_mut().advance_open(&self.network, step, from)
    }

    /// Ends a step without a planned end at its newest increment.
    pub fn end_step(&self, from: Checkpoint, end: &mut StepResult) -> (Checkpoint, Vec<RequirementResult>) {
        self.driver.borrow_mut().end_step(&self.network, from, end)
    }

    /// A checkpoint of another harness on this one, in equilibrium; `None` if that needs the history.
    pub fn transferred(&self, other: &DrivenHarness, checkpoint: &Checkpoint) -> Option<Checkpoint> {
        let nodes = |network: &Network| -> Vec<usize> {
            network.branches.iter().map(|branch| branch.rod.mesh().nodes()).collect()
        };
        if nodes(&self.network) != nodes(&other.network) {
            return None;
        }
        match transfer(checkpoint, &other.network, &self.network)? {
            Transferred::Same(checkpoint) => Some(*checkpoint),
            Transferred::Approximate(checkpoint) => self.driver.borrow_mut().balance(&self.network, *checkpoint),
        }
    }

    /// The equilibrium at a checkpoint, and those near it with a constraint moved.
    ///
    /// # Errors
    /// If it is no equilibrium that has neighbours.
    pub(crate) fn moved(&self, at: &Checkpoint) -> Result<Moved<'_>, NotFound> {
        self.driver.borrow().moved(&self.network, at)
    }

    /// Index of the active constraint of this name.
    ///
    /// # Errors
    /// If there is none.
    pub fn active_constraint(&self, name: &str, at: &Checkpoint) -> Result<usize, SessionError> {
        let active = self.network.constraints.iter().enumerate().filter(|(f, _)| at.acts(*f));
        let found = active.clone().find(|(_, own)| own.name == name).map(|(f, _)| f);
        let known = active.map(|(_, own)| own.name.as_str());
        found.ok_or_else(|| SessionError::unknown(format!("no constraint \"{name}\" is active"), name, known))
    }

    /// Takes over the solver of another harness.
    pub fn replace_solver(&self, other: DrivenHarness) {
        self.driver.replace(other.driver.into_inner());
    }

    /// Length of the longest branch, m.
    pub fn longest(&self) -> f64 {
        self.network.branches.iter().map(|branch| branch.rod.mesh().length()).fold(0.0, f64::max)
    }

    /// Total length of all branches, m.
    pub fn total_length(&self) -> f64 {
        self.network.branches.iter().map(|branch| branch.rod.mesh().length()).sum()
    }
}
