//! Weight of fixed meshes, masses of joints, and loads ([`crate::load`]): `E = −Σ f·x` of dead forces.
//!
//! Forces per length act on segments and are lumped at their nodes, as weight is. What has no potential adds its
//! generalised forces to the gradient, but nothing to the energy, and [`crate::Problem::hessian`] does not contain its
//! derivatives; they are blocks with the columns of one frame R each ([`LoadTangent`], [`SegmentTangent`]). With force
//! f and moment m at a place in the axes of its frame (of a dead moment M it is `Rᵀ M`), and their derivatives f′, m′
//! along `R ∘ exp(θ)` (`[m]ₓ` of a dead moment, 0 of a follower):
//!
//! | load | gradient | derivative along `R ∘ exp(θ)` |
//! | --- | --- | --- |
//! | force at a place | `−R f` on x | `R ([f]ₓ − f′)` on x |
//! | moment at a place | `−m` on θ | `½ [m]ₓ − m′` on θ |
//! | force per length f(R) | `−ℓ f` on x | `−ℓ ∂f/∂θ` on x |
//!
//! Derivatives on θ are pulled back to θ, as all second derivatives are: that of a covector r in the axes of the frame
//! is its change less `½ r × θ`.

use super::gravity;
use crate::conditions::System;
use crate::load::{Axes, LineLoad, LoadAction, PointLoad};
use crate::network::NodeRange;
use crate::rotation::skew;
use crate::variable::Variable;
use crate::{Matrix, Network, Pose, Rotation, State, Tangent, Vector};
use std::sync::Arc;

/// Term of the loads.
pub struct LoadTerm {
    /// Dead force at every point, N; without the weight of branches whose mesh may move along the cable.
    forces: Vec<Vector>,
    /// What has no potential at places.
    places: Vec<AtPlace>,
    /// What has no potential along parts of branches.
    parts: Vec<AlongPart>,
    /// Active fraction of what has no potential.
    fraction: f64,
}

/// Load without a potential at a place.
struct AtPlace {
    load: Arc<dyn PointLoad>,
    /// Its factor, with the active fraction.
    factor: f64,
    /// Index of the independent point.
    point: usize,
    /// Index of the independent frame.
    frame: usize,
    /// Pose of the place relative to them.
    local: Pose,
}

/// Load without a potential along a part of a branch.
struct AlongPart {
    load: Arc<dyn LineLoad>,
    /// Diameter of the cable, m.
    diameter: f64,
    /// The segments: index of the frame, and points at which the load is lumped, with the factor on the force per
    /// length, m.
    segments: Vec<(usize, Lumps)>,
}

/// Most segments for which a load is asked at once.
const AT_ONCE: usize = 64;

impl AtPlace {
    /// Force and moment in the axes of the frame, at its point.
    fn exerted(&self, frame: &Rotation) -> [Vector; 2] {
        let Self { load, factor, local, .. } = self;
        let of_load = load.on(&(frame * local.orientation));
        let [force, moment] = of_load.map(|v| match load.axes() {
            Axes::World => frame.inverse_transform_vector(&(v * *factor)),
            Axes::Frame => local.orientation * v * *factor,
        });
        [force, moment + local.position.cross(&force)]
    }

    /// Their derivatives along `frame ∘ exp(θ)`.
    fn derivatives(&self, frame: &Rotation) -> [Matrix; 2] {
        let Self { load, factor, local, .. } = self;
        let (a, r) = (local.orientation.to_rotation_matrix(), frame.to_rotation_matrix());
        let place = frame * local.orientation;
        let (values, derivatives) = (load.on(&place), load.derivative(&place));
        let [force, moment] = [0, 1].map(|k| {
            let derivative = derivatives[k] * a.matrix().transpose() * *factor;
            match load.axes() {
                Axes::World => {
                    let turns = skew(&frame.inverse_transform_vector(&(values[k] * *factor)));
                    turns + r.matrix().transpose() * derivative
                }
                Axes::Frame => a.matrix() * derivative,
            }
        });
        [force, moment + skew(&local.position) * force]
    }

    /// Largest moment that it can have, N m.
    fn largest_moment(&self) -> f64 {
        let now = self.exerted(&Rotation::identity())[1].norm();
        let largest = self.load.largest()[1] * self.factor.abs();
        // The two differ by round-off where it is the same in all frames.
        if largest > now * (1.0 + 1e-12) { largest } else { now }
    }
}

impl AlongPart {
    /// Calls `take` for each segment with its lumps and what `ask` writes for its frame; the load is asked for many
    /// segments at once.
    fn each<T: Copy>(
        &self,
        state: &State,
        zero: T,
        ask: impl Fn(&dyn LineLoad, &[Rotation], &mut [T]),
        mut take: impl FnMut(usize, &Lumps, T),
    ) {
        let (mut frames, mut values) = ([Rotation::identity(); AT_ONCE], [zero; AT_ONCE]);
        for segments in self.segments.chunks(AT_ONCE) {
            let (frames, values) = (&mut frames[..segments.len()], &mut values[..segments.len()]);
            for (frame, (index, _)) in frames.iter_mut().zip(segments) {
                *frame = state.frames[*index];
            }
            ask(self.load.as_ref(), frames, values);
            for ((frame, lumps), value) in segments.iter().zip(values) {
                take(*frame, lumps, *value);
            }
        }
    }

    fn each_force(&self, state: &State, mut take: impl FnMut(&Lumps, Vector)) {
        let ask = |load: &dyn LineLoad, frames: &[Rotation], forces: &mut [Vector]| {
            load.on_all(frames, self.diameter, forces);
        };
        self.each(state, Vector::zeros(), ask, |_, lumps, force| take(lumps, force));
    }
}

/// Indices of points with lengths of cable, m; a length is 0 where fewer points take part.
type Lumps = [(usize, f64); LUMPS];

/// Most points at which the load of a segment is lumped.
const LUMPS: usize = 4;

/// Derivative of the gradient of a load at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadTangent {
    /// Independent variable of its rows.
    pub row: Variable,
    /// Index of the independent frame of its columns.
    pub frame: usize,
    /// The block: N (rows a point) or N m (rows a frame) per rad.
    pub block: Matrix,
}

/// Derivative of the gradient of a force per length on a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentTangent {
    /// Index of the frame of its columns.
    pub frame: usize,
    /// Blocks with the points of their rows, which may be tied, N/rad.
    pub blocks: [(usize, Matrix); LUMPS],
}

impl LoadTerm {
    /// Term without loads; see [`Self::update`].
    pub fn new(network: &Network) -> Self {
        Self {
            forces: vec![Vector::zeros(); network.points],
            places: Vec::with_capacity(network.loads.len()),
            parts: Vec::new(),
            fraction: 1.0,
        }
    }

    /// Recomputes the lumped weights and loads, after a change of the conditions.
    pub fn update(&mut self, system: System<'_>) {
        let Self { forces, places, parts, fraction } = self;
        forces.fill(Vector::zeros());
        gravity::fixed_weights(system, |point, force| forces[point] += force);
        places.clear();
        parts.clear();
        for joint in &system.network.joints {
            forces[joint.point] += system.conditions.gravity * joint.mass;
        }
        for (own, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
            match &own.action {
                LoadAction::At { place, load } => forces[place.point] += load.dead_force() * *factor,
                LoadAction::Along { load, .. } => {
                    let force = load.dead_force();
                    if force != Vector::zeros() {
                        each_segment(system, &own.action, |_, lumps| {
                            lumps.iter().for_each(|(point, length)| forces[*point] += force * (length * factor));
                        });
                    }
                }
            }
            let factor = *factor * *fraction;
            if factor == 0.0 || own.action.without_potential().is_none() {
                continue;
            }
            match &own.action {
                LoadAction::At { place, load } => {
                    let (point, local) = (place.site.point, place.site.local);
                    places.extend(place.site.frame.map(|frame| AtPlace {
                        load: load.clone(),
                        factor,
                        point,
                        frame,
                        local,
                    }));
                }
                LoadAction::Along { spans, load } => {
                    let spans = spans.iter().flat_map(|span| of_one_section(system, span));
                    parts.extend(spans.map(|(diameter, span)| {
                        let mut segments = Vec::with_capacity(span.nodes.len());
                        each_segment_of(system, &span, |frame, lumps| {
                            segments.push((frame, lumps.map(|(point, length)| (point, length * factor))));
                        });
                        AlongPart { load: load.clone(), diameter, segments }
                    }));
                }
            }
        }
    }

    /// Dead force at every point of the state, N: weight and loads, also at points tied to a joint. Without the weight
    /// of branches whose mesh may move along the cable.
    pub fn forces(&self) -> &[Vector] {
        &self.forces
    }

    /// Whether all loads that act have a potential.
    pub fn has_potential(&self) -> bool {
        self.places.is_empty() && self.parts.is_empty()
    }

    /// Largest moments of the active loads at places: index of the independent frame, and size, N m.
    pub fn moments(&self) -> impl Iterator<Item = (usize, f64)> {
        self.places.iter().map(|own| (own.frame, own.largest_moment()))
    }

    /// Sets the active fraction of the loads without a potential, 0 to 1; effective from the next [`Self::update`].
    pub fn set_fraction(&mut self, fraction: f64) {
        self.fraction = fraction;
    }

    /// Potential energy of the loads, `−Σ f·x` without weight, J.
    pub fn energy(&self, system: System<'_>, state: &State) -> f64 {
        let mut energy = 0.0;
        for (own, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
            match &own.action {
                LoadAction::At { place, load } => {
                    energy -= factor * load.dead_force().dot(&state.points[place.point]);
                }
                LoadAction::Along { load, .. } => {
                    let force = load.dead_force();
                    if force != Vector::zeros() {
                        each_segment(system, &own.action, |_, lumps| {
                            let work = |(point, length): (usize, f64)| force.dot(&state.points[point]) * length;
                            energy -= factor * lumps.into_iter().map(work).sum::<f64>();
                        });
                    }
                }
            }
        }
        energy
    }

    /// Potential energy of all dead forces, `−Σ f·x` including weight, J.
    pub fn energy_with_weight(&self, state: &State) -> f64 {
        self.forces.iter().zip(&state.points).map(|(f, x)| -f.dot(x)).sum()
    }

    /// Adds the first derivatives `−f` of the dead forces to the gradient, their energy to `energy` (J), and the sum
    /// of its absolute values to `magnitude` (J).
    pub fn force_gradient(&self, state: &State, gradient: &mut Tangent, energy: &mut f64, magnitude: &mut f64) {
        for ((g, x), f) in gradient.points.iter_mut().zip(&state.points).zip(&self.forces) {
            *g -= f;
            let work = f.dot(x);
            *energy -= work;
            *magnitude += work.abs();
        }
    }

    /// Adds the generalised forces of the loads without a potential to the gradient, with tied entries.
    pub fn add_without_potential(&self, state: &State, gradient: &mut Tangent) {
        for own in &self.places {
            let frame = &state.frames[own.frame];
            let [force, moment] = own.exerted(frame);
            gradient.points[own.point] -= frame * force;
            gradient.frames[own.frame] -= moment;
        }
        for own in &self.parts {
            own.each_force(state, |lumps, force| {
                lumps.iter().for_each(|(point, length)| gradient.points[*point] -= force * *length);
            });
        }
    }

    /// Work over a step of the loads without a potential, J, to first order.
    pub fn work_without_potential(&self, state: &State, step: &Tangent, alpha: f64) -> f64 {
        let mut work = 0.0;
        for own in &self.places {
            let frame = &state.frames[own.frame];
            let [force, moment] = own.exerted(frame);
            work += alpha * ((frame * force).dot(&step.points[own.point]) + moment.dot(&step.frames[own.frame]));
        }
        for own in &self.parts {
            own.each_force(state, |lumps, force| {
                let moved: Vector = lumps.iter().map(|(point, length)| step.points[*point] * *length).sum();
                work += alpha * force.dot(&moved);
            });
        }
        work
    }

    /// Derivatives of the loads at places without a potential; see the table above.
    pub fn tangents(&self, state: &State) -> Vec<LoadTangent> {
        let of_place = |own: &AtPlace| {
            let (frame, r) = (own.frame, &state.frames[own.frame]);
            let ([force, moment], [of_force, of_moment]) = (own.exerted(r), own.derivatives(r));
            let turned = r.to_rotation_matrix().matrix() * (skew(&force) - of_force);
            let force = LoadTangent { row: Variable::Point(own.point), frame, block: turned };
            let moment = LoadTangent { row: Variable::Frame(frame), frame, block: skew(&moment) * 0.5 - of_moment };
            [force, moment].into_iter().filter(|tangent| tangent.block != Matrix::zeros())
        };
        self.places.iter().flat_map(of_place).collect()
    }

    /// Derivatives of the forces per length without a potential.
    pub fn segment_tangents(&self, state: &State) -> Vec<SegmentTangent> {
        let mut tangents = Vec::new();
        for own in &self.parts {
            let ask = |load: &dyn LineLoad, frames: &[Rotation], derivatives: &mut [Matrix]| {
                load.derivative_all(frames, own.diameter, derivatives);
            };
            own.each(state, Matrix::zeros(), ask, |frame, lumps, derivative| {
                let blocks = lumps.map(|(point, length)| (point, derivative * -length));
                tangents.push(SegmentTangent { frame, blocks });
            });
        }
        tangents
    }
}

/// Force of the loads along a segment per unstressed length, N/m, world axes.
pub fn along_segment(system: System<'_>, state: &State, branch: usize, segment: usize) -> Vector {
    let mut sum = Vector::zeros();
    let own = &system.network.branches[branch];
    for (load, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
        if let LoadAction::Along { spans, load } = &load.action {
            let acts = |nodes: &std::ops::Range<usize>| nodes.start <= segment && segment + 1 < nodes.end;
            let spans = spans.iter().filter(|span| span.branch == branch && acts(&span.nodes)).count();
            let frame = &state.frames[own.segment_frame(segment)];
            let force = load.dead_force() + load.on(frame, own.sections.of(segment).diameter);
            sum += force * (*factor * spans as f64);
        }
    }
    sum
}

/// Calls `act` for every segment along which a load acts; see [`each_segment_of`].
fn each_segment<P>(system: System<'_>, action: &LoadAction<P, NodeRange>, mut act: impl FnMut(usize, Lumps)) {
    let LoadAction::Along { spans, .. } = action else { return };
    spans.iter().for_each(|span| each_segment_of(system, span, &mut act));
}

/// Parts of a span that have one section, with its diameter, m.
fn of_one_section<'s>(system: System<'s>, span: &NodeRange) -> impl Iterator<Item = (f64, NodeRange)> + 's {
    let NodeRange { branch, nodes } = span.clone();
    system.network.branches[branch].sections.spans().iter().filter_map(move |own| {
        let (start, end) = (nodes.start.max(own.segments.start), (nodes.end - 1).min(own.segments.end));
        (start < end).then(|| (own.section.diameter, NodeRange { branch, nodes: start..end + 1 }))
    })
}

/// Calls `act` for every segment of a span, with its frame, and the points and lengths (m) at which the force per
/// length is lumped.
fn each_segment_of(system: System<'_>, span: &NodeRange, mut act: impl FnMut(usize, Lumps)) {
    let branch = &system.network.branches[span.branch];
    let mesh = branch.rod.mesh();
    for j in span.nodes.start..span.nodes.end - 1 {
        let mut lumps = [(branch.points.start + j, 0.0); LUMPS];
        for (node, fraction) in gravity::lumps(mesh, j) {
            // The first with this point, or without a length yet.
            let point = branch.points.start + node;
            let place = lumps.iter().position(|(own, length)| *own == point || *length == 0.0);
            let lump = &mut lumps[place.expect("no more points than take part")];
            *lump = (point, lump.1 + fraction * mesh.rest_lengths[j]);
        }
        act(branch.segment_frame(j), lumps);
    }
}
