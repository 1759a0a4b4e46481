//! The tie satisfies the contract of equations, with a gap and without.

use wireloom_plugin::core::constraint::{ConstraintSpec, ConstraintView, StationSpec};
use wireloom_plugin::core::{Constraint, Parameters, Pose, Value, Vector};

fn tie(gap: f64) -> Box<dyn Constraint> {
    let station = StationSpec { place: Some(("branch".into(), 0.1)), diameter: 6e-3 };
    let spec = ConstraintSpec { name: "tie".into(), stations: vec![station; 2], ..ConstraintSpec::default() };
    let values = [("gap".to_owned(), Value::Number(gap)), ("tight_at".to_owned(), Value::Number(0.5))];
    (cable_tie::cable_tie().build)(&spec, &Parameters(values.into())).expect("a tie")
}

wireloom_testkit::equations_conformance!(touching, || tie(0.0), 2, 0);
wireloom_testkit::equations_conformance!(loose, || tie(5e-3), 2, 0);

/// Branches of 6 mm in a tie with a gap of 5 mm: it is 11 mm long at the end of its step.
#[test]
fn a_tie_is_loose_where_it_is_longer_than_the_branches_are_apart() {
    let loose = |apart: f64| {
        let pose = |x: f64| Pose { position: Vector::new(x, 0.0, 0.0), ..Pose::identity() };
        let (stations, targets) = ([pose(0.0), pose(apart)], [pose(0.0), pose(0.02)]);
        let at = ConstraintView {
            stations: &stations,
            targets: &targets,
            span: &[],
            span_lengths: &[],
            progress: 1.0,
            memory: &[],
            tensions: &[[0.0; 2]; 2],
        };
        tie(5e-3).outputs(&at).into_iter().find(|(name, _)| name == "loose").map(|(_, length)| length)
    };
    assert_eq!(loose(0.011), None);
    assert!(loose(0.008).is_some_and(|length| (length - 3e-3).abs() < 1e-12), "{:?}", loose(0.008));
}
