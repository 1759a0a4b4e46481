#import algebra
#import bindings

// A task of the backward substitution: x_j = z_j − D_j⁻¹ Σ B_ijᵀ x_i.
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
    let table = range.table;
    let end = table + program[table + k + 1u];
    var at = table + program[table + k];
    while at < end {
        let own = program[at];
        let pivot = program[at + 1u];
        let products = program[at + 2u];
        at += 3u;
        var sum = vec3<real>(real(0.0), real(0.0), real(0.0));
        for (var i = 0u; i < products; i++) {
            sum += vector3(3u * program[at + 1u], variant) * block33(program[at], variant);
            at += 2u;
        }
        set_vector3(3u * own, variant, vector3(3u * own, variant) - block33(pivot, variant) * sum);
    }
}
