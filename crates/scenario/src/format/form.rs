//! The types of the tables of keys: the keys of an entry and the form of their values.

use super::limits::{ANY, Bound};
use wireloom_core::Quantity;

/// Families of kinds in the registry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// Rods.
    Rod,
    /// Joint models.
    Joint,
    /// Constraints.
    Constraint,
    /// Minimisers.
    Minimiser,
    /// Shapes of obstacles.
    Shape,
}

impl Family {
    /// Word for one of its kinds.
    pub fn word(self) -> &'static str {
        match self {
            Family::Rod => "rod",
            Family::Joint => "joint model",
            Family::Constraint => "constraint kind",
            Family::Minimiser => "minimiser",
            Family::Shape => "shape",
        }
    }
}

/// Form of the value of a key.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    /// The version of the format.
    Version,
    /// A string that is not empty: a new name, or a reference.
    Name,
    /// A list of such strings.
    Names,
    /// Name of a kind of the registry; with the default.
    Kind(Family, Option<&'static str>),
    /// A number.
    Number(Quantity, Bound),
    /// A number, or two.
    OneOrTwo(Quantity, Bound),
    /// Three numbers.
    Vector(Quantity),
    /// Three numbers that are not all zero, of any length.
    Direction,
    /// A quaternion `[w, x, y, z]` of any length but zero.
    Orientation,
    /// A list of points, m; with its least length.
    Points(usize),
    /// A list of at least this many pairs of these quantities, the points of a curve.
    Curve([Quantity; 2], usize),
    /// One or two directions.
    Directions,
    /// A whole number between these.
    Count(usize, usize),
    /// true or false.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A number of any quantity, or a string with a unit.
    Quantity,
    /// A number of any quantity, or a list of such numbers.
    QuantityOrList,
    /// A list of values of any kind.
    Values,
    /// Paths of keys, each with a value or a list of values.
    Conditions,
    /// Some of these words.
    Words(&'static [&'static str]),
    /// A table.
    Table(&'static Keys),
    /// A list of tables.
    Tables(&'static Keys),
    /// A table, or a list of them.
    OneOrMoreTables(&'static Keys),
    /// A table of tables, by name.
    Named(&'static Keys),
    /// A name, a table, or a list of them; a name stands for a table with this name only.
    NamesOrTables(&'static Keys),
}

impl Form {
    /// Quantity and limits of each of its numbers.
    pub fn bound(&self) -> Option<(Quantity, Bound)> {
        let (quantity, bound) = match *self {
            Form::Number(quantity, bound) | Form::OneOrTwo(quantity, bound) => (quantity, bound),
            Form::Vector(quantity) => (quantity, ANY),
            Form::Points(_) => (Quantity::Length, ANY),
            _ => return None,
        };
        Some((quantity, bound.of(quantity)))
    }
}

/// Conditions under which a key must be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Need {
    /// Always.
    Must,
    /// Never.
    May,
    /// Unless one of these keys is given.
    Unless(&'static [&'static str]),
    /// Never; the key has no meaning without this other key.
    With(&'static str),
}

/// A key of an entry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    /// Its name.
    pub name: &'static str,
    /// Form of its value.
    pub form: Form,
    /// Whether it must be given.
    pub need: Need,
    /// Its meaning.
    pub doc: &'static str,
}

/// The keys of an entry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Keys {
    /// Word for an entry with these keys.
    pub what: &'static str,
    /// The keys.
    pub keys: &'static [Key],
}

impl Keys {
    /// The key of this name.
    pub fn get(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The key that names the entry's kind, with the default. Parameters of the kind are keys of the entry too.
    pub fn kind(&self) -> Option<(&'static str, Family, Option<&'static str>)> {
        self.keys.iter().find_map(|key| match key.form {
            Form::Kind(family, default) => Some((key.name, family, default)),
            _ => None,
        })
    }
}

/// A key that must be given.
pub(crate) const fn must(name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::Must, doc }
}

/// A key that may be left out.
pub(crate) const fn may(name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::May, doc }
}

/// A key that must be given unless one of the `others` is.
pub(crate) const fn unless(others: &'static [&'static str], name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::Unless(others), doc }
}

/// A key that may be left out and has no meaning without `other`.
pub(crate) const fn with(other: &'static str, name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::With(other), doc }
}
