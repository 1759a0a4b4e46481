#import inertia

// After a factorisation for the points alone: if the energy is not convex in the points, they stay where they are.
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
    if negative_pivots(variant) > real(0.0) {
        control[variant].phase = ACCEPT;
    }
}
