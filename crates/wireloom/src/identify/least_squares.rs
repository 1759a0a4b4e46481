//! Robust nonlinear least squares: Gauss–Newton steps with damping (Levenberg 1944, Marquardt 1963), Huber's loss of
//! the distances between points, linear priors, bounds.
//!
//! With the residuals r (m) of points k, the distances d_k of the points, a scale s of the noise of one coordinate, and
//! priors `(aᵀθ − v)/σ`, what is minimised over θ is
//!
//! ```text
//! F(θ) = Σ_k ρ(d_k/s) + Σ ((aᵀθ − v)/σ)²,      ρ(u) = u²  for u ≤ c,   2cu − c²  beyond       (Huber 1964)
//! ```
//!
//! The scale s is that of the current residuals ([`Points::scale`]), or it is known. A point that cannot be computed
//! makes the step shorter.

use nalgebra::{Cholesky, DMatrix, DVector};
use std::ops::Range;

/// Distance of a point, in units of the noise of one coordinate, from which on it pulls with a constant force: 97 % of
/// the points with normal noise in three coordinates are nearer (χ with 3 degrees of freedom).
pub const HUBER: f64 = 3.0;
/// Damping at the beginning, relative to the diagonal of the normal matrix.
const FIRST_DAMPING: f64 = 1e-3;
/// Smallest damping.
const LEAST_DAMPING: f64 = 1e-9;
/// Damping beyond which a step is so short that none is found.
const MOST_DAMPING: f64 = 1e9;
/// Factor on the damping after a step that was too long, and divisor after a good one.
const DAMPING: f64 = 5.0;
/// Factor on the damping after a step to where nothing could be computed.
const SHORTER: f64 = 20.0;
/// Largest number of iterations.
const ITERATIONS: usize = 60;
/// Decrease of F that a whole step predicts below which it is at its minimum: the step is then at most a tenth of the
/// deviation of every unknown. Near a limit point derivatives are not exact enough for much less.
const CONVERGED: f64 = 1e-2;
/// The same where differences of F are not resolved any more: a quarter of a deviation.
const RESOLVED: f64 = 5e-2;
/// Step, in units of the unknowns, that changes nothing that could be measured.
const SMALLEST: f64 = 1e-7;
/// Change of the scale of the noise, relative to it, that is none.
const SAME_SCALE: f64 = 1e-3;

/// A linear prior `(Σ aᵢ θᵢ − v)/σ`.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// Index and coefficient of each unknown.
    pub terms: Vec<(usize, f64)>,
    /// v.
    pub value: f64,
    /// σ.
    pub deviation: f64,
}

impl Prior {
    /// Value of the residual.
    pub fn residual(&self, theta: &DVector<f64>) -> f64 {
        (self.terms.iter().map(|(i, a)| a * theta[*i]).sum::<f64>() - self.value) / self.deviation
    }

    /// Adds its part of the normal matrix.
    pub fn add_to(&self, normal: &mut DMatrix<f64>) {
        for (i, a) in &self.terms {
            for (j, b) in &self.terms {
                normal[(*i, *j)] += a * b / (self.deviation * self.deviation);
            }
        }
    }
}

/// The measured points: which residuals belong to one point.
#[derive(Clone, Debug, PartialEq)]
pub struct Points {
    /// Residuals of each point, one for each coordinate that was measured.
    pub ranges: Vec<Range<usize>>,
    /// Known noise of a coordinate, m.
    pub noise: Option<f64>,
    /// Least noise, m: the accuracy of computed positions.
    pub least_noise: f64,
}

impl Points {
    /// Number of residuals.
    pub fn residuals(&self) -> usize {
        self.ranges.last().map_or(0, |range| range.end)
    }

    /// Distance of a point, m.
    pub fn distance(&self, k: usize, residuals: &DVector<f64>) -> f64 {
        self.ranges[k].clone().map(|i| residuals[i] * residuals[i]).sum::<f64>().sqrt()
    }

    /// Scale s of the noise of one coordinate: the known one, or the median of the distances, each in units of the
    /// median that normal noise of one metre has in as many coordinates; more by what `unknowns` take out of it.
    pub fn scale(&self, residuals: &DVector<f64>, unknowns: usize) -> f64 {
        if let Some(noise) = self.noise {
            return noise;
        }
        // Medians of χ with 1, 2 and 3 degrees of freedom.
        let median = |coordinates: usize| [1.0, 0.6745, 1.1774, 1.5382][coordinates.min(3)];
        let relative = |k: usize| self.distance(k, residuals) / median(self.ranges[k].len());
        let mut all: Vec<f64> = (0..self.ranges.len()).map(relative).collect();
        all.sort_by(f64::total_cmp);
        let middle = all.len() / 2;
        let median = match all.len() {
            0 => 0.0,
            n if n % 2 == 1 => all[middle],
            _ => 0.5 * (all[middle - 1] + all[middle]),
        };
        let n = self.residuals() as f64;
        let free = (n - unknowns as f64).max(1.0);
        (median * (n / free).sqrt()).max(self.least_noise)
    }

    /// Huber's weight of a point.
    pub fn weight(&self, k: usize, residuals: &DVector<f64>, scale: f64) -> f64 {
        let u = self.distance(k, residuals) / scale;
        if u <= HUBER { 1.0 } else { HUBER / u }
    }

    /// Huber's loss of all points.
    fn loss(&self, residuals: &DVector<f64>, scale: f64) -> f64 {
        let of_point = |k: usize| {
            let u = self.distance(k, residuals) / scale;
            if u <= HUBER { u * u } else { 2.0 * HUBER * u - HUBER * HUBER }
        };
        (0..self.ranges.len()).map(of_point).sum()
    }

    /// Normal matrix JᵀWJ/s² and gradient JᵀWr/s² of the data.
    pub fn normal(
        &self,
        jacobian: &DMatrix<f64>,
        residuals: &DVector<f64>,
        scale: f64,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let mut weights = DVector::zeros(residuals.len());
        for (k, range) in self.ranges.iter().enumerate() {
            let weight = self.weight(k, residuals, scale) / (scale * scale);
            range.clone().for_each(|i| weights[i] = weight);
        }
        let weighted = DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |i, j| weights[i] * jacobian[(i, j)]);
        (weighted.transpose() * jacobian, weighted.transpose() * residuals)
    }
}

/// What is minimised.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The points.
    pub points: Points,
    /// The priors.
    pub priors: Vec<Prior>,
    /// Bounds of the unknowns.
    pub bounds: Vec<[f64; 2]>,
    /// Largest step of an unknown.
    pub largest_step: f64,
    /// Other starts, which are tried before the first step: unknowns and what is added to them.
    pub starts: Vec<DVector<f64>>,
}

impl Problem {
    /// F with the scale of the noise.
    pub fn cost(&self, theta: &DVector<f64>, residuals: &DVector<f64>, scale: f64) -> f64 {
        let priors: f64 = self.priors.iter().map(|prior| prior.residual(theta).powi(2)).sum();
        self.points.loss(residuals, scale) + priors
    }
}

/// The work was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stopped;

/// Residuals at some unknowns, with their derivatives where they were wanted.
pub type Computed = Option<(DVector<f64>, Option<DMatrix<f64>>)>;

/// Residuals as a function of the unknowns.
pub trait Model {
    /// Residuals; `None` where they cannot be computed. Their derivatives if `wanted` says so of the residuals.
    ///
    /// # Errors
    /// If it was stopped.
    fn compute(
        &mut self,
        theta: &DVector<f64>,
        wanted: &mut dyn FnMut(&DVector<f64>) -> bool,
    ) -> Result<Computed, Stopped>;
}

/// How a minimisation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// At a minimum.
    Converged,
    /// No shorter step led to less.
    NoStep,
    /// After the largest number of iterations.
    Iterations,
    /// It was stopped.
    Stopped,
}

/// Where a minimisation ended.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// How.
    pub ending: Ending,
    /// Unknowns.
    pub theta: DVector<f64>,
    /// Residuals.
    pub residuals: DVector<f64>,
    /// Their derivatives.
    pub jacobian: DMatrix<f64>,
    /// Scale of the noise.
    pub scale: f64,
    /// Number of iterations.
    pub iterations: usize,
}

/// Minimises F from a start. `None`: nothing could be computed at any start.
///
/// # Errors
/// If it was stopped before there was a first result.
pub fn minimise(problem: &Problem, start: &DVector<f64>, model: &mut dyn Model) -> Result<Option<Minimum>, Stopped> {
    let Some(mut here) = best_start(problem, start, model)? else { return Ok(None) };
    let mut damping = FIRST_DAMPING;
    loop {
        here.iterations += 1;
        match iterate(problem, &mut here, &mut damping, model) {
            Ok(None) if here.iterations < ITERATIONS => {}
            Ok(None) => here.ending = Ending::Iterations,
            Ok(Some(ending)) => here.ending = ending,
            Err(Stopped) => here.ending = Ending::Stopped,
        }
        if here.ending != Ending::Iterations || here.iterations >= ITERATIONS {
            return Ok(Some(here));
        }
    }
}

/// The starts: the given one, then the others.
fn starts(problem: &Problem, start: &DVector<f64>) -> impl Iterator<Item = DVector<f64>> {
    std::iter::once(start.clone()).chain(problem.starts.iter().map(move |more| clamped(problem, &(start + more))))
}

/// Least sum of the distances of all points at one of the starts, m; infinite if nothing could be computed.
///
/// # Errors
/// If it was stopped.
pub fn least_distance(problem: &Problem, start: &DVector<f64>, model: &mut dyn Model) -> Result<f64, Stopped> {
    let mut least = f64::INFINITY;
    for theta in starts(problem, start) {
        let Some((residuals, _)) = model.compute(&theta, &mut |_| false)? else { continue };
        let points = &problem.points;
        least = least.min((0..points.ranges.len()).map(|k| points.distance(k, &residuals)).sum());
    }
    Ok(least)
}

/// The start of which F is least, with the scale of the noise at the given one.
fn best_start(problem: &Problem, start: &DVector<f64>, model: &mut dyn Model) -> Result<Option<Minimum>, Stopped> {
    let unknowns = start.len();
    let mut best: Option<(DVector<f64>, f64, f64)> = None;
    for theta in starts(problem, start) {
        let Some((residuals, _)) = model.compute(&theta, &mut |_| false)? else { continue };
        let scale = best.as_ref().map_or_else(|| problem.points.scale(&residuals, unknowns), |best| best.2);
        let cost = problem.cost(&theta, &residuals, scale);
        if best.as_ref().is_none_or(|best| cost < best.1) {
            best = Some((theta, cost, scale));
        }
    }
    let Some((theta, ..)) = best else { return Ok(None) };
    Ok(model.compute(&theta, &mut |_| true)?.and_then(|(residuals, jacobian)| {
        let scale = problem.points.scale(&residuals, unknowns);
        let (ending, jacobian) = (Ending::Iterations, jacobian?);
        Some(Minimum { ending, theta, residuals, jacobian, scale, iterations: 0 })
    }))
}

fn clamped(problem: &Problem, theta: &DVector<f64>) -> DVector<f64> {
    DVector::from_fn(theta.len(), |i, _| theta[i].clamp(problem.bounds[i][0], problem.bounds[i][1]))
}

/// One iteration: steps that become shorter until one leads to less. `None`: it may go on.
fn iterate(
    problem: &Problem,
    here: &mut Minimum,
    damping: &mut f64,
    model: &mut dyn Model,
) -> Result<Option<Ending>, Stopped> {
    let unknowns = here.theta.len();
    let (mut normal, mut gradient) = problem.points.normal(&here.jacobian, &here.residuals, here.scale);
    for prior in &problem.priors {
        prior.add_to(&mut normal);
        let residual = prior.residual(&here.theta) / prior.deviation;
        prior.terms.iter().for_each(|(i, a)| gradient[*i] += a * residual);
    }
    // At a bound that the gradient leads to, an unknown stays.
    let free: Vec<usize> = (0..unknowns)
        .filter(|&i| {
            let [low, high] = problem.bounds[i];
            !(here.theta[i] <= low && gradient[i] > 0.0 || here.theta[i] >= high && gradient[i] < 0.0)
        })
        .collect();
    let (step, predicted) = step(&normal, &gradient, &free, LEAST_DAMPING);
    if predicted <= CONVERGED || step.amax() <= SMALLEST {
        return Ok(Some(Ending::Converged));
    }
    let cost = problem.cost(&here.theta, &here.residuals, here.scale);
    while *damping <= MOST_DAMPING {
        let (mut step, _) = self::step(&normal, &gradient, &free, *damping);
        let largest = step.amax();
        if largest > problem.largest_step {
            step *= problem.largest_step / largest;
        }
        let theta = clamped(problem, &(&here.theta + step));
        let scale = here.scale;
        let found = model.compute(&theta, &mut |residuals| problem.cost(&theta, residuals, scale) < cost)?;
        match found {
            None => *damping *= SHORTER,
            Some((_, None)) => *damping *= DAMPING,
            Some((residuals, Some(jacobian))) => {
                *damping = (*damping / DAMPING).max(LEAST_DAMPING);
                let gained = cost - problem.cost(&theta, &residuals, scale);
                *here = Minimum { theta, residuals, jacobian, ..here.clone() };
                here.scale = problem.points.scale(&here.residuals, unknowns);
                let same = (here.scale - scale).abs() <= SAME_SCALE * scale;
                return Ok((same && gained <= CONVERGED && predicted <= RESOLVED).then_some(Ending::Converged));
            }
        }
    }
    Ok(Some(if predicted <= RESOLVED { Ending::Converged } else { Ending::NoStep }))
}

/// The damped step of the free unknowns, and the decrease of F that it predicts.
fn step(normal: &DMatrix<f64>, gradient: &DVector<f64>, free: &[usize], damping: f64) -> (DVector<f64>, f64) {
    let mut all = DVector::zeros(gradient.len());
    if free.is_empty() {
        return (all, 0.0);
    }
    let gradient = gradient.select_rows(free);
    let reduced = normal.select_rows(free).select_columns(free);
    let largest = reduced.diagonal().amax().max(f64::MIN_POSITIVE);
    let mut damped = reduced.clone();
    for i in 0..free.len() {
        // Relative to the unknown's own curvature; a trace of the largest keeps those without one.
        damped[(i, i)] += damping * reduced[(i, i)].max(1e-9 * largest) + 1e-14 * largest;
    }
    let Some(factor) = Cholesky::new(damped) else { return (all, f64::INFINITY) };
    let step = -factor.solve(&gradient);
    // F has twice this gradient and Hessian.
    let predicted = -2.0 * gradient.dot(&step) - step.dot(&(&reduced * &step));
    for (k, i) in free.iter().enumerate() {
        all[*i] = step[k];
    }
    (all, predicted)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points (x, a exp(−b x)) with a = exp(θ0), b = exp(θ1); cannot be computed for b > `most`.
    struct Decay {
        measured: Vec<[f64; 2]>,
        most: f64,
        failed: usize,
    }

    impl Model for Decay {
        fn compute(
            &mut self,
            theta: &DVector<f64>,
            wanted: &mut dyn FnMut(&DVector<f64>) -> bool,
        ) -> Result<Computed, Stopped> {
            let (a, b) = (theta[0].exp(), theta[1].exp());
            if b > self.most {
                self.failed += 1;
                return Ok(None);
            }
            let n = self.measured.len();
            let value = |i: usize| a * (-b * self.measured[i][0]).exp();
            let residuals = DVector::from_fn(n, |i, _| value(i) - self.measured[i][1]);
            let by = |i: usize, j: usize| value(i) * if j == 0 { 1.0 } else { -b * self.measured[i][0] };
            let jacobian = wanted(&residuals).then(|| DMatrix::from_fn(n, 2, by));
            Ok(Some((residuals, jacobian)))
        }
    }

    fn decay(noise: f64, outlier: f64) -> Decay {
        let mut random = fastrand::Rng::with_seed(7);
        let mut measured: Vec<[f64; 2]> = (0..30)
            .map(|k| {
                let x = 0.1 * f64::from(k);
                [x, 2.0 * (-1.5 * x).exp() + noise * (random.f64() - 0.5)]
            })
            .collect();
        measured[12][1] += outlier;
        Decay { measured, most: f64::INFINITY, failed: 0 }
    }

    fn problem() -> Problem {
        Problem {
            points: Points { ranges: (0..30).map(|k| k..k + 1).collect(), noise: None, least_noise: 1e-9 },
            priors: Vec::new(),
            bounds: vec![[-7.0, 7.0]; 2],
            largest_step: 2.0,
            starts: Vec::new(),
        }
    }

    fn fitted(problem: &Problem, model: &mut Decay) -> (Minimum, [f64; 2]) {
        let start = DVector::from_vec(vec![0.0, 0.0]);
        let found = minimise(problem, &start, model).expect("nobody stops it").expect("the start can be computed");
        let values = [found.theta[0].exp(), found.theta[1].exp()];
        (found, values)
    }

    #[test]
    fn exact_points_give_the_exact_values() {
        let (found, [a, b]) = fitted(&problem(), &mut decay(0.0, 0.0));
        assert_eq!(found.ending, Ending::Converged);
        assert!((a - 2.0).abs() < 1e-7 && (b - 1.5).abs() < 1e-7, "{a} {b}");
        assert!(found.iterations < 10, "{}", found.iterations);
    }

    #[test]
    fn a_wrong_point_hardly_counts() {
        let (_, without) = fitted(&problem(), &mut decay(0.02, 0.0));
        let (_, with) = fitted(&problem(), &mut decay(0.02, 5.0));
        for k in 0..2 {
            // Plain least squares would be 0.5 off.
            assert!((with[k] - without[k]).abs() < 0.01, "{with:?} {without:?}");
        }
    }

    #[test]
    fn where_nothing_can_be_computed_the_step_is_shorter() {
        let mut failed = 0;
        for start in [[3.0, -4.0], [-3.0, -2.0], [0.0, 0.0], [2.0, -1.0], [-2.0, 0.2]] {
            let mut model = Decay { most: 1.505, ..decay(0.0, 0.0) };
            let start = DVector::from_column_slice(&start);
            let found = minimise(&problem(), &start, &mut model).expect("nobody stops it").expect("a start");
            assert_eq!(found.ending, Ending::Converged);
            assert!((found.theta[1].exp() - 1.5).abs() < 1e-6, "{:?}", found.theta);
            failed += model.failed;
        }
        assert!(failed > 0);
    }

    #[test]
    fn a_bound_and_a_prior_hold() {
        let bounded = Problem { bounds: vec![[-7.0, 7.0], [-7.0, 0.0]], ..problem() };
        let (found, [_, b]) = fitted(&bounded, &mut decay(0.0, 0.0));
        assert!(found.ending == Ending::Converged && b == 1.0, "{found:?}");
        let tight = Prior { terms: vec![(1, 1.0)], value: 0.1, deviation: 1e-9 };
        let (found, _) = fitted(&Problem { priors: vec![tight], ..problem() }, &mut decay(0.02, 0.0));
        assert!((found.theta[1] - 0.1).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn another_start_is_taken_where_it_is_better_or_the_first_cannot_be_computed() {
        let near = DVector::from_vec(vec![2f64.ln(), 1.5f64.ln()]);
        let mut model = Decay { most: 1.6, ..decay(0.0, 0.0) };
        let start = DVector::from_vec(vec![0.0, 3.0]);
        assert!(minimise(&problem(), &start, &mut model).expect("nobody stops it").is_none());
        let others = Problem { starts: vec![&near - &start], ..problem() };
        let found = minimise(&others, &start, &mut model).expect("nobody stops it").expect("the other start");
        assert!(found.ending == Ending::Converged && found.iterations == 1, "{found:?}");
    }
}
