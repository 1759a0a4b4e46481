#import algebra
#import bindings

// Stretch and shear of one segment away from stations: v = Rᵀ e/ℓ, Γ = v − e3, n = C Γ, E = ½ ℓ n·Γ; an edge that points against its
// frame meets B besides EA.
struct Segment {
    c: vec3<real>,
    l: real,
    overturned: real,
}

struct SegmentLaw {
    r: mat3x3<real>,
    v: vec3<real>,
    n: vec3<real>,
    // C at v.
    c: vec3<real>,
    // What of it B is responsible for.
    beyond: real,
}

fn segment(k: u32, variant: u32) -> Segment {
    let entry = places.segments_numbers + 5u * k;
    return Segment(number3(entry, variant), number(entry + 3u, variant), number(entry + 4u, variant));
}

fn segment_law(s: Segment, e: vec3<real>, q: vec4<real>) -> SegmentLaw {
    let r = rotation_matrix(q);
    let v = (e * r) * (real(1.0) / s.l);
    let beyond = select(real(0.0), s.overturned, v.z < real(0.0));
    let n = vec3<real>(s.c.x * v.x, s.c.y * v.y, s.c.z * (v.z - real(1.0)) + beyond * v.z);
    return SegmentLaw(r, v, n, vec3<real>(s.c.xy, s.c.z + beyond), beyond);
}

fn segment_energy(law: SegmentLaw, l: real) -> real {
    let n = law.n;
    let v = law.v;
    return real(0.5) * l * (n.x * v.x + n.y * v.y + n.z * (v.z - real(1.0)) + law.beyond * v.z);
}
