//! `load`: load factors.

use super::context::Context;
use super::{Begins, StepOperation};
use crate::format::form::{Form, Keys, may, must};
use crate::format::limits::LOAD_FACTOR;
use crate::read::entry::Entry;
use crate::read::names::lookup;
use wireloom_core::Quantity;
use wireloom_core::steps::Operation;

/// Load factors reached by a step.
pub(super) const LOAD: StepOperation = StepOperation {
    key: may("load", Form::Tables(&KEYS), "load factors reached at its end"),
    begins: |_| Begins::Nothing,
    read,
};

/// A load factor reached by a step.
const KEYS: Keys = Keys {
    what: "load",
    keys: &[
        must("load", Form::Name, "name of the load"),
        must("factor", Form::Number(Quantity::Dimensionless, LOAD_FACTOR), "factor reached at the end of the step"),
    ],
};

fn read(entry: &Entry<'_>, _: Option<usize>, step: &mut Context<'_, '_>) -> Option<Operation> {
    let factor = entry.number("factor");
    let name = entry.word("load")?;
    let span = entry.span_of("load");
    let index = *lookup(entry, "load", &step.names.loads, name, span.clone())?;
    if step.loads.iter().any(|(other, _)| *other == index) {
        let message = format!("{} changes the load \"{name}\" twice", step.entry.label);
        entry.reader.fault(span, message, "give one factor for every load");
        return None;
    }
    step.loads.extend(factor.map(|factor| (index, factor)));
    None
}
