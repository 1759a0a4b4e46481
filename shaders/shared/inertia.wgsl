#import bindings

// Number of negative pivots of a factorisation: the sum over the root tasks, which the table lists after their number.
fn negative_pivots(variant: u32) -> real {
    var negative = real(0.0);
    for (var i = 1u; i <= program[range.table]; i++) {
        negative += vector(offsets.negatives_vectors + program[range.table + i], variant);
    }
    return negative;
}
