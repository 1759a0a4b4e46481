use super::shared::algebra::{diagonal, lever_hessian, rotation_matrix, skew, symmetric_outer};
use super::shared::station_segment::{
    conjugate_force, station, station_law, station_moment, station_segment, station_turn,
};
use crate::layout::Range;
use crate::memory::{Memory, Vector};

/// Second derivatives of every segment with stations: ℓ Jᵀ C J with J = ∂u, those of ℓ p·v with respect to (e, θ) at
/// fixed p, −ℓ (L J + Jᵀ Lᵀ) with δᵀ L w = p·δB w, and those of −ℓ p·exp(−θ) β R′ exp(θ_Q) u at fixed u.
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
    let (v, u) = (&law.v, &law.u);
    let p = conjugate_force(&law);
    let rt = law.r.transpose();
    let t_0 = station_turn(&first);
    let t_1 = station_turn(&second);
    let turned = (t_0 + t_1) * u;
    // ∂u with respect to the edge, the segment and both stations.
    let g_e = law.inverse * rt * (1.0 / s.l);
    let g_f = law.inverse * (skew(v) - skew(&turned));
    let g_0 = law.inverse * t_0 * skew(u);
    let g_1 = law.inverse * t_1 * skew(u);
    // L.
    let b_f = skew(&p) * (t_0 + t_1);
    let b_0 = -skew(&t_0.tr_mul(&p));
    let b_1 = -skew(&t_1.tr_mul(&p));
    let c = diagonal(&law.c);
    let ee = g_e.transpose() * c * g_e * s.l;
    let fe = (g_f.transpose() * c - b_f) * g_e * s.l + skew(&p) * rt;
    let bent = b_f * g_f;
    let ff = (g_f.transpose() * c * g_f - bent - bent.transpose() + symmetric_outer(&p, &(v - turned))) * s.l;
    let e_0 = (g_0.transpose() * c - b_0) * g_e * s.l;
    let e_1 = (g_1.transpose() * c - b_1) * g_e * s.l;
    let along = skew(&p) * t_0 * skew(u);
    let f_0 = ((g_0.transpose() * c - b_0) * g_f - (b_f * g_0).transpose() + along.transpose()) * s.l;
    let beyond = skew(&p) * t_1 * skew(u);
    let f_1 = ((g_1.transpose() * c - b_1) * g_f - (b_f * g_1).transpose() + beyond.transpose()) * s.l;
    let own_0 = b_0 * g_0;
    let s_00 = (g_0.transpose() * c * g_0 - own_0 - own_0.transpose() - symmetric_outer(&t_0.tr_mul(&p), u)) * s.l;
    let own_1 = b_1 * g_1;
    let s_11 = (g_1.transpose() * c * g_1 - own_1 - own_1.transpose() - symmetric_outer(&t_1.tr_mul(&p), u)) * s.l;
    let s_10 = ((g_1.transpose() * c - b_1) * g_0 - (b_0 * g_1).transpose()) * s.l;
    // With respect to the carriers of the stations: θ = Aᵀ θ_Q, and ∂e/∂θ_Q = ± R [o]ₓ.
    let world = law.r * p;
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
        (p.cross(v) + turned.cross(&p)) * s.l + fe * de + ff * theta + q0_f.tr_mul(&theta_0) + q1_f.tr_mul(&theta_1);
    let on_first = station_moment(&first, &-world, &p, u, s.l)
        + q0_e * de
        + q0_f * theta
        + q0_q0 * theta_0
        + q1_q0.tr_mul(&theta_1);
    let on_second =
        station_moment(&second, &world, &p, u, s.l) + q1_e * de + q1_f * theta + q1_q0 * theta_0 + q1_q1 * theta_1;
    for (k, g) in [on_edge, on_frame, on_first, on_second].iter().enumerate() {
        m.set_part3(entry + 3 * k, variant, g);
    }
    for (k, h) in [ee, fe, ff, q0_e, q0_f, q0_q0, q1_e, q1_f, q1_q0, q1_q1].iter().enumerate() {
        m.set_part33(entry + 12 + 9 * k, variant, h);
    }
}
