#import algebra
#import exact

// The edge between two points at entries a and b of the state, without the round-off of large coordinates.
fn edge(a: u32, b: u32, variant: u32, opaque: bool) -> Sum {
    let zero = vec3<real>(real(0.0), real(0.0), real(0.0));
    let apart = two_sum(value3(b, variant), zero, -value3(a, variant), opaque);
    return two_sum(apart.sum, apart.error, compensation3(b, variant) - compensation3(a, variant), opaque);
}

// Γ = Rᵀ (e/ℓ − d3). The difference is small where e/ℓ and d3 are not, so it is computed with twice the
// digits: (|q|² e − ℓ d)/(ℓ |q|²) with d = |q|² d3. Deviations of |q| from 1 have no effect.
fn strain(r: mat3x3<real>, e: Sum, l: DoubleWord, q: vec4<real>, opaque: bool) -> vec3<real> {
    let xx = two_product(q.x, q.x, opaque);
    let yy = two_product(q.y, q.y, opaque);
    let zz = two_product(q.z, q.z, opaque);
    let ww = two_product(q.w, q.w, opaque);
    let across = dw_add(xx, yy, opaque);
    let along = dw_add(zz, ww, opaque);
    let size = dw_add(across, along, opaque);
    let x = dw_double(dw_add(two_product(q.x, q.z, opaque), two_product(q.w, q.y, opaque), opaque));
    let y = dw_double(dw_subtract(two_product(q.y, q.z, opaque), two_product(q.w, q.x, opaque), opaque));
    let z = dw_subtract(along, across, opaque);
    let gap = vec3<real>(
        gap_of(DoubleWord(e.sum.x, e.error.x), x, size, l, opaque),
        gap_of(DoubleWord(e.sum.y, e.error.y), y, size, l, opaque),
        gap_of(DoubleWord(e.sum.z, e.error.z), z, size, l, opaque),
    );
    return (gap * r) * (real(1.0) / ((l.hi + l.lo) * size.hi));
}

// e s − ℓ d
fn gap_of(e: DoubleWord, d: DoubleWord, size: DoubleWord, l: DoubleWord, opaque: bool) -> real {
    return dw_subtract(dw_multiply(e, size, opaque), dw_multiply(l, d, opaque), opaque).hi;
}
