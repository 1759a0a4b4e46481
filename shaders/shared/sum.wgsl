#import bindings
#import rounded_{real}

struct Sum {
    sum: vec3<real>,
    error: vec3<real>,
}

fn rounded3(x: vec3<real>, zero: u32) -> vec3<real> {
    return vec3<real>(rounded(x.x, zero), rounded(x.y, zero), rounded(x.z, zero));
}

// 0, but unknown to the compiler.
fn unknown_zero(variant: u32) -> u32 {
    return select(1u, 0u, control[variant].unit > real(0.5));
}

// x + δ with its rounding error: Knuth's error-free sum.
fn two_sum(x: vec3<real>, compensation: vec3<real>, step: vec3<real>, zero: u32) -> Sum {
    let delta = rounded3(step + compensation, zero);
    let sum = rounded3(x + delta, zero);
    let rest = rounded3(sum - x, zero);
    return Sum(sum, (x - rounded3(sum - rest, zero)) + (delta - rest));
}

fn set_point(entry: u32, variant: u32, x: Sum) {
    set_state3(entry, variant, x.sum);
    set_state3(entry + 4u, variant, x.error);
}
