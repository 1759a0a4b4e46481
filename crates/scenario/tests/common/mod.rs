//! A registry of kinds that have the names and parameters of the built-in ones and no mechanics, so that this
//! crate is tested without them; shapes are the built-in ones.

use wireloom_core::constraint::{
    Action, Attaches, Constraint, ConstraintSpec, ConstraintView, Hold, HoldWord, Potential,
};
use wireloom_core::joint::{JointModel, JointShape, JointSpec, Mounting};
use wireloom_core::minimiser::{Minimiser, Report, Stop};
use wireloom_core::registry::{
    BuildError, ConstraintKind, Form, JointKind, MinimiserKind, Parameter, Parameters, Quantity, RodKind, Value,
};
use wireloom_core::rod::{BranchHessian, BranchShape, Mesh, RodEnergy, RodSegment};
use wireloom_core::status::Status;
use wireloom_core::{Matrix, Problem, Registry, Rotation, State, Vector};

struct Rod(Mesh);

impl RodSegment for Rod {
    fn mesh(&self) -> &Mesh {
        &self.0
    }
    fn energy(&self, _: &BranchShape<'_>) -> RodEnergy {
        RodEnergy::default()
    }
    fn coupling_gradient(&self, _: &BranchShape<'_>, _: &mut [Vector]) -> f64 {
        0.0
    }
    fn segment_gradient(&self, _: &BranchShape<'_>, _: &mut [Vector], _: &mut [Vector]) -> f64 {
        0.0
    }
    fn hessian(&self, _: &BranchShape<'_>, _: Option<&[Vector]>, _: &mut BranchHessian) {}
    fn edge_stiffness(&self, _: &BranchShape<'_>, _: &mut [Matrix]) {}
    fn predicted_forces(&self, _: &BranchShape<'_>, _: &[Vector], _: &[Vector], _: &mut [Vector]) {}
    fn forces(&self, _: &BranchShape<'_>, _: &mut [Vector]) {}
    fn moments(&self, _: &BranchShape<'_>, _: &mut [Vector]) {}
    fn length_terms(&self, _: &BranchShape<'_>, _: &mut [[f64; 2]], _: &mut [[f64; 3]]) {}
    fn length_mixed(&self, _: &BranchShape<'_>, _: &[f64], _: &[f64], _: &mut [Vector], _: &mut [Vector]) {}
    fn rest_rotation(&self, _: usize) -> Rotation {
        Rotation::identity()
    }
}

struct Joint {
    mounting: Mounting,
    notes: Vec<String>,
}

impl JointModel for Joint {
    fn mounting(&self) -> Mounting {
        self.mounting
    }
    fn energy(&self, _: &JointShape<'_>) -> f64 {
        0.0
    }
    fn add_gradient(&self, _: &JointShape<'_>, _: &mut [Vector]) -> f64 {
        0.0
    }
    fn add_hessian(&self, _: &JointShape<'_>, _: &mut [Matrix]) {}
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }
}

struct Fixed(Hold);

impl Constraint for Fixed {
    fn action(&self) -> Action<'_> {
        Action::Prescribed(&self.0)
    }
}

struct Spring(f64);

impl Potential for Spring {
    fn energy(&self, _: &ConstraintView<'_>) -> f64 {
        0.0
    }
    fn gradient(&self, _: &ConstraintView<'_>, _: &mut [Vector], _: &mut [Vector]) -> f64 {
        0.0
    }
    fn hessian(&self, _: &ConstraintView<'_>, stations: &mut [Matrix], _: &mut [Matrix]) {
        stations[0] = Matrix::identity() * self.0;
    }
}

impl Constraint for Spring {
    fn action(&self) -> Action<'_> {
        Action::Potential(self)
    }
}

struct Idle(String);

impl Minimiser for Idle {
    fn name(&self) -> &str {
        &self.0
    }
    fn forget(&mut self) {}
    fn minimise(&mut self, _: &mut Problem<'_>, _: &mut State, _: &Stop) -> Report {
        Report { residual: 0.0, ..Report::begun(Status::Failed) }
    }
}

const EVERYTHING: [HoldWord; 3] = [HoldWord::Position, HoldWord::Tangent, HoldWord::Twist];

fn collar(spec: &ConstraintSpec, parameters: &Parameters) -> Result<Box<dyn Constraint>, BuildError> {
    let held = parameters.word("twist") == Some("held");
    Ok(Box::new(Fixed(spec.hold(&EVERYTHING[..if held { 3 } else { 2 }]))))
}

fn handle(spec: &ConstraintSpec, parameters: &Parameters) -> Result<Box<dyn Constraint>, BuildError> {
    if let Some(stiffness) = parameters.number("stiffness") {
        return Ok(Box::new(Spring(stiffness)));
    }
    let given = [true, spec.tangent_given, spec.up_given];
    let words: Vec<HoldWord> = EVERYTHING.into_iter().zip(given).filter(|(_, given)| *given).map(|(w, _)| w).collect();
    Ok(Box::new(Fixed(spec.hold(&words))))
}

fn fused(spec: &JointSpec, _: &Parameters) -> Result<Box<dyn JointModel>, BuildError> {
    match spec.arms.iter().find(|arm| arm.offset.norm() > 0.0) {
        None => Ok(Box::new(Joint { mounting: Mounting::Pose, notes: vec![] })),
        Some(arm) => Err(BuildError::new(
            format!("arm `{}` of the fused joint `{}` has an offset", arm.branch, spec.name),
            "a fused joint has no size: leave `offset` out, or use model = \"rigid-body\"",
        )
        .at("offset")),
    }
}

fn spring(name: &str, quantity: Quantity) -> Parameter {
    Parameter {
        name: name.into(),
        doc: "a spring between hand and cable".into(),
        form: Form::Number { quantity, minimum: 0.0, exclusive: true, maximum: f64::INFINITY },
        default: None,
        required: false,
    }
}

type Build<S, T> = fn(&S, &Parameters) -> Result<Box<T>, BuildError>;

fn constraint(name: &str, parameters: Vec<Parameter>, build: Build<ConstraintSpec, dyn Constraint>) -> ConstraintKind {
    ConstraintKind {
        name: name.into(),
        doc: format!("a {name}"),
        attaches: Attaches::default(),
        parameters,
        outputs: vec![],
        build: Box::new(build),
    }
}

fn joint(name: &str, build: Build<JointSpec, dyn JointModel>) -> JointKind {
    JointKind { name: name.into(), doc: format!("a {name} joint"), parameters: vec![], build: Box::new(build) }
}

/// The names and parameters of the built-in kinds.
pub fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_shapes::register(&mut registry, None);
    let rod = RodKind {
        name: "cosserat".into(),
        doc: "a rod".into(),
        parameters: vec![],
        build: Box::new(|spec, _| Ok(Box::new(Rod(spec.mesh.clone())))),
    };
    assert!(registry.add_rod(rod).is_ok());
    let point = |spec: &JointSpec, _: &Parameters| {
        let notes = vec![format!("{} arms", spec.arms.len())];
        Ok(Box::new(Joint { mounting: Mounting::Point, notes }) as Box<dyn JointModel>)
    };
    let hub = |_: &JointSpec, _: &Parameters| {
        Ok(Box::new(Joint { mounting: Mounting::Pose, notes: vec![] }) as Box<dyn JointModel>)
    };
    for kind in [joint("cosserat", point), joint("rigid-body", hub), joint("fused", fused)] {
        assert!(registry.add_joint(kind).is_ok());
    }
    let twist = Parameter {
        name: "twist".into(),
        doc: "whether the clip keeps the bundle from turning about its own axis".into(),
        form: Form::Choice(vec!["free".into(), "held".into()]),
        default: Some(Value::Word("free".into())),
        required: false,
    };
    let springs =
        vec![spring("stiffness", Quantity::ForcePerLength), spring("angular_stiffness", Quantity::MomentPerAngle)];
    let connector =
        |spec: &ConstraintSpec, _: &Parameters| Ok(Box::new(Fixed(spec.hold(&EVERYTHING))) as Box<dyn Constraint>);
    for kind in [
        constraint("connector", vec![], connector),
        constraint("collar", vec![twist], collar),
        constraint("handle", springs, handle),
    ] {
        assert!(registry.add_constraint(kind).is_ok());
    }
    for name in ["newton", "lbfgs", "ncg"] {
        let kind = MinimiserKind {
            name: name.into(),
            doc: format!("the minimiser {name}"),
            parameters: vec![],
            build: Box::new(move |(), _| Ok(Box::new(Idle(name.into())))),
        };
        assert!(registry.add_minimiser(kind).is_ok());
    }
    registry
}
