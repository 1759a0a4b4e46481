#import strain

// A segment with stations: Γ = v + v × φ − e3 with φ = Σ 2 β w v over the stations, (w, v) = q̄ Q; otherwise
// as in segment.wgsl.

struct StationSegment {
    c: vec3<real>,
    l: real,
    exact_l: DoubleWord,
    inversion_stiffness: real,
}

// A station of the segment: whether it exists, the independent frame that carries it, its matrix R, rest and offset in
// that frame, β, and (w, v) of the rotation from the segment to the station.
struct Station {
    present: bool,
    r: mat3x3<real>,
    rest: vec4<real>,
    offset: vec3<real>,
    blend: real,
    w: real,
    v: vec3<real>,
}

struct StationLaw {
    r: mat3x3<real>,
    v: vec3<real>,
    n: vec3<real>,
    c: vec3<real>,
    inverted: real,
    gamma: vec3<real>,
    phi: vec3<real>,
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
        return Station(false, zero33(), vec4<real>(o, o, o, o), zero, o, o, zero);
    }
    let entry = offsets.station_segments_numbers + 22u * k + 6u + 8u * end;
    let carrier = value4(state_entry(variable, trial, variant), variant);
    let rest = number4(entry, variant);
    let turn = relative(q, quaternion_product(carrier, rest));
    return Station(
        true,
        rotation_matrix(carrier),
        rest,
        number3(entry + 4u, variant),
        number(entry + 7u, variant),
        turn.w,
        turn.xyz,
    );
}

fn station_law(s: StationSegment, e: Sum, q: vec4<real>, first: Station, second: Station, opaque: bool) -> StationLaw {
    let r = rotation_matrix(q);
    let straight = strain(r, e, s.exact_l, q, opaque);
    let v = vec3<real>(straight.xy, straight.z + real(1.0));
    let phi = first.v * (real(2.0) * first.blend * first.w) + second.v * (real(2.0) * second.blend * second.w);
    let gamma = straight + cross3(v, phi);
    let inverted = select(real(0.0), s.inversion_stiffness, gamma.z < real(-1.0));
    let n = vec3<real>(s.c.x * gamma.x, s.c.y * gamma.y, s.c.z * gamma.z + inverted * (gamma.z + real(1.0)));
    return StationLaw(r, v, n, vec3<real>(s.c.xy, s.c.z + inverted), inverted, gamma, phi);
}

fn station_energy(law: StationLaw, l: real) -> real {
    return real(0.5) * l * (dot3(law.n, law.gamma) + law.inverted * (law.gamma.z + real(1.0)));
}

// ∂φ/∂θ of the segment over β: −(w (w I − [v]ₓ) − v vᵀ)
fn segment_rotation_jacobian(w: real, v: vec3<real>) -> mat3x3<real> {
    return outer(v, v) + skew(v) * w - identity(w * w);
}

// ∂φ/∂θ of the station over β: w (w I + [v]ₓ) − v vᵀ
fn station_rotation_jacobian(w: real, v: vec3<real>) -> mat3x3<real> {
    return identity(w * w) + skew(v) * w - outer(v, v);
}

// n′ = n + φ × n, the force conjugate to v.
fn conjugate_force(law: StationLaw) -> vec3<real> {
    return law.n + cross3(law.phi, law.n);
}

// Moment on a station, in the body frame of its carrier: the lever of the force on the end (world) and the moment μ
// through φ.
fn station_moment(s: Station, force: vec3<real>, mu: vec3<real>) -> vec3<real> {
    let own = (mu * station_rotation_jacobian(s.w, s.v)) * s.blend;
    return cross3(s.offset, force * s.r) + rotation_matrix(s.rest) * own;
}
