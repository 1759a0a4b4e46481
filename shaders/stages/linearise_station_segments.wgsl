#import station_segment

// Second derivatives of μ·φ with respect to the rotation of the segment, both rotations (rows: segment, columns:
// station), and that of the station.
struct TurnHessian {
    segment: mat3x3<real>,
    mixed: mat3x3<real>,
    station: mat3x3<real>,
}

// φ = 2 β w v: with a = −½(w μ + v × μ), b = ½(w μ − v × μ), m = μ·v they are, divided by β,
// −w m I + v aᵀ + a vᵀ, ½ w (v μᵀ + μ vᵀ + w [μ]ₓ) + v bᵀ − a vᵀ + ½ m [v]ₓ and −w m I − v
// bᵀ − b vᵀ.
fn turn_hessian(s: Station, force: vec3<real>) -> TurnHessian {
    let mu = force * s.blend;
    let v = s.v;
    let w = s.w;
    let along = mu * w;
    let across = cross3(v, mu);
    let m = dot3(mu, v);
    let va = outer(v, (along + across) * real(-0.5));
    let vb = outer(v, (along - across) * real(0.5));
    let vmu = outer(v, mu);
    let own = identity(-w * m);
    return TurnHessian(
        own + va + transpose(va),
        (vmu + transpose(vmu) + skew(mu) * w) * (real(0.5) * w) + vb - transpose(va) + skew(v) * (real(0.5) * m),
        own - vb - transpose(vb),
    );
}

// Second derivatives of every segment with stations: ℓ Jᵀ C J with J = ∂Γ, those of ℓ n′·v with respect to
// (e, θ), of μ·φ with respect to (θ, θ_Q), and twice ℓ n·(δv × δφ).
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
    let opaque = opaque_true(variant);
    let nodes = edge(state_entry(a, CURRENT, variant), state_entry(b, CURRENT, variant), variant, opaque);
    let e = two_sum(nodes.sum, nodes.error, second.r * second.offset - first.r * first.offset, opaque);
    let law = station_law(s, e, q, first, second, opaque);
    let n = law.n;
    let v = law.v;
    let rt = transpose(law.r);
    let along_v = identity(real(1.0)) - skew(law.phi);
    let along_phi = skew(v);
    // ∂v and ∂φ with respect to the edge, the segment and both stations.
    let dv_e = rt * (real(1.0) / s.l);
    let dphi_f = segment_rotation_jacobian(first.w, first.v) * first.blend
        + segment_rotation_jacobian(second.w, second.v) * second.blend;
    let dphi_0 = station_rotation_jacobian(first.w, first.v) * first.blend;
    let dphi_1 = station_rotation_jacobian(second.w, second.v) * second.blend;
    // ∂Γ.
    let g_e = along_v * dv_e;
    let g_f = along_v * skew(v) + along_phi * dphi_f;
    let g_0 = along_phi * dphi_0;
    let g_1 = along_phi * dphi_1;
    // a·([n]ₓᵀ b) = n·(a × b), and C: factors of ∂Γ, ∂v and ∂φ.
    let c = diagonal(law.c);
    let nt = skew(-n);
    let force = conjugate_force(law);
    let mu = cross3(n, v) * s.l;
    let zero = zero33();
    let h0 = turn_hessian(first, mu);
    let h1 = turn_hessian(second, mu);
    let fv = outer(force, v);
    let ee = transpose(g_e) * c * g_e * s.l;
    let fe = (transpose(g_f) * c * g_e - transpose(dphi_f) * nt * dv_e) * s.l + skew(force) * rt;
    let ff = (transpose(g_f) * c * g_f + transpose(skew(v)) * nt * dphi_f - transpose(dphi_f) * nt * skew(v)) * s.l
        + ((fv + transpose(fv)) * real(0.5) - identity(dot3(force, v))) * s.l + h0.segment + h1.segment;
    let e_0 = (transpose(g_0) * c * g_e - transpose(dphi_0) * nt * dv_e) * s.l;
    let e_1 = (transpose(g_1) * c * g_e - transpose(dphi_1) * nt * dv_e) * s.l;
    let f_0 = (transpose(g_0) * c * g_f - transpose(dphi_0) * nt * skew(v)) * s.l + transpose(h0.mixed);
    let f_1 = (transpose(g_1) * c * g_f - transpose(dphi_1) * nt * skew(v)) * s.l + transpose(h1.mixed);
    let s_00 = transpose(g_0) * c * g_0 * s.l + h0.station;
    let s_11 = transpose(g_1) * c * g_1 * s.l + h1.station;
    let s_10 = transpose(g_1) * c * g_0 * s.l;
    // With respect to the carriers of the stations: θ = Aᵀ θ_Q, and ∂e/∂θ_Q = ± R [o]ₓ.
    let world = law.r * force;
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
    let through = mu * dphi_f;
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
        cross3(force, v) * s.l + through + fe * de + ff * theta + theta_0 * q0_f + theta_1 * q1_f,
    );
    set_part3(
        entry + 6u,
        variant,
        station_moment(first, -world, mu) + q0_e * de + q0_f * theta + q0_q0 * theta_0 + theta_1 * q1_q0,
    );
    set_part3(
        entry + 9u,
        variant,
        station_moment(second, world, mu) + q1_e * de + q1_f * theta + q1_q0 * theta_0 + q1_q1 * theta_1,
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
