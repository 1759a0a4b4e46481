// x, rounded, if the compiler does not see through it: f64 has the digits even so.
fn rounded(x: real, zero: u32) -> real {
    return select(real(0.0), x, zero == 0u);
}
