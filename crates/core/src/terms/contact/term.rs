//! Workspace of the contact term, and a contact.

use super::distance_cache::CachedDistance;
use super::pairs::Cables;
use crate::conditions::{Conditions, ContactPoint, ContactRecord, Partner};
use crate::{Matrix, Network, State, Vector};

/// Largest distance between contact points, in radii: whatever comes between two of them touches one before it touches
/// the centre line.
pub(super) const SPACING: f64 = 1.5;
/// Tolerance of depth, and of the distance at which there is still a force, in radii.
pub const DEPTH: f64 = 1e-4;
/// Depth that the weight of the cable alone may cause before multipliers are updated, in radii: it sets the first
/// penalty.
const WEIGHT_DEPTH: f64 = 1e-3;
/// First penalty in units of EI/ℓ³, the stiffness of the cable against a push on one node: an update of the
/// multipliers takes about so much off the depth.
const STIFFNESS_RATIO: f64 = 100.0;
/// Acceleration (m/s²) that stands for weight in it.
const WEIGHT: f64 = 9.81;
/// Gap, in radii, below which a contact point counts as approaching: it may touch after the next step.
pub(super) const APPROACHING: f64 = 0.5;
/// Length of cable, in radii, over which it leaves a body that it is held in.
pub(super) const RUN_OUT: f64 = 8.0;

/// A contact point that touches, or nearly so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Index of the contact point.
    pub point: u32,
    /// The surface that it touches.
    pub partner: Partner,
    /// Place of the cable that it touches, if it is one.
    pub(crate) other: Option<Touched>,
    /// Position of the contact point, m.
    pub position: Vector,
    /// −c, m: distance of the surfaces.
    pub gap: f64,
    /// Radius that counts there, m.
    pub radius: f64,
    /// n, world axes.
    pub normal: Vector,
    /// ∂²φ/∂x², world axes, 1/m.
    pub(super) curvature: Matrix,
    /// μ, N; negative where it does not touch.
    pub force: f64,
    /// ρ, N/m.
    pub penalty: f64,
}

/// The place of a segment that a contact point touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touched {
    /// First point of the segment.
    pub(crate) first: usize,
    /// Fraction of the way to the second.
    pub(crate) fraction: f64,
    /// None at its ends, where it is the end that is touched.
    pub(super) turning: Option<Turning>,
}

/// Segment that a contact point touches between its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Turning {
    /// t.
    pub(super) direction: Vector,
    /// L, m.
    pub(super) length: f64,
    /// φ, m.
    pub(super) distance: f64,
}

/// Cable that a constraint holds nearer to a body than its radius.
pub(super) struct Sunk {
    pub(super) place: (usize, f64),
    pub(super) obstacle: u32,
    pub(super) distance: f64,
}

/// Term of contact with obstacles and between cables; keeps its workspace.
#[derive(Default)]
pub struct ContactTerm {
    pub(super) points: Vec<ContactPoint>,
    /// Number of them that every harness of the network has.
    pub(super) own: usize,
    /// For every contact point: its position at the last search, and how far it may move from there before it may touch
    /// what is not in its cache, m.
    pub(super) searched: Vec<(Vector, f64)>,
    /// Obstacles near each contact point.
    pub(super) cached: Vec<Vec<CachedDistance>>,
    /// The contact points that have any.
    pub(super) near: Vec<u32>,
    /// First penalty by branch, N/m.
    pub(super) penalties: Vec<f64>,
    /// Least stiffness of friction by branch, N/m.
    pub(crate) friction_stiffness: Vec<f64>,
    /// By point: index of the tie that carries it.
    pub(super) ties: Vec<Option<usize>>,
    /// By point: whether a constraint holds it.
    pub(super) held: Vec<bool>,
    pub(super) held_before: Vec<bool>,
    pub(super) sunk: Vec<Sunk>,
    pub(super) cables: Cables,
    pub(super) found: Vec<Contact>,
    /// Contact points without force that may touch after a step; `force` is what their spring would pull with.
    pub(super) approaching: Vec<Contact>,
}

impl ContactTerm {
    /// Contact of a harness: idle where there is nothing to touch.
    pub fn new(network: &Network, conditions: &Conditions) -> Self {
        let mut contact = Self::default();
        if network.obstacles.is_empty() && !network.contact.cables {
            return contact;
        }
        contact.cables = Cables::new(network);
        for (b, branch) in network.branches.iter().enumerate() {
            let mesh = branch.rod.mesh();
            let radius = 0.5 * branch.section.diameter;
            let length = mesh.length() / mesh.segments() as f64;
            let pieces = (length / (SPACING * radius)).ceil().clamp(1.0, 64.0) as usize;
            for segment in 0..mesh.segments() {
                let fraction = |k: usize| k as f64 / pieces as f64;
                let points = (0..pieces).map(|k| ContactPoint { branch: b, segment, fraction: fraction(k) });
                contact.points.extend(points);
            }
            contact.points.push(ContactPoint { branch: b, segment: mesh.segments() - 1, fraction: 1.0 });
            let bending = STIFFNESS_RATIO * branch.section.bend_diagonal().xy().max() / length.powi(3);
            let weight = branch.section.linear_density * WEIGHT * length / (WEIGHT_DEPTH * radius);
            contact.penalties.push(bending.max(weight) / pieces as f64);
            contact.friction_stiffness.push(branch.section.axial_stiffness / (length * pieces as f64));
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

    /// Whether there is nothing to touch.
    pub fn is_idle(&self) -> bool {
        self.points.is_empty()
    }

    /// Contact points: first those that every harness of the network has, in order, then those that were added.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points
    }

    /// Number of contact points that every harness of the network has.
    pub fn own_points(&self) -> usize {
        self.own
    }

    /// Contact point of a contact or a record.
    pub fn point(&self, index: u32) -> &ContactPoint {
        &self.points[index as usize]
    }

    /// Contacts with a force, where contact was evaluated last, in order.
    pub fn found(&self) -> &[Contact] {
        &self.found
    }

    /// Contact points that may touch after a step, where contact was evaluated last.
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

    /// Discards what was found near the contact points.
    pub(crate) fn search_again(&mut self) {
        self.searched.clear();
        self.searched.resize(self.points.len(), (Vector::zeros(), f64::NEG_INFINITY));
    }

    /// Replaces the contact points beside those that every harness of the network has.
    pub(crate) fn set_extra(&mut self, extra: &[ContactPoint]) {
        self.points.truncate(self.own);
        self.points.extend_from_slice(extra);
        self.cached.resize_with(self.points.len(), Vec::new);
        self.near.clear();
        self.search_again();
        self.cables.search_again();
    }

    /// Discards the pairs of cables that were found near each other.
    pub(crate) fn search_pairs_again(&mut self) {
        self.cables.search_again();
    }

    /// Position of node `node` of a branch, m.
    pub(super) fn node(network: &Network, state: &State, branch: usize, node: usize) -> Vector {
        let i = network.branches[branch].points.start + node;
        state.points[i] + state.compensation[i]
    }
}
