#import spring

// Energy of every spring on trial, the force on its point and the moment on its frame.
@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let it = item(group, groups, local);
    if !it.there {
        return;
    }
    let k = it.index;
    let variant = it.variant;
    let law = spring_law(k, 1u, variant);
    let s = spring(k, variant);
    let own = places.springs_parts + 33u * k;
    let energy = places.energies_vectors + places.segments + places.station_segments + places.couplings + k;
    set_vector(energy, variant, law.energy);
    set_part3(own, variant, law.force);
    set_part3(own + 3u, variant, cross3(s.offset, law.force * law.r) + rotation_matrix(s.rest) * law.moment);
}
