//! Reads a `result.json` back as the run that it was written of.

use super::read::{Entries, Number, invalid, known_schema, number, vector};
use serde::Deserialize;
use std::io::{self, Read};
use wireloom_core::equilibrium::{
    BranchResult, Clearance, ClearanceFrom, ConstraintResult, Event, EventPlace, JointResult, Library, MinimiserResult,
    Moment, ObstacleResult, OperationResult, PartFamily, PartFault, Run, SlideMotion, SlideResult, SpanResult,
    StationResult, StepResult, TightestBend,
};
use wireloom_core::rotation::frame_from;
use wireloom_core::{EventKind, Pose, Rotation, Status};

/// The run of a `result.json`. Numbers are those that were written, frames but for the last digits, since what is written of them is d3 and d1;
/// what was not finite is NaN, a bend radius infinite.
///
/// # Errors
/// Those of `input`; `InvalidData`, with the place, where it is no result.
pub fn read_run(input: impl Read) -> io::Result<Run> {
    let document: Document = serde_json::from_reader(io::BufReader::new(input))?;
    known_schema(document.schema)?;
    Ok(Run {
        scenario: document.scenario,
        status: status(&document.status)?,
        notes: document.notes,
        events: document.events.into_iter().map(Occurrence::event).collect::<io::Result<_>>()?,
        steps: document.steps.into_iter().map(Step::result).collect::<io::Result<_>>()?,
        clearances: document.clearance.into_iter().map(Near::clearance).collect::<io::Result<_>>()?,
        fault: document.fault.map(Fault::part).transpose()?,
        plugins: document.plugins,
    })
}

fn status(word: &str) -> io::Result<Status> {
    let found = Status::ALL.into_iter().find(|status| status.word() == word);
    found.ok_or_else(|| invalid(format!("no status is called \"{word}\"")))
}

#[derive(Deserialize)]
struct Document {
    schema: u32,
    scenario: String,
    status: String,
    notes: Vec<String>,
    #[serde(default)]
    plugins: Vec<Library>,
    events: Vec<Occurrence>,
    steps: Vec<Step>,
    #[serde(default)]
    clearance: Vec<Near>,
    fault: Option<Fault>,
}

#[derive(Deserialize)]
struct Near {
    branch: String,
    s: Number,
    position: [Number; 3],
    obstacle: Option<String>,
    other: Option<String>,
    other_s: Option<f64>,
    distance: Number,
    required: Number,
    at: Moment,
}

impl Near {
    fn clearance(self) -> io::Result<Clearance> {
        let from = match (self.obstacle, self.other) {
            (Some(name), None) => ClearanceFrom::Obstacle(name),
            (None, Some(name)) => ClearanceFrom::Branch { name, s: number(self.other_s) },
            _ => return Err(invalid(format!("a clearance of branch \"{}\" is not from one thing", self.branch))),
        };
        Ok(Clearance {
            branch: self.branch,
            from,
            distance: number(self.distance),
            s: number(self.s),
            position: vector(self.position),
            required: self.required,
            moment: self.at,
        })
    }
}

#[derive(Deserialize)]
struct Fault {
    constraint: Option<String>,
    joint: Option<String>,
    minimiser: Option<String>,
    kind: String,
    step: String,
    increment: usize,
    message: String,
}

impl Fault {
    fn part(self) -> io::Result<PartFault> {
        let Self { constraint, joint, minimiser, kind, step, increment, message } = self;
        let (family, name) = match (constraint, joint, minimiser) {
            (Some(name), None, None) => (PartFamily::Constraint, name),
            (None, Some(name), None) => (PartFamily::Joint, name),
            (None, None, Some(name)) => (PartFamily::Minimiser, name),
            _ => return Err(invalid("the fault is not that of one part".to_owned())),
        };
        Ok(PartFault { family, name, kind, step, increment, message })
    }
}

#[derive(Deserialize)]
struct Occurrence {
    kind: String,
    place: EventPlace,
    first: Moment,
    worst: Moment,
    last: Moment,
    increments: usize,
    value: Option<f64>,
    limit: Option<f64>,
    message: String,
}

impl Occurrence {
    fn event(self) -> io::Result<Event> {
        let Self { kind: word, place, first, worst, last, increments, value, limit, message } = self;
        let kind = EventKind::ALL.into_iter().find(|kind| kind.word() == word);
        let kind = kind.ok_or_else(|| invalid(format!("no event is called \"{word}\"")))?;
        Ok(Event { kind, place, first, worst, last, increments, value, limit, message })
    }
}

#[derive(Deserialize)]
struct Step {
    name: String,
    increment: usize,
    increments: usize,
    status: String,
    branches: Entries<Branch>,
    joints: Entries<Stands>,
    constraints: Entries<Constraint>,
    #[serde(default)]
    obstacles: Entries<Obstacle>,
    #[serde(default)]
    sliding: Entries<Slide>,
    #[serde(default)]
    operations: Vec<Operation>,
    energy: super::read::EnergyByEffect,
    min_bend_radius: Option<Tightest>,
    stable: Option<bool>,
    minimiser: Minimiser,
}

impl Step {
    fn result(self) -> io::Result<StepResult> {
        let mut slides = self.sliding.0;
        let constraint = |(name, constraint): (String, Constraint)| {
            let slide =
                slides.iter().position(|(sliding, _)| *sliding == name).map(|k| slides.swap_remove(k).1.result());
            Ok(constraint.result(name, slide.transpose()?))
        };
        let constraints = self.constraints.0.into_iter().map(constraint).collect::<io::Result<_>>()?;
        let branches = self.branches.0.into_iter().map(|(name, branch)| branch.result(name));
        let joint = |(name, joint): (String, Stands)| {
            let Pose { position, orientation } = joint.pose();
            JointResult { name, position, orientation }
        };
        Ok(StepResult {
            name: self.name,
            increment: self.increment,
            increments: self.increments,
            status: status(&self.status)?,
            branches: branches.collect::<io::Result<_>>()?,
            joints: self.joints.0.into_iter().map(joint).collect(),
            constraints,
            obstacles: self.obstacles.0.into_iter().map(|(name, obstacle)| obstacle.result(name)).collect(),
            operations: self.operations.into_iter().map(Operation::result).collect(),
            energy: self.energy.plain(),
            min_bend_radius: self.min_bend_radius.map(|bend| TightestBend {
                branch: bend.branch,
                s: number(bend.s),
                value: number(bend.value),
                limit: bend.limit,
            }),
            stable: self.stable,
            minimiser: self.minimiser.result(),
        })
    }
}

#[derive(Deserialize)]
struct Branch {
    diameter: Number,
    bend_radius_limit: Option<f64>,
    axial_stiffness: Number,
    s: Vec<Number>,
    position: Vec<[Number; 3]>,
    d3: Vec<[Number; 3]>,
    d1: Vec<[Number; 3]>,
    force: Vec<[Number; 3]>,
    moment: Vec<[Number; 3]>,
    bend_radius: Vec<Number>,
    twist_turns: Number,
}

impl Branch {
    fn result(self, name: String) -> io::Result<BranchResult> {
        let n = self.s.len();
        let lengths = [self.position.len(), self.d3.len(), self.d1.len(), self.force.len(), self.moment.len()];
        if lengths.iter().chain([&self.bend_radius.len()]).any(|length| *length != n) {
            return Err(invalid(format!("the lists of branch \"{name}\" differ in length")));
        }
        let vectors = |list: Vec<[Number; 3]>| list.into_iter().map(vector).collect::<Vec<_>>();
        let frames = vectors(self.d3).into_iter().zip(vectors(self.d1));
        Ok(BranchResult {
            name,
            diameter: number(self.diameter),
            bend_radius_limit: self.bend_radius_limit,
            axial_stiffness: number(self.axial_stiffness),
            s: self.s.into_iter().map(number).collect(),
            position: vectors(self.position),
            // Where a failure has left no numbers there is no frame either.
            frame: frames.map(|(d3, d1)| frame_from(&d3, &d1).unwrap_or_else(Rotation::identity)).collect(),
            force: vectors(self.force),
            moment: vectors(self.moment),
            bend_radius: self.bend_radius.into_iter().map(|radius| radius.unwrap_or(f64::INFINITY)).collect(),
            twist_turns: number(self.twist_turns),
        })
    }
}

/// A position and an orientation `[w, x, y, z]`.
#[derive(Deserialize)]
struct Stands {
    position: [Number; 3],
    orientation: [Number; 4],
}

impl Stands {
    fn pose(&self) -> Pose {
        let [w, i, j, k] = self.orientation.map(number);
        Pose { position: vector(self.position), orientation: Rotation::new_unchecked([i, j, k, w].into()) }
    }
}

#[derive(Deserialize)]
struct Obstacle {
    #[serde(flatten)]
    stands: Stands,
    force: [Number; 3],
    moment: [Number; 3],
    contacts: usize,
    depth: Number,
}

impl Obstacle {
    fn result(self, name: String) -> ObstacleResult {
        ObstacleResult {
            name,
            pose: self.stands.pose(),
            force: vector(self.force),
            moment: vector(self.moment),
            contacts: self.contacts,
            depth: number(self.depth),
        }
    }
}

#[derive(Deserialize)]
struct Constraint {
    kind: String,
    #[serde(flatten)]
    stands: Stands,
    force: [Number; 3],
    moment: [Number; 3],
    #[serde(default)]
    stations: Vec<Station>,
    span: Option<Span>,
}

#[derive(Deserialize)]
struct Station {
    position: [Number; 3],
    force: [Number; 3],
    moment: [Number; 3],
}

#[derive(Deserialize)]
struct Span {
    branch: String,
    from: Number,
    to: Number,
    force: [Number; 3],
    largest: [Number; 3],
    largest_at: Number,
}

impl Constraint {
    fn result(self, name: String, slide: Option<SlideResult>) -> ConstraintResult {
        let Pose { position, orientation } = self.stands.pose();
        let station = |station: Station| StationResult {
            position: vector(station.position),
            force: vector(station.force),
            moment: vector(station.moment),
        };
        let span = |span: Span| SpanResult {
            branch: span.branch,
            range: (number(span.from), number(span.to)),
            force: vector(span.force),
            largest: vector(span.largest),
            largest_at: number(span.largest_at),
        };
        ConstraintResult {
            name,
            kind: self.kind,
            position,
            orientation,
            force: vector(self.force),
            moment: vector(self.moment),
            stations: self.stations.into_iter().map(station).collect(),
            span: self.span.map(span),
            slide,
        }
    }
}

#[derive(Deserialize)]
struct Slide {
    branch: String,
    contact_arclength: Number,
    axial_force: Number,
    motion: String,
}

impl Slide {
    fn result(self) -> io::Result<SlideResult> {
        let all = [SlideMotion::Free, SlideMotion::Stick, SlideMotion::Slip, SlideMotion::Stopped];
        let motion = all.into_iter().find(|motion| motion.word() == self.motion);
        let motion = motion.ok_or_else(|| invalid(format!("no cable slides \"{}\"", self.motion)))?;
        let (arc_length, axial_force) = (number(self.contact_arclength), number(self.axial_force));
        Ok(SlideResult { branch: self.branch, arc_length, axial_force, motion })
    }
}

#[derive(Deserialize)]
#[serde(tag = "operation", rename_all = "lowercase")]
enum Operation {
    Grasp { constraint: String, branch: Option<String>, s: Number },
    Carry { constraints: Vec<String>, force: Number },
    Mate { constraint: String, insertion_force: Number, limit: Number },
    Clip { constraint: String, branch: Option<String>, s: Number, reach: Number },
}

impl Operation {
    fn result(self) -> OperationResult {
        match self {
            Self::Grasp { constraint, branch, s } => OperationResult::Grasp { constraint, place: branch.zip(s) },
            Self::Carry { constraints, force } => OperationResult::Carry { constraints, force: number(force) },
            Self::Mate { constraint, insertion_force, limit } => {
                OperationResult::Mate { constraint, insertion_force, limit }
            }
            Self::Clip { constraint, branch, s, reach } => {
                OperationResult::Clip { constraint, place: branch.zip(s), reach: number(reach) }
            }
        }
    }
}

#[derive(Deserialize)]
struct Tightest {
    branch: String,
    s: Number,
    value: Number,
    limit: Option<f64>,
}

#[derive(Deserialize)]
struct Minimiser {
    kind: String,
    device: Option<String>,
    iterations: usize,
    #[serde(default)]
    polish: usize,
    factorisations: usize,
    seconds: Number,
    force_residual: Number,
    shape_error: Option<f64>,
    constraint_residual: Option<f64>,
}

impl Minimiser {
    fn result(self) -> MinimiserResult {
        MinimiserResult {
            kind: self.kind,
            device: self.device,
            iterations: self.iterations,
            polish: self.polish,
            factorisations: self.factorisations,
            seconds: number(self.seconds),
            force_residual: number(self.force_residual),
            shape_error: self.shape_error,
            constraint_residual: self.constraint_residual,
        }
    }
}
