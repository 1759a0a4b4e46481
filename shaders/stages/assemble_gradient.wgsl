#import assembly

// The free gradient in a slot of the state: without held directions, in world axes (points) and body axes (frames).
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
    let dead = number3(offsets.variables_numbers + 4u * k, variant);
    var g = assembled_force(k, variant) - dead;
    let held = hold_entry(k);
    if held != NONE {
        let basis = hold_basis(held, variant);
        g = basis * ((g * basis) * free_directions(held, variant));
    }
    set_vector3(gradient_entry(k, range.slot, variant), variant, g);
}
