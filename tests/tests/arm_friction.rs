//! Friction at the arms of a compliant hub in whole runs: when it is remembered, and that nothing leaves it out. Its
//! closed form is `scenarios/analytic/arm_friction.toml`, which is resumed to the bit in `resume.rs`.

use wireloom::geometry::Vector;
use wireloom::result::ArmFriction;
use wireloom::scenario::{NoFiles, Setting};
use wireloom::session::drag::Goal;
use wireloom::session::{Monitor, Session, Transferred, transfer};
use wireloom::{Run, Status, StepResult};
use wireloom_tests::cables::{advanced, branch, built, connector, connector_along, driver, run, section};
use wireloom_tests::derivatives::derivatives;
use wireloom_tests::root;

/// What slips at both arms, of which the first elements slip at small turns.
const FRICTION: &str = "[joints.friction]\nbending = [{ stiffness = 0.2, moment = 0.005 }, \
                        { stiffness = 0.1, moment = 0.01 }]\ntorsion = [{ stiffness = 0.1, moment = 0.002 }]\n";

fn analytic() -> String {
    std::fs::read_to_string(root().join("scenarios/analytic/arm_friction.toml")).expect("a scenario of the repository")
}

/// A sagging cable between A and B with a hub in its middle, the second half of which may run towards the hub.
fn hanging(towards: bool, friction: &str, more: &str) -> String {
    let ends = if towards { ["B", "J"] } else { ["J", "B"] };
    [
        "schema = 1\nname = \"hanging\"\n",
        &section("s"),
        &branch("one", ["A", "J"], "s", 0.4, 20),
        &branch("two", ends, "s", 0.35, 18),
        "[[joints]]\nname = \"J\"\nmodel = \"compliant-hub\"\nbending_stiffness = 0.05\ntorsion_stiffness = 0.03\n\
         mass = 0.02\narms = [\n{ branch = \"one\", direction = [-1, 0, 0], up = [0, 0, 1], offset = [-0.01, 0, 0] },\n\
         { branch = \"two\", direction = [1, 0, 0], up = [0, 0, 1], offset = [0.01, 0, 0.002] },\n]\n",
        friction,
        &connector("plug-A", "A", [0.0; 3]),
        &connector("plug-B", "B", [0.6, 0.0, 0.0]),
        more,
    ]
    .concat()
}

/// Steps to these positions of plug B, each with a fifth of a turn about the cable.
fn ways(positions: &[[f64; 3]], increments: usize) -> String {
    let way = |(k, [x, y, z]): (usize, &[f64; 3])| {
        format!(
            "[[steps]]\nname = \"way {k}\"\nincrements = {increments}\n[[steps.move]]\nconstraint = \"plug-B\"\n\
             position = [{x}, {y}, {z}]\nturns = 0.2\n"
        )
    };
    positions.iter().enumerate().map(way).collect()
}

const WAYS: [[f64; 3]; 4] = [[0.3, 0.2, 0.1], [0.7, -0.1, -0.1], [0.6, 0.0, 0.0], [0.3, 0.2, 0.1]];

#[track_caller]
fn converged(text: &str) -> Run {
    let run = run(text);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?} {:?}", run.notes, run.events, run.fault());
    run
}

fn last(text: &str) -> StepResult {
    converged(text).steps.pop().expect("a step")
}

#[track_caller]
fn friction<'e>(end: &'e StepResult, branch: &str) -> &'e ArmFriction {
    end.joints[0].friction.iter().find(|own| own.branch == branch).expect("it slips")
}

fn refusal(text: &str) -> (String, String) {
    let faults = wireloom::load(text, &wireloom::registry()).err().expect("it is refused");
    (faults[0].message.clone(), faults[0].help.clone())
}

/// An arm that is turned in one direction, in one increment or in twenty, has the same set, up to what the minimiser
/// leaves.
#[test]
fn the_number_of_increments_does_not_matter_where_a_turn_grows() {
    let of = |increments: &str| converged(&analytic().replace("increments = 6", increments)).steps;
    for (one, many) in of("increments = 1").iter().zip(&of("increments = 20")) {
        let [one_arm, many_arm] = [one, many].map(|end| friction(end, "right"));
        assert!((one_arm.set - many_arm.set).norm() <= 1e-9, "{}: {one_arm:?} and {many_arm:?}", one.name);
        let [few, often] = [one_arm, many_arm].map(|arm| arm.dissipated_in_all);
        assert!((few - often).abs() <= 1e-11, "{few} J and {often} J");
    }
}

/// Increments that do not converge at once are halved: what the halves slip does not count twice, nor does what was
/// tried in vain.
#[test]
fn an_increment_that_was_cut_back_is_remembered_once() {
    let text = analytic().replace("increments = 6", "increments = 1");
    let cut = converged(&text.replace("[minimiser]", "[minimiser]\nmax_iterations = 3"));
    assert!(cut.events.iter().any(|event| event.kind == wireloom::result::EventKind::CutBack), "{:?}", cut.events);
    for (cut, whole) in cut.steps.iter().zip(&converged(&text).steps) {
        let [cut_arm, whole_arm] = [cut, whole].map(|end| friction(end, "right"));
        assert!((cut_arm.set - whole_arm.set).norm() <= 1e-9, "{}: {cut_arm:?} and {whole_arm:?}", cut.name);
        assert!((cut_arm.dissipated_in_all - whole_arm.dissipated_in_all).abs() <= 1e-11, "{}", cut.name);
    }
}

/// Weight, space, a whole loop: energy is dissipated at each arm in every increment or not at all, and adds up.
#[test]
fn energy_is_dissipated_at_arms_and_never_gained() {
    let run = converged(&hanging(false, FRICTION, &format!("[output]\nincrements = true\n{}", ways(&WAYS, 5))));
    for arm in ["one", "two"] {
        let mut total = None;
        for end in &run.steps {
            let ArmFriction { dissipated, dissipated_in_all, .. } = friction(end, arm);
            assert!(*dissipated >= 0.0, "{dissipated} J in {} {}", end.name, end.increment);
            if let Some(before) = total {
                assert_eq!(*dissipated_in_all, before + dissipated, "{} {}", end.name, end.increment);
            }
            total = Some(*dissipated_in_all);
        }
        assert!(total > Some(1e-4), "{total:?} J");
    }
    // The same way twice, and not the same shape: what lies in between is remembered.
    let [first, last] = [4, 19].map(|k| run.steps[k].joints[0].position);
    assert!((first - last).norm() > 1e-4, "{first:?} and {last:?}");
}

/// Where time is divided, because a section creeps, arms are committed with every part, and its energies are summed.
#[test]
fn energy_adds_up_where_an_increment_is_divided_in_time() {
    let creep = "torsion_stiffness = 0.008\n[sections.s.creep]\nbending = [{ stiffness = 0.005, time = 20 }]\n";
    let own = section("s").replace("torsion_stiffness = 0.008\n", creep);
    let steps = ways(&WAYS[..2], 2).replace("increments = 2", "increments = 2\nduration = 60");
    let text = hanging(false, FRICTION, &format!("[output]\nincrements = true\n{steps}")).replace(&section("s"), &own);
    let run = converged(&text);
    let mut total = 0.0;
    for (k, end) in run.steps.iter().enumerate() {
        let ArmFriction { dissipated, dissipated_in_all, .. } = friction(end, "two");
        assert!(k == 0 || *dissipated_in_all == total + dissipated, "{dissipated_in_all} J after {total} J");
        total = *dissipated_in_all;
    }
    assert!(total > 1e-4, "{total} J");
}

/// A branch that runs towards the hub has the same set, in its own axes.
#[test]
fn a_branch_that_runs_the_other_way_keeps_the_same_set() {
    let end = |towards: bool| {
        let sign = if towards { -1.0 } else { 1.0 };
        let way = |name: &str, x: f64, y: f64| {
            format!(
                "[[steps]]\nname = \"{name}\"\nincrements = 4\n[[steps.move]]\nconstraint = \"plug-B\"\n\
                 position = [{x}, {y}, {y}]\ntangent = [{sign}, {}, 0]\nup = [0, 0, 1]\n",
                sign * 3.0 * y
            )
        };
        let text = hanging(towards, FRICTION, &[way("there", 0.5, 0.15), way("back", 0.7, 0.0)].concat());
        let plug = connector("plug-B", "B", [0.6, 0.0, 0.0]);
        assert!(text.contains(&plug));
        last(&text.replace(&plug, &connector_along("plug-B", "B", [0.7, 0.0, 0.0], [sign, 0.0, 0.0], [0.0, 0.0, 1.0])))
    };
    let (from, to) = (end(false), end(true));
    let [away, towards] = [&from, &to].map(|end| friction(end, "two").clone());
    assert!(away.set.norm() > 0.05, "{away:?}");
    let turned = Vector::new(towards.set.x, -towards.set.y, -towards.set.z);
    assert!((away.set - turned).norm() < 1e-5, "{away:?} and {towards:?}");
    assert!((away.dissipated_in_all - towards.dissipated_in_all).abs() < 1e-7, "{away:?} and {towards:?}");
}

/// Without friction a joint has none in its results.
#[test]
fn an_elastic_hub_remembers_nothing() {
    assert_eq!(last(&hanging(false, "", "")).joints[0].friction, []);
}

/// What is dragged, undone and dragged again ends in the same bits, and so does the recorded text, run from its start.
#[test]
fn undo_forgets_what_an_arm_remembers_of_a_drag() {
    let text = hanging(false, FRICTION, "");
    let mut session =
        Session::open(&text, Box::new(NoFiles), wireloom::registry(), Monitor::default()).expect("a session");
    let goal = |x: f64, z: f64| Goal { position: Some([x, 0.1, z]), orientation: None };
    let start = session.end().clone();
    session.move_to("plug-B", &goal(0.4, 0.2)).expect("a way");
    let once = session.end().clone();
    assert!(friction(&once, "two").dissipated_in_all > friction(&start, "two").dissipated_in_all);
    session.undo().expect("a drag");
    assert_eq!(session.end().joints, start.joints);
    session.move_to("plug-B", &goal(0.4, 0.2)).expect("a way");
    assert_eq!(session.end().joints, once.joints);
    assert_eq!(last(&session.text().expect("a text")).joints, once.joints);
}

/// A harness that is grasped between two steps gets a station; its arms keep what they remember. A hub without
/// friction cannot take it over.
#[test]
fn a_grasp_between_two_steps_does_not_make_an_arm_forget() {
    let plain = analytic();
    let hand = "[[steps.add]]\nname = \"hand\"\nkind = \"handle\"\nat = { branch = \"right\", s = 0.15 }\n";
    let grasped = format!("{plain}\n[[steps]]\nname = \"grasped\"\nincrements = 1\n{hand}");
    let [from, to] = [&plain, &grasped].map(|text| built(text));
    let start = driver(&plain).start(&from.network, None, &from.schedule).expect("a start");
    let bent = advanced(&plain, &start.checkpoint, 0);
    let Some(Transferred::Approximate(there)) = transfer(&bent.checkpoint, &from.network, &to.network) else {
        panic!("not transferred");
    };
    assert!(there.fits(&to.network));
    let there = driver(&plain).balance(&to.network, *there).expect("an equilibrium");
    let let_go = advanced(&grasped, &there, 1);
    let whole = converged(&plain);
    let [own, other] = [&let_go.end, &whole.steps[1]].map(|end| friction(end, "right").clone());
    assert!((own.set - other.set).norm() <= 1e-6, "{own:?} and {other:?}");
    let element = plain.find("[joints.arms.friction]").expect("friction")..plain.find("[[constraints]]").expect("some");
    let elastic = built(&plain.replace(&plain[element], ""));
    assert!(!bent.checkpoint.fits(&elastic.network));
    assert_eq!(transfer(&bent.checkpoint, &from.network, &elastic.network), None);
}

/// An arm has the friction of its joint, or its own in place of that; a sweep reaches every number.
#[test]
fn elements_of_a_joint_are_those_of_arms_that_give_none() {
    let own = "offset = [0.01, 0, 0.002], friction = { torsion = [{ stiffness = 0.3, moment = 0.004 }] }";
    let text = hanging(false, FRICTION, "").replace("offset = [0.01, 0, 0.002]", own);
    let settings = ["joints.J.friction.bending.1.moment", "joints.J.arms.two.friction.torsion.0.stiffness"]
        .map(|key| Setting { key: key.to_owned(), value: "0.07".to_owned() });
    let loaded = wireloom::load_with_settings(&text, &settings, &NoFiles, &wireloom::registry());
    let (scenario, _) = loaded.unwrap_or_else(|faults| panic!("{faults:?}"));
    let [one, two] = [0, 1].map(|k| scenario.joints[0].arms[k].spring.friction.clone());
    assert_eq!((one.bending.len(), one.torsion.len(), one.bending[1].moment), (2, 1, 0.07));
    assert_eq!((two.bending.len(), two.torsion[0].stiffness, two.torsion[0].moment), (0, 0.07, 0.004));
}

/// A model without friction does not leave it out silently.
#[test]
fn friction_of_arms_is_refused_where_the_model_has_none() {
    for model in ["rigid-body", "cosserat"] {
        let text = hanging(false, FRICTION, "").replace("compliant-hub", model);
        let text = text.replace(", offset = [-0.01, 0, 0] }", " }").replace(", offset = [0.01, 0, 0.002] }", " }");
        let (message, help) = refusal(&text);
        let says = format!(
            "joint \"J\": its arm \"one\" has `friction`, and its model \"{model}\" does not say that it models this"
        );
        assert_eq!(message, says);
        assert_eq!(help, "use model = \"compliant-hub\", or leave `friction` out");
    }
}

/// Elements are checked as those of sections, in the units of an arm.
#[test]
fn elements_of_arms_are_checked() {
    let with = |friction: &str| refusal(&hanging(false, friction, ""));
    let (message, help) = with("[joints.friction]\n");
    assert!(message.contains("has no elements"), "{message}");
    assert!(help.contains("stiffness = \"0.02 N m/rad\""), "{help}");
    let (message, _) = with("[joints.friction]\nbending = [{ stiffness = \"0.02 N m^2\", moment = 0.01 }]\n");
    assert!(message.contains("N m^2"), "{message}");
    let (message, _) = with("[joints.friction]\nbending = [{ stiffness = 0.02, moment = 0 }]\n");
    assert!(message.contains("moment"), "{message}");
}

/// Derivatives are those of the equilibrium with what the arms remember, and say so.
#[test]
fn sensitivities_say_that_the_history_of_arms_is_kept() {
    let kept = |friction: &str| {
        let text = hanging(false, friction, &ways(&[[0.5, 0.0, 0.1]], 2));
        let found = derivatives(&text, &wireloom::registry(), &["energy.total"], &["branches.one.length"], None);
        found.expect("derivatives").keeps_history
    };
    assert!(kept(FRICTION) && !kept(""));
}
