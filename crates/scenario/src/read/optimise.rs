//! Reads what an optimisation chooses, and to what end.

use super::entry::{Entry, NameOrEntry};
use super::sweep::{listed, pair};
use crate::optimise::{Choice, Minimised, Optimise, Term, Variable};

/// Margin from limits, relative to them, where none is given.
const MARGIN: f64 = 1e-3;
/// Accuracy of the objective where none is given.
const ACCURACY: f64 = 1e-4;
/// Largest number of runs where none is given.
const RUNS: usize = 200;

/// Reads an optimisation; `None` if it is faulty.
pub(crate) fn optimise(entry: &Entry<'_>) -> Option<Optimise> {
    let before = entry.reader.fault_count();
    let varied = entry.named_entries("vary");
    if varied.is_empty() && entry.has("vary") {
        let help = "add a key, such as \"branches.left.length\" = { from = 0.4, to = 0.5 }";
        entry.fault_at("vary", "nothing is to be chosen", help);
    }
    let variables: Vec<Variable> = varied.iter().filter_map(|(key, entry)| variable(key, entry)).collect();
    let given = entry.names_or_entries("minimise");
    if given.is_empty() && entry.has("minimise") && entry.reader.fault_count() == before {
        entry.fault_at("minimise", "there is nothing to minimise", "write \"length\", or the name of a requirement");
    }
    let mut terms: Vec<Term> = Vec::with_capacity(given.len());
    for item in given {
        let Some(term) = term(item) else { continue };
        if terms.iter().any(|other| other.of == term.of) {
            let message = format!("{} is minimised twice", term.of);
            entry.reader.fault(term.span.clone(), message, "leave it out, and change its `weight`");
        }
        terms.push(term);
    }
    let of_margin = terms.iter().find(|term| term.of == Minimised::WorstMargin);
    if let (Some(term), true) = (of_margin, terms.len() > 1) {
        let help = "leave the others out: with a `margin` they are kept away from the limits, too";
        entry.reader.fault(term.span.clone(), "\"worst margin\" is minimised beside others", help);
    }
    let optimise = Optimise {
        variables,
        terms,
        starts: entry.count("starts").unwrap_or(1),
        runs: entry.count("runs").unwrap_or(RUNS),
        margin: entry.number("margin").unwrap_or(MARGIN),
        accuracy: entry.number("accuracy").unwrap_or(ACCURACY),
        span: entry.span.clone(),
    };
    let whole = !varied.is_empty() && !optimise.terms.is_empty();
    (whole && entry.reader.fault_count() == before).then_some(optimise)
}

fn variable(key: &str, entry: &Entry<'_>) -> Option<Variable> {
    let given: Vec<&str> = ["values", "from", "to"].into_iter().filter(|name| entry.has(name)).collect();
    let choice = match &given[..] {
        ["values"] => {
            let values: Vec<_> = entry.values("values").iter().map(|node| listed(entry, node)).collect();
            if values.is_empty() {
                let help = "write a list, such as [\"thin\", \"thick\"]";
                entry.fault_at("values", format!("`{key}` has no values"), help);
                return None;
            }
            Choice::Values(values)
        }
        ["from", "to"] => {
            let (unit, [from, to]) = pair(entry, ["from", "to"])?;
            if from >= to {
                let message = format!("`from` of `{key}` is not below `to`");
                entry.fault_at("to", message, "give the least value as `from` and the greatest as `to`");
                return None;
            }
            Choice::Between { from, to, unit }
        }
        _ => {
            let given = if given.is_empty() { "no values".to_owned() } else { given.join(", ") };
            entry.fault_here(format!("`{key}` has {given}"), "give either from and to, or values");
            return None;
        }
    };
    Some(Variable { key: key.to_owned(), choice, span: entry.span.clone() })
}

fn term(item: NameOrEntry<'_>) -> Option<Term> {
    let (name, weight, span) = match item {
        NameOrEntry::Name(name, span) => (name, 1.0, span),
        NameOrEntry::Entry(entry) => {
            let weight = entry.number("weight").unwrap_or(1.0);
            if weight.is_nan() || weight <= 0.0 {
                let help = "give a weight above zero; worst values of requirements are made better in any case";
                entry.fault_at("weight", format!("`weight` = {weight} is not above zero"), help);
                return None;
            }
            (entry.word("name")?, weight, entry.span.clone())
        }
    };
    Some(Term { of: Minimised::of(name), weight, span })
}
