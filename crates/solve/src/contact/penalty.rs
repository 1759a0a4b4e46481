//! Penalty schedule of the augmented Lagrangian method.

/// Rule by which penalties are raised after updates of the multipliers that reduce the violation too little.
pub(super) struct PenaltySchedule {
    /// An update that leaves more than this fraction of the violation raises the penalty.
    pub(super) largest_left: f64,
    /// Factor by which a penalty is raised.
    pub(super) factor: f64,
    /// Highest penalty, in the units of the first one: beyond it round-off decides.
    pub(super) highest: f64,
}

impl PenaltySchedule {
    /// Whether the penalty is raised after an update that took the violation from `before` to `now`.
    pub(super) fn raises(&self, before: f64, now: f64) -> bool {
        now > self.largest_left * before
    }

    /// The next penalty.
    pub(super) fn raised(&self, penalty: f64) -> f64 {
        (self.factor * penalty).min(self.highest)
    }
}

/// Schedule of the equations and inequalities of constraints; their first penalty is 1e4 (see `core::conditions`).
pub(super) const OF_CONSTRAINTS: PenaltySchedule = PenaltySchedule { largest_left: 0.25, factor: 10.0, highest: 1e9 };
/// Schedule of contact; its first penalty is 1.
pub(super) const OF_CONTACT: PenaltySchedule = PenaltySchedule { largest_left: 0.5, factor: 10.0, highest: 1e4 };
