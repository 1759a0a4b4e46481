//! A harness that is moved by hand, and the scenario that is recorded meanwhile: `run` of its text passes through the
//! same equilibria.

use super::drag::{Drag, Goal, MAX_MOTION, MAX_ROTATION, quaternion, turning};
use super::error::SessionError;
use super::harness::DrivenHarness;
use std::rc::Rc;
use wireloom_core::equilibrium::{Outcome, Run, StepResult};
use wireloom_core::mechanism::MechanismJoint;
use wireloom_core::requirement::RequirementResult;
use wireloom_core::steps::{ObstacleMove, Step, Track};
use wireloom_core::{Monitor, Pose, Registry, Vector};
use wireloom_scenario::record::{
    Attachment, Begins, BodyMotion, JointMotion, Turned, Written, rotation, with_json, with_steps,
};
use wireloom_scenario::{Fault, Files, plugins};
use wireloom_solve::steps::checkpoint::Checkpoint;
use wireloom_solve::steps::interactive::Ended;

/// Largest number of operations that can be undone.
const MAX_UNDO: usize = 100;
/// Most increments of the motion of a joint; it turns further in each of them then.
const MOST_INCREMENTS: f64 = 1000.0;

/// Help where no equilibrium is found in the steps of the scenario.
const OPENING: &str = "a run of the scenario shows where";
/// Help where none is found in an operation that is carried out as a whole.
const UNCHANGED: &str = "the session is as it was; go in smaller steps, or elsewhere";
/// Help where none is found in a motion.
const ON_THE_WAY: &str = "the harness is in the last equilibrium on the way; move in smaller steps, or elsewhere";

/// A state of the session, between two operations.
#[derive(Clone)]
struct Snapshot {
    /// The scenario with changed values, without what was done by hand.
    text: Rc<str>,
    by_hand: Vec<Rc<Written>>,
    harness: Rc<DrivenHarness>,
    at: Rc<Checkpoint>,
    end: Rc<StepResult>,
    /// The requirements so far.
    sheet: Rc<[RequirementResult]>,
}

impl Snapshot {
    /// The equilibrium after all steps; `help` where there is none.
    fn after_all_steps(
        text: &str,
        by_hand: Vec<Rc<Written>>,
        harness: DrivenHarness,
        help: &str,
    ) -> Result<Self, SessionError> {
        let Ended { checkpoint, end, requirements, .. } = balanced(harness.start()?, help)?;
        let (at, end, sheet) = (Rc::new(checkpoint), Rc::new(end), requirements.into());
        let mut all = Self { text: text.into(), by_hand, harness: Rc::new(harness), at, end, sheet };
        all.carry_out(help)?;
        Ok(all)
    }

    /// The end of an increment becomes the current state, if it is in balance.
    fn take(&mut self, ended: Ended, help: &str) -> Result<(), SessionError> {
        let ended = balanced(ended, help)?;
        (self.at, self.end) = (Rc::new(ended.checkpoint), Rc::new(ended.end));
        self.sheet = ended.requirements.into();
        Ok(())
    }

    /// Carries out what is left of the schedule.
    fn carry_out(&mut self, help: &str) -> Result<(), SessionError> {
        while let Some(step) = self.harness.clone().schedule.steps.get(self.at.done().0) {
            let ended = self.harness.advance(step, &self.at)?;
            self.take(ended, help)?;
        }
        Ok(())
    }
}

/// An end from which another increment may follow.
fn balanced(ended: Ended, help: &str) -> Result<Ended, SessionError> {
    if ended.is_balanced() {
        return Ok(ended);
    }
    Err(SessionError::request(format!("no equilibrium was found: {}", ended.end.status.word()), help))
}

/// The wanted name, with a number if it is taken.
pub fn unused_name<'n>(wanted: &str, taken: impl Iterator<Item = &'n str>) -> String {
    let taken: Vec<&str> = taken.collect();
    let numbered = (2..).map(|k| format!("{wanted} {k}"));
    std::iter::once(wanted.to_owned()).chain(numbered).find(|name| !taken.contains(&name.as_str())).unwrap_or_default()
}

/// A motion, and the state before it.
#[derive(Clone)]
struct Moving {
    drag: Drag,
    before: Snapshot,
}

/// What a failure restores.
struct Saved {
    now: Snapshot,
    undo: Vec<Snapshot>,
    moving: Option<Moving>,
}

/// A harness that is moved by hand, each time to a new equilibrium, while its scenario is recorded. It begins in the
/// equilibrium after all steps of the scenario. An operation that fails changes nothing, except for
/// [`move_to`](Self::move_to), which leaves the harness in the last equilibrium on its way.
///
/// ```
/// use wireloom::scenario::NoFiles;
/// use wireloom::session::drag::Goal;
/// use wireloom::session::{Monitor, Session};
///
/// let text = std::fs::read_to_string("../../scenarios/mechanisms/door.toml")?;
/// let mut session = Session::open(&text, Box::new(NoFiles), wireloom::registry(), Monitor::default())?;
/// session.drive("hinge", 0.5)?;
/// session.move_to("pillar plug", &Goal { position: Some([0.0, 0.0, 0.02]), orientation: None })?;
/// assert_eq!(session.run().steps[0].mechanisms[0].joints[0].1, [0.5]);
/// session.undo()?;
/// // The scenario, with the step that is left.
/// assert!(session.text()?.contains("name = \"drive hinge\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Session {
    files: Box<dyn Files>,
    registry: Registry,
    monitor: Monitor,
    now: Snapshot,
    undo: Vec<Snapshot>,
    moving: Option<Moving>,
}

impl Session {
    /// Finds the initial equilibrium and carries out the steps of a scenario. `files` are those that it names;
    /// `monitor` stops this, and what the session does later.
    ///
    /// # Errors
    /// If the text has faults, or no equilibrium is found.
    pub fn open(text: &str, files: Box<dyn Files>, registry: Registry, monitor: Monitor) -> Result<Self, SessionError> {
        let harness = with_own_mesh(text, &*files, &registry, &monitor)?;
        let now = Snapshot::after_all_steps(text, Vec::new(), harness, OPENING)?;
        Ok(Self { files, registry, monitor, now, undo: Vec::new(), moving: None })
    }

    /// The current equilibrium, as a run of one step with the events and requirements so far.
    pub fn run(&self) -> Run {
        let Snapshot { harness, at, end, sheet, .. } = &self.now;
        Run {
            scenario: harness.schedule.scenario.clone(),
            outcome: Outcome::Graded(end.status),
            notes: at.notes().to_vec(),
            events: at.events().to_vec(),
            steps: vec![(**end).clone()],
            clearances: Vec::new(),
            requirements: sheet.to_vec(),
            plugins: Vec::new(),
            identities: harness.schedule.identities.clone(),
            drawn_start: None,
            sensitivities: Vec::new(),
        }
    }

    /// The current equilibrium.
    pub fn end(&self) -> &StepResult {
        &self.now.end
    }

    /// The scenario, with what was done by hand.
    ///
    /// # Errors
    /// If the text is not TOML, which cannot happen.
    pub fn text(&self) -> Result<String, SessionError> {
        let moved = self.moving.as_ref().and_then(|moving| moving.drag.written()).map(Rc::new);
        whole_text(&self.now.text, self.now.by_hand.iter().cloned().chain(moved))
    }

    /// Names of the constraints that can be moved, and whether they can be turned.
    pub fn movable(&self) -> Vec<(&str, bool)> {
        let Snapshot { harness, at, .. } = &self.now;
        let active = harness.network.constraints.iter().enumerate().filter(|(f, _)| at.acts(*f));
        let own = active.filter(|(_, own)| !own.stations.is_empty());
        own.map(|(_, own)| (own.name.as_str(), turning(own).is_some())).collect()
    }

    /// Pose to which a constraint holds the cable.
    ///
    /// # Errors
    /// If there is no such constraint.
    pub fn target(&self, name: &str) -> Result<Pose, SessionError> {
        let index = self.now.harness.active_constraint(name, &self.now.at)?;
        Ok(self.now.at.target(index).unwrap_or_else(Pose::identity))
    }

    /// Moves a constraint to a pose, in as many increments as the way needs. Motions of one constraint that follow each
    /// other are one step of the scenario, and are undone together. One that fails on its way stays in the last
    /// equilibrium there.
    ///
    /// # Errors
    /// If there is no such constraint, the target is none of it, or no equilibrium is found.
    pub fn move_to(&mut self, name: &str, goal: &Goal) -> Result<(), SessionError> {
        let Snapshot { harness, at, .. } = &self.now;
        if let Some(moving) = self.moving.as_ref().filter(|moving| moving.drag.name() == name) {
            moving.drag.check(goal, harness, at)?;
            return self.move_on(goal);
        }
        let drag = Drag::of(self.step_name(&format!("drag {name}")), name, harness, at)?;
        drag.check(goal, harness, at)?;
        let saved = self.saved();
        self.end_motion();
        self.moving = Some(Moving { drag, before: self.now.clone() });
        self.move_on(goal).inspect_err(|_| {
            if self.moving.as_ref().is_some_and(|moving| !moving.drag.has_begun()) {
                self.restore(saved);
            }
        })
    }

    /// Moves the constraint of a motion.
    fn move_on(&mut self, goal: &Goal) -> Result<(), SessionError> {
        let Some(Moving { drag, .. }) = &mut self.moving else { return Ok(()) };
        loop {
            let (ended, reached) = drag.advance(goal, &self.now.harness, &self.now.at)?;
            self.now.take(ended, ON_THE_WAY)?;
            if reached {
                return Ok(());
            }
        }
    }

    /// Ends the step of a motion.
    fn end_motion(&mut self) {
        let Some(Moving { drag, before }) = self.moving.take() else { return };
        let now = &mut self.now;
        let mut end = (*now.end).clone();
        let (at, sheet) = now.harness.end_step((*now.at).clone(), &mut end);
        (now.at, now.end, now.sheet) = (Rc::new(at), Rc::new(end), sheet.into());
        now.by_hand.extend(drag.written().map(Rc::new));
        self.keep(before);
    }

    fn saved(&self) -> Saved {
        Saved { now: self.now.clone(), undo: self.undo.clone(), moving: self.moving.clone() }
    }

    fn restore(&mut self, saved: Saved) {
        (self.now, self.undo, self.moving) = (saved.now, saved.undo, saved.moving);
    }

    /// Ends a motion and does something else; if that fails, the motion has not ended either.
    fn after_motion(&mut self, work: impl FnOnce(&mut Self) -> Result<(), SessionError>) -> Result<(), SessionError> {
        let saved = self.moving.is_some().then(|| self.saved());
        self.end_motion();
        work(self).inspect_err(|_| {
            if let Some(saved) = saved {
                self.restore(saved);
            }
        })
    }

    /// Goes on from another state.
    fn switch_to(&mut self, next: Snapshot) {
        let before = std::mem::replace(&mut self.now, next);
        self.keep(before);
    }

    /// Keeps a state for undo.
    fn keep(&mut self, before: Snapshot) {
        self.undo.push(before);
        if self.undo.len() > MAX_UNDO {
            self.undo.remove(0);
        }
    }

    /// An unused name for a step.
    fn step_name(&self, wanted: &str) -> String {
        let Snapshot { harness, by_hand, .. } = &self.now;
        let own = harness.schedule.steps.iter().map(|step| step.name.as_str());
        let by_hand = by_hand.iter().map(|step| step.name.as_str());
        unused_name(wanted, own.chain(by_hand).chain(self.moving.as_ref().map(|moving| moving.drag.step.as_str())))
    }

    /// Takes hold of the cable where it is, at the node nearest to an arc length, with a new handle of this name.
    ///
    /// # Errors
    /// If there is no such place, the name is taken, or no equilibrium is found.
    pub fn hold(&mut self, branch: &str, s: f64, name: &str) -> Result<(), SessionError> {
        self.after_motion(|session| {
            let at = attachment(session.end(), branch, s)?;
            let begins = vec![Begins { name: name.to_owned(), kind: None, at }];
            let step = session.step_name(&format!("hold {name}"));
            session.apply(Written { name: step, begins, ..Written::default() })
        })
    }

    /// Releases a constraint.
    ///
    /// # Errors
    /// If there is no such constraint, or no equilibrium is found.
    pub fn release(&mut self, name: &str) -> Result<(), SessionError> {
        self.after_motion(|session| {
            session.now.harness.active_constraint(name, &session.now.at)?;
            let step = session.step_name(&format!("release {name}"));
            session.apply(Written { name: step, release: vec![name.to_owned()], ..Written::default() })
        })
    }

    /// Drives a joint of a mechanism, `MECHANISM/JOINT` or `JOINT`, to a value, rad or m.
    ///
    /// # Errors
    /// If there is no such joint, it does not get there, or no equilibrium is found.
    pub fn drive(&mut self, joint: &str, to: f64) -> Result<(), SessionError> {
        self.after_motion(|session| {
            let drive = Some(joint_motion(&session.now.harness, session.end(), joint, to)?);
            let name = session.step_name(&format!("drive {joint}"));
            session.apply(Written { name, drive, ..Written::default() })
        })
    }

    /// Appends a step and carries it out, if the scenario stays valid and there is an equilibrium.
    fn apply(&mut self, written: Written) -> Result<(), SessionError> {
        let mut next = self.now.clone();
        next.by_hand.push(Rc::new(written));
        let text = whole_text(&next.text, next.by_hand.iter().cloned())?;
        let refused = |faults| SessionError::Refused { text: text.clone(), faults };
        let loaded = DrivenHarness::load(&text, &*self.files, &self.registry, &self.monitor).map_err(refused)?;
        let harness = loaded.on_mesh_of(&next.harness.network, &self.registry, &self.monitor).map_err(refused)?;
        match harness.transferred(&next.harness, &next.at) {
            Some(at) => {
                (next.at, next.harness) = (Rc::new(at), Rc::new(harness));
                next.carry_out(UNCHANGED)?;
            }
            // Slow, but right: from the start.
            None => next = Snapshot::after_all_steps(&next.text, next.by_hand, harness, UNCHANGED)?,
        }
        self.switch_to(next);
        Ok(())
    }

    /// Moves an obstacle to a pose, in as many increments as the way needs.
    ///
    /// # Errors
    /// If there is no such obstacle, a mechanism carries it, the target is none, or no equilibrium is found.
    pub fn move_obstacle(&mut self, name: &str, goal: &Goal) -> Result<(), SessionError> {
        self.after_motion(|session| session.carry_obstacle(name, goal))
    }

    fn carry_obstacle(&mut self, name: &str, goal: &Goal) -> Result<(), SessionError> {
        let harness = self.now.harness.clone();
        let bodies = &harness.network.obstacles;
        let known = bodies.iter().map(|body| body.name.as_str());
        let obstacle = known.clone().position(|own| own == name);
        let obstacle =
            obstacle.ok_or_else(|| SessionError::unknown(format!("there is no obstacle \"{name}\""), name, known))?;
        if bodies[obstacle].mount.is_some() {
            let message = format!("a mechanism carries \"{name}\", so it cannot be moved by itself");
            return Err(SessionError::request(message, "drive a joint of the mechanism"));
        }
        let from = self.now.end.obstacles.get(obstacle).map_or(bodies[obstacle].pose, |body| body.pose);
        goal.check(name, &from.position, &harness)?;
        let position = goal.position.unwrap_or_else(|| from.position.into());
        let orientation = goal.orientation.unwrap_or_else(|| quaternion(&from.orientation));
        let turn = Turned::Orientation(orientation).turn();
        let angle = rotation(orientation).map_or(0.0, |to| to.angle_to(&from.orientation));
        let distance = (Vector::from(position) - from.position).norm();
        let increments = (distance / (MAX_MOTION * harness.longest())).max(angle / MAX_ROTATION).ceil().max(1.0);
        let track = Track {
            positions: vec![(1.0, position.into())],
            turns: turn.into_iter().map(|turn| (1.0, turn)).collect(),
            spin: 0.0,
        };
        let increments = increments as usize;
        let step = Step {
            name: self.step_name(&format!("move {name}")),
            increments,
            obstacle_moves: vec![ObstacleMove { obstacle, track }],
            ..Step::default()
        };
        let mut next = self.now.clone();
        for _ in 0..increments {
            let ended = harness.advance(&step, &next.at)?;
            next.take(ended, UNCHANGED)?;
        }
        let body = BodyMotion { obstacle: name.to_owned(), position, orientation, increments };
        next.by_hand.push(Rc::new(Written { name: step.name, body: Some(body), ..Written::default() }));
        self.switch_to(next);
        Ok(())
    }

    /// Sets a value of the scenario, as `wireloom run --set` does, and carries out all its steps again, with those by
    /// hand. The kinds of the session stay, so it cannot load further plugins.
    ///
    /// # Errors
    /// If there is no such key, the scenario has faults with it, or no equilibrium is found.
    pub fn set(&mut self, key: &str, value: &serde_json::Value) -> Result<(), SessionError> {
        self.after_motion(|session| {
            let Snapshot { text, by_hand, .. } = session.now.clone();
            let of_key = |fault| SessionError::Key { text: text.to_string(), fault };
            let changed = with_json(&text, key, value, &session.registry).map_err(of_key)?;
            refuse_further_plugins(&text, &changed)?;
            let whole = whole_text(&changed, by_hand.iter().cloned())?;
            let harness = with_own_mesh(&whole, &*session.files, &session.registry, &session.monitor)?;
            session.switch_to(Snapshot::after_all_steps(&changed, by_hand, harness, UNCHANGED)?);
            Ok(())
        })
    }

    /// Takes the last operation back, up to 100 of them.
    ///
    /// # Errors
    /// If there is none.
    pub fn undo(&mut self) -> Result<(), SessionError> {
        let before = self.moving.take().map(|moving| moving.before).or_else(|| self.undo.pop());
        let none = || SessionError::request("there is nothing to undo", "the session is as it was opened");
        self.now = before.ok_or_else(none)?;
        Ok(())
    }
}

/// The harness of a text, on the mesh that its accuracy asks for.
fn with_own_mesh(
    text: &str,
    files: &dyn Files,
    registry: &Registry,
    monitor: &Monitor,
) -> Result<DrivenHarness, SessionError> {
    let loaded = crate::load_with_files(text, files, registry);
    let meshed = loaded.and_then(|(scenario, built)| crate::mesh::by_accuracy(scenario, built, registry, monitor));
    let (scenario, built) = meshed.map_err(|faults| SessionError::Refused { text: text.to_owned(), faults })?;
    Ok(DrivenHarness::new(scenario, built, monitor))
}

/// Refuses a text that loads plugins which it did not load before.
fn refuse_further_plugins(before: &str, after: &str) -> Result<(), SessionError> {
    let known = plugins(before).load;
    let further = |name: &str| known.iter().all(|(own, _)| own != name);
    let Some((name, span)) = plugins(after).load.into_iter().find(|(name, _)| further(name)) else { return Ok(()) };
    let message = format!("a session loads no further plugins, so \"{name}\" is not loaded");
    let help = "open another session, of a scenario that loads it".to_owned();
    Err(SessionError::Refused { text: after.to_owned(), faults: vec![Fault { span, message, help }] })
}

/// The text with all its steps, followed by those by hand.
fn whole_text(text: &str, by_hand: impl Iterator<Item = Rc<Written>>) -> Result<String, SessionError> {
    let further: Vec<Written> = by_hand.map(|step| (*step).clone()).collect();
    with_steps(text, usize::MAX, &further)
        .map_err(|fault| SessionError::Refused { text: text.to_owned(), faults: vec![fault] })
}

/// The place of the node of a branch that is nearest to an arc length, m.
///
/// # Errors
/// If there is no such branch, or it has no such arc length.
pub fn attachment(end: &StepResult, branch: &str, s: f64) -> Result<Attachment, SessionError> {
    let known = end.branches.iter().map(|line| line.name.as_str());
    let line = end.branches.iter().find(|line| line.name == branch);
    let line = line.ok_or_else(|| SessionError::unknown(format!("there is no branch \"{branch}\""), branch, known))?;
    let length = line.s.last().copied().unwrap_or(0.0);
    if !(0.0..=length).contains(&s) {
        let message = format!("s = {s} m is outside branch \"{branch}\"");
        return Err(SessionError::value(message, format!("give an arc length from 0 to {length} m")));
    }
    let nearest = line.s.iter().copied().min_by(|a, b| (a - s).abs().total_cmp(&(b - s).abs())).unwrap_or(0.0);
    // Enough digits for a place, and easier to read in the text.
    Ok(Attachment::Branch(branch.to_owned(), (nearest * 1e12).round() / 1e12))
}

/// The motion of a joint from where it is to a value, rad or m, in as many increments as the way needs.
///
/// # Errors
/// If there is no such joint with one freedom.
pub fn joint_motion(
    harness: &DrivenHarness,
    end: &StepResult,
    joint: &str,
    to: f64,
) -> Result<JointMotion, SessionError> {
    let mechanisms = harness.network.mechanisms.iter().zip(&end.mechanisms);
    let joints = mechanisms.flat_map(|(own, now)| own.joints.iter().zip(&now.joints).map(|joint| (&own.name, joint)));
    let with_one = joints.filter_map(|(mechanism, (own, (_, values)))| {
        let [now] = values[..] else { return None };
        Some((format!("{mechanism}/{}", own.name), own, now))
    });
    let all: Vec<(String, &MechanismJoint, f64)> = with_one.collect();
    let meant: Vec<_> = all.iter().filter(|(whole, own, _)| *whole == joint || own.name == joint).collect();
    let [(whole, own, now)] = meant[..] else {
        if meant.is_empty() {
            let known = all.iter().map(|(whole, ..)| whole.as_str());
            return Err(SessionError::unknown(format!("there is no joint \"{joint}\""), joint, known));
        }
        let message = format!("several mechanisms have a joint \"{joint}\"");
        return Err(SessionError::request(message, format!("write \"{}\", for example", meant[0].0)));
    };
    if !to.is_finite() {
        return Err(SessionError::value(format!("{to} is not a value of a joint"), "give a number in rad or m"));
    }
    let reach = if own.kind.is_length(0) { MAX_MOTION * harness.longest() } else { MAX_ROTATION };
    let increments = ((to - now).abs() / reach).ceil().clamp(1.0, MOST_INCREMENTS) as usize;
    Ok(JointMotion { joint: whole.clone(), to, increments })
}
