//! Loads, accelerations and temperatures in whole runs: against closed forms, against each other and in balance.

use std::sync::Arc;
use wireloom::geometry::{Matrix, Rotation, Vector};
use wireloom::harness::{Axes, LineLoad, Load, LoadAction, LoadSite, Network, NodeRange, Place, PointLoad};
use wireloom::{Control, Run, Status, StepResult};
use wireloom_testkit::balance::imbalance;
use wireloom_testkit::{line_load_conformance, point_load_conformance};
use wireloom_tests::cables::{branch, built, connector, hanging, run, section};

#[track_caller]
fn converged(text: &str) -> Run {
    let run = run(text);
    assert_eq!(run.status(), Status::Converged, "{:?} {:?} {:?}", run.notes, run.events, run.fault());
    run
}

fn end(run: &Run) -> &StepResult {
    run.steps.last().expect("a step")
}

/// Largest distance of the nodes of two results, m.
fn apart(a: &StepResult, b: &StepResult) -> f64 {
    let of = |end: &StepResult| end.branches.iter().flat_map(|b| b.position.clone()).collect::<Vec<Vector>>();
    of(a).iter().zip(of(b)).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// In the axes of a car its acceleration is a gravity against it: the same bits, at the beginning and in steps, and
/// what a step does not give stays.
#[test]
fn an_acceleration_is_a_gravity_against_it() {
    let of = |more: &str| converged(&hanging("car", 40, more));
    let brakes = of("[[steps]]\nname = \"brake\"\nincrements = 4\nacceleration = [\"-3 m/s^2\", 0, 0]\n\
                     [[steps]]\nname = \"on the moon\"\nincrements = 2\ngravity = [0, 0, -1.62]\n");
    let turned = of("[[steps]]\nname = \"brake\"\nincrements = 4\ngravity = [3, 0, -9.81]\n\
                     [[steps]]\nname = \"on the moon\"\nincrements = 2\ngravity = [3, 0, -1.62]\n");
    for (a, b) in brakes.steps.iter().zip(&turned.steps) {
        assert_eq!(a.branches, b.branches, "{}", a.name);
        assert_eq!(a.energy, b.energy, "{}", a.name);
    }
    assert!(apart(&brakes.steps[0], &brakes.steps[1]) > 1e-3);
    // TOML has keys of the root before its tables.
    let text = hanging("car", 40, "").replace("schema = 1\n", "schema = 1\nacceleration = [-3, 0, 0]\n");
    let from_start = converged(&text);
    assert!(apart(end(&from_start), &brakes.steps[0]) < 1e-6);
}

/// A Y of three branches with everything at once; `LOADS` are its factors.
fn harness(steps: &str) -> String {
    let loads = r#"
[[joints]]
name = "J"
model = "rigid-body"
mass = "30 g"
arms = [
  { branch = "trunk", direction = [-1, 0, 0], up = [0, 0, 1], offset = [-0.01, 0, 0] },
  { branch = "left", direction = [1, 0.7, 0], up = [0, 0, 1], offset = [0.01, 0.007, 0] },
  { branch = "right", direction = [1, -0.7, 0], up = [0, 0, 1], offset = [0.01, -0.007, 0] },
]
[[loads]]
name = "wind"
span = [{ branch = "trunk", from = 0.05 }, { branch = "left" }]
flow = { velocity = [4, 15, 6] }
factor = 0
[[loads]]
name = "snow"
span = { branch = "trunk", from = 0.1, to = 0.3 }
force_per_length = [0, 0, "-2 N/m"]
factor = 0
[[loads]]
name = "pull"
at = { end = "C" }
force = [0, 0.1, 0.3]
moment = [0.002, 0, 0.001]
follows = true
factor = 0
[[loads]]
name = "hub"
at = { joint = "J" }
force = [0.4, 0.1, 0]
follows = true
factor = 0
"#;
    let section = section("cable").replace("axial", "thermal_expansion = \"17 ppm/K\"\naxial");
    [
        "schema = 1\nname = \"Y\"\nacceleration = [-3, 2, 0]\n",
        &section,
        &branch("trunk", ["A", "J"], "cable", 0.4, 40),
        &branch("left", ["J", "B"], "cable", 0.3, 30),
        &branch("right", ["J", "C"], "cable", 0.3, 30),
        loads,
        &connector("plug-A", "A", [0.0; 3]),
        &connector("plug-B", "B", [0.63, 0.17, 0.0]),
        steps,
    ]
    .concat()
}

const ALL: &str = r#"
[[steps]]
name = "all"
increments = 4
temperature = [{ change = "95 K" }]
load = [
  { load = "wind", factor = 1 },
  { load = "snow", factor = 1 },
  { load = "pull", factor = 1 },
  { load = "hub", factor = 1 },
]
"#;

/// The constraints bear exactly what acts: the certificate's balance, found again from the result alone.
#[test]
fn what_constraints_bear_is_what_acts() {
    let text = harness(ALL);
    let mut network = built(&text).network;
    network.loads.iter_mut().for_each(|load| load.factor = 1.0);
    let run = converged(&text);
    let gravity = Vector::new(3.0, -2.0, -9.81);
    let left = imbalance(&network, &gravity, end(&run));
    // The forces of a curved cable are those at segments, the result has frames and positions at nodes: second order,
    // 4e-4 of the forces here.
    assert!(left.force < 1e-3 && left.moment < 1e-3, "{left:?}");
    let quiet = imbalance(&built(&harness(ALL)).network, &gravity, end(&run));
    assert!(quiet.force > 0.1, "the loads hardly matter: {quiet:?}");
    assert_eq!(end(&run).stable, None);
    assert!(end(&run).minimiser.iterations < 100, "{}", end(&run).minimiser.iterations);
}

/// Minimisers that go by the energy name what has none.
#[test]
fn loads_without_a_potential_are_refused_by_minimisers_of_energies() {
    for (load, why) in [
        ("at = { branch = \"cable\", s = 0.5 }\nforce = [1, 0, 0]\nfollows = true", "follows the cable"),
        ("span = { branch = \"cable\" }\nforce_per_length = [1, 0, 0]\nfollows = true", "follows the cable"),
        ("span = { branch = \"cable\" }\nflow = { velocity = [9, 0, 0] }", "is the drag of a flow"),
    ] {
        let text = hanging("x", 10, &format!("[minimiser]\nkind = \"lbfgs\"\n[[loads]]\nname = \"load\"\n{load}\n"));
        let faults = wireloom::load(&text, &wireloom::registry()).err().expect("refused");
        let said = wireloom::scenario::render(&text, &faults);
        assert!(said.contains(&format!("load `load` {why}, which has no potential")), "{said}");
    }
}

/// A temperature that comes and goes leaves nothing behind, and a longer cable hangs lower.
#[test]
fn a_cable_that_warms_up_sags_and_rises_again() {
    let steps = "[[steps]]\nname = \"warm\"\nincrements = 2\n[[steps.temperature]]\nchange = 100\n\
                 [[steps]]\nname = \"cold\"\nincrements = 2\n[[steps.temperature]]\nchange = 0\n";
    let text = hanging("warm", 40, steps);
    let run = converged(&text.replace("axial", "thermal_expansion = 1e-4\naxial"));
    let start = converged(&hanging("warm", 40, ""));
    let sag = |end: &StepResult| -end.branches[0].position[20].z;
    // A chain of 1 m over 0.6 m: d sag/dL = 0.6 about; 1 % of a metre more.
    let lower = sag(&run.steps[0]) - sag(end(&start));
    assert!((0.004..0.008).contains(&lower), "{lower}");
    assert!(apart(&run.steps[1], end(&start)) < 1e-7);
    assert_eq!(run.steps[0].stable, Some(true));
}

/// A stiff bar on a hinge in a light wind hangs where `w cos²θ = ρ g sin θ`. The forces of the wind on the nodes of a
/// fine mesh were within the tolerance, and the bar did not move.
#[test]
fn a_light_wind_turns_a_stiff_bar_on_any_mesh() {
    const LENGTH: f64 = 0.2;
    for segments in [10, 200] {
        let run = converged(&format!(
            r#"schema = 1
[sections.bar]
diameter = "8 mm"
linear_density = 0.1
axial_stiffness = 1e6
shear_stiffness = 8e3
bending_stiffness = 0.5
torsion_stiffness = 0.04
[[branches]]
name = "bar"
from = "a"
to = "b"
section = "bar"
length = {LENGTH}
segments = {segments}
[[constraints]]
name = "hinge"
kind = "connector"
at = {{ end = "a" }}
position = [0, 0, 0]
tangent = [0, 0, -1]
up = [1, 0, 0]
free_axis = [0, 1, 0]
[[loads]]
name = "wind"
span = {{ branch = "bar" }}
flow = {{ velocity = [1, 0, 0] }}
"#
        ));
        // Air of 1.2 kg/m³ and the coefficient 1.2 are the defaults.
        let drag = 0.5 * 1.2 * 1.2 * 0.008;
        let mut sine = 0.0_f64;
        for _ in 0..20 {
            sine = drag * (1.0 - sine * sine) / (0.1 * 9.81);
        }
        let x = end(&run).branches[0].position.last().expect("a node").x;
        // The bar bends by less than w L⁴/8EI = 2 µm; the shape is refined to 1e-7 of the length.
        assert!((x - LENGTH * sine).abs() < 3e-6, "{x} for {} in {segments} segments", LENGTH * sine);
    }
}

/// A moment without a potential on a stiff bar, which stands on a soft hub.
#[test]
fn a_small_moment_turns_a_stiff_bar_on_a_soft_hub() {
    const MOMENT: f64 = 9e-4;
    let bar = |name: &str, from: &str, to: &str| {
        format!(
            "[[branches]]\nname = \"{name}\"\nfrom = \"{from}\"\nto = \"{to}\"\nsection = \"bar\"\nlength = 0.1\n\
             segments = 10\n"
        )
    };
    let run = converged(&format!(
        r#"schema = 1
gravity = [0, 0, 0]
[sections.bar]
diameter = "8 mm"
linear_density = 0.1
axial_stiffness = 1e6
bending_stiffness = 100.0
torsion_stiffness = 100.0
{}{}
[[joints]]
name = "J"
model = "compliant-hub"
bending_stiffness = 0.1
torsion_stiffness = 0.1
arms = [
  {{ branch = "A", direction = [-1, 0, 0], up = [0, 0, 1] }},
  {{ branch = "B", direction = [1, 0, 0], up = [0, 0, 1] }},
]
[[constraints]]
name = "a"
kind = "connector"
at = {{ end = "a" }}
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[loads]]
name = "turn"
at = {{ end = "b" }}
moment = [0, {MOMENT}, 0]
"#,
        bar("A", "a", "J"),
        bar("B", "J", "b")
    ));
    let tip = end(&run).branches[1].position.last().expect("a node").z;
    // Two springs in series; the bars bend by 1e-4 of that.
    let turn = 2.0 * MOMENT / 0.1;
    assert!((tip + 0.1 * turn).abs() < 1e-3 * 0.1 * turn, "{tip} for {}", -0.1 * turn);
    let moment = end(&run).constraints[0].moment;
    assert!((moment.norm() - MOMENT).abs() < 1e-4 * MOMENT, "{moment}");
}

/// A bar magnet along the end of a cable, in a field: its moment turns the end towards the field.
#[derive(Debug)]
struct Compass {
    /// Dipole moment times field, N m, world axes.
    field: Vector,
}

impl PointLoad for Compass {
    fn without_potential(&self) -> Option<&str> {
        Some("is a magnet")
    }
    fn axes(&self) -> Axes {
        Axes::World
    }
    fn on(&self, frame: &Rotation) -> [Vector; 2] {
        [Vector::zeros(), (frame * Vector::z()).cross(&self.field)]
    }
    fn derivative(&self, frame: &Rotation) -> [Matrix; 2] {
        let r = frame.to_rotation_matrix();
        [Matrix::zeros(), self.field.cross_matrix() * r.matrix() * Vector::z().cross_matrix()]
    }
    fn largest(&self) -> [f64; 2] {
        [0.0, self.field.norm()]
    }
}

/// Friction of a fluid along a cable, `c (v·t) t` per length.
#[derive(Debug)]
struct SkinFriction {
    /// v, m/s.
    velocity: Vector,
    /// c, N s/m².
    friction: f64,
}

impl LineLoad for SkinFriction {
    fn without_potential(&self) -> Option<&str> {
        Some("is the friction of a fluid")
    }
    fn on(&self, frame: &Rotation, _: f64) -> Vector {
        let t = frame * Vector::z();
        t * (self.friction * t.dot(&self.velocity))
    }
    fn derivative(&self, frame: &Rotation, _: f64) -> Matrix {
        let t = frame * Vector::z();
        let of_t = (Matrix::identity() * t.dot(&self.velocity) + t * self.velocity.transpose()) * self.friction;
        -(of_t * frame.to_rotation_matrix().matrix() * Vector::z().cross_matrix())
    }
    fn largest(&self, _: f64) -> f64 {
        self.friction * self.velocity.norm()
    }
}

point_load_conformance!(compass, |turn: &Rotation| Box::new(Compass { field: turn * Vector::new(0.02, -0.01, 0.03) }));
line_load_conformance!(skin_friction, |turn: &Rotation| Box::new(SkinFriction {
    velocity: turn * Vector::new(3.0, 1.0, -2.0),
    friction: 0.4,
}));

/// The end of a cable without weight, clamped along x, under a load of another program.
fn with_own(load: impl FnOnce(&Network) -> LoadAction<LoadSite, NodeRange>) -> Run {
    let text = [
        "schema = 1\nname = \"own\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("cable", ["A", "B"], "cable", 0.5, 20),
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
    ]
    .concat();
    let mut own = built(&text);
    let action = load(&own.network);
    own.network.loads.push(Load { name: "own".to_owned(), action, factor: 1.0 });
    let run = wireloom::run(own, &mut |_, _| Control::Continue);
    assert_eq!(run.status(), Status::Converged, "{:?}", run.events);
    run
}

/// A pure moment at the end bends the cable to an arc: its angle θ satisfies `EI θ/L = μ B sin(φ − θ)`.
#[test]
fn a_load_of_another_program_at_a_place_is_in_balance() {
    let (size, phi) = (0.04, 2.0_f64);
    let field = Vector::new(phi.cos(), phi.sin(), 0.0) * size;
    let run = with_own(|network| LoadAction::At {
        place: network.load_site(Place::Node { branch: 0, node: 20 }),
        load: Arc::new(Compass { field }),
    });
    let mut theta = 0.5_f64;
    for _ in 0..50 {
        let residual = 0.01 * theta / 0.5 - size * (phi - theta).sin();
        theta -= residual / (0.01 / 0.5 + size * (phi - theta).cos());
    }
    let tangent = end(&run).branches[0].frame[20] * Vector::z();
    let exact = Vector::new(theta.cos(), theta.sin(), 0.0);
    assert!((tangent - exact).norm() < 1e-6, "{tangent}, not {exact}");
    assert_eq!(end(&run).stable, None);
}

/// A cable along the flow is pulled by all of the friction: `c v L` at its clamp.
#[test]
fn a_load_of_another_program_along_a_cable_is_in_balance() {
    let friction = SkinFriction { velocity: Vector::x() * 3.0, friction: 0.4 };
    let run = with_own(|_| LoadAction::Along {
        spans: vec![NodeRange { branch: 0, nodes: 0..21 }],
        load: Arc::new(friction),
    });
    let plug = &end(&run).constraints[0];
    assert!((plug.force + Vector::x() * (0.4 * 3.0 * 0.5)).norm() < 1e-9, "{}", plug.force);
}
