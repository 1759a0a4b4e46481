#import algebra
#import bindings

// Sums over a chunk of a slot of the state: its energy, and its largest free force and moment (squared).
@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let it = item(group, groups, local);
    if !it.present {
        return;
    }
    let k = it.index;
    let variant = it.variant;
    let parts_count = offsets.segments + offsets.station_segments + offsets.couplings + offsets.springs;
    var energy = real(0.0);
    for (var own = k; own < parts_count; own += offsets.chunks) {
        energy += vector(offsets.energies_vectors + own, variant);
    }
    var force = real(0.0);
    var moment = real(0.0);
    for (var variable = k; variable < offsets.variables; variable += offsets.chunks) {
        let gradient = vector3(gradient_entry(variable, range.slot, variant), variant);
        let square = dot3(gradient, gradient);
        if program[offsets.kinds_program + variable] == 1u {
            moment = larger(moment, square);
        } else {
            force = larger(force, square);
            let dead = number3(offsets.variables_numbers + 4u * variable, variant);
            energy -= dot3(dead, value3(state_entry(variable, range.slot, variant), variant));
        }
    }
    set_vector(offsets.partials_vectors + 7u * k, variant, energy);
    set_vector(offsets.partials_vectors + 7u * k + 2u, variant, force);
    set_vector(offsets.partials_vectors + 7u * k + 3u, variant, moment);
}
