//! Descriptions of the kinds and models of plugins.

use crate::print::text::printable;
use std::io::{self, Write};
use wireloom::parts::{ConstraintKind, Form, JointKind, Parameter, RodKind, SpanUse, Value};

/// A kind, what it acts on, its parameters and its outputs.
pub fn describe(kind: &ConstraintKind, out: &mut dyn Write) -> io::Result<()> {
    let stations = &kind.attaches.stations;
    let on = match (stations.start(), stations.end()) {
        (0, 0) => String::new(),
        (1, 1) => "one station".into(),
        (a, b) if a == b => format!("{a} stations"),
        (a, b) => format!("{a} to {b} stations"),
    };
    let along = match kind.attaches.span {
        SpanUse::Never => "",
        SpanUse::Maybe => "a span, if one is given",
        SpanUse::Always => "a span",
    };
    let on: Vec<&str> = [on.as_str(), along].into_iter().filter(|words| !words.is_empty()).collect();
    writeln!(out, "  constraint `{}` on {}: {}", kind.name, on.join(" and "), printable(&kind.doc))?;
    describe_parameters(&kind.parameters, out)?;
    kind.outputs.iter().try_for_each(|output| {
        let unit = wireloom::scenario::unit_of(output.quantity);
        let what = if output.event { "event" } else { "output" };
        writeln!(out, "    {what} {} ({unit}): {}", output.name, printable(&output.doc))
    })
}

/// A joint model and its parameters.
pub fn describe_joint(kind: &JointKind, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "  joint model `{}`: {}", kind.name, printable(&kind.doc))?;
    describe_parameters(&kind.parameters, out)
}

/// A rod and its parameters.
pub fn describe_rod(kind: &RodKind, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "  rod `{}`: {}", kind.name, printable(&kind.doc))?;
    describe_parameters(&kind.parameters, out)
}

fn describe_parameters(parameters: &[Parameter], out: &mut dyn Write) -> io::Result<()> {
    for parameter in parameters {
        writeln!(out, "    {} ({}): {}", parameter.name, form(parameter), printable(&parameter.doc))?;
    }
    Ok(())
}

fn form(parameter: &Parameter) -> String {
    let what = match &parameter.form {
        Form::Number { quantity, minimum, exclusive, maximum } => {
            let mut range = String::new();
            if minimum.is_finite() {
                range += &format!(", {} {minimum}", if *exclusive { "above" } else { "at least" });
            }
            if maximum.is_finite() {
                range += &format!(", at most {maximum}");
            }
            format!("{}{range}", wireloom::scenario::unit_of(*quantity))
        }
        Form::Vector { quantity } => format!("three numbers, {}", wireloom::scenario::unit_of(*quantity)),
        Form::Count { minimum } => format!("a whole number, at least {minimum}"),
        Form::Flag => "true or false".into(),
        Form::Choice(words) => words.join(" | "),
    };
    let otherwise = match (&parameter.default, parameter.required) {
        (Some(value), _) => format!("; default {}", plain(value)),
        (None, true) => "; required".into(),
        (None, false) => "; may be left out".into(),
    };
    what + &otherwise
}

fn plain(value: &Value) -> String {
    match value {
        Value::Number(x) => x.to_string(),
        Value::Vector(v) => format!("[{}, {}, {}]", v.x, v.y, v.z),
        Value::Count(n) => n.to_string(),
        Value::Flag(flag) => flag.to_string(),
        Value::Word(word) => word.clone(),
    }
}
