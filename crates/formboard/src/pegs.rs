//! What holds the harness on the board.

use crate::harness::{Harness, Place};
use crate::line::{Line, Point};
use std::collections::HashMap;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.81;

/// Weight of cable for each peg, N: with this, none bears 1 N. (The second support of an even beam on rigid ones bears
/// 1.14 times its share.)
const LOAD: f64 = 0.6;

/// Largest distance between pegs along a branch, m.
const SPACING: f64 = 0.4;

/// Least distance between pegs along a branch, m: they have a thickness.
const LEAST: f64 = 0.02;

/// Largest bend between two pegs, rad.
const BEND: f64 = std::f64::consts::PI / 6.0;

/// A support of the harness on the board: elastic, such as a fork of sheet metal.
#[derive(Clone, Debug, PartialEq)]
pub struct Peg {
    /// Its name.
    pub name: String,
    /// Where it holds the harness.
    pub at: Place,
    /// Where that is on the board, m.
    pub position: Point,
    /// What it holds.
    pub holds: Holds,
}

/// What a peg holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// An end: a holder for the connector.
    End,
    /// A joint.
    Joint,
    /// A clip.
    Clip,
    /// A place along a branch.
    Cable,
}

impl Peg {
    /// Stiffness, N/m. Between rigid pegs a slightly bent bundle would have kilonewtons.
    pub const STIFFNESS: f64 = 2000.0;
}

/// A peg at every vertex, at every clip, and between them such that none bears much.
pub(crate) fn pegs(harness: &Harness, lines: &[Line], points: &[Point], cut: &[usize]) -> Vec<Peg> {
    let (mut pegs, mut names) = (Vec::new(), HashMap::new());
    let mut unique = |name: String| {
        let times = names.entry(name.clone()).or_insert(0_usize);
        *times += 1;
        if *times == 1 { name } else { format!("{name} ({times})") }
    };
    let mut arms = vec![0; points.len()];
    for (k, branch) in harness.branches.iter().enumerate() {
        arms[branch.ends[0]] += 1;
        arms[branch.ends[1]] += usize::from(!cut.contains(&k));
    }
    for (vertex, own) in harness.vertices.iter().enumerate().filter(|(vertex, _)| arms[*vertex] > 0) {
        let holds = if arms[vertex] > 1 { Holds::Joint } else { Holds::End };
        let name = unique(format!("peg {}", own.name));
        pegs.push(Peg { name, at: Place::Vertex(vertex), position: points[vertex], holds });
    }
    for &k in cut {
        let name = unique(format!("peg {} cut", harness.branches[k].name));
        pegs.push(Peg { name, at: Place::Cut(k), position: lines[k].end(), holds: Holds::End });
    }
    for (k, branch) in harness.branches.iter().enumerate() {
        for clip in &branch.clips {
            let (name, at) = (unique(format!("peg {}", clip.name)), Place::Along { branch: k, s: clip.s });
            pegs.push(Peg { name, at, position: lines[k].at(clip.s), holds: Holds::Clip });
        }
    }
    let nearest = nearest_parts(harness, lines, cut);
    for (k, branch) in harness.branches.iter().enumerate() {
        for (count, s) in between(branch, &lines[k], nearest[k]).into_iter().enumerate() {
            let (name, at) = (unique(format!("peg {} {}", branch.name, count + 1)), Place::Along { branch: k, s });
            pegs.push(Peg { name, at, position: lines[k].at(s), holds: Holds::Cable });
        }
    }
    pegs
}

/// Length of cable that one peg bears at most.
fn part(branch: &crate::Branch, line: &Line) -> f64 {
    let by_weight = LOAD / (branch.linear_density * GRAVITY).max(1e-9);
    let by_bend = BEND / line.curvature.abs().max(1e-9);
    by_weight.min(SPACING).min(by_bend).max(LEAST)
}

/// For both ends of every branch the distance from there to the first peg along it, such that a joint bears no more
/// than [`LOAD`]: its peg has half of the cable up to there, of each arm. Light arms keep their own distance, the heavy
/// ones share the rest.
fn nearest_parts(harness: &Harness, lines: &[Line], cut: &[usize]) -> Vec<[f64; 2]> {
    let mut nearest: Vec<[f64; 2]> =
        harness.branches.iter().zip(lines).map(|(branch, line)| [part(branch, line); 2]).collect();
    let mut arms: Vec<Vec<(usize, usize)>> = vec![Vec::new(); harness.vertices.len()];
    for (k, branch) in harness.branches.iter().enumerate() {
        arms[branch.ends[0]].push((k, 0));
        if !cut.contains(&k) {
            arms[branch.ends[1]].push((k, 1));
        }
    }
    for arms in arms.iter().filter(|arms| arms.len() > 1) {
        let per_metre = |k: usize| 0.5 * harness.branches[k].linear_density * GRAVITY;
        let mut loads: Vec<(f64, usize, usize)> = arms
            .iter()
            .map(|&(k, end)| (per_metre(k) * nearest[k][end].min(harness.branches[k].length), k, end))
            .collect();
        loads.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut left = LOAD;
        for (index, &(load, k, end)) in loads.iter().enumerate() {
            let fair = left / (loads.len() - index) as f64;
            if load > fair {
                nearest[k][end] = (fair / per_metre(k)).max(LEAST);
            }
            left = (left - load.min(fair)).max(0.0);
        }
    }
    nearest
}

/// Arc lengths of pegs between the ends and clips of a branch. `nearest`: distances to the first and from the last one.
fn between(branch: &crate::Branch, line: &Line, nearest: [f64; 2]) -> Vec<f64> {
    let part = part(branch, line);
    let mut held = vec![0.0, branch.length];
    held.extend(branch.clips.iter().map(|clip| clip.s));
    held.sort_by(f64::total_cmp);
    let mut found = Vec::new();
    let spans = held.len() - 1;
    for (k, span) in held.windows(2).enumerate() {
        let mut stops = vec![span[0], span[1]];
        let length = span[1] - span[0];
        let first = (k == 0 && nearest[0] < part).then(|| span[0] + nearest[0]);
        let last = (k + 1 == spans && nearest[1] < part).then(|| span[1] - nearest[1]);
        // Where a span is too short for both, its middle is as good.
        let inside = |s: f64| s - span[0] > 0.5 * LEAST && span[1] - s > 0.5 * LEAST;
        match (first, last) {
            (Some(first), Some(last)) if last - first < LEAST => stops.push(span[0] + 0.5 * length),
            (first, last) => stops.extend(first.into_iter().chain(last)),
        }
        stops.retain(|&s| s == span[0] || s == span[1] || inside(s));
        stops.sort_by(f64::total_cmp);
        for pair in stops.windows(2) {
            let parts = ((pair[1] - pair[0]) / part * (1.0 - 1e-9)).ceil().max(1.0);
            found.extend((1..parts as usize).map(|n| pair[0] + (pair[1] - pair[0]) * n as f64 / parts));
        }
        found.extend(stops.into_iter().filter(|&s| s > span[0] && s < span[1]));
    }
    found.sort_by(f64::total_cmp);
    found
}
