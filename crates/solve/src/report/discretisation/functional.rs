//! Derivatives of the functional D, which the discrete energy has beside that of the rod (see the module above).

use super::cells::Curvature;
use super::samples::Samples;
use crate::report::nodes::growth;
use crate::report::result::{mean_length, mean_rotation, others, runs_through};
use wireloom_core::joint::Arm;
use wireloom_core::network::Joint;
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::rod::BranchHessian;
use wireloom_core::rotation::columns;
use wireloom_core::{State, Tangent, Vector};

/// Fraction of a segment's load that a station passes to the next node where the scheme is of second order.
const STATION_SHIFT: f64 = 1.0 / 24.0;
/// Factor of `ℓ² Δ² x″` in what the wide stencil at a station leaves of its edge (put `x′ = exp(−a s)` into it).
const WIDE_STENCIL: f64 = 23.0 / 5760.0;
/// Coefficients of κ, κ′ ℓ and κ″ ℓ² at a station in the curvatures of the couplings at ¼ ℓ, ℓ and 2 ℓ from it.
const AT_STATION: [[f64; 3]; 3] =
    [[32.0 / 21.0, -2.0 / 3.0, 1.0 / 7.0], [-16.0 / 7.0, 3.0, -5.0 / 7.0], [32.0 / 21.0, -8.0 / 3.0, 8.0 / 7.0]];
/// Divisor of `ℓ² Δ x″` in what the narrow one leaves.
const NARROW_STENCIL: f64 = 96.0;

impl Samples<'_> {
    /// Share of the cells of its couplings that a segment has, Σ λ³/24, m³.
    fn cells(&self, j: usize) -> f64 {
        let mut share = 0.0;
        for c in self.couplings(j).into_iter().flatten() {
            let node = self.branch.rod.mesh().coupling_nodes[c];
            let others = self.branch.rod.mesh().station_frame(node).is_none();
            let other = if node == j { j.checked_sub(1) } else { Some(j + 1) };
            let is_shared = others && other.and_then(|j| *self.rate.get(j)?).is_some();
            share += self.shape.coupling_lengths[c].powi(3) / if is_shared { 48.0 } else { 24.0 };
        }
        share
    }

    /// a of a segment, m, with the offset `−ℓ Γ` of an alignment, whose part of D is `−½ ℓ n · Γ`.
    pub(super) fn edge_offset(&self, j: usize) -> Vector {
        let bends: Vector = self.offset_factors(j).map(|(of, end, factor)| self.bends[of][end] * factor).sum();
        let offset = bends + self.stretch_offset(j);
        if self.alignment == 0.0 {
            return offset;
        }
        let frame = &self.shape.frames[self.branch.rod.mesh().segment_frames[j]];
        let n = frame.inverse() * self.forces[j];
        let by_stiffness = Vector::new(n.x / self.stiffness[j].m22, n.y / self.stiffness[j].m11, 0.0);
        offset - frame * by_stiffness * (self.alignment * self.shape.rest_lengths[j].powi(3) / 12.0)
    }

    /// Part of a of a segment by the part of x″ along the cable, m: that of a change of stretch, `(ℓ²/24) ε′ x′` at its
    /// end less that at its start. In a scheme of fourth order nodes are moved by it, but for stations.
    fn stretch_offset(&self, j: usize) -> Vector {
        let (mesh, l) = (self.branch.rod.mesh(), self.shape.rest_lengths);
        let along = self.shape.edge(j);
        let at = |end: usize| {
            let node = j + end;
            let is_station = node == 0 || node == l.len() || mesh.station_frame(node).is_some();
            if self.fine[j] && !is_station { 0.0 } else { self.stretch_rate(j, end, is_station) }
        };
        along.normalize() * ((at(1) - at(0)) * l[j] * l[j] / 24.0)
    }

    /// ε′ at the start (0) or end (1) of a segment, 1/m: by the segments on both sides, at a station or an end of the
    /// branch by those of its side.
    fn stretch_rate(&self, j: usize, end: usize, is_station: bool) -> f64 {
        let (mesh, l) = (self.branch.rod.mesh(), self.shape.rest_lengths);
        let stretch = |j: usize| self.shape.edge(j).norm() / l[j];
        // At the node between a segment and the next one.
        let between = |j: usize| {
            let is_inner = j + 1 < l.len() && mesh.station_frame(j + 1).is_none();
            is_inner.then(|| (stretch(j + 1) - stretch(j)) * 2.0 / (l[j] + l[j + 1]))
        };
        let near = |steps: usize| match (end, is_station) {
            (0, true) => between(j + steps),
            (0, false) => between(j - 1),
            (_, true) => j.checked_sub(1 + steps).and_then(between),
            (_, false) => between(j),
        };
        let Some(first) = near(0) else { return 0.0 };
        if is_station { near(1).map_or(first, |second| 2.0 * first - second) } else { first }
    }

    /// Factors on x″ in a of a segment, m², that are not 0, with the segments and their ends (0 or 1) where it is
    /// taken.
    fn offset_factors(&self, j: usize) -> impl Iterator<Item = (usize, usize, f64)> {
        let mesh = self.branch.rod.mesh();
        let l = self.shape.rest_lengths;
        let square = l[j] * l[j];
        let mut factors = [[(j, 0, 0.0); 3]; 2];
        for (end, factors) in factors.iter_mut().enumerate() {
            let (node, sign) = (j + end, 2.0 * end as f64 - 1.0);
            if !self.fine[j] {
                factors[0] = (j, end, (1.0 / 24.0 - 0.5 * self.blend(j, node)) * square * sign);
                continue;
            }
            if mesh.station_frame(node).is_none() {
                let other = if end == 0 { j.checked_sub(1) } else { Some(j + 1).filter(|k| *k < l.len()) };
                let mean = other.map_or(self.joint_lengths[end], |other| 0.5 * (l[j] + l[other]));
                factors[0] = (j, end, (square - mean * mean) / 24.0 * sign);
                continue;
            }
            let beside = mesh.beside.iter().find(|beside| beside.segment == j).and_then(|beside| beside.next);
            match (beside, if end == 0 { Some(j + 1) } else { j.checked_sub(1) }) {
                (Some(_), Some(next)) => {
                    let factor = square * WIDE_STENCIL * sign;
                    *factors = [(j, end, factor), (j, 1 - end, -2.0 * factor), (next, 1 - end, factor)];
                }
                _ => {
                    let factor = square / NARROW_STENCIL;
                    (factors[0], factors[1]) = ((j, 0, -factor), (j, 1, factor));
                }
            }
        }
        factors.into_iter().flatten().filter(|(_, _, factor)| *factor != 0.0)
    }

    /// Coefficients of κ, κ′ and κ″ at a coupling in the curvatures of the one before, its own and the one after (1,
    /// 1/m, 1/m²), if all lie in one span of fourth order.
    fn rates(&self, c: usize) -> Option<[[f64; 3]; 3]> {
        let mesh = self.branch.rod.mesh();
        let paired = |frame: usize| mesh.pairs.binary_search_by_key(&frame, |pair| pair.frame).is_ok();
        if c == 0 || c + 1 >= self.curvature.len() || !(paired(c) && paired(c + 1)) {
            return None;
        }
        let (before, after) = (self.place[c] - self.place[c - 1], self.place[c + 1] - self.place[c]);
        let both = before + after;
        let rate = [-after / (before * both), (after - before) / (before * after), before / (after * both)];
        let second = [2.0 / (before * both), -2.0 / (before * after), 2.0 / (after * both)];
        Some([[0.0, 1.0, 0.0], rate, second])
    }

    /// Curvature and its derivatives from those of couplings with these coefficients.
    fn curvature(&self, couplings: [usize; 3], coefficients: &[[f64; 3]; 3]) -> Curvature {
        let of = |k: usize| couplings.iter().zip(coefficients[k]).map(|(c, factor)| self.curvature[*c] * factor).sum();
        Curvature {
            own: of(0),
            rate: of(1),
            second: of(2),
            rest: self.rest,
            stiffness: *self.of_coupling(couplings[1]),
        }
    }

    /// ∂D/∂κ of the couplings, N m², without edges and weight.
    pub(super) fn moments_of_cells(&self) -> Vec<Vector> {
        let mesh = self.branch.rod.mesh();
        let lambda = self.shape.coupling_lengths;
        let mut moments = vec![Vector::zeros(); self.curvature.len()];
        for (c, moment) in moments.iter_mut().enumerate() {
            let excess = self.discrete_stiffness[c] - self.of_coupling(c);
            *moment = excess * (self.curvature[c] - self.rest) * lambda[c];
        }
        for j in (0..mesh.segments()).filter(|j| !self.fine[*j]) {
            self.add_rate_moments(j, 1.0, &mut moments);
        }
        if !self.branch.rod.couples_pairs() {
            return moments;
        }
        let rates: Vec<_> = (0..moments.len()).map(|c| self.rates(c)).collect();
        for (c, coefficients) in rates.iter().enumerate() {
            let Some(coefficients) = coefficients else { continue };
            let neighbours = [c - 1, c, c + 1];
            // Cells beside stations have the rate of their neighbours.
            let cells: f64 =
                neighbours.iter().filter(|k| **k == c || rates[**k].is_none()).map(|k| lambda[*k].powi(5)).sum();
            let derivatives = self.curvature(neighbours, coefficients).of_cells();
            for (coefficients, derivative) in coefficients.iter().zip(&derivatives) {
                for (k, factor) in neighbours.into_iter().zip(coefficients) {
                    moments[k] += derivative * (cells * factor);
                }
            }
        }
        moments
    }

    /// Adds ∂D/∂κ of `−factor (ℓ³/24) κ′ᵀ C κ′` of a segment.
    fn add_rate_moments(&self, j: usize, factor: f64, moments: &mut [Vector]) {
        let [start, end] = self.couplings(j);
        if let (Some(rate), Some(start), Some(end)) = (self.rate[j], start, end) {
            let distance = self.place[end] - self.place[start];
            let moment = self.stiffness[j] * rate * (2.0 * factor * self.cells(j) / distance);
            moments[start] += moment;
            moments[end] -= moment;
        }
    }

    /// Adds ∂D/∂κ of what the couplings leave at stations, where the next segments are of one length.
    fn add_station_moments(&self, moments: &mut [Vector]) {
        let mesh = self.branch.rod.mesh();
        if !self.branch.rod.couples_pairs() {
            return;
        }
        for beside in mesh.beside.iter().filter(|beside| beside.next.is_some()) {
            let l = self.shape.rest_lengths[beside.segment];
            let (couplings, direction) = match beside.stations {
                [Some(start), _] => ([start, start + 1, start + 2], 1.0),
                [None, Some(end)] => ([end - 1, end - 2, end - 3], -1.0),
                [None, None] => continue,
            };
            let [own, rate, second] = AT_STATION;
            let coefficients = [own, rate.map(|k| k * direction / l), second.map(|k| k / (l * l))];
            let derivatives = self.curvature(couplings, &coefficients).at_station();
            for (coefficients, derivative) in coefficients.iter().zip(&derivatives) {
                for (c, factor) in couplings.into_iter().zip(coefficients) {
                    moments[c] -= derivative * (l.powi(4) * direction * factor);
                }
            }
        }
    }

    /// Adds to the gradients of a harness those of the couplings' part of D.
    fn add_cells(&self, gradient: &mut Tangent) {
        self.add_moments(&self.cell_moments, &mut gradient.frames[self.branch.frames.clone()]);
    }

    /// Adds the gradient of `Σ_c μ·κ` with these μ (N m²).
    fn add_moments(&self, moments: &[Vector], frames: &mut [Vector]) {
        for (c, moment) in moments.iter().enumerate() {
            let lambda = self.shape.coupling_lengths[c];
            let turned = (self.curvature[c] * (0.5 * lambda)).cross(moment);
            frames[c + 1] += (moment - turned) / lambda;
            frames[c] -= (moment + turned) / lambda;
        }
    }

    /// Adds to the gradients of a harness those of the edges' and the weight's part of D; `own` are the second
    /// derivatives of the branch, `load` is the load per length of a segment (N/m).
    fn add_edges(
        &self,
        problem: &Problem<'_>,
        own: &BranchHessian,
        load: impl Fn(usize) -> Vector,
        gradient: &mut Tangent,
    ) {
        let mesh = self.branch.rod.mesh();
        let points = &mut gradient.points[self.branch.points.clone()];
        let frames = &mut gradient.frames[self.branch.frames.clone()];
        for j in 0..mesh.segments() {
            let frame = mesh.segment_frames[j];
            let a = self.edge_offset(j);
            let h = &own.segments[j];
            let mut force = h.ee * a;
            frames[frame] += h.te * a;
            // What turns x″ at a joint turns it in both arms: see `add_joint`.
            let within = self.offset_factors(j).filter(|(of, end, _)| self.couplings(*of)[*end].is_some());
            for (of, end, factor) in within {
                let turn = self.bends[of][end].cross(&self.forces[j]) * factor;
                // x″ at a node turns with the frames around it.
                let beyond = if end == 0 { of.checked_sub(1) } else { Some(of + 1) };
                let own = &mesh.segment_frames[of];
                let around = match mesh.station_frame(of + end) {
                    Some(station) => [station; 2],
                    None => [*own, *beyond.and_then(|j| mesh.segment_frames.get(j)).unwrap_or(own)],
                };
                for frame in around {
                    frames[frame] += (self.shape.frames[frame].inverse() * turn) * 0.5;
                }
            }
            // Weight: W (t_i − t_{i−1}) at nodes, and what is shifted from stations.
            let l = &self.shape.rest_lengths;
            let lumped = |node: usize| {
                let is_end = node == 0 || node == mesh.segments();
                match (self.fine[j], is_end || mesh.station_frame(node).is_some()) {
                    (true, true) => l[j] * l[j] / 24.0,
                    (false, _) if is_end => 0.0,
                    (fine, _) => {
                        let (a, b) = (l[node - 1], l[node]);
                        (a.powi(3) + b.powi(3)) / ((a + b) * if fine { 24.0 } else { 12.0 })
                    }
                }
            };
            let own = load(j);
            force -= own * ((lumped(j) - lumped(j + 1)) / l[j]);
            // A load that grows along the segment is lumped as if it were even.
            force += growth(mesh, j, &load) * (l[j] / 12.0);
            for (node, sign) in [(j, -1.0), (j + 1, 1.0)] {
                if mesh.station_frame(node).is_some() && !self.fine[j] {
                    force += own * (sign * STATION_SHIFT * l[j]);
                }
            }
            // The centrifugal potential V of nodes beside the centre line: `(ℓ²/24) ρ x′ᵀ ∂²V x′` per length.
            let rotation = &problem.conditions().rotation;
            if self.fine[j] && rotation.is_moving() {
                let density = self.branch.sections.of(j).linear_density;
                force += rotation.hessian() * self.shape.edge(j) * (density * l[j] / 12.0);
            }
            points[j] -= force;
            points[j + 1] += force;
        }
        for (beside, h) in mesh.beside.iter().zip(&own.beside) {
            let a = self.edge_offset(beside.segment);
            for (frame, se) in beside.neighbours().iter().zip(&h.se) {
                if let Some(c) = frame {
                    frames[*c] += se * a;
                }
            }
        }
        self.add_moments(&self.edge_moments, frames);
    }

    /// ∂D/∂κ of the couplings, N m², of the edges' part of D.
    pub(super) fn moments_of_edges(&self) -> Vec<Vector> {
        let mut moments = vec![Vector::zeros(); self.curvature.len()];
        self.add_station_moments(&mut moments);
        for j in (0..self.forces.len()).filter(|j| self.fine[*j] && self.alignment > 0.0) {
            self.add_rate_moments(j, -self.alignment, &mut moments);
        }
        for (j, force) in self.forces.iter().enumerate() {
            for (of, end, factor) in self.offset_factors(j) {
                if let Some(c) = self.couplings(of)[end] {
                    moments[c] += Vector::z().cross(&(self.result.frame[of + end].inverse() * force)) * factor;
                }
            }
        }
        moments
    }
}

/// Adds to the gradients of a harness the derivative by x″ of what D has at a joint that a rod runs through. An arm
/// whose segment there has the length ℓ has `n · a`, `a = ± ((ℓ² − L²)/24) x″` (see [`Samples::edge_offset`]), with the
/// offset `(L²/24) x″` of the centre line from the node; what acts on the joint acts at the node, not on the centre
/// line, which is `F · (L²/24) x″`. With the pull p of each arm, `F = −Σ p`, the sum is `−Σ p · (ℓ²/24) x″`. x″ is the
/// sum of the outward tangents of the arms, less that of their directions at rest, over the mean of ℓ.
fn add_joint(joint: &Joint, state: &State, samples: &[Samples<'_>], gradient: &mut Tangent) {
    let sign = |arm: &Arm| if arm.starts_here { 1.0 } else { -1.0 };
    let pull = |(arm, &b): (&Arm, &usize)| {
        let forces = &samples[b].result.force;
        let outward = forces[if arm.starts_here { 0 } else { forces.len() - 1 }] * sign(arm);
        outward * (arm.segment_length * arm.segment_length / 24.0)
    };
    let by_bend = -joint.arms.iter().zip(&joint.branches).map(pull).sum::<Vector>() / mean_length(joint);
    let mean = mean_rotation(others(joint, usize::MAX, state));
    let rest: Vector = joint.arms.iter().map(|arm| columns(&(mean * arm.rest))[2] * sign(arm)).sum();
    for (arm, &frame) in joint.arms.iter().zip(&joint.arm_frames) {
        let to_body = state.frames[frame].inverse();
        // The mean turns by half of what each arm does.
        gradient.frames[frame] +=
            Vector::z().cross(&(to_body * by_bend)) * sign(arm) - to_body * (rest.cross(&by_bend) * 0.5);
    }
}

/// ∂D at `state` in the independent variables, for [`Response::parts`].
pub(crate) fn defect(problem: &Problem<'_>, state: &State, samples: &[Samples<'_>], hessian: &Hessian) -> [Tangent; 2] {
    let mut gradients = [Tangent::zeros(problem.network), Tangent::zeros(problem.network)];
    for (index, samples) in samples.iter().enumerate() {
        let weight = |j: usize| problem.force_per_length(state, index, j);
        samples.add_cells(&mut gradients[0]);
        samples.add_edges(problem, &hessian.branches[index], weight, &mut gradients[1]);
    }
    for joint in problem.network.joints.iter().filter(|joint| runs_through(joint)) {
        add_joint(joint, state, samples, &mut gradients[1]);
    }
    gradients.iter_mut().for_each(|gradient| problem.network.pull_back(state, gradient));
    gradients
}
