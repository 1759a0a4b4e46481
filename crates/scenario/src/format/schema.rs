//! The format as a JSON Schema, derived from the tables of keys.

use super::form::{Family, Form, Key, Keys, Need};
use super::keys;
use super::kinds::{self, KindInfo};
use super::limits::{ANY, Bound, MAX_COUNT};
use super::units;
use crate::read::fixing_types::{FixingType, Types};
use crate::read::library::shipped_fixing_types;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use wireloom_core::registry;
use wireloom_core::{Quantity, Registry};

/// The JSON Schema (2020-12) of scenario files, with the kinds of `registry` and their parameters.
pub fn schema(registry: &Registry) -> Value {
    let mut whole = entry(&keys::SCENARIO, registry);
    whole["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    whole["title"] = json!("Wireloom scenario");
    whole
}

/// The schema of an entry: its keys and, for each kind, the parameters of the kind.
fn entry(table: &Keys, registry: &Registry) -> Value {
    let mut properties = Map::new();
    let (mut required, mut unless, mut with) = (Vec::new(), BTreeMap::<&[&str], Vec<&str>>::new(), Map::new());
    for key in table.keys {
        properties.insert(key.name.to_owned(), property(table, key, registry));
        match key.need {
            Need::Must => required.push(key.name),
            Need::May => {}
            Need::Unless(others) => unless.entry(others).or_default().push(key.name),
            Need::With(other) => drop(with.insert(key.name.to_owned(), json!([other]))),
        }
    }
    let mut object = json!({ "type": "object", "properties": properties, "required": required });
    let mut cases: Vec<Value> = unless.into_iter().map(|(others, keys)| unless_given(others, &keys)).collect();
    if let [only] = &mut cases[..] {
        object["anyOf"] = only["anyOf"].take();
        cases.clear();
    }
    if !with.is_empty() {
        object["dependentRequired"] = Value::Object(with);
    }
    match table.kind() {
        None => object["additionalProperties"] = json!(false),
        Some((key, family, default)) => {
            let kinds = kinds::all(registry, family);
            cases.extend(kinds.iter().map(|kind| when_kind(key, kind, default)));
            if has_types(table) {
                let types = shipped_fixing_types(registry);
                cases.extend(types.iter().filter_map(|(name, of)| when_type(key, name, of.as_ref()?, &kinds)));
                cases.push(when_unknown(key, &kinds, &types));
            }
            object["unevaluatedProperties"] = json!(false);
        }
    }
    if !cases.is_empty() {
        object["allOf"] = Value::Array(cases);
    }
    object
}

/// Condition: one of the `others` is given, or all these keys are.
fn unless_given(others: &[&str], keys: &[&str]) -> Value {
    let mut ways: Vec<Value> = others.iter().map(|other| json!({ "required": [other] })).collect();
    ways.push(json!({ "required": keys }));
    json!({ "anyOf": ways })
}

/// Whether the kind of such an entry may be a type of fixing.
fn has_types(table: &Keys) -> bool {
    matches!(table.kind(), Some((_, Family::Constraint, _))) && table.what != keys::FIXING_TYPE.what
}

/// Condition: an entry of this kind may have the parameters of the kind.
fn when_kind(key: &str, kind: &KindInfo<'_>, default: Option<&str>) -> Value {
    let mut condition = json!({ "properties": { key: { "const": kind.name } } });
    if default != Some(kind.name) {
        condition["required"] = json!([key]);
    }
    let required: Vec<&str> = kind
        .parameters
        .iter()
        .filter(|parameter| parameter.required && parameter.default.is_none())
        .map(|parameter| parameter.name.as_str())
        .collect();
    json!({ "if": condition, "then": { "properties": parameters(kind), "required": required } })
}

/// Condition: an entry of this type of fixing may have the parameters of its kind.
fn when_type(key: &str, name: &str, of: &FixingType, kinds: &[KindInfo<'_>]) -> Option<Value> {
    let kind = kinds.iter().find(|kind| kind.name == of.kind)?;
    let condition = json!({ "properties": { key: { "const": name } }, "required": [key] });
    Some(json!({ "if": condition, "then": { "properties": parameters(kind), "required": of.needs } }))
}

/// Condition: an entry of a type of fixing that is not shipped may have the parameters of any kind.
fn when_unknown(key: &str, kinds: &[KindInfo<'_>], types: &Types) -> Value {
    let known: Vec<&str> = kinds.iter().map(|kind| kind.name).chain(types.keys().map(String::as_str)).collect();
    let condition = json!({ "properties": { key: { "not": { "enum": known } } }, "required": [key] });
    let any: Map<String, Value> = kinds.iter().flat_map(parameters).collect();
    json!({ "if": condition, "then": { "properties": any } })
}

/// The parameters of a kind.
fn parameters(kind: &KindInfo<'_>) -> Map<String, Value> {
    let mut properties = Map::new();
    for parameter in kind.parameters {
        let mut value = parameter_form(&parameter.form);
        value["description"] = json!(described(&parameter.doc, parameter_quantity(&parameter.form)));
        if let Some(default) = &parameter.default {
            value["default"] = plain(default);
        }
        properties.insert(parameter.name.clone(), value);
    }
    properties
}

fn property(table: &Keys, key: &Key, registry: &Registry) -> Value {
    let mut value = match key.form {
        Form::Kind(family, default) => kind(table, family, default, registry),
        _ => form(&key.form, registry),
    };
    value["description"] = json!(described(key.doc, quantity(&key.form)));
    value
}

fn described(doc: &str, quantity: Option<Quantity>) -> String {
    match quantity.map(|quantity| units::words(quantity).unit) {
        None | Some("") => doc.to_owned(),
        Some(unit) => format!("{doc} ({unit})"),
    }
}

fn quantity(form: &Form) -> Option<Quantity> {
    match form {
        Form::Number(quantity, _) | Form::OneOrTwo(quantity, _) | Form::Vector(quantity) => Some(*quantity),
        Form::Points(_) => Some(Quantity::Length),
        _ => None,
    }
}

fn parameter_quantity(form: &registry::Form) -> Option<Quantity> {
    match form {
        registry::Form::Number { quantity, .. } | registry::Form::Vector { quantity } => Some(*quantity),
        registry::Form::Count { .. } | registry::Form::Flag | registry::Form::Choice(_) => None,
    }
}

fn form(form: &Form, registry: &Registry) -> Value {
    match *form {
        Form::Version => json!({ "const": 1 }),
        Form::Name => name(),
        Form::Names => json!({ "type": "array", "items": name() }),
        Form::Kind(..) => name(),
        Form::Number(quantity, bound) => number(quantity, bound),
        Form::OneOrTwo(quantity, bound) => {
            let one = number(quantity, bound);
            json!({ "anyOf": [one, list(one.clone(), 2, Some(2))] })
        }
        Form::Vector(quantity) => list(number(quantity, ANY), 3, Some(3)),
        Form::Direction => direction(),
        Form::Orientation => list(json!({ "type": "number" }), 4, Some(4)),
        Form::Points(least) => list(list(number(Quantity::Length, ANY), 3, Some(3)), least, None),
        Form::Curve(quantities, least) => {
            let point = quantities.map(|quantity| number(quantity, ANY));
            let point = json!({ "type": "array", "prefixItems": point, "minItems": 2, "maxItems": 2 });
            list(point, least, None)
        }
        Form::Directions => list(direction(), 1, Some(2)),
        Form::Count(minimum, maximum) => json!({ "type": "integer", "minimum": minimum, "maximum": maximum }),
        Form::Flag => json!({ "type": "boolean" }),
        Form::Choice(words) => json!({ "enum": words }),
        Form::Quantity => json!({ "type": ["number", "string"] }),
        Form::QuantityOrList => {
            let one = json!({ "type": ["number", "string"] });
            json!({ "anyOf": [one, list(one.clone(), 1, None)] })
        }
        Form::Values => json!({ "type": "array", "minItems": 1 }),
        Form::Conditions => json!({ "type": "object", "minProperties": 1 }),
        Form::Words(words) => list(json!({ "enum": words }), 1, None),
        Form::Table(table) => entry(table, registry),
        Form::Tables(table) => json!({ "type": "array", "items": entry(table, registry) }),
        Form::OneOrMoreTables(table) => {
            let one = entry(table, registry);
            json!({ "anyOf": [one, list(one.clone(), 1, None)] })
        }
        Form::Named(table) => json!({ "type": "object", "additionalProperties": entry(table, registry) }),
        Form::NamesOrTables(table) => {
            let one = json!({ "anyOf": [name(), entry(table, registry)] });
            json!({ "anyOf": [name(), entry(table, registry), { "type": "array", "items": one }] })
        }
    }
}

fn name() -> Value {
    json!({ "type": "string", "minLength": 1 })
}

fn direction() -> Value {
    list(json!({ "type": "number" }), 3, Some(3))
}

fn list(items: Value, least: usize, most: Option<usize>) -> Value {
    let mut list = json!({ "type": "array", "items": items, "minItems": least });
    if let Some(most) = most {
        list["maxItems"] = json!(most);
    }
    list
}

fn kind(table: &Keys, family: Family, default: Option<&str>, registry: &Registry) -> Value {
    let choice = |name: &str, doc: &str| json!({ "const": name, "description": doc });
    let mut choices: Vec<Value> = kinds::all(registry, family).iter().map(|kind| choice(kind.name, kind.doc)).collect();
    let mut value = json!({ "type": "string" });
    if has_types(table) {
        let types = shipped_fixing_types(registry);
        choices.extend(types.iter().filter_map(|(name, of)| Some(choice(name, &of.as_ref()?.doc))));
        let own = "a type of fixing from `fixings` of this file or of a library file";
        choices.push(json!({ "minLength": 1, "description": own }));
        value["anyOf"] = Value::Array(choices);
    } else {
        value["oneOf"] = Value::Array(choices);
    }
    if let Some(default) = default {
        value["default"] = json!(default);
    }
    value
}

/// A number in SI, or a string with a unit.
fn number(quantity: Quantity, bound: Bound) -> Value {
    let bound = bound.of(quantity);
    let least = if bound.exclusive { "exclusiveMinimum" } else { "minimum" };
    let plain = json!({ "type": "number", least: bound.minimum, "maximum": bound.maximum });
    let words = units::words(quantity);
    let text = format!("{} with a unit, such as {}", words.name, words.example);
    json!({ "anyOf": [plain, { "type": "string", "pattern": "^\\s*[+-]?[0-9.]", "description": text }] })
}

fn parameter_form(form: &registry::Form) -> Value {
    match form {
        registry::Form::Number { quantity, minimum, exclusive, maximum } => {
            number(*quantity, Bound { minimum: *minimum, exclusive: *exclusive, maximum: *maximum })
        }
        registry::Form::Vector { quantity } => list(number(*quantity, ANY), 3, Some(3)),
        registry::Form::Count { minimum } => json!({ "type": "integer", "minimum": minimum, "maximum": MAX_COUNT }),
        registry::Form::Flag => json!({ "type": "boolean" }),
        registry::Form::Choice(words) => json!({ "enum": words }),
    }
}

fn plain(value: &registry::Value) -> Value {
    match value {
        registry::Value::Number(x) => json!(x),
        registry::Value::Vector(v) => json!([v.x, v.y, v.z]),
        registry::Value::Count(n) => json!(n),
        registry::Value::Flag(flag) => json!(flag),
        registry::Value::Word(word) => json!(word),
    }
}
