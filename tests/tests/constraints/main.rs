//! Constraints of every shape, by kinds that only tests know: against closed forms, cut back, resumed, at fault.

mod kinds;
mod wrong_derivatives;

use kinds::{Ratchet, counting, registry};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use wireloom::geometry::{Pose, Vector};
use wireloom::harness::{Conditions, Problem, update_constraints};
use wireloom::parts::{Minimiser, Newton, Stop};
use wireloom::result::{ConstraintResult, EventKind};
use wireloom::session::{Checkpoint, Observer, Progress, Resumed};
use wireloom::{Control, Run, Status, StepResult};
use wireloom_testkit::constraints::{Floor, Link, Parts, Plunger, Sight, Strut};
use wireloom_testkit::{equations_conformance, potential_and_equations_conformance, potential_conformance};
use wireloom_tests::cables::{branch, connector, run_with, section};

potential_conformance!(strut, || Box::new(Strut { rest: 0.3, stiffness: 70.0 }), 2, 0);
potential_conformance!(ratchet, || Box::new(Ratchet(Arc::default())), 1, 0);
equations_conformance!(link, || Box::new(Link(0.4)), 2, 0);
equations_conformance!(floor_under_a_span, || Box::new(Floor(0.1)), 0, 7);
equations_conformance!(sight, || Box::new(Sight), 2, 0);
potential_and_equations_conformance!(plunger, || Box::new(Plunger { stiffness: 70.0, parts: Parts::Both }), 1, 0);

fn run(text: &str) -> Run {
    run_with(text, &registry())
}

/// Message and help of each fault of a text that is refused.
fn refused(text: &str) -> Vec<(String, String)> {
    let faults = wireloom::load(text, &registry()).err().expect("faults");
    faults.into_iter().map(|fault| (fault.message, fault.help)).collect()
}

fn constraint<'r>(end: &'r StepResult, name: &str) -> &'r ConstraintResult {
    end.constraints.iter().find(|constraint| constraint.name == name).expect("a constraint of this name")
}

/// N.
const EA: f64 = 100.0;
/// N m².
const EI: f64 = 0.01;

/// Two bars in a line along x, clamped at x = 0 and x = 2.3 m, 1 m and 0.8 m long, with 0.5 m between their free ends B
/// and C.
fn bars(more: &str) -> String {
    let section = section("bar").replace("axial_stiffness = 1e4", &format!("axial_stiffness = {EA}"));
    [
        "schema = 1\nname = \"bars\"\ngravity = [0, 0, 0]\n",
        &section,
        &branch("left", ["A", "B"], "bar", 1.0, 10),
        &branch("right", ["C", "D"], "bar", 0.8, 8),
        &connector("A", "A", [0.0, 0.0, 0.0]),
        &connector("D", "D", [2.3, 0.0, 0.0]),
        more,
    ]
    .concat()
}

/// Flexibility of both bars along x, m/N.
const BARS: f64 = 1.0 / EA + 0.8 / EA;

/// Three springs in a row: `F = (gap − rest)/(Σ 1/k)`, whatever the mesh.
#[test]
fn a_spring_between_two_branches() {
    let run = run(&bars(
        "[[constraints]]\nname = \"strut\"\nkind = \"strut\"\nat = [{ end = \"B\" }, { end = \"C\" }]\nrest = 0.2\n\
         stiffness = 50",
    ));
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let strut = constraint(&run.steps[0], "strut");
    let force = 0.3 / (BARS + 1.0 / 50.0);
    let [at_b, at_c] = &strut.stations[..] else { panic!("{:?}", strut.stations) };
    assert!((at_b.force - Vector::x() * force).norm() < 1e-9, "{} instead of {force}", at_b.force);
    assert!((at_c.force + Vector::x() * force).norm() < 1e-9, "{}", at_c.force);
    assert!((at_b.position.x - (1.0 + force / EA)).abs() < 1e-10);
    assert_eq!((strut.force, strut.largest_force()), (at_b.force, at_b.force.norm().max(at_c.force.norm())));
    assert_eq!(run.steps[0].minimiser.iterations, 1, "work");
}

/// The same with a link in place of the spring: `F = (gap − d)/(Σ 1/k)`.
#[test]
fn an_equation_between_two_branches() {
    let run = run(&bars(
        "[[constraints]]\nname = \"link\"\nkind = \"link\"\nat = [{ end = \"B\" }, { end = \"C\" }]\n\
         distance = \"300 mm\"",
    ));
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let end = &run.steps[0];
    let link = constraint(end, "link");
    let force = 0.2 / BARS;
    assert!((link.force - Vector::x() * force).norm() < 1e-6 * force, "{} instead of {force}", link.force);
    let apart = (link.stations[1].position - link.stations[0].position).norm();
    assert!((apart - 0.3).abs() < 1e-8, "{apart}");
    assert!(end.minimiser.constraint_residual.expect("there are equations") <= 1e-8);
    assert_eq!(end.stable, Some(true));
}

/// A plunger at the end of a beam holds two directions and is a spring in the third, as its two halves are together,
/// and the spring alone lets the end go.
#[test]
fn a_potential_and_equations_in_one_are_both_of_them() {
    let end = "at = { end = \"B\" }\nposition = [0.9, 0.1, 0.02]\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n\
               stiffness = 40\n";
    let with = |kinds: &[&str]| {
        let one = |kind: &&str| format!("[[constraints]]\nname = \"{kind}\"\nkind = \"{kind}\"\n{end}");
        let run = run(&beam(&kinds.iter().map(one).collect::<String>(), -9.81));
        assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
        run.steps.into_iter().next().expect("a step")
    };
    let (one, two) = (with(&["plunger"]), with(&["plunger-spring", "plunger-guide"]));
    let whole = constraint(&one, "plunger");
    let halves = ["plunger-spring", "plunger-guide"].map(|name| constraint(&two, name));
    let sum = halves[0].force + halves[1].force;
    assert!((whole.force - sum).norm() < 1e-6 * sum.norm(), "{} and {sum}", whole.force);
    let (x, target) = (whole.position, Vector::new(0.9, 0.1, 0.02));
    assert!((x - halves[0].position).norm() < 1e-7, "{x} and {}", halves[0].position);
    // The target lies on the tangent, at a distance that is the force along it over k.
    let (gap, tangent) = (target - x, whole.orientation * Vector::z());
    assert!(gap.cross(&tangent).norm() < 1e-7, "{gap}");
    assert!((whole.force.dot(&tangent) - 40.0 * gap.dot(&tangent)).abs() < 1e-6, "{} at {gap}", whole.force);
    assert!(one.minimiser.constraint_residual.expect("there are equations") <= 1e-8);
    let spring = with(&["plunger-spring"]);
    assert!((constraint(&spring, "plunger-spring").position - x).norm() > 0.01);
}

/// A link between clamps cannot be met: no loop without end, and no claim.
#[test]
fn what_cannot_be_met_is_said_with_numbers() {
    let run = run(&bars(
        "[[constraints]]\nname = \"link\"\nkind = \"link\"\nat = [{ end = \"A\" }, { end = \"D\" }]\ndistance = 2.0",
    ));
    assert_eq!(run.status(), Status::IterationLimit);
    let off = run.steps[0].minimiser.constraint_residual.expect("there are equations");
    assert!((off - 0.3).abs() < 1e-9, "{off}");
    let event = run.events.iter().find(|event| event.kind == EventKind::NotConverged).expect("an event");
    assert!(event.message.contains("equations of constraints are off by 3.0e-1, allowed 1.0e-8"), "{}", event.message);
}

fn beam(constraints: &str, gravity: f64) -> String {
    let head = format!("schema = 1\nname = \"beam\"\ngravity = [0, 0, {gravity}]\n");
    [
        &*head,
        &section("beam"),
        &branch("beam", ["A", "B"], "beam", 1.0, 100),
        &connector("A", "A", [0.0, 0.0, 0.0]),
        constraints,
    ]
    .concat()
}

/// A cantilever under a force P at its tip comes to lie on a floor: the floor takes `P − 3 EI gap/L³`, and with a floor
/// too deep, nothing.
#[test]
fn an_inequality_along_a_span() {
    let (p, gap) = (6e-5, 1e-3);
    let text = |gap: f64| {
        let floor = format!(
            "[[constraints]]\nname = \"floor\"\nkind = \"floor\"\nspan = {{ branch = \"beam\", from = 0.1 }}\n\
             height = {}\n\
             [[loads]]\nname = \"p\"\nat = {{ end = \"B\" }}\nforce = [0, 0, {}]",
            -gap, -p
        );
        beam(&floor, 0.0)
    };
    let touching = run(&text(gap));
    assert_eq!(touching.status(), Status::Converged, "{:?}", touching.events);
    let span = constraint(&touching.steps[0], "floor").span.clone().expect("a span");
    let want = p - 3.0 * EI * gap;
    assert!((span.force.z - want).abs() < 1e-4 * want, "{} instead of {want}", span.force.z);
    assert_eq!(span.largest, span.force);
    for (found, s) in [(span.range.0, 0.1), (span.range.1, 1.0), (span.largest_at, 1.0)] {
        assert!((found - s).abs() < 1e-12, "{span:?}");
    }
    let free = run(&text(2.5e-3));
    assert_eq!(constraint(&free.steps[0], "floor").span.clone().expect("a span").force, Vector::zeros());
    let tip = free.steps[0].branches[0].position[100].z;
    assert!((tip + p / (3.0 * EI)).abs() < 1e-3 * p / (3.0 * EI), "{tip}");
}

/// A heavy cable held at one end lies on the floor: what floor and clamp take is its weight.
#[test]
fn a_cable_lies_on_the_floor() {
    let run = run(&beam(
        "[[constraints]]\nname = \"floor\"\nkind = \"floor\"\nspan = { branch = \"beam\" }\nheight = -0.05",
        -9.81,
    ));
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let end = &run.steps[0];
    let carried = constraint(end, "floor").span.clone().expect("a span").force.z + constraint(end, "A").force.z;
    assert!((carried - 0.05 * 9.81).abs() < 1e-6, "{carried}");
    let lowest = end.branches[0].position.iter().map(|x| x.z).fold(f64::INFINITY, f64::min);
    assert!((-0.05 - 1e-5..-0.0499).contains(&lowest), "{lowest}");
}

/// Two hanging cables tied together: how much work the equation makes is pinned, for Newton must keep its order through
/// it.
#[test]
fn equations_keep_the_order_of_newton() {
    let text = include_str!("tied.toml");
    let run = run(text);
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let pull = run.steps.last().expect("a step");
    let each = pull.minimiser.iterations as f64 / pull.increments as f64;
    assert!(each <= 6.0, "{each} iterations an increment");
    let tie = constraint(pull, "tie");
    let sum = tie.stations[0].force + tie.stations[1].force;
    assert!(sum.norm() < 1e-12 && tie.force.norm() > 1e-3, "{:?}", tie.stations);
    let apart = (tie.stations[1].position - tie.stations[0].position).norm();
    assert!((apart - 0.02).abs() < 1e-8, "{apart}");
}

/// The multipliers are updated around whatever minimiser there is.
#[test]
fn every_minimiser_meets_equations() {
    let with = |kind: &str| {
        let minimiser = format!("[minimiser]\nkind = \"{kind}\"\nmax_iterations = 2000\n");
        let run = run(&(include_str!("tied.toml").to_owned() + &minimiser));
        assert_eq!(run.status(), Status::Converged, "{kind}: {:?}", run.events);
        constraint(run.steps.last().expect("a step"), "tie").force
    };
    let newton = with("newton");
    for kind in ["lbfgs", "ncg"] {
        let force = with(kind);
        assert!((force - newton).norm() < 1e-4 * newton.norm(), "{kind}: {force} instead of {newton}");
    }
}

/// A second cable hangs from the first one by two ties and by nothing else.
fn hung(ties: &str) -> String {
    beam(
        &format!(
            r#"
[[branches]]
name = "second"
from = "E"
to = "F"
section = "beam"
length = 0.5
segments = 40
[[constraints]]
name = "B"
kind = "connector"
at = {{ end = "B" }}
position = [0.9, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
{ties}
"#
        ),
        -9.81,
    )
}

#[test]
fn a_cable_may_hang_from_another_one() {
    let tie = |name: &str, s: f64, of_second: f64| {
        format!(
            "[[constraints]]\nname = \"{name}\"\nkind = \"link\"\ndistance = \"20 mm\"\n\
             at = [{{ branch = \"beam\", s = {s} }}, {{ branch = \"second\", s = {of_second} }}]\n"
        )
    };
    let run = run(&hung(&(tie("one", 0.3, 0.1) + &tie("other", 0.6, 0.4))));
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let end = &run.steps[0];
    let carried: Vector = ["one", "other"].iter().map(|name| constraint(end, name).stations[1].force).sum();
    assert!((carried - Vector::z() * (0.5 * 0.05 * 9.81)).norm() < 1e-6, "{carried}");
    let both = constraint(end, "A").force.z + constraint(end, "B").force.z;
    assert!((both - 1.5 * 0.05 * 9.81).abs() < 1e-6, "{both}");
    let loose = refused(&hung(""));
    assert!(loose[0].0.starts_with("branch \"second\" is not held"), "{loose:?}");
}

/// A hand carries the end of a hanging cable out and back; a ratchet on the cable does not let it come back.
fn ratchet(iterations: usize, increments: usize) -> String {
    beam(
        &format!(
            r#"
[[constraints]]
name = "B"
kind = "connector"
at = {{ end = "B" }}
position = [0.6, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[constraints]]
name = "ratchet"
kind = "ratchet"
at = {{ branch = "beam", s = 0.8 }}
[minimiser]
kind = "newton"
max_iterations = {iterations}
[output]
increments = true
[[steps]]
name = "out"
increments = {increments}
[[steps.move]]
constraint = "B"
position = [0.8, 0, 0]
[[steps]]
name = "back"
increments = {increments}
[[steps.move]]
constraint = "B"
position = [0.6, 0, 0]
"#
        ),
        -9.81,
    )
}

/// Run, positions of the ratchet's station at the end of every increment, and number of calls of `commit`.
fn ratcheted(text: &str) -> (Run, Vec<f64>, usize) {
    let commits = Arc::new(AtomicUsize::new(0));
    let (_, built) = wireloom::load(text, &counting(commits.clone())).unwrap_or_else(|faults| panic!("{faults:#?}"));
    let run = wireloom::run(built, &mut |_, _| Control::Continue);
    let places = run.steps.iter().map(|end| constraint(end, "ratchet").position.x).collect();
    (run, places, commits.load(Ordering::Relaxed))
}

#[test]
fn a_ratchet_remembers() {
    let (run, places, commits) = ratcheted(&ratchet(200, 12));
    assert_eq!((run.status(), run.steps.len(), commits), (Status::Converged, 24, 24));
    let out = places[11];
    assert!(out - places[0] > 0.1, "{places:?}");
    let back = constraint(&run.steps[23], "ratchet");
    assert!(back.force.x > 0.05 && out - back.position.x < 0.02, "{} N, {places:?}", back.force.x);
    assert!((back.force.x - kinds::RATCHET * (out - back.position.x)).abs() < 1e-9);
}

/// A released constraint forgets: a ratchet that takes hold again pulls at nothing.
#[test]
fn a_ratchet_that_begins_again_has_forgotten() {
    let again = "[[steps]]\nname = \"off\"\nincrements = 1\nrelease = [\"ratchet\"]\n\
                 [[steps]]\nname = \"on\"\nincrements = 1\n[[steps.add]]\nname = \"ratchet\"\nkind = \"ratchet\"\n\
                 at = { branch = \"beam\", s = 0.8 }\n";
    let run = run(&(ratchet(200, 12) + again));
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let forces: Vec<f64> = ["back", "on"]
        .map(|name| constraint(run.steps.iter().rfind(|end| end.name == name).expect("a step"), "ratchet").force.norm())
        .into();
    assert!(forces[0] > 1.0 && forces[1] == 0.0, "{forces:?}");
}

/// Equations cost no allocation once there is room for them.
#[test]
fn a_step_through_equations_does_not_allocate() {
    let (_, built) = wireloom::load(include_str!("tied.toml"), &registry()).expect("no faults");
    let network = &built.network;
    let mut state = wireloom::harness::place(network, &built.schedule);
    let mut conditions = Conditions::new(network, built.schedule.gravity, &state);
    conditions.active.fill(true);
    let mut problem = Problem::new(network, conditions);
    let targets = |problem: &mut Problem<'_>, shift: f64| {
        for (f, constraint) in network.constraints.iter().enumerate() {
            if let Some(position) = constraint.position {
                let base = problem.conditions().constraints[f].base;
                let moved = if constraint.name == "D" { Vector::y() * shift } else { Vector::zeros() };
                problem.set_target(f, Pose { position: position + moved, ..base });
            }
        }
    };
    let mut newton = Newton::new();
    let stop = Stop { max_iterations: 2000, ..Stop::default() };
    targets(&mut problem, 0.0);
    for _ in 0..10 {
        newton.minimise(&mut problem, &mut state, &stop);
        update_constraints(&mut problem, &state, 0.0, &mut Vec::new());
    }
    let mut status = Status::Failed;
    let count = allocation_counter::measure(|| {
        targets(&mut problem, 0.003);
        status = newton.minimise(&mut problem, &mut state, &stop).status;
    });
    assert_eq!((status, count.count_total), (Status::Converged, 0));
}

/// An increment that is halved, because it is allowed few iterations, remembers once, at its end: as where it was not
/// halved.
#[test]
fn what_is_cut_back_is_not_remembered() {
    let (plain, places, _) = ratcheted(&ratchet(200, 6));
    let (cut, cut_places, commits) = ratcheted(&ratchet(4, 6));
    let halved = cut.events.iter().filter(|event| event.kind == EventKind::CutBack).count();
    assert!(halved > 0 && plain.events.iter().all(|event| event.kind != EventKind::CutBack), "{:?}", cut.events);
    assert_eq!((cut.status(), commits), (Status::Converged, 12));
    for (a, b) in places.iter().zip(&cut_places) {
        assert!((a - b).abs() < 1e-6, "{places:?}, {cut_places:?}");
    }
}

#[derive(Default)]
struct Keep {
    checkpoints: Vec<Vec<u8>>,
    steps: Vec<StepResult>,
}

impl Observer for Keep {
    fn increment(&mut self, _: &Progress, end: &StepResult, kept: bool) -> Control {
        if kept {
            self.steps.push(end.clone());
        }
        Control::Continue
    }
    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.checkpoints.push(postcard::to_stdvec(checkpoint).expect("bytes"));
    }
}

/// Memory, multipliers and progress survive, and the increment before a fault: from every checkpoint the same bits come
/// out.
#[test]
fn what_is_remembered_is_resumed() {
    for text in [ratchet(200, 24), include_str!("tied.toml").to_owned(), door(), breaking("brittle")] {
        let built = || wireloom::load(&text, &registry()).unwrap_or_else(|faults| panic!("{faults:#?}")).1;
        let without_times = |mut run: Run| {
            run.steps.iter_mut().for_each(|step| step.minimiser.seconds = 0.0);
            format!("{run:?}")
        };
        let mut keep = Keep::default();
        let whole = without_times(wireloom::run_observed(built(), None, &mut keep));
        assert!(keep.checkpoints.len() > 2);
        for bytes in &keep.checkpoints {
            let checkpoint: Checkpoint = postcard::from_bytes(bytes).expect("a checkpoint");
            let built = built();
            assert!(checkpoint.fits(&built.network));
            let steps = keep.steps[..checkpoint.kept()].to_vec();
            let resumed = Some(Resumed { checkpoint, steps });
            assert!(without_times(wireloom::run_observed(built, resumed, &mut Keep::default())) == whole);
        }
    }
}

/// A clip on a door that is opened in the step in which it begins, and stays open.
fn door() -> String {
    beam(
        r#"
[[steps]]
name = "open"
increments = 12
[[steps.add]]
name = "clip"
kind = "door"
at = { end = "B" }
position = [0.8, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
angle = "60 deg"
[[steps]]
name = "rest"
increments = 12
[[steps.move]]
constraint = "clip"
position = [0.7, 0, 0]
"#,
        -9.81,
    )
}

#[test]
fn a_target_moves_with_the_progress_of_its_first_step() {
    let run = run(&door());
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    let (sin, cos) = 60.0_f64.to_radians().sin_cos();
    for (step, reach) in run.steps.iter().zip([0.8, 0.7]) {
        let clip = constraint(step, "clip");
        let want = Vector::new(cos, sin, 0.0) * reach;
        assert!((clip.position - want).norm() < 1e-12, "{} instead of {want}", clip.position);
        let tangent = clip.orientation * Vector::z();
        assert!((tangent - Vector::new(cos, sin, 0.0)).norm() < 1e-12, "{tangent}");
    }
}

/// A hand that pulls by a constraint that breaks down at y = 0.05 m, half way of its second step.
fn breaking(kind: &str) -> String {
    beam(
        &format!(
            "[[constraints]]\nname = \"hand\"\nkind = \"{kind}\"\nat = {{ end = \"B\" }}\nposition = [0.7, 0, 0]\n\
             until = 0.05\n\
             [[steps]]\nname = \"wait\"\nincrements = 1\n[[steps]]\nname = \"pull\"\nincrements = 8\n\
             [[steps.move]]\nconstraint = \"hand\"\nposition = [0.7, 0.1, 0]\n"
        ),
        -9.81,
    )
}

#[test]
fn a_number_that_is_not_finite_ends_the_run_with_what_is_finished() {
    let run = run(&breaking("brittle"));
    let fault = run.fault().expect("a fault");
    assert_eq!(
        fault.to_string(),
        "constraint `hand` (brittle) in step `pull`, increment 5: it gave a number that is not finite for a harness \
         that is"
    );
    assert_eq!(run.status(), Status::Failed);
    let kept: Vec<_> = run.steps.iter().map(|end| (end.name.as_str(), end.increment, end.status)).collect();
    assert_eq!(kept, [("wait", 1, Status::Converged), ("pull", 4, Status::Converged)]);
}

#[test]
fn a_constraint_may_say_itself_that_it_is_at_fault() {
    let run = run(&breaking("worn"));
    assert_eq!(
        run.fault().expect("a fault").to_string(),
        "constraint `hand` (worn) in step `pull`, increment 5: worn out"
    );
    assert_eq!(run.status(), Status::Failed);
    let kept: Vec<_> = run.steps.iter().map(|end| (end.name.as_str(), end.increment, end.status)).collect();
    assert_eq!(kept, [("wait", 1, Status::Converged), ("pull", 4, Status::Converged)]);
}

#[test]
fn what_does_not_attach_as_its_kind_does_is_refused() {
    let with =
        |kind: &str, keys: &str| refused(&bars(&format!("[[constraints]]\nname = \"x\"\nkind = \"{kind}\"\n{keys}")));
    let said =
        |kind: &str, keys: &str| with(kind, keys).into_iter().map(|(m, h)| format!("{m}; {h}")).collect::<Vec<_>>();
    assert_eq!(
        said("link", "at = { end = \"B\" }\ndistance = 1"),
        ["constraint \"x\" attaches to one place, and its kind \"link\" does not; give 2 places in `at`"]
    );
    assert_eq!(
        said("connector", "at = [{ end = \"B\" }, { end = \"C\" }]"),
        ["constraint \"x\" attaches to 2 places, and its kind \"connector\" does not; give one place in `at`"]
    );
    assert_eq!(
        said("floor", "at = { end = \"B\" }\nheight = 0"),
        ["constraint \"x\" has no `span`, along which its kind \"floor\" acts; add span = { branch = \"…\", from = \
             …, to = … }"]
    );
    assert_eq!(
        said("link", "span = { branch = \"left\" }\ndistance = 1"),
        ["constraint \"x\" has a `span`, and its kind \"link\" does not act along one; leave `span` out, or choose \
             a kind that acts along a span"]
    );
    assert_eq!(
        said("floor", "span = { branch = \"left\", from = 0.5, to = 1.5 }\nheight = 0"),
        ["`to` = 1.5 m is outside branch \"left\"; give an arc length from 0 to 1 m"]
    );
    assert_eq!(
        said("floor", "span = { branch = \"left\", from = 0.5, to = 0.5 }\nheight = 0"),
        ["the span of branch \"left\" from 0.5 m to 0.5 m has no length; `from` comes before `to`, both in arc \
             length along the branch"]
    );
    assert_eq!(
        said(
            "link",
            "at = [{ branch = \"left\", s = 0.5 }, { branch = \"right\", s = 0.5 }]\nslide = true\ndistance = 1"
        ),
        ["no cable can slide through constraint \"x\": it does not act on one place alone; leave `slide` out"]
    );
    let ring = "[[constraints]]\nname = \"ring\"\nkind = \"collar\"\nat = { branch = \"left\", s = 0.5 }\nslide = true";
    assert_eq!(
        said("floor", &format!("span = {{ branch = \"left\" }}\nheight = 0\n{ring}")),
        ["constraint \"x\" acts along branch \"left\", which slides through another one; \
             use no sliding constraint on that branch, or divide it by a joint"]
    );
}
