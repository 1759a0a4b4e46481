//! `softening-bundle`: a bundle that bends more easily the more it is bent. README.md has the physics in words.

use wireloom_plugin::core::constitutive::{ConstitutiveLaw, ConstitutiveLaws, Past, Point, Response};
use wireloom_plugin::core::registry::{ConstitutiveKind, Form, Parameter, Quantity};
use wireloom_plugin::core::{Matrix, Vector};

wireloom_plugin::export! { rods: [kind()] }

/// What scenarios see: the name of the rod, its parameters.
pub fn kind() -> ConstitutiveKind {
    let number = |name: &str, doc: &str, quantity, maximum| Parameter {
        name: name.into(),
        doc: doc.into(),
        form: Form::Number { quantity, minimum: 0.0, exclusive: true, maximum },
        default: None,
        required: true,
    };
    ConstitutiveKind {
        name: "softening-bundle".into(),
        doc: "a bundle that bends more easily the more it is bent".into(),
        parameters: vec![
            number(
                "loose_share",
                "share of the bending stiffness that is left in tight bends",
                Quantity::Dimensionless,
                1.0,
            ),
            number("slip_curvature", "curvature about which the wires come loose", Quantity::Curvature, f64::INFINITY),
        ],
        build: Box::new(|spec, parameters| {
            let [ei1, ei2] = spec.section.bending_stiffness;
            let slip = parameters.number("slip_curvature").unwrap_or_default();
            let law = SofteningBundle {
                stiffness: Vector::new(ei1, ei2, 0.0),
                torsion: spec.section.torsion_stiffness,
                share: parameters.number("loose_share").unwrap_or_default(),
                limit: 0.25 * (ei1 + ei2) * slip * slip,
            };
            // Stretch is that of the section.
            Ok(Box::new(ConstitutiveLaws { stretch: None, bend: Some(Box::new(law)) }))
        }),
    }
}

/// With the energy `Q = ½ (EI1 κ1² + EI2 κ2²)` of wires that stick, its value Q₀ at the curvature of slip, and
/// `s = √(1 + Q/Q₀)`,
///
/// `V = r Q + 2 (1 − r) Q₀ (s − 1) + ½ GJ κ3²`
struct SofteningBundle {
    /// EI1, EI2 and 0, N m².
    stiffness: Vector,
    /// GJ, N m².
    torsion: f64,
    /// r.
    share: f64,
    /// Q₀, J/m.
    limit: f64,
}

impl ConstitutiveLaw for SofteningBundle {
    fn respond(&self, curvatures: &[Vector], _: Past<'_>, response: &mut Response<'_>) {
        let (c, r, twist) = (&self.stiffness, self.share, Vector::z() * self.torsion);
        response.each(curvatures, |_, kappa| {
            let moment = c.component_mul(kappa);
            let q = 0.5 * moment.dot(kappa);
            let s = (1.0 + q / self.limit).sqrt();
            let factor = r + (1.0 - r) / s;
            let softening = (1.0 - r) / (2.0 * self.limit * s.powi(3));
            Point {
                // Q₀ (s − 1) = Q/(s + 1), without cancellation where it is nearly straight.
                energy: r * q + 2.0 * (1.0 - r) * q / (s + 1.0) + 0.5 * self.torsion * kappa.z * kappa.z,
                gradient: moment * factor + twist * kappa.z,
                hessian: Matrix::from_diagonal(&(c * factor + twist)) - moment * moment.transpose() * softening,
            }
        });
    }
}
