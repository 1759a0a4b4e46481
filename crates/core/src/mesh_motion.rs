//! Motion of a mesh along its cable.

use crate::{Network, State, Vector};

impl Network {
    /// Moves the mesh of a branch along the cable and interpolates points and frames: `knots` (increasing nodes,
    /// including both ends) move to the given arc lengths (m), and between them the mesh keeps the proportions it was
    /// built with. Returns false, and does nothing, if the arc lengths do not increase.
    pub fn move_mesh(&self, branch: usize, knots: &[(usize, f64)], state: &mut State) -> bool {
        if knots.windows(2).any(|pair| pair[0].1 >= pair[1].1) {
            return false;
        }
        let old = state.arc_lengths(self, branch);
        let branch_index = branch;
        let branch = &self.branches[branch];
        let mesh = branch.rod.mesh();
        let built = mesh.arc_lengths();
        let mut new = old.clone();
        for pair in knots.windows(2) {
            let ((a, from), (b, to)) = (pair[0], pair[1]);
            for node in a..=b {
                let fraction = (built[node] - built[a]) / (built[b] - built[a]);
                new[node] = if node == b { to } else { from + (to - from) * fraction };
            }
        }
        let points: Vec<Vector> = branch.points.clone().map(|i| state.points[i] + state.compensation[i]).collect();
        let frames = state.frames[branch.frames.clone()].to_vec();
        let (old_places, new_places) = (mesh.frame_places(&old), mesh.frame_places(&new));
        for (node, s) in new.iter().enumerate().filter(|(node, s)| **s != old[*node]) {
            let i = branch.points.start + node;
            state.points[i] = point_at(&old, &points, *s);
            state.compensation[i] = Vector::zeros();
        }
        for (c, s) in new_places.iter().enumerate().filter(|(c, s)| **s != old_places[*c]) {
            let k = old_places.partition_point(|place| place <= s).clamp(1, frames.len() - 1);
            let fraction = (s - old_places[k - 1]) / (old_places[k] - old_places[k - 1]);
            let between = frames[k - 1].try_slerp(&frames[k], fraction.clamp(0.0, 1.0), 1e-12);
            state.frames[branch.frames.start + c] = between.unwrap_or(frames[k]);
        }
        for (j, pair) in new.windows(2).enumerate() {
            state.rest_lengths[branch.points.start + j] = pair[1] - pair[0];
        }
        self.couple(branch_index, state);
        true
    }

    /// Recomputes the coupling lengths of a branch from its rest lengths.
    pub(crate) fn couple(&self, branch: usize, state: &mut State) {
        let branch = &self.branches[branch];
        let mesh = branch.rod.mesh();
        let lengths = &state.rest_lengths[branch.points.start..][..mesh.segments()];
        mesh.couple(lengths, &mut state.coupling_lengths[branch.frames.start..][..mesh.coupling_lengths.len()]);
    }
}

/// Point at arc length `s` of a curve through `points` at arc lengths `places`: cubic Hermite interpolation with slopes
/// by central differences.
fn point_at(places: &[f64], points: &[Vector], s: f64) -> Vector {
    let last = points.len() - 1;
    let k = places.partition_point(|place| *place <= s).clamp(1, last);
    let slope = |i: usize| {
        let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
        (points[b] - points[a]) / (places[b] - places[a])
    };
    let h = places[k] - places[k - 1];
    let t = ((s - places[k - 1]) / h).clamp(0.0, 1.0);
    let (a, b) = (points[k - 1], points[k]);
    let (u, v) = (slope(k - 1) * h, slope(k) * h);
    let (t2, t3) = (t * t, t * t * t);
    a * (1.0 - 3.0 * t2 + 2.0 * t3) + b * (3.0 * t2 - 2.0 * t3) + u * (t - 2.0 * t2 + t3) + v * (t3 - t2)
}
