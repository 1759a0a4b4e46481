//! Contact: cables are kept out of obstacles.
//!
//! A cable of radius R is looked at in **spots**: its nodes, places between them that are no farther apart than `SPACING` radii, and places
//! that were found to lie deeper than `BETWEEN` radii ([`crate::Problem::refine_spots`]). With φ(x) the distance of a spot x from the
//! surface of a body, it must be `c = R − φ(x) ≤ 0`: an inequality as those of [`crate::fixings`], with multiplier λ (the force between
//! them, N) and penalty ρ (N/m), which adds `(μ² − λ²)/(2ρ)`, `μ = max(0, λ + ρ c)`, to the energy; the force on the spot is `μ n` with
//! `n = ∂φ/∂x`, and the second derivatives are `ρ n nᵀ − μ ∂²φ/∂x²` (Alart and Curnier 1991, without their friction). Multipliers are
//! updated until no spot is deeper than [`DEPTH`] radii, nor pushed while it is farther than that from the surface.
//!
//! **Friction** (Coulomb, quasi-static): a spot that touches is bound to the place of the body where it first touched (its anchor) by a
//! tangential spring of stiffness k ≥ ρ, whose force is at most `f N`: with u the tangential distance from the anchor it adds `½ k u²`,
//! beyond `u = f N/k` `f N (u − f N/(2k))`. Normal force N and normal n are those of the round before; at the end of an increment the
//! anchor follows a spot that slipped (return mapping), so that what sticks does not creep. Where the cable is stiffer along itself k is larger, so
//! that what slips one way goes over into what slips the other within about a segment. Friction on a body acts on the centre line: it does not roll.
//!
//! Between cables the spring joins their surfaces. The spot x in its segment's frame P carries the point `x + P a`, `a = −r Pᵀ n` with its own
//! share r of the distance; the anchor b belongs to the frame R of the segment that is touched, with y the place that is touched on its
//! centre line: `u = (1 − n nᵀ)(Rᵀ(x + P a − y) − b)`, n in the axes of R. Nothing of it changes when both move as one, the force has the same
//! line of action on both, and cables roll on each other without slipping. With every round a, b and y become those of where the two touch
//! then, on the next segment, too, and u stays; a spot that was not there before begins with `u = 0`. Where two cables cross both have
//! spots, which share N, so that all of them together pull with no more than `f N`. As k is many times the stiffness of a
//! cable, `u = f N/k`, by which what sticks may give way when the spots that share N change, moves nothing that can be seen.
//!
//! Near what holds a cable inside a body or at its surface (a clip on a panel) R grows from what it is there to the radius over
//! `RUN_OUT` radii of cable.

mod cables;
mod cross;
mod foresee;
mod friction;
mod held;
mod look;
mod update;
mod watch;

use crate::constraint::Action;
use crate::fixings::Block;
use crate::network::Place;
use crate::problem::{Conditions, Problem, Variable};
use crate::rotation::skew;
use crate::{Matrix, Network, Pose, State, Tangent, Vector};
use cables::Cables;
use friction::Rub;
use serde::{Deserialize, Serialize};
use watch::Watched;

pub use cables::Overlap;
pub use foresee::Foresight;
pub use friction::Grip;
pub use held::HeldOverlap;
pub use look::Inside;
pub use update::{Lack, Rounds, Touching, UnmetContact};

/// Largest distance between spots, in radii: whatever comes between two of them touches one before it touches the centre line.
const SPACING: f64 = 1.5;
/// Depth, and distance at which there is still a force, that are let pass, in radii.
pub const DEPTH: f64 = 1e-4;
/// Depth between spots, in radii, from which on one is put there: the cable is a smooth curve, of which straight segments cut corners.
const BETWEEN: f64 = 0.02;
/// Depth that the weight of the cable alone may cause before multipliers are updated, in radii: it sets the first penalty.
const SOFTNESS: f64 = 1e-3;
/// First penalty in units of EI/ℓ³, the stiffness of the cable against a push on one node: an update of the multipliers takes about so
/// much off the depth.
const STIFFER: f64 = 100.0;
/// Acceleration (m/s²) that stands for weight in it.
const WEIGHT: f64 = 9.81;
/// How near, in radii, a spot must be to be taken for one that may come to touch with a step.
const COMING: f64 = 0.5;
/// Length of cable, in radii, over which it leaves a body that it is held in.
const RUN_OUT: f64 = 8.0;

/// A place of a cable: between nodes `segment` and `segment + 1` of a branch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spot {
    /// Index of the branch.
    pub branch: usize,
    /// Index of the segment.
    pub segment: usize,
    /// Share of the way from its first to its second node.
    pub share: f64,
}

/// What a spot touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Against {
    /// A body.
    Obstacle {
        /// Index of the obstacle.
        obstacle: u32,
        /// Part of its surface.
        part: u32,
    },
    /// A cable.
    Cable {
        /// Index of the branch.
        branch: u32,
        /// Index of the segment.
        segment: u32,
    },
}

impl Against {
    /// Index of the obstacle, if it is one.
    pub fn obstacle(self) -> Option<u32> {
        match self {
            Against::Obstacle { obstacle, .. } => Some(obstacle),
            Against::Cable { .. } => None,
        }
    }
}

/// What is carried along of a spot that touches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// Index of the spot.
    pub spot: u32,
    /// What it touches.
    pub against: Against,
    /// λ, N.
    pub multiplier: f64,
    /// ρ in units of the first one.
    pub penalty: f64,
    /// Friction; none where the body is smooth.
    pub grip: Option<Grip>,
}

/// What contact carries along from one equilibrium to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactState {
    /// Where each obstacle stands.
    pub poses: Vec<Pose>,
    /// Whether friction acts: not while a start is being found.
    pub friction: bool,
    /// Spots beside those that every harness of the network has.
    pub extra: Vec<Spot>,
    /// Sorted by spot, then by what it touches.
    pub marks: Vec<Mark>,
    /// Sorted by spot and branch.
    pub overlaps: Vec<Overlap>,
}

impl ContactState {
    /// At the beginning: nothing touches.
    pub fn new(network: &Network) -> Self {
        Self { poses: network.obstacles.iter().map(|o| o.pose).collect(), ..Self::default() }
    }
}

/// A spot that touches, or nearly so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Index of the spot.
    pub spot: u32,
    /// What it touches.
    pub against: Against,
    /// Where on a cable.
    other: Option<Touched>,
    /// Where the spot is, m.
    pub position: Vector,
    /// −c, m: how far the surfaces are apart.
    pub gap: f64,
    /// Radius that counts there, m.
    pub radius: f64,
    /// n, world axes.
    pub normal: Vector,
    /// ∂²φ/∂x², world axes, 1/m.
    curvature: Matrix,
    /// μ, N.
    pub force: f64,
    /// ρ, N/m.
    penalty: f64,
}

/// The place of a segment that a spot touches.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Touched {
    /// First point of the segment.
    first: usize,
    /// Share of the way to the second.
    share: f64,
    /// None at its ends, where it is the end that is touched.
    turning: Option<Turning>,
}

/// Segment that a spot touches between its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turning {
    /// t.
    direction: Vector,
    /// L, m.
    length: f64,
    /// φ, m.
    distance: f64,
}

/// A fixing that holds a cable nearer to a body than its radius.
struct Sunk {
    place: (usize, f64),
    obstacle: u32,
    distance: f64,
}

/// Workspace of contact.
#[derive(Default)]
pub(crate) struct Contacts {
    spots: Vec<Spot>,
    /// How many of them every harness of the network has.
    own: usize,
    /// For every spot: where it was looked at, and how far it may go from there before it may touch what it does not watch, m.
    looks: Vec<(Vector, f64)>,
    /// Obstacles that each spot watches.
    watched: Vec<Vec<Watched>>,
    /// The spots that watch any.
    near: Vec<u32>,
    /// First penalty by branch, N/m.
    penalties: Vec<f64>,
    /// Least stiffness of friction by branch, N/m.
    holds: Vec<f64>,
    /// By point: which tie carries it.
    ties: Vec<Option<usize>>,
    /// By point: whether a fixing holds it.
    held: Vec<bool>,
    held_before: Vec<bool>,
    sunk: Vec<Sunk>,
    cables: Cables,
    found: Vec<Contact>,
    /// What is not pushed, and so near that it may be after a step; its force is what its spring would pull with.
    coming: Vec<Contact>,
    rubs: Vec<Rub>,
}

/// Energy of an inequality `−gap ≤ 0`, and μ.
fn pushed(gap: f64, lambda: f64, rho: f64) -> (f64, f64) {
    let mu = (lambda - rho * gap).max(0.0);
    ((mu * mu - lambda * lambda) / (2.0 * rho), mu)
}

impl Contacts {
    pub(crate) fn new(network: &Network, conditions: &Conditions) -> Self {
        let mut contacts = Self::default();
        if network.obstacles.is_empty() && !network.contact.cables {
            return contacts;
        }
        contacts.cables = Cables::new(network);
        for (b, branch) in network.branches.iter().enumerate() {
            let mesh = branch.rod.mesh();
            let radius = 0.5 * branch.section.diameter;
            let length = mesh.length() / mesh.segments() as f64;
            let pieces = (length / (SPACING * radius)).ceil().clamp(1.0, 64.0) as usize;
            for segment in 0..mesh.segments() {
                let share = |k: usize| k as f64 / pieces as f64;
                contacts.spots.extend((0..pieces).map(|k| Spot { branch: b, segment, share: share(k) }));
            }
            contacts.spots.push(Spot { branch: b, segment: mesh.segments() - 1, share: 1.0 });
            let bending = STIFFER * branch.section.bend_diagonal().xy().max() / length.powi(3);
            let weight = branch.section.linear_density * WEIGHT * length / (SOFTNESS * radius);
            contacts.penalties.push(bending.max(weight) / pieces as f64);
            contacts.holds.push(branch.section.axial_stiffness / (length * pieces as f64));
        }
        contacts.own = contacts.spots.len();
        contacts.ties = vec![None; network.points];
        for (t, tie) in network.ties.iter().enumerate() {
            contacts.ties[tie.point] = Some(t);
        }
        contacts.held = vec![false; network.points];
        contacts.held_before = contacts.held.clone();
        contacts.set_extra(&conditions.contact.extra);
        contacts
    }

    /// Index of the branch that a mark is on.
    pub(crate) fn branch_of(&self, mark: &Mark) -> usize {
        self.spots[mark.spot as usize].branch
    }

    /// Whether there is anything to touch.
    fn is_idle(&self) -> bool {
        self.spots.is_empty()
    }

    /// Everything must be looked at anew.
    fn look_again(&mut self) {
        self.looks.clear();
        self.looks.resize(self.spots.len(), (Vector::zeros(), f64::NEG_INFINITY));
    }

    fn set_extra(&mut self, extra: &[Spot]) {
        self.spots.truncate(self.own);
        self.spots.extend_from_slice(extra);
        self.watched.resize_with(self.spots.len(), Vec::new);
        self.near.clear();
        self.look_again();
        self.cables.search_again();
    }
}

/// Where a spot is, m.
fn position(network: &Network, state: &State, spot: &Spot) -> Vector {
    let i = network.branches[spot.branch].points.start + spot.segment;
    let (a, b) = (state.points[i] + state.carry[i], state.points[i + 1] + state.carry[i + 1]);
    a + (b - a) * spot.share
}

/// The marks of a spot.
fn marks_of(marks: &[Mark], spot: u32) -> &[Mark] {
    let from = marks.partition_point(|mark| mark.spot < spot);
    let marks = &marks[from..];
    &marks[..marks.partition_point(|mark| mark.spot == spot)]
}

impl Problem<'_> {
    /// Radius that counts for a spot against an obstacle, m.
    fn touch_radius(&self, state: &State, spot: &Spot, obstacle: u32) -> f64 {
        let branch = &self.network.branches[spot.branch];
        let radius = 0.5 * branch.section.diameter;
        let mut least = radius;
        for sunk in self.contacts.sunk.iter().filter(|sunk| sunk.obstacle == obstacle && sunk.place.0 == spot.branch) {
            let lengths = &state.rest_lengths[branch.points.start..];
            let s: f64 = lengths[..spot.segment].iter().sum::<f64>() + lengths[spot.segment] * spot.share;
            let t = ((s - sunk.place.1).abs() / (RUN_OUT * radius)).min(1.0);
            least = least.min(sunk.distance + (radius - sunk.distance) * t * t * (3.0 - 2.0 * t));
        }
        least
    }

    /// Finds every spot that touches at `state`, in order, and those that may come to with a step. Returns the energy of contact, J, of which
    /// multipliers leave nothing behind at an equilibrium.
    pub(crate) fn find_contacts(&mut self, state: &State) -> f64 {
        if self.contacts.is_idle() {
            return 0.0;
        }
        self.look(state);
        self.search_pairs(state);
        let mut found = std::mem::take(&mut self.contacts.found);
        let mut watched = std::mem::take(&mut self.contacts.watched);
        let mut coming = std::mem::take(&mut self.contacts.coming);
        found.clear();
        coming.clear();
        let contact = &self.conditions.contact;
        // What is marked and touches no more leaves this behind.
        let rho = |mark: &Mark| self.contacts.penalties[self.contacts.spots[mark.spot as usize].branch] * mark.penalty;
        let mut energy: f64 = contact.marks.iter().map(|m| -0.5 * m.multiplier * m.multiplier / rho(m)).sum();
        for &index in &self.contacts.near {
            let spot = &self.contacts.spots[index as usize];
            let position = position(self.network, state, spot);
            let marks = marks_of(&contact.marks, index);
            let first = self.contacts.penalties[spot.branch];
            for watched in &mut watched[index as usize] {
                let o = watched.obstacle;
                let (obstacle, pose) = (&self.network.obstacles[o as usize], &contact.poses[o as usize]);
                let radius = self.touch_radius(state, spot, o);
                let marks = || marks.iter().filter(|mark| mark.against.obstacle() == Some(o));
                let pull = marks().map(|mark| mark.multiplier / (first * mark.penalty)).fold(0.0, f64::max);
                for touch in watched.touches(&*obstacle.shape, &pose.local(&position), (1.0 + COMING) * radius + pull) {
                    let against = Against::Obstacle { obstacle: o, part: touch.part };
                    let mark = marks().find(|mark| mark.against == against);
                    let rho = first * mark.map_or(1.0, |mark| mark.penalty);
                    let lambda = mark.map_or(0.0, |mark| mark.multiplier);
                    let gap = touch.distance - radius;
                    let (e, force) = pushed(gap, lambda, rho);
                    energy += e + 0.5 * lambda * lambda / rho;
                    let r = pose.orientation.to_rotation_matrix();
                    let contact = Contact {
                        spot: index,
                        against,
                        other: None,
                        position,
                        gap,
                        radius,
                        normal: r * touch.normal,
                        curvature: r.matrix() * touch.curvature * r.matrix().transpose(),
                        force: lambda - rho * gap,
                        penalty: rho,
                    };
                    if force > 0.0 { found.push(contact) } else { coming.push(contact) }
                }
            }
        }
        self.contacts.watched = watched;
        energy += self.find_pairs(state, &mut found, &mut coming);
        self.couple_contacts(state, found.iter().chain(&coming));
        (self.contacts.found, self.contacts.coming) = (found, coming);
        energy + self.find_rubs(state)
    }

    /// Adds the first derivatives of the energy of contact in the positions of all points, tied ones included; returns that energy, J.
    pub(crate) fn contact_gradient(&mut self, state: &State, gradient: &mut Tangent) -> f64 {
        let energy = self.find_contacts(state);
        for contact in &self.contacts.found {
            let Some(Touched { first, share, .. }) = contact.other else { continue };
            gradient.points[first] += contact.normal * (contact.force * (1.0 - share));
            gradient.points[first + 1] += contact.normal * (contact.force * share);
        }
        for contact in &self.contacts.found {
            for (point, share) in self.spot_points(contact.spot) {
                gradient.points[point] -= contact.normal * contact.force * share;
            }
        }
        self.rub_gradient(state, gradient);
        energy
    }

    /// Adds the second derivatives of the energy of contact at `state` in the independent variables: both triangles; with `convex` without what
    /// makes it less convex. The levers of tied points have theirs from the forces at them.
    ///
    /// With `u` how the spot moves against the place it touches, and, where that is within a segment from a to b (length L, direction t),
    /// `w = δb − δa`: `δ²φ = u·∂²φ/∂x² u − 2 (t·u)(n·w)/L − (φ/L²)(n·w)²`, the last two because the nearest place moves along as the
    /// segment turns.
    pub(crate) fn contact_hessian(&mut self, state: &State, convex: bool, blocks: &mut Vec<Block>) {
        self.find_contacts(state);
        for contact in &self.contacts.found {
            let (n, mu) = (contact.normal, contact.force);
            let mut uu = n * n.transpose() * contact.penalty;
            if !convex {
                uu -= contact.curvature * mu;
            }
            let (uw, ww) = match contact.other.and_then(|other| other.turning) {
                Some(Turning { direction, length, distance }) => {
                    let uw = if convex { Matrix::zeros() } else { direction * n.transpose() * (mu / length) };
                    (uw, n * n.transpose() * (mu * distance / (length * length)))
                }
                None => (Matrix::zeros(), Matrix::zeros()),
            };
            let of =
                |u: f64, v: f64, w: f64, z: f64| uu * (u * v) + uw * (u * z) + uw.transpose() * (w * v) + ww * (w * z);
            self.add_blocks(state, &self.places(contact), of, blocks);
        }
        self.rub_hessian(state, convex, blocks);
    }

    /// The two points that a spot moves with, and their shares.
    fn spot_points(&self, spot: u32) -> [(usize, f64); 2] {
        let spot = &self.contacts.spots[spot as usize];
        let i = self.network.branches[spot.branch].points.start + spot.segment;
        [(i, 1.0 - spot.share), (i + 1, spot.share)]
    }

    /// The points that a contact depends on, each with its weights in u and w; without weights where there are no more.
    fn places(&self, contact: &Contact) -> [(usize, f64, f64); 4] {
        let [a, b] = self.spot_points(contact.spot).map(|(point, u)| (point, u, 0.0));
        let [c, d] = match contact.other {
            Some(Touched { first, share, .. }) => [(first, share - 1.0, -1.0), (first + 1, -share, 1.0)],
            None => [(0, 0.0, 0.0); 2],
        };
        [a, b, c, d]
    }

    /// The independent variables that a point moves with, and how.
    fn columns(&self, state: &State, point: usize) -> [Option<(Variable, Matrix)>; 2] {
        let Some(tie) = self.contacts.ties[point].map(|t| &self.network.ties[t]) else {
            return [Some((Variable::Point(point), Matrix::identity())), None];
        };
        let lever = tie.hub_frame.map(|hub| {
            let r = state.frames[hub].to_rotation_matrix();
            (Variable::Frame(hub), -(r.matrix() * skew(&tie.offset)))
        });
        [Some((Variable::Point(tie.hub_point), Matrix::identity())), lever]
    }

    /// Adds second derivatives in some points, each with its weights in u and w, as those in independent variables; `of` gives them for two of
    /// the points by their weights.
    fn add_blocks(
        &self,
        state: &State,
        points: &[(usize, f64, f64)],
        of: impl Fn(f64, f64, f64, f64) -> Matrix,
        blocks: &mut Vec<Block>,
    ) {
        let weighty = || points.iter().filter(|(_, u, w)| *u != 0.0 || *w != 0.0);
        for (p, u, w) in weighty() {
            for (q, v, z) in weighty() {
                let h = of(*u, *v, *w, *z);
                for (row, a) in self.columns(state, *p).into_iter().flatten() {
                    for (column, b) in self.columns(state, *q).into_iter().flatten() {
                        blocks.push(Block { row, column, matrix: a.transpose() * h * b });
                    }
                }
            }
        }
    }

    /// Finds which points fixings hold, and which of them within a radius of an obstacle.
    pub(crate) fn note_held_near(&mut self) {
        if self.contacts.is_idle() {
            return;
        }
        let (held, before) = (&mut self.contacts.held, &mut self.contacts.held_before);
        std::mem::swap(held, before);
        held.fill(false);
        self.contacts.sunk.clear();
        let network = self.network;
        for (f, fixing) in network.fixings.iter().enumerate().filter(|(f, _)| self.conditions.active[*f]) {
            let Action::Prescribed(hold) = fixing.constraint.action() else { continue };
            if !hold.position {
                continue;
            }
            if hold.rails.is_empty() {
                self.contacts.held[fixing.site.point] = true;
            }
            for (o, obstacle) in network.obstacles.iter().enumerate() {
                let x = self.conditions.contact.poses[o].local(&self.conditions.targets[f].position);
                let mut sink = |branch: usize, s: f64| {
                    let radius = 0.5 * network.branches[branch].section.diameter;
                    let distance = obstacle.shape.distance(&x, radius);
                    if distance < radius {
                        self.contacts.sunk.push(Sunk { place: (branch, s), obstacle: o as u32, distance });
                    }
                };
                match fixing.place {
                    Place::Node { branch, node } => {
                        let mesh = network.branches[branch].rod.mesh();
                        sink(branch, mesh.rest_lengths[..node].iter().sum());
                    }
                    Place::Joint(j) => {
                        for (arm, &branch) in network.joints[j].arms.iter().zip(&network.joints[j].branches) {
                            let mesh = network.branches[branch].rod.mesh();
                            sink(branch, if arm.starts_here { 0.0 } else { mesh.length() });
                        }
                    }
                }
            }
        }
        self.note_held_overlaps();
        for tie in &network.ties {
            let rides = tie.hub_frame.is_none() && self.contacts.held[tie.hub_point];
            self.contacts.held[tie.point] |= rides;
        }
        if self.contacts.held != self.contacts.held_before {
            self.contacts.look_again();
        }
    }
}
