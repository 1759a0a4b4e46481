//! Results beside each other on one page: what `wireloom compare --report` writes.

use super::layout::{OPEN, fixed, millimetres, radius};
use super::{plots, style};
use crate::comparison::{BranchDifference, Case, Comparison, Trend};
use crate::ending::BranchEnd;
use crate::picture;
use base64::Engine;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::io::{self, Write};

/// What the page is about. Its writer knows neither clock nor machine: whoever asks for it says.
#[derive(Clone, Debug, PartialEq)]
pub struct Beside<'a> {
    /// Headline.
    pub title: &'a str,
    /// The results.
    pub cases: &'a [Case],
    /// What is different.
    pub comparison: &'a Comparison,
    /// How results settle, where meshes were compared.
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
pub fn write_beside(beside: &Beside<'_>, out: &mut impl Write) -> io::Result<()> {
    out.write_all(page(beside).into_string().as_bytes())
}

fn page(beside: &Beside<'_>) -> Markup {
    let picture = picture::overlay(beside.cases, beside.title);
    let source = base64::engine::general_purpose::STANDARD.encode(picture);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (beside.title) }
                style { (PreEscaped(style::SHEET)) }
            }
            body {
                header {
                    h1 { (beside.title) }
                    p { (beside.program) " · " (beside.machine) " · " (beside.written) }
                }
                (endings(beside.cases))
                section id="shapes" {
                    h2 { "Shapes" }
                    img alt="all shapes over each other" src={ "data:image/svg+xml;base64," (source) };
                }
                (differences(beside))
                (settling(beside.trends))
                @if beside.alike { (equilibria(beside)) }
                (branches(beside))
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
                thead { tr {
                    th { "result" } th { "status" } th { "stable" } th class="n" { "energy [J]" } th class="n" { "tightest bend [mm]" } th { "on" }
                    th { "minimiser" } th class="n" { "iterations" } th class="n" { "factorisations" } th class="n" { "time [s]" } th { "events" }
                } }
                tbody { @for (k, Case { ending, .. }) in cases.iter().enumerate() {
                    tr class=[(!ending.converged || ending.stable == Some(false)).then_some("trouble")] {
                        td { (name(cases, k)) }
                        td { (ending.status) }
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
                        td { (ending.events.iter().map(|(kind, n)| format!("{n} × {}", kind.title())).collect::<Vec<_>>().join(", ")) }
                    }
                } }
            }
        }
    }
}

fn differences(beside: &Beside<'_>) -> Markup {
    let Beside { cases, comparison, .. } = beside;
    html! {
        section id="differences" {
            h2 { "Differences from " (cases[comparison.reference].name) }
            table {
                thead { tr {
                    th { "result" } th class="n" { "farthest apart [mm]" } th { "on" } th class="n" { "mean [mm]" } th class="n" { "energy [J]" }
                    th class="n" { "largest force difference [N]" } th { "at constraint" } th class="n" { "its moment [N m]" }
                } }
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

fn settling(trends: &[Trend]) -> Markup {
    if trends.is_empty() {
        return html! {};
    }
    html! {
        section id="convergence" {
            h2 { "Convergence" }
            p { "Changes from each mesh to the next finer one; order and error of the finest from the last three (Richardson)." }
            table {
                thead { tr {
                    th { "quantity" } th { "changes" } th class="n" { "observed order" } th class="n" { "error of the finest" } th class="n" { "limit" }
                } }
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

/// Which are the same, and why the others are not.
fn equilibria(beside: &Beside<'_>) -> Markup {
    let Beside { cases, comparison, .. } = beside;
    html! {
        section id="equilibria" {
            h2 { "Equilibria" }
            p { "The same: no branch is " (fixed(1e3 * comparison.tolerance, 3)) " mm away from where it is in the other." }
            ol { @for group in &comparison.groups { li {
                (names(cases, &group.cases))
                @if !group.reasons.is_empty() {
                    (format!(": {:+.3} mJ", 1e3 * comparison.differences[group.cases[0]].energy))
                    ul { @for reason in &group.reasons { li { (reason) } } }
                }
            } } }
            @if !comparison.parts.is_empty() {
                p { "Parts of the harness that lie in more than one way:" }
                table {
                    thead { tr { th { "part" } th class="n" { "way" } th class="n" { "from way 1 [mm]" } th { "on" } th { "results" } } }
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
fn branches(beside: &Beside<'_>) -> Markup {
    let Beside { cases, comparison, .. } = beside;
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
            p { "The one that lies farthest from where it lies in the reference first." }
            @for (k, (branch, reach)) in order.iter().enumerate() {
                details open[k < OPEN] {
                    summary { (branch.name) " (" (fixed(1e3 * reach, 3)) " mm)" }
                    (branch_rows(beside, &branch.name))
                    @if k < PLOTS { div class="plots" { figure {
                        (PreEscaped(plots::bend_radii(&curves(cases, &branch.name))))
                        figcaption { "bend radius [mm] along s [mm]" }
                    } } }
                }
            }
        }
    }
}

/// Branches that have plots; the rest of a large harness would make the page a heavy one.
const PLOTS: usize = 60;

fn curves<'a>(cases: &'a [Case], name: &str) -> Vec<(&'a BranchEnd, &'static str)> {
    let of = |(k, case): (usize, &'a Case)| {
        let branch = case.ending.branches.iter().find(|branch| branch.name == name)?;
        Some((branch, picture::colour(k)))
    };
    cases.iter().enumerate().filter_map(of).collect()
}

fn branch_rows(beside: &Beside<'_>, branch: &str) -> Markup {
    let find = |k: usize| -> Option<&BranchDifference> {
        beside.comparison.differences[k].branches.iter().find(|other| other.name == branch)
    };
    html! {
        table {
            thead { tr {
                th { "result" } th class="n" { "farthest apart [mm]" } th class="n" { "at s [mm]" } th class="n" { "mean [mm]" }
                th class="n" { "tightest bend [mm]" } th class="n" { "twist [turns]" }
            } }
            tbody { @for k in 0..beside.cases.len() { @if let Some(difference) = find(k) { tr {
                td { (name(beside.cases, k)) }
                @if k == beside.comparison.reference { td {} td {} td {} } @else {
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
