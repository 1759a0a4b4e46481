//! The sheet of requirements for pages.

use crate::frame::{Violation, number};
use crate::protocol::{Place, SensitivityLine, Sheet, SheetLine};
use crate::stretches;
use wireloom::result::{EventPlace, Moment, RequirementResult, Verdict, by_urgency, verdict};
use wireloom::sensitivity::LineOfMove;
use wireloom::{Status, StepResult, result};

/// The sheet at the end of a run, or so far: `steps` of which `done` have been computed. `frame`: the number of an
/// increment's frame.
pub(crate) fn sheet(
    lines: &[RequirementResult],
    status: Status,
    (done, steps): (usize, usize),
    frame: impl Fn(&Moment) -> Option<u32>,
) -> Sheet {
    let verdict = match verdict(lines) {
        Verdict::Pass if status != Status::Converged || done < steps => Verdict::Unresolved,
        verdict => verdict,
    };
    let mut lines: Vec<&RequirementResult> = lines.iter().collect();
    lines.sort_by(|a, b| by_urgency(a, b));
    Sheet {
        verdict: verdict.word().to_owned(),
        status: status.word().to_owned(),
        done: number(done),
        steps: number(steps),
        lines: lines.into_iter().map(|own| line(own, &frame)).collect(),
    }
}

fn line(line: &RequirementResult, frame: impl Fn(&Moment) -> Option<u32>) -> SheetLine {
    let moment = line.moment.as_ref();
    SheetLine {
        name: line.name.clone(),
        measure: line.measure.word().to_owned(),
        unit: line.measure.unit().to_owned(),
        severity: line.severity.word().to_owned(),
        origin: line.origin.word().to_owned(),
        because: line.because.clone(),
        verdict: line.verdict.word().to_owned(),
        reason: line.reason.clone(),
        worst: line.worst,
        limit: line.limit,
        bound: line.bound.word().to_owned(),
        margin: line.margin(),
        error: line.error,
        step: moment.map(|moment| moment.step.clone()),
        increment: moment.map(|moment| number(moment.increment)),
        frame: moment.and_then(frame),
        place: Place::of(&line.place),
    }
}

/// What it does to the requirements to move a constraint.
pub(crate) fn sensitivities(mut found: Vec<LineOfMove>) -> Vec<SensitivityLine> {
    found.sort_by(|a, b| by_urgency(&a.line, &b.line));
    let line = |LineOfMove { line, by }: LineOfMove| {
        Some(SensitivityLine {
            value: line.worst?,
            measure: line.measure.word().to_owned(),
            unit: line.measure.unit().to_owned(),
            limit: line.limit,
            bound: line.bound.word().to_owned(),
            place: Place::of(&line.place),
            by: by.each_ref().map(|own| own.value.map_or(own.sides, |value| [Some(value); 2])),
            reasons: by.map(|own| own.reason),
            name: line.name,
        })
    };
    found.into_iter().filter_map(line).collect()
}

impl Place {
    fn of(place: &EventPlace) -> Self {
        let EventPlace { constraint, obstacle, branch, s, other_branch, other_s } = place.clone();
        Self { constraint, obstacle, branch, s, other_branch, other_s }
    }
}

impl Violation {
    pub(crate) fn of(violation: &result::Violation, end: &StepResult) -> Self {
        let stretches = stretches::of(violation, end);
        let result::Violation { name, measure, severity, value, limit, bound, place } = violation;
        Self {
            name: name.clone(),
            measure: measure.word().to_owned(),
            unit: measure.unit().to_owned(),
            severity: severity.word().to_owned(),
            value: *value,
            limit: *limit,
            bound: bound.word().to_owned(),
            margin: bound.margin(*value, *limit),
            place: Place::of(place),
            stretches,
        }
    }
}
