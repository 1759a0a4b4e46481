//! Registry of kinds: name, factory and declared parameters, for built-in kinds and plugins alike.

use crate::Vector;
pub use crate::build_error::BuildError;
use crate::constitutive::{ConstitutiveLaws, ConstitutiveSpec};
use crate::constraint::{Attaches, Constraint, ConstraintSpec};
use crate::joint::{JointModel, JointSpec};
use crate::minimiser::Minimiser;
use crate::obstacle::{Shape, ShapeSpec};
pub use crate::quantity::{Output, Quantity};
use crate::rod::{RodSegment, RodSpec};
use std::collections::BTreeMap;

/// Form of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// One number, within `[minimum, maximum]`; `exclusive` excludes the minimum itself.
    Number {
        /// Its quantity.
        quantity: Quantity,
        /// Least value.
        minimum: f64,
        /// Whether the least value itself is excluded.
        exclusive: bool,
        /// Greatest value.
        maximum: f64,
    },
    /// Three numbers.
    Vector {
        /// Their quantity.
        quantity: Quantity,
    },
    /// A whole number of at least this.
    Count {
        /// Least value.
        minimum: usize,
    },
    /// true or false.
    Flag,
    /// One of these words.
    Choice(Vec<String>),
}

/// A declared parameter of a kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Key in the scenario.
    pub name: String,
    /// One-line description.
    pub doc: String,
    /// Its form.
    pub form: Form,
    /// Value if the key is absent; `None`: the parameter then has no value.
    pub default: Option<Value>,
    /// Whether the key must be given.
    pub required: bool,
}

/// A parameter's value, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number.
    Number(f64),
    /// Three numbers.
    Vector(Vector),
    /// A whole number.
    Count(usize),
    /// true or false.
    Flag(bool),
    /// A word.
    Word(String),
}

/// Values of a kind's parameters, checked against their declaration, with defaults filled in.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parameters(pub BTreeMap<String, Value>);

impl Parameters {
    /// A number, if given.
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.0.get(name) {
            Some(Value::Number(x)) => Some(*x),
            Some(Value::Count(n)) => Some(*n as f64),
            _ => None,
        }
    }
    /// A whole number, if given.
    pub fn count(&self, name: &str) -> Option<usize> {
        match self.0.get(name) {
            Some(Value::Count(n)) => Some(*n),
            _ => None,
        }
    }
    /// A word, if given.
    pub fn word(&self, name: &str) -> Option<&str> {
        match self.0.get(name) {
            Some(Value::Word(w)) => Some(w),
            _ => None,
        }
    }
    /// A flag, if given.
    pub fn flag(&self, name: &str) -> Option<bool> {
        match self.0.get(name) {
            Some(Value::Flag(f)) => Some(*f),
            _ => None,
        }
    }
}

/// A kind: name, description, parameters and factory.
pub struct Kind<S, T: ?Sized> {
    /// Name in scenarios.
    pub name: String,
    /// One-line description.
    pub doc: String,
    /// Declared parameters.
    pub parameters: Vec<Parameter>,
    /// Its factory.
    pub build: Factory<S, T>,
}

/// Factory: builds an object of a kind from the scenario's data.
pub type Factory<S, T> = Box<dyn Fn(&S, &Parameters) -> Result<Box<T>, BuildError> + Send + Sync>;

/// A rod kind.
pub type RodKind = Kind<RodSpec, dyn RodSegment>;
/// A kind of constitutive laws, for rods of plugins.
pub type ConstitutiveKind = Kind<ConstitutiveSpec, ConstitutiveLaws>;
/// A joint kind.
pub type JointKind = Kind<JointSpec, dyn JointModel>;
/// A constraint kind.
pub struct ConstraintKind {
    /// Name in scenarios.
    pub name: String,
    /// One-line description.
    pub doc: String,
    /// Stations and span that it attaches to.
    pub attaches: Attaches,
    /// Declared parameters.
    pub parameters: Vec<Parameter>,
    /// Declared outputs.
    pub outputs: Vec<Output>,
    /// Its factory.
    pub build: Factory<ConstraintSpec, dyn Constraint>,
}
/// A minimiser kind.
pub type MinimiserKind = Kind<(), dyn Minimiser>;

/// A kind of obstacle, by its shape.
pub type ShapeKind = Kind<ShapeSpec, dyn Shape>;

/// All kinds known to the program, by name.
#[derive(Default)]
pub struct Registry {
    rods: BTreeMap<String, RodKind>,
    joints: BTreeMap<String, JointKind>,
    constraints: BTreeMap<String, ConstraintKind>,
    minimisers: BTreeMap<String, MinimiserKind>,
    shapes: BTreeMap<String, ShapeKind>,
}

macro_rules! family {
    ($add:ident, $get:ident, $all:ident, $kind:ty, $what:literal) => {
        #[doc = concat!("Adds a ", $what, " kind; gives it back if the name is taken.")]
        pub fn $add(&mut self, kind: $kind) -> Result<(), Box<$kind>> {
            if self.$all.contains_key(&kind.name) {
                return Err(Box::new(kind));
            }
            self.$all.insert(kind.name.clone(), kind);
            Ok(())
        }
        #[doc = concat!("The ", $what, " kind of this name.")]
        pub fn $get(&self, name: &str) -> Option<&$kind> {
            self.$all.get(name)
        }
        #[doc = concat!("All ", $what, " kinds, by name.")]
        pub fn $all(&self) -> impl Iterator<Item = &$kind> {
            self.$all.values()
        }
    };
}

impl Registry {
    family!(add_rod, rod, rods, RodKind, "rod");
    family!(add_joint, joint, joints, JointKind, "joint");
    family!(add_constraint, constraint, constraints, ConstraintKind, "constraint");
    family!(add_minimiser, minimiser, minimisers, MinimiserKind, "minimiser");
    family!(add_shape, shape, shapes, ShapeKind, "shape");
}
