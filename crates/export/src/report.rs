//! `report.html`: a run on one page that needs no other file, to be read on a screen, kept, or printed.
//!
//! The verdict on the harness, the status of the run and the sheet of requirements first, then events, the result of
//! each step with its picture, the reactions, the branches with the one nearest to its limit first, and the scenario
//! itself. Long sections are folded; printing unfolds them.

mod compared;
mod cross_sections;
mod deviation;
mod identities;
mod layout;
mod plots;
mod points;
mod sensitivities;
mod sheet;
mod style;
mod surroundings;

pub use compared::{ComparisonPage, write_comparison};
pub use points::{Points, write_points};

use crate::format::{Ended, File, Format, ends};
use crate::local::{Local, node_count};
use crate::picture::{self, Drawing};
use crate::sheet::{capitals, open_in};
use base64::Engine;
use layout::{OPEN, fixed, heading, millimetres, radius};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::io::{self, Write};
use wireloom_core::equilibrium::{BranchResult, ConstraintResult, Run, SlideMotion, StepResult};
use wireloom_core::event::grouped;
use wireloom_core::identity::{Identified, Identities};
use wireloom_core::obstacle::Obstacle;
use wireloom_core::sections::Bend;
use wireloom_core::{Event, Status, Vector};

/// In a run with more steps than this, only steps with events, the first and the last have pictures.
const PICTURES: usize = 24;
/// Largest number of pictures.
const MOST_PICTURES: usize = 40;
/// Smallest number of pictures of a run with as many steps.
const LEAST_PICTURES: usize = 4;
/// Size of all pictures together, bytes, unless there are fewer than [`LEAST_PICTURES`].
const PICTURE_BYTES: usize = 16 << 20;

/// Content of a report. The writer looks at neither clock nor machine: the caller states both.
#[derive(Clone, Debug)]
pub struct Report<'a> {
    /// The run.
    pub run: &'a Run,
    /// The obstacles, for the pictures.
    pub obstacles: &'a [Obstacle],
    /// Names and texts: of the scenario, then of the files it names.
    pub texts: &'a [(String, String)],
    /// Program and version.
    pub program: &'a str,
    /// The machine.
    pub machine: &'a str,
    /// Day and time.
    pub written: &'a str,
}

/// Writes the report.
///
/// # Errors
/// Those of `out`; `InvalidInput` where a branch's vectors differ in length.
pub fn write(report: &Report<'_>, out: &mut impl Write) -> io::Result<()> {
    for branch in report.run.steps.iter().flat_map(|step| &step.branches) {
        node_count(branch)?;
    }
    out.write_all(page(report)?.into_string().as_bytes())
}

fn page(report: &Report<'_>) -> io::Result<Markup> {
    let run = report.run;
    let ends = ends(run);
    let name = if run.scenario.is_empty() { "harness" } else { &run.scenario };
    let (drawn, pictures) = pictures(report, &ends)?;
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (name) ": " (capitals(run.verdict())) ", " (run.status().word()) }
                style { (PreEscaped(style::SHEET)) }
            }
            body {
                header {
                    h1 { (name) }
                    (sheet::verdict(run))
                    @if let Some(fault) = run.fault() { p class="bad" { (fault) } }
                    p { (report.program) " · " (report.machine) " · " (report.written) }
                    (contents(&ends))
                }
                (sheet::sheet(run, &drawn))
                (sensitivities::sensitivities(run))
                (events(&run.events))
                (steps(&ends))
                (operations(&ends))
                section id="pictures" { h2 { "Pictures" } (pictures) }
                (reactions(&ends, &run.identities))
                (surroundings::obstacles(&ends))
                (surroundings::clearances(&run.clearances))
                (branches(&ends))
                (deviation::deviation(ends.last().copied(), run.drawn_start.as_ref()))
                (identities::identities(&run.identities))
                (cross_sections::cross_sections(&run.identities.cross_sections))
                @if !run.notes.is_empty() {
                    section id="notes" { h2 { "Notes" } ul { @for note in &run.notes { li { (note) } } } }
                }
                section id="scenario" {
                    h2 { "Scenario" }
                    @for (name, text) in report.texts {
                        details open[text.lines().count() <= 150] { summary { (name) } pre { (text) } }
                    }
                }
                script { (PreEscaped(style::UNFOLD)) }
            }
        }
    })
}

fn contents(ends: &[&StepResult]) -> Markup {
    let size = ends.last().map(|end| {
        let nodes: usize = end.branches.iter().map(|branch| branch.s.len()).sum();
        let counted = |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        [
            counted(end.branches.len(), "branch", "branches"),
            counted(end.joints.len(), "joint", "joints"),
            counted(nodes, "node", "nodes"),
            counted(ends.len(), "step", "steps"),
        ]
        .join(", ")
    });
    html! {
        p { (size.unwrap_or_else(|| "nothing was computed".into())) }
        nav {
            @for (id, title) in [
                ("requirements", "Requirements"), ("events", "Events"), ("steps", "Steps"), ("pictures", "Pictures"),
                ("reactions", "Reactions"), ("branches", "Branches"), ("scenario", "Scenario"),
            ] { a href={ "#" (id) } { (title) } " " }
        }
    }
}

fn events(events: &[Event]) -> Markup {
    let groups = grouped(events);
    html! {
        section id="events" {
            h2 { "Events" }
            @if groups.is_empty() {
                p { "No events: no limit was passed, nothing slipped or snapped, no increment was cut back." }
            } @else {
                table {
                    (heading(&["event", "where", "worst value", "first in", "worst in", ">increments"]))
                    tbody {
                        @for group in &groups {
                            tr class=[group.worst.kind.is_trouble().then_some("trouble")] {
                                td { (group.worst.kind.title()) }
                                td { (group.worst.place) }
                                td { (group.worst.message) }
                                td { (group.first.first.step) " (" (group.first.first.increment) ")" }
                                td { (group.worst.worst.step) " (" (group.worst.worst.increment) ")" }
                                td class="n" { (group.increments) }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn steps(ends: &[&StepResult]) -> Markup {
    html! {
        section id="steps" {
            h2 { "Steps" }
            table {
                (heading(&[
                    "step", "status", ">increments", ">iterations", ">time [s]", ">residual", ">energy [J]", "stable",
                    ">tightest bend [mm]", "on",
                ]))
                tbody {
                    @for end in ends {
                        tr class=[(end.status != Status::Converged || end.stable == Some(false)).then_some("trouble")] {
                            td { (end.name) }
                            td { (end.status.word()) }
                            td class="n" {
                                (end.increment)
                                @if end.increment < end.increments { " of " (end.increments) }
                            }
                            td class="n" { (end.minimiser.iterations) }
                            td class="n" { (format!("{:.3}", end.minimiser.seconds)) }
                            td class="n" { (format!("{:.0e}", end.minimiser.force_residual)) }
                            td class="n" { (format!("{:.4}", end.energy.total())) }
                            td { (match end.stable { Some(true) => "yes", Some(false) => "NO", None => "unknown" }) }
                            @if let Some(bend) = &end.min_bend_radius {
                                td class="n" { (millimetres(bend.value)) }
                                td { (bend.branch) " at s = " (millimetres(bend.s)) " mm" }
                            } @else { td class="n" { "straight" } td {} }
                        }
                    }
                }
            }
        }
    }
}

/// Table of operations: grasp, carry, mate, clip.
fn operations(ends: &[&StepResult]) -> Markup {
    if ends.iter().all(|end| end.operations.is_empty()) {
        return html! {};
    }
    html! {
        section id="operations" {
            h2 { "Operations" }
            table {
                (heading(&["step", "operation", "of", "result"]))
                tbody {
                    @for end in ends {
                        @for operation in &end.operations {
                            tr {
                                td { (end.name) }
                                td { (operation.word()) }
                                td { (operation.of().join(", ")) }
                                td { (operation) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A picture for each step, or for those with events or requirements that are not kept where there are very many; with
/// the indices of the steps drawn.
fn pictures(report: &Report<'_>, ends: &[&StepResult]) -> io::Result<(Vec<usize>, Markup)> {
    let Report { run, obstacles, .. } = report;
    let of_event =
        |event: &Event, k| event.kind.is_trouble() && (event.first.step_index..=event.last.step_index).contains(&k);
    let told = |k: usize| run.events.iter().any(|event| of_event(event, k)) || !open_in(run, Some(k)).is_empty();
    let mut chosen: Vec<usize> =
        (0..ends.len()).filter(|&k| ends.len() <= PICTURES || k == 0 || k + 1 == ends.len() || told(k)).collect();
    let draw = |k: usize| -> io::Result<String> {
        let mut svg = Vec::new();
        let title = format!("{}: {}", run.scenario, ends[k].name);
        let of_step = Some(k);
        picture::write(&Drawing { step: ends[k], obstacles, title: &title, run: Some(run), of_step }, &mut svg)?;
        Ok(format!("data:image/svg+xml;base64,{}", base64::engine::general_purpose::STANDARD.encode(svg)))
    };
    let size = ends.len().checked_sub(1).map(draw).transpose()?.map_or(1, |source| source.len());
    let most = (PICTURE_BYTES / size).clamp(LEAST_PICTURES, MOST_PICTURES);
    if chosen.len() > most {
        chosen = (0..most).map(|k| chosen[k * (chosen.len() - 1) / (most - 1)]).collect();
    }
    let drawn = chosen.iter().map(|&k| Ok((k, draw(k)?))).collect::<io::Result<Vec<_>>>()?;
    let markup = html! {
        @for (k, source) in &drawn {
            details id=(sheet::picture(*k)) open[drawn.len() <= OPEN || k + 1 == ends.len()] {
                summary { (k + 1) ". " (ends[*k].name) }
                img alt={ "the harness at the end of step " (ends[*k].name) } src=(source);
            }
        }
        @if chosen.len() < ends.len() {
            p { "Pictures of " (ends.len() - chosen.len()) " steps are omitted, to keep this page small." }
        }
    };
    Ok((chosen, markup))
}

fn reactions(ends: &[&StepResult], identities: &Identities) -> Markup {
    let part = |name: &str| identities.find(Identified::Constraint, name).and_then(|own| own.part.as_deref());
    html! {
        section id="reactions" {
            h2 { "Reactions" }
            p {
                "Force F and moment M about the held point that each constraint exerts on the harness at the end of "
                "each step, at each of its stations, or in total along its span; world axes."
            }
            @for (k, end) in ends.iter().enumerate() {
                details open[ends.len() <= OPEN / 4 || k + 1 == ends.len()] {
                    summary { (k + 1) ". " (end.name) }
                    table {
                        (heading(&[
                            "constraint", "kind", "part", ">Fx [N]", ">Fy [N]", ">Fz [N]", ">|F| [N]",
                            ">Mx [N m]", ">My [N m]", ">Mz [N m]", ">|M| [N m]", "cable",
                        ]))
                        tbody { @for constraint in &end.constraints { (reaction(constraint, part(&constraint.name))) } }
                    }
                }
            }
        }
    }
}

fn reaction(constraint: &ConstraintResult, part: Option<&str>) -> Markup {
    let cells = |v: &Vector, digits: usize| {
        html! { @for c in [v.x, v.y, v.z, v.norm()] { td class="n" { (fixed(c, digits)) } } }
    };
    html! {
        tr {
            td { (constraint.name) }
            td { (constraint.kind) }
            td { (part.unwrap_or_default()) }
            (cells(&constraint.force, 3))
            (cells(&constraint.moment, 4))
            td {
                @if let Some(slide) = &constraint.slide {
                    (match slide.motion {
                        SlideMotion::Free => "runs freely",
                        SlideMotion::Stick => "sticks",
                        SlideMotion::Slip => "slips",
                        SlideMotion::Stopped => "is stopped",
                    })
                    " at s = " (millimetres(slide.arc_length)) " mm"
                }
                @if let Some(span) = &constraint.span {
                    (span.branch) " from s = " (millimetres(span.range.0)) " mm to " (millimetres(span.range.1)) " mm"
                }
            }
        }
        @for (k, station) in constraint.stations.iter().enumerate().skip(1) {
            tr {
                td { (constraint.name) ", station " (k + 1) }
                td {}
                td {}
                (cells(&station.force, 3))
                (cells(&station.moment, 4))
                td {}
            }
        }
    }
}

/// A branch over all steps that ended in an equilibrium.
struct Course<'a> {
    last: &'a BranchResult,
    /// Step and bend that is nearest to its limit; without one, the tightest.
    tightest: (usize, Bend),
    /// Largest tension or compression: step and tension, N.
    pulled: (usize, f64),
}

impl<'a> Course<'a> {
    fn of(k: usize, ends: &[&'a StepResult]) -> Option<Self> {
        let last = &ends.last()?.branches[k];
        let straight = Bend { s: 0.0, radius: f64::INFINITY, limit: last.bend_radius_limit };
        let (mut tightest, mut pulled) = ((0, straight), (0, 0.0_f64));
        for (step, end) in ends.iter().enumerate() {
            let branch = &end.branches[k];
            let worst = branch.bends().min_by(Bend::compare);
            if let Some(bend) = worst.filter(|bend| bend.compare(&tightest.1).is_lt()) {
                tightest = (step, bend);
            }
            for i in 0..branch.s.len() {
                let tension = Local::at(branch, i).tension;
                if tension.abs() > pulled.1.abs() {
                    pulled = (step, tension);
                }
            }
        }
        Some(Self { last, tightest, pulled })
    }
}

fn branches(ends: &[&StepResult]) -> Markup {
    let ends: Vec<&StepResult> = ends.iter().copied().filter(|end| end.status.is_balanced()).collect();
    let ends = ends.as_slice();
    let count = ends.last().map_or(0, |end| end.branches.len());
    let mut courses: Vec<Course> = (0..count).filter_map(|k| Course::of(k, ends)).collect();
    courses.sort_by(|a, b| a.tightest.1.compare(&b.tightest.1));
    html! {
        section id="branches" {
            h2 { "Branches" }
            @if ends.is_empty() {
                p { "No step ended in an equilibrium." }
            } @else {
                p { "At the ends of the steps that ended in an equilibrium; the branch nearest to its limit first." }
                table {
                (heading(&[
                    "branch", ">tightest bend [mm]", ">limit [mm]", ">of limit", ">at s [mm]", "in step",
                    ">largest tension [N]", "in step",
                ]))
                tbody { @for (k, course) in courses.iter().enumerate() {
                    tr class=[(course.tightest.1.use_of_limit() > 1.0).then_some("trouble")] {
                        td { a href={ "#b" (k) } { (course.last.name) } }
                        td class="n" { (radius(course.tightest.1.radius)) }
                        td class="n" { (course.tightest.1.limit.map_or_else(|| "no limit".into(), millimetres)) }
                        td class="n" {
                            @if course.tightest.1.limit.is_some() {
                                (fixed(100.0 * course.tightest.1.use_of_limit(), 0)) " %"
                            }
                        }
                        td class="n" { @if course.tightest.1.radius.is_finite() { (millimetres(course.tightest.1.s)) } }
                        td { (ends[course.tightest.0].name) }
                        td class="n" { (fixed(course.pulled.1, 3)) }
                        td { (ends[course.pulled.0].name) }
                    }
                } }
                }
            }
            @for (k, course) in courses.iter().enumerate() {
                details id={ "b" (k) } open[k < OPEN] {
                    summary { (course.last.name) }
                    div class="plots" { (plots_of(course, ends)) }
                }
            }
        }
    }
}

fn plots_of(course: &Course<'_>, ends: &[&StepResult]) -> Markup {
    let last = ends.len() - 1;
    let at = |step: usize| ends[step].branches.iter().find(|branch| branch.name == course.last.name);
    let curves = |other: usize| -> Vec<&BranchResult> {
        let other = (other != last).then(|| at(other)).flatten();
        other.into_iter().chain([course.last]).collect()
    };
    let legend = |other: usize| {
        html! {
            @if other != last { span class="other" { (ends[other].name) } " " }
            span class="last" { (ends[last].name) }
        }
    };
    html! {
        figure {
            (PreEscaped(plots::bend_radius(&curves(course.tightest.0))))
            figcaption {
                "bend radius [mm] along s [mm]: " (legend(course.tightest.0))
                @if course.tightest.1.limit.is_some() { " " span class="limit" { "limit" } }
            }
        }
        figure {
            (PreEscaped(plots::tension(&curves(course.pulled.0))))
            figcaption { "tension [N] along s [mm]: " (legend(course.pulled.0)) }
        }
    }
}

/// The format `report.html`.
pub struct Html;

/// Its file.
pub const FILE: &str = "report.html";

impl Format for Html {
    fn key(&self) -> Option<&'static str> {
        Some("report")
    }

    fn files(&self) -> &'static [&'static str] {
        &[FILE]
    }

    fn media_type(&self) -> &'static str {
        "text/html; charset=utf-8"
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        vec![File::new(FILE, |mut out| {
            let Ended { run, texts, program, machine, written, .. } = *ended;
            let obstacles = ended.surroundings.obstacles();
            write(&Report { run, obstacles, texts, program, machine, written }, &mut out)
        })]
    }

    fn offered(&self, _: &[&str], _: bool) -> Vec<String> {
        vec![FILE.to_owned()]
    }

    fn at_hand<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        self.at_end(ended)
    }
}
