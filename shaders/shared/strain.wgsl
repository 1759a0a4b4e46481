#import algebra
#import exact

// The edge between two points of the state at entries a and b, free of the round-off of large coordinates.
fn edge(a: u32, b: u32, variant: u32, on: bool) -> Sum {
    let zero = vec3<real>(real(0.0), real(0.0), real(0.0));
    let apart = add_exactly(value3(b, variant), zero, -value3(a, variant), on);
    return add_exactly(apart.sum, apart.error, carry3(b, variant) - carry3(a, variant), on);
}

// Γ = Rᵀ (e/ℓ − d3), with the difference, which is small where e/ℓ and d3 are not, to twice the digits:
// (|q|² e − ℓ d)/(ℓ |q|²) with d = |q|² d3, so that what q lacks of length 1 does not count.
fn strain(r: mat3x3<real>, e: Sum, l: Two, q: vec4<real>, on: bool) -> vec3<real> {
    let xx = multiply(q.x, q.x, on);
    let yy = multiply(q.y, q.y, on);
    let zz = multiply(q.z, q.z, on);
    let ww = multiply(q.w, q.w, on);
    let across = add_two(xx, yy, on);
    let along = add_two(zz, ww, on);
    let size = add_two(across, along, on);
    let x = twice(add_two(multiply(q.x, q.z, on), multiply(q.w, q.y, on), on));
    let y = twice(subtract_two(multiply(q.y, q.z, on), multiply(q.w, q.x, on), on));
    let z = subtract_two(along, across, on);
    let gap = vec3<real>(
        gap_of(Two(e.sum.x, e.error.x), x, size, l, on),
        gap_of(Two(e.sum.y, e.error.y), y, size, l, on),
        gap_of(Two(e.sum.z, e.error.z), z, size, l, on),
    );
    return (gap * r) * (real(1.0) / ((l.hi + l.lo) * size.hi));
}

// e s − ℓ d
fn gap_of(e: Two, d: Two, size: Two, l: Two, on: bool) -> real {
    return subtract_two(multiply_two(e, size, on), multiply_two(l, d, on), on).hi;
}
