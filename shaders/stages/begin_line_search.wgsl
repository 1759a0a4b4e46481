#import algebra
#import bindings
#import limits

// Slope of the energy along the step, and the largest step length with bounded rotations. The gradient method
// adds β times the last step, β = g·M⁻¹(g − g°)/(g°·M⁻¹g°) if that is positive and the sum is a descent
// direction (Polak and Ribière 1969, Polyak 1969); M is the matrix.
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
    let variant = it.variant;
    var slope = real(0.0);
    var before = real(0.0);
    var last = real(0.0);
    var turn = real(0.0);
    for (var k = 0u; k < offsets.totals; k++) {
        let at = offsets.totals_vectors + 7u * k;
        slope += vector(at + 1u, variant);
        turn = max(turn, vector(at + 4u, variant));
        before += vector(at + 5u, variant);
        last += vector(at + 6u, variant);
    }
    turn = sqrt(turn);
    var beta = real(0.0);
    if control[variant].since > 0u {
        beta = max((before - slope) / control[variant].product, real(0.0));
        if !(slope + beta * last < real(0.0)) {
            beta = real(0.0);
        }
    }
    control[variant].beta = beta;
    control[variant].product = -slope;
    control[variant].since += 1u;
    control[variant].iterations += 1u;
    slope += beta * last;
    // Upper bound for the rotation by both directions.
    turn += beta * control[variant].max_rotation;
    control[variant].slope = slope;
    control[variant].max_rotation = turn;
    control[variant].alpha = min(real(1.0), MAX_ROTATION / max(turn, MAX_ROTATION));
    control[variant].phase = COMBINE;
    if !is_finite(slope) || !is_finite(turn) {
        end(variant, FAILED);
    }
}
