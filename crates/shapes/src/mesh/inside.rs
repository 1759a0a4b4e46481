//! Octree of the regions inside and outside a closed surface, so that far from the surface no search for it is needed.

use crate::tree::Corners;
use wireloom_core::Vector;

/// Number of times that the box about the body is halved along each axis.
const DEEPEST: usize = 6;

/// A cube.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cube {
    Outside,
    Inside,
    /// The surface may be in it.
    Mixed,
    /// The first of its eight parts.
    Divided(u32),
}

/// A cube about the body, divided where the surface is.
pub(super) struct Regions {
    middle: Vector,
    half: f64,
    cubes: Vec<Cube>,
}

/// Region of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Region {
    /// Outside.
    Outside,
    /// Inside.
    Inside,
    /// The surface is no further away than this, m.
    Near(f64),
}

impl Regions {
    /// By the signed distance φ(x, reach), which is any number above `reach`, or below −`reach`, further away.
    pub fn of([low, high]: Corners, signed_distance: impl Fn(&Vector) -> f64) -> Self {
        let mut regions = Self {
            middle: (low + high) * 0.5,
            half: 0.5 * (high - low).max() * (1.0 + 1e-9),
            cubes: vec![Cube::Mixed],
        };
        regions.divide(0, regions.middle, regions.half, 0, &signed_distance);
        regions
    }

    fn divide(
        &mut self,
        cube: usize,
        middle: Vector,
        half: f64,
        depth: usize,
        signed_distance: &impl Fn(&Vector) -> f64,
    ) {
        let distance = signed_distance(&middle);
        // Half the diagonal, and a little for round-off.
        if distance.abs() > half * 1.7321 {
            self.cubes[cube] = if distance > 0.0 { Cube::Outside } else { Cube::Inside };
        } else if depth < DEEPEST {
            let first = self.cubes.len();
            self.cubes[cube] = Cube::Divided(first as u32);
            self.cubes.extend([Cube::Mixed; 8]);
            for k in 0..8 {
                self.divide(first + k, middle + eighth(k) * (0.5 * half), 0.5 * half, depth + 1, signed_distance);
            }
        }
    }

    /// Region that a point is in.
    pub fn at(&self, x: &Vector) -> Region {
        let (mut middle, mut half) = (self.middle, self.half);
        if (x - middle).amax() > half || x.iter().any(|c| c.is_nan()) {
            return Region::Outside;
        }
        let mut cube = self.cubes[0];
        loop {
            match cube {
                Cube::Outside => return Region::Outside,
                Cube::Inside => return Region::Inside,
                // Of the centre of a smallest cube it is no further than half its diagonal, of any other point of it
                // twice that.
                Cube::Mixed => return Region::Near(half * 2.0 * 1.7321),
                Cube::Divided(first) => {
                    let side = |k: usize| usize::from(x[k] >= middle[k]) << k;
                    let k = side(0) | side(1) | side(2);
                    half *= 0.5;
                    middle += eighth(k) * half;
                    cube = self.cubes[first as usize + k];
                }
            }
        }
    }
}

fn eighth(k: usize) -> Vector {
    let side = |axis: usize| if k >> axis & 1 == 1 { 1.0 } else { -1.0 };
    Vector::new(side(0), side(1), side(2))
}
