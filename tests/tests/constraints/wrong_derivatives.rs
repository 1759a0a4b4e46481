//! Parts whose derivatives are not those of their values: each of them once came to rest as "converged".

use super::{bars, beam, run_with};
use wireloom::geometry::{Matrix, Vector};
use wireloom::parts::rods::constitutive;
use wireloom::parts::{
    Action, Attaches, ConstitutiveKind, ConstitutiveLaw, ConstitutiveLaws, Constraint, ConstraintKind, ConstraintView,
    Equations, JointKind, JointModel, JointShape, Mounting, Past, Point, Potential, Residual, Response,
};
use wireloom::{Registry, Run, Status};
use wireloom_testkit::constraints::{Link, Parts, Plunger};
use wireloom_tests::cables::{branch, connector, connector_along, section};

/// A spring whose first and second derivatives are those of its energy, times these factors.
struct LyingSpring([f64; 2]);

impl Constraint for LyingSpring {
    fn action(&self) -> Action<'_> {
        Action::Potential(self)
    }
}

impl Potential for LyingSpring {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        5.0 * (at.stations[0].position - at.targets[0].position).norm_squared()
    }
    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], _: &mut [Vector]) -> f64 {
        stations[0] = (at.stations[0].position - at.targets[0].position) * (10.0 * self.0[0]);
        self.energy(at)
    }
    fn hessian(&self, _: &ConstraintView<'_>, stations: &mut [Matrix], _: &mut [Matrix]) {
        stations[0] = Matrix::identity() * (10.0 * self.0[1]);
    }
}

/// A link whose Jacobian is doubled: it is met, with half the force.
struct DoubledLink(Link);

impl Constraint for DoubledLink {
    fn action(&self) -> Action<'_> {
        Action::Equations(self)
    }
    fn needs_frame(&self) -> bool {
        false
    }
}

impl Equations for DoubledLink {
    fn of_stations(&self) -> Vec<Residual> {
        self.0.of_stations()
    }
    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        self.0.residuals(at, c);
    }
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], span: &mut [Vector]) {
        self.0.jacobian(at, c, stations, span);
        stations.iter_mut().for_each(|j| *j *= 2.0);
    }
}

/// A joint whose first derivatives are those of its energy times this factor, and whose second ones are zero.
struct LyingJoint(f64);

impl JointModel for LyingJoint {
    fn mounting(&self) -> Mounting {
        Mounting::Point
    }
    fn energy(&self, JointShape { frames, .. }: &JointShape<'_>) -> f64 {
        1.0 - (frames[0] * Vector::z()).dot(&(frames[1] * Vector::z()))
    }
    fn add_gradient(&self, shape: &JointShape<'_>, gradient: &mut [Vector]) -> f64 {
        for (a, b) in [(0, 1), (1, 0)] {
            let other = shape.frames[a].inverse() * (shape.frames[b] * Vector::z());
            gradient[a] -= Vector::z().cross(&other) * self.0;
        }
        self.energy(shape)
    }
    fn add_hessian(&self, _: &JointShape<'_>, _: &mut [Matrix]) {}
}

/// A law of bending whose first and second derivatives are those of its energy, times these factors.
struct LyingLaw([f64; 2]);

impl ConstitutiveLaw for LyingLaw {
    fn respond(&self, curvatures: &[Vector], _: Past<'_>, response: &mut Response<'_>) {
        let Self([first, second]) = self;
        response.each(curvatures, |_, kappa| Point {
            energy: 0.005 * kappa.norm_squared(),
            gradient: kappa * (0.01 * first),
            hessian: Matrix::identity() * (0.01 * second),
        });
    }
}

/// An honest law that writes no number into its memory.
struct LosingLaw;

impl ConstitutiveLaw for LosingLaw {
    fn respond(&self, curvatures: &[Vector], past: Past<'_>, response: &mut Response<'_>) {
        LyingLaw([1.0, 1.0]).respond(curvatures, past, response);
    }
    fn memory(&self) -> usize {
        1
    }
    fn commit(&self, _: &[Vector], _: f64, memory: &mut [f64], _: &mut [f64]) {
        memory.fill(f64::NAN);
    }
}

/// A spring and a link in one, of which one is wrong: the doubled spring with an equation of its own, or the doubled
/// link with a spring that is right.
struct HalfWrong {
    spring: bool,
}

/// A guide along a tangent, and a spring beside it.
const RIGHT: [Plunger; 2] =
    [Plunger { stiffness: 10.0, parts: Parts::Guide }, Plunger { stiffness: 10.0, parts: Parts::Spring }];

/// `x3 = x°3` at the station, with twice its derivative.
struct DoubledHeight;

impl Constraint for HalfWrong {
    fn action(&self) -> Action<'_> {
        match self.spring {
            true => Action::PotentialAndEquations(&LyingSpring([2.0, 2.0]), &RIGHT[0]),
            false => Action::PotentialAndEquations(&RIGHT[1], &DoubledHeight),
        }
    }
}

impl Equations for DoubledHeight {
    fn of_stations(&self) -> Vec<Residual> {
        vec![Residual::zero(1.0)]
    }
    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        c[0] = at.stations[0].position.z - at.targets[0].position.z;
    }
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], _: &mut [Vector]) {
        self.residuals(at, c);
        stations[0] = Vector::z() * 2.0;
    }
}

fn registry() -> Registry {
    let mut registry = wireloom::registry();
    let mut constraint = |name: &str, stations: usize, build: fn() -> Box<dyn Constraint>| {
        let kind = ConstraintKind {
            name: name.into(),
            doc: format!("a {name}"),
            attaches: Attaches::to_stations(stations..=stations),
            parameters: vec![],
            outputs: vec![],
            build: Box::new(move |_, _| Ok(build())),
        };
        assert!(registry.add_constraint(kind).is_ok());
    };
    constraint("doubled-spring", 1, || Box::new(LyingSpring([2.0, 2.0])));
    constraint("wrong-slopes", 1, || Box::new(LyingSpring([1.0, 2.0])));
    constraint("half-wrong-spring", 1, || Box::new(HalfWrong { spring: true }));
    constraint("half-wrong-link", 1, || Box::new(HalfWrong { spring: false }));
    constraint("doubled-link", 2, || Box::new(DoubledLink(Link(0.3))));
    for (name, factor) in [("energy-alone", 0.0), ("no-slopes", 1.0)] {
        let joint = JointKind {
            name: name.into(),
            doc: "a joint".into(),
            parameters: vec![],
            build: Box::new(move |_, _| Ok(Box::new(LyingJoint(factor)))),
        };
        assert!(registry.add_joint(joint).is_ok());
    }
    let losing = ConstitutiveKind {
        name: "losing".into(),
        doc: "a rod".into(),
        parameters: vec![],
        build: Box::new(|_, _| Ok(Box::new(ConstitutiveLaws { stretch: None, bend: Some(Box::new(LosingLaw)) }))),
    };
    assert!(registry.add_rod(constitutive::kind(losing)).is_ok());
    for (name, factors) in [("honest", [1.0, 1.0]), ("doubled", [2.0, 2.0]), ("wrong-slopes", [1.0, 2.0])] {
        let laws = ConstitutiveKind {
            name: name.into(),
            doc: "a rod".into(),
            parameters: vec![],
            build: Box::new(move |_, _| {
                Ok(Box::new(ConstitutiveLaws { stretch: None, bend: Some(Box::new(LyingLaw(factors))) }))
            }),
        };
        assert!(registry.add_rod(constitutive::kind(laws)).is_ok());
    }
    registry
}

#[track_caller]
fn at_fault(run: &Run, part: &str) {
    assert_eq!(run.status(), Status::Failed, "{:?}", run.events);
    let fault = run.fault().expect("a fault").to_string();
    assert!(fault.starts_with(part) && fault.contains("not those of its values"), "{fault}");
    assert!(run.steps.is_empty(), "no increment ended");
}

/// As [`at_fault`], for second derivatives.
#[track_caller]
fn has_wrong_slopes(run: &Run, part: &str) {
    let fault = run.fault().expect("a fault").to_string();
    let what = "its second derivatives are not those of its first derivatives";
    assert!(fault.starts_with(part) && fault.contains(what), "{fault}");
}

/// A beam that hangs from such a spring at its end.
fn hanging_from(kind: &str) -> Run {
    let hand = format!(
        "[[constraints]]\nname = \"hand\"\nkind = \"{kind}\"\nat = {{ end = \"B\" }}\nposition = [1, 0, 0.01]\n"
    );
    run_with(&beam(&hand, -9.81), &registry())
}

#[test]
fn a_spring_that_pulls_twice_as_hard_as_its_energy_says_is_at_fault() {
    at_fault(&hanging_from("doubled-spring"), "constraint `hand` (doubled-spring)");
}

/// With a stiffness that it does not have, an equilibrium may be called stable that is not.
#[test]
fn a_spring_of_another_stiffness_than_its_force_has_is_at_fault() {
    has_wrong_slopes(&hanging_from("wrong-slopes"), "constraint `hand` (wrong-slopes)");
}

#[test]
fn a_link_that_exerts_half_its_force_is_at_fault() {
    let link = "[[constraints]]\nname = \"link\"\nkind = \"doubled-link\"\nat = [{ end = \"B\" }, { end = \"C\" }]\n";
    at_fault(&run_with(&bars(link), &registry()), "constraint `link` (doubled-link)");
}

/// Of a potential and equations in one each half is looked at for itself.
#[test]
fn a_constraint_of_which_one_half_lies_is_at_fault() {
    for kind in ["half-wrong-spring", "half-wrong-link"] {
        let hand = format!(
            "[[constraints]]\nname = \"hand\"\nkind = \"{kind}\"\nat = {{ end = \"B\" }}\nposition = [1, 0, 0.01]\n\
             tangent = [1, 0, 0]\nup = [0, 0, 1]\n"
        );
        at_fault(&run_with(&beam(&hand, -9.81), &registry()), &format!("constraint `hand` ({kind})"));
    }
}

/// Two cables that meet at an angle in such a joint.
fn joined_by(model: &str) -> Run {
    let joint = format!(
        "[[joints]]\nname = \"J\"\nmodel = \"{model}\"\narms = [\n\
         {{ branch = \"left\", direction = [-1, 0, 0], up = [0, 0, 1] }},\n\
         {{ branch = \"right\", direction = [1, 0, 0], up = [0, 0, 1] }},\n]\n"
    );
    let text = [
        "schema = 1\nname = \"bend\"\ngravity = [0, 0, 0]\n",
        &section("cable"),
        &branch("left", ["A", "J"], "cable", 0.5, 10),
        &branch("right", ["J", "B"], "cable", 0.5, 10),
        &joint,
        &connector("A", "A", [0.0, 0.0, 0.0]),
        &connector_along("B", "B", [0.7, 0.4, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
    ]
    .concat();
    run_with(&text, &registry())
}

#[test]
fn a_joint_with_an_energy_that_exerts_nothing_is_at_fault() {
    at_fault(&joined_by("energy-alone"), "joint `J` (energy-alone)");
}

#[test]
fn a_joint_without_the_stiffness_that_its_moment_has_is_at_fault() {
    has_wrong_slopes(&joined_by("no-slopes"), "joint `J` (no-slopes)");
}

/// A cable that hangs down from a clamp, of this rod.
fn hanging(rod: &str) -> Run {
    let cable = branch("cable", ["A", "B"], "cable", 0.5, 20);
    let text = [
        "schema = 1\nname = \"hang\"\n",
        &section("cable"),
        &cable.replace("[[branches]]\n", &format!("[[branches]]\nrod = \"{rod}\"\n")),
        &connector("A", "A", [0.0, 0.0, 0.0]),
    ]
    .concat();
    run_with(&text, &registry())
}

#[test]
fn a_rod_with_twice_the_moment_that_its_energy_has_is_at_fault() {
    at_fault(&hanging("doubled"), "rod `cable` (doubled)");
    assert_eq!(hanging("honest").status(), Status::Converged);
}

#[test]
fn a_rod_with_second_derivatives_that_are_not_those_of_its_moment_is_at_fault() {
    has_wrong_slopes(&hanging("wrong-slopes"), "rod `cable` (wrong-slopes)");
}

/// Nothing else would have looked at it: the law does not depend on what it remembers.
#[test]
fn a_rod_that_remembers_what_is_no_number_is_at_fault() {
    let fault = hanging("losing").fault().expect("a fault").to_string();
    assert!(fault.contains("what it remembers is not a finite number"), "{fault}");
}
