//! One design: its text, its run, and how far its requirements are kept in each step.

use super::parts;
use crate::sensitivity::{NoAnswer, Source, Study};
use nalgebra::DVector;
use wireloom_core::Network;
use wireloom_core::equilibrium::RequirementResult;
use wireloom_core::requirement::{self, Bound, Measure, Origin, Severity, Verdict};
use wireloom_scenario::optimise::{Minimised, Optimise};
use wireloom_solve::report::MARGIN_WITHOUT_ERROR;

/// Margin beyond what is asked for, relative to the limit: room for the accuracy of the method.
pub(super) const INSIDE: f64 = 2e-4;

/// Worst value of a requirement in a step.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// Index of the requirement or its part.
    pub requirement: usize,
    /// Its name, of a part that of the whole.
    pub name: String,
    /// Index of the step.
    pub step: usize,
    /// Increment of the worst value, from 1.
    pub increment: usize,
    /// The worst value, in the unit of its measure.
    pub worst: f64,
    /// Whether it must be kept.
    pub must: bool,
    /// Whether its margin is relative to a limit, as that of all but some of what holds for every harness.
    pub is_relative: bool,
    /// Side of its limit.
    pub bound: Bound,
    /// How far it is kept, as a constraint: zero where it is kept with the margin asked for.
    pub kept: f64,
    /// Derivative of `kept` by the worst value.
    pub kept_slope: f64,
    /// Distance from the limit less the error, relative to the limit.
    pub margin: f64,
    /// Derivative of `margin` by the worst value.
    pub margin_slope: f64,
    /// Gradient of the worst value by the scaled variables, once it is known.
    pub gradient: Option<DVector<f64>>,
}

impl Line {
    fn new(requirement: usize, line: &RequirementResult, margin: f64) -> Option<Self> {
        let (worst, moment) = (line.worst.filter(|worst| !worst.is_nan())?, line.moment.as_ref()?);
        let limit = line.limit;
        let scale = if limit == 0.0 { 1.0 } else { limit.abs() };
        let sign = if line.bound == Bound::Min { 1.0 } else { -1.0 };
        let error = line.error.unwrap_or(if limit == 0.0 { 0.0 } else { MARGIN_WITHOUT_ERROR * scale });
        let own = (line.bound.gap(worst, limit) - error) / scale;
        // A radius is the inverse of what bends, in which requirements are nearly linear; also of a straight cable.
        let doubted = worst - sign * error;
        let bends = line.measure == Measure::BendRadius && limit > 0.0 && doubted > 0.0;
        let (kept, kept_slope) = if bends {
            (sign * (1.0 - limit / doubted), sign * limit / (doubted * doubted))
        } else {
            (own, sign / scale)
        };
        Some(Self {
            requirement,
            name: parts::whole(&line.name).to_owned(),
            step: moment.step_index,
            increment: moment.increment,
            worst,
            must: line.severity == Severity::Must,
            is_relative: line.origin != Origin::Always || limit != 0.0,
            bound: line.bound,
            // What holds for every harness may be exactly as it should be, such as a span that is just taut: no margin
            // is asked of it.
            kept: if line.origin == Origin::Always { own - INSIDE } else { kept - margin - INSIDE },
            kept_slope: if line.origin == Origin::Always { sign / scale } else { kept_slope },
            margin: own,
            margin_slope: sign / scale,
            gradient: None,
        })
    }

    /// What is minimised where the requirement is: smaller is better.
    pub fn badness(&self) -> f64 {
        self.badness_slope() * self.worst
    }

    /// Derivative of [`Self::badness`] by the worst value.
    pub fn badness_slope(&self) -> f64 {
        if self.bound == Bound::Min { -1.0 } else { 1.0 }
    }

    /// Whether it is the same requirement in the same step.
    pub fn is_of(&self, other: &Line) -> bool {
        self.requirement == other.requirement && self.step == other.step
    }
}

/// Why a design has no run.
pub(super) enum NoRun {
    /// It was stopped.
    Stopped,
    /// It failed.
    Failed(String),
}

/// A design that was run to its end.
pub(super) struct Evaluation<'a> {
    /// Its text.
    pub text: String,
    /// Values of its variables as they are written, SI.
    pub values: Vec<f64>,
    /// The same as fractions of their ranges.
    pub at: DVector<f64>,
    /// Length and mass in the objective, with their weights.
    pub smooth: f64,
    /// Gradient of `smooth`, once it is known.
    pub smooth_gradient: Option<DVector<f64>>,
    /// Worst values of all requirements in all steps.
    pub lines: Vec<Line>,
    /// The objective.
    pub objective: f64,
    /// Verdict of the run.
    pub verdict: Verdict,
    /// The run.
    pub study: Study<'a>,
}

impl<'a> Evaluation<'a> {
    /// Runs a design.
    ///
    /// # Errors
    /// If its run failed, or was stopped.
    pub fn run(source: Source<'a>, optimise: &Optimise, values: Vec<f64>, at: DVector<f64>) -> Result<Self, NoRun> {
        let text = source.text.clone().into_owned();
        let ran = Study::with_requirements(source, parts::divide).and_then(|mut study| {
            let last = study.steps().len() - 1;
            study.run_to(last)?;
            Ok(study)
        });
        let study = match ran {
            Ok(study) => study,
            Err(NoAnswer::Stopped) => return Err(NoRun::Stopped),
            Err(NoAnswer::Faults(faults)) => {
                let words = faults.first().map_or_else(String::new, |fault| fault.message.clone());
                return Err(NoRun::Failed(format!("refused: {words}")));
            }
            Err(other) => return Err(NoRun::Failed(other.to_string())),
        };
        let steps = study.ends().iter().skip(1);
        let lines: Vec<Line> = steps
            .flat_map(|end| end.requirements_of_step.iter().enumerate())
            .filter_map(|(k, line)| Line::new(k, line, optimise.margin))
            .collect();
        let verdict = study.ends().last().map_or(Verdict::Unresolved, |end| verdict(&end.requirements));
        let smooth = smooth(optimise, study.network());
        let mut objective = smooth;
        for term in &optimise.terms {
            let Some(worst) = worst_of(&lines, &term.of) else {
                if matches!(term.of, Minimised::Length | Minimised::Mass) {
                    continue;
                }
                let words = format!("`{}` has no value in this run", term.of);
                return Err(NoRun::Failed(words));
            };
            if !worst.is_finite() {
                return Err(NoRun::Failed(format!("`{}` is not finite in this run: a cable is straight", term.of)));
            }
            objective += term.weight * worst;
        }
        Ok(Self { text, values, at, smooth, smooth_gradient: None, lines, objective, verdict, study })
    }

    /// The constraint that is kept least.
    pub fn tightest(&self) -> Option<&Line> {
        let musts = self.lines.iter().filter(|line| line.must);
        musts.min_by(|a, b| a.kept.total_cmp(&b.kept))
    }

    /// Whether all requirements are kept, with the margin asked for.
    pub fn is_kept(&self) -> bool {
        self.verdict == Verdict::Pass && self.tightest().is_none_or(|line| line.kept >= -INSIDE)
    }

    /// Sum of what requirements lack.
    pub fn violation(&self) -> f64 {
        self.lines.iter().filter(|line| line.must).map(|line| (-line.kept).max(0.0)).sum()
    }
}

/// Lines of which the largest value counts in a term, each with value and slope; empty for lengths and masses.
pub(super) fn counted<'l>(lines: &'l [Line], of: &'l Minimised) -> impl Iterator<Item = (&'l Line, f64, f64)> {
    lines.iter().filter_map(move |line| match of {
        Minimised::Requirement(name) if *name == line.name => Some((line, line.badness(), line.badness_slope())),
        Minimised::WorstMargin if line.must && line.is_relative => Some((line, -line.margin, -line.margin_slope)),
        _ => None,
    })
}

fn worst_of(lines: &[Line], of: &Minimised) -> Option<f64> {
    counted(lines, of).map(|(_, value, _)| value).reduce(f64::max)
}

/// Verdict on a sheet by parts: of a requirement it is enough that one part was checked.
fn verdict(sheet: &[RequirementResult]) -> Verdict {
    let checked = |name: &str| {
        let others = sheet.iter().filter(|line| parts::whole(&line.name) == name);
        others.into_iter().any(|line| line.verdict != Verdict::NotChecked)
    };
    let counts = |line: &&RequirementResult| line.verdict != Verdict::NotChecked || !checked(parts::whole(&line.name));
    let sheet: Vec<RequirementResult> = sheet.iter().filter(counts).cloned().collect();
    requirement::verdict(&sheet)
}

/// Lengths and masses in the objective, with their weights.
pub(super) fn smooth(optimise: &Optimise, network: &Network) -> f64 {
    let term = |of: &Minimised| -> f64 {
        let branches = network.branches.iter();
        match of {
            Minimised::Length => branches.map(|branch| branch.rod.mesh().length()).sum(),
            Minimised::Mass => branches.map(wireloom_core::network::Branch::mass).sum(),
            Minimised::WorstMargin | Minimised::Requirement(_) => 0.0,
        }
    };
    optimise.terms.iter().map(|own| own.weight * term(&own.of)).sum()
}
