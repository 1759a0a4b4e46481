//! The length of the joint `cosserat`: what it does is the same on every mesh, and what closed forms say.

use wireloom::geometry::Vector;
use wireloom::result::EventKind;
use wireloom::{Control, Status, StepResult};
use wireloom_tests::cables::run;

/// Solves a scenario; the end of its last step.
fn solved(text: &str) -> StepResult {
    let mut run = run(text);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?}", run.notes, run.fault());
    run.steps.pop().expect("a step")
}

/// A trunk that splits into two arms, plugged in at three places that bend and twist it in space; `joint` is what
/// stands in the joint beside its arms, `segments` are those of every branch.
fn y_harness(joint: &str, segments: usize) -> String {
    let text = std::fs::read_to_string(wireloom_tests::root().join("scenarios/branches/y_cosserat.toml"));
    let text = text.expect("a scenario of the repository");
    assert!(text.contains("model = \"cosserat\"\n") && text.contains("max_segment = \"10 mm\""));
    text.replace("model = \"cosserat\"\n", &format!("{joint}\n"))
        .replace("max_segment = \"10 mm\"", &format!("segments = {segments}"))
        .replace(
            "position = [0.6, 0.2, 0.05]\ntangent = [1, 0, 0]\nup = [0, 0, 1]",
            "position = [0.55, 0.15, 0.1]\ntangent = [1, 0.5, 0]\nup = [0, 1, 1]",
        )
        + "\n[minimiser]\nforce_tolerance = 1e-10\n"
}

/// A table of wires: this share of the trunk's to each arm.
fn wires(left: f64, right: f64) -> String {
    format!(
        "model = \"cosserat\"\nwires = [{{ between = [\"trunk\", \"left\"], share = {left} }}, \
         {{ between = [\"trunk\", \"right\"], share = {right} }}]"
    )
}

/// Largest distance between the nodes that two meshes of every branch have in common, m.
fn apart(one: &StepResult, other: &StepResult) -> f64 {
    let mut worst = 0.0_f64;
    for (a, b) in one.branches.iter().zip(&other.branches) {
        let (n, m) = (a.position.len() - 1, b.position.len() - 1);
        let (coarse, fine, ratio) = if n < m { (a, b, m / n) } else { (b, a, n / m) };
        assert_eq!(n.max(m), ratio * n.min(m), "meshes that share no nodes");
        for (i, x) in coarse.position.iter().enumerate() {
            worst = worst.max((x - fine.position[i * ratio]).norm());
        }
    }
    worst
}

/// Meshes of 20 to 160 segments a branch: differences fall with the fourth power of the segment length, towards a shape
/// that is not that of the joint `fused`.
#[test]
fn the_joint_comes_to_a_limit_of_its_own_with_fourth_order() {
    for joint in
        ["model = \"cosserat\"".to_owned(), wires(0.9, 0.1), wires(0.3, 0.3), wires(0.9, 0.1) + "\nlength = \"40 mm\""]
    {
        let found = [20, 40, 80, 160].map(|n| solved(&y_harness(&joint, n)));
        let steps = [0, 1, 2].map(|k| apart(&found[k], &found[k + 1]));
        for pair in steps.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((3.6..4.4).contains(&order), "{joint}: order {order:.2}, differences {steps:?}");
        }
        let fused = solved(&y_harness("model = \"fused\"", 160));
        let own = apart(&found[3], &fused);
        assert!(own > 100.0 * steps[2], "{joint}: {own:e} m from fused, meshes {steps:?}");
    }
}

/// The effect of the wires is there on every mesh: 50/50 and 90/10 lie as far apart with 640 segments a branch as with
/// 40.
#[test]
fn anatomy_does_not_vanish_with_refinement() {
    let distance = |n: usize| apart(&solved(&y_harness(&wires(0.5, 0.5), n)), &solved(&y_harness(&wires(0.9, 0.1), n)));
    let (coarse, fine) = (distance(40), distance(640));
    assert!(fine > 1e-3, "{fine:e} m apart");
    assert!((coarse - fine).abs() < 0.02 * fine, "{coarse:e} m apart with 40 segments, {fine:e} m with 640");
}

/// A shorter joint is nearer to the joint `fused`, in proportion to its length.
#[test]
fn a_joint_without_length_is_the_fused_one() {
    let fused = solved(&y_harness("model = \"fused\"", 40));
    let distance =
        |length: &str| apart(&solved(&y_harness(&format!("{}\nlength = \"{length}\"", wires(0.5, 0.5)), 40)), &fused);
    let [long, short, least] = ["4 mm", "2 mm", "0.001 mm"].map(distance);
    assert!((1.9..2.1).contains(&(long / short)), "{long:e} m and {short:e} m from fused");
    assert!(least < 2e-3 * long, "{least:e} m from fused");
}

/// A cable from A to D of 0.4 m and 0.3 m with a joint between them, of a section with three different stiffnesses, its
/// end turned; `joined` is what stands in the joint, or the cable is in one piece.
fn cable(joint: Option<&str>, parts: [usize; 2], more: &str, end: &str) -> String {
    let branch = |name: &str, [from, to]: [&str; 2], length: f64, segments: usize| {
        format!(
            "[[branches]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \"s\"\nlength = {length}\n\
             segments = {segments}\n{more}\n"
        )
    };
    let branches = match joint {
        None => branch("one", ["A", "D"], 0.7, parts[0] + parts[1]),
        Some(joint) => {
            branch("one", ["A", "J"], 0.4, parts[0])
                + &branch("two", ["J", "D"], 0.3, parts[1])
                + &format!(
                    "[[joints]]\nname = \"J\"\n{joint}\narms = [{{ branch = \"one\", direction = [-1, 0, 0], up = [0, \
                     0, 1] }}, \
                     {{ branch = \"two\", direction = [1, 0, 0], up = [0, 0, 1] }}]\n"
                )
        }
    };
    format!(
        "schema = 1\nname = \"cable\"\n[sections.s]\ndiameter = 0.008\nlinear_density = 0.1\naxial_stiffness = 2e4\n\
         bending_stiffness = [0.05, 0.08]\ntorsion_stiffness = 0.03\n{branches}\
         [[constraints]]\nname = \"a\"\nkind = \"connector\"\nat = {{ end = \"A\" }}\nposition = [0, 0, 0]\n\
         tangent = [1, 0, 0]\nup = [0, 0, 1]\n\
         [[constraints]]\nname = \"d\"\nkind = \"connector\"\nat = {{ end = \"D\" }}\n{end}\n\
         [minimiser]\nforce_tolerance = 1e-10\n"
    )
}

/// All wires run through: the cable in two pieces is the cable in one, whatever the joint's length and the mesh, curved
/// at rest or straight.
#[test]
fn a_two_arm_joint_is_the_plain_rod_at_any_length() {
    let end = "position = [0.5, 0.1, 0.1]\ntangent = [0.5, 1, 0]\nup = [0, 0, 1]";
    for (parts, more) in [([4, 3], ""), ([40, 30], ""), ([40, 30], "curvature = [1.0, 2.0, 3.0]")] {
        let plain = solved(&cable(None, parts, more, end));
        let nodes = |step: &StepResult| -> Vec<Vector> {
            let skip = |k: usize| usize::from(k > 0);
            step.branches.iter().enumerate().flat_map(|(k, b)| b.position[skip(k)..].to_vec()).collect()
        };
        let through = "wires = [{ between = [\"one\", \"two\"], share = 1 }]";
        for joint in ["", "length = 1e-6", "length = \"8 mm\"\n", "length = \"150 mm\""]
            .map(|length| format!("{length}\n{through}"))
        {
            let joined = solved(&cable(Some(&joint), parts, more, end));
            let pairs = nodes(&plain).into_iter().zip(nodes(&joined));
            let apart = pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(apart < 1e-10, "{parts:?} {more} {joint}: {apart:e} m apart");
            let moment = (plain.constraints[1].moment - joined.constraints[1].moment).norm();
            assert!(moment < 1e-9, "{parts:?} {more} {joint}: moments {moment:e} N m apart");
        }
    }
}

/// Two arms that share all wires, but meet at an angle or have two stiffnesses, are no plain rod: coupled as neighbours
/// they came to their limit with first order, and with stated errors of a tenth to a thousandth of the real ones.
#[test]
fn two_arms_at_an_angle_or_of_two_sections_come_to_their_limit_with_fourth_order() {
    let end = "position = [0.5, 0.2, 0.1]\ntangent = [0.5, 1, 0]\nup = [0, 0, 1]";
    let through = "wires = [{ between = [\"one\", \"two\"], share = 1 }]";
    let angle = |text: &str| text.replace("direction = [1, 0, 0]", "direction = [1, 0.8, 0.2]");
    let thinner = |text: &str| {
        let two = "name = \"two\"\nfrom = \"J\"\nto = \"D\"\nsection = \"s\"";
        let (before, after) = text.split_once(two).expect("a branch `two`");
        let section = "[sections.thin]\ndiameter = 0.006\nlinear_density = 0.05\naxial_stiffness = 1e4\n\
                       bending_stiffness = [0.01, 0.02]\ntorsion_stiffness = 0.006\n";
        format!("{before}{}{after}{section}", two.replace("\"s\"", "\"thin\""))
    };
    let both = |text: &str| thinner(&angle(text));
    for (what, change) in [("angle", &angle as &dyn Fn(&str) -> String), ("two sections", &thinner), ("both", &both)] {
        let of = |joint: &str, n: usize| solved(&change(&cable(Some(joint), [4 * n, 3 * n], "", end)));
        let limit = of(through, 40);
        // The spring is as stiff as a ten-thousandth of a diameter of each arm.
        let fused = apart(&limit, &of("model = \"fused\"", 40));
        assert!(fused < 1e-6, "{what}: {fused:e} m from fused");
        let errors = [5, 10].map(|n| {
            let found = of(through, n);
            let stated: f64 = found.branches.iter().map(|b| b.error.expect("an estimate").position).fold(0.0, f64::max);
            (apart(&found, &limit), stated)
        });
        let order = (errors[0].0 / errors[1].0).log2();
        assert!(order > 3.4, "{what}: order {order:.2}, {errors:?}");
        assert!(errors.iter().all(|(error, stated)| *error < 1.5 * stated), "{what}: {errors:?}");
    }
}

/// A straight cable of which a share p of the wires runs through a joint of length L, its end turned by a small angle
/// about one axis and free to move: the moment is the same everywhere, so `θ = M (0.7/C + 2 L (1/p − 1)/C)` about d1,
/// d2 and d3.
#[test]
fn compliances_of_cable_and_joint_add_up() {
    let (p, length, angle) = (0.3, 0.03, 0.2_f64);
    let joint = format!("length = {length}\nwires = [{{ between = [\"one\", \"two\"], share = {p} }}]");
    let (c, s) = (angle.cos(), angle.sin());
    let free = "hold = [\"tangent\", \"twist\"]";
    // d1 is z, d2 is d3 × d1 = −y.
    let ends = [
        ("d1", 0.05, format!("tangent = [{c}, {s}, 0]\nup = [0, 0, 1]")),
        ("d2", 0.08, format!("tangent = [{c}, 0, {s}]\nup = [{}, 0, {c}]", -s)),
        ("d3", 0.03, format!("tangent = [1, 0, 0]\nup = [0, {s}, {c}]")),
    ];
    for (about, stiffness, pose) in ends {
        let text = cable(Some(&joint), [40, 30], "", &format!("{free}\n{pose}"))
            .replace("name = \"cable\"", "name = \"cable\"\ngravity = [0, 0, 0]");
        let moment = solved(&text).constraints[1].moment.norm();
        let compliance = (0.7 + 2.0 * length * (1.0 / p - 1.0)) / stiffness;
        let want = angle / compliance;
        // The joint's law is the angle up to its fourth power.
        assert!((moment - want).abs() < 1e-5 * want, "about {about}: {moment} N m instead of {want}");
    }
}

/// A length that the arms do not have is refused at its place, with what would be right.
#[test]
fn a_joint_longer_than_half_its_shortest_arm_is_refused() {
    let text = y_harness("model = \"cosserat\"\nlength = \"200 mm\"", 40);
    let faults = wireloom::load(&text, &wireloom::registry()).err().expect("refused");
    let said = wireloom::scenario::render(&text, &faults);
    for words in ["length = 0.2 m", "its arm `left` is 0.3 m long", "0.15 m here", "49:10: "] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// One file serves all models, so that `compare --joint` can try them.
#[test]
fn every_model_takes_a_file_with_a_length() {
    for model in ["fused", "rigid-body"] {
        let with = solved(&y_harness(&format!("model = \"{model}\"\nlength = \"20 mm\""), 20));
        let without = solved(&y_harness(&format!("model = \"{model}\""), 20));
        assert_eq!(apart(&with, &without), 0.0, "{model}");
    }
}

/// A joint through which few wires run takes nearly all the twist: where it would turn past half a turn, a turn would
/// be lost, and the joint is what is named, not a number of segments.
#[test]
fn a_turn_that_would_be_lost_in_the_wires_of_a_joint_is_told() {
    let joint = "wires = [{ between = [\"one\", \"two\"], share = 0.02 }]";
    let end = "position = [0.7, 0, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]";
    let turned = |turns: f64| {
        let step =
            format!("[[steps]]\nname = \"turn\"\nincrements = 8\nmove = [{{ constraint = \"d\", turns = {turns} }}]\n");
        let text = cable(Some(joint), [20, 20], "", end) + &step;
        let (_, built) = wireloom::load(&text, &wireloom::registry()).expect("no faults");
        wireloom::run(built, &mut |_, _| Control::Continue)
    };
    assert_eq!(turned(0.3).status(), Status::Converged);
    let run = turned(1.0);
    assert_eq!(run.status(), Status::Failed);
    let lost = run.events.iter().find(|event| event.kind == EventKind::TwistLost).expect("an event");
    assert!(lost.message.contains("at the joint with branch `two`: the wires that run"), "{lost:?}");
}
