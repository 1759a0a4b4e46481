//! Kinds of the registry, and their open parameters.

use super::entry::Entry;
use super::fixing_types::{FixingType, Types};
use crate::fault::{did_you_mean, nearest};
use crate::format::kinds::{KindInfo, all};
use crate::format::limits::{Bound, MAX_COUNT};
use std::collections::BTreeMap;
use wireloom_core::registry;
use wireloom_core::{Parameters, Registry, Value};

/// A kind that a scenario chooses.
pub(crate) struct Chosen {
    /// Its name in the file: that of the kind, or of a type of fixing.
    pub name: String,
    /// Name of the kind.
    pub kind: String,
    /// Its parameters, checked, with defaults.
    pub parameters: Parameters,
}

/// The kind of an entry and its parameters; refuses all keys that are neither the entry's nor the kind's.
/// `None` if the kind is unknown (then only keys of no kind at all are refused) or a parameter is faulty.
pub(crate) fn read(entry: &Entry<'_>) -> Option<Chosen> {
    read_among(entry, &Types::new(), None).map(|(chosen, _)| chosen)
}

/// Likewise, for an entry that may also name one of these types of fixings, which sets parameters; `of_part`: the type
/// of its part number, which counts where it names a kind and not a type.
pub(crate) fn read_among<'t>(
    entry: &Entry<'_>,
    types: &'t Types,
    of_part: Option<&'t str>,
) -> Option<(Chosen, Option<&'t FixingType>)> {
    let (key, family, default) = entry.keys.kind()?;
    let registry: &Registry = entry.reader.registry;
    let kinds = all(registry, family);
    let given = match entry.node(key) {
        Some(node) => entry.reader.word(key, node),
        None => default,
    };
    let given = given.map(|name| of_part.filter(|_| !types.contains_key(name)).unwrap_or(name));
    let named = given.and_then(|name| types.get(name));
    let fixing_type = named.and_then(Option::as_ref);
    let own_name = fixing_type.map(|of| of.kind.as_str()).or(given);
    let kind = own_name.and_then(|name| kinds.iter().find(|kind| kind.name == name));
    let Some(kind) = kind else {
        if let (Some(name), None) = (given, named) {
            let known = kinds.iter().map(|kind| kind.name).chain(types.keys().map(String::as_str));
            let mut help = did_you_mean(name, known.clone());
            if nearest(name, known).is_none() {
                help += "; for a kind of a plugin, name the plugin in `load` of [plugins]";
            }
            entry.fault_at(key, format!("unknown {} \"{name}\" in {}", family.word(), entry.label), help);
        }
        entry.refuse_unknown_keys(kinds.iter().flat_map(|kind| kind.parameters.iter().map(|p| p.name.as_str())));
        return None;
    };
    entry.refuse_unknown_keys(kind.parameters.iter().map(|p| p.name.as_str()));
    let before = entry.reader.fault_count();
    let parameters = parameters(entry, kind, fixing_type.map(|of| &of.parameters));
    let chosen = Chosen { name: given?.to_owned(), kind: kind.name.to_owned(), parameters };
    (entry.reader.fault_count() == before).then_some((chosen, fixing_type))
}

/// The parameters of a kind; `set` gives those that are left out. A faulty one is omitted.
fn parameters(entry: &Entry<'_>, kind: &KindInfo<'_>, set: Option<&Parameters>) -> Parameters {
    let mut values = BTreeMap::new();
    for parameter in kind.parameters {
        let name = parameter.name.as_str();
        let set = set.and_then(|set| set.0.get(name));
        let value = match entry.table.get(name) {
            Some(node) => read_value(entry, name, node, &parameter.form),
            None if set.is_some() => set.cloned(),
            None if parameter.required && parameter.default.is_none() => {
                entry.missing(name, &parameter.doc);
                None
            }
            None => parameter.default.clone(),
        };
        if let Some(value) = value {
            values.insert(name.to_owned(), value);
        }
    }
    Parameters(values)
}

fn read_value(
    entry: &Entry<'_>,
    name: &str,
    node: &toml::Spanned<toml::de::DeValue<'_>>,
    form: &registry::Form,
) -> Option<Value> {
    let reader = entry.reader;
    match form {
        registry::Form::Number { quantity, minimum, exclusive, maximum } => {
            let bound = Bound { minimum: *minimum, exclusive: *exclusive, maximum: *maximum };
            reader.number(name, node, *quantity, bound).map(Value::Number)
        }
        registry::Form::Vector { quantity } => reader.vector(name, node, *quantity).map(Value::Vector),
        registry::Form::Count { minimum } => reader.count(name, node, *minimum, MAX_COUNT).map(Value::Count),
        registry::Form::Flag => reader.flag(name, node).map(Value::Flag),
        registry::Form::Choice(words) => {
            reader.choice(name, node, words.iter().map(String::as_str)).map(|word| Value::Word(word.to_owned()))
        }
    }
}
