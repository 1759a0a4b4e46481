#import algebra
#import bindings

const NEGATIVE: u32 = 0x80000000u;
const TRANSPOSED: u32 = 0x40000000u;

// Sum of the parts' first derivatives with respect to a variable, without dead forces.
fn assembled_force(variable: u32, variant: u32) -> vec3<real> {
    let table = offsets.forces_program;
    var sum = vec3<real>(real(0.0), real(0.0), real(0.0));
    for (var at = program[table + variable]; at < program[table + variable + 1u]; at++) {
        let source = program[table + at];
        let own = part3(source & ~NEGATIVE, variant);
        sum += select(own, -own, (source & NEGATIVE) != 0u);
    }
    return sum;
}

// Entry of a variable's hold; NONE if it has none.
fn hold_entry(variable: u32) -> u32 {
    let hold = program[offsets.holds_program + variable];
    if hold == NONE {
        return NONE;
    }
    return offsets.holds_numbers + 20u * hold;
}

// Columns of a hold's basis.
fn hold_basis(entry: u32, variant: u32) -> mat3x3<real> {
    return mat3x3<real>(number3(entry, variant), number3(entry + 3u, variant), number3(entry + 6u, variant));
}

// 0 in the held directions, 1 in the others.
fn free_directions(entry: u32, variant: u32) -> vec3<real> {
    let count = number(entry + 9u, variant);
    let o = real(0.0);
    let i = real(1.0);
    return vec3<real>(
        select(i, o, count > real(0.5)),
        select(i, o, count > real(1.5)),
        select(i, o, count > real(2.5)),
    );
}
