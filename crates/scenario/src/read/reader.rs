//! Reads values; collects faults and continues.

use super::files::Files;
use crate::fault::{Fault, did_you_mean};
use crate::format::limits::{ANY, Bound};
use crate::format::units;
use crate::span::Span;
use nalgebra::{Quaternion, Unit};
use std::cell::RefCell;
use toml::Spanned;
use toml::de::{DeInteger, DeValue};
use wireloom_core::{Quantity, Registry, Rotation, Vector};

pub(crate) type Node<'a> = Spanned<DeValue<'a>>;

/// The text, the files that it may name, the registry of kinds, and the faults found so far.
pub(crate) struct Reader<'a> {
    pub text: &'a str,
    pub files: &'a dyn Files,
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

    /// The text of another file, named at `span`; notes a fault if it cannot be read.
    pub fn file(&self, path: &str, span: Span) -> Option<String> {
        let text = self.files.read(path);
        if let Err(reason) = &text {
            let help = "give the path of a text file, from the folder of the scenario";
            self.fault(span, format!("cannot read \"{path}\": {reason}"), help);
        }
        text.ok()
    }

    /// The bytes of another file, named at `span`; notes a fault if it cannot be read.
    pub fn bytes(&self, path: &str, span: Span) -> Option<Vec<u8>> {
        let bytes = self.files.bytes(path);
        if let Err(reason) = &bytes {
            let help = "give the path of a file, from the folder of the scenario";
            self.fault(span, format!("cannot read \"{path}\": {reason}"), help);
        }
        bytes.ok()
    }

    /// Number of faults so far.
    pub fn fault_count(&self) -> usize {
        self.faults.borrow().len()
    }

    /// All faults, in the order of the text.
    pub fn finish(self) -> Vec<Fault> {
        let mut faults = self.faults.into_inner();
        faults.sort_by_key(|fault| fault.span.start);
        faults
    }

    /// The text at a place, shortened.
    pub fn excerpt(&self, span: Span) -> String {
        const LONGEST: usize = 60;
        let line = self.text.get(span).unwrap_or_default().lines().next().unwrap_or_default();
        if line.chars().count() <= LONGEST {
            return line.to_owned();
        }
        line.chars().take(LONGEST).chain(['…']).collect()
    }

    /// Notes that the value of a key has the wrong form.
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

    /// A list of `N` numbers, each read by `one`.
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
        self.numbers::<3>(key, node, quantity, |item| self.number(key, item, quantity, ANY)).map(Vector::from)
    }

    /// Numbers, without units, whose ratios alone matter.
    fn ratios<const N: usize>(&self, key: &str, node: &Node<'_>) -> Option<[f64; N]> {
        self.numbers(key, node, Quantity::Dimensionless, |item| {
            if let DeValue::String(_) = item.get_ref() {
                self.mismatch(key, item, "a number", "write a number without quotes and unit: ratios alone matter");
                return None;
            }
            self.plain_number(key, item, Quantity::Dimensionless)
        })
    }

    /// Three numbers that are not all zero, made a unit vector.
    pub fn direction(&self, key: &str, node: &Node<'_>) -> Option<Unit<Vector>> {
        let direction = normalised(Vector::from(self.ratios::<3>(key, node)?));
        if direction.is_none() {
            self.fault(
                node.span(),
                format!("`{key}` = {} has no direction", self.excerpt(node.span())),
                "give a vector that is not zero; its length is ignored",
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

    /// Notes a text with control characters, once: names may be read several times, and go into files, tables and
    /// terminals.
    pub fn refuse_control_characters(&self, what: &str, text: &str, span: Span) {
        let Some(control) = text.chars().find(|c| c.is_control()) else { return };
        let message = format!("{what} has the control character U+{:04X}", u32::from(control));
        let fault = Fault { span, message, help: "leave it out".into() };
        if !self.faults.borrow().contains(&fault) {
            self.faults.borrow_mut().push(fault);
        }
    }

    /// A string that is not empty, without control characters; texts other than names may have several lines.
    pub fn word<'n>(&self, key: &str, node: &'n Node<'_>) -> Option<&'n str> {
        if let DeValue::String(text) = node.get_ref() {
            let text = if key == "name" { text.to_string() } else { text.replace(['\n', '\r', '\t'], " ") };
            self.refuse_control_characters(&format!("`{key}`"), &text, node.span());
        }
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

    /// One of some words.
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

/// The rotation of a quaternion `[w, x, y, z]`; `None` if it is zero.
pub(crate) fn rotation([w, x, y, z]: [f64; 4]) -> Option<Rotation> {
    let largest = [w, x, y, z].into_iter().fold(0.0, |m: f64, c| m.max(c.abs()));
    let whole = || Unit::new_normalize(Quaternion::new(w / largest, x / largest, y / largest, z / largest));
    (largest > 0.0).then(whole)
}

/// The unit vector along `vector`; `None` if it is zero.
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
