#import algebra
#import exact

// The edge between two points at entries a and b of the state, without the round-off of large coordinates.
fn edge(a: u32, b: u32, variant: u32, zero: u32) -> Sum {
    let none = vec3<real>(real(0.0), real(0.0), real(0.0));
    let apart = two_sum(value3(b, variant), none, -value3(a, variant), zero);
    return two_sum(apart.sum, apart.error, compensation3(b, variant) - compensation3(a, variant), zero);
}

// Γ = Rᵀ (e/ℓ − d3). The difference is small where e/ℓ and d3 are not, so it is computed with twice the
// digits: (|q|² e − ℓ d)/(ℓ |q|²) with d = |q|² d3. Deviations of |q| from 1 have no effect.
fn strain(r: mat3x3<real>, e: Sum, l: DoubleWord, q: vec4<real>, zero: u32) -> vec3<real> {
    let xx = two_product(q.x, q.x, zero);
    let yy = two_product(q.y, q.y, zero);
    let zz = two_product(q.z, q.z, zero);
    let ww = two_product(q.w, q.w, zero);
    let across = dw_add(xx, yy, zero);
    let along = dw_add(zz, ww, zero);
    let size = dw_add(across, along, zero);
    let x = dw_double(dw_add(two_product(q.x, q.z, zero), two_product(q.w, q.y, zero), zero));
    let y = dw_double(dw_subtract(two_product(q.y, q.z, zero), two_product(q.w, q.x, zero), zero));
    let z = dw_subtract(along, across, zero);
    let gap = vec3<real>(
        gap_of(DoubleWord(e.sum.x, e.error.x), x, size, l, zero),
        gap_of(DoubleWord(e.sum.y, e.error.y), y, size, l, zero),
        gap_of(DoubleWord(e.sum.z, e.error.z), z, size, l, zero),
    );
    return (gap * r) * (real(1.0) / ((l.hi + l.lo) * size.hi));
}

// e s − ℓ d
fn gap_of(e: DoubleWord, d: DoubleWord, size: DoubleWord, l: DoubleWord, zero: u32) -> real {
    return dw_subtract(dw_multiply(e, size, zero), dw_multiply(l, d, zero), zero).hi;
}
