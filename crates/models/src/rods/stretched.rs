//! Laws of stretch of rods on the staggered grid: an energy `ℓ W(Γ)` in every segment, beside what is linear in it and
//! what holds frames to edges.
//!
//! Its derivatives are those of a linear segment with the force `∂W` and the stiffness `∂²W` in place of C Γ and C. As
//! the strain of a segment is that at its middle to fourth order, so is the force of the law.

use crate::kernel::{BlendedStretchShear, StretchShear};
use crate::rods::staggered::StaggeredRod;
use wireloom_core::constitutive::Point;
use wireloom_core::rod::{Beside, BranchHessian, BranchShape};
use wireloom_core::{Matrix, Vector};

/// A segment with the force of a law, and no other.
pub struct Stretched<'s> {
    /// Its index.
    pub segment: usize,
    /// W, J/m.
    energy: f64,
    /// ∂²W, N.
    tangent: Matrix,
    geometry: Geometry<'s>,
}

#[expect(clippy::large_enum_variant, reason = "one at a time is used, and none is kept")]
enum Geometry<'s> {
    Plain(StretchShear),
    /// Beside a station, with its index in [`wireloom_core::rod::Mesh::beside`].
    Beside(usize, &'s Beside, BlendedStretchShear),
}

/// Every segment of a rod in this shape under a law: with its index and its strain Γ.
pub fn all<'s>(
    rod: &'s StaggeredRod,
    shape: &'s BranchShape<'_>,
    law: impl Fn(usize, &Vector) -> Point + Copy + 's,
) -> impl Iterator<Item = Stretched<'s>> + 's {
    let plain = rod.plain().map(move |segment| {
        let own = rod.segment(shape, segment);
        let Point { energy, gradient, hessian } = law(segment, &own.strain());
        Stretched { segment, energy, tangent: hessian, geometry: Geometry::Plain(own.with_force(gradient)) }
    });
    let beside = rod.all_blended(shape).enumerate().map(move |(index, (beside, own))| {
        let Point { energy, gradient, hessian } = law(beside.segment, &own.strain());
        let geometry = Geometry::Beside(index, beside, own.with_force(gradient));
        Stretched { segment: beside.segment, energy, tangent: hessian, geometry }
    });
    plain.chain(beside)
}

/// Γ of every segment of a rod in this shape.
pub fn strains(rod: &StaggeredRod, shape: &BranchShape<'_>, strains: &mut [Vector]) {
    for j in rod.plain() {
        strains[j] = rod.segment(shape, j).strain();
    }
    for (beside, own) in rod.all_blended(shape) {
        strains[beside.segment] = own.strain();
    }
}

impl Stretched<'_> {
    /// Its energy, J.
    pub fn energy(&self, l: f64) -> f64 {
        self.energy * l
    }

    /// Adds its derivatives, times a factor; `segment_frame` is the index of its frame.
    pub fn add_gradient(
        &self,
        [l, factor]: [f64; 2],
        segment_frame: usize,
        points: &mut [Vector],
        frames: &mut [Vector],
    ) {
        let j = self.segment;
        let (force, moment) = match &self.geometry {
            Geometry::Plain(own) => own.gradient(l),
            Geometry::Beside(_, beside, own) => {
                let (force, moment, at_neighbours) = own.gradient(l);
                for (frame, moment) in beside.neighbours().iter().zip(at_neighbours) {
                    if let Some(c) = frame {
                        frames[*c] += moment * factor;
                    }
                }
                (force, moment)
            }
        };
        points[j] -= force * factor;
        points[j + 1] += force * factor;
        frames[segment_frame] += moment * factor;
    }

    /// Adds its second derivatives; with `geometric` those of its force, too.
    pub fn add_hessian(&self, l: f64, geometric: bool, hessian: &mut BranchHessian) {
        let of = |n: &Vector| if geometric { *n } else { Vector::zeros() };
        let own = match &self.geometry {
            Geometry::Plain(own) => own.hessian_with(l, &of(&own.n), &self.tangent),
            Geometry::Beside(index, _, own) => {
                let (own, neighbours) = own.hessian_with(l, &of(&own.n), &self.tangent);
                let room = &mut hessian.beside[*index];
                for k in 0..2 {
                    room.se[k] += neighbours.se[k];
                    room.st[k] += neighbours.st[k];
                    room.ss[k] += neighbours.ss[k];
                }
                room.s1s0 += neighbours.s1s0;
                own
            }
        };
        let room = &mut hessian.segments[self.segment];
        room.ee += own.ee;
        room.te += own.te;
        room.tt += own.tt;
    }

    /// `∂²E/∂e²`, N/m.
    pub fn edge_stiffness(&self, l: f64) -> Matrix {
        match &self.geometry {
            Geometry::Plain(own) => own.r * self.tangent * own.r.transpose() / l,
            Geometry::Beside(_, _, own) => own.edge_stiffness_with(l, &self.tangent),
        }
    }

    /// Its force to first order after a step of its edge and of the frames, N, body frame.
    pub fn predicted_force(&self, l: f64, de: &Vector, theta: &Vector, frames: &[Vector]) -> Vector {
        match &self.geometry {
            Geometry::Plain(own) => own.n + self.tangent * own.strain_change(l, de, theta),
            Geometry::Beside(_, beside, own) => {
                let at_neighbours = beside.neighbours().map(|c| c.map_or_else(Vector::zeros, |c| frames[c]));
                own.n + self.tangent * own.strain_change(l, de, theta, at_neighbours)
            }
        }
    }

    /// Its force, N, world.
    pub fn world_force(&self) -> Vector {
        match &self.geometry {
            Geometry::Plain(own) => own.r * own.n,
            Geometry::Beside(_, _, own) => own.world_force(),
        }
    }

    /// Its moments on the neighbours, N m: what [`StaggeredRod`] adds to those of couplings.
    pub fn at_neighbours(&self, l: f64) -> Option<([Option<usize>; 2], [Vector; 2])> {
        match &self.geometry {
            Geometry::Plain(_) => None,
            Geometry::Beside(_, beside, own) => Some((beside.neighbours(), own.gradient(l).2)),
        }
    }

    /// `[∂E/∂ℓ, ∂²E/∂ℓ²]` with the edge and the frames fixed: `W − n·v` and `vᵀ T v/ℓ`.
    pub fn length_terms(&self, l: f64) -> [f64; 2] {
        let (n, v) = match &self.geometry {
            Geometry::Plain(own) => (own.n, &own.v),
            Geometry::Beside(_, _, own) => (own.n, own.corrected()),
        };
        [self.energy - n.dot(v), v.dot(&(self.tangent * v)) / l]
    }

    /// The segment whose derivatives are those of its own in ℓ.
    pub fn per_length(self, l: f64) -> Self {
        let geometry = match self.geometry {
            Geometry::Plain(own) => {
                let change = self.tangent * own.v / -l;
                Geometry::Plain(own.with_force(change))
            }
            Geometry::Beside(index, beside, own) => {
                let change = self.tangent * own.corrected() / -l;
                Geometry::Beside(index, beside, own.with_force(change))
            }
        };
        Self { geometry, ..self }
    }
}
