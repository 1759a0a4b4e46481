//! Friction within sections in whole runs: when it is remembered, and that nothing leaves it out.

use wireloom::geometry::Vector;
use wireloom::result::FrictionResult;
use wireloom::session::{Transferred, transfer};
use wireloom::{Run, Status, StepResult};
use wireloom_tests::cables::{advanced, branch, built, connector, driver, hanging, run, section};
use wireloom_tests::root;

/// Elements of a bundle of wires, of which the first slips in gentle bends.
const FRICTION: &str = "friction = { bending = [{ stiffness = 0.02, moment = 0.01 }, \
                        { stiffness = 0.01, moment = 0.03 }], torsion = [{ stiffness = 0.01, moment = 0.01 }] }\n";

/// The section of the shared cables with friction.
fn with_friction(text: &str) -> String {
    let elastic = "torsion_stiffness = 0.008\n";
    assert!(text.contains(elastic));
    text.replace(elastic, &format!("{elastic}{FRICTION}"))
}

fn scenario(path: &str) -> String {
    std::fs::read_to_string(root().join("scenarios").join(path)).expect("a scenario of the repository")
}

#[track_caller]
fn converged(text: &str) -> Run {
    let run = run(text);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?} {:?}", run.notes, run.events, run.fault());
    run
}

fn friction(end: &StepResult) -> &FrictionResult {
    end.branches[0].friction.as_ref().expect("it has friction")
}

/// Set in the middle of the first branch, 1/m.
fn set(end: &StepResult) -> Vector {
    let all = &friction(end).set;
    all[all.len() / 2]
}

/// A cable that is turned at its end and let go: in one increment, or in forty, its set is the same up to what the
/// minimiser leaves, as every coupling is bent in one direction only.
#[test]
fn the_number_of_increments_does_not_matter_where_all_bends_grow() {
    let text = scenario("analytic/friction_set.toml");
    let of = |increments: &str| converged(&text.replace("increments = 6", increments)).steps;
    for (one, many) in of("increments = 1").iter().zip(&of("increments = 40")) {
        assert!((set(one) - set(many)).norm() <= 1e-7, "{}: {:?} and {:?}", one.name, set(one), set(many));
        let [one, many] = [one, many].map(|end| friction(end).dissipated_in_all);
        assert!((one - many).abs() <= 1e-9, "{one} J and {many} J");
    }
}

/// The initial equilibrium is committed: a cable that is held bent from the beginning was straight before, and keeps
/// the set of that bend.
#[test]
fn a_cable_held_bent_from_the_start_keeps_a_set() {
    let text = scenario("analytic/friction_set.toml");
    let (before, steps) = text.split_once("[[steps]]").expect("steps");
    let turned = "[[constraints]]\nname = \"wrist\"\nkind = \"connector\"\nat = { end = \"B\" }\n\
                  hold = [\"tangent\", \"twist\"]\ntangent = [0, 0, 1]\nup = [-1, 0, 0]\n\n";
    let rest = &steps[steps.find("[[steps]]\nname = \"let go\"").expect("the second step")..];
    let (early, late) = (converged(&format!("{before}{turned}{rest}")), converged(&text));
    for (early, late) in early.steps.iter().zip(&late.steps[1..]) {
        // The initial equilibrium is balanced to the force tolerance of 1e-6 only.
        assert!((set(early) - set(late)).norm() <= 5e-6, "{}: {:?} and {:?}", late.name, set(early), set(late));
        let [early, late] = [early, late].map(|end| friction(end).dissipated_in_all);
        assert!((early - late).abs() <= 1e-7, "{early} J and {late} J");
    }
}

/// A plug that goes out and comes back within one increment: only its end is remembered. In two increments the bend in
/// between is.
#[test]
fn only_ends_of_increments_are_remembered() {
    let out = |increments: usize| {
        let way = "[[steps]]\nname = \"out and back\"\nincrements = INCREMENTS\n[[steps.move]]\n\
                   constraint = \"plug-B\"\nvia = [[0.2, 0, 0.4]]\nposition = [0.6, 0, 0]\n";
        with_friction(&hanging("out", 40, &way.replace("INCREMENTS", &increments.to_string())))
    };
    let [start, once, twice] = [out(1).split("[[steps]]").next().expect("a text").to_owned(), out(1), out(2)]
        .map(|text| converged(&text).steps.pop().expect("a step"));
    let apart = |end: &StepResult| {
        let pairs = friction(end).set.iter().zip(&friction(&start).set);
        pairs.map(|(now, before)| (now - before).norm()).fold(0.0, f64::max)
    };
    // 1/m; the cable is bent by up to 5 1/m.
    assert!(apart(&once) <= 1e-4, "{} 1/m", apart(&once));
    assert!(apart(&twice) > 0.1, "{} 1/m", apart(&twice));
    assert!(friction(&twice).dissipated > 0.0);
}

/// Increments that do not converge at once are halved: what the halves slip does not count twice, nor does what was
/// tried in vain.
#[test]
fn an_increment_that_was_cut_back_is_remembered_once() {
    let text = scenario("analytic/friction_set.toml").replace("increments = 6", "increments = 1");
    let cut = converged(&format!("{text}\n[minimiser]\nmax_iterations = 3\n"));
    assert!(cut.events.iter().any(|event| event.kind == wireloom::result::EventKind::CutBack), "{:?}", cut.events);
    for (cut, whole) in cut.steps.iter().zip(&converged(&text).steps) {
        assert!((set(cut) - set(whole)).norm() <= 1e-6, "{}: {:?} and {:?}", cut.name, set(cut), set(whole));
        let [cut, whole] = [cut, whole].map(|end| friction(end).dissipated_in_all);
        assert!((cut - whole).abs() <= 1e-8, "{cut} J and {whole} J");
    }
}

/// Weight, space, a whole loop: energy is dissipated in every increment or not at all, and adds up.
#[test]
fn energy_is_dissipated_and_never_gained() {
    let ways = [[1.0, 0.3, 0.2, 0.1], [2.0, 0.7, -0.1, -0.2], [3.0, 0.6, 0.0, 0.0], [4.0, 0.3, 0.2, 0.1]];
    let ways = ways.map(|[name, x, y, z]| {
        format!(
            "[[steps]]\nname = \"{name}\"\nincrements = 5\n[[steps.move]]\nconstraint = \"plug-B\"\n\
             position = [{x}, {y}, {z}]\nturns = 0.2\n"
        )
    });
    let text = with_friction(&hanging("loop", 40, &format!("[output]\nincrements = true\n{}", ways.concat())));
    let run = converged(&text);
    let mut total = None;
    for end in &run.steps {
        let FrictionResult { dissipated, dissipated_in_all, .. } = friction(end);
        assert!(*dissipated >= 0.0, "{dissipated} J in {} {}", end.name, end.increment);
        if let Some(before) = total {
            assert_eq!(*dissipated_in_all, before + dissipated, "{} {}", end.name, end.increment);
        }
        total = Some(*dissipated_in_all);
    }
    assert!(total > Some(1e-3), "{total:?} J");
    // The same way twice, and not the same shape: what lies in between is remembered.
    let [first, last] = [4, 19].map(|k| run.steps[k].branches[0].position[20]);
    assert!((first - last).norm() > 1e-3, "{first:?} and {last:?}");
}

/// An elastic section has no friction in its results.
#[test]
fn an_elastic_section_remembers_nothing() {
    let end = converged(&hanging("elastic", 20, "")).steps.pop().expect("a step");
    assert_eq!(end.branches[0].friction, None);
}

/// A harness that is grasped between two steps gets a station, which divides a coupling: each half keeps what the whole
/// remembered, and where the hand lets go again they become one.
#[test]
fn a_grasp_between_two_steps_does_not_make_a_cable_forget() {
    let plain = scenario("analytic/friction_set.toml");
    let hand = "[[steps.add]]\nname = \"hand\"\nkind = \"handle\"\nat = { branch = \"cable\", s = 0.25 }\n";
    let grasped = format!("{plain}\n[[steps]]\nname = \"grasped\"\nincrements = 1\n{hand}");
    let [from, to] = [&plain, &grasped].map(|text| built(text));
    let start = driver(&plain).start(&from.network, None, &from.schedule).expect("a start");
    let turned = advanced(&plain, &start.checkpoint, 0);
    let Some(Transferred::Approximate(there)) = transfer(&turned.checkpoint, &from.network, &to.network) else {
        panic!("not transferred");
    };
    assert!(there.fits(&to.network));
    let there = driver(&plain).balance(&to.network, *there).expect("an equilibrium");
    let let_go = advanced(&grasped, &there, 1);
    let whole = converged(&plain);
    assert!((set(&let_go.end) - set(&whole.steps[1])).norm() <= 1e-5, "{:?}", set(&let_go.end));
    let Some(Transferred::Approximate(back)) = transfer(&let_go.checkpoint, &to.network, &from.network) else {
        panic!("not transferred back");
    };
    let back = driver(&plain).balance(&from.network, *back).expect("an equilibrium");
    let end = advanced(&plain, &advanced(&plain, &back, 2).checkpoint, 3).end;
    assert!((set(&end) - set(&whole.steps[3])).norm() <= 1e-5, "{:?}", set(&end));
    // On another mesh nothing is transferred.
    let finer = built(&plain.replace("segments = 50", "segments = 60"));
    assert_eq!(transfer(&turned.checkpoint, &from.network, &finer.network), None);
}

/// A sweep reaches every number of the elements.
#[test]
fn elements_are_settings_like_any_other() {
    let text = [
        "schema = 1\nname = \"swept\"\n",
        &with_friction(&section("cable")),
        &branch("cable", ["A", "B"], "cable", 0.5, 10),
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
    ]
    .concat();
    let key = "sections.cable.friction.bending.1.moment";
    let settings = [wireloom::scenario::Setting { key: key.to_owned(), value: "0.07".to_owned() }];
    let loaded = wireloom::load_with_settings(&text, &settings, &wireloom::scenario::NoFiles, &wireloom::registry());
    let (scenario, _) = loaded.unwrap_or_else(|faults| panic!("{faults:?}"));
    assert_eq!(scenario.sections[0].friction.bending[1].moment, 0.07);
}

/// The section of the shared cables with keys in place of some of its own, and what was read.
fn section_with(keys: &str) -> (wireloom::scenario::Scenario, Vec<String>) {
    let text = [
        "schema = 1\nname = \"bundle\"\n[sections.cable]\n",
        keys,
        "\n",
        &branch("cable", ["A", "B"], "cable", 0.5, 10),
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
    ]
    .concat();
    let (scenario, built) = wireloom::load(&text, &wireloom::registry())
        .unwrap_or_else(|faults| panic!("{}", wireloom::scenario::render(&text, &faults)));
    (scenario, built.notes)
}

const MEASURED: &str = "diameter = 0.008\nlinear_density = 0.1\naxial_stiffness = 1e4\nbending_stiffness = 0.01\n\
                        torsion_stiffness = 0.01\n";

/// Moment over curvature has its kink at the slip moment, where the section was as many times as stiff as it is beyond.
#[test]
fn slip_moment_and_stiff_ratio_are_the_kink_of_the_moment_over_curvature() {
    let (scenario, _) = section_with(&format!(
        "{MEASURED}friction = {{ slip_moment = \"40 N mm\", stiff_ratio = 4, \
         torsion = [{{ stiffness = 0.002, moment = 0.001 }}] }}"
    ));
    let section = &scenario.sections[0];
    let [element] = section.friction.bending[..] else { panic!("{:?}", section.friction) };
    let kink = element.limit();
    let moment = |curvature: f64| 0.01 * curvature + (element.stiffness * curvature).min(element.moment);
    assert!((moment(kink) - 0.04).abs() < 1e-15, "{kink}");
    assert!((moment(0.5 * kink) / (0.5 * kink) - 4.0 * 0.01).abs() < 1e-15);
    assert!((moment(2.0 * kink) - moment(kink) - 0.01 * kink).abs() < 1e-15);
    assert_eq!(section.friction.torsion.len(), 1);
}

/// What sticks would otherwise be counted twice: as friction, and as cohesion in the elastic stiffness.
#[test]
fn wires_whose_friction_is_given_slide_by_the_rule() {
    let wires = "wires = [{ type = \"FLRY-B 0.5\", count = 24 }]\ncovering = \"pvc tape, half lap\"\n";
    let friction = "friction = { slip_moment = \"40 N mm\", stiff_ratio = 4 }\n";
    let of = |more: &str| section_with(&format!("{wires}{more}"));
    let bending = |more: &str| of(more).0.sections[0].bending_stiffness[0];
    let torsion = |more: &str| of(more).0.sections[0].torsion_stiffness;
    assert_eq!(bending(friction), bending("cohesion = 0\n"));
    assert!(bending(friction) < 0.5 * bending(""));
    assert_eq!(bending(&format!("{friction}cohesion = 0.12\n")), bending(""));
    // Twists do not slip here, and friction in torsion alone leaves bends as they are.
    assert_eq!(torsion(friction), torsion(""));
    assert_eq!(bending("friction = { torsion = [{ stiffness = 0.002, moment = 0.001 }] }\n"), bending(""));
    let (scenario, notes) = of(friction);
    let sticking = scenario.sections[0].sticking_diagonal().x;
    assert!((sticking / bending(friction) - 4.0).abs() < 1e-12);
    assert!(notes[0].ends_with("; EI 0.021 N m² while its wires stick"), "{}", notes[0]);
}
