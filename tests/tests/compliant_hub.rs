//! The joint `compliant-hub`: its limits, its springs about each axis, what attaches to it, and what one file says for
//! all models. Its closed form with offsets is `scenarios/analytic/compliant_hub.toml`.

use wireloom::geometry::Vector;
use wireloom::{Status, StepResult};
use wireloom_tests::cables::{branch, connector, run, section};

/// Solves a scenario; the end of its last step.
#[track_caller]
fn solved(text: &str) -> StepResult {
    let mut run = run(text);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?}", run.notes, run.fault());
    run.steps.pop().expect("a step")
}

/// One of the Y harnesses of `scenarios/branches`, with its model replaced.
fn y_harness(file: &str, model: &str, joint: &str) -> String {
    let path = wireloom_tests::root().join("scenarios/branches").join(file);
    let text = std::fs::read_to_string(path).expect("a scenario of the repository");
    let own = format!("model = \"{model}\"\n");
    assert!(text.contains(&own));
    text.replace(&own, &format!("{joint}\n")) + "\n[minimiser]\nforce_tolerance = 1e-9\n"
}

fn springs(bending: f64, torsion: f64) -> String {
    format!("model = \"compliant-hub\"\nbending_stiffness = {bending:?}\ntorsion_stiffness = {torsion:?}")
}

/// Largest distance between nodes, m.
fn apart(one: &StepResult, other: &StepResult) -> f64 {
    let nodes = |step: &StepResult| -> Vec<Vector> { step.branches.iter().flat_map(|b| b.position.clone()).collect() };
    nodes(one).into_iter().zip(nodes(other)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// Springs twice as stiff leave half the distance to the joint without springs, with the offsets and the mass of its
/// hub.
#[test]
fn stiff_springs_are_the_rigid_body_and_without_offsets_the_fused_joint() {
    for (file, model) in [("y_rigid_body.toml", "rigid-body"), ("y_fused.toml", "fused")] {
        let rigid = solved(&y_harness(file, model, &format!("model = \"{model}\"")));
        let distance = |k: f64| apart(&solved(&y_harness(file, model, &springs(k, k))), &rigid);
        let [soft, stiff, stiffest] = [50.0, 100.0, 1e5].map(distance);
        assert!((1.95..2.05).contains(&(soft / stiff)), "{model}: {soft:e} m and {stiff:e} m");
        assert!(stiffest < 1.5e-3 * stiff, "{model}: {stiffest:e} m beside {stiff:e} m");
    }
}

/// A cable of 0.4 m and 0.3 m from A to D with a hub between them, one half of which may run towards the hub; `at_end`
/// says what holds D.
fn cable(towards: bool, arms: [&str; 2], at_end: &str) -> String {
    let ends = if towards { ["D", "J"] } else { ["J", "D"] };
    [
        "schema = 1\nname = \"cable\"\ngravity = [0, 0, 0]\n",
        &section("s"),
        &branch("one", ["A", "J"], "s", 0.4, 40),
        &branch("two", ends, "s", 0.3, 30),
        &format!(
            "[[joints]]\nname = \"J\"\nmodel = \"compliant-hub\"\narms = [\n\
             {{ branch = \"one\", direction = [-1, 0, 0], up = [0, 0, 1], {} }},\n\
             {{ branch = \"two\", direction = [1, 0, 0], up = [0, 0, 1], {} }},\n]\n",
            arms[0], arms[1]
        ),
        &connector("a", "A", [0.0; 3]),
        "[[constraints]]\nname = \"d\"\nkind = \"connector\"\nat = { end = \"D\" }\n",
        at_end,
        "\n[minimiser]\nforce_tolerance = 1e-10\n",
    ]
    .concat()
}

/// The end of a straight cable is turned by a small angle about one axis and free to move: the moment is the same
/// everywhere, so `θ = M (L/C + 1/k + 1/k′)` about d1, d2 and d3.
#[test]
fn springs_are_in_series_with_the_cable_about_each_axis() {
    let arms =
        ["bending_stiffness = [0.3, 0.5], torsion_stiffness = 0.2", "bending_stiffness = 0.9, torsion_stiffness = 0.4"];
    let (c, s) = (0.2_f64.cos(), 0.2_f64.sin());
    // d1 is z, d2 is d3 × d1 = −y.
    let ends = [
        ("d1", 0.7 / 0.01 + 1.0 / 0.3 + 1.0 / 0.9, format!("tangent = [{c}, {s}, 0]\nup = [0, 0, 1]")),
        ("d2", 0.7 / 0.01 + 1.0 / 0.5 + 1.0 / 0.9, format!("tangent = [{c}, 0, {s}]\nup = [{}, 0, {c}]", -s)),
        ("d3", 0.7 / 0.008 + 1.0 / 0.2 + 1.0 / 0.4, format!("tangent = [1, 0, 0]\nup = [0, {s}, {c}]")),
    ];
    for (about, compliance, pose) in ends {
        let end = solved(&cable(false, arms, &format!("hold = [\"tangent\", \"twist\"]\n{pose}")));
        let (moment, want) = (end.constraints[1].moment.norm(), 0.2 / compliance);
        // The moment of a spring of small angle is k φ to its fourth power.
        assert!((moment - want).abs() < 1e-6 * want, "about {about}: {moment} N m instead of {want}");
        let energy = end.energy.joint;
        let spent = 0.5 * want * want * (compliance - 0.7 / if about == "d3" { 0.008 } else { 0.01 });
        assert!((energy - spent).abs() < 1e-5 * spent, "about {about}: {energy} J in the springs instead of {spent}");
    }
}

/// The stiffness about d1 and d2 is that of the arm whichever way its branch runs.
#[test]
fn a_branch_that_runs_the_other_way_has_the_same_shape() {
    let offset =
        |x: f64| format!("offset = [{x}, 0.004, 0.002], bending_stiffness = [0.05, 0.2], torsion_stiffness = 0.03");
    let arms = [offset(-0.01), offset(0.012)];
    let arms = [&*arms[0], &*arms[1]];
    let at = |sign: f64| {
        format!("position = [0.55, 0.15, 0.1]\ntangent = [{sign}, {}, {}]\nup = [0, 0.4, 1]", 0.5 * sign, 0.2 * sign)
    };
    let (from, towards) = (solved(&cable(false, arms, &at(1.0))), solved(&cable(true, arms, &at(-1.0))));
    let pairs = from.branches[1].position.iter().zip(towards.branches[1].position.iter().rev());
    let apart = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(apart < 1e-9, "{apart:e} m apart");
    let turned = from.joints[0].orientation.angle_to(&towards.joints[0].orientation);
    assert!(turned < 1e-8 && from.joints[0].orientation.angle() > 0.1, "the hub turns by {turned:e} rad");
    assert!((from.energy.joint - towards.energy.joint).abs() < 1e-10, "{:?}", towards.energy);
}

/// What is attached to the very end of an arm is on the hub, where the arm leaves it: it holds the hub's pose, and the
/// cable turns against it by its moment over the stiffness.
#[test]
fn what_attaches_to_the_end_of_an_arm_holds_the_hub() {
    let arm = |x: f64| format!("offset = [{x}, 0, 0], bending_stiffness = 0.5, torsion_stiffness = 0.2");
    let arms = [arm(-0.01), arm(0.01)];
    let text =
        cable(false, [&*arms[0], &*arms[1]], "hold = [\"tangent\", \"twist\"]\ntangent = [0, 1, 0]\nup = [0, 0, 1]")
            + "[[constraints]]\nname = \"clamp\"\nkind = \"connector\"\nat = { branch = \"two\", s = 0 }\n\
           position = [0.43, 0, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n";
    let end = solved(&text);
    let hub = &end.joints[0];
    assert!((hub.position - Vector::new(0.42, 0.0, 0.0)).norm() < 1e-12, "{:?}", hub.position);
    let two = &end.branches[1];
    assert!((two.position[0] - Vector::new(0.43, 0.0, 0.0)).norm() < 1e-12, "{:?}", two.position[0]);
    // A right angle over 0.3 m of EI = 0.01 N m² and the spring.
    let moment = 0.5 * std::f64::consts::PI / (0.3 / 0.01 + 1.0 / 0.5);
    let tangent = two.frame[0] * Vector::z();
    let turned = tangent.y.atan2(tangent.x);
    assert!((turned - moment / 0.5).abs() < 1e-6, "{turned} rad instead of {}", moment / 0.5);
    let of_clamp = end.constraints.iter().find(|own| own.name == "clamp").expect("it acts").moment;
    assert!((of_clamp.z + moment).abs() < 1e-7, "{of_clamp:?} instead of {moment}");
}

/// One file serves all models, so that `compare --joint` can try them: others do not look at the springs.
#[test]
fn every_model_takes_a_file_with_springs() {
    for (file, model) in
        [("y_rigid_body.toml", "rigid-body"), ("y_fused.toml", "fused"), ("y_cosserat.toml", "cosserat")]
    {
        let own = format!("model = \"{model}\"");
        let with = format!("{own}\nbending_stiffness = [1, 2]\ntorsion_stiffness = 1");
        let [with, without] = [with, own].map(|joint| solved(&y_harness(file, model, &joint)));
        assert_eq!(apart(&with, &without), 0.0, "{model}");
    }
}
