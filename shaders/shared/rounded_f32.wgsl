// x, rounded. `zero` is 0, but unknown to the compiler, which therefore cannot simplify the rounding error of a sum to
// 0, nor fuse a product into a sum. It must go through an integer: one compiler turned a + (b − a) t into a mixture of a
// and b, which is b for t = 1; another one took x out of a choice between x and 0.
fn rounded(x: real, zero: u32) -> real {
    return bitcast<f32>(bitcast<u32>(x) ^ zero);
}
