#import bindings

struct Sum {
    sum: vec3<real>,
    error: vec3<real>,
}

// x, rounded. `opaque` is true, but unknown to the compiler, which therefore cannot simplify the rounding error of a
// sum to 0. (A factor 1 read from memory is not enough: one compiler turned a + (b − a) t into a mixture of a and b,
// which is b for t = 1.)
fn rounded(x: real, opaque: bool) -> real {
    return select(real(0.0), x, opaque);
}

fn rounded3(x: vec3<real>, opaque: bool) -> vec3<real> {
    return vec3<real>(rounded(x.x, opaque), rounded(x.y, opaque), rounded(x.z, opaque));
}

// Whether sums are rounded: always true.
fn opaque_true(variant: u32) -> bool {
    return control[variant].unit > real(0.5);
}

// x + δ with its rounding error: Knuth's error-free sum.
fn two_sum(x: vec3<real>, compensation: vec3<real>, step: vec3<real>, opaque: bool) -> Sum {
    let delta = rounded3(step + compensation, opaque);
    let sum = rounded3(x + delta, opaque);
    let rest = rounded3(sum - x, opaque);
    return Sum(sum, (x - rounded3(sum - rest, opaque)) + (delta - rest));
}

fn set_point(entry: u32, variant: u32, x: Sum) {
    for (var i = 0u; i < 3u; i++) {
        set_state(entry + i, variant, x.sum[i]);
        set_state(entry + 4u + i, variant, x.error[i]);
    }
}
