//! Places of the nodes of a harness of which only the lengths are known.

use crate::curve::Vector;
use crate::document::Segment;
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Positions of nodes, m: straight segments with their lengths in a plane, from the first node of each piece outward,
/// spread evenly where they branch. A segment that closes a loop lies as the others let it.
pub(super) fn positions(nodes: usize, segments: &[Segment]) -> Vec<Vector> {
    let mut at: Vec<Vec<usize>> = vec![Vec::new(); nodes];
    for (k, segment) in segments.iter().enumerate() {
        segment.ends.iter().for_each(|end| at[*end].push(k));
    }
    let mut positions = vec![Vector::zeros(); nodes];
    let mut known = vec![false; nodes];
    for start in 0..nodes {
        if known[start] {
            continue;
        }
        known[start] = true;
        let mut open = VecDeque::from([(start, None)]);
        while let Some((node, heading)) = open.pop_front() {
            let other = |k: usize| segments[k].ends[usize::from(segments[k].ends[0] == node)];
            let next: Vec<usize> = at[node].iter().copied().filter(|k| !known[other(*k)]).collect();
            for (k, &segment) in next.iter().enumerate() {
                let end = other(segment);
                if std::mem::replace(&mut known[end], true) {
                    continue;
                }
                let angle: f64 = match heading {
                    None => 2.0 * PI * k as f64 / next.len() as f64,
                    Some(heading) => heading + PI * ((k as f64 + 1.0) / (next.len() as f64 + 1.0) - 0.5),
                };
                let own = &segments[segment];
                let length = own.physical_length.or(own.virtual_length).unwrap_or_default();
                positions[end] = positions[node] + Vector::new(angle.cos(), angle.sin(), 0.0) * length;
                open.push_back((end, Some(angle)));
            }
        }
    }
    positions
}
