//! What it does to the requirements to move a constraint from where it is.

use super::answer::{Derivative, NoAnswer, Parameter};
use super::differences::{Around, derivatives};
use super::outputs::{Asked, Catalogue, Measured};
use crate::session::DrivenHarness;
use crate::session::drag::movable;
use wireloom_core::conditions::Partner;
use wireloom_core::equilibrium::{RequirementResult, StepResult};
use wireloom_core::{Monitor, Status, Vector};
use wireloom_solve::steps::checkpoint::Checkpoint;
use wireloom_solve::steps::nearby::{Moved, Nearby};

/// What it does to the requirements to move a constraint.
#[derive(Clone, Debug, PartialEq)]
pub struct OfMove {
    /// Whether friction, slip, or parts that remember have a history, which is kept as it is.
    pub keeps_history: bool,
    /// The requirements that have a finite value at this equilibrium.
    pub lines: Vec<LineOfMove>,
}

/// What it does to a requirement to move a constraint.
#[derive(Clone, Debug, PartialEq)]
pub struct LineOfMove {
    /// The requirement, with its worst value at this equilibrium.
    pub line: RequirementResult,
    /// Derivatives of that value by the place of the constraint along x, y, z; unit of the measure over m.
    pub by: [Derivative; 3],
}

/// Derivatives of the requirements that have a value at an equilibrium, `end` with its checkpoint `at`, by the place of
/// a constraint. Everything else stays, history included.
///
/// # Errors
/// A name that is no constraint that acts and can be moved; an equilibrium that has not converged or has no neighbours;
/// if it was stopped.
pub fn of_move(
    harness: &DrivenHarness,
    (at, end): (&Checkpoint, &StepResult),
    constraint: &str,
    monitor: &Monitor,
) -> Result<OfMove, NoAnswer> {
    let constraint = movable(constraint, harness, at).map_err(|error| NoAnswer::Question(error.to_string()))?;
    let step = || end.name.clone();
    if end.status != Status::Converged {
        return Err(NoAnswer::NotConverged { step: step(), status: end.status });
    }
    let none = |reason| NoAnswer::NotDifferentiable { step: step(), increment: end.increment, reason };
    let names = harness.network.requirement_names();
    let moved = harness.moved(at).map_err(none)?;
    let catalogue = Catalogue::new(&harness.scenario, &harness.network);
    let mut around = ByPlace { harness, constraint, monitor, names, catalogue, moved };
    let here = around.moved.find(constraint, Vector::zeros()).map_err(none)?;
    let here = around.measured(here);
    let known = |line: &&RequirementResult| line.worst.is_some_and(f64::is_finite);
    let line = |line: &RequirementResult| LineOfMove { line: line.clone(), by: Default::default() };
    let mut lines: Vec<LineOfMove> = here.near.requirements.iter().filter(known).map(line).collect();
    let asked: Vec<Asked> = lines.iter().map(|own| Asked::new(&own.line.name, &here, &harness.network)).collect();
    for (axis, key) in AXES.iter().enumerate() {
        let key = (*key).to_owned();
        let parameter = Parameter { key, value: 0.0, unit: "m".to_owned(), scale: 0.0, tolerance: None };
        let all = derivatives(&mut around, &parameter, &here, &asked)?;
        lines.iter_mut().zip(all).for_each(|(own, derivative)| own.by[axis] = derivative);
    }
    Ok(OfMove { keeps_history: around.moved.has_history(), lines })
}

/// Keys of the parameters.
const AXES: [&str; 3] = ["x", "y", "z"];

/// The neighbourhood by the place of a constraint.
struct ByPlace<'h> {
    harness: &'h DrivenHarness,
    constraint: usize,
    monitor: &'h Monitor,
    /// Distinct names of the requirements.
    names: Vec<String>,
    catalogue: Catalogue,
    moved: Moved<'h>,
}

impl ByPlace<'_> {
    fn measured(&self, mut near: Nearby) -> Measured {
        near.requirements.iter_mut().zip(&self.names).for_each(|(line, name)| line.name.clone_from(name));
        self.catalogue.measured(&self.harness.scenario, &self.harness.network, near)
    }
}

impl Around for ByPlace<'_> {
    fn at(&mut self, parameter: &Parameter, value: f64) -> Result<Result<Measured, String>, NoAnswer> {
        if self.monitor.is_stopped() {
            return Err(NoAnswer::Stopped);
        }
        let by = Vector::from(AXES.map(|axis| if axis == parameter.key { value } else { 0.0 }));
        let found = self.moved.find(self.constraint, by);
        Ok(found.map(|near| self.measured(near)).map_err(|reason| reason.to_string()))
    }

    fn words(&self, touching: (u32, Partner)) -> String {
        self.moved.words(touching)
    }
}
