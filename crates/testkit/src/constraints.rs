//! Constraints of every shape, as third parties write them: for tests.

use wireloom_core::constraint::Residual;
use wireloom_core::rotation::skew;
use wireloom_core::{Action, Constraint, ConstraintView, Equations, Matrix, Potential, Vector};

/// Derivatives of the distance r of two stations: the direction, and r″ between their points.
fn distance(at: &ConstraintView<'_>) -> (f64, Vector, Matrix) {
    let gap = at.stations[1].position - at.stations[0].position;
    let r = gap.norm();
    let d = gap / r;
    (r, d, (Matrix::identity() - d * d.transpose()) / r)
}

/// `½ k (r − r°)²` between two stations.
pub struct Strut {
    /// r°, m.
    pub rest: f64,
    /// k, N/m.
    pub stiffness: f64,
}

impl Constraint for Strut {
    fn action(&self) -> Action<'_> {
        Action::Potential(self)
    }
    fn needs_frame(&self) -> bool {
        false
    }
}

impl Potential for Strut {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        0.5 * self.stiffness * (distance(at).0 - self.rest).powi(2)
    }
    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], _: &mut [Vector]) -> f64 {
        let (r, d, _) = distance(at);
        let force = d * (self.stiffness * (r - self.rest));
        (stations[0], stations[2]) = (-force, force);
        self.energy(at)
    }
    fn hessian(&self, at: &ConstraintView<'_>, stations: &mut [Matrix], _: &mut [Matrix]) {
        let (r, d, second) = distance(at);
        let k = (d * d.transpose() + second * (r - self.rest)) * self.stiffness;
        (stations[0], stations[2], stations[8], stations[10]) = (k, -k, -k, k);
    }
}

/// `r − d = 0` between two stations.
pub struct Link(
    /// d, m.
    pub f64,
);

impl Constraint for Link {
    fn action(&self) -> Action<'_> {
        Action::Equations(self)
    }
    fn needs_frame(&self) -> bool {
        false
    }
}

impl Equations for Link {
    fn of_stations(&self) -> Vec<Residual> {
        vec![Residual::zero(1.0)]
    }
    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        c[0] = distance(at).0 - self.0;
    }
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], _: &mut [Vector]) {
        let (r, d, _) = distance(at);
        c[0] = r - self.0;
        (stations[0], stations[2]) = (-d, d);
    }
    fn curvature(&self, at: &ConstraintView<'_>, w: &[f64], stations: &mut [Matrix], _: &mut [Matrix]) {
        let k = distance(at).2 * w[0];
        (stations[0], stations[2], stations[8], stations[10]) = (k, -k, -k, k);
    }
}

/// `h − z ≤ 0` for every node of a span.
pub struct Floor(
    /// h, m.
    pub f64,
);

impl Constraint for Floor {
    fn action(&self) -> Action<'_> {
        Action::Equations(self)
    }
    fn objective(&self) -> bool {
        false
    }
}

impl Equations for Floor {
    fn of_stations(&self) -> Vec<Residual> {
        vec![]
    }
    fn of_each_node(&self) -> Vec<Residual> {
        vec![Residual::not_positive(1.0)]
    }
    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        for (c, x) in c.iter_mut().zip(at.span) {
            *c = self.0 - x.z;
        }
    }
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], _: &mut [Vector], span: &mut [Vector]) {
        self.residuals(at, c);
        span.fill(-Vector::z());
    }
}

/// The second station is in the plane across d1 of the first, and within 1 m of it: points and frames are coupled.
pub struct Sight;

impl Constraint for Sight {
    fn action(&self) -> Action<'_> {
        Action::Equations(self)
    }
}

/// `c = Rᵀ_a (x_b − x_a) · e1`, `½ |x_b − x_a|² − ½ ≤ 0`.
impl Equations for Sight {
    fn of_stations(&self) -> Vec<Residual> {
        vec![Residual::zero(1.0), Residual::not_positive(1.0)]
    }
    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        let gap = at.stations[1].position - at.stations[0].position;
        c[0] = at.stations[0].orientation.inverse_transform_vector(&gap).x;
        c[1] = 0.5 * gap.norm_squared() - 0.5;
    }
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], _: &mut [Vector]) {
        self.residuals(at, c);
        let gap = at.stations[1].position - at.stations[0].position;
        let a = &at.stations[0].orientation;
        let along = a * Vector::x();
        // δ(Rᵀ g · e1) = −θ × (Rᵀ g) · e1 = θ · (e1 × Rᵀ g).
        let turn = Vector::x().cross(&a.inverse_transform_vector(&gap));
        (stations[0], stations[1], stations[2]) = (-along, turn, along);
        (stations[4], stations[6]) = (-gap, gap);
    }
    fn curvature(&self, at: &ConstraintView<'_>, w: &[f64], stations: &mut [Matrix], _: &mut [Matrix]) {
        let a = &at.stations[0].orientation;
        let g = a.inverse_transform_vector(&(at.stations[1].position - at.stations[0].position));
        let r = a.to_rotation_matrix();
        // ∂(e1 × Rᵀ g)/∂g = [e1]ₓ Rᵀ; in θ twice: sym(g e1ᵀ) − (g·e1) I.
        let mixed = skew(&Vector::x()) * r.inverse().matrix() * w[0];
        let outer = g * Vector::x().transpose();
        let turned = ((outer + outer.transpose()) * 0.5 - Matrix::identity() * g.x) * w[0];
        let apart = Matrix::identity() * w[1];
        stations[0] = apart;
        stations[1] = -mixed.transpose();
        stations[2] = -apart;
        stations[4] = -mixed;
        stations[5] = turned;
        stations[6] = mixed;
        stations[8] = -apart;
        stations[9] = mixed.transpose();
        stations[10] = apart;
    }
}

/// Which parts of a [`Plunger`] act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parts {
    /// `½ k a3²`
    Spring,
    /// `a1 = a2 = 0`
    Guide,
    /// Both.
    Both,
}

/// The target lies on the tangent of the station, and a spring along it pulls. With the target at `a = Rᵀ (x° − x)` in
/// the axes of the station: `a1 = a2 = 0`, and `½ k a3²`.
pub struct Plunger {
    /// k, N/m.
    pub stiffness: f64,
    /// What of it acts.
    pub parts: Parts,
}

impl Plunger {
    /// `a_i` and its derivatives in x and θ.
    fn along(at: &ConstraintView<'_>, i: usize) -> (f64, [Vector; 2]) {
        let (r, e) = (&at.stations[0].orientation, Vector::ith(i, 1.0));
        let a = r.inverse_transform_vector(&(at.targets[0].position - at.stations[0].position));
        (a[i], [-(r * e), e.cross(&a)])
    }

    /// Adds w times the second derivatives of `a_i`: `−[e_i]ₓ Rᵀ` in θ and x, `sym(a e_iᵀ) − a_i I` in θ twice.
    fn add_second(at: &ConstraintView<'_>, i: usize, w: f64, table: &mut [Matrix]) {
        let (r, e) = (&at.stations[0].orientation, Vector::ith(i, 1.0));
        let a = r.inverse_transform_vector(&(at.targets[0].position - at.stations[0].position));
        let mixed = -(skew(&e) * r.to_rotation_matrix().inverse().matrix()) * w;
        let outer = a * e.transpose();
        table[1] += mixed.transpose();
        table[2] += mixed;
        table[3] += ((outer + outer.transpose()) * 0.5 - Matrix::identity() * a[i]) * w;
    }
}

impl Constraint for Plunger {
    fn action(&self) -> Action<'_> {
        match self.parts {
            Parts::Spring => Action::Potential(self),
            Parts::Guide => Action::Equations(self),
            Parts::Both => Action::PotentialAndEquations(self, self),
        }
    }
}

impl Potential for Plunger {
    fn energy(&self, at: &ConstraintView<'_>) -> f64 {
        0.5 * self.stiffness * Self::along(at, 2).0.powi(2)
    }
    fn gradient(&self, at: &ConstraintView<'_>, stations: &mut [Vector], _: &mut [Vector]) -> f64 {
        let (a, slopes) = Self::along(at, 2);
        stations.copy_from_slice(&slopes.map(|slope| slope * (self.stiffness * a)));
        self.energy(at)
    }
    fn hessian(&self, at: &ConstraintView<'_>, stations: &mut [Matrix], _: &mut [Matrix]) {
        let (a, slopes) = Self::along(at, 2);
        for (k, block) in stations.iter_mut().enumerate() {
            *block = slopes[k / 2] * slopes[k % 2].transpose() * self.stiffness;
        }
        Self::add_second(at, 2, self.stiffness * a, stations);
    }
}

impl Equations for Plunger {
    fn of_stations(&self) -> Vec<Residual> {
        vec![Residual::zero(1.0); 2]
    }
    fn residuals(&self, at: &ConstraintView<'_>, c: &mut [f64]) {
        c.iter_mut().enumerate().for_each(|(i, c)| *c = Self::along(at, i).0);
    }
    fn jacobian(&self, at: &ConstraintView<'_>, c: &mut [f64], stations: &mut [Vector], _: &mut [Vector]) {
        for (i, (c, row)) in c.iter_mut().zip(stations.chunks_exact_mut(2)).enumerate() {
            let (a, slopes) = Self::along(at, i);
            *c = a;
            row.copy_from_slice(&slopes);
        }
    }
    fn curvature(&self, at: &ConstraintView<'_>, w: &[f64], stations: &mut [Matrix], _: &mut [Matrix]) {
        w.iter().enumerate().for_each(|(i, w)| Self::add_second(at, i, *w, stations));
    }
}
