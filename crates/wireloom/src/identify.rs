//! Identification: numbers of a scenario, such as a bending stiffness, from measured points of the real harness.
//!
//! ```
//! use wireloom::identify::{Request, Wishes, identify};
//! use wireloom::scenario::NoFiles;
//! use wireloom::sensitivity::Source;
//!
//! let text = std::fs::read_to_string("../../scenarios/measured/hanging.toml")?;
//! let table = std::fs::read_to_string("../../scenarios/measured/hanging.csv")?;
//! let registry = wireloom::registry();
//! let fit = ["sections.cable.bending_stiffness".to_owned()];
//! let wishes = Wishes { fit: &fit, ..Wishes::default() };
//! let request = Request { tables: &[&table], wishes, noise: None };
//! let found = identify(Source::new(&text, &NoFiles, &registry), &request).expect("it can be carried out");
//! let stiffness = &found.parameters[0];
//! println!("{:?} ± {:?} {}", stiffness.value, stiffness.deviation, stiffness.unit);
//! # assert!(found.is_complete());
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! A table has a line for each measured point: `configuration, marker, x, y, z` (m). A configuration is the end of the
//! step of that name; of a scenario with one step, that step. A marker is one of `[[markers]]`, a joint or a free end;
//! instead of it the columns `branch, s` name a place by its arc length (m). Markers may be missing in some
//! configurations, and an empty cell is a coordinate that was not measured. All tables together are one fit.
//!
//! # Method
//!
//! Every trial carries the scenario out from its beginning, on one mesh; the initial equilibrium is searched for near
//! that of the values from which the fit goes on, if it has one there. Steps are those of Gauss and Newton with the
//! derivatives of [`crate::sensitivity`], damped after Levenberg and Marquardt. Where an equilibrium has no derivatives
//! (contact changes, it is neutral) they are differences of whole runs. A trial that comes to no equilibrium makes the
//! step shorter. The loss is that of Huber: points farther than three times the noise pull with a constant force. The
//! noise of one coordinate is estimated from the residuals, unless it is given. Numbers that are positive (stiffness,
//! length, mass) are fitted by their logarithm. Before the first step, stiffness is also tried at a third, a tenth,
//! three times and ten times its start.
//!
//! Where a harness has several equilibria, the points tell which one was measured: branches without a `path` are also
//! tried with one through the points of the first measured step. If that comes nearer to the points, it is part of the
//! fitted scenario ([`Identified::drawn`]).
//!
//! # Priors
//!
//! Each unknown has a prior: the user's; for values that follow from the wires of a section, the rule with its
//! uncertainty; otherwise a weak one, whose deviation is a factor of ten (numbers that are not positive: one length of
//! the longest branch, or ten radians over it). Points that say anything outweigh a weak prior.
//!
//! # What is not identifiable
//!
//! An unknown is *not identifiable*, and has no [`Estimate::value`], if one of these holds. Prior knowledge does not
//! count here; smoothness does.
//!
//! - Its deviation from the points alone is more than 30 % of its value (numbers that are not positive: 3 % of the
//!   longest branch, 0.3 rad over it, 0.3 rad).
//! - It ended at a bound: without others, 10⁴ times or 10⁻⁴ of its start.
//! - Two deviations away from the fit, with the other unknowns following, the misfit grows by less than a quarter of
//!   what a normal distribution has there: to that side it is open.
//! - There are not more coordinates than unknowns, and the noise is not given.
//!
//! Deviations are those of the linearised problem, with Student's distribution for the interval. Where the residuals of
//! points beside each other are correlated, the model misses something that noise does not explain: deviations are then
//! larger by √((1 + ρ)/(1 − ρ)).

mod drawn;
mod harness;
mod least_squares;
mod points;
mod statistics;
mod unknowns;

pub use points::{COLUMNS, MeasuredPlace, MeasuredPoint, PLACE};
pub use unknowns::{Knowledge, Unknown, Wishes};

use crate::sensitivity::{NoAnswer, Source, Study};
use harness::{Harness, position, rows};
use least_squares::{Ending, Minimum, Model, Points, Prior, Problem, Stopped};
use nalgebra::DVector;
use serde::Serialize;
use statistics::Statistics;
use wireloom_core::equilibrium::PartFault;
use wireloom_core::{Network, Status, StepResult, Vector};
use wireloom_scenario::record::{self, Attachment};
use wireloom_scenario::{Built, Fault, Scenario};
use wireloom_solve::steps::steps_of;

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
/// Accuracy of computed positions, relative to the length of all branches.
const ACCURACY: f64 = 1e-7;
/// Distance of points of the same equilibrium, in units of the accuracy of computed positions.
const SAME: f64 = 1e3;
/// Largest step of an unknown in one iteration: a factor of ten.
const LARGEST_STEP: f64 = std::f64::consts::LN_10;
/// Sum of the distances of the points from a drawn start, relative to that from the scenario's own, below which they are
/// other equilibria.
const NEARER: f64 = 0.9;
/// Correlation of two unknowns from which on they are named together.
const TOGETHER: f64 = 0.9;

/// What is to be identified from what.
#[derive(Clone, Copy, Debug, Default)]
pub struct Request<'a> {
    /// Tables of measured points.
    pub tables: &'a [&'a str],
    /// Unknowns, with what is known of them.
    pub wishes: Wishes<'a>,
    /// Standard deviation of a measured coordinate, m; `None`: it is estimated.
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FitStatus {
    /// At a minimum of the misfit.
    Converged,
    /// Not at a minimum: no step led to less, or there were too many.
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
#[derive(Clone, Debug, Serialize)]
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
    /// Those among them that could not be computed.
    pub derivatives_missing: usize,
    /// Branches whose start is drawn through the measured points: from the scenario's own start it comes to other
    /// equilibria, farther from the points, or to none.
    pub drawn: Vec<String>,
    /// Number of measured coordinates.
    pub coordinates: usize,
    /// Standard deviation of one coordinate, m: of the residuals, or the given one if that is larger.
    pub noise: Option<f64>,
    /// Correlation of the residuals of points beside each other.
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
    /// The scenario's text with the fitted values; comments stay.
    #[serde(skip)]
    pub text: String,
    /// The equilibria at the end of each step up to the last measured one.
    #[serde(skip)]
    pub ends: Vec<StepResult>,
}

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
    /// Whether the fit converged, with every configuration in equilibrium, and every parameter is identifiable.
    pub fn is_complete(&self) -> bool {
        self.status == FitStatus::Converged && self.identifiable
    }
}

/// Identifies numbers of a scenario from measured points.
///
/// # Errors
/// Faults of the scenario or the table, a question that cannot be answered, or no equilibrium to begin with.
pub fn identify(source: Source<'_>, request: &Request<'_>) -> Result<Identified, NoFit> {
    let loaded = crate::load_with_files(&source.text, source.files, source.registry).map_err(NoFit::Faults)?;
    let points = read_points(request, &loaded.0, &loaded.1)?;
    let text = with_places(&source.text, &points).map_err(|fault| NoFit::Faults(vec![fault]))?;
    let first = Study::new(Source { text: text.into(), ..source.clone() }).map_err(no_fit)?;
    let scenario = first.scenario();
    let (unknowns, text) =
        unknowns::unknowns(first.text(), scenario, source.registry, request.wishes).map_err(NoFit::Question)?;
    let smooth = unknowns::smoothness(&unknowns, request.wishes.smooth).map_err(NoFit::Question)?;
    let coordinates: usize = points.iter().map(MeasuredPoint::coordinates).sum();
    if coordinates < unknowns.len() {
        let counts = format!("{coordinates} measured coordinates for {} parameters", unknowns.len());
        return Err(NoFit::Question(format!("{counts}: measure more points, or fit fewer parameters")));
    }
    let total: f64 = scenario.branches.iter().map(|branch| branch.length).sum();
    let fit = Fit {
        problem: problem(&unknowns, &points, &smooth, request.noise, ACCURACY * total),
        chains: chains(first.network(), &points),
        unknowns: &unknowns,
        points: &points,
        smooth,
    };
    let through_points = drawn::drawn(&text, scenario, &first.network().markers, &points, source.registry);
    let source = Source { text: text.into(), ..source };
    let mut harness = Harness {
        source,
        mesh: scenario,
        unknowns: &unknowns,
        points: &points,
        work: harness::Work::default(),
        reference: None,
        failure: None,
    };
    let start = DVector::from_iterator(unknowns.len(), unknowns.iter().map(|own| own.theta(own.start)));
    let drawn = match through_points {
        Some((text, names)) => {
            let comes_nearer = from_drawn_start(&fit.problem, &start, &mut harness, text);
            if comes_nearer.map_err(|Stopped| NoFit::Stopped)? { names } else { Vec::new() }
        }
        None => Vec::new(),
    };
    let minimum = least_squares::minimise(&fit.problem, &start, &mut harness).map_err(|Stopped| NoFit::Stopped)?;
    let Some(mut minimum) = minimum else {
        let reason = harness.failure.unwrap_or_default();
        return Err(NoFit::NoStart { reason, solves: harness.work.solves });
    };
    let names: Vec<String> = first.steps().iter().map(|step| step.name.clone()).collect();
    let found = fit.answer(&mut minimum, &mut harness, &scenario.name, &names)?;
    Ok(Identified { drawn, ..found })
}

/// Reads the points, with what the scenario has.
fn read_points(request: &Request<'_>, scenario: &Scenario, built: &Built) -> Result<Vec<MeasuredPoint>, NoFit> {
    if request.noise.is_some_and(|noise| !(noise.is_finite() && noise > 0.0)) {
        return Err(NoFit::Question("the noise of the measured coordinates must be above 0 m".to_owned()));
    }
    let network = &built.network;
    let steps: Vec<String> = steps_of(&built.schedule).iter().map(|step| step.name.clone()).collect();
    let markers = network.markers.iter().map(|marker| marker.name.clone());
    let markers: Vec<String> = markers.chain(network.joints.iter().map(|joint| joint.name.clone())).collect();
    let vertices = scenario.branches.iter().flat_map(|branch| branch.vertices.iter());
    let ends: Vec<String> = vertices.filter(|name| !markers.contains(name)).cloned().collect();
    let branches: Vec<(String, f64)> =
        scenario.branches.iter().map(|branch| (branch.name.clone(), branch.length)).collect();
    let held = network.constraints.iter().filter_map(|constraint| constraint.position).map(|x| x.norm());
    let reach = branches.iter().map(|(_, length)| length).sum::<f64>() + held.fold(0.0, f64::max);
    let names = points::Names { steps: &steps, markers: &markers, ends: &ends, branches: &branches, reach };
    let mut all = Vec::new();
    for (k, table) in request.tables.iter().enumerate() {
        all.extend(points::read(table, names).map_err(|faults| NoFit::Table(k, faults))?);
    }
    Ok(all)
}

/// The text with a marker at each measured place that has none.
fn with_places(text: &str, points: &[MeasuredPoint]) -> Result<String, Fault> {
    let mut further: Vec<(String, Attachment)> = Vec::new();
    for point in points {
        let at = match &point.place {
            MeasuredPlace::Named => continue,
            MeasuredPlace::End => Attachment::End(point.marker.clone()),
            MeasuredPlace::Along(branch, s) => Attachment::Branch(branch.clone(), *s),
        };
        if further.iter().all(|(name, _)| *name != point.marker) {
            further.push((point.marker.clone(), at));
        }
    }
    if further.is_empty() { Ok(text.to_owned()) } else { record::with_markers(text, &further) }
}

/// Gives the harness the text with a drawn start if one of the starts of the fit comes nearer to the points from it.
fn from_drawn_start(
    problem: &Problem,
    start: &DVector<f64>,
    harness: &mut Harness<'_>,
    text: String,
) -> Result<bool, Stopped> {
    let own = least_squares::least_distance(problem, start, harness)?;
    let undrawn = std::mem::replace(&mut harness.source.text, text.into());
    let from_drawn = least_squares::least_distance(problem, start, harness)?;
    let nearer = from_drawn < NEARER * own;
    if !nearer {
        harness.source.text = undrawn;
    }
    Ok(nearer)
}

fn problem(
    unknowns: &[Unknown],
    points: &[MeasuredPoint],
    smooth: &[Prior],
    noise: Option<f64>,
    least_noise: f64,
) -> Problem {
    let ranges = rows(points).map(|(first, point)| first..first + point.coordinates()).collect();
    let shifted = |factor: f64| {
        let more = |own: &Unknown| if own.is_stiffness() { factor.ln() } else { 0.0 };
        DVector::from_iterator(unknowns.len(), unknowns.iter().map(more))
    };
    let stiff = unknowns.iter().any(Unknown::is_stiffness);
    let factors: &[f64] = if stiff { &[0.3, 3.0, 0.1, 10.0] } else { &[] };
    Problem {
        points: Points { ranges, noise, least_noise },
        priors: unknowns.iter().enumerate().map(|(i, own)| own.prior(i)).chain(smooth.iter().cloned()).collect(),
        bounds: unknowns.iter().map(Unknown::theta_bounds).collect(),
        largest_step: LARGEST_STEP,
        starts: factors.iter().map(|factor| shifted(*factor)).collect(),
    }
}

/// Points that lie beside each other on one branch in one configuration, in order.
fn chains(network: &Network, points: &[MeasuredPoint]) -> Vec<Vec<usize>> {
    let mut placed: Vec<(&str, usize, f64, usize)> = Vec::new();
    for (k, point) in points.iter().enumerate() {
        if let Some(marker) = network.markers.iter().find(|marker| marker.name == point.marker) {
            placed.push((&point.configuration, marker.branch, marker.s, k));
        }
    }
    placed.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    let together = placed.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    together.map(|chain| chain.iter().map(|(.., k)| *k).collect()).collect()
}

fn no_fit(reason: NoAnswer) -> NoFit {
    match reason {
        NoAnswer::Faults(faults) => NoFit::Faults(faults),
        NoAnswer::Part(fault) => NoFit::Part(fault),
        NoAnswer::Stopped => NoFit::Stopped,
        other => NoFit::Question(other.to_string()),
    }
}

/// A fit and its data.
struct Fit<'f> {
    problem: Problem,
    unknowns: &'f [Unknown],
    points: &'f [MeasuredPoint],
    smooth: Vec<Prior>,
    chains: Vec<Vec<usize>>,
}

impl Fit<'_> {
    fn answer(
        &self,
        at: &mut Minimum,
        harness: &mut Harness<'_>,
        scenario: &str,
        steps: &[String],
    ) -> Result<Identified, NoFit> {
        let statistics = Statistics::new(&self.problem, at, &self.smooth, &self.chains);
        let mut reasons: Vec<Option<String>> = Vec::with_capacity(self.unknowns.len());
        for i in 0..self.unknowns.len() {
            let reason = match self.not_identifiable(i, at, &statistics) {
                None if at.ending == Ending::Stopped => None,
                None => self.open_side(i, at, &statistics, harness).unwrap_or_else(|Stopped| {
                    at.ending = Ending::Stopped;
                    None
                }),
                some => some,
            };
            reasons.push(reason);
        }
        // A monitor that has stopped the fit would stop this one, too; what was computed is not lost.
        harness.source.monitor = wireloom_core::Monitor::default();
        let ends = harness.ends(&at.theta).map_err(|Stopped| NoFit::Stopped)?.unwrap_or_default();
        // Users carry the fitted scenario out from its beginning.
        harness.reference = None;
        let anew = harness.ends(&at.theta).map_err(|Stopped| NoFit::Stopped)?.unwrap_or_default();
        let same = at.scale.max(SAME * self.problem.points.least_noise);
        let comes_again = |point: &MeasuredPoint| {
            let [one, other] = [&ends, &anew].map(|all| all.get(point.step).map(|end| position(end, &point.marker)));
            one.zip(other).is_some_and(|(one, other)| (one - other).norm() <= same)
        };
        let repeatable = self.points.iter().all(comes_again);
        let work = harness.work;
        let parameters = reasons.into_iter().enumerate().map(|(i, reason)| self.estimate(i, at, &statistics, reason));
        let parameters: Vec<Estimate> = parameters.collect();
        let configurations = self.configurations(at, &ends, steps);
        let settled = configurations.iter().all(|own| own.status == Status::Converged.word());
        let status = match at.ending {
            Ending::Converged if settled => FitStatus::Converged,
            Ending::Stopped => FitStatus::Interrupted,
            _ => FitStatus::NotConverged,
        };
        let unknowns = 0..self.unknowns.len();
        Ok(Identified {
            scenario: scenario.to_owned(),
            identifiable: parameters.iter().all(|own| own.identifiable),
            iterations: at.iterations,
            solves: work.solves,
            failed_solves: work.failed,
            derivatives: work.derivatives,
            derivatives_by_runs: work.by_runs,
            derivatives_missing: work.none,
            coordinates: self.problem.points.residuals(),
            noise: statistics.noise,
            neighbour_correlation: statistics.neighbours,
            widened: statistics.widened,
            repeatable,
            correlations: unknowns.map(|i| statistics.correlations.row(i).iter().copied().collect()).collect(),
            text: harness.text(&at.theta).map_err(NoFit::Question)?,
            status,
            parameters,
            drawn: Vec::new(),
            configurations,
            ends,
        })
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
        harness: &mut Harness<'_>,
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
            let Some((residuals, _)) = harness.compute(&theta, &mut |_| false)? else { continue };
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

    fn configurations(&self, at: &Minimum, ends: &[StepResult], steps: &[String]) -> Vec<Configuration> {
        let mut all: Vec<Configuration> = Vec::new();
        for (k, point) in self.points.iter().enumerate() {
            let end = ends.get(point.step);
            let found = all.iter().position(|own| own.name == point.configuration);
            let own = found.unwrap_or_else(|| {
                all.push(Configuration {
                    name: point.configuration.clone(),
                    step: steps[point.step].clone(),
                    status: end.map_or(Status::Interrupted, |end| end.status).word(),
                    mean_distance: 0.0,
                    rms_distance: 0.0,
                    largest_distance: 0.0,
                    points: Vec::new(),
                });
                all.len() - 1
            });
            let mut computed = end.map_or_else(|| Vector::repeat(f64::NAN), |end| position(end, &point.marker));
            let mut rest = self.problem.points.ranges[k].clone();
            for (axis, measured) in point.position.iter().enumerate() {
                let Some(measured) = measured else { continue };
                computed[axis] = measured + rest.next().map_or(0.0, |i| at.residuals[i]);
            }
            all[own].points.push(FittedPoint {
                marker: point.marker.clone(),
                measured: point.position,
                computed: [computed.x, computed.y, computed.z],
                distance: self.problem.points.distance(k, &at.residuals),
                weight: self.problem.points.weight(k, &at.residuals, at.scale),
            });
        }
        for own in &mut all {
            let n = own.points.len() as f64;
            let distances = || own.points.iter().map(|point| point.distance);
            (own.mean_distance, own.rms_distance, own.largest_distance) = (
                distances().sum::<f64>() / n,
                (distances().map(|d| d * d).sum::<f64>() / n).sqrt(),
                distances().fold(0.0, f64::max),
            );
        }
        all
    }
}
