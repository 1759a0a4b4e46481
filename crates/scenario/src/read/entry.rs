//! An entry of a scenario: a table, and the keys that it may have.

use super::reader::{Node, Reader};
use crate::fault::{did_you_mean, nearest};
use crate::format::form::{Form, Key, Keys, Need};
use crate::format::limits::ANY;
use crate::format::units::words;
use crate::span::{Span, Spans};
use nalgebra::Unit;
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};
use wireloom_core::identity::Identity;
use wireloom_core::{Quantity, Rotation, Vector};

/// An entry of the file: a table, and the keys it may have.
pub(crate) struct Entry<'a> {
    pub reader: &'a Reader<'a>,
    pub table: &'a DeTable<'a>,
    pub keys: &'static Keys,
    /// Its place in the text.
    pub span: Span,
    /// Its name in messages: `branch "trunk"`.
    pub label: String,
}

impl<'a> Entry<'a> {
    /// An entry. Keys that are not declared are refused at once, except for entries of a kind: those may
    /// have the kind's parameters, see [`super::kinds::read`].
    pub fn new(reader: &'a Reader<'a>, table: &'a DeTable<'a>, span: Span, keys: &'static Keys, label: String) -> Self {
        let entry = Self { reader, table, keys, span, label };
        if keys.kind().is_none() {
            entry.refuse_unknown_keys(std::iter::empty());
        }
        entry
    }

    /// The declared key. An undeclared one is a mistake of this crate, which every test would meet.
    fn key(&self, name: &str) -> &'static Key {
        self.keys.get(name).unwrap_or_else(|| unreachable!("{} has no key {name}", self.keys.what))
    }

    /// The value of a key; notes a fault if it must be given and is not.
    pub fn node(&self, name: &str) -> Option<&'a Node<'a>> {
        let key = self.key(name);
        let node = self.table.get(name);
        let needed = match key.need {
            Need::Must => true,
            Need::Unless(others) => !others.iter().any(|other| self.has(other)),
            Need::May | Need::With(_) => false,
        };
        if node.is_none() && needed && !self.misspelt(name) {
            self.missing(key.name, key.doc);
        }
        if let (Some(node), Need::With(other)) = (node, key.need)
            && !self.has(other)
            && !self.misspelt(other)
        {
            let message = format!("{} has `{name}` but no `{other}`", self.label);
            self.reader.fault(
                node.span(),
                message,
                format!("it has no meaning without `{other}`: leave it out, or add that"),
            );
        }
        node
    }

    /// Whether an unknown key is probably this one misspelt; one fault is enough then.
    pub(super) fn misspelt(&self, name: &str) -> bool {
        let own = || self.keys.keys.iter().map(|key| key.name);
        self.table
            .keys()
            .any(|key| self.keys.get(key.get_ref()).is_none() && nearest(key.get_ref(), own()) == Some(name))
    }

    /// Notes that a key is missing.
    pub fn missing(&self, name: &str, doc: &str) {
        self.fault_here(format!("{} has no `{name}`", self.label), format!("add `{name}`: {doc}"));
    }

    /// Notes a fault of the whole entry.
    pub fn fault_here(&self, message: impl Into<String>, help: impl Into<String>) {
        self.reader.fault(self.span.clone(), message, help);
    }

    /// Notes a fault at the value of a key, or at the whole entry if the key is left out.
    pub fn fault_at(&self, name: &str, message: impl Into<String>, help: impl Into<String>) {
        self.reader.fault(self.span_of(name), message, help);
    }

    /// Place of the value of a key, or of the whole entry if the key is left out.
    pub fn span_of(&self, name: &str) -> Span {
        self.table.get(name).map_or_else(|| self.span.clone(), Spanned::span)
    }

    /// Whether a key is given.
    pub fn has(&self, name: &str) -> bool {
        self.table.contains_key(name)
    }

    /// Places of the entry and of all its values.
    pub fn spans(&self) -> Spans {
        let keys = self.table.iter().map(|(key, value)| (key.get_ref().to_string(), value.span())).collect();
        Spans { entry: self.span.clone(), keys }
    }

    /// Notes keys that are neither declared nor parameters of the entry's kind.
    pub fn refuse_unknown_keys<'w>(&self, parameters: impl IntoIterator<Item = &'w str> + Clone) {
        let own = self.keys.keys.iter().map(|key| key.name);
        let known: Vec<&str> = own.chain(parameters).collect();
        for (key, value) in self.table {
            let name = key.get_ref().as_ref();
            if known.contains(&name) {
                continue;
            }
            let span = if key.span().is_empty() { value.span() } else { key.span() };
            let message = format!("unknown key `{name}` in {}", self.label);
            self.reader.fault(span, message, did_you_mean(name, known.iter().copied()));
        }
    }

    /// A string.
    pub fn word(&self, name: &str) -> Option<&'a str> {
        self.node(name).and_then(|node| self.reader.word(name, node))
    }

    /// The string of a key, if it is one that is not empty; faults are noted where the key is read by [`Self::word`].
    pub fn text(&self, name: &str) -> Option<&'a str> {
        match self.table.get(name).map(Spanned::get_ref) {
            Some(DeValue::String(text)) if !text.is_empty() => Some(text.as_ref()),
            _ => None,
        }
    }

    /// A number in SI.
    pub fn number(&self, name: &str) -> Option<f64> {
        let Form::Number(quantity, bound) = self.key(name).form else { unreachable!("{name} is no number") };
        self.node(name).and_then(|node| self.reader.number(name, node, quantity, bound))
    }

    /// A number, or two.
    pub fn one_or_two(&self, name: &str) -> Option<[f64; 2]> {
        let Form::OneOrTwo(quantity, bound) = self.key(name).form else { unreachable!("{name} is no pair") };
        let node = self.node(name)?;
        let DeValue::Array(list) = node.get_ref() else {
            return self.reader.number(name, node, quantity, bound).map(|x| [x, x]);
        };
        let [a, b] = list.as_ref() else {
            self.reader.mismatch(name, node, "a number or a list of two", "write one number, or two in brackets");
            return None;
        };
        let both = [a, b].map(|item| self.reader.number(name, item, quantity, bound));
        Some([both[0]?, both[1]?])
    }

    /// Three numbers.
    pub fn vector(&self, name: &str) -> Option<Vector> {
        let Form::Vector(quantity) = self.key(name).form else { unreachable!("{name} is no vector") };
        self.node(name).and_then(|node| self.reader.vector(name, node, quantity))
    }

    /// A unit vector.
    pub fn direction(&self, name: &str) -> Option<Unit<Vector>> {
        self.node(name).and_then(|node| self.reader.direction(name, node))
    }

    /// A rotation.
    pub fn orientation(&self, name: &str) -> Option<Rotation> {
        self.node(name).and_then(|node| self.reader.orientation(name, node))
    }

    /// A whole number.
    pub fn count(&self, name: &str) -> Option<usize> {
        let Form::Count(minimum, maximum) = self.key(name).form else { unreachable!("{name} is no count") };
        self.node(name).and_then(|node| self.reader.count(name, node, minimum, maximum))
    }

    /// true or false.
    pub fn flag(&self, name: &str) -> Option<bool> {
        self.node(name).and_then(|node| self.reader.flag(name, node))
    }

    /// Part number, description, supplier and colour.
    pub fn identity(&self) -> Identity {
        let word = |key: &str| self.word(key).map(str::to_owned);
        Identity {
            part: word("part"),
            description: word("description"),
            supplier: word("supplier"),
            colour: word("colour"),
        }
    }

    /// The values of a list; empty if it is left out or not a list.
    fn list(&self, name: &str) -> &'a [Node<'a>] {
        let Some(node) = self.node(name) else { return &[] };
        if let DeValue::Array(list) = node.get_ref() {
            return list;
        }
        self.reader.mismatch(name, node, "a list", "write a list in brackets");
        &[]
    }

    /// The values of a list, or one value alone.
    pub fn items(&self, name: &str) -> &'a [Node<'a>] {
        match self.node(name) {
            Some(node) => match node.get_ref() {
                DeValue::Array(list) => list,
                _ => std::slice::from_ref(node),
            },
            None => &[],
        }
    }

    /// Points of a list.
    pub fn points(&self, name: &str) -> Option<Vec<Vector>> {
        let Form::Points(least) = self.key(name).form else { unreachable!("{name} are no points") };
        let list = self.list(name);
        if self.has(name) && list.len() < least {
            self.fault_at(
                name,
                format!("`{name}` of {} has {} points", self.label, list.len()),
                format!("give a list of at least {least}, such as [[0, 0, 0], [1, 0, 0]]"),
            );
            return None;
        }
        list.iter().map(|item| self.reader.vector(name, item, Quantity::Length)).collect()
    }

    /// Points of a curve, SI, in the order in which they are given.
    pub fn curve(&self, name: &str) -> Option<Vec<[f64; 2]>> {
        let Form::Curve(quantities, least) = self.key(name).form else { unreachable!("{name} is no curve") };
        let list = self.list(name);
        let point = |item: &Node<'_>| {
            let DeValue::Array(pair) = item.get_ref() else {
                self.reader.mismatch(name, item, "a pair", "write two numbers in brackets");
                return None;
            };
            let [x, y] = pair.as_ref() else {
                self.reader.mismatch(name, item, "a pair", "write two numbers in brackets");
                return None;
            };
            let [x, y] = [(x, quantities[0]), (y, quantities[1])]
                .map(|(node, quantity)| self.reader.number(name, node, quantity, ANY));
            Some([x?, y?])
        };
        let points: Vec<Option<[f64; 2]>> = list.iter().map(point).collect();
        let points: Vec<[f64; 2]> = points.into_iter().collect::<Option<_>>()?;
        if !self.has(name) {
            return None;
        }
        if points.len() < least {
            let message = format!("`{name}` of {} has {} points", self.label, points.len());
            self.fault_at(name, message, format!("give at least {least}"));
            return None;
        }
        for (k, [[x, y], [u, v]]) in points.array_windows().enumerate() {
            for (at, before, after, quantity) in [(0, x, u, quantities[0]), (1, y, v, quantities[1])] {
                if after > before {
                    continue;
                }
                let unit = words(quantity).unit;
                let message = format!("`{name}` goes from {before} to {after} {unit}").trim_end().to_owned();
                let help = "give points in the order in which both numbers increase: a cable whose force or moment \
                            falls is not stable";
                self.reader.fault(pair_span(&list[k + 1], at), message, help);
                return None;
            }
        }
        Some(points)
    }

    /// Unit vectors of a list.
    pub fn directions(&self, name: &str) -> Option<Vec<Unit<Vector>>> {
        self.list(name).iter().map(|item| self.reader.direction(name, item)).collect()
    }

    /// One of the words declared.
    pub fn choice(&self, name: &str) -> Option<&'a str> {
        let Form::Choice(words) = self.key(name).form else { unreachable!("{name} is no choice") };
        self.node(name).and_then(|node| self.reader.choice(name, node, words.iter().copied()))
    }

    /// The values of a list, of any kind.
    pub fn values(&self, name: &str) -> &'a [Node<'a>] {
        let Form::Values = self.key(name).form else { unreachable!("{name} is no list of values") };
        self.list(name)
    }

    /// Keys with their values, each with its place, in the order of the text.
    pub fn conditions(&self, name: &str) -> Vec<(&'a str, &'a [Node<'a>], Span)> {
        let Form::Conditions = self.key(name).form else { unreachable!("{name} are no conditions") };
        let Some(node) = self.node(name) else { return Vec::new() };
        let DeValue::Table(table) = node.get_ref() else {
            let help = "write the key with its value, such as { \"joints.J.model\" = \"cosserat\" }";
            self.reader.mismatch(name, node, "a table", help);
            return Vec::new();
        };
        if table.is_empty() {
            self.fault_at(name, format!("`{name}` of {} is empty", self.label), "leave it out");
        }
        let one = |(key, value): (&'a Spanned<Cow<'a, str>>, &'a Node<'a>)| {
            let values = match value.get_ref() {
                DeValue::Array(list) => list.as_ref(),
                _ => std::slice::from_ref(value),
            };
            (key.get_ref().as_ref(), values, value.span())
        };
        let mut all: Vec<_> = table.iter().map(one).collect();
        all.sort_by_key(|(_, _, span)| span.start);
        all
    }

    /// Words of a list, each one of those declared.
    pub fn choices(&self, name: &str) -> Vec<&'a str> {
        let Form::Words(words) = self.key(name).form else { unreachable!("{name} are no words") };
        self.list(name).iter().filter_map(|item| self.reader.choice(name, item, words.iter().copied())).collect()
    }

    /// Names of a list, with their places.
    pub fn names(&self, name: &str) -> Vec<(&'a str, Span)> {
        self.list(name).iter().filter_map(|item| Some((self.reader.word(name, item)?, item.span()))).collect()
    }

    /// The strings of a list; other items are ignored, as [`Self::names`] notes their faults.
    pub fn texts(&self, name: &str) -> Vec<&'a str> {
        let Some(DeValue::Array(list)) = self.table.get(name).map(Spanned::get_ref) else { return Vec::new() };
        let text =
            |item: &'a Node<'a>| if let DeValue::String(text) = item.get_ref() { Some(text.as_ref()) } else { None };
        list.iter().filter_map(text).collect()
    }

    /// A table as an entry of its own.
    pub fn entry(&self, name: &str) -> Option<Entry<'a>> {
        let Form::Table(keys) = self.key(name).form else { unreachable!("{name} is no table") };
        let node = self.node(name)?;
        let DeValue::Table(table) = node.get_ref() else {
            self.reader.mismatch(name, node, "a table", format!("write its keys in a table: {}", some_keys(keys)));
            return None;
        };
        Some(Entry::new(self.reader, table, node.span(), keys, format!("`{name}` of {}", self.label)))
    }

    /// A table, or those of a list, as entries of their own.
    pub fn one_or_more(&self, name: &str) -> Vec<Entry<'a>> {
        let Form::OneOrMoreTables(keys) = self.key(name).form else { return self.entry(name).into_iter().collect() };
        let Some(node) = self.node(name) else { return Vec::new() };
        let items = match node.get_ref() {
            DeValue::Array(list) => list.as_ref(),
            _ => std::slice::from_ref(node),
        };
        if items.is_empty() {
            self.fault_at(
                name,
                format!("`{name}` of {} is empty", self.label),
                "give at least one table, or leave it out",
            );
        }
        let one = |item: &'a Node<'a>| match item.get_ref() {
            DeValue::Table(table) => {
                Some(Entry::new(self.reader, table, item.span(), keys, format!("`{name}` of {}", self.label)))
            }
            _ => {
                let help = format!("write a table with keys {}, or a list of them", some_keys(keys));
                self.reader.mismatch(name, item, "a table", help);
                None
            }
        };
        items.iter().filter_map(one).collect()
    }

    /// Tables as entries of their own, labelled by their name or by the entry that they belong to.
    pub fn entries(&self, name: &str) -> Vec<Entry<'a>> {
        let Form::Tables(keys) = self.key(name).form else { unreachable!("{name} are no tables") };
        let entry = |item: &'a Node<'a>| {
            let DeValue::Table(table) = item.get_ref() else {
                self.reader.mismatch(name, item, "a table", format!("write tables with keys: {}", some_keys(keys)));
                return None;
            };
            let label = match (keys.get("name"), table.get("name").map(Spanned::get_ref)) {
                (Some(_), Some(DeValue::String(own))) => format!("{} \"{own}\"", keys.what),
                (Some(_), _) => keys.what.to_owned(),
                (None, _) => format!("`{name}` of {}", self.label),
            };
            Some(Entry::new(self.reader, table, item.span(), keys, label))
        };
        self.list(name).iter().filter_map(entry).collect()
    }

    /// Names and tables, alone or in a list.
    pub fn names_or_entries(&self, name: &str) -> Vec<NameOrEntry<'a>> {
        let Form::NamesOrTables(keys) = self.key(name).form else { unreachable!("{name} are no names or tables") };
        let Some(node) = self.node(name) else { return Vec::new() };
        let items = match node.get_ref() {
            DeValue::Array(list) => list.as_ref(),
            _ => std::slice::from_ref(node),
        };
        let one = |item: &'a Node<'a>| match item.get_ref() {
            DeValue::String(_) => Some(NameOrEntry::Name(self.reader.word(name, item)?, item.span())),
            DeValue::Table(table) => {
                let label = format!("`{name}` of {}", self.label);
                Some(NameOrEntry::Entry(Entry::new(self.reader, table, item.span(), keys, label)))
            }
            _ => {
                let help = format!("write a name in quotes, a table with keys {}, or a list of them", some_keys(keys));
                self.reader.mismatch(name, item, "a name or a table", help);
                None
            }
        };
        items.iter().filter_map(one).collect()
    }

    /// The tables of a table, by name, in the order of the text.
    pub fn named_entries(&self, name: &str) -> Vec<(&'a str, Entry<'a>)> {
        let Form::Named(keys) = self.key(name).form else { unreachable!("{name} are no named tables") };
        let Some(node) = self.node(name) else { return Vec::new() };
        let DeValue::Table(tables) = node.get_ref() else {
            self.reader.mismatch(name, node, "a table of tables", format!("write [{name}.NAME] tables"));
            return Vec::new();
        };
        let mut entries = Vec::new();
        for (key, value) in tables {
            self.reader.refuse_control_characters(&format!("a name in `{name}`"), key.get_ref(), key.span());
            let DeValue::Table(table) = value.get_ref() else {
                let what = format!("`{name}` has the key `{}`, which is no table", key.get_ref());
                self.reader.fault(value.span(), what, format!("write [{name}.NAME] tables"));
                continue;
            };
            let label = format!("{} \"{}\"", keys.what, key.get_ref());
            entries.push((key.get_ref().as_ref(), Entry::new(self.reader, table, value.span(), keys, label)));
        }
        entries.sort_by_key(|(_, entry)| entry.span.start);
        entries
    }
}

/// An item of a list of names and tables.
pub(crate) enum NameOrEntry<'a> {
    /// A name, and where it is.
    Name(&'a str, Span),
    /// A table.
    Entry(Entry<'a>),
}

fn some_keys(keys: &Keys) -> String {
    let names: Vec<String> = keys.keys.iter().map(|key| format!("`{}`", key.name)).collect();
    names.join(", ")
}

/// Place of a number of a pair.
fn pair_span(node: &Node<'_>, at: usize) -> Span {
    match node.get_ref() {
        DeValue::Array(pair) => pair.get(at).map_or_else(|| node.span(), |item| item.span()),
        _ => node.span(),
    }
}
