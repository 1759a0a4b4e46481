//! Sweeps: a scenario run over many values. Every point follows from its number and the seed alone, so each can be
//! computed again, on any machine, in any order.

pub use crate::attachment::At;

use crate::attachment::Stretch;
use crate::fault::Fault;
use crate::settings::{self, Setting};
use crate::span::Span;
use statrs::distribution::{ContinuousCDF, Normal};
use std::sync::OnceLock;

/// Number of tabulated points of Sobol's sequence. After them the sequence repeats with another scrambling.
const SOBOL: usize = 1 << 16;
/// Largest number of keys of Sobol's sequence.
pub(crate) const MAX_SOBOL_KEYS: usize = 256;
/// Largest number of points of a sweep.
pub(crate) const MAX_POINTS: usize = 10_000_000;

/// Methods to choose points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Every combination; the last key varies fastest.
    Grid,
    /// The first values of all keys, then the second ones, and so on.
    Zip,
    /// Independent random numbers.
    Random,
    /// One point in each of as many equally likely slices of every key.
    LatinHypercube,
    /// Sobol's sequence, scrambled (Owen, by the hash of Burley).
    Sobol,
}

/// A sweep: the points that a scenario is run at.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Method to choose the points.
    pub method: Method,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Keys that vary.
    pub axes: Vec<Axis>,
    /// Number of points.
    pub points: usize,
    /// Columns of the table besides those that it always has.
    pub outputs: Vec<Output>,
    /// Slice of each point of a Latin hypercube, key by key; computed on first use.
    slices: OnceLock<Vec<Vec<usize>>>,
}

/// A key that varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Path to the key.
    pub key: String,
    /// Its values.
    pub range: Range,
    /// Its place in the file, bytes.
    pub span: Span,
}

/// A further column of a sweep's table: one for a number, four (components and norm) for a vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Name.
    pub name: String,
    /// Quantity measured at the end of the run.
    pub measured: Measured,
}

/// Quantities that can be measured of a harness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measured {
    /// Position of a place, m.
    Position(At),
    /// Internal force at an arc length (m) of a branch, by index: the force that the part behind exerts on the part
    /// before, N.
    Force(usize, f64),
    /// Internal moment, likewise, N m.
    Moment(usize, f64),
    /// Component of that force along the branch, N.
    Tension(usize, f64),
    /// Smallest bend radius of a part of a branch, m.
    BendRadius(Stretch),
    /// Unstressed length of a part of a branch beyond the distance of its ends, m.
    Slack(Stretch),
}

/// Values of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Range {
    /// A list; all values are equally likely.
    Values(Vec<Value>),
    /// A uniform distribution, in SI units.
    Uniform {
        /// Least.
        from: f64,
        /// Greatest.
        to: f64,
        /// SI unit; empty for plain numbers.
        unit: String,
    },
    /// A normal distribution, in SI units.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation.
        deviation: f64,
        /// SI unit; empty for plain numbers.
        unit: String,
    },
}

/// A value of a key.
#[derive(Clone, Debug, PartialEq)]
pub struct Value {
    /// Text as in a file.
    pub text: String,
    /// Value in SI units, if it is a number.
    pub number: Option<f64>,
}

impl Value {
    pub(crate) fn number(number: f64, unit: &str) -> Self {
        let text = if unit.is_empty() { format!("{number:?}") } else { format!("\"{number:?} {unit}\"") };
        Self { text, number: Some(number) }
    }

    /// The text without quotes.
    pub fn word(&self) -> &str {
        self.text.trim_matches('"')
    }
}

impl Range {
    /// The quantile at `u`, 0 < u < 1.
    fn quantile(&self, u: f64) -> Value {
        match self {
            Range::Values(values) => values[((u * values.len() as f64) as usize).min(values.len() - 1)].clone(),
            Range::Uniform { from, to, unit } => Value::number(from + u * (to - from), unit),
            Range::Normal { mean, deviation, unit } => {
                Value::number(mean + deviation * Normal::standard().inverse_cdf(u), unit)
            }
        }
    }

    /// Number of values in a list; 1 for distributions.
    pub(crate) fn count(&self) -> usize {
        if let Range::Values(values) = self { values.len() } else { 1 }
    }

    /// Whether all values are numbers.
    pub fn is_numeric(&self) -> bool {
        match self {
            Range::Values(values) => values.iter().all(|value| value.number.is_some()),
            Range::Uniform { .. } | Range::Normal { .. } => true,
        }
    }
}

impl Sweep {
    /// A sweep with this number of points.
    pub(crate) fn new(method: Method, seed: u64, axes: Vec<Axis>, points: usize, outputs: Vec<Output>) -> Self {
        Self { method, seed, axes, points, outputs, slices: OnceLock::new() }
    }

    /// The values of a point, by number from 0, in the order of the axes.
    ///
    /// # Panics
    /// If `k` is not below the number of points.
    pub fn point(&self, k: usize) -> Vec<Value> {
        assert!(k < self.points, "the sweep has {} points", self.points);
        let listed = |axis: &Axis, i: usize| match &axis.range {
            Range::Values(values) => values[i].clone(),
            Range::Uniform { .. } | Range::Normal { .. } => unreachable!("grids and zips have lists"),
        };
        match self.method {
            Method::Grid => {
                let mut left = k;
                let mut values: Vec<Value> = Vec::with_capacity(self.axes.len());
                for axis in self.axes.iter().rev() {
                    let n = axis.range.count();
                    values.push(listed(axis, left % n));
                    left /= n;
                }
                values.reverse();
                values
            }
            Method::Zip => self.axes.iter().map(|axis| listed(axis, k)).collect(),
            Method::Random | Method::LatinHypercube | Method::Sobol => {
                let coordinates = (0..self.axes.len()).map(|axis| self.coordinate(k, axis));
                self.axes.iter().zip(coordinates).map(|(axis, u)| axis.range.quantile(u)).collect()
            }
        }
    }

    /// Between 0 and 1, both excluded.
    fn coordinate(&self, k: usize, axis: usize) -> f64 {
        let u = match self.method {
            Method::Sobol => {
                let scrambling = (self.seed as u32).wrapping_add(0x9e37_79b9_u32.wrapping_mul((k / SOBOL) as u32));
                let sample = sobol_burley::sample((k % SOBOL) as u32, axis as u32, scrambling);
                // The middle of the smallest interval that the sequence knows.
                f64::from(sample) + f64::from(f32::EPSILON) / 4.0
            }
            Method::LatinHypercube => {
                (self.slices()[axis][k] as f64 + random(self.seed, k, axis).f64()) / self.points as f64
            }
            _ => random(self.seed, k, axis).f64(),
        };
        u.clamp(f64::EPSILON, 1.0 - f64::EPSILON)
    }

    /// Coordinates of a point among all points, one for each key, from 0 to 1: points with near coordinates have near
    /// values. The distance of two words is that of their places in the list.
    pub fn place(&self, k: usize) -> Vec<f64> {
        let listed = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
        let mut left = k;
        let mut places: Vec<f64> = (0..self.axes.len())
            .rev()
            .map(|axis| match (self.method, self.axes[axis].range.count()) {
                (Method::Grid, n) => {
                    let i = left % n;
                    left /= n;
                    listed(i, n)
                }
                (Method::Zip, n) => listed(k, n),
                (Method::Random | Method::LatinHypercube | Method::Sobol, _) => self.coordinate(k, axis),
            })
            .collect();
        places.reverse();
        places
    }

    fn slices(&self) -> &[Vec<usize>] {
        self.slices.get_or_init(|| (0..self.axes.len()).map(|axis| permutation(self.seed, axis, self.points)).collect())
    }

    /// Settings of a point.
    pub fn settings(&self, k: usize) -> Vec<Setting> {
        self.axes.iter().zip(self.point(k)).map(|(axis, value)| Setting::new(&axis.key, value.text)).collect()
    }
}

/// Random numbers of one coordinate of one point; the odd factors separate neighbours.
fn random(seed: u64, k: usize, axis: usize) -> fastrand::Rng {
    let mixed = seed
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add((k as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9))
        .wrapping_add((axis as u64).wrapping_mul(0x94d0_49bb_1331_11eb));
    let mut random = fastrand::Rng::with_seed(mixed);
    // The first numbers of neighbouring seeds are similar, so the second number serves as a seed.
    random.u64(..);
    fastrand::Rng::with_seed(random.u64(..))
}

fn permutation(seed: u64, axis: usize, n: usize) -> Vec<usize> {
    let mut slices: Vec<usize> = (0..n).collect();
    random(seed, usize::MAX, axis).shuffle(&mut slices);
    slices
}

/// Faults of the first point's settings, where the sweep names their keys.
pub(crate) fn placed(sweep: &Sweep, text: &str, faults: Vec<Fault>) -> Vec<Fault> {
    let (own, set) = settings::apart(text, faults);
    let lines = settings::lines(&sweep.settings(0));
    let place = |fault: Fault| {
        let line = fault.position(&lines).0 - 1;
        let span = sweep.axes.get(line).map_or(0..0, |axis| axis.span.clone());
        Fault { span, message: format!("at the first point of the sweep: {}", fault.message), help: fault.help }
    };
    own.into_iter().chain(set.into_iter().map(place)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(method: Method, points: usize) -> Sweep {
        let axis = |key: &str| Axis {
            key: key.into(),
            range: Range::Uniform { from: 0.0, to: 1.0, unit: String::new() },
            span: 0..0,
        };
        let axes = vec![axis("a"), axis("b")];
        Sweep { method, seed: 7, axes, points, outputs: vec![], slices: OnceLock::new() }
    }

    fn numbers(sweep: &Sweep) -> Vec<[f64; 2]> {
        (0..sweep.points).map(|k| [0, 1].map(|axis| sweep.point(k)[axis].number.unwrap())).collect()
    }

    #[test]
    fn points_fill_their_range_evenly() {
        for method in [Method::Random, Method::LatinHypercube, Method::Sobol] {
            let points = numbers(&uniform(method, 1024));
            // Of 16 × 16 squares each should have 4; of Poisson-distributed numbers some 2 % would have none.
            let mut squares = [[0; 16]; 16];
            for [a, b] in &points {
                squares[(16.0 * a) as usize][(16.0 * b) as usize] += 1;
            }
            let empty = squares.iter().flatten().filter(|n| **n == 0).count();
            assert!(empty < if method == Method::Sobol { 1 } else { 20 }, "{method:?}: {empty}");
            let mean = points.iter().map(|[a, b]| a + b).sum::<f64>() / 2048.0;
            assert!((mean - 0.5).abs() < 0.02, "{method:?}: {mean}");
            assert_eq!(points, numbers(&uniform(method, 1024)));
        }
        // Beyond the end of Sobol's tables each further 65,536 points fill it evenly, and are others.
        let sobol = uniform(Method::Sobol, 2 * SOBOL);
        let mut squares = [[0; 256]; 256];
        for k in SOBOL..2 * SOBOL {
            let [a, b] = [0, 1].map(|axis| sobol.coordinate(k, axis));
            squares[(256.0 * a) as usize][(256.0 * b) as usize] += 1;
            assert!(a != sobol.coordinate(k - SOBOL, 0));
        }
        assert!(squares.iter().flatten().all(|n| *n == 1), "one in each of as many squares");
        let slices = |axis: usize| {
            let mut slices: Vec<usize> = numbers(&uniform(Method::LatinHypercube, 100))
                .iter()
                .map(|point| (100.0 * point[axis]) as usize)
                .collect();
            slices.sort_unstable();
            slices
        };
        assert!(slices(0).into_iter().eq(0..100) && slices(1).into_iter().eq(0..100), "one point a slice");
    }

    #[test]
    fn quantiles_are_those_of_the_distribution() {
        let normal = Range::Normal { mean: 2.0, deviation: 0.5, unit: "m".into() };
        // Tables: Φ(1.959964) = 0.975.
        for (u, expected) in [(0.5, 2.0), (0.975, 2.0 + 0.5 * 1.959964), (0.001, 2.0 - 0.5 * 3.090232)] {
            let value = normal.quantile(u);
            assert!((value.number.unwrap() - expected).abs() < 1e-6, "{value:?}");
            assert!(value.text.starts_with('"') && value.text.ends_with(" m\""), "{value:?}");
        }
    }
}
