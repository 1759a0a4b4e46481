//! Updates of multipliers and penalties between minimisations (augmented Lagrangian: Bertsekas 1982).

use super::penalty::{OF_CONSTRAINTS, OF_CONTACT};
use nalgebra::{DMatrix, DVector};
use wireloom_core::conditions::{ContactRecord, Partner};
use wireloom_core::terms::contact::DEPTH;
use wireloom_core::{Problem, State};

/// Number of updates that are mixed.
const MIXED: usize = 6;
/// Largest mixed force, as a multiple of the largest force found.
const LARGEST_MIXED: f64 = 10.0;
/// Singular values below this fraction of the largest are dropped from the mixing.
const SINGULAR: f64 = 1e-8;

/// Sets the multipliers of constraints to their forces at `state`, a minimum, and raises the penalties of residuals
/// above `tolerance` that decreased too little since `last` (in units of their scales), which becomes the present
/// residuals.
pub fn update_constraints(problem: &mut Problem<'_>, state: &State, tolerance: f64, last: &mut Vec<f64>) {
    let residuals = problem.constraint_residuals(state);
    last.resize(residuals.len(), f64::INFINITY);
    for (residual, last) in residuals.iter().zip(last) {
        let mut penalty = problem.conditions().constraints[residual.constraint].penalties[residual.residual];
        if residual.violation > tolerance && OF_CONSTRAINTS.raises(*last, residual.violation) {
            penalty = OF_CONSTRAINTS.raised(penalty);
        }
        problem.set_multiplier(residual, residual.mu, penalty);
        *last = residual.violation;
    }
}

/// History of the updates of contact multipliers. Taking the forces found as the next multipliers converges slowly
/// where several contact points bear one load or friction transmits tension; Anderson mixing of the last updates
/// accelerates it (Anderson 1965; Walker and Ni 2011).
#[derive(Default)]
pub struct ContactHistory {
    /// Whether penalties, and which segments cross, stay as they are.
    of_kept_matrix: bool,
    /// Largest violation at the last update, in radii.
    deepest: Option<f64>,
    /// Contact points and their partners.
    keys: Vec<(u32, Partner)>,
    /// Multipliers, and the forces found under them, update by update.
    given: Vec<DVector<f64>>,
    found: Vec<DVector<f64>>,
}

impl ContactHistory {
    /// History of updates that leave penalties, and which segments cross, as they are: a matrix that is kept is that
    /// of them.
    pub fn of_kept_matrix() -> Self {
        Self { of_kept_matrix: true, ..Self::default() }
    }

    /// Next multipliers, after an update in which the multipliers `given` led to the forces `found`.
    fn mix(&mut self, keys: Vec<(u32, Partner)>, given: DVector<f64>, found: DVector<f64>) -> DVector<f64> {
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
        let Ok(weights) = svd.solve(&off[last], cut) else { return self.found[last].clone() };
        let mut next = self.found[last].clone();
        for (k, weight) in weights.iter().enumerate() {
            next -= (&self.found[k + 1] - &self.found[k]) * *weight;
        }
        let most = LARGEST_MIXED * self.found[last].max();
        next.map(|force| force.max(0.0).min(most))
    }
}

/// Sets the multipliers of contact to the forces at `state`, a minimum, or to the forces that `history` extrapolates;
/// raises the penalties of contact points that are too deep if the largest violation decreased too little since the
/// last update; updates the arcs of segments and the anchors of friction.
pub fn update_contacts(problem: &mut Problem<'_>, state: &State, history: &mut ContactHistory) {
    if problem.contact().is_idle() {
        return;
    }
    problem.find_contacts(state);
    let found = problem.contact().found();
    let contact_state = &problem.conditions().contact;
    let deepest = found.iter().map(|c| c.gap.abs() / c.radius).fold(0.0, f64::max);
    let raises = history.deepest.replace(deepest).is_some_and(|last| OF_CONTACT.raises(last, deepest))
        && !history.of_kept_matrix;
    let mut given = Vec::with_capacity(found.len());
    let mut records = Vec::with_capacity(found.len());
    for contact in found {
        let (point, partner) = (contact.point, contact.partner);
        let known = contact_state.record_of(point, partner);
        let mut penalty = known.map_or(1.0, |record| record.penalty);
        if raises && contact.gap.abs() > DEPTH * contact.radius {
            penalty = OF_CONTACT.raised(penalty);
        }
        let anchor = problem.friction_anchor(state, contact);
        given.push(known.map_or(0.0, |record| record.multiplier));
        records.push(ContactRecord { point, partner, multiplier: contact.force, penalty, anchor });
    }
    let keys = records.iter().map(|record| (record.point, record.partner)).collect();
    let forces = DVector::from_iterator(records.len(), records.iter().map(|record| record.multiplier));
    let next = history.mix(keys, DVector::from_vec(given), forces);
    for (record, force) in records.iter_mut().zip(&next) {
        record.multiplier = *force;
        if let Some(anchor) = &mut record.anchor {
            anchor.force = *force;
        }
    }
    records.sort_by_key(|record| (record.point, record.partner));
    problem.set_contact_records(records);
    problem.update_bends(state);
    if !history.of_kept_matrix {
        problem.update_crossings(state);
    }
}
