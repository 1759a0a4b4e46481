#import strain

// Stretch and shear of a segment without stations: Γ = Rᵀ e/ℓ − e3, v = Γ + e3, n = C Γ, E = ½ ℓ n·Γ. An
// edge that points against its frame (v3 < 0) has the stiffness B in addition to EA.
struct Segment {
    c: vec3<real>,
    l: real,
    exact_l: DoubleWord,
    inversion_stiffness: real,
}

struct SegmentLaw {
    r: mat3x3<real>,
    gamma: vec3<real>,
    v: vec3<real>,
    n: vec3<real>,
    // C at v.
    c: vec3<real>,
    // Contribution of B.
    inverted: real,
}

fn segment(k: u32, variant: u32) -> Segment {
    let entry = offsets.segments_numbers + 6u * k;
    let l = DoubleWord(number(entry + 3u, variant), number(entry + 4u, variant));
    return Segment(number3(entry, variant), l.hi + l.lo, l, number(entry + 5u, variant));
}

fn segment_law(s: Segment, e: Sum, q: vec4<real>, zero: u32) -> SegmentLaw {
    let r = rotation_matrix(q);
    let gamma = strain(r, e, s.exact_l, q, zero);
    let v = vec3<real>(gamma.xy, gamma.z + real(1.0));
    let inverted = select(real(0.0), s.inversion_stiffness, v.z < real(0.0));
    let n = vec3<real>(s.c.x * gamma.x, s.c.y * gamma.y, s.c.z * gamma.z + inverted * v.z);
    return SegmentLaw(r, gamma, v, n, vec3<real>(s.c.xy, s.c.z + inverted), inverted);
}

fn segment_energy(law: SegmentLaw, l: real) -> real {
    return real(0.5) * l * (dot3(law.n, law.gamma) + law.inverted * law.v.z);
}
