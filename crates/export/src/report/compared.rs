//! Page of `wireloom compare --report`: several results side by side.

use super::layout::{OPEN, fixed, heading, millimetres, radius};
use super::{plots, style};
use crate::comparison::{BranchDifference, Case, Comparison, Trend, forces};
use crate::ending::{BranchEnd, Ending};
use crate::{picture, sheet};
use base64::Engine;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::io::{self, Write};
use wireloom_core::equilibrium::RequirementResult;
use wireloom_core::requirement::Verdict;

/// Content of the page. The writer looks at neither clock nor machine: the caller states both.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparisonPage<'a> {
    /// Headline.
    pub title: &'a str,
    /// The results.
    pub cases: &'a [Case],
    /// Their differences.
    pub comparison: &'a Comparison,
    /// Convergence under mesh refinement, where meshes were compared.
    pub trends: &'a [Trend],
    /// Whether all are the same problem, so that they could have ended in the same equilibrium.
    pub alike: bool,
    /// Program and version.
    pub program: &'a str,
    /// The machine.
    pub machine: &'a str,
    /// Day and time.
    pub written: &'a str,
}

/// Writes the page.
///
/// # Errors
/// Those of `out`.
pub fn write_comparison(compared: &ComparisonPage<'_>, out: &mut impl Write) -> io::Result<()> {
    out.write_all(page(compared).into_string().as_bytes())
}

fn page(compared: &ComparisonPage<'_>) -> Markup {
    let picture = picture::overlay(compared.cases, compared.title);
    let source = base64::engine::general_purpose::STANDARD.encode(picture);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (compared.title) }
                style { (PreEscaped(style::SHEET)) }
            }
            body {
                header {
                    h1 { (compared.title) }
                    p { (compared.program) " · " (compared.machine) " · " (compared.written) }
                }
                (endings(compared.cases))
                (requirements(compared.cases))
                section id="shapes" {
                    h2 { "Shapes" }
                    img alt="all shapes over each other" src={ "data:image/svg+xml;base64," (source) };
                }
                @if !compared.alike { (forces_of_constraints(compared.cases)) }
                (differences(compared))
                (convergence(compared.trends))
                @if compared.alike { (equilibria(compared)) }
                (branches(compared))
                script { (PreEscaped(style::UNFOLD)) }
            }
        }
    }
}

fn name(cases: &[Case], k: usize) -> Markup {
    html! { span style={ "color:" (picture::colour(k)) } { "■ " } (cases[k].name) }
}

fn names(cases: &[Case], which: &[usize]) -> Markup {
    html! { @for (i, k) in which.iter().enumerate() { @if i > 0 { ", " } (name(cases, *k)) } }
}

fn endings(cases: &[Case]) -> Markup {
    html! {
        section id="results" {
            h2 { "Results" }
            table {
                (heading(&[
                    "result", "status", "verdict", "stable", ">energy [J]", ">tightest bend [mm]", "on",
                    "minimiser", ">iterations", ">factorisations", ">time [s]", "events",
                ]))
                tbody { @for (k, Case { ending, .. }) in cases.iter().enumerate() {
                    tr class=[(!ending.converged || ending.stable == Some(false)).then_some("trouble")] {
                        td { (name(cases, k)) }
                        td { (ending.status) }
                        td class=(if ending.verdict == Verdict::Pass { "good" } else { "bad" }) {
                            (sheet::capitals(ending.verdict))
                        }
                        td { (match ending.stable { Some(true) => "yes", Some(false) => "NO", None => "unknown" }) }
                        td class="n" { (format!("{:.6}", ending.energy.total())) }
                        @if let Some((branch, s, radius)) = ending.tightest() {
                            td class="n" { (millimetres(radius)) }
                            td { (branch) " at s = " (millimetres(s)) " mm" }
                        } @else { td class="n" { "straight" } td {} }
                        td { (ending.minimiser) }
                        td class="n" { (ending.iterations) }
                        td class="n" { (ending.factorisations) }
                        td class="n" { (format!("{:.3}", ending.seconds)) }
                        td { (events(ending)) }
                    }
                } }
            }
        }
    }
}

/// Requirements that are not kept everywhere, the results side by side.
fn requirements(cases: &[Case]) -> Markup {
    let sheets: Vec<&[RequirementResult]> = cases.iter().map(|case| &case.ending.requirements[..]).collect();
    let open = sheet::open_in_any(&sheets);
    html! {
        @if !open.is_empty() {
            section id="requirements" {
                h2 { "Requirements that are not kept everywhere" }
                table {
                    thead { tr { th { "requirement" } @for k in 0..cases.len() { th { (name(cases, k)) } } } }
                    tbody { @for requirement in open { tr {
                        td { (requirement) }
                        @for lines in &sheets {
                            @match lines.iter().find(|line| line.name == requirement) {
                                Some(line) => td class=[sheet::is_open(line).then_some("bad")] { (sheet::brief(line)) },
                                None => td { "–" },
                            }
                        }
                    } } }
                }
            }
        }
    }
}

/// Forces of constraints, the results side by side.
fn forces_of_constraints(cases: &[Case]) -> Markup {
    let all = forces(cases);
    html! {
        @if !all.is_empty() {
            section id="forces" {
                h2 { "Forces of constraints" }
                table {
                    thead { tr {
                        th { "constraint" }
                        th class="n" { "largest [N]" }
                        th { "in" }
                        @for k in 0..cases.len() { th class="n" { (name(cases, k)) } }
                    } }
                    tbody { @for own in &all { tr {
                        td { (own.constraint) }
                        td class="n" { (fixed(own.most(), 2)) }
                        td { (name(cases, own.largest)) }
                        @for force in &own.of {
                            td class="n" { @if let Some(force) = force { (fixed(*force, 2)) } @else { "–" } }
                        }
                    } } }
                }
            }
        }
    }
}

/// `2 × slipped against friction, 1 × not converged`.
fn events(ending: &Ending) -> String {
    let words: Vec<String> = ending.events.iter().map(|(kind, n)| format!("{n} × {}", kind.title())).collect();
    words.join(", ")
}

fn differences(compared: &ComparisonPage<'_>) -> Markup {
    let ComparisonPage { cases, comparison, .. } = compared;
    html! {
        section id="differences" {
            h2 { "Differences from " (cases[comparison.reference].name) }
            table {
                (heading(&[
                    "result", ">farthest apart [mm]", "on", ">mean [mm]", ">energy [J]",
                    ">largest force difference [N]", "at constraint", ">its moment [N m]",
                ]))
                tbody { @for (k, difference) in comparison.differences.iter().enumerate() {
                    @if k != comparison.reference { tr {
                        td { (name(cases, k)) }
                        @if let Some(branch) = difference.farthest() {
                            td class="n" { (fixed(1e3 * branch.largest, 4)) }
                            td { (branch.name) " at s = " (millimetres(branch.s)) " mm" }
                            td class="n" { (fixed(1e3 * difference.mean(), 4)) }
                        } @else { td {} td {} td {} }
                        td class="n" { (format!("{:+.3e}", difference.energy)) }
                        @if let Some(constraint) = difference.hardest() {
                            td class="n" { (fixed(constraint.force, 4)) }
                            td { (constraint.name) }
                            td class="n" { (fixed(constraint.moment, 5)) }
                        } @else { td {} td {} td {} }
                    } }
                } }
            }
        }
    }
}

fn convergence(trends: &[Trend]) -> Markup {
    if trends.is_empty() {
        return html! {};
    }
    html! {
        section id="convergence" {
            h2 { "Convergence" }
            p {
                "Changes from each mesh to the next finer one; order and error of the finest from the last three "
                "(Richardson)."
            }
            table {
                (heading(&["quantity", "changes", ">observed order", ">error of the finest", ">limit"]))
                tbody { @for trend in trends { tr {
                    td { (trend.quantity) " [" (trend.unit) "]" }
                    td { (trend.changes.iter().map(|change| format!("{change:.2e}")).collect::<Vec<_>>().join(", ")) }
                    td class="n" { (trend.order.map_or("–".into(), |order| format!("{order:.2}"))) }
                    td class="n" { (trend.error.map_or("–".into(), |error| format!("{error:.1e}"))) }
                    td class="n" { (trend.limit.map_or(String::new(), |limit| format!("{limit:.6}"))) }
                } } }
            }
        }
    }
}

/// Groups of equal results, and causes of the differences.
fn equilibria(compared: &ComparisonPage<'_>) -> Markup {
    let ComparisonPage { cases, comparison, .. } = compared;
    html! {
        section id="equilibria" {
            h2 { "Equilibria" }
            p {
                "Equal: no branch is farther than " (fixed(1e3 * comparison.tolerance, 3))
                " mm from its place in the other, and twist, forces and energy agree."
            }
            ol { @for group in &comparison.groups { li {
                (names(cases, &group.cases))
                @if !group.reasons.is_empty() {
                    @if group.cases[0] != comparison.reference {
                        (format!(": {:+.3} mJ", 1e3 * comparison.differences[group.cases[0]].energy))
                    }
                    ul { @for reason in &group.reasons { li { (reason) } } }
                }
            } } }
            @if !comparison.parts.is_empty() {
                p { "Parts of the harness with more than one shape:" }
                table {
                    (heading(&["part", ">shape", ">from shape 1 [mm]", "on", "results"]))
                    tbody { @for part in &comparison.parts { @for (k, way) in part.ways.iter().enumerate() { tr {
                        td { @if k == 0 { (part.branches.join(", ")) } }
                        td class="n" { (k + 1) }
                        @if let Some((branch, s, distance)) = &way.farthest {
                            td class="n" { (millimetres(*distance)) }
                            td { (branch) " at s = " (millimetres(*s)) " mm" }
                        } @else { td {} td {} }
                        td { (names(cases, &way.cases)) }
                    } } } }
                }
            }
        }
    }
}

/// The branch that moves farthest first.
fn branches(compared: &ComparisonPage<'_>) -> Markup {
    let ComparisonPage { cases, comparison, .. } = compared;
    let reach = |branch: &BranchEnd| {
        let own = comparison.differences.iter().flat_map(|difference| &difference.branches);
        own.filter(|other| other.name == branch.name).fold(0.0, |reach: f64, other| reach.max(other.largest))
    };
    let mut order: Vec<(&BranchEnd, f64)> =
        cases[comparison.reference].ending.branches.iter().map(|branch| (branch, reach(branch))).collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    html! {
        section id="branches" {
            h2 { "Branches" }
            p { "In descending order of the distance from the reference." }
            @for (k, (branch, reach)) in order.iter().enumerate() {
                details open[k < OPEN] {
                    summary { (branch.name) " (" (fixed(1e3 * reach, 3)) " mm)" }
                    (branch_rows(compared, &branch.name))
                    @if k < PLOTS { div class="plots" { figure {
                        (PreEscaped(plots::bend_radii(&curves(cases, &branch.name))))
                        figcaption { "bend radius [mm] along s [mm]" }
                    } } }
                }
            }
        }
    }
}

/// Largest number of branches with plots, which limits the size of the page.
const PLOTS: usize = 60;

fn curves<'a>(cases: &'a [Case], name: &str) -> Vec<(&'a BranchEnd, &'static str)> {
    let of = |(k, case): (usize, &'a Case)| {
        let branch = case.ending.branches.iter().find(|branch| branch.name == name)?;
        Some((branch, picture::colour(k)))
    };
    cases.iter().enumerate().filter_map(of).collect()
}

fn branch_rows(compared: &ComparisonPage<'_>, branch: &str) -> Markup {
    let find = |k: usize| -> Option<&BranchDifference> {
        compared.comparison.differences[k].branches.iter().find(|other| other.name == branch)
    };
    html! {
        table {
            (heading(&[
                "result", ">farthest apart [mm]", ">at s [mm]", ">mean [mm]", ">tightest bend [mm]", ">twist [turns]",
            ]))
            tbody { @for k in 0..compared.cases.len() { @if let Some(difference) = find(k) { tr {
                td { (name(compared.cases, k)) }
                @if k == compared.comparison.reference { td {} td {} td {} } @else {
                    td class="n" { (fixed(1e3 * difference.largest, 4)) }
                    td class="n" { (millimetres(difference.s)) }
                    td class="n" { (fixed(1e3 * difference.mean, 4)) }
                }
                td class="n" { (radius(difference.bend_radius[1])) }
                td class="n" { (fixed(difference.twist_turns[1], 3)) }
            } } } }
        }
    }
}
