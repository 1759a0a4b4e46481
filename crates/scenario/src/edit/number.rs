//! The number at a key of a scenario's text, with its unit.

use super::adjust::quoted;
use super::key_path::{NAMES, below, parts};
use super::record::{as_json, value_at};
use crate::fault::Fault;
use crate::format::form::Form;
use crate::format::{keys, kinds, units};
use serde_json::Value;
use wireloom_core::{Registry, registry};

/// A number of a scenario's text.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Its value in SI units.
    pub value: f64,
    /// SI unit; empty for a pure number.
    pub unit: String,
    /// Its size; of a component that of the largest number of its list.
    pub scale: f64,
}

/// The number at a key of the text; `key` as in [`crate::settings`], without `*`.
///
/// # Errors
/// If the text is not TOML, there is no such key, or what it holds is not one number that may vary continuously. The
/// place is that in the text, or its end.
pub fn number_at(text: &str, key: &str, registry: &Registry) -> Result<Number, Fault> {
    let refused = |message: String, help: String| Fault { span: text.len()..text.len(), message, help };
    let found = value_at(text, key)?;
    let form = form_at(key);
    if matches!(form, Some(Form::Count(..) | Form::Version)) {
        let help = "name a number that may have any value between two others, such as a length or a stiffness";
        return Err(refused(format!("`{key}` = {found} is a whole number, which does not vary"), help.to_owned()));
    }
    let unit = quantity_at(key)
        .or_else(|| of_kind(text, key, registry))
        .map(|quantity| units::words(quantity).unit.to_owned());
    let list = parts(key, 0).ok().and_then(|parts| {
        let last = parts.last()?;
        value_at(text, key.get(..last.span.start.checked_sub(1)?)?).ok()
    });
    let beside = list.as_ref().and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let scale = |value: f64| beside.iter().filter_map(si).map(f64::abs).fold(value.abs(), f64::max);
    match &found {
        Value::Number(number) => {
            let value = number.as_f64().unwrap_or(f64::NAN);
            Ok(Number { value, unit: unit.unwrap_or_default(), scale: scale(value) })
        }
        Value::String(word) => match units::any(word) {
            Ok((value, symbols)) => Ok(Number { value, unit: unit.unwrap_or(symbols), scale: scale(value) }),
            Err(_) => Err(refused(format!("`{key}` = {found} is a word, not a number"), "name a number".to_owned())),
        },
        Value::Array(list) if !list.is_empty() => {
            let help = format!("name one of its numbers, such as `{key}.0`");
            Err(refused(format!("`{key}` is a list of {}, not a number", list.len()), help))
        }
        other => {
            let what = match other {
                Value::Object(_) => "a table".to_owned(),
                plain => plain.to_string(),
            };
            Err(refused(format!("`{key}` is {what}, not a number"), "name a number".to_owned()))
        }
    }
}

/// Keys of the lengths and places of a text, of which a designer chooses: lengths of branches, arc lengths and
/// positions of constraints, and positions to which steps move something.
///
/// # Errors
/// If the text is not TOML.
pub fn lengths_and_places(text: &str) -> Result<Vec<String>, Fault> {
    let scenario = as_json(text)?;
    let mut keys = Vec::new();
    for (branch, own) in entries(&scenario, "branches") {
        keys.extend(own.get("length").map(|_| format!("{branch}.length")));
    }
    for (constraint, own) in entries(&scenario, "constraints") {
        keys.extend(own.pointer("/at/s").map(|_| format!("{constraint}.at.s")));
        keys.extend(components(&constraint, own));
    }
    for (step, own) in entries(&scenario, "steps") {
        for (moved, own) in entries(own, "move") {
            keys.extend(components(&format!("{step}.{moved}"), own));
        }
    }
    Ok(keys)
}

/// The entries of a list, each with its path from the table that has it.
fn entries<'v>(table: &'v Value, list: &str) -> impl Iterator<Item = (String, &'v Value)> {
    let all = table.get(list).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let path = format!("{list}.");
    all.iter().enumerate().map(move |(k, entry)| {
        let name = NAMES.iter().find_map(|key| entry.get(*key)?.as_str());
        (path.clone() + &name.map_or_else(|| k.to_string(), quoted), entry)
    })
}

/// Keys of the components of an entry's position.
fn components(entry: &str, own: &Value) -> impl Iterator<Item = String> {
    let count = own.get("position").and_then(Value::as_array).map_or(0, Vec::len);
    (0..count).map(move |k| format!("{entry}.position.{k}"))
}

/// A value for a key, as a user writes it: a number in SI units, or one with a unit of the key's quantity.
///
/// # Errors
/// What is wrong with it.
pub fn value_for(text: &str, key: &str, written: &str, registry: &Registry) -> Result<f64, String> {
    if let Ok(value) = written.trim().parse::<f64>() {
        return if value.is_finite() { Ok(value) } else { Err(format!("`{written}` is not a finite number")) };
    }
    let found = match quantity_at(key).or_else(|| of_kind(text, key, registry)) {
        Some(quantity) => units::parse(written, quantity),
        None => units::any(written).map(|(value, _)| value),
    };
    found.map_err(|words| format!("`{written}` {words}"))
}

/// A number as it is written, in SI units.
fn si(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| units::any(value.as_str()?).ok().map(|(value, _)| value))
}

/// Quantity of the number at a key, if the tables of keys have it.
fn quantity_at(key: &str) -> Option<wireloom_core::Quantity> {
    match form_at(key)? {
        Form::Curve(quantities, _) => {
            let last = parts(key, 0).ok()?.last()?.name.parse::<usize>().ok()?;
            quantities.get(last).copied()
        }
        form => form.bound().map(|(quantity, _)| quantity),
    }
}

/// Form of the value of a key, if the tables of keys have it; of a component of a list that of the list.
fn form_at(key: &str) -> Option<Form> {
    let (mut at, mut form) = (Some(&keys::SCENARIO), None);
    for part in parts(key, 0).ok()? {
        let component = at.is_none() && part.name.parse::<usize>().is_ok();
        form = at.and_then(|keys| keys.get(&part.name)).map(|key| key.form).or(form.filter(|_| component));
        at = below(at, &part.name).0;
    }
    form
}

/// Quantity of a parameter of the kind of its entry.
fn of_kind(text: &str, key: &str, registry: &Registry) -> Option<wireloom_core::Quantity> {
    let parts = parts(key, 0).ok()?;
    let (last, way) = parts.split_last()?;
    let entry = way.iter().try_fold(&keys::SCENARIO, |at, part| below(Some(at), &part.name).0)?;
    let (name, family, default) = entry.kind()?;
    let chosen = value_at(text, &format!("{}.{name}", &key[..last.span.start.checked_sub(1)?])).ok();
    let word = chosen.as_ref().and_then(Value::as_str).or(default)?;
    let kind = kinds::all(registry, family).into_iter().find(|kind| kind.name == word)?;
    let parameter = kind.parameters.iter().find(|parameter| parameter.name == last.name)?;
    match parameter.form {
        registry::Form::Number { quantity, .. } | registry::Form::Vector { quantity, .. } => Some(quantity),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
schema = 1
gravity = [0, 0, -9.81]
[sections.length]
bending_stiffness = [0.01, 0.012]
diameter = "6 mm"
bending_curve = [[1, 0.01], [2, "15 N mm"]]
[[branches]]
name = "b.1"
length = "1 m"
segments = 4
[[constraints]]
name = "hand"
kind = "handle"
stiffness = 500
at = { branch = "b.1", s = 0.2 }
"#;

    fn at(key: &str) -> Result<(f64, String), String> {
        let found = number_at(TEXT, key, &Registry::default());
        found.map(|number| (number.value, number.unit)).map_err(|fault| format!("{} - {}", fault.message, fault.help))
    }

    #[test]
    fn numbers_have_the_units_of_their_keys() {
        let is = |key: &str, value: f64, unit: &str| assert_eq!(at(key), Ok((value, unit.to_owned())), "{key}");
        is("sections.length.bending_stiffness.1", 0.012, "N m²");
        is("sections.length.diameter", 0.006, "m");
        is("sections.length.bending_curve.1.0", 2.0, "1/m");
        is("sections.length.bending_curve.1.1", 0.015, "N m");
        is("branches.\"b.1\".length", 1.0, "m");
        is("gravity.2", -9.81, "m/s²");
        is("constraints.hand.at.s", 0.2, "m");
        // The registry has no kinds here.
        is("constraints.hand.stiffness", 500.0, "");
        let scale = |key: &str| number_at(TEXT, key, &Registry::default()).unwrap().scale;
        assert_eq!((scale("gravity.0"), scale("branches.\"b.1\".length")), (9.81, 1.0));
    }

    #[test]
    fn values_for_a_key_have_its_unit_or_none() {
        let value = |key: &str, written: &str| value_for(TEXT, key, written, &Registry::default());
        assert_eq!(value("branches.\"b.1\".length", " 5 mm"), Ok(0.005));
        assert_eq!(value("constraints.hand.at.s", "0.25"), Ok(0.25));
        for (written, says) in
            [("5 N", "is a force, not a length"), ("five", "is not a length"), ("inf", "is not a finite number")]
        {
            let said = value("branches.\"b.1\".length", written).unwrap_err();
            assert!(said.contains(says), "{said}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        let says = |key: &str, words: &str| {
            let said = at(key).unwrap_err();
            assert!(said.contains(words), "{said}");
        };
        says("branches.\"b.1\".segments", "is a whole number");
        says("branches.\"b.1\".name", "is a word");
        says("sections.length.bending_stiffness", "is a list of 2, not a number - name one of its numbers");
        says("sections.length", "is a table");
        says("sections.lenght.diameter", "there is no `lenght`");
        says("branches..length", "a part of it is empty");
    }
}
