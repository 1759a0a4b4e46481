//! `temperature`: temperatures of branches.

use super::context::Context;
use super::{Begins, StepOperation};
use crate::format::form::{Form, Keys, may, must};
use crate::format::limits::ANY;
use crate::read::entry::Entry;
use crate::read::names::lookup;
use toml::Spanned;
use toml::de::DeValue;
use wireloom_core::Quantity;
use wireloom_core::steps::Operation;

/// Temperatures reached by a step.
pub(super) const TEMPERATURE: StepOperation = StepOperation {
    key: may("temperature", Form::Tables(&KEYS), "temperatures of branches reached at its end"),
    begins: |_| Begins::Nothing,
    read,
};

/// The temperature of some branches, or of all.
const KEYS: Keys = Keys {
    what: "temperature",
    keys: &[
        must(
            "change",
            Form::Number(Quantity::Temperature, ANY),
            "temperature reached at the end of the step less that at which the branches have their lengths, K",
        ),
        may("branches", Form::Names, "the branches that have it; default all"),
    ],
};

fn read(entry: &Entry<'_>, _: Option<usize>, step: &mut Context<'_, '_>) -> Option<Operation> {
    let change = entry.number("change");
    let branches: Vec<_> = if entry.has("branches") {
        let named = entry.names("branches");
        if matches!(entry.node("branches").map(Spanned::get_ref), Some(DeValue::Array(list)) if list.is_empty()) {
            let message = format!("`branches` of {} names none", entry.label);
            entry.fault_at("branches", message, "name some, or leave it out for all branches");
        }
        named
            .into_iter()
            .filter_map(|(name, span)| {
                lookup(entry, "branch", &step.names.branches, name, span.clone()).map(|index| (*index, span))
            })
            .collect()
    } else {
        (0..step.names.lengths.len()).map(|branch| (branch, entry.span.clone())).collect()
    };
    for (branch, span) in branches {
        if step.temperatures.iter().any(|(other, _)| *other == branch) {
            let message = format!("{} gives a branch two temperatures", step.entry.label);
            entry.reader.fault(span, message, "give one temperature for every branch");
            return None;
        }
        step.temperatures.extend(change.map(|change| (branch, change)));
    }
    None
}
