//! The tie satisfies the contract of equations, with a gap and without.

use wireloom_plugin::core::constraint::{ConstraintSpec, StationSpec};
use wireloom_plugin::core::{Constraint, Parameters, Value};

fn tie(gap: f64) -> Box<dyn Constraint> {
    let station = StationSpec { place: Some(("branch".into(), 0.1)), diameter: 6e-3 };
    let spec = ConstraintSpec { name: "tie".into(), stations: vec![station; 2], ..ConstraintSpec::default() };
    let values = [("gap".to_owned(), Value::Number(gap)), ("tight_at".to_owned(), Value::Number(0.5))];
    (cable_tie::cable_tie().build)(&spec, &Parameters(values.into())).expect("a tie")
}

wireloom_testkit::equations_conformance!(touching, || tie(0.0), 2, 0);
wireloom_testkit::equations_conformance!(loose, || tie(5e-3), 2, 0);
