//! Part numbers and the like.

use super::layout::{heading, millimetres};
use maud::{Markup, html};
use wireloom_core::identity::{Component, Connection, Identities, Identity, WireEnd};

/// Part numbers, components that do not act, and connections.
pub(super) fn identities(all: &Identities) -> Markup {
    if all.parts.is_empty() && all.components.is_empty() && all.connections.is_empty() {
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
