//! The table of what was grasped, carried, mated and clipped.

use crate::summary::Columns;
use std::io::{self, Write};
use wireloom::core::Run;
use wireloom::core::equilibrium::OperationResult;

/// Rows that are shown.
const ROWS: usize = 40;

/// Prints the operations of a run, each as the last increment of its step has it.
pub fn print(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let mut table = Columns::new(["operation", "of", "in step", "came to"]);
    let mut rows = 0;
    for (k, end) in run.steps.iter().enumerate() {
        if run.steps.get(k + 1).is_some_and(|next| next.name == end.name && next.increment > end.increment) {
            continue;
        }
        for operation in &end.operations {
            rows += 1;
            if rows <= ROWS {
                let (word, of, result) = words(operation);
                table.row([word.to_owned(), of, end.name.clone(), result]);
            }
        }
    }
    table.print(out)?;
    if rows > ROWS { writeln!(out, "({} more operations: see result.json)\n", rows - ROWS) } else { Ok(()) }
}

/// The operation, what takes part, and what it came to.
fn words(operation: &OperationResult) -> (&'static str, String, String) {
    let at = |place: &Option<(String, f64)>| match place {
        Some((branch, s)) => format!("at s = {:.1} mm of {branch}", 1e3 * s),
        None => "at a joint".to_owned(),
    };
    match operation {
        OperationResult::Grasp { constraint, place } => ("grasp", constraint.clone(), at(place)),
        OperationResult::Carry { constraints, force } => {
            ("carry", constraints.join(", "), format!("largest force {force:.3} N"))
        }
        OperationResult::Mate { constraint, insertion_force, limit } => {
            let force =
                insertion_force.map_or_else(|| "not pushed home".into(), |f| format!("insertion force {f:.2} N"));
            let limit = match (limit, insertion_force) {
                (Some(limit), Some(force)) if force > limit => format!(", TOO LARGE: allowed {limit} N"),
                (Some(limit), _) => format!(", allowed {limit} N"),
                (None, _) => String::new(),
            };
            ("mate", constraint.clone(), force + &limit)
        }
        OperationResult::Clip { constraint, place, reach } => {
            ("clip", constraint.clone(), format!("{}, {:.1} mm from its seat", at(place), 1e3 * reach))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_insertion_force_is_compared_with_what_is_allowed() {
        let mate =
            |force, limit| words(&OperationResult::Mate { constraint: "B".into(), insertion_force: force, limit }).2;
        assert_eq!(mate(Some(46.0), Some(45.0)), "insertion force 46.00 N, TOO LARGE: allowed 45 N");
        assert_eq!(mate(Some(44.0), Some(45.0)), "insertion force 44.00 N, allowed 45 N");
        assert_eq!(mate(Some(44.0), None), "insertion force 44.00 N");
        assert_eq!(mate(None, None), "not pushed home");
    }
}
