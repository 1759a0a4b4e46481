//! Cables that pass through each other, or through themselves, while contact is off: events with depth and place.

use wireloom_core::equilibrium::Run;
use wireloom_core::requirement::{Measure, RequirementResult, Verdict};
use wireloom_core::status::Status;
use wireloom_core::{Event, EventKind, Registry};
use wireloom_solve::Control;
use wireloom_solve::steps::checkpoint::IncrementObserver;

const SECTION: &str = r#"
schema = 1
name = "cables"
gravity = [0, 0, 0]
[sections.cable]
diameter = "8 mm"
linear_density = "120 g/m"
axial_stiffness = 2.0e4
bending_stiffness = 0.012
torsion_stiffness = 0.009
"#;

#[track_caller]
fn run(text: &str) -> Run {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    wireloom_shapes::register(&mut registry, None);
    wireloom_solve::register(&mut registry);
    let built = wireloom_scenario::build_with_settings(text, &[], &wireloom_scenario::NoFiles, &registry);
    let (_, built) = built.unwrap_or_else(|faults| panic!("{}", wireloom_scenario::render(text, &faults)));
    let wireloom_scenario::Built { network, coarse, schedule, mut minimiser, stop, .. } = built;
    let observer = &mut IncrementObserver(&mut |_, _| Control::Continue);
    let run =
        wireloom_solve::carry_out(&network, coarse.as_ref(), minimiser.as_mut(), &stop, &schedule, None, observer);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?}", run.notes, run.events);
    run
}

fn passed(run: &Run) -> Vec<&Event> {
    run.events.iter().filter(|event| event.kind == EventKind::PassedThrough).collect()
}

/// The line of the sheet about cables in each other.
fn line(run: &Run) -> &RequirementResult {
    run.requirements.iter().find(|line| line.measure == Measure::Overlap).expect("a line")
}

/// A straight cable between two connectors.
fn straight(name: &str, from: [f64; 3], to: [f64; 3], tangent: [f64; 3], segments: usize) -> String {
    let length = from.iter().zip(to).map(|(a, b)| (b - a) * (b - a)).sum::<f64>().sqrt();
    let mut text = format!(
        "[[branches]]\nname = \"{name}\"\nfrom = \"{name}1\"\nto = \"{name}2\"\nsection = \"cable\"\n\
         length = {length}\nsegments = {segments}\n"
    );
    for (end, at) in [("1", from), ("2", to)] {
        text += &format!(
            "[[constraints]]\nname = \"{name}{end}\"\nkind = \"connector\"\nat = {{ end = \"{name}{end}\" }}\n\
             position = {at:?}\ntangent = {tangent:?}\nup = [0, 0, 1]\n"
        );
    }
    text
}

/// Two straight cables at right angles; the upper one goes down through the other one to `depth` above it.
fn crossed(depth: f64, contact: bool) -> String {
    let [x, y] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let a = straight("a", [-0.1, 0.0, 0.0], [0.3, 0.0, 0.0], x, 33);
    let b = straight("b", [0.02, -0.15, 0.05], [0.02, 0.15, 0.05], y, 30);
    let mut text =
        format!("{SECTION}[contact]\ncables = {contact}\n{a}{b}[[steps]]\nname = \"down\"\nincrements = 10\n");
    for (end, y) in [("b1", -0.15), ("b2", 0.15)] {
        text += &format!("[[steps.move]]\nconstraint = \"{end}\"\nposition = [0.02, {y}, {depth}]\n");
    }
    text
}

/// From 50 mm above to 50 mm below in ten increments: in the fifth the axes meet, 8 mm deep. Nothing told of it.
#[test]
fn cables_that_pass_through_each_other_are_an_event_with_depth_and_place() {
    let run = run(&crossed(-0.05, false));
    let [event] = passed(&run)[..] else { panic!("{:?}", run.events) };
    assert!((event.value.unwrap() - 0.008).abs() < 1e-9 && (event.limit.unwrap() - 0.0008).abs() < 1e-15, "{event:?}");
    assert_eq!((event.worst.increment, event.increments), (5, 1));
    let place = &event.place;
    assert_eq!((place.branch.as_deref(), place.other_branch.as_deref()), (Some("a"), Some("b")));
    assert!((place.s.unwrap() - 0.12).abs() < 1e-6 && (place.other_s.unwrap() - 0.15).abs() < 1e-6, "{place:?}");
    // The sheet says the same, in the same increment.
    let line = line(&run);
    assert_eq!((line.verdict, line.worst, line.limit), (Verdict::Fail, event.value, event.limit.unwrap()));
    assert_eq!((&line.place, line.moment.as_ref()), (place, Some(&event.worst)));
}

/// 0.5 mm of 8 mm is within what soft cables and their measured diameters allow; 1 mm is not.
#[test]
fn soft_cables_may_press_into_each_other_a_little() {
    let little = run(&crossed(0.0075, false));
    assert!(passed(&little).is_empty(), "{:?}", little.events);
    let found = line(&little);
    assert!(found.verdict == Verdict::Pass && (found.worst.unwrap() - 0.0005).abs() < 1e-9, "{found:?}");
    let more = run(&crossed(0.007, false));
    assert!((passed(&more)[0].value.unwrap() - 0.001).abs() < 1e-9, "{:?}", more.events);
}

#[test]
fn cables_kept_apart_by_contact_are_no_event() {
    let run = run(&crossed(0.005, true));
    assert!(passed(&run).is_empty() && line(&run).verdict == Verdict::Pass, "{:?} {:?}", run.events, line(&run));
}

/// A cable that is curved at rest, held at one end: 1.2 turns of a plane ring lie in each other.
#[test]
fn a_cable_that_passes_through_itself_is_an_event() {
    let ring = |turns: f64| {
        let length = turns * std::f64::consts::TAU * 0.1;
        format!(
            "{SECTION}[[branches]]\nname = \"ring\"\nfrom = \"A\"\nto = \"B\"\nsection = \"cable\"\nlength = {length}\n\
             segments = 72\ncurvature = [0, 10, 0]\n[[constraints]]\nname = \"A\"\nkind = \"connector\"\n\
             at = {{ end = \"A\" }}\nposition = [0, 0, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n"
        )
    };
    let run_once = run(&ring(1.2));
    let [event] = passed(&run_once)[..] else { panic!("{:?}", run_once.events) };
    assert!((event.value.unwrap() - 0.008).abs() < 1e-4, "{event:?}");
    assert_eq!((event.place.branch.as_deref(), event.place.other_branch.as_deref()), (Some("ring"), Some("ring")));
    // A turn of the ring lies between the two places.
    let apart = event.place.other_s.unwrap() - event.place.s.unwrap();
    assert!((apart - std::f64::consts::TAU * 0.1).abs() < 0.01, "{apart}");
    // Nine tenths of a turn do not meet.
    assert!(passed(&run(&ring(0.9))).is_empty());
}

/// A trunk with two arms 20° apart: they lie in each other for 23 mm, until they have separated.
fn narrow_fork(steps: &str) -> String {
    let [x, y] = [10_f64.to_radians().cos(), 10_f64.to_radians().sin()];
    let arm = |name: &str, y: f64| {
        format!(
            "[[branches]]\nname = \"{name}\"\nfrom = \"J\"\nto = \"{name}2\"\nsection = \"cable\"\nlength = 0.3\n\
             segments = 60\n[[constraints]]\nname = \"{name}2\"\nkind = \"connector\"\nat = {{ end = \"{name}2\" }}\n\
             position = [{}, {}, 0]\ntangent = [{x}, {y}, 0]\nup = [0, 0, 1]\n",
            0.3 * x,
            0.3 * y
        )
    };
    format!(
        "{SECTION}{}{}{}[[joints]]\nname = \"J\"\nmodel = \"rigid-body\"\narms = [\n\
         {{ branch = \"trunk\", direction = [-1, 0, 0], up = [0, 0, 1] }},\n\
         {{ branch = \"left\", direction = [{x}, {y}, 0], up = [0, 0, 1] }},\n\
         {{ branch = \"right\", direction = [{x}, {}, 0], up = [0, 0, 1] }},\n]\n{steps}",
        "[[branches]]\nname = \"trunk\"\nfrom = \"T\"\nto = \"J\"\nsection = \"cable\"\nlength = 0.2\nsegments = 40\n\
         [[constraints]]\nname = \"T\"\nkind = \"connector\"\nat = { end = \"T\" }\nposition = [-0.2, 0, 0]\n\
         tangent = [1, 0, 0]\nup = [0, 0, 1]\n",
        arm("left", y),
        arm("right", -y),
        -y
    )
}

#[test]
fn arms_that_leave_a_joint_side_by_side_do_not_pass_through_each_other() {
    let run = run(&narrow_fork(""));
    assert!(passed(&run).is_empty() && line(&run).verdict == Verdict::Pass, "{:?} {:?}", run.events, line(&run));
}

/// The same arms cross farther out, beyond the place where they have separated.
#[test]
fn arms_that_cross_beyond_their_joint_do() {
    let mut steps = "[[steps]]\nname = \"cross\"\nincrements = 20\n".to_owned();
    for (name, y) in [("left2", -0.06), ("right2", 0.06)] {
        steps += &format!(
            "[[steps.move]]\nconstraint = \"{name}\"\nposition = [0.27, {y}, 0]\ntangent = [1, {}, 0]\n",
            10.0 * y
        );
    }
    let run = run(&narrow_fork(&steps));
    let [event] = passed(&run)[..] else { panic!("{:?}", run.events) };
    let place = (event.place.branch.as_deref(), event.place.other_branch.as_deref());
    assert_eq!(place, (Some("left"), Some("right")));
    assert!(event.value.unwrap() > 0.0075 && event.place.s.unwrap() > 0.04, "{event:?}");
}
