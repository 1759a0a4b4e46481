//! Friction of contact: springs between surfaces that touch, up to the force that Coulomb's law allows.
//!
//! Coulomb's law, quasi-static: a contact point that touches is bound to the place of the body where it first touched
//! (its anchor) by a tangential spring of stiffness k ≥ ρ, whose force is at most `f N`: with u the tangential
//! distance from the anchor it adds `½ k u²`, beyond `u = f N/k` `f N (u − f N/(2k))`. Normal force N and normal n
//! are those of the last update of the multipliers; at the end of an increment the anchor follows a contact point that
//! slipped (return mapping), so that what sticks does not creep. Where the cable is stiffer along itself k is larger,
//! so that the change from slip one way to slip the other takes about a segment. Friction on a body acts on the centre
//! line: the cable does not roll.
//!
//! Between cables the spring joins their surfaces. The contact point x in its segment's frame P carries the point
//! `x + P a`, `a = −r Pᵀ n` with its own part r of the distance; the anchor b belongs to the frame R of the segment
//! that is touched, with y the place that is touched on its centre line:
//! `u = (1 − n nᵀ)(Rᵀ(x + P a − y) − b)`, n in the axes of R. It does not change when both move as one, the
//! force has the same line of action on both, and cables roll on each other without slipping. With every update a, b
//! and y become those of the place where the two touch then, on the next segment, too, and u stays; a contact point
//! that was not there before begins with `u = 0`. Where two cables cross both have contact points, which divide N among
//! them, so that together they pull with no more than `f N`. As k is many times the stiffness of a cable, `u = f N/k`,
//! by which a sticking contact may give way when the contact points that divide N change, is too small to be seen.

use super::contact::{Contact, ContactTerm, Touched};
use crate::conditions::{Bond, ContactPoint, ContactRecord, FrictionAnchor, Partner, System, records_of};
use crate::rotation::skew;
use crate::variable::{Block, Variable};
use crate::{Matrix, Pose, State, Tangent, Vector};

/// Term of friction of contact; keeps its workspace.
#[derive(Default)]
pub struct FrictionTerm {
    forces: Vec<FrictionForce>,
}

/// Friction on a contact point: the force (N), and the second derivative of its energy in the place where it acts
/// (N/m); world axes.
struct FrictionForce {
    point: u32,
    partner: Partner,
    force: Vector,
    stiffness: Matrix,
    cables: Option<Between>,
}

/// Friction between two cables: the points and frames that it acts on.
struct Between {
    /// Points of the segment that is touched, and their weights.
    points: [(usize, f64); 2],
    /// Frames of the contact point's segment and of the one that is touched.
    frames: [usize; 2],
    /// From each centre line to the place where the force acts, m; world axes.
    levers: [Vector; 2],
}

impl FrictionAnchor {
    /// Energy (J), force on the contact point (N) and second derivative (N/m) of friction with coefficient `f` and
    /// stiffness `k`; all in the axes of the partner.
    fn drag(&self, x: &Vector, f: f64, k: f64) -> (f64, Vector, Matrix) {
        let along = Matrix::identity() - self.normal * self.normal.transpose();
        let u = along * (x - self.position);
        let (length, most) = (u.norm(), f * self.force);
        if k * length <= most {
            return (0.5 * k * length * length, -u * k, along * k);
        }
        let d = u / length;
        (most * (length - 0.5 * most / k), -d * most, (along - d * d.transpose()) * (most / length))
    }

    /// Position of the anchor once the contact point has slipped to `x` (return mapping).
    fn followed(&self, x: &Vector, f: f64, k: f64) -> Vector {
        let u = (x - self.position) - self.normal * self.normal.dot(&(x - self.position));
        let (length, most) = (u.norm(), f * self.force);
        let elastic = if k * length <= most { u } else { u * (most / (k * length)) };
        x - elastic
    }
}

/// Contact of a harness at a state: what anchors are found by.
#[derive(Clone, Copy)]
pub(crate) struct Anchoring<'a> {
    pub(crate) contact: &'a ContactTerm,
    pub(crate) system: System<'a>,
    pub(crate) state: &'a State,
}

impl Anchoring<'_> {
    /// Axes in which an anchor is given.
    fn axes(&self, partner: Partner, bond: Option<&Bond>) -> Pose {
        match partner {
            Partner::Obstacle { obstacle, .. } => self.system.conditions.contact.poses[obstacle as usize],
            Partner::Cable { branch, segment } => {
                let (branch, segment) = (branch as usize, segment as usize);
                let fraction = bond.map_or(0.0, |bond| bond.fraction);
                let network = self.system.network;
                Pose {
                    position: ContactPoint { branch, segment, fraction }.position(network, self.state),
                    orientation: self.state.frames[network.branches[branch].segment_frame(segment)],
                }
            }
        }
    }

    /// Position of a bound contact point, or of its surface, in the axes of its anchor, m.
    fn local(&self, point: u32, axes: &Pose, bond: Option<&Bond>) -> Vector {
        let point = self.contact.point(point);
        let x = point.position(self.system.network, self.state);
        axes.local(&bond.map_or(x, |bond| x + self.own_lever(point, bond)))
    }

    /// From a contact point to the surface that it is bound by, world axes, m.
    fn own_lever(&self, point: &ContactPoint, bond: &Bond) -> Vector {
        self.state.frames[self.system.network.branches[point.branch].segment_frame(point.segment)] * bond.lever
    }

    /// Stiffness of an anchor, N/m: the penalty of the contact point, and no less than the cable has along itself. A
    /// softer one would spread the change from slip one way to slip the other over more of the cable than a segment.
    fn stiffness(&self, record: &ContactRecord) -> f64 {
        self.contact.penalty(record).max(self.contact.friction_stiffness[self.contact.branch_of(record)])
    }

    /// Anchor of a contact point that touches, where `known` is its record so far, among `old` ones; none where the
    /// partner is smooth. An anchor on an obstacle stays; one on a cable moves to the place that is touched now, with
    /// the same spring elongation, whichever segment it was on.
    pub(crate) fn anchor(
        &self,
        old: &[ContactRecord],
        known: Option<&ContactRecord>,
        contact: &Contact,
    ) -> Option<FrictionAnchor> {
        if self.system.friction_coefficient(contact.partner) == 0.0 {
            return None;
        }
        let known = known.or_else(|| beside(old, contact));
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

    /// Place where a contact point touches another cable.
    fn bond(&self, contact: &Contact, touched: &Touched) -> Bond {
        let point = self.contact.point(contact.point);
        let network = self.system.network;
        let diameter = |b: usize| network.branches[b].section.diameter;
        let Partner::Cable { branch, .. } = contact.partner else { unreachable!("obstacles have no segments") };
        let own = diameter(point.branch) / (diameter(point.branch) + diameter(branch as usize));
        let frame = &self.state.frames[network.branches[point.branch].segment_frame(point.segment)];
        let lever = frame.inverse_transform_vector(&contact.normal) * (-own * contact.radius);
        Bond { fraction: touched.fraction, lever }
    }

    /// Anchor of a record once its contact point has slipped to its place at the state.
    pub(crate) fn follow(&self, record: &ContactRecord, anchor: &FrictionAnchor) -> FrictionAnchor {
        let axes = self.axes(record.partner, anchor.bond.as_ref());
        let x = self.local(record.point, &axes, anchor.bond.as_ref());
        let coefficient = self.system.friction_coefficient(record.partner);
        FrictionAnchor { position: anchor.followed(&x, coefficient, self.stiffness(record)), ..*anchor }
    }

    /// Points and frames that bear the friction of a record, which acts at `lever` from the place of the segment.
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

/// Of the records that bind the contact point of a contact to the segments before and behind, the one of largest force.
fn beside<'m>(old: &'m [ContactRecord], contact: &Contact) -> Option<&'m ContactRecord> {
    let Partner::Cable { branch: touched, segment: here } = contact.partner else { return None };
    let same = |record: &&ContactRecord| matches!(record.partner, Partner::Cable { branch, segment } if branch == touched && segment.abs_diff(here) == 1);
    let force = |record: &ContactRecord| record.anchor.map_or(0.0, |anchor| anchor.force);
    records_of(old, contact.point).iter().filter(same).max_by(|a, b| force(a).total_cmp(&force(b)))
}

impl FrictionTerm {
    /// Finds the friction at `state`; returns its energy, J. It acts as long as its normal force is taken to be there,
    /// wherever the contact point is.
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

    /// Friction on a contact point, N, where friction was evaluated last.
    pub fn force_on(&self, contact: &Contact) -> Vector {
        let own = |friction: &&FrictionForce| friction.point == contact.point && friction.partner == contact.partner;
        self.forces.iter().find(own).map_or_else(Vector::zeros, |friction| friction.force)
    }

    /// Adds the first derivatives of the energy of friction: in the points of the partner `f`, of the contact point
    /// `−f`, and in the frames, which carry either surface at a lever a, `∓Rᵀ (a × f)`; returns that energy, J.
    pub fn gradient(
        &mut self,
        contact: &ContactTerm,
        system: System<'_>,
        state: &State,
        gradient: &mut Tangent,
    ) -> f64 {
        let energy = self.energy(contact, system, state);
        for friction in &self.forces {
            for (point, weight) in contact.support(system, friction.point) {
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

    /// Adds the second derivatives of the energy of friction; with `convex` without what makes it less convex.
    ///
    /// Between two cables with frames P and R, levers a and b (world) and turns α and β (body axes): the spring is
    /// drawn out by `δz + b × Rβ` in the axes of R, `δz = δx − δy + Pα × a`, and to second order by
    /// `−Rβ × δz + ½ Rβ × (Rβ × b) + ½ Pα × (Pα × a)`, which the force f is multiplied by.
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
            let own_points = contact.support(system, friction.point);
            let Some(Between { points, frames: [own, other], levers: [a, b] }) = &friction.cables else {
                let places = own_points.map(|(point, u)| (point, u, 0.0));
                contact.add_blocks(system, state, &places, |u, v, _, _| friction.stiffness * (u * v), blocks);
                continue;
            };
            let (p, r) = (state.frames[*own].to_rotation_matrix(), state.frames[*other].to_rotation_matrix());
            let (p, r, f) = (p.matrix(), r.matrix(), &friction.force);
            let frame = Variable::Frame;
            // Each variable with what it adds to δz, to `b × Rβ` and to Rβ.
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
            for (row, [z, by, turn]) in parts() {
                for (column, [y, beside, turns]) in parts() {
                    let mut h = (z + by).transpose() * friction.stiffness * (y + beside);
                    if !convex {
                        h += z.transpose() * turned * turns - turn.transpose() * turned * y;
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
