//! Requirements: each is the worst value over a whole run, with its place and time, and no run passes by default.

use std::f64::consts::{PI, TAU};
use wireloom::geometry::Vector;
use wireloom::result::{EventKind, Measure, Origin, RequirementResult, Verdict};
use wireloom::{Control, Run, Status};
use wireloom_tests::cables::{branch, built, connector, connector_along, run, section};

/// Line of the requirement of the file with this name.
fn line<'r>(run: &'r Run, name: &str) -> &'r RequirementResult {
    let found = run.requirements.iter().find(|line| line.name == name);
    found.unwrap_or_else(|| panic!("no line {name} in {:?}", run.requirements))
}

fn close(value: Option<f64>, expected: f64, tolerance: f64) {
    let value = value.expect("a value");
    assert!((value - expected).abs() <= tolerance, "{value} not {expected}");
}

/// A cable of 1 m that hangs in a U between two plugs that point down, 0.6 m apart.
fn hanging(name: &str, more: &str) -> String {
    [
        &*format!("schema = 1\nname = \"{name}\"\n"),
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 1.0, 60),
        &connector_along("plug-A", "A", [0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]),
        &connector_along("plug-B", "B", [0.6, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
        more,
    ]
    .concat()
}

/// A hanging cable whose right plug goes to 0.2 m and back; `more` are requirements.
fn there_and_back(more: &str) -> Run {
    let steps = "[[steps]]\nname = \"in\"\nincrements = 8\n\
                 move = [{ constraint = \"plug-B\", position = [0.2, 0, 0] }]\n\
                 [[steps]]\nname = \"out\"\nincrements = 8\n\
                 move = [{ constraint = \"plug-B\", position = [0.6, 0, 0] }]\n\
                 [output]\nincrements = true\n";
    run(&hanging("there and back", &[steps, more].concat()))
}

/// The end of the run is as harmless as its beginning; what counts is the increment between.
#[test]
fn the_worst_of_all_increments_is_reported_and_not_the_end() {
    let run = there_and_back(
        "[[requirements]]\nname = \"bend\"\nquantity = \"bend_radius\"\nof = { branch = \"cable\" }\nmin = \"150 mm\"\n\
         because = \"sheet 12\"\n",
    );
    assert_eq!(run.status(), Status::Converged);
    let bend = line(&run, "bend");
    let tightest = |step: &wireloom::StepResult| {
        let branch = &step.branches[0];
        let nodes = branch.bend_radius.iter().zip(&branch.s);
        nodes.map(|(r, s)| (*r, *s)).min_by(|a, b| a.0.total_cmp(&b.0)).expect("nodes")
    };
    let all: Vec<(f64, f64)> = run.steps.iter().map(tightest).collect();
    let worst = (0..all.len()).min_by(|a, b| all[*a].0.total_cmp(&all[*b].0)).expect("increments");
    assert!(worst != all.len() - 1 && all[worst].0 < 0.15 && all[all.len() - 1].0 > 0.15, "{all:?}");
    let moment = bend.moment.as_ref().expect("an increment");
    assert_eq!((bend.verdict, bend.worst, bend.place.s), (Verdict::Fail, Some(all[worst].0), Some(all[worst].1)));
    assert_eq!((moment.step.as_str(), moment.increment), (&*run.steps[worst].name, run.steps[worst].increment));
    assert_eq!(bend.because.as_deref(), Some("sheet 12"));
    close(bend.margin(), all[worst].0 / 0.15 - 1.0, 1e-12);
    assert_eq!(run.verdict(), Verdict::Fail);
}

#[test]
fn a_requirement_counts_in_its_steps_only_and_should_decides_nothing() {
    let of =
        |more: &str| format!("[[requirements]]\nname = \"bend\"\nquantity = \"bend_radius\"\nmin = \"150 mm\"\n{more}");
    let run = there_and_back(&of("severity = \"should\"\n"));
    assert_eq!((line(&run, "bend").verdict, run.verdict()), (Verdict::Fail, Verdict::Pass));
    let run = there_and_back(&of("steps = [\"out\"]\n"));
    assert_eq!(line(&run, "bend").moment.as_ref().map(|moment| moment.step.as_str()), Some("out"));
}

/// A path that leaves and comes back within one increment: its ends are harmless, its corner is not.
#[test]
fn a_corner_between_two_increments_is_checked() {
    let steps = "[[steps]]\nname = \"nod\"\nincrements = 1\nmove = [{ constraint = \"plug-B\", via = [[0.2, 0, 0]], \
                 position = [0.6, 0, 0] }]\n[[requirements]]\nname = \"bend\"\nquantity = \"bend_radius\"\n\
                 min = \"150 mm\"\n";
    let run = run(&hanging("nod", steps));
    assert_eq!((run.status(), line(&run, "bend").verdict), (Status::Converged, Verdict::Fail));
}

/// A value that would pass its limit in the next increment is looked at on the way there: the run has more iterations
/// than the same run without the requirement, and the same end.
#[test]
fn where_a_value_changes_fast_it_is_checked_between_increments() {
    let steps =
        "[[steps]]\nname = \"in\"\nincrements = 3\nmove = [{ constraint = \"plug-B\", position = [0.06, 0, 0] }]\n";
    let required = "[[requirements]]\nname = \"bend\"\nquantity = \"bend_radius\"\nmin = \"90 mm\"\n";
    let plain = run(&hanging("in", steps));
    let watched = run(&hanging("in", &[steps, required].concat()));
    let iterations = |run: &Run| run.steps[0].minimiser.iterations;
    assert!(iterations(&watched) > iterations(&plain), "{} and {}", iterations(&watched), iterations(&plain));
    let end = |run: &Run| run.steps[0].branches[0].position[30];
    assert!((end(&watched) - end(&plain)).norm() < 1e-6);
}

/// Balance of a cable that hangs straight down: its weight pulls at the upper end.
#[test]
fn tension_strain_and_reaction_of_a_plumb_line_are_its_weight() {
    let text = [
        "schema = 1\nname = \"plumb\"\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 1.0, 20),
        "path = [[0, 0, 0], [0, 0, -1]]\n",
        "[[constraints]]\nname = \"hook\"\nkind = \"connector\"\nat = { end = \"A\" }\nposition = [0, 0, 0]\n\
         tangent = [0, 0, -1]\nup = [1, 0, 0]\npull_out_force = 0.4\n",
        "[[requirements]]\nname = \"pull\"\nquantity = \"tension\"\nmax = 1\n",
        "[[requirements]]\nname = \"stretch\"\nquantity = \"strain\"\nmax = \"0.1 %\"\n",
        "[[requirements]]\nname = \"way\"\nquantity = \"deviation\"\nmax = \"1 mm\"\n",
        "[[markers]]\nname = \"tip\"\nat = { end = \"B\" }\n[[markers]]\nname = \"middle\"\n\
         at = { branch = \"cable\", s = 0.487 }\n",
    ]
    .concat();
    let run = run(&text);
    let weight = 0.05 * 9.81;
    close(line(&run, "pull").worst, weight, 1e-9);
    assert_eq!((line(&run, "pull").place.s, line(&run, "pull").verdict), (Some(0.0), Verdict::Pass));
    close(line(&run, "stretch").worst, weight / 1e4, 1e-9);
    // It stretches by W L/2 EA.
    close(line(&run, "way").worst, 0.5 * weight / 1e4, 1e-9);
    let hook = line(&run, "hook");
    assert_eq!((hook.origin, hook.measure, hook.verdict), (Origin::Constraint, Measure::Force, Verdict::Fail));
    close(hook.worst, weight, 1e-9);
    let markers = &run.steps[0].markers;
    assert!((markers[0].position - Vector::new(0.0, 0.0, -1.0 - 0.5 * weight / 1e4)).norm() < 1e-9);
    assert!((markers[1].position.z + 0.487).abs() < 5e-5 && markers[1].name == "middle");
}

#[test]
fn torsion_and_turns_of_a_twisted_rod_are_those_prescribed() {
    let text = [
        "schema = 1\nname = \"twist\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.5, 20),
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
        &connector("plug-B", "B", [0.5, 0.0, 0.0]),
        "[[steps]]\nname = \"turn\"\nincrements = 4\nmove = [{ constraint = \"plug-B\", turns = 0.5 }]\n",
        "[[requirements]]\nname = \"torsion\"\nquantity = \"torsion\"\nmax = \"0.9 turns/m\"\n",
        "[[requirements]]\nname = \"turns\"\nquantity = \"turns\"\nmax = \"200 deg\"\n",
    ]
    .concat();
    let run = run(&text);
    // κ = (2/λ)(1 + v²/6) v is 1.6e-5 less than the angle over the length.
    close(line(&run, "torsion").worst, TAU * 0.5 / 0.5, 2e-4);
    close(Some(line(&run, "torsion").limit), 0.9 * TAU, 1e-12);
    close(line(&run, "turns").worst, 0.5, 1e-9);
    let verdicts = ["torsion", "turns"].map(|name| line(&run, name).verdict);
    assert_eq!(verdicts, [Verdict::Fail, Verdict::Pass]);
}

/// The program says "converged" of a cable that is stretched to twice its length, and the sheet that it fails.
#[test]
fn a_plug_out_of_reach_fails_though_it_converges() {
    let steps =
        "[[steps]]\nname = \"out\"\nincrements = 8\nmove = [{ constraint = \"plug-B\", position = [2, 0, 0] }]\n";
    let run = run(&hanging("out of reach", steps));
    let reach = run.requirements.iter().find(|line| line.measure == Measure::Reach).expect("always");
    assert_eq!((run.status(), reach.verdict, run.verdict()), (Status::Converged, Verdict::Fail, Verdict::Fail));
    close(reach.worst, 2.0, 1e-9);
    assert!(reach.margin().expect("a margin") < -0.99);
}

#[test]
fn a_run_that_is_stopped_does_not_pass() {
    let text = hanging(
        "early",
        "[[steps]]\nname = \"in\"\nincrements = 8\nmove = [{ constraint = \"plug-B\", position = [0.4, 0, 0] }]\n\
         [[requirements]]\nname = \"bend\"\nquantity = \"bend_radius\"\nmin = \"1 mm\"\n",
    );
    let stop = |at: usize| {
        let mut control = |progress: &wireloom::session::Progress, _: &_| {
            if progress.increment == at { Control::Stop } else { Control::Continue }
        };
        wireloom::run(built(&text), &mut control)
    };
    let verdict = |run: &Run| (line(run, "bend").verdict, run.verdict());
    assert_eq!(verdict(&stop(9)), (Verdict::Pass, Verdict::Pass));
    let stopped = stop(2);
    assert_eq!(verdict(&stopped), (Verdict::Unresolved, Verdict::Unresolved));
    assert!(line(&stopped, "bend").reason.as_ref().is_some_and(|reason| reason.contains("interrupted")));
}

/// A limit while moving is one thing, and one at rest another: the cable is tight for a moment only.
#[test]
fn bend_limits_in_motion_and_at_rest_are_apart() {
    let of = |name: &str, motion: &str| {
        format!(
            "[[requirements]]\nname = \"{name}\"\nquantity = \"bend_radius\"\nmin = \"150 mm\"\nmotion = \"{motion}\"\n\
             steps = [\"out\"]\n"
        )
    };
    let run = there_and_back(&[of("moving", "moving"), of("rest", "rest")].concat());
    assert_eq!((line(&run, "moving").verdict, line(&run, "rest").verdict), (Verdict::Fail, Verdict::Pass));
}

/// A cable laid on a plane: the plane carries what the plugs do not.
#[test]
fn the_contact_force_of_a_plane_is_the_weight_it_carries() {
    let text = [
        "schema = 1\nname = \"laid\"\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 1.0, 40),
        &connector("plug-A", "A", [0.0, 0.0, 0.003]),
        "[[obstacles]]\nname = \"table\"\nshape = \"plane\"\n",
        "[[requirements]]\nname = \"load\"\nquantity = \"contact_force\"\nof = { obstacle = \"table\" }\nmax = 0.4\n",
        "[[requirements]]\nname = \"pair\"\nquantity = \"contact_force\"\nmax = \"1 N\"\n\
         between = [{ obstacle = \"table\" }, { branches = \"c*\" }]\n",
    ]
    .concat();
    let run = run(&text);
    let carried = run.steps[0].obstacles[0].force.z;
    let load = line(&run, "load");
    assert_eq!(
        (run.status(), load.verdict, load.place.obstacle.as_deref()),
        (Status::Converged, Verdict::Fail, Some("table"))
    );
    close(load.worst, carried, 1e-9);
    close(Some(carried), 0.05 * 9.81 - run.steps[0].constraints[0].force.z, 1e-6);
    close(line(&run, "pair").worst, carried, 1e-9);
}

/// Between the clip at 0.1 m and the plug 0.4 m of cable bridge 0.395 m: also a span of the part from its start to
/// 0.2 m, whose middle is not there.
#[test]
fn the_reach_of_a_part_counts_spans_that_cross_it() {
    let text = [
        "schema = 1\nname = \"part\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.5, 20),
        &connector("wall", "A", [0.0; 3]),
        &connector("plug", "B", [0.48, 0.0, 0.0]),
        "[[constraints]]\nname = \"clip\"\nkind = \"connector\"\nat = { branch = \"cable\", s = 0.1 }\n\
         position = [0.085, 0, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n\
         [[requirements]]\nname = \"taut\"\nquantity = \"reach\"\nof = { branch = \"cable\", to = 0.2 }\nmax = 0.9\n",
    ];
    let run = run(&text.concat());
    close(line(&run, "taut").worst, 0.395 / 0.4, 1e-6);
    assert_eq!(line(&run, "taut").verdict, Verdict::Fail);
}

#[test]
fn slack_and_reach_of_a_half_circle_are_those_of_geometry() {
    let text = [
        "schema = 1\nname = \"arc\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", PI, 200),
        &format!("curvature = [1, 0, 0]\n{}", connector("plug-A", "A", [0.0, 0.0, 0.0])),
        "[[requirements]]\nname = \"slack\"\nquantity = \"slack\"\nmin = 2\n",
        "[[requirements]]\nname = \"reach\"\nquantity = \"reach\"\nmax = 0.6\n",
    ]
    .concat();
    let run = run(&text);
    close(line(&run, "slack").worst, PI - 2.0, 1e-4);
    close(line(&run, "reach").worst, 2.0 / PI, 1e-4);
    assert_eq!((line(&run, "slack").verdict, line(&run, "reach").verdict), (Verdict::Fail, Verdict::Fail));
}

/// A straight cable pushed together: the straight shape is in balance, and no cable would keep it.
#[test]
fn a_span_pressed_straight_beyond_its_buckling_load_fails() {
    let push = |gap: f64| {
        let text = [
            "schema = 1\nname = \"pressed\"\ngravity = [0, 0, 0]\n",
            &section("cable"),
            &branch("cable", ["A", "B"], "cable", 0.2, 20),
            &connector("plug-A", "A", [0.0, 0.0, 0.0]),
            &connector("plug-B", "B", [0.2, 0.0, 0.0]),
            &format!(
                "[[steps]]\nname = \"push\"\nincrements = 4\n\
                 move = [{{ constraint = \"plug-B\", position = [{gap:?}, 0, 0] }}]\n[output]\nincrements = true\n"
            ),
        ]
        .concat();
        run(&text)
    };
    let buckling = |run: &Run| {
        let found = run.requirements.iter().find(|line| line.measure == Measure::Buckling);
        found.expect("always").clone()
    };
    // 4 π² EI/L² = 9.9 N: a strain of 1e-3 in EA = 1e4 N.
    let (euler, harmless) = (4.0 * PI * PI * 0.01 / 0.04, push(0.2 * (1.0 - 0.5e-3)));
    close(buckling(&harmless).worst, 5.0, 1e-6);
    close(Some(buckling(&harmless).limit), 1.1 * euler, 1e-9);
    assert_eq!(harmless.verdict(), Verdict::Pass);
    let pressed = push(0.2 * (1.0 - 2e-3));
    let line = buckling(&pressed);
    // Either it stays straight and fails, or it buckles and bears about its Euler load.
    let straight =
        pressed.steps.iter().any(|step| step.branches[0].position.iter().all(|x| x.z.abs() + x.y.abs() < 1e-9));
    assert_eq!(line.verdict == Verdict::Fail, straight && line.worst > Some(1.1 * euler), "{line:?}");
    assert!(!straight || pressed.verdict() != Verdict::Pass, "{:?}", pressed.requirements);
}

/// A hub of two arms is a rigid part of a column. It was taken for a fixed end where its arms have levers, however
/// short: the limit was that of the longer half, up to four times as large.
#[test]
fn a_hub_with_lever_arms_does_not_divide_a_column() {
    // Ratio of the limit to 1.1 times Euler's load of all cable; cable on both sides of the hub, and its length.
    let ratio = |[before, behind]: [f64; 2], hub: f64, model: &str, more: &str| {
        let length = before + behind + hub;
        let run = run(&[
            "schema = 1\nname = \"hub\"\ngravity = [0, 0, 0]\n",
            &section("cable"),
            &branch("one", ["A", "J"], "cable", before, 20),
            &branch("other", ["B", "J"], "cable", behind, 20),
            &format!(
                "[[joints]]\nname = \"J\"\nmodel = \"{model}\"\narms = [\
                 {{ branch = \"one\", direction = [-1, 0, 0], up = [0, 0, 1], offset = [{:?}, 0, 0]{more} }}, \
                 {{ branch = \"other\", direction = [1, 0, 0], up = [0, 0, 1], offset = [{:?}, 0, 0]{more} }}]\n",
                -0.25 * hub,
                0.75 * hub
            ),
            &connector("plug-A", "A", [0.0; 3]),
            &connector_along("plug-B", "B", [length, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            &format!(
                "[[steps]]\nname = \"push\"\nmove = [{{ constraint = \"plug-B\", position = [{:?}, 0, 0] }}]\n",
                length - 5e-5
            ),
        ]
        .concat());
        let line = run.requirements.iter().find(|line| line.measure == Measure::Buckling).expect("always");
        let cable = before + behind;
        close(line.worst, 1e4 * 5e-5 / cable, 1e-4);
        line.limit / (1.1 * 4.0 * PI * PI * 0.01 / (cable * cable))
    };
    // In the middle it goes sideways without a turn, as long as it likes.
    close(Some(ratio([0.099, 0.099], 0.002, "rigid-body", "")), 1.0, 1e-9);
    close(Some(ratio([0.08, 0.08], 0.04, "rigid-body", "")), 1.0, 1e-9);
    let springs = ", bending_stiffness = 5, torsion_stiffness = 5";
    close(Some(ratio([0.099, 0.099], 0.002, "compliant-hub", springs)), 1.0, 1e-9);
    // Elsewhere: critical loads of beam elements of Hermite, 60 on each side, and how far above them the limit may be.
    for (sides, hub, exact, above) in [
        ([0.05, 0.15], 0.002, 0.980_268, 1e-3),
        ([0.05, 0.15], 0.02, 0.832_986, 0.03),
        ([0.02, 0.18], 0.02, 0.913_428, 0.03),
    ] {
        let found = ratio(sides, hub, "rigid-body", "") / exact;
        assert!((1.0..1.0 + above).contains(&found), "{sides:?} {hub}: {found}");
    }
}

/// A straight cable of 100 mm along z that is held at both ends, without weight.
fn upright(segments: usize, more: &str) -> String {
    [
        "schema = 1\nname = \"upright\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.1, segments),
        &connector_along("plug-A", "A", [0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        &connector_along("plug-B", "B", [0.0, 0.0, 0.1], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        more,
    ]
    .concat()
}

fn sphere(radius: f64, position: [f64; 3], min_clearance: f64) -> String {
    format!(
        "[[obstacles]]\nname = \"ball\"\nshape = \"sphere\"\nradius = {radius}\nposition = {position:?}\n\
         min_clearance = {min_clearance}\n"
    )
}

/// Where a sphere and a cable pass each other, their least distance is known: that of the centre line from the way of
/// the middle. Whatever moves, how long the segments and how few the increments are, it is found; a body that passed
/// was found to be up to 2 % of the radius farther off.
#[test]
fn nothing_passes_a_clearance_between_increments() {
    let radius = 0.003;
    let carried = |x: f64, increments: usize| {
        format!(
            "[[steps]]\nname = \"carry\"\nincrements = {increments}\nmove = [\
             {{ constraint = \"plug-A\", position = [{x}, 0, 0] }}, \
             {{ constraint = \"plug-B\", position = [{x}, 0, 0.1] }}]\n"
        )
    };
    let moved = |to: [f64; 3], increments: usize| {
        format!(
            "[[steps]]\nname = \"move\"\nincrements = {increments}\n\
             move = [{{ obstacle = \"ball\", position = {to:?} }}]\n"
        )
    };
    // Name, segments, radius of the sphere, where it begins, distance at the nearest, and the step.
    type Case<'c> = (&'c str, usize, f64, [f64; 3], f64, Box<dyn Fn(usize) -> String>);
    let cases: [Case<'_>; 4] = [
        ("between two nodes", 6, 0.002, [0.53, 0.009, 0.0425], 0.009, Box::new(move |n| carried(0.6, n))),
        ("after a long way", 40, 0.001, [0.508, 0.0062, 0.0425], 0.0062, Box::new(move |n| carried(1.0, n))),
        ("an obstacle that moves", 20, 0.02, [-0.2, 0.06, 0.05], 0.06, Box::new(move |n| moved([0.37, 0.06, 0.05], n))),
        ("halves of halves", 20, 0.02, [-0.31, 0.05, 0.03], 0.05, Box::new(move |n| moved([0.2, 0.05, 0.03], n))),
    ];
    for (name, segments, ball, at, distance, step) in &cases {
        let least = distance - ball - radius;
        for increments in [1, 2, 3, 7] {
            let verdict = |min: f64| {
                let text = upright(*segments, &(sphere(*ball, *at, min) + &step(increments)));
                let run = run(&text);
                assert_eq!(run.status(), Status::Converged, "{name}");
                let line = line(&run, "ball").clone();
                (line.verdict, line.worst)
            };
            let (kept, value) = verdict(0.9 * least);
            assert_eq!(kept, Verdict::Pass, "{name}, {increments} increments: {value:?}, least {least}");
            let (broken, value) = verdict(1.01 * least);
            assert_eq!(broken, Verdict::Fail, "{name}, {increments} increments: {value:?}, least {least}");
        }
    }
}

/// The tables of clearances and events count the equilibria between increments, as the sheet does.
#[test]
fn clearances_and_events_between_increments_stand_in_their_tables() {
    let pass = "[[steps]]\nname = \"carry\"\nincrements = 1\nmove = [\
                { constraint = \"plug-A\", position = [1, 0, 0] }, \
                { constraint = \"plug-B\", position = [1, 0, 0.1] }]\n\
                [output]\nclearance = true\n";
    let run = run(&upright(40, &(sphere(0.001, [0.508, 0.0062, 0.0425], 0.005) + pass)));
    let worst = line(&run, "ball").worst.expect("a value");
    assert!(worst < 0.005, "{worst}");
    let least = run.clearances.iter().map(|pair| pair.distance).fold(f64::INFINITY, f64::min);
    assert!((least - worst).abs() < 1e-9, "{least} in the table, {worst} in the sheet");
    let event = run.events.iter().find(|event| event.kind == EventKind::Clearance).expect("an event");
    assert!((event.value.expect("a value") - worst).abs() < 1e-9, "{event:?}, {worst} in the sheet");
}

/// A requirement with one limit; `of` is the table of its part, `limit` such as `max = 3.8`.
fn requirement(name: &str, quantity: &str, of: &str, limit: &str) -> String {
    format!("[[requirements]]\nname = \"{name}\"\nquantity = \"{quantity}\"\nof = {of}\n{limit}\n")
}

/// A cable of 1 m and 50 g/m, EI = 0.01 N m², in the direction `along`; a collar at s = 0.6 m alone holds it.
fn held_in_between(gravity: &str, along: [f64; 3], more: &str) -> Run {
    let at = along.map(|x| 0.6 * x);
    let collar = format!(
        "[[constraints]]\nname = \"clip\"\nkind = \"collar\"\nat = {{ branch = \"cable\", s = 0.6 }}\n\
         position = {at:?}\ntangent = {along:?}\ntwist = \"held\"\n"
    );
    let path = format!("path = [[0, 0, 0], {along:?}]\n");
    run(&[
        "schema = 1\nname = \"held in between\"\n",
        gravity,
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 1.0, 20),
        &path,
        &collar,
        more,
    ]
    .concat())
}

/// Below the clip hang 0.4 m, above it stand 0.6 m: it is drawn on one side and pressed on the other. One value is
/// shown for the node, and it must not be the one that decides.
#[test]
fn the_force_on_either_side_of_a_clip_counts() {
    let (hanging, standing) = (0.4 * 0.05 * 9.81, 0.6 * 0.05 * 9.81);
    let all = [
        requirement("drawn", "tension", "{ branch = \"cable\" }", &format!("max = {}", 0.98 * hanging)),
        requirement("pressed", "compression", "{ branch = \"cable\" }", &format!("max = {}", 0.98 * standing)),
        requirement("below", "compression", "{ branch = \"cable\", from = 0.6 }", "max = 0.01"),
        requirement("above", "tension", "{ branch = \"cable\", to = 0.6 }", "max = 0.01"),
    ];
    let run = held_in_between("", [0.0, 0.0, -1.0], &all.concat());
    assert_eq!(run.status(), Status::Converged);
    for (name, verdict, value) in [
        ("drawn", Verdict::Fail, hanging),
        ("pressed", Verdict::Fail, standing),
        ("below", Verdict::Pass, 0.0),
        ("above", Verdict::Pass, 0.0),
    ] {
        let line = line(&run, name);
        assert_eq!(line.verdict, verdict, "{line:?}");
        close(line.worst, value, 1e-6);
    }
}

/// The tip of a cantilever with a small force: the curvature is `P (L − s)/EI` all along it, between nodes too, and on
/// the other side of the clip there is none.
#[test]
fn a_part_has_the_bends_between_its_own_ends() {
    let load = "[[loads]]\nname = \"tip\"\nat = { end = \"A\" }\nforce = [0, 0, 1e-4]\n";
    let of = |from: f64, to: f64| format!("{{ branch = \"cable\", from = {from}, to = {to} }}");
    let all = [
        requirement("part", "bend_radius", &of(0.27, 0.43), "min = 1"),
        requirement("least", "bend_radius", &of(0.27, 0.43), "max = 1"),
        requirement("beyond", "bend_radius", &of(0.6, 1.0), "min = 1"),
        requirement("straight", "bend_radius", &of(0.7, 0.8), "max = 1"),
    ];
    let run = held_in_between("gravity = [0, 0, 0]\n", [1.0, 0.0, 0.0], &[load, &all.concat()].concat());
    let radius = |s: f64| 0.01 / (1e-4 * s);
    close(line(&run, "part").worst, radius(0.43), 1e-3 * radius(0.43));
    close(line(&run, "least").worst, radius(0.27), 1e-3 * radius(0.27));
    assert_eq!((line(&run, "beyond").verdict, line(&run, "beyond").worst), (Verdict::Pass, None));
    // What is straight is not bent to any radius.
    assert_eq!(line(&run, "straight").verdict, Verdict::Fail);
}

/// A shaft of two branches: each has half of the turns, to the joint between them.
#[test]
fn the_turns_of_a_branch_reach_its_joint() {
    let arms = "arms = [{ branch = \"left\", direction = [-1, 0, 0], up = [0, 0, 1] }, \
                { branch = \"right\", direction = [1, 0, 0], up = [0, 0, 1] }]\n";
    let turn = "[[steps]]\nname = \"turn\"\nincrements = 2\nmove = [{ constraint = \"plug-B\", turns = 0.2 }]\n";
    for model in ["cosserat", "fused"] {
        for segments in [5, 20] {
            let run = run(&[
                "schema = 1\nname = \"shaft\"\ngravity = [0, 0, 0]\n",
                &section("cable"),
                &branch("left", ["A", "J"], "cable", 0.3, segments),
                &branch("right", ["J", "B"], "cable", 0.3, segments),
                &format!("[[joints]]\nname = \"J\"\nmodel = \"{model}\"\n{arms}"),
                &connector("plug-A", "A", [0.0; 3]),
                &connector("plug-B", "B", [0.6, 0.0, 0.0]),
                turn,
            ]
            .concat());
            let end = run.steps.last().expect("a step");
            for branch in &end.branches {
                close(Some(branch.twist_turns), 0.1, 1e-6);
            }
        }
    }
}

/// `∫ κ3 ds` of a cable that is bent and twisted at rest is that of its rest curvature, exactly.
#[test]
fn the_turns_of_a_bent_cable_are_the_integral_of_its_twist() {
    let run = run(&[
        "schema = 1\nname = \"helix\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 1.0, 20),
        "curvature = [0, 15, 4]\n",
        &connector("plug-A", "A", [0.0; 3]),
        "[initial]\nbranch = \"cable\"\nposition = [0, 0, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n",
    ]
    .concat());
    let turns = run.steps[0].branches[0].twist_turns;
    // The law of a coupling is wrong by its angle to the fourth power over 300: 0.78 rad here.
    assert!((turns - 4.0 / TAU).abs() < 2e-3 * 4.0 / TAU, "{turns}");
}

/// Cooled by 80 K with 1e-4 /K, a cable that just reached is 0.8 % too short; heated by 1 K, it is longer than its way.
#[test]
fn the_length_of_a_cable_is_that_at_its_temperature() {
    let text = |change: f64| {
        [
            "schema = 1\nname = \"temperature\"\ngravity = [0, 0, 0]\n",
            &section("cable"),
            "thermal_expansion = 1e-4\n",
            &branch("cable", ["A", "B"], "cable", 0.5, 20),
            &connector("plug-A", "A", [0.0; 3]),
            &connector("plug-B", "B", [0.5, 0.0, 0.0]),
            &requirement("slack", "slack", "{ branch = \"cable\" }", "min = 0"),
            &format!("[[steps]]\nname = \"change\"\n[[steps.temperature]]\nchange = {change:?}\n"),
        ]
        .concat()
    };
    for (change, verdict) in [(-80.0, Verdict::Fail), (1.0, Verdict::Pass)] {
        let run = run(&text(change));
        let long = 1.0 + 1e-4 * change;
        let reach = run.requirements.iter().find(|line| line.measure == Measure::Reach).expect("reach");
        assert_eq!(reach.verdict, verdict, "{reach:?}");
        close(line(&run, "slack").worst, 0.5 * (long - 1.0), 1e-9);
        assert_eq!(run.steps.iter().any(|step| !step.violations.is_empty()), change < 0.0);
    }
}

/// With few segments the cable lies beyond the chords between its nodes: the clearance says so with its error.
#[test]
fn a_clearance_from_chords_covers_the_cable_between_them() {
    let text = |segments: usize| {
        let wall = "[[obstacles]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, -0.52]\nnormal = [0, 0, 1]\n\
                    [[requirements]]\nname = \"off\"\nquantity = \"clearance\"\nmin = 0.001\n\
                    between = [{ branch = \"cable\" }, { obstacle = \"floor\" }]\n";
        hanging("chords", wall).replace("segments = 60", &format!("segments = {segments}"))
    };
    let [coarse, fine] = [13, 312].map(|segments| {
        let run = run(&text(segments));
        let line = line(&run, "off");
        (line.worst.expect("a clearance"), line.error.expect("its error"))
    });
    assert!(coarse.0 - fine.0 > 1e-4, "the chords hide nothing: {coarse:?} {fine:?}");
    assert!(coarse.0 - fine.0 < coarse.1, "{coarse:?} {fine:?}");
}

/// The search for the initial equilibrium comes near a sphere that the harness, once in balance, is far away from.
#[test]
fn states_before_the_initial_equilibrium_break_no_clearance() {
    let text = "schema = 1\nname = \"start\"\n\
                [sections.c]\ndiameter = 0.006\nlinear_density = 0.1\naxial_stiffness = 2e4\nbending_stiffness = 0.02\n\
                torsion_stiffness = 0.016\nshear_stiffness = 8000.0\n"
        .to_owned()
        + &branch("a", ["A", "J"], "c", 0.4, 24)
        + &branch("b", ["J", "B"], "c", 0.4, 24)
        + &branch("c", ["J", "C"], "c", 0.4, 24)
        + "[[joints]]\nname = \"J\"\nmodel = \"fused\"\narms = [\
           { branch = \"a\", direction = [-1, 0, 0], up = [0, 0, 1] }, \
           { branch = \"b\", direction = [0.866, 0.5, 0], up = [0, 0, 1] }, \
           { branch = \"c\", direction = [0.866, -0.5, 0], up = [0, 0, 1] }]\n"
        + &connector_along("p", "A", [0.0; 3], [1.4447, -0.4002, 0.2038], [0.0, 0.1, 1.0])
        + &connector_along("q", "B", [0.64069, 0.2139, 0.01439], [0.9015, 0.0044, -0.4095], [0.1, 0.0, 1.0])
        + "[[obstacles]]\nname = \"ball\"\nshape = \"sphere\"\nradius = 0.054236\n\
           position = [0.440269, -0.158158, -0.065069]\n"
        + &requirement("off", "clearance", "{ obstacle = \"ball\" }", "min = 0.005");
    let run = run(&text);
    assert_eq!(run.status(), Status::Converged);
    close(line(&run, "off").worst, 0.1325, 1e-3);
}

/// A moment has no potential; what it does to the errors of other branches goes through the joint all the same.
#[test]
fn under_a_moment_errors_pass_through_joints() {
    let text = |segments: usize| {
        "schema = 1\nname = \"moment\"\n".to_owned()
            + &section("cable")
            + &branch("trunk", ["A", "J"], "cable", 0.6, segments)
            + &branch("arm", ["J", "B"], "cable", 0.3, 60)
            + &branch("other", ["J", "C"], "cable", 0.3, 60)
            + "[[joints]]\nname = \"J\"\nmodel = \"fused\"\narms = [\
               { branch = \"trunk\", direction = [-1, 0, 0], up = [0, 1, 0] }, \
               { branch = \"arm\", direction = [0.8, 0.6, 0], up = [0, 0, 1] }, \
               { branch = \"other\", direction = [0.8, -0.6, 0], up = [0, 0, 1] }]\n"
            + &connector_along("a", "A", [0.0; 3], [0.7, 0.0, 0.7], [0.0, 1.0, 0.0])
            + &connector_along("b", "B", [0.7, 0.22, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0])
            + &connector_along("c", "C", [0.68, -0.2, 0.0], [0.9, -0.1, 0.0], [0.0, 0.0, 1.0])
            + "[[loads]]\nname = \"m\"\nat = { branch = \"other\", s = 0.15 }\nmoment = [0, 1e-4, 0]\n"
            + &requirement("force", "force", "{ constraint = \"b\" }", "max = 10")
            + &requirement("moment", "moment", "{ constraint = \"b\" }", "max = 10")
            + &requirement("bend", "bend_radius", "{ branch = \"arm\" }", "min = 0.001")
    };
    let [coarse, fine] = [8, 128].map(|segments| run(&text(segments)));
    for name in ["force", "moment", "bend"] {
        let [coarse, fine] = [&coarse, &fine].map(|run| line(run, name));
        let (value, error) = (coarse.worst.expect("a value"), coarse.error.expect("an error"));
        let wrong = (value - fine.worst.expect("a value")).abs();
        assert!(wrong > 1e-7 && wrong < error && error < 20.0 * wrong, "{name}: {value} ± {error}, wrong by {wrong}");
    }
}

/// A spring at the middle of a pressed column, as soft as it likes, does not take it out of the check.
#[test]
fn a_soft_spring_supports_no_column() {
    let run = run(&[
        "schema = 1\nname = \"soft\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.2, 20),
        &connector("plug-A", "A", [0.0; 3]),
        &connector("plug-B", "B", [0.2, 0.0, 0.0]),
        "[[constraints]]\nname = \"soft\"\nkind = \"handle\"\nat = { branch = \"cable\", s = 0.1 }\n\
         position = [0.1, 0, 0]\nstiffness = 0.001\n",
        "[[steps]]\nname = \"push\"\nmove = [{ constraint = \"plug-B\", position = [0.1999, 0, 0] }]\n",
    ]
    .concat());
    let line = run.requirements.iter().find(|line| line.measure == Measure::Buckling).expect("always");
    // EA times the strain of 5e-4, and 1.1 · 4 π² EI/L².
    close(line.worst, 5.0, 1e-5);
    close(Some(line.limit), 1.1 * 4.0 * PI * PI * 0.01 / 0.04, 1e-9);
}

/// Between a plug and a hub that is held the cable reaches to the end of the hub's lever arm.
#[test]
fn a_plug_out_of_reach_of_a_held_hub_fails() {
    let text = |plug: f64| {
        [
            "schema = 1\nname = \"hub\"\ngravity = [0, 0, 0]\n",
            &section("cable"),
            &branch("trunk", ["A", "J"], "cable", 0.3, 30),
            &branch("arm", ["J", "B"], "cable", 0.4, 40),
            "[[joints]]\nname = \"J\"\nmodel = \"rigid-body\"\narms = [\
             { branch = \"trunk\", direction = [-1, 0, 0], up = [0, 0, 1], offset = [-0.01, 0, 0] }, \
             { branch = \"arm\", direction = [1, 0, 0], up = [0, 0, 1], offset = [0.01, 0, 0] }]\n",
            "[[constraints]]\nname = \"hub\"\nkind = \"connector\"\nat = { joint = \"J\" }\n\
             position = [0.31, 0, 0]\ntangent = [0, 0, 1]\nup = [1, 0, 0]\n",
            &connector("plug-A", "A", [0.0; 3]),
            &connector("plug-B", "B", [plug, 0.0, 0.0]),
        ]
        .concat()
    };
    for (plug, verdict) in [(0.72, Verdict::Pass), (0.7212, Verdict::Fail)] {
        let run = run(&text(plug));
        let reach = run.requirements.iter().find(|line| line.measure == Measure::Reach).expect("reach");
        assert_eq!(reach.verdict, verdict, "{reach:?}");
    }
}

/// Wind has no potential and is applied last: on its way up the cable passes a ball that it is far from in the end.
#[test]
fn no_clearance_is_broken_while_the_wind_rises_before_the_first_step() {
    let run = run(&[
        "schema = 1\nname = \"wind\"\n",
        &section("cable").replace("50 g/m", "100 g/m"),
        &branch("cable", ["A", "B"], "cable", 1.0, 60),
        &connector_along("plug-A", "A", [0.0; 3], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]),
        &sphere(0.02, [0.0, 0.04, -0.9], 0.03),
        "[[loads]]\nname = \"wind\"\nspan = { branch = \"cable\" }\nflow = { velocity = [20, 0, 0] }\n",
        "[[steps]]\nname = \"hold\"\n",
    ]
    .concat());
    assert_eq!(run.status(), Status::Converged);
    assert_eq!(line(&run, "ball").verdict, Verdict::Pass, "{:?}", line(&run, "ball"));
    assert!(line(&run, "ball").worst > Some(0.3));
}

/// An S between two plugs is straight at its middle, which lies between two nodes of an odd number of segments.
#[test]
fn a_cable_is_straight_where_its_bend_changes_sides() {
    for segments in [24, 25] {
        let text = [
            "schema = 1\nname = \"S\"\ngravity = [0, 0, 0]\n",
            &section("cable"),
            &branch("cable", ["A", "B"], "cable", 0.6, segments),
            &connector("plug-A", "A", [0.0, 0.0, 0.0]),
            &connector("plug-B", "B", [0.591, 0.1, 0.0]),
            &requirement("bent", "bend_radius", "{ branch = \"cable\" }", "max = 200"),
        ];
        let run = run(&text.concat());
        let line = line(&run, "bent");
        assert_eq!(line.verdict, Verdict::Fail, "{segments} segments: {:?}", line.worst);
        assert!(line.worst.expect("a value") > 1e6, "{segments} segments: {:?}", line.worst);
    }
}

/// An arc is as bent between its nodes as at them.
#[test]
fn an_arc_is_not_straighter_between_its_nodes() {
    let text = [
        "schema = 1\nname = \"arc\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.3, 20),
        "curvature = [20, 0, 0]\n",
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
        &requirement("bent", "bend_radius", "{ branch = \"cable\" }", "max = 0.0501"),
    ];
    let run = run(&text.concat());
    let line = line(&run, "bent");
    assert!((line.worst.expect("a value") - 0.05).abs() < 1e-6, "{:?}", line.worst);
    assert_ne!(line.verdict, Verdict::Fail);
}

/// A bar beside a cable turns once about its own middle: it is where it was, and has been at the cable.
#[test]
fn an_obstacle_that_turns_once_in_an_increment_breaks_a_clearance() {
    let pose = "position = [0.1, 0, 0.05]\ntangent = [0, 0, 1]\nup = [0, 1, 0]\n";
    let bar = |size: &str| {
        format!(
            "[[obstacles]]\nname = \"bar\"\nshape = \"box\"\nsize = {size}\n{pose}min_clearance = 0.04\n\
             [[steps]]\nname = \"turn\"\n[[steps.move]]\nobstacle = \"bar\"\n{pose}turns = 1\n"
        )
    };
    // It turns about its tangent, z: along its length, and across it.
    for (size, expected) in [("[0.01, 0.01, 0.12]", Verdict::Pass), ("[0.12, 0.01, 0.01]", Verdict::Fail)] {
        let run = run(&upright(40, &bar(size)));
        assert_eq!(line(&run, "bar").verdict, expected, "{size}: {:?}", line(&run, "bar").worst);
    }
}

/// Two arms that part at a joint and meet again: what counts as near the joint goes by the length of cable, not by
/// whole segments.
#[test]
fn the_clearance_of_arms_of_one_joint_does_not_depend_on_the_mesh() {
    let clearance = |segments: usize| {
        let joint = |name: &str, side: f64, other: &str| {
            format!(
                "[[joints]]\nname = \"{name}\"\nmodel = \"fused\"\narms = [\
                 {{ branch = \"{other}\", direction = [{}, 0, 0], up = [0, 0, 1] }}, \
                 {{ branch = \"one\", direction = [{side}, {side}, 0], up = [0, 0, 1] }}, \
                 {{ branch = \"two\", direction = [{side}, {}, 0], up = [0, 0, 1] }}]\n",
                -side, -side
            )
        };
        let text = [
            "schema = 1\nname = \"loop\"\ngravity = [0, 0, 0]\n",
            &section("cable"),
            &branch("in", ["A", "J"], "cable", 0.2, 20),
            &branch("one", ["J", "K"], "cable", 0.3, segments),
            &branch("two", ["J", "K"], "cable", 0.3, segments),
            &branch("out", ["K", "B"], "cable", 0.2, 20),
            &joint("J", 1.0, "in"),
            &joint("K", -1.0, "out"),
            &connector("plug-A", "A", [0.0, 0.0, 0.0]),
            "[[requirements]]\nname = \"apart\"\nquantity = \"clearance\"\n\
             between = [{ branch = \"one\" }, { branch = \"two\" }]\nmin = 0.001\n",
        ];
        let run = run(&text.concat());
        let line = line(&run, "apart");
        (line.worst.expect("a value"), line.error.expect("an error"))
    };
    let (fine, _) = clearance(192);
    for segments in [12, 24, 48] {
        let (coarse, error) = clearance(segments);
        assert!((coarse - fine).abs() < error.max(0.02 * fine), "{segments}: {coarse} ± {error}, {fine} with 192");
    }
}

/// Where a cable begins to touch is known to a segment: a contact force near its limit is not resolved on a coarse
/// mesh.
#[test]
fn a_contact_force_has_an_error_that_goes_by_the_mesh() {
    let error = |segments: usize| {
        let text = [
            "schema = 1\nname = \"lies\"\n",
            &section("cable"),
            &branch("cable", ["A", "B"], "cable", 1.0, segments),
            &connector("plug-A", "A", [0.0, 0.0, 0.0]),
            "[[obstacles]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, -0.03]\nnormal = [0, 0, 1]\n\
             max_contact_force = 1\n",
        ];
        let run = run(&text.concat());
        let line = line(&run, "floor");
        let force = line.worst.expect("a force");
        assert!(force > 0.1 && force < 0.5, "{force} N of its weight of 0.49 N");
        line.error.expect("an error") / force
    };
    // 2 h/L, and what the bend where it begins to touch adds.
    let (coarse, fine) = (error(10), error(80));
    assert!((0.2..0.35).contains(&coarse) && (0.025..0.03).contains(&fine), "{coarse}, {fine}");
}

/// Plugs push a cable without weight together: it bends out to any side, so that it may touch the ball or not. Its bend
/// radius is the same on all sides. Weight determines where it is, and so it does of a cable between two hands, which
/// only rolls about its own centre line.
#[test]
fn a_clearance_of_a_cable_that_bends_out_to_any_side_is_not_resolved() {
    let verdicts = |gravity: &str, plugs: &[String; 2]| {
        let text = [
            "schema = 1\nname = \"any side\"\n",
            gravity,
            &section("cable"),
            &branch("c", ["A", "B"], "cable", 0.5, 40),
            &plugs.concat(),
            &sphere(0.02, [0.2, 0.3, 0.3], 0.05),
            "[[requirements]]\nname = \"bend\"\nquantity = \"bend_radius\"\nof = { branch = \"c\" }\nmin = 0.02\n\
             [[steps]]\nname = \"hold\"\n",
        ];
        let run = run(&text.concat());
        assert_eq!(run.status(), Status::Converged);
        let clearance = run.requirements.iter().find(|own| own.measure == Measure::Clearance).expect("a clearance");
        (run.steps[0].stable, clearance.verdict, clearance.reason.clone(), line(&run, "bend").verdict)
    };
    let plugs = [connector("A", "A", [0.0; 3]), connector("B", "B", [0.4, 0.0, 0.0])];
    let (stable, clearance, reason, bend) = verdicts("gravity = [0, 0, 0]\n", &plugs);
    assert_eq!((stable, clearance, bend), (None, Verdict::Unresolved, Verdict::Pass), "{reason:?}");
    assert!(reason.is_some_and(|reason| reason.starts_with("nothing determines where the harness is in step `hold`")));
    let (stable, clearance, reason, _) = verdicts("", &plugs);
    assert_eq!((stable, clearance), (Some(true), Verdict::Pass), "{reason:?}");
    let hand = |end: &str, x: f64| {
        format!(
            "[[constraints]]\nname = \"{end}\"\nkind = \"handle\"\nat = {{ end = \"{end}\" }}\nposition = [{x}, 0, 0]\n"
        )
    };
    let (stable, clearance, reason, _) = verdicts("", &[hand("A", 0.0), hand("B", 0.4)]);
    assert_eq!((stable, clearance), (None, Verdict::Pass), "{reason:?}");
}
