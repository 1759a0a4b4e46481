#import assembly

// A block of the matrix of all variables, or of the points alone: the sum of the parts' second derivatives, and σ
// times the weight on the diagonal of frames. Rows and columns of held directions become those of the identity, in the
// basis of each held variable.
@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let it = item(group, groups, local);
    if !it.present {
        return;
    }
    let k = it.index;
    let variant = it.variant;
    let table = range.table;
    let block = program[table + 4u * k + 1u];
    let row = program[table + 4u * k + 2u];
    let column = program[table + 4u * k + 3u];
    var sum = zero33();
    for (var at = program[table + 4u * k]; at < program[table + 4u * k + 4u]; at++) {
        let source = program[table + at];
        var own = part33(source & ~(NEGATIVE | TRANSPOSED), variant);
        if (source & TRANSPOSED) != 0u {
            own = transpose(own);
        }
        if (source & NEGATIVE) != 0u {
            own = own * real(-1.0);
        }
        sum = sum + own;
    }
    if row == column {
        let weight = number(offsets.variables_numbers + 4u * row + 3u, variant);
        sum = sum + identity(control[variant].sigma * weight);
    }
    let held_row = hold_entry(row);
    if held_row != NONE {
        let free = free_directions(held_row, variant);
        sum = diagonal(free) * (transpose(hold_basis(held_row, variant)) * sum);
    }
    let held_column = hold_entry(column);
    if held_column != NONE {
        let free = free_directions(held_column, variant);
        sum = sum * hold_basis(held_column, variant) * diagonal(free);
        if row == column {
            sum = sum + diagonal(vec3<real>(real(1.0), real(1.0), real(1.0)) - free);
        }
    }
    set_block33(block, variant, sum);
}
