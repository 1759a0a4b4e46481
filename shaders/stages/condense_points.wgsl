#import assembly
#import sum

// Static condensation: the trial state with its points in equilibrium for fixed frames.
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
    let at = state_entry(k, TRIAL, variant);
    let to = state_entry(k, CONDENSED, variant);
    for (var i = 0u; i < 7u; i++) {
        set_state(to + i, variant, state_at(at + i, variant));
    }
    let own = program[offsets.condensation_program + k];
    if own == NONE {
        return;
    }
    var step = vector3(3u * own, variant);
    let held = hold_entry(k);
    if held != NONE {
        step = hold_basis(held, variant) * step;
    }
    set_point(to, variant, two_sum(value3(at, variant), compensation3(at, variant), step, unknown_zero(variant)));
}
