#import strain

// A segment with stations: Γ = u − e3 with B u = v, B = I − Σ β (I − R′) over the stations, R′ that of q̄ Q; otherwise
// as in segment.wgsl.

struct StationSegment {
    c: vec3<real>,
    l: real,
    exact_l: DoubleWord,
    inversion_stiffness: real,
}

// A station of the segment: whether it exists, the independent frame that carries it, its matrix R, rest and offset in
// that frame, β, and β (I − R′).
struct Station {
    present: bool,
    r: mat3x3<real>,
    rest: vec4<real>,
    offset: vec3<real>,
    blend: real,
    lack: mat3x3<real>,
}

struct StationLaw {
    r: mat3x3<real>,
    v: vec3<real>,
    n: vec3<real>,
    c: vec3<real>,
    inverted: real,
    gamma: vec3<real>,
    u: vec3<real>,
    inverse: mat3x3<real>,
}

fn station_segment(k: u32, variant: u32) -> StationSegment {
    let entry = offsets.station_segments_numbers + 22u * k;
    let l = DoubleWord(number(entry + 3u, variant), number(entry + 4u, variant));
    return StationSegment(number3(entry, variant), l.hi + l.lo, l, number(entry + 5u, variant));
}

// The station at end 0 or 1 of segment k, whose frame is q; `trial`: slot of the state.
fn station(k: u32, end: u32, q: vec4<real>, trial: u32, variant: u32) -> Station {
    let variable = program[offsets.station_segments_program + 5u * k + 3u + end];
    let o = real(0.0);
    let zero = vec3<real>(o, o, o);
    if variable == NONE {
        return Station(false, zero33(), vec4<real>(o, o, o, o), zero, o, zero33());
    }
    let entry = offsets.station_segments_numbers + 22u * k + 6u + 8u * end;
    let carrier = value4(state_entry(variable, trial, variant), variant);
    let rest = number4(entry, variant);
    let turn = relative(q, quaternion_product(carrier, rest));
    let blend = number(entry + 7u, variant);
    // R′ = I + 2 w [v]ₓ + 2 [v]ₓ²
    let across = skew(turn.xyz);
    let lack = (across * turn.w + across * across) * (real(-2.0) * blend);
    return Station(
        true,
        rotation_matrix(carrier),
        rest,
        number3(entry + 4u, variant),
        blend,
        lack,
    );
}

fn station_law(s: StationSegment, e: Sum, q: vec4<real>, first: Station, second: Station, zero: u32) -> StationLaw {
    let r = rotation_matrix(q);
    let straight = strain(r, e, s.exact_l, q, zero);
    let v = vec3<real>(straight.xy, straight.z + real(1.0));
    let lack = first.lack + second.lack;
    let inverse = inverse33(identity(real(1.0)) - lack);
    // Γ = B⁻¹ (v − B e3), without the difference of u and e3.
    let gamma = inverse * (straight + lack[2]);
    let u = vec3<real>(gamma.xy, gamma.z + real(1.0));
    let inverted = select(real(0.0), s.inversion_stiffness, gamma.z < real(-1.0));
    let n = vec3<real>(s.c.x * gamma.x, s.c.y * gamma.y, s.c.z * gamma.z + inverted * (gamma.z + real(1.0)));
    return StationLaw(r, v, n, vec3<real>(s.c.xy, s.c.z + inverted), inverted, gamma, u, inverse);
}

fn station_energy(law: StationLaw, l: real) -> real {
    return real(0.5) * l * (dot3(law.n, law.gamma) + law.inverted * (law.gamma.z + real(1.0)));
}

// p = B⁻ᵀ n, the force conjugate to v.
fn conjugate_force(law: StationLaw) -> vec3<real> {
    return law.n * law.inverse;
}

// β R′.
fn station_turn(s: Station) -> mat3x3<real> {
    return identity(s.blend) - s.lack;
}

// Moment on a station, in the body frame of its carrier: the lever of the force on the end (world), and ℓ z × u with
// z = β R′ᵀ p.
fn station_moment(s: Station, force: vec3<real>, p: vec3<real>, u: vec3<real>, l: real) -> vec3<real> {
    let own = cross3(p * station_turn(s), u) * l;
    return cross3(s.offset, force * s.r) + rotation_matrix(s.rest) * own;
}
