use super::shared::algebra::{diagonal, identity, outer, skew};
use super::shared::segment::{segment, segment_law};
use crate::layout::Range;
use crate::memory::Memory;

/// Second derivatives of every segment at the current state: ∂²E/∂e² = R C Rᵀ/ℓ, ∂²E/∂θ∂e =
/// (\[v\]ₓᵀ C + \[n\]ₓ) Rᵀ, ∂²E/∂θ² = ℓ (\[v\]ₓᵀ C \[v\]ₓ + sym(n vᵀ) − (n·v) I); and first
/// derivatives extrapolated by the prescribed motion.
pub(crate) fn linearise_segments(m: &mut Memory, _: &Range, k: usize, variant: usize) {
    let s = segment(m, k, variant);
    let links = m.offsets.segments_program as usize + 3 * k;
    let [a, b, f] = [0, 1, 2].map(|i| m.word(links + i) as usize);
    let e = m.edge(m.state_entry(a, 0, variant), m.state_entry(b, 0, variant), variant);
    let law = segment_law(&s, &e, &m.value4(m.state_entry(f, 0, variant), variant));
    let c = diagonal(&law.c);
    let rt = law.r.transpose();
    let vt = -skew(&law.v);
    let ee = (law.r * c * rt) * (1.0 / s.l);
    let te = (vt * c + skew(&law.n)) * rt;
    let nv = outer(&law.n, &law.v);
    let tt = (vt * c * skew(&law.v) + (nv + nv.transpose()) * 0.5 - identity(law.n.dot(&law.v))) * s.l;
    let de = m.motion(b, variant) - m.motion(a, variant);
    let theta = m.motion(f, variant);
    let entry = m.offsets.segments_parts as usize + 33 * k;
    m.set_part3(entry, variant, &(law.r * law.n + ee * de + te.tr_mul(&theta)));
    m.set_part3(entry + 3, variant, &(law.n.cross(&law.v) * s.l + te * de + tt * theta));
    m.set_part33(entry + 6, variant, &ee);
    m.set_part33(entry + 15, variant, &te);
    m.set_part33(entry + 24, variant, &tt);
}
