#import segment

// Energy of every segment on trial, ∂E/∂e = R n and ∂E/∂θ = ℓ n × v.
@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let it = item(group, groups, local);
    if !it.there || phase(it.variant) != SEARCH {
        return;
    }
    let k = it.index;
    let s = segment(k, it.variant);
    let links = places.segments_program + 3u * k;
    let a = state_entry(program[links], 1u, it.variant);
    let b = state_entry(program[links + 1u], 1u, it.variant);
    let f = state_entry(program[links + 2u], 1u, it.variant);
    let e = (value3(b, it.variant) - value3(a, it.variant)) + (carry3(b, it.variant) - carry3(a, it.variant));
    let law = segment_law(s, e, value4(f, it.variant));
    let entry = places.segments_parts + 33u * k;
    set_vector(places.energies_vectors + k, it.variant, segment_energy(law, s.l));
    set_part3(entry, it.variant, law.r * law.n);
    set_part3(entry + 3u, it.variant, cross3(law.n, law.v) * s.l);
}
