//! The constraints and loads that act at the start and in each step.

use crate::scenario::Scenario;
use crate::span::Span;
use wireloom_core::Vector;
use wireloom_core::requirement::{Measure, Part, Requirement};
use wireloom_core::steps::Step;

/// The beginning, or a step.
pub(crate) struct Stage<'s> {
    /// Its time, for messages.
    pub label: String,
    /// Its place in the file; `None` at the start.
    pub span: Option<Span>,
    /// The step; `None` at the start.
    pub step: Option<&'s Step>,
    /// Constraints that begin with it.
    pub begins: Vec<usize>,
    /// Constraints that act in it.
    pub active: Vec<usize>,
    /// Whether gravity acts at some time in it, or the axes rotate at some time.
    pub gravity: bool,
    /// Loads that act at some time in it.
    pub loads: Vec<usize>,
}

impl Scenario {
    /// Indices of the constraints that act in each step; of a scenario without steps at its one equilibrium.
    pub fn acting(&self) -> Vec<Vec<usize>> {
        let stages = stages(self).into_iter().map(|stage| stage.active);
        stages.skip(usize::from(!self.steps.is_empty())).collect()
    }
}

/// Why a requirement can have no value in any of these steps: it is about constraints alone, and none of them acts
/// there.
pub(crate) fn never_acts(scenario: &Scenario, requirement: &Requirement, steps: &[usize]) -> Option<String> {
    // It has the force on the way, after which the constraint may be gone.
    if requirement.of.is_empty() || requirement.measure == Measure::InsertionForce {
        return None;
    }
    let acting = scenario.acting();
    let acts = |part: &Part| match part {
        Part::Constraint(constraint) => steps.iter().any(|step| acting[*step].contains(constraint)),
        Part::Branch { .. } | Part::Obstacle(_) => true,
    };
    if requirement.of.iter().any(acts) {
        return None;
    }
    Some(format!("no part of `{}` acts in the steps in which it counts", requirement.name))
}

/// All stages of a scenario, in order. Gravity and loads of the first step count at the start too: its first
/// increment is the first equilibrium.
pub(crate) fn stages(scenario: &Scenario) -> Vec<Stage<'_>> {
    let mut active: Vec<usize> =
        (0..scenario.constraints.len()).filter(|c| scenario.constraints[*c].from_start).collect();
    let mut gravity = scenario.gravity;
    let rotates = scenario.rotates();
    let mut factors: Vec<f64> = scenario.loads.iter().map(|load| load.factor).collect();
    let mut all = Vec::new();
    let first = Step::default();
    let mut stage = |label, span, begins: Vec<usize>, active: &[usize], step, ahead: &Step| {
        let mut acting: Vec<bool> = factors.iter().map(|factor| *factor != 0.0).collect();
        let mut pulls = gravity != Vector::zeros() || rotates;
        for (load, factor) in &ahead.loads {
            factors[*load] = *factor;
            acting[*load] |= *factor != 0.0;
        }
        if let Some(next) = ahead.gravity {
            gravity = next;
            pulls |= next != Vector::zeros();
        }
        let loads = (0..acting.len()).filter(|load| acting[*load]).collect();
        all.push(Stage { label, span, step, begins, active: active.to_vec(), gravity: pulls, loads });
    };
    let ahead = scenario.steps.first().unwrap_or(&first);
    stage("at the start".to_owned(), None, active.clone(), &active, None, ahead);
    for (step, span) in scenario.steps.iter().zip(&scenario.step_spans) {
        active.retain(|constraint| !step.release.contains(constraint));
        active.extend(&step.add);
        let label = format!("in step \"{}\"", step.name);
        stage(label, Some(span.clone()), step.add.clone(), &active, Some(step), step);
    }
    all
}
