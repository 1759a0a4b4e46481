//! Sensitivities: derivatives of results at the end of an increment by numbers of the scenario.
//!
//! ```
//! use wireloom::scenario::NoFiles;
//! use wireloom::sensitivity::{Question, Source, Study};
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let registry = wireloom::registry();
//! let of = ["force.plug-B".to_owned()];
//! let by = ["branches.left.length".to_owned(), "branches.trunk.length".to_owned()];
//! let mut study = Study::new(Source::new(&text, &NoFiles, &registry)).expect("it has no faults");
//! let found = study.answer(&Question { of: &of, by: &by, step: None }).expect("it converges");
//! for (parameter, derivative) in found.parameters.iter().zip(&found.outputs[0].by) {
//!     println!("1 {} more of {}: {:?} N", parameter.unit, parameter.key, derivative.value);
//! }
//! # assert!(found.outputs[0].by.iter().all(|derivative| derivative.value.is_some()));
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! An output is a requirement, by its name, or a column of the table of a sweep ([`crate::sweep`]) that belongs to one
//! equilibrium, such as `force.plug-B`, `bend_radius.trunk`, `energy.total`, or one of `[sweep.outputs]`; beside these
//! `position_x.NAME` (`_y`, `_z`) of a marker or a joint. A parameter is any key of the text that holds a number.
//!
//! # Method
//!
//! For each parameter the scenario is built twice, with a slightly larger and a slightly smaller value and the same
//! mesh. [`wireloom_solve::steps::nearby`] finds both equilibria near that of the run with the factor of the Hessian
//! there, which is kept: a few residuals and back-substitutions, no run and no factorisation. The derivative is the
//! central difference of the output. The step is so small that the harness turns by about 2e-4 rad, or moves by so many
//! lengths of its longest branch, at most.
//!
//! # Where there is no derivative
//!
//! The differences to both sides must agree, up to what curvature explains (it shrinks with the step). Where they do
//! not, or where different points touch or another place is the worst on the two sides, there is no derivative, but one
//! value for each side and the reason.
//!
//! # Tolerances
//!
//! Where the scenario's sweep spreads a parameter (`mean` and `deviation`, or `from` and `to`), the scenario is also
//! carried out at its mean and one standard deviation σ to both sides, and an output follows the parabola
//! `f + a z + b z²` through the three values, z in units of σ from the mean. Parameters add up: the slope a of each
//! squared plus `2 b²` (normal) or `0.8 b²` (uniform) is its part of the variance. It is told where that may be far
//! off: where b has a tenth of the variance, a derivative says something else, or a run within σ does not converge.

mod answer;
mod differences;
mod moved;
mod outputs;
mod sheet;
mod tolerances;

pub use answer::{Derivative, NoAnswer, Output, Parameter, Question, Sensitivities, Source, Spread, Tolerance};
pub use moved::{LineOfMove, OfMove, of_move};
pub use sheet::{add_sensitivities, of_requirements};

use differences::OfScenario;
use outputs::{Asked, Catalogue};
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::equilibrium::RequirementResult;
use wireloom_core::minimiser::Stop;
use wireloom_core::steps::{Schedule, Step};
use wireloom_core::{Network, Status, StepResult};
use wireloom_scenario::fault::did_you_mean;
use wireloom_scenario::{Built, Fault, Scenario, number_at};
use wireloom_solve::steps::checkpoint::Checkpoint;
use wireloom_solve::steps::interactive::{Ended, InteractiveDriver};
use wireloom_solve::steps::nearby::Neighbourhood;
use wireloom_solve::steps::{Interruption, steps_of};

/// A scenario and its run, kept at the ends of its steps, with derivatives at the end of every increment.
pub struct Study<'a> {
    source: Source<'a>,
    scenario: Scenario,
    network: Network,
    coarse: Option<Network>,
    schedule: Schedule,
    steps: Vec<Step>,
    stop: Stop,
    catalogue: Catalogue,
    /// Changes the requirements of every network that is built of the scenario.
    requirements: fn(&mut Network),
    driver: InteractiveDriver,
    /// At the start, then at the end of each step, as far as the run came.
    ends: Vec<Ended>,
    /// Of each of these steps, by number: the increments in which a requirement is at its worst in that step.
    worst: Vec<BTreeMap<usize, Ended>>,
}

impl<'a> Study<'a> {
    /// Reads a scenario; with `[mesh] accuracy` finds its mesh.
    ///
    /// # Errors
    /// Faults of the scenario.
    pub fn new(source: Source<'a>) -> Result<Self, NoAnswer> {
        Self::with_requirements(source, tell_apart)
    }

    /// The same with a change of the requirements of every network that is built of the scenario.
    ///
    /// # Errors
    /// Faults of the scenario.
    pub(crate) fn with_requirements(source: Source<'a>, requirements: fn(&mut Network)) -> Result<Self, NoAnswer> {
        let Source { text, files, registry, monitor } = &source;
        let (scenario, built) = crate::load_with_files(text, *files, registry)
            .and_then(|(scenario, built)| crate::mesh::by_accuracy(scenario, built, registry, monitor))
            .map_err(NoAnswer::Faults)?;
        Ok(Self::of(source, scenario, built, requirements))
    }

    /// Reads a scenario and gives it the mesh of another one that differs in numbers only, so that results of both can
    /// be subtracted.
    ///
    /// # Errors
    /// Faults of the scenario.
    pub fn on_mesh_of(source: Source<'a>, other: &Scenario) -> Result<Self, NoAnswer> {
        let (mut scenario, built) =
            crate::load_with_files(&source.text, source.files, source.registry).map_err(NoAnswer::Faults)?;
        let changes = scenario.keep_mesh_of(other);
        let built = if changes { scenario.build(source.registry).map_err(NoAnswer::Faults)? } else { built };
        Ok(Self::of(source, scenario, built, tell_apart))
    }

    fn of(source: Source<'a>, scenario: Scenario, built: Built, requirements: fn(&mut Network)) -> Self {
        let Built { mut network, coarse, schedule, minimiser, stop, .. } = built;
        requirements(&mut network);
        Self {
            requirements,
            catalogue: Catalogue::new(&scenario, &network),
            driver: InteractiveDriver::new(minimiser, stop, false, source.monitor.clone()),
            steps: steps_of(&schedule).into_owned(),
            ends: Vec::new(),
            worst: Vec::new(),
            source,
            scenario,
            network,
            coarse,
            schedule,
            stop,
        }
    }

    /// The scenario.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Carries out the scenario up to the end of a step, and differentiates there.
    ///
    /// # Errors
    /// Faults of the question; a run that does not converge, or to an equilibrium without derivatives.
    pub fn answer(&mut self, question: &Question<'_>) -> Result<Sensitivities, NoAnswer> {
        // What can be told before the run is told before it.
        let step = self.step(question.step)?;
        let mut parameters = self.parameters(question.by)?;
        for parameter in &mut parameters {
            parameter.tolerance = self.tolerance(&parameter.key);
        }
        self.check(question.of)?;
        question.of.iter().try_for_each(|name| self.can_have_value(name, step))?;
        self.run_to(step)?;
        let found = self.derivatives((step, self.steps[step].increments), question.of, &parameters)?;
        self.with_spreads(found, step)
    }

    /// The scenario's text.
    pub(crate) fn text(&self) -> &str {
        &self.source.text
    }

    /// The harness.
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// The steps.
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// The equilibria at the start, then at the end of each step, as far as the run came.
    pub fn ends(&self) -> &[Ended] {
        &self.ends
    }

    /// Index of a step; `None`: the last one.
    ///
    /// # Errors
    /// If there is no such step.
    pub fn step(&self, name: Option<&str>) -> Result<usize, NoAnswer> {
        let Some(name) = name else { return Ok(self.steps.len() - 1) };
        self.steps.iter().position(|step| step.name == name).ok_or_else(|| {
            let known = did_you_mean(name, self.steps.iter().map(|step| step.name.as_str()));
            NoAnswer::Question(format!("the scenario has no step `{name}`: {known}"))
        })
    }

    /// The numbers at these keys; without keys at those that the scenario's sweep varies.
    ///
    /// # Errors
    /// If there is no number at a key, or no key.
    pub fn parameters(&self, by: &[String]) -> Result<Vec<Parameter>, NoAnswer> {
        // What varies under a condition may not be in the text.
        let axes = self.scenario.sweep.iter().flat_map(|sweep| &sweep.axes);
        let axes = axes.filter(|axis| axis.range.is_numeric() && axis.when.is_empty());
        let varied: Vec<String> = axes.map(|axis| axis.key.clone()).collect();
        let keys = if by.is_empty() { &varied } else { by };
        if keys.is_empty() {
            let message = "the scenario has no [sweep] that varies numbers: name the keys to differentiate by";
            return Err(NoAnswer::Question(message.to_owned()));
        }
        if let Some(twice) = keys.iter().enumerate().find(|(k, key)| keys[..*k].contains(key)) {
            return Err(NoAnswer::Question(format!("`{}` is named twice", twice.1)));
        }
        let parameter = |key: &String| {
            let number = number_at(&self.source.text, key, self.source.registry)
                .map_err(|Fault { message, help, .. }| NoAnswer::Question(format!("{message}: {help}")))?;
            Ok(Parameter {
                key: key.clone(),
                value: number.value,
                unit: number.unit,
                scale: number.scale,
                tolerance: None,
            })
        };
        keys.iter().map(parameter).collect()
    }

    /// Refuses names that are no outputs.
    ///
    /// # Errors
    /// If there is such a name.
    pub fn check(&self, of: &[String]) -> Result<(), NoAnswer> {
        of.iter().try_for_each(|name| self.catalogue.check(name))
    }

    /// Refuses an output that has no value at the end of a step, whatever the run: a requirement that does not count
    /// there, or a force or moment of a constraint that does not act there.
    fn can_have_value(&self, output: &str, step: usize) -> Result<(), NoAnswer> {
        let requirement = self.network.requirements.iter().find(|own| own.name == output);
        let counts = requirement.and_then(|own| own.steps.as_ref()).is_none_or(|steps| steps.contains(&step));
        let (quantity, of) = output.split_once('.').unwrap_or((output, ""));
        let reaction = requirement.is_none() && ["force", "moment"].iter().any(|word| quantity.starts_with(word));
        let constraint = self.network.constraints.iter().position(|own| reaction && own.name == of);
        let acts = constraint.is_none_or(|constraint| self.scenario.acting()[step].contains(&constraint));
        if counts && acts {
            return Ok(());
        }
        let name = &self.steps[step].name;
        let why = if counts { format!("`{of}` does not act") } else { format!("`{output}` does not count") };
        Err(NoAnswer::Question(format!("{why} in step `{name}`: ask at the end of another one with --step")))
    }

    /// Finds the initial equilibrium near that of another scenario, which differs in numbers only, so that both are the
    /// same of several. Where there is none nearby, [`Self::run_to`] finds it from the layout.
    pub fn start_near(&mut self, other: &Network, start: &Checkpoint) {
        if self.ends.is_empty() {
            self.ends.extend(self.driver.start_near(&self.network, &self.schedule, (other, start)));
        }
    }

    /// Carries out the scenario up to the end of a step, from where it is.
    ///
    /// # Errors
    /// If a step does not converge, a part cannot continue, or it was stopped.
    pub fn run_to(&mut self, step: usize) -> Result<(), NoAnswer> {
        if self.ends.is_empty() {
            let start = self.driver.start(&self.network, self.coarse.as_ref(), &self.schedule);
            self.ends.push(start.map_err(no_answer)?);
        }
        while self.ends.len() < step + 2 {
            let step = self.ends.len() - 1;
            let mut worst = BTreeMap::new();
            let mut now = self.ends[step].clone();
            for increment in 1..=self.steps[step].increments {
                now = self.advance(step, &now)?;
                let moments: BTreeSet<usize> = now.requirements_of_step.iter().filter_map(worst_in).collect();
                worst.retain(|increment, _| moments.contains(increment));
                if moments.contains(&increment) {
                    worst.insert(increment, now.clone());
                }
            }
            self.ends.push(now);
            self.worst.push(worst);
        }
        Ok(())
    }

    /// The equilibria at the start and at the end of every increment of all steps.
    ///
    /// # Errors
    /// As those of [`Self::run_to`].
    pub(crate) fn whole_path(&mut self) -> Result<Vec<StepResult>, NoAnswer> {
        let start = self.driver.start(&self.network, self.coarse.as_ref(), &self.schedule);
        let mut now = start.map_err(no_answer)?;
        let mut path = vec![now.end.clone()];
        for step in 0..self.steps.len() {
            for _ in 0..self.steps[step].increments {
                now = self.advance(step, &now)?;
                path.push(now.end.clone());
            }
        }
        Ok(path)
    }

    /// The end of the next increment of a step.
    fn advance(&mut self, step: usize, from: &Ended) -> Result<Ended, NoAnswer> {
        let step = &self.steps[step];
        let ended = self.driver.advance(&self.network, step, &from.checkpoint).map_err(no_answer)?;
        if ended.is_balanced() {
            return Ok(ended);
        }
        Err(NoAnswer::NotConverged { step: step.name.clone(), status: ended.end.status })
    }

    /// The end of an increment of a step to whose beginning the run came.
    fn end_of(&mut self, step: usize, increment: usize) -> Result<Ended, NoAnswer> {
        if let (Some(end), true) = (self.ends.get(step + 1), increment == self.steps[step].increments) {
            return Ok(end.clone());
        }
        if let Some(kept) = self.worst.get(step).and_then(|worst| worst.get(&increment)) {
            return Ok(kept.clone());
        }
        let mut now = self.ends[step].clone();
        for _ in 0..increment {
            now = self.advance(step, &now)?;
        }
        Ok(now)
    }

    /// Derivatives at the end of an increment of a step to whose beginning the run came: the index of the step, and the
    /// number of the increment from 1.
    ///
    /// # Errors
    /// Outputs that do not exist; an equilibrium that has not converged or has no derivatives.
    ///
    /// # Panics
    /// If the run did not come to the beginning of the step, or the step has no such increment.
    pub fn derivatives(
        &mut self,
        (step, increment): (usize, usize),
        of: &[String],
        parameters: &[Parameter],
    ) -> Result<Sensitivities, NoAnswer> {
        self.check(of)?;
        let increments = self.steps[step].increments;
        assert!((1..=increments).contains(&increment), "there is no increment {increment}");
        let ended = self.end_of(step, increment)?;
        let name = self.steps[step].name.clone();
        if ended.end.status != Status::Converged {
            return Err(NoAnswer::NotConverged { step: name, status: ended.end.status });
        }
        let path = self.ends[..=step].iter().chain([&ended]).map(|end| end.checkpoint.clone()).collect();
        let not_differentiable = |reason| NoAnswer::NotDifferentiable { step: name.clone(), increment, reason };
        let mut own = self.scenario.build(self.source.registry).map_err(NoAnswer::Faults)?;
        (self.requirements)(&mut own.network);
        let minimiser = own.minimiser.as_mut();
        let fraction = increment as f64 / increments as f64;
        let mut neighbourhood =
            Neighbourhood::new(&self.network, &self.schedule, &self.stop, minimiser, path, fraction)
                .map_err(not_differentiable)?;
        let catalogue = &self.catalogue;
        let sheet = of.is_empty() || of.iter().any(|name| catalogue.is_requirement(name));
        let here = neighbourhood.find(&own.network, &own.schedule, minimiser, sheet).map_err(not_differentiable)?;
        let here = catalogue.measured(&self.scenario, &own.network, here);
        let names = catalogue.names(of, &here)?;
        let outputs: Vec<Asked> = names.iter().map(|name| Asked::new(name, &here, &self.network)).collect();
        let (source, scenario, requirements) = (&self.source, &self.scenario, self.requirements);
        let mut around = OfScenario { source, scenario, catalogue, requirements, neighbourhood, sheet };
        let mut columns = Vec::with_capacity(parameters.len());
        for parameter in parameters {
            columns.push(differences::derivatives(&mut around, parameter, &here, &outputs)?);
        }
        let outputs = outputs.into_iter().enumerate().map(|(k, asked)| Output {
            remark: catalogue.remark(&asked.name, &ended, &here),
            unit: asked.unit.to_owned(),
            value: asked.value,
            by: columns.iter_mut().map(|column| std::mem::take(&mut column[k])).collect(),
            spread: None,
            name: asked.name,
        });
        Ok(Sensitivities {
            scenario: scenario.name.clone(),
            outputs: outputs.collect(),
            keeps_history: around.neighbourhood.has_history(),
            parameters: parameters.to_vec(),
            tolerances_left_out: Vec::new(),
            step: name,
            increment,
        })
    }
}

/// Gives the requirements of a network distinct names, by which outputs are asked for.
pub(crate) fn tell_apart(network: &mut Network) {
    let names = network.requirement_names();
    network.requirements.iter_mut().zip(names).for_each(|(own, name)| own.name = name);
}

/// Number of the increment of the worst value of a requirement.
fn worst_in(line: &RequirementResult) -> Option<usize> {
    line.moment.as_ref().map(|moment| moment.increment)
}

/// Why a driver was interrupted.
fn no_answer(interruption: Interruption) -> NoAnswer {
    match interruption {
        Interruption::Stopped => NoAnswer::Stopped,
        Interruption::Fault(fault) => NoAnswer::Part(fault),
    }
}
