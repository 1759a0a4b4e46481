//! Values of a scenario that a user may set interactively: models, rods, the minimiser, numbers of sections; each
//! with its meaning, its form and its current value. Derived from the tables of keys and from the registry.

use crate::format::form::{Form, Keys};
use crate::format::keys;
use crate::format::kinds::{self, KindInfo};
use crate::format::limits::Bound;
use crate::format::units::unit_of;
use crate::scenario::Scenario;
use wireloom_core::registry;
use wireloom_core::{ArmSpring, Parameter, Parameters, Quantity, Registry, Section, Value};

/// A value that may be set.
#[derive(Clone, Debug, PartialEq)]
pub struct Adjustable {
    /// Path to its key; see [`crate::settings`].
    pub key: String,
    /// The part that it belongs to: "joint J".
    pub group: String,
    /// Its key.
    pub label: String,
    /// Its meaning, one line.
    pub doc: String,
    /// Its form.
    pub holds: Holds,
    /// Its current value; `None` if not given, or if there is more than one.
    pub value: Option<Value>,
}

/// Form of the value of an [`Adjustable`].
#[derive(Clone, Debug, PartialEq)]
pub enum Holds {
    /// One of these words, each with its meaning.
    Choice(Vec<(String, String)>),
    /// A number within these bounds.
    Number {
        /// SI unit; empty for pure numbers.
        unit: String,
        /// Least value.
        minimum: f64,
        /// Greatest value.
        maximum: f64,
    },
    /// A whole number, with its least value.
    Count(usize),
    /// true or false.
    Flag,
}

/// The values of sections that may be set.
const OF_SECTIONS: [&str; 9] = [
    "diameter",
    "linear_density",
    "axial_stiffness",
    "bending_stiffness",
    "torsion_stiffness",
    "min_bend_radius",
    "min_bend_radius_moving",
    "max_tension",
    "max_torsion",
];

/// All values of a scenario that may be set: joints with the springs of their arms, branches, sections, the minimiser,
/// in this order.
pub fn adjustable(scenario: &Scenario, registry: &Registry) -> Vec<Adjustable> {
    let mut all = Vec::new();
    for joint in &scenario.joints {
        let place = Place::of("joints", &joint.name, format!("joint {}", joint.name));
        place.kind(&keys::JOINT, &joint.model, &joint.parameters, registry, &mut all);
        place.spring(&keys::JOINT, &joint.spring, &mut all);
        for arm in joint.arms.iter().filter(|arm| arm.spring != joint.spring) {
            let branch = &scenario.branches[arm.branch].name;
            let way = format!("{}.arms.{}", place.way, quoted(branch));
            let place = Place { way, group: format!("arm {branch} of joint {}", joint.name) };
            place.spring(&keys::ARM, &arm.spring, &mut all);
        }
    }
    for branch in &scenario.branches {
        let place = Place::of("branches", &branch.name, format!("branch {}", branch.name));
        place.kind(&keys::BRANCH, &branch.rod, &branch.parameters, registry, &mut all);
    }
    let used = |k: usize| scenario.branches.iter().any(|branch| branch.has_section(k));
    for (_, section) in scenario.sections.iter().enumerate().filter(|(k, _)| used(*k)) {
        let place = Place::of("sections", &section.name, format!("section {}", section.name));
        let has_curve = |name: &str| match name {
            "axial_stiffness" => section.laws.axial.as_ref().is_some_and(|law| law.measured),
            "bending_stiffness" => section.laws.bending.is_some(),
            _ => false,
        };
        for name in OF_SECTIONS.into_iter().filter(|name| !has_curve(name)) {
            all.extend(place.number(&keys::SECTION, name, value_of(section, name)));
        }
    }
    let minimiser = &scenario.minimiser;
    let place = Place { way: "minimiser".to_owned(), group: "minimiser".to_owned() };
    place.kind(&keys::MINIMISER, &minimiser.kind, &minimiser.parameters, registry, &mut all);
    all.extend(place.number(&keys::MINIMISER, "force_tolerance", Some(minimiser.stop.force_tolerance)));
    all.extend(place.count(&keys::MINIMISER, "max_iterations", minimiser.stop.max_iterations));
    all
}

/// A value of a section; `None` if it has none, or two that differ.
fn value_of(section: &Section, name: &str) -> Option<f64> {
    match name {
        "diameter" => Some(section.diameter),
        "linear_density" => Some(section.linear_density),
        "axial_stiffness" => Some(section.axial_stiffness),
        "bending_stiffness" => one(section.bending_stiffness),
        "torsion_stiffness" => Some(section.torsion_stiffness),
        "min_bend_radius" => section.min_bend_radius,
        "min_bend_radius_moving" => section.min_bend_radius_moving,
        "max_tension" => section.max_tension,
        "max_torsion" => section.max_torsion,
        _ => None,
    }
}

/// Both of a pair, if they are equal.
fn one([first, second]: [f64; 2]) -> Option<f64> {
    (first == second).then_some(first)
}

/// An entry of the scenario.
struct Place {
    /// Path to it.
    way: String,
    group: String,
}

impl Place {
    fn of(list: &str, name: &str, group: String) -> Self {
        Self { way: format!("{list}.{}", quoted(name)), group }
    }

    fn entry(&self, name: &str, doc: &str, holds: Holds, value: Option<Value>) -> Adjustable {
        Adjustable {
            key: format!("{}.{name}", self.way),
            group: self.group.clone(),
            label: name.to_owned(),
            doc: doc.to_owned(),
            holds,
            value,
        }
    }

    /// The kind of the entry, and the parameters of that kind.
    fn kind(&self, keys: &Keys, kind: &str, given: &Parameters, registry: &Registry, all: &mut Vec<Adjustable>) {
        let Some((name, family, _)) = keys.kind() else { return };
        let doc = keys.get(name).map_or("", |key| key.doc);
        let kinds = kinds::all(registry, family);
        let words = kinds.iter().map(|kind| (kind.name.to_owned(), kind.doc.to_owned())).collect();
        all.push(self.entry(name, doc, Holds::Choice(words), Some(Value::Word(kind.to_owned()))));
        let parameters: &[Parameter] =
            kinds.iter().find(|own: &&KindInfo<'_>| own.name == kind).map_or(&[], |kind| kind.parameters);
        for parameter in parameters {
            let Some(holds) = holds(&parameter.form) else { continue };
            all.push(self.entry(&parameter.name, &parameter.doc, holds, given.0.get(&parameter.name).cloned()));
        }
    }

    /// The spring of a joint or an arm.
    fn spring(&self, keys: &Keys, spring: &ArmSpring, all: &mut Vec<Adjustable>) {
        all.extend(self.number(keys, "bending_stiffness", spring.bending.and_then(one)));
        all.extend(self.number(keys, "torsion_stiffness", spring.torsion));
    }

    fn number(&self, keys: &Keys, name: &str, value: Option<f64>) -> Option<Adjustable> {
        let key = keys.get(name)?;
        let (Form::Number(quantity, bound) | Form::OneOrTwo(quantity, bound)) = key.form else { return None };
        Some(self.entry(name, key.doc, number(quantity, bound), value.map(Value::Number)))
    }

    fn count(&self, keys: &Keys, name: &str, value: usize) -> Option<Adjustable> {
        let key = keys.get(name)?;
        let Form::Count(minimum, _) = key.form else { return None };
        Some(self.entry(name, key.doc, Holds::Count(minimum), Some(Value::Count(value))))
    }
}

/// A name as a part of the path to a key: in quotes where it would be misread.
pub fn quoted(name: &str) -> String {
    let quote = if name.contains('"') { '\'' } else { '"' };
    let plain = !name.is_empty() && name.trim() == name && name != "*" && !name.contains(['.', '"', '\'']);
    if plain { name.to_owned() } else { format!("{quote}{name}{quote}") }
}

fn holds(form: &registry::Form) -> Option<Holds> {
    match form {
        registry::Form::Number { quantity, minimum, exclusive, maximum } => {
            let bound = Bound { minimum: *minimum, exclusive: *exclusive, maximum: *maximum };
            Some(number(*quantity, bound))
        }
        registry::Form::Vector { .. } => None,
        registry::Form::Count { minimum } => Some(Holds::Count(*minimum)),
        registry::Form::Flag => Some(Holds::Flag),
        registry::Form::Choice(words) => {
            Some(Holds::Choice(words.iter().map(|word| (word.clone(), String::new())).collect()))
        }
    }
}

fn number(quantity: Quantity, bound: Bound) -> Holds {
    let unit = if quantity == Quantity::Dimensionless { "" } else { unit_of(quantity) };
    let Bound { minimum, maximum, .. } = bound.of(quantity);
    Holds::Number { unit: unit.to_owned(), minimum, maximum }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_quoted_where_a_way_would_be_misread() {
        assert_eq!(quoted("trunk 1"), "trunk 1");
        assert_eq!(quoted("a.b"), "\"a.b\"");
        assert_eq!(quoted("a\"b"), "'a\"b'");
    }
}
