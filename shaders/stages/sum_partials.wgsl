#import algebra
#import bindings

// Sums and maxima of every n-th chunk, n = totals: what `sum_state` and `sum_step` left.
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
    var energy = real(0.0);
    var slope = real(0.0);
    var force = real(0.0);
    var moment = real(0.0);
    var turn = real(0.0);
    var before = real(0.0);
    var last = real(0.0);
    for (var chunk = k; chunk < offsets.chunks; chunk += offsets.totals) {
        let chunk_vectors = offsets.partials_vectors + 7u * chunk;
        energy += vector(chunk_vectors, variant);
        slope += vector(chunk_vectors + 1u, variant);
        force = larger(force, vector(chunk_vectors + 2u, variant));
        moment = larger(moment, vector(chunk_vectors + 3u, variant));
        turn = larger(turn, vector(chunk_vectors + 4u, variant));
        before += vector(chunk_vectors + 5u, variant);
        last += vector(chunk_vectors + 6u, variant);
    }
    let at = offsets.totals_vectors + 7u * k;
    set_vector(at, variant, energy);
    set_vector(at + 1u, variant, slope);
    set_vector(at + 2u, variant, force);
    set_vector(at + 3u, variant, moment);
    set_vector(at + 4u, variant, turn);
    set_vector(at + 5u, variant, before);
    set_vector(at + 6u, variant, last);
}
