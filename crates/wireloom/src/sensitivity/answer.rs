//! Question about the derivatives of a scenario, and its answer.

use serde::Serialize;
use std::borrow::Cow;
use wireloom_core::equilibrium::PartFault;
use wireloom_core::{Monitor, Registry, Status};
use wireloom_scenario::{Fault, Files};
use wireloom_solve::steps::nearby::NotFound;

/// A scenario as text.
#[derive(Clone)]
pub struct Source<'a> {
    /// Its text.
    pub text: Cow<'a, str>,
    /// The files it names.
    pub files: &'a dyn Files,
    /// The kinds.
    pub registry: &'a Registry,
    /// Monitor that may stop the work.
    pub monitor: Monitor,
}

impl<'a> Source<'a> {
    /// A scenario whose work nobody stops.
    pub fn new(text: impl Into<Cow<'a, str>>, files: &'a dyn Files, registry: &'a Registry) -> Self {
        Self { text: text.into(), files, registry, monitor: Monitor::default() }
    }
}

/// What is asked about a scenario.
#[derive(Clone, Copy, Debug, Default)]
pub struct Question<'a> {
    /// Outputs; empty: all requirements that have a value there.
    pub of: &'a [String],
    /// Keys; empty: those that the scenario's sweep varies, as far as they are numbers.
    pub by: &'a [String],
    /// Name of the step at whose end; `None`: the last one.
    pub step: Option<&'a str>,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivities {
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the step.
    pub step: String,
    /// Number of the increment, from 1.
    pub increment: usize,
    /// Whether friction, slip, or parts that remember have a history, which is kept as it is: derivatives are those of
    /// the last equilibrium, not of the path to it.
    pub keeps_history: bool,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// The outputs.
    pub outputs: Vec<Output>,
    /// Keys that the scenario's sweep varies, too, and that have no part in spreads.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tolerances_left_out: Vec<String>,
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
    /// Its size, SI: of a component that of the largest number of its list.
    #[serde(skip)]
    pub scale: f64,
    /// How the scenario's sweep spreads it, if it does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<Tolerance>,
}

/// Distribution of a parameter, SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tolerance {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// Whether it is uniform; otherwise it is normal.
    pub is_uniform: bool,
}

/// An output with its derivatives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// Its name.
    pub name: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// Its value at the end of the increment; `None`: there is none.
    pub value: Option<f64>,
    /// Remark for users, such as that the worst value over the run is another one.
    pub remark: Option<String>,
    /// Its derivatives, in the order of the parameters.
    pub by: Vec<Derivative>,
    /// How tolerances of parameters spread it; `None` where there are none, or one of them has no effect that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spread: Option<Spread>,
}

/// How tolerances spread an output, as if each parameter changed it alone, along a parabola; SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
    /// Standard deviation by each parameter alone, with the sign of what more of it does, in the order of the
    /// parameters; 0 for those without tolerance. The sum of their squares is the square of the standard deviation.
    pub parts: Vec<f64>,
    /// Distance of a requirement from its limit, which may be spread, too: mean over standard deviation; below 0 beyond
    /// the limit. `None` where the worst value of the run is elsewhere, or a run within a tolerance has none.
    pub deviations_to_limit: Option<f64>,
    /// Why it may be far off.
    pub remark: Option<String>,
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
    /// The run did not come to the end of a step.
    #[error("step `{step}` did not converge: {}", .status.word())]
    NotConverged {
        /// The step.
        step: String,
        /// Its status.
        status: Status,
    },
    /// The equilibrium has no neighbours that derivatives could be taken from.
    #[error("not differentiable in step `{step}`, increment {increment}: {reason}")]
    NotDifferentiable {
        /// The step.
        step: String,
        /// Number of the increment, from 1.
        increment: usize,
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
