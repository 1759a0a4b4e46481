//! Ways of mechanisms: values of all joints while some of them are driven.
//!
//! A joint between bodies a and b that closes a loop asks that both ways from the ground lead to the same pose,
//! `B_a M(q) = B_b`: six equations for the values of the joints that are not driven. They are solved by Newton's
//! method; a step is the shortest solution of the linear equations, as a planar loop in space has more equations than
//! it needs. Joints outside of driven loops keep their values.

use super::{Mechanism, Twist};
use crate::{Pose, Vector};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Largest change of an angle from one knot of a way to the next, rad; of a length, relative to the mechanism.
const KNOT: f64 = 0.05;
/// Smallest part of a way between knots: below it, it leads no further.
const SMALLEST: f64 = 1e-7;
/// Iterations of Newton's method: from a neighbouring knot it takes four or five.
const ITERATIONS: usize = 20;
/// Residual of a closed loop, relative to the mechanism: some hundred times round-off.
const CLOSED: f64 = 1e-13;
/// Ratio of singular values below which a freedom of a loop is not determined.
const UNDETERMINED: f64 = 1e-7;

/// Values of all freedoms of a mechanism over a step. Between knots driven values are interpolated linearly, and the
/// others are solved for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Way {
    /// Fractions of the step, from 0 to 1, and the values there.
    knots: Vec<(f64, Vec<f64>)>,
    /// Fractions of the step at which a driven value has a corner.
    corners: Vec<f64>,
    /// Freedoms that are solved for.
    unknown: Vec<usize>,
    /// Loops that are solved.
    loops: Vec<usize>,
}

impl Way {
    /// Values at the end.
    pub fn end(&self) -> &[f64] {
        self.knots.last().map_or(&[], |(_, values)| values)
    }

    /// Fractions of the step, without its start and end, at which a driven value has a corner.
    pub fn corners(&self) -> &[f64] {
        &self.corners
    }
}

/// The values that a freedom takes over a step: fractions of the step (increasing, at most 1), and its values there;
/// in between linear, from the present value on.
#[derive(Clone, Debug, PartialEq)]
pub struct Driven {
    /// The freedom.
    pub freedom: usize,
    /// Fractions and values.
    pub through: Vec<(f64, f64)>,
}

impl Driven {
    /// Value at a fraction of the step; `start`: that at its beginning.
    pub fn at(&self, start: f64, t: f64) -> f64 {
        let next = self.through.partition_point(|knot| knot.0 < t);
        let (from, a) = if next == 0 { (0.0, start) } else { self.through[next - 1] };
        match self.through.get(next) {
            Some(&(to, b)) if t >= to => b,
            Some(&(to, b)) => a + (b - a) * ((t - from) / (to - from)),
            None => a,
        }
    }
}

/// Why a mechanism cannot be driven so.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WayFault {
    /// The loops of the driven joints leave the value of a joint (by index) open.
    #[error("the value of joint {joint} does not follow from the driven ones ({missing} freedoms are open)")]
    Open {
        /// Index of the joint.
        joint: usize,
        /// Number of freedoms that would have to be driven too.
        missing: usize,
    },
    /// A loop, closed by a joint (by index), cannot be closed beyond a fraction of the step.
    #[error("the loop of joint {joint} does not close beyond {fraction} of the step")]
    Parted {
        /// Index of the joint that closes the loop.
        joint: usize,
        /// Fraction of the step that is reached.
        fraction: f64,
        /// Distance, m, and angle, rad, that remain at the step's end.
        apart: (f64, f64),
    },
    /// A joint (by index) passes a limit.
    #[error("joint {joint} reaches {value} at {fraction} of the step, and its limit is {limit}")]
    Limit {
        /// Index of the joint.
        joint: usize,
        /// Fraction of the step.
        fraction: f64,
        /// Value there.
        value: f64,
        /// The limit.
        limit: f64,
    },
}

impl Mechanism {
    /// The way from the present values, of which some are driven.
    ///
    /// # Errors
    /// If the driven values do not determine the others, do not allow the loops to close, or a joint passes a limit
    /// that it is not beyond already.
    pub fn way(&self, from: &[f64], driven: &[Driven]) -> Result<Way, WayFault> {
        let (unknown, loops) = self.unknowns(driven);
        let mut corners: Vec<f64> = driven.iter().flat_map(|d| d.through.iter().map(|knot| knot.0)).collect();
        corners.retain(|t| 0.0 < *t && *t < 1.0);
        corners.sort_by(f64::total_cmp);
        corners.dedup();
        let mut way = Way { knots: vec![(0.0, from.to_vec())], corners, unknown, loops };
        if let Some(fault) = self.undetermined(&way, from) {
            return Err(fault);
        }
        let mut t = 0.0;
        while t < 1.0 {
            let corner = way.corners.iter().copied().find(|corner| *corner > t).unwrap_or(1.0);
            let mut next = corner;
            let values = loop {
                match self.knot(&way, from, driven, next) {
                    Some(values) => break values,
                    None if next - t < SMALLEST => {
                        let joint = self.loops[way.loops.first().copied().unwrap_or_default()].0;
                        let ahead = self.closed(&way, self.guess(&way, from, driven, 1.0));
                        let apart = self.apart(&way, &ahead);
                        return Err(WayFault::Parted { joint, fraction: t, apart });
                    }
                    None => next = t + 0.5 * (next - t),
                }
            };
            t = next;
            way.knots.push((t, values));
        }
        self.passed_limit(&way).map_or(Ok(way), Err)
    }

    /// Values at a fraction of the step.
    pub fn at(&self, way: &Way, t: f64) -> Vec<f64> {
        let next = way.knots.partition_point(|knot| knot.0 <= t);
        let (from, a) = &way.knots[next.saturating_sub(1)];
        match way.knots.get(next) {
            Some((to, b)) if t > *from => self.closed(way, between(a, b, (t - from) / (to - from))),
            _ => a.clone(),
        }
    }

    /// Freedoms that follow from the driven ones, and the loops that they are solved from: those that share a joint
    /// with a driven one, directly or through other loops.
    fn unknowns(&self, driven: &[Driven]) -> (Vec<usize>, Vec<usize>) {
        let mut moves = vec![false; self.joints.len()];
        for d in driven {
            moves[self.joint_of(d.freedom)] = true;
        }
        let mut loops = vec![false; self.loops.len()];
        while let Some(k) = (0..loops.len()).find(|k| !loops[*k] && self.loops[*k].1.iter().any(|j| moves[*j])) {
            loops[k] = true;
            self.loops[k].1.iter().for_each(|joint| moves[*joint] = true);
        }
        let in_loop = |joint: usize| (0..loops.len()).any(|k| loops[k] && self.loops[k].1.contains(&joint));
        let is_driven = |freedom: usize| driven.iter().any(|d| d.freedom == freedom);
        let unknown = (0..self.freedoms()).filter(|f| in_loop(self.joint_of(*f)) && !is_driven(*f));
        (unknown.collect(), (0..loops.len()).filter(|k| loops[*k]).collect())
    }

    /// Values at a fraction from which Newton's method starts: driven ones as they are, the others continued from the
    /// last knots.
    fn guess(&self, way: &Way, start: &[f64], driven: &[Driven], t: f64) -> Vec<f64> {
        let known = way.knots.len();
        let (now, last) = &way.knots[known - 1];
        let mut values = last.clone();
        // Continued straight, so that a way goes on through a dead point where it can.
        if known > 1 && !way.corners.contains(now) {
            let (before, earlier) = &way.knots[known - 2];
            for &f in &way.unknown {
                values[f] += (last[f] - earlier[f]) * (t - now) / (now - before);
            }
        }
        for d in driven {
            values[d.freedom] = d.at(start[d.freedom], t);
        }
        for (k, joint) in self.joints.iter().enumerate() {
            if let Some((of, factor)) = joint.follows {
                values[self.starts[k]] = factor * values[self.starts[of]];
            }
        }
        values
    }

    /// The next knot, if it is near enough to the last and the loops close there and half-way.
    fn knot(&self, way: &Way, start: &[f64], driven: &[Driven], t: f64) -> Option<Vec<f64>> {
        let (_, last) = way.knots.last()?;
        let guess = self.guess(way, start, driven, t);
        if way.loops.is_empty() {
            return Some(guess);
        }
        let near = |values: &[f64]| {
            let size = self.size();
            let change = |f: usize| (values[f] - last[f]).abs() / if self.is_length(f) { size } else { 1.0 };
            (0..values.len()).all(|f| change(f) <= KNOT)
        };
        if !near(&guess) {
            return None;
        }
        let closes = |values: Vec<f64>| {
            let values = self.closed(way, values);
            (near(&values) && self.equations(way, &values).0.amax() <= CLOSED).then_some(values)
        };
        let values = closes(guess)?;
        closes(between(last, &values, 0.5))?;
        Some(values)
    }

    /// The values with which the loops close, from values near them.
    fn closed(&self, way: &Way, mut values: Vec<f64>) -> Vec<f64> {
        if way.unknown.is_empty() {
            return values;
        }
        let size = self.size();
        let (mut residual, mut jacobian) = self.equations(way, &values);
        for _ in 0..ITERATIONS {
            let Some(step) = shortest(&jacobian, &residual) else { break };
            let mut next = values.clone();
            for (k, &f) in way.unknown.iter().enumerate() {
                next[f] -= step[k] * if self.is_length(f) { size } else { 1.0 };
            }
            let (left, slopes) = self.equations(way, &next);
            if left.amax() >= residual.amax() && residual.amax() <= CLOSED {
                break;
            }
            (values, residual, jacobian) = (next, left, slopes);
        }
        values
    }

    /// Residuals of the loops (rad, and m relative to the size of the mechanism), and their derivatives by the unknown
    /// freedoms; lengths among these are relative too. Exact where the loops are closed.
    fn equations(&self, way: &Way, values: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let size = self.size();
        let poses = self.poses(values);
        let twists = self.twists(values, &poses);
        let mut residual = DVector::zeros(6 * way.loops.len());
        let mut jacobian = DMatrix::zeros(6 * way.loops.len(), way.unknown.len());
        for (row, &k) in way.loops.iter().enumerate() {
            let closing = self.loops[k].0;
            let joint = &self.joints[closing];
            let [a, b] = joint.bodies;
            let through = poses[a].compose(&joint.motion(&values[self.freedoms_of(closing)]));
            let [x, y] = [&through, &poses[b]].map(|pose: &Pose| pose.world(&joint.origin));
            let turned = (through.orientation * poses[b].orientation.inverse()).scaled_axis();
            residual.fixed_rows_mut::<3>(6 * row).copy_from(&turned);
            residual.fixed_rows_mut::<3>(6 * row + 3).copy_from(&((x - y) / size));
            let [way_a, way_b] = [a, b].map(|body| self.way_to(body));
            for (column, &f) in way.unknown.iter().enumerate() {
                let scale = if self.is_length(f) { size } else { 1.0 };
                let of = self.joint_of(f);
                let mut add = |sign: f64, place: &Vector| {
                    let twist = &twists[f];
                    let mut turn = jacobian.fixed_view_mut::<3, 1>(6 * row, column);
                    turn += twist.turn * (sign * scale);
                    let mut shift = jacobian.fixed_view_mut::<3, 1>(6 * row + 3, column);
                    shift += twist.at(place) * (sign * scale / size);
                };
                if of == closing || way_a.contains(&of) {
                    add(self.sign(of), &x);
                }
                if way_b.contains(&of) {
                    add(-self.sign(of), &y);
                }
            }
        }
        (residual, jacobian)
    }

    /// −1 for a joint of the tree that leads from its second body to its first.
    fn sign(&self, joint: usize) -> f64 {
        if self.tree.iter().any(|&(_, k, forward)| k == joint && !forward) { -1.0 } else { 1.0 }
    }

    /// Velocity of the second body of each freedom's joint relative to the first, in the world.
    pub(super) fn twists(&self, values: &[f64], poses: &[Pose]) -> Vec<Twist> {
        let of_joint = |k: usize| {
            let joint = &self.joints[k];
            let own = joint.twists(&values[self.freedoms_of(k)]);
            own.into_iter().map(move |twist| twist.moved(&poses[joint.bodies[0]]))
        };
        (0..self.joints.len()).flat_map(of_joint).collect()
    }

    /// The joint whose value the loops leave most open.
    fn undetermined(&self, way: &Way, values: &[f64]) -> Option<WayFault> {
        if way.unknown.is_empty() {
            return None;
        }
        let (_, jacobian) = self.equations(way, values);
        // AᵀA has the squares of the singular values, and an eigenvector for each freedom that nothing determines.
        let eigen = (jacobian.transpose() * &jacobian).symmetric_eigen();
        let open = UNDETERMINED.powi(2) * eigen.eigenvalues.max();
        let missing = eigen.eigenvalues.iter().filter(|value| **value <= open.max(f64::EPSILON)).count();
        let least = eigen.eigenvalues.imin();
        let most = eigen.eigenvectors.column(least).icamax();
        (missing > 0).then(|| WayFault::Open { joint: self.joint_of(way.unknown[most]), missing })
    }

    /// Largest distance, m, and angle, rad, by which the loops are open.
    fn apart(&self, way: &Way, values: &[f64]) -> (f64, f64) {
        let (residual, _) = self.equations(way, values);
        let of = |first: usize| {
            let parts = (0..way.loops.len()).map(|row| residual.fixed_rows::<3>(6 * row + first).norm());
            parts.fold(0.0, f64::max)
        };
        (of(3) * self.size(), of(0))
    }

    /// The first limit that a joint passes; one that is beyond a limit may come back.
    fn passed_limit(&self, way: &Way) -> Option<WayFault> {
        for pair in way.knots.windows(2) {
            for (joint, own) in self.joints.iter().enumerate() {
                let Some([low, high]) = own.limits else { continue };
                let f = self.starts[joint];
                let (before, value) = (pair[0].1[f], pair[1].1[f]);
                let limit = match () {
                    () if value > high && value > before => high,
                    () if value < low && value < before => low,
                    () => continue,
                };
                return Some(WayFault::Limit { joint, fraction: pair[1].0, value, limit });
            }
        }
        None
    }
}

/// Values at a fraction of the way from some to others.
fn between(a: &[f64], b: &[f64], fraction: f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + (b - a) * fraction).collect()
}

/// Shortest solution of linear equations that may be more than are needed.
fn shortest(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let largest = matrix.amax();
    matrix.clone().svd(true, true).solve(right, UNDETERMINED * largest).ok()
}
