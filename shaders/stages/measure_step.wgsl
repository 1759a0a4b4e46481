#import gather

// A chunk of the step: from the bases of the held variables to world and body axes, with the prescribed motion; the slope of the
// energy along it and its largest turn.
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
    var slope = real(0.0);
    var turn = real(0.0);
    for (var variable = k; variable < places.variables; variable += places.chunks) {
        var step = vector3(3u * variable, variant);
        let held = hold_entry(variable);
        if held != NONE {
            step = hold_basis(held, variant) * step + motion(variable, variant);
        }
        set_vector3(places.step_vectors + 3u * variable, variant, step);
        slope += dot3(vector3(gradient_entry(variable, AT_HAND, variant), variant), step);
        if program[places.kinds_program + variable] == 1u {
            turn = max(turn, dot3(step, step));
        }
    }
    set_vector(places.partials_vectors + 5u * k + 1u, variant, slope);
    set_vector(places.partials_vectors + 5u * k + 4u, variant, turn);
}
