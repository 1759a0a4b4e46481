#import spring

// Energy of every spring in a slot of the state, the force on its point, the moment on its frame and ∂²E/∂X².
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
    let law = spring_law(k, range.slot, variant);
    let s = spring(k, variant);
    let own = offsets.springs_parts + 33u * k;
    let energy = offsets.energies_vectors + offsets.segments + offsets.station_segments + offsets.couplings + k;
    set_vector(energy, variant, law.energy);
    set_part3(own, variant, law.force);
    set_part3(own + 3u, variant, cross3(s.offset, law.force * law.r) + rotation_matrix(s.rest) * law.moment);
    set_part33(own + 6u, variant, identity(s.k));
}
