#import algebra
#import bindings

// Bending and twist between the frames q_a ∘ rest_a and q_b ∘ rest_b: (w ≥ 0, v) of q̄_a q_b, κ = (2/λ)(1 + |v|²/6) v,
// m = C (κ − κ°), E = ½ λ m·(κ − κ°).
struct Coupling {
    c: vec3<real>,
    lambda: real,
    k0: vec3<real>,
}

struct BendTwist {
    w: real,
    v: vec3<real>,
    moment: vec3<real>,
    strain: vec3<real>,
    // ½ ∂E/∂v = G m, G = (1 + |v|²/6) I + v vᵀ/3.
    half_mu: vec3<real>,
}

fn bend_twist(qa: vec4<real>, qb: vec4<real>, c: Coupling) -> BendTwist {
    let r = relative(qa, qb);
    let v = r.xyz;
    let g = real(1.0) + dot3(v, v) / real(6.0);
    let strain = v * (real(2.0) * g / c.lambda) - c.k0;
    let moment = c.c * strain;
    let half_mu = moment * g + v * (dot3(v, moment) / real(3.0));
    return BendTwist(r.w, v, moment, strain, half_mu);
}

fn bend_twist_energy(law: BendTwist, c: Coupling) -> real {
    return real(0.5) * c.lambda * dot3(law.moment, law.strain);
}

// −½(w μ + v × μ)
fn moment_on_first(law: BendTwist) -> vec3<real> {
    return -(law.half_mu * law.w + cross3(law.v, law.half_mu));
}

// ½(w μ − v × μ)
fn moment_on_second(law: BendTwist) -> vec3<real> {
    return law.half_mu * law.w - cross3(law.v, law.half_mu);
}

struct CouplingHessian {
    aa: mat3x3<real>,
    ab: mat3x3<real>,
    bb: mat3x3<real>,
}

// With J_b = ½(w I + [v]ₓ), J_a = −J_bᵀ, K = ∂²E/∂v² = (4/λ) G C G + ⅔ ((m·v) I + m vᵀ + v mᵀ):
// J_aᵀ K J_a − ¼(μ·v) I, J_aᵀ K J_b + ¼(v μᵀ + μ vᵀ + w [μ]ₓ − (μ·v) I), J_bᵀ K J_b − ¼(μ·v) I.
fn bend_twist_hessian(law: BendTwist, c: Coupling) -> CouplingHessian {
    let w = law.w;
    let v = law.v;
    let m = law.moment;
    let g = real(1.0) + dot3(v, v) / real(6.0);
    let cv = c.c * v;
    let y = (cv * (g / real(3.0)) + v * (dot3(cv, v) / real(18.0))) * (real(4.0) / c.lambda)
        + m * (real(2.0) / real(3.0));
    let vy = outer(v, y);
    let k = diagonal(c.c * (real(4.0) * g * g / c.lambda)) + identity(dot3(m, v) * (real(2.0) / real(3.0)))
        + vy + transpose(vy);
    // A = [v]ₓ K, B = [v]ₓ K [v]ₓ: 4 J K Jᵀ = w² K − B + w (A + Aᵀ), 4 Jᵀ K J = w² K − B − w (A +
    // Aᵀ),
    // 4 J K J = w² K + B + w (A − Aᵀ).
    let a = skew(v) * k;
    let b = (a * skew(v)) * real(0.25);
    let at = transpose(a);
    let kw = k * (real(0.25) * w * w);
    let sum = (a + at) * (real(0.25) * w);
    let difference = (a - at) * (real(0.25) * w);
    let mu = law.half_mu;
    let own = identity(real(-0.5) * dot3(mu, v));
    let vm = outer(v, mu) * real(0.5);
    let mixed = vm + transpose(vm) + skew(mu) * (real(0.5) * w) + own;
    let both = kw - b + own;
    return CouplingHessian(both + sum, mixed - kw - b - difference, both - sum);
}
