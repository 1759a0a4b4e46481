//! What a fit says of its parameters: values with deviations, or why they are not identifiable.

use super::least_squares::{self, Ending, Minimum, Model, Points, Prior, Problem, Stopped};
use super::statistics::Statistics;
use super::unknowns::Unknown;
use crate::halton::halton;
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
/// Factors on all stiffness together of other starts.
const COMMON_FACTORS: [f64; 4] = [0.3, 3.0, 0.1, 10.0];
/// Number of other starts in which each unknown has a value of its own: where the ratio of two stiffnesses is wrong, a
/// search may end at a minimum that is not the least one.
const SPREAD_STARTS: usize = 16;
/// Number of searches for a minimum if there are such starts: of 240 random trees on springs, with starts that were
/// wrong by factors of 2 to 5, one search ended at another minimum in 6, three in none.
const SEARCHES: usize = 3;

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
    pub fn estimates(&self, at: &mut Minimum, model: &mut impl Model) -> (Statistics, Vec<Estimate>) {
        let statistics = Statistics::new(&self.problem, at, &self.smooth, &self.chains);
        let mut reasons: Vec<Option<String>> =
            (0..self.unknowns.len()).map(|i| self.not_identifiable(i, at, &statistics)).collect();
        if at.ending != Ending::Stopped && self.ask_further(at, &statistics, model, &mut reasons).is_err() {
            at.ending = Ending::Stopped;
        }
        if at.ending == Ending::Stopped {
            let why = || "the search was interrupted before it had ended".to_owned();
            reasons.iter_mut().for_each(|reason| *reason = Some(why()));
        }
        let estimate = |(i, reason)| self.estimate(i, at, &statistics, reason);
        let estimates = reasons.into_iter().enumerate().map(estimate).collect();
        (statistics, estimates)
    }

    /// Adds the reasons that the linearised problem does not show: fits that are as good elsewhere.
    fn ask_further(
        &self,
        at: &mut Minimum,
        statistics: &Statistics,
        model: &mut impl Model,
        reasons: &mut [Option<String>],
    ) -> Result<(), Stopped> {
        if statistics.noise.is_some() {
            let is_open = |i: &usize| reasons[*i].is_some() && !is_held(*i, &self.problem.priors);
            let open: Vec<usize> = (0..reasons.len()).filter(is_open).collect();
            for i in open {
                self.refit(i, at, statistics, model)?;
            }
        }
        for (i, reason) in reasons.iter_mut().enumerate().filter(|(_, reason)| reason.is_none()) {
            let far = |rival: &&DVector<f64>| (rival[i] - at.theta[i]).abs() > SIDE * statistics.deviation(i);
            *reason = match at.rivals.iter().find(far) {
                Some(rival) => {
                    let Unknown { unit, .. } = &self.unknowns[i];
                    let value = self.unknowns[i].value(rival[i]);
                    Some(format!("another fit is as good, with {value:.4e} {unit}"))
                }
                None => self.open_side(i, at, statistics, model)?,
            };
        }
        Ok(())
    }

    /// Fits the others again with an unknown that is not identifiable at both sides of where the fit ended: what they
    /// become there may differ from what the linearised problem says. Fits that are as good are rivals of the minimum.
    fn refit(
        &self,
        i: usize,
        at: &mut Minimum,
        statistics: &Statistics,
        model: &mut impl Model,
    ) -> Result<(), Stopped> {
        if at.jacobian.column(i).amax() == 0.0 {
            return Ok(());
        }
        let reference = model.reference();
        let away = statistics.deviation(i).min(LARGEST_STEP);
        for side in [-away, away] {
            let mut theta = at.theta.clone();
            let [low, high] = self.problem.bounds[i];
            theta[i] = (theta[i] + side).clamp(low, high);
            let mut problem = Problem { starts: Vec::new(), searches: 1, ..self.problem.clone() };
            problem.bounds[i] = [theta[i]; 2];
            model.set_reference(reference.clone());
            let starts = least_squares::starts(&problem, &theta, model)?;
            let Some(found) = least_squares::minimise(&problem, &starts, model)? else { continue };
            if found.ending == Ending::Stopped {
                return Err(Stopped);
            }
            if at.is_rival(&self.problem, &found) {
                at.rivals.push(found.theta);
            }
        }
        model.set_reference(reference);
        Ok(())
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
        model: &mut impl Model,
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
    let starts = other_starts(unknowns, smooth);
    Problem {
        points,
        priors: unknowns.iter().enumerate().map(|(i, own)| own.prior(i)).chain(smooth.iter().cloned()).collect(),
        bounds: unknowns.iter().map(Unknown::theta_bounds).collect(),
        largest_step: LARGEST_STEP,
        searches: if starts.len() > COMMON_FACTORS.len() { SEARCHES } else { 1 },
        starts,
    }
}

/// Whether an unknown is held together with neighbours, and so has no value of its own.
fn is_held(i: usize, priors: &[Prior]) -> bool {
    priors.iter().any(|prior| prior.terms.len() > 1 && prior.terms.iter().any(|(own, _)| *own == i))
}

/// Other starts: what is added to the unknowns.
fn other_starts(unknowns: &[Unknown], smooth: &[Prior]) -> Vec<DVector<f64>> {
    let vector = |of: &dyn Fn(usize, &Unknown) -> f64| {
        DVector::from_iterator(unknowns.len(), unknowns.iter().enumerate().map(|(i, own)| of(i, own)))
    };
    let mut starts = Vec::new();
    if unknowns.iter().any(Unknown::is_stiffness) {
        let common = |factor: f64| vector(&|_, own| if own.is_stiffness() { factor.ln() } else { 0.0 });
        starts.extend(COMMON_FACTORS.map(common));
    }
    let spread = vector(&|i, own| if is_held(i, smooth) { 0.0 } else { own.spread() });
    let spread_ones = (0..unknowns.len()).filter(|&i| spread[i] > 0.0);
    // A single stiffness has its factors.
    if spread_ones.clone().count() > 1 || spread_ones.clone().any(|i| !unknowns[i].is_stiffness()) {
        let index = |i: usize| spread_ones.clone().take_while(|own| *own < i).count();
        let at = |number: usize| vector(&|i, _| spread[i] * (2.0 * halton(number, index(i)) - 1.0));
        starts.extend((1..=SPREAD_STARTS).map(at));
    }
    starts
}

#[cfg(test)]
mod tests {
    use super::super::least_squares::Computed;
    use super::super::unknowns::Knowledge;
    use super::*;
    use nalgebra::DMatrix;

    fn stiffness(key: &str) -> Unknown {
        Unknown {
            key: key.to_owned(),
            unit: "N m²".to_owned(),
            start: 1.0,
            logarithm: true,
            scale: 1.0,
            bounds: [1e-4, 1e4],
            prior: [1.0, std::f64::consts::LN_10],
            knowledge: Knowledge::Weak,
        }
    }

    /// Ten points that measure θ1 + 2 exp(−θ0), and two that hardly say that θ0 is 3.
    struct Valley;

    impl Model for Valley {
        type Reference = ();

        fn reference(&self) {}

        fn set_reference(&mut self, (): ()) {}

        fn compute(
            &mut self,
            theta: &DVector<f64>,
            wanted: &mut dyn FnMut(&DVector<f64>) -> bool,
        ) -> Result<Computed, Stopped> {
            let (bend, weak) = (2.0 * (-theta[0]).exp(), 0.004);
            let value = |i: usize| if i < 10 { theta[1] + bend } else { weak * (theta[0] - 3.0) };
            let residuals = DVector::from_fn(12, |i, _| value(i) + if i % 2 == 0 { 0.01 } else { -0.01 });
            let by = |i: usize, j: usize| if i < 10 { [-bend, 1.0][j] } else { [weak, 0.0][j] };
            let jacobian = wanted(&residuals).then(|| DMatrix::from_fn(12, 2, by));
            Ok(Some((residuals, jacobian)))
        }
    }

    #[test]
    fn what_follows_an_unknown_that_runs_away_is_not_called_known() {
        let curvature = Unknown {
            unit: "1/m".to_owned(),
            start: 0.0,
            logarithm: false,
            bounds: [-30.0, 30.0],
            prior: [0.0, 10.0],
            ..stiffness("curvature")
        };
        // The fit ends where the first hardly matters any more, and the second seems to be known.
        let unknowns = [Unknown { prior: [20.0, 200.0], ..stiffness("stiffness") }, curvature];
        let points = Points { ranges: (0..12).map(|k| k..k + 1).collect(), noise: None, least_noise: 1e-9 };
        let fit = Fit {
            problem: problem(&unknowns, points, &[]),
            unknowns: &unknowns,
            smooth: Vec::new(),
            chains: Vec::new(),
        };
        let starts = least_squares::starts(&fit.problem, &fit.start(), &mut Valley).expect("nobody stops it");
        let found = least_squares::minimise(&fit.problem, &starts, &mut Valley).expect("nobody stops it");
        let mut found = found.expect("a minimum");
        let (statistics, estimates) = fit.estimates(&mut found, &mut Valley);
        assert!(statistics.by_data[0] > NOT_IDENTIFIABLE && statistics.by_data[1] < NOT_IDENTIFIABLE);
        let reason = estimates[1].reason.as_deref().unwrap_or_default();
        assert!(!estimates[0].identifiable && reason.contains("another fit is as good"), "{estimates:?}");
    }

    #[test]
    fn other_starts_leave_what_is_known() {
        let length = Unknown { unit: "m".to_owned(), ..stiffness("length") };
        let given = Unknown { prior: [1.0, 0.01], knowledge: Knowledge::Given, ..stiffness("given") };
        let unknowns = [stiffness("one"), length, given, stiffness("other")];
        let starts = other_starts(&unknowns, &[]);
        assert_eq!(starts.len(), COMMON_FACTORS.len() + SPREAD_STARTS);
        let of_their_own = &starts[COMMON_FACTORS.len()..];
        assert!(of_their_own.iter().all(|start| start[1] == 0.0 && start[2].abs() <= 0.02));
        for (i, j) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            assert!(of_their_own.iter().any(|start| i * start[0] > 0.5 && j * start[3] > 0.5), "{i} {j}");
        }
        // A stiffness alone has its factors, and pieces that are held together go together.
        assert_eq!(other_starts(&unknowns[..2], &[]).len(), COMMON_FACTORS.len());
        let smooth = Prior { terms: vec![(0, 1.0), (3, -1.0)], value: 0.0, deviation: 0.1 };
        assert!(other_starts(&unknowns, &[smooth]).iter().all(|start| start[0] == start[3]));
    }
}
