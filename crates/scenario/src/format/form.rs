//! Tables of keys: what an entry of a scenario may have, and what each key holds.

use super::limits::{ANY, Bound};
use wireloom_core::Quantity;

/// What is looked up by name in the registry.
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
    /// The word for one of its kinds.
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

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    /// The version of the format.
    Version,
    /// A string that is not empty: a new name, or that of something.
    Name,
    /// A list of such strings.
    Names,
    /// Name of a kind of the registry, and the one taken where the key is left out.
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
    /// A list of points, m, at least so many.
    Points(usize),
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
    /// A list of values of any kind.
    Values,
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
    /// A name, a table, or a list of them; a name stands for a table that has nothing but it.
    NamesOrTables(&'static Keys),
}

impl Form {
    /// What each of its numbers measures, and between what it must be.
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

/// Whether a key must be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Need {
    /// It must.
    Must,
    /// It may be left out.
    May,
    /// It must, unless this key is given.
    Unless(&'static str),
    /// It may be left out, and means nothing without this key.
    With(&'static str),
}

/// A key of an entry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it holds.
    pub form: Form,
    /// Whether it must be given.
    pub need: Need,
    /// What it is for.
    pub doc: &'static str,
}

/// The keys of an entry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Keys {
    /// Word for such an entry.
    pub what: &'static str,
    /// The keys.
    pub keys: &'static [Key],
}

impl Keys {
    /// The key of this name.
    pub fn get(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The key that names the entry's kind, whose parameters are keys of the entry too.
    pub fn kind(&self) -> Option<(&'static str, Family, Option<&'static str>)> {
        self.keys.iter().find_map(|key| match key.form {
            Form::Kind(family, default) => Some((key.name, family, default)),
            _ => None,
        })
    }
}

pub(crate) const fn must(name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::Must, doc }
}

pub(crate) const fn may(name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::May, doc }
}

pub(crate) const fn unless(other: &'static str, name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::Unless(other), doc }
}

pub(crate) const fn with(other: &'static str, name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::With(other), doc }
}
