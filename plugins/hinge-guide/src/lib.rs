//! `hinge-guide`: a clip on a door or an arm that rotates about an axis. README.md lists the parameters.

use wireloom_plugin::core::constraint::{Attaches, ConstraintSpec, ConstraintView, Hold, HoldWord};
use wireloom_plugin::core::registry::{
    BuildError, ConstraintKind, Form, Output, Parameter, Parameters, Quantity, Value,
};
use wireloom_plugin::core::{Action, Constraint, Pose, Rotation, Vector};

wireloom_plugin::export! { constraints: [turning_clip()] }

/// The kind `turning-clip`.
pub fn turning_clip() -> ConstraintKind {
    let vector = |name: &str, doc: &str, quantity| Parameter {
        name: name.into(),
        doc: doc.into(),
        form: Form::Vector { quantity },
        default: None,
        required: true,
    };
    ConstraintKind {
        name: "turning-clip".into(),
        doc: "a clip on a door or an arm, which turns about an axis over the step in which the clip begins to hold"
            .into(),
        attaches: Attaches::default(),
        parameters: vec![
            vector("hinge", "a point on the axis of the hinge", Quantity::Length),
            vector(
                "axis",
                "direction of the axis; the turn is counter-clockwise, seen against it",
                Quantity::Dimensionless,
            ),
            Parameter {
                name: "angle".into(),
                doc: "how far the door has turned at the end of the step; negative: the other way".into(),
                form: Form::Number {
                    quantity: Quantity::Angle,
                    minimum: f64::NEG_INFINITY,
                    exclusive: false,
                    maximum: f64::INFINITY,
                },
                default: None,
                required: true,
            },
            Parameter {
                name: "twist".into(),
                doc: "whether the clip also keeps the bundle from turning about its own axis".into(),
                form: Form::Choice(vec!["free".into(), "held".into()]),
                default: Some(Value::Word("free".into())),
                required: false,
            },
        ],
        outputs: vec![Output {
            name: "angle".into(),
            doc: "how far the door has turned".into(),
            quantity: Quantity::Angle,
            event: false,
        }],
        build: Box::new(|spec, parameters| Ok(Box::new(Clip::new(spec, parameters)?))),
    }
}

/// A rotating clip.
struct Clip {
    hold: Hold,
    /// c, m.
    hinge: Vector,
    /// φ, rad.
    angle: f64,
    /// a φ, rad.
    turn: Vector,
}

impl Clip {
    fn new(spec: &ConstraintSpec, parameters: &Parameters) -> Result<Self, BuildError> {
        let vector = |name: &str| match parameters.0.get(name) {
            Some(Value::Vector(v)) => *v,
            _ => Vector::zeros(),
        };
        let Some(axis) = vector("axis").try_normalize(1e-300) else {
            let message = format!("`axis` of turning clip `{}` has no direction", spec.name);
            return Err(
                BuildError::new(message, "give three numbers that are not all zero, such as [0, 0, 1]").at("axis")
            );
        };
        let mut words = vec![HoldWord::Position, HoldWord::Tangent];
        if parameters.word("twist") == Some("held") {
            words.push(HoldWord::Twist);
        }
        let angle = parameters.number("angle").unwrap_or_default();
        Ok(Self { hold: spec.hold(&words), hinge: vector("hinge"), angle, turn: axis * angle })
    }
}

impl Constraint for Clip {
    fn action(&self) -> Action<'_> {
        Action::Prescribed(&self.hold)
    }

    /// The hinge is fixed in the world.
    fn objective(&self) -> bool {
        false
    }

    fn outputs(&self, at: &ConstraintView<'_>) -> Vec<(String, f64)> {
        vec![("angle".into(), self.angle * at.progress)]
    }

    /// `R = exp(p φ a)`: `x = c + R (x° − c)`, `q = R q°`
    fn target(&self, base: &Pose, progress: f64) -> Pose {
        let turn = Rotation::from_scaled_axis(self.turn * progress);
        Pose { position: self.hinge + turn * (base.position - self.hinge), orientation: turn * base.orientation }
    }
}
