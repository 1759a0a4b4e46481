#import assembly
#import sum

// The shortest rotation from direction a to b, both unit vectors; the identity if they are opposite.
fn shortest(a: vec3<real>, b: vec3<real>) -> vec4<real> {
    let w = real(1.0) + dot3(a, b);
    if w < real(1e-12) {
        return vec4<real>(real(0.0), real(0.0), real(0.0), real(1.0));
    }
    return normalised(vec4<real>(cross3(a, b), w));
}

// The trial state: points move by α δ, frames rotate by α θ, and held variables are set to their targets.
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
    let at = state_entry(k, CURRENT, variant);
    let to = state_entry(k, TRIAL, variant);
    let step = vector3(offsets.step_vectors + 3u * k, variant) * control[variant].alpha;
    let held = hold_entry(k);
    var count = real(0.0);
    if held != NONE {
        count = number(held + 9u, variant);
    }
    if program[offsets.kinds_program + k] == 1u {
        var q = rotated(value4(at, variant), step);
        if count > real(2.5) {
            q = number4(held + 10u, variant);
        } else if count > real(1.5) {
            let wanted = rotation_matrix(number4(held + 10u, variant))[2];
            q = normalised(quaternion_product(shortest(rotation_matrix(q)[2], wanted), q));
        }
        set_state(to, variant, q.x);
        set_state(to + 1u, variant, q.y);
        set_state(to + 2u, variant, q.z);
        set_state(to + 3u, variant, q.w);
        return;
    }
    let zero = unknown_zero(variant);
    var moved = two_sum(value3(at, variant), compensation3(at, variant), step, zero);
    if count > real(2.5) {
        let none = vec3<real>(real(0.0), real(0.0), real(0.0));
        moved = two_sum(number3(held + 10u, variant), number3(held + 14u, variant), none, zero);
    } else if count > real(0.5) {
        let basis = hold_basis(held, variant);
        let one = vec3<real>(real(1.0), real(1.0), real(1.0));
        let gap = ((number3(held + 10u, variant) - moved.sum) + (number3(held + 14u, variant) - moved.error)) * basis;
        moved = two_sum(moved.sum, moved.error, basis * (gap * (one - free_directions(held, variant))), zero);
    }
    set_point(to, variant, moved);
}
