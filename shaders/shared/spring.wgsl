#import algebra
#import bindings
#import coupling

// A spring at X = x + R(q) o, S = q ∘ rest: E = ½ k |X − X°|² − F·X + k_t (1 − d3(S)·d3(S°)) + bend and
// twist from S° to S over λ = 1 with C = k_f I.
struct Spring {
    rest: vec4<real>,
    offset: vec3<real>,
    k: real,
    tangent: real,
    frame: real,
    position: vec3<real>,
    orientation: vec4<real>,
    force: vec3<real>,
}

struct SpringLaw {
    // R(q).
    r: mat3x3<real>,
    energy: real,
    // ∂E/∂X, N, world.
    force: vec3<real>,
    // ∂E/∂θ of S, N m, in the frame S.
    moment: vec3<real>,
    // ∂²E/∂θ² of S.
    hessian: mat3x3<real>,
}

fn spring(k: u32, variant: u32) -> Spring {
    let entry = offsets.springs_numbers + 20u * k;
    return Spring(
        number4(entry, variant),
        number3(entry + 4u, variant),
        number(entry + 7u, variant),
        number(entry + 8u, variant),
        number(entry + 9u, variant),
        number3(entry + 10u, variant),
        number4(entry + 13u, variant),
        number3(entry + 17u, variant),
    );
}

fn spring_law(k: u32, trial: u32, variant: u32) -> SpringLaw {
    let s = spring(k, variant);
    let point = state_entry(program[offsets.springs_program + 2u * k], trial, variant);
    let variable = program[offsets.springs_program + 2u * k + 1u];
    let o = real(0.0);
    let x = value3(point, variant);
    let compensation = compensation3(point, variant);
    if variable == NONE {
        let gap = (x - s.position) + compensation;
        let energy = real(0.5) * s.k * dot3(gap, gap) - dot3(s.force, x);
        return SpringLaw(zero33(), energy, gap * s.k - s.force, vec3<real>(o, o, o), zero33());
    }
    let q = value4(state_entry(variable, trial, variant), variant);
    let r = rotation_matrix(q);
    let lever = r * s.offset;
    let gap = ((x - s.position) + compensation) + lever;
    let at = quaternion_product(q, s.rest);
    // ½ k_t |d3 − t|² = k_t (1 − d3·t), t in the frame S.
    let t = (rotation_matrix(s.orientation)[2]) * rotation_matrix(at);
    let c = Coupling(vec3<real>(s.frame, s.frame, s.frame), real(1.0), vec3<real>(o, o, o));
    let turn = bend_twist(s.orientation, at, c);
    let energy = real(0.5) * s.k * dot3(gap, gap) - dot3(s.force, x + lever) + s.tangent * (real(1.0) - t.z)
        + bend_twist_energy(turn, c);
    let e3 = vec3<real>(o, o, real(1.0));
    let te = outer(t, e3);
    let hessian = (identity(t.z) - (te + transpose(te)) * real(0.5)) * s.tangent + bend_twist_hessian(turn, c).bb;
    return SpringLaw(r, energy, gap * s.k - s.force, moment_on_second(turn) - cross3(e3, t) * s.tangent, hessian);
}
