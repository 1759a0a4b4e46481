#import station_segment

// Second derivatives of every segment with stations: ℓ Jᵀ C J with J = ∂u, those of ℓ p·v with respect to (e, θ) at
// fixed p, −ℓ (L J + Jᵀ Lᵀ) with δᵀ L w = p·δB w, and those of −ℓ p·exp(−θ) β R′ exp(θ_Q) u at fixed u.
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
    let s = station_segment(k, variant);
    let links = offsets.station_segments_program + 5u * k;
    let a = program[links];
    let b = program[links + 1u];
    let f = program[links + 2u];
    let q = value4(state_entry(f, CURRENT, variant), variant);
    let first = station(k, 0u, q, CURRENT, variant);
    let second = station(k, 1u, q, CURRENT, variant);
    let zero = unknown_zero(variant);
    let nodes = edge(state_entry(a, CURRENT, variant), state_entry(b, CURRENT, variant), variant, zero);
    let e = two_sum(nodes.sum, nodes.error, second.r * second.offset - first.r * first.offset, zero);
    let law = station_law(s, e, q, first, second, zero);
    let v = law.v;
    let u = law.u;
    let p = conjugate_force(law);
    let rt = transpose(law.r);
    let t_0 = station_turn(first);
    let t_1 = station_turn(second);
    let turned = (t_0 + t_1) * u;
    // ∂u with respect to the edge, the segment and both stations.
    let g_e = law.inverse * rt * (real(1.0) / s.l);
    let g_f = law.inverse * (skew(v) - skew(turned));
    let g_0 = law.inverse * t_0 * skew(u);
    let g_1 = law.inverse * t_1 * skew(u);
    // L.
    let b_f = skew(p) * (t_0 + t_1);
    let b_0 = skew(-(p * t_0));
    let b_1 = skew(-(p * t_1));
    let c = diagonal(law.c);
    let ee = transpose(g_e) * c * g_e * s.l;
    let fe = (transpose(g_f) * c - b_f) * g_e * s.l + skew(p) * rt;
    let bent = b_f * g_f;
    let ff = (transpose(g_f) * c * g_f - bent - transpose(bent) + symmetric_outer(p, v - turned)) * s.l;
    let e_0 = (transpose(g_0) * c - b_0) * g_e * s.l;
    let e_1 = (transpose(g_1) * c - b_1) * g_e * s.l;
    let along = skew(p) * t_0 * skew(u);
    let f_0 = ((transpose(g_0) * c - b_0) * g_f - transpose(b_f * g_0) + transpose(along)) * s.l;
    let beyond = skew(p) * t_1 * skew(u);
    let f_1 = ((transpose(g_1) * c - b_1) * g_f - transpose(b_f * g_1) + transpose(beyond)) * s.l;
    let own_0 = b_0 * g_0;
    let s_00 = (transpose(g_0) * c * g_0 - own_0 - transpose(own_0) - symmetric_outer(p * t_0, u)) * s.l;
    let own_1 = b_1 * g_1;
    let s_11 = (transpose(g_1) * c * g_1 - own_1 - transpose(own_1) - symmetric_outer(p * t_1, u)) * s.l;
    let s_10 = ((transpose(g_1) * c - b_1) * g_0 - transpose(b_0 * g_1)) * s.l;
    // With respect to the carriers of the stations: θ = Aᵀ θ_Q, and ∂e/∂θ_Q = ± R [o]ₓ.
    let world = law.r * p;
    let a_0 = rotation_matrix(first.rest);
    let a_1 = rotation_matrix(second.rest);
    let l_0 = first.r * skew(first.offset);
    let l_1 = second.r * skew(-second.offset);
    let q0_e = transpose(l_0) * ee + a_0 * e_0;
    let q1_e = transpose(l_1) * ee + a_1 * e_1;
    let q0_f = transpose(l_0) * transpose(fe) + a_0 * f_0;
    let q1_f = transpose(l_1) * transpose(fe) + a_1 * f_1;
    let across_0 = a_0 * e_0 * l_0;
    let across_1 = a_1 * e_1 * l_1;
    let q0_q0 = transpose(l_0) * ee * l_0 + across_0 + transpose(across_0) + a_0 * s_00 * transpose(a_0)
        + lever_hessian(first.r, -world, first.offset);
    let q1_q1 = transpose(l_1) * ee * l_1 + across_1 + transpose(across_1) + a_1 * s_11 * transpose(a_1)
        + lever_hessian(second.r, world, second.offset);
    let q1_q0 = transpose(l_1) * ee * l_0 + a_1 * e_1 * l_0 + transpose(l_1) * transpose(e_0) * transpose(a_0)
        + a_1 * s_10 * transpose(a_0);
    // First derivatives extrapolated by the prescribed motion.
    let de = motion(b, variant) - motion(a, variant);
    let theta = motion(f, variant);
    var theta_0 = vec3<real>(real(0.0), real(0.0), real(0.0));
    var theta_1 = theta_0;
    if first.present {
        theta_0 = motion(program[links + 3u], variant);
    }
    if second.present {
        theta_1 = motion(program[links + 4u], variant);
    }
    let entry = offsets.station_segments_parts + 102u * k;
    set_part3(entry, variant, world + ee * de + theta * fe + theta_0 * q0_e + theta_1 * q1_e);
    set_part3(
        entry + 3u,
        variant,
        (cross3(p, v) + cross3(turned, p)) * s.l + fe * de + ff * theta + theta_0 * q0_f + theta_1 * q1_f,
    );
    set_part3(
        entry + 6u,
        variant,
        station_moment(first, -world, p, u, s.l) + q0_e * de + q0_f * theta + q0_q0 * theta_0 + theta_1 * q1_q0,
    );
    set_part3(
        entry + 9u,
        variant,
        station_moment(second, world, p, u, s.l) + q1_e * de + q1_f * theta + q1_q0 * theta_0 + q1_q1 * theta_1,
    );
    set_part33(entry + 12u, variant, ee);
    set_part33(entry + 21u, variant, fe);
    set_part33(entry + 30u, variant, ff);
    set_part33(entry + 39u, variant, q0_e);
    set_part33(entry + 48u, variant, q0_f);
    set_part33(entry + 57u, variant, q0_q0);
    set_part33(entry + 66u, variant, q1_e);
    set_part33(entry + 75u, variant, q1_f);
    set_part33(entry + 84u, variant, q1_q0);
    set_part33(entry + 93u, variant, q1_q1);
}
