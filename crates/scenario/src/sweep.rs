//! Sweeps: a scenario run over many values. Every point follows from its number and the seed alone, so each can be
//! computed again, on any machine, in any order.

pub use crate::attachment::At;

use crate::attachment::Stretch;
use crate::fault::Fault;
use crate::settings::{self, Setting};
use crate::span::Span;
use statrs::distribution::{ContinuousCDF, Normal};

/// Number of tabulated points of Sobol's sequence. After them the sequence repeats with another scrambling.
const SOBOL: usize = 1 << 16;
/// Largest number of keys of Sobol's sequence.
pub(crate) const MAX_SOBOL_KEYS: usize = 256;
/// Largest number of points of a sweep.
pub(crate) const MAX_POINTS: usize = 1_000_000_000;
/// Largest number of points of a sweep with conditions: those that differ are listed before it begins.
pub(crate) const MAX_LISTED: usize = 10_000_000;
/// Rounds of the permutation of a Latin hypercube.
const ROUNDS: u32 = 6;

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

impl Method {
    /// Word used in scenarios.
    pub fn word(self) -> &'static str {
        match self {
            Method::Grid => "grid",
            Method::Zip => "zip",
            Method::Random => "random",
            Method::LatinHypercube => "latin-hypercube",
            Method::Sobol => "sobol",
        }
    }
}

/// A sweep: the points that a scenario is run at.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Method to choose the points.
    pub method: Method,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Keys that vary: those that are crossed with all others first.
    pub axes: Vec<Axis>,
    /// Number of the keys that are crossed.
    pub crossed: usize,
    /// Number of points.
    pub points: usize,
    /// Columns of the table besides those that it always has.
    pub outputs: Vec<Output>,
    /// Time limit of a point, s.
    pub time_limit: Option<f64>,
    /// Size of the cells of the grid on which the space swept at all points is found, m.
    pub swept: Option<f64>,
    /// Points of each combination of the crossed keys.
    samples: usize,
    /// Places in the whole design of the points that differ from all before; `None`: all of them.
    distinct: Option<Vec<usize>>,
}

/// A key that varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Path to the key.
    pub key: String,
    /// Its values.
    pub range: Range,
    /// It varies only where all of these hold.
    pub when: Vec<Condition>,
    /// Its place in the file, bytes.
    pub span: Span,
}

/// Condition under which a key varies: another key has one of these values.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Index of the other key.
    pub axis: usize,
    /// The values.
    pub values: Vec<Value>,
}

/// A further column of a sweep's table: one for a number, several for a vector.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Name.
    pub name: String,
    /// Measured quantity.
    pub measured: Measured,
    /// Increment at which it is measured.
    pub at: When,
}

/// Increment at which an output is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// The last one.
    End,
    /// The one with the least value.
    Min,
    /// The one with the greatest value.
    Max,
    /// The last one of a step, by index.
    Step(usize),
}

/// Quantities that can be measured of a harness.
#[derive(Clone, Debug, PartialEq)]
pub enum Measured {
    /// Position of a place, m.
    Position(Body),
    /// Orientation of a place.
    Orientation(Body),
    /// Angle between the directions of two branches at arc lengths (m), rad.
    Angle([(usize, f64); 2]),
    /// Internal force at an arc length (m) of a branch, by index: the force that the part behind exerts on the part
    /// before, N.
    Force(usize, f64),
    /// Internal moment, likewise, N m.
    Moment(usize, f64),
    /// Component of that force along the branch, N.
    Tension(usize, f64),
    /// Force of a constraint or an obstacle on the harness, N.
    Reaction(Body),
    /// Its moment on the harness, N m.
    ReactionMoment(Body),
    /// Smallest bend radius of a part of a branch, m.
    BendRadius(Stretch),
    /// Unstressed length of a part of a branch beyond the distance of its ends, m.
    Slack(Stretch),
    /// Total material twist of a branch, turns.
    Turns(usize),
    /// Distance between the surfaces of parts of two branches, or of a part of a branch and an obstacle, m.
    Clearance(Stretch, Body),
    /// Sum of the sizes of the contact forces of an obstacle, N.
    ContactForce(usize),
    /// Output of a constraint's kind: name of the constraint, name of the output; SI.
    Output(String, String),
}

/// Something that an output is measured of.
#[derive(Clone, Debug, PartialEq)]
pub enum Body {
    /// A place on the harness.
    Place(At),
    /// A part of a branch.
    Part(Stretch),
    /// A constraint, by name: others may have the same name before and after it.
    Constraint(String),
    /// An obstacle, by index.
    Obstacle(usize),
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
        self.text.trim_matches(['"', '\''])
    }

    /// Whether both are the same number, or the same text.
    pub(crate) fn is(&self, other: &Value) -> bool {
        match (self.number, other.number) {
            (Some(a), Some(b)) => a == b,
            _ => self.word() == other.word(),
        }
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

/// Design of a sweep, from which its points follow.
pub(crate) struct Design {
    pub method: Method,
    pub seed: u64,
    pub axes: Vec<Axis>,
    pub crossed: usize,
    /// Points of each combination of the crossed keys.
    pub samples: usize,
    /// Points of all combinations.
    pub whole: usize,
}

impl Sweep {
    /// A sweep with this design. Points that would be the same as others, because keys do not vary there, are left out.
    pub(crate) fn new(design: Design) -> Self {
        let Design { method, seed, axes, crossed, samples, whole } = design;
        let conditional = axes.iter().any(|axis| !axis.when.is_empty());
        let mut sweep = Self {
            method,
            seed,
            axes,
            crossed,
            points: whole,
            outputs: Vec::new(),
            time_limit: None,
            swept: None,
            samples,
            distinct: None,
        };
        if conditional {
            let distinct: Vec<usize> = (0..whole).filter(|k| sweep.is_first(*k)).collect();
            sweep.points = distinct.len();
            sweep.distinct = Some(distinct);
        }
        sweep
    }

    /// Whether no earlier point of the whole design has the same values.
    fn is_first(&self, place: usize) -> bool {
        let indices = self.indices(place);
        let varies = self.varying(place);
        let lists = indices.iter().zip(&varies).all(|(index, varies)| *varies || index.is_none_or(|i| i == 0));
        // Where no key of `vary` varies, one sample is enough.
        let sampled = !matches!(self.method, Method::Grid);
        lists && (!sampled || place.is_multiple_of(self.samples) || varies[self.crossed..].iter().any(|varies| *varies))
    }

    /// Index of the value of each key in its list, at a place of the whole design; `None`: it is not chosen by one.
    fn indices(&self, place: usize) -> Vec<Option<usize>> {
        let (mut combination, mut sample) = (place / self.samples, place % self.samples);
        let mut indices: Vec<Option<usize>> = Vec::with_capacity(self.axes.len());
        for (k, axis) in self.axes.iter().enumerate().rev() {
            let left = match (k < self.crossed, self.method) {
                (true, _) => &mut combination,
                (false, Method::Grid) => &mut sample,
                (false, Method::Zip | Method::Random | Method::LatinHypercube | Method::Sobol) => {
                    indices.push(None);
                    continue;
                }
            };
            let n = axis.range.count();
            indices.push(Some(*left % n));
            *left /= n;
        }
        indices.reverse();
        indices
    }

    /// The value of a key at a place of the whole design, whether it varies there or not.
    fn value(&self, k: usize, place: usize, index: Option<usize>) -> Value {
        let range = &self.axes[k].range;
        match (index, self.method, range) {
            (Some(i), _, Range::Values(values)) => values[i].clone(),
            (None, Method::Zip, Range::Values(values)) => values[place % self.samples].clone(),
            _ => range.quantile(self.coordinate(place % self.samples, k - self.crossed)),
        }
    }

    /// Whether each key varies at a place of the whole design.
    fn varying(&self, place: usize) -> Vec<bool> {
        let indices = self.indices(place);
        let holds = |condition: &Condition| {
            let value = self.value(condition.axis, place, indices[condition.axis]);
            condition.values.iter().any(|other| other.is(&value))
        };
        self.axes.iter().map(|axis| axis.when.iter().all(holds)).collect()
    }

    /// Place of a point in the whole design.
    fn place_of(&self, k: usize) -> usize {
        assert!(k < self.points, "the sweep has {} points", self.points);
        self.distinct.as_ref().map_or(k, |distinct| distinct[k])
    }

    /// The values of a point, by number from 0, in the order of the axes; `None` where a key does not vary.
    ///
    /// # Panics
    /// If `k` is not below the number of points.
    pub fn point(&self, k: usize) -> Vec<Option<Value>> {
        let place = self.place_of(k);
        let (indices, varying) = (self.indices(place), self.varying(place));
        (0..self.axes.len()).map(|k| varying[k].then(|| self.value(k, place, indices[k]))).collect()
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
                let slice = permuted(self.seed, axis, self.samples, k);
                (slice as f64 + random(self.seed, k, axis).f64()) / self.samples as f64
            }
            _ => random(self.seed, k, axis).f64(),
        };
        u.clamp(f64::EPSILON, 1.0 - f64::EPSILON)
    }

    /// Coordinates of a point among all points, one for each key, from 0 to 1: points with near coordinates have near
    /// values. The distance of two words is that of their places in the list.
    pub fn place(&self, k: usize) -> Vec<f64> {
        let listed = |i: usize, n: usize| i as f64 / (n.max(2) - 1) as f64;
        let place = self.place_of(k);
        let coordinate = |(axis, index): (usize, Option<usize>)| match (index, self.method) {
            (Some(i), _) => listed(i, self.axes[axis].range.count()),
            (None, Method::Zip) => listed(place % self.samples, self.samples),
            (None, _) => self.coordinate(place % self.samples, axis - self.crossed),
        };
        self.indices(place).into_iter().enumerate().map(coordinate).collect()
    }

    /// Settings of a point.
    pub fn settings(&self, k: usize) -> Vec<Setting> {
        let values = self.axes.iter().zip(self.point(k));
        values.filter_map(|(axis, value)| Some(Setting::new(&axis.key, value?.text))).collect()
    }

    /// Points to try before the work begins: the first, and the first at which each key with a condition varies.
    pub(crate) fn trials(&self) -> Vec<usize> {
        let mut trials = vec![0];
        for (axis, _) in self.axes.iter().enumerate().filter(|(_, axis)| !axis.when.is_empty()) {
            trials.extend((0..self.points).find(|k| self.varying(self.place_of(*k))[axis]));
        }
        trials.sort_unstable();
        trials.dedup();
        trials
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

/// Slice of point `k` of a Latin hypercube of `n` points: a keyed permutation of the numbers below `n`, so that any
/// point can be computed without the others. A Feistel network permutes the numbers below the next power of four; it is
/// applied until the number is below `n` (J. Black, P. Rogaway, "Ciphers with arbitrary finite domains", CT-RSA 2002).
fn permuted(seed: u64, axis: usize, n: usize, k: usize) -> usize {
    let half = (usize::BITS - n.saturating_sub(1).leading_zeros()).div_ceil(2);
    let mask = (1 << half) - 1;
    // The coordinates themselves have the keys from 0.
    let round =
        |round: u32, right: usize| random(seed, right + ((round as usize) << half), usize::MAX - axis).usize(..);
    let mut slice = k;
    loop {
        let (mut left, mut right) = (slice >> half, slice & mask);
        for r in 0..ROUNDS {
            (left, right) = (right, (left ^ round(r, right)) & mask);
        }
        slice = left << half | right;
        if slice < n {
            return slice;
        }
    }
}

/// Faults of the settings of a point, where the sweep names their keys.
pub(crate) fn placed(sweep: &Sweep, k: usize, text: &str, faults: Vec<Fault>) -> Vec<Fault> {
    let (own, set) = settings::apart(text, faults);
    let lines = settings::lines(&sweep.settings(k));
    let point = if k == 0 { "the first point".to_owned() } else { format!("point {k}") };
    let varying: Vec<&Axis> =
        sweep.axes.iter().zip(sweep.point(k)).filter_map(|(axis, value)| value.map(|_| axis)).collect();
    let place = |fault: Fault| {
        let line = fault.position(&lines).0 - 1;
        let span = varying.get(line).map_or(0..0, |axis| axis.span.clone());
        Fault { span, message: format!("at {point} of the sweep: {}", fault.message), help: fault.help }
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
            when: vec![],
            span: 0..0,
        };
        let axes = vec![axis("a"), axis("b")];
        Sweep::new(Design { method, seed: 7, axes, crossed: 0, samples: points, whole: points })
    }

    fn numbers(sweep: &Sweep) -> Vec<[f64; 2]> {
        (0..sweep.points).map(|k| [0, 1].map(|axis| sweep.point(k)[axis].as_ref().unwrap().number.unwrap())).collect()
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
    fn a_latin_hypercube_is_a_permutation_of_each_size_and_no_place_of_it_is_preferred() {
        for n in [1, 2, 3, 5, 16, 17, 100, 4096, 5000] {
            let mut slices: Vec<usize> = (0..n).map(|k| permuted(3, 1, n, k)).collect();
            slices.sort_unstable();
            assert!(slices.into_iter().eq(0..n), "{n}");
        }
        // Slice of the first of ten points over 10,000 seeds: each 1000 times, with a deviation of 30.
        let mut counts = [0_i32; 10];
        (0..10_000).for_each(|seed| counts[permuted(seed, 0, 10, 0)] += 1);
        assert!(counts.iter().all(|n| (n - 1000).abs() < 150), "{counts:?}");
        // A point among a thousand million takes no longer, and no memory.
        let far = uniform(Method::LatinHypercube, MAX_POINTS);
        assert!((0..2).all(|axis| (0.0..1.0).contains(&far.coordinate(MAX_POINTS - 1, axis))));
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

    /// `a` from a list of two words; `b` from a list of three numbers, only where `a` is "x"; `c` at random.
    fn models(method: Method) -> Sweep {
        let list = |texts: &[&str]| {
            Range::Values(texts.iter().map(|text| Value { text: (*text).into(), number: text.parse().ok() }).collect())
        };
        let axis = |key: &str, range: Range, when: Vec<Condition>| Axis { key: key.into(), range, when, span: 0..0 };
        let x = Condition { axis: 0, values: vec![Value { text: "\"x\"".into(), number: None }] };
        let words = axis("a", list(&["\"x\"", "\"y\""]), vec![]);
        let numbers = axis("b", list(&["1", "2", "3"]), vec![x]);
        let uniform = Range::Uniform { from: 0.0, to: 1.0, unit: String::new() };
        match method {
            Method::Grid => {
                let axes = vec![words, numbers];
                Sweep::new(Design { method, seed: 1, axes, crossed: 0, samples: 6, whole: 6 })
            }
            _ => {
                let axes = vec![words, numbers, axis("c", uniform, vec![])];
                Sweep::new(Design { method, seed: 1, axes, crossed: 2, samples: 10, whole: 60 })
            }
        }
    }

    fn words(sweep: &Sweep, k: usize) -> Vec<Option<String>> {
        sweep.point(k).into_iter().map(|value| value.map(|value| value.word().to_owned())).collect()
    }

    #[test]
    fn a_key_of_one_model_varies_with_that_model_only() {
        let sweep = models(Method::Grid);
        let some = |word: &str| Some(word.to_owned());
        let points: Vec<_> = (0..sweep.points).map(|k| words(&sweep, k)).collect();
        let expected =
            [[some("x"), some("1")], [some("x"), some("2")], [some("x"), some("3")], [some("y"), None]].map(Vec::from);
        assert_eq!(points, expected, "the other model is computed once");
        assert_eq!(sweep.settings(3), [Setting::new("a", "\"y\"")]);
        assert_eq!(sweep.trials(), [0]);
    }

    #[test]
    fn crossed_keys_have_the_same_samples() {
        let sweep = models(Method::LatinHypercube);
        assert_eq!(sweep.points, 40, "three values of b with x, one with y");
        let c = |k: usize| sweep.point(k)[2].as_ref().and_then(|value| value.number).unwrap();
        for k in 0..sweep.points {
            let expected = if k < 30 { vec!["x", ["1", "2", "3"][k / 10]] } else { vec!["y"] };
            let found: Vec<String> = words(&sweep, k)[..2].iter().flatten().cloned().collect();
            assert_eq!(found, expected, "point {k}");
            assert_eq!(c(k), c(k % 10), "point {k}");
        }
        let mut slices: Vec<usize> = (0..10).map(|k| (10.0 * c(k)) as usize).collect();
        slices.sort_unstable();
        assert!(slices.into_iter().eq(0..10), "one point a slice");
    }
}
