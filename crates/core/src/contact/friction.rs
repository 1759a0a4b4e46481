//! Friction: springs between what touches, as far as Coulomb's law lets them pull.

use super::{Against, Contact, Mark, Spot, Touched, marks_of, position};
use crate::fixings::Block;
use crate::problem::{Problem, Variable};
use crate::rotation::skew;
use crate::{Matrix, Pose, State, Tangent, Vector};
use serde::{Deserialize, Serialize};

/// What binds a spot to a place of a body, or of another cable: its surface to that one's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grip {
    /// Where it is bound to, m: in the axes of the body; on a cable from the centre line, in the axes of the segment's frame.
    pub(super) anchor: Vector,
    /// n in the same axes.
    normal: Vector,
    /// N, N.
    pub(super) force: f64,
    /// Where two cables are bound to each other.
    pub(super) bond: Option<Bond>,
}

/// Where two cables are bound to each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Bond {
    /// Share of the way along the segment that the spot is bound to.
    share: f64,
    /// From the spot to the surface of its own cable, in the axes of its segment's frame, m.
    lever: Vector,
}

/// Friction on a spot: the force (N), and the second derivative of its energy in where it acts (N/m); world axes.
pub(super) struct Rub {
    spot: u32,
    against: Against,
    force: Vector,
    stiffness: Matrix,
    cables: Option<Between>,
}

/// Friction between two cables: where it acts, and what bears it.
struct Between {
    /// Points of the segment that is touched, and their shares.
    points: [(usize, f64); 2],
    /// Frames of the spot's segment and of the one that is touched.
    frames: [usize; 2],
    /// How far each centre line is from where the force acts, m; world axes.
    levers: [Vector; 2],
}

impl Grip {
    /// Energy (J), force on the spot (N) and second derivative (N/m) of friction with coefficient `f` and stiffness `k`; all in the axes of
    /// what it is bound to.
    fn drag(&self, x: &Vector, f: f64, k: f64) -> (f64, Vector, Matrix) {
        let along = Matrix::identity() - self.normal * self.normal.transpose();
        let u = along * (x - self.anchor);
        let (length, most) = (u.norm(), f * self.force);
        if k * length <= most {
            return (0.5 * k * length * length, -u * k, along * k);
        }
        let d = u / length;
        (most * (length - 0.5 * most / k), -d * most, (along - d * d.transpose()) * (most / length))
    }

    /// Where the anchor is once the spot has slipped to `x`.
    fn followed(&self, x: &Vector, f: f64, k: f64) -> Vector {
        let u = (x - self.anchor) - self.normal * self.normal.dot(&(x - self.anchor));
        let (length, most) = (u.norm(), f * self.force);
        let elastic = if k * length <= most { u } else { u * (most / (k * length)) };
        x - elastic
    }
}

impl Problem<'_> {
    /// Coefficient of friction of what is touched, where it acts.
    pub(super) fn friction(&self, against: Against) -> f64 {
        match against {
            _ if !self.conditions.contact.friction => 0.0,
            Against::Obstacle { obstacle, .. } => self.network.obstacles[obstacle as usize].friction,
            Against::Cable { .. } => self.network.contact.friction,
        }
    }

    /// What is bound to a cable, and to which segment of which branch.
    pub(super) fn bound_cables(&self) -> impl Iterator<Item = (&Mark, [usize; 2])> {
        self.conditions.contact.marks.iter().filter_map(|mark| match mark.against {
            Against::Cable { branch, segment } if mark.grip.is_some() => {
                Some((mark, [branch as usize, segment as usize]))
            }
            _ => None,
        })
    }

    /// The axes that a grip is given in.
    fn axes(&self, state: &State, against: Against, bond: Option<&Bond>) -> Pose {
        match against {
            Against::Obstacle { obstacle, .. } => self.conditions.contact.poses[obstacle as usize],
            Against::Cable { branch, segment } => {
                let (branch, segment) = (branch as usize, segment as usize);
                let share = bond.map_or(0.0, |bond| bond.share);
                Pose {
                    position: position(self.network, state, &Spot { branch, segment, share }),
                    orientation: state.frames[self.network.branches[branch].segment_frame(segment)],
                }
            }
        }
    }

    /// Where a bound spot, or its surface, is in the axes of its grip, m.
    fn seen(&self, state: &State, spot: u32, axes: &Pose, bond: Option<&Bond>) -> Vector {
        let spot = &self.contacts.spots[spot as usize];
        let x = position(self.network, state, spot);
        axes.local(&bond.map_or(x, |bond| x + self.own_lever(state, spot, bond)))
    }

    /// From a spot to the surface that it is bound by, world axes, m.
    fn own_lever(&self, state: &State, spot: &Spot, bond: &Bond) -> Vector {
        state.frames[self.network.branches[spot.branch].segment_frame(spot.segment)] * bond.lever
    }

    /// Stiffness of a grip, N/m: the penalty of the spot, and no less than the cable has along itself. Softer ones would spread the change from
    /// what slips one way to what slips the other over more of the cable than a segment.
    fn hold(&self, mark: &Mark) -> f64 {
        let branch = self.contacts.spots[mark.spot as usize].branch;
        (self.contacts.penalties[branch] * mark.penalty).max(self.contacts.holds[branch])
    }

    /// How friction holds a spot that touches, of which `known` is what was known. The place of an obstacle that it is bound to stays; on a
    /// cable it becomes the one that is touched now, drawn out as before, whichever segment that was on.
    pub(super) fn grip(&self, state: &State, old: &[Mark], known: Option<&Mark>, contact: &Contact) -> Option<Grip> {
        if self.friction(contact.against) == 0.0 {
            return None;
        }
        let known = known.or_else(|| self.beside(old, contact));
        let held = known.and_then(|mark| Some((mark, mark.grip?)));
        let bond = contact.other.as_ref().map(|touched| self.bond(state, contact, touched));
        let axes = self.axes(state, contact.against, bond.as_ref());
        let x = self.seen(state, contact.spot, &axes, bond.as_ref());
        let anchor = match (held, bond) {
            (None, _) => x,
            (Some((_, grip)), None) => grip.anchor,
            (Some((mark, grip)), Some(_)) => {
                let before = self.axes(state, mark.against, grip.bond.as_ref());
                let u = before.orientation * (self.seen(state, mark.spot, &before, grip.bond.as_ref()) - grip.anchor);
                x - axes.orientation.inverse_transform_vector(&(u - contact.normal * contact.normal.dot(&u)))
            }
        };
        let normal = axes.orientation.inverse_transform_vector(&contact.normal);
        Some(Grip { anchor, normal, force: contact.force, bond })
    }

    /// What holds the spot of a contact on the segments before and behind, most of all.
    fn beside<'m>(&self, old: &'m [Mark], contact: &Contact) -> Option<&'m Mark> {
        let Against::Cable { branch: touched, segment: here } = contact.against else { return None };
        let same = |mark: &&Mark| matches!(mark.against, Against::Cable { branch, segment } if branch == touched && segment.abs_diff(here) == 1);
        let force = |mark: &Mark| mark.grip.map_or(0.0, |grip| grip.force);
        marks_of(old, contact.spot).iter().filter(same).max_by(|a, b| force(a).total_cmp(&force(b)))
    }

    /// Where a spot touches another cable.
    fn bond(&self, state: &State, contact: &Contact, touched: &Touched) -> Bond {
        let spot = &self.contacts.spots[contact.spot as usize];
        let diameter = |b: usize| self.network.branches[b].section.diameter;
        let Against::Cable { branch, .. } = contact.against else { unreachable!("obstacles have no segments") };
        let own = diameter(spot.branch) / (diameter(spot.branch) + diameter(branch as usize));
        let frame = &state.frames[self.network.branches[spot.branch].segment_frame(spot.segment)];
        let lever = frame.inverse_transform_vector(&contact.normal) * (-own * contact.radius);
        Bond { share: touched.share, lever }
    }

    /// The grip of a mark once its spot has slipped to where it is at `state`.
    pub(super) fn follow(&self, state: &State, mark: &Mark, grip: &Grip) -> Grip {
        let axes = self.axes(state, mark.against, grip.bond.as_ref());
        let x = self.seen(state, mark.spot, &axes, grip.bond.as_ref());
        Grip { anchor: grip.followed(&x, self.friction(mark.against), self.hold(mark)), ..*grip }
    }

    /// Finds what friction exerts at `state`; returns its energy, J. It acts as long as its normal force is taken to be there, wherever the spot is.
    pub(super) fn find_rubs(&mut self, state: &State) -> f64 {
        let mut rubs = std::mem::take(&mut self.contacts.rubs);
        rubs.clear();
        let mut energy = 0.0;
        for mark in &self.conditions.contact.marks {
            let Some(grip) = &mark.grip.filter(|_| self.friction(mark.against) > 0.0) else { continue };
            let axes = self.axes(state, mark.against, grip.bond.as_ref());
            let x = self.seen(state, mark.spot, &axes, grip.bond.as_ref());
            let (e, force, stiffness) = grip.drag(&x, self.friction(mark.against), self.hold(mark));
            energy += e;
            let r = axes.orientation.to_rotation_matrix();
            let stiffness = r.matrix() * stiffness * r.matrix().transpose();
            let cables = grip.bond.as_ref().map(|bond| self.between(state, mark, bond, r * x));
            rubs.push(Rub { spot: mark.spot, against: mark.against, force: r * force, stiffness, cables });
        }
        self.contacts.rubs = rubs;
        energy
    }

    /// What bears the friction of a spot, which acts at `lever` from the place of the segment.
    fn between(&self, state: &State, mark: &Mark, bond: &Bond, lever: Vector) -> Between {
        let spot = &self.contacts.spots[mark.spot as usize];
        let Against::Cable { branch, segment } = mark.against else { unreachable!("what is bound to a cable") };
        let (branch, segment) = (branch as usize, segment as usize);
        let first = self.network.branches[branch].points.start + segment;
        Between {
            points: [(first, 1.0 - bond.share), (first + 1, bond.share)],
            frames: [(spot.branch, spot.segment), (branch, segment)]
                .map(|(b, j)| self.network.branches[b].segment_frame(j)),
            levers: [self.own_lever(state, spot, bond), lever],
        }
    }

    /// What friction exerts on a spot, N.
    pub(super) fn drag_on(&self, contact: &Contact) -> Vector {
        let own = |rub: &&Rub| rub.spot == contact.spot && rub.against == contact.against;
        self.contacts.rubs.iter().find(own).map_or_else(Vector::zeros, |rub| rub.force)
    }

    /// Adds the first derivatives of the energy of friction: in the points of what is touched `f`, of the spot `−f`, and in the frames, of
    /// which either surface is carried along at a lever a, `∓Rᵀ (a × f)`.
    pub(super) fn rub_gradient(&self, state: &State, gradient: &mut Tangent) {
        for rub in &self.contacts.rubs {
            for (point, share) in self.spot_points(rub.spot) {
                gradient.points[point] -= rub.force * share;
            }
            let Some(Between { points, frames: [own, other], levers: [a, b] }) = &rub.cables else { continue };
            for (point, share) in points {
                gradient.points[*point] += rub.force * *share;
            }
            gradient.frames[*own] -= state.frames[*own].inverse_transform_vector(&a.cross(&rub.force));
            gradient.frames[*other] += state.frames[*other].inverse_transform_vector(&b.cross(&rub.force));
        }
    }

    /// Adds the second derivatives of the energy of friction; with `convex` without what makes it less convex.
    ///
    /// Between two cables with frames P and R, levers a and b (world) and turns α and β (body axes): the spring is drawn out by
    /// `δz + b × Rβ` in the axes of R, `δz = δx − δy + Pα × a`, and to second order by
    /// `−Rβ × δz + ½ Rβ × (Rβ × b) + ½ Pα × (Pα × a)`, which the force f is multiplied by.
    pub(super) fn rub_hessian(&self, state: &State, convex: bool, blocks: &mut Vec<Block>) {
        for rub in &self.contacts.rubs {
            let spot = self.spot_points(rub.spot);
            let Some(Between { points, frames: [own, other], levers: [a, b] }) = &rub.cables else {
                self.add_blocks(
                    state,
                    &spot.map(|(point, u)| (point, u, 0.0)),
                    |u, v, _, _| rub.stiffness * (u * v),
                    blocks,
                );
                continue;
            };
            let (p, r) = (state.frames[*own].to_rotation_matrix(), state.frames[*other].to_rotation_matrix());
            let (p, r, f) = (p.matrix(), r.matrix(), &rub.force);
            let frame = Variable::Frame;
            // Each variable with what it adds to δz, to `b × Rβ` and to Rβ.
            let parts = || {
                let points = spot.into_iter().chain(points.map(|(point, share)| (point, -share)));
                let columns = points.filter(|(_, share)| *share != 0.0).flat_map(|(point, share)| {
                    self.columns(state, point).into_iter().flatten().map(move |(v, column)| (v, column * share))
                });
                let (none, with_own) = (Matrix::zeros(), (frame(*own), -(skew(a) * p)));
                let moved = columns.chain([with_own]).map(move |(v, column)| (v, [column, none, none]));
                moved.chain([(frame(*other), [none, skew(b) * r, *r])])
            };
            let turned = skew(f);
            for (row, [z, by, turn]) in parts() {
                for (column, [y, beside, turns]) in parts() {
                    let mut h = (z + by).transpose() * rub.stiffness * (y + beside);
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
