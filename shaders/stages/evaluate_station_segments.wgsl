#import station_segment

// Energy of every segment with stations in a slot of the state, ∂E/∂e = R p, ∂E/∂θ = ℓ (p × v + Σ β (R′ u) × p), the
// moments on its stations, and ∂²E/∂e² = R B⁻ᵀ C B⁻¹ Rᵀ/ℓ.
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
    let s = station_segment(k, variant);
    let links = offsets.station_segments_program + 5u * k;
    let a = program[links];
    let b = program[links + 1u];
    let f = program[links + 2u];
    let q = value4(state_entry(f, range.slot, variant), variant);
    let first = station(k, 0u, q, range.slot, variant);
    let second = station(k, 1u, q, range.slot, variant);
    let zero = unknown_zero(variant);
    let nodes = edge(state_entry(a, range.slot, variant), state_entry(b, range.slot, variant), variant, zero);
    let e = two_sum(nodes.sum, nodes.error, second.r * second.offset - first.r * first.offset, zero);
    let law = station_law(s, e, q, first, second, zero);
    let p = conjugate_force(law);
    let force = law.r * p;
    let turned = (station_turn(first) + station_turn(second)) * law.u;
    let entry = offsets.station_segments_parts + 102u * k;
    set_vector(offsets.energies_vectors + offsets.segments + k, variant, station_energy(law, s.l));
    set_part3(entry, variant, force);
    set_part3(entry + 3u, variant, (cross3(p, law.v) + cross3(turned, p)) * s.l);
    set_part3(entry + 6u, variant, station_moment(first, -force, p, law.u, s.l));
    set_part3(entry + 9u, variant, station_moment(second, force, p, law.u, s.l));
    let along = law.r * transpose(law.inverse);
    set_part33(entry + 12u, variant, (along * diagonal(law.c) * transpose(along)) * (real(1.0) / s.l));
}
