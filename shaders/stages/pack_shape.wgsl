#import bindings

// Packs the states of all variants for read-back, whichever third of the buffer is current.
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
    for (var i = 0u; i < 7u; i++) {
        set_vector(offsets.shape_vectors + 7u * k + i, variant, state_at(at + i, variant));
    }
}
