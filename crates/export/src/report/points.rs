//! Page of `wireloom report`: a sweep with the verdicts of its points, the region that fails, the requirements with
//! their drivers, the status of points, distributions of results, responses to each key, and the influence of keys.

use super::layout::{fixed, heading};
use super::plots::Mark;
use super::{plots, style};
use crate::sheet;
use crate::table::statistics::{Requirement, Summary, Yield, converged_numbers, keys, measures, quantile, summary};
use crate::table::{Column, Table};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use std::io::{self, Write};

/// Content of the page. The writer looks at neither clock nor machine: the caller states both.
#[derive(Clone, Debug, PartialEq)]
pub struct Points<'a> {
    /// Headline.
    pub title: &'a str,
    /// The table of the sweep.
    pub table: &'a Table,
    /// Name of the scenario's file in commands that the page shows.
    pub file: &'a str,
    /// Program and version.
    pub program: &'a str,
    /// Day and time.
    pub written: &'a str,
}

/// Largest number of points in a plot; of more, every n-th is drawn.
const DRAWN: usize = 1500;
/// Results whose sections are open at first: those of the whole harness.
const WHOLE: [(&str, &str); 3] = [("min_bend_radius", "m"), ("max_force", "N"), ("energy.total", "J")];
/// Results of parts, and outputs of the sweep, by prefixes of their names.
const PARTS: [(&str, &str); 13] = [
    ("worst.", ""),
    ("angle.", "rad"),
    ("clearance.", "m"),
    ("contact_force.", "N"),
    ("min_bend_radius.", "m"),
    ("max_force.", "N"),
    ("position_x.", "m"),
    ("position_y.", "m"),
    ("position_z.", "m"),
    ("tension.", "N"),
    ("slack.", "m"),
    ("bend_radius.", "m"),
    ("force.", "N"),
];
/// Largest number of them with a section.
const MORE: usize = 40;

/// Writes the page.
///
/// # Errors
/// Those of `out`.
pub fn write_points(points: &Points<'_>, out: &mut impl Write) -> io::Result<()> {
    out.write_all(page(points).into_string().as_bytes())
}

/// Numbers of a column, by row.
struct Series<'a> {
    name: &'a str,
    unit: &'static str,
    entries: Cow<'a, [Option<f64>]>,
    /// Smallest and largest finite number.
    range: (f64, f64),
}

impl<'a> Series<'a> {
    fn of(table: &'a Table, name: &'a str, unit: &'static str) -> Option<Self> {
        let Some(Column::Numbers(entries)) = table.column(name) else { return None };
        Some(Self::new(name, unit, entries))
    }

    /// A result, of points that converged only.
    fn of_result(table: &'a Table, name: &'a str, unit: &'static str) -> Option<Self> {
        table.column(name).filter(|column| matches!(column, Column::Numbers(_)))?;
        Some(Self::new(name, unit, converged_numbers(table, name)))
    }

    fn new(name: &'a str, unit: &'static str, entries: impl Into<Cow<'a, [Option<f64>]>>) -> Self {
        let entries = entries.into();
        let mut series = Self { name, unit, entries, range: (f64::INFINITY, f64::NEG_INFINITY) };
        series.range = series.finite().fold(series.range, |(a, b), x| (a.min(x), b.max(x)));
        series
    }

    fn finite(&self) -> impl Iterator<Item = f64> + '_ {
        self.entries.iter().flatten().copied().filter(|x| x.is_finite())
    }

    fn varies(&self) -> bool {
        let (low, high) = self.range;
        high > low
    }
}

fn page(points: &Points<'_>) -> Markup {
    let table = points.table;
    let found = summary(table);
    let keys = keys(table);
    let numeric: Vec<Series> =
        keys.iter().filter_map(|key| Series::of(table, key, "")).filter(Series::varies).collect();
    let results = results(table);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (points.title) }
                style { (PreEscaped(style::SHEET)) }
            }
            body {
                header {
                    h1 { (points.title) ": " (table.rows()) " points" }
                    p { (points.program) " · " (points.written) }
                }
                (verdicts(&found, points.file))
                (region(table, &found))
                (requirements(&found))
                (statuses(table, &found))
                (distributions(&results, found.yields.not_converged))
                @for (k, result) in results.iter().enumerate() {
                    section {
                        details open[k < WHOLE.len()] {
                            summary { (result.name) " [" (result.unit) "]" }
                            (tornado(&numeric, result))
                            div class="plots" {
                                figure {
                                    (PreEscaped(plots::histogram(&result.finite().collect::<Vec<_>>())))
                                    figcaption { "number of points by " (result.name) " [" (result.unit) "]" }
                                }
                                @for key in &numeric { (response(key, result, keys.len() == 1)) }
                            }
                        }
                    }
                }
                @for (key, text) in &table.notes { @if key == "wireloom.text" {
                    section id="scenario" { h2 { "Scenario" } details { summary { "text" } pre { (text) } } }
                } }
                script { (PreEscaped(style::UNFOLD)) }
            }
        }
    }
}

/// Results that differ from point to point: those of the whole harness, then outputs of the sweep and those of parts.
fn results(table: &Table) -> Vec<Series<'_>> {
    let whole = WHOLE.iter().filter_map(|(name, unit)| Series::of_result(table, name, unit));
    let keys = keys(table);
    let named = |start: &str| -> Vec<&str> {
        let names = table.columns.iter().map(|(name, _)| name.as_str());
        names.filter(|name| name.starts_with(start) && !keys.contains(name)).collect()
    };
    let parts = PARTS.iter().flat_map(|(start, unit)| named(start).into_iter().map(move |name| (name, *unit)));
    let units = |name: &str| {
        let (measure, _) = measures(table).find(|(_, line)| name.strip_prefix("worst.") == Some(*line))?;
        Some(measure.unit())
    };
    let parts = parts.filter_map(|(name, unit)| Series::of_result(table, name, units(name).unwrap_or(unit)));
    whole.chain(parts.take(MORE)).filter(Series::varies).collect()
}

/// What passes and what fails, and the worst point.
fn verdicts(found: &Summary, file: &str) -> Markup {
    let Yield { passed, failed, unresolved, without, not_converged } = found.yields;
    html! {
        section id="verdicts" {
            h2 { "Verdict" }
            @if found.requirements.is_empty() {
                p { "No requirements: nothing was checked. " (not_converged) " not converged." }
            } @else {
                p class=(if passed == found.yields.points() { "good" } else { "bad" }) {
                    strong {
                        (passed) " pass, " (failed) " fail, " (unresolved) " unresolved"
                        @if without > 0 { ", " (without) " without a result" }
                    }
                    " · " (not_converged) " not converged"
                }
                // Combinations share their samples: together they are no random sample.
                p { (share(&found.yields, found.sampled && found.combinations.is_empty())) }
                @if !found.combinations.is_empty() {
                    table {
                        (heading(&["combination", ">pass", ">fail", ">unresolved", ">without a result", "yield"]))
                        tbody { @for (name, yields) in &found.combinations { tr {
                            td { (name) }
                            @for n in [yields.passed, yields.failed, yields.unresolved, yields.without] {
                                td class="n" { (n) }
                            }
                            td { (share(yields, found.sampled)) }
                        } } }
                    }
                }
                @if let Some(k) = found.worst {
                    p {
                        @let words = if failed + unresolved > 0 { "worst point" } else { "point nearest to failing" };
                        a href="#requirements" { "The " (words) ", " (k) ", and all requirements" }
                        ". To see it: " code { "wireloom run " (file) " --point " (k) " --report" }
                    }
                }
            }
        }
    }
}

/// "62.0 % of the points pass", with the interval of a sample.
fn share(yields: &Yield, sampled: bool) -> String {
    let percent = |share: f64| format!("{} %", fixed(100.0 * share, 1));
    let share = percent(yields.share());
    if !sampled {
        return format!("{share} of the points pass");
    }
    let (low, high) = yields.interval();
    format!("yield {share}, with 95 % confidence {} to {}", percent(low), percent(high))
}

/// All requirements: how often they fail, their worst value, and the keys that drive them.
fn requirements(found: &Summary) -> Markup {
    let percent = |margin: f64| format!("{} %", fixed(100.0 * margin, 1));
    html! {
        @if !found.requirements.is_empty() {
            section id="requirements" {
                h2 { "Requirements" }
                table {
                    (heading(&[
                        "requirement", ">fails", ">unresolved", ">worst", ">margin", ">point", "step", "place",
                        "driven by",
                    ]))
                    tbody { @for own in &found.requirements {
                        @let Requirement { name, measure, fails, unresolved, worst, drivers } = own;
                        tr class=[(*fails > 0).then_some("trouble")] {
                            td { (name) }
                            td class="n" { (fails) }
                            td class="n" { (unresolved) }
                            @if let Some(worst) = worst {
                                td class="n" { (sheet::value(*measure, worst.value)) }
                                td class="n" { @if let Some(margin) = worst.margin { (percent(margin)) } }
                                td class="n" { (worst.point) }
                                td { (worst.step) }
                                td { (worst.place) }
                            } @else { td colspan="5" { "not checked" } }
                            td { @for (k, driver) in drivers.iter().enumerate() {
                                @if k > 0 { ", " }
                                (driver.key) " (" (format!("{:+.2}", driver.correlation)) ")"
                            } }
                        }
                    } }
                }
                p {
                    "In brackets: Spearman's rank correlation of the worst value with the key, within each combination \
                     of crossed keys; only those told from chance."
                }
            }
        }
    }
}

/// Picture of the region that fails: points by the two keys that drive the requirement that fails most (one key: over
/// the worst value of that requirement), coloured by verdict. A key that some points do not have, such as one of a
/// single joint model, is no axis.
fn region(table: &Table, found: &Summary) -> Markup {
    let Some(first) = found.requirements.first() else { return html! {} };
    let everywhere = |key: &str| table.numbers(key).iter().all(Option::is_some);
    let numeric = |key: &&str| everywhere(key) && Series::of(table, key, "").is_some_and(|series| series.varies());
    let mut axes: Vec<&str> = first.drivers.iter().map(|driver| driver.key.as_str()).collect();
    axes.extend(keys(table).into_iter().filter(|key| !first.drivers.iter().any(|driver| driver.key == **key)));
    axes.retain(numeric);
    let worst = format!("worst.{}", first.name);
    let [x, y] = match axes[..] {
        [] => return html! {},
        [x] => [x, worst.as_str()],
        [x, y, ..] => [x, y],
    };
    let (xs, ys) = (table.numbers(x), table.numbers(y));
    let mark = |row: usize| match table.words("verdict").get(row).and_then(|verdict| verdict.as_deref()) {
        Some("pass") => Mark::Pass,
        Some("fail") => Mark::Fail,
        _ => Mark::Unresolved,
    };
    let at = |row: usize| Some((xs[row]?, (*ys.get(row)?)?, mark(row)));
    let points = (0..table.rows()).filter_map(at);
    let (mut points, beyond): (Vec<_>, Vec<_>) = points.partition(|(x, y, _)| x.is_finite() && y.is_finite());
    // Of too many every n-th that passes: none that fails is left out.
    let every = points.len().div_ceil(DRAWN).max(1);
    let mut passed = 0;
    points.retain(|(_, _, mark)| {
        passed += usize::from(*mark == Mark::Pass);
        *mark != Mark::Pass || passed % every == 0
    });
    html! {
        section id="region" {
            h2 { "Region that fails" }
            figure {
                (PreEscaped(plots::region(&points)))
                figcaption {
                    (y) " over " (x) ": "
                    span class="good" { "● pass" } " " span class="bad" { "● fail" } " ○ unresolved or without a result"
                    @if every > 1 { " (every " (every) "th point that passes)" }
                    @if !beyond.is_empty() { "; left out: " (beyond.len()) " with an infinite value" }
                }
            }
        }
    }
}

fn statuses(table: &Table, found: &Summary) -> Markup {
    let reason = table.words("message").iter().enumerate().find_map(|(k, message)| Some((k, message.as_ref()?)));
    html! {
        section id="status" {
            h2 { "Status of points" }
            table { tbody { @for (word, n) in &found.statuses {
                tr class=[(word != "converged").then_some("trouble")] { td { (word) } td class="n" { (n) } }
            } } }
            @if let Some((k, message)) = reason { p { "First message, point " (k) ": " (message) } }
        }
    }
}

fn distributions(results: &[Series<'_>], not_converged: usize) -> Markup {
    html! {
        section id="results" {
            h2 { "Results" }
            @if not_converged > 0 { p { "Of points that converged; " (not_converged) " did not." } }
            table {
                (heading(&[
                    "result", ">points", ">minimum", ">5 %", ">median", ">95 %", ">maximum", ">mean",
                    ">standard deviation",
                ]))
                tbody { @for result in results {
                    @let mut sorted = result.finite().collect::<Vec<f64>>();
                    @let () = sorted.sort_by(f64::total_cmp);
                    @let n = sorted.len() as f64;
                    @let mean = sorted.iter().sum::<f64>() / n;
                    @let squares: f64 = sorted.iter().map(|x| (x - mean).powi(2)).sum();
                    @let deviation = (squares / (n - 1.0).max(1.0)).sqrt();
                    tr {
                        td { (result.name) " [" (result.unit) "]" }
                        td class="n" { (sorted.len()) }
                        @for fraction in [0.0, 0.05, 0.5, 0.95, 1.0] {
                            td class="n" { (fixed(quantile(&sorted, fraction), 5)) }
                        }
                        td class="n" { (fixed(mean, 5)) }
                        td class="n" { (format!("{deviation:.2e}")) }
                    }
                } }
            }
        }
    }
}

/// Influence of each key: change of the result over the key's range, from a least-squares plane.
fn tornado(keys: &[Series<'_>], result: &Series<'_>) -> Markup {
    let Some(Fit { mut swings, fraction }) = fit(keys, result) else { return html! {} };
    swings.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let most = swings.first().map_or(1.0, |(_, swing)| swing.abs()).max(f64::MIN_POSITIVE);
    html! {
        table {
            (heading(&["key", ">range", &format!(">changes {} by [{}]", result.name, result.unit), ""]))
            tbody { @for (k, swing) in &swings {
                @let (low, high) = keys[*k].range;
                tr {
                    td { (keys[*k].name) }
                    td class="n" { (fixed(low, 5)) " to " (fixed(high, 5)) }
                    td class="n" { (format!("{swing:+.3e}")) }
                    @let colour = if *swing < 0.0 { "#c46a00" } else { "#1f5fa8" };
                    td { div style={
                        "height:.7rem;min-width:1px;background:" (colour)
                        ";width:" (fixed(16.0 * swing.abs() / most, 2)) "rem"
                    } {} }
                }
            } }
        }
        p {
            "By the least-squares plane through all points, which explains " (fixed(100.0 * fraction, 1))
            " % of the variance."
        }
    }
}

/// A plane through the points.
#[derive(Debug)]
struct Fit {
    /// Index of a key, and change of the result over the key's whole range.
    swings: Vec<(usize, f64)>,
    /// Fraction of the variance that the plane explains, R².
    fraction: f64,
}

/// Least squares of `y = b₀ + Σ bᵢ xᵢ`, keys scaled to −½ .. ½ so that `bᵢ` are the swings; none where there are too
/// few points.
fn fit(keys: &[Series<'_>], result: &Series<'_>) -> Option<Fit> {
    let rows: Vec<usize> = (0..result.entries.len())
        .filter(|&row| {
            let finite = |series: &Series<'_>| series.entries[row].is_some_and(f64::is_finite);
            finite(result) && keys.iter().all(finite)
        })
        .collect();
    if keys.is_empty() || rows.len() < keys.len() + 2 {
        return None;
    }
    let at = |series: &Series<'_>, row: usize| series.entries[row].unwrap_or(f64::NAN);
    let x = DMatrix::from_fn(rows.len(), keys.len() + 1, |i, j| match j.checked_sub(1) {
        None => 1.0,
        Some(k) => {
            let (low, high) = keys[k].range;
            (at(&keys[k], rows[i]) - low) / (high - low) - 0.5
        }
    });
    let y = DVector::from_fn(rows.len(), |i, _| at(result, rows[i]));
    let b = (x.transpose() * &x).cholesky()?.solve(&(x.transpose() * &y));
    let mean = y.mean();
    let left = (&y - &x * &b).norm_squared();
    let all = y.add_scalar(-mean).norm_squared();
    Some(Fit {
        swings: (0..keys.len()).map(|k| (k, b[k + 1])).collect(),
        fraction: if all > 0.0 { 1.0 - left / all } else { 1.0 },
    })
}

/// The result over a key.
fn response(key: &Series<'_>, result: &Series<'_>, joined: bool) -> Markup {
    let points = key.entries.iter().zip(result.entries.iter());
    let mut points: Vec<(f64, f64)> =
        points.filter_map(|(x, y)| Some(((*x)?, (*y)?))).filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let every = points.len().div_ceil(DRAWN).max(1);
    points = points.into_iter().step_by(every).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    html! {
        figure {
            (PreEscaped(plots::response(&points, joined)))
            figcaption {
                (result.name) " [" (result.unit) "] over " (key.name)
                @if every > 1 { " (every " (every) "th point)" }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_found_and_what_it_explains() {
        let x: Vec<Option<f64>> = (0..30).map(|k| Some(1.0 + f64::from(k % 5))).collect();
        let z: Vec<Option<f64>> = (0..30).map(|k| Some(f64::from(k % 7))).collect();
        let y: Vec<Option<f64>> = x.iter().zip(&z).map(|(x, z)| Some(3.0 + 2.0 * (*x)? - 0.5 * (*z)?)).collect();
        let series = |name, entries: &[Option<f64>]| Series::new(name, "", entries.to_vec());
        let Fit { swings, fraction } = fit(&[series("x", &x), series("z", &z)], &series("y", &y)).unwrap();
        assert!((swings[0].1 - 8.0).abs() < 1e-10 && (swings[1].1 + 3.0).abs() < 1e-10, "{swings:?}");
        assert!((fraction - 1.0).abs() < 1e-12);
        assert!(
            fit(&[series("x", &x[..2])], &series("y", &y[..2])).is_none(),
            "two points make no plane of two numbers"
        );
        // A parabola about the middle of its range has no slope.
        let square: Vec<Option<f64>> = x.iter().map(|x| Some((x.unwrap() - 3.0).powi(2))).collect();
        let flat = fit(&[series("x", &x)], &series("y", &square)).unwrap();
        assert!(flat.swings[0].1.abs() < 1e-10 && flat.fraction < 1e-10, "{flat:?}");
    }
}
