//! Where a contact point touches another cable.
//!
//! Where cables cross they touch on the arcs of their segments (see `follow`): as a polygon each would catch on the
//! other one at its corners. Without friction the point that is added there follows the place where the two arcs are
//! nearest to each other; so that it is one place, only the lower one of the two segments follows. Cables that lie side
//! by side, nearly parallel or wrapped round each other, touch on the chords: on smooth lines the points of both would
//! bear the same load, now these, now those.

use super::follow::{Along, ContactPlace, FOLLOWED, arc_between, arc_of};
use super::pairs::Pair;
use super::term::{Contact, ContactTerm, DEPTH, Slides, Sliding};
use crate::arc::Arc;
use crate::conditions::{Against, ContactPoint, Crossing, Partner, System};
use crate::obstacle::Touch;
use crate::rotation::orthogonal;
use crate::{Matrix, State, Vector};
use std::collections::BTreeSet;

/// Depth between contact points, in sums of both radii, above which one is added where two cables cross.
const CROSSING: f64 = 4.0 * DEPTH;
/// Least distance of an added contact point that stays from its neighbours, as a fraction of the distance between them.
const NEAR_POINT: f64 = 0.02;
/// Lower bound of the distance, in sums of both radii, in the curvature of the distance, which is unbounded at zero.
pub(super) const COINCIDENT: f64 = 1e-6;
/// Share of the second derivative of the distance that is left when curvatures are taken from it, where cables cross:
/// where more is taken one is wrapped round the other.
const CROSSED: f64 = 0.7;
/// Depth, in sums of both radii, by which points that stay may lie in a cable that crosses without friction: the one
/// that follows bears alone, and they do not catch on it. One that stays where they cross has none beside it.
const ASIDE: f64 = 1e-3;
/// Squared sine of the angle up to which cables lie side by side: 11.5°.
const BESIDE: f64 = 0.04;
/// Squared sine of the angle below which two lines have no place where they cross.
const PARALLEL: f64 = 1e-3;

/// Where a contact point touches a segment of another cable.
pub(super) struct CablePlace {
    /// Place on the own segment as a fraction of its length.
    pub(super) fraction: f64,
    /// Its position, m.
    pub(super) position: Vector,
    /// Place on the other segment as a fraction of its length.
    pub(super) other: f64,
    /// Distance of the two places, m.
    pub(super) distance: f64,
    /// What holds it to its contact point, or lets it lie in the other cable, as a part of the gap, m.
    pub(super) held: f64,
    pub(super) normal: Vector,
    /// ∂²φ/∂x², 1/m, with both places where they are nearest.
    pub(super) curvature: Matrix,
    pub(super) slides: Slides,
    /// Whether it follows, where the cables cross.
    pub(super) on_crossing: bool,
}

/// The place of an arc that is nearest to a point.
struct Nearest {
    fraction: f64,
    /// φ, n and ∂²φ/∂x².
    touch: Touch,
    /// How it slides along the arc; `None` at an end.
    sliding: Option<Sliding>,
}

impl Nearest {
    /// On an arc, or straight on its chord; `least` bounds the distance in curvatures, m.
    fn new(arc: &Arc, x: &Vector, least: f64) -> Self {
        let fraction = arc.nearest(x);
        let (apart, tangent) = (x - arc.at(fraction), arc.tangent(fraction));
        let distance = apart.norm();
        // Coincident centre lines: any orthogonal direction is a normal.
        let normal = if distance > 0.0 { apart / distance } else { orthogonal(&tangent.normalize()) };
        let bounded = distance.max(least);
        let mut across = Matrix::identity() - normal * normal.transpose();
        let stiffness = tangent.norm_squared() / bounded - normal.dot(&arc.bend(fraction));
        let inside = fraction > 0.0 && fraction < 1.0 && stiffness > 0.0;
        let sliding = inside.then(|| {
            across -= tangent * tangent.transpose() / (bounded * stiffness);
            Sliding { by_motion: tangent / (bounded * stiffness), by_turn: 1.0 / stiffness }
        });
        let touch = Touch { part: 0, distance, normal, curvature: across / bounded };
        Self { fraction, touch, sliding }
    }
}

/// Fraction of the first arc between these at which it crosses the second one deeper than the sum of both radii (m) and
/// than at both, and the distance there, m.
fn lowest([own, other]: [&Arc; 2], ends: [f64; 2], radius: f64) -> Option<(f64, f64)> {
    let nearest = |x: &Vector| Nearest::new(other, x, COINCIDENT * radius);
    let distance = |x: &Vector| Some(nearest(x).touch);
    let along = Along { nearest: &distance, arc: *own };
    let t = along.lowest(ends, radius)?;
    let Nearest { touch, sliding, .. } = nearest(&own.at(t));
    let least = ends.map(|t| nearest(&own.at(t)).touch.distance).iter().copied().fold(radius, f64::min);
    let is_deep = touch.distance < least - FOLLOWED * radius;
    (is_deep && sliding.is_some()).then_some((t, touch.distance))
}

/// Whether two segments (branch, segment) cross: they are not nearly parallel, and neither is wrapped round the other.
/// With unit tangents at the angle α, the distance φ and curvatures κ and η towards each other the second derivatives
/// of the distance along both are a = 1/φ − κ, c = 1/φ − η and b = cos α/φ; straight cables have (a c − b²)/c =
/// sin²α/φ.
fn cross(system: System<'_>, state: &State, segments: [(usize, usize); 2]) -> bool {
    let network = system.network;
    let first = segments.map(|(branch, segment)| network.branches[branch].points.start + segment);
    let tangents = first.map(|i| (state.points[i + 1] - state.points[i]).normalize());
    let diameters = segments.map(|(branch, segment)| 2.0 * network.radius(branch, segment));
    let flat = 2.0 / (diameters[0] + diameters[1]);
    let across = tangents[0].cross(&tangents[1]);
    if across.norm_squared() <= BESIDE {
        return false;
    }
    let straight = flat * across.norm_squared();
    let [own, other] = first.map(|i| state.points[i] + state.points[i + 1]);
    let towards = across.normalize() * (other - own).dot(&across).signum();
    let bend = |i: usize, sign: f64| system.conditions.contact.bends.get(i).map_or(0.0, |x| sign * towards.dot(x));
    let along = |i: usize, sign: f64| flat - bend(i, sign).max(bend(i + 1, sign));
    let (a, c) = (along(first[0], 1.0), along(first[1], -1.0));
    let bent = a * c - flat * flat * tangents[0].dot(&tangents[1]).powi(2);
    a > 0.0 && c > 0.0 && bent > CROSSED * straight * a.max(c)
}

impl ContactTerm {
    /// The segments of a contact between cables, the lower one first.
    pub fn segments(&self, contact: &Contact) -> Option<[(usize, usize); 2]> {
        let Partner::Cable { branch, segment } = contact.partner else { return None };
        let point = &self.points[contact.point as usize];
        let (own, other) = ((point.branch, point.segment), (branch as usize, segment as usize));
        Some([own.min(other), own.max(other)])
    }

    /// Segments of cables that touch or may soon at the last evaluated state.
    pub fn near_segments(&self) -> BTreeSet<[(usize, usize); 2]> {
        self.found.iter().chain(&self.approaching).filter_map(|contact| self.segments(contact)).collect()
    }

    /// Segments of cables that touch or may soon, at the last evaluated state, and cross there, and those that have
    /// crossed before.
    pub fn crossings(&self, system: System<'_>, state: &State) -> Vec<Crossing> {
        let known = &system.conditions.contact.crossings;
        let near = self.near_segments().into_iter();
        let new =
            near.filter(|segments| cross(system, state, *segments)).map(|segments| Crossing { segments, acts: true });
        let still = |crossing: &Crossing| Crossing {
            acts: crossing.acts && cross(system, state, crossing.segments),
            ..*crossing
        };
        // Known ones go first.
        let mut all: Vec<Crossing> = known.iter().map(still).chain(new).collect();
        all.sort_by_key(|crossing| crossing.segments);
        all.dedup_by_key(|crossing| crossing.segments);
        all
    }

    /// Contact place of a contact point, which is at `x` (m) on its chord, and of a segment (indices of branch and
    /// segment) of another cable between these nodes (m); `radius` is the sum of both radii, m.
    pub(super) fn cable_place(
        &self,
        system: System<'_>,
        state: &State,
        (index, x): (u32, &Vector),
        (segment, ends): ((usize, usize), [Vector; 2]),
        radius: f64,
    ) -> CablePlace {
        let point = self.points[index as usize];
        let mut other = arc_between(system, segment, ends);
        let (mut position, mut held) = (*x, 0.0);
        if system.conditions.contact.cross((point.branch, point.segment), segment) {
            let own = arc_of(system, state, &point);
            if point.follows.is_some() {
                let nearest = |x: &Vector| Some(Nearest::new(&other, x, COINCIDENT * radius).touch);
                let length = system.network.branches[point.branch].rod.mesh().rest_lengths[point.segment];
                let along = Along { nearest: &nearest, arc: own };
                if let Some(place) = along.followed(&own, point.fraction, 0.5 * radius, length) {
                    return Self::crossing_place(&other, place, radius);
                }
            }
            position += own.beside(point.fraction);
            if system.network.contact.friction == 0.0 {
                held = ASIDE * radius;
            }
        } else {
            other = other.chord();
        }
        let Nearest { fraction, touch, sliding } = Nearest::new(&other, &position, COINCIDENT * radius);
        CablePlace {
            fraction: point.fraction,
            position,
            other: fraction,
            distance: touch.distance,
            held,
            normal: touch.normal,
            curvature: touch.curvature,
            slides: Slides { on_partner: sliding, ..Slides::default() },
            on_crossing: false,
        }
    }

    /// Where a place follows the other arc.
    fn crossing_place(other: &Arc, place: ContactPlace, radius: f64) -> CablePlace {
        let Nearest { fraction, touch, sliding } = Nearest::new(other, &place.position, COINCIDENT * radius);
        let mut curvature = touch.curvature;
        let on_own = place.sliding(&touch.normal, &mut curvature);
        let by_tangent = |sliding: Sliding| sliding.by_motion.dot(&place.tangent);
        let drift = if on_own.is_some() { sliding.map_or(0.0, by_tangent) } else { 0.0 };
        CablePlace {
            fraction: place.fraction,
            position: place.position,
            other: fraction,
            distance: touch.distance,
            held: place.held,
            normal: touch.normal,
            curvature,
            slides: Slides { on_partner: sliding, on_own, drift },
            on_crossing: true,
        }
    }

    /// Adds contact points where the piece from a contact point to the next one on its segment crosses another segment
    /// at less than the permitted distance.
    pub(super) fn crossings_of(
        &self,
        system: System<'_>,
        state: &State,
        pair: &Pair,
        next: f64,
        found: &mut Vec<ContactPoint>,
    ) {
        let point = self.points[pair.point as usize];
        let own = arc_of(system, state, &point);
        let (p, d) = (own.chord().at(point.fraction), own.edge() * (next - point.fraction));
        for segment in pair.segments.0..=pair.segments.1 {
            let radius = self.least_distance(system, state, pair.point, (pair.branch, segment), pair.both);
            let (b, j) = (pair.branch as usize, segment as usize);
            let ends = [j, j + 1].map(|node| Self::node(system.network, state, b, node));
            let (q, e) = (ends[0], ends[1] - ends[0]);
            // Nearest points p + t d and q + s e of two lines.
            let (dd, de, ee, r) = (d.norm_squared(), d.dot(&e), e.norm_squared(), q - p);
            let square = dd * ee - de * de;
            if square < PARALLEL * dd * ee {
                continue;
            }
            let inside = |t: f64| t > NEAR_POINT && t < 1.0 - NEAR_POINT;
            let segments = [(point.branch, point.segment), (b, j)];
            let known = system.conditions.contact.crossing(segments[0], segments[1]);
            if known.map_or_else(|| cross(system, state, segments), |crossing| crossing.acts) {
                let other = arc_between(system, (b, j), ends);
                let Some((fraction, distance)) = lowest([&own, &other], [point.fraction, next], radius) else {
                    continue;
                };
                let place = ContactPoint { fraction, ..point };
                if system.network.contact.friction > 0.0 {
                    let t = (fraction - point.fraction) / (next - point.fraction);
                    found.extend((inside(t) && distance < radius * (1.0 - CROSSING)).then_some(place));
                } else if segments[0] < segments[1] {
                    let place = ContactPoint { follows: Some(Against::Branch(b)), ..place };
                    found.extend((!self.has_follower(&place, distance)).then_some(place));
                }
                continue;
            }
            let t = (ee * d.dot(&r) - de * e.dot(&r)) / square;
            let s = (de * d.dot(&r) - dd * e.dot(&r)) / square;
            if inside(t) && (0.0..=1.0).contains(&s) && (p + d * t - q - e * s).norm() < radius * (1.0 - CROSSING) {
                let fraction = point.fraction + (next - point.fraction) * t;
                found.push(ContactPoint { fraction, ..point });
            }
        }
    }
}
