//! What a millimetre of a length or a place does to the requirements.

use super::layout::heading;
use crate::sheet::value;
use maud::{Markup, html};
use wireloom_core::equilibrium::{KeySensitivity, RequirementSensitivity, Run};
use wireloom_core::requirement::Measure;

/// Keys of a requirement that the table shows.
const KEYS: usize = 5;
/// What a key changes by, m.
const STEP: f64 = 1e-3;

/// Remark where there is a history.
const HISTORY: &str = "with what has slipped or yielded before as it is: a run with another number also changes that";

/// The table, requirement by requirement in the order of the scenario; nothing where it was not asked for.
pub(super) fn sensitivities(run: &Run) -> Markup {
    if run.sensitivities.is_empty() {
        return html! {};
    }
    html! {
        section id="sensitivities" {
            h2 { "What drives each requirement" }
            p {
                "Change of its worst value by 1 mm more of a length or a place, the largest first, at most " (KEYS)
                " of each requirement; result.json has all."
            }
            table {
                (heading(&["requirement", ">worst", "1 mm more of", ">changes it by", "remark"]))
                tbody { @for (own, line) in run.sensitivities.iter().zip(&run.requirements) {
                    (rows(own, line.measure, line.worst))
                } }
            }
        }
    }
}

fn rows(own: &RequirementSensitivity, measure: Measure, worst: Option<f64>) -> Markup {
    let worst = worst.map(|worst| value(measure, worst)).unwrap_or_default();
    let nothing = "no length and no place changes it".to_owned();
    let none = own.by.is_empty().then(|| own.reason.clone().unwrap_or(nothing));
    html! {
        @if let Some(why) = none {
            tr { td { (own.requirement) } td class="n" { (worst) } td {} td {} td { (why) } }
        }
        @for (k, by) in own.by.iter().take(KEYS).enumerate() {
            tr {
                td { @if k == 0 { (own.requirement) } }
                td class="n" { @if k == 0 { (worst) } }
                td { (by.key) }
                td class="n" { (change(by, measure)) }
                td {
                    @if let Some(reason) = &by.reason { (reason) }
                    @else if own.keeps_history { (HISTORY) }
                }
            }
        }
    }
}

/// What a step of a key does to a value of this measure; where both sides differ, what less and what more do.
fn change(by: &KeySensitivity, measure: Measure) -> String {
    let signed = |change: f64| format!("{}{}", if change > 0.0 { "+" } else { "" }, value(measure, change));
    if let Some(derivative) = by.derivative {
        return signed(STEP * derivative);
    }
    let [below, above] = by.sides.unwrap_or_default();
    let sides = [("less", below, -STEP), ("more", above, STEP)];
    let known = sides.into_iter().filter_map(|(word, side, step)| Some(format!("{word}: {}", signed(step * side?))));
    known.collect::<Vec<_>>().join(", ")
}
