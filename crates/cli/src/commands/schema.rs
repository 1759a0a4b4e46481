//! `wireloom schema`: the JSON Schema of scenarios.

use crate::failure::{Failure, Outcome};
use std::io::Write;

/// Prints the schema with all built-in kinds.
pub fn schema(out: &mut dyn Write) -> Result<Outcome, Failure> {
    let schema = wireloom::scenario::schema(&wireloom::registry());
    writeln!(out, "{schema:#}").map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}
