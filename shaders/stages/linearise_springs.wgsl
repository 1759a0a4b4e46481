#import spring

// Second derivatives of every spring, and first derivatives extrapolated by the prescribed motion; ∂X/∂θ = −R
// [o]ₓ.
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
    let law = spring_law(k, CURRENT, variant);
    let s = spring(k, variant);
    let point = program[offsets.springs_program + 2u * k];
    let frame = program[offsets.springs_program + 2u * k + 1u];
    let rest = rotation_matrix(s.rest);
    let lever = law.r * skew(-s.offset);
    let xx = identity(s.k);
    let tx = transpose(lever) * s.k;
    let tt = tx * lever + rest * law.hessian * transpose(rest) + lever_hessian(law.r, law.force, s.offset);
    let dx = motion(point, variant);
    var theta = vec3<real>(real(0.0), real(0.0), real(0.0));
    if frame != NONE {
        theta = motion(frame, variant);
    }
    let own = offsets.springs_parts + 33u * k;
    let moment = cross3(s.offset, law.force * law.r) + rest * law.moment;
    set_part3(own, variant, law.force + xx * dx + theta * tx);
    set_part3(own + 3u, variant, moment + tx * dx + tt * theta);
    set_part33(own + 6u, variant, xx);
    set_part33(own + 15u, variant, tx);
    set_part33(own + 24u, variant, tt);
}
