//! Energy of contact, and its first and second derivatives.

use super::term::{APPROACHING, Contact, ContactTerm, HeldDepth, RUN_OUT, Slides, Sliding, Touched};
use crate::conditions::{ContactPoint, ContactRecord, Partner, System};
use crate::constraint::Action;
use crate::network::Place;
use crate::rotation::skew;
use crate::variable::{Block, Variable};
use crate::{Matrix, State, Tangent};

/// Energy `(μ² − λ²)/(2ρ)`, J, of an inequality `−gap ≤ 0` with multiplier λ and penalty ρ, and
/// `μ = max(0, λ − ρ gap)`, N.
pub fn inequality(gap: f64, lambda: f64, rho: f64) -> (f64, f64) {
    let mu = (lambda - rho * gap).max(0.0);
    ((mu * mu - lambda * lambda) / (2.0 * rho), mu)
}

/// Weights of a point in the motions on which φ at a contact depends to second order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weights {
    /// In u, the motion of the contact point relative to the contact place.
    pub u: f64,
    /// In w of the segment of the partner, and in z of its own (`ContactTerm::hessian`).
    pub w: [f64; 2],
}

impl ContactTerm {
    /// Effective radius of a contact point against an obstacle, m: reduced near constraints that hold the cable nearer
    /// than its radius, with a smooth transition (smoothstep).
    pub(super) fn touch_radius(&self, system: System<'_>, state: &State, point: &ContactPoint, obstacle: u32) -> f64 {
        let radius = system.network.radius(point.branch, point.segment);
        let mut least = radius;
        for held in self.held_depths.iter().filter(|held| held.obstacle == obstacle && held.place.0 == point.branch) {
            let arc = held.arc_to(system, state, point);
            let t = (arc / (RUN_OUT * radius)).min(1.0);
            least = least.min(held.distance + (radius - held.distance) * t * t * (3.0 - 2.0 * t));
        }
        least
    }

    /// Evaluates contact at `state`: finds the contacts with a force, in order, and the approaching ones. Returns the
    /// energy of contact `Σ (μ² − λ²)/(2ρ)`, J.
    pub fn energy(&mut self, system: System<'_>, state: &State) -> f64 {
        if self.is_idle() {
            return 0.0;
        }
        self.search(system, state);
        self.search_pairs(system, state);
        let mut found = std::mem::take(&mut self.found);
        let mut cached = std::mem::take(&mut self.cached);
        let mut approaching = std::mem::take(&mut self.approaching);
        found.clear();
        approaching.clear();
        let contact = &system.conditions.contact;
        // Records without a contact contribute −λ²/(2ρ).
        let of_record = |r: &ContactRecord| -0.5 * r.multiplier * r.multiplier / self.penalty(r);
        let mut energy: f64 = contact.records.iter().map(of_record).sum();
        for &index in &self.near {
            let records = contact.records_of(index);
            let first = self.penalties[self.points[index as usize].branch];
            for cached in &mut cached[index as usize] {
                let o = cached.obstacle;
                let (obstacle, pose) = (&system.network.obstacles[o as usize], &contact.poses[o as usize]);
                let place = self.contact_place(system, state, index, cached);
                let (fraction, position) = (place.fraction, place.position);
                let point = ContactPoint { fraction, ..self.points[index as usize] };
                let radius = self.touch_radius(system, state, &point, o);
                let length = system.network.branches[point.branch].rod.mesh().rest_lengths[point.segment];
                let on_edge = place.profile.is_some_and(|profile| profile.is_edge(length, radius));
                let records = || records.iter().filter(|record| record.partner.obstacle() == Some(o));
                let pull = records().map(|record| record.multiplier / (first * record.penalty)).fold(0.0, f64::max);
                let reach = (1.0 + APPROACHING) * radius + pull;
                for touch in cached.touches(&*obstacle.shape, &pose.local(&position), reach) {
                    let partner = Partner::Obstacle { obstacle: o, part: touch.part };
                    let record = records().find(|record| record.partner == partner);
                    let rho = first * record.map_or(1.0, |record| record.penalty);
                    let lambda = record.map_or(0.0, |record| record.multiplier);
                    let gap = touch.distance + place.held - radius;
                    let (e, force) = inequality(gap, lambda, rho);
                    energy += e + 0.5 * lambda * lambda / rho;
                    let r = pose.orientation.to_rotation_matrix();
                    let normal = r * touch.normal;
                    let mut curvature = r.matrix() * touch.curvature * r.matrix().transpose();
                    let slides = Slides { on_own: place.sliding(&normal, &mut curvature), ..Slides::default() };
                    let contact = Contact {
                        point: index,
                        fraction,
                        partner,
                        other: None,
                        on_edge,
                        slides,
                        position,
                        gap,
                        radius,
                        normal,
                        curvature,
                        force: lambda - rho * gap,
                        penalty: rho,
                    };
                    if force > 0.0 { found.push(contact) } else { approaching.push(contact) }
                }
            }
        }
        self.cached = cached;
        energy += self.find_pairs(system, state, &mut found, &mut approaching);
        self.couple_contacts(system, state, found.iter().chain(&approaching));
        (self.found, self.approaching) = (found, approaching);
        energy
    }

    /// Adds the first derivatives of the energy of contact, `−μ n` at the contact point and `μ n` at the partner,
    /// in the positions of all points, tied ones included; returns the energy, J.
    pub fn gradient(&mut self, system: System<'_>, state: &State, gradient: &mut Tangent) -> f64 {
        let energy = self.energy(system, state);
        for contact in &self.found {
            let Some(Touched { first, fraction }) = contact.other else { continue };
            gradient.points[first] += contact.normal * (contact.force * (1.0 - fraction));
            gradient.points[first + 1] += contact.normal * (contact.force * fraction);
        }
        for contact in &self.found {
            for (point, fraction) in self.support(system, contact.point, contact.fraction) {
                gradient.points[point] -= contact.normal * contact.force * fraction;
            }
        }
        energy
    }

    /// Adds the second derivatives of the energy of contact at `state` in the independent variables: both triangles;
    /// with `convex` without the indefinite geometric parts. The second derivatives of the levers of tied points are
    /// not included.
    ///
    /// The second variation is `ρ (n·u)² − μ δ²φ` with u the motion of the contact point relative to the contact place.
    /// Where one of the two is that of least φ along a segment e from a to b, with `w = δb − δa`, K = ∂²φ/∂x² and
    /// k = ∂²φ/∂t² along it, `δ²φ = u·K u − (e·K u + n·w)²/k`: the last part comes from the motion of that place along
    /// the segment; k = e·e/φ between straight cables. Where both places move, first that on the partner (e, w, k) is
    /// eliminated, which leaves `M = K − K e eᵀ K/k`, then that on the own segment (f, z, l), with
    /// `(f·M u + n·z − (f·K e/k) n·w)²/l`.
    pub fn hessian(&mut self, system: System<'_>, state: &State, convex: bool, blocks: &mut Vec<Block>) {
        self.energy(system, state);
        for contact in &self.found {
            let (n, mu) = (contact.normal, contact.force);
            let mut uu = n * n.transpose() * contact.penalty;
            if !convex {
                uu -= contact.curvature * mu;
            }
            let parts = [contact.slides.on_partner, contact.slides.on_own].map(|sliding| {
                let Sliding { by_motion, by_turn } = sliding?;
                let uw = if convex { Matrix::zeros() } else { by_motion * n.transpose() * mu };
                Some((uw, n * n.transpose() * (mu * by_turn)))
            });
            let of = |p: &Weights, q: &Weights| {
                let mut block = uu * (p.u * q.u);
                for (k, part) in parts.iter().enumerate() {
                    let Some((uw, ww)) = part else { continue };
                    let (w, z) = (p.w[k], q.w[k]);
                    block += uw * (p.u * z) + uw.transpose() * (w * q.u) + ww * (w * z);
                }
                block
            };
            self.add_blocks(system, state, &self.places(system, contact), of, blocks);
        }
    }

    /// The two nodes of a contact point's segment, and their weights at this fraction of it.
    pub fn support(&self, system: System<'_>, point: u32, fraction: f64) -> [(usize, f64); 2] {
        let point = &self.points[point as usize];
        let i = system.network.branches[point.branch].points.start + point.segment;
        [(i, 1.0 - fraction), (i + 1, fraction)]
    }

    /// The points on which a contact depends, with their weights; unused entries have none.
    pub fn places(&self, system: System<'_>, contact: &Contact) -> [(usize, Weights); 4] {
        let [(a, u), (b, v)] = self.support(system, contact.point, contact.fraction);
        let Slides { on_own, drift, .. } = contact.slides;
        let own = if on_own.is_some() { 1.0 } else { 0.0 };
        let mut places = [(0, Weights::default()); 4];
        places[0] = (a, Weights { u, w: [0.0, -own] });
        places[1] = (b, Weights { u: v, w: [0.0, own] });
        if let Some(Touched { first, fraction }) = contact.other {
            places[2] = (first, Weights { u: fraction - 1.0, w: [-1.0, drift] });
            places[3] = (first + 1, Weights { u: -fraction, w: [1.0, -drift] });
        }
        places
    }

    /// The independent variables on which a point depends, and its derivatives in them; `−R [o]ₓ` in the frame of a
    /// hub with lever o.
    pub fn columns(&self, system: System<'_>, state: &State, point: usize) -> [Option<(Variable, Matrix)>; 2] {
        let Some(tie) = self.ties[point].map(|t| &system.network.ties[t]) else {
            return [Some((Variable::Point(point), Matrix::identity())), None];
        };
        let lever = tie.hub_frame.map(|hub| {
            let r = state.frames[hub].to_rotation_matrix();
            (Variable::Frame(hub), -(r.matrix() * skew(&tie.offset)))
        });
        [Some((Variable::Point(tie.hub_point), Matrix::identity())), lever]
    }

    /// Adds second derivatives in the positions of `points` as blocks of the independent variables; `of` returns the
    /// block of two points from their weights.
    pub fn add_blocks(
        &self,
        system: System<'_>,
        state: &State,
        points: &[(usize, Weights)],
        of: impl Fn(&Weights, &Weights) -> Matrix,
        blocks: &mut Vec<Block>,
    ) {
        let weighted = || points.iter().filter(|(_, weights)| *weights != Weights::default());
        for (p, first) in weighted() {
            for (q, second) in weighted() {
                let h = of(first, second);
                for (row, a) in self.columns(system, state, *p).into_iter().flatten() {
                    for (column, b) in self.columns(system, state, *q).into_iter().flatten() {
                        blocks.push(Block { row, column, matrix: a.transpose() * h * b });
                    }
                }
            }
        }
    }

    /// Finds the points that constraints hold, and the places where they hold a cable nearer to an obstacle than its
    /// radius.
    pub fn update_held(&mut self, system: System<'_>) {
        if self.is_idle() {
            return;
        }
        let (held, before) = (&mut self.held, &mut self.held_before);
        std::mem::swap(held, before);
        held.fill(false);
        self.held_depths.clear();
        let network = system.network;
        for (c, constraint) in system.acting() {
            let Action::Prescribed(hold) = constraint.model.action() else { continue };
            if !hold.position {
                continue;
            }
            if hold.rails.is_empty() {
                self.held[constraint.site.point] = true;
            }
            for (o, obstacle) in network.obstacles.iter().enumerate() {
                let x = system.conditions.contact.poses[o].local(&system.conditions.targets[c].position);
                let mut add = |branch: usize, node: usize| {
                    let radius = 0.5 * network.diameter_at(Place::Node { branch, node });
                    let distance = obstacle.shape.distance(&x, radius);
                    if distance < radius {
                        self.held_depths.push(HeldDepth { place: (branch, node), obstacle: o as u32, distance });
                    }
                };
                match constraint.place {
                    Place::Node { branch, node } => add(branch, node),
                    Place::Joint(j) => {
                        for (arm, &branch) in network.joints[j].arms.iter().zip(&network.joints[j].branches) {
                            let mesh = network.branches[branch].rod.mesh();
                            add(branch, if arm.starts_here { 0 } else { mesh.segments() });
                        }
                    }
                }
            }
        }
        self.update_held_overlaps(system);
        for tie in &network.ties {
            let hub_held = tie.hub_frame.is_none() && self.held[tie.hub_point];
            self.held[tie.point] |= hub_held;
        }
        if self.held != self.held_before {
            self.search_again();
        }
    }
}
