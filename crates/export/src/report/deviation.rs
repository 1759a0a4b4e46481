//! Deviation from the drawing.

use super::layout::{fixed, heading, millimetres};
use maud::{Markup, html};
use wireloom_core::equilibrium::{BranchResult, DrawnStart, StepResult};

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
