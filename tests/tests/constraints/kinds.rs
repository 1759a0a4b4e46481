//! Kinds of constraints of every shape, put into the registry as a third party would.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use wireloom::Registry;
use wireloom::geometry::{Matrix, Pose, Rotation, Vector};
use wireloom::parts::{
    Action, Attaches, Constraint, ConstraintKind, ConstraintSpec, ConstraintView, Form, Hold, HoldWord, Parameter,
    Parameters, Potential, Quantity, SpanUse,
};
use wireloom_testkit::constraints::{Floor, Link, Parts, Plunger, Strut};

fn number(name: &str, quantity: Quantity) -> Parameter {
    Parameter {
        name: name.into(),
        doc: format!("the {name}"),
        form: Form::Number { quantity, minimum: f64::NEG_INFINITY, exclusive: false, maximum: f64::INFINITY },
        default: None,
        required: true,
    }
}

fn add<C: Constraint + 'static>(
    registry: &mut Registry,
    name: &str,
    attaches: Attaches,
    parameters: Vec<Parameter>,
    build: impl Fn(&ConstraintSpec, &Parameters) -> C + Send + Sync + 'static,
) {
    let kind = ConstraintKind {
        name: name.into(),
        doc: format!("a {name}"),
        attaches,
        parameters,
        outputs: vec![],
        build: Box::new(move |spec, parameters| Ok(Box::new(build(spec, parameters)))),
    };
    assert!(registry.add_constraint(kind).is_ok());
}

/// The built-in kinds and those below.
pub fn registry() -> Registry {
    counting(Arc::default())
}

/// The same; ratchets count their commits.
pub fn counting(commits: Arc<AtomicUsize>) -> Registry {
    let mut registry = wireloom::registry();
    let pair = || Attaches::to_stations(2..=2);
    let length = |name: &str| number(name, Quantity::Length);
    add(&mut registry, "strut", pair(), vec![length("rest"), number("stiffness", Quantity::ForcePerLength)], |_, p| {
        Strut { rest: p.number("rest").unwrap(), stiffness: p.number("stiffness").unwrap() }
    });
    add(&mut registry, "link", pair(), vec![length("distance")], |_, p| Link(p.number("distance").unwrap()));
    let plungers = [("plunger", Parts::Both), ("plunger-spring", Parts::Spring), ("plunger-guide", Parts::Guide)];
    for (name, parts) in plungers {
        let stiffness = vec![number("stiffness", Quantity::ForcePerLength)];
        add(&mut registry, name, Attaches::default(), stiffness, move |_, p| Plunger {
            stiffness: p.number("stiffness").unwrap(),
            parts,
        });
    }
    let along = Attaches { stations: 0..=0, span: SpanUse::Always };
    add(&mut registry, "floor", along, vec![length("height")], |_, p| Floor(p.number("height").unwrap()));
    add(&mut registry, "ratchet", Attaches::default(), vec![], move |_, _| Ratchet(commits.clone()));
    add(&mut registry, "door", Attaches::default(), vec![number("angle", Quantity::Angle)], |_, p| {
        let words = [HoldWord::Position, HoldWord::Tangent, HoldWord::Twist];
        Door { hold: Hold::new(&words, None, &[]), angle: p.number("angle").unwrap() }
    });
    add(&mut registry, "brittle", Attaches::default(), vec![length("until")], |_, p| {
        Brittle(p.number("until").unwrap())
    });
    add(&mut registry, "worn", Attaches::default(), vec![length("until")], |_, p| Worn {
        until: p.number("until").unwrap(),
        broken: AtomicUsize::new(0),
    });
    registry
}

/// Lets a station pass along x, and pulls it back to the furthest place it has reached: `½ k max(0, m − x)²`; counts
/// commits.
pub struct Ratchet(pub Arc<AtomicUsize>);

/// N/m.
pub const RATCHET: f64 = 200.0;

impl Constraint for Ratchet {
    fn action(&self) -> Action<'_> {
        Action::Potential(self)
    }
    fn objective(&self) -> bool {
        false
    }
    fn memory(&self) -> Vec<f64> {
        vec![-1e3]
    }
    fn commit(&self, at: &ConstraintView<'_>, memory: &mut [f64]) {
        self.0.fetch_add(1, Ordering::Relaxed);
        memory[0] = memory[0].max(at.stations[0].position.x);
    }
}

impl Potential for Ratchet {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        0.5 * RATCHET * (at.memory[0] - at.stations[0].position.x).max(0.0).powi(2)
    }
    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], _: &mut [Vector]) -> f64 {
        stations[0].x = -RATCHET * (at.memory[0] - at.stations[0].position.x).max(0.0);
        self.energy(at)
    }
    fn hessian(&self, at: &ConstraintView<'_>, stations: &mut [Matrix], _: &mut [Matrix]) {
        if at.memory[0] > at.stations[0].position.x {
            stations[0][(0, 0)] = RATCHET;
        }
    }
}

/// Holds a station on a door that turns about the world's z axis while the step goes on.
pub struct Door {
    hold: Hold,
    angle: f64,
}

impl Constraint for Door {
    fn action(&self) -> Action<'_> {
        Action::Prescribed(&self.hold)
    }
    fn target(&self, base: &Pose, progress: f64) -> Pose {
        let turn = Rotation::from_axis_angle(&Vector::z_axis(), self.angle * progress);
        Pose { position: turn * base.position, orientation: turn * base.orientation }
    }
}

/// A potential that is not finite any more where its target is further than so far along y.
pub struct Brittle(pub f64);

impl Constraint for Brittle {
    fn action(&self) -> Action<'_> {
        Action::Potential(self)
    }
}

impl Potential for Brittle {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        let gap = at.stations[0].position - at.targets[0].position;
        if at.targets[0].position.y > self.0 { f64::NAN } else { 5.0 * gap.norm_squared() }
    }
    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], _: &mut [Vector]) -> f64 {
        stations[0] = (at.stations[0].position - at.targets[0].position) * 10.0;
        self.energy(at)
    }
    fn hessian(&self, _: &ConstraintView<'_>, stations: &mut [Matrix], _: &mut [Matrix]) {
        stations[0] = Matrix::identity() * 10.0;
    }
}

/// A spring that says by itself when it is not to be relied on any more.
pub struct Worn {
    until: f64,
    broken: AtomicUsize,
}

impl Constraint for Worn {
    fn action(&self) -> Action<'_> {
        Action::Potential(self)
    }
    fn memory(&self) -> Vec<f64> {
        vec![0.0]
    }
    fn commit(&self, at: &ConstraintView<'_>, _: &mut [f64]) {
        if at.targets[0].position.y > self.until {
            self.broken.store(1, Ordering::Relaxed);
        }
    }
    fn fault(&self) -> Option<String> {
        (self.broken.load(Ordering::Relaxed) == 1).then(|| "worn out".to_owned())
    }
}

impl Potential for Worn {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        5.0 * (at.stations[0].position - at.targets[0].position).norm_squared()
    }
    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], _: &mut [Vector]) -> f64 {
        stations[0] = (at.stations[0].position - at.targets[0].position) * 10.0;
        self.energy(at)
    }
    fn hessian(&self, _: &ConstraintView<'_>, stations: &mut [Matrix], _: &mut [Matrix]) {
        stations[0] = Matrix::identity() * 10.0;
    }
}
