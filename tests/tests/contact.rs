//! Cables that touch obstacles and each other, by the whole program: closed forms, and random scenes.

use std::f64::consts::PI;
use wireloom::geometry::{Rotation, Vector};
use wireloom::result::EventKind;
use wireloom::scenario::NoFiles;
use wireloom::session::drag::Goal;
use wireloom::session::{Monitor, Session, SessionError};
use wireloom::{Run, Status, StepResult};
use wireloom_tests::cables::{branch, connector, run, section};

/// A scenario of `scenarios/contact`, in which some texts are replaced; it must converge.
#[track_caller]
fn converged(name: &str, changes: &[(&str, &str)]) -> Run {
    let path = wireloom_tests::root().join("scenarios/contact").join(name);
    let mut text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    for (from, to) in changes {
        assert!(text.contains(from), "{name} says {from}");
        text = text.replace(from, to);
    }
    let run = run(&text);
    assert_eq!(run.status(), Status::Converged, "{name}: {:?} {:?}", run.notes, run.events);
    run
}

fn force(step: &StepResult, constraint: &str) -> Vector {
    step.constraints.iter().find(|c| c.name == constraint).expect("a constraint of this name").force
}

/// With l the length that hangs free, `l⁴ = 72 EI h/q`, the clamp bears `2 q l/3` and the floor all else: of small
/// slopes, to a hundredth.
#[test]
fn a_heavy_cable_lies_on_a_plane_as_a_beam_does() {
    let (q, h, ei, length) = (0.12 * 9.81, 0.006, 0.05, 1.2);
    let free = (72.0_f64 * ei * h / q).powf(0.25);
    let run = converged("cable_on_plane.toml", &[]);
    let step = &run.steps[0];
    let (held, floor) = (force(step, "plug-A").z, step.obstacles[0].force.z);
    assert!((held - 2.0 * q * free / 3.0).abs() < 0.01 * held, "{held} N held, {} N expected", 2.0 * q * free / 3.0);
    assert!((held + floor - q * length).abs() < 1e-6 * q * length, "{held} N + {floor} N");
    // Where it comes down: the floor pushes the nodes beyond it.
    let cable = &step.branches[0];
    let down = cable.s.iter().zip(&cable.position).find(|(_, x)| x.z < 0.004).expect("it comes down").0;
    assert!((down - free).abs() < 0.02 * free + 0.005, "down at {down} m, {free} m expected");
    assert!(cable.position.iter().all(|x| x.z > 0.004 * (1.0 - 1e-3)), "nothing is below the floor");
    // What comes to touch is foreseen: 253 where every step found out anew, 21 now.
    assert!(step.minimiser.iterations < 50, "{} iterations", step.minimiser.iterations);
}

/// Euler 1762, Eytelwein 1793: it slips where the pulls are as `exp(μ θ)`.
#[test]
fn a_cable_slips_on_a_drum_at_the_pull_of_the_capstan() {
    let run = converged("capstan.toml", &[]);
    let step = run.steps.last().expect("steps");
    let (ratio, expected) = (-force(step, "hand").z / 2.0, (0.2 * PI).exp());
    assert!((ratio / expected - 1.0).abs() < 0.02, "{ratio}, {expected} expected");
}

/// A clamped rod that is pressed in a tube touches the wall, at its middle, at `P = 4 π² EI/L²` (Feodosyev's problem;
/// Chen and Li 2007). Each half then is a beam-column from the axis to the clearance h, horizontal at both ends: with
/// `k² = P/EI`, `u = k L/4` and ξ from its middle `y = a (sin kξ − kξ cos u)`, `a = h/(2 sin u − 2 u cos u)`; its ends
/// bear `P k a cos u` each, so that the wall pushes with `F = 4 P h u/(L (u − tan u))`, up to `u = π` where the rod
/// comes to lie flat against it. It shortens by `a² k² (L/4 + (L/2) cos² u − 3 sin u cos u/k) + P L/EA`. Of small
/// slopes: here up to 0.04, whose square is 0.15 %, and a mesh of 100 segments. At 12 π² EI/L² it would rather leave
/// the plane.
#[test]
fn a_rod_pressed_in_a_tube_lies_against_its_wall_as_a_beam_column_does() {
    let (ei, ea, length, h) = (0.012, 2e4, 1.0, 0.012);
    let pressed = |p: f64| {
        let k = (p / ei).sqrt();
        let u = 0.25 * k * length;
        let a = h / (2.0 * (u.sin() - u * u.cos()));
        let slopes = 0.25 * length + 0.5 * length * u.cos().powi(2) - 3.0 * u.sin() * u.cos() / k;
        let wall = 4.0 * p * h * u / (length * (u - u.tan()));
        (a * a * k * k * slopes + p * length / ea, wall)
    };
    for times in [5.0, 6.5, 8.0] {
        let p = times * PI * PI * ei / length.powi(2);
        let (shortening, _) = pressed(p);
        let to = format!(
            "increments = 4\n[[steps.move]]\nconstraint = \"hand\"\nposition = [{}, 0, 0]",
            length - shortening
        );
        // Its weight of 1.2 N would bend it more than the wall does; a millionth says to which side.
        let run = converged(
            "rod_in_tube.toml",
            &[
                ("gravity = [0, 0, -9.81]", "gravity = [0, 0, -1e-5]"),
                ("increments = 20\n[[steps.move]]\nconstraint = \"hand\"\nposition = [0.985, 0, 0]", &to),
            ],
        );
        let step = run.steps.last().expect("steps");
        let (push, pushed) = (-force(step, "hand").x, step.obstacles[0].force.z);
        assert!((push / p - 1.0).abs() < 0.005, "{push} N push, {p} N expected");
        let (_, wall) = pressed(push);
        assert!((pushed / wall - 1.0).abs() < 0.005, "{pushed} N on the wall, {wall} N expected");
        assert_eq!((step.obstacles[0].contacts, step.stable), (1, Some(true)));
    }
}

/// Two crossed cables exert opposite forces, and each is its own mirror image, rough or smooth.
#[test]
fn crossed_cables_rest_on_each_other() {
    check_crossed(&converged("crossed_cables.toml", &[]));
    check_crossed(&converged("crossed_cables.toml", &[("cables = true", "cables = true\nfriction = 0.3")]));
}

fn check_crossed(run: &Run) {
    let step = run.steps.last().expect("steps");
    let all: f64 = ["A", "B", "C", "D"].iter().map(|end| force(step, &format!("plug-{end}")).z).sum();
    let weight = 2.0 * 0.6 * 0.12 * 9.81;
    assert!((all - weight).abs() < 1e-5 * weight, "{all} N, {weight} N expected");
    for branch in &step.branches {
        let n = branch.position.len();
        for i in 0..n {
            let (x, y) = (branch.position[i], branch.position[n - 1 - i]);
            // The tolerance of forces, over the little stiffness against sliding along each other, is micrometres.
            assert!((x.z - y.z).abs() < 2e-5, "{}: node {i} at {x:?}, its image at {y:?}", branch.name);
        }
    }
    let gap = least_apart(&step.branches[0].position, &step.branches[1].position, 0);
    assert!((gap - 0.008).abs() < 0.008 * 2e-3, "{gap} m between the centre lines");
}

/// A cable that is pressed on a stiff one by h with its clamped ends, and dragged along it by δ, is a beam in both
/// planes, `K = 192 EI/L³`: the normal force is `N = K h`. As long as it sticks the force along the stiff one changes
/// by `δ/(1/K + R² L/(4 GJ))`, the latter since it is held at its surface and turns; it slips at `μ N`, and sticks
/// again when it is dragged back. Of small slopes (up to 0.03, whose square is 1e-3), and a mesh of 81 segments: to
/// 2e-3.
#[test]
fn a_cable_that_is_dragged_across_another_sticks_and_slips_as_coulomb_says() {
    let (ei, gj, length, radius, h, friction) = (0.012_f64, 0.009, 0.4_f64, 0.004_f64, 0.004, 0.3);
    let stiffness = 192.0 * ei / length.powi(3);
    let sticking = 1.0 / (1.0 / stiffness + radius.powi(2) * length / (4.0 * gj));
    let (normal, most) = (stiffness * h, friction * stiffness * h);
    let run = converged("dragged_across.toml", &[]);
    let (mut x, mut expected) = (0.0, 0.0_f64);
    let mut seen = [0, 0];
    for step in &run.steps[4..] {
        let at = |name: &str| step.constraints.iter().find(|c| c.name == name).expect("a hand").position.x;
        let on_rod = force(step, "plug-A") + force(step, "plug-B");
        let dragged = at("hand-C");
        let wanted = expected + sticking * (dragged - x);
        (x, expected) = (dragged, wanted.clamp(-most, most));
        seen[usize::from(wanted != expected)] += 1;
        assert!((on_rod.z / normal - 1.0).abs() < 0.002, "{} N, {normal} N expected", on_rod.z);
        assert!((on_rod.x + expected).abs() < 0.002 * most, "at {x} m {} N, {expected} N expected", -on_rod.x);
    }
    assert!(seen[0] > 8 && seen[1] > 4, "{seen:?}");
}

/// Least distance between two pieces of straight line.
fn pieces_apart([p, p_end]: [&Vector; 2], [q, q_end]: [&Vector; 2]) -> f64 {
    let (d, e, r) = (p_end - p, q_end - q, p - q);
    let (a, b, c, f, g) = (d.dot(&d), d.dot(&e), d.dot(&r), e.dot(&e), e.dot(&r));
    let square = a * f - b * b;
    let mut s = if square > 1e-12 * a * f { ((b * g - c * f) / square).clamp(0.0, 1.0) } else { 0.0 };
    let mut t = (b * s + g) / f;
    if !(0.0..=1.0).contains(&t) {
        t = t.clamp(0.0, 1.0);
        s = ((b * t - c) / a).clamp(0.0, 1.0);
    }
    (p + d * s - q - e * t).norm()
}

/// Least distance between two rows of nodes, or between nodes of the same one that are further apart in it than
/// `apart`.
fn least_apart(x: &[Vector], y: &[Vector], apart: usize) -> f64 {
    let pairs = (0..x.len() - 1).flat_map(|i| (0..y.len() - 1).map(move |j| (i, j)));
    let far = pairs.filter(|(i, j)| apart == 0 || i + apart <= *j);
    far.map(|(i, j)| pieces_apart([&x[i], &x[i + 1]], [&y[j], &y[j + 1]])).fold(f64::INFINITY, f64::min)
}

/// No deeper than a thousandth of the radius; the tolerance where cables cross is 4e-4 of what is between the centre
/// lines.
#[test]
fn a_knot_that_is_pulled_tight_does_not_pass_through_itself() {
    let run = converged("overhand_knot.toml", &[]);
    let step = run.steps.last().expect("steps");
    let x = &step.branches[0].position;
    let least = least_apart(x, x, 10);
    assert!(least > 0.006 - 1e-3 * 0.003, "{least} m between centre lines");
    // Without a knot the cable would be slack by a tenth of its length, and nothing would pull.
    assert!(force(step, "B").x > 1.0 && least < 0.0062, "{:?}", force(step, "B"));
}

/// It takes more than half as much again to pull a rough knot as tight; let go a little it pulls less than a smooth
/// one, for friction holds it.
#[test]
fn a_rough_knot_is_harder_to_pull_tight_and_holds() {
    let back = "[[steps]]\nname = \"back\"\nincrements = 2\n[[steps.move]]\nconstraint = \"B\"\n\
                position = [0.376, 0, 0.058856]\n";
    let end = ("position = [0.436608, -0.053351, 0.058856]", &*format!("position = [0.38, 0, 0.058856]\n{back}"));
    let pulls = |friction: &str| {
        let contact = format!("cables = true\nfriction = {friction}");
        let changes = [("cables = true", &*contact), end, ("increments = 24", "increments = 10")];
        let run = converged("overhand_knot.toml", &changes);
        [0, 1].map(|step| force(&run.steps[step], "B").x)
    };
    let ([smooth, smooth_back], [rough, rough_back]) = (pulls("0"), pulls("0.3"));
    assert!(rough > 1.5 * smooth, "{rough} N rough, {smooth} N smooth");
    assert!(rough_back < smooth_back, "back: {rough_back} N rough, {smooth_back} N smooth");
}

/// A box of half sizes `half`, turned about z: how far a point is from it, m; negative inside.
fn box_distance(x: &Vector, centre: &Vector, half: &Vector, turn: f64) -> f64 {
    let own = Rotation::from_axis_angle(&Vector::z_axis(), -turn) * (x - centre);
    let off = own.abs() - half;
    off.map(|d| d.max(0.0)).norm() + off.max().min(0.0)
}

/// Random harnesses of three arms, held at one end, let down onto random boxes on a floor; of every hundred at most
/// three may not converge, and must say so.
#[test]
fn random_harnesses_lie_on_random_boxes_without_entering_them() {
    let drops: u64 = std::env::var("WIRELOOM_DROPS").ok().and_then(|n| n.parse().ok()).unwrap_or(40);
    let mut lost = Vec::new();
    for seed in 0..drops {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut between = |a: f64, b: f64| a + (b - a) * rng.f64();
        let mut text = String::from("schema = 1\nname = \"drop\"\n");
        let diameter = between(0.006, 0.012);
        text += &format!(
            "[sections.cable]\ndiameter = {diameter}\nlinear_density = {}\naxial_stiffness = 1e4\n\
             bending_stiffness = {}\n\
             torsion_stiffness = {}\n",
            between(0.05, 0.15),
            between(0.003, 0.02),
            between(0.003, 0.015)
        );
        for (name, from, to) in [("trunk", "A", "J"), ("left", "J", "B"), ("right", "J", "C")] {
            let length = between(0.2, 0.4);
            text += &format!(
                "[[branches]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \"cable\"\n\
                 length = {length}\n\
                 segments = {}\n",
                (length / 0.02).ceil()
            );
        }
        text += "[[joints]]\nname = \"J\"\narms = [\n  { branch = \"trunk\", direction = [-1, 0, 0], up = [0, 0, 1] \
                 },\n  \
                 { branch = \"left\", direction = [0.8, 0.6, 0], up = [0, 0, 1] },\n  \
                 { branch = \"right\", direction = [0.8, -0.6, 0], up = [0, 0, 1] },\n]\n";
        text += "[[constraints]]\nname = \"hand\"\nkind = \"connector\"\nat = { end = \"A\" }\n\
                 position = [-0.3, 0, 0.4]\n\
                 tangent = [1, 0, 0]\nup = [0, 0, 1]\n[initial]\nbranch = \"trunk\"\nposition = [-0.3, 0, 0.4]\n\
                 tangent = [1, 0, 0]\n\
                 up = [0, 0, 1]\n";
        let mut boxes = Vec::new();
        for k in 0..3 {
            let half = Vector::new(between(0.04, 0.12), between(0.04, 0.12), between(0.03, 0.08));
            let centre = Vector::new(between(-0.05, 0.45), between(-0.25, 0.25), half.z);
            let turn = between(0.0, PI);
            text += &format!(
                "[[obstacles]]\nname = \"box {k}\"\nshape = \"box\"\nsize = [{}, {}, {}]\nposition = [{}, {}, {}]\n\
                 orientation = [{}, 0, 0, {}]\n",
                2.0 * half.x,
                2.0 * half.y,
                2.0 * half.z,
                centre.x,
                centre.y,
                centre.z,
                (0.5 * turn).cos(),
                (0.5 * turn).sin()
            );
            boxes.push((centre, half, turn));
        }
        text += "[[obstacles]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n";
        text += "[[steps]]\nname = \"let down\"\nincrements = 8\n[[steps.move]]\nconstraint = \"hand\"\n\
                 position = [-0.3, 0, 0.06]\n";
        let run = run(&text);
        let radius = 0.5 * diameter;
        for step in run.steps.iter().filter(|step| step.status == Status::Converged) {
            for branch in &step.branches {
                for x in &branch.position {
                    let bodies = boxes.iter().map(|(centre, half, turn)| box_distance(x, centre, half, *turn));
                    let distance = bodies.fold(x.z, f64::min);
                    // The tolerance is 1e-4 of the radius.
                    assert!(distance > (1.0 - 1.1e-4) * radius, "seed {seed}: {} m deep at {x:?}", radius - distance);
                }
            }
        }
        if run.status() != Status::Converged {
            lost.push((seed, run.status()));
        }
    }
    assert!(lost.len() as u64 * 100 <= 3 * drops.max(34), "{} of {drops} did not converge: {lost:?}", lost.len());
}

/// A weightless rod, let go of at one end, is swung through a plane by 3.5 turns and comes to rest above it: straight,
/// with nothing to bear. The contact that had opened kept its multiplier of 1e5 N, by which residuals were measured: it
/// "converged" 18 N m out of balance, with an energy of -2e7 J.
#[test]
fn a_contact_that_has_opened_hides_no_residual() {
    for segments in [4, 8, 16] {
        let run = run(&SWUNG.replace("SEGMENTS", &segments.to_string()));
        assert_eq!(run.status(), Status::Converged, "{segments} segments: {:?}", run.events);
        let step = run.steps.last().expect("steps");
        let (energy, moment) = (step.energy.total(), step.constraints[0].moment.norm());
        let bending = 2.2366 / 0.46464;
        assert!(
            moment < 1e-6 * bending && energy.abs() < 1e-6 * bending,
            "{segments} segments: {energy} J, {moment} N m"
        );
    }
}

const SWUNG: &str = r#"
schema = 1
name = "swung"
gravity = [0, 0, 0]
[sections.rod]
diameter = 0.01062
linear_density = 0.0075
axial_stiffness = 6.31e5
bending_stiffness = 2.2366
torsion_stiffness = 0.85936
[[branches]]
name = "rod"
from = "A"
to = "B"
section = "rod"
length = 0.46464
segments = SEGMENTS
[[constraints]]
name = "hand"
kind = "connector"
at = { end = "B" }
position = [0.1398, -0.0204, 0.2646]
orientation = [0.25268, 0.58218, 0.17458, -0.75282]
[[constraints]]
name = "slide"
kind = "connector"
at = { end = "A" }
position = [0.54440, 0.23352, 0.26035]
orientation = [-0.05967, 0.84580, 0.46563, -0.25345]
rail = [[0.67881, -0.68615, -0.26155]]
[[obstacles]]
name = "floor"
shape = "plane"
point = [0, 0, 0.06565]
normal = [0, 0, 1]
[[steps]]
name = "swing"
increments = 2
release = ["slide"]
[[steps.move]]
constraint = "hand"
turns = 3.4682
"#;

/// Two plugs 0.588 m apart hold a cable of 0.6 m and radius 4 mm; `more` is the rest of the text.
fn between_two_plugs(segments: usize, more: &str) -> String {
    [
        "schema = 1\nname = \"two plugs\"\n[sections.s]\ndiameter = 0.008\nlinear_density = 0.12\n\
         axial_stiffness = 20000.0\nbending_stiffness = 0.012\ntorsion_stiffness = 0.009\n",
        &branch("c", ["A", "B"], "s", 0.6, segments),
        &connector("A", "A", [0.0, 0.0, 0.0]),
        &connector("B", "B", [0.588, 0.0, 0.0]),
        more,
    ]
    .concat()
}

/// A bar of 1 mm goes 220 mm down through a cable, between two nodes of it, in two increments.
fn bar_through_a_cable(x: f64) -> Run {
    let bar = format!(
        "[[obstacles]]\nname = \"bar\"\nposition = [{x}, 0, 0.1]\nshape = \"cylinder\"\nradius = 0.0005\n\
         length = 2.0\ntangent = [0, 1, 0]\n[[steps]]\nname = \"rest\"\n[[steps]]\nname = \"go\"\n\
         increments = 2\nmove = [{{ obstacle = \"bar\", position = [{x}, 0, -0.12] }}]\n"
    );
    run(&between_two_plugs(120, &bar))
}

/// It takes the cable along. At rest its ends bear less than 1 N.
#[test]
fn a_thin_bar_does_not_pass_between_two_nodes() {
    let run = bar_through_a_cable(0.3125);
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    assert!(force(&run.steps[0], "A").norm() < 1.0);
    let step = &run.steps[1];
    assert!(step.obstacles[0].contacts > 0 && force(step, "A").norm() > 500.0, "{:?}", step.obstacles);
}

/// A thin sheet between two plugs that is moved along y.
fn pushed(length: f64, increments: usize, y: f64) -> Run {
    let text = [
        "schema = 1\nname = \"pushed\"\n[sections.s]\ndiameter = 0.008\nlinear_density = 0.08\n\
         axial_stiffness = 1e4\nbending_stiffness = 0.05\ntorsion_stiffness = 0.04\n",
        &branch("c", ["A", "B"], "s", length, 30),
        &connector("A", "A", [0.0, 0.0, 0.0]),
        &connector("B", "B", [0.8, 0.0, 0.0]),
        "[[obstacles]]\nname = \"sheet\"\nposition = [0.4, 0.1, 0]\nshape = \"box\"\nsize = [0.2, 0.0005, 1.0]\n\
         [[steps]]\nname = \"hang\"\n[[steps]]\nname = \"push\"\n",
        &format!("increments = {increments}\nmove = [{{ obstacle = \"sheet\", position = [0.4, {y:?}, 0] }}]\n"),
    ];
    run(&text.concat())
}

/// The cable cannot follow. Where an increment ended in the middle of its way, and the harness snapped from there, that
/// was taken for its end.
#[test]
fn an_increment_that_converged_came_to_its_end() {
    for (length, increments) in [(0.81, 1), (0.83, 5)] {
        let run = pushed(length, increments, -0.15);
        let (end, y) = (run.steps[1].status, run.steps[1].obstacles[0].pose.position.y);
        assert!(end != Status::Converged || (y + 0.15).abs() < 1e-12, "{end:?} at {y} m");
    }
}

/// It comes through the cable within a ten-thousandth of the step: that converged, and all clearances were kept.
#[test]
fn a_sheet_that_is_too_fast_does_not_pass_through_a_cable() {
    let run = pushed(0.9, 1, -100.0);
    assert_eq!(run.status(), Status::Failed);
    assert!(run.events.iter().any(|event| event.message.contains("would pass through a cable")), "{:?}", run.events);
}

/// A drum that turns below a cable rubs it on its whole way, however few increments it takes; also where these are
/// divided because something creeps.
#[test]
fn a_drum_that_turns_once_in_an_increment_pulls_as_the_capstan_does() {
    let path = wireloom_tests::root().join("scenarios/contact/capstan.toml");
    let text = std::fs::read_to_string(&path).expect("a text");
    let (harness, _) = text.split_once("[[steps]]").expect("steps");
    let harness = harness.replace("friction = 0.2", "friction = 0.2\nmount = \"wheel\"")
        + "[[mechanisms]]\nname = \"m\"\n[[mechanisms.joints]]\nname = \"axle\"\nkind = \"revolute\"\n\
           between = [\"ground\", \"wheel\"]\norigin = [0, 0, 0]\naxis = [0, 1, 0]\n";
    let creeping = section("soft")
        + "creep = { bending = [{ stiffness = 0.005, time = 1 }] }\n"
        + &branch("aside", ["C", "D"], "soft", 0.2, 10)
        + &connector("C", "C", [0.0, 1.0, 0.0]);
    let turn = |time: &str| {
        format!(
            "[[steps]]\nname = \"settle\"\n[[steps]]\nname = \"turn\"\n{time}\
             drive = [{{ joint = \"axle\", to = \"-360 deg\" }}]\n"
        )
    };
    for text in [harness.clone() + &turn(""), harness + &creeping + &turn("duration = \"10 s\"\n")] {
        let run = run(&text);
        assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
        let (ratio, expected) = (-force(run.steps.last().expect("steps"), "hand").z / 2.0, (0.2 * PI).exp());
        assert!((ratio / expected - 1.0).abs() < 0.02, "{ratio}, {expected} expected");
    }
}

/// What is held cannot give way to a body: that is told, whichever of them moves.
#[test]
fn a_body_that_is_driven_into_a_held_cable_is_an_event() {
    let ram = |step: &str| {
        "[[constraints]]\nname = \"clip\"\nkind = \"collar\"\nat = { branch = \"c\", s = 0.3 }\n\
         position = [0.295, 0, 0]\ntangent = [1, 0, 0]\n[[obstacles]]\nname = \"ram\"\nposition = [0.295, 0, 0.4]\n\
         shape = \"box\"\nsize = [0.02, 0.02, 0.3]\n[[steps]]\nname = \"rest\"\n"
            .to_owned()
            + step
    };
    let events = |step: &str| {
        let run = run(&between_two_plugs(60, &ram(step)));
        assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
        run.events.into_iter().filter(|event| event.kind == EventKind::Overlap).collect::<Vec<_>>()
    };
    let down = |z: f64| {
        format!(
            "[[steps]]\nname = \"down\"\nincrements = 20\n\
             move = [{{ obstacle = \"ram\", position = [0.295, 0, {z}] }}]\n"
        )
    };
    let found = events(&down(0.0));
    assert!(found.len() == 1 && found[0].place.constraint.as_deref() == Some("clip"), "{found:?}");
    assert!((found[0].value.expect("a distance") + 0.01).abs() < 1e-9, "half the width of the ram: {found:?}");
    assert_eq!(events(&down(0.16)), [], "6 mm above the surface of the cable");
}

/// What is plugged home lies at the face of its counterpart.
#[test]
fn a_plug_at_the_face_of_a_body_is_not_driven_into_it() {
    let home = "[[obstacles]]\nname = \"header\"\nposition = [0.608, 0, 0]\nshape = \"box\"\n\
                size = [0.04, 0.04, 0.04]\n[[steps]]\nname = \"plug in\"\nincrements = 5\n\
                move = [{ constraint = \"B\", position = [0.588, 0, 0] }]\n";
    let text = between_two_plugs(60, home).replace("[0.588, 0.0, 0.0]", "[0.55, 0.0, 0.0]");
    let run = run(&text);
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    assert!(run.events.iter().all(|event| event.kind != EventKind::Overlap), "{:?}", run.events);
}

fn session(text: &str) -> Result<Session, SessionError> {
    Session::open(text, Box::new(NoFiles), wireloom::registry(), Monitor::default())
}

/// Friction begins at the start: it was not in balance with it, and the session did not open.
#[test]
fn a_session_opens_where_the_start_touches_something_rough() {
    let floor = "[[obstacles]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, -0.05]\nnormal = [0, 0, 1]\n\
                 friction = 0.3\n";
    let text = between_two_plugs(20, floor).replace(&connector("B", "B", [0.588, 0.0, 0.0]), "");
    let opened = session(&text).expect("an equilibrium");
    let run = run(&text);
    assert_eq!((opened.end().status, run.status()), (Status::Converged, Status::Converged));
    let [by_hand, by_run] = [opened.end(), &run.steps[0]].map(|end| force(end, "A"));
    assert!((by_hand - by_run).norm() < 1e-5 * by_run.norm(), "{by_hand} {by_run}");
    assert!(run.notes.iter().any(|note| note.contains("without friction")), "{:?}", run.notes);
}

/// What a run of the saved text refuses, the session refuses.
#[test]
fn a_session_takes_no_plug_into_a_body() {
    let floor = "[[obstacles]]\nname = \"floor\"\nshape = \"plane\"\npoint = [0, 0, -0.05]\nnormal = [0, 0, 1]\n";
    let mut opened = session(&between_two_plugs(20, floor)).expect("an equilibrium");
    let to = |z: f64| Goal { position: Some([0.58, 0.0, z]), orientation: None };
    let refused = opened.move_to("B", &to(-0.056)).expect_err("6 mm deep, the radius is 4 mm");
    assert!(refused.to_string().contains("6.0 mm inside obstacle \"floor\""), "{refused}");
    opened.move_to("B", &to(-0.045)).expect("on the floor");
    session(&opened.text().expect("a text")).expect("the text is one that can be run");
}

/// A cable that is dragged along a rough floor by its plug, from and to x = -20 mm.
fn dragged_by_its_plug(segments: usize) -> Run {
    let floor = "path = [[0, 0, 0.003], [1, 0, 0.003]]\n[[obstacles]]\nname = \"floor\"\nshape = \"plane\"\n\
                 point = [0, 0, 0]\nnormal = [0, 0, 1]\nfriction = 0.5\n";
    let steps = "[[steps]]\nname = \"pull\"\nmove = [{ constraint = \"plug\", position = [-0.02, 0, 0.003] }]\n";
    let cable = branch("cable", ["A", "B"], "cable", 1.0, segments);
    let plug = connector("plug", "A", [0.0, 0.0, 0.003]);
    run(&["schema = 1\nname = \"dragged\"\n", &section("cable"), &cable, floor, &plug, steps].concat())
}

/// From 2,000 nodes on, the start is searched for on a coarser mesh first: after it nothing rubbed, this pull was 0 N.
#[test]
fn friction_acts_after_a_start_on_a_coarser_mesh() {
    let expected = 0.5 * 0.05 * 9.81;
    for segments in [300, 2100] {
        let run = dragged_by_its_plug(segments);
        assert_eq!(run.status(), Status::Converged, "{segments}: {:?}", run.events);
        let pull = force(&run.steps[0], "plug").x;
        assert!((pull + expected).abs() < 0.01 * expected, "{segments} segments: {pull} N");
        assert!(run.notes.iter().any(|note| note.contains("without friction")), "{segments}: {:?}", run.notes);
    }
}

/// Points of a sweep that start from a neighbour had no friction between cables. Without weight the density that varies
/// here changes nothing.
#[test]
fn friction_acts_in_points_of_a_sweep_that_start_from_a_neighbour() {
    let path = wireloom_tests::root().join("scenarios/contact/dragged_across.toml");
    let text = std::fs::read_to_string(path).expect("a scenario of the repository");
    let vary = "[sweep.vary]\n\"sections.rod.linear_density\" = { from = 0.4, to = 0.6, count = 48 }\n";
    let (_, rows) = wireloom::sweep::run(&format!("{text}{vary}"), &NoFiles, &wireloom::registry()).expect("points");
    let energies: Vec<f64> = rows.iter().map(|row| row.numbers[2].expect("an energy")).collect();
    // Chains of three points, of which the second one starts from the first one.
    assert!(rows.len() == 48 && energies.iter().all(|own| (own / energies[0] - 1.0).abs() < 1e-4), "{energies:?}");
}

/// The layout runs below the plate, and the way to the upper plug goes through it: this start failed, though nothing
/// touches the plate in the end.
#[test]
fn a_start_that_an_obstacle_blocks_is_found_without_it() {
    let plugs = connector("A", "A", [-0.15, 0.0, 0.0]) + &connector("B", "B", [0.12, 0.05, 0.1]);
    let cable = branch("cable", ["A", "B"], "cable", 0.4, 29);
    let text = ["schema = 1\nname = \"plate\"\n", &section("cable"), &cable, &plugs].concat();
    let plate =
        "[[obstacles]]\nname = \"plate\"\nshape = \"box\"\nsize = [0.3, 0.2, 0.004]\nposition = [0.25, 0, 0.08]\n";
    let [alone, beside] = [text.clone(), text + plate].map(|text| run(&text));
    assert_eq!((alone.status(), beside.status()), (Status::Converged, Status::Converged), "{:?}", beside.events);
    let [free, found] = [&alone, &beside].map(|run| &run.steps[0].branches[0].position);
    let apart = free.iter().zip(found).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    assert!(apart < 1e-6, "{apart} m");
    let told = |run: &Run| run.notes.iter().any(|note| note.contains("without them first"));
    assert!(told(&beside) && !told(&alone), "{:?}", beside.notes);
}

/// It did with 115 J, and on five meshes in five different equilibria, all of them stable. The one without the block
/// does not touch it.
#[test]
fn a_loop_does_not_start_caught_around_a_block() {
    let text = include_str!("contact/caught.toml");
    let (before, block) = text.split_once("[[obstacles]]").expect("an obstacle");
    let (_, rest) = block.split_once("[contact]").expect("contact");
    let [alone, beside] = [&format!("{before}[contact]{rest}"), text].map(run);
    assert_eq!((alone.status(), beside.status()), (Status::Converged, Status::Converged), "{:?}", beside.events);
    let [free, found] = [&alone, &beside].map(|run| run.steps[0].energy.total());
    assert!((free - found).abs() < 1e-3 * free.abs(), "{free} J and {found} J");
}
