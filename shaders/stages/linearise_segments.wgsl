#import segment

// Second derivatives of every segment at the current state: ∂²E/∂e² = R C Rᵀ/ℓ, ∂²E/∂θ∂e = ([v]ₓᵀ
// C + [n]ₓ) Rᵀ, ∂²E/∂θ² = ℓ ([v]ₓᵀ C [v]ₓ + sym(n vᵀ) − (n·v) I); and first derivatives
// extrapolated by the prescribed motion.
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
    let s = segment(k, variant);
    let links = offsets.segments_program + 3u * k;
    let a = program[links];
    let b = program[links + 1u];
    let f = program[links + 2u];
    let zero = unknown_zero(variant);
    let e = edge(state_entry(a, CURRENT, variant), state_entry(b, CURRENT, variant), variant, zero);
    let law = segment_law(s, e, value4(state_entry(f, CURRENT, variant), variant), zero);
    let c = diagonal(law.c);
    let rt = transpose(law.r);
    let vt = skew(-law.v);
    let ee = (law.r * c * rt) * (real(1.0) / s.l);
    let te = (vt * c + skew(law.n)) * rt;
    let nv = outer(law.n, law.v);
    let tt = (vt * c * skew(law.v) + (nv + transpose(nv)) * real(0.5) - identity(dot3(law.n, law.v))) * s.l;
    let de = motion(b, variant) - motion(a, variant);
    let theta = motion(f, variant);
    let entry = offsets.segments_parts + 33u * k;
    set_part3(entry, variant, law.r * law.n + ee * de + theta * te);
    set_part3(entry + 3u, variant, cross3(law.n, law.v) * s.l + te * de + tt * theta);
    set_part33(entry + 6u, variant, ee);
    set_part33(entry + 15u, variant, te);
    set_part33(entry + 24u, variant, tt);
}
