#import bindings

struct Sum {
    sum: vec3<real>,
    error: vec3<real>,
}

// x, rounded. `on` is true, which no compiler can know: so none sees through it, and takes the error of a sum for 0. (A factor 1 that is read
// from memory is not enough: a + (b − a) t was seen to become a mixture of a and b, which for t = 1 is b.)
fn kept(x: real, on: bool) -> real {
    return select(real(0.0), x, on);
}

fn kept3(x: vec3<real>, on: bool) -> vec3<real> {
    return vec3<real>(kept(x.x, on), kept(x.y, on), kept(x.z, on));
}

// Whether sums are to be rounded: always.
fn is_on(variant: u32) -> bool {
    return control[variant].unit > real(0.5);
}

// x + δ with its rounding error: the error-free sum of Knuth.
fn add_exactly(x: vec3<real>, carry: vec3<real>, step: vec3<real>, on: bool) -> Sum {
    let delta = kept3(step + carry, on);
    let sum = kept3(x + delta, on);
    let rounded = kept3(sum - x, on);
    return Sum(sum, (x - kept3(sum - rounded, on)) + (delta - rounded));
}

fn set_point(entry: u32, variant: u32, x: Sum) {
    for (var i = 0u; i < 3u; i++) {
        set_state(entry + i, variant, x.sum[i]);
        set_state(entry + 4u + i, variant, x.error[i]);
    }
}
