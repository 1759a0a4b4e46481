//! `wireloom models`: all kinds that a scenario may name.

use crate::arguments::Allowed;
use crate::failure::{Failure, Outcome};
use crate::plugin::load::load_allowed;
use crate::print::text::printable;
use std::io::{self, Write};
use wireloom::scenario::explain::{Models, models};

/// Lists all kinds with their parameters, those of allowed plugins included.
pub fn list(allowed: &Allowed, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut registry = wireloom::registry();
    let _libraries = load_allowed(allowed, &mut registry)?;
    let all = models(&registry);
    all.iter().try_for_each(|family| list_family(family, out)).map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}

fn list_family(family: &Models, out: &mut dyn Write) -> io::Result<()> {
    let default = family.default.map_or_else(String::new, |default| format!(", default \"{default}\""));
    writeln!(out, "{}: `{}`{default}", family.what, family.key)?;
    for model in &family.models {
        writeln!(out, "  {}", printable(&model.name))?;
        writeln!(out, "    {}", printable(&model.doc))?;
        for parameter in &model.parameters {
            let name = parameter.places.first().and_then(|place| place.rsplit('.').next()).unwrap_or_default();
            let default = parameter.default.as_ref().map(|default| format!("default {default}"));
            let need = default.as_ref().unwrap_or(&parameter.need);
            let line = format!("{name}: {} ({}; {need})", parameter.doc, parameter.holds);
            writeln!(out, "    - {}", printable(&line))?;
        }
    }
    writeln!(out)
}
