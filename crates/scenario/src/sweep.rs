//! Sweeps: which values a scenario is run over. Every point follows from its number and the seed alone, so any of them can be
//! computed again, on any machine, in any order.

mod outputs;

pub use crate::scenario::At;
pub(crate) use outputs::QUANTITIES;
pub use outputs::{Measured, Output};

use crate::Span;
use crate::document::Names;
use crate::fault::Fault;
use crate::reader::Entry;
use crate::settings::Setting;
use crate::units;
use statrs::distribution::{ContinuousCDF, Normal};
use std::sync::OnceLock;
use toml::Spanned;
use toml::de::DeValue;

/// Points of Sobol's sequence, as far as it is tabulated; after them it begins anew, scrambled otherwise.
const SOBOL: usize = 1 << 16;
/// The most keys of it.
const SOBOL_KEYS: usize = 256;
/// The most points of any sweep.
const POINTS: usize = 10_000_000;

/// How points are chosen.
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

/// What a scenario is run over.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// How points are chosen.
    pub method: Method,
    /// Of the random numbers.
    pub seed: u64,
    /// What varies.
    pub axes: Vec<Axis>,
    /// Number of points.
    pub points: usize,
    /// What is measured beside what always is.
    pub outputs: Vec<Output>,
    /// Of a Latin hypercube: which slice each point has, key by key; there once a point is asked for.
    slices: OnceLock<Vec<Vec<usize>>>,
}

/// A key that varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The way to it.
    pub key: String,
    /// Its values.
    pub range: Range,
    /// Where it is in the file, bytes.
    pub span: Span,
}

/// Values of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Range {
    /// These, all as likely as each other.
    Values(Vec<Value>),
    /// Any between these, in SI units, all as likely as each other.
    Uniform {
        /// Least.
        from: f64,
        /// Greatest.
        to: f64,
        /// SI unit; empty for plain numbers.
        unit: String,
    },
    /// Normally distributed, in SI units.
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
    /// As it would stand in the file.
    pub text: String,
    /// In SI units, where it is a number.
    pub number: Option<f64>,
}

impl Value {
    fn number(number: f64, unit: &str) -> Self {
        let text = if unit.is_empty() { format!("{number:?}") } else { format!("\"{number:?} {unit}\"") };
        Self { text, number: Some(number) }
    }

    /// As a word: without quotes.
    pub fn word(&self) -> &str {
        self.text.trim_matches('"')
    }
}

impl Range {
    /// The value below which is the share `u` of all, 0 < u < 1.
    fn quantile(&self, u: f64) -> Value {
        match self {
            Range::Values(values) => values[((u * values.len() as f64) as usize).min(values.len() - 1)].clone(),
            Range::Uniform { from, to, unit } => Value::number(from + u * (to - from), unit),
            Range::Normal { mean, deviation, unit } => {
                Value::number(mean + deviation * Normal::standard().inverse_cdf(u), unit)
            }
        }
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
    /// The values of a point, by number from 0, in the order of the axes.
    ///
    /// # Panics
    /// If there are not so many points.
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
                    let n = count(&axis.range);
                    values.push(listed(axis, left % n));
                    left /= n;
                }
                values.reverse();
                values
            }
            Method::Zip => self.axes.iter().map(|axis| listed(axis, k)).collect(),
            Method::Random | Method::LatinHypercube | Method::Sobol => {
                let shares = (0..self.axes.len()).map(|axis| self.share(k, axis));
                self.axes.iter().zip(shares).map(|(axis, u)| axis.range.quantile(u)).collect()
            }
        }
    }

    /// Between 0 and 1, both excluded.
    fn share(&self, k: usize, axis: usize) -> f64 {
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

    /// Where a point is among all, key by key, each between 0 and 1: what is near there has values that are near. Words are as far
    /// from each other as places in their list.
    pub fn place(&self, k: usize) -> Vec<f64> {
        let listed = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
        let mut left = k;
        let mut places: Vec<f64> = (0..self.axes.len())
            .rev()
            .map(|axis| match (self.method, count(&self.axes[axis].range)) {
                (Method::Grid, n) => {
                    let i = left % n;
                    left /= n;
                    listed(i, n)
                }
                (Method::Zip, n) => listed(k, n),
                (Method::Random | Method::LatinHypercube | Method::Sobol, _) => self.share(k, axis),
            })
            .collect();
        places.reverse();
        places
    }

    fn slices(&self) -> &[Vec<usize>] {
        self.slices.get_or_init(|| (0..self.axes.len()).map(|axis| permutation(self.seed, axis, self.points)).collect())
    }

    /// What to set for a point.
    pub fn settings(&self, k: usize) -> Vec<Setting> {
        self.axes.iter().zip(self.point(k)).map(|(axis, value)| Setting::new(&axis.key, value.text)).collect()
    }
}

/// Random numbers of one coordinate of one point; the odd factors keep neighbours apart.
fn random(seed: u64, k: usize, axis: usize) -> fastrand::Rng {
    let mixed = seed
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add((k as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9))
        .wrapping_add((axis as u64).wrapping_mul(0x94d0_49bb_1331_11eb));
    let mut random = fastrand::Rng::with_seed(mixed);
    // The first numbers of neighbouring seeds are alike: they are taken as a seed themselves.
    random.u64(..);
    fastrand::Rng::with_seed(random.u64(..))
}

fn count(range: &Range) -> usize {
    if let Range::Values(values) = range { values.len() } else { 1 }
}

/// Reads a sweep; `None` where it is at fault.
pub(crate) fn sweep(entry: &Entry<'_>, names: &Names<'_>) -> Option<Sweep> {
    let before = entry.reader.fault_count();
    let method = match entry.choice("method").unwrap_or("grid") {
        "zip" => Method::Zip,
        "random" => Method::Random,
        "latin-hypercube" => Method::LatinHypercube,
        "sobol" => Method::Sobol,
        _ => Method::Grid,
    };
    let sampled = matches!(method, Method::Random | Method::LatinHypercube | Method::Sobol);
    let samples = entry.count("samples");
    if sampled && !entry.has("samples") {
        entry.fault_at("method", "a sweep at random has no `samples`", "say how many points, such as samples = 1000");
    }
    if !sampled && entry.has("samples") {
        entry.fault_at(
            "samples",
            "this sweep has as many points as its lists give",
            "leave out `samples`, or choose method = \"random\"",
        );
    }
    let seed = entry.count("seed").unwrap_or(0) as u64;
    let varied = entry.named_entries("vary");
    let axes: Vec<Axis> = varied.iter().filter_map(|(key, varied)| axis(key, varied, sampled)).collect();
    if varied.is_empty() && entry.has("vary") {
        entry.fault_at(
            "vary",
            "nothing varies",
            "add a key, such as \"branches.left.length\" = { from = 0.4, to = 0.5 }",
        );
    }
    let measured = entry.named_entries("outputs");
    let outputs: Vec<Output> =
        measured.iter().filter_map(|(name, output)| outputs::output(name, output, names)).collect();
    if entry.reader.fault_count() > before || axes.is_empty() {
        return None;
    }
    let counts: Vec<usize> = axes.iter().map(|axis| count(&axis.range)).collect();
    let points = match method {
        Method::Grid => counts.iter().try_fold(1_usize, |all, n| all.checked_mul(*n)).unwrap_or(usize::MAX),
        Method::Zip => {
            if let Some(k) = counts.iter().position(|n| *n != counts[0]) {
                let message =
                    format!("`{}` has {} values, `{}` has {}", axes[k].key, counts[k], axes[0].key, counts[0]);
                entry.reader.fault(axes[k].span.clone(), message, "keys that vary together have as many values each");
                return None;
            }
            counts[0]
        }
        _ => samples.unwrap_or(1),
    };
    if points > POINTS {
        entry.fault_here(format!("this sweep has {points} points"), format!("at most {POINTS} are possible"));
        return None;
    }
    if method == Method::Sobol && axes.len() > SOBOL_KEYS {
        entry.fault_here(
            format!("this sweep varies {} keys", axes.len()),
            format!("at most {SOBOL_KEYS} are possible with sobol"),
        );
        return None;
    }
    Some(Sweep { method, seed, axes, points, outputs, slices: OnceLock::new() })
}

fn permutation(seed: u64, axis: usize, n: usize) -> Vec<usize> {
    let mut slices: Vec<usize> = (0..n).collect();
    random(seed, usize::MAX, axis).shuffle(&mut slices);
    slices
}

fn axis(key: &str, entry: &Entry<'_>, sampled: bool) -> Option<Axis> {
    let given: Vec<&str> =
        ["values", "from", "to", "count", "mean", "deviation"].into_iter().filter(|name| entry.has(name)).collect();
    let range = match &given[..] {
        ["values"] => {
            let values: Vec<Value> = entry.values("values").iter().map(|node| listed(entry, node)).collect();
            if values.is_empty() {
                entry.fault_at("values", format!("`{key}` has no values"), "write a list, such as [0.4, \"500 mm\"]");
                return None;
            }
            Range::Values(values)
        }
        ["from", "to"] | ["from", "to", "count"] => {
            let (unit, [from, to]) = pair(entry, ["from", "to"])?;
            match (sampled, entry.count("count")) {
                (true, None) => Range::Uniform { from, to, unit },
                (false, Some(n)) => {
                    let at = |i: usize| from + (to - from) * i as f64 / (n - 1) as f64;
                    Range::Values((0..n).map(|i| Value::number(at(i), &unit)).collect())
                }
                (true, Some(_)) => {
                    let help = "leave it out, or choose method = \"grid\"";
                    entry.fault_at("count", format!("`count` of `{key}` means nothing at random"), help);
                    return None;
                }
                (false, None) => {
                    let help = "add count = 5, or choose a method with samples, such as \"random\"";
                    entry.fault_here(format!("`{key}` has no `count`"), help);
                    return None;
                }
            }
        }
        ["mean", "deviation"] if sampled => {
            let (unit, [mean, deviation]) = pair(entry, ["mean", "deviation"])?;
            if deviation < 0.0 {
                entry.fault_at(
                    "deviation",
                    format!("`deviation` of `{key}` is below zero"),
                    "give a standard deviation",
                );
                return None;
            }
            Range::Normal { mean, deviation, unit }
        }
        ["mean", "deviation"] => {
            entry.fault_here(
                format!("`{key}` is distributed, but points are not chosen at random"),
                "choose a method with samples, such as \"random\" or \"latin-hypercube\"",
            );
            return None;
        }
        _ => {
            entry.fault_here(
                format!("`{key}` has {}", if given.is_empty() { "no values".to_owned() } else { given.join(", ") }),
                "give either values, or from and to (and count), or mean and deviation",
            );
            return None;
        }
    };
    Some(Axis { key: key.to_owned(), range, span: entry.span.clone() })
}

/// A value of a list, as it stands in the file.
fn listed(entry: &Entry<'_>, node: &Spanned<DeValue<'_>>) -> Value {
    let text = entry.reader.text.get(node.span()).unwrap_or_default().to_owned();
    let number = match node.get_ref() {
        DeValue::Integer(integer) => integer.as_str().parse().ok(),
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::String(text) => units::any(text).ok().map(|(value, _)| value),
        _ => None,
    };
    Value { text, number }
}

/// Two numbers of the same unit, in SI.
fn pair(entry: &Entry<'_>, names: [&str; 2]) -> Option<(String, [f64; 2])> {
    let read = |name: &str| -> Option<(f64, String)> {
        let node = entry.node(name)?;
        let read = match node.get_ref() {
            DeValue::Integer(integer) => {
                integer.as_str().parse().map(|x| (x, String::new())).map_err(|_| String::new())
            }
            DeValue::Float(float) => float.as_str().parse().map(|x| (x, String::new())).map_err(|_| String::new()),
            DeValue::String(text) => units::any(text),
            _ => Err(String::new()),
        };
        match read {
            Ok((value, unit)) if value.is_finite() => Some((value, unit)),
            Ok(_) | Err(_) => {
                let shown = entry.reader.text.get(node.span()).unwrap_or_default();
                let message = format!("`{name}` = {shown} is no number");
                entry.fault_at(name, message, "write a number in SI units, or one with a unit such as \"500 mm\"");
                None
            }
        }
    };
    let (first, second) = (read(names[0]), read(names[1]));
    let ((a, unit), (b, other)) = (first?, second?);
    if unit != other {
        let shown = |unit: &str| if unit.is_empty() { "no unit".to_owned() } else { format!("the unit {unit}") };
        let message = format!("`{}` has {}, `{}` has {}", names[0], shown(&unit), names[1], shown(&other));
        entry.fault_at(names[1], message, "give both with a unit of the same quantity, or both without");
        return None;
    }
    Some((unit, [a, b]))
}

/// Faults of the first point's settings, where the sweep names their keys.
pub(crate) fn placed(sweep: &Sweep, text: &str, faults: Vec<Fault>) -> Vec<Fault> {
    let (own, set) = crate::settings::apart(text, faults);
    let lines = crate::settings::lines(&sweep.settings(0));
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
            let [a, b] = [0, 1].map(|axis| sobol.share(k, axis));
            squares[(256.0 * a) as usize][(256.0 * b) as usize] += 1;
            assert!(a != sobol.share(k - SOBOL, 0));
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
