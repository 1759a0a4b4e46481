//! The text of a scenario as a TOML table.

use crate::fault::Fault;
use toml::de::DeTable;

/// Number of syntax errors that are shown: those that follow are mostly echoes of the first ones.
const SYNTAX_ERRORS: usize = 3;

/// The text as a table, with the places of its values.
pub(crate) fn table(text: &str) -> Result<toml::Spanned<DeTable<'_>>, Vec<Fault>> {
    let (table, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Ok(table);
    }
    let mut faults: Vec<Fault> = errors.iter().map(|error| syntax_fault(text, error)).collect();
    faults.sort_by_key(|fault| fault.span.start);
    faults.truncate(SYNTAX_ERRORS);
    Err(faults)
}

fn syntax_fault(text: &str, error: &toml::de::Error) -> Fault {
    Fault {
        span: error.span().unwrap_or(text.len()..text.len()),
        message: format!("this is not TOML: {}", error.message()),
        help: "see https://toml.io; the faults after this one may follow from it".to_owned(),
    }
}
