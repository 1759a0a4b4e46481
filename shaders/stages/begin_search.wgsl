#import algebra
#import bindings
#import limits

// The slope of the energy along the step, and the longest share of it that turns no frame too far.
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
    let variant = it.variant;
    var slope = real(0.0);
    var turn = real(0.0);
    for (var chunk = 0u; chunk < places.chunks; chunk++) {
        slope += vector(places.partials_vectors + 5u * chunk + 1u, variant);
        turn = max(turn, vector(places.partials_vectors + 5u * chunk + 4u, variant));
    }
    turn = sqrt(turn);
    control[variant].slope = slope;
    control[variant].largest_turn = turn;
    control[variant].alpha = min(real(1.0), LARGEST_TURN / max(turn, LARGEST_TURN));
    control[variant].phase = SEARCH;
    if !is_finite(slope) || !is_finite(turn) {
        end(variant, FAILED);
    }
}
