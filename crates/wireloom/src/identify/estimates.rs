//! What a fit says of its parameters: values with deviations, or why they are not identifiable.

use super::least_squares::{Ending, Minimum, Model, Points, Prior, Problem, Stopped};
use super::statistics::Statistics;
use super::unknowns::Unknown;
use nalgebra::DVector;
use serde::Serialize;

/// Deviation, relative to a value or to the scale of an unknown, from which on it is not identifiable.
pub const NOT_IDENTIFIABLE: f64 = 0.3;
/// Deviation below which the misfit is not computed at both sides of the fit: a normal distribution describes it.
const NARROW: f64 = 0.03;
/// Distance of these sides from the fit, in deviations.
const SIDE: f64 = 2.0;
/// Growth of the misfit there, relative to that of a normal distribution, below which it is open to that side.
const OPEN: f64 = 0.25;
/// Distance from a bound, relative to the way to it from the other one, that is none.
const AT_BOUND: f64 = 1e-6;
/// Correlation of two unknowns from which on they are named together.
const TOGETHER: f64 = 0.9;

/// A parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Path to its key.
    pub key: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// Value of the scenario.
    pub start: f64,
    /// Whether the points determine it.
    pub identifiable: bool,
    /// Fitted value; `None` where it is not identifiable.
    pub value: Option<f64>,
    /// Its standard deviation, with the prior.
    pub deviation: Option<f64>,
    /// Interval that contains it with a probability of 95 %.
    pub interval: Option<[f64; 2]>,
    /// Where the fit ended. If the parameter is not identifiable, other values fit the points as well.
    pub ended_at: f64,
    /// Standard deviation from the points alone; `None`: they say nothing.
    pub deviation_by_points: Option<f64>,
    /// What the prior is, with its value and deviation.
    pub prior: EstimatePrior,
    /// Why it is not identifiable.
    pub reason: Option<String>,
}

/// The prior of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EstimatePrior {
    /// Where it is from: given, rule of the wires, or weak.
    pub from: &'static str,
    /// Value.
    pub value: f64,
    /// Standard deviation.
    pub deviation: f64,
}

/// Largest step of an unknown in one iteration: a factor of ten.
const LARGEST_STEP: f64 = std::f64::consts::LN_10;

/// A fit and its data.
pub struct Fit<'f> {
    /// What is minimised.
    pub problem: Problem,
    /// The unknowns.
    pub unknowns: &'f [Unknown],
    /// Priors that are part of the model.
    pub smooth: Vec<Prior>,
    /// Points that lie beside each other, in order.
    pub chains: Vec<Vec<usize>>,
}

impl Fit<'_> {
    /// The start: the values of the scenario.
    pub fn start(&self) -> DVector<f64> {
        DVector::from_iterator(self.unknowns.len(), self.unknowns.iter().map(|own| own.theta(own.start)))
    }

    /// What is known at a minimum, and of each parameter. If it is stopped, the minimum says so.
    pub fn estimates(&self, at: &mut Minimum, model: &mut dyn Model) -> (Statistics, Vec<Estimate>) {
        let statistics = Statistics::new(&self.problem, at, &self.smooth, &self.chains);
        let mut estimates = Vec::with_capacity(self.unknowns.len());
        for i in 0..self.unknowns.len() {
            let reason = match self.not_identifiable(i, at, &statistics) {
                None if at.ending == Ending::Stopped => None,
                None => self.open_side(i, at, &statistics, model).unwrap_or_else(|Stopped| {
                    at.ending = Ending::Stopped;
                    None
                }),
                some => some,
            };
            estimates.push(self.estimate(i, at, &statistics, reason));
        }
        (statistics, estimates)
    }

    /// Why the points do not determine an unknown, by the linearised problem.
    fn not_identifiable(&self, i: usize, at: &Minimum, statistics: &Statistics) -> Option<String> {
        let own = &self.unknowns[i];
        if statistics.noise.is_none() {
            return Some("there are no more coordinates than parameters: give the noise, or more points".to_owned());
        }
        let [low, high] = own.theta_bounds();
        let room = AT_BOUND * (high - low);
        if at.theta[i] <= low + room || at.theta[i] >= high - room {
            let bound = own.bounds[usize::from(at.theta[i] >= high - room)];
            return Some(format!("it ran against its bound, {bound:.4e} {}", own.unit));
        }
        let deviation = statistics.by_data[i];
        if deviation <= NOT_IDENTIFIABLE {
            return None;
        }
        if at.jacobian.column(i).amax() == 0.0 {
            return Some("no measured point depends on it".to_owned());
        }
        let partner = |j: &usize| *j != i && statistics.correlations[(i, *j)].abs() > TOGETHER;
        let partners: Vec<&str> =
            (0..self.unknowns.len()).filter(partner).map(|j| self.unknowns[j].key.as_str()).collect();
        let known = match deviation {
            infinite if infinite.is_infinite() => "the points do not determine it".to_owned(),
            of_value if own.logarithm => format!("the points leave a deviation of {:.0} % of it", 100.0 * of_value),
            moved => format!("the points leave a deviation of {:.3e} {}", moved * own.scale, own.unit),
        };
        Some(if partners.is_empty() { known } else { format!("{known}; it acts like {}", partners.join(", ")) })
    }

    /// Whether the misfit hardly grows to one side of the fit.
    fn open_side(
        &self,
        i: usize,
        at: &Minimum,
        statistics: &Statistics,
        model: &mut dyn Model,
    ) -> Result<Option<String>, Stopped> {
        let deviation = statistics.deviation(i);
        if deviation < NARROW {
            return Ok(None);
        }
        // In the function that was minimised: its minimum is here.
        let here = self.problem.cost(&at.theta, &at.residuals, at.scale);
        let (mut normal, _) = self.problem.points.normal(&at.jacobian, &at.residuals, at.scale);
        self.problem.priors.iter().for_each(|prior| prior.add_to(&mut normal));
        for (side, words) in [(-SIDE, "smaller"), (SIDE, "larger")] {
            let step = statistics.profile(i, side);
            let theta = &at.theta + &step;
            let Some((residuals, _)) = model.compute(&theta, &mut |_| false)? else { continue };
            let grown = self.problem.cost(&theta, &residuals, at.scale) - here;
            if grown < OPEN * step.dot(&(&normal * &step)) {
                let value = self.unknowns[i].value(theta[i]);
                let unit = &self.unknowns[i].unit;
                return Ok(Some(format!("{words} values fit as well: {value:.4e} {unit}")));
            }
        }
        Ok(None)
    }

    fn estimate(&self, i: usize, at: &Minimum, statistics: &Statistics, reason: Option<String>) -> Estimate {
        let own = &self.unknowns[i];
        let theta = at.theta[i];
        let (ended_at, slope) = (own.value(theta), own.slope(theta));
        let half = statistics.quantile * statistics.deviation(i);
        let identifiable = reason.is_none();
        let by_data = statistics.by_data[i];
        let [value, deviation] = own.prior;
        Estimate {
            key: own.key.clone(),
            unit: own.unit.clone(),
            start: own.start,
            value: identifiable.then_some(ended_at),
            deviation: identifiable.then_some(slope * statistics.deviation(i)),
            interval: identifiable.then(|| [own.value(theta - half), own.value(theta + half)]),
            deviation_by_points: by_data.is_finite().then_some(slope * by_data),
            prior: EstimatePrior { from: own.knowledge.words(), value, deviation },
            identifiable,
            ended_at,
            reason,
        }
    }
}

/// What is minimised for these unknowns.
pub fn problem(unknowns: &[Unknown], points: Points, smooth: &[Prior]) -> Problem {
    let shifted = |factor: f64| {
        let more = |own: &Unknown| if own.is_stiffness() { factor.ln() } else { 0.0 };
        DVector::from_iterator(unknowns.len(), unknowns.iter().map(more))
    };
    let stiff = unknowns.iter().any(Unknown::is_stiffness);
    let factors: &[f64] = if stiff { &[0.3, 3.0, 0.1, 10.0] } else { &[] };
    Problem {
        points,
        priors: unknowns.iter().enumerate().map(|(i, own)| own.prior(i)).chain(smooth.iter().cloned()).collect(),
        bounds: unknowns.iter().map(Unknown::theta_bounds).collect(),
        largest_step: LARGEST_STEP,
        starts: factors.iter().map(|factor| shifted(*factor)).collect(),
    }
}
