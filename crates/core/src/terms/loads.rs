//! Weight of fixed meshes, masses of joints, and loads ([`crate::load`]): `E = −Σ f·x` of dead forces.
//!
//! Forces per length act on segments and are lumped at their nodes, as weight is. What has no potential adds its
//! generalised forces to the gradient, but nothing to the energy, and [`crate::Problem::hessian`] does not contain its
//! derivatives; they are blocks with the columns of one frame R each ([`LoadTangent`], [`SegmentTangent`]):
//!
//! | load | gradient | derivative along `R ∘ exp(θ)` |
//! | --- | --- | --- |
//! | dead moment M | `−Rᵀ M` on θ | `−½ [Rᵀ M]ₓ` on θ |
//! | follower moment M | `−M` on θ | `½ [M]ₓ` on θ |
//! | follower force F | `−R F` on x | `R [F]ₓ` on x |
//! | force per length f(R) | `−ℓ f` on x | `−ℓ ∂f/∂θ` on x |
//!
//! Derivatives on θ are pulled back to θ, as all second derivatives are: that of a covector r in the axes of the frame
//! is its change less `½ r × θ`.

use super::gravity;
use crate::conditions::System;
use crate::load::{LineForce, LoadAction};
use crate::network::{Branch, NodeRange};
use crate::rotation::skew;
use crate::variable::Variable;
use crate::{Matrix, Network, State, Tangent, Vector};

/// Term of the loads.
pub struct LoadTerm {
    /// Dead force at every point, N; without the weight of branches whose mesh may move along the cable.
    forces: Vec<Vector>,
    /// Dead moments by independent frame, N m, world axes.
    moments: Vec<(usize, Vector)>,
    followers: Vec<Follower>,
    segments: Vec<SegmentLoad>,
    /// Active fraction of what has no potential.
    fraction: f64,
}

/// Force and moment that turn with a frame, in its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Follower {
    /// Index of the independent point.
    point: usize,
    /// Index of the independent frame.
    frame: usize,
    /// N.
    force: Vector,
    /// N m.
    moment: Vector,
}

/// Force per length without a potential on a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SegmentLoad {
    /// Index of its frame.
    frame: usize,
    /// Points at which it is lumped, with the factor on the force per length, m.
    lumps: Lumps,
    /// Diameter of the cable, m.
    diameter: f64,
    force: LineForce,
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
            moments: Vec::with_capacity(network.loads.len()),
            followers: Vec::new(),
            segments: Vec::new(),
            fraction: 1.0,
        }
    }

    /// Recomputes the lumped weights and loads, after a change of the conditions.
    pub fn update(&mut self, system: System<'_>) {
        let Self { forces, moments, followers, segments, fraction } = self;
        forces.fill(Vector::zeros());
        gravity::fixed_weights(system, |point, force| forces[point] += force);
        moments.clear();
        followers.clear();
        segments.clear();
        for joint in &system.network.joints {
            forces[joint.point] += system.conditions.gravity * joint.mass;
        }
        for (load, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
            match &load.action {
                LoadAction::At { place, force, moment, follows: false } => {
                    forces[place.point] += force * *factor;
                    let moment = moment * (*factor * *fraction);
                    if let Some(frame) = place.site.frame
                        && moment != Vector::zeros()
                    {
                        moments.push((frame, moment));
                    }
                }
                LoadAction::At { place, force, moment, follows: true } => {
                    let (local, factor) = (place.site.local, *factor * *fraction);
                    let force = local.orientation * force * factor;
                    let moment = local.orientation * moment * factor + local.position.cross(&force);
                    if let Some(frame) = place.site.frame
                        && (force, moment) != (Vector::zeros(), Vector::zeros())
                    {
                        followers.push(Follower { point: place.site.point, frame, force, moment });
                    }
                }
                LoadAction::Along { force: LineForce::Dead(force), .. } => {
                    each_segment(system, &load.action, |_, _, lumps| {
                        lumps.iter().for_each(|(point, length)| forces[*point] += force * (length * factor));
                    });
                }
                LoadAction::Along { force, .. } => {
                    let factor = *factor * *fraction;
                    if factor != 0.0 {
                        each_segment(system, &load.action, |branch, frame, lumps| {
                            let lumps = lumps.map(|(point, length)| (point, length * factor));
                            segments.push(SegmentLoad {
                                frame,
                                lumps,
                                diameter: branch.section.diameter,
                                force: *force,
                            });
                        });
                    }
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
        self.moments.is_empty() && self.followers.is_empty() && self.segments.is_empty()
    }

    /// Active moments, of dead loads and of followers: index of the independent frame, and the moment, N m, in the axes
    /// of the world or of the frame.
    pub fn moments(&self) -> impl Iterator<Item = (usize, Vector)> {
        self.moments.iter().copied().chain(self.followers.iter().map(|own| (own.frame, own.moment)))
    }

    /// Sets the active fraction of the loads without a potential, 0 to 1; effective from the next [`Self::update`].
    pub fn set_fraction(&mut self, fraction: f64) {
        self.fraction = fraction;
    }

    /// Potential energy of the loads, `−Σ f·x` without weight, J.
    pub fn energy(&self, system: System<'_>, state: &State) -> f64 {
        let mut energy = 0.0;
        for (load, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
            match &load.action {
                LoadAction::At { place, force, follows: false, .. } => {
                    energy -= factor * force.dot(&state.points[place.point]);
                }
                LoadAction::Along { force: LineForce::Dead(force), .. } => {
                    each_segment(system, &load.action, |_, _, lumps| {
                        let work = |(point, length): (usize, f64)| force.dot(&state.points[point]) * length;
                        energy -= factor * lumps.into_iter().map(work).sum::<f64>();
                    });
                }
                _ => {}
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
        for (frame, moment) in &self.moments {
            gradient.frames[*frame] -= state.frames[*frame].inverse_transform_vector(moment);
        }
        for own in &self.followers {
            gradient.points[own.point] -= state.frames[own.frame] * own.force;
            gradient.frames[own.frame] -= own.moment;
        }
        for own in &self.segments {
            let force = own.force.on(&state.frames[own.frame], own.diameter);
            own.lumps.iter().for_each(|(point, length)| gradient.points[*point] -= force * *length);
        }
    }

    /// Work over a step of the loads without a potential, J, to first order; of moments `α Σ M·R θ`.
    pub fn work_without_potential(&self, state: &State, step: &Tangent, alpha: f64) -> f64 {
        let of_moments: f64 =
            self.moments.iter().map(|(c, m)| alpha * m.dot(&(state.frames[*c] * step.frames[*c]))).sum();
        let of_followers = self.followers.iter().map(|own| {
            let force = state.frames[own.frame] * own.force;
            alpha * (force.dot(&step.points[own.point]) + own.moment.dot(&step.frames[own.frame]))
        });
        let of_segments = self.segments.iter().map(|own| {
            let moved: Vector = own.lumps.iter().map(|(point, length)| step.points[*point] * *length).sum();
            alpha * own.force.on(&state.frames[own.frame], own.diameter).dot(&moved)
        });
        of_followers.chain(of_segments).fold(of_moments, |sum, work| sum + work)
    }

    /// Derivatives of the loads at places without a potential; see the table above.
    pub fn tangents(&self, state: &State) -> Vec<LoadTangent> {
        let of_moments = self.moments.iter().map(|(frame, moment)| LoadTangent {
            row: Variable::Frame(*frame),
            frame: *frame,
            block: skew(&state.frames[*frame].inverse_transform_vector(moment)) * -0.5,
        });
        let of_followers = self.followers.iter().flat_map(|own| {
            let frame = own.frame;
            let turned = state.frames[frame].to_rotation_matrix().matrix() * skew(&own.force);
            let force = LoadTangent { row: Variable::Point(own.point), frame, block: turned };
            let moment = LoadTangent { row: Variable::Frame(frame), frame, block: skew(&own.moment) * 0.5 };
            [force, moment].into_iter().filter(|tangent| tangent.block != Matrix::zeros())
        });
        of_moments.chain(of_followers).collect()
    }

    /// Derivatives of the forces per length without a potential.
    pub fn segment_tangents(&self, state: &State) -> Vec<SegmentTangent> {
        let tangent = |own: &SegmentLoad| {
            let derivative = own.force.derivative(&state.frames[own.frame], own.diameter);
            SegmentTangent { frame: own.frame, blocks: own.lumps.map(|(point, length)| (point, derivative * -length)) }
        };
        self.segments.iter().map(tangent).collect()
    }
}

/// Force of the loads along a segment per unstressed length, N/m, world axes.
pub fn along_segment(system: System<'_>, state: &State, branch: usize, segment: usize) -> Vector {
    let mut sum = Vector::zeros();
    let own = &system.network.branches[branch];
    for (load, factor) in system.network.loads.iter().zip(&system.conditions.load_factors) {
        if let LoadAction::Along { spans, force } = &load.action {
            let acts = |nodes: &std::ops::Range<usize>| nodes.start <= segment && segment + 1 < nodes.end;
            let spans = spans.iter().filter(|span| span.branch == branch && acts(&span.nodes)).count();
            let frame = &state.frames[own.segment_frame(segment)];
            sum += force.on(frame, own.section.diameter) * (*factor * spans as f64);
        }
    }
    sum
}

/// Calls `act` for every segment along which a load acts, with its branch, its frame, and the points and lengths (m) at
/// which the force per length is lumped.
fn each_segment<P>(system: System<'_>, action: &LoadAction<P, NodeRange>, mut act: impl FnMut(&Branch, usize, Lumps)) {
    let LoadAction::Along { spans, .. } = action else { return };
    for span in spans {
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
            act(branch, branch.segment_frame(j), lumps);
        }
    }
}
