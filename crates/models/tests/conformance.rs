//! The built-in kinds, as the registry makes them, under the conformance suites.

use nalgebra::Unit;
use wireloom_core::constraint::{Constraint, ConstraintSpec, HoldWord};
use wireloom_core::joint::{JointModel, JointSpec};
use wireloom_core::rod::{RodSegment, RodSpec};
use wireloom_core::{Parameters, Registry, Value, Vector};
use wireloom_testkit::{constraint_conformance, joint_conformance, potential_conformance, rod_conformance};

fn registry() -> Registry {
    let mut registry = Registry::default();
    wireloom_models::register(&mut registry);
    registry
}

fn rod(kind: &'static str) -> impl Fn(RodSpec) -> Box<dyn RodSegment> {
    let registry = registry();
    move |spec| (registry.rod(kind).unwrap().build)(&spec, &Parameters::default()).unwrap()
}

fn joint(kind: &'static str) -> impl Fn(JointSpec) -> Box<dyn JointModel> {
    let registry = registry();
    move |spec| (registry.joint(kind).unwrap().build)(&spec, &Parameters::default()).unwrap()
}

fn constraint(
    kind: &'static str,
    spec: ConstraintSpec,
    values: &[(&'static str, Value)],
) -> impl Fn() -> Box<dyn Constraint> {
    let registry = registry();
    let values = Parameters(values.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect());
    move || (registry.constraint(kind).unwrap().build)(&spec, &values).unwrap()
}

/// As where a scenario says nothing.
fn plain() -> ConstraintSpec {
    ConstraintSpec::default()
}

fn directed(up_given: bool) -> ConstraintSpec {
    ConstraintSpec { tangent_given: true, up_given, ..plain() }
}

fn on_rails(rails: &[[f64; 3]]) -> ConstraintSpec {
    ConstraintSpec { rails: rails.iter().map(|r| Vector::from(*r)).collect(), ..plain() }
}

fn hinged() -> ConstraintSpec {
    ConstraintSpec { free_axis: Some(Unit::new_normalize(Vector::new(1.0, 2.0, -1.0))), ..plain() }
}

fn holding(words: &[HoldWord]) -> ConstraintSpec {
    ConstraintSpec { hold: Some(words.to_vec()), ..plain() }
}

/// N/m and, where it turns too, N m/rad.
fn springs(angular: Option<f64>) -> Vec<(&'static str, Value)> {
    let mut values = vec![("stiffness", Value::Number(35.0))];
    values.extend(angular.map(|k| ("angular_stiffness", Value::Number(k))));
    values
}

rod_conformance!(cosserat_rod, rod("cosserat"));

joint_conformance!(cosserat_joint, joint("cosserat"));
joint_conformance!(rigid_body_joint, joint("rigid-body"));
joint_conformance!(fused_joint, joint("fused"));

constraint_conformance!(connector, constraint("connector", plain(), &[]));
constraint_conformance!(hinge, constraint("connector", hinged(), &[]));
constraint_conformance!(connector_on_a_rail, constraint("connector", on_rails(&[[0.0, 3.0, 4.0]]), &[]));
constraint_conformance!(
    connector_on_a_plane,
    constraint("connector", on_rails(&[[1.0, 1.0, 0.0], [0.0, 1.0, -2.0]]), &[])
);
constraint_conformance!(twist_alone, constraint("connector", holding(&[HoldWord::Twist]), &[]));
constraint_conformance!(collar, constraint("collar", plain(), &[]));
constraint_conformance!(collar_with_twist, constraint("collar", plain(), &[("twist", Value::Word("held".into()))]));
constraint_conformance!(handle, constraint("handle", plain(), &[]));
constraint_conformance!(handle_with_tangent, constraint("handle", directed(false), &[]));
constraint_conformance!(handle_with_frame, constraint("handle", directed(true), &[]));

potential_conformance!(springy_handle, constraint("handle", plain(), &springs(None)));
potential_conformance!(springy_handle_with_tangent, constraint("handle", directed(false), &springs(Some(0.4))));
potential_conformance!(springy_handle_with_frame, constraint("handle", directed(true), &springs(Some(0.4))));
