//! Data of the contact term, and of a contact.

use super::distance_cache::CachedDistance;
use super::pairs::Cables;
use crate::conditions::{Conditions, ContactPoint, ContactRecord, Partner};
use crate::{Matrix, Network, Section, State, Vector};

/// Largest distance between contact points, in radii: an object between two of them touches one of them before it
/// reaches the centre line.
pub(super) const SPACING: f64 = 1.5;
/// Largest number of contact points of a segment: those of a segment longer than `SPACING` times as many radii are
/// farther apart.
const MOST_PIECES: f64 = 64.0;
/// Tolerance of the penetration depth, and of a gap with a force, in radii.
pub const DEPTH: f64 = 1e-4;
/// Depth under the weight of the cable alone before multipliers are updated, in radii: it determines the initial
/// penalty.
const WEIGHT_DEPTH: f64 = 1e-3;
/// Initial penalty in units of EI/ℓ³, the stiffness of the cable against a force on one node: an update of the
/// multipliers reduces the depth by about this factor.
const STIFFNESS_RATIO: f64 = 100.0;
/// Acceleration (m/s²) of that weight.
const WEIGHT: f64 = 9.81;
/// Gap, in radii, below which a contact point is approaching: it may touch after the next step.
pub(super) const APPROACHING: f64 = 0.5;
/// Length of cable, in radii, over which it leaves an obstacle inside which a constraint holds it.
pub(super) const RUN_OUT: f64 = 8.0;

/// Contact: a contact point that touches its partner or approaches it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Index of the contact point.
    pub point: u32,
    /// Contact place on its segment as a fraction of the length: that of the contact point, unless it follows.
    pub fraction: f64,
    /// Its partner.
    pub partner: Partner,
    /// Contact place on the partner, if it is a cable.
    pub(crate) other: Option<Touched>,
    /// Whether it follows, on an edge of an obstacle or where cables cross.
    pub(super) on_edge: bool,
    pub(super) slides: Slides,
    /// Position of the contact place, m.
    pub position: Vector,
    /// −c, m: distance of the surfaces.
    pub gap: f64,
    /// Effective radius, or sum of radii for cables, m.
    pub radius: f64,
    /// n, world axes.
    pub normal: Vector,
    /// ∂²φ/∂x², world axes, 1/m.
    pub(super) curvature: Matrix,
    /// λ − ρ gap, N: μ where positive; negative where it does not touch.
    pub force: f64,
    /// ρ, N/m.
    pub penalty: f64,
}

/// Contact place on a segment of another cable.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touched {
    /// First point of the segment.
    pub(crate) first: usize,
    /// Position on the segment as a fraction of its length.
    pub(crate) fraction: f64,
}

/// How the contact places move along their segments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Slides {
    /// Along that of the partner, if it is a cable.
    pub(super) on_partner: Option<Sliding>,
    /// Along its own, if it follows.
    pub(super) on_own: Option<Sliding>,
    /// Change of the fraction on the partner per change of that on the own segment, with the nodes at rest.
    pub(super) drift: f64,
}

/// Contact place that is where φ is least along a segment, between its ends. With e = ∂x/∂t, K = ∂²φ/∂x² and
/// k = ∂²φ/∂t² along it the fraction t changes by `(e·K u + n·w)/k`, on the own segment in the other direction
/// (u and w: `ContactTerm::hessian`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sliding {
    /// K e/k, 1/m.
    pub(super) by_motion: Vector,
    /// 1/k, 1/m.
    pub(super) by_turn: f64,
}

/// Place where a constraint holds a cable nearer to an obstacle than its radius.
pub(super) struct HeldDepth {
    /// Branch and node.
    pub(super) place: (usize, usize),
    pub(super) obstacle: u32,
    pub(super) distance: f64,
}

/// Term of contact with obstacles and between cables; keeps its workspace.
#[derive(Default)]
pub struct ContactTerm {
    pub(super) points: Vec<ContactPoint>,
    /// Number of permanent contact points.
    pub(super) own: usize,
    /// For every contact point: its position at the last search, and the distance (m) it may move from there before it
    /// may touch an obstacle that is not in its cache.
    pub(super) searched: Vec<(Vector, f64)>,
    /// Distance caches of the obstacles near each contact point.
    pub(super) cached: Vec<Vec<CachedDistance>>,
    /// Contact points with a cached obstacle.
    pub(super) near: Vec<u32>,
    /// Whether cables go through obstacles.
    pub(super) without_obstacles: bool,
    /// Largest distance between neighbouring contact points at rest, by branch, m.
    pub(super) spacings: Vec<f64>,
    /// Initial penalty by branch, N/m.
    pub(super) penalties: Vec<f64>,
    /// Least stiffness of friction by branch, N/m.
    pub(crate) friction_stiffness: Vec<f64>,
    /// Fraction of the next contact point on the same segment, of each contact point; 1 if there is none.
    pub(super) next: Vec<f64>,
    /// Index of the tie of each point, if it is tied.
    pub(super) ties: Vec<Option<usize>>,
    /// Whether a constraint holds each point.
    pub(super) held: Vec<bool>,
    pub(super) held_before: Vec<bool>,
    pub(super) held_depths: Vec<HeldDepth>,
    pub(super) cables: Cables,
    pub(super) found: Vec<Contact>,
    /// Contacts without force that may have one after a step; their `force` is not positive.
    pub(super) approaching: Vec<Contact>,
}

impl ContactTerm {
    /// Contact term of a network; idle without obstacles and contact between cables.
    pub fn new(network: &Network, conditions: &Conditions) -> Self {
        let mut contact = Self::default();
        if network.obstacles.is_empty() && !network.contact.cables {
            return contact;
        }
        contact.cables = Cables::new(network);
        for (b, branch) in network.branches.iter().enumerate() {
            let mesh = branch.rod.mesh();
            let pieces = |length: f64, radius: f64| (length / (SPACING * radius)).ceil().clamp(1.0, MOST_PIECES);
            let mut spacing = 0.0_f64;
            for (segment, length) in mesh.rest_lengths.iter().enumerate() {
                let pieces = pieces(*length, network.radius(b, segment));
                spacing = spacing.max(length / pieces);
                let fraction = |k: usize| k as f64 / pieces;
                contact.points.extend((0..pieces as usize).map(|k| ContactPoint::new(b, segment, fraction(k))));
            }
            contact.spacings.push(spacing);
            contact.points.push(ContactPoint::new(b, mesh.segments() - 1, 1.0));
            // Penalties are those of the mean segment.
            let length = mesh.length() / mesh.segments() as f64;
            let pieces = pieces(length, 0.5 * branch.sections.diameter());
            let penalty = |section: &Section| {
                let bending = STIFFNESS_RATIO * section.sticking_diagonal().xy().max() / length.powi(3);
                let weight = section.linear_density * WEIGHT * length / (WEIGHT_DEPTH * 0.5 * section.diameter);
                bending.max(weight) / pieces
            };
            contact.penalties.push(branch.sections.iter().map(penalty).fold(0.0, f64::max));
            let axial = branch.sections.iter().map(|section| section.axial_stiffness).fold(0.0, f64::max);
            contact.friction_stiffness.push(axial / (length * pieces));
        }
        contact.own = contact.points.len();
        contact.ties = vec![None; network.points];
        for (t, tie) in network.ties.iter().enumerate() {
            contact.ties[tie.point] = Some(t);
        }
        contact.held = vec![false; network.points];
        contact.held_before = contact.held.clone();
        contact.set_extra(&conditions.contact.extra);
        contact
    }

    /// Whether there are no contact points.
    pub fn is_idle(&self) -> bool {
        self.points.is_empty()
    }

    /// Contact points: first the permanent ones, in order, then the added ones.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points
    }

    /// Number of permanent contact points.
    pub fn own_points(&self) -> usize {
        self.own
    }

    /// Contact point of a contact or a record.
    pub fn point(&self, index: u32) -> &ContactPoint {
        &self.points[index as usize]
    }

    /// Contacts with a force at the last evaluated state, in order.
    pub fn found(&self) -> &[Contact] {
        &self.found
    }

    /// Contacts without force at the last evaluated state that may have one after a step.
    pub fn approaching(&self) -> &[Contact] {
        &self.approaching
    }

    /// Index of the branch of a record.
    pub fn branch_of(&self, record: &ContactRecord) -> usize {
        self.point(record.point).branch
    }

    /// ρ of a record, N/m.
    pub fn penalty(&self, record: &ContactRecord) -> f64 {
        self.penalties[self.branch_of(record)] * record.penalty
    }

    /// Sets whether cables touch obstacles, as they do at first.
    pub fn set_obstacles_act(&mut self, act: bool) {
        self.without_obstacles = !act;
        self.near.clear();
        self.cached.iter_mut().for_each(Vec::clear);
        self.search_again();
    }

    /// Whether an obstacle is near a cable at the state evaluated last.
    pub fn is_beside_obstacle(&self) -> bool {
        !self.near.is_empty()
    }

    /// Discards the search results, so that the next evaluation searches around every contact point again.
    pub fn search_again(&mut self) {
        self.searched.clear();
        self.searched.resize(self.points.len(), (Vector::zeros(), f64::NEG_INFINITY));
    }

    /// Replaces the added contact points.
    pub fn set_extra(&mut self, extra: &[ContactPoint]) {
        self.points.truncate(self.own);
        self.points.extend_from_slice(extra);
        self.find_next();
        self.cached.resize_with(self.points.len(), Vec::new);
        self.near.clear();
        self.search_again();
        self.cables.search_again();
    }

    /// Discards the near pairs, so that the next evaluation searches again.
    pub fn search_pairs_again(&mut self) {
        self.cables.search_again();
    }

    /// Position of node `node` of a branch, m.
    pub(super) fn node(network: &Network, state: &State, branch: usize, node: usize) -> Vector {
        let i = network.branches[branch].points.start + node;
        state.points[i] + state.compensation[i]
    }
}
