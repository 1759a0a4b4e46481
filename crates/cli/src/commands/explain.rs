//! `wireloom explain`: a key of scenarios, or a kind.

use crate::arguments::Allowed;
use crate::failure::{Failure, Outcome};
use crate::plugin::load::load_allowed;
use crate::print::text::printable;
use std::io::{self, Write};
use wireloom::scenario::explain::{Explained, explain as explained};

/// Explains a key, or a kind.
pub fn explain(key: &str, allowed: &Allowed, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut registry = wireloom::registry();
    let _libraries = load_allowed(allowed, &mut registry)?;
    let found = explained(key, &registry)
        .map_err(|help| Failure::Input(format!("a scenario has no key `{}`: {help}", key.escape_debug())))?;
    let parts = found.iter().enumerate().try_for_each(|(k, explained)| {
        if k > 0 {
            writeln!(out)?;
        }
        show(explained, out)
    });
    parts.map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}

fn show(explained: &Explained, out: &mut dyn Write) -> io::Result<()> {
    let of = explained.of.as_ref().map_or_else(String::new, |of| format!(", where {of}"));
    let mut say = |line: String| writeln!(out, "{}", printable(&line));
    say(format!("{}{of}", explained.places.join(", ")))?;
    say(format!("  {}", explained.doc))?;
    say(format!("  holds    {}", explained.holds))?;
    match &explained.default {
        Some(default) => say(format!("  default  {default}"))?,
        None if explained.need.is_empty() => {}
        None => say(format!("  need     {}", explained.need))?,
    }
    let mut lines = explained.example.lines();
    say(format!("  example  {}", lines.next().unwrap_or_default()))?;
    lines.try_for_each(|line| say(format!("           {line}")))
}
