//! Sensitivities: derivatives of results at the end of a step by numbers of the scenario.
//!
//! ```
//! use wireloom::scenario::NoFiles;
//! use wireloom::sensitivity::{Question, answer};
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let registry = wireloom::registry();
//! let of = ["force.plug-B".to_owned()];
//! let by = ["branches.left.length".to_owned(), "branches.trunk.length".to_owned()];
//! let question = Question { of: &of, by: &by, ..Question::about(&text, &NoFiles, &registry) };
//! let found = answer(&question).expect("it converges");
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
//! central difference of the output. The step is so small that the harness turns by about [`MOVES`] at most.
//!
//! # Where there is no derivative
//!
//! The differences to both sides must agree, up to what curvature explains (it shrinks with the step). Where they do
//! not, or where different points touch or another place is the worst on the two sides, there is no derivative, but one
//! value for each side and the reason.

use serde::Serialize;
use wireloom_core::equilibrium::{Outcome, PartFault, Run, StepResult};
use wireloom_core::network::Branch;
use wireloom_core::requirement::{Measure, Origin, RequirementResult};
use wireloom_core::{EventPlace, Monitor, Network, Registry, Status};
use wireloom_export::ending::Ending;
use wireloom_export::table::{Cell, Computed, Header};
use wireloom_scenario::fault::did_you_mean;
use wireloom_scenario::sweep::When;
use wireloom_scenario::{Built, Fault, Files, Scenario, Setting, number_at};
use wireloom_solve::steps::interactive::{Ended, InteractiveDriver};
use wireloom_solve::steps::nearby::{Nearby, Neighbourhood, NotFound};
use wireloom_solve::steps::{Interruption, steps_of};

/// Step of a parameter as a fraction of its size: the error of a central difference is about the square of it.
const STEP: f64 = 1e-4;
/// Step of a parameter that is zero, SI, before it is known how far it moves the harness.
const STEP_FROM_ZERO: f64 = 1e-6;
/// Largest step of such a parameter, SI.
const LARGEST_FROM_ZERO: f64 = 1e-2;
/// Distance that a step should move the harness: move relative to the longest branch, or turn (rad). Higher-order
/// terms grow with its square times EA L²/EI, differences of forces are round-off of EA over it.
pub const MOVES: f64 = 2e-4;
/// Distance from which on a step is made smaller.
const FAR: f64 = 1e-3;
/// Distance up to which a step is made larger.
const NEAR: f64 = 5e-5;
/// Largest step of a parameter that hardly moves the harness, as a fraction of its size.
const LARGEST_STEP: f64 = 3e-4;
/// Number of times that a step is changed.
const STEP_CHANGES: usize = 3;
/// Factor on a step at which no equilibrium was found.
const CUT: f64 = 1.0 / 30.0;
/// Factor on the step of a second pair of differences.
const CLOSER: f64 = 0.25;
/// Difference of the derivatives to both sides, relative to the larger one, up to which one pair of differences is
/// enough: the error of their mean is about the square of it.
const AGREE: f64 = 5e-4;
/// Difference of the means of two pairs, relative to the larger derivative, of a smooth function.
const SMOOTH: f64 = 1e-2;
/// Ratio of the differences of the derivatives to both sides of the closer pair and of the first one, for a smooth
/// function: [`CLOSER`], with room for higher orders.
const SHRINKS: [f64; 2] = [0.15, 0.4];
/// Round-off of an output relative to the size of the quantity in the harness.
const ROUND_OFF: f64 = 1e-12;
/// Number of rounding errors of the strains that add up in a force.
const ROUNDINGS: f64 = 20.0;

/// What is asked about a scenario.
#[derive(Clone)]
pub struct Question<'a> {
    /// Its text.
    pub text: &'a str,
    /// The files it names.
    pub files: &'a dyn Files,
    /// The kinds.
    pub registry: &'a Registry,
    /// Outputs; empty: all requirements that have a value at the end of the step.
    pub of: &'a [String],
    /// Keys; empty: those that the scenario's sweep varies, as far as they are numbers.
    pub by: &'a [String],
    /// Name of the step; `None`: the last one.
    pub step: Option<&'a str>,
    /// Monitor that may stop the work.
    pub monitor: Monitor,
}

impl<'a> Question<'a> {
    /// All requirements, by the keys of the sweep, at the end of the last step.
    pub fn about(text: &'a str, files: &'a dyn Files, registry: &'a Registry) -> Self {
        Self { text, files, registry, of: &[], by: &[], step: None, monitor: Monitor::default() }
    }
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivities {
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the step at whose end the derivatives are taken.
    pub step: String,
    /// Whether friction, slip, or parts that remember have a history, which is kept as it is: derivatives are those of
    /// the last equilibrium, not of the path to it.
    pub keeps_history: bool,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// The outputs.
    pub outputs: Vec<Output>,
}

/// A parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Path to its key.
    pub key: String,
    /// Its value, SI.
    pub value: f64,
    /// SI unit; empty for pure numbers.
    pub unit: String,
}

/// An output with its derivatives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// Its name.
    pub name: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// Its value at the end of the step; `None`: there is none.
    pub value: Option<f64>,
    /// Remark for users, such as that the worst value over the run is another one.
    pub remark: Option<String>,
    /// Its derivatives, in the order of the parameters.
    pub by: Vec<Derivative>,
}

/// A derivative, SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Derivative {
    /// Its value; `None` where it is not differentiable.
    pub value: Option<f64>,
    /// Where there is no derivative: the derivatives to both sides (towards smaller and larger values of the
    /// parameter), as far as they are known.
    pub sides: [Option<f64>; 2],
    /// Why there is no derivative.
    pub reason: Option<String>,
}

/// Reason why there is no answer.
#[derive(Clone, Debug, thiserror::Error)]
pub enum NoAnswer {
    /// The scenario has faults.
    #[error("the scenario has faults")]
    Faults(Vec<Fault>),
    /// The question names what the scenario does not have.
    #[error("{0}")]
    Question(String),
    /// The run did not come to the end of the step.
    #[error("step `{step}` did not converge: {}", .status.word())]
    NotConverged {
        /// The step.
        step: String,
        /// Its status.
        status: Status,
    },
    /// The equilibrium has no neighbours that derivatives could be taken from.
    #[error("not differentiable at the end of step `{step}`: {reason}")]
    NotDifferentiable {
        /// The step.
        step: String,
        /// The reason.
        reason: NotFound,
    },
    /// A part of the run failed.
    #[error("{0}")]
    Part(PartFault),
    /// It was stopped.
    #[error("stopped")]
    Stopped,
}

/// Carries out the scenario up to the end of the step, and differentiates there.
///
/// # Errors
/// Faults of the scenario or of the question; a run that does not converge, or to an equilibrium without derivatives.
pub fn answer(question: &Question<'_>) -> Result<Sensitivities, NoAnswer> {
    let Question { text, files, registry, monitor, .. } = question;
    let loaded = crate::load_with_files(text, *files, registry).map_err(NoAnswer::Faults)?;
    let (scenario, built) =
        crate::mesh::by_accuracy(loaded.0, loaded.1, registry, monitor).map_err(NoAnswer::Faults)?;
    let Built { network, coarse, schedule, minimiser, stop, .. } = built;
    let steps = steps_of(&schedule);
    let step = match question.step {
        None => steps.len() - 1,
        Some(name) => steps.iter().position(|step| step.name == name).ok_or_else(|| {
            let known = did_you_mean(name, steps.iter().map(|step| step.name.as_str()));
            NoAnswer::Question(format!("the scenario has no step `{name}`: {known}"))
        })?,
    };
    let mut parameters = parameters(question, &scenario)?;
    // What can be told before the run is told before it.
    let catalogue = Catalogue::new(&scenario, &network);
    for name in question.of {
        catalogue.check(name)?;
    }
    let name = steps[step].name.clone();
    let mut driver = InteractiveDriver::new(minimiser, stop, false, monitor.clone());
    let stopped = |interruption| match interruption {
        Interruption::Stopped => NoAnswer::Stopped,
        Interruption::Fault(fault) => NoAnswer::Part(fault),
    };
    let mut ended = driver.start(&network, coarse.as_ref(), &schedule).map_err(stopped)?;
    let mut path = vec![ended.checkpoint.clone()];
    for step in &steps[..=step] {
        for _ in 0..step.increments {
            ended = driver.advance(&network, step, &ended.checkpoint).map_err(stopped)?;
            if !matches!(ended.end.status, Status::Converged | Status::Stalled) {
                return Err(NoAnswer::NotConverged { step: step.name.clone(), status: ended.end.status });
            }
        }
        path.push(ended.checkpoint.clone());
    }
    if ended.end.status != Status::Converged {
        return Err(NoAnswer::NotConverged { step: name, status: ended.end.status });
    }
    let again = || scenario.build(registry).map_err(NoAnswer::Faults);
    let not_differentiable = |reason| NoAnswer::NotDifferentiable { step: name.clone(), reason };
    let mut own = again()?;
    let neighbourhood = Neighbourhood::new(&network, &schedule, &stop, own.minimiser.as_mut(), path);
    let mut neighbourhood = neighbourhood.map_err(not_differentiable)?;
    let sheet = question.of.is_empty() || question.of.iter().any(|name| catalogue.is_requirement(name));
    let here = neighbourhood.find(&own.network, &own.schedule, own.minimiser.as_mut(), sheet);
    let here = here.map_err(not_differentiable)?;
    let here = catalogue.measured(&scenario, &own.network, here);
    let names = catalogue.names(question.of, &here)?;
    let outputs: Vec<Asked> = names.iter().map(|name| Asked::new(name, &here, &network)).collect();
    let mut around = Around { question, scenario: &scenario, catalogue: &catalogue, neighbourhood, sheet };
    let mut columns = Vec::with_capacity(parameters.len());
    for (parameter, scale) in &parameters {
        columns.push(around.derivatives(parameter, *scale, &here, &outputs)?);
    }
    let outputs = outputs.into_iter().enumerate().map(|(k, asked)| Output {
        remark: catalogue.remark(&asked.name, &ended, &here),
        unit: asked.unit.to_owned(),
        value: asked.value,
        by: columns.iter_mut().map(|column| std::mem::take(&mut column[k])).collect(),
        name: asked.name,
    });
    Ok(Sensitivities {
        scenario: scenario.name.clone(),
        outputs: outputs.collect(),
        keeps_history: around.neighbourhood.has_history(),
        parameters: parameters.drain(..).map(|(parameter, _)| parameter).collect(),
        step: name,
    })
}

/// The parameters, each with its size.
fn parameters(question: &Question<'_>, scenario: &Scenario) -> Result<Vec<(Parameter, f64)>, NoAnswer> {
    let axes = scenario.sweep.iter().flat_map(|sweep| &sweep.axes).filter(|axis| axis.range.is_numeric());
    let varied: Vec<String> = axes.map(|axis| axis.key.clone()).collect();
    let keys = if question.by.is_empty() { &varied } else { question.by };
    if keys.is_empty() {
        let message = "the scenario has no [sweep] that varies numbers: name the keys to differentiate by";
        return Err(NoAnswer::Question(message.to_owned()));
    }
    let parameter = |key: &String| {
        let number = number_at(question.text, key, question.registry)
            .map_err(|Fault { message, help, .. }| NoAnswer::Question(format!("{message}: {help}")))?;
        let parameter = Parameter { key: key.clone(), value: number.value, unit: number.unit };
        Ok((parameter, number.scale))
    };
    keys.iter().map(parameter).collect()
}

/// Outputs of a harness at one equilibrium.
struct Catalogue {
    header: Header,
    /// Names of the columns that belong to one equilibrium.
    columns: Vec<String>,
    requirements: Vec<String>,
    /// Columns that hold a value of the path.
    of_path: Vec<String>,
}

/// Values of all outputs at an equilibrium.
struct Measured {
    columns: Vec<(String, f64)>,
    requirements: Vec<RequirementResult>,
    near: Nearby,
}

impl Measured {
    /// Value of an output; `None` where there is none.
    fn value(&self, name: &str) -> Option<f64> {
        let worst = self.requirements.iter().find(|line| line.name == name).map(|line| line.worst);
        let column = || self.columns.iter().find(|(column, _)| column == name).map(|(_, value)| *value);
        worst.unwrap_or_else(column).filter(|value| value.is_finite())
    }

    /// Place of the worst value of a requirement.
    fn place(&self, name: &str) -> Option<&EventPlace> {
        self.requirements.iter().find(|line| line.name == name).map(|line| &line.place)
    }

    /// Mean length of the segments of a branch, m.
    fn segment(&self, branch: &str) -> f64 {
        let own = self.near.end.branches.iter().find(|own| own.name == branch);
        own.map_or(0.0, |own| own.s[own.s.len() - 1] / (own.s.len() - 1) as f64)
    }
}

impl Catalogue {
    fn new(scenario: &Scenario, network: &Network) -> Self {
        let outputs = scenario.sweep.as_ref().map_or(&[][..], |sweep| &sweep.outputs);
        let header = crate::sweep::header_of(Vec::new(), outputs, network);
        let of_path = |name: &String| {
            let worst = outputs.iter().filter(|output| matches!(output.at, When::Min | When::Max));
            let worst = worst.flat_map(crate::sweep::outputs::columns).any(|column| column == *name);
            worst
                || name.starts_with("min_")
                || name.starts_with("max_")
                || matches!(&name[..], "iterations" | "polish")
        };
        let (of_path, mut columns): (Vec<String>, Vec<String>) = header.numbers().into_iter().partition(of_path);
        let markers = network.markers.iter().map(|marker| &marker.name);
        for name in markers.chain(network.joints.iter().map(|joint| &joint.name)) {
            columns.extend(["x", "y", "z"].map(|axis| format!("position_{axis}.{name}")));
        }
        let requirements = network.requirements.iter().map(|requirement| requirement.name.clone()).collect();
        Self { header, columns, requirements, of_path }
    }

    fn is_requirement(&self, name: &str) -> bool {
        self.requirements.iter().any(|own| own == name)
    }

    /// Refuses a name that is no output.
    fn check(&self, name: &str) -> Result<(), NoAnswer> {
        let own = |all: &[String]| all.iter().any(|own| own == name);
        if own(&self.requirements) || own(&self.columns) {
            return Ok(());
        }
        let why = if own(&self.of_path) {
            format!("`{name}` is of the whole run, not of one equilibrium")
        } else {
            let known = self.requirements.iter().chain(&self.columns).map(String::as_str);
            format!("there is no output `{name}`: {}", did_you_mean(name, known))
        };
        Err(NoAnswer::Question(why))
    }

    /// The outputs that are asked for.
    fn names(&self, of: &[String], here: &Measured) -> Result<Vec<String>, NoAnswer> {
        if !of.is_empty() {
            return Ok(of.to_vec());
        }
        let lines = here.requirements.iter().filter(|line| line.worst.is_some() && line.origin != Origin::Always);
        let names: Vec<String> = lines.map(|line| line.name.clone()).collect();
        if names.is_empty() {
            let message = "no requirement has a value at the end of this step: name the outputs to differentiate";
            return Err(NoAnswer::Question(message.to_owned()));
        }
        Ok(names)
    }

    /// Values of all outputs.
    fn measured(&self, scenario: &Scenario, network: &Network, near: Nearby) -> Measured {
        let outputs = scenario.sweep.as_ref().map_or(&[][..], |sweep| &sweep.outputs);
        let values = outputs.iter().flat_map(|output| {
            let (columns, values) = (
                crate::sweep::outputs::columns(output).len(),
                crate::sweep::outputs::values(&output.measured, network, &near.end),
            );
            if values.len() == columns { values } else { vec![f64::NAN; columns] }
        });
        let computed = Computed { outputs: values.collect(), ..Computed::default() };
        let end = &near.end;
        let places = end.markers.iter().map(|marker| (&marker.name, marker.position));
        let places: Vec<(String, f64)> = places
            .chain(end.joints.iter().map(|joint| (&joint.name, joint.position)))
            .flat_map(|(name, x)| ["x", "y", "z"].iter().zip([x.x, x.y, x.z]).map(move |(axis, x)| (axis, name, x)))
            .map(|(axis, name, x)| (format!("position_{axis}.{name}"), x))
            .collect();
        let row = Ending::of(&alone(end)).map(|ending| self.header.row(Vec::<Cell>::new(), &ending, computed));
        let numbers = row.map_or_else(Vec::new, |row| row.numbers);
        let numbers = self.header.numbers().into_iter().zip(numbers.into_iter().map(|x| x.unwrap_or(f64::NAN)));
        let columns = numbers.chain(places).collect();
        Measured { columns, requirements: near.requirements.clone(), near }
    }

    /// Remark on an output: its value is not the worst of the run, or it has none.
    fn remark(&self, name: &str, ended: &Ended, here: &Measured) -> Option<String> {
        let line = ended.requirements.iter().find(|line| line.name == name)?;
        if line.measure == Measure::InsertionForce {
            return Some("it is the largest force on the way, not a value of one equilibrium".to_owned());
        }
        let (worst, moment) = (line.worst?, line.moment.as_ref()?);
        let value = here.value(name);
        let same = value.is_some_and(|value| (value - worst).abs() <= 1e-6 * worst.abs());
        let unit = line.measure.unit();
        (!same).then(|| {
            format!("its worst value, {worst:.4} {unit}, is in step `{}`, increment {}", moment.step, moment.increment)
        })
    }
}

/// A run that has this end only.
fn alone(end: &StepResult) -> Run {
    Run {
        scenario: String::new(),
        outcome: Outcome::Graded(end.status),
        notes: Vec::new(),
        events: Vec::new(),
        steps: vec![end.clone()],
        clearances: Vec::new(),
        requirements: Vec::new(),
        plugins: Vec::new(),
    }
}

/// An output that is asked for.
struct Asked {
    name: String,
    unit: &'static str,
    value: Option<f64>,
    /// Round-off of its value.
    noise: f64,
}

impl Asked {
    fn new(name: &str, here: &Measured, network: &Network) -> Self {
        let requirement = here.requirements.iter().find(|line| line.name == name);
        let unit = requirement.map_or_else(|| unit_of(name), |line| line.measure.unit());
        let value = here.value(name);
        let noise = noise(unit, &here.near.end, network).max(ROUND_OFF * value.unwrap_or(0.0).abs());
        Self { name: name.to_owned(), unit, value, noise }
    }
}

/// Round-off of a quantity with this unit. The strains of a cable are exact to some rounding errors ε, so its forces to
/// ε EA, its moments to ε EA ℓ with segments of length ℓ, and over a length L its turns to ε EA ℓ L/EI or L/GJ.
fn noise(unit: &str, end: &StepResult, network: &Network) -> f64 {
    let of_branch = |branch: &Branch| {
        let (mesh, section) = (branch.rod.mesh(), &branch.section);
        let length = mesh.length();
        let force = ROUNDINGS * f64::EPSILON * section.axial_stiffness;
        let moment = force * length / mesh.segments() as f64;
        let [one, other] = section.bending_stiffness;
        let turn = moment * length / one.min(other).min(section.torsion_stiffness);
        match unit {
            "N" => force,
            "N m" => moment,
            "m" => length * turn.max(ROUND_OFF),
            _ => turn.max(ROUND_OFF),
        }
    };
    let e = &end.energy;
    let energies = [e.stretch, e.shear, e.bend, e.twist, e.gravity, e.load, e.joint, e.constraint];
    match unit {
        "J" => ROUND_OFF * energies.iter().map(|e| e.abs()).sum::<f64>(),
        _ => network.branches.iter().map(of_branch).fold(0.0, f64::max),
    }
}

/// SI unit of a column.
fn unit_of(column: &str) -> &'static str {
    let quantity = column.split('.').next().unwrap_or_default();
    let quantity = ["_w", "_x", "_y", "_z"].iter().fold(quantity, |word, axis| word.strip_suffix(axis).unwrap_or(word));
    match quantity {
        "energy" => "J",
        "force" | "tension" | "contact_force" => "N",
        "moment" => "N m",
        "position" | "bend_radius" | "slack" | "clearance" => "m",
        "angle" => "rad",
        "turns" | "twist_turns" => "turns",
        _ => "",
    }
}

/// The neighbourhood of the equilibrium, by any number of the scenario.
struct Around<'a, 'n> {
    question: &'a Question<'a>,
    scenario: &'a Scenario,
    catalogue: &'a Catalogue,
    neighbourhood: Neighbourhood<'n>,
    sheet: bool,
}

/// Results with a smaller and a larger value of a parameter, or why there are none.
type Pair = [Result<Measured, String>; 2];

impl Around<'_, '_> {
    /// Derivatives of all outputs by a parameter.
    fn derivatives(
        &mut self,
        parameter: &Parameter,
        scale: f64,
        here: &Measured,
        outputs: &[Asked],
    ) -> Result<Vec<Derivative>, NoAnswer> {
        let (h, first) = self.suitable_step(parameter, scale)?;
        let mut closer = None;
        let mut all = Vec::with_capacity(outputs.len());
        for asked in outputs {
            let Some(value) = asked.value else {
                let reason = Some("it has no value here".to_owned());
                all.push(Derivative { reason, ..Derivative::default() });
                continue;
            };
            let one = Differences::new(asked, value, h, &first);
            if one.agree(asked) && !differs(&first, &asked.name) {
                all.push(Derivative { value: one.central(), ..Derivative::default() });
                continue;
            }
            // Curvature shrinks with the step; a kink does not.
            if closer.is_none() {
                closer = Some(self.pair(parameter, CLOSER * h)?);
            }
            let pair = closer.as_ref().unwrap_or(&first);
            let two = Differences::new(asked, value, CLOSER * h, pair);
            // A closer pair alone shows nothing: it may be between two kinks.
            let smooth = two.are_curved(&one, asked);
            // Of both pairs, without the error of second order (Richardson).
            let extrapolated = || Some((two.central()? - CLOSER * CLOSER * one.central()?) / (1.0 - CLOSER * CLOSER));
            all.push(if smooth && !differs(pair, &asked.name) {
                Derivative { value: extrapolated(), ..Derivative::default() }
            } else {
                Derivative { value: None, sides: two.sides, reason: Some(self.reason(here, pair, &asked.name)) }
            });
        }
        Ok(all)
    }

    /// A step that moves the harness neither too far nor too little, and the results of both sides.
    fn suitable_step(&mut self, parameter: &Parameter, scale: f64) -> Result<(f64, Pair), NoAnswer> {
        let largest = if scale > 0.0 { LARGEST_STEP * scale } else { LARGEST_FROM_ZERO };
        let mut h = if scale > 0.0 { STEP * scale } else { STEP_FROM_ZERO };
        let mut pair = self.pair(parameter, h)?;
        for _ in 0..STEP_CHANGES {
            let distances = pair.iter().flatten().map(|measured| measured.near.distance);
            let next = match distances.reduce(f64::max) {
                None => CUT * h,
                Some(distance) if distance > FAR => h * MOVES / distance,
                Some(distance) if distance > 0.0 && distance < NEAR => (h * MOVES / distance).min(largest),
                Some(_) => break,
            };
            if next == h {
                break;
            }
            h = next;
            pair = self.pair(parameter, h)?;
        }
        Ok((h, pair))
    }

    /// Results of both sides.
    fn pair(&mut self, parameter: &Parameter, h: f64) -> Result<Pair, NoAnswer> {
        Ok([self.at(parameter, parameter.value - h)?, self.at(parameter, parameter.value + h)?])
    }

    /// Results with another value of a parameter.
    fn at(&mut self, parameter: &Parameter, value: f64) -> Result<Result<Measured, String>, NoAnswer> {
        let Question { text, files, registry, monitor, .. } = self.question;
        if monitor.is_stopped() {
            return Err(NoAnswer::Stopped);
        }
        let built = crate::load_with_settings(text, &[Setting::number(&parameter.key, value)], *files, registry)
            .and_then(|(mut scenario, built)| {
                let built = if scenario.keep_mesh_of(self.scenario) { scenario.build(registry)? } else { built };
                Ok((scenario, built))
            });
        let (scenario, mut built) = match built {
            Ok(built) => built,
            Err(faults) => {
                let first = faults.first().map_or("", |fault| fault.message.as_str());
                return Ok(Err(format!("{value} is refused: {first}")));
            }
        };
        let found = self.neighbourhood.find(&built.network, &built.schedule, built.minimiser.as_mut(), self.sheet);
        Ok(match found {
            Ok(near) => Ok(self.catalogue.measured(&scenario, &built.network, near)),
            Err(reason) => Err(reason.to_string()),
        })
    }

    /// Why an output has no derivative.
    fn reason(&self, here: &Measured, pair: &Pair, name: &str) -> String {
        let [below, above] = match pair {
            [Err(reason), Err(_)] => return reason.clone(),
            [Err(reason), Ok(_)] => return format!("towards smaller values: {reason}"),
            [Ok(_), Err(reason)] => return format!("towards larger values: {reason}"),
            [Ok(below), Ok(above)] => [below, above],
        };
        let touching = [&below.near.touching, &here.near.touching, &above.near.touching];
        let changes = touching[0].symmetric_difference(touching[2]);
        if let Some(changed) = changes.chain(touching[0].symmetric_difference(touching[1])).next() {
            return format!("contact changes here, between {}", self.neighbourhood.words(*changed));
        }
        if below.value(name).is_none() || above.value(name).is_none() {
            return "it has no value on one side".to_owned();
        }
        match (below.place(name), above.place(name)) {
            (Some(one), Some(other)) if is_elsewhere(below, one, other) => {
                format!("the worst place changes here: {one}, or {other}")
            }
            _ => "its slopes to both sides differ".to_owned(),
        }
    }
}

/// Whether different points touch, or another place is the worst, on the two sides.
fn differs(pair: &Pair, name: &str) -> bool {
    let [Ok(below), Ok(above)] = pair else { return true };
    let elsewhere = match (below.place(name), above.place(name)) {
        (Some(one), Some(other)) => is_elsewhere(below, one, other),
        (one, other) => one.is_some() != other.is_some(),
    };
    elsewhere || below.near.touching != above.near.touching
}

/// Whether two places are not the same, up to half a segment: a place may move with the harness.
fn is_elsewhere(measured: &Measured, one: &EventPlace, other: &EventPlace) -> bool {
    let apart = |branch: &Option<String>, a: Option<f64>, b: Option<f64>| match (branch, a, b) {
        (Some(branch), Some(a), Some(b)) => (a - b).abs() > 0.5 * measured.segment(branch),
        _ => a != b,
    };
    let parts = |place: &EventPlace| EventPlace { s: None, other_s: None, ..place.clone() };
    parts(one) != parts(other)
        || apart(&one.branch, one.s, other.s)
        || apart(&one.other_branch, one.other_s, other.other_s)
}

/// Differences of an output to both sides.
struct Differences {
    h: f64,
    sides: [Option<f64>; 2],
}

impl Differences {
    fn new(asked: &Asked, value: f64, h: f64, [below, above]: &Pair) -> Self {
        let at = |side: &Result<Measured, String>| side.as_ref().ok().and_then(|measured| measured.value(&asked.name));
        Self { h, sides: [at(below).map(|below| (value - below) / h), at(above).map(|above| (above - value) / h)] }
    }

    /// The central difference.
    fn central(&self) -> Option<f64> {
        let [below, above] = self.sides;
        Some(0.5 * (below? + above?))
    }

    /// Difference of both, and the larger one.
    fn gap(&self) -> Option<(f64, f64)> {
        let [below, above] = self.sides;
        let (below, above) = (below?, above?);
        Some(((above - below).abs(), above.abs().max(below.abs())))
    }

    /// Whether they agree so well that the central difference is exact.
    fn agree(&self, asked: &Asked) -> bool {
        self.gap().is_some_and(|(gap, larger)| gap <= AGREE * larger + 4.0 * asked.noise / self.h)
    }

    /// Whether they differ as curvature makes them, beside those of a larger step: in proportion to the step, with the
    /// same central difference.
    fn are_curved(&self, wider: &Differences, asked: &Asked) -> bool {
        let (Some((gap, _)), Some((wide, larger))) = (self.gap(), wider.gap()) else { return false };
        let (Some(one), Some(other)) = (self.central(), wider.central()) else { return false };
        let noise = 4.0 * asked.noise / self.h;
        let [least, most] = SHRINKS;
        least * wide - noise <= gap
            && gap <= most * wide + noise
            && (one - other).abs() <= SMOOTH * larger.max(wide) + noise
    }
}
