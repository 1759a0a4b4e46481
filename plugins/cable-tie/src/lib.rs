//! `cable-tie`: a tie around two branches, tightened during the step in which it is added. README.md lists the
//! parameters.

use wireloom_plugin::core::constraint::{Attaches, ConstraintSpec, ConstraintView, Equations, Residual, SpanUse};
use wireloom_plugin::core::registry::{
    BuildError, ConstraintKind, Form, Output, Parameter, Parameters, Quantity, Value,
};
use wireloom_plugin::core::{Action, Constraint, Matrix, Vector};

wireloom_plugin::export! { constraints: [cable_tie()] }

/// The kind `cable-tie`.
pub fn cable_tie() -> ConstraintKind {
    let number = |name: &str, doc: &str, quantity, maximum, default| Parameter {
        name: name.into(),
        doc: doc.into(),
        form: Form::Number { quantity, minimum: 0.0, exclusive: false, maximum },
        default: Some(Value::Number(default)),
        required: false,
    };
    ConstraintKind {
        name: "cable-tie".into(),
        doc: "a tie around two branches, tightened during its first step; it pulls until they touch".into(),
        attaches: Attaches { stations: 2..=2, span: SpanUse::Never },
        parameters: vec![
            number("gap", "gap between the surfaces when the tie is tight", Quantity::Length, f64::INFINITY, 0.0),
            number("tight_at", "share of the step at which it is tight", Quantity::Dimensionless, 1.0, 1.0),
        ],
        outputs: vec![
            Output {
                name: "length".into(),
                doc: "of the tie between the centre lines, to which it is drawn".into(),
                quantity: Quantity::Length,
                event: false,
            },
            Output {
                name: "gap".into(),
                doc: "distance between the surfaces of the branches".into(),
                quantity: Quantity::Length,
                event: false,
            },
            Output {
                name: "loose".into(),
                doc: "it is longer than the branches are apart, and holds nothing".into(),
                quantity: Quantity::Length,
                event: true,
            },
        ],
        build: Box::new(|spec, parameters| Ok(Box::new(Tie::new(spec, parameters)?))),
    }
}

/// Length by which a loose tie is longer than the branches are apart, m: far above the tolerance of its equation.
const LOOSE: f64 = 1e-6;

/// A tie: the distance `d = |x₂ − x₁|` of the centre lines lies between `r₁ + r₂` (the surfaces touch) and
/// the length L of the tie. L decreases from the distance d₀ at which the tie is added to `D = r₁ + r₂ +
/// gap`.
struct Tie {
    /// r₁ + r₂, m.
    touching: f64,
    /// Gap between the surfaces when tight, m.
    gap: f64,
    /// Fraction of the step at which the tie is tight.
    tight_at: f64,
}

impl Tie {
    fn new(spec: &ConstraintSpec, parameters: &Parameters) -> Result<Self, BuildError> {
        let touching: f64 = spec.stations.iter().map(|station| 0.5 * station.diameter).sum();
        let number = |name| parameters.number(name).unwrap_or_default();
        if number("tight_at") == 0.0 {
            let help = "give the share of the step, above 0, over which it is drawn tight";
            return Err(BuildError::new(format!("tie `{}` would be tight at once", spec.name), help).at("tight_at"));
        }
        Ok(Self { touching, gap: number("gap"), tight_at: number("tight_at") })
    }

    /// `L = d₀ + (D − d₀) min(1, p / p_tight)`, but at least D: branches that are nearer stay loose.
    fn length(&self, at: &ConstraintView<'_>) -> f64 {
        let tight = self.touching + self.gap;
        let put_on = (at.targets[1].position - at.targets[0].position).norm();
        let drawn = (at.progress / self.tight_at).min(1.0);
        if self.gap == 0.0 { put_on + (tight - put_on) * drawn } else { (put_on + (tight - put_on) * drawn).max(tight) }
    }
}

/// d and its direction; the direction is zero where the centre lines meet.
fn distance(at: &ConstraintView<'_>) -> (f64, Vector) {
    let apart = at.stations[1].position - at.stations[0].position;
    let d = apart.norm();
    (d, if d > 0.0 { apart / d } else { Vector::zeros() })
}

impl Constraint for Tie {
    fn action(&self) -> Action<'_> {
        Action::Equations(self)
    }

    fn needs_frame(&self) -> bool {
        false
    }

    fn outputs(&self, at: &ConstraintView<'_>) -> Vec<(String, f64)> {
        let (d, _) = distance(at);
        let length = self.length(at);
        let loose = (length - d > LOOSE).then(|| ("loose".into(), length - d));
        [("length".into(), length), ("gap".into(), d - self.touching)].into_iter().chain(loose).collect()
    }
}

impl Equations for Tie {
    /// Without a gap `d = L`: the tie pulls or the surfaces push. With a gap `d ≤ L` and `r₁ + r₂ ≤ d`.
    fn of_stations(&self) -> Vec<Residual> {
        if self.gap == 0.0 { vec![Residual::zero(1.0)] } else { vec![Residual::not_positive(1.0); 2] }
    }

    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        let (d, _) = distance(at);
        c[0] = d - self.length(at);
        if let Some(push) = c.get_mut(1) {
            *push = self.touching - d;
        }
    }

    /// `∂d/∂x₁ = −n`, `∂d/∂x₂ = n`
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], _span: &mut [Vector]) {
        self.residuals(at, c);
        let (_, n) = distance(at);
        for (row, sign) in stations.chunks_exact_mut(4).zip([1.0, -1.0]) {
            (row[0], row[2]) = (-n * sign, n * sign);
        }
    }

    /// `∂²d/∂x² = ±(I − n nᵀ)/d`
    fn curvature(&self, at: &ConstraintView<'_>, w: &[f64], stations: &mut [Matrix], _span: &mut [Matrix]) {
        let (d, n) = distance(at);
        if d == 0.0 {
            return;
        }
        let w = w[0] - w.get(1).copied().unwrap_or(0.0);
        let block = (Matrix::identity() - n * n.transpose()) * (w / d);
        (stations[0], stations[10]) = (block, block);
        (stations[2], stations[8]) = (-block, -block);
    }
}
