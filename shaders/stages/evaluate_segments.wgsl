#import segment

// Energy of every segment in a slot of the state, ∂E/∂e = R n, ∂E/∂θ = ℓ n × v and ∂²E/∂e² = R C Rᵀ/ℓ.
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
    let s = segment(k, variant);
    let links = offsets.segments_program + 3u * k;
    let a = state_entry(program[links], range.slot, variant);
    let b = state_entry(program[links + 1u], range.slot, variant);
    let f = state_entry(program[links + 2u], range.slot, variant);
    let zero = unknown_zero(variant);
    let law = segment_law(s, edge(a, b, variant, zero), value4(f, variant), zero);
    let entry = offsets.segments_parts + 33u * k;
    set_vector(offsets.energies_vectors + k, variant, segment_energy(law, s.l));
    set_part3(entry, variant, law.r * law.n);
    set_part3(entry + 3u, variant, cross3(law.n, law.v) * s.l);
    set_part33(entry + 6u, variant, (law.r * diagonal(law.c) * transpose(law.r)) * (real(1.0) / s.l));
}
