//! `result.json` read as far as results are compared.

use super::convert::{Apart, listed, numbers, outputs, radii, same_lengths, vectors};
use super::document::{Branch, Constraint, Document, Requirement, Step};
use super::stream::{Collect, Collected, Fields, invalid, is_apart};
use super::values::{Number, Skipped, vector};
use crate::ending::{BranchEnd, Closed, ConstraintEnd, Ending, Way, Work, count};
use crate::fields::BranchFields;
use std::io;
use wireloom_core::Status;
use wireloom_core::requirement::with_distinct_names;

/// The last step, and the sums over all of them.
#[derive(Default)]
pub struct Last {
    step: Option<(Step<Skipped>, Option<Apart>)>,
    way: Way,
    /// Steps whose node fields are in another file, and all.
    apart: usize,
    steps: usize,
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
        let apart = step.apart()?;
        self.apart += usize::from(apart.is_some());
        self.steps += 1;
        self.step = Some((step, apart));
        Ok(())
    }
}

/// The ending of what was read; `None` where there are no steps.
pub fn ending(mut document: Document<Collected<Last>>, read: Fields<'_>) -> io::Result<Option<Ending>> {
    let Last { step, apart, steps, .. } = &mut document.steps.0;
    is_apart(document.fields, apart == steps, *apart == 0)?;
    let Some((end, apart)) = step.take() else { return Ok(None) };
    let fields = apart.map(|apart| read(*steps - 1, *steps, &apart)).transpose()?;
    ended(document, end, fields).map(Some).map_err(invalid)
}

/// The ending of a document with this last step; `fields`: those of its nodes that were in another file.
fn ended(
    document: Document<Collected<Last>>,
    end: Step<Skipped>,
    fields: Option<Vec<BranchFields>>,
) -> Result<Ending, String> {
    let way = document.steps.0.way;
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
    let mut fields = fields.map(Vec::into_iter);
    let branches = end.branches.0.into_iter().map(|(name, branch)| {
        let apart = fields.as_mut().and_then(Iterator::next);
        branch_end(name, branch, apart)
    });
    let branches = branches.collect::<Result<_, _>>()?;
    let (work, closed) = way.sums();
    let sheet: Vec<_> = document.requirements.into_iter().map(Requirement::result).collect();
    Ok(Ending {
        scenario: document.scenario,
        status: document.status.0.word().to_owned(),
        converged: document.status.0 == Status::Converged,
        verdict: document.verdict.0,
        requirements: with_distinct_names(&sheet),
        stable: end.stable,
        branches,
        constraints,
        closed,
        energy: end.energy.energy(),
        events: count(document.events.iter().map(|event| event.kind.0)),
        iterations: work.iterations,
        polish: work.polish,
        factorisations: work.factorisations,
        seconds: work.seconds,
        minimiser: end.minimiser.kind,
    })
}

fn branch_end(name: String, branch: Branch<Skipped>, apart: Option<BranchFields>) -> Result<BranchEnd, String> {
    let (s, position, tangent, bend_radius) = match apart {
        Some(fields) => (fields.s, fields.position, fields.d3, fields.bend_radius),
        None => (
            numbers(listed(branch.s)),
            vectors(listed(branch.position)),
            vectors(listed(branch.d3)),
            radii(listed(branch.bend_radius)),
        ),
    };
    same_lengths(&name, s.len(), &[position.len(), tangent.len(), bend_radius.len()])?;
    if s.iter().any(|s| !s.is_finite()) {
        return Err(format!("`s` of branch \"{name}\" has a null"));
    }
    Ok(BranchEnd { name, s, position, tangent, bend_radius, twist_turns: branch.twist_turns.0 })
}

fn finite(number: Number) -> Option<f64> {
    Some(number.0).filter(|number| number.is_finite())
}
