#import bindings

struct Sum {
    sum: vec3<real>,
    error: vec3<real>,
}

// x + δ with its rounding error: the error-free sum of Knuth. `unit` is 1, which no compiler can know: so none takes the error for 0.
fn add_exactly(x: vec3<real>, carry: vec3<real>, step: vec3<real>, unit: real) -> Sum {
    let delta = step + carry;
    let sum = (x + delta) * unit;
    let rounded = (sum - x) * unit;
    return Sum(sum, (x - (sum - rounded) * unit) + (delta - rounded));
}

fn set_point(entry: u32, variant: u32, x: Sum) {
    for (var i = 0u; i < 3u; i++) {
        set_state(entry + i, variant, x.sum[i]);
        set_state(entry + 4u + i, variant, x.error[i]);
    }
}
