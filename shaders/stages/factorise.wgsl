#import algebra
#import bindings
#import instructions

struct Pivot {
    inverse: mat3x3<real>,
    negative: real,
}

// P⁻¹ and the number of negative pivots of P, by P = L D Lᵀ.
fn invert(p: mat3x3<real>) -> Pivot {
    let i1 = real(1.0) / p[0].x;
    let l21 = p[0].y * i1;
    let l31 = p[0].z * i1;
    let d2 = p[1].y - l21 * p[0].y;
    let i2 = real(1.0) / d2;
    let e32 = p[1].z - l31 * p[0].y;
    let l32 = e32 * i2;
    let d3 = p[2].z - l31 * p[0].z - l32 * e32;
    let i3 = real(1.0) / d3;
    // L⁻¹ = [1, 0, 0; −l21, 1, 0; m31, −l32, 1]
    let m31 = l21 * l32 - l31;
    let x13 = m31 * i3;
    let x23 = -l32 * i3;
    let x12 = m31 * x23 - l21 * i2;
    let x22 = i2 - l32 * x23;
    let x11 = i1 + l21 * l21 * i2 + m31 * x13;
    let o = real(0.0);
    let i = real(1.0);
    let negative = select(o, i, p[0].x < o) + select(o, i, d2 < o) + select(o, i, d3 < o);
    let inverse = mat3x3<real>(vec3<real>(x11, x12, x13), vec3<real>(x12, x22, x23), vec3<real>(x13, x23, i3));
    return Pivot(inverse, negative);
}

// A task of the factorisation A = B D⁻¹ Bᵀ, block by block: A_ij + Σ U − Σ B_ik D_k⁻¹ B_jkᵀ. Pivots are
// inverted in place; negative ones are added to those of earlier tasks (Sylvester's law of inertia).
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
    let end = table + program[table + k + 1u];
    var at = table + program[table + k];
    var negative = real(0.0);
    let children = program[at];
    for (var i = 1u; i <= children; i++) {
        negative += vector(offsets.negatives_vectors + program[at + i], variant);
    }
    at += 1u + children;
    while at < end {
        let block = program[at];
        let flags = program[at + 1u];
        let adds = program[at + 2u];
        let products = program[at + 3u];
        at += 4u;
        var sum = zero33();
        if (flags & UPDATE) == 0u {
            sum = block33(block, variant);
        }
        for (var i = 0u; i < adds; i++) {
            sum = sum + block33(program[at + i], variant);
        }
        at += adds;
        for (var i = 0u; i < products; i++) {
            let left = block33(program[at], variant) * block33(program[at + 2u], variant);
            sum = sum - left * transpose(block33(program[at + 1u], variant));
            at += 3u;
        }
        if (flags & PIVOT) != 0u {
            let pivot = invert(sum);
            sum = pivot.inverse;
            negative += pivot.negative;
        }
        set_block33(block, variant, sum);
    }
    set_vector(offsets.negatives_vectors + k, variant, negative);
}
