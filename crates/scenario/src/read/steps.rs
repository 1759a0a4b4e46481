//! Reads steps: each through its own keys and the step operations.

use super::constraints::constraint;
use super::entry::Entry;
use super::names::{Names, lookup, register};
use crate::operations::context::{Acting, Context};
use crate::operations::{Begins, OPERATIONS, StepOperation, drive};
use crate::scenario::Constraint;
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::Vector;
use wireloom_core::conditions::RotatingAxes;
use wireloom_core::mechanism::Mechanism;
use wireloom_core::steps::Step;

/// What pulls at every mass: gravity, and the acceleration of the car in which the harness is at rest, m/s².
#[derive(Clone, Copy)]
pub(crate) struct Pull {
    pub gravity: Vector,
    pub acceleration: Vector,
}

impl Pull {
    /// Reads what an entry gives of it; the rest stays. Returns whether it gives any.
    pub fn read(&mut self, entry: &Entry<'_>) -> bool {
        let (gravity, acceleration) = (entry.vector("gravity"), entry.vector("acceleration"));
        self.gravity = gravity.unwrap_or(self.gravity);
        self.acceleration = acceleration.unwrap_or(self.acceleration);
        gravity.is_some() || acceleration.is_some()
    }

    /// Both together: in the axes of the car its acceleration is a gravity against it.
    pub fn total(&self) -> Vector {
        self.gravity - self.acceleration
    }
}

/// Rotation of the axes in which the harness is at rest.
#[derive(Clone, Copy)]
pub(crate) struct Spin {
    point: Vector,
    axis: Vector,
    speed: f64,
}

impl Spin {
    pub fn read(entry: &Entry<'_>) -> Self {
        Self {
            point: entry.vector("point").unwrap_or_default(),
            axis: entry.direction("axis").map_or_else(Vector::z, |axis| *axis),
            speed: entry.number("speed").unwrap_or(0.0),
        }
    }

    pub fn at_the_beginning(self) -> RotatingAxes {
        RotatingAxes { point: self.point, velocity: self.axis * self.speed }
    }
}

/// Angular velocity that a step reaches, rad/s.
fn angular_velocity(step: &Entry<'_>, spin: Option<Spin>) -> Option<Vector> {
    let speed = step.number("rotation_speed");
    if spin.is_none() && step.has("rotation_speed") {
        let message = format!("{} has a `rotation_speed`, but the scenario has no `rotation`", step.label);
        step.fault_at("rotation_speed", message, "give the axis: rotation = { axis = [0, 0, 1] } before all tables");
    }
    Some(spin?.axis * speed?)
}

/// The steps; the constraints that they add follow those that act from the beginning. `pull` and `spin` are those at
/// the beginning.
pub(crate) fn steps<'a>(
    entries: &[Entry<'a>],
    (mut pull, spin): (Pull, Option<Spin>),
    constraints: &mut Vec<Constraint>,
    names: &mut Names<'a>,
) -> Vec<Step> {
    // Names come first: a step that names a constraint of a later step gets a message of its own.
    let from_start = constraints.len();
    let mut first = names.constraints.clone();
    let begun: Vec<Begun<'a>> = entries.iter().map(|entry| begin(entry, constraints, names)).collect();
    for (name, index) in begun.iter().flat_map(|begun| &begun.names) {
        first.entry(name).or_insert(*index);
    }
    names.constraints = first;
    let mut acting = Acting { active: (0..from_start).collect(), released: BTreeMap::new(), mated: BTreeSet::new() };
    let mut step_names: BTreeMap<&str, usize> = BTreeMap::new();
    let mut steps = Vec::new();
    let mut values: Vec<Vec<f64>> = names.mechanisms.iter().map(Mechanism::drawn).collect();
    for (k, (entry, begun)) in entries.iter().zip(begun).enumerate() {
        let name = entry.word("name");
        if let Some(name) = name {
            names.broken |= !register(entry, entry.keys.what, &mut step_names, name, k);
        }
        let before = entry.reader.fault_count();
        let release = release(entry, k, &mut acting, names);
        names.constraints.extend(begun.names.iter().copied());
        acting.active.extend(&begun.constraints);
        let mut step = Context {
            entry,
            names,
            acting: &mut acting,
            constraints,
            begun: &begun.constraints,
            drives: Vec::new(),
            moves: Vec::new(),
            obstacle_moves: Vec::new(),
            loads: Vec::new(),
            temperatures: Vec::new(),
        };
        let read = |(operation, entry, begun): &(&StepOperation, Entry<'_>, Option<usize>)| {
            (operation.read)(entry, *begun, &mut step)
        };
        let operations = begun.operations.iter().filter_map(read).collect();
        let (drives, parts) = drive::ways(&step, &mut values);
        let Context { moves, obstacle_moves, loads, temperatures, .. } = step;
        refuse_work_while_waiting(entry);
        names.broken |= entry.reader.fault_count() > before;
        steps.push(Step {
            name: name.map_or_else(|| format!("step {}", k + 1), str::to_owned),
            increments: entry.count("increments").unwrap_or(1) * parts,
            parts,
            duration: entry.number("duration").unwrap_or(0.0),
            gravity: pull.read(entry).then(|| pull.total()),
            angular_velocity: angular_velocity(entry, spin),
            add: begun.constraints,
            release,
            drives,
            moves,
            obstacle_moves,
            operations,
            loads,
            temperatures,
        });
    }
    steps
}

/// The operations of a step, and the constraints that begin with it.
#[derive(Default)]
struct Begun<'a> {
    constraints: Vec<usize>,
    names: Vec<(&'a str, usize)>,
    /// Every operation, with its entry and the constraint that this begins.
    operations: Vec<(&'static StepOperation, Entry<'a>, Option<usize>)>,
}

fn begin<'a>(step: &Entry<'a>, constraints: &mut Vec<Constraint>, names: &mut Names<'a>) -> Begun<'a> {
    let released = step.texts("release");
    names.let_go.extend(released.into_iter().filter(|name| names.constraints.contains_key(name)));
    let mut begun = Begun::default();
    for operation in OPERATIONS {
        let before = step.reader.fault_count();
        let entries = step.entries(operation.key.name);
        names.broken |= step.reader.fault_count() > before;
        for entry in entries {
            let nearest = match (operation.begins)(&entry) {
                Begins::Nothing => None,
                Begins::AtPlace => Some(false),
                Begins::AtPlaceOrNearest => Some(true),
            };
            let own = nearest.and_then(|nearest| constraint(&entry, false, nearest, names)).map(|constraint| {
                let index = constraints.len();
                begun.constraints.push(index);
                begun.names.extend(entry.word("name").map(|name| (name, index)));
                constraints.push(constraint);
                index
            });
            begun.operations.push((operation, entry, own));
        }
    }
    begun
}

fn refuse_work_while_waiting(step: &Entry<'_>) {
    let idle = ["name", "increments", "duration", "wait"];
    let waits = step.flag("wait") == Some(true);
    let Some(work) = step.table.keys().find(|key| !idle.contains(&key.get_ref().as_ref())) else { return };
    if waits && step.keys.get(work.get_ref()).is_some() {
        let message = format!("{} has `wait` and `{}`", step.label, work.get_ref());
        step.reader.fault(work.span(), message, "put other work into a step of its own, before or after");
    }
}

fn release(entry: &Entry<'_>, step: usize, acting: &mut Acting, names: &Names<'_>) -> Vec<usize> {
    let mut all = Vec::new();
    for (name, span) in entry.names("release") {
        let Some(&index) = lookup(entry, "constraint", &names.constraints, name, span.clone()) else { continue };
        if acting.active.remove(&index) {
            acting.released.insert(index, step);
            acting.mated.remove(&index);
            all.push(index);
            continue;
        }
        let (message, help) = if acting.released.contains_key(&index) {
            (format!("{} releases \"{name}\", which is already released", entry.label), "release it once")
        } else {
            (format!("{} releases \"{name}\", which has not begun", entry.label), "release it in a later step")
        };
        entry.reader.fault(span, message, help);
    }
    all
}
