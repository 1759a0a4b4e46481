//! Branches whose section changes along them (`sections`): against closed forms, and against branches that meet in
//! joints there.

use wireloom::geometry::Vector;
use wireloom::result::{BranchResult, EventKind, SlideMotion, Verdict};
use wireloom::{Run, Status};
use wireloom_tests::cables::{branch, connector, connector_along, run, section};

const STEM: &str = "schema = 1\nname = \"changes\"\n[minimiser]\nforce_tolerance = 1e-9\n";
const WEIGHTLESS: &str = "schema = 1\nname = \"changes\"\ngravity = [0, 0, 0]\n[minimiser]\nforce_tolerance = 1e-9\n";

/// A section with three times the stiffness, twice the diameter and mass of [`section`].
fn thick(name: &str) -> String {
    format!(
        "[sections.{name}]\ndiameter = \"12 mm\"\nlinear_density = \"100 g/m\"\naxial_stiffness = 3e4\n\
         bending_stiffness = 0.03\ntorsion_stiffness = 0.024\n"
    )
}

/// With another section between two arc lengths, m.
fn with_part(branch: &str, section: &str, [from, to]: [f64; 2]) -> String {
    format!("{branch}sections = [{{ section = \"{section}\", from = {from:?}, to = {to:?} }}]\n")
}

#[track_caller]
fn converged(text: &str) -> Run {
    let run = run(text);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?} {:?}", run.notes, run.events, run.fault());
    run
}

fn at(branch: &BranchResult, s: f64) -> Vector {
    let node = branch.s.iter().position(|own| (own - s).abs() < 1e-9).expect("a node there");
    branch.position[node]
}

/// A cantilever of two sections under a small force at its tip: `F/3 (((L³ − b³)/EI) + b³/EI′)` with b the length of
/// the stiffer part beside the tip, and by torsion `M (a/GJ + b/GJ′)`. What is left is the square of the slope.
#[test]
fn a_cantilever_of_two_sections_bends_and_twists_as_its_closed_form() {
    let cable = with_part(&branch("cable", ["A", "B"], "thin", 0.6, 60), "thick", [0.25, 0.6]);
    let load = "[[loads]]\nname = \"pull\"\nat = { end = \"B\" }\nforce = [0, 0, 1e-4]\nmoment = [1e-4, 0, 0]\n";
    let wall = connector("wall", "A", [0.0; 3]);
    let stiff = |section: String| section + "shear_stiffness = 1e8\n";
    let text = [WEIGHTLESS, &stiff(section("thin")), &stiff(thick("thick")), &cable, &wall, load].concat();
    let end = &converged(&text).steps[0].branches[0];
    let (a, b, force) = (0.25_f64, 0.35_f64, 1e-4);
    let exact = force / 3.0 * (((a + b).powi(3) - b.powi(3)) / 0.01 + b.powi(3) / 0.03);
    let tip = at(end, 0.6).z;
    assert!((tip - exact).abs() < 1e-5 * exact, "{tip} instead of {exact}");
    let turns = 1e-4 * (a / 0.008 + b / 0.024) / std::f64::consts::TAU;
    assert!((end.twist_turns - turns).abs() < 1e-5 * turns, "{} instead of {turns}", end.twist_turns);
}

/// Short stiff sleeves of one or two segments: the change of curvature beyond their ends, times their stiffness, was
/// taken for an error of the moment. It was 13,000 times the true one, and that of a bend far away half of its radius.
#[test]
fn short_stiff_sleeves_do_not_make_everything_uncertain() {
    let stiff = section("stiff").replace("0.01", "2.5").replace("0.008", "2.0");
    let sleeves = "sections = [{ section = \"stiff\", from = 0.23, to = 0.26 }, \
                   { section = \"stiff\", from = 0.48, to = 0.495 }]\n";
    let clip = "[[constraints]]\nname = \"clip\"\nkind = \"collar\"\nat = { branch = \"cable\", s = 0.488 }\n\
                position = [0.32, 0.1, -0.05]\ntangent = [0.3, 1, 0]\n";
    let of = |segment: &str| {
        let cable = branch("cable", ["A", "B"], "thin", 0.7, 28).replace("segments = 28", segment) + sleeves;
        let plugs = connector_along("A", "A", [0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])
            + &connector_along("B", "B", [0.3, 0.25, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        converged(&[STEM, &section("thin"), &stiff, &cable, &plugs, clip].concat()).steps.remove(0)
    };
    let [coarse, fine] = ["max_segment = 0.025", "max_segment = 0.0025"].map(of);
    let [radius, exact] = [&coarse, &fine].map(|end| end.min_bend_radius.as_ref().expect("it is bent").value);
    let stated = coarse.branches[0].error.as_ref().expect("an estimate");
    let of_radius = stated.bend_radius.expect("it is bent");
    assert!((radius - exact).abs() < of_radius && of_radius < 0.03 * radius, "{radius} ± {of_radius}, {exact}");
    let moment = |end: &wireloom::StepResult| end.constraints.iter().find(|own| own.name == "A").expect("it").moment;
    let off = (moment(&coarse) - moment(&fine)).norm();
    assert!(off < stated.moment && stated.moment < 0.2 * moment(&fine).norm(), "{off} of {}", stated.moment);
}

/// A heavy cable in space: with the change of section within a branch it is that of three branches with fused joints,
/// and of fourth order.
#[test]
fn a_branch_of_parts_is_the_same_as_branches_that_are_fused() {
    let sections = [STEM, &section("thin"), &thick("thick")].concat();
    let plugs = connector("plug-A", "A", [0.0; 3])
        + &connector_along("plug-B", "B", [0.4, 0.2, 0.05], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let of_parts = |segments: usize| {
        let cable = with_part(&branch("cable", ["A", "B"], "thin", 0.7, segments), "thick", [0.18, 0.42]);
        converged(&[&*sections, &cable, &plugs].concat()).steps.pop().expect("a step")
    };
    let ends = [["A", "P"], ["P", "Q"], ["Q", "B"]];
    let kinds = [("thin", 0.18, 18), ("thick", 0.24, 24), ("thin", 0.28, 28)];
    let pieces = ends.into_iter().zip(kinds).zip(["first", "second", "third"]);
    let pieces: String =
        pieces.map(|((ends, (section, length, n)), name)| branch(name, ends, section, length, n)).collect();
    let joint = |name: &str, [before, after]: [&str; 2]| {
        format!(
            "[[joints]]\nname = \"{name}\"\nmodel = \"fused\"\narms = [{{ branch = \"{before}\", direction = [-1, 0, \
             0], up = [0, 0, 1] }}, {{ branch = \"{after}\", direction = [1, 0, 0], up = [0, 0, 1] }}]\n"
        )
    };
    let joints = joint("P", ["first", "second"]) + &joint("Q", ["second", "third"]);
    let fused = converged(&[&*sections, &pieces, &joints, &plugs].concat()).steps.pop().expect("a step");
    let one = of_parts(70);
    for (branch, start, s) in [(0, 0.0, 0.1), (1, 0.18, 0.0), (1, 0.18, 0.12), (2, 0.42, 0.0), (2, 0.42, 0.08)] {
        let difference = (at(&fused.branches[branch], s) - at(&one.branches[0], start + s)).norm();
        assert!(difference < 1e-8, "{difference} m at {} m", start + s);
    }
    let [first, second] = [&one, &fused].map(|end| end.constraints[0].force);
    assert!((first - second).norm() < 1e-7, "{first} and {second}");
    let finest = of_parts(560);
    let error = |end: &wireloom::result::StepResult| (at(&end.branches[0], 0.3) - at(&finest.branches[0], 0.3)).norm();
    let [coarse, fine] = [error(&of_parts(35)), error(&one)];
    assert!(fine < coarse / 12.0, "{coarse} and {fine} m with half the segments");
    let stated = one.branches[0].error.as_ref().expect("an estimate").position;
    assert!(fine < stated && stated < 30.0 * fine, "{stated} m is stated, {fine} m is wrong");
}

/// At the change both sections have the same moment, so the thinner one bends more tightly; each is held to its own
/// limit.
#[test]
fn each_section_is_held_to_its_own_limits() {
    let limit = |section: String, radius: &str| format!("{section}min_bend_radius = \"{radius}\"\n");
    let sections = [STEM, &limit(section("thin"), "20 mm"), &limit(thick("thick"), "100 mm")].concat();
    let plugs = connector("plug-A", "A", [0.0; 3])
        + &connector_along("plug-B", "B", [0.3, 0.2, 0.05], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let cable = with_part(&branch("cable", ["A", "B"], "thin", 0.7, 140), "thick", [0.3, 0.4]);
    let run = converged(&[&*sections, &cable, &plugs].concat());
    let branch = &run.steps[0].branches[0];
    let sides = branch.sides.iter().find(|own| (branch.s[own.node] - 0.4).abs() < 1e-9).expect("both sides");
    let [thick, thin] = sides.bend_radius;
    assert!((thick / thin - 3.0).abs() < 1e-6, "{thick} and {thin} m");
    assert!(thin < 0.1 && thick > 0.1, "{thick} and {thin} m: the test would tell nothing");
    let line = |name: &str| run.requirements.iter().find(|line| line.name == name).expect("its limit");
    let [of_thin, of_thick] = [line("thin"), line("thick")];
    assert_eq!([of_thin.verdict, of_thick.verdict], [Verdict::Pass; 2], "{of_thin:?} {of_thick:?}");
    let s = of_thick.place.s.expect("a place");
    assert!((0.3 - 1e-9..0.4 + 1e-9).contains(&s) && of_thick.worst > Some(0.1), "{of_thick:?}");
    // The tighter side counts, also where both are not known, as in results that are read.
    let read = BranchResult { sides: Vec::new(), ..branch.clone() };
    assert_eq!([branch, &read].map(|own| own.bend_radius_limit_at(sides.node)), [Some(0.02); 2]);
    assert_eq!(branch.bend_radius_limit_at(sides.node - 1), Some(0.1));
    // The worst value of the thin parts is beside the tube or elsewhere, never within it.
    let s = of_thin.place.s.expect("a place");
    assert!(!(0.3 + 1e-9..0.4 - 1e-9).contains(&s), "{of_thin:?}");
}

/// Beside a stiff sleeve a cable bends a thousand times as tightly as that does: its error would be all that is known
/// of the sleeve.
#[test]
fn the_error_of_a_soft_part_is_not_that_of_the_stiff_part_beside_it() {
    let stiff = thick("sleeve").replace("0.03", "10.0").replace("0.024", "8.0") + "min_bend_radius = \"30 m\"\n";
    let plugs = connector("plug-A", "A", [0.0; 3])
        + &connector_along("plug-B", "B", [0.3, 0.2, 0.05], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let line = |segments: usize| {
        let cable = with_part(&branch("cable", ["A", "B"], "thin", 0.7, segments), "sleeve", [0.3, 0.4]);
        let run = converged(&[STEM, &section("thin"), &stiff, &cable, &plugs].concat());
        run.requirements.into_iter().find(|line| line.name == "sleeve").expect("its limit")
    };
    let [coarse, fine] = [21, 280].map(line);
    assert_eq!(coarse.verdict, Verdict::Pass, "{coarse:?}");
    let [off, stated] = [(coarse.worst.unwrap() - fine.worst.unwrap()).abs(), coarse.error.unwrap()];
    assert!(off < stated && stated < 0.3 * coarse.worst.unwrap(), "{off} m off, {stated} m stated: {coarse:?}");
}

/// A straight cable beside a wall: its clearance is that of the thicker part where that is, and where the wall touches
/// the thin part alone, that of the thin one. The same between two cables.
#[test]
fn a_cable_is_as_far_from_a_wall_as_its_section_there_is_thick() {
    let cable = |name: &str, ends: [&str; 2], y: f64, part: [f64; 2]| {
        let [start, end] = [[0.0, y, 0.0], [0.5, y, 0.0]];
        with_part(&branch(name, ends, "thin", 0.5, 50), "thick", part)
            + &connector(&format!("{name} start"), ends[0], start)
            + &connector(&format!("{name} end"), ends[1], end)
    };
    let wall = |name: &str, x: f64| {
        format!(
            "[[obstacles]]\nname = \"{name}\"\nshape = \"box\"\nsize = [0.02, 0.02, 0.02]\nposition = [{x}, 0, 0.03]\n"
        )
    };
    let text = [
        WEIGHTLESS,
        "[contact]\ncables = true\n",
        &section("thin"),
        &thick("thick"),
        &cable("cable", ["A", "B"], 0.0, [0.2, 0.4]),
        &cable("other", ["C", "D"], 0.03, [0.1, 0.15]),
        &wall("at the thin part", 0.05),
        &wall("at the thick part", 0.3),
        "[[requirements]]\nname = \"apart\"\nquantity = \"clearance\"\nbetween = [{ branch = \"cable\" }, { branch = \
         \"other\" }]\nmin = \"1 mm\"\n",
        "[[requirements]]\nname = \"thin\"\nquantity = \"clearance\"\nbetween = [{ branch = \"cable\" }, { obstacle = \
         \"at the thin part\" }]\nmin = \"1 mm\"\n",
        "[[requirements]]\nname = \"thick\"\nquantity = \"clearance\"\nbetween = [{ branch = \"cable\" }, { obstacle = \
         \"at the thick part\" }]\nmin = \"1 mm\"\n",
    ]
    .concat();
    let run = converged(&text);
    let worst = |name: &str| {
        let line = run.requirements.iter().find(|line| line.name == name).expect("its line");
        line.worst.expect("a worst value")
    };
    for (name, exact) in [("thin", 0.02 - 0.003), ("thick", 0.02 - 0.006), ("apart", 0.03 - 0.003 - 0.006)] {
        assert!((worst(name) - exact).abs() < 1e-9, "{name}: {} m instead of {exact} m", worst(name));
    }
}

/// Two tubes press into each other by 1.5 mm, of 2 mm that they may; the bare cables beside them by 1 mm, of 0.4 mm.
/// The deepest place alone was looked at.
#[test]
fn thin_parts_that_lie_in_each_other_are_seen_beside_tubes_that_press_deeper() {
    let thin = section("thin").replace("6 mm", "4 mm");
    let tube = thick("tube").replace("12 mm", "20 mm");
    let straight = |name: &str, [start, end]: [&str; 2], y: [f64; 2]| {
        let way = Vector::new(0.5, y[1] - y[0], 0.0);
        let tangent = way.normalize();
        let plug = |vertex: &str, x: f64, y: f64| {
            connector_along(&format!("plug {vertex}"), vertex, [x, y, 0.0], tangent.into(), [0.0, 0.0, 1.0])
        };
        with_part(&branch(name, [start, end], "thin", way.norm(), 100), "tube", [0.1, 0.2])
            + &plug(start, 0.0, y[0])
            + &plug(end, 0.5, y[1])
    };
    // 18.5 mm apart at 0.2 m, and 3 mm at the end.
    let slope = 0.0155 / 0.3;
    let other = straight("other", ["C", "D"], [0.0185 + 0.2 * slope, 0.003]);
    let run = converged(&[WEIGHTLESS, &thin, &tube, &straight("cable", ["A", "B"], [0.0; 2]), &other].concat());
    let line = run.requirements.iter().find(|line| line.name == "cables lie side by side").expect("its line");
    assert_eq!(line.verdict, Verdict::Fail, "{line:?}");
    let (depth, s) = (line.worst.expect("a depth"), line.place.s.expect("a place"));
    assert!((depth - 0.001).abs() < 1e-5 && s > 0.48 && (line.limit - 0.0004).abs() < 1e-9, "{line:?}");
}

/// A clamped column whose middle half is ten times as stiff buckles at 3.126 times Euler's load of its soft ends (beam
/// elements, 64 of them). What bounds it was 1.76 times that.
#[test]
fn a_column_with_a_stiff_middle_does_not_bear_what_its_mean_stiffness_would() {
    let stiff = thick("stiff").replace("0.03", "0.1");
    let column = with_part(&branch("cable", ["A", "B"], "thin", 0.5, 80), "stiff", [0.125, 0.375]);
    let plugs = connector("plug-A", "A", [0.0; 3]) + &connector("plug-B", "B", [0.49998, 0.0, 0.0]);
    let run = converged(&[WEIGHTLESS, &section("thin"), &stiff, &column, &plugs].concat());
    let line = run.requirements.iter().find(|line| line.name == "straight spans do not buckle").expect("its line");
    let exact = 3.126 * 4.0 * std::f64::consts::PI.powi(2) * 0.01 / 0.25;
    assert!(line.worst > Some(0.1) && line.verdict == Verdict::Pass, "{line:?}");
    // The bound is 1.09 times the exact load, and 1.1 times that is beyond what a buckled column bears.
    assert!(line.limit > 1.1 * exact && line.limit < 1.1 * 1.1 * exact, "{} N, exactly {exact} N", line.limit);
}

/// A cable between plugs just above a table lies on it with its thick part alone, at the radius of that.
#[test]
fn a_thick_part_lies_on_a_table_at_its_own_radius() {
    let cable = with_part(&branch("cable", ["A", "B"], "thin", 0.4, 80), "thick", [0.1, 0.3]);
    let plugs = connector("plug-A", "A", [0.0, 0.0, 0.006]) + &connector("plug-B", "B", [0.4, 0.0, 0.006]);
    let table = "[[obstacles]]\nname = \"table\"\nshape = \"box\"\nsize = [1, 1, 0.1]\nposition = [0, 0, -0.05]\n";
    let end = converged(&[STEM, &section("thin"), &thick("thick"), &cable, &plugs, table].concat());
    let end = end.steps.last().expect("a step");
    let branch = &end.branches[0];
    for (s, x) in branch.s.iter().zip(&branch.position) {
        let deepest = if (0.1..=0.3).contains(s) { 0.006 - 1e-6 } else { 0.003 };
        assert!(x.z > deepest && x.z < 0.006 + 1e-5, "{} m at {s} m", x.z);
    }
    // The plugs take the weight of the thin parts and of the first of the thick one.
    let (thick, all) = (9.81 * 0.2 * 0.1, 9.81 * (0.2 * 0.1 + 0.2 * 0.05));
    let force = end.obstacles[0].force.z;
    assert!(force > 0.9 * thick && force < all, "{force} N of {thick} and {all} N");
}

/// A cable that is drawn through a ring runs up to where its section changes: what is behind does not fit, as far as is
/// known. An event tells it.
#[test]
fn a_cable_runs_through_a_ring_up_to_where_its_section_changes() {
    let cable = with_part(&branch("cable", ["A", "B"], "thin", 0.5, 50), "thick", [0.3, 0.5]);
    let ring = "[[constraints]]\nname = \"ring\"\nkind = \"loose-tie\"\nposition = [0.24, 0, -0.02]\n\
                at = { branch = \"cable\", s = 0.25 }\n";
    let step = "[[steps]]\nname = \"drawn\"\nincrements = 20\n\
                [[steps.move]]\nconstraint = \"plug-A\"\nposition = [-0.06, 0, 0]\n";
    let text =
        [STEM, &section("thin"), &thick("thick"), &cable, &connector("plug-A", "A", [0.0; 3]), ring, step].concat();
    let run = converged(&text);
    let stopped = run.events.iter().find(|event| event.kind == EventKind::SlideStop).expect("it is told");
    assert_eq!(stopped.place.constraint.as_deref(), Some("ring"));
    let slide = run.steps[0].constraints[1].slide.as_ref().expect("it slides");
    assert!(slide.arc_length < 0.3 && slide.arc_length > 0.299, "{}", slide.arc_length);
    assert_eq!(slide.motion, SlideMotion::Stopped);
}
