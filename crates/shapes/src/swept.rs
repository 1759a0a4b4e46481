//! The space that cables go through while they move, as one closed surface: the swept envelope for a digital mock-up.
//!
//! From one state to the next every straight piece of a centre line goes through a patch, of which two triangles are
//! taken; what is nearer than the cable's radius to any of them has been swept. φ, the distance from all patches less
//! the radius, is found at the points of a grid, where it is near 0, and the surface φ = 0 of what is linear between
//! them is drawn by `cubes`. It lies where the grid of cell size h has it: with cables of radius r at most about h²/(4
//! r) within the true surface where that is round, and beside it by less than h where two swept parts meet in a groove.
//! Ends are round: they reach a radius farther than the cable. Cables thinner than two cells are drawn as thick as
//! that.

mod cubes;

use cubes::{EDGES, TRIANGLES};
use std::collections::HashMap;
use wireloom_core::Vector;
use wireloom_core::obstacle::Surface;

/// Points along a side of a block of the grid.
const SIDE: usize = 8;
/// φ is known where it is less than so many cells: farther than any corner of a cell that the surface goes through.
const BAND: f64 = 2.0;
/// Of a cell: what moved by less since it was drawn last is not drawn again.
const STILL: f64 = 0.02;
/// Of a cell: corners of the surface lie no nearer to points of the grid, so none fall together.
const APART: f32 = 0.02;
/// Blocks that are taken at most: 2 GB.
const MANY: usize = 1 << 20;
/// Twice the area of a triangle over the product of two sides, below which it is looked at as its edges.
const FLAT: f64 = 1e-6;

/// φ in cells, at the points of a block.
type Block = [f32; SIDE * SIDE * SIDE];

/// The cells are too small for the memory of a machine.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("what is swept takes too many cells of {cell} m")]
pub struct TooFine {
    /// Their size, m.
    pub cell: f64,
}

/// Volume that cables have swept, on a grid.
pub struct Envelope {
    cell: f64,
    /// Of each segment of each cable, m.
    radii: Vec<Vec<f64>>,
    /// Nodes of each cable where they were drawn last, m; empty before the first state.
    drawn: Vec<Vec<Vector>>,
    blocks: HashMap<[i32; 3], Box<Block>>,
    /// Blocks that are taken at most.
    most: usize,
}

impl Envelope {
    /// Of cables with these radii of their segments (m), none of which has been anywhere yet; `cell`: size of the
    /// grid's cells, m, greater than 0.
    pub fn new(cell: f64, radii: &[Vec<f64>]) -> Self {
        let mut envelope = Self { cell, radii: Vec::new(), drawn: Vec::new(), blocks: HashMap::new(), most: MANY };
        envelope.begin(radii);
        envelope
    }

    /// Other cables, with these radii of their segments (m), begin anywhere; what was swept before stays.
    pub fn begin(&mut self, radii: &[Vec<f64>]) {
        let drawn = |radius: &f64| radius.max(self.cell);
        self.radii = radii.iter().map(|cable| cable.iter().map(drawn).collect()).collect();
        self.drawn.clear();
    }

    /// Size of the grid's cells, m.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// What was swept, by blocks of the grid, in the order of their places: φ in cells at the points of each.
    pub fn blocks(&self) -> Vec<([i32; 3], &[f32])> {
        let mut blocks: Vec<_> = self.blocks.iter().map(|(place, block)| (*place, &block[..])).collect();
        blocks.sort_unstable_by_key(|(place, _)| *place);
        blocks
    }

    /// Adds what another envelope with the same cells has swept, by one of its [`Self::blocks`]. The surface does not
    /// depend on the order in which envelopes are added.
    ///
    /// # Errors
    /// [`TooFine`] where that needs too much memory.
    ///
    /// # Panics
    /// If the block has another number of points.
    pub fn add_block(&mut self, place: [i32; 3], phi: &[f32]) -> Result<(), TooFine> {
        assert_eq!(phi.len(), SIDE.pow(3), "points of a block");
        if self.blocks.len() == self.most && !self.blocks.contains_key(&place) {
            return Err(TooFine { cell: self.cell });
        }
        let block = self.blocks.entry(place).or_insert_with(|| Box::new([BAND as f32; SIDE.pow(3)]));
        for (own, other) in block.iter_mut().zip(phi) {
            *own = own.min(*other);
        }
        Ok(())
    }

    /// The cables go straight from where they were to `lines`: their nodes, m, as many as ever.
    ///
    /// # Errors
    /// [`TooFine`] where that needs too much memory; what is swept is not whole then.
    pub fn sweep(&mut self, lines: &[Vec<Vector>]) -> Result<(), TooFine> {
        let first = self.drawn.is_empty();
        if first {
            self.drawn = lines.to_vec();
        }
        let mut drawn = std::mem::take(&mut self.drawn);
        for (k, (was, now)) in drawn.iter_mut().zip(lines).enumerate() {
            let moved: Vec<bool> =
                was.iter().zip(now).map(|(a, b)| first || (a - b).norm() > STILL * self.cell).collect();
            for j in 0..now.len().saturating_sub(1) {
                if moved[j] || moved[j + 1] {
                    let (b, d) =
                        (if moved[j] { now[j] } else { was[j] }, if moved[j + 1] { now[j + 1] } else { was[j + 1] });
                    let radius = self.radii[k][j];
                    self.draw(&Triangle::of([was[j], was[j + 1], d]), radius)?;
                    self.draw(&Triangle::of([was[j], d, b]), radius)?;
                }
            }
            for ((was, now), moved) in was.iter_mut().zip(now).zip(moved) {
                if moved {
                    *was = *now;
                }
            }
        }
        self.drawn = drawn;
        Ok(())
    }

    /// Everything within a radius of a triangle has been swept.
    fn draw(&mut self, triangle: &Triangle, radius: f64) -> Result<(), TooFine> {
        let reach = radius + BAND * self.cell;
        let width = SIDE as f64 * self.cell;
        let block = |x: Vector| x.map(|x| (x / width).floor() as i32);
        let [a, b, c] = triangle.corners;
        let (low, high) = (a.inf(&b).inf(&c).add_scalar(-reach), a.sup(&b).sup(&c).add_scalar(reach));
        let (first, last) = (block(low), block(high));
        for i in first.x..=last.x {
            for j in first.y..=last.y {
                for k in first.z..=last.z {
                    let corner = Vector::new(f64::from(i), f64::from(j), f64::from(k)) * width;
                    let half = 0.5 * (width - self.cell);
                    if triangle.distance(&corner.add_scalar(half)) > reach + half * 3.0_f64.sqrt() {
                        continue;
                    }
                    if self.blocks.len() == self.most {
                        return Err(TooFine { cell: self.cell });
                    }
                    let block = self.blocks.entry([i, j, k]).or_insert_with(|| Box::new([BAND as f32; SIDE.pow(3)]));
                    // Points within reach of the box around the triangle: the others are too far away.
                    let near = |d: usize| {
                        let [from, to] = [low[d], high[d]].map(|end| (end - corner[d]) / self.cell);
                        from.ceil() as usize..(to.floor() as usize).min(SIDE - 1) + 1
                    };
                    for (z, y) in near(2).flat_map(|z| near(1).map(move |y| (z, y))) {
                        for x in near(0) {
                            let phi = &mut block[x + SIDE * (y + SIDE * z)];
                            // Deep inside, the depth is not needed.
                            if *phi > -BAND as f32 {
                                let at = [x, y, z].map(|m| m as f64 * self.cell);
                                let distance = triangle.distance(&(corner + Vector::from(at)));
                                *phi = phi.min(((distance - radius) / self.cell) as f32);
                            }
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The surface of all that was swept, closed, every edge with two triangles; without triangles where nothing was.
    pub fn surface(&self) -> Surface {
        const ROW: usize = SIDE + 1;
        let mut blocks: Vec<&[i32; 3]> = self.blocks.keys().collect();
        blocks.sort_unstable();
        let mut surface = Surface::default();
        // Corners of the surface by the point where their edge of the grid begins, and its axis.
        let mut known: HashMap<([i32; 3], usize), u32> = HashMap::new();
        let mut phi = [0.0_f32; ROW * ROW * ROW];
        for block in blocks {
            let first = block.map(|k| k * SIDE as i32);
            for (n, phi) in phi.iter_mut().enumerate() {
                let at = [n % ROW, n / ROW % ROW, n / (ROW * ROW)];
                let (over, own) = (at.map(|m| (m / SIDE) as i32), at.map(|m| m % SIDE));
                let home = [block[0] + over[0], block[1] + over[1], block[2] + over[2]];
                *phi = self.blocks.get(&home).map_or(BAND as f32, |b| b[own[0] + SIDE * (own[1] + SIDE * own[2])]);
            }
            for n in 0..SIDE.pow(3) {
                let at = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)];
                let corner = |k: usize| [0, 1, 2].map(|d| at[d] + (k >> d & 1));
                let value = |k: usize| {
                    let [x, y, z] = corner(k);
                    phi[x + ROW * (y + ROW * z)]
                };
                let inside = (0..8).filter(|k| value(*k) < 0.0).fold(0, |bits, k| bits | 1 << k);
                for triangle in &TRIANGLES[inside] {
                    let corners = triangle.map(|e| {
                        let [a, b] = EDGES[e];
                        let from = corner(a);
                        let point = [0, 1, 2].map(|d| first[d] + from[d] as i32);
                        *known.entry((point, e / 4)).or_insert_with(|| {
                            let share = (value(a) / (value(a) - value(b))).clamp(APART, 1.0 - APART);
                            let mut x = Vector::from(point.map(f64::from));
                            x[e / 4] += f64::from(share);
                            surface.corners.push(x * self.cell);
                            surface.corners.len() as u32 - 1
                        })
                    });
                    surface.triangles.push(corners);
                }
            }
        }
        surface
    }
}

/// A triangle, or what is left of it.
struct Triangle {
    corners: [Vector; 3],
    /// Sides, and their lengths squared.
    sides: [(Vector, f64); 3],
    /// Unit normal, where it has an area.
    normal: Option<Vector>,
}

impl Triangle {
    fn of(corners: [Vector; 3]) -> Self {
        let sides = [0, 1, 2].map(|k| {
            let side = corners[(k + 1) % 3] - corners[k];
            (side, side.norm_squared())
        });
        let normal = sides[0].0.cross(&sides[1].0);
        let flat = normal.norm_squared() <= FLAT * FLAT * sides[0].1 * sides[1].1;
        Self { corners, sides, normal: (!flat).then(|| normal.normalize()) }
    }

    /// From the plane where x is above the inside, else from the nearest side.
    fn distance(&self, x: &Vector) -> f64 {
        if let Some(normal) = &self.normal {
            let within = |k: usize| normal.cross(&self.sides[k].0).dot(&(x - self.corners[k])) >= 0.0;
            if (0..3).all(within) {
                return normal.dot(&(x - self.corners[0])).abs();
            }
        }
        let to_side = |k: usize| {
            let (side, square) = &self.sides[k];
            let off = x - self.corners[k];
            let share = if *square > 0.0 { (off.dot(side) / square).clamp(0.0, 1.0) } else { 0.0 };
            (off - side * share).norm_squared()
        };
        (0..3).map(to_side).fold(f64::INFINITY, f64::min).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use std::f64::consts::PI;
    use wireloom_core::obstacle::Shape;

    /// By the divergence theorem.
    fn volume(surface: &Surface) -> f64 {
        let corner = |k: u32| surface.corners[k as usize];
        surface.triangles.iter().map(|t| corner(t[0]).cross(&corner(t[1])).dot(&corner(t[2])) / 6.0).sum()
    }

    fn straight(from: Vector, to: Vector, pieces: usize) -> Vec<Vector> {
        (0..=pieces).map(|k| from + (to - from) * (k as f64 / pieces as f64)).collect()
    }

    /// A straight cable (length L, radius r) that is moved sideways by D sweeps all that is within r of a rectangle: by
    /// Steiner's formula `2 L D r + π r² (L + D) + 4/3 π r³`.
    #[test]
    fn a_cable_that_is_moved_sideways_sweeps_what_is_within_its_radius_of_a_rectangle() {
        let (l, d, r) = (0.1, 0.05, 0.004);
        let expected = 2.0 * l * d * r + PI * r * r * (l + d) + 4.0 / 3.0 * PI * r.powi(3);
        let (along, aside) = (Vector::new(0.8, 0.6, 0.0), Vector::new(-0.36, 0.48, 0.8));
        let start = Vector::new(0.013, -0.007, 0.0021);
        let errors: Vec<f64> = [r / 2.0, r / 4.0]
            .into_iter()
            .map(|cell| {
                let mut envelope = Envelope::new(cell, &[vec![r; 7]]);
                for k in 0..=5 {
                    let at = start + aside * (d * f64::from(k) / 5.0);
                    envelope.sweep(&[straight(at, at + along * l, 7)]).expect("it finds room");
                }
                let surface = envelope.surface();
                let mesh = Mesh::new(&surface, false).expect("it is closed, and every edge has two triangles");
                assert!(mesh.notes().is_empty(), "{:?}", mesh.notes());
                let middle = start + along * (0.5 * l) + aside * (0.5 * d);
                let deep = mesh.distance(&middle, 1.0);
                assert!((deep + r).abs() < 0.1 * cell, "{deep} m at the middle");
                (volume(&surface) - expected) / expected
            })
            .collect();
        // What is cut off the round sides goes with the square of the cells.
        assert!(errors[0] < 0.0 && errors[0] > -0.02, "{errors:?}");
        assert!(errors[1] < 0.0 && errors[1] > 0.35 * errors[0], "{errors:?}");
    }

    /// A straight cable that is thicker along a part of it, and stands still: what is beside the thin part is free.
    #[test]
    fn a_cable_sweeps_with_the_thickness_that_it_has_there() {
        let mut envelope = Envelope::new(0.0005, &[vec![0.002, 0.002, 0.006, 0.006, 0.002, 0.002]]);
        envelope.sweep(&[straight(Vector::zeros(), Vector::x() * 0.12, 6)]).expect("it finds room");
        let mesh = Mesh::new(&envelope.surface(), false).expect("it is closed, and every edge has two triangles");
        for (x, radius) in [(0.01, 0.002), (0.06, 0.006), (0.11, 0.002)] {
            let above = mesh.distance(&Vector::new(x, 0.0, 0.008), 1.0);
            assert!((above - (0.008 - radius)).abs() < 0.0002, "{above} m above {x} m");
        }
    }

    /// Cables that turn, cross each other, slide along themselves and stand still; thin ones are drawn thicker.
    #[test]
    fn what_is_swept_is_closed_whatever_the_motion() {
        for seed in 0..20 {
            let mut rng = fastrand::Rng::with_seed(seed);
            let mut point = |size: f64| Vector::from_fn(|_, _| size * (rng.f64() - 0.5));
            let mut lines: Vec<Vec<Vector>> = (0..3).map(|_| straight(point(0.1), point(0.1), 6)).collect();
            let radii = [0.003, 0.0005, 0.005];
            let mut envelope = Envelope::new(0.002, &radii.map(|radius| vec![radius; 6]));
            envelope.sweep(&lines).expect("it finds room");
            for _ in 0..4 {
                lines[0].iter_mut().for_each(|x| *x += point(0.02));
                let along = (lines[1][6] - lines[1][0]) * 0.1;
                lines[1].iter_mut().for_each(|x| *x += along);
                envelope.sweep(&lines).expect("it finds room");
            }
            let surface = envelope.surface();
            let mesh = Mesh::new(&surface, false).unwrap_or_else(|fault| panic!("seed {seed}: {fault}"));
            for (line, radius) in lines.iter().zip(radii) {
                let least = radius.max(0.002) - 0.001;
                for x in line {
                    let distance = mesh.distance(x, 1.0);
                    assert!(distance < -least, "seed {seed}: {distance} m at a node of a cable of {radius} m");
                }
            }
            assert!(volume(&surface) > 0.0);
        }
    }

    /// Two cables one after the other in one envelope, and each in an envelope of its own, added in both orders.
    #[test]
    fn envelopes_add_up_in_any_order() {
        let one = straight(Vector::zeros(), Vector::new(0.1, 0.02, 0.0), 5);
        let moved: Vec<Vector> = one.iter().map(|x| x + Vector::new(0.0, 0.01, 0.03)).collect();
        let other = straight(Vector::new(0.05, -0.04, 0.01), Vector::new(0.06, 0.05, 0.0), 5);
        let mut both = Envelope::new(0.002, &[vec![0.004; 5]]);
        let mut apart = [Envelope::new(0.002, &[vec![0.004; 5]]), Envelope::new(0.002, &[vec![0.006; 5]])];
        for line in [&one, &moved] {
            both.sweep(std::slice::from_ref(line)).expect("it finds room");
            apart[0].sweep(std::slice::from_ref(line)).expect("it finds room");
        }
        both.begin(&[vec![0.006; 5]]);
        both.sweep(std::slice::from_ref(&other)).expect("it finds room");
        apart[1].sweep(std::slice::from_ref(&other)).expect("it finds room");
        for order in [[0, 1], [1, 0]] {
            let mut sum = Envelope::new(0.002, &[]);
            for k in order {
                for (place, phi) in apart[k].blocks() {
                    sum.add_block(place, phi).expect("it finds room");
                }
            }
            assert_eq!(sum.surface(), both.surface());
        }
        let mesh = Mesh::new(&both.surface(), false).expect("closed");
        assert!(mesh.distance(&Vector::new(0.05, 0.01, 0.0), 1.0) < 0.0 && mesh.distance(&other[1], 1.0) < 0.0);
        // No patch leads from the one cable to the other.
        assert!(mesh.distance(&Vector::new(0.02, -0.03, 0.005), 1.0) > 0.01);
    }

    #[test]
    fn cells_that_are_too_small_for_any_machine_are_refused() {
        let line = straight(Vector::zeros(), Vector::x(), 1);
        let swept =
            |most: usize| Envelope { most, ..Envelope::new(0.01, &[vec![0.05]]) }.sweep(std::slice::from_ref(&line));
        assert_eq!((swept(10), swept(1000)), (Err(TooFine { cell: 0.01 }), Ok(())));
    }
}
