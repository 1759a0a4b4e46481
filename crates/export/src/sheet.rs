//! The sheet of requirements in words: values with units and sensible digits, the same in the terminal, in reports, in
//! pictures and in tables.

use std::cmp::Ordering;
use wireloom_core::Status;
use wireloom_core::equilibrium::{RequirementResult, Run};
use wireloom_core::requirement::{Bound, Measure, Origin, Severity, Verdict, by_urgency};

/// Significant digits of a value.
const DIGITS: usize = 3;
/// Most significant digits, for a value close to its limit.
const MOST_DIGITS: usize = 9;
/// Values below this fraction of their limit are noise, and shown as 0.
const NOISE: f64 = 1e-7;
/// The error of a value without an estimate.
const NO_ESTIMATE: &str = "unknown";
/// Margins beyond this many percent are not worth their digits.
const FAR: f64 = 1000.0;
/// Margins of what is kept below this many percent are shown as 0.
const LEAST: f64 = 0.01;

/// A line of the sheet in words. What does not apply is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Line {
    /// "FAIL", "unresolved", "not checked" or "pass"; where the requirement decides nothing, also "(should)".
    pub verdict: String,
    /// Name.
    pub name: String,
    /// Quantity.
    pub quantity: String,
    /// Worst value with its unit.
    pub worst: String,
    /// Limit with its side and unit, such as "min 30 mm".
    pub limit: String,
    /// Margin in percent of the limit, negative where it fails.
    pub margin: String,
    /// Estimate of the discretisation error with its unit; "unknown" where a value has none.
    pub error: String,
    /// Place of the worst value.
    pub place: String,
    /// Step, and increment in brackets.
    pub moment: String,
    /// Why it is required.
    pub because: String,
    /// Why it is unresolved or not checked; or what the worst value leaves out.
    pub reason: String,
}

impl Line {
    /// The words of a line.
    pub fn of(line: &RequirementResult) -> Self {
        let RequirementResult { name, measure, severity, because, verdict, reason, .. } = line;
        let verdict = if *verdict == Verdict::Fail { "FAIL" } else { verdict.word() };
        let should = if *severity == Severity::Should { " (should)" } else { "" };
        let (worst, limit) = values(line);
        let error =
            line.error.map_or_else(String::new, |error| with_unit(*measure, &digits(shown(*measure, error), 2)));
        let checked = line.moment.is_some();
        Self {
            verdict: format!("{verdict}{should}"),
            name: name.clone(),
            quantity: measure.title().to_owned(),
            worst,
            limit,
            margin: line.margin().map_or_else(String::new, percent),
            error: match (error.is_empty(), checked) {
                (false, _) => format!("± {error}"),
                (true, true) => NO_ESTIMATE.to_owned(),
                (true, false) => error,
            },
            place: if checked { line.place.to_string() } else { String::new() },
            moment: line
                .moment
                .as_ref()
                .map_or_else(String::new, |moment| format!("{} ({})", moment.step, moment.increment)),
            because: because.clone().unwrap_or_default(),
            reason: reason.clone().unwrap_or_default(),
        }
    }
}

/// The lines of a sheet, the most urgent first; where that does not decide, in their order.
pub fn sorted(sheet: &[RequirementResult]) -> Vec<&RequirementResult> {
    let mut lines: Vec<&RequirementResult> = sheet.iter().collect();
    lines.sort_by(|a, b| by_urgency(a, b));
    lines
}

/// Whether a line demands attention: it fails or is unresolved.
pub fn is_open(line: &RequirementResult) -> bool {
    matches!(line.verdict, Verdict::Fail | Verdict::Unresolved)
}

/// Names of the requirements that fail or are unresolved in any of several sheets, the most urgent first.
pub fn open_in_any<'s>(sheets: &[&'s [RequirementResult]]) -> Vec<&'s str> {
    let mut open: Vec<&RequirementResult> =
        sheets.iter().flat_map(|sheet| *sheet).filter(|line| is_open(line)).collect();
    open.sort_by(|a, b| by_urgency(a, b));
    let mut names: Vec<&str> = Vec::new();
    for line in open {
        if !names.contains(&line.name.as_str()) {
            names.push(&line.name);
        }
    }
    names
}

/// Verdict, worst value, margin and place in one cell: "FAIL 29.1 mm (−3 %), branch loop at s = 120 mm".
pub fn brief(line: &RequirementResult) -> String {
    let Line { verdict, worst, margin, place, .. } = Line::of(line);
    let mut text = verdict;
    for (before, part, after) in [(" ", worst, ""), (" (", margin, ")"), (", ", place, "")] {
        if !part.is_empty() {
            text.extend([before, &part, after]);
        }
    }
    text
}

/// The lines of a run that fail or are unresolved, the most urgent first: of one step, by its index, or all.
pub fn open_in(run: &Run, step: Option<usize>) -> Vec<&RequirementResult> {
    let there = |line: &RequirementResult| {
        step.is_none_or(|step| line.moment.as_ref().is_some_and(|moment| moment.step_index == step))
    };
    sorted(&run.requirements).into_iter().filter(|line| is_open(line) && there(line)).collect()
}

/// The verdict on a run, and what it is based on: "FAIL: 2 of 14 requirements fail, 1 is unresolved".
pub fn headline(run: &Run) -> String {
    format!("{}: {}", capitals(run.verdict()), numbers(run))
}

/// The word of a verdict on a whole harness.
pub fn capitals(verdict: Verdict) -> String {
    verdict.word().to_uppercase()
}

/// How many requirements fail, and so on.
pub fn numbers(run: &Run) -> String {
    let of = |severity, verdict| {
        run.requirements.iter().filter(|line| (line.severity, line.verdict) == (severity, verdict)).count()
    };
    let must = |verdict| of(Severity::Must, verdict);
    let all: usize = Verdict::ALL.into_iter().map(must).sum();
    let (failed, open, unchecked) = (must(Verdict::Fail), must(Verdict::Unresolved), must(Verdict::NotChecked));
    let mut words = vec![];
    if run.requirements.is_empty() {
        words.push("nothing is required of this harness".to_owned());
    }
    if failed > 0 {
        words.push(format!("{failed} of {} {}", requirements(all), if failed == 1 { "fails" } else { "fail" }));
    }
    if open > 0 {
        let of = if failed > 0 { String::new() } else { format!(" of {}", requirements(all)) };
        words.push(format!("{open}{of} {} unresolved", is_or_are(open)));
    }
    if failed + open == 0 && all > 0 {
        match must(Verdict::Pass) {
            passed if passed == all => words.push(format!("{} kept", requirements(all))),
            passed => words.push(format!("{passed} of {} kept", requirements(all))),
        }
    }
    if unchecked > 0 {
        words.push(format!("{unchecked} not checked"));
    }
    let advised = of(Severity::Should, Verdict::Fail);
    if advised > 0 {
        words.push(format!("{advised} that should be kept {}", if advised == 1 { "fails" } else { "fail" }));
    }
    if run.status() != Status::Converged && failed + open == 0 {
        words.push(format!("but the run did not come to its end ({})", run.status().word()));
    }
    words.join(", ")
}

fn requirements(n: usize) -> String {
    if n == 1 { "1 requirement".to_owned() } else { format!("{n} requirements") }
}

fn is_or_are(n: usize) -> &'static str {
    if n == 1 { "is" } else { "are" }
}

/// Worst value and limit; where the limit is not kept, with as many digits as tell them apart.
fn values(line: &RequirementResult) -> (String, String) {
    let measure = line.measure;
    let side = line.bound.word();
    let limit = |n| digits(shown(measure, line.limit), n);
    let Some(worst) = line.worst.filter(|worst| *worst != f64::INFINITY) else {
        let straight = measure == Measure::BendRadius && (line.worst.is_some() || line.verdict == Verdict::Pass);
        let worst = if straight { "straight".to_owned() } else { String::new() };
        // The limits of what holds for every harness come with the values.
        let known = line.origin != Origin::Always || line.worst.is_some();
        let limit = format!("{side} {}", with_unit(measure, &short(&limit(DIGITS + 1))));
        return (worst, if known { limit } else { String::new() });
    };
    let noise = NOISE * line.limit.abs();
    let value = if worst.abs() < noise { 0.0 } else { worst };
    let number = |n| digits(shown(measure, value), n);
    let differ = |n: usize| number(n).parse::<f64>().ok() != limit(n).parse::<f64>().ok();
    let kept = line.bound.gap(worst, line.limit) >= 0.0;
    let apart = (DIGITS..MOST_DIGITS).find(|n| kept || differ(*n)).unwrap_or(MOST_DIGITS);
    let limit = short(&limit(apart.max(DIGITS + 1)));
    (with_unit(measure, &number(apart)), format!("{side} {}", with_unit(measure, &limit)))
}

/// A value of a measure in the unit in which it is shown.
pub fn value(measure: Measure, value: f64) -> String {
    if measure == Measure::BendRadius && value == f64::INFINITY {
        return "straight".to_owned();
    }
    with_unit(measure, &digits(shown(measure, value), DIGITS))
}

/// The number of a value in the unit in which it is shown: lengths in mm, pure numbers in percent.
fn shown(measure: Measure, value: f64) -> f64 {
    match measure.unit() {
        "m" => 1e3 * value,
        "" => 1e2 * value,
        _ => value,
    }
}

fn with_unit(measure: Measure, number: &str) -> String {
    let unit = match measure.unit() {
        "m" => "mm",
        "" => "%",
        unit => unit,
    };
    format!("{number} {unit}")
}

/// A number with `n` significant digits, without exponent where it is of a usual size.
fn digits(value: f64, n: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".to_owned() } else { format!("{value}") };
    }
    let magnitude = value.abs().log10().floor();
    if !(-6.0..7.0).contains(&magnitude) {
        return format!("{value:.*e}", n - 1);
    }
    format!("{value:.*}", (n as f64 - 1.0 - magnitude).max(0.0) as usize)
}

/// Without zeros at its end behind the point.
fn short(number: &str) -> String {
    if !number.contains('.') || number.contains('e') {
        return number.to_owned();
    }
    number.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A margin in percent. What fails never shows 0, and noise is 0.
fn percent(margin: f64) -> String {
    let percent = 1e2 * margin;
    match percent.abs().partial_cmp(&FAR) {
        Some(Ordering::Greater) if percent > 0.0 => format!("> {FAR} %"),
        Some(Ordering::Greater) => format!("< -{FAR} %"),
        _ if (0.0..LEAST).contains(&percent) => "0 %".to_owned(),
        _ if percent.abs() < 9.95 => format!("{} %", digits(percent, 2)),
        _ => format!("{percent:.0} %"),
    }
}

/// "30 mm" and "min", as one reads it: "29.1 mm, at least 30 mm".
pub fn sentence(line: &RequirementResult) -> String {
    let (worst, limit) = values(line);
    let side = match line.bound {
        Bound::Min => "at least",
        Bound::Max => "at most",
    };
    let limit = limit.split_once(' ').map_or("", |(_, limit)| limit);
    if worst.is_empty() { format!("{side} {limit}") } else { format!("{worst}, {side} {limit}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom_core::equilibrium::Outcome;
    use wireloom_core::event::{EventPlace, Moment};

    fn line(measure: Measure, bound: Bound, worst: f64, limit: f64) -> RequirementResult {
        let verdict = if bound.gap(worst, limit) < 0.0 { Verdict::Fail } else { Verdict::Pass };
        RequirementResult {
            name: "loop".into(),
            origin: Origin::Scenario,
            measure,
            severity: Severity::Must,
            because: Some("VW 60306".into()),
            verdict,
            reason: None,
            worst: Some(worst),
            limit,
            bound,
            error: None,
            moment: Some(Moment { step: "open 30".into(), step_index: 1, increment: 7 }),
            place: EventPlace::branch("trunk", 0.3),
        }
    }

    fn words(measure: Measure, bound: Bound, worst: f64, limit: f64) -> [String; 3] {
        let Line { worst, limit, margin, .. } = Line::of(&line(measure, bound, worst, limit));
        [worst, limit, margin]
    }

    #[test]
    fn a_limit_that_comes_with_its_value_is_not_shown_without_it() {
        let never = RequirementResult {
            origin: Origin::Always,
            worst: None,
            verdict: Verdict::NotChecked,
            ..line(Measure::Buckling, Bound::Max, 0.0, 0.0)
        };
        assert_eq!(Line::of(&never).limit, "");
        let given = RequirementResult { origin: Origin::Scenario, ..never };
        assert_eq!(Line::of(&given).limit, "max 0 N");
    }

    #[test]
    fn a_line_reads_as_an_engineer_writes_it() {
        let found = Line::of(&RequirementResult {
            error: Some(4e-4),
            severity: Severity::Should,
            ..line(Measure::BendRadius, Bound::Min, 0.029_12, 0.03)
        });
        let expected = Line {
            verdict: "FAIL (should)".into(),
            name: "loop".into(),
            quantity: "bend radius".into(),
            worst: "29.1 mm".into(),
            limit: "min 30 mm".into(),
            margin: "-2.9 %".into(),
            error: "± 0.40 mm".into(),
            place: "branch `trunk` at s = 300.0 mm".into(),
            moment: "open 30 (7)".into(),
            because: "VW 60306".into(),
            reason: String::new(),
        };
        assert_eq!(found, expected);
        assert_eq!(sentence(&line(Measure::BendRadius, Bound::Min, 0.029_12, 0.03)), "29.1 mm, at least 30 mm");
    }

    #[test]
    fn digits_are_sensible_and_noise_is_zero() {
        use {Bound::*, Measure::*};
        let all = [
            (words(Force, Max, 11_902.7, 150.0), ["11903 N", "max 150 N", "< -1000 %"]),
            (words(Clearance, Min, 5.91e-17, 0.006), ["0 mm", "min 6 mm", "-100 %"]),
            (words(Clearance, Min, -0.0126, 0.006), ["-12.6 mm", "min 6 mm", "-310 %"]),
            (words(Strain, Max, 0.000_512, 0.002), ["0.0512 %", "max 0.2 %", "74 %"]),
            (words(Reach, Max, 3.0, 1.0), ["300 %", "max 100 %", "-200 %"]),
            (words(Turns, Max, 0.25, 200.0 / 360.0), ["0.250 turns", "max 0.5556 turns", "55 %"]),
            (words(BendRadius, Min, 40.0, 0.03), ["40000 mm", "min 30 mm", "> 1000 %"]),
            (words(Slack, Min, 0.01, 0.0), ["10.0 mm", "min 0 mm", ""]),
            (words(Moment, Max, 1e-9, 2.5), ["0 N m", "max 2.5 N m", "100 %"]),
        ];
        for (found, expected) in all {
            assert_eq!(found, expected);
        }
    }

    /// 29.9997 mm of 30 mm fails, and the sheet does not say "30.0 mm, min 30 mm, 0 %".
    #[test]
    fn what_fails_by_a_hair_is_not_shown_as_its_limit() {
        let found = words(Measure::BendRadius, Bound::Min, 0.029_999_7, 0.03);
        assert_eq!(found, ["29.9997 mm", "min 30 mm", "-0.00100 %"]);
        let found = words(Measure::BendRadius, Bound::Min, 0.03, 0.03);
        assert_eq!(found, ["30.0 mm", "min 30 mm", "0 %"]);
        let found = words(Measure::Reach, Bound::Max, 1.0, 1.0 + 1e-9);
        assert_eq!(found, ["100 %", "max 100 %", "0 %"]);
    }

    #[test]
    fn the_headline_counts() {
        let mut run = Run {
            scenario: "y".into(),
            outcome: Outcome::Graded(Status::Converged),
            notes: vec![],
            events: vec![],
            steps: vec![],
            clearances: vec![],
            requirements: vec![],
            plugins: vec![],
            identities: Default::default(),
            drawn_start: None,
            sensitivities: Vec::new(),
        };
        assert_eq!(headline(&run), "UNRESOLVED: nothing is required of this harness");
        let of = |verdict, severity| RequirementResult {
            verdict,
            severity,
            origin: Origin::Section,
            ..line(Measure::Force, Bound::Max, 1.0, 2.0)
        };
        use {Severity::*, Verdict::*};
        run.requirements = vec![of(Pass, Must), of(Pass, Must), of(NotChecked, Must)];
        assert_eq!(headline(&run), "PASS: 2 of 3 requirements kept, 1 not checked");
        run.requirements.pop();
        assert_eq!(headline(&run), "PASS: 2 requirements kept");
        run.outcome = Outcome::Graded(Status::Interrupted);
        assert_eq!(
            headline(&run),
            "UNRESOLVED: 2 requirements kept, but the run did not come to its end (interrupted)"
        );
        run.outcome = Outcome::Graded(Status::Converged);
        run.requirements.extend([of(Unresolved, Must), of(Fail, Should)]);
        assert_eq!(headline(&run), "UNRESOLVED: 1 of 3 requirements is unresolved, 1 that should be kept fails");
        run.requirements.extend([of(Fail, Must), of(Fail, Must)]);
        assert_eq!(headline(&run), "FAIL: 2 of 5 requirements fail, 1 is unresolved, 1 that should be kept fails");
        let sheet: Vec<Verdict> = sorted(&run.requirements).iter().map(|line| line.verdict).collect();
        assert_eq!(sheet, [Fail, Fail, Unresolved, Fail, Pass, Pass]);
    }
}
