//! Marching cubes (Lorensen and Cline 1987) whose cases are traced, not tabulated.
//!
//! Corners and edges of a cube have numbers: corner k lies at the bits of k (x, y, z); edge `4 d + m` goes along axis d
//! from the m-th of the four corners that are at 0 there. On a face the corners inside are cut off in runs, one by one
//! where they lie across from each other: both cubes of a face do the same, so there are no gaps. Polygons are cut
//! along diagonals within the cube only, so every edge has two triangles.

use std::sync::LazyLock;

/// Ends of the edges.
pub(super) const EDGES: [[usize; 2]; 12] = {
    let mut edges = [[0; 2]; 12];
    let mut axis = 0;
    while axis < 3 {
        let (mut corner, mut k) = (0, 4 * axis);
        while corner < 8 {
            if corner & (1 << axis) == 0 {
                edges[k] = [corner, corner | (1 << axis)];
                k += 1;
            }
            corner += 1;
        }
        axis += 1;
    }
    edges
};

/// By which corners are inside (bits): triangles of edges on which their corners lie, counter-clockwise as seen from
/// outside.
pub(super) static TRIANGLES: LazyLock<Vec<Vec<[usize; 3]>>> =
    LazyLock::new(|| (0..256).map(|inside| polygons(inside).iter().flat_map(|p| triangles(p)).collect()).collect());

/// The edge between two corners.
fn edge(a: usize, b: usize) -> usize {
    let ends = [a.min(b), a.max(b)];
    EDGES.iter().position(|edge| *edge == ends).expect("corners next to each other")
}

/// Corners of the faces, counter-clockwise as seen from outside the cube.
fn faces() -> impl Iterator<Item = [usize; 4]> {
    (0..3).flat_map(|axis| {
        let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        let high = 1 << axis;
        [[0, v, u | v, u], [high, high | u, high | u | v, high | v]]
    })
}

/// The polygons that part the corners inside from the others, as rings of edges: on a face one side of a polygon runs
/// from where the walk around it comes in to where it goes out again.
fn polygons(inside: usize) -> Vec<Vec<usize>> {
    let is_in = |corner: usize| inside & (1 << corner) != 0;
    let mut next = [None; 12];
    for face in faces() {
        for k in 0..4 {
            let at = |j: usize| face[(k + j) % 4];
            if is_in(at(0)) || !is_in(at(1)) {
                continue;
            }
            let out = (1..4)
                .find(|&j| is_in(at(j)) && !is_in(at(j + 1)))
                .expect("it goes out where it came in at the latest");
            next[edge(at(0), at(1))] = Some(edge(at(out), at(out + 1)));
        }
    }
    let mut rings = Vec::new();
    for first in 0..12 {
        let mut ring = Vec::new();
        let mut at = first;
        while let Some(to) = next[at].take() {
            ring.push(at);
            at = to;
        }
        if !ring.is_empty() {
            rings.push(ring);
        }
    }
    rings
}

/// Whether two edges lie on one face.
fn share_a_face(a: usize, b: usize) -> bool {
    let on = |face: &[usize; 4], edge: usize| EDGES[edge].iter().all(|corner| face.contains(corner));
    faces().any(|face| on(&face, a) && on(&face, b))
}

/// A ring as a fan, from a corner of it whose diagonals lie within the cube.
fn triangles(ring: &[usize]) -> Vec<[usize; 3]> {
    let n = ring.len();
    let at = |k: usize| ring[k % n];
    let clear = |k: &usize| (2..n - 1).all(|j| !share_a_face(at(*k), at(k + j)));
    let root = (0..n).find(clear).expect("a ring has a corner to fan it from");
    (1..n - 1).map(|j| [at(root), at(root + j), at(root + j + 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every case is fanned; the triangles of a case have every edge that is cut, and no other.
    #[test]
    fn every_case_parts_what_is_inside_from_what_is_not() {
        for (inside, triangles) in TRIANGLES.iter().enumerate() {
            let is_cut = |e: usize| EDGES[e].map(|corner| inside & (1 << corner) != 0) == [true, false];
            let is_cut = |e: usize| is_cut(e) || EDGES[e].map(|corner| inside & (1 << corner) != 0) == [false, true];
            for e in 0..12 {
                assert_eq!(triangles.iter().flatten().any(|k| *k == e), is_cut(e), "case {inside}, edge {e}");
            }
        }
        assert_eq!(TRIANGLES[1], [[0, 4, 8]], "one corner, cut off so that its other side is seen counter-clockwise");
    }
}
