//! A rod that runs through a joint as if it were not there: the variation of curvature of the two pairs of couplings
//! ([`crate::variation`]) around the one across the joint.

use crate::kernel::{BendTwist, rotation_matrix};
use crate::variation::Variation;
use wireloom_core::{Matrix, Rotation, Vector};

/// The four frames at the joint: the first segments of both arms, then the second ones.
const FRAMES: usize = 4;

/// Frames along the rod, as indices of those of the joint: in along the first arm, out along the second one.
const ALONG: [usize; FRAMES] = [2, 0, 1, 3];

/// The rod at a joint.
pub(super) struct ContinuedRod {
    /// What the frames of the first and of the second arm are multiplied by to run along the rod.
    pub(super) senses: [Rotation; 2],
    /// Length λ of the couplings along the rod, m: before the joint, across it, after it.
    pub(super) lengths: [f64; 3],
    /// κ° of each, 1/m.
    pub(super) curvatures: [Vector; 3],
    /// C: diag(EI1, EI2, GJ), N m².
    pub(super) stiffness: Vector,
    /// f.
    pub(super) variation: f64,
}

impl ContinuedRod {
    /// Rotation of a frame along the rod.
    fn sense(&self, place: usize) -> &Rotation {
        &self.senses[place / 2]
    }

    /// The couplings along the rod.
    fn couplings(&self, frames: &[Rotation]) -> [BendTwist; 3] {
        let along: [Rotation; FRAMES] = std::array::from_fn(|place| frames[ALONG[place]] * self.sense(place));
        std::array::from_fn(|c| {
            BendTwist::new(&along[c], &along[c + 1], self.lengths[c], &self.stiffness, &self.curvatures[c])
        })
    }

    /// Variation of the couplings c and c + 1; they share their cells with the pairs beside them.
    fn pair(&self, couplings: &[BendTwist; 3], c: usize) -> Variation {
        let lengths = [self.lengths[c], self.lengths[c + 1]];
        Variation::new([&couplings[c], &couplings[c + 1]], lengths, [0.5; 2], self.variation, &self.stiffness)
    }

    /// Energy, J.
    pub(super) fn energy(&self, frames: &[Rotation]) -> f64 {
        let couplings = self.couplings(frames);
        let of_pair = |c| {
            let (bend, twist) = self.pair(&couplings, c).energy();
            bend + twist
        };
        of_pair(0) + of_pair(1)
    }

    /// Adds ∂E/∂θ of the frames (N m, body axes); returns the energy, J.
    pub(super) fn add_gradient(&self, frames: &[Rotation], gradient: &mut [Vector]) -> f64 {
        let couplings = self.couplings(frames);
        let mut energy = 0.0;
        for c in 0..2 {
            let pair = self.pair(&couplings, c);
            let (bend, twist) = pair.energy();
            energy += bend + twist;
            for (k, moment) in (c..).zip(pair.moments()) {
                let (a, b) = couplings[k].with_moment(moment).gradient();
                gradient[ALONG[k]] += self.sense(k) * a;
                gradient[ALONG[k + 1]] += self.sense(k + 1) * b;
            }
        }
        energy
    }

    /// Adds ∂²E/∂θ∂θ of the frames to a table of rows by columns, rows not before columns (N m).
    pub(super) fn add_hessian(&self, frames: &[Rotation], hessian: &mut [Matrix]) {
        let couplings = self.couplings(frames);
        let turns: [Matrix; FRAMES] = std::array::from_fn(|place| rotation_matrix(self.sense(place)));
        let mut add = |row: usize, column: usize, block: Matrix| {
            let block = turns[row] * block * turns[column].transpose();
            let (row, column) = (ALONG[row], ALONG[column]);
            if row >= column {
                hessian[row * FRAMES + column] += block;
            } else {
                hessian[column * FRAMES + row] += block.transpose();
            }
        };
        for c in 0..2 {
            let pair = self.pair(&couplings, c);
            let [aa, ab, bb] = pair.hessian();
            for (k, (moment, second)) in (c..).zip(pair.moments().into_iter().zip([aa, bb])) {
                let lambda = self.lengths[k];
                let h = couplings[k].with_moment(moment).hessian_with(&(second / lambda));
                add(k, k, h.aa);
                add(k, k + 1, h.ab);
                add(k + 1, k + 1, h.bb);
            }
            let [outer, inner] = couplings[c].hessian_across(&couplings[c + 1], &ab);
            add(c, c + 1, outer[0]);
            add(c, c + 2, outer[1]);
            add(c + 1, c + 1, inner[0] + inner[0].transpose());
            add(c + 1, c + 2, inner[1]);
        }
    }
}
