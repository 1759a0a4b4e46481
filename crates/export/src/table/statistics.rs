//! Statistics of a sweep: how many points pass, which requirements fail, and which keys drive them.
//!
//! # Yield
//!
//! The share of points that pass, p = passed / n. A point counts as passed only if its verdict is "pass": one that is
//! unresolved, or for which nothing was computed, does not. For a random sample the yield of all harnesses lies, with a
//! confidence of 95 %, in Wilson's score interval,
//!
//! ```text
//! (p + z²/2n ± z √(p (1 − p)/n + z²/4n²)) / (1 + z²/n),   z = 1.959964
//! ```
//!
//! (E. B. Wilson, "Probable inference, the law of succession, and statistical inference", J. Am. Stat. Assoc. 22, 1927,
//! pp. 209–212). It also holds where no point or every point passes. Points of a Latin hypercube and of Sobol's
//! sequence are spread more evenly than independent ones; for them the interval is mostly too wide. Points of a grid
//! are no sample: they have a share, but no interval.
//!
//! # Drivers
//!
//! The influence of a key on the worst value of a requirement is Spearman's rank correlation ρ, the linear correlation
//! of the ranks (C. Spearman, "The proof and measurement of association between two things", Am. J. Psychol. 15, 1904,
//! pp. 72–101; for sensitivity analysis A. Saltelli et al., "Global Sensitivity Analysis", 2008, chapter 1). It is ±1
//! where the value rises or falls with the key throughout. Equal values share their mean rank; an infinite one (the
//! bend radius of a straight cable) has the last. Where keys are crossed, ranks are those within each combination, so
//! that only the sampled key counts. A correlation of less than 2/√(n − 1) is not told from chance. Samples of keys are
//! correlated by chance, too: beside stronger drivers a key counts only if its partial rank correlation is told from
//! chance as well. Here n is the number of samples: combinations share them, and more combinations do not make more of
//! them.
//!
//! # Results
//!
//! Results of points that did not converge are those of no equilibrium. They are in the table, but in no minimum, mean,
//! quantile, plot or correlation. Between two values a quantile is interpolated (type 7 of R. J. Hyndman and Y. Fan,
//! "Sample quantiles in statistical packages", Am. Stat. 50, 1996, pp. 361–365).

use super::Table;
use nalgebra::DVector;
use std::collections::BTreeMap;
use wireloom_core::Status;
use wireloom_core::requirement::{Measure, Verdict};

/// Note of the table: word of the method that chose the points.
pub const METHOD: &str = "wireloom.method";
/// Note of the table: the keys that are crossed, one a line.
pub const CROSSED: &str = "wireloom.crossed";
/// Note of the table: a line for each requirement: word of its measure, tab, name.
pub const REQUIREMENTS: &str = "wireloom.requirements";

/// The text of the note [`REQUIREMENTS`].
pub fn requirement_lines(requirements: &[(String, Measure)]) -> String {
    let lines: Vec<String> = requirements.iter().map(|(name, measure)| format!("{}\t{name}", measure.word())).collect();
    lines.join("\n")
}

/// Note of the table: name of the scenario's file.
pub const FILE: &str = "wireloom.file";

/// Quantile of the normal distribution for a confidence of 95 %.
const Z: f64 = 1.959_963_984_540_054;
/// What is left of ranks beside those of other keys, as a fraction of them, that is as good as nothing.
const LEFT: f64 = 0.05;

/// Points and how they end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Number of points by status, the most frequent first.
    pub statuses: Vec<(String, usize)>,
    /// Verdicts of all points.
    pub yields: Yield,
    /// Verdicts of each combination of the crossed keys; empty where none is crossed.
    pub combinations: Vec<(String, Yield)>,
    /// Whether the points are a random sample.
    pub sampled: bool,
    /// Requirements, the one that fails most first.
    pub requirements: Vec<Requirement>,
    /// Point that fails most, or is nearest to failing.
    pub worst: Option<usize>,
}

/// Verdicts of some points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Yield {
    /// Points that pass.
    pub passed: usize,
    /// Points that fail.
    pub failed: usize,
    /// Points whose verdict is unresolved.
    pub unresolved: usize,
    /// Points without a result.
    pub without: usize,
    /// Points whose status is not "converged", whatever their verdict.
    pub not_converged: usize,
}

/// A requirement over all points.
#[derive(Clone, Debug, PartialEq)]
pub struct Requirement {
    /// Name.
    pub name: String,
    /// What it limits.
    pub measure: Measure,
    /// Points at which it fails.
    pub fails: usize,
    /// Points at which it is unresolved.
    pub unresolved: usize,
    /// The point with the worst verdict, and of those the least margin.
    pub worst: Option<Worst>,
    /// Keys that drive it, the strongest first.
    pub drivers: Vec<Driver>,
}

/// The worst value of a requirement over all points.
#[derive(Clone, Debug, PartialEq)]
pub struct Worst {
    /// Point.
    pub point: usize,
    /// Value; infinite: a straight cable; not a number: the table has none.
    pub value: f64,
    /// Margin, relative to the limit.
    pub margin: Option<f64>,
    /// Step.
    pub step: String,
    /// Place.
    pub place: String,
}

/// Influence of a key.
#[derive(Clone, Debug, PartialEq)]
pub struct Driver {
    /// The key.
    pub key: String,
    /// Rank correlation with the worst value.
    pub correlation: f64,
}

impl Yield {
    /// Number of points.
    pub fn points(&self) -> usize {
        self.passed + self.failed + self.unresolved + self.without
    }

    /// Share of points that pass.
    pub fn share(&self) -> f64 {
        self.passed as f64 / self.points().max(1) as f64
    }

    /// Wilson's interval of the yield with a confidence of 95 %.
    pub fn interval(&self) -> (f64, f64) {
        wilson(self.passed, self.points())
    }

    fn count(&mut self, verdict: Option<&str>, status: Option<&str>) {
        *match known(verdict) {
            Some(Verdict::Pass) => &mut self.passed,
            Some(Verdict::Fail) => &mut self.failed,
            Some(Verdict::Unresolved | Verdict::NotChecked) => &mut self.unresolved,
            None => &mut self.without,
        } += 1;
        self.not_converged += usize::from(status != Some(Status::Converged.word()));
    }
}

/// Wilson's interval with a confidence of 95 % of a probability, of which `passed` of `n` trials are known.
pub fn wilson(passed: usize, n: usize) -> (f64, f64) {
    if n == 0 {
        return (0.0, 1.0);
    }
    let (n, z2) = (n as f64, Z * Z);
    let p = passed as f64 / n;
    let middle = p + z2 / (2.0 * n);
    let half = Z * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    let end = |x: f64| (x / (1.0 + z2 / n)).clamp(0.0, 1.0);
    (end(middle - half), end(middle + half))
}

/// Columns of a table that [`summary`] needs.
pub fn is_needed(column: &str) -> bool {
    let parts = ["verdict.", "worst.", "margin.", "step.", "where."];
    matches!(column, "point" | "status" | "verdict" | "margin") || parts.iter().any(|part| column.starts_with(part))
}

/// Names of the keys that vary: the columns between the number of a point and its status.
pub fn keys(table: &Table) -> Vec<&str> {
    table.columns.iter().map(|(name, _)| name.as_str()).skip(1).take_while(|name| *name != "status").collect()
}

/// Summary of the table of a sweep.
pub fn summary(table: &Table) -> Summary {
    let (statuses, verdicts) = (table.words("status"), table.words("verdict"));
    let verdict = |row: usize| verdicts.get(row).and_then(|verdict| verdict.as_deref());
    let mut found = Summary { sampled: is_sample(table), ..Summary::default() };
    for (row, status) in statuses.iter().enumerate() {
        let status = status.as_deref().unwrap_or("unknown");
        found.yields.count(verdict(row), Some(status));
        match found.statuses.iter_mut().find(|(known, _)| known == status) {
            Some((_, n)) => *n += 1,
            None => found.statuses.push((status.to_owned(), 1)),
        }
    }
    found.statuses.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    let groups = combinations(table);
    if groups.len() > 1 {
        for (name, rows) in &groups {
            let mut yields = Yield::default();
            rows.iter().for_each(|row| yields.count(verdict(*row), statuses[*row].as_deref()));
            found.combinations.push((name.clone(), yields));
        }
    }
    let groups: Vec<Vec<usize>> = groups.into_iter().map(|(_, rows)| rows).collect();
    found.requirements = measures(table).map(|(measure, name)| requirement(table, name, measure, &groups)).collect();
    let margins = table.numbers("margin");
    let margin = |one: &Requirement| margin_or_worst(one.worst.as_ref().and_then(|worst| worst.margin), one.fails > 0);
    found.requirements.sort_by(|a, b| {
        let more = |of: fn(&Requirement) -> usize| of(b).cmp(&of(a));
        more(|one| one.fails).then(more(|one| one.unresolved)).then(margin(a).total_cmp(&margin(b)))
    });
    found.worst = most_urgent((0..table.rows()).filter_map(|row| Some((row, known(verdict(row))?))), margins);
    found
}

/// The row that fails most, or is nearest to failing: the worst verdict, then the least margin.
fn most_urgent(rows: impl Iterator<Item = (usize, Verdict)>, margins: &[Option<f64>]) -> Option<usize> {
    let margin = |row: usize, verdict| margin_or_worst(margins.get(row).copied().flatten(), verdict == Verdict::Fail);
    let order = |row: usize, verdict: Verdict| (verdict, margin(row, verdict));
    let rows = rows.map(|(row, verdict)| (row, order(row, verdict)));
    rows.min_by(|(_, a), (_, b)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|(row, _)| row)
}

/// A margin to sort by. Where there is none (a limit of 0, or a value that is no number) what fails fails most, and
/// what does not comes last.
fn margin_or_worst(margin: Option<f64>, fails: bool) -> f64 {
    let without = if fails { f64::NEG_INFINITY } else { f64::INFINITY };
    margin.filter(|margin| !margin.is_nan()).unwrap_or(without)
}

/// The verdict of a word.
fn known(word: Option<&str>) -> Option<Verdict> {
    Verdict::ALL.into_iter().find(|known| Some(known.word()) == word)
}

/// Numbers of a column, of points that converged only.
pub fn converged_numbers(table: &Table, column: &str) -> Vec<Option<f64>> {
    let statuses = table.words("status");
    let converged = |row: usize| statuses.get(row).is_some_and(|own| own.as_deref() == Some(Status::Converged.word()));
    table.numbers(column).iter().enumerate().map(|(row, number)| number.filter(|_| converged(row))).collect()
}

/// Quantile of sorted values, from 0 (least) to 1 (greatest); NaN where there are none.
pub fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = fraction.clamp(0.0, 1.0) * last as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    // Values may be infinite.
    if below == above || below == f64::NEG_INFINITY { below } else { below + (above - below) * place.fract() }
}

/// Measures and names of the requirements of a table.
pub fn measures(table: &Table) -> impl Iterator<Item = (Measure, &str)> {
    table.note(REQUIREMENTS).unwrap_or_default().lines().filter_map(|line| {
        let (word, name) = line.split_once('\t')?;
        Some((Measure::ALL.into_iter().find(|measure| measure.word() == word)?, name))
    })
}

/// Whether the points were chosen at random.
fn is_sample(table: &Table) -> bool {
    table.note(METHOD).is_some_and(|method| !matches!(method, "grid" | "zip"))
}

/// Rows of each combination of the crossed keys, with its name, in their order.
fn combinations(table: &Table) -> Vec<(String, Vec<usize>)> {
    let crossed: Vec<&str> = table.note(CROSSED).unwrap_or_default().lines().collect();
    let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    for row in 0..table.rows() {
        let value = |key: &&str| {
            let number = table.numbers(key).get(row).copied().flatten().map(|x| x.to_string());
            let word = number.or_else(|| table.words(key).get(row).cloned().flatten());
            word.map(|word| format!("{key} = {word}"))
        };
        let name = crossed.iter().filter_map(value).collect::<Vec<_>>().join(", ");
        let group = *known.entry(name.clone()).or_insert_with(|| {
            groups.push((name, Vec::new()));
            groups.len() - 1
        });
        groups[group].1.push(row);
    }
    groups
}

fn requirement(table: &Table, name: &str, measure: Measure, groups: &[Vec<usize>]) -> Requirement {
    let words = |what: &str| table.words(&format!("{what}.{name}"));
    let verdicts = words("verdict");
    let count = |of: Verdict| verdicts.iter().flatten().filter(|verdict| *verdict == of.word()).count();
    let (values, margins) = (table.numbers(&format!("worst.{name}")), table.numbers(&format!("margin.{name}")));
    let value = |row: usize| values.get(row).copied().flatten();
    // What was not checked has no value.
    let checked = |row: usize| Some((row, known(verdicts[row].as_deref())?));
    let checked = (0..verdicts.len()).filter_map(checked).filter(|(_, verdict)| *verdict != Verdict::NotChecked);
    let worst =
        most_urgent(checked.filter(|(row, verdict)| *verdict == Verdict::Fail || value(*row).is_some()), margins);
    let text = |what: &str, row: usize| words(what).get(row).cloned().flatten().unwrap_or_default();
    Requirement {
        name: name.to_owned(),
        measure,
        fails: count(Verdict::Fail),
        unresolved: count(Verdict::Unresolved),
        worst: worst.map(|row| Worst {
            point: row,
            value: value(row).unwrap_or(f64::NAN),
            margin: margins.get(row).copied().flatten(),
            step: text("step", row),
            place: text("where", row),
        }),
        drivers: drivers(table, &converged_numbers(table, &format!("worst.{name}")), groups),
    }
}

/// A key that may drive values.
struct Candidate<'t> {
    key: &'t str,
    correlation: f64,
    /// Number of samples.
    samples: usize,
    /// Ranks of the key and of the values in each row, about their means; zero where one of the two is missing.
    ranks: [DVector<f64>; 2],
}

impl<'t> Candidate<'t> {
    fn of(table: &'t Table, key: &'t str, values: &[Option<f64>], groups: &[Vec<usize>]) -> Option<Self> {
        let numbers = table.numbers(key);
        let pair = |row: usize| {
            let pair = ((*numbers.get(row)?)?, (*values.get(row)?)?);
            (pair.0.is_finite() && !pair.1.is_nan()).then_some(pair)
        };
        let mut ranks = [DVector::zeros(table.rows()), DVector::zeros(table.rows())];
        let mut samples = 0;
        let mut pairs = Vec::new();
        for rows in groups {
            let rows: Vec<usize> = rows.iter().copied().filter(|row| pair(*row).is_some()).collect();
            let own: Vec<(f64, f64)> = rows.iter().filter_map(|row| pair(*row)).collect();
            let of = [|pair: &(f64, f64)| pair.0, |pair: &(f64, f64)| pair.1];
            for (ranks, of) in ranks.iter_mut().zip(of) {
                let ranked = centred_ranks(&own.iter().map(of).collect::<Vec<_>>());
                rows.iter().zip(ranked).for_each(|(row, rank)| ranks[*row] = rank);
            }
            samples = samples.max(own.len());
            pairs.push(own);
        }
        Some(Self { key, correlation: rank_correlation(&pairs)?, samples, ranks })
    }

    /// Partial correlation with the values beside keys of these ranks, which are orthogonal; `None` where nothing is
    /// left to explain, or to explain it with.
    fn beside(&self, known: &[DVector<f64>]) -> Option<f64> {
        let [x, y] = self.ranks.each_ref().map(|ranks| {
            let left = beside(ranks, known);
            (left.norm() > LEFT * ranks.norm()).then_some(left)
        });
        let (x, y) = (x?, y?);
        Some(x.dot(&y) / (x.norm() * y.norm()))
    }

    /// Whether such a correlation beside so many other keys is told from chance.
    fn is_told(&self, correlation: f64, others: usize) -> bool {
        self.samples > others + 2 && correlation.abs() > 2.0 / ((self.samples - 1 - others) as f64).sqrt()
    }
}

/// What is left of ranks beside those of other keys, which are orthogonal.
fn beside(ranks: &DVector<f64>, known: &[DVector<f64>]) -> DVector<f64> {
    known.iter().fold(ranks.clone(), |left, own| &left - own * (own.dot(&left) / own.norm_squared()))
}

/// Keys whose rank correlation with these values is told from chance, also beside stronger ones; the strongest first.
fn drivers(table: &Table, values: &[Option<f64>], groups: &[Vec<usize>]) -> Vec<Driver> {
    let candidates = keys(table).into_iter().filter_map(|key| Candidate::of(table, key, values, groups));
    let mut candidates: Vec<Candidate<'_>> = candidates.filter(|own| own.is_told(own.correlation, 0)).collect();
    candidates.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    let (mut drivers, mut known) = (Vec::new(), Vec::<DVector<f64>>::new());
    for own in candidates {
        if own.beside(&known).is_some_and(|partial| own.is_told(partial, known.len())) {
            let [ranks, _] = &own.ranks;
            known.push(beside(ranks, &known));
            drivers.push(Driver { key: own.key.to_owned(), correlation: own.correlation });
        }
    }
    drivers
}

/// Spearman's rank correlation of pairs, with ranks within each group; `None` where one of the two does not vary.
pub fn rank_correlation(groups: &[Vec<(f64, f64)>]) -> Option<f64> {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for pairs in groups {
        // Ranks relative to the size of the group, about their mean.
        let ranks = |of: fn(&(f64, f64)) -> f64| centred_ranks(&pairs.iter().map(of).collect::<Vec<_>>());
        for (x, y) in ranks(|pair| pair.0).into_iter().zip(ranks(|pair| pair.1)) {
            (xx, xy, yy) = (xx + x * x, xy + x * y, yy + y * y);
        }
    }
    (xx > 0.0 && yy > 0.0).then(|| (xy / (xx * yy).sqrt()).clamp(-1.0, 1.0))
}

/// Ranks from −½ to ½; equal values share their mean rank.
fn centred_ranks(values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; n];
    let mut first = 0;
    while first < n {
        let same = order[first..].iter().take_while(|k| values[**k] == values[order[first]]).count();
        let rank = first as f64 + 0.5 * (same - 1) as f64;
        for k in &order[first..first + same] {
            ranks[*k] = (rank - 0.5 * (n - 1) as f64) / n as f64;
        }
        first += same;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::super::Column;
    use super::*;

    /// R: `binom::binom.wilson(c(0, 7, 15, 20), 20)`, and Newcombe (1998), table I: 81 of 263.
    #[test]
    fn wilsons_interval_is_that_of_the_tables() {
        for (passed, n, low, high) in
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
        {
            let (a, b) = wilson(passed, n);
            assert!((a - low).abs() < 5e-5 && (b - high).abs() < 5e-5, "{passed} of {n}: {a} to {b}");
        }
        assert_eq!(wilson(0, 0), (0.0, 1.0));
    }

    /// Spearman by its formula 1 − 6 Σd²/(n (n² − 1)) for ranks without ties; with ties by hand.
    #[test]
    fn rank_correlation_is_spearmans() {
        let pairs = [(106.0, 7.0), (86.0, 0.0), (100.0, 27.0), (101.0, 50.0), (99.0, 28.0), (103.0, 29.0)];
        let pairs: Vec<(f64, f64)> =
            pairs.into_iter().chain([(97.0, 20.0), (113.0, 12.0), (112.0, 6.0), (110.0, 17.0)]).collect();
        let found = rank_correlation(std::slice::from_ref(&pairs)).unwrap();
        // Σd² = 194.
        assert!((found - (1.0 - 6.0 * 194.0 / 990.0)).abs() < 1e-12, "{found}");
        let ties = vec![(1.0, 1.0), (1.0, 2.0), (2.0, 3.0)];
        // Ranks −½, −½, 1 and −1, 0, 1.
        assert!((rank_correlation(&[ties]).unwrap() - 1.5 / (1.5_f64 * 2.0).sqrt()).abs() < 1e-12);
        assert_eq!(rank_correlation(&[vec![(1.0, 2.0), (1.0, 3.0)]]), None);
        // Two combinations at different levels, each falling: together they would seem to rise.
        let fall = |at: f64| (0..5).map(|k| (at + f64::from(k), 10.0 * at - f64::from(k))).collect::<Vec<_>>();
        assert_eq!(rank_correlation(&[fall(0.0), fall(10.0)]), Some(-1.0));
    }

    #[test]
    fn the_median_of_two_values_lies_between_them() {
        assert_eq!(quantile(&[1.0, 2.0], 0.5), 1.5);
        assert_eq!(quantile(&[1.0, 2.0, 4.0, 8.0], 0.5), 3.0);
        // R: quantile(c(1, 2, 4, 8), c(0.05, 0.95)).
        assert!((quantile(&[1.0, 2.0, 4.0, 8.0], 0.05) - 1.15).abs() < 1e-12);
        assert!((quantile(&[1.0, 2.0, 4.0, 8.0], 0.95) - 7.4).abs() < 1e-12);
        let ends = [0.0, 1.0].map(|fraction| quantile(&[1.0, f64::INFINITY, f64::INFINITY], fraction));
        assert_eq!(ends, [1.0, f64::INFINITY]);
    }

    /// A table of points with these keys, and the requirement "pull" with these values.
    fn pulled(crossed: &str, columns: Vec<(&str, Vec<f64>)>, pull: Vec<f64>, status: Vec<&str>) -> Table {
        let rows = pull.len();
        let of = |all: Vec<f64>| Column::Numbers(all.into_iter().map(Some).collect());
        let words = |all: Vec<&str>| Column::Words(all.into_iter().map(|word| Some(word.to_owned())).collect());
        let mut all = vec![("point".to_owned(), Column::Counts((0..rows as i64).map(Some).collect()))];
        all.extend(columns.into_iter().map(|(key, values)| (key.to_owned(), of(values))));
        all.push(("status".to_owned(), words(status)));
        all.push(("verdict".to_owned(), words(vec!["pass"; rows])));
        all.push(("verdict.pull".to_owned(), words(vec!["pass"; rows])));
        all.push(("worst.pull".to_owned(), of(pull)));
        let notes = [(METHOD, "random"), (CROSSED, crossed), (REQUIREMENTS, "force\tpull")];
        Table { columns: all, notes: notes.map(|(key, text)| (key.to_owned(), text.to_owned())).to_vec() }
    }

    /// Sixteen samples, each with ten values of a crossed key: a key that the value does not depend on is correlated
    /// with it by chance, as much as sixteen samples may be.
    #[test]
    fn samples_that_are_crossed_are_no_further_samples() {
        let pull: Vec<f64> = (0..16).map(f64::from).collect();
        let key = [3.0, 9.0, 1.0, 12.0, 7.0, 0.0, 14.0, 5.0, 10.0, 2.0, 15.0, 8.0, 4.0, 13.0, 6.0, 11.0];
        let times = |all: &[f64]| (0..10).flat_map(|_| all.to_vec()).collect::<Vec<f64>>();
        let crossed = (0..160).map(|k| f64::from(k / 16)).collect();
        let columns = vec![("key", times(&key)), ("crossed", crossed)];
        let table = pulled("crossed", columns, times(&pull), vec!["converged"; 160]);
        let rho = rank_correlation(&[pull.into_iter().zip(key).collect()]).unwrap();
        assert!(rho > 2.0 / 159.0_f64.sqrt() && rho < 2.0 / 15.0_f64.sqrt(), "{rho}");
        assert_eq!(summary(&table).requirements[0].drivers, []);
    }

    /// Two keys whose samples are correlated by chance: the value depends on one of them.
    #[test]
    fn a_key_is_no_driver_because_its_samples_are_like_those_of_one() {
        let first: Vec<f64> = (0..16).map(f64::from).collect();
        let second: Vec<f64> = (0..16).map(|k| f64::from(if k % 9 == 0 { 9 - k } else { k })).collect();
        let table = pulled(
            "",
            vec![("first", first.clone()), ("second", second.clone())],
            first.clone(),
            vec!["converged"; 16],
        );
        let rho = rank_correlation(&[first.iter().copied().zip(second.clone()).collect()]).unwrap();
        assert!(rho > 2.0 / 15.0_f64.sqrt(), "{rho}");
        let drivers = |table: &Table| {
            let found = summary(table).requirements.remove(0).drivers;
            found.into_iter().map(|own| own.key).collect::<Vec<_>>()
        };
        assert_eq!(drivers(&table), ["first"]);
        // Where it depends on both, both are.
        let both: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a + b).collect();
        let table = pulled("", vec![("first", first), ("second", second)], both, vec!["converged"; 16]);
        assert_eq!(drivers(&table).len(), 2, "{:?}", drivers(&table));
    }

    #[test]
    fn points_that_did_not_converge_are_in_no_statistics() {
        let status = (0..20).map(|k| if k < 16 { "converged" } else { "stalled" }).collect();
        let first: Vec<f64> = (0..20).map(f64::from).collect();
        // Only those that did not converge depend on the key.
        let pull = (0..20).map(|k| if k < 16 { f64::from(k % 2) } else { 1e6 }).collect();
        let table = pulled("", vec![("first", first)], pull, status);
        let numbers: Vec<f64> = converged_numbers(&table, "worst.pull").into_iter().flatten().collect();
        assert_eq!((numbers.len(), numbers.iter().sum::<f64>()), (16, 8.0));
        assert!(summary(&table).requirements[0].drivers.is_empty());
    }

    #[test]
    fn what_was_not_computed_does_not_pass() {
        let words = |words: &[Option<&str>]| Column::Words(words.iter().map(|w| w.map(str::to_owned)).collect());
        let numbers = |numbers: &[Option<f64>]| Column::Numbers(numbers.to_vec());
        let (pass, fail) = (Some("pass"), Some("fail"));
        let table = Table {
            columns: vec![
                ("point".into(), Column::Counts((0..5).map(Some).collect())),
                ("length".into(), numbers(&[1.0, 2.0, 3.0, 4.0, 5.0].map(Some))),
                (
                    "status".into(),
                    words(&[Some("converged"), Some("converged"), Some("refused"), Some("converged"), Some("failed")]),
                ),
                ("verdict".into(), words(&[pass, fail, None, fail, Some("unresolved")])),
                ("margin".into(), numbers(&[Some(0.5), Some(-0.1), None, Some(-0.4), Some(0.1)])),
                ("verdict.bend".into(), words(&[pass, fail, None, fail, pass])),
                ("worst.bend".into(), numbers(&[Some(0.05), Some(0.04), None, Some(0.03), Some(0.02)])),
                ("margin.bend".into(), numbers(&[Some(0.5), Some(-0.1), None, Some(-0.4), Some(0.1)])),
                ("where.bend".into(), words(&[None, None, None, Some("branch `loop`"), None])),
            ],
            notes: vec![(METHOD.into(), "random".into()), (REQUIREMENTS.into(), "bend_radius\tbend".into())],
        };
        let found = summary(&table);
        let expected = Yield { passed: 1, failed: 2, unresolved: 1, without: 1, not_converged: 2 };
        assert_eq!((found.yields, found.yields.points(), found.sampled), (expected, 5, true));
        assert_eq!(found.worst, Some(3));
        let bend = &found.requirements[0];
        assert_eq!((bend.fails, bend.unresolved), (2, 0));
        let worst = bend.worst.as_ref().unwrap();
        assert_eq!((worst.point, worst.value, worst.place.as_str()), (3, 0.03, "branch `loop`"));
        // Four points, falling throughout, but a correlation below 2/√3 is not told from chance.
        assert!(bend.drivers.is_empty());
    }

    /// A straight cable under a greatest bend radius, one without a value, and one with a limit of 0.
    #[test]
    fn a_failure_without_a_finite_margin_is_worse_than_what_passes() {
        let words = |words: &[&str]| Column::Words(words.iter().map(|word| Some((*word).to_owned())).collect());
        let of = |values: [Option<f64>; 4], margins: [Option<f64>; 4]| {
            let verdicts = words(&["pass", "pass", "fail", "unresolved"]);
            let table = Table {
                columns: vec![
                    ("point".into(), Column::Counts((0..4).map(Some).collect())),
                    ("length".into(), Column::Numbers([1.0, 2.0, 4.0, 3.0].map(Some).to_vec())),
                    ("status".into(), words(&["converged"; 4])),
                    ("verdict".into(), verdicts.clone()),
                    ("margin".into(), Column::Numbers(margins.to_vec())),
                    ("verdict.bend".into(), verdicts),
                    ("worst.bend".into(), Column::Numbers(values.to_vec())),
                    ("margin.bend".into(), Column::Numbers(margins.to_vec())),
                ],
                notes: vec![(METHOD.into(), "random".into()), (REQUIREMENTS.into(), "bend_radius\tbend".into())],
            };
            let found = summary(&table);
            let bend = found.requirements[0].clone();
            assert_eq!((found.yields.failed, found.worst, bend.fails), (1, Some(2), 1));
            bend.worst.expect("a worst value")
        };
        let (values, margins) = ([Some(0.4), Some(0.5), None, Some(0.8)], [Some(0.2), Some(0.01), None, Some(0.0)]);
        let straight = [Some(f64::INFINITY), Some(f64::NEG_INFINITY)];
        for [value, margin] in [straight, [Some(f64::INFINITY), Some(f64::NAN)], [Some(3.0), None], [None, None]] {
            let with = |mut all: [Option<f64>; 4], one| {
                all[2] = one;
                all
            };
            let worst = of(with(values, value), with(margins, margin));
            assert_eq!((worst.point, worst.value.to_bits()), (2, value.unwrap_or(f64::NAN).to_bits()));
        }
    }

    /// Six values rise with the length; without the infinite one five are too few to tell.
    #[test]
    fn an_infinite_value_has_the_last_rank() {
        let numbers = |numbers: [f64; 6]| Column::Numbers(numbers.map(Some).to_vec());
        let radii = [0.1, 0.2, 0.3, 0.4, 0.5, f64::INFINITY];
        let table = Table {
            columns: vec![
                ("point".into(), Column::Counts((0..6).map(Some).collect())),
                ("length".into(), numbers([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
                ("status".into(), Column::Words(vec![Some("converged".into()); 6])),
                ("worst.bend".into(), numbers(radii)),
            ],
            notes: Vec::new(),
        };
        let found = drivers(&table, table.numbers("worst.bend"), &[(0..6).collect()]);
        assert_eq!(found, [Driver { key: "length".into(), correlation: 1.0 }]);
    }
}
