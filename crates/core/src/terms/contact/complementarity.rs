//! Complementarity of contact: at an equilibrium the gap or the force is zero.

use super::term::{ContactTerm, DEPTH};
use crate::State;
use crate::conditions::{Partner, System};
use std::collections::BTreeSet;

/// Tolerance of the normal force used by friction, as a fraction of the largest normal force.
const FRICTION_TOLERANCE: f64 = 1e-3;

/// A violation of contact, with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactViolation {
    /// Index of the branch.
    pub branch: usize,
    /// Arc length, m.
    pub s: f64,
    /// Its partner.
    pub partner: Partner,
    /// Kind of the violation.
    pub lack: Lack,
}

/// Kind of a violation of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lack {
    /// Depth, m; if negative, a force acts across a gap of this size.
    Depth(f64),
    /// Difference of the normal force used by friction from the present one, N.
    Friction(f64),
}

impl ContactTerm {
    /// Largest violation of contact at `state`, in units of the tolerance: up to 1 is accepted. `None` if there are no
    /// contact points.
    pub fn violation(&mut self, system: System<'_>, state: &State) -> Option<f64> {
        if self.is_idle() {
            return None;
        }
        self.energy(system, state);
        let mut worst = 0.0_f64;
        self.for_violations(system, state, |value, _, _, _| worst = worst.max(value));
        Some(worst)
    }

    /// Largest violation of contact at `state`, if it is above the tolerance.
    pub fn worst_violation(&mut self, system: System<'_>, state: &State) -> Option<ContactViolation> {
        if self.is_idle() {
            return None;
        }
        self.energy(system, state);
        let mut worst: Option<(f64, u32, Partner, Lack)> = None;
        self.for_violations(system, state, |value, point, partner, lack| {
            if value > worst.map_or(1.0, |worst| worst.0) {
                worst = Some((value, point, partner, lack));
            }
        });
        worst.map(|(_, point, partner, lack)| {
            let point = self.point(point);
            let (branch, s) = (point.branch, point.arc_length(system.network, state));
            ContactViolation { branch, s, partner, lack }
        })
    }

    /// Calls `visit` with the violation of every contact and record at the last evaluated state, in units of the
    /// tolerance.
    fn for_violations(&self, system: System<'_>, state: &State, mut visit: impl FnMut(f64, u32, Partner, Lack)) {
        let bends = if self.found.is_empty() { Vec::new() } else { Self::bends(system, state) };
        let records = &system.conditions.contact.records;
        let found = &self.found;
        let largest = found.iter().map(|c| c.force).fold(0.0, f64::max);
        for contact in found {
            let (point, partner, gap) = (contact.point, contact.partner, contact.gap);
            visit(gap.abs() / (DEPTH * contact.radius), point, partner, Lack::Depth(-gap));
            let stale = Self::stale(system, contact, self.point(point), &bends);
            visit(stale / (DEPTH * contact.radius), point, partner, Lack::Depth(stale));
            if system.friction_coefficient(partner) > 0.0 {
                let anchor = system
                    .conditions
                    .contact
                    .record_of(contact.point, contact.partner)
                    .and_then(|record| record.anchor);
                let difference = (anchor.map_or(0.0, |anchor| anchor.force) - contact.force).abs();
                visit(difference / (FRICTION_TOLERANCE * largest), point, partner, Lack::Friction(difference));
            }
        }
        // A contact that has opened must not keep a multiplier, λ/ρ in metres: the measure of complementarity
        // `|max(c, −λ/ρ)|` (Birgin and Martínez 2014, Practical Augmented Lagrangian Methods). Residuals are
        // relative to contact forces, so a large multiplier would hide any residual.
        let touching: BTreeSet<_> = found.iter().map(|contact| (contact.point, contact.partner)).collect();
        for record in records.iter().filter(|record| !touching.contains(&(record.point, record.partner))) {
            let reach = record.multiplier / self.penalty(record);
            let point = self.point(record.point);
            let radius = system.network.radius(point.branch, point.segment);
            visit(reach / (DEPTH * radius), record.point, record.partner, Lack::Depth(-reach));
            // Friction that still acts there, with the previous normal force, is a violation however small it is.
            let anchor =
                record.anchor.filter(|anchor| anchor.force > 0.0 && system.friction_coefficient(record.partner) > 0.0);
            if let Some(anchor) = anchor {
                visit(f64::INFINITY, record.point, record.partner, Lack::Friction(anchor.force));
            }
        }
    }
}
