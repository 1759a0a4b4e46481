//! Reference of `shared/totals.wgsl`.

use crate::memory::Memory;

/// Energy and relative residual of the slot of the state that was evaluated last.
pub(crate) struct Totals {
    pub(crate) energy: f64,
    /// Largest free force, N.
    pub(crate) force: f64,
    pub(crate) residual: f64,
}

pub(crate) fn totals(m: &Memory, variant: usize) -> Totals {
    let (mut energy, mut force, mut moment) = (0.0, 0.0_f64, 0.0_f64);
    for k in 0..m.offsets.totals as usize {
        let at = m.offsets.totals_vectors as usize + 7 * k;
        energy += m.vector(at, variant);
        force = force.max(m.vector(at + 2, variant));
        moment = moment.max(m.vector(at + 3, variant));
    }
    force = force.sqrt();
    let control = &m.control[variant];
    let residual = f64::max(force / control.force_scale, moment.sqrt() / control.moment_scale);
    Totals { energy, force, residual }
}
