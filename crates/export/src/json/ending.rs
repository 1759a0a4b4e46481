//! `result.json` read as far as results are compared.

use super::convert::{numbers, outputs, radii, vectors};
use super::document::{Branch, Constraint, Document, Requirement, Step};
use super::stream::{Collect, Collected};
use super::values::{Number, Skipped, vector};
use crate::ending::{BranchEnd, Closed, ConstraintEnd, Ending, Way, Work, count};
use wireloom_core::Status;

/// The last step, and the sums over all of them.
#[derive(Default)]
pub struct Last {
    step: Option<Step<Skipped>>,
    way: Way,
}

impl Collect for Last {
    type Vectors = Skipped;

    fn take(&mut self, mut step: Step<Skipped>) -> Result<(), String> {
        let minimiser = &step.minimiser;
        let work = Work {
            iterations: minimiser.iterations,
            polish: minimiser.polish,
            factorisations: minimiser.factorisations,
            seconds: if minimiser.seconds.0.is_nan() { 0.0 } else { minimiser.seconds.0 },
        };
        let operations = std::mem::take(&mut step.operations).into_iter();
        let closed = operations.filter_map(|operation| Closed::of(&operation.result()));
        self.way.add(&step.name, step.increment, work, closed);
        self.step = Some(step);
        Ok(())
    }
}

/// The ending of what was read; `None` where there are no steps.
pub fn ending(document: Document<Collected<Last>>) -> Result<Option<Ending>, String> {
    let Last { step, way } = document.steps.0;
    let Some(end) = step else { return Ok(None) };
    let mut slides = vec![];
    for (name, slide) in end.sliding.0 {
        let at = finite(slide.contact_arclength).ok_or_else(|| format!("`contact_arclength` of \"{name}\" is null"))?;
        slides.push((name, (slide.branch, at)));
    }
    let constraint = |(name, constraint): (String, Constraint)| ConstraintEnd {
        position: vector(constraint.position),
        force: vector(constraint.force),
        moment: vector(constraint.moment),
        outputs: outputs(constraint.outputs),
        slide: slides.iter().find(|(sliding, _)| *sliding == name).map(|(_, at)| at.clone()),
        name,
    };
    let constraints = end.constraints.0.into_iter().map(constraint).collect();
    let branches = end.branches.0.into_iter().map(|(name, branch)| branch_end(name, branch));
    let (work, closed) = way.sums();
    Ok(Some(Ending {
        scenario: document.scenario,
        status: document.status.0.word().to_owned(),
        converged: document.status.0 == Status::Converged,
        verdict: document.verdict.0,
        requirements: document.requirements.into_iter().map(Requirement::result).collect(),
        stable: end.stable,
        branches: branches.collect::<Result<_, _>>()?,
        constraints,
        closed,
        energy: end.energy.energy(),
        events: count(document.events.iter().map(|event| event.kind.0)),
        iterations: work.iterations,
        polish: work.polish,
        factorisations: work.factorisations,
        seconds: work.seconds,
        minimiser: end.minimiser.kind,
    }))
}

fn branch_end(name: String, branch: Branch<Skipped>) -> Result<BranchEnd, String> {
    branch.same_lengths(&name, &[])?;
    if branch.s.iter().any(|s| finite(*s).is_none()) {
        return Err(format!("`s` of branch \"{name}\" has a null"));
    }
    Ok(BranchEnd {
        name,
        s: numbers(branch.s),
        position: vectors(branch.position),
        tangent: vectors(branch.d3),
        bend_radius: radii(branch.bend_radius),
        twist_turns: branch.twist_turns.0,
    })
}

fn finite(number: Number) -> Option<f64> {
    Some(number.0).filter(|number| number.is_finite())
}
