//! A start that is drawn through the measured points: where a harness has several equilibria, such as a loop in its
//! plane or out of it, the points tell which one was measured.

use super::points::MeasuredPoint;
use serde_json::json;
use std::collections::BTreeMap;
use wireloom_core::requirement::Marker;
use wireloom_core::{Registry, Vector};
use wireloom_scenario::{At, Branch, Scenario, record};

/// Distance of points of a drawn line, relative to the length of its branch, below which they are one.
const SAME: f64 = 1e-3;

/// A place of a branch: arc length, m, and the coordinates that are known there.
type Known = (f64, [Option<f64>; 3]);

/// The text with paths through the points of the first measured step, and the names of the branches that have one now:
/// those of which points between their ends were measured, and that had none. `None`: no branch.
pub fn drawn(
    text: &str,
    scenario: &Scenario,
    markers: &[Marker],
    points: &[MeasuredPoint],
    registry: &Registry,
) -> Option<(String, Vec<String>)> {
    if scenario.initial.is_some() {
        return None;
    }
    let first = points.iter().map(|point| point.step).min()?;
    // The first line counts where a point was measured several times.
    let mut measured: BTreeMap<&str, [Option<f64>; 3]> = BTreeMap::new();
    for point in points.iter().filter(|point| point.step == first) {
        measured.entry(&point.marker).or_insert(point.position);
    }
    let (mut text, mut names) = (text.to_owned(), Vec::new());
    for (k, branch) in scenario.branches.iter().enumerate().filter(|(_, branch)| branch.path.is_empty()) {
        let of_branch = markers.iter().filter(|marker| marker.branch == k);
        let known: Vec<Known> =
            of_branch.filter_map(|marker| Some((marker.s, *measured.get(&*marker.name)?))).collect();
        let Some(path) = path(scenario, k, branch, known, &measured) else { continue };
        let path: Vec<[f64; 3]> = path.iter().map(|x| [x.x, x.y, x.z].map(|x| (1e6 * x).round() / 1e6)).collect();
        text = record::with_json(&text, &format!("branches.\"{}\".path", branch.name), &json!(path), registry).ok()?;
        names.push(branch.name.clone());
    }
    (!names.is_empty()).then_some((text, names))
}

/// The line through the points of a branch from end to end; coordinates that were not measured lie between their
/// neighbours.
fn path(
    scenario: &Scenario,
    k: usize,
    branch: &Branch,
    mut known: Vec<Known>,
    measured: &BTreeMap<&str, [Option<f64>; 3]>,
) -> Option<Vec<Vector>> {
    let length = branch.length;
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    known.retain(|(s, _)| (SAME * length..=(1.0 - SAME) * length).contains(s));
    known.dedup_by(|b, a| b.0 - a.0 < SAME * length);
    if known.is_empty() {
        return None;
    }
    for (vertex, s) in branch.vertices.iter().zip([0.0, length]) {
        let at_end = |at: &At| matches!(at, At::Branch { branch, s: own } if *branch == k && *own == s);
        let held = scenario.constraints.iter().filter(|own| own.from_start && own.at.iter().any(at_end));
        let held = held.filter_map(|own| own.position).map(|x| [x.x, x.y, x.z].map(Some)).next();
        if let Some(position) = measured.get(vertex.as_str()).copied().or(held) {
            known.push((s, position));
        }
    }
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [x, y, z] = [0, 1, 2].map(|axis| between(&known, axis));
    let (x, y, z) = (x?, y?, z?);
    let mut path: Vec<Vector> = x.into_iter().zip(y).zip(z).map(|((x, y), z)| Vector::new(x, y, z)).collect();
    path.dedup_by(|b, a| (*b - *a).norm() < SAME * length);
    // An end of which nothing is known lies straight on.
    let straight_on = |near: Vector, next: Vector, rest: f64| near + (near - next).normalize() * rest;
    let last = path.len().checked_sub(1).filter(|last| *last > 0)?;
    if known[0].0 > 0.0 {
        path.insert(0, straight_on(path[0], path[1], known[0].0));
    }
    let (end, n) = (known[known.len() - 1].0, path.len());
    if end < length && last > 0 {
        path.push(straight_on(path[n - 1], path[n - 2], length - end));
    }
    Some(path)
}

/// A coordinate of all places, linear between those where it is known. `None`: it is known nowhere.
fn between(known: &[Known], axis: usize) -> Option<Vec<f64>> {
    let all: Vec<(f64, f64)> = known.iter().filter_map(|(s, x)| Some((*s, x[axis]?))).collect();
    let (first, last) = (all.first()?, all.last()?);
    let at = |s: f64| match all.iter().position(|own| own.0 >= s) {
        Some(0) => first.1,
        None => last.1,
        Some(k) => {
            let (before, after) = (all[k - 1], all[k]);
            before.1 + (after.1 - before.1) * (s - before.0) / (after.0 - before.0)
        }
    };
    Some(known.iter().map(|(s, _)| at(*s)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coordinate_that_was_not_measured_lies_between_its_neighbours() {
        let known =
            [(0.0, [Some(0.0), Some(1.0), None]), (0.125, [Some(0.5), None, None]), (0.5, [None, Some(3.0), None])];
        assert_eq!(between(&known, 0), Some(vec![0.0, 0.5, 0.5]));
        assert_eq!(between(&known, 1), Some(vec![1.0, 1.5, 3.0]));
        assert_eq!(between(&known, 2), None);
    }
}
