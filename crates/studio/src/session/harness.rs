//! A harness built from a scenario text, with its solver.

use super::refusal::Refusal;
use std::cell::RefCell;
use wireloom::geometry::Pose;
use wireloom::harness::{AttachedConstraint, Network, Schedule, Step};
use wireloom::parts::Action;
use wireloom::result::RequirementResult;
use wireloom::scenario::{Built, Fault, Files, Scenario};
use wireloom::session::{Checkpoint, Ended, InteractiveDriver, Interruption, Monitor, Transferred, transfer};
use wireloom::{Registry, Status, StepResult};

/// A harness and its solver.
pub(super) struct Harness {
    pub scenario: Scenario,
    pub network: Network,
    pub schedule: Schedule,
    /// Notes for the engineer.
    pub notes: Vec<String>,
    coarse: Option<Network>,
    solver: RefCell<InteractiveDriver>,
}

impl Harness {
    /// Builds a harness from a text; `monitor` stops its solver.
    ///
    /// # Errors
    /// All faults of the text.
    pub fn load(text: &str, files: &dyn Files, registry: &Registry, monitor: &Monitor) -> Result<Self, Vec<Fault>> {
        let (scenario, built) = wireloom::load_with_files(text, files, registry)?;
        Ok(Self::of(scenario, built, monitor))
    }

    /// Builds a harness from a checked scenario; `monitor` stops its solver.
    ///
    /// # Errors
    /// Those of [`Scenario::build`].
    pub fn build(scenario: Scenario, registry: &Registry, monitor: &Monitor) -> Result<Self, Vec<Fault>> {
        let built = scenario.build(registry)?;
        Ok(Self::of(scenario, built, monitor))
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
        wireloom::mesh::keep_nodes(&mut scenario, other);
        Self::build(scenario, registry, monitor)
    }

    fn of(scenario: Scenario, built: Built, monitor: &Monitor) -> Self {
        let Built { network, coarse, schedule, minimiser, stop, notes, .. } = built;
        let solver = RefCell::new(InteractiveDriver::new(minimiser, stop, schedule.clearances, monitor.clone()));
        Self { scenario, network, schedule, notes, coarse, solver }
    }

    /// Whether the target of an initially active constraint changes during the first step.
    pub fn tightens_in_first_step(&self) -> bool {
        let changes = |constraint: &AttachedConstraint| match constraint.model.action() {
            Action::Prescribed(_) => {
                let base = Pose::identity();
                constraint.model.target(&base, 0.0) != constraint.model.target(&base, 1.0)
            }
            // Only the constraint itself knows how it depends on the progress.
            Action::Potential(_) | Action::Equations(_) => true,
        };
        self.network.constraints.iter().any(|constraint| constraint.from_start && changes(constraint))
    }

    /// Computes the initial equilibrium.
    ///
    /// # Errors
    /// If none is found.
    pub fn start(&self) -> Result<Ended, Interruption> {
        self.solver.borrow_mut().start(&self.network, self.coarse.as_ref(), &self.schedule)
    }

    /// Takes over the solver of another harness.
    pub fn replace_solver(&self, other: Harness) {
        self.solver.replace(other.solver.into_inner());
    }

    /// Computes the next increment of a step of the schedule.
    ///
    /// # Errors
    /// If no result is obtained.
    pub fn advance(&self, step: &Step, from: &Checkpoint) -> Result<Ended, Interruption> {
        self.solver.borrow_mut().advance(&self.network, step, from)
    }

    /// Computes one more increment of a step without a planned end.
    ///
    /// # Errors
    /// If no result is obtained.
    pub fn advance_drag(&self, step: &Step, from: &Checkpoint) -> Result<Ended, Interruption> {
        self.solver.borrow_mut().advance_open(&self.network, step, from)
    }

    /// Ends a step without a planned end at its newest increment.
    pub fn end_step(&self, from: Checkpoint, end: &mut StepResult) -> (Checkpoint, Vec<RequirementResult>) {
        self.solver.borrow_mut().end_step(&self.network, from, end)
    }

    /// Transfers a checkpoint of another harness to this one, in equilibrium. `None` if the transfer needs the history.
    pub fn transfer(&self, other: &Harness, checkpoint: &Checkpoint) -> Option<Checkpoint> {
        match transfer(checkpoint, &other.network, &self.network)? {
            Transferred::Same(checkpoint) => Some(*checkpoint),
            Transferred::Approximate(checkpoint) => self.solver.borrow_mut().balance(&self.network, *checkpoint),
        }
    }

    /// Index of the active constraint of this name.
    ///
    /// # Errors
    /// If no active constraint has this name.
    pub fn active_constraint(&self, name: &str, at: &Checkpoint) -> Result<usize, Refusal> {
        let of_name = |f: &usize| self.network.constraints[*f].name == name && at.acts(*f);
        (0..self.network.constraints.len()).find(of_name).ok_or_else(|| {
            let active_constraint = self.network.constraints.iter().enumerate().filter(|(f, _)| at.acts(*f));
            let names: Vec<&str> = active_constraint.map(|(_, constraint)| constraint.name.as_str()).collect();
            Refusal::new(format!("no constraint \"{name}\" is active"), format!("active: {}", names.join(", ")))
        })
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

/// Whether all branches have as many nodes as in a result.
pub(super) fn same_nodes(one: &StepResult, network: &Network) -> bool {
    let counts = network.branches.iter().map(|branch| branch.rod.mesh().nodes());
    one.branches.iter().map(|branch| branch.s.len()).eq(counts)
}

/// Whether another increment may follow.
pub(super) fn is_balanced(ended: &Ended) -> bool {
    matches!(ended.end.status, Status::Converged | Status::Stalled)
}
