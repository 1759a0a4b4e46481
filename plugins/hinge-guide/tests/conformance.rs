//! The clip satisfies the contract of prescribed constraints, and its target follows the rotation computed by hand.

use wireloom_plugin::core::constraint::ConstraintSpec;
use wireloom_plugin::core::{Constraint, Parameters, Pose, Value, Vector};

fn clip(angle: f64) -> Box<dyn Constraint> {
    let values = [
        ("hinge".to_owned(), Value::Vector(Vector::new(1.0, 0.0, 0.0))),
        ("axis".to_owned(), Value::Vector(Vector::new(0.0, 0.0, 2.0))),
        ("angle".to_owned(), Value::Number(angle)),
        ("twist".to_owned(), Value::Word("free".into())),
    ];
    (hinge_guide::turning_clip().build)(&ConstraintSpec::default(), &Parameters(values.into())).expect("a clip")
}

wireloom_testkit::constraint_conformance!(contract, || clip(1.0));

#[test]
fn a_quarter_turn_about_an_axis_beside_the_origin() {
    let base = Pose { position: Vector::new(3.0, 0.0, 0.5), ..Pose::identity() };
    let clip = clip(std::f64::consts::PI);
    let half_way = clip.target(&base, 0.5);
    assert!((half_way.position - Vector::new(1.0, 2.0, 0.5)).norm() < 1e-15, "{}", half_way.position);
    assert!((half_way.orientation * Vector::x() - Vector::y()).norm() < 1e-15);
    assert_eq!(clip.target(&base, 0.0), base);
}
