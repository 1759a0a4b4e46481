use crate::layout::Range;
use crate::memory::Memory;

/// Maximum that propagates NaN.
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a >= b { a } else { b }
}

/// Sums over a chunk of a slot of the state: its energy, and its largest free force and moment (squared).
pub(crate) fn sum_state(m: &mut Memory, range: &Range, k: usize, variant: usize) {
    let p = m.offsets;
    let parts = p.segments + p.station_segments + p.couplings + p.springs;
    let mut energy = 0.0;
    for own in (k..parts as usize).step_by(p.chunks as usize) {
        energy += m.vector(p.energies_vectors as usize + own, variant);
    }
    let (mut force, mut moment) = (0.0, 0.0);
    for variable in (k..p.variables as usize).step_by(p.chunks as usize) {
        let square = m.vector3(m.gradient_entry(variable, range.slot, variant), variant).norm_squared();
        if m.word(p.kinds_program as usize + variable) == 1 {
            moment = larger(moment, square);
        } else {
            force = larger(force, square);
            let dead = m.number3(p.variables_numbers as usize + 4 * variable, variant);
            energy -= dead.dot(&m.value3(m.state_entry(variable, range.slot, variant), variant));
        }
    }
    let at = p.partials_vectors as usize + 7 * k;
    m.set_vector(at, variant, energy);
    m.set_vector(at + 2, variant, force);
    m.set_vector(at + 3, variant, moment);
}
