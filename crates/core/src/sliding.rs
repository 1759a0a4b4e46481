//! Fixings that the cable runs through.
//!
//! The station stays at the fixing and the mesh moves along the cable: as the arc length s at the fixing grows, the rest lengths
//! before it grow and those after it shrink, up to the next place that is tied to the material. So s is one more variable of a smooth
//! energy, `dℓ_j/ds = ±ℓ_j/L` with L the length that takes part; nothing jumps as material passes a node. At rest without friction
//! `∂E/∂s`, the difference of the configurational forces on either side, vanishes (Bigoni, Dal Corso, Bosi, Misseroni 2015:
//! the "Eshelby-like" force of a sliding sleeve; for a ring it makes the tensions equal).

use crate::Mounting;
use crate::equilibrium::{SlideMotion, SlideResult};
use crate::network::{BranchEnd, Place};
use crate::problem::{Problem, STATION_SHIFT};
use crate::rotation::columns;
use crate::{Network, State, Tangent, Vector};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Length (in diameters of the cable) that stays on either side of a sliding fixing: what is left there counts as run out.
const LEAST_LENGTH: f64 = 0.1;
/// The same as a share of the unstretched span.
const LEAST_SHARE: f64 = 0.01;
/// Coulomb's law is met to this share of its limit.
const FRICTION_TOLERANCE: f64 = 1e-4;
/// A motion of less than this share of the arc length is none.
const STANDSTILL: f64 = 1e-9;
/// Room (as a share of the length that is kept) below which a fixing counts as standing at its stop.
const AT_STOP: f64 = 1e-6;

/// How a fixing slides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Sliding {
    /// It does not: its arc length stays what it is. What it takes along the cable is a reaction.
    Stuck,
    /// The cable runs. `force` (N) acts on the arc length against the motion: friction, or 0.
    Running {
        /// Constant generalised force on the arc length: `∂E/∂s + force = 0` at rest, N.
        force: f64,
    },
}

/// What keeps a cable from running on through a fixing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SlideStop {
    /// A free end: the cable runs out of the fixing.
    End,
    /// A joint.
    Joint,
    /// Another fixing, a load, or an end that is held.
    Fixing,
}

/// A fixing that slides, and acts: which part of the cable grows and shrinks with it.
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
    /// How much cable may still run in from either side, m: from the last [`Problem::update_held`].
    room: [f64; 2],
}

impl ActiveSlide {
    /// Length that takes part on a side, m.
    fn length(&self, state: &State, network: &Network, side: usize) -> f64 {
        let start = network.branches[self.branch].points.start;
        state.rest_lengths[start..][self.sides[side].clone()].iter().sum()
    }

    /// Whether a force of this sign on s meets a stop: a negative `gradient` drives s up, into what is after it.
    fn is_stopped(&self, gradient: f64) -> bool {
        self.room[usize::from(gradient < 0.0)] <= AT_STOP * self.least[usize::from(gradient < 0.0)]
    }
}

/// Second derivatives of the energy in the arc lengths of the fixings that slide.
#[derive(Clone, Debug, Default)]
pub struct SlideHessian {
    /// For each running fixing: its index in [`Network::slides`].
    pub running: Vec<usize>,
    /// For each running fixing `∂²E/∂s∂(x, θ)` in the independent variables.
    pub mixed: Vec<Tangent>,
    /// `∂²E/∂s_a∂s_b`, N/m, row by row.
    pub own: Vec<f64>,
}

/// Room for what a rod says of its lengths.
#[derive(Default)]
pub(crate) struct LengthTerms {
    segments: Vec<[f64; 2]>,
    couplings: Vec<[f64; 2]>,
    segment_rates: [Vec<f64>; 2],
    coupling_rates: [Vec<f64>; 2],
}

impl Problem<'_> {
    /// Finds the fixings that slide and act, and how far each may.
    pub(crate) fn find_slides(&mut self) {
        let network = self.network;
        self.slides.clear();
        for (index, site) in network.slides.iter().enumerate() {
            if !self.conditions().active[site.fixing] {
                continue;
            }
            let branch = &network.branches[site.branch];
            let mesh = branch.rod.mesh();
            let knots = self.knots(site.branch);
            let place = knots.partition_point(|&node| node < site.node);
            let neighbours = [knots[place - 1], knots[place + 1]];
            let (mut stops, mut least) = ([SlideStop::Fixing; 2], [0.0; 2]);
            let mut sides = [neighbours[0]..site.node, site.node..neighbours[1]];
            for (side, end) in [(0, branch.start), (1, branch.end)] {
                let last = [0, mesh.segments()][side];
                let held = network.fixings.iter().enumerate().any(|(f, fixing)| {
                    self.conditions().active[f]
                        && fixing.places.contains(&Place::Node { branch: site.branch, node: last })
                });
                least[side] = (LEAST_LENGTH * branch.section.diameter)
                    .min(LEAST_SHARE * mesh.rest_lengths[sides[side].clone()].iter().sum::<f64>());
                if neighbours[side] != last {
                    continue;
                }
                match end {
                    BranchEnd::Free if !held => stops[side] = SlideStop::End,
                    BranchEnd::Free => {}
                    BranchEnd::Joint { joint, .. } => {
                        stops[side] = SlideStop::Joint;
                        // The joint's energy knows the length of the first segment of each arm: that one stays.
                        if network.joints[joint].model.mounting() == Mounting::Point {
                            sides[0].start += usize::from(side == 0);
                            sides[1].end -= usize::from(side == 1);
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
                room: [f64::INFINITY; 2],
            });
        }
    }

    /// The nodes of a branch that are tied to the material or to space: ends, fixings that act, loads. Increasing.
    pub fn knots(&self, branch: usize) -> Vec<usize> {
        let network = self.network;
        let points = &network.branches[branch].points;
        let acting = network.fixings.iter().zip(&self.conditions().active).filter(|(_, active)| **active);
        let of_fixings = acting.flat_map(|(fixing, _)| &fixing.places).filter_map(|place| match place {
            Place::Node { branch: b, node } if *b == branch => Some(*node),
            _ => None,
        });
        let of_loads =
            network.loads.iter().filter(|load| points.contains(&load.point)).map(|load| load.point - points.start);
        let mut knots: Vec<usize> = of_fixings.chain(of_loads).chain([0, points.len() - 1]).collect();
        knots.sort_unstable();
        knots.dedup();
        knots
    }

    /// Whether any fixing slides.
    pub fn slides_any(&self) -> bool {
        !self.slides.is_empty()
    }

    /// Arc length at a fixing that slides (index in [`Network::slides`]), m.
    pub fn slide_arc_length(&self, slide: usize, state: &State) -> f64 {
        let site = &self.network.slides[slide];
        let start = self.network.branches[site.branch].points.start;
        state.rest_lengths[start..start + site.node].iter().sum()
    }

    /// What a fixing (index in [`Network::slides`]) that the cable wants to run through stands at, if it does: `gradient` is the
    /// whole gradient at the state of the last [`Problem::update_held`].
    pub fn slide_stop(&self, slide: usize, gradient: &Tangent) -> Option<SlideStop> {
        let found = self.slides.iter().find(|s| s.index == slide)?;
        let g = gradient.slides[slide];
        let running = matches!(self.conditions().sliding[slide], Sliding::Running { .. });
        (running && found.is_stopped(g)).then_some(found.stops[usize::from(g < 0.0)])
    }

    /// Whether the cable slips in a fixing that acts, against friction.
    pub fn slips(&self, slide: usize) -> bool {
        let site = &self.network.slides[slide];
        site.friction > 0.0 && self.conditions.active[site.fixing] && self.conditions.sliding[slide] != Sliding::Stuck
    }

    /// Whether what slips has come from `before` to `state` the other way than its friction says, or stood still.
    pub fn slips_backward(&self, slide: usize, before: &State, state: &State) -> bool {
        let Sliding::Running { force } = self.conditions.sliding[slide] else { return false };
        let (from, to) = (self.slide_arc_length(slide, before), self.slide_arc_length(slide, state));
        self.slips(slide) && force.signum() * (to - from) <= STANDSTILL * to
    }

    /// Coulomb's law at the balanced `state` with whole gradient `gradient`: what a fixing takes along the cable, `|∂E/∂s|`, is at most μ
    /// times what it takes across. What sticks beyond that slips, and what slips meets the friction of its present pressure. Returns
    /// whether anything had to be changed: then the state is not balanced any more.
    pub fn update_friction(&mut self, state: &State, gradient: &Tangent) -> bool {
        let mut changed = false;
        for k in 0..self.slides.len() {
            let index = self.slides[k].index;
            let friction = self.network.slides[index].friction;
            if friction == 0.0 {
                continue;
            }
            let limit = friction * self.pressure(index, state, gradient);
            let tolerance = FRICTION_TOLERANCE * limit.max(self.scales().force * FRICTION_TOLERANCE);
            match self.conditions().sliding[index] {
                Sliding::Stuck if gradient.slides[index].abs() > limit + tolerance => {
                    self.set_sliding(index, Sliding::Running { force: -limit.copysign(gradient.slides[index]) });
                    changed = true;
                }
                Sliding::Running { force } if (force.abs() - limit).abs() > tolerance => {
                    self.set_sliding(index, Sliding::Running { force: limit.copysign(force) });
                    changed = true;
                }
                _ => {}
            }
        }
        changed
    }

    /// What a fixing that slides takes across the cable, N.
    fn pressure(&self, slide: usize, state: &State, gradient: &Tangent) -> f64 {
        let fixing = self.network.slides[slide].fixing;
        let (force, _) = self.reaction(fixing, state, gradient);
        let tangent = columns(&state.pose(&self.network.fixings[fixing].site).orientation)[2];
        (force - tangent * tangent.dot(&force)).norm()
    }

    /// What the cable does in a fixing that slides, and acts: `gradient` is the whole gradient at `state`.
    pub fn slide_result(&self, slide: usize, state: &State, gradient: &Tangent) -> SlideResult {
        let site = &self.network.slides[slide];
        let (motion, friction) = match self.conditions().sliding[slide] {
            _ if self.slide_stop(slide, gradient).is_some() => (SlideMotion::Stopped, 0.0),
            Sliding::Stuck => (SlideMotion::Stick, 0.0),
            Sliding::Running { force } if site.friction > 0.0 => (SlideMotion::Slip, force),
            Sliding::Running { .. } => (SlideMotion::Free, 0.0),
        };
        SlideResult {
            branch: self.network.branches[site.branch].name.clone(),
            arc_length: self.slide_arc_length(slide, state),
            // gradient = ∂E/∂s + friction, and the fixing exerts −∂E/∂s on the cable.
            axial_force: if motion == SlideMotion::Free { 0.0 } else { friction - gradient.slides[slide] },
            motion,
        }
    }

    /// How far each fixing may still slide at `state`.
    pub(crate) fn update_room(&mut self, state: &State) {
        let network = self.network;
        for slide in &mut self.slides {
            slide.room = [0, 1].map(|side| slide.length(state, network, side) - slide.least[side]);
        }
    }

    /// Sets the entries of slides that do not run, or stand at a stop, to zero.
    pub(crate) fn free_slides(&self, gradient: &mut Tangent) {
        for slide in &self.slides {
            let g = &mut gradient.slides[slide.index];
            if self.conditions().sliding[slide.index] == Sliding::Stuck || slide.is_stopped(*g) {
                *g = 0.0;
            }
        }
    }

    /// `to = from ⊕ α step`: [`Network::retract`], and the mesh moves along the cable where fixings slide.
    pub fn retract(&self, from: &State, step: &Tangent, alpha: f64, to: &mut State) {
        self.network.retract(from, step, alpha, to);
        for slide in self.slides.iter().filter(|slide| step.slides[slide.index] != 0.0) {
            let branch = &self.network.branches[slide.branch];
            let start = branch.points.start;
            for (side, sign) in [(0, 1.0), (1, -1.0)] {
                let rate = sign * alpha * step.slides[slide.index] / slide.length(from, self.network, side);
                for j in slide.sides[side].clone() {
                    to.rest_lengths[start + j] += from.rest_lengths[start + j] * rate;
                }
            }
            self.network.couple(slide.branch, to);
        }
    }

    /// Largest share of a step that leaves every fixing within its stops and no span shorter than a quarter.
    pub fn largest_slide(&self, state: &State, step: &Tangent) -> f64 {
        let mut share = 1.0_f64;
        for slide in &self.slides {
            let (ds, side) = (step.slides[slide.index], usize::from(step.slides[slide.index] > 0.0));
            let room = slide.room[side].max(0.0).min(0.75 * slide.length(state, self.network, side));
            // Two that share a span may both eat from it.
            let twice = self.slides.iter().any(|other| other.sides[1 - side] == slide.sides[side]);
            let room = if twice { 0.5 * room } else { room };
            if ds.abs() > room {
                share = share.min(room / ds.abs());
            }
        }
        share
    }

    /// dℓ_j/ds and dλ_c/ds of a slide.
    fn rates(&self, slide: &ActiveSlide, state: &State, segments: &mut Vec<f64>, couplings: &mut Vec<f64>) {
        let branch = &self.network.branches[slide.branch];
        let mesh = branch.rod.mesh();
        segments.clear();
        segments.resize(mesh.segments(), 0.0);
        couplings.clear();
        couplings.resize(mesh.coupling_lengths.len(), 0.0);
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let length = slide.length(state, self.network, side);
            for j in slide.sides[side].clone() {
                segments[j] = sign * state.rest_lengths[branch.points.start + j] / length;
            }
        }
        mesh.couple(segments, couplings);
    }

    /// ∂E/∂s of every fixing that slides, friction included, into `gradient`. Returns the work that friction is charged with, J.
    pub(crate) fn slide_gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        gradient.slides.fill(0.0);
        let mut room = std::mem::take(&mut self.length_terms);
        let mut work = 0.0;
        for slide in &self.slides {
            self.fill_terms(slide.branch, state, &mut room);
            let LengthTerms { segments, couplings, segment_rates: [a, _], coupling_rates: [b, _] } = &mut room;
            self.rates(slide, state, a, b);
            let sum =
                |rates: &[f64], terms: &[[f64; 2]]| -> f64 { rates.iter().zip(terms).map(|(r, t)| r * t[0]).sum() };
            let mut g = sum(a, segments) + sum(b, couplings);
            self.for_weights(slide.branch, a, |point, force| g -= force.dot(&state.points[point]));
            if let Sliding::Running { force } = self.conditions().sliding[slide.index] {
                g += force;
                if force != 0.0 {
                    work += force * self.slide_arc_length(slide.index, state);
                }
            }
            gradient.slides[slide.index] = g;
        }
        self.length_terms = room;
        work
    }

    fn fill_terms(&self, branch: usize, state: &State, room: &mut LengthTerms) {
        let rod = &self.network.branches[branch].rod;
        room.segments.resize(rod.mesh().segments(), [0.0; 2]);
        room.couplings.resize(rod.mesh().coupling_lengths.len(), [0.0; 2]);
        rod.length_terms(&self.shape(state, branch), &mut room.segments, &mut room.couplings);
    }

    /// Second derivatives in the arc lengths of the fixings that may run at `state`, where `gradient` is the whole gradient.
    pub fn slide_hessian(&mut self, state: &State, gradient: &Tangent, hessian: &mut SlideHessian) {
        let runs = |slide: &ActiveSlide| {
            self.conditions().sliding[slide.index] != Sliding::Stuck && !slide.is_stopped(gradient.slides[slide.index])
        };
        let running: Vec<usize> = (0..self.slides.len()).filter(|&k| runs(&self.slides[k])).collect();
        hessian.running.clear();
        hessian.running.extend(running.iter().map(|&k| self.slides[k].index));
        hessian.mixed.resize_with(running.len().max(hessian.mixed.len()), || Tangent::zeros(self.network));
        hessian.own.clear();
        hessian.own.resize(running.len() * running.len(), 0.0);
        let mut room = std::mem::take(&mut self.length_terms);
        for (row, &k) in running.iter().enumerate() {
            let slide = &self.slides[k];
            let branch = &self.network.branches[slide.branch];
            self.fill_terms(slide.branch, state, &mut room);
            let LengthTerms { segments, couplings, segment_rates, coupling_rates } = &mut room;
            let ([a, other_a], [b, other_b]) = (segment_rates, coupling_rates);
            self.rates(slide, state, a, b);
            let mixed = &mut hessian.mixed[row];
            mixed.clear();
            branch.rod.length_mixed(
                &self.shape(state, slide.branch),
                a,
                b,
                &mut mixed.points[branch.points.clone()],
                &mut mixed.frames[branch.frames.clone()],
            );
            self.for_weights(slide.branch, a, |point, force| mixed.points[point] -= force);
            self.network.pull_back(state, mixed);
            for (column, &other) in
                running.iter().enumerate().filter(|(_, other)| self.slides[**other].branch == slide.branch)
            {
                self.rates(&self.slides[other], state, other_a, other_b);
                let sum = |x: &[f64], y: &[f64], terms: &[[f64; 2]]| -> f64 {
                    x.iter().zip(y).zip(terms).map(|((x, y), t)| x * y * t[1]).sum()
                };
                hessian.own[row * running.len() + column] = sum(a, other_a, segments) + sum(b, other_b, couplings);
            }
        }
        self.length_terms = room;
    }

    /// Weight of segments of these rest lengths (m), lumped at nodes: half of each segment's weight at either of its nodes, but
    /// see [`STATION_SHIFT`].
    pub(crate) fn for_weights(&self, branch: usize, rest_lengths: &[f64], mut add: impl FnMut(usize, Vector)) {
        let branch = &self.network.branches[branch];
        let start = branch.points.start;
        let density = self.conditions().gravity * branch.section.linear_density;
        for (j, l) in rest_lengths.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            add(start + j, density * (0.5 * l));
            add(start + j + 1, density * (0.5 * l));
        }
        for beside in &branch.rod.mesh().beside {
            let j = beside.segment;
            let shifted = density * (rest_lengths[j] * STATION_SHIFT);
            for (from, station) in [j, j + 1].into_iter().zip(beside.stations) {
                if station.is_some() {
                    add(start + from, -shifted);
                    add(start + 2 * j + 1 - from, shifted);
                }
            }
        }
    }
}

impl Network {
    /// Moves the mesh of a branch along the cable, points and frames being interpolated: `knots` (increasing nodes, both ends among
    /// them) come to the given arc lengths (m), and between them the mesh is divided as it was built. Returns false, and does nothing,
    /// where the arc lengths do not increase.
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
                let share = (built[node] - built[a]) / (built[b] - built[a]);
                new[node] = if node == b { to } else { from + (to - from) * share };
            }
        }
        let points: Vec<Vector> = branch.points.clone().map(|i| state.points[i] + state.carry[i]).collect();
        let frames = state.frames[branch.frames.clone()].to_vec();
        let (old_places, new_places) = (mesh.frame_places(&old), mesh.frame_places(&new));
        for (node, s) in new.iter().enumerate().filter(|(node, s)| **s != old[*node]) {
            let i = branch.points.start + node;
            state.points[i] = point_at(&old, &points, *s);
            state.carry[i] = Vector::zeros();
        }
        for (c, s) in new_places.iter().enumerate().filter(|(c, s)| **s != old_places[*c]) {
            let k = old_places.partition_point(|place| place <= s).clamp(1, frames.len() - 1);
            let share = (s - old_places[k - 1]) / (old_places[k] - old_places[k - 1]);
            let between = frames[k - 1].try_slerp(&frames[k], share.clamp(0.0, 1.0), 1e-12);
            state.frames[branch.frames.start + c] = between.unwrap_or(frames[k]);
        }
        for (j, pair) in new.windows(2).enumerate() {
            state.rest_lengths[branch.points.start + j] = pair[1] - pair[0];
        }
        self.couple(branch_index, state);
        true
    }

    /// Makes the coupling lengths of a branch those of its rest lengths.
    pub(crate) fn couple(&self, branch: usize, state: &mut State) {
        let branch = &self.branches[branch];
        let mesh = branch.rod.mesh();
        let lengths = &state.rest_lengths[branch.points.start..][..mesh.segments()];
        mesh.couple(lengths, &mut state.coupling_lengths[branch.frames.start..][..mesh.coupling_lengths.len()]);
    }
}

/// The point at arc length `s` of a curve through `points` at arc lengths `places`: cubic, with the mean of the neighbouring slopes.
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
