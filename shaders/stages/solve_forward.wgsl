#import algebra
#import bindings
#import instructions

// A task of the forward substitution: z_j = D_j⁻¹ (r_j + Σ u − Σ B_jk z_k), and its updates for later tasks.
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
        let flags = program[at + 1u];
        let pivot = program[at + 2u];
        let adds = program[at + 3u];
        let products = program[at + 4u];
        at += 5u;
        var sum = vec3<real>(real(0.0), real(0.0), real(0.0));
        if (flags & UPDATE) == 0u {
            sum = vector3(3u * own, variant);
        }
        for (var i = 0u; i < adds; i++) {
            sum += vector3(3u * program[at + i], variant);
        }
        at += adds;
        for (var i = 0u; i < products; i++) {
            sum -= block33(program[at], variant) * vector3(3u * program[at + 1u], variant);
            at += 2u;
        }
        if (flags & PIVOT) != 0u {
            sum = block33(pivot, variant) * sum;
        }
        set_vector3(3u * own, variant, sum);
    }
}
