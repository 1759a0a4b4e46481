//! From a built scenario to its equilibria.

use wireloom_core::Network;
use wireloom_core::equilibrium::{Run, StepResult};
use wireloom_core::network::Branch;
use wireloom_scenario::Built;
use wireloom_solve::steps::checkpoint::{IncrementObserver, Observer, Resumed};
use wireloom_solve::{Control, Progress};

/// Carries out the steps of a built scenario. `observer` is called at the end of every increment and may stop the run;
/// what has been computed is kept. Not converging is a status of the run, not an error. See the [first page](crate) for
/// an example.
pub fn run(built: Built, observer: &mut dyn FnMut(&Progress, &StepResult) -> Control) -> Run {
    run_observed(built, None, &mut IncrementObserver(observer))
}

/// Carries out a built scenario as [`run`] does, with an observer that may keep checkpoints. With `resumed` it
/// continues a run from one of them, to the same bits as without an interruption. See [`session`](crate::session) for
/// an example.
///
/// # Panics
/// If the checkpoint is not one of a run of the same scenario; see
/// [`Checkpoint::fits`](wireloom_solve::steps::checkpoint::Checkpoint::fits).
pub fn run_observed(built: Built, resumed: Option<Resumed>, observer: &mut dyn Observer) -> Run {
    let Built { network, coarse, schedule, mut minimiser, stop, notes, .. } = built;
    let minimiser = minimiser.as_mut();
    let mut run = wireloom_solve::carry_out(&network, coarse.as_ref(), minimiser, &stop, &schedule, resumed, observer);
    run.notes.splice(0..0, notes);
    run.notes.extend(coarse_meshes(&network, &run.steps));
    run
}

/// Part of a bend radius above which its error is worth a note.
const COARSE: f64 = 0.1;
/// Multiple of its limit below which a bend radius is within reach of it.
const REACH: f64 = 3.0;
/// Accuracy that a proposed number of segments is for.
const ACCURACY: f64 = 0.02;

/// A note for each branch whose mesh is too coarse to tell whether it keeps its bend radius.
fn coarse_meshes(network: &Network, steps: &[StepResult]) -> Vec<String> {
    let note = |(b, branch): (usize, &Branch)| {
        // The error is that of the tightest bend.
        let bends = steps.iter().filter_map(|step| {
            let result = &step.branches[b];
            let tightest = result.bends().min_by(|a, b| a.radius.total_cmp(&b.radius))?;
            Some((tightest.radius, result.error?.bend_radius?, tightest.limit?))
        });
        let (radius, error, limit) = bends
            .filter(|(radius, error, limit)| *radius <= REACH * limit && *error > COARSE * radius)
            .max_by(|a, b| (a.1 / a.0).total_cmp(&(b.1 / b.0)))?;
        let segments = branch.rod.mesh().segments();
        // The error of the curvature goes with the square of the length of segments.
        let finer = segments as f64 * (error / (radius - error) / ACCURACY).sqrt();
        Some(format!(
            "branch `{}`: its mesh of {segments} segments is coarse for its bend radius of {:.1} mm, which may be \
             smaller by {:.1} mm (limit {:.1} mm): [mesh] accuracy = \"2 %\" makes one that is fine enough, or \
             segments = {:.0}",
            branch.name,
            1e3 * radius,
            1e3 * error,
            1e3 * limit,
            finer.ceil()
        ))
    };
    network.branches.iter().enumerate().filter_map(note).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::Status;

    /// A tight cable that bends sharply at its clamps.
    const BENT: &str = r#"schema = 1
name = "bent"

[sections.cable]
diameter = "8 mm"
linear_density = "120 g/m"
axial_stiffness = 2.0e4
bending_stiffness = 0.0005
torsion_stiffness = 0.0004
min_bend_radius = "40 mm"

[[branches]]
name = "A"
from = "start"
to = "end"
section = "cable"
length = 0.4
segments = SEGMENTS

[[constraints]]
name = "a"
kind = "connector"
at = { end = "start" }

[[constraints]]
name = "b"
kind = "connector"
at = { end = "end" }

[initial]
branch = "A"
tangent = [1, 0, 0]
up = [0, 0, 1]

[[steps]]
name = "bend"
increments = 10
[[steps.move]]
constraint = "b"
position = [0.37, 0.16, 0.0]
"#;

    #[test]
    fn a_mesh_too_coarse_for_its_bend_radius_is_noted() {
        let notes = |segments: &str| {
            let text = BENT.replace("SEGMENTS", segments);
            let (_, built) = crate::load(&text, &crate::registry()).unwrap_or_else(|faults| panic!("{faults:?}"));
            let run = run(built, &mut |_, _| Control::Continue);
            assert_eq!(run.status(), Status::Converged);
            run.notes.into_iter().filter(|note| note.contains("is coarse")).collect::<Vec<_>>()
        };
        let coarse = notes("40");
        assert!(coarse.len() == 1 && coarse[0].contains("`A`") && coarse[0].contains("limit 40.0 mm"), "{coarse:?}");
        assert!(notes("1000").is_empty());
    }
}
