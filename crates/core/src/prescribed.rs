//! Elimination of prescribed directions: constraints that prescribe a pose reduce the independent variables.

use crate::conditions::System;
use crate::constraint::{Action, RotationHold};
use crate::rotation::{columns, nearer_sign, orthogonal, shortest, twist_angle};
use crate::variable::Variable;
use crate::{Matrix, Rotation, State, Tangent, Vector};

/// Motion (m or rad) that counts as zero.
const NO_MOTION: f64 = 1e-14;
/// A direction counts as held already if its part orthogonal to the held directions is shorter than this.
const SAME_DIRECTION: f64 = 1e-6;

/// A variable with some or all directions prescribed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held {
    /// The variable.
    pub variable: Variable,
    /// Orthonormal columns: world axes for points, body axes for frames. The held directions come first.
    pub basis: Matrix,
    /// The constraint that holds each held direction.
    pub constraint: [usize; 3],
    /// Number of held directions of the basis.
    pub count: usize,
}

/// Prescribed directions of all variables.
#[derive(Default)]
pub struct Prescribed {
    held: Vec<Held>,
}

impl Prescribed {
    /// Held variables, as found by [`Self::update`].
    pub fn held(&self) -> &[Held] {
        &self.held
    }

    /// Finds the held directions at `state`. Allocates only if there are more of them than ever before.
    pub fn update(&mut self, system: System<'_>, state: &State) {
        let mut held = std::mem::take(&mut self.held);
        held.clear();
        for (f, constraint) in system.acting() {
            let Action::Prescribed(hold) = constraint.model.action() else { continue };
            if hold.position {
                let variable = Variable::Point(constraint.site.point);
                match hold.rails.as_slice() {
                    [] => {
                        for d in [Vector::x(), Vector::y(), Vector::z()] {
                            add_direction(&mut held, variable, f, &d);
                        }
                    }
                    [a] => {
                        let b = orthogonal(a);
                        add_direction(&mut held, variable, f, &b);
                        add_direction(&mut held, variable, f, &a.cross(&b));
                    }
                    [a, b, ..] => add_direction(&mut held, variable, f, &a.cross(b)),
                }
            }
            let Some(frame) = constraint.site.frame else { continue };
            let variable = Variable::Frame(frame);
            let local = &constraint.site.local.orientation;
            let mut add = |d: Vector| add_direction(&mut held, variable, f, &(local * d));
            match &hold.rotation {
                RotationHold::Free => {}
                RotationHold::Tangent => {
                    add(Vector::x());
                    add(Vector::y());
                }
                RotationHold::All => {
                    add(Vector::x());
                    add(Vector::y());
                    add(Vector::z());
                }
                RotationHold::Twist => {
                    // Gradient of the twist angle α = 2 atan2(z, w) of p = q̄_target q.
                    let p = system.conditions.targets[f].orientation.inverse() * (state.frames[frame] * local);
                    let (w, v) = (p.w, p.imag());
                    add(Vector::new(v.z * v.x - w * v.y, w * v.x + v.z * v.y, w * w + v.z * v.z).normalize());
                }
                RotationHold::Hinge(axis) => {
                    let axis = (state.frames[frame] * local).inverse_transform_vector(axis);
                    let b = orthogonal(&axis);
                    add(b);
                    add(axis.cross(&b));
                }
            }
        }
        for h in &mut held {
            complete_basis(h);
        }
        self.held = held;
    }

    /// Moves every held degree of freedom exactly to its target, and updates the tied points and frames.
    pub fn place(&self, system: System<'_>, state: &mut State) {
        for (f, constraint) in system.acting() {
            let Action::Prescribed(hold) = constraint.model.action() else { continue };
            if let Some(frame) = constraint.site.frame
                && hold.rotation != RotationHold::Free
            {
                let local = &constraint.site.local.orientation;
                let station = state.frames[frame] * local;
                let placed = placed(system, f, &hold.rotation, &station) * local.inverse();
                state.frames[frame] = nearer_sign(placed, &state.frames[frame]);
            }
            if hold.position {
                let lever = constraint
                    .site
                    .frame
                    .map_or_else(Vector::zeros, |c| state.frames[c] * constraint.site.local.position);
                let target = system.conditions.targets[f].position - lever;
                let i = constraint.site.point;
                if hold.rails.is_empty() {
                    state.points[i] = target;
                    state.compensation[i] = Vector::zeros();
                } else {
                    let gap = target - state.points[i];
                    let along: Vector = hold.rails.iter().map(|d| d * d.dot(&gap)).sum();
                    state.points[i] += gap - along;
                }
            }
        }
        system.network.follow_ties(state);
    }

    /// Motion of the held degrees of freedom from `state` to their targets (to first order; zero elsewhere). Returns
    /// whether it is not zero.
    pub fn motion(&self, system: System<'_>, state: &State, motion: &mut Tangent) -> bool {
        motion.clear();
        for (f, constraint) in system.acting() {
            let Action::Prescribed(hold) = constraint.model.action() else { continue };
            if let Some(frame) = constraint.site.frame
                && hold.rotation != RotationHold::Free
            {
                let local = &constraint.site.local.orientation;
                let station = state.frames[frame] * local;
                let turn = station.inverse() * placed(system, f, &hold.rotation, &station);
                motion.frames[frame] += local * turn.scaled_axis();
            }
            if hold.position {
                let at = state.pose(&constraint.site).position;
                let gap = system.conditions.targets[f].position - at;
                let along: Vector = hold.rails.iter().map(|d| d * d.dot(&gap)).sum();
                motion.points[constraint.site.point] += gap - along;
            }
        }
        let mut moves = false;
        for h in &self.held {
            let held_part =
                |d: &Vector| -> Vector { (0..h.count).map(|k| h.basis.column(k) * h.basis.column(k).dot(d)).sum() };
            let d = match h.variable {
                Variable::Point(i) => &mut motion.points[i],
                Variable::Frame(c) => &mut motion.frames[c],
            };
            *d = held_part(d);
            moves |= d.amax() > NO_MOTION;
        }
        moves
    }

    /// Removes the held directions from a gradient: the rest vanishes at an equilibrium.
    pub fn project(&self, gradient: &mut Tangent) {
        for h in &self.held {
            let g = match h.variable {
                Variable::Point(i) => &mut gradient.points[i],
                Variable::Frame(c) => &mut gradient.frames[c],
            };
            for k in 0..h.count {
                let d: Vector = h.basis.column(k).into();
                *g -= d * d.dot(g);
            }
        }
    }

    /// Force (N) and moment about the held point (N m), world axes, of a constraint that prescribes. `gradient` is the
    /// whole gradient at `state`.
    pub fn reaction(&self, system: System<'_>, f: usize, state: &State, gradient: &Tangent) -> (Vector, Vector) {
        let constraint = &system.network.constraints[f];
        let (mut force, mut moment) = (Vector::zeros(), Vector::zeros());
        for h in &self.held {
            for k in (0..h.count).filter(|&k| h.constraint[k] == f) {
                let d: Vector = h.basis.column(k).into();
                match h.variable {
                    Variable::Point(i) => force += d * d.dot(&gradient.points[i]),
                    Variable::Frame(c) => moment += state.frames[c] * (d * d.dot(&gradient.frames[c])),
                }
            }
        }
        let lever =
            constraint.site.frame.map_or_else(Vector::zeros, |c| state.frames[c] * constraint.site.local.position);
        (force, moment - lever.cross(&force))
    }
}

/// Orientation that a constraint prescribes for a station with orientation `q`: its target, except for free rotations.
fn placed(system: System<'_>, constraint: usize, rotation: &RotationHold, q: &Rotation) -> Rotation {
    let target = &system.conditions.targets[constraint].orientation;
    match rotation {
        RotationHold::Free => *q,
        RotationHold::All => *target,
        RotationHold::Tangent => shortest(&columns(q)[2], &columns(target)[2]) * q,
        RotationHold::Twist => {
            let alpha = twist_angle(&(target.inverse() * q));
            q * Rotation::from_axis_angle(&Vector::z_axis(), -alpha)
        }
        RotationHold::Hinge(axis) => {
            let r = q * target.inverse();
            let phi = 2.0 * r.imag().dot(axis).atan2(r.w);
            Rotation::from_axis_angle(axis, phi) * target
        }
    }
}

/// Adds a held direction to a variable, unless it is held already (Gram–Schmidt).
fn add_direction(held: &mut Vec<Held>, variable: Variable, constraint: usize, direction: &Vector) {
    let index = held.iter().position(|h| h.variable == variable).unwrap_or_else(|| {
        held.push(Held { variable, basis: Matrix::zeros(), constraint: [usize::MAX; 3], count: 0 });
        held.len() - 1
    });
    let h = &mut held[index];
    let rest = (0..h.count).fold(*direction, |d, k| {
        let c: Vector = h.basis.column(k).into();
        d - c * c.dot(&d)
    });
    // A direction that is held twice (the targets were checked to agree) counts once.
    if h.count < 3
        && let Some(d) = rest.try_normalize(SAME_DIRECTION)
    {
        h.basis.set_column(h.count, &d);
        h.constraint[h.count] = constraint;
        h.count += 1;
    }
}

/// Completes a basis by its free columns.
fn complete_basis(h: &mut Held) {
    let column = |k: usize, b: &Matrix| -> Vector { b.column(k).into() };
    if h.count == 1 {
        let b = orthogonal(&column(0, &h.basis));
        h.basis.set_column(1, &b);
    }
    if h.count < 3 {
        let c = column(0, &h.basis).cross(&column(1, &h.basis));
        h.basis.set_column(2, &c);
    }
}
