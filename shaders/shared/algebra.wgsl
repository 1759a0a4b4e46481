// Vectors, matrices and rotations, from operations that every device computes alike: sums, products, quotients and
// square roots. Quaternions are (x, y, z, w).

fn cross3(a: vec3<real>, b: vec3<real>) -> vec3<real> {
    return vec3<real>(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

fn dot3(a: vec3<real>, b: vec3<real>) -> real {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Maximum that propagates NaN.
fn larger(a: real, b: real) -> real {
    return select(b, a, a >= b);
}

// a bᵀ
fn outer(a: vec3<real>, b: vec3<real>) -> mat3x3<real> {
    return mat3x3<real>(a * b.x, a * b.y, a * b.z);
}

fn diagonal(c: vec3<real>) -> mat3x3<real> {
    let o = real(0.0);
    return mat3x3<real>(vec3<real>(c.x, o, o), vec3<real>(o, c.y, o), vec3<real>(o, o, c.z));
}

fn identity(a: real) -> mat3x3<real> {
    return diagonal(vec3<real>(a, a, a));
}

fn zero33() -> mat3x3<real> {
    return identity(real(0.0));
}

// [a]ₓ
fn skew(a: vec3<real>) -> mat3x3<real> {
    let o = real(0.0);
    return mat3x3<real>(vec3<real>(o, a.z, -a.y), vec3<real>(-a.z, o, a.x), vec3<real>(a.y, -a.x, o));
}

// By the cross products of its columns.
fn inverse33(m: mat3x3<real>) -> mat3x3<real> {
    let bc = cross3(m[1], m[2]);
    let rows = mat3x3<real>(bc, cross3(m[2], m[0]), cross3(m[0], m[1]));
    return transpose(rows) * (real(1.0) / dot3(m[0], bc));
}

// sym(a bᵀ) − (a·b) I
fn symmetric_outer(a: vec3<real>, b: vec3<real>) -> mat3x3<real> {
    let twice = outer(a, b);
    return (twice + transpose(twice)) * real(0.5) - identity(dot3(a, b));
}

// R(q), the quadratic form.
fn rotation_matrix(q: vec4<real>) -> mat3x3<real> {
    let x2 = q.x + q.x;
    let y2 = q.y + q.y;
    let z2 = q.z + q.z;
    let xx = q.x * x2;
    let yy = q.y * y2;
    let zz = q.z * z2;
    let xy = q.x * y2;
    let xz = q.x * z2;
    let yz = q.y * z2;
    let wx = q.w * x2;
    let wy = q.w * y2;
    let wz = q.w * z2;
    let one = real(1.0);
    return mat3x3<real>(
        vec3<real>(one - (yy + zz), xy + wz, xz - wy),
        vec3<real>(xy - wz, one - (xx + zz), yz + wx),
        vec3<real>(xz + wy, yz - wx, one - (xx + yy)),
    );
}

// p ∘ q
fn quaternion_product(p: vec4<real>, q: vec4<real>) -> vec4<real> {
    return vec4<real>(q.xyz * p.w + p.xyz * q.w + cross3(p.xyz, q.xyz), p.w * q.w - dot3(p.xyz, q.xyz));
}

// q̄_a q_b, with the sign that makes w ≥ 0.
fn relative(a: vec4<real>, b: vec4<real>) -> vec4<real> {
    let w = a.w * b.w + dot3(a.xyz, b.xyz);
    let r = vec4<real>(b.xyz * a.w - a.xyz * b.w - cross3(a.xyz, b.xyz), w);
    return select(r, -r, w < real(0.0));
}

fn normalised(q: vec4<real>) -> vec4<real> {
    return q * (real(1.0) / sqrt(dot3(q.xyz, q.xyz) + q.w * q.w));
}

// q ∘ cay(θ)
fn rotated(q: vec4<real>, theta: vec3<real>) -> vec4<real> {
    let h = theta * real(0.5);
    return normalised(vec4<real>(q.xyz + h * q.w + cross3(q.xyz, h), q.w - dot3(q.xyz, h)));
}

// Second derivative with respect to θ of `force · R exp(θ) offset`, with f = Rᵀ force: sym(f oᵀ) − (f·o) I.
fn lever_hessian(r: mat3x3<real>, force: vec3<real>, offset: vec3<real>) -> mat3x3<real> {
    let f = force * r;
    let dw_double = outer(f, offset);
    return (dw_double + transpose(dw_double)) * real(0.5) - identity(dot3(f, offset));
}
