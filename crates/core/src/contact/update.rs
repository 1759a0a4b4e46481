//! What happens between minimisations: multipliers, spots that are added, friction, and what is carried along.

use super::watch::Watched;
use super::{Against, BETWEEN, Contact, DEPTH, Mark, Spot, marks_of, position};
use crate::problem::{Conditions, Problem};
use crate::{State, Vector};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;

/// Where an update leaves more than this share of the largest depth, penalties are raised.
const SHRINKS: f64 = 0.5;
/// By how much.
const RAISE: f64 = 10.0;
/// Highest penalty in units of the first one.
const HIGHEST: f64 = 1e4;
/// Share by which the normal force of friction may differ from the one that is there.
const SETTLED: f64 = 1e-3;
/// A spot is added no nearer to others than this share of the distance between its neighbours.
const APART: f64 = 0.1;
/// Steps of the search for the deepest place between two spots; each takes a third off the interval.
const SEARCH: usize = 16;

/// Rounds that the mixing of forces goes by.
const MIXED: usize = 6;
/// No force is mixed to more times the largest that was found.
const FARTHEST: f64 = 10.0;
/// Singular values below this share of the largest say nothing in it.
const SINGULAR: f64 = 1e-8;

/// What is known of the rounds in which multipliers were updated. That the forces found under the last multipliers become the next ones
/// converges slowly where spots share the load or friction passes tension on; mixing what the last rounds have shown makes it fast
/// (Anderson 1965; Walker and Ni 2011).
#[derive(Default)]
pub struct Rounds {
    /// How deep the deepest spot was in the last one, in radii.
    deepest: Option<f64>,
    /// Which spots touched what.
    keys: Vec<(u32, Against)>,
    /// Multipliers, and the forces found under them, round by round.
    given: Vec<DVector<f64>>,
    found: Vec<DVector<f64>>,
}

impl Rounds {
    /// The next multipliers, after a round in which `found` came of `given`.
    fn mix(&mut self, keys: Vec<(u32, Against)>, given: DVector<f64>, found: DVector<f64>) -> DVector<f64> {
        if keys != self.keys {
            (self.keys, self.given, self.found) = (keys, Vec::new(), Vec::new());
        }
        if self.given.len() == MIXED {
            self.given.remove(0);
            self.found.remove(0);
        }
        self.given.push(given);
        self.found.push(found);
        let last = self.given.len() - 1;
        let off: Vec<DVector<f64>> = self.given.iter().zip(&self.found).map(|(given, found)| found - given).collect();
        if last == 0 {
            return self.found[0].clone();
        }
        let changes = DMatrix::from_fn(off[0].len(), last, |i, k| off[k + 1][i] - off[k][i]);
        let svd = changes.svd(true, true);
        let cut = SINGULAR * svd.singular_values.max();
        let Ok(shares) = svd.solve(&off[last], cut) else { return self.found[last].clone() };
        let mut next = self.found[last].clone();
        for (k, share) in shares.iter().enumerate() {
            next -= (&self.found[k + 1] - &self.found[k]) * *share;
        }
        let most = FARTHEST * self.found[last].max();
        next.map(|force| force.max(0.0).min(most))
    }
}

/// What a harness exerts on an obstacle, and how it lies there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touching {
    /// Force on the harness, N.
    pub force: Vector,
    /// Moment on the harness about the obstacle's position, N m.
    pub moment: Vector,
    /// Number of spots that are pushed.
    pub spots: usize,
    /// How deep the deepest of them is, m.
    pub depth: f64,
}

/// A place where contact is not met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnmetContact {
    /// Index of the branch.
    pub branch: usize,
    /// Arc length, m.
    pub s: f64,
    /// What it touches.
    pub against: Against,
    /// What is wrong.
    pub lack: Lack,
}

/// What is wrong with a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lack {
    /// It is so deep, m; where that is negative it pushes from so far away.
    Depth(f64),
    /// Friction goes by a normal force that is so far from the one that is there, N.
    Friction(f64),
}

impl Problem<'_> {
    /// How far contact is from being met at `state`, in units of what is let pass: 1 or less is met. `None` where nothing can touch.
    pub fn contact_unmet(&mut self, state: &State) -> Option<f64> {
        if self.contacts.is_idle() {
            return None;
        }
        self.find_contacts(state);
        let mut worst = 0.0_f64;
        self.for_unmet(|value, _, _, _| worst = worst.max(value));
        Some(worst)
    }

    /// Where contact is furthest from being met at `state`, if it is not.
    pub fn worst_contact(&mut self, state: &State) -> Option<UnmetContact> {
        if self.contacts.is_idle() {
            return None;
        }
        self.find_contacts(state);
        let mut worst: Option<(f64, u32, Against, Lack)> = None;
        self.for_unmet(|value, spot, against, lack| {
            if value > worst.map_or(1.0, |worst| worst.0) {
                worst = Some((value, spot, against, lack));
            }
        });
        worst.map(|(_, spot, against, lack)| {
            let Spot { branch, segment, share } = self.contacts.spots[spot as usize];
            let lengths = &state.rest_lengths[self.network.branches[branch].points.start..];
            let s = lengths[..segment].iter().sum::<f64>() + lengths[segment] * share;
            UnmetContact { branch, s, against, lack }
        })
    }

    /// Shows how far everything that touches is from being met, where contacts were found last, in units of what is let pass.
    fn for_unmet(&self, mut see: impl FnMut(f64, u32, Against, Lack)) {
        let marks = &self.conditions.contact.marks;
        let found = &self.contacts.found;
        let largest = found.iter().map(|c| c.force).fold(0.0, f64::max);
        for contact in found {
            let Contact { spot, against, gap, .. } = *contact;
            see(gap.abs() / (DEPTH * contact.radius), spot, against, Lack::Depth(-gap));
            if self.friction(against) > 0.0 {
                let grip = self.mark_of(marks, contact).and_then(|mark| mark.grip);
                let off = (grip.map_or(0.0, |grip| grip.force) - contact.force).abs();
                see(off / (SETTLED * largest), spot, against, Lack::Friction(off));
            }
        }
        // What has opened must not be left with a multiplier, λ/ρ in metres: the measure of complementarity `|max(c, −λ/ρ)|` (Birgin and Martínez
        // 2014, Practical Augmented Lagrangian Methods). Residuals are measured by what pushes, and a large one would hide any of them.
        let touching: BTreeSet<_> = found.iter().map(|contact| (contact.spot, contact.against)).collect();
        for mark in marks.iter().filter(|mark| !touching.contains(&(mark.spot, mark.against))) {
            let branch = self.contacts.branch_of(mark);
            let reach = mark.multiplier / (self.contacts.penalties[branch] * mark.penalty);
            let radius = 0.5 * self.network.branches[branch].section.diameter;
            see(reach / (DEPTH * radius), mark.spot, mark.against, Lack::Depth(-reach));
            // Friction that still acts there, by a normal force of before: however small it is, nothing bears it.
            let grip = mark.grip.filter(|grip| grip.force > 0.0 && self.friction(mark.against) > 0.0);
            if let Some(grip) = grip {
                see(f64::INFINITY, mark.spot, mark.against, Lack::Friction(grip.force));
            }
        }
    }

    fn mark_of<'m>(&self, marks: &'m [Mark], contact: &Contact) -> Option<&'m Mark> {
        marks_of(marks, contact.spot).iter().find(|mark| mark.against == contact.against)
    }

    /// Moves multipliers to the forces that there are at `state`, a minimum, or where `rounds` say that they are going; raises the penalties of
    /// spots that are too deep if the deepest has hardly risen since the last round; lets friction take hold.
    pub fn update_contacts(&mut self, state: &State, rounds: &mut Rounds) {
        if self.contacts.is_idle() {
            return;
        }
        self.find_contacts(state);
        let old = std::mem::take(&mut self.conditions.contact.marks);
        let depths = self.contacts.found.iter().map(|c| c.gap.abs() / c.radius);
        let deepest = depths.fold(0.0, f64::max);
        let raise = rounds.deepest.replace(deepest).is_some_and(|last| deepest > SHRINKS * last);
        let mut given = Vec::with_capacity(self.contacts.found.len());
        let mut marks = Vec::with_capacity(self.contacts.found.len());
        for contact in &self.contacts.found {
            let known = self.mark_of(&old, contact);
            let mut penalty = known.map_or(1.0, |mark| mark.penalty);
            if raise && contact.gap.abs() > DEPTH * contact.radius {
                penalty = (RAISE * penalty).min(HIGHEST);
            }
            let grip = self.grip(state, &old, known, contact);
            let (spot, against) = (contact.spot, contact.against);
            given.push(known.map_or(0.0, |mark| mark.multiplier));
            marks.push(Mark { spot, against, multiplier: contact.force, penalty, grip });
        }
        let keys = marks.iter().map(|mark| (mark.spot, mark.against)).collect();
        let found = DVector::from_iterator(marks.len(), marks.iter().map(|mark| mark.multiplier));
        let next = rounds.mix(keys, DVector::from_vec(given), found);
        for (mark, force) in marks.iter_mut().zip(&next) {
            mark.multiplier = *force;
            if let Some(grip) = &mut mark.grip {
                grip.force = *force;
            }
        }
        marks.sort_by_key(|mark| (mark.spot, mark.against));
        self.conditions.contact.marks = marks;
    }

    /// Adds spots where the cable lies deeper between two of them than is let pass. Returns whether it did. Only between spots of which one
    /// is pushed at `state`, or that both are within a spacing of a body.
    pub fn refine_spots(&mut self, state: &State) -> bool {
        if self.contacts.is_idle() {
            return false;
        }
        self.look(state);
        self.search_pairs(state);
        let mut found: Vec<Spot> = Vec::new();
        for pair in &self.contacts.cables.pairs {
            let spot = self.contacts.spots[pair.spot as usize];
            if spot.share < 1.0 {
                self.crossings(state, pair, self.next_share(&spot), &mut found);
            }
        }
        for &index in &self.contacts.near {
            let spot = self.contacts.spots[index as usize];
            if spot.share == 1.0 {
                continue;
            }
            let next = self.next_share(&spot);
            for watched in &self.contacts.watched[index as usize] {
                found.extend(self.deepest_between(state, &spot, next, watched));
            }
        }
        found.sort_by(|a, b| (a.branch, a.segment).cmp(&(b.branch, b.segment)).then(a.share.total_cmp(&b.share)));
        found.dedup_by(|a, b| a.branch == b.branch && a.segment == b.segment && (a.share - b.share).abs() < 1e-6);
        if found.is_empty() {
            return false;
        }
        self.conditions.contact.extra.extend(found);
        let extra = std::mem::take(&mut self.conditions.contact.extra);
        self.contacts.set_extra(&extra);
        self.conditions.contact.extra = extra;
        true
    }

    /// Where the next spot on the segment is, whoever it is: those that every harness has are in order.
    pub(super) fn next_share(&self, spot: &Spot) -> f64 {
        let place = |s: &Spot| (s.branch, s.segment);
        let (own, added) = self.contacts.spots.split_at(self.contacts.own);
        let first = own.partition_point(|s| place(s) < place(spot));
        let others = own[first..].iter().take_while(|s| place(s) == place(spot));
        let others = others.chain(added.iter().filter(|s| place(s) == place(spot)));
        others.map(|s| s.share).filter(|t| *t > spot.share).fold(1.0, f64::min)
    }

    /// The deepest place between a spot and the next one on its segment, if it is deeper than is let pass, and deeper than both.
    fn deepest_between(&self, state: &State, spot: &Spot, next: f64, watched: &Watched) -> Option<Spot> {
        let o = watched.obstacle as usize;
        let (shape, pose) = (&self.network.obstacles[o].shape, &self.conditions.contact.poses[o]);
        let radius = self.touch_radius(state, spot, watched.obstacle);
        let at = |share: f64| Spot { share, ..*spot };
        let own = |share: f64| pose.local(&position(self.network, state, &at(share)));
        let (a, b) = (own(spot.share), own(next));
        let way = b - a;
        let let_pass = radius - BETWEEN * radius;
        // φ falls no faster than one goes.
        if watched.is_beyond(&a, let_pass + way.norm()) {
            return None;
        }
        // φ and how it falls along the way.
        let nearest = |x: &Vector| {
            let mut least: Option<(f64, f64)> = None;
            shape.touches(x, 2.0 * radius + way.norm(), &mut |touch| {
                if least.is_none_or(|(distance, _)| touch.distance < distance) {
                    least = Some((touch.distance, touch.normal.dot(&way)));
                }
            });
            least
        };
        let (at_a, down) = nearest(&a)?;
        if down >= 0.0 {
            return None;
        }
        let (at_b, up) = nearest(&b)?;
        // Along a straight line φ of a convex body is convex: it lies above its tangents.
        if up <= 0.0 || 0.5 * (at_a + at_b - way.norm()) >= let_pass {
            return None;
        }
        // at_a + down t = at_b + up (t − 1)
        let meet = (at_b - up - at_a) / (down - up);
        if at_a + down * meet >= let_pass {
            return None;
        }
        let depth = |x: &Vector| shape.distance(x, 2.0 * radius + way.norm());
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..SEARCH {
            let (first, second) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if depth(&(a + way * first)) < depth(&(a + way * second)) {
                high = second;
            } else {
                low = first;
            }
        }
        let t = 0.5 * (low + high);
        let deepest = depth(&(a + way * t));
        let inside = t > APART && t < 1.0 - APART;
        (inside && deepest < let_pass && deepest < at_a.min(at_b)).then(|| at(spot.share + (next - spot.share) * t))
    }

    /// Notes where friction has got to, and forgets spots that were added and are not needed any more; called at the equilibrium an
    /// increment ends in.
    pub(crate) fn commit_contacts(&mut self, state: &State) {
        if self.contacts.is_idle() {
            return;
        }
        self.find_contacts(state);
        let mut marks = std::mem::take(&mut self.conditions.contact.marks);
        for mark in &mut marks {
            mark.grip = mark.grip.map(|grip| self.follow(state, mark, &grip));
        }
        // Penalties that were raised stay so only where something is pushed.
        let own = self.contacts.own;
        let needed = |k: usize| marks.iter().any(|mark| mark.spot as usize == own + k);
        let kept: Vec<usize> = (0..self.conditions.contact.extra.len()).filter(|&k| needed(k)).collect();
        if kept.len() < self.conditions.contact.extra.len() {
            for mark in &mut marks {
                if let Some(k) = (mark.spot as usize).checked_sub(own) {
                    let place = kept.iter().position(|&old| old == k).expect("what is marked is kept");
                    mark.spot = (own + place) as u32;
                }
            }
            let extra: Vec<Spot> = kept.iter().map(|&k| self.conditions.contact.extra[k]).collect();
            self.contacts.set_extra(&extra);
            self.conditions.contact.extra = extra;
        }
        self.conditions.contact.marks = marks;
        self.commit_pairs(state);
    }

    /// Makes what contact carries along that of other conditions; obstacles stay where they are.
    pub fn set_contacts(&mut self, other: &Conditions) {
        self.conditions.contact.marks.clone_from(&other.contact.marks);
        // They may couple what nothing couples now.
        if self.bound_cables().next().is_some() {
            self.contacts.cables.search_again();
        }
        self.conditions.contact.overlaps.clone_from(&other.contact.overlaps);
        if self.conditions.contact.extra != other.contact.extra {
            self.conditions.contact.extra.clone_from(&other.contact.extra);
            self.contacts.set_extra(&other.contact.extra);
        }
    }

    /// Lets friction act from now on.
    pub fn let_rub(&mut self) {
        self.conditions.contact.friction = true;
    }

    /// By point: whether it belongs to a segment that touches something at `state`, or that may come to with a step.
    pub fn touching_points(&mut self, state: &State) -> Vec<bool> {
        let mut touching = vec![false; self.network.points];
        self.find_contacts(state);
        for contact in self.contacts.found.iter().chain(&self.contacts.coming) {
            let others = contact.other.iter().flat_map(|other| [other.first, other.first + 1]);
            let own = self.spot_points(contact.spot).map(|(point, _)| point);
            own.into_iter().chain(others).for_each(|point| touching[point] = true);
        }
        // What meets at a joint is drawn there as one.
        for tie in &self.network.ties {
            touching[tie.hub_point] |= touching[tie.point];
        }
        for tie in &self.network.ties {
            touching[tie.point] |= touching[tie.hub_point];
        }
        touching
    }

    /// What every obstacle exerts on the harness at `state`.
    pub fn touching(&mut self, state: &State) -> Vec<Touching> {
        let mut all = vec![Touching::default(); self.network.obstacles.len()];
        self.find_contacts(state);
        for contact in &self.contacts.found {
            let Some(o) = contact.against.obstacle().map(|o| o as usize) else { continue };
            let force = contact.normal * contact.force + self.drag_on(contact);
            // Friction on an obstacle acts on the centre line, the push along its normal on all that is below.
            let lever = contact.position - self.conditions.contact.poses[o].position;
            all[o].force += force;
            all[o].moment += lever.cross(&force);
            all[o].spots += 1;
            all[o].depth = all[o].depth.max(-contact.gap);
        }
        all
    }
}
