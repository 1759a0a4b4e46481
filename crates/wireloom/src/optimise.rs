//! Optimisation: numbers and words of a scenario chosen so that an objective is smallest and all requirements are kept,
//! as its `[optimise]` asks for.
//!
//! ```
//! use wireloom::optimise::{Ending, Search};
//! use wireloom::scenario::NoFiles;
//! use wireloom::sensitivity::Source;
//!
//! let text = std::fs::read_to_string("../../scenarios/optimise/shortest_cable.toml")?;
//! let registry = wireloom::registry();
//! let search = Search::new(Source::new(&text, &NoFiles, &registry)).expect("it has an [optimise]");
//! let found = search.run(&mut |design| println!("{:?}: {:?}", design.values, design.objective));
//! let found = found.expect("its choices can be written");
//! let optimum = found.optimum.expect("one that keeps all requirements");
//! println!("{} m after {} runs", optimum.objective, found.counts.runs);
//! # assert_eq!(found.ending, Ending::Converged);
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! # Method
//!
//! Variables are scaled to their ranges. A design is the text of the scenario with values written into it, and its
//! run. Every requirement is a constraint by itself in every step, for every part and for both halves of a cable, so
//! that the model has no kink where another place becomes the worst: its margin less the estimated discretisation
//! error, the margin that `[optimise]` asks for, and 2e-4. Of a bend radius the margin is that of the curvature. Worst
//! values in the objective are linearised in the same way.
//!
//! From a start the method is sequential quadratic programming with an exact penalty in a trust region (Fletcher 1987,
//! sections 12.4 and 14.4; Nocedal and Wright 2006, section 18.5): linear models of the worst values and of the
//! constraints, and a damped BFGS approximation of the Hessian of the Lagrangian. Derivatives are those of the
//! equilibrium in which a requirement is at its worst in its step ([`crate::sensitivity`]): no runs. A step that leaves
//! the requirements is corrected by a second one, with the gradients there. Where there are no derivatives, they are
//! differences of further runs, which are counted. The program of each step is solved by Clarabel (interior point). A
//! design whose run fails is a step that was too long.
//!
//! Every combination of choices is searched by itself, from each start. The best design is run once more, from its text
//! alone; it counts only if that run converges with the verdict "pass".

mod evaluation;
mod gradient;
mod parts;
mod subproblem;
mod text;

use crate::halton::halton;
use crate::sensitivity::Source;
use evaluation::{Evaluation, INSIDE, Line, NoRun, counted};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use std::borrow::Cow;
use subproblem::{Linear, Model, Proposal};
use wireloom_core::equilibrium::Run;
use wireloom_core::requirement::Verdict;
use wireloom_core::{Monitor, Registry, Status};
use wireloom_scenario::optimise::{Choice, Optimise};
use wireloom_scenario::{Fault, Files, Setting, number_at, record};
use wireloom_solve::Control;

/// First size of the trust region, as a fraction of the ranges.
const FIRST_RADIUS: f64 = 0.2;
/// Size below which the model has nothing more to say.
const LEAST_RADIUS: f64 = 1e-5;
/// Size of the trust region for which a design at its end promises nothing more.
const PROMISE: f64 = 0.05;
/// Sum of violations, relative to their limits, up to which a second step leads back to the requirements.
const CORRECTED: f64 = 0.5;
/// Size at which a search begins again with gradients from runs.
const AGAIN_RADIUS: f64 = 0.02;
/// Least ratio of the actual and the predicted decrease of a step that is taken; below the second one the trust region
/// shrinks, above the third one it grows.
const RATIOS: [f64; 3] = [1e-3, 0.25, 0.75];
/// Factor on the step for the next trust region after a poor step.
const SHRINK: f64 = 0.3;
/// The same after a run that failed.
const SHRINK_FAILED: f64 = 0.25;
/// Factor on a trust region that was filled by a good step.
const GROW: f64 = 2.5;
/// First penalty of constraints, for an objective of the size 1.
const PENALTY: f64 = 10.0;
/// Largest penalty.
const MOST_PENALTY: f64 = 1e6;
/// Penalty of the merit function that judges a step, in units of the largest multiplier.
const MERIT: f64 = 3.0;
/// Its least value.
const LEAST_MERIT: f64 = 0.05;
/// Least decrease of that merit function, as a fraction of that with the full penalty; below it the full one judges.
const ENOUGH: f64 = 0.1;
/// Factor on a penalty that leaves a violation.
const RAISE: f64 = 10.0;
/// Numbers are written with this resolution, as a fraction of their range.
const RESOLUTION: f64 = 1e-7;
/// Largest number of designs of which a certificate is tried.
const CANDIDATES: usize = 5;
/// Distance of the best design from the best local optimum that is round-off of both, in units of the accuracy.
const SAME_OPTIMUM: f64 = 3.0;
/// Of damped BFGS (Powell).
const DAMPING: f64 = 0.2;

/// Why a design was run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// To start from.
    Start,
    /// As a step of the method.
    Step,
    /// For a difference, where there is no derivative.
    Difference,
    /// For the certificate.
    Certificate,
}

/// A design that was run: a row of the table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Design {
    /// Number of the run, from 1.
    pub run: usize,
    /// Number of the search, from 1: one for each start of each combination of choices.
    pub search: usize,
    /// Why it was run.
    pub kind: Kind,
    /// Values of the variables: numbers in SI units, or words.
    pub values: Vec<String>,
    /// Whether the run converged; otherwise why not.
    pub failure: Option<String>,
    /// The objective.
    pub objective: Option<f64>,
    /// The requirement that is nearest to its limit, and the step.
    pub tightest: Option<String>,
    /// Its margin: distance from the limit less the discretisation error, relative to the limit.
    pub margin: Option<f64>,
    /// The verdict.
    pub verdict: Option<String>,
}

/// Numbers of what an optimisation took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Runs of the scenario.
    pub runs: usize,
    /// Of these, runs that failed: each shortened a step, or ended a start.
    pub failed: usize,
    /// Runs for differences where derivatives do not exist.
    pub differences: usize,
    /// Equilibria at which derivatives were taken.
    pub gradients: usize,
}

/// How an optimisation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ending {
    /// The best design is a local optimum, and its certificate holds.
    Converged,
    /// Requirements are kept, but no step leads further, though the model promises a better design.
    Stuck,
    /// The largest number of runs was reached.
    OutOfRuns,
    /// No design was found that keeps all requirements.
    Infeasible,
    /// No start has a run that converges.
    NoStart,
    /// It was stopped.
    Stopped,
}

impl Ending {
    /// In words, for users.
    pub fn words(self) -> &'static str {
        match self {
            Ending::Converged => "converged",
            Ending::Stuck => "not converged: no step leads further",
            Ending::OutOfRuns => "not converged: the largest number of runs was reached",
            Ending::Infeasible => "no design was found that keeps all requirements",
            Ending::NoStart => "no start has a run that converges",
            Ending::Stopped => "stopped",
        }
    }
}

/// The best design that keeps all requirements.
#[derive(Clone, Debug)]
pub struct Optimum {
    /// Number of its run.
    pub run: usize,
    /// The scenario, with the comments of its author.
    pub text: String,
    /// Values of the variables, as in [`Design::values`].
    pub values: Vec<String>,
    /// The objective.
    pub objective: f64,
    /// A fresh run of the text; `None` if it was stopped before.
    pub certificate: Option<Run>,
}

/// What an optimisation found.
#[derive(Clone, Debug)]
pub struct Optimisation {
    /// Keys of the variables.
    pub keys: Vec<String>,
    /// Their SI units; empty for pure numbers and words.
    pub units: Vec<String>,
    /// All designs, in the order of their runs.
    pub designs: Vec<Design>,
    /// The best one that keeps all requirements.
    pub optimum: Option<Optimum>,
    /// How it ended.
    pub ending: Ending,
    /// What it took.
    pub counts: Counts,
}

/// Reason why there is no optimisation.
#[derive(Clone, Debug, thiserror::Error)]
pub enum NoOptimum {
    /// The scenario has faults.
    #[error("the scenario has faults")]
    Faults(Vec<Fault>),
    /// It has no `[optimise]`.
    #[error("the scenario has no [optimise]: add one, with the keys to `vary` and what to `minimise`")]
    NothingAsked,
    /// It was stopped.
    #[error("stopped")]
    Stopped,
}

/// A variable that may have any value of a range.
struct Range {
    key: String,
    unit: String,
    from: f64,
    to: f64,
}

/// How the search from one start ended.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Local {
    Optimum,
    Stuck,
    Infeasible,
    NoStart,
    OutOfRuns,
}

/// A design that keeps all requirements.
struct Candidate {
    run: usize,
    text: String,
    values: Vec<String>,
    objective: f64,
}

/// An optimisation at work.
pub struct Search<'a> {
    text: Cow<'a, str>,
    files: &'a dyn Files,
    registry: &'a Registry,
    monitor: Monitor,
    optimise: Optimise,
    ranges: Vec<Range>,
    /// The present search, from 1, and the choices in it.
    search: usize,
    designs: Vec<Design>,
    /// The designs that were not shown yet begin here.
    shown: usize,
    candidates: Vec<Candidate>,
    /// Objectives of the local optima.
    optima: Vec<f64>,
    counts: Counts,
    keeps_history: bool,
}

impl<'a> Search<'a> {
    /// Reads a scenario.
    ///
    /// # Errors
    /// Its faults; if it has no `[optimise]`.
    pub fn new(source: Source<'a>) -> Result<Self, NoOptimum> {
        let Source { text, files, registry, monitor } = source;
        let (scenario, _) = crate::load_with_files(&text, files, registry).map_err(NoOptimum::Faults)?;
        let Some(optimise) = scenario.optimise else { return Err(NoOptimum::NothingAsked) };
        let range = |variable: &wireloom_scenario::optimise::Variable| match &variable.choice {
            Choice::Values(_) => None,
            Choice::Between { from, to, .. } => {
                let unit = number_at(&text, &variable.key, registry).map(|number| number.unit).unwrap_or_default();
                Some(Range { key: variable.key.clone(), unit, from: *from, to: *to })
            }
        };
        let ranges = optimise.variables.iter().filter_map(range).collect();
        Ok(Self {
            text,
            files,
            registry,
            monitor,
            optimise,
            ranges,
            search: 0,
            designs: Vec::new(),
            shown: 0,
            candidates: Vec::new(),
            optima: Vec::new(),
            counts: Counts::default(),
            keeps_history: false,
        })
    }

    /// Keys of the variables.
    pub fn keys(&self) -> Vec<String> {
        self.optimise.variables.iter().map(|variable| variable.key.clone()).collect()
    }

    /// Searches. `observer` is called for every design, after its run.
    ///
    /// # Errors
    /// If a choice cannot be written into the text.
    pub fn run(mut self, observer: &mut dyn FnMut(&Design)) -> Result<Optimisation, NoOptimum> {
        let searched = self.search_all(observer);
        let (optimum, mut ending) = match searched {
            Ok(local) => {
                let certified = self.certify(observer);
                let ending = match (&certified, local) {
                    (Some((_, 0)), Local::Optimum) => Ending::Converged,
                    (Some(_), Local::OutOfRuns) => Ending::OutOfRuns,
                    (Some(_), _) => Ending::Stuck,
                    (None, Local::NoStart) => Ending::NoStart,
                    (None, Local::OutOfRuns) => Ending::OutOfRuns,
                    (None, _) => Ending::Infeasible,
                };
                (certified.map(|(optimum, _)| optimum), ending)
            }
            Err(NoOptimum::Stopped) => (None, Ending::Stopped),
            Err(other) => return Err(other),
        };
        let mut optimum = optimum;
        if self.monitor.is_stopped() {
            ending = Ending::Stopped;
            // The best design is kept, without a certificate.
            self.candidates.sort_by(|a, b| a.objective.total_cmp(&b.objective));
            let best = self.candidates.drain(..).next();
            optimum = optimum.or(best.map(|best| best.with_certificate(None)));
        }
        let unit = |variable: &wireloom_scenario::optimise::Variable| {
            let range = self.ranges.iter().find(|range| range.key == variable.key);
            range.map_or_else(String::new, |range| range.unit.clone())
        };
        Ok(Optimisation {
            keys: self.keys(),
            units: self.optimise.variables.iter().map(unit).collect(),
            designs: self.designs,
            optimum,
            ending,
            counts: self.counts,
        })
    }

    /// All starts of all combinations of choices.
    fn search_all(&mut self, observer: &mut dyn FnMut(&Design)) -> Result<Local, NoOptimum> {
        let (combinations, starts) = (self.optimise.combinations(), self.optimise.starts);
        let mut all = Vec::new();
        for start in 0..starts {
            for choices in &combinations {
                if self.counts.runs >= self.optimise.runs {
                    return Ok(Local::OutOfRuns);
                }
                self.search += 1;
                let text = self.with_choices(choices)?;
                let at = self.start(&text, start);
                let local = self.descend(&text, at, observer);
                self.show(observer);
                all.push(local?);
            }
            // Without ranges one design is all there is of a combination.
            if self.ranges.is_empty() {
                break;
            }
        }
        // The best design decides: whether it is a local optimum, to the accuracy; if there is none, what was reached.
        let least = |objectives: &mut dyn Iterator<Item = f64>| objectives.reduce(f64::min);
        let best = least(&mut self.candidates.iter().map(|candidate| candidate.objective));
        let optimum = least(&mut self.optima.iter().copied()).unwrap_or(f64::INFINITY);
        let any = |local: Local| all.contains(&local);
        Ok(match best {
            _ if any(Local::OutOfRuns) => Local::OutOfRuns,
            Some(best) if optimum - best <= SAME_OPTIMUM * self.optimise.accuracy * best.abs() => Local::Optimum,
            Some(_) => Local::Stuck,
            None if any(Local::Infeasible) || any(Local::Stuck) => Local::Infeasible,
            None => Local::NoStart,
        })
    }

    /// The text with these choices.
    fn with_choices(&self, choices: &[Setting]) -> Result<String, NoOptimum> {
        let with = |text: String, choice: &Setting| {
            let value = toml_value(&choice.value);
            record::with_json(&text, &choice.key, &value, self.registry).map_err(|fault| NoOptimum::Faults(vec![fault]))
        };
        choices.iter().try_fold(self.text.clone().into_owned(), with)
    }

    /// A start: the values of the text, then points that fill the ranges evenly (Halton's sequence).
    fn start(&self, text: &str, number: usize) -> DVector<f64> {
        let at = |(k, range): (usize, &Range)| {
            let own = number_at(text, &range.key, self.registry).map_or(range.from, |number| number.value);
            if number > 0 { halton(number, k) } else { ((own - range.from) / (range.to - range.from)).clamp(0.0, 1.0) }
        };
        DVector::from_iterator(self.ranges.len(), self.ranges.iter().enumerate().map(at))
    }

    /// Shows the designs that were not shown yet.
    fn show(&mut self, observer: &mut dyn FnMut(&Design)) {
        self.designs[self.shown..].iter().for_each(observer);
        self.shown = self.designs.len();
    }

    /// The text with the numbers at a point, and the numbers as they are written.
    fn written(&self, text: &str, at: &DVector<f64>) -> Result<(String, Vec<f64>), Fault> {
        let mut own = text.to_owned();
        let mut values = Vec::with_capacity(self.ranges.len());
        for (range, at) in self.ranges.iter().zip(at.iter()) {
            let (width, bounds) = (range.to - range.from, [range.from, range.to]);
            let value = (range.from + at * width).clamp(range.from, range.to);
            let (next, value) = text::with_number(&own, &range.key, value, RESOLUTION * width, bounds, self.registry)?;
            own = next;
            values.push(value);
        }
        Ok((own, values))
    }

    /// Runs a design, and keeps its row. `None` if its run fails.
    fn evaluate(&mut self, text: &str, at: &DVector<f64>, kind: Kind) -> Result<Option<Evaluation<'a>>, NoOptimum> {
        let (words, evaluated) = match self.written(text, at) {
            Ok((own, values)) => {
                let fraction = |(range, value): (&Range, &f64)| (value - range.from) / (range.to - range.from);
                let at = DVector::from_iterator(values.len(), self.ranges.iter().zip(&values).map(fraction));
                let words = self.words(&own, &values);
                let source = Source { monitor: self.monitor.clone(), ..Source::new(own, self.files, self.registry) };
                match Evaluation::run(source, &self.optimise, values, at) {
                    Ok(design) => (words, Ok(design)),
                    Err(NoRun::Failed(reason)) => (words, Err(reason)),
                    Err(NoRun::Stopped) => return Err(NoOptimum::Stopped),
                }
            }
            Err(fault) => (vec![String::new(); self.optimise.variables.len()], Err(fault.message)),
        };
        self.counts.runs += 1;
        self.counts.differences += usize::from(kind == Kind::Difference);
        let mut row = Design {
            run: self.counts.runs,
            search: self.search,
            kind,
            values: words,
            failure: None,
            objective: None,
            tightest: None,
            margin: None,
            verdict: None,
        };
        let design = match evaluated {
            Ok(design) => design,
            Err(words) => {
                self.counts.failed += 1;
                row.failure = Some(words);
                self.designs.push(row);
                return Ok(None);
            }
        };
        let tightest = design.tightest();
        let step = |line: &Line| design.study.steps()[line.step].name.clone();
        row.tightest = tightest.map(|line| format!("{} ({})", line.name, step(line)));
        row.margin = tightest.map(|line| line.margin);
        row.objective = Some(design.objective);
        row.verdict = Some(design.verdict.word().to_owned());
        if design.is_kept() {
            self.candidates.push(Candidate {
                run: row.run,
                text: design.text.clone(),
                values: row.values.clone(),
                objective: design.objective,
            });
        }
        self.designs.push(row);
        Ok(Some(design))
    }

    /// Values of all variables, for rows.
    fn words(&self, text: &str, values: &[f64]) -> Vec<String> {
        let mut numbers = values.iter();
        let word = |variable: &wireloom_scenario::optimise::Variable| match &variable.choice {
            Choice::Between { .. } => numbers.next().map_or_else(String::new, f64::to_string),
            Choice::Values(_) => match record::value_at(text, &variable.key) {
                Ok(serde_json::Value::String(word)) => word,
                Ok(other) => other.to_string(),
                Err(_) => String::new(),
            },
        };
        self.optimise.variables.iter().map(word).collect()
    }

    /// The search from one start.
    fn descend(
        &mut self,
        text: &str,
        start: DVector<f64>,
        observer: &mut dyn FnMut(&Design),
    ) -> Result<Local, NoOptimum> {
        let Some(mut here) = self.evaluate(text, &start, Kind::Start)? else { return Ok(Local::NoStart) };
        self.show(observer);
        let n = self.ranges.len();
        if n == 0 {
            return Ok(self.end_at(&here, true));
        }
        let scale = 1.0 / here.objective.abs().max(f64::MIN_POSITIVE.sqrt());
        let scale = if scale.is_finite() && scale < 1e6 { scale } else { 1.0 };
        let (mut radius, mut penalty, mut by_runs, mut after_rejection) = (FIRST_RADIUS, PENALTY, false, false);
        let mut rejected;
        let mut hessian = DMatrix::zeros(n, n);
        self.keeps_history = false;
        self.differentiate(&mut here, by_runs)?;
        loop {
            self.show(observer);
            let model = self.model(&here, &hessian, scale, penalty);
            let lower = here.at.map(|at| (-at).max(-radius));
            let upper = here.at.map(|at| (1.0 - at).min(radius));
            let Some(proposal) = model.minimise(&lower, &upper) else { return Ok(self.end_at(&here, false)) };
            let kept = here.violation() <= 0.5 * INSIDE;
            let length = proposal.step.amax();
            // A small trust region hides what a larger one would promise.
            let hidden = if length > 0.9 * radius { (PROMISE / radius).max(1.0) } else { 1.0 };
            let least = self.optimise.accuracy * (scale * here.objective.abs()).max(f64::EPSILON);
            if proposal.decrease * hidden <= least {
                if kept {
                    return Ok(self.end_at(&here, true));
                }
                if here.violation() > 0.0 && penalty < MOST_PENALTY {
                    penalty *= RAISE;
                    continue;
                }
                return Ok(self.end_at(&here, false));
            }
            if self.counts.runs >= self.optimise.runs {
                return Ok(Local::OutOfRuns);
            }
            let mut trial = self.evaluate(text, &(&here.at + &proposal.step), Kind::Step)?;
            // A penalty far above the multipliers would allow only steps along the requirements, which are curved.
            let multiplier = proposal.of_requirements.iter().copied().fold(0.0, f64::max);
            let weight = (MERIT * multiplier).clamp(LEAST_MERIT, penalty);
            let decrease = proposal.decrease - (penalty - weight) * (here.violation() - proposal.violation);
            let enough = decrease >= ENOUGH * proposal.decrease;
            let (weight, decrease) = if enough { (weight, decrease) } else { (penalty, proposal.decrease) };
            let merit = |design: &Evaluation<'_>| scale * design.objective + weight * design.violation();
            let gain = |trial: &Evaluation<'_>| (merit(&here) - merit(trial)) / decrease;
            let mut ratio = trial.as_ref().map(gain);
            if let Some(beyond) = trial.as_mut().filter(|beyond| {
                gain(beyond) <= RATIOS[0] && (0.0..CORRECTED).contains(&beyond.violation()) && beyond.violation() > 0.0
            }) {
                // Requirements are curved: a second step, with their gradients there, leads back to them.
                self.differentiate(beyond, by_runs)?;
                self.update(&mut hessian, &here, beyond, &proposal, scale);
                let model = self.model(beyond, &hessian, scale, penalty);
                let around = |bound: f64| &here.at.map(|at| (at + bound).clamp(0.0, 1.0)) - &beyond.at;
                if let Some(back) = model.minimise(&around(-radius), &around(radius)) {
                    let corrected = self.evaluate(text, &(&beyond.at + &back.step), Kind::Step)?;
                    ratio = corrected.as_ref().map(gain).or(ratio);
                    trial = corrected;
                }
            }
            rejected = trial.is_none() || ratio.is_none_or(|ratio| ratio <= RATIOS[0]);
            match ratio {
                None => radius = SHRINK_FAILED * length,
                Some(ratio) if ratio < RATIOS[1] => radius = SHRINK * length,
                // Not back to where a step has just failed.
                Some(ratio) if ratio > RATIOS[2] && length > 0.9 * radius && !after_rejection => {
                    radius = (GROW * radius).min(1.0);
                }
                Some(_) => {}
            }
            after_rejection = rejected;
            if let (Some(mut next), false) = (trial, rejected) {
                self.differentiate(&mut next, by_runs)?;
                self.update(&mut hessian, &here, &next, &proposal, scale);
                here = next;
            } else if radius < LEAST_RADIUS {
                // What a run remembers is not in derivatives of its equilibria.
                if by_runs || !self.keeps_history {
                    return Ok(self.end_at(&here, false));
                }
                (by_runs, radius) = (true, AGAIN_RADIUS);
                hessian.fill(0.0);
                self.differentiate(&mut here, by_runs)?;
            }
        }
    }

    /// How a search ends at a design.
    fn end_at(&mut self, design: &Evaluation<'_>, optimum: bool) -> Local {
        if !design.is_kept() {
            return Local::Infeasible;
        }
        if !optimum {
            return Local::Stuck;
        }
        self.optima.push(design.objective);
        Local::Optimum
    }

    /// The model at a design whose gradients are known.
    fn model(&self, here: &Evaluation<'_>, hessian: &DMatrix<f64>, scale: f64, penalty: f64) -> Model {
        let n = self.ranges.len();
        let zero = || DVector::zeros(n);
        let gradient = scale * here.smooth_gradient.clone().unwrap_or_else(zero);
        let worst = self.optimise.terms.iter().map(|term| {
            let linear = |(line, value, slope): (&Line, f64, f64)| {
                Some(Linear { value, gradient: slope * line.gradient.as_ref()? })
            };
            (scale * term.weight, counted(&here.lines, &term.of).filter_map(linear).collect::<Vec<_>>())
        });
        let requirement = |line: &Line| {
            let gradient = line.kept_slope * line.gradient.as_ref()?;
            line.must.then_some(Linear { value: line.kept, gradient })
        };
        Model {
            smooth: Linear { value: scale * here.smooth, gradient },
            worst: worst.filter(|(_, list)| !list.is_empty()).collect(),
            requirements: here.lines.iter().filter_map(requirement).collect(),
            hessian: hessian.clone(),
            penalty,
        }
    }

    /// Damped BFGS update of the Hessian of the Lagrangian (Nocedal and Wright 2006, procedure 18.2).
    fn update(
        &self,
        hessian: &mut DMatrix<f64>,
        here: &Evaluation<'_>,
        next: &Evaluation<'_>,
        proposal: &Proposal,
        scale: f64,
    ) {
        let step = &next.at - &here.at;
        let (Some(before), Some(after)) = (&here.smooth_gradient, &next.smooth_gradient) else { return };
        let mut change = scale * (after - before);
        let mut add = |line: &Line, factor: f64, slope: &dyn Fn(&Line) -> f64| {
            let other = next.lines.iter().find(|other| other.is_of(line));
            if let (Some(before), Some((other, Some(after)))) =
                (&line.gradient, other.map(|other| (other, &other.gradient)))
            {
                change += factor * (slope(other) * after - slope(line) * before);
            }
        };
        let terms = self.optimise.terms.iter().filter(|term| counted(&here.lines, &term.of).next().is_some());
        for (term, multipliers) in terms.zip(&proposal.of_worst) {
            let lines = counted(&here.lines, &term.of).filter(|(line, ..)| line.gradient.is_some());
            for ((line, ..), multiplier) in lines.zip(multipliers) {
                let slope = |line: &Line| counted(std::slice::from_ref(line), &term.of).next().map_or(0.0, |own| own.2);
                add(line, *multiplier, &slope);
            }
        }
        let musts = here.lines.iter().filter(|line| line.must && line.gradient.is_some());
        for (line, multiplier) in musts.zip(&proposal.of_requirements) {
            add(line, -multiplier, &|line| line.kept_slope);
        }
        let curvature = step.dot(&change);
        if hessian.amax() == 0.0 {
            if curvature <= 0.0 {
                return;
            }
            hessian.fill_with_identity();
            *hessian *= curvature / step.norm_squared();
        }
        let moved = &*hessian * &step;
        let own = step.dot(&moved);
        if own <= 0.0 {
            return;
        }
        let damped = if curvature < DAMPING * own {
            let theta = (1.0 - DAMPING) * own / (own - curvature);
            theta * change + (1.0 - theta) * &moved
        } else {
            change
        };
        *hessian += &damped * damped.transpose() / step.dot(&damped) - &moved * moved.transpose() / own;
    }

    /// Runs the best designs afresh, from their texts alone, up to the first one that keeps all requirements; and how
    /// many better ones do not.
    fn certify(&mut self, observer: &mut dyn FnMut(&Design)) -> Option<(Optimum, usize)> {
        self.candidates.sort_by(|a, b| a.objective.total_cmp(&b.objective));
        let candidates: Vec<Candidate> = self.candidates.drain(..).take(CANDIDATES).collect();
        let mut best = None;
        for (k, candidate) in candidates.into_iter().enumerate() {
            let Some(run) = self.fresh(&candidate.text) else {
                return Some((candidate.with_certificate(None), k));
            };
            self.counts.runs += 1;
            let holds = run.status() == Status::Converged && run.verdict() == Verdict::Pass;
            let row = self.designs.iter().find(|design| design.run == candidate.run);
            let row = row.map(|row| Design {
                run: self.counts.runs,
                kind: Kind::Certificate,
                verdict: Some(run.verdict().word().to_owned()),
                ..row.clone()
            });
            self.designs.extend(row);
            self.show(observer);
            if holds {
                best = Some((candidate.with_certificate(Some(run)), k));
                break;
            }
        }
        best
    }

    /// A run of a text as `wireloom run` does it; `None` if it was stopped.
    fn fresh(&self, text: &str) -> Option<Run> {
        let (_, built) = crate::load_with_files(text, self.files, self.registry)
            .and_then(|(scenario, built)| crate::mesh::by_accuracy(scenario, built, self.registry, &self.monitor))
            .ok()?;
        let monitor = &self.monitor;
        let run = crate::run(built, &mut |_, _| if monitor.is_stopped() { Control::Stop } else { Control::Continue });
        (!monitor.is_stopped()).then_some(run)
    }
}

impl Candidate {
    fn with_certificate(self, certificate: Option<Run>) -> Optimum {
        let Candidate { run, text, values, objective, .. } = self;
        Optimum { run, text, values, objective, certificate }
    }
}

/// The value of a setting: a number, or a word.
fn toml_value(text: &str) -> serde_json::Value {
    let plain = text.trim().trim_matches(['"', '\'']);
    let quoted = plain.len() < text.trim().len();
    match serde_json::from_str(text) {
        Ok(value) if !quoted => value,
        _ => serde_json::Value::String(plain.to_owned()),
    }
}
