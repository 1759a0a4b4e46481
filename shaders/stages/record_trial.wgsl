#import totals
#import limits

// Records energy and residual of the trial state, and whether its points need condensation: a rotation by θ stretches
// segments by the fraction ½ θ², which causes forces far above all others (see the static condensation of solve).
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
    let variant = it.variant;
    let trial = totals(variant);
    control[variant].trial_energy = trial.energy;
    control[variant].trial_residual = trial.residual;
    control[variant].evaluations += 1u;
    let condensed = trial.force <= CONDENSED_FRACTION * control[variant].tolerance * control[variant].force_scale;
    control[variant].phase = select(CONDENSE, ACCEPT, condensed || !is_finite(trial.force));
}
