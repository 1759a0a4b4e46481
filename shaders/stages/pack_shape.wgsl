#import bindings

// Collects the current state of a variant for read-back.
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
    let x = state_at(state_entry(0u, CURRENT, variant) + k, variant);
    transfer[variant * 7u * offsets.variables + k] = x;
}
