//! What touches the harness, and how near it comes to what is about it.

use super::layout::{OPEN, fixed, millimetres};
use maud::{Markup, html};
use wireloom_core::StepResult;
use wireloom_core::equilibrium::Clearance;

/// What obstacles exert at the ends of steps.
pub(super) fn obstacles(ends: &[&StepResult]) -> Markup {
    if ends.iter().all(|end| end.obstacles.is_empty()) {
        return html! {};
    }
    html! {
        section id="obstacles" {
            h2 { "Obstacles" }
            p { "Force F on the harness, and moment M about the obstacle's position, at the end of each step; world axes." }
            @for (k, end) in ends.iter().enumerate() {
                details open[ends.len() <= OPEN / 4 || k + 1 == ends.len()] {
                    summary { (k + 1) ". " (end.name) }
                    table {
                        thead { tr {
                            th { "obstacle" }
                            @for head in ["Fx [N]", "Fy [N]", "Fz [N]", "|F| [N]", "Mx [N m]", "My [N m]", "Mz [N m]", "contacts", "depth [µm]"] {
                                th class="n" { (head) }
                            }
                        } }
                        tbody { @for obstacle in &end.obstacles {
                            tr {
                                td { (obstacle.name) }
                                @for c in obstacle.force.iter().copied().chain([obstacle.force.norm()]) { td class="n" { (fixed(c, 3)) } }
                                @for c in &obstacle.moment { td class="n" { (fixed(*c, 4)) } }
                                td class="n" { (obstacle.contacts) }
                                td class="n" { (fixed(1e6 * obstacle.depth, 1)) }
                            }
                        } }
                    }
                }
            }
        }
    }
}

/// Pairs shown; a harness of many branches has thousands.
const PAIRS: usize = 200;

/// The least distances over the whole run, what is nearest to its limit first.
pub(super) fn clearances(clearances: &[Clearance]) -> Markup {
    if clearances.is_empty() {
        return html! {};
    }
    let beyond = |clearance: &Clearance| clearance.distance - clearance.required.unwrap_or(0.0);
    let mut sorted: Vec<&Clearance> = clearances.iter().collect();
    sorted.sort_by(|a, b| beyond(a).total_cmp(&beyond(b)));
    html! {
        section id="clearance" {
            h2 { "Clearance" }
            p { "Least distance from surface to surface over all increments." }
            table {
                thead { tr {
                    th { "branch" } th { "nearest to" } th class="n" { "clearance [mm]" } th class="n" { "required [mm]" }
                    th class="n" { "at s [mm]" } th { "in step" }
                } }
                tbody { @for clearance in sorted.iter().take(PAIRS) {
                    tr class=[clearance.is_short().then_some("trouble")] {
                        td { (clearance.branch) }
                        td { (clearance.from) }
                        td class="n" { (millimetres(clearance.distance)) }
                        td class="n" { (clearance.required.map_or_else(String::new, millimetres)) }
                        td class="n" { (millimetres(clearance.s)) }
                        td { (clearance.moment.step) " (" (clearance.moment.increment) ")" }
                    }
                } }
            }
            @if sorted.len() > PAIRS {
                p { "Of " (sorted.len() - PAIRS) " further pairs result.json tells." }
            }
        }
    }
}
