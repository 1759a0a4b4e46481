//! Tables of `wireloom sensitivities`: one for each output.

use crate::print::table::Columns;
use crate::print::text::{number, printable, with_unit};
use std::io::{self, Write};
use wireloom::sensitivity::{Derivative, Output, Parameter, Sensitivities};

/// Prints all derivatives.
pub fn print(found: &Sensitivities, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "at the end of step `{}`", printable(&found.step))?;
    if found.keeps_history {
        writeln!(out, "friction and what else has a history stay as they are there")?;
    }
    writeln!(out)?;
    for output in &found.outputs {
        let Output { name, unit, value, remark, by } = output;
        let value = value.map_or("has no value here".to_owned(), |value| format!("= {}", with_unit(value, unit)));
        writeln!(out, "{} {value}", printable(name))?;
        if let Some(remark) = remark {
            writeln!(out, "  ({})", printable(remark))?;
        }
        let remarks = by.iter().any(|derivative| derivative.reason.is_some());
        let headings = ["key", ">value", ">derivative", "unit", "remark"];
        let mut table = Columns::new(headings.into_iter().take(if remarks { 5 } else { 4 }));
        for (parameter, derivative) in found.parameters.iter().zip(by) {
            let row = [
                parameter.key.clone(),
                with_unit(parameter.value, &parameter.unit),
                derivative.value.map_or("none".to_owned(), number),
                ratio(unit, parameter),
                remark_on(derivative),
            ];
            table.row(row.into_iter().take(if remarks { 5 } else { 4 }));
        }
        table.print(out)?;
    }
    Ok(())
}

/// Unit of a derivative.
fn ratio(unit: &str, parameter: &Parameter) -> String {
    let of = if unit.is_empty() { "1" } else { unit };
    if parameter.unit.is_empty() { unit.to_owned() } else { format!("{of} per {}", parameter.unit) }
}

/// Why there is no derivative, and those of both sides.
fn remark_on(Derivative { sides: [below, above], reason, .. }: &Derivative) -> String {
    let sides = [("below", below), ("above", above)];
    let sides = sides.into_iter().filter_map(|(side, value)| Some(format!("{side}: {}", number((*value)?))));
    let sides: Vec<String> = sides.collect();
    let reason = reason.clone().unwrap_or_default();
    if sides.is_empty() { reason } else { format!("{} ({reason})", sides.join(", ")) }
}
