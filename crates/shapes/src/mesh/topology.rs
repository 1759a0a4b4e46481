//! From loose triangles to a surface whose triangles know their neighbours.

use super::fault::{LARGEST, MeshFault};
use std::collections::HashMap;
use wireloom_core::Vector;
use wireloom_core::obstacle::Surface;

/// Of the size of the body: as near as this, corners are one. Single precision, in which most files are written, has
/// 1e-7.
const SEAM: f64 = 1e-6;

/// No triangle: the edge is a border.
pub(super) const NONE: u32 = u32::MAX;

/// A surface, closed unless it is open on purpose. Edge `k` of a triangle goes from its corner `k` to the next one.
#[derive(Clone, Debug, Default)]
pub(super) struct Topology {
    pub corners: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
    /// The triangle across each edge.
    pub neighbours: Vec<[u32; 3]>,
    /// Unit normal of each triangle, out of the body; zero where it has no area.
    pub normals: Vec<Vector>,
    /// Bend of the surface across each edge, rad: positive where it is convex, negative in a groove.
    pub bends: Vec<[f32; 3]>,
    pub notes: Vec<String>,
}

impl Topology {
    /// Corners at the same place become one; triangles are turned to face outward.
    ///
    /// # Errors
    /// Whatever makes it no surface; see [`MeshFault`].
    pub fn of(surface: &Surface, open: bool) -> Result<Self, MeshFault> {
        if surface.triangles.is_empty() {
            return Err(MeshFault::Empty);
        }
        let size = size(&surface.corners)?;
        if size > LARGEST {
            return Err(MeshFault::Gigantic { size });
        }
        let mut topology = Self::welded(surface)?;
        let borders = topology.find_neighbours()?;
        if !borders.is_empty() {
            topology.close_seams(&borders, SEAM * size);
            let borders = topology.find_neighbours()?;
            if let (Some(&(a, b)), false) = (borders.first(), open) {
                return Err(MeshFault::Open { edges: borders.len(), at: topology.middle(a, b) });
            }
        }
        topology.orient(open)?;
        topology.part_corners();
        topology.measure();
        let flat = topology.normals.iter().filter(|normal| **normal == Vector::zeros()).count();
        if flat == topology.triangles.len() {
            return Err(MeshFault::Degenerate { triangles: surface.triangles.len() });
        }
        let dropped = flat + surface.triangles.len() - topology.triangles.len();
        if dropped > 0 {
            topology
                .notes
                .push(format!("{dropped} of its {} triangles have no area and are left out", surface.triangles.len()));
        }
        Ok(topology)
    }

    /// With one corner for every place, without triangles that have a corner twice.
    fn welded(surface: &Surface) -> Result<Self, MeshFault> {
        let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(surface.corners.len());
        let mut corners = Vec::new();
        let mut index = Vec::with_capacity(surface.corners.len());
        for corner in &surface.corners {
            // −0 and 0 are one place.
            let bits = [corner.x + 0.0, corner.y + 0.0, corner.z + 0.0].map(f64::to_bits);
            let next = corners.len() as u32;
            let own = *known.entry(bits).or_insert(next);
            if own == next {
                corners.push(*corner);
            }
            index.push(own);
        }
        let mut triangles = Vec::with_capacity(surface.triangles.len());
        for (k, triangle) in surface.triangles.iter().enumerate() {
            if let Some(&corner) = triangle.iter().find(|corner| **corner as usize >= index.len()) {
                return Err(MeshFault::NoSuchCorner { triangle: k, corner, corners: index.len() });
            }
            let [a, b, c] = triangle.map(|corner| index[corner as usize]);
            if a != b && b != c && c != a {
                triangles.push([a, b, c]);
            }
        }
        if triangles.is_empty() {
            return Err(MeshFault::Degenerate { triangles: surface.triangles.len() });
        }
        Ok(Self { corners, triangles, ..Self::default() })
    }

    fn middle(&self, a: u32, b: u32) -> Vector {
        (self.corners[a as usize] + self.corners[b as usize]) * 0.5
    }

    /// Finds the triangle across each edge; returns the edges that have one triangle only.
    fn find_neighbours(&mut self) -> Result<Vec<(u32, u32)>, MeshFault> {
        let ends = |t: &[u32; 3], e: usize| {
            let (a, b) = (t[e], t[(e + 1) % 3]);
            (a.min(b), a.max(b))
        };
        let all = self.triangles.iter().enumerate();
        let mut edges: Vec<((u32, u32), u32, u8)> =
            all.flat_map(|(t, corners)| (0..3).map(move |e| (ends(corners, e), t as u32, e as u8))).collect();
        edges.sort_unstable();
        self.neighbours = vec![[NONE; 3]; self.triangles.len()];
        let (mut borders, mut crowded) = (Vec::new(), Vec::new());
        for same in edges.chunk_by(|a, b| a.0 == b.0) {
            match same {
                [(border, ..)] => borders.push(*border),
                [(_, s, e), (_, t, f)] => {
                    self.neighbours[*s as usize][*e as usize] = *t;
                    self.neighbours[*t as usize][*f as usize] = *s;
                }
                _ => crowded.push((same[0].0, same.len())),
            }
        }
        match crowded.first() {
            Some(&((a, b), triangles)) => {
                Err(MeshFault::NonManifold { edges: crowded.len(), triangles, at: self.middle(a, b) })
            }
            None => Ok(borders),
        }
    }

    /// Corners of borders that lie within round-off of each other are one corner, written in different digits.
    fn close_seams(&mut self, borders: &[(u32, u32)], near: f64) {
        let mut corners: Vec<u32> = borders.iter().flat_map(|&(a, b)| [a, b]).collect();
        corners.sort_unstable();
        corners.dedup();
        let cell = |corner: &Vector| corner.map(|c| (c / near).floor() as i64);
        let mut known: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let mut becomes: Vec<u32> = (0..self.corners.len() as u32).collect();
        for &k in &corners {
            let own = self.corners[k as usize];
            let middle = cell(&own);
            let beside = (0..27).map(|n| [n % 3, n / 3 % 3, n / 9].map(|c: i64| c - 1));
            let mut beside = beside.map(|d| [0, 1, 2].map(|k| middle[k].saturating_add(d[k])));
            let same = beside.find_map(|cell| {
                known.get(&cell)?.iter().find(|&&other| (self.corners[other as usize] - own).norm() < near)
            });
            match same {
                Some(&other) => becomes[k as usize] = other,
                None => known.entry(middle.into()).or_default().push(k),
            }
        }
        self.triangles.iter_mut().for_each(|t| *t = t.map(|k| becomes[k as usize]));
        self.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
    }

    /// Turns triangles so that neighbours run along their common edge in opposite directions, and closed bodies face
    /// outward.
    fn orient(&mut self, open: bool) -> Result<(), MeshFault> {
        let mut seen = vec![false; self.triangles.len()];
        let (mut turned, mut inside_out) = (0, 0);
        let mut component = Vec::new();
        let mut volume = 0.0;
        for first in 0..self.triangles.len() {
            if seen[first] {
                continue;
            }
            seen[first] = true;
            component.clear();
            component.push(first);
            let mut next = 0;
            let mut own_turned = 0;
            while next < component.len() {
                let t = component[next];
                next += 1;
                for e in 0..3 {
                    let other = self.neighbours[t][e];
                    if other == NONE {
                        continue;
                    }
                    let (a, b) = (self.triangles[t][e], self.triangles[t][(e + 1) % 3]);
                    let u = other as usize;
                    let same_way = self.edge_of(u, a, b).is_some();
                    if same_way && seen[u] {
                        return Err(MeshFault::OneSided { at: self.middle(a, b) });
                    }
                    if same_way {
                        self.turn(u);
                        own_turned += 1;
                    }
                    if !seen[u] {
                        seen[u] = true;
                        component.push(u);
                    }
                }
            }
            turned += own_turned;
            let own_volume = component.iter().map(|&t| self.volume_to_origin(t)).sum::<f64>();
            // Triangles that had to be turned say nothing of where outside is; that is then where the volume is
            // positive.
            if !open && own_turned > 0 && own_volume < 0.0 {
                component.iter().for_each(|&t| self.turn(t));
                volume -= own_volume;
            } else {
                volume += own_volume;
            }
        }
        if !open && volume < 0.0 {
            (0..self.triangles.len()).for_each(|t| self.turn(t));
            inside_out = self.triangles.len();
        }
        if turned > 0 && !open {
            self.notes
                .push(format!("{turned} of its triangles faced the other way than their neighbours and are turned"));
        } else if inside_out > 0 {
            self.notes.push("its triangles faced inward and are turned".to_owned());
        }
        Ok(())
    }

    /// Six times the volume of the tetrahedron with the first corner of all.
    fn volume_to_origin(&self, t: usize) -> f64 {
        let origin = self.corners[0];
        let [a, b, c] = self.at(t).map(|corner| corner - origin);
        a.cross(&b).dot(&c)
    }

    fn turn(&mut self, t: usize) {
        self.triangles[t].swap(1, 2);
        // Edges ab, bc, ca become ac, cb, ba.
        self.neighbours[t].swap(0, 2);
    }

    /// The edge of a triangle that goes from one corner to another.
    fn edge_of(&self, t: usize, from: u32, to: u32) -> Option<usize> {
        let corners = self.triangles[t];
        (0..3).find(|&e| corners[e] == from && corners[(e + 1) % 3] == to)
    }

    /// Splits corners at which surfaces touch in a point only: each surface gets a corner of its own.
    fn part_corners(&mut self) {
        let mut parted = vec![[false; 3]; self.triangles.len()];
        let mut taken = vec![false; self.corners.len()];
        let mut fan = Vec::new();
        for t in 0..self.triangles.len() {
            for k in 0..3 {
                if parted[t][k] {
                    continue;
                }
                fan.clear();
                self.around(t, k, |_, _| true, |u, j| fan.push((u, j)));
                let corner = self.triangles[t][k];
                let own = if std::mem::replace(&mut taken[corner as usize], true) {
                    self.corners.push(self.corners[corner as usize]);
                    self.corners.len() as u32 - 1
                } else {
                    corner
                };
                for &(u, j) in &fan {
                    parted[u][j] = true;
                    self.triangles[u][j] = own;
                }
            }
        }
    }

    /// Goes through the triangles about corner `k` of triangle `t`, itself first, across edges (of a triangle) that
    /// `cross` allows; `see` is told each and which of its corners it is.
    pub fn around(&self, t: usize, k: usize, cross: impl Fn(usize, usize) -> bool, mut see: impl FnMut(usize, usize)) {
        see(t, k);
        for forward in [false, true] {
            let (mut at, mut j) = (t, k);
            loop {
                let edge = if forward { (j + 2) % 3 } else { j };
                let next = self.neighbours[at][edge];
                if next == NONE || !cross(at, edge) {
                    break;
                }
                let next = next as usize;
                if next == t {
                    return;
                }
                let place = self.corners[self.triangles[at][j] as usize];
                let Some(i) = (0..3).find(|&i| self.corners[self.triangles[next][i] as usize] == place) else { break };
                (at, j) = (next, i);
                see(at, j);
            }
        }
    }

    /// The corners of a triangle.
    pub fn at(&self, t: usize) -> [Vector; 3] {
        self.triangles[t].map(|corner| self.corners[corner as usize])
    }

    /// Normals, and how the surface turns at edges.
    fn measure(&mut self) {
        self.normals = (0..self.triangles.len()).map(|t| normal(&self.at(t))).collect();
        self.bends = (0..self.triangles.len()).map(|t| [0, 1, 2].map(|e| self.bend(t, e) as f32)).collect();
    }

    fn bend(&self, t: usize, e: usize) -> f64 {
        let other = self.neighbours[t][e];
        if other == NONE {
            return 0.0;
        }
        let (m, n) = (self.normals[t], self.normals[other as usize]);
        let [a, b] = [e, (e + 1) % 3].map(|k| self.corners[self.triangles[t][k] as usize]);
        let (along, across) = ((b - a).normalize(), m.cross(&n));
        if m == Vector::zeros() || n == Vector::zeros() { 0.0 } else { along.dot(&across).atan2(m.dot(&n)) }
    }
}

/// Of a triangle; zero where it has no area beside its edges.
fn normal([a, b, c]: &[Vector; 3]) -> Vector {
    let (u, v) = (b - a, c - a);
    let area = u.cross(&v);
    let longest = u.norm_squared().max(v.norm_squared()).max((c - b).norm_squared());
    if area.norm() > 1e-12 * longest { area.normalize() } else { Vector::zeros() }
}

/// Longest side of a box about points.
fn size(corners: &[Vector]) -> Result<f64, MeshFault> {
    if let Some(corner) = corners.iter().position(|corner| !corner.iter().all(|c| c.is_finite())) {
        return Err(MeshFault::NotFinite { corner });
    }
    let low = corners.iter().fold(Vector::repeat(f64::INFINITY), |low, corner| low.inf(corner));
    let high = corners.iter().fold(Vector::repeat(f64::NEG_INFINITY), |high, corner| high.sup(corner));
    Ok((high - low).max())
}
