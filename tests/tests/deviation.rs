//! Deviation of computed shapes from drawn ones: against the sag of beams in closed form, with the reason, and beside
//! the equilibrium from the drawn start.

use wireloom::parts::Monitor;
use wireloom::result::{Deviation, DeviationCause};
use wireloom::{Run, Status};
use wireloom_tests::cables::{branch, connector, run, section};

/// Weight of the cable of [`section`], N/m, and its bending stiffness, N m².
const WEIGHT: f64 = 0.05 * 9.81;
const EI: f64 = 0.01;

/// A horizontal cable of length `l` (m) that is drawn straight; `more` holds it.
fn drawn_straight(l: f64, more: &str) -> Run {
    let text = [
        "schema = 1\nname = \"straight\"\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", l, 60),
        &format!("path = [[0, 0, 0], [{l:?}, 0, 0]]\n"),
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
        more,
    ]
    .concat();
    let run = run(&text);
    assert_eq!(run.status(), Status::Converged);
    run
}

fn deviation(run: &Run) -> &Deviation {
    let end = run.steps.last().expect("a step");
    end.branches[0].deviation.as_ref().expect("a drawn line")
}

fn close(value: f64, expected: f64, part: f64) {
    assert!((value - expected).abs() <= part * expected, "{value} not {expected}");
}

/// The tip of a clamped beam under its weight sags by w L⁴/(8 EI), half of its length by less than the value at the
/// middle, w L⁴/(8 EI) · 17/48 (Timoshenko & Gere). The sag is a twentieth of the length here, which makes the beam's
/// linear theory about 1 % too soft. Nothing holds the tip: that is the reason.
#[test]
fn a_cantilever_deviates_by_its_sag_because_its_end_is_free() {
    let l = 0.2;
    let run = drawn_straight(l, "");
    let sag = WEIGHT * l.powi(4) / (8.0 * EI);
    let found = deviation(&run);
    close(found.max, sag, 0.02);
    close(found.median, sag * 17.0 / 48.0, 0.03);
    close(found.s, l, 1e-9);
    match &found.cause {
        // 9.8 mm of 6 mm diameter.
        Some(DeviationCause::FreeEnd { from: Some(from), free_length }) => {
            assert_eq!(from, "plug-A");
            close(*free_length, l, 1e-9);
        }
        other => panic!("{other:?}"),
    }
}

/// Between two clamps a beam sags by w L⁴/(384 EI) without tension: one clamp slides along the cable's axis.
#[test]
fn between_clamps_it_deviates_by_the_sag_of_a_beam_and_has_too_few_of_them() {
    let l = 0.6;
    let far = connector("plug-B", "B", [l, 0.0, 0.0]) + "rail = [[1, 0, 0]]\n";
    let run = drawn_straight(l, &far);
    let sag = WEIGHT * l.powi(4) / (384.0 * EI);
    let found = deviation(&run);
    close(found.max, sag, 0.02);
    close(found.s, 0.5 * l, 1e-6);
    match &found.cause {
        Some(DeviationCause::FewConstraints { between, free_length, room }) => {
            assert_eq!(between, &["plug-A".to_owned(), "plug-B".to_owned()]);
            close(*free_length, l, 1e-9);
            // The plug has come nearer by what the sag takes; so far the cable can reach aside.
            let chord = run.steps[0].constraints[1].position.x;
            close(*room, 0.5 * (l * l - chord * chord).sqrt(), 1e-6);
            assert!(found.max < *room, "{found:?}");
        }
        other => panic!("{other:?}"),
    }
}

/// With a clip in the middle the sag is a sixteenth: less than the diameter, and no reason is given.
#[test]
fn one_clip_more_and_the_drawing_is_met() {
    let l = 0.6;
    let clip = "[[constraints]]\nname = \"clip\"\nkind = \"collar\"\nat = { branch = \"cable\", s = 0.3 }\n\
                position = [0.3, 0, 0]\ntangent = [1, 0, 0]\nrail = [[1, 0, 0]]\n";
    let far = connector("plug-B", "B", [l, 0.0, 0.0]) + "rail = [[1, 0, 0]]\n" + clip;
    let run = drawn_straight(l, &far);
    let found = deviation(&run);
    close(found.max, WEIGHT * 0.3_f64.powi(4) / (384.0 * EI), 0.02);
    assert_eq!(found.cause, None);
}

/// A plug 40 mm beside the drawn end takes the cable with it: not the number of constraints is the reason.
#[test]
fn a_plug_beside_the_drawing_is_named() {
    let far = connector("plug-B", "B", [0.29, 0.04, 0.0]);
    let run = drawn_straight(0.3, &far);
    let found = deviation(&run);
    close(found.max, 0.04, 0.01);
    assert_eq!(found.cause, Some(DeviationCause::HeldElsewhere { constraint: "plug-B".to_owned() }));
}

/// Neither a drawn line nor a reason to compare.
#[test]
fn what_is_not_drawn_does_not_deviate() {
    let text = wireloom_tests::cables::hanging("undrawn", 20, "");
    let run = run(&text);
    assert_eq!(run.steps[0].branches[0].deviation, None);
    assert_eq!(run.drawn_start, None);
}

/// An arm that is not drawn does not make a joint lie on its drawing: the hand holds it 80 mm beside that.
#[test]
fn a_joint_with_an_arm_that_is_not_drawn_is_held_elsewhere() {
    let arms = "arms = [{ branch = \"left\", direction = [-1, 0, 0], up = [0, 0, 1] }, \
                { branch = \"right\", direction = [1, 0, 0], up = [0, 0, 1] }]\n";
    let text = [
        "schema = 1\nname = \"joint\"\n",
        &section("cable"),
        &branch("left", ["A", "J"], "cable", 0.3, 20),
        "path = [[0, 0, 0], [0.3, 0, 0]]\n",
        &branch("right", ["J", "B"], "cable", 0.1, 8),
        "[[joints]]\nname = \"J\"\nmodel = \"fused\"\n",
        arms,
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
        "[[constraints]]\nname = \"hand\"\nkind = \"handle\"\nat = { joint = \"J\" }\nposition = [0.28, 0, 0.08]\n",
    ]
    .concat();
    let run = run(&text);
    assert_eq!(run.status(), Status::Converged);
    assert_eq!(deviation(&run).cause, Some(DeviationCause::HeldElsewhere { constraint: "hand".to_owned() }));
}

/// A run, compared with the drawn start.
fn compared(text: &str) -> Run {
    let registry = wireloom::registry();
    let (scenario, built) = wireloom::load(text, &registry)
        .unwrap_or_else(|faults| panic!("{}", wireloom::scenario::render(text, &faults)));
    let mut run = wireloom::run(built, &mut |_, _| wireloom::Control::Continue);
    assert_eq!(run.status(), Status::Converged);
    run.drawn_start = wireloom::compare_with_drawn_start(&scenario, &run, &registry, &Monitor::default());
    run
}

/// A cable that starts on a board at y = −0.5 and is carried to two plugs at y = 0, where it is drawn; `turns` are made
/// on the way.
fn carried(turns: f64) -> Run {
    compared(
        &[
            "schema = 1\nname = \"carried\"\n",
            &section("cable"),
            &branch("cable", ["A", "B"], "cable", 0.4, 40),
            "path = [[0, -0.5, 0], [0.4, -0.5, 0]]\n\
             drawn = [[0, 0, 0], [0.1, 0, -0.07], [0.2, 0, -0.1], [0.3, 0, -0.07], [0.39, 0, 0]]\n",
            &connector("plug-A", "A", [0.0, -0.5, 0.0]),
            &connector("plug-B", "B", [0.4, -0.5, 0.0]),
            "[[steps]]\nname = \"carry\"\nincrements = 20\n\
             move = [{ constraint = \"plug-A\", position = [0, 0, 0] }, \
             { constraint = \"plug-B\", position = [0.35, 0, 0]",
            &format!(", turns = {turns:?} }}]\n"),
        ]
        .concat(),
    )
}

/// A straight cable, whose centre line a turn of twist does not move.
fn straight(far: &str, step: &str) -> Run {
    compared(
        &[
            "schema = 1\nname = \"straight\"\ngravity = [0, 0, 0]\n",
            &section("cable"),
            &branch("cable", ["A", "B"], "cable", 0.4, 20),
            "path = [[0, -0.5, 0], [0.4, -0.5, 0]]\ndrawn = [[0, 0, 0], [0.4, 0, 0]]\n",
            &connector("plug-A", "A", [0.0, -0.5, 0.0]),
            far,
            "[[steps]]\nname = \"carry\"\nincrements = 10\nmove = [{ constraint = \"plug-A\", position = [0, 0, 0] }, ",
            step,
            "]\n",
        ]
        .concat(),
    )
}

#[test]
fn a_turn_that_remains_in_a_straight_cable_is_told() {
    let far = connector("plug-B", "B", [0.4, -0.5, 0.0]);
    let run = straight(&far, "{ constraint = \"plug-B\", position = [0.4, 0, 0], turns = 1 }");
    let compared = run.drawn_start.expect("compared");
    let [own] = &compared.branches[..] else { panic!("{compared:?}") };
    assert!((own.turns.abs() - 1.0).abs() < 1e-6 && own.distance < 1e-6, "{compared:?}");
    assert!(compared.why[0].contains("whole turns of twist"), "{compared:?}");
}

/// A result says where a spring holds the cable, not where it pulls to: from there it would be at rest.
#[test]
fn a_harness_on_a_spring_is_not_compared_as_if_the_spring_were_at_rest() {
    let far = "[[constraints]]\nname = \"hand\"\nkind = \"handle\"\nat = { end = \"B\" }\n\
               position = [0.4, -0.5, 0.2]\nstiffness = 5.0\n";
    let run = straight(far, "{ constraint = \"hand\", position = [0.4, 0, 0.2] }");
    let compared = run.drawn_start.expect("a word on it");
    let why = compared.not_compared.expect("no comparison");
    assert!(why.contains("\"hand\" is a spring"), "{why}");
}

/// An arm that slipped on the way would be at rest where it is drawn.
#[test]
fn a_harness_whose_arms_slip_is_not_compared_as_if_they_had_not() {
    let half = |name: &str, ends: [&str; 2], from: f64| {
        let (x, end) = (from, from + 0.2);
        branch(name, ends, "cable", 0.2, 10)
            + &format!("path = [[{x}, -0.5, 0], [{end}, -0.5, 0]]\ndrawn = [[{x}, 0, 0], [{end}, 0, 0]]\n")
    };
    let run = compared(
        &[
            "schema = 1\nname = \"taped\"\n",
            &section("cable"),
            &half("left", ["A", "J"], 0.0),
            &half("right", ["J", "B"], 0.2),
            "[[joints]]\nname = \"J\"\nmodel = \"compliant-hub\"\nbending_stiffness = 0.1\ntorsion_stiffness = 0.1\n\
             friction = { bending = [{ stiffness = 0.1, moment = 0.001 }] }\n\
             arms = [{ branch = \"left\", direction = [-1, 0, 0], up = [0, 0, 1] }, \
             { branch = \"right\", direction = [1, 0, 0], up = [0, 0, 1] }]\n",
            &connector("plug-A", "A", [0.0, -0.5, 0.0]),
            &connector("plug-B", "B", [0.39, -0.5, 0.0]),
            "[[steps]]\nname = \"carry\"\nincrements = 4\nmove = [{ constraint = \"plug-A\", position = [0, 0, 0] }, \
             { constraint = \"plug-B\", position = [0.39, 0, 0] }]\n",
        ]
        .concat(),
    );
    let why = run.drawn_start.expect("a word on it").not_compared.expect("no comparison");
    assert_eq!(why, "joint \"J\" keeps a set from the way there");
}

/// A whole turn on the way remains in the cable, which winds out of its plane: the run says that it ends elsewhere, how
/// far, and why. Without the turn it ends where it would from its drawn line.
#[test]
fn a_run_that_ends_elsewhere_than_from_the_drawn_start_says_so_and_why() {
    let compared = carried(0.0).drawn_start.expect("compared");
    assert!(compared.not_compared.is_none() && compared.branches.is_empty(), "{compared:?}");
    assert!(compared.energy.is_some_and(|energy| energy.abs() < 1e-6), "{compared:?}");

    let turned = carried(1.0);
    let compared = turned.drawn_start.as_ref().expect("compared");
    assert_eq!(compared.not_compared, None);
    let farthest = compared.branches.first().expect("it ends elsewhere");
    assert!((farthest.turns.abs() - 1.0).abs() < 0.5 && farthest.distance > 0.006, "{compared:?}");
    assert!(compared.energy.is_some_and(|energy| energy > 0.0), "{compared:?}");
    assert!(compared.why[0].contains("whole turns of twist") && compared.why[0].contains("`cable`"), "{compared:?}");
    // The deviation is that from the drawn line, not from the board where it started.
    assert!(deviation(&turned).max < 0.2, "{:?}", deviation(&turned));
}
