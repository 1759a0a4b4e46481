#import assembly

// Minus the gradient, in the basis of each held variable and without held directions. If the step includes the
// prescribed motion, the gradient is extrapolated by it.
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
    let own = program[range.table + 2u * k];
    let variable = program[range.table + 2u * k + 1u];
    let dead = number3(offsets.variables_numbers + 4u * variable, variant);
    var r = dead - assembled_force(variable, variant);
    let held = hold_entry(variable);
    if held != NONE {
        r = (r * hold_basis(held, variant)) * free_directions(held, variant);
    }
    set_vector3(3u * own, variant, r);
}
