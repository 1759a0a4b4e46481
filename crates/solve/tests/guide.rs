//! Equilibria that are searched for near those of the same run on another mesh.

use std::collections::BTreeMap;
use wireloom_core::equilibrium::{Run, StepResult};
use wireloom_core::status::Status;
use wireloom_core::{Registry, State, Vector};
use wireloom_scenario::{Built, NoFiles};
use wireloom_solve::report::discretisation::NodalErrors;
use wireloom_solve::steps::Guide;
use wireloom_solve::steps::checkpoint::Observer;
use wireloom_solve::{Control, Progress};

/// A cable that is bent to a hairpin, turned by a whole turn, and let go of at one end.
const HAIRPIN: &str = r#"
schema = 1
[sections.cable]
diameter = "8 mm"
linear_density = "120 g/m"
axial_stiffness = 2.0e4
bending_stiffness = 0.012
torsion_stiffness = 0.009
[[branches]]
name = "cable"
from = "A"
to = "B"
section = "cable"
length = 0.6
segments = SEGMENTS
[[constraints]]
name = "plug-A"
kind = "connector"
at = { end = "A" }
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[constraints]]
name = "plug-B"
kind = "connector"
at = { end = "B" }
position = [0.6, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[steps]]
name = "bend"
increments = 6
move = [{ constraint = "plug-B", via = [[0.5, 0.1, 0]], position = [0.2, 0.15, 0], tangent = [-0.87, -0.5, 0] }]
[[steps]]
name = "turn"
increments = 6
move = [{ constraint = "plug-B", turns = 1 }]
[[steps]]
name = "let go"
release = ["plug-B"]
increments = 2
"#;

#[derive(Default)]
struct Watch {
    /// Equilibria to collect.
    collected: Option<Guide>,
    guide: Option<Guide>,
    state: Option<State>,
}

impl Observer for Watch {
    fn state(&mut self, state: &State, _: &[NodalErrors]) {
        self.state = Some(state.clone());
    }

    fn increment(&mut self, _: &Progress, end: &StepResult, _: bool) -> Control {
        if let (Some(collected), Some(state)) = (&mut self.collected, &self.state) {
            collected.add(end, state);
        }
        Control::Continue
    }

    fn guide(&self) -> Option<Guide> {
        self.guide.clone()
    }
}

fn built(segments: usize) -> Built {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    wireloom_solve::register(&mut registry);
    let text = HAIRPIN.replace("SEGMENTS", &segments.to_string());
    let built = wireloom_scenario::build_with_settings(&text, &[], &NoFiles, &registry);
    built.unwrap_or_else(|faults| panic!("{}", wireloom_scenario::render(&text, &faults))).1
}

/// The run on a mesh, near the equilibria of `guide`; and its own equilibria.
fn run(segments: usize, guide: Option<Guide>) -> (Run, Guide) {
    let Built { network, coarse, mut schedule, mut minimiser, stop, .. } = built(segments);
    schedule.increments = true;
    let mut watch = Watch { collected: Guide::new(&network), guide, state: None };
    let run =
        wireloom_solve::carry_out(&network, coarse.as_ref(), minimiser.as_mut(), &stop, &schedule, None, &mut watch);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?}", run.notes, run.events);
    (run, watch.collected.expect("no mesh moves here"))
}

/// Iterations of each step.
fn iterations(run: &Run) -> BTreeMap<&str, usize> {
    run.steps.iter().map(|end| (end.name.as_str(), end.minimiser.iterations)).collect()
}

/// The equilibria are those of the run by itself, the turn of the plug included, with fewer iterations.
#[test]
fn a_guided_run_has_the_same_equilibria_in_fewer_iterations() {
    let (_, coarse) = run(24, None);
    let ((own, _), (guided, _)) = (run(60, None), run(60, Some(coarse)));
    assert_eq!(own.steps.len(), guided.steps.len());
    for (own, guided) in own.steps.iter().zip(&guided.steps) {
        let (a, b) = (&own.branches[0], &guided.branches[0]);
        let farthest = a.position.iter().zip(&b.position).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(farthest < 1e-6, "{} {}: {farthest:e} m", own.name, own.increment);
        let (a, b) = (a.moment[0], b.moment[0]);
        assert!((a - b).norm() < 1e-5 * a.norm().max(1e-3), "{} {}: {a} and {b}", own.name, own.increment);
    }
    let (own, guided) = (iterations(&own), iterations(&guided));
    for (step, own) in own {
        assert!(4 * guided[step] <= 3 * own, "{step}: {} of {own} iterations", guided[step]);
    }
}

/// Where no equilibrium is found near the guide's, an increment goes its own way from the one before.
#[test]
fn a_guide_that_leads_nowhere_changes_nothing() {
    let (coarse, mut wrong) = run(24, None);
    let nowhere = State { points: vec![Vector::repeat(f64::NAN); 25], ..State::origin(&built(24).network) };
    for end in &coarse.steps {
        wrong.add(end, &nowhere);
    }
    let ((own, _), (guided, _)) = (run(60, None), run(60, Some(wrong)));
    for (own, guided) in own.steps.iter().zip(&guided.steps) {
        let pairs = own.branches[0].position.iter().zip(&guided.branches[0].position);
        assert!(pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) < 1e-6, "{} {}", own.name, own.increment);
    }
}
