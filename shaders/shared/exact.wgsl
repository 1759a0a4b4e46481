#import sum

// Double-word numbers: unevaluated sums of two numbers, with twice the digits (Dekker 1971).
struct DoubleWord {
    hi: real,
    lo: real,
}

fn dw_add(a: DoubleWord, b: DoubleWord, zero: u32) -> DoubleWord {
    let sum = rounded(a.hi + b.hi, zero);
    let rest = rounded(sum - a.hi, zero);
    let error = (a.hi - rounded(sum - rest, zero)) + (b.hi - rest);
    return fast_two_sum(sum, error + (a.lo + b.lo), zero);
}

fn dw_subtract(a: DoubleWord, b: DoubleWord, zero: u32) -> DoubleWord {
    return dw_add(a, DoubleWord(-b.hi, -b.lo), zero);
}

// Sum of two numbers, the second far smaller, as a double word.
fn fast_two_sum(a: real, b: real, zero: u32) -> DoubleWord {
    let sum = rounded(a + b, zero);
    return DoubleWord(sum, b - rounded(sum - a, zero));
}

// The leading half of the digits of a (Veltkamp 1968). In f64 these are fewer than half, and products are as in plain
// arithmetic.
fn split_high(a: real, zero: u32) -> real {
    let far = rounded(a * real(4097.0), zero);
    return rounded(far - rounded(far - a, zero), zero);
}

fn two_product(a: real, b: real, zero: u32) -> DoubleWord {
    let p = rounded(a * b, zero);
    let a1 = split_high(a, zero);
    let b1 = split_high(b, zero);
    let a2 = rounded(a - a1, zero);
    let b2 = rounded(b - b1, zero);
    return DoubleWord(p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2);
}

fn dw_multiply(a: DoubleWord, b: DoubleWord, zero: u32) -> DoubleWord {
    let p = two_product(a.hi, b.hi, zero);
    return fast_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi), zero);
}

fn dw_double(a: DoubleWord) -> DoubleWord {
    return DoubleWord(a.hi + a.hi, a.lo + a.lo);
}
