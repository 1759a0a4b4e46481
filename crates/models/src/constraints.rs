//! Built-in constraints: `connector`, `collar`, `handle`.

use crate::kernel::BendTwist;
use wireloom_core::constraint::{
    Action, Attaches, Constraint, ConstraintSpec, ConstraintView, Hold, HoldWord, Potential,
};
use wireloom_core::law::{SpringLaw, TurningLaw};
use wireloom_core::registry::{BuildError, ConstraintKind, Form, Parameter, Parameters, Quantity, Value};
use wireloom_core::rotation::columns;
use wireloom_core::{Matrix, Pose, Vector};

/// Prescribes freedoms of a station.
pub struct Fixed(Hold);

impl Constraint for Fixed {
    fn action(&self) -> Action<'_> {
        Action::Prescribed(&self.0)
    }
}

/// The kind `connector`.
pub fn connector() -> ConstraintKind {
    ConstraintKind {
        name: "connector".into(),
        doc: "holds position, tangent and twist, as a plugged connector does".into(),
        attaches: Attaches::default(),
        parameters: vec![],
        outputs: vec![],
        build: Box::new(|spec, _| {
            Ok(Box::new(Fixed(spec.hold(&[HoldWord::Position, HoldWord::Tangent, HoldWord::Twist]))))
        }),
    }
}

/// The kind `collar`.
pub fn collar() -> ConstraintKind {
    ConstraintKind {
        name: "collar".into(),
        doc: "a clip around the bundle: holds position and tangent; the twist is free unless held".into(),
        attaches: Attaches::default(),
        parameters: vec![Parameter {
            name: "twist".into(),
            doc: "whether the clip also keeps the bundle from turning about its own axis".into(),
            form: Form::Choice(vec!["free".into(), "held".into()]),
            default: Some(Value::Word("free".into())),
            required: false,
        }],
        outputs: vec![],
        build: Box::new(|spec, parameters| {
            let mut words = vec![HoldWord::Position, HoldWord::Tangent];
            if parameters.word("twist") == Some("held") {
                words.push(HoldWord::Twist);
            }
            Ok(Box::new(Fixed(spec.hold(&words))))
        }),
    }
}

/// The kind `handle`.
pub fn handle() -> ConstraintKind {
    let spring = |name: &str, doc: &str, quantity| Parameter {
        name: name.into(),
        doc: doc.into(),
        form: Form::Number { quantity, minimum: 0.0, exclusive: true, maximum: f64::INFINITY },
        default: None,
        required: false,
    };
    ConstraintKind {
        name: "handle".into(),
        doc: "what a hand or robot holds: the position, and tangent and twist where they are given; rigid or springy"
            .into(),
        attaches: Attaches::default(),
        parameters: vec![
            spring("stiffness", "spring between hand and cable; left out, the hand is rigid", Quantity::ForcePerLength),
            spring(
                "angular_stiffness",
                "spring that turns the cable to the given tangent or orientation; goes with stiffness",
                Quantity::MomentPerAngle,
            ),
        ],
        outputs: vec![],
        build: Box::new(build_handle),
    }
}

fn build_handle(spec: &ConstraintSpec, parameters: &Parameters) -> Result<Box<dyn Constraint>, BuildError> {
    let mut words = vec![HoldWord::Position];
    if spec.tangent_given {
        words.push(HoldWord::Tangent);
    }
    if spec.up_given {
        words.push(HoldWord::Twist);
    }
    let hold = spec.hold(&words);
    let angular = parameters.number("angular_stiffness");
    let Some(linear) = parameters.number("stiffness") else {
        return match angular {
            None => Ok(Box::new(Fixed(hold))),
            Some(k) => Err(BuildError::new(
                format!("handle `{}` has angular_stiffness = {k} but no stiffness", spec.name),
                "give `stiffness` (N/m) too, or leave both out for a rigid handle",
            )
            .at("angular_stiffness")),
        };
    };
    if !hold.rails.is_empty() || spec.free_axis.is_some() || spec.hold.is_some() {
        return Err(BuildError::new(
            format!("springy handle `{}` spells out freedoms", spec.name),
            "`hold`, `rail` and `free_axis` go with rigid constraints: leave `stiffness` out",
        )
        .at("stiffness"));
    }
    if angular.is_none() && spec.tangent_given {
        return Err(BuildError::new(
            format!("springy handle `{}` is given a direction but nothing to turn the cable with", spec.name),
            "give `angular_stiffness` (N m/rad) too, or leave the direction out",
        )
        .at("stiffness"));
    }
    let angular = match (angular, spec.up_given) {
        (None, _) => Angular::None,
        (Some(k), true) => Angular::Frame(k),
        (Some(k), false) => Angular::Tangent(k),
    };
    Ok(Box::new(Spring { linear, angular }))
}

/// Rotational coupling between the handle and the cable.
enum Angular {
    /// Nothing.
    None,
    /// `½ k |d3 − t|²`, N m/rad.
    Tangent(f64),
    /// `½ k |κ|²` with κ the curvature of a [`BendTwist`] of length 1 from target to station, N m/rad.
    Frame(f64),
}

/// A springy handle: `½ k |x − x_target|²`, and likewise for the orientation.
pub struct Spring {
    linear: f64,
    angular: Angular,
}

impl Constraint for Spring {
    fn action(&self) -> Action<'_> {
        Action::Potential(self)
    }

    fn needs_frame(&self) -> bool {
        !matches!(self.angular, Angular::None)
    }

    fn law(&self) -> Option<SpringLaw> {
        let turning = match self.angular {
            Angular::None => TurningLaw::None,
            Angular::Tangent(k) => TurningLaw::Tangent(k),
            Angular::Frame(k) => TurningLaw::Frame(k),
        };
        Some(SpringLaw { stiffness: self.linear, turning })
    }
}

impl Spring {
    /// The frame's spring is a bend-twist element of length 1 between target and station.
    fn turn(k: f64, at: &Pose, target: &Pose) -> (BendTwist, Vector) {
        let c = Vector::repeat(k);
        (BendTwist::new(&target.orientation, &at.orientation, 1.0, &c, &Vector::zeros()), c)
    }
}

impl Potential for Spring {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        let (at, target) = (&at.stations[0], &at.targets[0]);
        let turn = match self.angular {
            Angular::None => 0.0,
            Angular::Tangent(k) => {
                0.5 * k * (columns(&at.orientation)[2] - columns(&target.orientation)[2]).norm_squared()
            }
            Angular::Frame(k) => {
                let (bend, twist) = Self::turn(k, at, target).0.energy(1.0);
                bend + twist
            }
        };
        0.5 * self.linear * (at.position - target.position).norm_squared() + turn
    }

    /// For the tangent: `½|d3 − t|² = 1 − d3·t`, `δd3 = R (θ × e3)`, so `∂/∂θ = −k e3 × Rᵀt`.
    fn gradient(&self, situation: &ConstraintView<'_>, stations: &mut [Vector], _: &mut [Vector]) -> f64 {
        let (at, target) = (&situation.stations[0], &situation.targets[0]);
        let turn = match self.angular {
            Angular::None => Vector::zeros(),
            Angular::Tangent(k) => {
                let t = at.orientation.inverse_transform_vector(&columns(&target.orientation)[2]);
                Vector::z().cross(&t) * -k
            }
            Angular::Frame(k) => Self::turn(k, at, target).0.gradient().1,
        };
        stations[0] = (at.position - target.position) * self.linear;
        stations[1] = turn;
        self.energy(situation)
    }

    /// For the tangent: `−k t_b·(½ θ × (θ × e3))'' = k (t_b·e3 I − sym(t_b e3ᵀ))`, `t_b = Rᵀ t`.
    fn hessian(&self, at: &ConstraintView<'_>, stations: &mut [Matrix], _: &mut [Matrix]) {
        let (at, target) = (&at.stations[0], &at.targets[0]);
        let turn = match self.angular {
            Angular::None => Matrix::zeros(),
            Angular::Tangent(k) => {
                let t = at.orientation.inverse_transform_vector(&columns(&target.orientation)[2]);
                let outer = t * Vector::z().transpose();
                (Matrix::identity() * t.z - (outer + outer.transpose()) * 0.5) * k
            }
            Angular::Frame(k) => {
                let (law, c) = Self::turn(k, at, target);
                law.hessian(&c).bb
            }
        };
        stations[0] = Matrix::identity() * self.linear;
        stations[3] = turn;
    }
}
