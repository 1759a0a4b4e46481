use super::shared::algebra::{diagonal, identity, lever_hessian, outer, rotation_matrix, skew};
use super::shared::station_segment::{
    Station, conjugate_force, segment_rotation_jacobian, station, station_law, station_moment,
    station_rotation_jacobian, station_segment,
};
use crate::layout::Range;
use crate::memory::{Matrix, Memory, Vector};

/// Second derivatives of μ·φ with respect to the rotation of the segment, both rotations (rows: segment, columns:
/// station), and that of the station.
struct TurnHessian {
    segment: Matrix,
    mixed: Matrix,
    station: Matrix,
}

/// φ = 2 β w v: with a = −½(w μ + v × μ), b = ½(w μ − v × μ), m = μ·v they are, divided by
/// β, −w m I + v aᵀ + a vᵀ, ½ w (v μᵀ + μ vᵀ + w \[μ\]ₓ) + v bᵀ − a vᵀ + ½ m \[v\]ₓ and −w
/// m I − v bᵀ − b vᵀ.
fn turn_hessian(s: &Station, force: &Vector) -> TurnHessian {
    let mu = force * s.blend;
    let (w, v) = (s.w, &s.v);
    let along = mu * w;
    let across = v.cross(&mu);
    let m = mu.dot(v);
    let va = outer(v, &((along + across) * -0.5));
    let vb = outer(v, &((along - across) * 0.5));
    let vmu = outer(v, &mu);
    let own = identity(-w * m);
    TurnHessian {
        segment: own + va + va.transpose(),
        mixed: (vmu + vmu.transpose() + skew(&mu) * w) * (0.5 * w) + vb - va.transpose() + skew(v) * (0.5 * m),
        station: own - vb - vb.transpose(),
    }
}

/// Second derivatives of every segment with stations: ℓ Jᵀ C J with J = ∂Γ, those of ℓ n′·v with respect to
/// (e, θ), of μ·φ with respect to (θ, θ_Q), and twice ℓ n·(δv × δφ).
pub(crate) fn linearise_station_segments(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let s = station_segment(m, k, variant);
    let links = m.offsets.station_segments_program as usize + 5 * k;
    let [a, b, f] = [0, 1, 2].map(|i| m.word(links + i) as usize);
    let q = m.value4(m.state_entry(f, 0, variant), variant);
    let first = station(m, k, 0, &q, 0, variant);
    let second = station(m, k, 1, &q, 0, variant);
    let nodes = m.edge(m.state_entry(a, 0, variant), m.state_entry(b, 0, variant), variant);
    let e = nodes + (second.r * second.offset - first.r * first.offset);
    let law = station_law(&s, &e, &q, &first, &second);
    let (n, v) = (&law.n, &law.v);
    let rt = law.r.transpose();
    let along_v = identity(1.0) - skew(&law.phi);
    let along_phi = skew(v);
    // ∂v and ∂φ with respect to the edge, the segment and both stations.
    let dv_e = rt * (1.0 / s.l);
    let dphi_f = segment_rotation_jacobian(first.w, &first.v) * first.blend
        + segment_rotation_jacobian(second.w, &second.v) * second.blend;
    let dphi_0 = station_rotation_jacobian(first.w, &first.v) * first.blend;
    let dphi_1 = station_rotation_jacobian(second.w, &second.v) * second.blend;
    // ∂Γ.
    let g_e = along_v * dv_e;
    let g_f = along_v * skew(v) + along_phi * dphi_f;
    let g_0 = along_phi * dphi_0;
    let g_1 = along_phi * dphi_1;
    // a·([n]ₓᵀ b) = n·(a × b), and C: factors of ∂Γ, ∂v and ∂φ.
    let c = diagonal(&law.c);
    let nt = -skew(n);
    let force = conjugate_force(&law);
    let mu = n.cross(v) * s.l;
    let h0 = turn_hessian(&first, &mu);
    let h1 = turn_hessian(&second, &mu);
    let fv = outer(&force, v);
    let ee = g_e.transpose() * c * g_e * s.l;
    let fe = (g_f.transpose() * c * g_e - dphi_f.transpose() * nt * dv_e) * s.l + skew(&force) * rt;
    let ff = (g_f.transpose() * c * g_f + skew(v).transpose() * nt * dphi_f - dphi_f.transpose() * nt * skew(v)) * s.l
        + ((fv + fv.transpose()) * 0.5 - identity(force.dot(v))) * s.l
        + h0.segment
        + h1.segment;
    let e_0 = (g_0.transpose() * c * g_e - dphi_0.transpose() * nt * dv_e) * s.l;
    let e_1 = (g_1.transpose() * c * g_e - dphi_1.transpose() * nt * dv_e) * s.l;
    let f_0 = (g_0.transpose() * c * g_f - dphi_0.transpose() * nt * skew(v)) * s.l + h0.mixed.transpose();
    let f_1 = (g_1.transpose() * c * g_f - dphi_1.transpose() * nt * skew(v)) * s.l + h1.mixed.transpose();
    let s_00 = g_0.transpose() * c * g_0 * s.l + h0.station;
    let s_11 = g_1.transpose() * c * g_1 * s.l + h1.station;
    let s_10 = g_1.transpose() * c * g_0 * s.l;
    // With respect to the carriers of the stations: θ = Aᵀ θ_Q, and ∂e/∂θ_Q = ± R [o]ₓ.
    let world = law.r * force;
    let a_0 = rotation_matrix(&first.rest);
    let a_1 = rotation_matrix(&second.rest);
    let l_0 = first.r * skew(&first.offset);
    let l_1 = -(second.r * skew(&second.offset));
    let q0_e = l_0.transpose() * ee + a_0 * e_0;
    let q1_e = l_1.transpose() * ee + a_1 * e_1;
    let q0_f = l_0.transpose() * fe.transpose() + a_0 * f_0;
    let q1_f = l_1.transpose() * fe.transpose() + a_1 * f_1;
    let across_0 = a_0 * e_0 * l_0;
    let across_1 = a_1 * e_1 * l_1;
    let q0_q0 = l_0.transpose() * ee * l_0
        + across_0
        + across_0.transpose()
        + a_0 * s_00 * a_0.transpose()
        + lever_hessian(&first.r, &-world, &first.offset);
    let q1_q1 = l_1.transpose() * ee * l_1
        + across_1
        + across_1.transpose()
        + a_1 * s_11 * a_1.transpose()
        + lever_hessian(&second.r, &world, &second.offset);
    let q1_q0 = l_1.transpose() * ee * l_0
        + a_1 * e_1 * l_0
        + l_1.transpose() * e_0.transpose() * a_0.transpose()
        + a_1 * s_10 * a_0.transpose();
    // First derivatives extrapolated by the prescribed motion.
    let through = dphi_f.tr_mul(&mu);
    let de = m.motion(b, variant) - m.motion(a, variant);
    let theta = m.motion(f, variant);
    let motion = |present: bool, link: usize| -> Vector {
        if present { m.motion(m.word(links + link) as usize, variant) } else { Vector::zeros() }
    };
    let theta_0 = motion(first.present, 3);
    let theta_1 = motion(second.present, 4);
    let entry = m.offsets.station_segments_parts as usize + 102 * k;
    let on_edge = world + ee * de + fe.tr_mul(&theta) + q0_e.tr_mul(&theta_0) + q1_e.tr_mul(&theta_1);
    let on_frame =
        force.cross(v) * s.l + through + fe * de + ff * theta + q0_f.tr_mul(&theta_0) + q1_f.tr_mul(&theta_1);
    let on_first =
        station_moment(&first, &-world, &mu) + q0_e * de + q0_f * theta + q0_q0 * theta_0 + q1_q0.tr_mul(&theta_1);
    let on_second = station_moment(&second, &world, &mu) + q1_e * de + q1_f * theta + q1_q0 * theta_0 + q1_q1 * theta_1;
    for (k, g) in [on_edge, on_frame, on_first, on_second].iter().enumerate() {
        m.set_part3(entry + 3 * k, variant, g);
    }
    for (k, h) in [ee, fe, ff, q0_e, q0_f, q0_q0, q1_e, q1_f, q1_q0, q1_q1].iter().enumerate() {
        m.set_part33(entry + 12 + 9 * k, variant, h);
    }
}
