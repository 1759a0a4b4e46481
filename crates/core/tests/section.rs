//! Sections whose bending and twist are coupled.

use wireloom_core::section::softest_bending;
use wireloom_core::{Matrix, Section, Vector};
use wireloom_testkit::conformance::rod::section;

fn coupled(coupling_stiffness: [f64; 3]) -> Section {
    Section { coupling_stiffness, ..section() }
}

/// Weak couplings, such that another axis is the softest, and strong ones of equal stiffnesses.
fn sections() -> Vec<Section> {
    let equal = Section { bending_stiffness: [0.05; 2], torsion_stiffness: 0.05, ..section() };
    let stronger = Section { coupling_stiffness: [0.02, 0.024, 0.024], ..equal };
    vec![coupled([1e-9, 0.0, 0.0]), coupled([0.02, -0.01, 0.025]), coupled([-0.06, 0.0, 0.0]), stronger]
}

#[test]
fn principal_axes_are_axes_in_which_nothing_is_coupled() {
    for section in sections() {
        let (axes, principal) = section.principal_axes();
        let q = axes.to_rotation_matrix().into_inner();
        let again = q * Matrix::from_diagonal(&principal) * q.transpose();
        assert!((again - section.bend_stiffness()).amax() < 1e-15, "{again}");
    }
    let (axes, principal) = section().principal_axes();
    assert_eq!((axes.angle(), principal), (0.0, section().bend_diagonal()));
    // Each axis is beside the director that it is nearest to.
    assert!(coupled([1e-9, 0.0, 0.0]).principal_axes().0.angle() < 1e-7);
}

#[test]
fn the_curvature_under_a_moment_has_that_moment() {
    let moment = Vector::new(0.3, -0.7, 0.2);
    for section in sections() {
        let left = section.bend_stiffness() * section.curvature_under(&moment) - moment;
        assert!(left.amax() < 1e-12, "{left}");
    }
}

#[test]
fn the_softest_bending_has_the_greatest_energy_of_a_unit_bending_moment() {
    for section in sections() {
        let twice = (0..3600).map(|k| f64::from(k) * std::f64::consts::PI / 3600.0).map(|angle| {
            let moment = Vector::new(angle.cos(), angle.sin(), 0.0);
            moment.dot(&section.curvature_under(&moment))
        });
        let (greatest, found) = (twice.fold(0.0, f64::max), softest_bending(&section.bend_stiffness()));
        assert!((greatest * found - 1.0).abs() < 1e-4, "{found} beside {}", 1.0 / greatest);
    }
    assert_eq!(softest_bending(&Matrix::zeros()), 0.0);
}
