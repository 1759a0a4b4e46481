//! Estimate of the discretisation error of an equilibrium.
//!
//! **Method.** Defect correction with the modified equation (Stetter 1978, The defect correction principle and
//! discretization methods, Numerische Mathematik 29; Warming and Hyett 1974, The modified equation approach to the
//! stability and accuracy analysis of finite-difference methods, Journal of Computational Physics 14). Put on the grid
//! (positions at nodes, frames at the middle of segments), a rod has the discrete energy `E_h = E + D`, to leading
//! order with
//!
//! ```text
//! D = − Σ_c (λ³/24) κ′ᵀ C κ′            a coupling measures the mean of κ over its cell of length λ
//!     + Σ_j n · a                       an edge is not the tangent at its middle: a = (ℓ²/24) Δx″ ± (β ℓ²/2) x″
//!     − Σ_i (ℓ²/12) ρ g · Δx′           weight is lumped at nodes
//!     + Σ_j (ℓ²/12) w′ · ℓ x′           a load w that is not even is lumped as if it were
//!     + Σ_c (λ/2) κᵀ (C_h − C) κ        stiffness of couplings that is not that of the section (`mass-spring`)
//!     − Σ p · (ℓ²/24) x″                each arm that pulls (p) at a joint of two does so beside the centre line
//! ```
//!
//! where β is the coefficient of a station in a segment beside it (`models::kernel::Stencil`), and Δ the difference
//! between the ends of a segment (of neighbouring segments). In spans where the scheme is of fourth order
//! ([`wireloom_core::RodSegment::couples_pairs`], [`wireloom_core::rod::Mesh::is_fine`]) it is instead, for nodes at `x
//! − (ℓ²/24) x″`,
//!
//! ```text
//! D = Σ_c λ⁵ f ∓ Σ_i ℓ⁴ b               what couplings leave in their cells and at stations: see `cells`
//!     + Σ_j n · a                       a: what the stencils at stations leave, ± (ℓ²/24) ε′ x′ there of a changing
//!                                       stretch ε, and what a change of ℓ along the branch leaves
//!     − Σ_i ((ℓ²/24) at i − that of the segments) ρ g · Δx′
//!     + Σ_j (ℓ³/24) ρ x′ᵀ ∂²V x′        centrifugal potential V
//!     + Σ_j ((f − 1) ℓ³/24) (κ′ᵀ C κ′ − Qᵀ C⊥⁻¹ Q)   frames aligned with their edges (`kirchhoff`), Q across them
//! ```
//!
//! The computed equilibrium minimises `E + D` but for the forces r that the minimiser has left, so it differs from the
//! rod's by `δ = −H⁻¹ (∂D − r)` with the Hessian H that the certificate has factorised: one more solution with it. From
//! δ follow the errors of positions, curvatures, forces and moments; to the curvature of a node is added what its cell
//! differs from it, `(λ²/24) κ″`, at a station `β ℓ κ′`. Beside a station of a scheme of fourth order, where D is cut
//! off, the error of the moment follows by the balance of moments from that of a node within.
//!
//! **What is reported** is not the leading term itself, which changes its sign where the true error does at a slightly
//! different place, but its envelope: the largest value within `REACH` nodes, no less than a tenth (`FLOOR`) of
//! the branch's largest, times `SAFETY`. On a mesh so coarse that curvature changes by its own size from node to node
//! the leading term says little; there the estimate is the change itself (Zienkiewicz and Zhu 1992, The superconvergent
//! patch recovery, International Journal for Numerical Methods in Engineering 33, estimate the error by such jumps).
//!
//! Under loads without a potential H is the tangent of the residual. At a neutral equilibrium δ is without neutral
//! motions, such as a cable that rolls about its own centre line. Where H is not available (the state is no
//! equilibrium, or cables slide under such loads), the estimate is local: the last contribution, times `LOCAL_SAFETY`,
//! integrated along the branch for positions. Where cables touch something H has the contacts that act, and where they
//! slide the arc length at the constraint is fixed; with another mesh both would differ a little, so the estimate is
//! doubled there, that of positions tripled where they slide.

mod cells;
mod functional;
mod samples;

use super::nodes::{curvatures, twists};
pub(crate) use functional::defect;
pub(crate) use samples::Samples;
use samples::touches;
use wireloom_core::equilibrium::{BranchError, BranchResult};
use wireloom_core::network::{Branch, BranchEnd};
use wireloom_core::problem::{Hessian, Problem};
use wireloom_core::rod::{BranchHessian, SegmentHessian};
use wireloom_core::section::softest_bending;
use wireloom_core::{Matrix, State, Tangent, Vector};

/// Factor on the envelope of the leading term.
const SAFETY: f64 = 1.5;
/// Factor on what the leading term of the response would be expected to be, where only local terms are known.
const LOCAL_SAFETY: f64 = 4.0;
/// Share of the change of curvature from node to node that is its error where that is as large as the curvature.
const COARSE: f64 = 0.8;
/// Divisor of the fourth power of the angle of a cell (rad): the error of the law of a coupling relative to its
/// curvature.
const LAW: f64 = 300.0;
/// Further factor in a scheme of fourth order, whose leading term is most of the error on fine meshes only.
const FINE_SAFETY: f64 = 1.5;
/// By how much errors are larger than the leading term says, for the fourth power of the largest change of curvature
/// from coupling to coupling, relative to the largest curvature.
const STEEP: f64 = 10.0;
/// Differences of the load per length that are round-off, relative to the force.
const EVEN: f64 = 1e-9;
/// Lever of a force that is missing, as a fraction of the branch.
const LEVER: f64 = 1.0 / 8.0;
/// Nodes from a station on, at which the estimate of a scheme of fourth order is that of the next one.
const CUT_OFF: usize = 4;
/// Factor where cables touch something.
const CONTACT_SAFETY: f64 = 2.0;
/// Further factor on positions where they slide.
const SLIDE_SAFETY: f64 = 1.5;
/// Number of segments between stations below which differences of twist say too little of its error: in a scheme of
/// second order bends that are not resolved add to it, and frames that turn.
const SHORT: usize = 6;
/// Nodes on each side over which the envelope is taken.
const REACH: usize = 2;
/// Least error as a fraction of the sizes of its two parts, which may cancel.
const CANCELLED: f64 = 0.5;
/// Least error of a node as a fraction of the largest of its branch.
const FLOOR: f64 = 0.1;

/// Estimated errors of the results of a branch, one for each node.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodalErrors {
    /// Of the curvature, 1/m.
    pub curvature: Vec<f64>,
    /// Of the torsion (twist per length) under the moment, 1/m.
    pub torsion: Vec<f64>,
    /// Of the twist per length of the frames, 1/m.
    pub twist: Vec<f64>,
    /// Of the internal force, N.
    pub force: Vec<f64>,
    /// Of the internal moment, N m.
    pub moment: Vec<f64>,
    /// Of the position, m.
    pub position: Vec<f64>,
    /// By how much the curvature between nodes is larger than at each, 1/m.
    pub between: Vec<f64>,
    /// Order of the scheme all along the branch.
    pub order: u32,
}

impl NodalErrors {
    /// Error of a bend radius R (m) at a node, m: by so much the true one may be smaller there or between it and the
    /// next nodes, `R − 1/(1/R + e)` with e the error of the curvature; 0 where the cable is straight.
    pub fn bend_radius(&self, node: usize, radius: f64) -> f64 {
        let error = self.curvature[node] + self.between[node];
        if radius.is_finite() { radius - 1.0 / (1.0 / radius + error) } else { 0.0 }
    }

    /// Largest errors of the branch; `None` if some are not finite.
    pub fn largest(&self, branch: &BranchResult) -> Option<BranchError> {
        let largest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
        let tightest = branch.bend_radius.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        let error = BranchError {
            position: largest(&self.position),
            force: largest(&self.force),
            moment: largest(&self.moment),
            bend_radius: tightest.filter(|(_, r)| r.is_finite()).map(|(node, r)| self.bend_radius(node, *r)),
            order: self.order,
        };
        let all = [&self.curvature, &self.torsion, &self.twist, &self.force, &self.moment, &self.position];
        all.iter().all(|errors| errors.iter().all(|e| e.is_finite())).then_some(error)
    }
}

/// What a response changes in a branch.
struct Change<'a> {
    /// Of its frames, rad.
    turns: &'a [Vector],
    /// Of its points, m.
    moves: &'a [Vector],
    /// Of the forces of its segments, N.
    forces: &'a [Vector],
}

impl Samples<'_> {
    /// What the force in the branch may lack where the load per length differs from segment to segment, N: it is lumped
    /// at nodes as if it were even, `(ℓ²/12) w′`, and so it is interpolated, `(ℓ²/8) w′`.
    fn uneven(&self, weight: impl Fn(usize) -> Vector) -> f64 {
        let (mesh, l) = (self.branch.rod.mesh(), self.shape.rest_lengths);
        // The load may end at a station.
        let inner = (1..l.len()).filter(|node| mesh.station_frame(*node).is_none());
        inner.map(|node| (weight(node) - weight(node - 1)).norm() * l[node] * (5.0 / 24.0)).fold(0.0, f64::max)
    }

    /// Errors of κ at the couplings that are not beside a station, and of the moments there, from the response.
    fn curvature_errors(&self, response: Option<&[Vector]>) -> Vec<Vector> {
        let mesh = self.branch.rod.mesh();
        let error = |c: usize| {
            let node = mesh.coupling_nodes[c];
            let lambda = self.shape.coupling_lengths[c];
            if node > 0 && self.fine[node - 1] {
                let Some(turns) = response else {
                    return self.bent(c, &self.cell_moments[c]) / lambda;
                };
                let [within, turned] = self.parts_of_curvature(c, turns);
                return within
                    .zip_map(&turned, |a, b| (a + b).abs().max(CANCELLED * (a.abs() + b.abs())).copysign(a + b));
            }
            let rates = [node.checked_sub(1), Some(node)].map(|j| j.and_then(|j| *self.rate.get(j)?));
            let (second, first) = match rates {
                [Some(before), Some(after)] => ((after - before) / lambda, (before + after) * 0.5),
                _ => (Vector::zeros(), Vector::zeros()),
            };
            let within = second * (lambda * lambda / 24.0);
            let Some(turns) = response else { return within };
            let shift = 0.25 * (self.shape.rest_lengths[node] - self.shape.rest_lengths[node - 1]);
            within + first * shift + self.turned(c, turns)
        };
        let at_station = |c: usize| mesh.station_frame(mesh.coupling_nodes[c]).is_some();
        // Of a segment between two stations there are no other couplings.
        let alone = |c: usize| match response.filter(|_| self.span_of(c) == 1) {
            Some(turns) => self.turned(c, turns),
            None => Vector::zeros(),
        };
        let mut errors: Vec<Vector> =
            (0..self.curvature.len()).map(|c| if at_station(c) { alone(c) } else { error(c) }).collect();
        // D is cut off at stations: its derivatives by the first curvatures are far larger than what they cancel to.
        let of_node = |node: usize| {
            let first = mesh.coupling_nodes.partition_point(|own| *own < node);
            (mesh.coupling_nodes.get(first) == Some(&node)).then_some(first)
        };
        for c in 0..errors.len() {
            let node = mesh.coupling_nodes[c];
            if at_station(c) || !self.fine[node - 1] {
                continue;
            }
            let k = mesh.stations.partition_point(|station| *station < node);
            let from = k.checked_sub(1).map_or(0, |k| mesh.stations[k] + CUT_OFF);
            let to = mesh.stations.get(k).map_or(mesh.segments(), |station| station.saturating_sub(CUT_OFF));
            let inner = if from <= to { of_node(node.clamp(from, to)) } else { None };
            if let Some(inner) = inner {
                errors[c] = errors[inner];
            }
        }
        errors
    }

    /// Change of the curvature of a coupling by these turns of the frames (rad), 1/m.
    fn turned(&self, c: usize, turns: &[Vector]) -> Vector {
        let (a, b) = (turns[c], turns[c + 1]);
        (b - a) / self.shape.coupling_lengths[c] + self.curvature[c].cross(&((a + b) * 0.5))
    }

    /// Error of the curvature of a coupling in a scheme of fourth order, in two parts, 1/m. The curvature reported is
    /// that under the moment, to which D adds `∂D/∂κ/λ`.
    fn parts_of_curvature(&self, c: usize, turns: &[Vector]) -> [Vector; 2] {
        let of_defect = self.cell_moments[c] + self.edge_moments[c];
        [self.bent(c, &of_defect) / self.shape.coupling_lengths[c], self.turned(c, turns)]
    }

    /// Error of the curvature of a node by one of its moment (N m, world axes), 1/m. A station turns with its frame,
    /// other nodes with those around them.
    fn curvature_of(&self, node: usize, error: &Vector, turns: &[Vector]) -> Vector {
        let mesh = self.branch.rod.mesh();
        let last = mesh.segments() - 1;
        let around = match mesh.station_frame(node) {
            Some(frame) => [frame; 2],
            None => [node.saturating_sub(1), node.min(last)].map(|j| mesh.segment_frames[j]),
        };
        let turn = around.iter().map(|frame| turns[*frame]).sum::<Vector>() * 0.5;
        let to_body = self.result.frame[node].inverse();
        let moment = to_body * self.result.moment[node];
        let error = to_body * error - turn.cross(&moment);
        let [before, after] = self.beside(node).map(|j| self.compliance[j] * error);
        before.zip_map(&after, |a, b| if a.abs() < b.abs() { b } else { a })
    }

    /// Errors of the moment near stations and ends, N m, world axes, each with its node, where the scheme is of fourth
    /// order: by the balance of moments `M′ = −x′ × n` from that of the node [`CUT_OFF`] nodes farther in,
    ///
    /// ```text
    /// δM(p) = δM(b) ± Σ_j (δe_j × n_j + e_j × δn_j)    over the segments between p and b; + where b is ahead of p
    /// ```
    fn moments_near_stations(&self, change: &Change<'_>) -> Vec<(usize, Vector)> {
        let mesh = self.branch.rod.mesh();
        let n = mesh.segments();
        let mut all = Vec::new();
        let inner_stations = mesh.stations.iter().copied().filter(|station| (1..n).contains(station));
        for end in [0, n].into_iter().chain(inner_stations) {
            for ahead in [true, false] {
                let first = if ahead { Some(end) } else { end.checked_sub(1) };
                let Some(first) = first.filter(|j| self.fine.get(*j) == Some(&true)) else { continue };
                let steps = CUT_OFF.min(self.span(first) / 2);
                let inner = if ahead { end + steps } else { end - steps };
                let c = mesh.coupling_nodes.partition_point(|node| *node < inner);
                let [within, turned] = self.parts_of_curvature(c, change.turns);
                let moment = self.of_coupling(c) * (self.curvature[c] - self.rest);
                let turn = (change.turns[c] + change.turns[c + 1]) * 0.5;
                let own = self.of_coupling(c) * (within + turned) + turn.cross(&moment);
                let mut error = self.result.frame[inner] * own;
                for k in (0..steps).rev() {
                    let (j, node, sign) = if ahead { (end + k, end + k, 1.0) } else { (end - 1 - k, end - k, -1.0) };
                    let stretched = change.moves[j + 1] - change.moves[j];
                    error += (stretched.cross(&self.forces[j]) + self.shape.edge(j).cross(&change.forces[j])) * sign;
                    all.push((node, error));
                }
            }
        }
        all
    }

    /// Change of the force of each segment in a response to edges with these offsets, N.
    fn forces_of(&self, response: &Tangent, own: &BranchHessian, offsets: &[Vector]) -> Vec<Vector> {
        let mesh = self.branch.rod.mesh();
        let moves = &response.points[self.branch.points.clone()];
        let turns = &response.frames[self.branch.frames.clone()];
        let force = |(j, h): (usize, &SegmentHessian)| {
            h.ee * (moves[j + 1] - moves[j] + offsets[j]) + h.te.tr_mul(&turns[mesh.segment_frames[j]])
        };
        let mut forces: Vec<Vector> = own.segments.iter().enumerate().map(force).collect();
        for (beside, h) in mesh.beside.iter().zip(&own.beside) {
            for (frame, se) in beside.neighbours().iter().zip(&h.se) {
                if let Some(c) = frame {
                    forces[beside.segment] += se.tr_mul(&turns[*c]);
                }
            }
        }
        forces
    }

    /// Estimates from the response, which is the error of the state; without one, from local terms only.
    fn errors(&self, index: usize, response: Option<Response<'_>>) -> NodalErrors {
        let result = self.result;
        let mesh = self.branch.rod.mesh();
        let n = mesh.segments();
        let turns: Option<Vec<Vector>> = response.map(|response| {
            let [cells, edges] = response.parts.each_ref().map(|part| &part.frames[self.branch.frames.clone()]);
            cells.iter().zip(edges).map(|(a, b)| a + b).collect()
        });
        let turns = turns.as_deref();
        let at_couplings = self.curvature_errors(turns);
        let mut bend = vec![0.0_f64; n + 1];
        let mut torsion = vec![0.0_f64; n + 1];
        let mut whole = vec![0.0_f64; n + 1];
        for (c, error) in at_couplings.iter().enumerate() {
            let node = mesh.coupling_nodes[c];
            bend[node] = bend[node].max(error.xy().norm());
            torsion[node] = torsion[node].max(error.z.abs());
            whole[node] = whole[node].max((self.of_coupling(c) * error).norm());
        }
        // Stations and joints have the error of the node beside them, and their own.
        for node in 0..=n {
            let neighbours = [node.checked_sub(1), (node < n).then_some(node + 1)];
            let is_plain = |node: &usize| *node > 0 && *node < n && mesh.station_frame(*node).is_none();
            if is_plain(&node) {
                continue;
            }
            for neighbour in neighbours.into_iter().flatten().filter(is_plain) {
                bend[node] = bend[node].max(bend[neighbour]);
                torsion[node] = torsion[node].max(torsion[neighbour]);
                whole[node] = whole[node].max(whole[neighbour]);
            }
        }
        let local = if response.is_none() { LOCAL_SAFETY } else { 1.0 };
        for j in 0..n {
            for end in [0, 1] {
                let node = j + end;
                let (Some(c), Some(rate)) = (self.couplings(j)[end], self.rate[j]) else { continue };
                // Moment and curvature of a station are not those of its coupling, but leave an error of the second
                // order.
                if mesh.station_frame(node).is_some() && !self.fine[j] {
                    let l = self.shape.rest_lengths[j];
                    let next = if end == 0 { Some(j + 1) } else { j.checked_sub(1) };
                    let next = next.filter(|_| mesh.station_frame(j + 1 - end).is_none());
                    let next = next.and_then(|next| *self.rate.get(next)?).unwrap_or_default();
                    let left =
                        rate * ((self.place[c] - result.s[node]).abs() * l / mesh.length()) + (next - rate) * (l / 8.0);
                    bend[node] += left.xy().norm();
                    torsion[node] += left.z.abs();
                    whole[node] += (self.stiffness[j] * left).norm();
                }
            }
        }
        let mut errors = NodalErrors {
            curvature: bend.iter().map(|e| e * local).collect(),
            torsion: torsion.iter().map(|e| e * local).collect(),
            twist: torsion.iter().map(|e| e * local).collect(),
            moment: whole.iter().map(|e| e * local).collect(),
            force: vec![0.0; n + 1],
            position: vec![0.0; n + 1],
            between: between(self.branch, result),
            order: self.order(),
        };
        if let (Some(response), Some(turns)) = (response, turns) {
            let own = &response.hessian.branches[index];
            let [cells, edges] = response.parts;
            let offsets: Vec<Vector> = (0..n).map(|j| self.edge_offset(j)).collect();
            let none = vec![Vector::zeros(); n];
            let forces = [self.forces_of(cells, own, &none), self.forces_of(edges, own, &offsets)];
            for (j, (of_cells, of_edges)) in forces[0].iter().zip(&forces[1]).enumerate() {
                for node in [j, j + 1] {
                    errors.force[node] = errors.force[node].max(of_parts(of_cells, of_edges));
                }
            }
            let [cells, edges] = response.parts.each_ref().map(|part| &part.points[self.branch.points.clone()]);
            let moves: Vec<Vector> = cells.iter().zip(edges).map(|(a, b)| a + b).collect();
            let forces: Vec<Vector> = forces[0].iter().zip(&forces[1]).map(|(a, b)| a + b).collect();
            for (node, moment) in self.moments_near_stations(&Change { turns, moves: &moves, forces: &forces }) {
                errors.moment[node] = errors.moment[node].max(moment.norm());
                let curvature = self.curvature_of(node, &moment, turns);
                errors.curvature[node] = errors.curvature[node].max(curvature.xy().norm());
                errors.torsion[node] = errors.torsion[node].max(curvature.z.abs());
            }
            self.add_jumps_at_ends(&mut errors);
            for (node, position) in errors.position.iter_mut().enumerate() {
                let drawn = if self.fine[node.saturating_sub(1)] {
                    Vector::zeros()
                } else {
                    result.position[node] - self.shape.points[node] - self.shape.compensation[node]
                };
                *position = of_parts(&cells[node], &(edges[node] + drawn));
            }
            // Moments in world axes turn with the frames; a frame that turns about another axis takes a part of the
            // bending moment for torsion.
            for (c, turn) in turns.iter().enumerate().take(self.curvature.len()) {
                let node = mesh.coupling_nodes[c];
                let moment = self.of_coupling(c) * (self.curvature[c] - self.rest);
                let turned = turn.cross(&moment);
                errors.moment[node] += turned.norm();
                if self.span_of(c) < SHORT {
                    errors.torsion[node] += self.bent(c, &turned).z.abs();
                }
            }
            errors.twist.clone_from(&errors.torsion);
            self.add_turns_at_stations(&mut errors.torsion);
        } else {
            // By bending alone: the turn is the integral of the error of κ, the position that of the turn.
            let cell = |node: usize| {
                let side = |j: Option<usize>| j.and_then(|j| self.shape.rest_lengths.get(j)).copied().unwrap_or(0.0);
                0.5 * (side(node.checked_sub(1)) + side(Some(node)))
            };
            let turn: f64 = errors.curvature.iter().enumerate().map(|(node, e)| e * cell(node)).sum();
            errors.position.fill(turn * mesh.length());
            let (moment, error) = (largest_norm(&result.moment), errors.moment.iter().copied().fold(0.0, f64::max));
            let force = largest_norm(&result.force);
            errors.force.fill(if moment > 0.0 { force * (error / moment + turn) } else { 0.0 });
        }
        errors
    }

    /// Adds to the errors at the ends of a branch by how much their curvature and twist are beside the cubic through
    /// the next four nodes, where they do not follow from the moment by a linear law: what yielded or crept in the half
    /// segment at an end depends on more than the present state. The twist of an end is that of its segment.
    fn add_jumps_at_ends(&self, errors: &mut NodalErrors) {
        let beside = |all: Vec<f64>| {
            let [a, b, c, d, e] = *all.first_chunk()?;
            Some(((a - 4.0 * b + 6.0 * c - 4.0 * d + e).abs(), 0.5 * (b - a).abs()))
        };
        let n = self.branch.rod.mesh().segments();
        for (node, is_start) in [(0, true), (n, false)] {
            let inward = |all: Vec<f64>| if is_start { all } else { all.into_iter().rev().collect() };
            if !self.branch.bends_linearly()
                && let Some((jump, _)) = beside(inward(curvatures(self.result)))
            {
                errors.curvature[node] += jump;
            }
            if !self.branch.twists_linearly()
                && let Some((jump, within)) = beside(inward(twists(self.result)))
            {
                errors.torsion[node] += jump + within;
            }
        }
    }

    /// Adds to the errors of the torsion what frames beside stations take of the bending moment for torsion: they turn
    /// by `ℓ³ (κ″/64 + κ κ′/320)` where the scheme is of fourth order (measured).
    fn add_turns_at_stations(&self, torsion: &mut [f64]) {
        let mesh = self.branch.rod.mesh();
        for &station in &mesh.stations {
            for ahead in [false, true] {
                // The segments from the station on, and the nodes behind them.
                let segment = |k: usize| if ahead { Some(station + k) } else { station.checked_sub(1 + k) };
                let node = |k: usize| if ahead { station + 1 + k } else { station - 1 - k };
                let [Some(j), Some(next), Some(third)] = [0, 1, 2].map(segment) else { continue };
                if self.fine.get(j) != Some(&true) {
                    continue;
                }
                let (Some(Some(rate)), Some(Some(other))) = (self.rate.get(next), self.rate.get(third)) else {
                    continue;
                };
                let (length, kappa) = (self.shape.rest_lengths[j], self.at_node(next, usize::from(!ahead)));
                let kappa = kappa.unwrap_or_default();
                let second = (other - rate).norm() / length;
                let turn = length.powi(3) * (second / 64.0 + kappa.norm() * rate.norm() / 320.0);
                let moment = (self.stiffness[j] * (kappa - self.rest)).xy().norm();
                for k in 0..2 {
                    torsion[node(k)] += turn * moment * self.compliance[j].column(2).norm();
                }
            }
        }
    }

    /// Factor on what the leading term says, by how steeply the curvature changes: near a clamp a heavy or thin cable
    /// may bend within the length of a segment.
    fn steepness(&self) -> f64 {
        let bends = |j: usize| self.couplings(j).map(|c| c.map(|c| self.curvature[c].xy()));
        let change = |j: usize| match bends(j) {
            [Some(before), Some(after)] => (after - before).norm(),
            _ => 0.0,
        };
        let steepest = (0..self.rate.len()).map(change).fold(0.0, f64::max);
        let largest = self.curvature.iter().map(|kappa| kappa.xy().norm()).fold(f64::MIN_POSITIVE, f64::max);
        1.0 + STEEP * (steepest / largest).min(1.0).powi(4)
    }

    /// Additional errors of the curvature (1/m) and the moment (N m) of each node where the mesh is too coarse for the
    /// leading term: where the curvature changes by its own size within a segment, or the angle of a cell is large.
    fn unresolved(&self) -> Vec<[f64; 2]> {
        let mut errors = vec![[0.0_f64; 2]; self.branch.rod.mesh().nodes()];
        let lengths = self.shape.rest_lengths;
        let bends = |j: usize| [0, 1].map(|end| self.at_node(j, end).map(|kappa| kappa.xy().norm()));
        let bends: Vec<[Option<f64>; 2]> = (0..lengths.len()).map(bends).collect();
        for (j, [start, end]) in bends.iter().enumerate() {
            let around = &bends[j.saturating_sub(REACH)..(j + REACH + 1).min(bends.len())];
            let largest = around.iter().flatten().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
            let change = start.zip(*end).map_or(0.0, |(start, end)| (end - start).abs());
            for (node, kappa) in [(j, start), (j + 1, end)] {
                let kappa = kappa.unwrap_or(0.0);
                let power = if self.fine[j] { 8 } else { 4 };
                let coarse = COARSE * change * (change / largest).min(1.0).powi(power);
                let of_curvature = coarse + kappa * (kappa * lengths[j]).powi(4) / LAW;
                let of_moment = self.stiffness[j].diagonal().xy().max() * of_curvature;
                let [curvature, moment] = &mut errors[node];
                (*curvature, *moment) = (curvature.max(of_curvature), moment.max(of_moment));
            }
        }
        errors
    }
}

fn largest_norm(all: &[Vector]) -> f64 {
    all.iter().map(Vector::norm).fold(0.0, f64::max)
}

/// Largest value within [`REACH`] nodes, no less than [`FLOOR`] of the largest, times `factor`.
fn envelope(errors: &mut Vec<f64>, factor: f64) {
    let floor = FLOOR * errors.iter().copied().fold(0.0, f64::max);
    *errors = (0..errors.len()).map(|node| largest_around(errors, node).max(floor) * factor).collect();
}

/// The same of errors of curvature or torsion, by this stiffness, where the section changes: errors of moments are
/// alike on both sides. At a change they are those of the softer section.
fn envelope_of_moments(errors: &mut Vec<f64>, factor: f64, samples: &Samples<'_>, stiffness: fn(&Matrix) -> f64) {
    if samples.branch.sections.only().is_some() {
        return envelope(errors, factor);
    }
    let of_node = |node: usize| {
        samples.beside(node).map(|j| stiffness(&samples.stiffness[j])).into_iter().fold(f64::INFINITY, f64::min)
    };
    errors.iter_mut().enumerate().for_each(|(node, error)| *error *= of_node(node));
    envelope(errors, factor);
    errors.iter_mut().enumerate().for_each(|(node, error)| *error /= of_node(node));
}

/// Largest value within [`REACH`] nodes.
fn largest_around(errors: &[f64], node: usize) -> f64 {
    let window = node.saturating_sub(REACH)..(node + REACH + 1).min(errors.len());
    errors[window].iter().copied().fold(0.0, f64::max)
}

/// Response of a harness to the defect of its scheme.
#[derive(Clone, Copy)]
pub(crate) struct Response<'a> {
    /// `−H⁻¹ ∂D` with each part of D: that of the couplings, and that of edges and weight.
    pub parts: [&'a Tangent; 2],
    /// H.
    pub hessian: &'a Hessian,
}

/// Estimated errors of the results of all branches at `state`; without a response the estimate is local.
pub(crate) fn estimate(
    problem: &Problem<'_>,
    state: &State,
    samples: &[Samples<'_>],
    response: Option<Response<'_>>,
) -> Vec<NodalErrors> {
    let touches = touches(problem);
    let slides = problem.has_slides();
    let factor = if touches || slides { SAFETY * CONTACT_SAFETY } else { SAFETY };
    // What is not resolved in one branch moves those that it meets.
    let around = |end: BranchEnd| match end {
        BranchEnd::Joint { joint, .. } => &problem.network.joints[joint].branches[..],
        BranchEnd::Free => &[],
    };
    let own: Vec<f64> = samples.iter().map(Samples::steepness).collect();
    let steepness = |index: usize| {
        let Branch { start, end, .. } = &problem.network.branches[index];
        around(*start).iter().chain(around(*end)).map(|other| own[*other]).fold(own[index], f64::max)
    };
    let estimate = |index: usize| {
        let samples = &samples[index];
        let mut errors = samples.errors(index, response);
        let steepness = steepness(index);
        let slid = if slides { SLIDE_SAFETY } else { 1.0 };
        for all in [&mut errors.force, &mut errors.moment, &mut errors.curvature] {
            all.iter_mut().for_each(|error| *error *= steepness);
        }
        errors.position.iter_mut().for_each(|error| *error *= steepness * slid);
        for (node, [unresolved, of_moment]) in samples.unresolved().into_iter().enumerate() {
            errors.curvature[node] += unresolved;
            errors.moment[node] += of_moment;
            let is_inner = |j: &usize| *j < samples.rate.len();
            let around = [node.checked_sub(1), Some(node)].into_iter().flatten().filter(is_inner);
            if around.into_iter().any(|j| samples.span(j) < SHORT) {
                errors.torsion[node] += unresolved;
                errors.twist[node] += unresolved;
            }
        }
        let uneven = samples.uneven(|j| problem.force_per_length(state, index, j));
        if uneven > EVEN * largest_norm(&samples.result.force) {
            errors.order = errors.order.min(2);
            let moment = uneven * samples.branch.rod.mesh().length() * LEVER;
            errors.force.iter_mut().for_each(|error| *error += uneven);
            errors.moment.iter_mut().for_each(|error| *error += moment);
            let softest = samples.stiffness.iter().map(softest_bending).fold(f64::INFINITY, f64::min);
            errors.curvature.iter_mut().for_each(|error| *error += moment / softest);
        }
        let NodalErrors { curvature, torsion, twist, force, moment, position, .. } = &mut errors;
        let factor = if samples.fine.contains(&true) { FINE_SAFETY * factor } else { factor };
        for all in [force, moment, position] {
            envelope(all, factor);
        }
        envelope_of_moments(curvature, factor, samples, softest_bending);
        for all in [torsion, twist] {
            envelope_of_moments(all, factor, samples, |c| c.m33);
        }
        if touches {
            // At a node that touches something the force jumps; with another mesh it touches elsewhere.
            let mut jumps = vec![0.0; errors.force.len()];
            for (node, pair) in samples.forces.windows(2).enumerate() {
                jumps[node + 1] = 0.5 * (pair[1] - pair[0]).norm();
            }
            for (node, force) in errors.force.iter_mut().enumerate() {
                *force += factor * largest_around(&jumps, node);
            }
        }
        errors
    };
    problem.network.map(samples.len(), estimate)
}

/// By how much the curvature is larger between nodes than at the nearest one, at the top of the parabola through that
/// of a node without a station and of those beside it, 1/m: with β half the difference of these and γ half the second
/// difference it is `β²/(−4 γ)` above the node, `β/(−2 γ)` of a segment beside it; times [`FINE_SAFETY`], as the
/// curvature is no parabola. At a station and at an end of the branch it is that of the parabola beside it.
fn between(branch: &Branch, result: &BranchResult) -> Vec<f64> {
    // Before and behind each node.
    let mut bends: Vec<[f64; 2]> = result.bend_radius.iter().map(|radius| [1.0 / radius; 2]).collect();
    for own in result.sides.iter().filter(|_| branch.sections.only().is_none()) {
        bends[own.node] = own.bend_radius.map(|radius| 1.0 / radius);
    }
    let (last, is_station) = (bends.len() - 1, |node: usize| branch.rod.mesh().station_frame(node).is_some());
    let mut all = vec![0.0_f64; bends.len()];
    for (k, three) in bends.windows(3).enumerate() {
        let [before, here, after] = [three[0][1], three[1][0], three[2][0]];
        let (slope, bend) = (0.5 * (after - before), 0.5 * (before + after) - here);
        if bend >= 0.0 || is_station(k + 1) {
            continue;
        }
        let (place, top) = (slope / (-2.0 * bend), here - slope * slope / (4.0 * bend));
        let node = if place.abs() <= 0.5 {
            k + 1
        } else if place < 0.0 {
            k
        } else {
            k + 2
        };
        if place.abs() < 1.0 && (node == k + 1 || node == 0 || node == last || is_station(node)) {
            let own = bends[node][if node == k + 2 { 0 } else { 1 }];
            all[node] = all[node].max(FINE_SAFETY * (top - own));
        }
    }
    all
}

/// Size of an error of two parts. Where they cancel, what is left is no longer the leading term: no less than
/// [`CANCELLED`] of their sizes.
fn of_parts(a: &Vector, b: &Vector) -> f64 {
    (a + b).norm().max(CANCELLED * (a.norm() + b.norm()))
}
