#import bindings

// Distributes what was uploaded of a variant: its numbers, then its current state.
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
    let x = transfer[variant * (offsets.numbers + 7u * offsets.variables) + k];
    if k < offsets.numbers {
        numbers[k * offsets.variants + variant] = x;
    } else {
        set_state(state_entry(0u, CURRENT, variant) + k - offsets.numbers, variant, x);
    }
}
