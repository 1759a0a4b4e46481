//! Reads what happens: the first shape, the minimiser, the steps.

use crate::document::{Names, lookup, register};
use crate::fixings::{constraint, facing};
use crate::reader::Entry;
use crate::scenario::{Constraint, Facing, Minimiser, Spans};
use crate::{keys, kinds};
use std::collections::{BTreeMap, BTreeSet};
use wireloom_core::rotation::{frame_from, orthogonal};
use wireloom_core::steps::{Initial, Move, Step, Turn};
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
struct Acting {
    active: BTreeSet<usize>,
    /// Those that have let go, and in which step.
    released: BTreeMap<usize, usize>,
}

/// The steps; the constraints they add are put behind those that act from the beginning.
pub(crate) fn steps<'a>(entries: &[Entry<'a>], constraints: &mut Vec<Constraint>, names: &mut Names<'a>) -> Vec<Step> {
    // Names come first: a step may name a constraint that only a later one adds, and that has its own message.
    let added: Vec<Vec<usize>> = entries
        .iter()
        .map(|entry| {
            let first = constraints.len();
            constraints.extend(entry.entries("add").iter().filter_map(|add| constraint(add, false, names)));
            (first..constraints.len()).collect()
        })
        .collect();
    let mut acting = Acting {
        active: (0..constraints.len()).filter(|c| constraints[*c].from_start).collect(),
        released: BTreeMap::new(),
    };
    let mut step_names = BTreeMap::new();
    entries
        .iter()
        .zip(added)
        .enumerate()
        .map(|(k, (entry, add))| {
            let name = entry.word("name").inspect(|name| {
                names.broken |= !register(entry, &mut step_names, name, k);
            });
            let before = entry.reader.fault_count();
            let release = release(entry, k, &mut acting, names);
            acting.active.extend(&add);
            let mut moves = moves(entry, &acting, constraints, names);
            for motion in moves.iter_mut().filter(|motion| add.contains(&motion.fixing)) {
                go_by_what_is_given(motion, &constraints[motion.fixing]);
            }
            let loads = factors(entry, names);
            names.broken |= entry.reader.fault_count() > before;
            Step {
                name: name.map_or_else(|| format!("step {}", k + 1), str::to_owned),
                increments: entry.count("increments").unwrap_or(1),
                gravity: entry.vector("gravity"),
                add,
                release,
                moves,
                loads,
            }
        })
        .collect()
}

fn release(entry: &Entry<'_>, step: usize, acting: &mut Acting, names: &Names<'_>) -> Vec<usize> {
    let mut all = Vec::new();
    for (name, span) in entry.names("release") {
        let Some(&index) = lookup(entry, "constraint", &names.constraints, name, span.clone()) else { continue };
        if acting.active.remove(&index) {
            acting.released.insert(index, step);
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

fn moves(entry: &Entry<'_>, acting: &Acting, constraints: &mut [Constraint], names: &Names<'_>) -> Vec<Move> {
    let mut all: Vec<Move> = Vec::new();
    for motion in entry.entries("move") {
        let path = path(&motion);
        let facing = facing(&motion);
        let turns = motion.number("turns").unwrap_or(0.0);
        let moves_something = ["position", "via", "tangent", "up", "orientation", "turns"];
        if !moves_something.iter().any(|key| motion.has(key)) {
            let message = format!("{} moves nothing", motion.label);
            motion.fault_here(message, "give `position`, `tangent` and `up`, `orientation` or `turns`");
        }
        let Some(name) = motion.word("constraint") else { continue };
        let span = motion.span_of("constraint");
        let Some(&index) = lookup(&motion, "constraint", &names.constraints, name, span.clone()) else { continue };
        if !acting.active.contains(&index) {
            let (message, help) = if acting.released.contains_key(&index) {
                (format!("{} moves \"{name}\", which has let go", entry.label), "move it before it is released")
            } else {
                (format!("{} moves \"{name}\", which has not begun", entry.label), "add it in this step or before")
            };
            entry.reader.fault(span, message, help);
            continue;
        }
        if all.iter().any(|other| other.fixing == index) {
            let message = format!("{} moves \"{name}\" twice", entry.label);
            entry.reader.fault(
                span,
                message,
                "give one move for every constraint, with `via` points where it needs them",
            );
            continue;
        }
        let constraint = &mut constraints[index];
        let turn = turn(facing);
        constraint.tangent_given |= turn != Turn::Keep;
        constraint.up_given |= matches!(turn, Turn::Orientation(_));
        all.push(Move { fixing: index, path, turn, turns });
    }
    all
}

fn turn(facing: Facing) -> Turn {
    match facing {
        Facing::Left => Turn::Keep,
        Facing::Tangent(tangent) => Turn::Tangent(tangent),
        Facing::Orientation(orientation) => Turn::Orientation(orientation),
    }
}

/// A constraint that begins with a step takes hold of the cable where it is: its motion in that step goes through the
/// position it is given, and to the facing where it has no other.
fn go_by_what_is_given(motion: &mut Move, constraint: &Constraint) {
    if let Some(position) = constraint.position {
        motion.path.insert(0, position);
    }
    if motion.turn == Turn::Keep {
        motion.turn = turn(constraint.facing);
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
