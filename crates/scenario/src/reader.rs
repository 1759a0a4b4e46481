//! Reads the values of an entry as its table of keys declares them; gathers faults and goes on.

use crate::fault::{Fault, Places, did_you_mean, nearest};
use crate::files::Files;
use crate::keys::{self, Bound, Form, Key, Keys, Need};
use crate::units;
use nalgebra::{Quaternion, Unit};
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};
use wireloom_core::{Quantity, Registry, Rotation, Vector};

pub(crate) type Span = Range<usize>;
type Node<'a> = Spanned<DeValue<'a>>;

/// The text that is read, the files it may name, the kinds that are known, the faults found so far.
pub(crate) struct Reader<'a> {
    pub text: &'a str,
    files: &'a dyn Files,
    pub registry: &'a Registry,
    faults: RefCell<Vec<Fault>>,
}

impl<'a> Reader<'a> {
    pub fn new(text: &'a str, files: &'a dyn Files, registry: &'a Registry) -> Self {
        Self { text, files, registry, faults: RefCell::default() }
    }

    /// Notes a fault.
    pub fn fault(&self, span: Span, message: impl Into<String>, help: impl Into<String>) {
        self.faults.borrow_mut().push(Fault { span, message: message.into(), help: help.into() });
    }

    /// Notes faults.
    pub fn faults(&self, faults: Vec<Fault>) {
        self.faults.borrow_mut().extend(faults);
    }

    /// The text of another file, named at `span`; notes a fault where it cannot be read.
    pub fn file(&self, path: &str, span: Span) -> Option<String> {
        let text = self.files.read(path);
        if let Err(reason) = &text {
            let help = "give the path of a text file, from the folder of the scenario";
            self.fault(span, format!("cannot read \"{path}\": {reason}"), help);
        }
        text.ok()
    }

    /// The bytes of another file, named at `span`; notes a fault where it cannot be read.
    pub fn bytes(&self, path: &str, span: Span) -> Option<Vec<u8>> {
        let bytes = self.files.bytes(path);
        if let Err(reason) = &bytes {
            let help = "give the path of a file, from the folder of the scenario";
            self.fault(span, format!("cannot read \"{path}\": {reason}"), help);
        }
        bytes.ok()
    }

    /// Reads another file, named at `span`, as TOML with keys of its own. Its faults are noted at `span`, each with its place in that
    /// file.
    pub fn include<T>(
        &self,
        path: &str,
        span: Span,
        keys: &'static Keys,
        read: impl FnOnce(&Entry<'_>) -> T,
    ) -> Option<T> {
        let text = self.file(path, span.clone())?;
        let (found, faults) = included(path, &text, self.files, self.registry, keys, read);
        let places = Places::of(&text);
        for fault in faults {
            let (line, column) = places.position(fault.span.start);
            self.fault(span.clone(), format!("{path}:{line}:{column}: {}", fault.message), fault.help);
        }
        found
    }

    /// How many faults there are so far.
    pub fn fault_count(&self) -> usize {
        self.faults.borrow().len()
    }

    /// All faults, in the order of the text.
    pub fn finish(self) -> Vec<Fault> {
        let mut faults = self.faults.into_inner();
        faults.sort_by_key(|fault| fault.span.start);
        faults
    }

    /// What stands at a place, shortened.
    fn excerpt(&self, span: Span) -> String {
        const LONGEST: usize = 60;
        let line = self.text.get(span).unwrap_or_default().lines().next().unwrap_or_default();
        if line.chars().count() <= LONGEST {
            return line.to_owned();
        }
        line.chars().take(LONGEST).chain(['…']).collect()
    }

    /// Notes that the value of a key is not what it should be.
    pub fn mismatch(&self, key: &str, node: &Node<'_>, expected: &str, help: impl Into<String>) {
        let found = match node.get_ref() {
            DeValue::Table(_) => "a table".to_owned(),
            DeValue::Array(list) if list.iter().all(|item| matches!(item.get_ref(), DeValue::Table(_))) => {
                "a list of tables".to_owned()
            }
            _ => self.excerpt(node.span()),
        };
        self.fault(node.span(), format!("`{key}` is {found}, not {expected}"), help);
    }

    /// A number in SI, without checking its limits.
    fn plain_number(&self, key: &str, node: &Node<'_>, quantity: Quantity) -> Option<f64> {
        let words = units::words(quantity);
        let value = match node.get_ref() {
            DeValue::Integer(integer) => whole(integer).map(|i| i as f64).unwrap_or(f64::NAN),
            DeValue::Float(float) => float.as_str().parse().unwrap_or(f64::NAN),
            DeValue::String(text) => match units::parse(text, quantity) {
                Ok(value) => value,
                Err(wrong) => {
                    let shown = self.excerpt(node.span());
                    self.fault(node.span(), format!("`{key}` = {shown} {wrong}"), help_number(quantity));
                    return None;
                }
            },
            _ => {
                self.mismatch(key, node, words.name, help_number(quantity));
                return None;
            }
        };
        if value.is_finite() {
            return Some(value);
        }
        self.fault(
            node.span(),
            format!("`{key}` = {} is not a finite number", self.excerpt(node.span())),
            help_number(quantity),
        );
        None
    }

    /// A number in SI, within limits and physically plausible.
    pub fn number(&self, key: &str, node: &Node<'_>, quantity: Quantity, bound: Bound) -> Option<f64> {
        let value = self.plain_number(key, node, quantity)?;
        let bound = bound.of(quantity);
        let low = value < bound.minimum || (bound.exclusive && value == bound.minimum);
        if !low && value <= bound.maximum {
            return Some(value);
        }
        let side = if low { "small" } else { "large" };
        let shown = self.excerpt(node.span());
        self.fault(
            node.span(),
            format!("`{key}` = {shown} is too {side}"),
            format!("it must be {}", bound.words(quantity)),
        );
        None
    }

    /// A list of so many numbers, each read by `one`.
    fn numbers<const N: usize>(
        &self,
        key: &str,
        node: &Node<'_>,
        quantity: Quantity,
        one: impl Fn(&Node<'_>) -> Option<f64>,
    ) -> Option<[f64; N]> {
        let list = match node.get_ref() {
            DeValue::Array(list) if list.len() == N => list,
            _ => {
                let words = units::words(quantity);
                let unit = if words.unit.is_empty() { String::new() } else { format!(", in {}", words.unit) };
                let example = if N == 3 { "[0, 0, 1]" } else { "[1, 0, 0, 0]" };
                self.mismatch(key, node, &format!("a list of {N} numbers"), format!("write such as {example}{unit}"));
                return None;
            }
        };
        let values: Vec<Option<f64>> = list.iter().map(one).collect();
        let values: Option<Vec<f64>> = values.into_iter().collect();
        values?.try_into().ok()
    }

    /// Three numbers, each physically plausible.
    pub fn vector(&self, key: &str, node: &Node<'_>, quantity: Quantity) -> Option<Vector> {
        self.numbers::<3>(key, node, quantity, |item| self.number(key, item, quantity, keys::ANY)).map(Vector::from)
    }

    /// Numbers of which only the ratios matter.
    fn ratios<const N: usize>(&self, key: &str, node: &Node<'_>) -> Option<[f64; N]> {
        self.numbers(key, node, Quantity::Dimensionless, |item| self.plain_number(key, item, Quantity::Dimensionless))
    }

    /// Three numbers that are not all zero, made a unit vector.
    pub fn direction(&self, key: &str, node: &Node<'_>) -> Option<Unit<Vector>> {
        let direction = normalised(Vector::from(self.ratios::<3>(key, node)?));
        if direction.is_none() {
            self.fault(
                node.span(),
                format!("`{key}` = {} has no direction", self.excerpt(node.span())),
                "give a vector that is not zero; its length does not matter",
            );
        }
        direction
    }

    /// A quaternion, made a unit one.
    pub fn orientation(&self, key: &str, node: &Node<'_>) -> Option<Rotation> {
        let rotation = rotation(self.ratios(key, node)?);
        if rotation.is_none() {
            self.fault(
                node.span(),
                format!("`{key}` = {} is no rotation", self.excerpt(node.span())),
                "give a quaternion [w, x, y, z] that is not zero; [1, 0, 0, 0] leaves the axes as they are",
            );
        }
        rotation
    }

    /// A whole number within limits.
    pub fn count(&self, key: &str, node: &Node<'_>, minimum: usize, maximum: usize) -> Option<usize> {
        let help = format!("write a whole number from {minimum} to {maximum}");
        let value = match node.get_ref() {
            DeValue::Integer(integer) => whole(integer),
            _ => {
                self.mismatch(key, node, "a whole number", help);
                return None;
            }
        };
        let value = value.and_then(|value| usize::try_from(value).ok()).filter(|v| (minimum..=maximum).contains(v));
        if value.is_none() {
            self.fault(node.span(), format!("`{key}` = {} is out of range", self.excerpt(node.span())), help);
        }
        value
    }

    /// true or false.
    pub fn flag(&self, key: &str, node: &Node<'_>) -> Option<bool> {
        if let DeValue::Boolean(value) = node.get_ref() {
            return Some(*value);
        }
        self.mismatch(key, node, "true or false", "write true or false, without quotes");
        None
    }

    /// A string that is not empty.
    pub fn word<'n>(&self, key: &str, node: &'n Node<'_>) -> Option<&'n str> {
        match node.get_ref() {
            DeValue::String(text) if !text.trim().is_empty() => Some(text),
            DeValue::String(_) => {
                self.fault(node.span(), format!("`{key}` is empty"), "give it a name");
                None
            }
            _ => {
                self.mismatch(key, node, "a string", "write a string in quotes");
                None
            }
        }
    }

    /// A word out of some.
    pub fn choice<'n, 'w>(
        &self,
        key: &str,
        node: &'n Node<'_>,
        words: impl IntoIterator<Item = &'w str> + Clone,
    ) -> Option<&'n str> {
        let word = self.word(key, node)?;
        if words.clone().into_iter().any(|known| known == word) {
            return Some(word);
        }
        self.fault(node.span(), format!("`{key}` has no choice \"{word}\""), did_you_mean(word, words));
        None
    }
}

/// What a text of its own says, and its faults, by place in it; `name` is what messages call it.
pub(crate) fn included<T>(
    name: &str,
    text: &str,
    files: &dyn Files,
    registry: &Registry,
    keys: &'static Keys,
    read: impl FnOnce(&Entry<'_>) -> T,
) -> (Option<T>, Vec<Fault>) {
    let table = match crate::toml_table(text) {
        Ok(table) => table,
        Err(faults) => return (None, faults),
    };
    let reader = Reader::new(text, files, registry);
    let found = read(&Entry::new(&reader, table.get_ref(), 0..0, keys, name.to_owned()));
    (Some(found), reader.finish())
}

/// The rotation of a quaternion `[w, x, y, z]`; `None` where it is zero.
pub(crate) fn rotation([w, x, y, z]: [f64; 4]) -> Option<Rotation> {
    let largest = [w, x, y, z].into_iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let whole = || Unit::new_normalize(Quaternion::new(w / largest, x / largest, y / largest, z / largest));
    (largest > 0.0).then(whole)
}

/// A unit vector along `vector`, whatever its length; none where it is zero.
pub(crate) fn normalised(vector: Vector) -> Option<Unit<Vector>> {
    let largest = vector.amax();
    (largest > 0.0).then(|| Unit::new_normalize(vector / largest))
}

fn whole(integer: &DeInteger<'_>) -> Option<i64> {
    i64::from_str_radix(integer.as_str(), integer.radix()).ok()
}

fn help_number(quantity: Quantity) -> String {
    let words = units::words(quantity);
    if words.unit.is_empty() {
        return format!("write a finite number without unit, such as {}", words.example);
    }
    format!("write {} in {}, or with a unit such as {}", words.name, words.unit, words.example)
}

/// An entry of the file: a table, and the keys it may have.
pub(crate) struct Entry<'a> {
    pub reader: &'a Reader<'a>,
    pub table: &'a DeTable<'a>,
    pub keys: &'static Keys,
    /// Where it is.
    pub span: Span,
    /// What messages call it: `branch "trunk"`.
    pub label: String,
}

impl<'a> Entry<'a> {
    /// An entry. Keys that are not declared are refused at once, but for entries of a kind: those may
    /// have the kind's parameters, see [`crate::kinds::read`].
    pub fn new(reader: &'a Reader<'a>, table: &'a DeTable<'a>, span: Span, keys: &'static Keys, label: String) -> Self {
        let entry = Self { reader, table, keys, span, label };
        if keys.kind().is_none() {
            entry.refuse_unknown_keys(std::iter::empty());
        }
        entry
    }

    /// The declared key; asking for one that is not declared is a mistake of this crate, met by every test.
    fn key(&self, name: &str) -> &'static Key {
        self.keys.get(name).unwrap_or_else(|| unreachable!("{} has no key {name}", self.keys.what))
    }

    /// The value of a key; notes a fault where it must be given and is not.
    pub fn node(&self, name: &str) -> Option<&'a Node<'a>> {
        let key = self.key(name);
        let node = self.table.get(name);
        let needed = match key.need {
            Need::Must => true,
            Need::Unless(other) => !self.has(other),
            Need::May | Need::With(_) => false,
        };
        if node.is_none() && needed && !self.misspelt(name) {
            self.missing(key.name, key.doc);
        }
        if let (Some(node), Need::With(other)) = (node, key.need)
            && !self.has(other)
        {
            let message = format!("{} has `{name}` but no `{other}`", self.label);
            self.reader.fault(
                node.span(),
                message,
                format!("it means nothing without `{other}`: leave it out, or add that"),
            );
        }
        node
    }

    /// Whether an unknown key is taken for this one misspelt; one fault is enough then.
    fn misspelt(&self, name: &str) -> bool {
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

    /// Notes a fault at the value of a key (or of the whole entry, where the key is left out).
    pub fn fault_at(&self, name: &str, message: impl Into<String>, help: impl Into<String>) {
        self.reader.fault(self.span_of(name), message, help);
    }

    /// Where the value of a key is; the whole entry where the key is left out.
    pub fn span_of(&self, name: &str) -> Span {
        self.table.get(name).map_or_else(|| self.span.clone(), Spanned::span)
    }

    /// Whether a key is given.
    pub fn has(&self, name: &str) -> bool {
        self.table.contains_key(name)
    }

    /// Where the entry and all its values are.
    pub fn spans(&self) -> crate::Spans {
        let keys = self.table.iter().map(|(key, value)| (key.get_ref().to_string(), value.span())).collect();
        crate::Spans { entry: self.span.clone(), keys }
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

    /// The values of a list; none, where it is left out or no list.
    fn list(&self, name: &str) -> &'a [Node<'a>] {
        let Some(node) = self.node(name) else { return &[] };
        if let DeValue::Array(list) = node.get_ref() {
            return list;
        }
        self.reader.mismatch(name, node, "a list", "write a list in brackets");
        &[]
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

    /// Unit vectors of a list.
    pub fn directions(&self, name: &str) -> Option<Vec<Unit<Vector>>> {
        self.list(name).iter().map(|item| self.reader.direction(name, item)).collect()
    }

    /// One of the words declared.
    pub fn choice(&self, name: &str) -> Option<&'a str> {
        let Form::Choice(words) = self.key(name).form else { unreachable!("{name} is no choice") };
        self.node(name).and_then(|node| self.reader.choice(name, node, words.iter().copied()))
    }

    /// The values of a list, whatever they are.
    pub fn values(&self, name: &str) -> &'a [Node<'a>] {
        let Form::Values = self.key(name).form else { unreachable!("{name} is no list of values") };
        self.list(name)
    }

    /// Words of a list out of those declared.
    pub fn choices(&self, name: &str) -> Vec<&'a str> {
        let Form::Words(words) = self.key(name).form else { unreachable!("{name} are no words") };
        self.list(name).iter().filter_map(|item| self.reader.choice(name, item, words.iter().copied())).collect()
    }

    /// Names of a list, with their places.
    pub fn names(&self, name: &str) -> Vec<(&'a str, Span)> {
        self.list(name).iter().filter_map(|item| Some((self.reader.word(name, item)?, item.span()))).collect()
    }

    /// The strings of a list, whatever else is in it: what is wrong with it is said when its names are read.
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
                "give one table at least, or leave it out",
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

    /// Tables as entries of their own, called by their name or by what they belong to.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NoFiles;

    struct Two;

    impl Files for Two {
        fn read(&self, path: &str) -> Result<String, String> {
            match path {
                "good.toml" => Ok("vtk = true".into()),
                "bad.toml" => Ok("\nvkt = true\ncsv = 3".into()),
                "torn.toml" => Ok("vtk = ".into()),
                _ => Err("no such file".into()),
            }
        }
    }

    #[test]
    fn another_file_is_read_with_keys_of_its_own_and_its_faults_stand_where_it_is_named() {
        let registry = Registry::default();
        let reader = Reader::new("", &Two, &registry);
        let read = |path| reader.include(path, 3..5, &keys::OUTPUT, |entry| entry.flag("vtk"));
        assert_eq!(read("good.toml"), Some(Some(true)));
        assert_eq!(reader.fault_count(), 0);
        assert_eq!(read("bad.toml"), Some(None));
        assert_eq!(read("torn.toml"), None);
        assert_eq!(read("none.toml"), None);
        let faults = reader.finish();
        assert!(faults.iter().all(|fault| fault.span == (3..5)));
        let said: Vec<&str> = faults.iter().map(|fault| fault.message.as_str()).collect();
        assert_eq!(said[0], "bad.toml:2:1: unknown key `vkt` in bad.toml");
        assert!(said[1].starts_with("torn.toml:1:"), "{}", said[1]);
        assert_eq!(said[2], "cannot read \"none.toml\": no such file");
    }

    #[test]
    fn a_text_without_a_folder_has_no_files() {
        let registry = Registry::default();
        let reader = Reader::new("", &NoFiles, &registry);
        assert_eq!(reader.file("good.toml", 0..0), None);
        assert_eq!(reader.finish()[0].message, "cannot read \"good.toml\": the scenario is a text without a folder");
    }
}
