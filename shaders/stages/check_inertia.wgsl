#import algebra
#import bindings
#import inertia
#import limits

// After a factorisation: if the matrix is not positive definite, increases the shift of the frames' diagonal and
// refactorises.
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
    let negative = negative_pivots(variant);
    control[variant].negative = u32(negative);
    control[variant].factorisations += 1u;
    let force_scale = control[variant].force_scale;
    let sigma = control[variant].sigma;
    if negative > real(0.0) && sigma < OVERFLOW * force_scale {
        control[variant].sigma = max(SHIFT_INCREASE * sigma, FIRST_SHIFT * force_scale);
        control[variant].cycles += 1u;
        control[variant].phase = REFACTOR;
    } else {
        control[variant].since = 0u;
        control[variant].phase = SOLVE;
    }
}
