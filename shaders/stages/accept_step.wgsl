#import algebra
#import bindings
#import totals
#import limits

// Accepts the trial state, condensed if that lowers its energy, or shortens the step; then selects the next phase.
// Backtracking line search (Armijo), with the parabola through value, slope and trial value where possible. If
// round-off hides the change of the energy, the residual decides.
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
    control[variant].cycles += 1u;
    let c = control[variant];
    let noise = c.noise * max(abs(c.energy), c.moment_scale);
    var energy = c.trial_energy;
    var residual = c.trial_residual;
    var slot = TRIAL;
    if c.phase == CONDENSE {
        let condensed = totals(variant);
        control[variant].evaluations += 1u;
        // If round-off hides the difference, the residual decides.
        let close = condensed.energy <= energy + noise && condensed.residual < residual;
        if condensed.energy <= energy || close {
            energy = condensed.energy;
            residual = condensed.residual;
            slot = CONDENSED;
        }
    }
    let finite = is_finite(energy) && is_finite(residual);
    if c.begun == 0u {
        // The first state that satisfies all holds: there is no previous energy to compare with.
        control[variant].begun = 1u;
        control[variant].moving = 0u;
        control[variant].last_rotation = c.alpha * c.max_rotation;
        if !finite {
            end(variant, FAILED);
            return;
        }
    } else {
        let hidden = -c.slope <= noise;
        let lower = energy <= c.energy + ARMIJO * c.alpha * c.slope + noise;
        if !finite || !(lower || (hidden && residual <= real(0.5) * c.residual)) {
            let parabola = real(-0.5) * c.slope * c.alpha * c.alpha / (energy - c.energy - c.slope * c.alpha);
            var alpha = real(0.25) * c.alpha;
            if finite && is_finite(parabola) {
                alpha = clamp(parabola, real(0.1) * c.alpha, real(0.5) * c.alpha);
            }
            control[variant].alpha = alpha;
            control[variant].phase = SEARCH;
            if alpha >= MIN_STEP {
                return;
            }
            if c.since > 1u {
                // Refactorise before giving up.
                control[variant].phase = LINEARISE;
            } else if hidden {
                end(variant, STALLED);
            } else if c.sigma < MAX_SHIFT * c.force_scale {
                control[variant].sigma = max(SHIFT_INCREASE_AFTER_SEARCH * c.sigma, FIRST_SHIFT * c.force_scale);
                control[variant].phase = LINEARISE;
            } else {
                end(variant, FAILED);
            }
            return;
        }
        control[variant].last_rotation = c.alpha * c.max_rotation;
        let stalled = select(0u, c.stalled + 1u, hidden && residual > real(0.5) * c.residual);
        control[variant].stalled = stalled;
        if stalled >= c.patience && c.residual <= residual {
            // The current state is better.
            end(variant, STALLED);
            return;
        }
        if c.sigma > real(0.0) {
            let sigma = c.sigma * select(SHIFT_DECREASE, real(4.0), c.alpha < real(0.25));
            control[variant].sigma = select(sigma, real(0.0), sigma < real(0.1) * FIRST_SHIFT * c.force_scale);
        }
    }
    control[variant].previous = c.current;
    control[variant].current = (c.current + slot) % 3u;
    control[variant].energy = energy;
    control[variant].residual = residual;
    let now = control[variant];
    if residual <= now.tolerance {
        let spent = now.polished == MAX_POLISHING_STEPS || now.stalled > 0u || now.iterations >= now.max_iterations;
        if now.last_rotation <= RESOLVED_ROTATION || spent {
            end(variant, CONVERGED);
            return;
        }
        control[variant].polished += 1u;
        control[variant].sigma = real(0.0);
    }
    if now.stalled >= now.patience {
        end(variant, STALLED);
    } else if now.iterations >= now.max_iterations {
        end(variant, ITERATION_LIMIT);
    } else if now.algorithm == 1u && c.begun == 1u && now.since < MAX_METRIC_AGE && c.alpha >= MIN_REUSED_STEP {
        control[variant].phase = DESCEND;
    } else {
        control[variant].phase = LINEARISE;
    }
}
