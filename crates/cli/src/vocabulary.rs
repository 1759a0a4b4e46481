//! `wireloom models` and `wireloom explain`: what a scenario may say.

use crate::arguments::Allowed;
use crate::failure::{Failure, Outcome};
use crate::plugins;
use crate::summary::printable;
use std::io::{self, Write};
use wireloom::scenario::explain::{Explained, Models, explain, models};

/// Every kind there is, with its parameters; those of allowed plugins, too.
pub fn list(allowed: &Allowed, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut registry = wireloom::registry();
    let _libraries = plugins::load_allowed(allowed, &mut registry)?;
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

/// A key, or a kind, in words.
pub fn explain_key(key: &str, allowed: &Allowed, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let mut registry = wireloom::registry();
    let _libraries = plugins::load_allowed(allowed, &mut registry)?;
    let found = explain(key, &registry)
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
