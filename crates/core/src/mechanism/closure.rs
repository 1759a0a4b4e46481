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
/// Ratio of singular values below which a freedom of a loop is not determined: beside a dead point the branches of the
/// motion are too near to each other to be told apart.
const UNDETERMINED: f64 = 1e-5;
/// Largest error of the straight continuation of a way to its next knot, relative to the change of the values: where
/// branches of the motion cross, the right one is nearest to it.
const STRAY: f64 = 0.25;
/// Error of the continuation that is round-off, rad; of a length, relative to the mechanism.
const ROUND_OFF: f64 = 1e-9;

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
    #[error("from {fraction} of the step the value of joint {joint} does not follow ({missing} freedoms are open)")]
    Open {
        /// Index of the joint.
        joint: usize,
        /// Fraction of the step.
        fraction: f64,
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
    /// A freedom of a joint (by index) passes a limit.
    #[error("freedom {freedom} of joint {joint} reaches {value} at {fraction} of the step, and its limit is {limit}")]
    Limit {
        /// Index of the joint.
        joint: usize,
        /// Which of its freedoms.
        freedom: usize,
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
        let mut t = 0.0;
        while t < 1.0 {
            let corner = way.corners.iter().copied().find(|corner| *corner > t).unwrap_or(1.0);
            let rates = self.rates(&way, from, driven, corner)?;
            let mut next = corner;
            let values = loop {
                match self.knot(&way, from, driven, &rates, next) {
                    Some(values) => break values,
                    None if next - t < SMALLEST => {
                        let joint = self.loops[way.loops.first().copied().unwrap_or_default()].0;
                        let ahead = self.closed(&way, self.guess(&way, from, driven, &rates, 1.0));
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

    /// Upper bound of the turns of any body from fraction `a` of the step to fraction `b`.
    pub fn turned(&self, way: &Way, a: f64, b: f64) -> f64 {
        let inside = way.knots.iter().filter(|(t, _)| a < *t && *t < b).map(|(_, values)| values.clone());
        let passed: Vec<Vec<f64>> = std::iter::once(self.at(way, a)).chain(inside).chain([self.at(way, b)]).collect();
        let change = |f: usize| passed.windows(2).map(|pair| (pair[1][f] - pair[0][f]).abs()).sum::<f64>();
        let of_joint = |k: usize| self.freedoms_of(k).filter(|f| !self.is_length(*f)).map(change).sum::<f64>();
        let of_body = |body: usize| self.way_to(body).into_iter().map(of_joint).sum::<f64>();
        (0..self.bodies.len()).map(of_body).fold(0.0, f64::max) / std::f64::consts::TAU
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

    /// Rates of the unknown freedoms beyond the last knot, per step: with J the derivatives of the loops,
    /// `J_u q̇_u = −J_d q̇_d`. At a dead point, where that does not determine them, a way goes straight on; it cannot
    /// begin or turn there.
    fn rates(&self, way: &Way, start: &[f64], driven: &[Driven], corner: f64) -> Result<Vec<f64>, WayFault> {
        let known = way.knots.len();
        let (now, last) = &way.knots[known - 1];
        if way.unknown.is_empty() {
            return Ok(Vec::new());
        }
        let (_, by_unknown) = self.equations(way, last, &way.unknown);
        let Some((joint, missing)) = self.undetermined(way, &by_unknown) else {
            let freedoms: Vec<usize> = driven.iter().map(|d| d.freedom).collect();
            let (_, by_driven) = self.equations(way, last, &freedoms);
            let rate = |d: &Driven| {
                let scale = if self.is_length(d.freedom) { self.size() } else { 1.0 };
                (d.at(start[d.freedom], corner) - last[d.freedom]) / ((corner - now) * scale)
            };
            let drive = DVector::from_iterator(driven.len(), driven.iter().map(rate));
            let rates =
                shortest(&by_unknown, &-(by_driven * drive)).unwrap_or_else(|| DVector::zeros(way.unknown.len()));
            let scaled = |(f, rate): (&usize, &f64)| rate * if self.is_length(*f) { self.size() } else { 1.0 };
            return Ok(way.unknown.iter().zip(rates.iter()).map(scaled).collect());
        };
        if known == 1 || way.corners.contains(now) {
            return Err(WayFault::Open { joint, fraction: *now, missing });
        }
        let (before, earlier) = &way.knots[known - 2];
        Ok(way.unknown.iter().map(|&f| (last[f] - earlier[f]) / (now - before)).collect())
    }

    /// Values at a fraction from which Newton's method starts: driven ones as they are, the others continued straight
    /// from the last knot.
    fn guess(&self, way: &Way, start: &[f64], driven: &[Driven], rates: &[f64], t: f64) -> Vec<f64> {
        let (now, last) = &way.knots[way.knots.len() - 1];
        let mut values = last.clone();
        for (&f, rate) in way.unknown.iter().zip(rates) {
            values[f] += rate * (t - now);
        }
        for d in driven {
            values[d.freedom] = d.at(start[d.freedom], t);
        }
        for (k, joint) in self.joints.iter().enumerate() {
            if let Some((of, factor)) = joint.follows {
                let [drawn, leads] = [k, of].map(|joint| self.joints[joint].drawn[0]);
                values[self.starts[k]] = drawn + factor * (values[self.starts[of]] - leads);
            }
        }
        values
    }

    /// The next knot, if it is near enough to the last and to the straight continuation, and the loops close there and
    /// half-way.
    fn knot(&self, way: &Way, start: &[f64], driven: &[Driven], rates: &[f64], t: f64) -> Option<Vec<f64>> {
        let (_, last) = way.knots.last()?;
        let guess = self.guess(way, start, driven, rates, t);
        if way.loops.is_empty() {
            return Some(guess);
        }
        let size = self.size();
        let apart = |a: &[f64], b: &[f64]| {
            let change = |f: usize| (a[f] - b[f]).abs() / if self.is_length(f) { size } else { 1.0 };
            (0..a.len()).map(change).fold(0.0, f64::max)
        };
        if apart(&guess, last) > KNOT {
            return None;
        }
        let closes = |values: Vec<f64>| {
            let values = self.closed(way, values);
            let is_closed = self.equations(way, &values, &[]).0.amax() <= CLOSED;
            (is_closed && apart(&values, last) <= KNOT).then_some(values)
        };
        let values = closes(guess.clone())?;
        closes(between(last, &values, 0.5))?;
        (apart(&values, &guess) <= STRAY * apart(&values, last) + ROUND_OFF).then_some(values)
    }

    /// The values with which the loops close, from values near them.
    fn closed(&self, way: &Way, mut values: Vec<f64>) -> Vec<f64> {
        if way.unknown.is_empty() {
            return values;
        }
        let size = self.size();
        let (mut residual, mut jacobian) = self.equations(way, &values, &way.unknown);
        for _ in 0..ITERATIONS {
            let Some(step) = shortest(&jacobian, &residual) else { break };
            let mut next = values.clone();
            for (k, &f) in way.unknown.iter().enumerate() {
                next[f] -= step[k] * if self.is_length(f) { size } else { 1.0 };
            }
            let (left, slopes) = self.equations(way, &next, &way.unknown);
            if left.amax() >= residual.amax() && residual.amax() <= CLOSED {
                break;
            }
            (values, residual, jacobian) = (next, left, slopes);
        }
        values
    }

    /// Residuals of the loops (rad, and m relative to the size of the mechanism), and their derivatives by some
    /// freedoms; lengths among these are relative too. Exact where the loops are closed.
    fn equations(&self, way: &Way, values: &[f64], freedoms: &[usize]) -> (DVector<f64>, DMatrix<f64>) {
        let size = self.size();
        let poses = self.poses(values);
        let twists = self.twists(values, &poses);
        let mut residual = DVector::zeros(6 * way.loops.len());
        let mut jacobian = DMatrix::zeros(6 * way.loops.len(), freedoms.len());
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
            for (column, &f) in freedoms.iter().enumerate() {
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

    /// The joint whose value the loops leave most open, and the number of open freedoms, from the derivatives of the
    /// loops by the unknown freedoms.
    fn undetermined(&self, way: &Way, jacobian: &DMatrix<f64>) -> Option<(usize, usize)> {
        // JᵀJ has the squares of the singular values, and an eigenvector for each freedom that nothing determines.
        let eigen = (jacobian.transpose() * jacobian).symmetric_eigen();
        let open = UNDETERMINED.powi(2) * eigen.eigenvalues.max();
        let missing = eigen.eigenvalues.iter().filter(|value| **value <= open.max(f64::EPSILON)).count();
        let most = eigen.eigenvectors.column(eigen.eigenvalues.imin()).icamax();
        (missing > 0).then(|| (self.joint_of(way.unknown[most]), missing))
    }

    /// Largest distance, m, and angle, rad, by which the loops are open.
    fn apart(&self, way: &Way, values: &[f64]) -> (f64, f64) {
        let (residual, _) = self.equations(way, values, &[]);
        let of = |first: usize| {
            let parts = (0..way.loops.len()).map(|row| residual.fixed_rows::<3>(6 * row + first).norm());
            parts.fold(0.0, f64::max)
        };
        (of(3) * self.size(), of(0))
    }

    /// The first limit that a joint passes; one that is beyond a limit may come back.
    fn passed_limit(&self, way: &Way) -> Option<WayFault> {
        for pair in way.knots.windows(2) {
            for f in 0..self.freedoms() {
                let joint = self.joint_of(f);
                let freedom = f - self.starts[joint];
                let [low, high] = self.joints[joint].limits[freedom];
                let (before, value) = (pair[0].1[f], pair[1].1[f]);
                let limit = match () {
                    () if value > high && value > before => high,
                    () if value < low && value < before => low,
                    () => continue,
                };
                return Some(WayFault::Limit { joint, freedom, fraction: pair[1].0, value, limit });
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
