//! Optimisation: which keys of a scenario are chosen, and to what end.

use crate::settings::Setting;
use crate::span::Span;
use crate::sweep::Value;
use std::fmt;

/// An optimisation.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimise {
    /// Keys that are chosen.
    pub variables: Vec<Variable>,
    /// The objective: a sum of these, which is made as small as possible.
    pub terms: Vec<Term>,
    /// Number of starts for each combination of choices.
    pub starts: usize,
    /// Largest number of runs.
    pub runs: usize,
    /// Margin to keep from every limit, relative to it, beyond the discretisation error.
    pub margin: f64,
    /// Change of the objective, relative to it, below which it counts as smallest.
    pub accuracy: f64,
    /// Its place in the text.
    pub span: Span,
}

/// A key that is chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Path to the key.
    pub key: String,
    /// Its values.
    pub choice: Choice,
    /// Its place in the text.
    pub span: Span,
}

/// Values that a variable may have.
#[derive(Clone, Debug, PartialEq)]
pub enum Choice {
    /// Any number of a range.
    Between {
        /// Least value, SI.
        from: f64,
        /// Greatest value, SI.
        to: f64,
        /// Unit in which they were given; empty without one.
        unit: String,
    },
    /// One of these.
    Values(Vec<Value>),
}

/// A part of the objective.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// What is minimised.
    pub of: Minimised,
    /// Its factor in the sum; above zero.
    pub weight: f64,
    /// Its place in the text.
    pub span: Span,
}

/// What an optimisation makes as small as possible.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Minimised {
    /// Total length of all branches, m.
    Length,
    /// Total mass of all branches, kg.
    Mass,
    /// The smallest relative margin of all requirements that must be kept, which is made as large as possible.
    WorstMargin,
    /// Worst value of the requirement with this name, in its unit.
    Requirement(String),
}

impl Minimised {
    /// What is meant by a word of the scenario.
    pub(crate) fn of(word: &str) -> Self {
        match word {
            "length" => Minimised::Length,
            "mass" => Minimised::Mass,
            "worst margin" => Minimised::WorstMargin,
            name => Minimised::Requirement(name.to_owned()),
        }
    }
}

impl fmt::Display for Minimised {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Minimised::Length => out.write_str("length"),
            Minimised::Mass => out.write_str("mass"),
            Minimised::WorstMargin => out.write_str("worst margin"),
            Minimised::Requirement(name) => out.write_str(name),
        }
    }
}

impl Optimise {
    /// The combinations of all choices, as settings; one without settings where nothing is chosen from a list.
    pub fn combinations(&self) -> Vec<Vec<Setting>> {
        let mut all = vec![Vec::new()];
        for variable in &self.variables {
            let Choice::Values(values) = &variable.choice else { continue };
            let longer = |before: &Vec<Setting>| {
                let with = |value: &Value| [&before[..], &[Setting::new(&variable.key, &value.text)]].concat();
                values.iter().map(with).collect::<Vec<_>>()
            };
            all = all.iter().flat_map(longer).collect();
        }
        all
    }
}
