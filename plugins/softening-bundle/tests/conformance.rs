//! The bundle satisfies the contract of constitutive laws, and its moment is that of the closed form.

use wireloom_models::rods::constitutive;
use wireloom_plugin::core::constitutive::{ConstitutiveLaws, Past};
use wireloom_plugin::core::rod::{Mesh, RodSegment, RodSpec};
use wireloom_plugin::core::{Parameters, Value, Vector};
use wireloom_testkit::conformance::rod::section;

fn rod(spec: RodSpec) -> Box<dyn RodSegment> {
    let number = |name: &str, value| (name.to_owned(), Value::Number(value));
    let values = Parameters([number("loose_share", 0.25), number("slip_curvature", 2.0)].into());
    (constitutive::kind(softening_bundle::kind()).build)(&spec, &values).expect("a rod")
}

wireloom_testkit::constitutive_conformance!(contract, rod);

#[test]
fn the_moment_falls_from_that_of_sticking_wires_to_that_of_loose_ones() {
    let mut section = section();
    section.bending_stiffness = [0.01; 2];
    let mesh = Mesh::new(vec![0.1; 4], vec![0, 4]);
    let rod = rod(RodSpec { name: "cable".into(), sections: section.into(), mesh, curvature: Vector::zeros() });
    let Some(ConstitutiveLaws { stretch: None, bend: Some(law) }) = rod.constitutive() else {
        panic!("it has a law of bending alone")
    };
    for kappa in [1e-6, 0.5, 4.0, 1e3] {
        // m = EI (r + (1 − r)/√(1 + (κ/κ₀)²)) κ, whatever the direction.
        let want = 0.01 * (0.25 + 0.75 / (1.0 + kappa * kappa / 4.0_f64).sqrt()) * kappa;
        let direction = Vector::new(0.6, -0.8, 0.0);
        let got = law.at(&(direction * kappa), Past::default()).gradient;
        assert!((got - direction * want).norm() < 1e-14 * want, "{got} at {kappa} 1/m");
        assert!((law.strain_under(&(direction * want), Past::default()) - direction * kappa).norm() < 1e-9 * kappa);
    }
}
