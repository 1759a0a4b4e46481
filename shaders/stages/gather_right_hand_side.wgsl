#import gather

// Minus the gradient as it is after the prescribed motion, in the basis of each held variable and without its held directions.
@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let it = item(group, groups, local);
    if !it.there {
        return;
    }
    let k = it.index;
    let variant = it.variant;
    let dead = number3(places.variables_numbers + 4u * k, variant);
    var r = dead - gathered_force(k, variant);
    let held = hold_entry(k);
    if held != NONE {
        r = (r * hold_basis(held, variant)) * free_directions(held, variant);
    }
    set_vector3(3u * k, variant, r);
}
