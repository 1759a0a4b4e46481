//! What is asked of a fit, and its answer.

use super::estimates::Estimate;
use super::least_squares::{Ending, Minimum};
use super::statistics::Statistics;
use super::unknowns::Wishes;
use crate::sensitivity::NoAnswer;
use serde::Serialize;
use wireloom_core::StepResult;
use wireloom_core::equilibrium::PartFault;
use wireloom_scenario::Fault;

/// What is to be identified from what.
#[derive(Clone, Copy, Debug, Default)]
pub struct Request<'a> {
    /// Tables of measured points.
    pub tables: &'a [&'a str],
    /// Measured bending curves.
    pub bending: &'a [&'a str],
    /// Unknowns, with what is known of them.
    pub wishes: Wishes<'a>,
    /// Standard deviation of a measured coordinate, m, or force, N; `None`: it is estimated.
    pub noise: Option<f64>,
}

/// Reason why nothing was identified.
#[derive(Clone, Debug, thiserror::Error)]
pub enum NoFit {
    /// The scenario has faults.
    #[error("the scenario has faults")]
    Faults(Vec<Fault>),
    /// A table of points has faults: its index, and the faults.
    #[error("a table of measured points has faults")]
    Table(usize, Vec<Fault>),
    /// What was asked cannot be answered.
    #[error("{0}")]
    Question(String),
    /// At none of the starts there is an equilibrium at each measured step.
    #[error("nothing to begin with: at the values of the scenario, {reason} ({solves} starts were tried)")]
    NoStart {
        /// Why.
        reason: String,
        /// Number of starts.
        solves: usize,
    },
    /// A part of the run failed.
    #[error("{0}")]
    Part(PartFault),
    /// It was stopped before there was anything.
    #[error("stopped")]
    Stopped,
}

/// How a fit ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FitStatus {
    /// At a minimum of the misfit.
    Converged,
    /// Not at a minimum: no step led to less, or there were too many.
    #[default]
    NotConverged,
    /// It was stopped.
    Interrupted,
}

impl FitStatus {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            FitStatus::Converged => "converged",
            FitStatus::NotConverged => "not converged",
            FitStatus::Interrupted => "interrupted",
        }
    }
}

/// The answer; SI units.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Identified {
    /// Name of the scenario.
    pub scenario: String,
    /// How the fit ended.
    pub status: FitStatus,
    /// Whether every parameter is identifiable.
    pub identifiable: bool,
    /// Number of iterations.
    pub iterations: usize,
    /// Scenarios that were carried out.
    pub solves: usize,
    /// Those among them that came to no equilibrium; the step was shortened then.
    pub failed_solves: usize,
    /// Derivatives of one configuration by one parameter.
    pub derivatives: usize,
    /// Those among them that are differences of whole runs, because the equilibrium has none.
    pub derivatives_by_runs: usize,
    /// Why the first of these has none.
    pub by_runs_because: Option<String>,
    /// Those among them that could not be computed.
    pub derivatives_missing: usize,
    /// Branches whose start is drawn through the measured points: from the scenario's own start it comes to other
    /// equilibria, farther from the points, or to none.
    pub drawn: Vec<String>,
    /// Number of measured coordinates, or forces of bending curves.
    pub coordinates: usize,
    /// Standard deviation of one coordinate, m, or force, N: of the residuals, or the given one if that is larger.
    pub noise: Option<f64>,
    /// Noise that was given, m or N.
    pub given_noise: Option<f64>,
    /// Correlation of the residuals of points beside each other, or of samples of a curve.
    pub neighbour_correlation: Option<f64>,
    /// Factor on deviations because of it.
    pub widened: f64,
    /// Whether the fitted scenario, carried out from its beginning, comes to the same equilibria. Where it does not,
    /// the harness has several, and its steps do not decide between them.
    pub repeatable: bool,
    /// The parameters, in the order in which they were asked for.
    pub parameters: Vec<Estimate>,
    /// Their correlations.
    pub correlations: Vec<Vec<f64>>,
    /// The configurations, in the order of the table.
    pub configurations: Vec<Configuration>,
    /// The bending curves, in the order of their tables.
    pub curves: Vec<Curve>,
    /// The scenario's text with the fitted values; comments stay.
    #[serde(skip)]
    pub text: String,
    /// The equilibria at the end of each step up to the last measured one.
    #[serde(skip)]
    pub ends: Vec<StepResult>,
}

/// Measured and computed points of a configuration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Configuration {
    /// Its name in the table.
    pub name: String,
    /// The step.
    pub step: String,
    /// Status of the equilibrium.
    pub status: &'static str,
    /// Mean distance between measured and computed points, m.
    pub mean_distance: f64,
    /// Root of the mean square distance, m.
    pub rms_distance: f64,
    /// Largest distance, m.
    pub largest_distance: f64,
    /// The points.
    pub points: Vec<FittedPoint>,
}

/// A measured point and where it was computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FittedPoint {
    /// Marker or joint.
    pub marker: String,
    /// Measured coordinates, m.
    pub measured: [Option<f64>; 3],
    /// Computed position, m.
    pub computed: [f64; 3],
    /// Distance in the coordinates that were measured, m.
    pub distance: f64,
    /// Weight in the fit: less than 1 for points that are far off.
    pub weight: f64,
}

impl Identified {
    /// The part of an answer that is the same for points and curves.
    pub(super) fn of(
        scenario: &str,
        at: &Minimum,
        statistics: &Statistics,
        parameters: Vec<Estimate>,
        settled: bool,
        text: String,
    ) -> Self {
        let status = match at.ending {
            Ending::Converged if settled => FitStatus::Converged,
            Ending::Stopped => FitStatus::Interrupted,
            _ => FitStatus::NotConverged,
        };
        Self {
            scenario: scenario.to_owned(),
            identifiable: parameters.iter().all(|own| own.identifiable),
            iterations: at.iterations,
            coordinates: at.residuals.len(),
            noise: statistics.noise,
            neighbour_correlation: statistics.neighbours,
            widened: statistics.widened,
            correlations: statistics.correlations.row_iter().map(|row| row.iter().copied().collect()).collect(),
            repeatable: true,
            status,
            parameters,
            text,
            ..Self::default()
        }
    }

    /// Whether the fit converged, with every configuration in equilibrium, and every parameter is identifiable.
    pub fn is_complete(&self) -> bool {
        self.status == FitStatus::Converged && self.identifiable
    }
}

/// A measured curve and what was computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Curve {
    /// Index of its table.
    pub table: usize,
    /// The samples.
    pub samples: Vec<CurveSample>,
    /// Samples beyond the deflection to which the scenario goes; they are left out.
    pub beyond: usize,
    /// Root of the mean square difference of the loads, N.
    pub rms: f64,
    /// The same relative to the root of the mean square of the measured loads.
    pub relative: f64,
    /// Computed deflection, m, and load, N, at the start and at each increment.
    pub computed: Vec<[f64; 2]>,
}

/// A sample of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurveSample {
    /// Deflection, m.
    pub deflection: f64,
    /// Measured load, N.
    pub measured: f64,
    /// Computed load, N.
    pub computed: f64,
    /// Weight in the fit: less than 1 for samples that are far off.
    pub weight: f64,
}

impl Request<'_> {
    /// Refuses a noise that is none.
    pub(super) fn check_noise(&self) -> Result<(), NoFit> {
        match self.noise {
            Some(noise) if !(noise.is_finite() && noise > 0.0) => {
                Err(NoFit::Question("the noise of what was measured must be above 0 m, or 0 N".to_owned()))
            }
            _ => Ok(()),
        }
    }
}

impl From<NoAnswer> for NoFit {
    fn from(reason: NoAnswer) -> Self {
        match reason {
            NoAnswer::Faults(faults) => NoFit::Faults(faults),
            NoAnswer::Part(fault) => NoFit::Part(fault),
            NoAnswer::Stopped => NoFit::Stopped,
            other => NoFit::Question(other.to_string()),
        }
    }
}
