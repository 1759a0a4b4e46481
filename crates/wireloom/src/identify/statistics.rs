//! What a fit knows: noise of the points, deviations of the unknowns with and without priors, their correlations.

use super::least_squares::{Minimum, Prior, Problem};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use statrs::distribution::{ContinuousCDF, StudentsT};
use std::ops::Range;

/// Eigenvalue of the normal matrix, relative to the largest one, below which it is round-off.
const ROUND_OFF: f64 = 1e-12;
/// Part of an unknown in what is not determined, squared, from which on it is not determined itself.
const PART: f64 = 1e-8;
/// Residual (m), and derivative (m per unit of an unknown), below which a coordinate tells nothing: one across the
/// plane in which everything lies.
const NOTHING: f64 = 1e-10;
/// Number of pairs of neighbouring points from which on their correlation is estimated.
const PAIRS: usize = 8;
/// Correlation, in units of its deviation for independent residuals, from which on it is not by chance.
const BY_CHANCE: f64 = 3.0;
/// Largest correlation that is taken into account.
const MOST_CORRELATED: f64 = 0.95;
/// Probability of the intervals.
pub const PROBABILITY: f64 = 0.95;

/// What a fit knows.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Standard deviation of one coordinate, m; `None` where there are no more coordinates than unknowns.
    pub noise: Option<f64>,
    /// Correlation of the residuals of points beside each other; `None` where there are too few pairs.
    pub neighbours: Option<f64>,
    /// Factor on deviations because of it.
    pub widened: f64,
    /// Half the width of an interval of 95 % in deviations.
    pub quantile: f64,
    /// Covariance of the unknowns, with priors.
    pub covariance: DMatrix<f64>,
    /// Deviation of each unknown from the points alone, with the priors that are part of the model; infinite where
    /// they do not determine it.
    pub by_data: DVector<f64>,
    /// Correlations of the unknowns.
    pub correlations: DMatrix<f64>,
}

impl Statistics {
    /// Those of a minimum. `of_model`: the priors that are part of the model, such as smoothness; `chains`: points that
    /// lie beside each other, in order.
    pub fn new(problem: &Problem, at: &Minimum, of_model: &[Prior], chains: &[Vec<usize>]) -> Self {
        let unknowns = at.theta.len();
        let (unit, _) = problem.points.normal(&at.jacobian, &at.residuals, 1.0);
        let weighed = |k: usize| {
            let weight = problem.points.weight(k, &at.residuals, at.scale);
            let tells = |i: &usize| at.residuals[*i].abs() > NOTHING || at.jacobian.row(*i).amax() > NOTHING;
            let coordinates = problem.points.ranges[k].clone().filter(tells).count();
            (weight * problem.points.distance(k, &at.residuals).powi(2), weight * coordinates as f64)
        };
        let (squares, coordinates) = (0..problem.points.ranges.len())
            .map(weighed)
            .fold((0.0, 0.0), |(squares, n), (more, own)| (squares + more, n + own));
        let priors = |all: &[Prior]| {
            let mut normal = DMatrix::zeros(unknowns, unknowns);
            all.iter().for_each(|prior| prior.add_to(&mut normal));
            normal
        };
        let all_priors = priors(&problem.priors);
        // Unknowns that the points determine: those that priors hold take nothing out of the residuals.
        let data = &unit / (at.scale * at.scale);
        let effective = inverse(&(&data + &all_priors)).map_or(unknowns as f64, |inverse| (inverse * &data).trace());
        let free = coordinates - effective;
        let estimated = (free >= 0.5).then(|| (squares / free).sqrt().max(problem.points.least_noise));
        let noise = match (problem.points.noise, estimated) {
            (Some(known), Some(estimated)) => Some(known.max(estimated)),
            (known, estimated) => known.or(estimated),
        };
        let neighbours = neighbours(&problem.points.ranges, &at.residuals, chains);
        let rho = neighbours.filter(|(rho, by_chance)| *rho > BY_CHANCE * by_chance).map_or(0.0, |(rho, _)| rho);
        let rho = rho.min(MOST_CORRELATED);
        // Of residuals that are correlated like rho^k with the k-th neighbour, n count as n (1 − rho)/(1 + rho).
        let widened = ((1.0 + rho) / (1.0 - rho)).sqrt();
        let scale = noise.unwrap_or(f64::INFINITY) * widened;
        let data = if scale.is_finite() { &unit / (scale * scale) } else { DMatrix::zeros(unknowns, unknowns) };
        let quantile = match (problem.points.noise, StudentsT::new(0.0, 1.0, free.max(1.0))) {
            (None, Ok(student)) => student.inverse_cdf(0.5 + 0.5 * PROBABILITY),
            _ => 1.96,
        };
        let by_data = deviations(&(&data + priors(of_model)));
        let covariance = inverse(&(&data + all_priors))
            .unwrap_or_else(|| DMatrix::from_diagonal_element(unknowns, unknowns, f64::INFINITY));
        let correlation = |i: usize, j: usize| {
            if i == j { 1.0 } else { covariance[(i, j)] / (covariance[(i, i)] * covariance[(j, j)]).sqrt() }
        };
        Self {
            correlations: DMatrix::from_fn(unknowns, unknowns, correlation),
            neighbours: neighbours.map(|(rho, _)| rho),
            noise,
            widened,
            quantile,
            covariance,
            by_data,
        }
    }

    /// Deviation of an unknown, with priors.
    pub fn deviation(&self, i: usize) -> f64 {
        self.covariance[(i, i)].sqrt()
    }

    /// Step of all unknowns along which unknown `i` changes by `deviations` of its own, and the others as the fit would
    /// have them then.
    pub fn profile(&self, i: usize, deviations: f64) -> DVector<f64> {
        self.covariance.column(i) * (deviations / self.deviation(i))
    }
}

/// Inverse of a normal matrix; `None` where it is singular.
fn inverse(normal: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    normal.clone().cholesky().map(|factor| factor.inverse()).filter(|inverse| inverse.iter().all(|x| x.is_finite()))
}

/// Standard deviations that follow from a normal matrix, infinite for what it does not determine.
fn deviations(normal: &DMatrix<f64>) -> DVector<f64> {
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(normal.clone());
    let least = ROUND_OFF * eigenvalues.amax();
    DVector::from_fn(normal.nrows(), |i, _| {
        let part = |k: usize| eigenvectors[(i, k)] * eigenvectors[(i, k)];
        let (known, unknown): (Vec<usize>, Vec<usize>) = (0..normal.nrows()).partition(|k| eigenvalues[*k] > least);
        if unknown.into_iter().map(part).sum::<f64>() > PART {
            return f64::INFINITY;
        }
        known.into_iter().map(|k| part(k) / eigenvalues[k]).sum::<f64>().sqrt()
    })
}

/// Correlation of the residuals of neighbours, and its deviation if they are independent.
fn neighbours(ranges: &[Range<usize>], residuals: &DVector<f64>, chains: &[Vec<usize>]) -> Option<(f64, f64)> {
    let (mut products, mut squares, mut pairs, mut count) = (0.0, 0.0, 0, 0);
    for chain in chains {
        for pair in chain.windows(2) {
            let [one, other] = [&ranges[pair[0]], &ranges[pair[1]]];
            if one.len() != other.len() {
                continue;
            }
            pairs += 1;
            for (i, j) in one.clone().zip(other.clone()) {
                products += residuals[i] * residuals[j];
                squares += 0.5 * (residuals[i] * residuals[i] + residuals[j] * residuals[j]);
                count += usize::from(residuals[i].abs() > NOTHING || residuals[j].abs() > NOTHING);
            }
        }
    }
    (pairs >= PAIRS && squares > 0.0 && count > 0).then(|| (products / squares, 1.0 / (count as f64).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::least_squares::{Ending, Points};

    /// A straight line a + b x through 20 points with noise 0.1, in closed form.
    #[test]
    fn deviations_of_a_straight_line_are_those_of_the_closed_form() {
        let n = 20;
        let mut random = fastrand::Rng::with_seed(3);
        let x: Vec<f64> = (0..n).map(|k| k as f64).collect();
        let noise: Vec<f64> = (0..n).map(|_| 0.1 * (random.f64() + random.f64() + random.f64() - 1.5)).collect();
        let (sx, sxx) = (x.iter().sum::<f64>(), x.iter().map(|x| x * x).sum::<f64>());
        let (sy, sxy) = (noise.iter().sum::<f64>(), x.iter().zip(&noise).map(|(x, y)| x * y).sum::<f64>());
        let m = n as f64;
        let b = (m * sxy - sx * sy) / (m * sxx - sx * sx);
        let a = (sy - b * sx) / m;
        let residuals = DVector::from_fn(n, |i, _| a + b * x[i] - noise[i]);
        let sigma = (residuals.norm_squared() / (m - 2.0)).sqrt();
        let expected = [sigma * (sxx / (m * sxx - sx * sx)).sqrt(), sigma * (m / (m * sxx - sx * sx)).sqrt()];
        let points = Points { ranges: (0..n).map(|k| k..k + 1).collect(), noise: None, least_noise: 1e-12 };
        let problem =
            Problem { points, priors: vec![], bounds: vec![], largest_step: 1.0, starts: vec![], searches: 1 };
        let jacobian = DMatrix::from_fn(n, 3, |i, j| [1.0, x[i], 0.0][j]);
        let at = |jacobian: DMatrix<f64>, unknowns: usize| Minimum {
            ending: Ending::Converged,
            theta: DVector::zeros(unknowns),
            residuals: residuals.clone(),
            scale: problem.points.scale(&residuals, 2),
            jacobian,
            iterations: 1,
            rivals: Vec::new(),
        };
        let found = Statistics::new(&problem, &at(jacobian.columns(0, 2).into_owned(), 2), &[], &[]);
        for (k, expected) in expected.iter().enumerate() {
            assert!((found.deviation(k) / expected - 1.0).abs() < 1e-9, "{found:?}");
            assert!((found.by_data[k] / expected - 1.0).abs() < 1e-9, "{found:?}");
        }
        // Student's distribution with 18 degrees of freedom: tables give 2.101.
        assert!((found.quantile - 2.101).abs() < 1e-3, "{}", found.quantile);
        let mean = sx / m;
        let expected = -mean / (sxx / m).sqrt();
        assert!((found.correlations[(0, 1)] - expected).abs() < 1e-9, "{}", found.correlations);
        // A third unknown that moves nothing.
        let found = Statistics::new(&problem, &at(jacobian, 3), &[], &[]);
        assert!(found.by_data[2].is_infinite() && found.by_data[1].is_finite(), "{found:?}");
    }

    #[test]
    fn residuals_that_follow_each_other_widen_the_deviations() {
        let n = 40;
        let ranges: Vec<Range<usize>> = (0..n).map(|k| k..k + 1).collect();
        let wave = DVector::from_fn(n, |i, _| (0.2 * i as f64).sin());
        let chain = [(0..n).collect::<Vec<usize>>()];
        let (rho, by_chance) = neighbours(&ranges, &wave, &chain).expect("39 pairs");
        // Of a sampled sine the correlation of neighbours is the cosine of the step.
        assert!((rho - 0.2f64.cos()).abs() < 0.03 && by_chance < 0.17, "{rho} {by_chance}");
        assert!(neighbours(&ranges, &wave, &[vec![0, 1, 2]]).is_none());
    }
}
