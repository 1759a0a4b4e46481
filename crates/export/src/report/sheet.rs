//! The verdict, the status, and the sheet of requirements: the first things on the page.

use super::layout::heading;
use crate::sheet::{Line, capitals, is_open, numbers, sorted};
use maud::{Markup, html};
use wireloom_core::Status;
use wireloom_core::equilibrium::{RequirementResult, Run};
use wireloom_core::requirement::{Severity, Verdict};

/// Lines that stand in one table; of a longer sheet, those that are kept are folded.
const LINES: usize = 40;

/// Heading of a column, and what stands in it.
type Column = (&'static str, fn(&Line) -> &String);

const COLUMNS: [Column; 9] = [
    ("requirement", |line| &line.name),
    ("quantity", |line| &line.quantity),
    (">worst", |line| &line.worst),
    (">limit", |line| &line.limit),
    (">margin", |line| &line.margin),
    (">error", |line| &line.error),
    ("where", |line| &line.place),
    ("because", |line| &line.because),
    ("remark", |line| &line.reason),
];

/// The verdict on the harness, and beside it the status of the run.
pub(super) fn verdict(run: &Run) -> Markup {
    let verdict = run.verdict();
    let status = if run.status() == Status::Converged { "pass" } else { "fail" };
    html! {
        div class="signs" {
            p class={ "sign verdict " (class(verdict)) } {
                small { "verdict on the harness" }
                strong { (capitals(verdict)) }
                (numbers(run))
            }
            p class={ "sign status " (status) } {
                small { "status of the run" }
                strong { (run.status().word()) }
            }
        }
    }
}

/// The lines of the sheet, the worst first; `drawn`: indices of the steps that have a picture.
pub(super) fn sheet(run: &Run, drawn: &[usize]) -> Markup {
    let lines = sorted(&run.requirements);
    let (open, kept): (Vec<_>, Vec<_>) = lines.iter().partition(|line| is_open(line));
    html! {
        section id="requirements" {
            h2 { "Requirements" }
            @if lines.is_empty() {
                p { "Nothing is required of this harness, so nothing was checked: add [[requirements]]." }
            } @else if lines.len() <= LINES {
                (table(&lines, drawn))
            } @else {
                @if !open.is_empty() { (table(&open, drawn)) }
                details open[open.is_empty()] {
                    summary { (kept.len()) " requirements that are kept or were not checked" }
                    (table(&kept, drawn))
                }
            }
        }
    }
}

/// A table of lines, without columns in which nothing stands.
fn table(lines: &[&RequirementResult], drawn: &[usize]) -> Markup {
    let words: Vec<Line> = lines.iter().map(|line| Line::of(line)).collect();
    let used = |(_, cell): &&Column| words.iter().any(|line| !cell(line).is_empty());
    let columns: Vec<&Column> = COLUMNS.iter().filter(used).collect();
    let names: Vec<&str> =
        ["verdict"].into_iter().chain(columns.iter().map(|(name, _)| *name)).chain(["in step"]).collect();
    html! {
        table class="sheet" {
            (heading(&names))
            tbody { @for (line, words) in lines.iter().zip(&words) {
                tr class=[is_open(line).then(|| of_line(line))] {
                    td { span class={ "mark " (of_line(line)) } { (words.verdict) } }
                    @for (name, cell) in &columns {
                        td class=[name.starts_with('>').then_some("n")] { (cell(words)) }
                    }
                    td { (step(line, &words.moment, drawn)) }
                }
            } }
        }
    }
}

/// The step of the worst value, with a link to its picture.
fn step(line: &RequirementResult, words: &str, drawn: &[usize]) -> Markup {
    let drawn = line.moment.as_ref().map(|moment| moment.step_index).filter(|step| drawn.contains(step));
    match drawn {
        Some(step) => html! { a href={ "#" (picture(step)) } { (words) } },
        None => html! { (words) },
    }
}

/// Name of the place of the picture of a step.
pub(super) fn picture(step: usize) -> String {
    format!("picture-{}", step + 1)
}

/// Style of a line: what fails and decides nothing is not red.
fn of_line(line: &RequirementResult) -> &'static str {
    match (line.verdict, line.severity) {
        (Verdict::Fail, Severity::Should) => class(Verdict::Unresolved),
        (verdict, _) => class(verdict),
    }
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "pass",
        Verdict::Fail => "fail",
        Verdict::Unresolved => "unresolved",
        Verdict::NotChecked => "unchecked",
    }
}
