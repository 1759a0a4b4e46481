//! Where contact points touch obstacles: on the arc of their segment, and at edges where that is nearest.
//!
//! **Arcs.** The polygon through the nodes is beside the centre line by up to `ℓ² κ/8`, and its corners catch on a body
//! as if there were friction with the coefficient `ℓ κ/2`. So a segment touches obstacles as the arc between its nodes
//! with the curvatures x″ there (a cubic; Catmull and Rom 1974, A class of local interpolating splines). x″ is that of
//! the last update of the multipliers, so forces act on the two nodes of the segment alone; contact is not met while x″
//! moves a place by more than the tolerance of depth. Where the arc bends towards the body the chord counts, as on the
//! ground, where a cable touches at its nodes. As the force acts on the chord its moment misses the part of the way
//! from chord to arc that is across the force.
//!
//! **Edges.** Contact points that stay in the material make an edge rest in the notch between two of them: with the
//! depth d there it resists sliding like a coefficient of friction of `√(2 d/R)`. So points that are added where an
//! edge presses in follow the place where φ is least along their segment: that `min φ` depends on the shape of the
//! cable alone. Where friction acts they stay, as it holds the material, and so they do where a cable is wrapped round
//! a body: there φ is nearly even along the segment.

use super::distance_cache::CachedDistance;
use super::term::{Contact, ContactTerm, Sliding};
use crate::arc::Arc;
use crate::conditions::{ContactPoint, Partner, System};
use crate::obstacle::{Shape, Touch};
use crate::{Matrix, State, Vector};

/// How far a contact place goes from its contact point along the cable, in radii: less than the margin of the cache of
/// obstacles.
pub(super) const WINDOW: f64 = 0.9;
/// Curvature, in units of 1/R, of a parabola that holds a contact place to its contact point: it does not jump from one
/// end of a flat face to the other. So much of the normal force per radius of their distance resists sliding.
const HOLD: f64 = 0.01;
/// Distance, in radii, at which a contact point is moved to the contact place.
const FAR: f64 = 0.1;
/// Share of the height of an arc by which permanent contact points between nodes are beyond it: where a cable is
/// wrapped round a body its nodes alone bear, and not now these, now those.
pub(super) const RECESS: f64 = 0.1;
/// Way from chord to arc, in radii, that is none.
const SAME: f64 = 1e-6;
/// Steps of the bisection for the lowest place between two contact points.
const SEARCH: usize = 30;
/// Largest number of steps to the least distance.
const STEPS: usize = 60;
/// Slope of φ along the segment at which the search ends.
const LEVEL: f64 = 1e-13;
/// Slope of φ along the segment below which a surface is the one that is nearest there.
const STATIONARY: f64 = 1e-9;
/// Curvature of a surface, in units of 1/R, above which it is an edge.
const SHARP: f64 = 0.02;
/// Share of it that is left when the curvature of the cable is taken from it, on an edge: where more is taken the cable
/// is wrapped round the body.
const UNWRAPPED: f64 = 0.5;
/// Depth, in radii, by which a place must be deeper than other contact points, also than one that follows, to get one
/// that follows.
pub(super) const FOLLOWED: f64 = 1e-4;
/// How far a surface is searched for, in radii.
const REACH: f64 = 2.0 + WINDOW;

impl ContactTerm {
    /// x″ of the centre line at each point, 1/m.
    pub fn bends(system: System<'_>, state: &State) -> Vec<Vector> {
        let mut bends = vec![Vector::zeros(); system.network.points];
        for branch in &system.network.branches {
            let points: Vec<Vector> = branch.points.clone().map(|i| state.points[i] + state.compensation[i]).collect();
            bends[branch.points.clone()].copy_from_slice(&crate::arc::bends(&points, &branch.rod.mesh().rest_lengths));
        }
        bends
    }

    /// Distance, m, by which the gap of a contact would change if x″ were that at `state`.
    pub(super) fn stale(system: System<'_>, contact: &Contact, point: &ContactPoint, bends: &[Vector]) -> f64 {
        let beside = |branch: usize, segment: usize, t: f64| {
            let branch = &system.network.branches[branch];
            let i = branch.points.start + segment;
            let known = |i: usize| system.conditions.contact.bends.get(i).copied().unwrap_or_default();
            let [a, b] = [i, i + 1].map(|i| bends[i] - known(i));
            let square = branch.rod.mesh().rest_lengths[segment].powi(2);
            contact.normal.dot(&(a * (1.0 - t) + b * t)) * (0.5 * square * t * (1.0 - t))
        };
        let own = || beside(point.branch, point.segment, contact.fraction);
        match (contact.partner, &contact.other) {
            (Partner::Cable { branch, segment }, Some(touched)) => {
                let other = (branch as usize, segment as usize);
                let crosses = system.conditions.contact.cross((point.branch, point.segment), other);
                if crosses { (own() - beside(other.0, other.1, touched.fraction)).abs() } else { 0.0 }
            }
            _ => own().abs(),
        }
    }

    /// Whether a contact place that follows the same thing is on the same segment, and as near.
    pub(super) fn has_follower(&self, place: &ContactPoint, distance: f64) -> bool {
        self.found.iter().any(|contact| {
            let point = &self.points[contact.point as usize];
            let is_beside = (point.branch, point.segment) == (place.branch, place.segment);
            let follows = point.follows.is_some() && point.follows == place.follows;
            is_beside && follows && contact.gap + contact.radius <= distance + FOLLOWED * contact.radius
        })
    }

    /// The added contact points, those that follow at the places of their contacts as found last: from the end of their
    /// range they go on, and where the cable is bent round a body they stay. `None` if nothing changes much.
    pub fn followed(&self, system: System<'_>, state: &State) -> Option<Vec<ContactPoint>> {
        let mut extra = self.points[self.own..].to_vec();
        let mut changes = false;
        for (k, point) in extra.iter_mut().enumerate().filter(|(_, point)| point.follows.is_some()) {
            let own = self.found.iter().filter(|contact| contact.point as usize == self.own + k);
            let Some(contact) = own.max_by(|a, b| a.force.total_cmp(&b.force)) else { continue };
            let way = (contact.fraction - point.fraction).abs() * arc_of(system, state, point).edge().norm();
            let radius = system.network.radius(point.branch, point.segment);
            changes |= !contact.on_edge || way > FAR * radius;
            point.fraction = contact.fraction;
            if !contact.on_edge {
                point.follows = None;
            }
        }
        changes.then_some(extra)
    }

    /// Contact place of a contact point and an obstacle.
    pub(super) fn contact_place(
        &self,
        system: System<'_>,
        state: &State,
        index: u32,
        cached: &CachedDistance,
    ) -> ContactPlace {
        let point = self.points[index as usize];
        let o = cached.obstacle as usize;
        let (shape, pose) = (&*system.network.obstacles[o].shape, &system.conditions.contact.poses[o]);
        let branch = &system.network.branches[point.branch];
        let radius = system.network.radius(point.branch, point.segment);
        let length = branch.rod.mesh().rest_lengths[point.segment];
        let arc = arc_of(system, state, &point);
        let (chord, beside) = (arc.chord().at(point.fraction), arc.beside(point.fraction));
        let tangent = arc.edge();
        let stays = |position| ContactPlace { fraction: point.fraction, position, held: 0.0, profile: None, tangent };
        if point.follows.is_none() && beside.norm() <= SAME * radius {
            return stays(chord);
        }
        let reach = REACH * radius;
        let nearest = |x: &Vector| nearest_part(shape, reach, x);
        let along = Along { nearest: &nearest, arc: arc.seen_from(pose) };
        if cached.is_beyond(&along.arc.at(point.fraction), reach) {
            return stays(chord);
        }
        if point.follows.is_none() {
            // Of chord and arc the one that is farther from the body counts.
            let recess = if (index as usize) < self.own { RECESS } else { 0.0 };
            let normal = nearest(&pose.local(&chord)).map(|touch| pose.orientation * touch.normal);
            let is_arc = normal.is_some_and(|normal| normal.dot(&beside) > 0.0);
            return stays(if is_arc { chord + beside * (1.0 + recess) } else { chord });
        }
        along.followed(&arc, point.fraction, radius, length).unwrap_or_else(|| stays(chord + beside))
    }
}

/// Where a contact point may touch something.
pub(super) struct ContactPlace {
    /// Place on the segment as a fraction of its length.
    pub(super) fraction: f64,
    /// Position, m.
    pub(super) position: Vector,
    /// What holds it to its contact point, as a part of the gap, m.
    pub(super) held: f64,
    /// φ along the segment where the place follows.
    pub(super) profile: Option<Profile>,
    /// ∂x/∂t of the centre line there, m.
    pub(super) tangent: Vector,
}

impl ContactPlace {
    /// How it slides on a surface with this normal; what that does to the second derivatives of φ by the motion of the
    /// place is taken out of `curvature`.
    pub(super) fn sliding(&self, normal: &Vector, curvature: &mut Matrix) -> Option<Sliding> {
        let profile = self.profile.as_ref().filter(|profile| profile.is_level)?;
        let by_tangent = *curvature * self.tangent;
        let is_nearest = (normal.dot(&self.tangent) - profile.slope).abs() <= STATIONARY * self.tangent.norm();
        if !(is_nearest && profile.stiffness > 0.0) {
            return None;
        }
        *curvature -= by_tangent * by_tangent.transpose() / profile.stiffness;
        Some(Sliding { by_motion: by_tangent / profile.stiffness, by_turn: 1.0 / profile.stiffness })
    }
}

/// Arc of the segment of a contact point.
pub(super) fn arc_of(system: System<'_>, state: &State, point: &ContactPoint) -> Arc {
    let i = system.network.branches[point.branch].points.start + point.segment;
    let ends = [i, i + 1].map(|i| state.points[i] + state.compensation[i]);
    arc_between(system, (point.branch, point.segment), ends)
}

/// Arc of a segment of a branch between these nodes, m.
pub(super) fn arc_between(system: System<'_>, (branch, segment): (usize, usize), [start, end]: [Vector; 2]) -> Arc {
    let branch = &system.network.branches[branch];
    let i = branch.points.start + segment;
    let bends = system.conditions.contact.bends.get(i..=i + 1);
    let bends = bends.map_or([Vector::zeros(); 2], |bends| [bends[0], bends[1]]);
    Arc::new(start, end, branch.rod.mesh().rest_lengths[segment], bends)
}

/// The part of a surface nearest to a point, up to `reach`, m.
pub(super) fn nearest_part(shape: &dyn Shape, reach: f64, x: &Vector) -> Option<Touch> {
    let mut least: Option<Touch> = None;
    shape.touches(x, reach, &mut |touch| {
        if least.as_ref().is_none_or(|least| touch.distance < least.distance) {
            least = Some(touch);
        }
    });
    least
}

/// An arc beside something.
#[derive(Clone, Copy)]
pub(super) struct Along<'a> {
    /// What of it is nearest to a point; `None` if it is out of reach.
    pub(super) nearest: &'a dyn Fn(&Vector) -> Option<Touch>,
    /// The arc, in the same axes.
    pub(super) arc: Arc,
}

/// φ along an arc, t from 0 to 1.
#[derive(Clone, Copy)]
pub(super) struct Profile {
    /// φ, m.
    pub(super) distance: f64,
    /// ∂φ/∂t, m.
    pub(super) slope: f64,
    /// The two parts of ∂²φ/∂t², m: by the curvature of the surface, and by that of the arc.
    bends: [f64; 2],
    /// Their sum, with what holds a place that follows, m.
    stiffness: f64,
    /// Whether a place that follows is at rest there, and not at the end of its range.
    is_level: bool,
}

impl Profile {
    /// Whether the cable lies on an edge: the surface is sharp, and the cable is not wrapped round it.
    pub(super) fn is_edge(&self, length: f64, radius: f64) -> bool {
        let [surface, arc] = self.bends;
        surface > SHARP * length * length / radius && surface + arc > UNWRAPPED * surface
    }
}

impl Along<'_> {
    /// Contact place that follows from `start`: the fraction to which φ decreases along the arc, held by a parabola;
    /// `line` is the arc in the axes of the world, `radius` that of the cable and `length` that of its segment, m.
    pub(super) fn followed(&self, line: &Arc, start: f64, radius: f64, length: f64) -> Option<ContactPlace> {
        let (window, hold) = (WINDOW * radius / length, HOLD * length * length / radius);
        let range = [(start - window).max(0.0), (start + window).min(1.0)];
        let (fraction, profile) = self.least(start, range, hold)?;
        Some(ContactPlace {
            fraction,
            position: line.at(fraction),
            held: 0.5 * hold * (fraction - start).powi(2),
            profile: Some(profile),
            tangent: line.tangent(fraction),
        })
    }

    /// φ at a fraction of the arc; `None` if it is out of reach.
    pub(super) fn at(&self, t: f64) -> Option<Profile> {
        let touch = (self.nearest)(&self.arc.at(t))?;
        let (tangent, bend) = (self.arc.tangent(t), self.arc.bend(t));
        let bends = [tangent.dot(&(touch.curvature * tangent)), touch.normal.dot(&bend)];
        let stiffness = bends[0] + bends[1];
        let slope = touch.normal.dot(&tangent);
        Some(Profile { distance: touch.distance, slope, bends, stiffness, is_level: false })
    }

    /// Fraction at which φ is least between these two, if it decreases from both and may be less than `most` (m) there.
    pub(super) fn lowest(&self, [first, last]: [f64; 2], most: f64) -> Option<f64> {
        let [start, end] = [self.at(first)?, self.at(last)?];
        let length = self.arc.edge().norm() * (last - first);
        if start.slope >= 0.0 || end.slope <= 0.0 || 0.5 * (start.distance + end.distance - length) >= most {
            return None;
        }
        let (mut low, mut high) = (first, last);
        for _ in 0..SEARCH {
            let middle = 0.5 * (low + high);
            if self.at(middle)?.slope < 0.0 { low = middle } else { high = middle }
        }
        Some(0.5 * (low + high))
    }

    /// Fraction in `range` to which `φ + ½ hold (t − start)²` decreases from `start`, and φ there; `None` if the
    /// body is out of reach. Newton's method, with bisections where it leaves the bracket.
    fn least(&self, start: f64, [first, last]: [f64; 2], hold: f64) -> Option<(f64, Profile)> {
        let level = LEVEL * self.arc.edge().norm();
        let mut own = self.at(start)?;
        let slope = |own: &Profile, t: f64| own.slope + hold * (t - start);
        let end = if own.slope > 0.0 { first } else { last };
        if own.slope.abs() > level {
            let at_end = self.at(end)?;
            if slope(&at_end, end) * own.slope > 0.0 {
                return Some((end, at_end));
            }
        }
        let (mut low, mut high) = if own.slope > 0.0 { (end, start) } else { (start, end) };
        let mut t = start;
        for _ in 0..STEPS {
            let slope = slope(&own, t);
            if slope.abs() <= level {
                break;
            }
            if slope > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - slope / (own.stiffness + hold);
            t = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            own = self.at(t)?;
        }
        Some((t, Profile { stiffness: own.stiffness + hold, is_level: true, ..own }))
    }
}
