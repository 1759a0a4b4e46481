//! Reads what happens: the first shape, the minimiser, the steps.

use crate::document::{Names, lookup, register};
use crate::fixings::{constraint, facing};
use crate::operations;
use crate::reader::{Entry, Span};
use crate::scenario::{Constraint, Facing, Minimiser, Spans};
use crate::{keys, kinds};
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::rotation::{frame_from, orthogonal};
use wireloom_core::steps::{Initial, Move, ObstacleMove, Step, Track, Turn};
use wireloom_core::{Pose, Stop, Vector};

/// Where the rest shape is laid; along world x with d1 up where the file does not say.
pub(crate) fn initial(entry: &Entry<'_>, names: &mut Names<'_>) -> Option<Initial> {
    let position = entry.vector("position").unwrap_or_default();
    let orientation = match facing(entry) {
        Facing::Left => frame_from(&Vector::x(), &Vector::z()),
        Facing::Tangent(tangent) => frame_from(&tangent, &orthogonal(&tangent)),
        Facing::Orientation(orientation) => Some(orientation),
    };
    let branch = entry
        .word("branch")
        .and_then(|branch| lookup(entry, "branch", &names.branches, branch, entry.span_of("branch")).copied());
    names.broken |= branch.is_none();
    Some(Initial { branch: branch?, pose: Pose { position, orientation: orientation? } })
}

/// The minimiser, with defaults where the file has none.
pub(crate) fn minimiser<'a>(root: &Entry<'a>, names: &mut Names<'a>) -> Minimiser {
    let empty = toml::de::DeTable::new();
    let given = root.entry("minimiser");
    let absent = given.is_none();
    let entry =
        given.unwrap_or_else(|| Entry::new(root.reader, &empty, 0..0, &keys::MINIMISER, "the minimiser".to_owned()));
    let kind = if absent && root.has("minimiser") { None } else { kinds::read(&entry) };
    names.broken |= kind.is_none();
    let (kind, parameters) = kind.map(|kind| (kind.name, kind.parameters)).unwrap_or_default();
    let default = Stop::default();
    let stop = Stop {
        force_tolerance: entry.number("force_tolerance").unwrap_or(default.force_tolerance),
        max_iterations: entry.count("max_iterations").unwrap_or(default.max_iterations),
    };
    Minimiser { kind, parameters, stop, spans: if absent { Spans::default() } else { entry.spans() } }
}

/// Which constraints act, as the steps go by.
pub(crate) struct Acting {
    pub active: BTreeSet<usize>,
    /// Those that have let go, and in which step.
    pub released: BTreeMap<usize, usize>,
    /// Connectors that have been pushed home.
    pub mated: BTreeSet<usize>,
}

/// The steps; the constraints they add are put behind those that act from the beginning.
pub(crate) fn steps<'a>(entries: &[Entry<'a>], constraints: &mut Vec<Constraint>, names: &mut Names<'a>) -> Vec<Step> {
    // Names come first: a step may name a constraint that only a later one adds, and that has its own message.
    let from_start = constraints.len();
    let mut first = names.constraints.clone();
    let begins: Vec<Begins<'a>> = entries.iter().map(|entry| begins(entry, constraints, names)).collect();
    for (name, index) in begins.iter().flat_map(|begins| &begins.names) {
        first.entry(name).or_insert(*index);
    }
    names.constraints = first;
    let mut acting = Acting { active: (0..from_start).collect(), released: BTreeMap::new(), mated: BTreeSet::new() };
    let mut step_names = BTreeMap::new();
    entries
        .iter()
        .zip(begins)
        .enumerate()
        .map(|(k, (entry, begins))| {
            let name = entry.word("name").inspect(|name| {
                names.broken |= !register(entry, entry.keys.what, &mut step_names, name, k);
            });
            let before = entry.reader.fault_count();
            let release = release(entry, k, &mut acting, names);
            names.constraints.extend(begins.names.iter().copied());
            acting.active.extend(&begins.all);
            let mut motions = Motions { step: entry, acting: &mut acting, moves: Vec::new(), obstacles: Vec::new() };
            moves(entry, &mut motions, &begins.all, constraints, names);
            let operations = operations::read(entry, &begins, &mut motions, constraints, names);
            let (moves, obstacle_moves) = (motions.moves, motions.obstacles);
            let loads = factors(entry, names);
            refuse_work_while_waiting(entry);
            names.broken |= entry.reader.fault_count() > before;
            Step {
                name: name.map_or_else(|| format!("step {}", k + 1), str::to_owned),
                increments: entry.count("increments").unwrap_or(1),
                gravity: entry.vector("gravity"),
                add: begins.all,
                release,
                moves,
                obstacle_moves,
                operations,
                loads,
            }
        })
        .collect()
}

/// The constraints that begin with a step, by what brings them.
#[derive(Default)]
pub(crate) struct Begins<'a> {
    pub all: Vec<usize>,
    pub names: Vec<(&'a str, usize)>,
    pub grasps: Vec<usize>,
    /// One for every `mate`; none where the constraint acts already.
    pub mates: Vec<Option<usize>>,
    pub clips: Vec<usize>,
}

fn begins<'a>(step: &Entry<'a>, constraints: &mut Vec<Constraint>, names: &mut Names<'a>) -> Begins<'a> {
    let released = step.texts("release");
    names.let_go.extend(released.into_iter().filter(|name| names.constraints.contains_key(name)));
    let mut begins = Begins::default();
    let mut begin = |entry: &Entry<'a>| {
        let constraint = constraint(entry, false, names)?;
        let index = constraints.len();
        begins.all.push(index);
        begins.names.extend(entry.word("name").map(|name| (name, index)));
        constraints.push(constraint);
        Some(index)
    };
    for add in step.entries("add") {
        begin(&add);
    }
    let grasps = step.entries("grasp").iter().filter_map(&mut begin).collect();
    let mates = step.entries("mate").iter().map(|mate| if mate.has("name") { begin(mate) } else { None }).collect();
    let clips = step.entries("clip").iter().filter_map(begin).collect();
    Begins { grasps, mates, clips, ..begins }
}

fn refuse_work_while_waiting(step: &Entry<'_>) {
    let idle = ["name", "increments", "wait"];
    let Some(work) = step.table.keys().find(|key| !idle.contains(&key.get_ref().as_ref())) else { return };
    if step.flag("wait") == Some(true) && step.keys.get(work.get_ref()).is_some() {
        let message = format!("{} waits, and has `{}` to do", step.label, work.get_ref());
        step.reader.fault(work.span(), message, "put what is to be done in a step of its own, before or after");
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
            (format!("{} releases \"{name}\", which has let go before", entry.label), "release it once")
        } else {
            (format!("{} releases \"{name}\", which has not begun", entry.label), "release it in a later step")
        };
        entry.reader.fault(span, message, help);
    }
    all
}

/// The motions of a step. A constraint or an obstacle takes part in one at most.
pub(crate) struct Motions<'s, 'a> {
    pub step: &'s Entry<'a>,
    pub acting: &'s mut Acting,
    pub moves: Vec<Move>,
    pub obstacles: Vec<ObstacleMove>,
}

impl Motions<'_, '_> {
    /// The constraint of this name, if it may be moved.
    pub fn claim(&self, entry: &Entry<'_>, name: &str, span: Span, names: &Names<'_>) -> Option<usize> {
        let index = *lookup(entry, "constraint", &names.constraints, name, span.clone())?;
        let step = &self.step.label;
        let (message, help) = if self.acting.released.contains_key(&index) {
            (format!("{step} moves \"{name}\", which has let go"), "move it before it is released")
        } else if !self.acting.active.contains(&index) {
            (format!("{step} moves \"{name}\", which has not begun"), "add it in this step or before")
        } else if self.moves.iter().any(|other| other.carried.iter().any(|carried| carried.fixing == index)) {
            let help = "give one move for every constraint, with `via` points where it needs them";
            (format!("{step} moves \"{name}\" twice"), help)
        } else {
            return Some(index);
        };
        entry.reader.fault(span, message, help);
        None
    }

    /// The obstacle of this name, if nothing else moves it.
    fn claim_obstacle(&self, entry: &Entry<'_>, name: &str, names: &Names<'_>) -> Option<usize> {
        let span = entry.span_of("obstacle");
        let index = *lookup(entry, "obstacle", &names.obstacles, name, span.clone())?;
        if self.obstacles.iter().any(|other| other.obstacle == index) {
            let message = format!("{} moves the obstacle \"{name}\" twice", self.step.label);
            let help = "give one move for every obstacle, with `via` points where it needs them";
            entry.reader.fault(span, message, help);
            return None;
        }
        Some(index)
    }
}

/// Where something goes through these points, at equal shares of the step.
fn track(path: Vec<Vector>, turn: Turn, spin: f64) -> Track {
    let legs = path.len() as f64;
    Track {
        positions: path.into_iter().enumerate().map(|(k, point)| ((k + 1) as f64 / legs, point)).collect(),
        turns: if turn == Turn::Keep { vec![] } else { vec![(1.0, turn)] },
        spin,
    }
}

fn moves(
    step: &Entry<'_>,
    motions: &mut Motions<'_, '_>,
    added: &[usize],
    constraints: &mut [Constraint],
    names: &Names<'_>,
) {
    for motion in step.entries("move") {
        let mut path = path(&motion);
        let facing = facing(&motion);
        let turns = motion.number("turns").unwrap_or(0.0);
        let moves_something = ["position", "via", "tangent", "up", "orientation", "turns"];
        if !moves_something.iter().any(|key| motion.has(key)) {
            let message = format!("{} moves nothing", motion.label);
            motion.fault_here(message, "give `position`, `tangent` and `up`, `orientation` or `turns`");
        }
        if motion.has("constraint") && motion.has("obstacle") {
            let message = format!("{} has both `constraint` and `obstacle`", motion.label);
            motion.fault_at("obstacle", message, "give each of them a move of its own");
            continue;
        }
        if let Some(name) = motion.word("obstacle") {
            let obstacle = motions.claim_obstacle(&motion, name, names);
            let track = track(path, turn(facing), turns);
            motions.obstacles.extend(obstacle.map(|obstacle| ObstacleMove { obstacle, track }));
            continue;
        }
        let Some(name) = motion.word("constraint") else { continue };
        let Some(index) = motions.claim(&motion, name, motion.span_of("constraint"), names) else { continue };
        let constraint = &mut constraints[index];
        let mut turn = turn(facing);
        constraint.tangent_given |= turn != Turn::Keep;
        constraint.up_given |= matches!(turn, Turn::Orientation(_));
        if added.contains(&index) {
            // It takes hold of the cable where it is: it goes through the position it is given, and to the facing where the
            // motion has no other.
            path.splice(0..0, constraint.position);
            turn = if turn == Turn::Keep { self::turn(constraint.facing) } else { turn };
        }
        motions.moves.push(Move::of(index, track(path, turn, turns)));
    }
}

pub(crate) fn turn(facing: Facing) -> Turn {
    match facing {
        Facing::Left => Turn::Keep,
        Facing::Tangent(tangent) => Turn::Tangent(tangent),
        Facing::Orientation(orientation) => Turn::Orientation(orientation),
    }
}

fn path(motion: &Entry<'_>) -> Vec<Vector> {
    let mut path = motion.points("via").unwrap_or_default();
    if motion.has("via") && !motion.has("position") {
        let message = format!("{} has `via` but no `position`", motion.label);
        motion.fault_at("via", message, "add `position`: where the motion ends");
    }
    path.extend(motion.vector("position"));
    path
}

fn factors(entry: &Entry<'_>, names: &Names<'_>) -> Vec<(usize, f64)> {
    let mut all: Vec<(usize, f64)> = Vec::new();
    for change in entry.entries("load") {
        let factor = change.number("factor");
        let Some(name) = change.word("load") else { continue };
        let span = change.span_of("load");
        let Some(&index) = lookup(&change, "load", &names.loads, name, span.clone()) else { continue };
        if all.iter().any(|(other, _)| *other == index) {
            let message = format!("{} changes the load \"{name}\" twice", entry.label);
            entry.reader.fault(span, message, "give one factor for every load");
            continue;
        }
        all.extend(factor.map(|factor| (index, factor)));
    }
    all
}
