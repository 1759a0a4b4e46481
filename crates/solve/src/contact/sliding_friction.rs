//! Updates of the Coulomb friction of sliding constraints between minimisations.

use wireloom_core::conditions::Sliding;
use wireloom_core::{Problem, State, Tangent};

/// Tolerance of Coulomb's law, as a fraction of the friction limit; its square, as a fraction of the force scale, is
/// the tolerance of limits near zero.
const TOLERANCE: f64 = 1e-4;

/// Updates friction by Coulomb's law at the balanced `state` with whole gradient `gradient`: the axial force of a
/// constraint, `|∂E/∂s|`, is at most μ times its force across. A constraint that sticks beyond that slips, and one
/// that slips gets the friction of its present normal force. Returns whether anything changed: the state is not in
/// balance then.
pub fn update(problem: &mut Problem<'_>, state: &State, gradient: &Tangent) -> bool {
    let mut changed = false;
    for slide in problem.sliding().acting() {
        let friction = problem.network.slides[slide].friction;
        if friction == 0.0 {
            continue;
        }
        let limit = friction * problem.slide_pressure(slide, state, gradient);
        let tolerance = TOLERANCE * limit.max(problem.scales().force * TOLERANCE);
        match problem.conditions().sliding[slide] {
            Sliding::Stuck if gradient.slides[slide].abs() > limit + tolerance => {
                problem.set_sliding(slide, Sliding::Running { force: -limit.copysign(gradient.slides[slide]) });
                changed = true;
            }
            Sliding::Running { force } if (force.abs() - limit).abs() > tolerance => {
                problem.set_sliding(slide, Sliding::Running { force: limit.copysign(force) });
                changed = true;
            }
            _ => {}
        }
    }
    changed
}
