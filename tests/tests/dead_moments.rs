//! Whole runs with dead moments: what they end in, in how many iterations, and what is said of their stability.

use std::f64::consts::TAU;
use wireloom::Status;
use wireloom::geometry::Vector;
use wireloom::result::EventKind;
use wireloom_tests::cables::run;

/// A weightless rod, EI = 1 N m², clamped at A, with a couple about −y at B; `REST` is what follows.
const ROD: &str = r#"
schema = 1
name = "rod"
gravity = [0, 0, 0]
[sections.steel]
diameter = "5 mm"
linear_density = 0
axial_stiffness = 1e4
bending_stiffness = 1
torsion_stiffness = 0.8
[[branches]]
name = "rod"
from = "A"
to = "B"
section = "steel"
length = LENGTH
segments = 80
[[constraints]]
name = "wall"
kind = "connector"
at = { end = "A" }
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[loads]]
name = "couple"
at = { end = "B" }
moment = [0, -MOMENT, 0]
factor = FACTOR
[minimiser]
force_tolerance = 1e-8
REST
"#;

fn rod(length: f64, moment: f64, factor: f64, rest: &str) -> String {
    let numbers = [("LENGTH", length), ("MOMENT", moment), ("FACTOR", factor)];
    let text = numbers.iter().fold(ROD.to_owned(), |text, (key, value)| text.replace(key, &format!("{value:?}")));
    text.replace("REST", rest)
}

/// One equilibrium, the couple there from the beginning: the start is found without it, then it comes.
#[test]
fn circles_are_found_from_the_straight_rod_in_one_equilibrium() {
    for circles in [0.5, 1.0, 2.0] {
        let run = run(&rod(1.0, TAU * circles, 1.0, ""));
        let angle = TAU * circles;
        let exact = Vector::new(angle.sin(), 0.0, 1.0 - angle.cos()) / angle;
        assert_eq!(run.status(), Status::Converged, "{circles}: {:?}", run.events);
        let end = run.steps.last().unwrap();
        let off = (end.branches[0].position.last().unwrap() - exact).norm();
        assert!(off < 5e-5, "{circles} circles: {off:e} m off");
        // Eleven increments of homing, ten in which the couple comes, and one.
        assert!(end.minimiser.iterations <= 100, "{circles} circles: {} iterations", end.minimiser.iterations);
    }
}

/// Twenty increments to two circles, each in twenty iterations at most, none of them halved; the flag does not know.
#[test]
fn no_increment_of_rolling_up_takes_more_than_twenty_iterations() {
    let steps = "[output]\nincrements = true\n[[steps]]\nname = \"roll\"\nincrements = 20\n[[steps.load]]\n\
                 load = \"couple\"\nfactor = 1\n";
    let run = run(&rod(1.0, 2.0 * TAU, 0.0, steps));
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    // In two circles the rod lies in itself, and nothing else is to tell of.
    assert!(run.events.iter().all(|event| event.kind == EventKind::PassedThrough), "{:?}", run.events);
    assert_eq!(run.steps.len(), 20);
    let mut before = 0;
    for end in &run.steps {
        let spent = end.minimiser.iterations - before;
        // The first increment has the homing in it.
        assert!(spent <= if end.increment == 1 { 40 } else { 20 }, "increment {}: {spent}", end.increment);
        before = end.minimiser.iterations;
        assert_eq!(end.stable, None, "increment {}", end.increment);
    }
}

/// A rod in a frictionless sleeve, bent behind it by a couple: the sleeve pushes it out by M²/2EI, which the plug must
/// hold (Bigoni and others 2015; for a couple the curvature is the same everywhere, so nothing else takes part). The
/// border of what slides and the couple go together.
#[test]
fn a_couple_pushes_a_rod_out_of_a_sleeve() {
    let rest = r#"
[[constraints]]
name = "sleeve"
kind = "collar"
at = { branch = "rod", s = 0.25 }
position = [0.25, 0, 0]
tangent = [1, 0, 0]
slide = true
[[steps]]
name = "bend"
increments = 4
[[steps.load]]
load = "couple"
factor = 1
"#;
    let run = run(&rod(1.25, 3.0, 0.0, rest));
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let end = run.steps.last().unwrap();
    let wall = end.constraints.iter().find(|c| c.name == "wall").unwrap();
    assert!((wall.force.x.abs() - 4.5).abs() < 5e-3, "{:?}", wall.force);
    assert!(end.minimiser.iterations <= 80, "{} iterations", end.minimiser.iterations);
}

/// The rod is rolled against a wall that it touches on its way: reactions and the couple are in balance.
#[test]
fn a_rod_rolled_against_a_plane_is_in_balance() {
    let rest = r#"
[[obstacles]]
name = "ceiling"
shape = "plane"
point = [0, 0, 0.3]
normal = [0, 0, -1]
[[steps]]
name = "bend"
increments = 10
[[steps.load]]
load = "couple"
factor = 1
"#;
    let run = run(&rod(1.0, 3.0, 0.0, rest));
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let end = run.steps.last().unwrap();
    let wall = &end.constraints[0];
    let ceiling = &end.obstacles[0];
    assert!(ceiling.contacts > 0 && ceiling.force.z < -0.1, "{ceiling:?}");
    assert!((wall.force + ceiling.force).norm() < 1e-4, "{wall:?} {ceiling:?}");
    let highest = end.branches[0].position.iter().map(|x| x.z).fold(0.0, f64::max);
    assert!(highest < 0.3 && highest > 0.29, "{highest}");
}
