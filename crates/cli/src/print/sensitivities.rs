//! Tables of `wireloom sensitivities`: one for each output.

use crate::print::table::Columns;
use crate::print::text::{number, printable, with_unit};
use std::io::{self, Write};
use wireloom::sensitivity::{Derivative, Output, Parameter, Sensitivities, Spread};

/// Prints all derivatives.
pub fn print(found: &Sensitivities, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "at the end of step `{}`", printable(&found.step))?;
    if found.keeps_history {
        writeln!(out, "derivatives leave friction and what else has a history as they are there")?;
    }
    writeln!(out)?;
    let has_tolerances = found.parameters.iter().any(|parameter| parameter.tolerance.is_some());
    for output in &found.outputs {
        let Output { name, unit, value, remark, by, spread } = output;
        let value = value.map_or("has no value here".to_owned(), |value| format!("= {}", with_unit(value, unit)));
        writeln!(out, "{} {value}", printable(name))?;
        if let Some(remark) = remark {
            writeln!(out, "  ({})", printable(remark))?;
        }
        let remarks = by.iter().any(|derivative| derivative.reason.is_some());
        let mut headings = vec!["key", ">value", ">derivative", "unit"];
        if spread.is_some() {
            headings.extend([">tolerance", ">effect", ">share"]);
        }
        headings.extend(remarks.then_some("remark"));
        let mut table = Columns::new(headings);
        for (k, (parameter, derivative)) in found.parameters.iter().zip(by).enumerate() {
            let mut row = vec![
                parameter.key.clone(),
                with_unit(parameter.value, &parameter.unit),
                derivative.value.map_or("none".to_owned(), number),
                ratio(unit, parameter),
            ];
            row.extend(spread.iter().flat_map(|spread| effect(spread, k, parameter, unit)));
            row.extend(remarks.then(|| remark_on(derivative)));
            table.row(row);
        }
        table.print(out)?;
        match spread {
            Some(spread) => sum(spread, unit, &found.tolerances_left_out, out)?,
            None if has_tolerances && output.value.is_some() => {
                writeln!(out, "its spread is not known: a tolerance has no effect that is known\n")?;
            }
            None => {}
        }
    }
    Ok(())
}

/// Tolerance of a parameter, its effect on an output, and its share of the variance.
fn effect(spread: &Spread, k: usize, parameter: &Parameter, unit: &str) -> [String; 3] {
    let Some(tolerance) = &parameter.tolerance else { return Default::default() };
    let part = spread.parts[k];
    let share = if spread.deviation > 0.0 { 1e2 * (part / spread.deviation).powi(2) } else { 0.0 };
    let deviation = |value: f64, unit: &str| format!("± {}", with_unit(value, unit));
    [deviation(tolerance.deviation, &parameter.unit), deviation(part.abs(), unit), format!("{share:.0} %")]
}

/// What all these tolerances together do to an output.
fn sum(spread: &Spread, unit: &str, left_out: &[String], out: &mut dyn Write) -> io::Result<()> {
    let Spread { mean, deviation, deviations_to_limit, remark, .. } = spread;
    write!(out, "with these tolerances {} ± {}", with_unit(*mean, unit), with_unit(*deviation, unit))?;
    match deviations_to_limit {
        Some(n) if *n < 0.0 => write!(out, "; the mean is {:.1} standard deviations beyond the limit", -n)?,
        Some(n) => write!(out, "; the limit is {n:.1} standard deviations away")?,
        None => {}
    }
    writeln!(out)?;
    if !left_out.is_empty() {
        writeln!(out, "  (without what the sweep varies beside them: {})", printable(&left_out.join(", ")))?;
    }
    if let Some(remark) = remark {
        writeln!(out, "  (only a first guess: {})", printable(remark))?;
    }
    writeln!(out)
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
