//! Equilibria of slightly changed scenarios, near the equilibrium at the end of an increment.
//!
//! With r(x, p) the free part of the gradient of the energy, an equilibrium x(p) satisfies `r = 0`, so its derivative
//! by a number p of the scenario is `dx/dp = −H⁻¹ ∂r/∂p`, with H the Hessian. [`Neighbourhood`] keeps the factor of H
//! at the equilibrium. For a harness that is built of a scenario with a slightly different p it evaluates r at the old
//! equilibrium, and solves with the kept factor: that step is the tangent, for every model and plugin, without code of
//! their own. Further steps with the same factor (simplified Newton method; Deuflhard 2004, section 2.1.3) remove
//! what is of higher order, so that what is found is an equilibrium, which the certificate confirms. No matrix is
//! factorised.
//!
//! Differences of results of two such equilibria, one on each side, are derivatives of any result. [`Moved`] does the
//! same for a constraint that is moved from where it is, without a scenario.
//!
//! **What is kept.** The path to the equilibrium is not computed again. Its history is that of the reference: memories
//! of rods, joints and constraints, anchors of friction, contact points, which constraints slip, and which ones still
//! act. Targets, gravity, rotation, loads, temperatures and poses of bodies are those that the steps of the changed
//! scenario lead to ([`Neighbourhood::find`] walks through its plans). Where a step begins with a constraint that takes
//! the cable where it is, the equilibrium at the beginning of that step is found in the same way first.

mod moved;

pub use moved::Moved;

use crate::contact::multipliers::{self, ContactHistory};
use crate::report::clearance::Cables;
use crate::report::requirements::Equilibrium;
use crate::report::sheet::{Found, Here, Sheet};
use crate::report::spans::Spans;
use crate::report::{EventLog, branch, discretisation};
use crate::start::layout;
use crate::steps::certificate::Certifier;
use crate::steps::checkpoint::Checkpoint;
use crate::steps::driver::Driver;
use crate::steps::plan::journey_to_target;
use crate::steps::run::steps_of;
use crate::steps::stability::{Inspector, Stability};
use crate::steps::step_result;
use std::collections::BTreeSet;
use wireloom_core::conditions::{Conditions, ContactState, Partner};
use wireloom_core::constraint::{Action, RotationHold};
use wireloom_core::equilibrium::{MinimiserResult, RequirementResult, StepResult};
use wireloom_core::load::LoadAction;
use wireloom_core::minimiser::{Minimiser, Stop};
use wireloom_core::network::{AttachedConstraint, Load, Place};
use wireloom_core::scales::nan_max;
use wireloom_core::steps::{Schedule, Step, Turn};
use wireloom_core::{Moment, Monitor, Network, Problem, State, Status, Tangent, Vector};

/// Largest residual, relative to the scales of the branches and above round-off, of a state in balance that further
/// steps do not improve: round-off of what is not in the scales.
const BALANCED: f64 = 1e-12;
/// The same after [`MISSES`] steps that did not reduce it: stiff contacts round off more.
const LEAST_BALANCED: f64 = 1e-10;
/// The same as a fraction of the largest residual on the way, and for violations: the accuracy of differences.
const ACCURACY: f64 = 1e-6;
/// Last step as a fraction of the first one where round-off allows no smaller one.
const LEAST_ACCURACY: f64 = 1e-3;
/// Length of a step beyond which what is found is not near: move relative to the longest branch, or turn (rad).
const LONGEST: f64 = 1.0;
/// Length of a first step below which it is round-off: move relative to the longest branch, or turn (rad).
const SMALLEST: f64 = 1e-6;
/// Largest violation of equations (in units of their scales) and of contact (in radii), likewise.
const SATISFIED: f64 = 1e-12;
/// Least reduction of a residual or a violation, as a fraction of the last one, that is progress.
const PROGRESS: f64 = 0.5;
/// Largest number of steps with the kept factor in one balance.
const STEPS: usize = 40;
/// Number of steps without progress after which there is none.
const MISSES: usize = 4;
/// Largest number of updates of multipliers.
const UPDATES: usize = 60;
/// Largest difference (m, rad) of targets that are the same, and of what is held from them. Where a constraint takes
/// the cable where it is, they are as exact as the run: its equilibria are balanced further here.
const SAME_TARGET: f64 = 1e-5;
/// Largest difference of load factors, temperatures (K), accelerations and speeds of rotation (SI) that are the same.
const SAME_LOAD: f64 = 1e-9;

/// Reason why an equilibrium near the reference was not found.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotFound {
    /// The reference is at the end of an increment that did not converge.
    #[error("there is no converged equilibrium")]
    NotConverged,
    /// The reference is unstable.
    #[error("the equilibrium is not stable: it has no neighbour that the harness would stay in")]
    Unstable,
    /// The reference is neutral.
    #[error("the equilibrium is neutral (a motion changes its energy by round-off only), as at a limit point")]
    Neutral,
    /// The changed harness has other nodes or parts.
    #[error("the mesh or the parts of the harness change")]
    OtherParts,
    /// What has crept depends on the way to the reference.
    #[error("times of creep change, and what has crept follows from the way there: run the scenario with both values")]
    OtherTimes,
    /// The targets of the reference do not follow from its steps.
    #[error("the targets of the constraints do not follow from the steps alone")]
    OtherPath,
    /// The steps with the kept factor did not lead to an equilibrium.
    #[error(
        "no equilibrium found nearby (residual {0:.1e}): the equilibrium changes abruptly, or sections or contacts are \
         where they begin to slip or yield"
    )]
    Unbalanced(f64),
    /// Other points touch.
    #[error("contact changes")]
    OtherContacts,
    /// Contact or equations were not satisfied.
    #[error("contact or equations of constraints are not satisfied nearby (violation {0:.1e})")]
    Violated(f64),
    /// A part failed.
    #[error("a part failed: {0}")]
    Fault(String),
}

/// An equilibrium near the reference.
#[derive(Clone, Debug)]
pub struct Nearby {
    /// Result, without stability and what belongs to the path.
    pub end: StepResult,
    /// The sheet of this equilibrium alone, without discretisation errors; empty if it was not asked for.
    pub requirements: Vec<RequirementResult>,
    /// Distance from the reference: largest move relative to the longest branch, or largest turn (rad).
    pub distance: f64,
    /// Contact points that touch, with their partners.
    pub touching: BTreeSet<(u32, Partner)>,
}

/// The equilibrium at the end of an increment, and the equilibria of slightly changed scenarios near it.
pub struct Neighbourhood<'n> {
    network: &'n Network,
    stop: Stop,
    /// Index of the step.
    step: usize,
    /// How much of it is done, up to 1.
    fraction: f64,
    /// References: at the beginning of each step up to this one (where an equilibrium there is needed), and within or
    /// at the end of this one.
    references: Vec<Reference<'n>>,
    /// See [`times`].
    times: Vec<f64>,
    /// Rest lengths of the reference's segments at the beginning of each step, m, once the stations of what begins with
    /// it are placed.
    begun: Vec<Vec<f64>>,
}

/// A reference on the path.
enum Reference<'n> {
    /// Only what is kept of it is needed.
    Passed(Box<Checkpoint>),
    /// Its neighbours are needed.
    Kept(Box<Kept<'n>>),
}

impl Reference<'_> {
    fn checkpoint(&self) -> &Checkpoint {
        match self {
            Reference::Passed(checkpoint) => checkpoint,
            Reference::Kept(kept) => &kept.checkpoint,
        }
    }
}

impl<'n> Neighbourhood<'n> {
    /// Neighbourhood of the end of an increment, where a fraction (up to 1) of its step is done. `path`: the
    /// checkpoints at the beginning of each step up to this one, then that of the increment
    /// ([`crate::steps::interactive::InteractiveDriver::advance`]).
    ///
    /// # Errors
    /// If it is no equilibrium that has neighbours.
    ///
    /// # Panics
    /// If there are fewer than two checkpoints.
    pub fn new(
        network: &'n Network,
        schedule: &Schedule,
        stop: &Stop,
        minimiser: &mut dyn Minimiser,
        path: Vec<Checkpoint>,
        fraction: f64,
    ) -> Result<Self, NotFound> {
        let (step, steps) = (path.len() - 2, steps_of(schedule));
        let reference = |(k, checkpoint): (usize, Checkpoint)| {
            let checkpoint = Box::new(Checkpoint { log: EventLog::default(), ..checkpoint });
            // Within a step its constraints are on the way from where they began, whatever they are given.
            let within = k == step && fraction < 1.0 && !steps[k].add.is_empty();
            let takes = within || k <= step && takes_where_it_is(network, &steps[k]);
            if takes || k > step {
                Kept::new(network, checkpoint).map(|kept| Reference::Kept(Box::new(kept)))
            } else {
                Ok(Reference::Passed(checkpoint))
            }
        };
        let references = path.into_iter().enumerate().map(reference).collect::<Result<Vec<_>, NotFound>>()?;
        let times = times(network, schedule);
        let mut new = Self { network, stop: *stop, step, fraction, references, times, begun: Vec::new() };
        // What follows from the plans alone must be what the run led to.
        let (walked, _) = new.walk(network, schedule, minimiser)?;
        let reached = new.references[step + 1].checkpoint();
        let mut problem = Problem::new(network, merged(&reached.conditions, &walked));
        problem.update_held(&reached.state);
        let mut motion = Tangent::zeros(network);
        problem.motion(&reached.state, &mut motion);
        let held = motion.points.iter().chain(&motion.frames).all(|v| v.norm() <= SAME_TARGET);
        let reached = &reached.conditions;
        let same = |(f, constraint): (usize, &AttachedConstraint)| {
            let prescribes = matches!(constraint.model.action(), Action::Prescribed(_));
            let [a, b] = [&walked.targets[f], &reached.targets[f]];
            let turned = a.orientation.angle_to(&b.orientation);
            let near = (a.position - b.position).norm() <= SAME_TARGET && turned <= SAME_TARGET;
            !reached.active[f] || prescribes || near
        };
        let near = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME_LOAD;
        let loads = walked.load_factors.iter().zip(&reached.load_factors).all(near);
        let temperatures = walked.temperatures.iter().zip(&reached.temperatures).all(near);
        let gravity = (walked.gravity - reached.gravity).norm() <= SAME_LOAD;
        let rotation = (walked.rotation.velocity - reached.rotation.velocity).norm() <= SAME_LOAD;
        let loads = loads && temperatures && gravity && rotation;
        let all = held && network.constraints.iter().enumerate().all(same) && loads;
        if all { Ok(new) } else { Err(NotFound::OtherPath) }
    }

    /// The equilibrium of a slightly changed harness and schedule near the reference; with `sheet` also its sheet.
    /// `minimiser` is one of the changed scenario; it finds nothing.
    ///
    /// # Errors
    /// If there is none, or the change is too large.
    pub fn find(
        &mut self,
        network: &Network,
        schedule: &Schedule,
        minimiser: &mut dyn Minimiser,
        sheet: bool,
    ) -> Result<Nearby, NotFound> {
        let alike = self.references.iter().all(|reference| reference.checkpoint().fits(network));
        if !alike || !same_places(self.network, network) {
            return Err(NotFound::OtherParts);
        }
        let (walked, change) = self.walk(network, schedule, minimiser)?;
        if times(network, schedule) != self.times {
            return Err(NotFound::OtherTimes);
        }
        let step = self.step;
        let settled = self.settle(step + 1, network, &walked, &change)?;
        let moment = Moment { step: steps_of(schedule)[step].name.clone(), step_index: step, increment: 0 };
        settled.measured(&self.stop, moment, sheet.then_some((Some(step), self.fraction == 1.0)))
    }

    /// Whether the equilibrium depends on its history: friction, slip, or a part that remembers.
    pub fn has_history(&self) -> bool {
        has_history(self.network, &self.references[self.step + 1].checkpoint().conditions)
    }

    /// Name of a branch and what it touches at a contact point.
    pub fn words(&self, (point, partner): (u32, Partner)) -> String {
        let Reference::Kept(kept) = &self.references[self.step + 1] else { unreachable!("the end is always kept") };
        kept.words((point, partner))
    }

    /// Conditions at the end of the increment, as far as they follow from the plans of the steps, and how much longer
    /// the segments are than those of the reference, m. The first walk is that of the reference itself.
    fn walk(
        &mut self,
        network: &Network,
        schedule: &Schedule,
        minimiser: &mut dyn Minimiser,
    ) -> Result<(Conditions, Vec<f64>), NotFound> {
        let mut change = longer(&State::origin(network).rest_lengths, &State::origin(self.network).rest_lengths);
        let from_start = || (0..network.constraints.len()).filter(|f| network.constraints[*f].from_start);
        let laid_out = if from_start().any(|f| !has_own_target(network, f)) {
            layout::place(network, schedule)
        } else {
            carried(&self.references[0].checkpoint().state, &change, network)
        };
        let mut problem = Problem::new(network, Conditions::new(network, schedule.gravity, &laid_out));
        for (f, constraint) in network.constraints.iter().enumerate().filter(|(_, constraint)| constraint.from_start) {
            let from = problem.conditions().constraints[f].base;
            problem.set_target(f, journey_to_target(f, constraint, from).at(1.0));
        }
        let mut walked = problem.conditions().clone();
        for (k, step) in steps_of(schedule)[..=self.step].iter().enumerate() {
            let state = match &self.references[k] {
                Reference::Kept(_) => self.settle(k, network, &walked, &change)?.state,
                Reference::Passed(checkpoint) => carried(&checkpoint.state, &change, network),
            };
            let reached = self.references[k].checkpoint();
            let conditions = merged(&reached.conditions, &walked);
            let checkpoint = Checkpoint { conditions, state, ..reached.clone() };
            let monitor = Monitor::default();
            let (mut driver, _) = Driver::at_checkpoint(network, minimiser, &self.stop, checkpoint, &monitor);
            let plan = driver.begin_step(step, k == 0, &mut Vec::new());
            plan.apply(&mut driver.problem, if k == self.step { self.fraction } else { 1.0 });
            walked = driver.problem.conditions().clone();
            // A clip closes at another place of the cable than in the reference.
            if self.begun.len() == k {
                self.begun.push(driver.state.rest_lengths.clone());
            }
            change = longer(&driver.state.rest_lengths, &self.begun[k]);
        }
        Ok((walked, change))
    }

    /// The equilibrium of a changed harness near a reference, under conditions of which targets and loads are `walked`;
    /// its segments are longer by `change`.
    fn settle<'m>(
        &mut self,
        k: usize,
        network: &'m Network,
        walked: &Conditions,
        change: &[f64],
    ) -> Result<Settled<'m>, NotFound> {
        let Reference::Kept(kept) = &mut self.references[k] else { unreachable!("it was kept for this") };
        let mut problem = Problem::new(network, merged(&kept.checkpoint.conditions, walked));
        let mut state = carried(&kept.checkpoint.state, change, network);
        let distance = kept.settle(&mut problem, &mut state)?;
        Ok(Settled { problem, state, distance })
    }
}

/// An equilibrium with a kept factor.
struct Kept<'n> {
    /// Its conditions and its state, balanced beyond the tolerance of the run.
    checkpoint: Box<Checkpoint>,
    problem: Problem<'n>,
    inspector: Inspector,
    // Scratch:
    gradient: Tangent,
    free: Tangent,
    motion: Tangent,
    from: State,
    /// Largest residual since the last call of [`Self::settle`].
    largest: f64,
    /// Contacts of the reference; `None` before they are known.
    touching: Option<BTreeSet<(u32, Partner)>>,
}

impl<'n> Kept<'n> {
    fn new(network: &'n Network, checkpoint: Box<Checkpoint>) -> Result<Self, NotFound> {
        let mut kept = Self {
            problem: Problem::new(network, checkpoint.conditions.clone()),
            inspector: Inspector::new(&Problem::new(network, checkpoint.conditions.clone())),
            gradient: Tangent::zeros(network),
            free: Tangent::zeros(network),
            motion: Tangent::zeros(network),
            from: checkpoint.state.clone(),
            largest: 0.0,
            touching: None,
            checkpoint,
        };
        let mut problem = Problem::new(network, kept.checkpoint.conditions.clone());
        let mut state = kept.checkpoint.state.clone();
        problem.find_contacts(&state);
        let mut contacts = bearing(&problem);
        loop {
            kept.factorise()?;
            let settled = kept.settle(&mut problem, &mut state);
            kept.checkpoint.state.copy_from(&state);
            kept.checkpoint.conditions = problem.conditions().clone();
            // Where a contact that bore next to no force has opened, the factor was that of one more.
            let now = bearing(&problem);
            match settled {
                Ok(_) => break,
                Err(NotFound::Unbalanced(_)) if now.len() < contacts.len() => contacts = now,
                Err(none) => return Err(none),
            }
            kept.problem = Problem::new(network, kept.checkpoint.conditions.clone());
        }
        kept.touching = Some(pressed(&problem));
        kept.problem = problem;
        // With the multipliers that were found, at the state that was found.
        kept.factorise()?;
        Ok(kept)
    }

    /// Name of a branch and what it touches at a contact point.
    fn words(&self, (point, partner): (u32, Partner)) -> String {
        let network = self.problem.network;
        let branch = &network.branches[self.problem.contact().point(point).branch].name;
        match (partner.obstacle(), partner.branch()) {
            (Some(obstacle), _) => {
                format!("branch `{branch}` and obstacle `{}`", network.obstacles[obstacle as usize].name)
            }
            (None, Some(other)) => format!("branches `{branch}` and `{}`", network.branches[other].name),
            (None, None) => format!("branch `{branch}`"),
        }
    }

    /// Factorises the Hessian at the reference.
    fn factorise(&mut self) -> Result<(), NotFound> {
        let Self { checkpoint, problem, inspector, gradient, .. } = self;
        let state = &checkpoint.state;
        problem.update_held(state);
        problem.gradient(state, gradient);
        let inspection = inspector.inspect(problem, state, gradient);
        match inspection.stability {
            Stability::Stable => {}
            Stability::Neutral if inspection.is_uncertain => {}
            // The Hessian lacks what has no potential, and alone says nothing.
            _ if !problem.has_potential() && !problem.has_slides() && !inspector.diverges(problem, state, gradient) => {
            }
            Stability::Neutral => return Err(NotFound::Neutral),
            Stability::Unstable => return Err(NotFound::Unstable),
        }
        Ok(())
    }

    /// Moves `state` to the equilibrium of `problem`, a slightly changed one, with multipliers. Returns the distance.
    fn settle(&mut self, problem: &mut Problem<'_>, state: &mut State) -> Result<f64, NotFound> {
        let mut history = ContactHistory::of_kept_matrix();
        let (mut last, mut misses, mut distance) = (f64::INFINITY, 0, 0.0);
        let mut most = 0.0_f64;
        self.largest = 0.0;
        for _ in 0..UPDATES {
            distance += self.balance(problem, state)?;
            if let Some((_, _, message)) = problem.fault(true) {
                return Err(NotFound::Fault(message));
            }
            let equations = problem.worst_residual(state).map_or(0.0, |worst| worst.violation);
            problem.find_contacts(state);
            let gaps = problem.contact().found().iter().map(|contact| contact.gap.abs() / contact.radius);
            let violation = gaps.fold(equations, nan_max);
            misses = if violation <= PROGRESS * last { 0 } else { misses + 1 };
            last = violation.min(last);
            most = most.max(violation);
            if violation <= SATISFIED || misses >= MISSES && violation <= ACCURACY * most {
                problem.gradient(state, &mut self.free);
                if self.keep_contacts(problem, state) {
                    return Err(NotFound::OtherContacts);
                }
                return Ok(distance);
            }
            if misses >= 2 * MISSES {
                break;
            }
            // Penalties, and what crosses, are part of the kept factor.
            multipliers::update_constraints(problem, state, f64::INFINITY, &mut Vec::new());
            multipliers::update_contacts(problem, state, &mut history);
        }
        problem.gradient(state, &mut self.free);
        Err(if self.keep_contacts(problem, state) { NotFound::OtherContacts } else { NotFound::Violated(last) })
    }

    /// Makes the whole gradient at `state` that of the contacts of the reference: they pull where they have opened, and
    /// others do not push. The kept factor is that of these contacts; a small motion of a body opens those with a small
    /// force, and would leave it without them. Returns whether there are such contacts.
    fn keep_contacts(&mut self, problem: &Problem<'_>, state: &State) -> bool {
        let Some(touching) = &self.touching else { return false };
        let contact = problem.contact();
        let opened = contact.approaching().iter().filter(|c| touching.contains(&(c.point, c.partner)));
        let others = contact.found().iter().filter(|c| !touching.contains(&(c.point, c.partner)));
        let all = opened.map(|contact| (contact, -1.0)).chain(others.map(|contact| (contact, 1.0)));
        self.gradient.clear();
        let mut any = false;
        for (contact, sign) in all {
            any = true;
            for (point, weights) in problem.contact().places(problem.system(), contact) {
                self.gradient.points[point] += contact.normal * (sign * contact.force * weights.u);
            }
        }
        if any {
            problem.network.pull_back(state, &mut self.gradient);
            self.free.add_scaled(1.0, &self.gradient);
        }
        any
    }

    /// Moves `state` to the minimum of `problem` under its multipliers, by steps with the kept factor. Returns the
    /// length of the first step.
    fn balance(&mut self, problem: &mut Problem<'_>, state: &mut State) -> Result<f64, NotFound> {
        let (mut last, mut misses) = (f64::INFINITY, 0);
        // Length of the first step, and of the last one.
        let (mut distance, mut length): (Option<f64>, f64) = (None, f64::INFINITY);
        for _ in 0..STEPS {
            problem.update_held(state);
            let moves = problem.motion(state, &mut self.motion);
            problem.gradient(state, &mut self.free);
            self.keep_contacts(problem, state);
            problem.free_part(&mut self.free);
            // Round-off included: results are subtracted from each other, so steps go on as long as they help.
            let residual = problem.whole_residual(&self.free);
            if !moves {
                misses = if residual <= PROGRESS * last { 0 } else { misses + 1 };
                last = residual.min(last);
                self.largest = self.largest.max(residual);
                let (accuracy, least) =
                    if misses >= MISSES { (LEAST_ACCURACY, LEAST_BALANCED) } else { (ACCURACY, BALANCED) };
                let balanced = || residual <= ACCURACY * self.largest || problem.residual(&self.free) <= least;
                // A soft harness moves far under small forces.
                let rests = || length <= accuracy * distance.unwrap_or(0.0).max(SMALLEST);
                // Where nothing rounds off, steps go on getting shorter.
                let stands = || length <= f64::EPSILON;
                if residual == 0.0 || balanced() && (misses > 0 && rests() || stands()) {
                    return Ok(distance.unwrap_or(0.0));
                }
            }
            if misses >= MISSES || residual.is_nan() {
                return Err(NotFound::Unbalanced(residual));
            }
            let motion = moves.then_some(&self.motion);
            // The free part: its directions may be others than those of the reference.
            let step = self.inspector.step_near(&self.problem, state, &self.free, motion);
            let largest = |all: &[Vector]| all.iter().map(Vector::norm).fold(0.0, nan_max);
            length = nan_max(largest(&step.points) / problem.scales().length, largest(&step.frames));
            if length.is_nan() || length > LONGEST {
                return Err(NotFound::Unbalanced(residual));
            }
            distance.get_or_insert(length);
            self.from.copy_from(state);
            problem.retract(&self.from, step, 1.0, state);
            problem.place_held(state);
        }
        Err(NotFound::Unbalanced(last))
    }
}

/// Whether an equilibrium depends on its history: friction, slip, or a part that remembers.
fn has_history(network: &Network, conditions: &Conditions) -> bool {
    let slides = network.slides.iter().any(|site| site.friction > 0.0 && conditions.active[site.constraint]);
    slides
        || conditions.contact.records.iter().any(|record| record.anchor.is_some())
        || conditions.rods.iter().any(|own| !own.memory.is_empty())
        || conditions.joints.iter().any(|own| !own.memory.is_empty())
        || conditions.constraints.iter().zip(&conditions.active).any(|(own, acts)| *acts && !own.memory.is_empty())
}

/// Contacts with a force in the records of a problem.
fn pressed(problem: &Problem<'_>) -> BTreeSet<(u32, Partner)> {
    let records = problem.conditions().contact.records.iter().filter(|record| record.multiplier > 0.0);
    records.map(|record| (record.point, record.partner)).collect()
}

/// Contacts that a problem found with a force.
fn bearing(problem: &Problem<'_>) -> BTreeSet<(u32, Partner)> {
    let found = problem.contact().found().iter().filter(|contact| contact.force > 0.0);
    found.map(|contact| (contact.point, contact.partner)).collect()
}

/// An equilibrium that was found.
struct Settled<'m> {
    problem: Problem<'m>,
    state: State,
    distance: f64,
}

impl Settled<'_> {
    /// Its results, once the certificate has confirmed it; where `at` says which requirements count
    /// ([`Equilibrium::new`]), also its sheet.
    fn measured(self, stop: &Stop, moment: Moment, at: Option<(Option<usize>, bool)>) -> Result<Nearby, NotFound> {
        let Self { mut problem, state, distance } = self;
        let network = problem.network;
        let mut certifier = Certifier::new(network);
        let certificate = certifier.certify(&mut problem, &state, stop, Status::Stalled);
        if certificate.grade != Status::Converged {
            return Err(NotFound::Unbalanced(certificate.residual));
        }
        let touching = problem.touching_points(&state);
        let branch = |b: usize| branch::result(&problem, b, &state, &touching);
        let branches = (0..network.branches.len()).map(branch).collect();
        let minimiser = MinimiserResult {
            kind: "kept factor".to_owned(),
            device: None,
            iterations: 0,
            polish: 0,
            factorisations: 0,
            seconds: 0.0,
            force_residual: certificate.residual,
            shape_error: None,
            constraint_residual: certificate.constraint.map(|worst| worst.violation),
        };
        let end = step_result::equilibrium(&mut problem, &state, &certifier.gradient, branches, &touching, minimiser);
        let requirements = at.map_or_else(Vec::new, |at| sheet_of(&mut problem, &state, &end, &moment, at));
        let touching = bearing(&problem);
        Ok(Nearby { end: StepResult { name: moment.step, ..end }, requirements, distance, touching })
    }
}

/// The sheet of an equilibrium.
fn sheet_of(
    problem: &mut Problem<'_>,
    state: &State,
    end: &StepResult,
    moment: &Moment,
    at: (Option<usize>, bool),
) -> Vec<RequirementResult> {
    let network = problem.network;
    let errors =
        discretisation::estimate(problem, state, &discretisation::Samples::of(problem, state, &end.branches), None);
    let cables = Cables::new(network, &end.branches);
    let spans = Spans::new(problem, state);
    let results = (&end.branches[..], &end.constraints[..], &[][..]);
    let equilibrium = Equilibrium::new(problem, (state, state), results, (&cables, &spans), (&errors, None), at);
    // Which place is the worst must not depend on estimates of its error.
    let certain = |found: Vec<Found>| found.into_iter().map(|found| Found { error: None, ..found }).collect();
    let found = network.requirements.iter().map(|requirement| certain(equilibrium.values(requirement))).collect();
    let mut sheet = Sheet::default();
    sheet.add(&network.requirements, found, moment, Here::End);
    sheet.lines(network, Status::Converged)
}

/// Times that what has crept depends on, s: of steps, and of elements of creep.
fn times(network: &Network, schedule: &Schedule) -> Vec<f64> {
    let laws = network.branches.iter().flat_map(|branch| branch.sections.iter()).map(|section| &section.laws.creep);
    let elements = laws.flat_map(|creep| creep.bending.iter().chain(&creep.torsion)).map(|element| element.time);
    steps_of(schedule).iter().map(|step| step.duration).chain(elements).collect()
}

/// Conditions that a run reached, with the targets, loads and poses of others.
fn merged(reached: &Conditions, walked: &Conditions) -> Conditions {
    let mut constraints = reached.constraints.clone();
    for (own, walked) in constraints.iter_mut().zip(&walked.constraints) {
        (own.base, own.progress) = (walked.base, walked.progress);
        own.beside.clone_from(&walked.beside);
    }
    Conditions {
        gravity: walked.gravity,
        rotation: walked.rotation,
        load_factors: walked.load_factors.clone(),
        temperatures: walked.temperatures.clone(),
        mechanisms: walked.mechanisms.clone(),
        targets: walked.targets.clone(),
        constraints,
        contact: ContactState { poses: walked.contact.poses.clone(), ..reached.contact.clone() },
        ..reached.clone()
    }
}

/// How much longer segments are than others, m.
fn longer(these: &[f64], others: &[f64]) -> Vec<f64> {
    these.iter().zip(others).map(|(this, other)| this - other).collect()
}

/// A state of the reference on a network with the same nodes, whose segments are longer by `change`.
fn carried(state: &State, change: &[f64], to: &Network) -> State {
    let mut moved = state.clone();
    moved.rest_lengths.iter_mut().zip(change).for_each(|(length, change)| *length += change);
    for branch in &to.branches {
        let lengths = &moved.rest_lengths[branch.points.start..branch.points.end - 1];
        branch.rod.mesh().couple(lengths, &mut moved.coupling_lengths[branch.frames.start..branch.frames.end - 1]);
    }
    to.follow_ties(&mut moved);
    moved
}

/// Whether the stations and attachments of two networks are at the same nodes.
fn same_places(one: &Network, other: &Network) -> bool {
    let stations =
        |network: &Network| network.branches.iter().map(|b| b.rod.mesh().stations.clone()).collect::<Vec<_>>();
    let places = |network: &Network| network.constraints.iter().map(|c| c.places.clone()).collect::<Vec<_>>();
    let loads = |network: &Network| {
        let place = |load: &Load| match &load.action {
            LoadAction::At { place, .. } => (Some(*place), Vec::new()),
            LoadAction::Along { spans, .. } => (None, spans.clone()),
        };
        network.loads.iter().map(place).collect::<Vec<_>>()
    };
    stations(one) == stations(other) && places(one) == places(other) && loads(one) == loads(other)
}

/// Whether the state at the beginning of a step decides on what follows in it: a constraint begins without a target of
/// its own, at several places, or on a mesh that moves.
fn takes_where_it_is(network: &Network, step: &Step) -> bool {
    step.add.iter().any(|&f| {
        let constraint = &network.constraints[f];
        let own = step.moves.iter().find(|m| m.carried.iter().any(|carried| carried.constraint == f));
        let given = match own {
            Some(own) => {
                let alone = own.carried.len() == 1 && own.origin == (None, None) && own.track.spin == 0.0;
                let turned = match own.track.turns.last() {
                    Some((_, turn)) => fixes_turn(constraint, matches!(turn, Turn::Tangent(_))),
                    None => !turns(constraint),
                };
                alone && !own.track.positions.is_empty() && turned && constraint.stations.len() <= 1
            }
            None => has_own_target(network, f),
        };
        let on_moving_mesh = constraint.places.iter().any(|place| match *place {
            Place::Node { branch, .. } => network.branches[branch].mesh_moves,
            Place::Joint(_) => false,
        });
        !given || on_moving_mesh
    })
}

/// Whether the whole target of a constraint is given.
fn has_own_target(network: &Network, f: usize) -> bool {
    let constraint = &network.constraints[f];
    let turned = match (constraint.orientation, constraint.tangent) {
        (None, None) => !turns(constraint),
        (orientation, _) => fixes_turn(constraint, orientation.is_none()),
    };
    constraint.position.is_some() && turned && constraint.stations.len() <= 1
}

/// Whether an orientation, or a tangent alone, fixes its target as far as it matters.
fn fixes_turn(constraint: &AttachedConstraint, tangent_alone: bool) -> bool {
    let of_tangent = match constraint.model.action() {
        Action::Prescribed(hold) => matches!(hold.rotation, RotationHold::Free | RotationHold::Tangent),
        _ => false,
    };
    !tangent_alone || of_tangent
}

/// Whether the orientation of its target matters.
fn turns(constraint: &AttachedConstraint) -> bool {
    match constraint.model.action() {
        Action::Prescribed(hold) => hold.rotation != RotationHold::Free,
        _ => true,
    }
}
