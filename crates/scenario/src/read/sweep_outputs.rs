//! Reads the outputs of a sweep.

use super::entry::Entry;
use super::names::Names;
use super::places::{attachment, stretch};
use crate::attachment::At;
use crate::sweep::{Measured, Output};

/// Reads an output; `None` if it is faulty.
pub(crate) fn output(name: &str, entry: &Entry<'_>, names: &Names<'_>) -> Option<Output> {
    for (taken, what) in
        [(names.branches.contains_key(name), "branch"), (names.constraints.contains_key(name), "constraint")]
    {
        if taken {
            let message = format!("{} has the name of a {what}, which is that of other columns", entry.label);
            entry.fault_here(message, "give it another name");
            return None;
        }
    }
    let quantity = entry.choice("quantity")?;
    let along = matches!(quantity, "bend-radius" | "slack");
    let [wanted, other] = if along { ["span", "at"] } else { ["at", "span"] };
    if entry.has(other) {
        let message = format!("{} has `{other}`, but a {quantity} has none", entry.label);
        entry.fault_at(other, message, format!("leave it out, and give the place by `{wanted}`"));
        return None;
    }
    let Some(place) = entry.entry(wanted) else {
        if !entry.has(wanted) {
            let help = match wanted {
                "at" => "add at = { branch = \"…\", s = … }",
                _ => "add span = { branch = \"…\" }, or span = { branch = \"…\", from = …, to = … }",
            };
            entry.fault_here(format!("{} has no place", entry.label), help);
        }
        return None;
    };
    let measured = match quantity {
        "bend-radius" => Measured::BendRadius(stretch(&place, names)?),
        "slack" => Measured::Slack(stretch(&place, names)?),
        _ => match (quantity, attachment(&place, names, false)?.0) {
            ("position", at) => Measured::Position(at),
            ("force", At::Branch { branch, s }) => Measured::Force(branch, s),
            ("moment", At::Branch { branch, s }) => Measured::Moment(branch, s),
            (_, At::Branch { branch, s }) => Measured::Tension(branch, s),
            (_, At::Joint(_)) => {
                let message = format!("{} is at a joint, where every branch has a {quantity} of its own", entry.label);
                place.fault_here(message, "give a place on one branch: at = { branch = \"…\", s = … }");
                return None;
            }
        },
    };
    Some(Output { name: name.to_owned(), measured })
}
