//! The minimiser `ncg`: nonlinear conjugate gradients, the method of the literature on interactive rods, on the manifold of positions and
//! frames (Sato 2016).
//!
//! ```text
//! d = −M⁻¹ g + β d′,   y = g − g′           (′: of the step before, carried to the state at hand)
//! β = (y·M⁻¹g)/(d′·y) − 2 (y·M⁻¹y) (d′·g)/(d′·y)²        hager-zhang (2005): leads downhill whatever the line search
//! β = (y·M⁻¹g)/(g′·M⁻¹g′)                                  polak-ribiere (1969)
//! ```
//!
//! Where β would be negative it begins anew (β = 0), and where the metric M is taken anew.

use crate::minimisers::descent::{self, Method};
use crate::minimisers::transport::carry;
use wireloom_core::registry::{Form, MinimiserKind, Parameter, Value};
use wireloom_core::{Network, Tangent};

/// Default fraction of the slope that a line search may leave: conjugacy wants it small.
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
            room: None,
            blank: true,
            along: 0.0,
        },
    )
}

/// The last direction.
struct Conjugate {
    polak_ribiere: bool,
    /// There once a network is.
    room: Option<Room>,
    blank: bool,
    /// −g′·M⁻¹g′.
    along: f64,
}

struct Room {
    /// −M⁻¹g, or −M⁻¹g′.
    down: Tangent,
    /// −M⁻¹g′ while −M⁻¹g is being made.
    before: Tangent,
    /// d′.
    direction: Tangent,
    /// y.
    change: Tangent,
}

impl Method for Conjugate {
    const NAME: &'static str = "ncg";

    fn ready(&mut self, network: &Network) {
        let zeros = || Tangent::zeros(network);
        self.room = Some(Room { down: zeros(), before: zeros(), direction: zeros(), change: zeros() });
    }

    fn restart(&mut self) {
        self.blank = true;
    }

    /// Directions are conjugate in one metric only.
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
        let Some(room) = &mut self.room else { return };
        carry(&mut room.down, step, alpha);
        room.direction.copy_from(step);
        room.change.copy_from(gradient);
        room.change.add_scaled(-1.0, before);
        self.blank = false;
    }

    fn direction(&mut self, gradient: &Tangent, solve: &mut dyn FnMut(&Tangent, &mut Tangent), step: &mut Tangent) {
        let Some(room) = &mut self.room else { return };
        std::mem::swap(&mut room.down, &mut room.before);
        solve(gradient, &mut room.down);
        step.copy_from(&room.down);
        let before = std::mem::replace(&mut self.along, gradient.dot(&room.down));
        if self.blank {
            return;
        }
        let (y, d) = (&room.change, &room.direction);
        let (y_down, y_before) = (y.dot(&room.down), y.dot(&room.before));
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
