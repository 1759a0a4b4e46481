#import coupling

// Second derivatives of every coupling, and first derivatives extrapolated by the prescribed motion.
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
    let entry = offsets.couplings_numbers + 15u * k;
    let c = Coupling(number3(entry, variant), number(entry + 3u, variant), number3(entry + 4u, variant));
    let links = offsets.couplings_program + 2u * k;
    let a = program[links];
    let b = program[links + 1u];
    let rest_a = number4(entry + 7u, variant);
    let rest_b = number4(entry + 11u, variant);
    let qa = quaternion_product(value4(state_entry(a, CURRENT, variant), variant), rest_a);
    let qb = quaternion_product(value4(state_entry(b, CURRENT, variant), variant), rest_b);
    let law = bend_twist(qa, qb, c);
    let ra = rotation_matrix(rest_a);
    let rb = rotation_matrix(rest_b);
    let own = offsets.couplings_parts + 33u * k;
    let h = bend_twist_hessian(law, c);
    let aa = ra * h.aa * transpose(ra);
    let ab = ra * h.ab * transpose(rb);
    let bb = rb * h.bb * transpose(rb);
    let theta_a = motion(a, variant);
    let theta_b = motion(b, variant);
    set_part3(own, variant, ra * moment_on_first(law) + aa * theta_a + ab * theta_b);
    set_part3(own + 3u, variant, rb * moment_on_second(law) + theta_a * ab + bb * theta_b);
    set_part33(own + 6u, variant, aa);
    set_part33(own + 15u, variant, ab);
    set_part33(own + 24u, variant, bb);
}
