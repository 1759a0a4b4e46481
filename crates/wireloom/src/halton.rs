//! Halton's sequence: points that fill a cube evenly.

/// Coordinate of a point of Halton's sequence: the digits of its number to a prime base, reflected at the point.
pub fn halton(number: usize, coordinate: usize) -> f64 {
    const PRIMES: [usize; 16] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53];
    let base = PRIMES[coordinate % PRIMES.len()];
    let (mut rest, mut place, mut value) = (number, 1.0, 0.0);
    while rest > 0 {
        place /= base as f64;
        value += place * (rest % base) as f64;
        rest /= base;
    }
    value
}
