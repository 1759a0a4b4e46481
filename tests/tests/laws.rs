//! Sections with curves and creep in whole runs: order of the scheme, checkpoints, what else reads their stiffness.

use wireloom::geometry::Vector;
use wireloom::result::Verdict;
use wireloom::{Run, Status};
use wireloom_tests::cables::{branch, connector, connector_along, hanging, run, section};

/// The section of the shared cables with another text in place of one of its lines.
#[track_caller]
fn with(line: &str, law: &str) -> String {
    let plain = section("cable");
    assert!(plain.contains(line), "{line}");
    plain.replace(line, law)
}

#[track_caller]
fn converged(text: &str) -> Run {
    let run = run(text);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?} {:?}", run.notes, run.events, run.fault());
    run
}

/// Moment over curvature that softens: 20 points of `m = 0.012 asinh(κ)`.
fn softening() -> Vec<[f64; 2]> {
    (1..=20).map(|k| 0.5 * f64::from(k)).map(|x| [x, 0.012 * x.asinh()]).collect()
}

const STEM: &str = "schema = 1\nname = \"law\"\ngravity = [0, 0, 0]\n[minimiser]\nforce_tolerance = 1e-9\n";

/// Tip of a cable of 0.6 m with this section, clamped along x, under a dead force at its tip, m.
fn tip(section: &str, segments: usize, force: [f64; 3]) -> Vector {
    let load = format!("[[loads]]\nname = \"pull\"\nat = {{ end = \"B\" }}\nforce = {force:?}\n");
    let cable = branch("cable", ["A", "B"], "cable", 0.6, segments);
    let text = [STEM, section, &cable, &connector("wall", "A", [0.0; 3]), &load].concat();
    let end = converged(&text).steps.pop().expect("a step");
    *end.branches[0].position.last().expect("a node")
}

/// Tip of the same cable without shear or stretch by its differential equation: the angle θ from the tip on, where it
/// has no moment, with `dm/ds = −f × t`, `dθ/ds = κ(m)` by the classical Runge-Kutta method; the angle at the tip is
/// found by bisection so that the clamp is along x. In the plane, κ = sinh(m/0.012) as long as the curve is smooth.
fn tip_by_shooting(force: f64, curvature: impl Fn(f64) -> f64) -> [f64; 2] {
    let steps = 6000;
    let h = 0.6 / f64::from(steps);
    // From the tip to the clamp: (θ, m, x, z).
    let from_tip = |at_tip: f64| {
        let rate = |[angle, moment, ..]: [f64; 4]| {
            let (sin, cos) = angle.sin_cos();
            [-curvature(moment), force * cos, cos, sin]
        };
        let mut y = [at_tip, 0.0, 0.0, 0.0];
        for _ in 0..steps {
            let add = |k: &[f64; 4], f: f64| std::array::from_fn(|i| y[i] + f * k[i]);
            let a = rate(y);
            let b = rate(add(&a, 0.5 * h));
            let c = rate(add(&b, 0.5 * h));
            let d = rate(add(&c, h));
            y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
        }
        y
    };
    let (mut low, mut high) = (0.0, std::f64::consts::FRAC_PI_2);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if from_tip(middle)[0] > 0.0 { high = middle } else { low = middle }
    }
    let [_, _, x, z] = from_tip(high);
    [x, z]
}

/// A cantilever whose section has a curve converges with the second power of the segments to the solution of its
/// differential equation, with either rod.
#[test]
fn a_cantilever_with_a_curve_is_that_of_its_differential_equation() {
    let points = softening();
    // Stretch and shear are below 1e-7, and the round-off of the stiffness is below the errors.
    let law = format!("bending_curve = {points:?}\naxial_stiffness = 1e6\nshear_stiffness = 1e6\n");
    let section = with("bending_stiffness = 0.01\n", &law).replace("axial_stiffness = 1e4\n", "");
    let curve = wireloom::parts::curve::Curve::new(&points, None);
    let [x, z] = tip_by_shooting(0.05, |moment| curve.inverse(moment));
    let exact = Vector::new(x, 0.0, z);
    assert!(z > 0.2, "{z}");
    let errors = [20, 40, 80].map(|segments| (tip(&section, segments, [0.0, 0.0, 0.05]) - exact).norm());
    // From mesh to mesh by 2 to 6, as the kinks of the slope pass the couplings; over both steps by 16.
    assert!((10.0..25.0).contains(&(errors[0] / errors[2])), "{errors:?}");
    assert!(errors[2] < 2e-5, "{errors:?}");
}

/// With a table of points on a line the curve is linear, and everything is as with that stiffness (on the grid of
/// second order: the difference falls with the square of the segments).
#[test]
fn a_straight_table_is_a_stiffness() {
    let plain = tip(&section("cable"), 160, [0.0, 0.0, 0.05]);
    let table = with("bending_stiffness = 0.01\n", "bending_curve = [[1, 0.01], [3, 0.03], [4, 0.04]]\n");
    let apart = [20, 40].map(|segments| (tip(&table, segments, [0.0, 0.0, 0.05]) - plain).norm());
    assert!(apart[1] < 2e-4 && (3.0..5.0).contains(&(apart[0] / apart[1])), "{apart:?}");
}

/// An axial law leaves the scheme at fourth order: a heavy cord that stretches by some percent, held aslant.
#[test]
fn an_axial_law_keeps_the_fourth_order() {
    let law = "axial_curve = [[0.01, 0.2], [0.2, 8], [0.3, 14]]\nshear_stiffness = 40\nlinear_density = 0.2\n";
    let section = with("axial_stiffness = 1e4\n", law).replace("linear_density = 0.2\n", "");
    let section = section.replace("\"50 g/m\"", "\"200 g/m\"");
    let middle = |segments: usize| {
        let text = [
            "schema = 1\nname = \"law\"\n[minimiser]\nforce_tolerance = 1e-10\n",
            &section,
            &branch("cable", ["A", "B"], "cable", 1.0, segments),
            &connector("plug-A", "A", [0.0; 3]),
            &connector("plug-B", "B", [1.1, 0.0, 0.2]),
        ]
        .concat();
        let end = converged(&text).steps.pop().expect("a step");
        let all = &end.branches[0].position;
        let strain = end.branches[0].strain_at(all.len() / 2);
        assert!((0.05..0.3).contains(&strain), "{strain}");
        all[all.len() / 2]
    };
    let [first, second, third, fourth] = [24, 48, 96, 192].map(middle);
    let limit = fourth + (fourth - third) / 15.0;
    let errors = [first, second, third].map(|x| (x - limit).norm());
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    assert!(orders.iter().all(|order| *order > 3.4), "{orders:?} from {errors:?}");
}

/// A strap between two hands that come together is slack: it hangs as a heavy cable does, with its weight at its ends;
/// pulled apart again it is as taut as before. (A slack cable that is stiff in bending pushes its ends apart.)
#[test]
fn a_strap_goes_slack_and_taut_again() {
    let limp = section("cable").replace("bending_stiffness = 0.01", "bending_stiffness = 1e-4");
    let strap = limp.replace("axial_stiffness = 1e4\n", "axial_stiffness = 1e4\ncompression_stiffness = 10\n");
    let ways = [("slack", 0.5), ("taut", 1.002), ("slack again", 0.5), ("taut again", 1.002)];
    let ways = ways.map(|(name, x)| {
        format!(
            "[[steps]]\nname = \"{name}\"\nincrements = 10\n[[steps.move]]\nconstraint = \"plug-B\"\nposition = \
             [{x:?}, 0, 0]\n"
        )
    });
    let text = |section: &str| {
        hanging("strap", 40, &ways.concat()).replace(&wireloom_tests::cables::section("cable"), section)
    };
    let (run, plain) = (converged(&text(&strap)), converged(&text(&limp)));
    let pull = |run: &Run, step: usize| run.steps[step].constraints[1].force;
    for slack in [0, 2] {
        // Its weight is shared by both ends, and is 0.4905 N; where it hangs it is pulled, not pushed.
        assert!((pull(&run, slack).z - 0.25 * 9.81 * 0.1).abs() < 1e-6, "{:?}", pull(&run, slack));
        let apart = (pull(&run, slack) - pull(&plain, slack)).norm();
        assert!(apart < 1e-4, "{:?} instead of {:?}", pull(&run, slack), pull(&plain, slack));
    }
    for taut in [1, 3] {
        // 20 N, less half of 1e-4 EA: it becomes taut over that strain; bending and weight are small beside it.
        assert!((pull(&run, taut).x - pull(&plain, taut).x + 0.5).abs() < 0.02, "{:?}", pull(&run, taut));
    }
    assert!((pull(&run, 1) - pull(&run, 3)).norm() < 1e-5, "{:?} and {:?}", pull(&run, 1), pull(&run, 3));
}

/// Strains of requirements are those of the axial law.
#[test]
fn strain_is_that_of_the_law() {
    let law = "axial_curve = [[0.01, 1], [0.02, 3], [0.03, 8]]\nshear_stiffness = 100\n";
    let section = with("axial_stiffness = 1e4\n", law);
    let rest = "[[loads]]\nname = \"pull\"\nat = { end = \"B\" }\nforce = [3, 0, 0]\n[[requirements]]\n\
                name = \"strain\"\nquantity = \"strain\"\nof = { branch = \"cable\" }\nmax = 0.05\n";
    let cable = branch("cable", ["A", "B"], "cable", 0.6, 12);
    let text = [STEM, &section, &cable, &connector("wall", "A", [0.0; 3]), rest].concat();
    let run = converged(&text);
    let worst = run.requirements.iter().find(|line| line.name == "strain").expect("a requirement");
    assert!((worst.worst.expect("a value") - 0.02).abs() < 1e-9, "{worst:?}");
}

/// The time of a step counts, not that of its increments: what is held relaxes the same in one increment or in thirty.
/// A cable that hangs creeps to the shape of what lasts.
#[test]
fn a_hanging_cable_creeps_to_its_lasting_shape() {
    let creep = "creep = { bending = [{ stiffness = 0.05, time = \"10 min\" }] }\n";
    let section = with("torsion_stiffness = 0.008\n", &format!("torsion_stiffness = 0.008\n{creep}"));
    let wait =
        |increments: usize| format!("[[steps]]\nname = \"a week\"\nincrements = {increments}\nduration = \"7 d\"\n");
    let cantilever = |section: &str, rest: &str| {
        let cable = branch("cable", ["A", "B"], "cable", 0.5, 20);
        let text = ["schema = 1\nname = \"law\"\n", section, &cable, &connector("wall", "A", [0.0; 3]), rest].concat();
        let run = converged(&text);
        run.steps.iter().map(|end| end.branches[0].position[20]).collect::<Vec<_>>()
    };
    let first = cantilever(&section, "")[0];
    let stiff =
        cantilever(&section.replace(creep, "").replace("bending_stiffness = 0.01", "bending_stiffness = 0.06"), "")[0];
    // Linear sections are of fourth order, those that creep of second.
    assert!((first - stiff).norm() < 2e-4, "{first:?} instead of {stiff:?}");
    let lasting = cantilever(&section.replace(creep, ""), "")[0];
    for increments in [1, 30] {
        let end = *cantilever(&section, &wait(increments)).last().expect("a step");
        // In one increment the ramp leaves 10 min of 7 d.
        assert!((end - lasting).norm() < 1e-3, "{end:?} instead of {lasting:?}");
        assert!((end - first).norm() > 0.02, "{end:?} and {first:?}");
    }
}

/// A cable under a constant moment for two hours, in any number of increments: its curvature by the standard linear
/// solid, `M/EI (1 − K/(EI + K) exp(−t EI/((EI + K) T)))`, lies within the stated error, and with it the verdict.
#[test]
fn the_error_of_creep_in_time_is_in_the_sheet() {
    let section = with(
        "torsion_stiffness = 0.008\n",
        "torsion_stiffness = 0.008\ncreep = { bending = [{ stiffness = 0.02, time = \"1 h\" }] }\n",
    );
    let cable = branch("cable", ["A", "B"], "cable", 0.5, 30);
    let held = |increments: usize, limit: f64| {
        let rest = format!(
            "[[loads]]\nname = \"m\"\nat = {{ end = \"B\" }}\nmoment = [0, -0.02, 0]\nfactor = 0\n\
             [[requirements]]\nname = \"bend\"\nquantity = \"bend_radius\"\nof = {{ branch = \"cable\" }}\n\
             min = {limit}\n[[steps]]\nname = \"on\"\n[[steps.load]]\nload = \"m\"\nfactor = 1\n\
             [[steps]]\nname = \"hold\"\nwait = true\nincrements = {increments}\nduration = \"2 h\"\n"
        );
        let run = converged(&[STEM, &section, &cable, &connector("wall", "A", [0.0; 3]), &rest].concat());
        let line = run.requirements.iter().find(|line| line.name == "bend").expect("a requirement").clone();
        (line.verdict, line.worst.expect("a value"), line.error.expect("an error"))
    };
    let bending = 0.01;
    let radius = bending / 0.02 / (1.0 - 2.0 / 3.0 * (-2.0_f64 / 3.0).exp());
    for increments in [1, 2, 7, 60] {
        let (verdict, worst, error) = held(increments, 0.77);
        assert!((worst - radius).abs() <= error, "{increments}: {worst} ± {error} m, not {radius} m");
        // One increment in one piece would be 18 mm off.
        assert!(error < 2e-3, "{increments}: ± {error} m");
        assert_eq!(verdict, Verdict::Fail, "{increments}");
        assert_eq!(held(increments, 0.75).0, Verdict::Pass, "{increments}");
    }
}

/// The same of the twist of a cable: `τ = (M + K q)/(GJ + K)` with `q = M/GJ (1 − exp(−(t/T) GJ/(GJ + K)))`, its turns
/// `τ L/2π`. One increment passed a limit that was exceeded.
#[test]
fn the_error_of_creep_in_time_is_in_the_turns() {
    let section = with(
        "torsion_stiffness = 0.008\n",
        "torsion_stiffness = 0.008\ncreep = { torsion = [{ stiffness = 0.02, time = \"1 h\" }] }\n",
    );
    let cable = branch("cable", ["A", "B"], "cable", 0.5, 30);
    let rest = "[[loads]]\nname = \"m\"\nat = { end = \"B\" }\nmoment = [0.01, 0, 0]\nfactor = 0\n\
         [[requirements]]\nname = \"turns\"\nquantity = \"turns\"\nof = { branch = \"cable\" }\nmax = 1\n\
         [[steps]]\nname = \"on\"\n[[steps.load]]\nload = \"m\"\nfactor = 1\n\
         [[steps]]\nname = \"hold\"\nwait = true\nduration = \"2 h\"\n";
    let run = converged(&[STEM, &section, &cable, &connector("wall", "A", [0.0; 3]), rest].concat());
    let line = run.requirements.iter().find(|line| line.name == "turns").expect("a requirement");
    let (worst, error) = (line.worst.expect("a value"), line.error.expect("an error"));
    let crept = 0.01 / 0.008 * (1.0 - (-2.0_f64 * 0.008 / 0.028).exp());
    let turns = (0.01 + 0.02 * crept) / 0.028 * 0.5 / std::f64::consts::TAU;
    assert!((worst - turns).abs() <= error && error < 1e-3, "{worst} ± {error}, not {turns}");
}

/// A load that goes within an increment leaves what has crept by then.
#[test]
fn a_load_that_goes_in_one_increment_leaves_what_it_leaves_in_many() {
    let section = with(
        "torsion_stiffness = 0.008\n",
        "torsion_stiffness = 0.008\ncreep = { bending = [{ stiffness = 0.05, time = \"10 min\" }] }\n",
    );
    let cable = branch("cable", ["A", "B"], "cable", 0.5, 20);
    let tip = |increments: usize| {
        let rest = format!(
            "[[loads]]\nname = \"pull\"\nat = {{ end = \"B\" }}\nforce = [0, 0, -0.1]\n\
             [[steps]]\nname = \"hold\"\nincrements = {increments}\nduration = \"10 min\"\n\
             [[steps]]\nname = \"off\"\nincrements = {increments}\nduration = \"20 min\"\n\
             [[steps.load]]\nload = \"pull\"\nfactor = 0\n"
        );
        let run = converged(&[STEM, &section, &cable, &connector("wall", "A", [0.0; 3]), &rest].concat());
        let end = run.steps.last().expect("a step");
        (end.branches[0].position[20], end.branches[0].error.as_ref().expect("an error").position)
    };
    let (many, _) = tip(200);
    let (one, error) = tip(1);
    assert!((one - many).norm() <= error, "{one:?} ± {error}, not {many:?}");
    assert!(error < 1e-3, "± {error} m");
}

/// What was dissipated adds up, and is never negative, while a cable is moved, held and let go.
#[test]
fn energy_of_creep_is_dissipated_and_never_gained() {
    let creep = "creep = { bending = [{ stiffness = 0.02, time = \"10 min\" }, { stiffness = 0.01, time = \"2 h\" }], \
                 torsion = [{ stiffness = 0.01, time = 60 }] }\n";
    let way = "[output]\nincrements = true\n[[steps]]\nname = \"move\"\nincrements = 4\nduration = 20\n\
               [[steps.move]]\nconstraint = \"plug-B\"\nposition = [0.3, 0.2, 0.1]\nturns = 0.2\n\
               [[steps]]\nname = \"hold\"\nwait = true\nincrements = 3\nduration = \"1 h\"\n\
               [[steps]]\nname = \"off\"\nincrements = 4\nrelease = [\"plug-B\"]\n\
               duration = \"1 s\"\n";
    let text = hanging("creeps", 30, way).replace(&section("cable"), &format!("{}{creep}", section("cable")));
    let run = converged(&text);
    let mut total = None;
    for end in &run.steps {
        let friction = end.branches[0].friction.as_ref().expect("it creeps");
        assert!(friction.dissipated >= 0.0, "{} J in {} {}", friction.dissipated, end.name, end.increment);
        if let Some(before) = total {
            assert_eq!(friction.dissipated_in_all, before + friction.dissipated, "{} {}", end.name, end.increment);
        }
        total = Some(friction.dissipated_in_all);
    }
    assert!(total > Some(1e-3), "{total:?} J");
}

/// A straight span is judged by the slope of its curve at the origin: that is what it buckles with.
#[test]
fn a_straight_span_buckles_with_the_slope_at_the_origin() {
    let pressed = |section: &str| {
        let rest = "[[steps]]\nname = \"press\"\n[[steps.move]]\nconstraint = \"hand\"\nposition = [0.49999, 0, 0]\n";
        let hand = connector_along("hand", "B", [0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let cable = branch("cable", ["A", "B"], "cable", 0.5, 20);
        let text = [STEM, section, &cable, &connector("wall", "A", [0.0; 3]), &hand, rest].concat();
        let run = converged(&text);
        let line = run.requirements.iter().find(|line| line.measure == wireloom::result::Measure::Buckling);
        line.map(|line| line.limit)
    };
    let table = with("bending_stiffness = 0.01\n", "bending_curve = [[1, 0.01], [3, 0.015], [9, 0.02]]\n");
    assert_eq!(pressed(&table), pressed(&section("cable")));
    assert!(pressed(&table).is_some());
}
