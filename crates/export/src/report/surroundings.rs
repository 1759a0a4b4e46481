//! Contact with obstacles, and clearances.

use super::layout::{OPEN, fixed, heading, millimetres};
use maud::{Markup, html};
use wireloom_core::StepResult;
use wireloom_core::equilibrium::Clearance;

/// Forces of obstacles at the ends of steps.
pub(super) fn obstacles(ends: &[&StepResult]) -> Markup {
    if ends.iter().all(|end| end.obstacles.is_empty()) {
        return html! {};
    }
    html! {
        section id="obstacles" {
            h2 { "Obstacles" }
            p {
                "Force F on the harness, and moment M about the obstacle's position, at the end of each step; "
                "world axes."
            }
            @for (k, end) in ends.iter().enumerate() {
                details open[ends.len() <= OPEN / 4 || k + 1 == ends.len()] {
                    summary { (k + 1) ". " (end.name) }
                    table {
                        (heading(&[
                            "obstacle", ">Fx [N]", ">Fy [N]", ">Fz [N]", ">|F| [N]", ">Mx [N m]", ">My [N m]",
                            ">Mz [N m]", ">contacts", ">depth [µm]",
                        ]))
                        tbody { @for obstacle in &end.obstacles {
                            tr {
                                td { (obstacle.name) }
                                @for c in &obstacle.force { td class="n" { (fixed(*c, 3)) } }
                                td class="n" { (fixed(obstacle.force.norm(), 3)) }
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

/// Largest number of pairs shown; a harness of many branches has thousands.
const PAIRS: usize = 200;

/// Smallest distances over the whole run, the nearest to its limit first.
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
            p { "Smallest distance from surface to surface over all increments." }
            table {
                (heading(&["branch", "nearest to", ">clearance [mm]", ">required [mm]", ">at s [mm]", "in step"]))
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
                p { (sorted.len() - PAIRS) " more pairs: see result.json." }
            }
        }
    }
}
