//! The estimate of the discretisation error against meshes that are eight times as fine.

use wireloom_core::equilibrium::{BranchResult, StepResult};
use wireloom_core::status::Status;
use wireloom_core::{Registry, State, Vector};
use wireloom_solve::report::discretisation::NodalErrors;
use wireloom_solve::steps::checkpoint::Observer;
use wireloom_solve::{Control, Progress};

/// Segments of the finer mesh for each one of the coarse mesh.
const FINER: usize = 8;

/// Results and estimates of all increments.
#[derive(Default)]
struct Keep(Vec<(StepResult, Vec<NodalErrors>)>, Vec<NodalErrors>);

impl Observer for Keep {
    fn state(&mut self, _: &State, errors: &[NodalErrors]) {
        self.1 = errors.to_vec();
    }

    fn increment(&mut self, _: &Progress, end: &StepResult, _: bool) -> Control {
        self.0.push((end.clone(), std::mem::take(&mut self.1)));
        Control::Continue
    }
}

fn run(text: &str) -> Vec<(StepResult, Vec<NodalErrors>)> {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    wireloom_shapes::register(&mut registry, None);
    wireloom_solve::register(&mut registry);
    let built = wireloom_scenario::build_with_settings(text, &[], &wireloom_scenario::NoFiles, &registry);
    let (_, built) = built.unwrap_or_else(|faults| panic!("{faults:?}"));
    let wireloom_scenario::Built { network, coarse, schedule, mut minimiser, stop, .. } = built;
    let mut keep = Keep::default();
    let run =
        wireloom_solve::carry_out(&network, coarse.as_ref(), minimiser.as_mut(), &stop, &schedule, None, &mut keep);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?}", run.notes, run.events);
    keep.0
}

/// True errors and estimates of a quantity at the places that matter.
#[derive(Default)]
struct Compared(Vec<[f64; 2]>);

impl Compared {
    /// Share of the places where the estimate is not below the true error.
    fn covered(&self) -> f64 {
        self.0.iter().filter(|[error, estimate]| estimate >= error).count() as f64 / self.0.len() as f64
    }

    /// Median of estimate over true error, where the error is above a tenth of the largest.
    fn median(&self) -> f64 {
        let largest = self.0.iter().map(|[error, _]| *error).fold(0.0, f64::max);
        let all = self.0.iter().filter(|[error, _]| *error > 0.1 * largest);
        let mut ratios: Vec<f64> = all.map(|[error, estimate]| estimate / error).collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    }
}

/// Curvature, moment, force and position of a scenario with `{n}` segments where the text says so, of which a number
/// `n`. What matters: curvatures, moments and forces above a tenth of the largest of their branch, and positions whose
/// error is above a tenth of the largest.
fn compare(text: &str, n: usize) -> [Compared; 4] {
    let at = |n: usize| run(&text.replace("{n}", &n.to_string()));
    let (coarse, fine) = (at(n), at(FINER * n));
    let mut compared: [Compared; 4] = Default::default();
    for ((coarse, errors), (fine, _)) in coarse.iter().zip(&fine) {
        for ((a, b), errors) in coarse.branches.iter().zip(&fine.branches).zip(errors) {
            let curvature = |r: f64| 1.0 / r;
            let bends: Vec<f64> = a.bend_radius.iter().map(|r| curvature(*r)).collect();
            let sizes = |all: &[Vector]| all.iter().map(Vector::norm).collect::<Vec<f64>>();
            let sizes = [bends.clone(), sizes(&a.moment), sizes(&a.force)];
            let largest = sizes.each_ref().map(|all| all.iter().copied().fold(0.0, f64::max));
            for (i, s) in a.s.iter().enumerate() {
                // Where a cable slides its nodes move along it.
                let after = b.s.partition_point(|other| *other < s - 1e-9).clamp(1, b.s.len() - 1);
                let t = ((s - b.s[after - 1]) / (b.s[after] - b.s[after - 1])).clamp(0.0, 1.0);
                let of = |all: &[Vector]| all[after - 1] * (1.0 - t) + all[after] * t;
                let fine_bend = curvature(b.bend_radius[after - 1]) * (1.0 - t) + curvature(b.bend_radius[after]) * t;
                let true_errors = [
                    (bends[i] - fine_bend).abs(),
                    (a.moment[i] - of(&b.moment)).norm(),
                    (a.force[i] - of(&b.force)).norm(),
                ];
                let estimates = [errors.curvature[i], errors.moment[i], errors.force[i]];
                for k in 0..3 {
                    if sizes[k][i] > 0.1 * largest[k] && largest[k] > 1e-6 {
                        compared[k].0.push([true_errors[k], estimates[k]]);
                    }
                }
                compared[3].0.push([(a.position[i] - of(&b.position)).norm(), errors.position[i]]);
            }
        }
    }
    let largest = compared[3].0.iter().map(|[error, _]| *error).fold(0.0, f64::max);
    compared[3].0.retain(|[error, _]| *error > 0.1 * largest);
    compared
}

/// Largest median of the local estimate over the true error: for positions it adds up the errors of all curvatures as
/// if they had one sign.
const LOCAL: f64 = 200.0;

const QUANTITIES: [&str; 4] = ["curvature", "moment", "force", "position"];

/// Every quantity of a scenario is covered in 95 % of the places that matter, by no more than `most` times the error in
/// the median.
#[track_caller]
fn covers(text: &str, n: usize, most: f64) {
    for (what, compared) in QUANTITIES.iter().zip(compare(text, n)) {
        if compared.0.is_empty() || compared.0.iter().all(|[error, _]| *error < 1e-9) {
            continue;
        }
        let (covered, median) = (compared.covered(), compared.median());
        assert!(covered >= 0.95, "{what}: {covered} of {} places", compared.0.len());
        assert!(median <= most, "{what}: {median} times the error");
    }
}

const SECTION: &str = r#"schema = 1
name = "estimate"

# Nothing of the errors is left by the minimiser.
[minimiser]
kind = "newton"
force_tolerance = 1e-10

[sections.cable]
diameter = "8 mm"
linear_density = "120 g/m"
axial_stiffness = 2.0e4
bending_stiffness = 0.02
torsion_stiffness = 0.015
"#;

/// A cable clamped at both ends, bent by a move of one end; `rod` is its kind, `more` further entries.
fn clamped(rod: &str, more: &str) -> String {
    format!(
        r#"{SECTION}
[[branches]]
name = "A"
from = "start"
to = "end"
section = "cable"
length = 1.0
segments = {{n}}
rod = "{rod}"

[[constraints]]
name = "a"
kind = "connector"
at = {{ end = "start" }}

[[constraints]]
name = "b"
kind = "connector"
at = {{ end = "end" }}

[initial]
branch = "A"
tangent = [1, 0, 0]
up = [0, 0, 1]
{more}
[[steps]]
name = "bend"
increments = 4
[[steps.move]]
constraint = "b"
position = [0.6, 0.2, 0.1]
tangent = [0.6, 0, 0.8]
"#
    )
}

#[test]
fn clamped_cables_are_covered() {
    covers(&clamped("cosserat", ""), 40, 10.0);
    // Its two errors of second order, of the grid and of the alignment, cancel to a hundredth.
    covers(&clamped("kirchhoff", ""), 40, 20.0);
}

/// Friction slips in some of the cells and sticks in others. The estimate takes it to stick everywhere: errors of
/// moments are estimated with a stiffness that is up to 3.5 times the one where it slips.
#[test]
fn friction_within_the_section_is_covered() {
    let elastic = "torsion_stiffness = 0.015\n";
    let friction = "friction = { bending = [{ stiffness = 0.03, moment = 0.03 }, { stiffness = 0.02, moment = 0.1 }], \
                    torsion = [{ stiffness = 0.01, moment = 0.005 }] }\n";
    let text = clamped("cosserat", "").replace(elastic, &format!("{elastic}{friction}"));
    covers(&text, 40, 25.0);
}

#[test]
fn the_first_order_error_of_springs_is_covered() {
    covers(&clamped("mass-spring", ""), 40, 11.0);
}

#[test]
fn clips_and_rings_are_covered() {
    let collar = |slide: bool| {
        format!(
            "\n[[constraints]]\nname = \"clip\"\nkind = \"collar\"\nat = {{ branch = \"A\", s = 0.5 }}\n\
             slide = {slide}\n"
        )
    };
    covers(&clamped("cosserat", &collar(false)), 40, 12.0);
    // Where cables slide the estimate is doubled.
    covers(&clamped("cosserat", &collar(true)), 40, 18.0);
}

/// Three arms at a joint of this model, each clamped at its end.
fn joined(model: &str) -> String {
    let mut text = format!("{SECTION}\n[initial]\nbranch = \"in\"\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n");
    for (name, from, to) in [("in", "A", "J"), ("left", "J", "B"), ("right", "J", "C")] {
        text += &format!(
            "\n[[branches]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \"cable\"\nlength = 0.5\n\
             segments = {{n}}\n"
        );
    }
    text += &format!(
        "\n[[joints]]\nname = \"J\"\nmodel = \"{model}\"\nbending_stiffness = 0.3\n\
         torsion_stiffness = 0.2\narms = [\n"
    );
    for (name, direction) in [("in", [-1.0, 0.0]), ("left", [0.8, 0.6]), ("right", [0.8, -0.6])] {
        let [x, y] = direction;
        text += &format!("  {{ branch = \"{name}\", direction = [{x}, {y}, 0], up = [0, 0, 1] }},\n");
    }
    text += "]\n";
    for end in ["A", "B", "C"] {
        text +=
            &format!("\n[[constraints]]\nname = \"plug-{end}\"\nkind = \"connector\"\nat = {{ end = \"{end}\" }}\n");
    }
    text + "\n[[steps]]\nname = \"push\"\nincrements = 4\n[[steps.move]]\nconstraint = \"plug-A\"\n\
            position = [0.2, 0.05, 0.1]\n"
}

#[test]
fn joints_are_covered() {
    covers(&joined("rigid-body"), 20, 10.0);
    covers(&joined("cosserat"), 20, 10.0);
    covers(&joined("compliant-hub"), 20, 10.0);
}

/// A scenario of the project with `{n}` segments in each branch.
fn scenario(name: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios").join(name);
    let text = std::fs::read_to_string(&path).expect("a scenario of the project");
    let divides = |line: &str| line.starts_with("segments = ") || line.starts_with("max_segment = ");
    let lines = text.lines().map(|line| if divides(line) { "segments = {n}" } else { line });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn a_cable_that_lies_on_a_floor_is_covered() {
    // In contact the estimate is that of a scheme of second order, doubled; away from it the cable is more accurate.
    covers(&scenario("contact/cable_on_plane.toml"), 40, 40.0);
}

/// At the ends of branches, where the tightest bends are: what was stated was that of nodes within, down to a third of
/// the error.
#[test]
fn the_bends_at_the_ends_of_branches_are_covered() {
    for name in ["branches/rail.toml", "branches/release.toml", "branches/sections_from_wires.toml"] {
        for n in [20, 40] {
            let at = |n: usize| run(&scenario(name).replace("{n}", &n.to_string())).pop().expect("an increment");
            let ((coarse, errors), (fine, _)) = (at(n), at(FINER * n));
            for ((a, b), errors) in coarse.branches.iter().zip(&fine.branches).zip(&errors) {
                for (end, of_fine) in [(0, 0), (a.s.len() - 1, b.s.len() - 1)] {
                    let (error, stated) =
                        ((1.0 / a.bend_radius[end] - 1.0 / b.bend_radius[of_fine]).abs(), errors.curvature[end]);
                    assert!(error <= stated, "{name}, {n} segments, {} at {end}: {error:e}, not {stated:e}", a.name);
                }
            }
        }
    }
}

/// A joint of two arms through which the rod runs, also held out of the way. Each arm takes the centre line to be
/// beside its node by the square of the length of its segments, and the hand holds the node. What was stated was a
/// thirtieth of the error of the curvature where it is held, and where the segments of the arms differ a tenth of that
/// of the position.
#[test]
fn joints_that_a_rod_runs_through_are_covered() {
    let pull = "\n[[steps]]\nname = \"pull\"\nincrements = 2\n\
                [[steps.add]]\nname = \"hand\"\nkind = \"handle\"\nat = { joint = \"J\" }\n\
                [[steps.move]]\nconstraint = \"hand\"\nposition = [0.3, 0.5, 0.1]\n";
    let uneven = scenario("analytic/two_arm_joint.toml");
    let even = uneven.replace("length = 0.4", "length = 0.5").replace("length = 0.6", "length = 0.5");
    for (text, most) in [(even.clone(), 25.0), (uneven.clone(), 5.0), (even + pull, 5.0), (uneven + pull, 5.0)] {
        covers(&text, 40, most);
    }
}

/// With the default tolerance a loaded cantilever stops 5e-6 m beside the equilibrium of its mesh: 4e-11 m were stated.
#[test]
fn what_is_left_of_the_forces_is_covered() {
    let text = scenario("analytic/cantilever_tip_load.toml").replace("{n}", "300");
    let exact = run(&(text.clone() + "\n[minimiser]\nforce_tolerance = 1e-12\n"));
    let mut largest = 0.0_f64;
    for ((left, errors), (exact, _)) in run(&text).iter().zip(&exact) {
        for (i, (a, b)) in left.branches[0].position.iter().zip(&exact.branches[0].position).enumerate() {
            let (error, stated) = ((a - b).norm(), errors[0].position[i]);
            largest = largest.max(error);
            assert!(error <= stated + 1e-12, "{} at {i}: {error:e} m, not {stated:e}", left.name);
        }
    }
    assert!(largest > 1e-9, "nothing was left: {largest:e} m");
}

/// A cord that stiffens hangs by its weight: 2e-4 of the error of its position was stated, as if only bends moved nodes
/// off the centre line.
#[test]
fn a_changing_stretch_is_covered() {
    let [.., position] = compare(&scenario("analytic/axial_curve.toml"), 40);
    let (covered, median) = (position.covered(), position.median());
    assert!(covered >= 0.95 && median <= 10.0, "{covered} of {} places, {median} times the error", position.0.len());
}

/// What rolls about its own centre line for nothing: of a ring a thirteenth of the error of its curvature was stated,
/// of a cable in three hands 170 times that of its position.
#[test]
fn neutral_equilibria_are_covered() {
    let hand = |name: &str, s: f64, position: &str| {
        format!(
            "\n[[constraints]]\nname = \"{name}\"\nkind = \"handle\"\nat = {{ branch = \"A\", s = {s} }}\n\
             position = {position}\n"
        )
    };
    let cable = "\n[[branches]]\nname = \"A\"\nfrom = \"start\"\nto = \"end\"\nsection = \"cable\"\n\
                 length = 1.0\nsegments = {n}\n";
    let hands = [("a", 0.0, "[0, 0, 0]"), ("b", 0.5, "[0.35, 0.1, 0.05]"), ("c", 1.0, "[0.75, 0, 0.1]")];
    let hands = hands.map(|(name, s, position)| hand(name, s, position)).concat();
    let held = [SECTION, cable, &hands, "\n[[steps]]\nname = \"hang\"\n"].concat();
    for text in [scenario("analytic/ring_loop.toml"), held] {
        assert!(run(&text.replace("{n}", "40")).iter().all(|(end, _)| end.stable.is_none()), "not neutral");
        covers(&text, 40, 10.0);
    }
}

/// Dead moments have no Hessian, so the estimate is local. It is coarser than that from the response of the harness.
#[test]
fn cables_under_dead_moments_are_covered_by_the_local_estimate() {
    let rest = "\n[[loads]]\nname = \"couple\"\nat = { end = \"end\" }\nmoment = [0, -0.05, 0.02]\nfactor = 0\n\
                \n[[steps]]\nname = \"turn\"\nincrements = 4\n[[steps.load]]\nload = \"couple\"\nfactor = 1\n";
    let text = clamped("cosserat", "");
    let (clamp, _) = text.split_once("\n[[constraints]]\nname = \"b\"").expect("two clamps");
    let start = "\n[initial]\nbranch = \"A\"\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n";
    covers(&[clamp, start, rest].concat(), 40, LOCAL);
}

/// The torsion under the moment, m·d3/GJ, and its estimate at all nodes whose error is above a tenth of the largest.
fn torsions(text: &str, n: usize) -> Compared {
    const GJ: f64 = 0.015;
    let at = |n: usize| run(&text.replace("{n}", &n.to_string()));
    let (coarse, fine) = (at(n), at(FINER * n));
    let mut all = Compared::default();
    for ((coarse, errors), (fine, _)) in coarse.iter().zip(&fine) {
        for ((a, b), errors) in coarse.branches.iter().zip(&fine.branches).zip(errors) {
            let of = |branch: &BranchResult, i: usize| branch.moment[i].dot(&(branch.frame[i] * Vector::z())) / GJ;
            all.0.extend((0..a.s.len()).map(|i| [(of(a, i) - of(b, FINER * i)).abs(), errors.torsion[i]]));
        }
    }
    let largest = all.0.iter().map(|[error, _]| *error).fold(0.0, f64::max);
    all.0.retain(|[error, _]| *error > 0.1 * largest);
    all
}

/// Of the torsion beside stations the error of their frames is the larger part: they take some of the bending moment
/// for torsion. Wind is not even along a cable. The estimate of a torsion in the wind was down to a fifth of the error.
#[test]
fn torsions_are_covered_beside_stations_and_in_the_wind() {
    let wind = "[[loads]]\nname = \"wind\"\nspan = { branch = \"A\" }\nflow = { velocity = [0, 8, 2] }\n";
    let tool = "[[loads]]\nname = \"tool\"\nat = { branch = \"A\", s = 0.5 }\nforce = [0.2, -0.3, -0.5]\n";
    for (what, more) in [("plain", ""), ("wind", wind), ("tool", tool), ("both", &[wind, tool].concat())] {
        for n in [20, 40, 80] {
            let found = torsions(&clamped("cosserat", more), n);
            let (covered, median) = (found.covered(), found.median());
            assert!(covered >= 0.95, "{what} {n}: {covered} of {} places", found.0.len());
            assert!(median <= 30.0, "{what} {n}: {median} times the error");
        }
    }
}

/// Turns of a branch of few segments, whose couplings are all beside stations: the estimate of one segment was 1e-20.
#[test]
fn the_turns_of_few_segments_are_covered() {
    let last = |n: usize| run(&clamped("cosserat", "").replace("{n}", &n.to_string())).pop().expect("an increment");
    let (fine, _) = last(320);
    for n in [1, 2, 3, 4, 6, 10, 20] {
        let (end, errors) = last(n);
        let (s, twist) = (&end.branches[0].s, &errors[0].twist);
        let pairs = s.windows(2).zip(twist.windows(2));
        let turned: f64 = pairs.map(|(s, e)| 0.5 * (e[0] + e[1]) * (s[1] - s[0])).sum();
        let error = (end.branches[0].twist_turns - fine.branches[0].twist_turns).abs();
        assert!(turned / std::f64::consts::TAU >= error, "{n}: {turned} radians, but {error} turns");
    }
}
