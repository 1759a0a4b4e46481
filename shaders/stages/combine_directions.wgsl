#import bindings

// The step: steepest descent in the current metric plus β times the last step; β is 0 in Newton's method.
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
    let entry = offsets.step_vectors + 3u * k;
    var step = vector3(offsets.descent_vectors + 3u * k, variant);
    if control[variant].beta > real(0.0) {
        step += vector3(entry, variant) * control[variant].beta;
    }
    set_vector3(entry, variant, step);
}
