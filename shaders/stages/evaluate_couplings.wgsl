#import coupling

// Energy of every coupling in a slot of the state, and the moments on the carriers of its frames.
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
    let entry = offsets.couplings_numbers + 15u * k;
    let c = Coupling(number3(entry, variant), number(entry + 3u, variant), number3(entry + 4u, variant));
    let links = offsets.couplings_program + 2u * k;
    let a = program[links];
    let b = program[links + 1u];
    let rest_a = number4(entry + 7u, variant);
    let rest_b = number4(entry + 11u, variant);
    let qa = quaternion_product(value4(state_entry(a, range.slot, variant), variant), rest_a);
    let qb = quaternion_product(value4(state_entry(b, range.slot, variant), variant), rest_b);
    let law = bend_twist(qa, qb, c);
    let ra = rotation_matrix(rest_a);
    let rb = rotation_matrix(rest_b);
    let own = offsets.couplings_parts + 33u * k;
    let energy = offsets.energies_vectors + offsets.segments + offsets.station_segments + k;
    set_vector(energy, variant, bend_twist_energy(law, c));
    set_part3(own, variant, ra * moment_on_first(law));
    set_part3(own + 3u, variant, rb * moment_on_second(law));
}
