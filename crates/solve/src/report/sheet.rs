//! The sheet of a run: the worst value of every requirement so far.
//!
//! Every requirement is checked at the end of every increment, and at every equilibrium on the way through one: where a
//! path has a corner or turns are resolved in parts, where a value changes fast ([`Sheet::parts`]), before a jump,
//! and where a cable may come nearer to an obstacle in between than at both ends, or touch it there alone
//! ([`super::passage`]).

use serde::{Deserialize, Serialize};
use wireloom_core::equilibrium::RequirementResult;
use wireloom_core::requirement::{Bound, Measure, Motion, Origin, Part, Requirement, Verdict};
use wireloom_core::{EventPlace, Moment, Network, Status};

/// Change of a value in one increment, as a fraction of its limit, above which it changes fast.
const FAST: f64 = 0.1;
/// Factor on the change of the last increment by which that of the next one is estimated.
const NEXT: f64 = 2.0;
/// Largest number of parts in which an increment is taken for the sake of a requirement.
const MOST_PARTS: f64 = 8.0;

/// Margin below which a value without an estimate of its error does not count as kept.
pub const MARGIN_WITHOUT_ERROR: f64 = 0.05;

/// A value of a requirement at one place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Found {
    /// The value, in the unit of the measure.
    pub value: f64,
    /// Estimate of its discretisation error.
    pub error: Option<f64>,
    /// Its limit, where it differs from that of the requirement.
    pub limit: Option<f64>,
    /// Where it was found.
    pub place: EventPlace,
}

impl Found {
    /// The limits of its requirement that count for it: a straight cable, whose bend radius is infinite, keeps any
    /// least one.
    pub fn limits<'r>(&self, requirement: &'r Requirement) -> impl Iterator<Item = (Bound, f64)> + use<'r> {
        let own = self.limit;
        let limits = [(Bound::Min, requirement.min), (Bound::Max, requirement.max)];
        let kept = self.value == f64::INFINITY;
        let counts = move |(bound, limit): (Bound, Option<f64>)| {
            let limit = limit.filter(|_| !(kept && bound == Bound::Min));
            Some((bound, own.unwrap_or(limit?)))
        };
        limits.into_iter().filter_map(counts)
    }
}

/// Where in an increment an equilibrium is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Here {
    /// Between its ends.
    OnTheWay,
    /// At its end.
    End,
    /// At its end, and not stable.
    UnstableEnd,
    /// At its end, and nothing determines where the harness is: it moves without a force.
    WanderingEnd,
}

/// The worst value so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Worst {
    value: f64,
    limit: f64,
    bound: Bound,
    error: Option<f64>,
    moment: Moment,
    place: EventPlace,
    /// Whether it was found between the ends of its increment.
    on_the_way: bool,
}

impl Worst {
    /// Distance from the limit relative to it (absolute for a limit of 0), less the error if `doubted`.
    fn margin(&self, doubted: bool) -> f64 {
        let error = self.error.filter(|_| doubted).unwrap_or(0.0);
        let scale = if self.limit == 0.0 { 1.0 } else { self.limit.abs() };
        let margin = (self.bound.gap(self.value, self.limit) - error) / scale;
        // What is not a number is beyond any limit.
        if margin.is_nan() { f64::NEG_INFINITY } else { margin }
    }

    /// Why a requirement with this value, whose error reaches over its limit, is not resolved; `worst` is the worst
    /// value.
    fn reaches_over(&self, worst: Option<&Self>) -> String {
        let why = "the discretisation error reaches over the limit";
        let Self { value, moment, place, .. } = self;
        if worst.is_some_and(|worst| (worst.value, &worst.moment, &worst.place) == (*value, moment, place)) {
            return why.to_owned();
        }
        format!("{why} at {place} in step `{}` ({})", moment.step, moment.increment)
    }

    /// Whether it keeps its limit, but is near it and has no estimate of its error.
    fn is_uncertain(&self) -> bool {
        self.error.is_none() && self.limit != 0.0 && (0.0..MARGIN_WITHOUT_ERROR).contains(&self.margin(false))
    }
}

/// A requirement, as far as it has been checked.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Line {
    /// Number of increments in which it was checked.
    checked: usize,
    /// The value nearest to its limit, or farthest beyond it.
    worst: Option<Worst>,
    /// The value nearest to its limit when its error is counted against it.
    doubted: Option<Worst>,
    /// The first increment in which it was checked on an equilibrium that is not stable.
    unstable: Option<Moment>,
    /// The first one in which it is about a place that nothing determines.
    wandering: Option<Moment>,
    /// Value and limit in the last two increments of the present step.
    recent: [Option<(f64, f64)>; 2],
}

/// The worst values of all requirements of a network, in their order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sheet {
    lines: Vec<Line>,
    /// Step of the last check.
    step: usize,
    /// The worst values in that step alone.
    of_step: Vec<Line>,
}

impl Sheet {
    /// Adds what was `found` for each requirement at an equilibrium of the increment `now`.
    pub fn add(&mut self, requirements: &[Requirement], found: Vec<Vec<Found>>, now: &Moment, here: Here) {
        if self.step != now.step_index {
            self.step = now.step_index;
            self.lines.iter_mut().for_each(|line| line.recent = [None; 2]);
            self.of_step.clear();
        }
        self.lines.resize_with(requirements.len(), Line::default);
        self.of_step.resize_with(requirements.len(), Line::default);
        let lines = self.lines.iter_mut().zip(&mut self.of_step);
        for (((line, of_step), requirement), found) in lines.zip(requirements).zip(found) {
            of_step.add(requirement, &found, now, here);
            line.add(requirement, &found, now, here);
        }
    }

    /// Number of parts in which the next increment of a step is taken, so that values are also checked between its
    /// ends: where a value that keeps its limit changed by more than a tenth of it in the last increment, and would
    /// reach it in the next one at twice that rate.
    pub fn parts(&self, requirements: &[Requirement], step: usize) -> usize {
        let parts = |(line, requirement): (&Line, &Requirement)| {
            let [Some((before, _)), Some((now, limit))] = line.recent else { return 1.0 };
            let (change, left) = ((now - before).abs(), (limit - now).abs());
            // What holds for every harness has limits that change from place to place.
            let watched = !line.has_failed() && requirement.origin != Origin::Always;
            let fast = watched && change > FAST * limit.abs() && NEXT * change >= left;
            if fast { (change / (FAST * limit.abs())).ceil().clamp(2.0, MOST_PARTS) } else { 1.0 }
        };
        if self.step != step {
            return 1;
        }
        self.lines.iter().zip(requirements).map(parts).fold(1.0, f64::max) as usize
    }

    /// The requirements that count in a step and have been kept so far.
    pub fn kept<'r>(
        &self,
        requirements: &'r [Requirement],
        step: usize,
    ) -> impl Iterator<Item = &'r Requirement> + use<'r, '_> {
        let counts = move |own: &Requirement| own.steps.as_ref().is_none_or(|steps| steps.contains(&step));
        let kept = |k: usize| self.lines.get(k).is_none_or(|line| !line.has_failed());
        requirements.iter().enumerate().filter(move |(k, own)| counts(own) && kept(*k)).map(|(_, own)| own)
    }

    /// The lines of the sheet, at the end of a run with this status.
    pub fn lines(&self, network: &Network, status: Status) -> Vec<RequirementResult> {
        results(&self.lines, network, status)
    }

    /// Whether the worst value of each requirement was found between the ends of its increment.
    pub fn on_the_way(&self) -> Vec<bool> {
        self.lines.iter().map(|line| line.worst.as_ref().is_some_and(|worst| worst.on_the_way)).collect()
    }

    /// Those of [`Self::lines`] for the step of the last check alone.
    pub fn lines_of_step(&self, network: &Network, status: Status) -> Vec<RequirementResult> {
        results(&self.of_step, network, status)
    }
}

fn results(lines: &[Line], network: &Network, status: Status) -> Vec<RequirementResult> {
    let none = Line::default();
    let requirements = network.requirements.iter().enumerate();
    requirements
        .map(|(k, requirement)| {
            let line = lines.get(k).unwrap_or(&none).result(requirement, status);
            let remark = cable_alone(network, requirement).filter(|_| line.worst.is_some());
            RequirementResult { reason: line.reason.or(remark), ..line }
        })
        .collect()
}

impl Line {
    /// Whether a value was beyond its limit.
    fn has_failed(&self) -> bool {
        self.worst.as_ref().is_some_and(|worst| worst.margin(false) < 0.0)
    }

    /// Adds what was found at an equilibrium.
    fn add(&mut self, requirement: &Requirement, found: &[Found], now: &Moment, here: Here) {
        self.checked += usize::from(!found.is_empty());
        if here == Here::UnstableEnd && !found.is_empty() {
            self.unstable.get_or_insert_with(|| now.clone());
        }
        let of_place = matches!(requirement.measure, Measure::Clearance | Measure::Deviation);
        if here == Here::WanderingEnd && of_place && !found.is_empty() {
            self.wandering.get_or_insert_with(|| now.clone());
        }
        let mut worst_here: Option<Worst> = None;
        for found in found {
            for (bound, limit) in found.limits(requirement) {
                let Found { value, error, place, .. } = found.clone();
                let on_the_way = here == Here::OnTheWay;
                let worst = Worst { value, limit, bound, error, moment: now.clone(), place, on_the_way };
                keep(&mut self.worst, &worst, false);
                keep(&mut self.doubted, &worst, true);
                keep(&mut worst_here, &worst, false);
            }
        }
        if here != Here::OnTheWay {
            self.recent = [self.recent[1], worst_here.map(|worst| (worst.value, worst.limit))];
        }
    }

    fn result(&self, requirement: &Requirement, status: Status) -> RequirementResult {
        let failed = self.has_failed();
        let doubted = self.doubted.as_ref().filter(|doubted| !failed && doubted.margin(true) < 0.0);
        let (verdict, reason) = if failed {
            (Verdict::Fail, None)
        } else if status != Status::Converged {
            (Verdict::Unresolved, Some(format!("the run did not come to its end: {}", status.word())))
        } else if self.checked == 0 {
            (Verdict::NotChecked, Some(why_not_checked(requirement)))
        } else if let Some(moment) = &self.unstable {
            let Moment { step, increment, .. } = moment;
            let why = format!("the equilibrium of step `{step}`, increment {increment}, is not stable");
            (Verdict::Unresolved, Some(why))
        } else if let Some(Moment { step, increment, .. }) = &self.wandering {
            let why = format!(
                "nothing determines where the harness is in step `{step}`, increment {increment}: it moves without a \
                 force"
            );
            (Verdict::Unresolved, Some(why))
        } else if let Some(doubted) = doubted {
            (Verdict::Unresolved, Some(doubted.reaches_over(self.worst.as_ref())))
        } else if self.worst.as_ref().is_some_and(Worst::is_uncertain) {
            let why = format!(
                "its discretisation error is not known, and it is within {} % of its limit",
                1e2 * MARGIN_WITHOUT_ERROR
            );
            (Verdict::Unresolved, Some(why))
        } else {
            (Verdict::Pass, None)
        };
        let shown = self.worst.as_ref();
        let limits = [(Bound::Min, requirement.min), (Bound::Max, requirement.max)];
        let first = limits.into_iter().find_map(|(bound, limit)| Some((limit?, bound)));
        let (limit, bound) = shown.map(|worst| (worst.limit, worst.bound)).or(first).unwrap_or((0.0, Bound::Max));
        RequirementResult {
            name: requirement.name.clone(),
            origin: requirement.origin,
            measure: requirement.measure,
            severity: requirement.severity,
            because: requirement.because.clone(),
            verdict,
            reason,
            worst: shown.map(|worst| worst.value),
            limit,
            bound,
            error: shown.and_then(|worst| worst.error),
            moment: shown.map(|worst| worst.moment.clone()),
            place: shown.map(|worst| worst.place.clone()).unwrap_or_default(),
        }
    }
}

/// Keeps the worse of two values; the first of equals.
fn keep(worst: &mut Option<Worst>, found: &Worst, doubted: bool) {
    if worst.as_ref().is_none_or(|worst| found.margin(doubted) < worst.margin(doubted)) {
        *worst = Some(found.clone());
    } else if let Some(worst) = worst
        && worst.on_the_way
        && *worst == (Worst { on_the_way: true, ..found.clone() })
    {
        // What stayed the same up to the end of its increment is a value of that end.
        worst.on_the_way = found.on_the_way;
    }
}

/// A remark on insertion forces that are less than those of the connectors, whose own part is not known.
fn cable_alone(network: &Network, requirement: &Requirement) -> Option<String> {
    let unknown = |part: &Part| match *part {
        Part::Constraint(f) if requirement.measure == Measure::InsertionForce => {
            Some(&network.constraints[f]).filter(|constraint| constraint.limits.insertion_force.is_none())
        }
        _ => None,
    };
    let names: Vec<String> = requirement.of.iter().filter_map(unknown).map(|plug| format!("`{}`", plug.name)).collect();
    let of = names.join(", ");
    (!names.is_empty()).then(|| format!("force of the cable alone: the `insertion_force` of {of} itself is not given"))
}

/// Why a requirement was never checked.
fn why_not_checked(requirement: &Requirement) -> String {
    let why = match (requirement.motion, requirement.measure) {
        (Motion::Moving, _) => "it did not move in these steps",
        (Motion::Rest, _) => "it was never at rest in these steps",
        (_, Measure::InsertionForce) => "it was not pushed in in these steps",
        (_, Measure::Force | Measure::Moment) => "it did not act in these steps",
        (..) if requirement.origin == Origin::Always => "there is nothing to check",
        _ => "nothing of it was there in these steps",
    };
    why.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::requirement::Severity;

    #[test]
    fn a_value_near_its_limit_whose_error_is_not_known_does_not_pass() {
        let requirement = Requirement {
            name: "pressed".to_owned(),
            origin: Origin::Scenario,
            measure: Measure::ContactForce,
            of: vec![],
            against: vec![],
            min: None,
            max: Some(10.0),
            steps: None,
            motion: Motion::Any,
            severity: Severity::Must,
            because: None,
        };
        let verdict = |value: f64, error: Option<f64>| {
            let mut sheet = Sheet::default();
            let found = Found { value, error, limit: None, place: EventPlace::default() };
            let now = Moment { step: "push".to_owned(), step_index: 0, increment: 1 };
            sheet.add(std::slice::from_ref(&requirement), vec![vec![found]], &now, Here::End);
            let line = sheet.lines[0].result(&requirement, Status::Converged);
            assert_eq!(line.reason.is_some(), line.verdict == Verdict::Unresolved, "{:?}", line.reason);
            line.verdict
        };
        assert_eq!(verdict(9.6, None), Verdict::Unresolved);
        assert_eq!(verdict(9.6, Some(0.3)), Verdict::Pass);
        assert_eq!(verdict(9.6, Some(0.5)), Verdict::Unresolved);
        assert_eq!(verdict(9.4, None), Verdict::Pass);
        assert_eq!(verdict(10.1, None), Verdict::Fail);
    }
}
