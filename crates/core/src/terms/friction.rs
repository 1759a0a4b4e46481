//! Friction of contact: tangential springs between touching surfaces, with a force bounded by Coulomb's law.
//!
//! Coulomb's law, quasi-static: a tangential spring of stiffness k ≥ ρ connects a touching contact point to the
//! place of the obstacle where it first touched (its anchor), and the force of the spring is at most `f N`. With u the
//! tangential distance from the anchor the energy is `½ k u²` up to `u = f N/k` (stick), and `f N (u − f N/(2k))`
//! beyond (slip). Normal force N and normal n are those of the last update of the multipliers. At the end of an
//! increment the anchor of a slipping contact point is moved (return mapping), so that a sticking one does not creep. k
//! is at least the axial stiffness of the cable per contact point, so that slip reverses over about a segment. Friction
//! on an obstacle acts on the centre line: the cable does not roll.
//!
//! Between cables the spring joins their surfaces. With x the contact point and P the frame of its segment, the point
//! on its surface is `x + P a`, `a = −r Pᵀ n` with r its radius as a part of the distance. With y the nearest point
//! on the centre line of the partner, R the frame of that segment and b the anchor in it,
//! `u = (1 − n nᵀ)(Rᵀ(x + P a − y) − b)`, n in the axes of R. u is invariant under a common rigid motion, the
//! force has the same line of action on both cables, and cables roll on each other without slipping. Each update sets
//! a, b and y to the present contact place, which may be on the next segment, and keeps u; a new contact starts with
//! `u = 0`. Where two cables cross both have contact points, which divide N among them, so that the total friction is
//! at most `f N`. As k is many times the stiffness of a cable, the displacement `u = f N/k` that a sticking contact may
//! lose when the contact points that divide N change is negligible.

use super::contact::{Contact, ContactTerm, Touched, Weights};
use crate::conditions::{Bond, ContactPoint, ContactRecord, FrictionAnchor, Partner, System};
use crate::rotation::skew;
use crate::variable::{Block, Variable};
use crate::{Matrix, Pose, State, Tangent, Vector};

/// Term of friction of contact; keeps its workspace.
#[derive(Default)]
pub struct FrictionTerm {
    forces: Vec<FrictionForce>,
}

/// Friction force on a contact point (N), and second derivative of its energy in the position where it acts (N/m);
/// world axes.
struct FrictionForce {
    point: u32,
    partner: Partner,
    force: Vector,
    stiffness: Matrix,
    cables: Option<Between>,
}

/// Points and frames on which friction between two cables acts.
struct Between {
    /// Points of the partner's segment, and their weights.
    points: [(usize, f64); 2],
    /// Frames of the contact point's segment and of the partner's.
    frames: [usize; 2],
    /// Levers from each centre line to the point of action of the force, m; world axes.
    levers: [Vector; 2],
}

impl FrictionAnchor {
    /// Energy (J), force on the contact point (N) and second derivative (N/m) of friction with coefficient `f` and
    /// stiffness `k`; all in the axes of the partner. With `u = (1 − n nᵀ)(x − b)`, `d = u/|u|`: stick `−k u`
    /// and `k (1 − n nᵀ)`; slip `−f N d` and `(f N/|u|)(1 − n nᵀ − d dᵀ)`.
    fn drag(&self, x: &Vector, f: f64, k: f64) -> (f64, Vector, Matrix) {
        let along = Matrix::identity() - self.normal * self.normal.transpose();
        let u = along * (x - self.position);
        let (length, limit) = (u.norm(), f * self.force);
        if k * length <= limit {
            return (0.5 * k * length * length, -u * k, along * k);
        }
        let d = u / length;
        (limit * (length - 0.5 * limit / k), -d * limit, (along - d * d.transpose()) * (limit / length))
    }

    /// Position of the anchor after the contact point has slipped to `x` (return mapping):
    /// `x − u min(1, f N/(k |u|))`.
    fn followed(&self, x: &Vector, f: f64, k: f64) -> Vector {
        let u = (x - self.position) - self.normal * self.normal.dot(&(x - self.position));
        let (length, limit) = (u.norm(), f * self.force);
        let elastic = if k * length <= limit { u } else { u * (limit / (k * length)) };
        x - elastic
    }
}

/// Contact of a harness at a state, from which anchors are computed.
#[derive(Clone, Copy)]
pub(crate) struct Anchoring<'a> {
    pub(crate) contact: &'a ContactTerm,
    pub(crate) system: System<'a>,
    pub(crate) state: &'a State,
}

impl Anchoring<'_> {
    /// Axes of an anchor.
    fn axes(&self, partner: Partner, bond: Option<&Bond>) -> Pose {
        match partner {
            Partner::Obstacle { obstacle, .. } => self.system.conditions.contact.poses[obstacle as usize],
            Partner::Cable { branch, segment } => {
                let (branch, segment) = (branch as usize, segment as usize);
                let fraction = bond.map_or(0.0, |bond| bond.fraction);
                let network = self.system.network;
                Pose {
                    position: ContactPoint::new(branch, segment, fraction).position(network, self.state),
                    orientation: self.state.frames[network.branches[branch].segment_frame(segment)],
                }
            }
        }
    }

    /// Position of a contact point, or with a `bond` of the point on its surface, in the axes of its anchor, m.
    fn local(&self, point: u32, axes: &Pose, bond: Option<&Bond>) -> Vector {
        let point = self.contact.point(point);
        let x = point.position(self.system.network, self.state);
        axes.local(&bond.map_or(x, |bond| x + self.own_lever(point, bond)))
    }

    /// Vector from a contact point to the point on its surface, world axes, m.
    fn own_lever(&self, point: &ContactPoint, bond: &Bond) -> Vector {
        self.state.frames[self.system.network.branches[point.branch].segment_frame(point.segment)] * bond.lever
    }

    /// Stiffness of a friction spring, N/m: the penalty of the contact point, and at least the axial stiffness of the
    /// cable per contact point. A smaller one would spread a reversal of slip over more than a segment of the cable.
    fn stiffness(&self, record: &ContactRecord) -> f64 {
        self.contact.penalty(record).max(self.contact.friction_stiffness[self.contact.branch_of(record)])
    }

    /// Friction anchor of a contact, given the records so far; `None` where the partner is smooth. An anchor on an
    /// obstacle stays; one on a cable moves to the present contact place with the same elongation of the spring, even
    /// from another segment.
    pub(crate) fn anchor(&self, contact: &Contact) -> Option<FrictionAnchor> {
        if self.system.friction_coefficient(contact.partner) == 0.0 {
            return None;
        }
        let records = self.system.conditions.contact.records_of(contact.point);
        let own = records.iter().find(|record| record.partner == contact.partner);
        let known = own.or_else(|| beside(records, contact));
        let held = known.and_then(|record| Some((record, record.anchor?)));
        let bond = contact.other.as_ref().map(|touched| self.bond(contact, touched));
        let axes = self.axes(contact.partner, bond.as_ref());
        let x = self.local(contact.point, &axes, bond.as_ref());
        let position = match (held, bond) {
            (None, _) => x,
            (Some((_, anchor)), None) => anchor.position,
            (Some((record, anchor)), Some(_)) => {
                let before = self.axes(record.partner, anchor.bond.as_ref());
                let elongation = self.local(record.point, &before, anchor.bond.as_ref()) - anchor.position;
                let u = before.orientation * elongation;
                x - axes.orientation.inverse_transform_vector(&(u - contact.normal * contact.normal.dot(&u)))
            }
        };
        let normal = axes.orientation.inverse_transform_vector(&contact.normal);
        Some(FrictionAnchor { position, normal, force: contact.force, bond })
    }

    /// Contact places of a contact point and another cable.
    fn bond(&self, contact: &Contact, touched: &Touched) -> Bond {
        let point = self.contact.point(contact.point);
        let network = self.system.network;
        let Partner::Cable { branch, .. } = contact.partner else { unreachable!("obstacles have no segments") };
        let segment = touched.first - network.branches[branch as usize].points.start;
        let radii = [network.radius(point.branch, point.segment), network.radius(branch as usize, segment)];
        let own = radii[0] / (radii[0] + radii[1]);
        let frame = &self.state.frames[network.branches[point.branch].segment_frame(point.segment)];
        let lever = frame.inverse_transform_vector(&contact.normal) * (-own * contact.radius);
        Bond { fraction: touched.fraction, lever }
    }

    /// Anchor of a record after its contact point has slipped to its position at the state (return mapping).
    pub(crate) fn follow(&self, record: &ContactRecord, anchor: &FrictionAnchor) -> FrictionAnchor {
        let axes = self.axes(record.partner, anchor.bond.as_ref());
        let x = self.local(record.point, &axes, anchor.bond.as_ref());
        let coefficient = self.system.friction_coefficient(record.partner);
        FrictionAnchor { position: anchor.followed(&x, coefficient, self.stiffness(record)), ..*anchor }
    }

    /// Points and frames on which the friction of a record acts, at `lever` from the centre line of the partner.
    fn between(&self, record: &ContactRecord, bond: &Bond, lever: Vector) -> Between {
        let point = self.contact.point(record.point);
        let Partner::Cable { branch, segment } = record.partner else { unreachable!("only cables have bonds") };
        let (branch, segment) = (branch as usize, segment as usize);
        let first = self.system.network.branches[branch].points.start + segment;
        Between {
            points: [(first, 1.0 - bond.fraction), (first + 1, bond.fraction)],
            frames: [(point.branch, point.segment), (branch, segment)]
                .map(|(b, j)| self.system.network.branches[b].segment_frame(j)),
            levers: [self.own_lever(point, bond), lever],
        }
    }
}

/// Record of the same contact point with a neighbouring segment of the same cable; of two, the one with the larger
/// force.
fn beside<'m>(records: &'m [ContactRecord], contact: &Contact) -> Option<&'m ContactRecord> {
    let Partner::Cable { branch: touched, segment: here } = contact.partner else { return None };
    let same = |record: &&ContactRecord| match record.partner {
        Partner::Cable { branch, segment } => branch == touched && segment.abs_diff(here) == 1,
        Partner::Obstacle { .. } => false,
    };
    let force = |record: &ContactRecord| record.anchor.map_or(0.0, |anchor| anchor.force);
    records.iter().filter(same).max_by(|a, b| force(a).total_cmp(&force(b)))
}

impl FrictionTerm {
    /// Evaluates friction at `state`; returns its energy, J. Every anchor acts with the normal force of its record, at
    /// any distance of the contact point.
    pub fn energy(&mut self, contact: &ContactTerm, system: System<'_>, state: &State) -> f64 {
        let anchoring = Anchoring { contact, system, state };
        self.forces.clear();
        let mut energy = 0.0;
        for record in &system.conditions.contact.records {
            let coefficient = system.friction_coefficient(record.partner);
            let Some(anchor) = &record.anchor.filter(|_| coefficient > 0.0) else { continue };
            let axes = anchoring.axes(record.partner, anchor.bond.as_ref());
            let x = anchoring.local(record.point, &axes, anchor.bond.as_ref());
            let (e, force, stiffness) = anchor.drag(&x, coefficient, anchoring.stiffness(record));
            energy += e;
            let r = axes.orientation.to_rotation_matrix();
            let stiffness = r.matrix() * stiffness * r.matrix().transpose();
            let cables = anchor.bond.as_ref().map(|bond| anchoring.between(record, bond, r * x));
            let (point, partner) = (record.point, record.partner);
            self.forces.push(FrictionForce { point, partner, force: r * force, stiffness, cables });
        }
        energy
    }

    /// Friction force on a contact point at the last evaluated state, N.
    pub fn force_on(&self, contact: &Contact) -> Vector {
        let own = |friction: &&FrictionForce| friction.point == contact.point && friction.partner == contact.partner;
        self.forces.iter().find(own).map_or_else(Vector::zeros, |friction| friction.force)
    }

    /// Adds the first derivatives of the energy of friction, with f the force on the contact point: `−f` in the
    /// position of the contact point, `f` in that of the partner, and `∓Rᵀ (a × f)` in the frames R of two cables
    /// with the levers a; returns the energy, J.
    pub fn gradient(
        &mut self,
        contact: &ContactTerm,
        system: System<'_>,
        state: &State,
        gradient: &mut Tangent,
    ) -> f64 {
        let energy = self.energy(contact, system, state);
        for friction in &self.forces {
            for (point, weight) in contact.support(system, friction.point, contact.point(friction.point).fraction) {
                gradient.points[point] -= friction.force * weight;
            }
            let Some(Between { points, frames: [own, other], levers: [a, b] }) = &friction.cables else { continue };
            for (point, weight) in points {
                gradient.points[*point] += friction.force * *weight;
            }
            gradient.frames[*own] -= state.frames[*own].inverse_transform_vector(&a.cross(&friction.force));
            gradient.frames[*other] += state.frames[*other].inverse_transform_vector(&b.cross(&friction.force));
        }
        energy
    }

    /// Adds the second derivatives of the energy of friction; with `convex` without the geometric parts, which may be
    /// indefinite.
    ///
    /// Between two cables with frames P and R, levers a and b (world) and turns α and β (body axes): the elongation
    /// of the spring changes by `δz + b × Rβ` in the axes of R, `δz = δx − δy + Pα × a`, and to second order
    /// by `−Rβ × δz + ½ Rβ × (Rβ × b) + ½ Pα × (Pα × a)`. With K the second derivative of the spring the
    /// second variation is `(δz + b × Rβ)ᵀ K (δz + b × Rβ)` minus twice the product of f with that second-order
    /// part.
    pub fn hessian(
        &mut self,
        contact: &ContactTerm,
        system: System<'_>,
        state: &State,
        convex: bool,
        blocks: &mut Vec<Block>,
    ) {
        self.energy(contact, system, state);
        for friction in &self.forces {
            let own_points = contact.support(system, friction.point, contact.point(friction.point).fraction);
            let Some(Between { points, frames: [own, other], levers: [a, b] }) = &friction.cables else {
                let places = own_points.map(|(point, u)| (point, Weights { u, ..Weights::default() }));
                contact.add_blocks(system, state, &places, |p, q| friction.stiffness * (p.u * q.u), blocks);
                continue;
            };
            let (p, r) = (state.frames[*own].to_rotation_matrix(), state.frames[*other].to_rotation_matrix());
            let (p, r, f) = (p.matrix(), r.matrix(), &friction.force);
            let frame = Variable::Frame;
            // Each variable with its contributions to δz, to `b × Rβ` and to Rβ.
            let parts = || {
                let points = own_points.into_iter().chain(points.map(|(point, weight)| (point, -weight)));
                let columns = points.filter(|(_, weight)| *weight != 0.0).flat_map(|(point, weight)| {
                    let columns = contact.columns(system, state, point).into_iter().flatten();
                    columns.map(move |(v, column)| (v, column * weight))
                });
                let (none, with_own) = (Matrix::zeros(), (frame(*own), -(skew(a) * p)));
                let moved = columns.chain([with_own]).map(move |(v, column)| (v, [column, none, none]));
                moved.chain([(frame(*other), [none, skew(b) * r, *r])])
            };
            let turned = skew(f);
            for (row, [z, lever, turn]) in parts() {
                for (column, [y, other_lever, other_turn]) in parts() {
                    let mut h = (z + lever).transpose() * friction.stiffness * (y + other_lever);
                    if !convex {
                        h += z.transpose() * turned * other_turn - turn.transpose() * turned * y;
                    }
                    blocks.push(Block { row, column, matrix: h });
                }
            }
            if convex {
                continue;
            }
            for (c, axes, lever) in [(*own, p, a), (*other, r, b)] {
                let outer = (f * lever.transpose() + lever * f.transpose()) * 0.5;
                let h = axes.transpose() * (Matrix::identity() * f.dot(lever) - outer) * axes;
                blocks.push(Block { row: frame(c), column: frame(c), matrix: h });
            }
        }
    }
}
