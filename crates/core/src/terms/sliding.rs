//! Sliding constraints, through which the cable runs.
//!
//! The station stays at the constraint and the mesh moves along the cable: as the arc length s at the constraint grows,
//! the rest lengths before it grow and those after it shrink, up to the next node that is fixed in the material. So s
//! is one more variable of a smooth energy, `dℓ_j/ds = ±ℓ_j/L` with L the length of the affected segments on that
//! side; the energy is smooth as material passes a node. Then
//! `∂E/∂s = Σ_j dℓ_j/ds ∂E/∂ℓ_j + Σ_c dλ_c/ds ∂E/∂λ_c − Σ_i dw_i/ds·x_i` with w_i the lumped
//! weight of node i. At rest without friction `∂E/∂s`, the difference of the configurational forces on either side,
//! vanishes (Bigoni, Dal Corso, Bosi, Misseroni 2015: the "Eshelby-like" force of a sliding sleeve; for a ring it makes
//! the tensions equal).

use super::gravity::{masses, weights};
use super::rods::RodTerm;
use crate::conditions::{Sliding, System};
use crate::equilibrium::{SlideMotion, SlideResult};
use crate::joint::Mounting;
use crate::network::{BranchEnd, Place};
use crate::{Network, State, Tangent};
use std::ops::Range;

/// Least length (in diameters of the cable) on either side of a sliding constraint: below it the cable has run out.
const LEAST_LENGTH: f64 = 0.1;
/// The same as a fraction of the unstretched length on that side.
const LEAST_FRACTION: f64 = 0.01;
/// Motion, as a fraction of the arc length, that counts as zero.
const STANDSTILL: f64 = 1e-9;
/// Remaining travel, as a fraction of the least length, below which a constraint is at its stop.
const AT_STOP: f64 = 1e-6;

/// Stop of a sliding cable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlideStop {
    /// A free end: the cable runs out of the constraint.
    End,
    /// A joint.
    Joint,
    /// Another constraint, a load, a held end, or a change of section.
    Constraint,
}

/// A sliding constraint that acts, with the segments of the cable whose lengths change with it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ActiveSlide {
    /// Index in [`Network::slides`].
    index: usize,
    branch: usize,
    node: usize,
    /// Segments before and after it whose lengths change.
    sides: [Range<usize>; 2],
    stops: [SlideStop; 2],
    /// Least length on either side, m.
    least: [f64; 2],
    /// Remaining travel on either side, m, as of the last [`crate::Problem::update_held`].
    travel: [f64; 2],
}

impl ActiveSlide {
    /// Length of the affected segments on a side, m.
    fn length(&self, state: &State, network: &Network, side: usize) -> f64 {
        let start = network.branches[self.branch].points.start;
        state.rest_lengths[start..][self.sides[side].clone()].iter().sum()
    }

    /// Whether the motion driven by a gradient of this sign is stopped: a negative `gradient` increases s.
    fn is_stopped(&self, gradient: f64) -> bool {
        self.travel[usize::from(gradient < 0.0)] <= AT_STOP * self.least[usize::from(gradient < 0.0)]
    }
}

/// Second derivatives of the energy in the arc lengths of the sliding constraints.
#[derive(Clone, Debug, Default)]
pub struct SlideHessian {
    /// Indices in [`Network::slides`] of the running constraints.
    pub running: Vec<usize>,
    /// For each running constraint `∂²E/∂s∂(x, θ)` in the independent variables.
    pub mixed: Vec<Tangent>,
    /// `∂²E/∂s_a∂s_b`, N/m, row by row.
    pub own: Vec<f64>,
}

/// Derivatives of a rod in its lengths.
#[derive(Default)]
pub(crate) struct LengthTerms {
    segments: Vec<[f64; 2]>,
    couplings: Vec<[f64; 3]>,
    segment_rates: [Vec<f64>; 2],
    coupling_rates: [Vec<f64>; 2],
}

/// Term of the arc lengths at sliding constraints; keeps its workspace.
#[derive(Default)]
pub struct SlidingTerm {
    /// The sliding constraints that act.
    slides: Vec<ActiveSlide>,
    scratch: LengthTerms,
}

impl SlidingTerm {
    /// Finds the sliding constraints that act, the affected segments and the stops.
    pub fn update(&mut self, system: System<'_>) {
        let network = system.network;
        self.slides.clear();
        for (index, site) in network.slides.iter().enumerate() {
            if !system.conditions.active[site.constraint] {
                continue;
            }
            let branch = &network.branches[site.branch];
            let mesh = branch.rod.mesh();
            let knots = system.knots(site.branch);
            let place = knots.partition_point(|&node| node < site.node);
            let neighbours = [knots[place - 1], knots[place + 1]];
            let (mut stops, mut least) = ([SlideStop::Constraint; 2], [0.0; 2]);
            let mut sides = [neighbours[0]..site.node, site.node..neighbours[1]];
            for (side, end) in [(0, branch.start), (1, branch.end)] {
                let last = [0, mesh.segments()][side];
                let here = Place::Node { branch: site.branch, node: last };
                let held = system.acting().any(|(_, constraint)| constraint.places.contains(&here));
                least[side] = (LEAST_LENGTH * branch.sections.of(site.node).diameter)
                    .min(LEAST_FRACTION * mesh.rest_lengths[sides[side].clone()].iter().sum::<f64>());
                if neighbours[side] != last {
                    continue;
                }
                match end {
                    BranchEnd::Free if !held => stops[side] = SlideStop::End,
                    BranchEnd::Free => {}
                    BranchEnd::Joint { joint, .. } => {
                        stops[side] = SlideStop::Joint;
                        // The joint's energy depends on the lengths of the segments that it couples: they stay
                        // constant.
                        let joint = &network.joints[joint];
                        if joint.model.mounting() == Mounting::Point {
                            let own = joint.coupled_frames.len() / joint.arm_frames.len();
                            sides[0].start += own * usize::from(side == 0);
                            sides[1].end -= own * usize::from(side == 1);
                        }
                    }
                }
            }
            self.slides.push(ActiveSlide {
                index,
                branch: site.branch,
                node: site.node,
                sides,
                stops,
                least,
                travel: [f64::INFINITY; 2],
            });
        }
    }

    /// Indices in [`Network::slides`] of the sliding constraints that act.
    pub fn acting(&self) -> Vec<usize> {
        self.slides.iter().map(|slide| slide.index).collect()
    }

    /// Whether no sliding constraint acts.
    pub fn is_idle(&self) -> bool {
        self.slides.is_empty()
    }

    /// Arc length at a sliding constraint (index in [`Network::slides`]), m.
    pub fn arc_length(&self, system: System<'_>, slide: usize, state: &State) -> f64 {
        let site = &system.network.slides[slide];
        let start = system.network.branches[site.branch].points.start;
        state.rest_lengths[start..start + site.node].iter().sum()
    }

    /// Stop that a running constraint (index in [`Network::slides`]) is driven against; `None` if it is not at a stop.
    /// `gradient` is the whole gradient at the state of the last [`crate::Problem::update_held`].
    pub fn stop(&self, system: System<'_>, slide: usize, gradient: &Tangent) -> Option<SlideStop> {
        let found = self.slides.iter().find(|s| s.index == slide)?;
        let g = gradient.slides[slide];
        let running = matches!(system.conditions.sliding[slide], Sliding::Running { .. });
        (running && found.is_stopped(g)).then_some(found.stops[usize::from(g < 0.0)])
    }

    /// Whether the cable slips against friction in a sliding constraint that acts.
    pub fn slips(&self, system: System<'_>, slide: usize) -> bool {
        let site = &system.network.slides[slide];
        site.friction > 0.0
            && system.conditions.active[site.constraint]
            && system.conditions.sliding[slide] != Sliding::Stuck
    }

    /// Whether a slipping constraint has moved from `before` to `state` opposite to the direction of its slip, or not
    /// at all.
    pub fn slips_backward(&self, system: System<'_>, slide: usize, before: &State, state: &State) -> bool {
        let Sliding::Running { force } = system.conditions.sliding[slide] else { return false };
        let (from, to) = (self.arc_length(system, slide, before), self.arc_length(system, slide, state));
        self.slips(system, slide) && force.signum() * (to - from) <= STANDSTILL * to
    }

    /// Result of a sliding constraint that acts; `gradient` is the whole gradient at `state`.
    pub fn result(&self, system: System<'_>, slide: usize, state: &State, gradient: &Tangent) -> SlideResult {
        let site = &system.network.slides[slide];
        let (motion, friction) = match system.conditions.sliding[slide] {
            _ if self.stop(system, slide, gradient).is_some() => (SlideMotion::Stopped, 0.0),
            Sliding::Stuck => (SlideMotion::Stick, 0.0),
            Sliding::Running { force } if site.friction > 0.0 => (SlideMotion::Slip, force),
            Sliding::Running { .. } => (SlideMotion::Free, 0.0),
        };
        SlideResult {
            branch: system.network.branches[site.branch].name.clone(),
            arc_length: self.arc_length(system, slide, state),
            // gradient = ∂E/∂s + friction, and the constraint exerts −∂E/∂s on the cable.
            axial_force: if motion == SlideMotion::Free { 0.0 } else { friction - gradient.slides[slide] },
            motion,
        }
    }

    /// Updates the remaining travel of each sliding constraint at `state`.
    pub fn update_travel(&mut self, network: &Network, state: &State) {
        for slide in &mut self.slides {
            slide.travel = [0, 1].map(|side| slide.length(state, network, side) - slide.least[side]);
        }
    }

    /// Sets the entries of slides that stick or are at a stop to zero.
    pub fn project(&self, system: System<'_>, gradient: &mut Tangent) {
        for slide in &self.slides {
            let g = &mut gradient.slides[slide.index];
            if system.conditions.sliding[slide.index] == Sliding::Stuck || slide.is_stopped(*g) {
                *g = 0.0;
            }
        }
    }

    /// `to = from ⊕ α step`: [`Network::retract`], and the mesh moves along the cable at sliding constraints.
    pub fn retract(&self, system: System<'_>, from: &State, step: &Tangent, alpha: f64, to: &mut State) {
        system.network.retract(from, step, alpha, to);
        for slide in self.slides.iter().filter(|slide| step.slides[slide.index] != 0.0) {
            let branch = &system.network.branches[slide.branch];
            let start = branch.points.start;
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let rate = sign * alpha * step.slides[slide.index] / slide.length(from, system.network, side);
                for j in slide.sides[side].clone() {
                    to.rest_lengths[start + j] += from.rest_lengths[start + j] * rate;
                }
            }
            system.network.couple(slide.branch, to);
        }
    }

    /// Largest fraction of a step that keeps every constraint within its stops and every side at a quarter of its
    /// length at least.
    pub fn largest_fraction(&self, system: System<'_>, state: &State, step: &Tangent) -> f64 {
        let mut fraction = 1.0_f64;
        for slide in &self.slides {
            let (ds, side) = (step.slides[slide.index], usize::from(step.slides[slide.index] > 0.0));
            let travel = slide.travel[side].max(0.0).min(0.75 * slide.length(state, system.network, side));
            // Two constraints may both shorten the segments between them.
            let twice = self.slides.iter().any(|other| other.sides[1 - side] == slide.sides[side]);
            let travel = if twice { 0.5 * travel } else { travel };
            if ds.abs() > travel {
                fraction = fraction.min(travel / ds.abs());
            }
        }
        fraction
    }

    /// Writes dℓ_j/ds and dλ_c/ds of a slide.
    fn rates(
        &self,
        system: System<'_>,
        slide: &ActiveSlide,
        state: &State,
        segments: &mut Vec<f64>,
        couplings: &mut Vec<f64>,
    ) {
        let branch = &system.network.branches[slide.branch];
        let mesh = branch.rod.mesh();
        segments.clear();
        segments.resize(mesh.segments(), 0.0);
        couplings.clear();
        couplings.resize(mesh.coupling_lengths.len(), 0.0);
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let length = slide.length(state, system.network, side);
            for j in slide.sides[side].clone() {
                segments[j] = sign * state.rest_lengths[branch.points.start + j] / length;
            }
        }
        mesh.couple(segments, couplings);
    }

    /// Writes ∂E/∂s of every sliding constraint that acts, plus the friction force F, into `gradient`. Returns the
    /// work of friction Σ F s, J.
    pub fn gradient(&mut self, system: System<'_>, rods: &RodTerm, state: &State, gradient: &mut Tangent) -> f64 {
        gradient.slides.fill(0.0);
        let mut terms = std::mem::take(&mut self.scratch);
        let mut work = 0.0;
        for slide in &self.slides {
            Self::fill_terms(system, rods, slide.branch, state, &mut terms);
            let LengthTerms { segments, couplings, segment_rates: [a, _], coupling_rates: [b, _] } = &mut terms;
            self.rates(system, slide, state, a, b);
            let of_segments: f64 = a.iter().zip(segments).map(|(rate, t)| rate * t[0]).sum();
            let of_couplings: f64 = b.iter().zip(couplings).map(|(rate, t)| rate * t[0]).sum();
            let mut g = of_segments + of_couplings;
            weights(system, slide.branch, a, |point, force| g -= force.dot(&state.points[point]));
            let rotation = &system.conditions.rotation;
            if rotation.is_moving() {
                masses(system, slide.branch, a, |point, mass| g += mass * rotation.potential(&state.points[point]));
            }
            if let Sliding::Running { force } = system.conditions.sliding[slide.index] {
                g += force;
                if force != 0.0 {
                    work += force * self.arc_length(system, slide.index, state);
                }
            }
            gradient.slides[slide.index] = g;
        }
        self.scratch = terms;
        work
    }

    fn fill_terms(system: System<'_>, rods: &RodTerm, branch: usize, state: &State, terms: &mut LengthTerms) {
        let rod = &system.network.branches[branch].rod;
        terms.segments.resize(rod.mesh().segments(), [0.0; 2]);
        terms.couplings.resize(rod.mesh().coupling_lengths.len(), [0.0; 3]);
        rod.length_terms(&rods.shape(system, state, branch), &mut terms.segments, &mut terms.couplings);
    }

    /// Second derivatives in the arc lengths of the running constraints at `state`,
    /// `∂²E/∂s_a∂s_b = Σ_j ℓ_j,a ℓ_j,b ∂²E/∂ℓ_j² + Σ_c λ_c,a λ_c,b ∂²E/∂λ_c² + Σ_c (λ_c,a λ_{c+1},b + λ_{c+1},a λ_c,b)
    /// ∂²E/∂λ_c∂λ_{c+1}` with the rates `ℓ_j,a = dℓ_j/ds_a`, which do not change with s, and the mixed `∂²E/∂s∂(x, θ)`.
    /// `gradient` is the whole gradient.
    pub fn hessian(
        &mut self,
        system: System<'_>,
        rods: &RodTerm,
        state: &State,
        gradient: &Tangent,
        hessian: &mut SlideHessian,
    ) {
        let runs = |slide: &ActiveSlide| {
            system.conditions.sliding[slide.index] != Sliding::Stuck && !slide.is_stopped(gradient.slides[slide.index])
        };
        let running: Vec<usize> = (0..self.slides.len()).filter(|&k| runs(&self.slides[k])).collect();
        hessian.running.clear();
        hessian.running.extend(running.iter().map(|&k| self.slides[k].index));
        hessian.mixed.resize_with(running.len().max(hessian.mixed.len()), || Tangent::zeros(system.network));
        hessian.own.clear();
        hessian.own.resize(running.len() * running.len(), 0.0);
        let mut terms = std::mem::take(&mut self.scratch);
        for (row, &k) in running.iter().enumerate() {
            let slide = &self.slides[k];
            let branch = &system.network.branches[slide.branch];
            Self::fill_terms(system, rods, slide.branch, state, &mut terms);
            let LengthTerms { segments, couplings, segment_rates, coupling_rates } = &mut terms;
            let ([a, other_a], [b, other_b]) = (segment_rates, coupling_rates);
            self.rates(system, slide, state, a, b);
            let mixed = &mut hessian.mixed[row];
            mixed.clear();
            branch.rod.length_mixed(
                &rods.shape(system, state, slide.branch),
                a,
                b,
                &mut mixed.points[branch.points.clone()],
                &mut mixed.frames[branch.frames.clone()],
            );
            weights(system, slide.branch, a, |point, force| mixed.points[point] -= force);
            let rotation = &system.conditions.rotation;
            if rotation.is_moving() {
                masses(system, slide.branch, a, |i, mass| mixed.points[i] -= rotation.pull(&state.points[i]) * mass);
            }
            system.network.pull_back(state, mixed);
            for (column, &other) in
                running.iter().enumerate().filter(|(_, other)| self.slides[**other].branch == slide.branch)
            {
                self.rates(system, &self.slides[other], state, other_a, other_b);
                let of_segments: f64 = a.iter().zip(&*other_a).zip(&*segments).map(|((x, y), t)| x * y * t[1]).sum();
                let pairs = b.iter().zip(&*other_b).zip(&*couplings);
                let of_couplings: f64 = pairs.clone().map(|((x, y), t)| x * y * t[1]).sum();
                let mixed = pairs.zip(b.iter().zip(&*other_b).skip(1));
                let of_neighbours: f64 =
                    mixed.map(|(((x, y), t), (next_x, next_y))| (x * next_y + next_x * y) * t[2]).sum();
                hessian.own[row * running.len() + column] = of_segments + of_couplings + of_neighbours;
            }
        }
        self.scratch = terms;
    }
}
