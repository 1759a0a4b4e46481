//! A mesh that is as fine as the accuracy of a scenario asks for: `[mesh] accuracy = "2 %"`.
//!
//! Trial runs of the whole scenario estimate the discretisation error of the curvature at every node and increment
//! ([`NodalErrors`]). Errors are of fourth order on even meshes, of second order on graded and coarse ones. So a
//! segment of length ℓ with the error e becomes one of the length `ℓ (t/e)^¼` where it may be longer, and `ℓ √(t/e)`
//! where it must be shorter; t is what is allowed there: the accuracy times the curvature, or times a third of the
//! largest curvature allowed (without a limit: of the branch's largest one, or of a bend of 50 diameters) where that is
//! more. Lengths grow by at most a quarter of the way along the branch, as the scheme has an order only on meshes that
//! change slowly. The mesh of a scenario is the same on every machine: the trial runs are. Those after the first one
//! search for each equilibrium near that of the first one ([`Guide`]); the run itself goes its way by itself.

use wireloom_core::equilibrium::StepResult;
use wireloom_core::{Monitor, Network, Registry, State, Status};
use wireloom_scenario::{Branch, Built, Division, Fault, Scenario};
use wireloom_solve::report::discretisation::NodalErrors;
use wireloom_solve::steps::Guide;
use wireloom_solve::steps::checkpoint::Observer;
use wireloom_solve::{Control, Progress};

/// Largest number of trial runs.
const TRIALS: usize = 3;
/// Factor on the computed lengths of segments, so that most meshes are fine enough after one trial.
const SAFETY: f64 = 0.85;
/// Least and greatest factor on the length of a segment in one trial: farther away the order of the error says little.
const CHANGE: [f64; 2] = [0.125, 2.5];
/// Growth of the length of segments per arc length.
const GROWTH: f64 = 0.25;
/// Least length of a segment in diameters.
const SHORTEST: f64 = 0.1;
/// Fraction of the largest curvature from which on a curvature is estimated to the accuracy.
const RELEVANT: f64 = 1.0 / 3.0;
/// Bend radius in diameters above which a bend does not matter where none is limited: catalogues allow 10 and less.
const GENTLE: f64 = 50.0;
/// Fewest segments of a branch.
const FEWEST: f64 = 4.0;

/// Lengths of segments along each branch; see [`Branch::sizes`].
type Sizes = Vec<Vec<[f64; 2]>>;

/// The scenario with a mesh of its accuracy; as it is where it asks for none, or where `monitor` is told to stop.
///
/// # Errors
/// Those of [`Scenario::build`] with the finer mesh.
pub fn by_accuracy(
    mut scenario: Scenario,
    mut built: Built,
    registry: &Registry,
    monitor: &Monitor,
) -> Result<(Scenario, Built), Vec<Fault>> {
    let Some(mut adaptation) = Adaptation::new(&scenario, &built.network) else { return Ok((scenario, built)) };
    while !monitor.is_stopped() {
        let mut watching = Watching { adaptation: &mut adaptation, state: None, errors: Vec::new(), monitor };
        let Built { network, coarse, schedule, mut minimiser, stop, .. } = built;
        let minimiser = minimiser.as_mut();
        let run =
            wireloom_solve::carry_out(&network, coarse.as_ref(), minimiser, &stop, &schedule, None, &mut watching);
        let next = if monitor.is_stopped() {
            Next::Run
        } else {
            adaptation.end_trial(run.status() == Status::Converged, &mut scenario)
        };
        built = scenario.build(registry)?;
        match next {
            Next::Trial => adaptation.begin_trial(&built.network),
            Next::Run | Next::Done => break,
        }
    }
    if !monitor.is_stopped() {
        built.notes.push(adaptation.note(&built.network));
    }
    Ok((scenario, built))
}

/// Keeps the nodes of a network in the branches whose mesh follows from the accuracy, so that the scenario can be built
/// with further attachments on the same mesh.
pub fn keep_nodes(scenario: &mut Scenario, network: &Network) {
    for (branch, own) in scenario.branches.iter_mut().zip(&network.branches) {
        if matches!(branch.division, Division::ByAccuracy { .. }) {
            let ends = own.rod.mesh().arc_lengths();
            let length = ends[ends.len() - 1];
            branch.nodes = ends.iter().map(|s| s / length).collect();
        }
    }
}

/// What follows a trial run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// Another trial run, on a new mesh.
    Trial,
    /// The run itself, on the mesh that was found: no further trial is made.
    Run,
    /// Nothing: the mesh of the trial run is fine enough, and the run goes as that did, so that it is the run itself.
    Done,
}

/// The mesh of a scenario on the way to its accuracy: trial runs, one after the other.
#[derive(Clone, Debug)]
pub struct Adaptation {
    accuracy: f64,
    /// Number of trial runs that have begun.
    trials: usize,
    /// Largest estimated error of a trial whose mesh was fine enough.
    reached: Option<f64>,
    trial: Trial,
    /// Equilibria of the first trial.
    first: Option<Guide>,
}

impl Adaptation {
    /// The first trial run of a scenario, on its first mesh; `None` where no mesh follows from an accuracy.
    pub fn new(scenario: &Scenario, network: &Network) -> Option<Self> {
        let accuracy = scenario.accuracy?;
        let open = |branch: &Branch| matches!(branch.division, Division::ByAccuracy { .. }) && branch.nodes.is_empty();
        let trial = Trial::new(network, accuracy);
        let first = Guide::new(network);
        scenario.branches.iter().any(open).then_some(Self { accuracy, trials: 1, reached: None, trial, first })
    }

    /// Takes the equilibrium at the end of an increment into account, with its estimated discretisation errors.
    pub fn add(&mut self, end: &StepResult, state: &State, errors: &[NodalErrors]) {
        self.trial.add(end, errors);
        if let (1, Status::Converged, Some(first)) = (self.trials, end.status, &mut self.first) {
            first.add(end, state);
        }
    }

    /// The equilibria near which those of the present trial are searched for.
    pub fn guide(&self) -> Option<Guide> {
        self.first.clone().filter(|_| self.trials > 1)
    }

    /// Ends a trial run, and puts the mesh that follows from it into the scenario, which must then be built anew.
    /// `complete`: the run came to its end. Only such a run whose increments have all converged can be fine enough.
    pub fn end_trial(&mut self, complete: bool, scenario: &mut Scenario) -> Next {
        let complete = complete && self.trial.converged;
        if complete && self.trial.worst <= 1.0 {
            self.reached = Some(self.trial.worst * self.accuracy);
            return if self.guide().is_none() { Next::Done } else { Next::Run };
        }
        for (branch, sizes) in self.trial.sizes(scenario, complete).into_iter().enumerate() {
            let own = &mut scenario.branches[branch];
            if matches!(own.division, Division::ByAccuracy { .. }) {
                own.sizes = sizes;
            }
        }
        if self.trials < TRIALS { Next::Trial } else { Next::Run }
    }

    /// Begins the next trial run, on this mesh.
    pub fn begin_trial(&mut self, network: &Network) {
        self.trials += 1;
        self.trial = Trial::new(network, self.accuracy);
    }

    /// What is being done, in words.
    pub fn progress(&self) -> String {
        let Self { accuracy, trials, .. } = self;
        format!("trial run {trials} of at most {TRIALS} for a mesh of an accuracy of {} %", 1e2 * accuracy)
    }

    /// What was done, with numbers.
    pub fn note(&self, network: &Network) -> String {
        let Self { accuracy, trials, .. } = self;
        let lengths = || network.branches.iter().flat_map(|branch| &branch.rod.mesh().rest_lengths);
        let (least, most) = lengths().fold((f64::INFINITY, 0.0_f64), |(a, b), l| (a.min(*l), b.max(*l)));
        let runs = if *trials == 1 { "1 trial run".to_owned() } else { format!("{trials} trial runs") };
        let error = self.reached.map_or_else(
            || "the sheet says what error is left".to_owned(),
            |error| {
                let of = if self.guide().is_some() { " in the last of them" } else { "" };
                format!("largest estimated error of a bend radius that matters{of} {:.2} %", 1e2 * error)
            },
        );
        format!(
            "mesh for an accuracy of {} %: {} segments of {:.2} to {:.2} mm after {runs}; {error}",
            1e2 * accuracy,
            lengths().count(),
            1e3 * least,
            1e3 * most
        )
    }
}

/// A trial run, and what it says about the mesh.
#[derive(Clone, Debug)]
struct Trial {
    network: Vec<Limits>,
    accuracy: f64,
    /// Arc length and wanted length of segments at each node of each branch, m.
    wanted: Vec<Vec<[f64; 2]>>,
    /// Largest error over what is allowed.
    worst: f64,
    /// Whether all increments have converged.
    converged: bool,
}

/// What the mesh of a branch goes by.
#[derive(Clone, Debug)]
struct Limits {
    /// Largest curvature allowed, 1/m.
    curvature: Option<f64>,
    /// Curvature below which no bend matters where none is limited, 1/m.
    gentle: f64,
    /// Rest lengths of its segments, m.
    lengths: Vec<f64>,
}

impl Trial {
    fn new(network: &Network, accuracy: f64) -> Self {
        let limits = network.branches.iter().map(|branch| Limits {
            curvature: branch.sections.bend_radius_limit().map(|radius| 1.0 / radius),
            gentle: 1.0 / (GENTLE * branch.sections.diameter()),
            lengths: branch.rod.mesh().rest_lengths.clone(),
        });
        let wanted = vec![Vec::new(); network.branches.len()];
        Self { network: limits.collect(), accuracy, wanted, worst: 0.0, converged: true }
    }

    /// Takes the equilibrium at the end of an increment into account.
    fn add(&mut self, end: &StepResult, errors: &[NodalErrors]) {
        self.converged &= end.status == Status::Converged;
        for (b, (branch, errors)) in end.branches.iter().zip(errors).enumerate() {
            let Limits { curvature: limit, gentle, lengths } = &self.network[b];
            let curvature = |i: usize| 1.0 / branch.bend_radius[i];
            let largest = (0..branch.s.len()).map(curvature).fold(0.0, f64::max);
            let relevant = RELEVANT * limit.unwrap_or(largest.max(*gentle));
            let wanted = &mut self.wanted[b];
            if wanted.is_empty() {
                wanted.extend(branch.s.iter().map(|s| [*s, f64::INFINITY]));
            }
            for (i, error) in errors.curvature.iter().enumerate() {
                let allowed = self.accuracy * curvature(i).max(relevant);
                let length = if i == 0 {
                    lengths[0]
                } else if i < lengths.len() {
                    lengths[i - 1].min(lengths[i])
                } else {
                    lengths[i - 1]
                };
                // A straight branch without a limit allows nothing and needs nothing.
                let ratio = if *error > 0.0 { error / allowed } else { 0.0 };
                self.worst = self.worst.max(ratio);
                let order = if ratio < 1.0 { 0.25 } else { 0.5 };
                let factor = (SAFETY * ratio.powf(-order)).clamp(CHANGE[0], CHANGE[1]);
                wanted[i][1] = wanted[i][1].min(length * factor);
            }
        }
    }

    /// Lengths of segments along each branch; half the present ones where nothing is known, as the run did not come to
    /// its end.
    fn sizes(&self, scenario: &Scenario, complete: bool) -> Sizes {
        let of_branch = |(b, wanted): (usize, &Vec<[f64; 2]>)| {
            let own = &scenario.branches[b];
            let shortest = SHORTEST * scenario.thinnest(own);
            let lengths = &self.network[b].lengths;
            let mut ends = vec![0.0];
            ends.extend(lengths.iter().scan(0.0, |s, length| {
                *s += length;
                Some(*s)
            }));
            let unknown = || ends.iter().map(|s| [*s, f64::INFINITY]).collect();
            let mut sizes = if wanted.is_empty() { unknown() } else { wanted.clone() };
            if !complete {
                for (i, size) in sizes.iter_mut().enumerate() {
                    let here = lengths[i.min(lengths.len() - 1)].min(lengths[i.saturating_sub(1)]);
                    size[1] = size[1].min(0.5 * here);
                }
            }
            for size in &mut sizes {
                size[1] = size[1].min(own.length / FEWEST).max(shortest.min(own.length / FEWEST));
            }
            limit_growth(&mut sizes);
            sizes.into_iter().map(|[s, size]| [s / own.length, size / own.length]).collect()
        };
        self.wanted.iter().enumerate().map(of_branch).collect()
    }
}

/// Watches a trial run.
struct Watching<'a> {
    adaptation: &'a mut Adaptation,
    state: Option<State>,
    errors: Vec<NodalErrors>,
    monitor: &'a Monitor,
}

impl Observer for Watching<'_> {
    fn state(&mut self, state: &State, errors: &[NodalErrors]) {
        (self.state, self.errors) = (Some(state.clone()), errors.to_vec());
    }

    fn increment(&mut self, _: &Progress, end: &StepResult, _: bool) -> Control {
        if let Some(state) = &self.state {
            self.adaptation.add(end, state, &self.errors);
        }
        Control::Continue
    }

    fn guide(&self) -> Option<Guide> {
        self.adaptation.guide()
    }

    fn monitor(&self) -> Monitor {
        self.monitor.clone()
    }
}

/// Shortens segments so that their length changes by at most [`GROWTH`] per arc length.
fn limit_growth(sizes: &mut [[f64; 2]]) {
    for k in 1..sizes.len() {
        sizes[k][1] = sizes[k][1].min(sizes[k - 1][1] + GROWTH * (sizes[k][0] - sizes[k - 1][0]));
    }
    for k in (1..sizes.len()).rev() {
        sizes[k - 1][1] = sizes[k - 1][1].min(sizes[k][1] + GROWTH * (sizes[k][0] - sizes[k - 1][0]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_segments_grow_slowly_in_both_directions() {
        let mut sizes = [[0.0, 1.0], [1.0, 0.1], [2.0, 1.0], [3.0, 0.8]];
        limit_growth(&mut sizes);
        for (size, expected) in sizes.iter().zip([0.35, 0.1, 0.35, 0.6]) {
            assert!((size[1] - expected).abs() < 1e-12, "{sizes:?}");
        }
    }
}
