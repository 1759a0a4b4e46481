#import assembly

// Sums over a chunk of the step: transforms the descent direction from the bases of held variables to world and body
// axes, adds the prescribed motion, and computes the products with the current and the previous gradient, the product
// of the last step with the gradient, and the largest rotation.
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
    var slope = real(0.0);
    var before = real(0.0);
    var last = real(0.0);
    var turn = real(0.0);
    for (var variable = k; variable < offsets.variables; variable += offsets.chunks) {
        var descent = vector3(3u * variable, variant);
        let held = hold_entry(variable);
        if held != NONE {
            descent = hold_basis(held, variant) * descent + motion(variable, variant);
        }
        set_vector3(offsets.descent_vectors + 3u * variable, variant, descent);
        let gradient = vector3(gradient_entry(variable, CURRENT, variant), variant);
        slope += dot3(gradient, descent);
        if control[variant].since > 0u {
            before += dot3(vector3(gradient_of(control[variant].previous, variable), variant), descent);
            last += dot3(gradient, vector3(offsets.step_vectors + 3u * variable, variant));
        }
        if program[offsets.kinds_program + variable] == 1u {
            turn = max(turn, dot3(descent, descent));
        }
    }
    let at = offsets.partials_vectors + 7u * k;
    set_vector(at + 1u, variant, slope);
    set_vector(at + 4u, variant, turn);
    set_vector(at + 5u, variant, before);
    set_vector(at + 6u, variant, last);
}
