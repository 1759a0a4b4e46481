#import sum

// Double-word numbers: unevaluated sums of two numbers, with twice the digits (Dekker 1971).
struct DoubleWord {
    hi: real,
    lo: real,
}

fn dw_add(a: DoubleWord, b: DoubleWord, opaque: bool) -> DoubleWord {
    let sum = rounded(a.hi + b.hi, opaque);
    let rest = rounded(sum - a.hi, opaque);
    let error = (a.hi - rounded(sum - rest, opaque)) + (b.hi - rest);
    return fast_two_sum(sum, error + (a.lo + b.lo), opaque);
}

fn dw_subtract(a: DoubleWord, b: DoubleWord, opaque: bool) -> DoubleWord {
    return dw_add(a, DoubleWord(-b.hi, -b.lo), opaque);
}

// Sum of two numbers, the second far smaller, as a double word.
fn fast_two_sum(a: real, b: real, opaque: bool) -> DoubleWord {
    let sum = rounded(a + b, opaque);
    return DoubleWord(sum, b - rounded(sum - a, opaque));
}

// The leading half of the digits of a (Veltkamp 1968). In f64 these are fewer than half, and products are as in plain
// arithmetic.
fn split_high(a: real, opaque: bool) -> real {
    let far = rounded(a * real(4097.0), opaque);
    return rounded(far - rounded(far - a, opaque), opaque);
}

fn two_product(a: real, b: real, opaque: bool) -> DoubleWord {
    let p = rounded(a * b, opaque);
    let a1 = split_high(a, opaque);
    let b1 = split_high(b, opaque);
    let a2 = rounded(a - a1, opaque);
    let b2 = rounded(b - b1, opaque);
    return DoubleWord(p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2);
}

fn dw_multiply(a: DoubleWord, b: DoubleWord, opaque: bool) -> DoubleWord {
    let p = two_product(a.hi, b.hi, opaque);
    return fast_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi), opaque);
}

fn dw_double(a: DoubleWord) -> DoubleWord {
    return DoubleWord(a.hi + a.hi, a.lo + a.lo);
}
