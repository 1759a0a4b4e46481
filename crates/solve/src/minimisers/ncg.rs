//! Minimiser `ncg`: nonlinear conjugate gradients, common in the literature on interactive rods, on the manifold of
//! positions and frames (Sato 2016).
//!
//! ```text
//! d = −M⁻¹ g + β d′,   y = g − g′           (′: of the previous step, transported to the present state)
//! β = (y·M⁻¹g)/(d′·y) − 2 (y·M⁻¹y) (d′·g)/(d′·y)²        hager-zhang (2005)
//! β = (y·M⁻¹g)/(g′·M⁻¹g′)                                  polak-ribiere (1969)
//! ```
//!
//! The first formula gives a descent direction with any line search. The method restarts (β = 0) where β would be
//! negative, and when the metric M is recomputed.

use crate::minimisers::descent::{self, Method};
use crate::minimisers::transport::transport;
use wireloom_core::registry::{Form, MinimiserKind, Parameter, Value};
use wireloom_core::{Network, Tangent};

/// Default fraction of the first slope that may remain after a line search: small, as conjugacy requires.
const SLOPE: f64 = 0.1;

/// The kind `ncg`.
pub fn kind() -> MinimiserKind {
    let formula = Parameter {
        name: "formula".into(),
        doc: "how the next direction is made conjugate to the last".into(),
        form: Form::Choice(vec!["hager-zhang".into(), "polak-ribiere".into()]),
        default: Some(Value::Word("hager-zhang".into())),
        required: false,
    };
    descent::kind(
        "nonlinear conjugate gradients, in the metric of a Hessian that is factorised now and then; to compare with",
        SLOPE,
        formula,
        |given| Conjugate {
            polak_ribiere: given.word("formula") == Some("polak-ribiere"),
            scratch: None,
            blank: true,
            along: 0.0,
        },
    )
}

/// Conjugate direction.
struct Conjugate {
    polak_ribiere: bool,
    /// `None` before [`Method::allocate`].
    scratch: Option<Scratch>,
    blank: bool,
    /// −g′·M⁻¹g′.
    along: f64,
}

struct Scratch {
    /// −M⁻¹g, or −M⁻¹g′.
    down: Tangent,
    /// −M⁻¹g′ while −M⁻¹g is computed.
    before: Tangent,
    /// d′.
    direction: Tangent,
    /// y.
    change: Tangent,
}

impl Method for Conjugate {
    const NAME: &'static str = "ncg";

    fn allocate(&mut self, network: &Network) {
        let zeros = || Tangent::zeros(network);
        self.scratch = Some(Scratch { down: zeros(), before: zeros(), direction: zeros(), change: zeros() });
    }

    fn restart(&mut self) {
        self.blank = true;
    }

    /// Restarts: directions are conjugate in one metric only.
    fn metric_changes(&mut self) {
        self.blank = true;
    }

    fn is_blank(&self) -> bool {
        self.blank
    }

    fn knows_lengths(&self) -> bool {
        false
    }

    fn learn(&mut self, step: &Tangent, alpha: f64, gradient: &Tangent, before: &Tangent) {
        let Some(scratch) = &mut self.scratch else { return };
        transport(&mut scratch.down, step, alpha);
        scratch.direction.copy_from(step);
        scratch.change.copy_from(gradient);
        scratch.change.add_scaled(-1.0, before);
        self.blank = false;
    }

    fn direction(&mut self, gradient: &Tangent, solve: &mut dyn FnMut(&Tangent, &mut Tangent), step: &mut Tangent) {
        let Some(scratch) = &mut self.scratch else { return };
        std::mem::swap(&mut scratch.down, &mut scratch.before);
        solve(gradient, &mut scratch.down);
        step.copy_from(&scratch.down);
        let before = std::mem::replace(&mut self.along, gradient.dot(&scratch.down));
        if self.blank {
            return;
        }
        let (y, d) = (&scratch.change, &scratch.direction);
        let (y_down, y_before) = (y.dot(&scratch.down), y.dot(&scratch.before));
        let beta = if self.polak_ribiere {
            y_down / before
        } else {
            let dy = d.dot(y);
            -y_down / dy - 2.0 * (y_before - y_down) * d.dot(gradient) / (dy * dy)
        };
        if beta > 0.0 && beta.is_finite() {
            step.add_scaled(beta, d);
        }
    }
}
