//! `result.json`: the whole run, for programs.
//!
//! Branches, joints and constraints are objects keyed by name, in the order of the scenario. Numbers have
//! all the digits needed to read the same double back. What is not finite (the bend radius of a straight
//! piece; anything after a failure) is `null`.
//!
//! `plugins` names the libraries that brought kinds of their own: name, version, file, and SHA-256 of the file as `hash`. Without any, the key is not there.
//!
//! A branch has its `diameter`, the smallest bend radius allowed (`bend_radius_limit`) and its axial stiffness EA beside what is known of its nodes.
//!
//! `provenance` says what made it: program, files (with their SHA-256), what was set beside them, kinds of rods, joints,
//! constraints and minimiser with all its options, and the seed of a sweep's point. With the same provenance comes the same result.
//!
//! `events` tells what happened on the way, increments that are not kept included. What goes on over increments that
//! follow each other is one event:
//!
//! | key | meaning |
//! | --- | --- |
//! | `kind` | [`EventKind::word`](wireloom_core::EventKind::word) |
//! | `place` | the `fixing`, `obstacle` or `branch` (with `s`, m) it happened to; empty: the harness |
//! | `first`, `worst`, `last` | `step`, `step_index` (from 0) and `increment` (from 1; 0: while the start was found) |
//! | `increments` | in how many increments it was so |
//! | `value`, `limit` | the worst value, and what it should not pass, in SI units; null where there is none |
//! | `message` | a sentence for people, of the worst increment |
//!
//! `clearance` stands there where it was asked for, or required of an obstacle: for every pair of a branch and an `obstacle`, or an `other` branch, the
//! least `distance` from surface to surface over all increments (m; negative where they overlap), at `s` of the branch, whose centre line is at
//! `position` there, and `other_s` of the other; `at` tells the increment; `required` is what was asked for. An obstacle of a step has its `position` and
//! `orientation`, the `force` and the `moment` (about its position) that it exerts on the harness, the number of `contacts`, and the `depth` of the deepest one.
//!
//! A constraint that acts on several stations has `stations`, each with `position`, `force` and `moment`; one that acts along a span has
//! `span`: `branch`, `from`, `to`, all the `force` on it, the `largest` on one node, and `largest_at`, its arc length. `fault` stands
//! there only where a constraint ended the run: `constraint`, `kind`, `step`, `increment` and `message`.

mod provenance;
mod read;
mod whole;

pub use provenance::{Provenance, options};
pub use read::read;
use serde::ser::{Serialize, SerializeMap, Serializer};
use std::io::{self, BufWriter, Write};
pub use whole::read_run;
use wireloom_core::equilibrium::{
    BranchResult, Clearance, ClearanceFrom, ConstraintResult, Energy, Event, JointResult, Library, MinimiserResult,
    Moment, ObstacleResult, OperationResult, PartFamily, PartFault, Run, SpanResult, StationResult, StepResult,
    TightestBend,
};
use wireloom_core::rotation::columns;
use wireloom_core::{Rotation, Vector};

/// Version of the form.
pub const SCHEMA: u32 = 1;

/// Writes `run` as one JSON object and a line feed.
///
/// # Errors
/// Those of `out`.
pub fn write(run: &Run, provenance: &Provenance, out: &mut impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    serde_json::to_writer(&mut out, &Document::of(run, provenance))?;
    out.write_all(b"\n")?;
    out.flush()
}

#[derive(serde::Serialize)]
struct Document<'a> {
    schema: u32,
    scenario: &'a str,
    status: &'static str,
    provenance: &'a Provenance,
    notes: &'a [String],
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    plugins: &'a [Library],
    events: Vec<Occurrence<'a>>,
    steps: Vec<Step<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    clearance: Vec<Near<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fault: Option<Fault<'a>>,
}

/// How near a branch came to an obstacle or another branch.
#[derive(serde::Serialize)]
struct Near<'a> {
    branch: &'a str,
    s: Number,
    position: [Number; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    other: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    other_s: Option<Number>,
    distance: Number,
    required: Option<Number>,
    at: Increment<'a>,
}

impl<'a> Near<'a> {
    fn of(clearance: &'a Clearance) -> Self {
        let (obstacle, other) = match &clearance.from {
            ClearanceFrom::Obstacle(name) => (Some(name.as_str()), None),
            ClearanceFrom::Branch { name, s } => (None, Some((name.as_str(), Number(*s)))),
        };
        let (other, other_s) = other.unzip();
        Self {
            branch: &clearance.branch,
            s: Number(clearance.s),
            position: vector(&clearance.position),
            obstacle,
            other,
            other_s,
            distance: Number(clearance.distance),
            required: clearance.required.map(Number),
            at: Increment::of(&clearance.moment),
        }
    }
}

/// What ended a run before its time.
#[derive(serde::Serialize)]
struct Fault<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    constraint: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    joint: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    minimiser: Option<&'a str>,
    kind: &'a str,
    step: &'a str,
    increment: usize,
    message: &'a str,
}

impl<'a> Fault<'a> {
    fn of(fault: &'a PartFault) -> Self {
        let PartFault { family, name, kind, step, increment, message } = fault;
        let named = |which: PartFamily| (*family == which).then_some(name.as_str());
        let (constraint, joint) = (named(PartFamily::Constraint), named(PartFamily::Joint));
        let minimiser = named(PartFamily::Minimiser);
        Self { constraint, joint, minimiser, kind, step, increment: *increment, message }
    }
}

impl<'a> Document<'a> {
    fn of(run: &'a Run, provenance: &'a Provenance) -> Self {
        Self {
            schema: SCHEMA,
            scenario: &run.scenario,
            status: run.status.word(),
            provenance,
            notes: &run.notes,
            plugins: &run.plugins,
            events: run.events.iter().map(Occurrence::of).collect(),
            steps: run.steps.iter().map(Step::of).collect(),
            clearance: run.clearances.iter().map(Near::of).collect(),
            fault: run.fault.as_ref().map(Fault::of),
        }
    }
}

/// An event; `first`, `worst` and `last` are increments.
#[derive(serde::Serialize)]
struct Occurrence<'a> {
    kind: &'static str,
    place: Place<'a>,
    first: Increment<'a>,
    worst: Increment<'a>,
    last: Increment<'a>,
    increments: usize,
    value: Option<Number>,
    limit: Option<Number>,
    message: &'a str,
}

impl<'a> Occurrence<'a> {
    fn of(event: &'a Event) -> Self {
        Self {
            kind: event.kind.word(),
            place: Place {
                fixing: event.place.fixing.as_deref(),
                obstacle: event.place.obstacle.as_deref(),
                branch: event.place.branch.as_deref(),
                s: event.place.s.map(Number),
            },
            first: Increment::of(&event.first),
            worst: Increment::of(&event.worst),
            last: Increment::of(&event.last),
            increments: event.increments,
            value: event.value.map(Number),
            limit: event.limit.map(Number),
            message: &event.message,
        }
    }
}

/// What an event happened to: the keys that apply; none: the harness.
#[derive(serde::Serialize)]
struct Place<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    fixing: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    branch: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    s: Option<Number>,
}

#[derive(serde::Serialize)]
struct Increment<'a> {
    step: &'a str,
    step_index: usize,
    increment: usize,
}

impl<'a> Increment<'a> {
    fn of(moment: &'a Moment) -> Self {
        Self { step: &moment.step, step_index: moment.step_index, increment: moment.increment }
    }
}

#[derive(serde::Serialize)]
struct Step<'a> {
    name: &'a str,
    increment: usize,
    increments: usize,
    status: &'static str,
    branches: ByName<'a, BranchResult>,
    joints: ByName<'a, JointResult>,
    constraints: ByName<'a, ConstraintResult>,
    #[serde(skip_serializing_if = "ByName::is_empty")]
    obstacles: ByName<'a, ObstacleResult>,
    #[serde(skip_serializing_if = "Slides::is_empty")]
    sliding: Slides<'a>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    operations: Vec<Operation<'a>>,
    energy: EnergyByEffect,
    min_bend_radius: Option<Tightest<'a>>,
    stable: Option<bool>,
    minimiser: Minimiser<'a>,
}

impl<'a> Step<'a> {
    fn of(step: &'a StepResult) -> Self {
        Self {
            name: &step.name,
            increment: step.increment,
            increments: step.increments,
            status: step.status.word(),
            branches: ByName(&step.branches),
            joints: ByName(&step.joints),
            constraints: ByName(&step.constraints),
            obstacles: ByName(&step.obstacles),
            sliding: Slides(&step.constraints),
            operations: step.operations.iter().map(Operation::of).collect(),
            energy: EnergyByEffect::of(&step.energy),
            min_bend_radius: step.min_bend_radius.as_ref().map(Tightest::of),
            stable: step.stable,
            minimiser: Minimiser::of(&step.minimiser),
        }
    }
}

/// `{ "operation": "mate", "constraint": "plug-B", "insertion_force": 31.2, "limit": 45.0 }` and the like: N, m.
#[derive(serde::Serialize)]
#[serde(tag = "operation", rename_all = "lowercase")]
enum Operation<'a> {
    Grasp {
        constraint: &'a str,
        #[serde(flatten)]
        place: Option<OnBranch<'a>>,
    },
    Carry {
        constraints: &'a [String],
        force: Number,
    },
    Mate {
        constraint: &'a str,
        insertion_force: Option<Number>,
        limit: Option<Number>,
    },
    Clip {
        constraint: &'a str,
        #[serde(flatten)]
        place: Option<OnBranch<'a>>,
        reach: Number,
    },
}

#[derive(serde::Serialize)]
struct OnBranch<'a> {
    branch: &'a str,
    s: Number,
}

impl<'a> Operation<'a> {
    fn of(result: &'a OperationResult) -> Self {
        let on =
            |place: &'a Option<(String, f64)>| place.as_ref().map(|(branch, s)| OnBranch { branch, s: Number(*s) });
        match result {
            OperationResult::Grasp { constraint, place } => Self::Grasp { constraint, place: on(place) },
            OperationResult::Carry { constraints, force } => Self::Carry { constraints, force: Number(*force) },
            OperationResult::Mate { constraint, insertion_force, limit } => {
                Self::Mate { constraint, insertion_force: insertion_force.map(Number), limit: limit.map(Number) }
            }
            OperationResult::Clip { constraint, place, reach } => {
                Self::Clip { constraint, place: on(place), reach: Number(*reach) }
            }
        }
    }
}

#[derive(serde::Serialize)]
struct Branch<'a> {
    diameter: Number,
    bend_radius_limit: Option<Number>,
    axial_stiffness: Number,
    s: Numbers<'a>,
    position: Vectors<'a>,
    d3: Directors<'a>,
    d1: Directors<'a>,
    force: Vectors<'a>,
    moment: Vectors<'a>,
    bend_radius: Numbers<'a>,
    twist_turns: Number,
}

impl Named for BranchResult {
    type Body<'a> = Branch<'a>;
    fn name(&self) -> &str {
        &self.name
    }
    fn body(&self) -> Branch<'_> {
        Branch {
            diameter: Number(self.diameter),
            bend_radius_limit: self.bend_radius_limit.map(Number),
            axial_stiffness: Number(self.axial_stiffness),
            s: Numbers(&self.s),
            position: Vectors(&self.position),
            d3: Directors { frames: &self.frame, column: 2 },
            d1: Directors { frames: &self.frame, column: 0 },
            force: Vectors(&self.force),
            moment: Vectors(&self.moment),
            bend_radius: Numbers(&self.bend_radius),
            twist_turns: Number(self.twist_turns),
        }
    }
}

#[derive(serde::Serialize)]
struct Joint {
    position: [Number; 3],
    orientation: [Number; 4],
}

impl Named for JointResult {
    type Body<'a> = Joint;
    fn name(&self) -> &str {
        &self.name
    }
    fn body(&self) -> Joint {
        Joint { position: vector(&self.position), orientation: quaternion(&self.orientation) }
    }
}

#[derive(serde::Serialize)]
struct Obstacle {
    position: [Number; 3],
    orientation: [Number; 4],
    force: [Number; 3],
    moment: [Number; 3],
    contacts: usize,
    depth: Number,
}

impl Named for ObstacleResult {
    type Body<'a> = Obstacle;
    fn name(&self) -> &str {
        &self.name
    }
    fn body(&self) -> Obstacle {
        Obstacle {
            position: vector(&self.pose.position),
            orientation: quaternion(&self.pose.orientation),
            force: vector(&self.force),
            moment: vector(&self.moment),
            contacts: self.contacts,
            depth: Number(self.depth),
        }
    }
}

/// How the cable runs through the fixings that slide, by their names.
struct Slides<'a>(&'a [ConstraintResult]);

impl Slides<'_> {
    fn is_empty(&self) -> bool {
        self.0.iter().all(|fixing| fixing.slide.is_none())
    }
}

impl Serialize for Slides<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let slides = self.0.iter().filter_map(|fixing| fixing.slide.as_ref().map(|slide| (&fixing.name, slide)));
        serializer.collect_map(slides.map(|(name, slide)| {
            let slide = Slide {
                branch: &slide.branch,
                contact_arclength: Number(slide.arc_length),
                axial_force: Number(slide.axial_force),
                motion: slide.motion.word(),
            };
            (name, slide)
        }))
    }
}

#[derive(serde::Serialize)]
struct Slide<'a> {
    branch: &'a str,
    contact_arclength: Number,
    axial_force: Number,
    motion: &'static str,
}

#[derive(serde::Serialize)]
struct Constraint<'a> {
    kind: &'a str,
    position: [Number; 3],
    orientation: [Number; 4],
    force: [Number; 3],
    moment: [Number; 3],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    stations: Vec<Station>,
    #[serde(skip_serializing_if = "Option::is_none")]
    span: Option<Span<'a>>,
}

#[derive(serde::Serialize)]
struct Station {
    position: [Number; 3],
    force: [Number; 3],
    moment: [Number; 3],
}

impl Station {
    fn of(station: &StationResult) -> Self {
        Self { position: vector(&station.position), force: vector(&station.force), moment: vector(&station.moment) }
    }
}

#[derive(serde::Serialize)]
struct Span<'a> {
    branch: &'a str,
    from: Number,
    to: Number,
    force: [Number; 3],
    largest: [Number; 3],
    largest_at: Number,
}

impl<'a> Span<'a> {
    fn of(span: &'a SpanResult) -> Self {
        Self {
            branch: &span.branch,
            from: Number(span.range.0),
            to: Number(span.range.1),
            force: vector(&span.force),
            largest: vector(&span.largest),
            largest_at: Number(span.largest_at),
        }
    }
}

impl Named for ConstraintResult {
    type Body<'a> = Constraint<'a>;
    fn name(&self) -> &str {
        &self.name
    }
    fn body(&self) -> Constraint<'_> {
        Constraint {
            kind: &self.kind,
            position: vector(&self.position),
            orientation: quaternion(&self.orientation),
            force: vector(&self.force),
            moment: vector(&self.moment),
            stations: self.stations.iter().map(Station::of).collect(),
            span: self.span.as_ref().map(Span::of),
        }
    }
}

#[derive(serde::Serialize)]
struct EnergyByEffect {
    total: Number,
    stretch: Number,
    shear: Number,
    bend: Number,
    twist: Number,
    gravity: Number,
    load: Number,
    joint: Number,
    constraint: Number,
}

impl EnergyByEffect {
    fn of(energy: &Energy) -> Self {
        Self {
            total: Number(energy.total()),
            stretch: Number(energy.stretch),
            shear: Number(energy.shear),
            bend: Number(energy.bend),
            twist: Number(energy.twist),
            gravity: Number(energy.gravity),
            load: Number(energy.load),
            joint: Number(energy.joint),
            constraint: Number(energy.constraint),
        }
    }
}

#[derive(serde::Serialize)]
struct Tightest<'a> {
    branch: &'a str,
    s: Number,
    value: Number,
    limit: Option<Number>,
}

impl<'a> Tightest<'a> {
    fn of(bend: &'a TightestBend) -> Self {
        Self { branch: &bend.branch, s: Number(bend.s), value: Number(bend.value), limit: bend.limit.map(Number) }
    }
}

#[derive(serde::Serialize)]
struct Minimiser<'a> {
    kind: &'a str,
    /// What it computed on, where that was not the processor.
    #[serde(skip_serializing_if = "Option::is_none")]
    device: Option<&'a str>,
    iterations: usize,
    /// How many of them another minimiser made to finish.
    #[serde(skip_serializing_if = "is_none")]
    polish: usize,
    factorisations: usize,
    seconds: Number,
    force_residual: Number,
    /// m; see [`MinimiserResult::shape_error`].
    #[serde(skip_serializing_if = "Option::is_none")]
    shape_error: Option<Number>,
    #[serde(skip_serializing_if = "Option::is_none")]
    constraint_residual: Option<Number>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "the form that serde asks for")]
fn is_none(count: &usize) -> bool {
    *count == 0
}

impl<'a> Minimiser<'a> {
    fn of(minimiser: &'a MinimiserResult) -> Self {
        Self {
            kind: &minimiser.kind,
            device: minimiser.device.as_deref(),
            iterations: minimiser.iterations,
            polish: minimiser.polish,
            factorisations: minimiser.factorisations,
            seconds: Number(minimiser.seconds),
            force_residual: Number(minimiser.force_residual),
            shape_error: minimiser.shape_error.map(Number),
            constraint_residual: minimiser.constraint_residual.map(Number),
        }
    }
}

/// An entry of an object whose keys are names.
trait Named {
    type Body<'a>: Serialize
    where
        Self: 'a;
    fn name(&self) -> &str;
    fn body(&self) -> Self::Body<'_>;
}

/// An object with one key a name, in the order given.
struct ByName<'a, T>(&'a [T]);

impl<T> ByName<'_, T> {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T: Named> Serialize for ByName<'_, T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for entry in self.0 {
            map.serialize_entry(entry.name(), &entry.body())?;
        }
        map.end()
    }
}

/// A number, or null where it is not finite.
struct Number(f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() { serializer.serialize_f64(self.0) } else { serializer.serialize_none() }
    }
}

struct Numbers<'a>(&'a [f64]);

impl Serialize for Numbers<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().copied().map(Number))
    }
}

struct Vectors<'a>(&'a [Vector]);

impl Serialize for Vectors<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(vector))
    }
}

/// One column of every frame.
struct Directors<'a> {
    frames: &'a [Rotation],
    column: usize,
}

impl Serialize for Directors<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.frames.iter().map(|frame| vector(&columns(frame)[self.column])))
    }
}

fn vector(v: &Vector) -> [Number; 3] {
    [Number(v.x), Number(v.y), Number(v.z)]
}

/// `[w, x, y, z]`.
fn quaternion(q: &Rotation) -> [Number; 4] {
    [Number(q.w), Number(q.i), Number(q.j), Number(q.k)]
}
