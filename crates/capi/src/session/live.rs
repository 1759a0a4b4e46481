//! A harness that is moved by hand, and the scenario that is recorded meanwhile: `run` of its text passes through the
//! same equilibria.

use super::harness::Harness;
use crate::failure::Failure;
use crate::scenario::Source;
use std::rc::Rc;
use wireloom::geometry::{Pose, Vector, columns};
use wireloom::harness::{ObstacleMove, Step, Track};
use wireloom::result::{Outcome, RequirementResult};
use wireloom::scenario::fault::did_you_mean;
use wireloom::scenario::record::{Attachment, Begins, BodyMotion, Passed, Turned, Way, Written, rotation, with_steps};
use wireloom::session::drag::{
    Goal, MAX_DISTANCE, MAX_MOTION, MAX_ROTATION, Turning, approach, quaternion, step_to, turning,
};
use wireloom::session::{Checkpoint, Ended, Monitor};
use wireloom::{Registry, Run, StepResult};

/// Largest number of operations that can be undone, as in the studio.
const MAX_UNDO: usize = 100;

/// A state of the session, between two operations.
#[derive(Clone)]
struct Snapshot {
    /// The scenario with changed values, without what was done by hand.
    text: Rc<str>,
    by_hand: Vec<Rc<Written>>,
    harness: Rc<Harness>,
    at: Rc<Checkpoint>,
    end: Rc<StepResult>,
    /// The requirements so far.
    sheet: Rc<[RequirementResult]>,
}

impl Snapshot {
    /// The initial equilibrium.
    fn start(text: &str, by_hand: Vec<Rc<Written>>, harness: Rc<Harness>) -> Result<Self, Failure> {
        let Ended { checkpoint, end, requirements, .. } = harness.start()?;
        let (at, end, sheet) = (Rc::new(checkpoint), Rc::new(end), requirements.into());
        Ok(Self { text: text.into(), by_hand, harness, at, end, sheet })
    }

    /// The end of an increment becomes the current state.
    fn take(&mut self, ended: Ended) {
        (self.at, self.end) = (Rc::new(ended.checkpoint), Rc::new(ended.end));
        self.sheet = ended.requirements.into();
    }

    /// Carries out what is left of the schedule.
    fn carry_out(&mut self) -> Result<(), Failure> {
        while let Some(step) = self.harness.clone().schedule.steps.get(self.at.done().0) {
            let ended = self.harness.advance(step, &self.at)?;
            self.take(ended);
        }
        Ok(())
    }
}

/// A motion by hand: one step, whose increments follow the targets.
#[derive(Clone)]
struct Drag {
    name: String,
    constraint: usize,
    turning: Option<Turning>,
    /// Whether it has turned so far.
    turned: bool,
    /// Poses that it has passed: as recorded, and as reached.
    passed: Vec<(Passed, Pose)>,
    before: Snapshot,
}

impl Drag {
    /// The step as the scenario has it.
    fn written(&self, constraint: &str) -> Written {
        let place = |(passed, stood): &(Passed, Pose)| {
            let turn = || match self.turning? {
                Turning::Frame => Some(Turned::Orientation(quaternion(&stood.orientation))),
                Turning::Tangent => Some(Turned::Tangent(columns(&stood.orientation)[2].into())),
            };
            Passed { turn: if self.turned { passed.turn.or_else(turn) } else { None }, ..*passed }
        };
        let way = Way { constraint: constraint.to_owned(), places: self.passed.iter().map(place).collect() };
        Written { name: self.name.clone(), way: Some(way), ..Written::default() }
    }
}

/// What a failure restores.
struct Saved {
    now: Snapshot,
    undo: Vec<Snapshot>,
    drag: Option<Drag>,
}

/// The harness of a session.
pub struct Live {
    source: Source,
    registry: Registry,
    monitor: Monitor,
    now: Snapshot,
    undo: Vec<Snapshot>,
    drag: Option<Drag>,
}

impl Live {
    /// Finds the initial equilibrium and carries out the steps of the scenario.
    pub fn open(source: Source, monitor: Monitor) -> Result<Self, Failure> {
        let registry = wireloom::registry();
        let (_, built) = source.load_with_mesh(&registry, &monitor)?;
        let harness = Rc::new(Harness::new(built, &monitor));
        let mut now = Snapshot::start(&source.text, Vec::new(), harness)?;
        now.carry_out()?;
        Ok(Self { source, registry, monitor, now, undo: Vec::new(), drag: None })
    }

    /// The current equilibrium.
    pub fn state(&self) -> Run {
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
        }
    }

    /// The scenario, with what was done by hand.
    pub fn text(&self) -> Result<String, Failure> {
        let drag = self.drag.as_ref().map(|drag| Rc::new(self.written(drag)));
        whole_text(&self.now.text, self.now.by_hand.iter().cloned().chain(drag))
    }

    fn written(&self, drag: &Drag) -> Written {
        drag.written(&self.now.harness.network.constraints[drag.constraint].name)
    }

    /// An unused name for a step.
    fn step_name(&self, wanted: &str) -> String {
        let own = self.now.harness.schedule.steps.iter().map(|step| &step.name);
        let taken: Vec<&String> = own.chain(self.now.by_hand.iter().map(|step| &step.name)).collect();
        let numbered = (2..).map(|k| format!("{wanted} {k}"));
        std::iter::once(wanted.to_owned()).chain(numbered).find(|name| !taken.contains(&name)).unwrap_or_default()
    }

    /// Index of an active constraint.
    fn constraint(&self, name: &str) -> Result<usize, Failure> {
        let Snapshot { harness, at, .. } = &self.now;
        let constraints = &harness.network.constraints;
        let active = || (0..constraints.len()).filter(|f| at.acts(*f));
        active().find(|f| constraints[*f].name == name).ok_or_else(|| {
            let names: Vec<&str> = active().map(|f| constraints[f].name.as_str()).collect();
            Failure::not_found(format!("no constraint \"{name}\" acts"), did_you_mean(name, names))
        })
    }

    /// Refuses a target that is too far away.
    fn check_distance(&self, name: &str, from: &Vector, to: &[f64; 3]) -> Result<(), Failure> {
        let far = MAX_DISTANCE * self.now.harness.lengths().1;
        if (Vector::from(*to) - from).norm() <= far {
            return Ok(());
        }
        let message = format!("{to:?} is not a valid position for \"{name}\"");
        Err(Failure::value(message, format!("give a position within {far:.1} m of where it is")))
    }

    /// Moves a constraint to a pose, in as many increments as the way needs.
    pub fn move_to(&mut self, name: &str, goal: &Goal) -> Result<(), Failure> {
        let index = self.constraint(name)?;
        let harness = self.now.harness.clone();
        let constraint = &harness.network.constraints[index];
        let how = turning(constraint);
        if constraint.stations.is_empty() {
            let message = format!("\"{name}\" acts along a part of a branch and cannot be moved");
            return Err(Failure::request(message, "move another constraint"));
        }
        check_some(name, goal)?;
        if goal.orientation.is_some() && how.is_none() {
            let message = format!("\"{name}\" does not hold the orientation of the cable, so it cannot be turned");
            return Err(Failure::request(message, "give a position only"));
        }
        check_orientation(goal.orientation)?;
        if let Some(to) = &goal.position {
            let stands = self.now.at.target(index).unwrap_or_else(Pose::identity);
            self.check_distance(name, &stands.position, to)?;
        }
        let target = |at: &Checkpoint| at.drawn_target(&harness.network, index).unwrap_or_else(Pose::identity);
        let goal = &goal.on(&self.now.at.body_under(&harness.network, index));
        let other = self.drag.as_ref().is_some_and(|drag| drag.constraint != index);
        let before = other.then(|| self.saved());
        if other {
            self.end_motion();
        }
        let step_name =
            self.drag.as_ref().map_or_else(|| self.step_name(&format!("drag {name}")), |drag| drag.name.clone());
        loop {
            let from = target(&self.now.at);
            let (passed, reached) = approach(&from, goal, how, MAX_MOTION * harness.lengths().0);
            let ended = match harness.advance_open(&step_to(&step_name, index, &passed), &self.now.at) {
                Ok(ended) => ended,
                Err(failure) => {
                    if let Some(before) = before.filter(|_| self.drag.is_none()) {
                        self.restore(before);
                    }
                    return Err(failure);
                }
            };
            let drag = self.drag.get_or_insert_with(|| Drag {
                name: step_name.clone(),
                constraint: index,
                turning: how,
                turned: false,
                passed: Vec::new(),
                before: self.now.clone(),
            });
            drag.turned |= passed.turn.is_some();
            drag.passed.push((passed, target(&ended.checkpoint)));
            self.now.take(ended);
            if reached {
                return Ok(());
            }
        }
    }

    /// Ends the step of a motion.
    fn end_motion(&mut self) {
        let Some(drag) = self.drag.take() else { return };
        let written = self.written(&drag);
        let now = &mut self.now;
        let mut end = (*now.end).clone();
        let (at, sheet) = now.harness.driver.borrow_mut().end_step(&now.harness.network, (*now.at).clone(), &mut end);
        (now.at, now.end, now.sheet) = (Rc::new(at), Rc::new(end), sheet.into());
        now.by_hand.push(Rc::new(written));
        self.keep(drag.before);
    }

    /// The session as it is.
    fn saved(&self) -> Saved {
        Saved { now: self.now.clone(), undo: self.undo.clone(), drag: self.drag.clone() }
    }

    /// The session as it was.
    fn restore(&mut self, saved: Saved) {
        (self.now, self.undo, self.drag) = (saved.now, saved.undo, saved.drag);
    }

    /// Ends a motion and does something else, or, if that fails, neither.
    fn after_motion(&mut self, work: impl FnOnce(&mut Self) -> Result<(), Failure>) -> Result<(), Failure> {
        let before = self.drag.is_some().then(|| self.saved());
        self.end_motion();
        work(self).inspect_err(|_| {
            if let Some(before) = before {
                self.restore(before);
            }
        })
    }

    /// Keeps a state for undo.
    fn keep(&mut self, before: Snapshot) {
        self.undo.push(before);
        if self.undo.len() > MAX_UNDO {
            self.undo.remove(0);
        }
    }

    /// Takes hold of the cable where it is, at the node nearest to an arc length, with a new handle of this name.
    pub fn hold(&mut self, branch: &str, s: f64, name: &str) -> Result<(), Failure> {
        self.after_motion(|live| live.hold_at(branch, s, name))
    }

    fn hold_at(&mut self, branch: &str, s: f64, name: &str) -> Result<(), Failure> {
        let branches = &self.now.end.branches;
        let line = branches.iter().find(|line| line.name == branch).ok_or_else(|| {
            let names: Vec<&str> = branches.iter().map(|line| line.name.as_str()).collect();
            Failure::not_found(format!("there is no branch \"{branch}\""), did_you_mean(branch, names))
        })?;
        let length = line.s.last().copied().unwrap_or(0.0);
        if !(0.0..=length).contains(&s) {
            let message = format!("s = {s} m is outside branch \"{branch}\"");
            return Err(Failure::value(message, format!("give an arc length from 0 to {length} m")));
        }
        let nearest = line.s.iter().copied().min_by(|a, b| (a - s).abs().total_cmp(&(b - s).abs())).unwrap_or(0.0);
        // Enough digits for a place, and easier to read in the text.
        let at = Attachment::Branch(branch.to_owned(), (nearest * 1e12).round() / 1e12);
        let begins = vec![Begins { name: name.to_owned(), kind: None, at }];
        let step = self.step_name(&format!("hold {name}"));
        self.apply(Written { name: step, begins, ..Written::default() })
    }

    /// Releases a constraint.
    pub fn release(&mut self, name: &str) -> Result<(), Failure> {
        self.after_motion(|live| live.release_now(name))
    }

    fn release_now(&mut self, name: &str) -> Result<(), Failure> {
        self.constraint(name)?;
        let step = self.step_name(&format!("release {name}"));
        self.apply(Written { name: step, release: vec![name.to_owned()], ..Written::default() })
    }

    /// Appends a step and carries it out, if the scenario stays valid and there is an equilibrium.
    fn apply(&mut self, written: Written) -> Result<(), Failure> {
        let mut next = self.now.clone();
        next.by_hand.push(Rc::new(written));
        let text = whole_text(&next.text, next.by_hand.iter().cloned())?;
        let source = Source { text, files: self.source.files.clone() };
        let loaded = source.load(&self.registry).map_err(|faults| Failure::refused(&source.text, &faults))?;
        let built = next.harness.with_own_mesh(loaded, &self.registry, &source.text)?;
        let harness = Rc::new(Harness::new(built, &self.monitor));
        match harness.transferred(&next.harness, &next.at, &next.end) {
            Some(at) => (next.at, next.harness) = (Rc::new(at), harness),
            // Slow, but right: from the start.
            None => next = Snapshot::start(&next.text, next.by_hand, harness)?,
        }
        next.carry_out()?;
        let before = std::mem::replace(&mut self.now, next);
        self.keep(before);
        Ok(())
    }

    /// Moves a body of the surroundings to a pose, in as many increments as the way needs.
    pub fn move_body(&mut self, name: &str, goal: &Goal) -> Result<(), Failure> {
        self.after_motion(|live| live.carry_body(name, goal))
    }

    fn carry_body(&mut self, name: &str, goal: &Goal) -> Result<(), Failure> {
        let harness = self.now.harness.clone();
        let bodies = &harness.network.obstacles;
        let index = bodies.iter().position(|body| body.name == name).ok_or_else(|| {
            let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
            Failure::not_found(format!("there is no body \"{name}\""), did_you_mean(name, names))
        })?;
        if bodies[index].mount.is_some() {
            let message = format!("a mechanism carries \"{name}\", so it cannot be moved by itself");
            return Err(Failure::request(message, "move another body"));
        }
        check_some(name, goal)?;
        let from = self.now.end.obstacles.get(index).map_or(bodies[index].pose, |body| body.pose);
        let position = goal.position.unwrap_or_else(|| from.position.into());
        self.check_distance(name, &from.position, &position)?;
        check_orientation(goal.orientation)?;
        let orientation = goal.orientation.unwrap_or_else(|| quaternion(&from.orientation));
        let turn = Turned::Orientation(orientation).turn();
        let angle = rotation(orientation).map_or(0.0, |to| to.angle_to(&from.orientation));
        let distance = (Vector::from(position) - from.position).norm();
        let increments = (distance / (MAX_MOTION * harness.lengths().0)).max(angle / MAX_ROTATION).ceil().max(1.0);
        let track = Track {
            positions: vec![(1.0, position.into())],
            turns: turn.into_iter().map(|turn| (1.0, turn)).collect(),
            spin: 0.0,
        };
        let increments = increments as usize;
        let step = Step {
            name: self.step_name(&format!("move {name}")),
            increments,
            obstacle_moves: vec![ObstacleMove { obstacle: index, track }],
            ..Step::default()
        };
        let mut next = self.now.clone();
        for _ in 0..increments {
            let ended = harness.advance(&step, &next.at)?;
            next.take(ended);
        }
        let body = BodyMotion { obstacle: name.to_owned(), position, orientation, increments };
        next.by_hand.push(Rc::new(Written { name: step.name, body: Some(body), ..Written::default() }));
        let before = std::mem::replace(&mut self.now, next);
        self.keep(before);
        Ok(())
    }

    /// Sets a value of the scenario, and carries out all its steps again, with those by hand.
    pub fn set(&mut self, key: &str, json: &str) -> Result<(), Failure> {
        self.after_motion(|live| live.set_value(key, json))
    }

    fn set_value(&mut self, key: &str, json: &str) -> Result<(), Failure> {
        let Snapshot { text, by_hand, .. } = self.now.clone();
        let changed = Source { text: text.to_string(), files: self.source.files.clone() };
        let text = changed.with_value(key, json, &self.registry)?;
        let whole = whole_text(&text, by_hand.iter().cloned())?;
        let source = Source { text: whole, files: changed.files };
        let (_, built) = source.load_with_mesh(&self.registry, &self.monitor)?;
        let mut next = Snapshot::start(&text, by_hand, Rc::new(Harness::new(built, &self.monitor)))?;
        next.carry_out()?;
        let before = std::mem::replace(&mut self.now, next);
        self.keep(before);
        Ok(())
    }

    /// Takes the last operation back.
    pub fn undo(&mut self) -> Result<(), Failure> {
        let before = self.drag.take().map(|drag| drag.before).or_else(|| self.undo.pop());
        let none = || Failure::request("there is nothing to undo", "the session is as it was opened");
        self.now = before.ok_or_else(none)?;
        Ok(())
    }
}

/// The text with all its steps, followed by those by hand.
fn whole_text(text: &str, by_hand: impl Iterator<Item = Rc<Written>>) -> Result<String, Failure> {
    let further: Vec<Written> = by_hand.map(|step| (*step).clone()).collect();
    with_steps(text, usize::MAX, &further).map_err(|fault| Failure::refused(text, &[fault]))
}

/// Refuses an empty target.
fn check_some(name: &str, goal: &Goal) -> Result<(), Failure> {
    if goal.position.is_some() || goal.orientation.is_some() {
        return Ok(());
    }
    Err(Failure::value(format!("the target of \"{name}\" is empty"), "give a position, an orientation, or both"))
}

/// Refuses a quaternion that is none.
fn check_orientation(orientation: Option<[f64; 4]>) -> Result<(), Failure> {
    let none = |q: &[f64; 4]| rotation(*q).is_none_or(|q| !q.coords.iter().all(|x| x.is_finite()));
    let Some(q) = orientation.filter(none) else { return Ok(()) };
    let help = "give a quaternion [w, x, y, z] that is not zero";
    Err(Failure::value(format!("{q:?} is not an orientation"), help))
}
