//! Deviation from the drawing, and part numbers.

use super::layout::{fixed, heading, millimetres};
use maud::{Markup, html};
use wireloom_core::equilibrium::{BranchResult, DrawnStart, StepResult};
use wireloom_core::identity::{Component, Connection, Identities, Identity, WireEnd};

/// Distance of the last equilibrium from the drawn lines, the farthest branch first, and from the equilibrium that the
/// drawn start leads to.
pub(super) fn deviation(end: Option<&StepResult>, drawn_start: Option<&DrawnStart>) -> Markup {
    let branches = end.map_or(&[][..], |end| &end.branches);
    let of = |branch: &BranchResult| branch.deviation.as_ref().map(|deviation| deviation.max);
    let mut drawn: Vec<&BranchResult> = branches.iter().filter(|branch| branch.deviation.is_some()).collect();
    if drawn.is_empty() && drawn_start.is_none() {
        return html! {};
    }
    drawn.sort_by(|a, b| of(b).unwrap_or_default().total_cmp(&of(a).unwrap_or_default()));
    html! {
        section id="deviation" {
            h2 { "Deviation from the drawing" }
            p {
                "Distance of the computed centre lines from the drawn ones at the end of the run, the farthest first. "
                "A branch that is more than its diameter away has the reason."
            }
            table {
                (heading(&[
                    "branch", ">median [mm]", ">largest [mm]", ">at s [mm]", ">diameter [mm]", "reason",
                ]))
                tbody { @for branch in drawn {
                    @if let Some(deviation) = &branch.deviation {
                        tr class=[deviation.cause.is_some().then_some("trouble")] {
                            td { (branch.name) }
                            td class="n" { (millimetres(deviation.median)) }
                            td class="n" { (millimetres(deviation.max)) }
                            td class="n" { (millimetres(deviation.s)) }
                            td class="n" { (millimetres(branch.diameter)) }
                            td { @if let Some(cause) = &deviation.cause { (cause) } }
                        }
                    }
                } }
            }
            @if let Some(drawn_start) = drawn_start { (from_drawn(drawn_start)) }
        }
    }
}

fn from_drawn(drawn_start: &DrawnStart) -> Markup {
    html! {
        h3 { "Beside the equilibrium from the drawn start" }
        @for line in drawn_start.lines() { p { (line) } }
        @if !drawn_start.branches.is_empty() {
            table {
                (heading(&["branch", ">distance [mm]", ">at s [mm]", ">twist [turns]"]))
                tbody { @for branch in &drawn_start.branches {
                    tr {
                        td { (branch.name) }
                        td class="n" { (millimetres(branch.distance)) }
                        td class="n" { (millimetres(branch.s)) }
                        td class="n" { (fixed(branch.turns, 2)) }
                    }
                } }
            }
        }
    }
}

/// Part numbers, components that do not act, and connections.
pub(super) fn identities(all: &Identities) -> Markup {
    if all.is_empty() {
        return html! {};
    }
    html! {
        section id="parts" {
            h2 { "Parts" }
            @if !all.parts.is_empty() {
                table {
                    (heading(&["of", "name", "part", "description", "supplier", "colour"]))
                    tbody { @for part in &all.parts {
                        tr { td { (part.of.word()) } td { (part.name) } (identity(&part.identity)) }
                    } }
                }
            }
            @if !all.components.is_empty() {
                details open[all.components.len() <= SHORT] {
                    summary { "Components that do not act (" (all.components.len()) ")" }
                    table {
                        (heading(&["kind", "name", "part", "description", "supplier", "colour", "place"]))
                        tbody { @for component in &all.components {
                            tr {
                                td { (component.kind.as_deref().unwrap_or_default()) }
                                td { (component.name) }
                                (identity(&component.identity))
                                td { (place(component)) }
                            }
                        } }
                    }
                }
            }
            @if !all.connections.is_empty() {
                details open[all.connections.len() <= SHORT] {
                    summary { "Connections (" (all.connections.len()) ")" }
                    table {
                        (heading(&[
                            "name", "signal", "wire", "part", "description", "supplier", "colour", "from", "to",
                            ">length [mm]", "through",
                        ]))
                        tbody { @for connection in &all.connections { (row(connection)) } }
                    }
                }
            }
        }
    }
}

/// Lists up to this length are open at first.
const SHORT: usize = 40;

fn identity(identity: &Identity) -> Markup {
    let Identity { part, description, supplier, colour } = identity;
    html! { @for text in [part, description, supplier, colour] { td { (text.as_deref().unwrap_or_default()) } } }
}

fn place(component: &Component) -> String {
    let mut words = Vec::new();
    words.extend(component.connector.iter().map(|name| format!("in {name}")));
    words.extend(component.cavity.iter().map(|cavity| format!("cavity {cavity}")));
    words.extend(component.vertex.iter().map(|name| format!("at {name}")));
    words.extend(component.branch.iter().map(|name| format!("on {name}")));
    words.extend(component.from.map(|s| format!("from s = {} mm", millimetres(s))));
    words.extend(component.to.map(|s| format!("to s = {} mm", millimetres(s))));
    words.join(", ")
}

fn row(connection: &Connection) -> Markup {
    html! {
        tr {
            td { (connection.name) }
            td { (connection.signal.as_deref().unwrap_or_default()) }
            td { (connection.wire.as_deref().unwrap_or_default()) }
            (identity(&connection.identity))
            @for k in 0..2 { td { (connection.ends.get(k).map(end).unwrap_or_default()) } }
            td class="n" { @if connection.length > 0.0 { (millimetres(connection.length)) } }
            td { (connection.branches.join(", ")) }
        }
    }
}

/// Example: "XA.1, cavity 3, terminal 000 979, seal 357 972".
fn end(end: &WireEnd) -> String {
    let mut words: Vec<String> = end.connector.iter().cloned().collect();
    for (what, value) in [("cavity", &end.cavity), ("terminal", &end.terminal), ("seal", &end.seal)] {
        words.extend(value.iter().map(|value| format!("{what} {value}")));
    }
    words.join(", ")
}
