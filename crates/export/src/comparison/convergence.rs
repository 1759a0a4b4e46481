//! Convergence studies: observed order under mesh refinement, and error of the finest mesh.
//!
//! With `h` the length of a segment and `f(h) = f₀ + C hᵖ`, three meshes `h₁ > h₂ > h₃` give the observed order `p`
//! from `(h₁ᵖ − h₂ᵖ)/(h₂ᵖ − h₃ᵖ) = e₁₂/e₂₃`, where `eᵢⱼ` is the change from one to the next, and Richardson's
//! estimate of the remaining error, `|f(h₃) − f₀| = e₂₃ h₃ᵖ/(h₂ᵖ − h₃ᵖ)`. For shapes the changes are distances,
//! negative where the shape goes back.
//!
//! The scheme is of fourth order ([`SCHEME`]), and of second order at worst. An observed order above [`NEARLY`] says
//! that the coarsest mesh is too coarse to have one; the error is then that of an order of [`CAREFUL`], and there is no
//! limit. Where changes get smaller but change their sign, which is no order at all, it is no less than the last
//! change. Where they hardly get smaller, there is no error.

use super::shape;
use crate::ending::Ending;

/// A quantity over a sequence of finer meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Trend {
    /// The quantity.
    pub quantity: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Changes from each mesh to the next, in that unit.
    pub changes: Vec<f64>,
    /// Observed order, from the last three meshes; none where the changes do not get smaller, or change their sign.
    pub order: Option<f64>,
    /// Richardson's estimate of the error of the finest, with no larger an order than that of the scheme.
    pub error: Option<f64>,
    /// Extrapolated limit, of a quantity that is a number and has an order.
    pub limit: Option<f64>,
}

/// Range of orders that are searched.
const ORDERS: [f64; 2] = [0.05, 12.0];
/// Order of the scheme.
const SCHEME: f64 = 4.0;
/// Observed orders up to this one are that of the scheme.
const NEARLY: f64 = 4.5;
/// Order that is taken where none is observed that the scheme can have.
const CAREFUL: f64 = 2.0;

/// Convergence of shape, energy, tightest bend and largest reaction. `meshes`: segments of a branch and the last
/// equilibrium, from coarse to fine.
pub fn convergence(meshes: &[(usize, &Ending)]) -> Vec<Trend> {
    let h: Vec<f64> = meshes.iter().map(|(segments, _)| 1.0 / *segments as f64).collect();
    let shapes = |measure: fn(&[shape::Gap], &[f64]) -> f64| -> Vec<f64> {
        let mut changes: Vec<f64> = meshes.windows(2).map(|pair| distance(pair[0].1, pair[1].1, measure)).collect();
        for (k, three) in meshes.windows(3).enumerate() {
            let sign = if goes_back([three[0].1, three[1].1, three[2].1]) { -1.0 } else { 1.0 };
            changes[k + 1] *= sign * changes[k].signum();
        }
        changes
    };
    let mean = |gaps: &[shape::Gap], lengths: &[f64]| {
        let whole: f64 = lengths.iter().sum();
        gaps.iter().zip(lengths).map(|(gap, length)| gap.mean * length).sum::<f64>() / whole
    };
    let largest = |gaps: &[shape::Gap], _: &[f64]| gaps.iter().fold(0.0, |a: f64, gap| a.max(gap.largest));
    let number = |quantity, unit, of: fn(&Ending) -> f64| {
        let values: Vec<f64> = meshes.iter().map(|(_, ending)| of(ending)).collect();
        trend(quantity, unit, &h, values.windows(2).map(|pair| pair[1] - pair[0]).collect(), values.last().copied())
    };
    vec![
        trend("shape, mean distance", "m", &h, shapes(mean), None),
        trend("shape, largest distance", "m", &h, shapes(largest), None),
        number("energy", "J", |ending| ending.energy.total()),
        number("tightest bend radius", "m", |ending| ending.tightest().map_or(f64::INFINITY, |(_, _, radius)| radius)),
        number("largest constraint force", "N", |ending| {
            ending.constraints.iter().fold(0.0, |f: f64, constraint| f.max(constraint.force.norm()))
        }),
    ]
}

fn distance(a: &Ending, b: &Ending, measure: fn(&[shape::Gap], &[f64]) -> f64) -> f64 {
    let both = a.branches.iter().filter_map(|branch| {
        let other = b.branches.iter().find(|other| other.name == branch.name)?;
        Some((shape::gap(branch, other), branch.s.last().copied().unwrap_or(0.0)))
    });
    let (gaps, lengths): (Vec<_>, Vec<_>) = both.unzip();
    measure(&gaps, &lengths)
}

/// Whether the shapes of the second mesh move back on the third one, rather than on as from the first to the second.
fn goes_back([first, second, third]: [&Ending; 3]) -> bool {
    let on = third.branches.iter().filter_map(|branch| {
        let [a, b] = [first, second].map(|ending| ending.branches.iter().find(|own| own.name == branch.name));
        let (a, b, c) = (a?.curve()?, b?.curve()?, branch.curve()?);
        Some(c.fractions().map(|u| (b.at(u) - a.at(u)).dot(&(c.at(u) - b.at(u)))).sum::<f64>())
    });
    on.sum::<f64>() < 0.0
}

/// A trend from changes, which may have signs, and the value on the finest mesh.
fn trend(quantity: &'static str, unit: &'static str, h: &[f64], changes: Vec<f64>, finest: Option<f64>) -> Trend {
    let mut trend = Trend { quantity, unit, order: None, error: None, limit: None, changes };
    if let ([.., e12, e23], [.., h1, h2, h3]) = (&trend.changes[..], h) {
        let left = |p: f64| e23 * h3.powf(p) / (h2.powf(p) - h3.powf(p));
        match order([*h1, *h2, *h3], e12 / e23) {
            Some(p) if p <= NEARLY => {
                trend.order = Some(p);
                trend.error = Some(left(p.min(SCHEME)).abs());
                trend.limit = finest.map(|finest| finest + left(p.min(SCHEME)));
            }
            order => {
                trend.order = order;
                let ratio = e12 / e23;
                trend.error = match order {
                    None if ratio < -1.0 => Some(left(CAREFUL).abs().max(e23.abs())),
                    None if ratio <= ratio_of([*h1, *h2, *h3], ORDERS[1]) => None,
                    None if ratio.is_nan() => None,
                    _ => Some(left(CAREFUL).abs()),
                };
            }
        }
    }
    trend.changes.iter_mut().for_each(|change| *change = change.abs());
    trend
}

/// `(h₁ᵖ − h₂ᵖ)/(h₂ᵖ − h₃ᵖ)`.
fn ratio_of([h1, h2, h3]: [f64; 3], p: f64) -> f64 {
    (h1.powf(p) - h2.powf(p)) / (h2.powf(p) - h3.powf(p))
}

/// `p` with `(h₁ᵖ − h₂ᵖ)/(h₂ᵖ − h₃ᵖ) = ratio`, by bisection: the left side grows with `p`.
fn order([h1, h2, h3]: [f64; 3], ratio: f64) -> Option<f64> {
    let excess = |p: f64| ratio_of([h1, h2, h3], p) - ratio;
    let [mut low, mut high] = ORDERS;
    if !(excess(low) < 0.0 && excess(high) > 0.0) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_whatever_the_steps_of_refinement() {
        for (p, c) in [(1.0, 0.3), (2.0, -4.0), (3.5, 1.0)] {
            let h = [1.0 / 20.0, 1.0 / 30.0, 1.0 / 80.0];
            let f: Vec<f64> = h.iter().map(|h: &f64| 7.0 + c * h.powf(p)).collect();
            let trend = trend("f", "", &h, vec![f[1] - f[0], f[2] - f[1]], Some(f[2]));
            assert!((trend.order.unwrap() - p).abs() < 1e-9, "{trend:?}");
            assert!((trend.limit.unwrap() - 7.0).abs() < 1e-12, "{trend:?}");
            assert!((trend.error.unwrap() - (f[2] - 7.0).abs()).abs() < 1e-12, "{trend:?}");
            assert!(trend.changes.iter().all(|change| *change > 0.0));
        }
    }

    /// Meshes of which the coarsest one is too coarse: the error of the others is of fourth order.
    #[test]
    fn an_order_above_that_of_the_scheme_makes_no_small_error() {
        let h = [1.0 / 10.0, 1.0 / 20.0, 1.0 / 40.0];
        let f: Vec<f64> = h.iter().map(|h: &f64| 7.0 + h.powi(4) + if *h > 0.09 { 6e-4 } else { 0.0 }).collect();
        let changes = vec![f[1] - f[0], f[2] - f[1]];
        let found = trend("f", "", &h, changes.clone(), Some(f[2]));
        let (order, error) = (found.order.unwrap(), found.error.unwrap());
        assert!(order > 6.0, "{found:?}");
        assert!(error >= f[2] - 7.0, "{error:e} is less than the error {:e}", f[2] - 7.0);
        assert_eq!(found.limit, None);
        // That of the observed order would be too small.
        assert!(changes[1].abs() / (2.0_f64.powf(order) - 1.0) < 0.2 * (f[2] - 7.0));
    }

    #[test]
    fn what_does_not_settle_has_no_order() {
        let h = [0.1, 0.05, 0.025];
        for changes in [[1.0, 2.0], [1.0, -0.5], [0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0]] {
            assert_eq!(trend("f", "", &h, changes.to_vec(), Some(1.0)).order, None, "{changes:?}");
        }
        assert_eq!(trend("f", "", &h[..2], vec![1.0], Some(1.0)).order, None);
    }

    /// Changes of 1, 0.99, 0.98 … add up to 100; those of 1, −0.9, 0.81 … leave 0.43.
    #[test]
    fn what_hardly_settles_has_no_small_error() {
        let h = [0.1, 0.05, 0.025];
        let error = |changes: [f64; 2]| trend("f", "", &h, changes.to_vec(), Some(1.0)).error;
        assert_eq!([error([1.0, 0.99]), error([1.0, 2.0]), error([1.0, -1.1]), error([f64::NAN, 1.0])], [None; 4]);
        assert!(error([1.0, -0.9]).unwrap() > 0.43);
        assert!(error([1.0, 1e-6]).is_some());
    }
}
