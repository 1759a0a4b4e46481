#import sum

// Numbers as unevaluated sums of two, which have twice the digits (Dekker 1971).
struct Two {
    hi: real,
    lo: real,
}

fn add_two(a: Two, b: Two, on: bool) -> Two {
    let sum = kept(a.hi + b.hi, on);
    let rounded = kept(sum - a.hi, on);
    let error = (a.hi - kept(sum - rounded, on)) + (b.hi - rounded);
    return in_order(sum, error + (a.lo + b.lo), on);
}

fn subtract_two(a: Two, b: Two, on: bool) -> Two {
    return add_two(a, Two(-b.hi, -b.lo), on);
}

// Two numbers, the second far smaller, as one.
fn in_order(a: real, b: real, on: bool) -> Two {
    let sum = kept(a + b, on);
    return Two(sum, b - kept(sum - a, on));
}

// The half of the digits of a that come first (Veltkamp 1968). In f64 these are fewer than half, and products are as they would be without.
fn first_half(a: real, on: bool) -> real {
    let far = kept(a * real(4097.0), on);
    return kept(far - kept(far - a, on), on);
}

fn multiply(a: real, b: real, on: bool) -> Two {
    let p = kept(a * b, on);
    let a1 = first_half(a, on);
    let b1 = first_half(b, on);
    let a2 = kept(a - a1, on);
    let b2 = kept(b - b1, on);
    return Two(p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2);
}

fn multiply_two(a: Two, b: Two, on: bool) -> Two {
    let p = multiply(a.hi, b.hi, on);
    return in_order(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi), on);
}

fn twice(a: Two) -> Two {
    return Two(a.hi + a.hi, a.lo + a.lo);
}
