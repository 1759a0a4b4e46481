//! Optimisation: which keys of a scenario are chosen, and to what end.

use crate::edit::number::number_at;
use crate::edit::record;
use crate::fault::{Fault, did_you_mean};
use crate::settings::Setting;
use crate::span::Span;
use crate::sweep::Value;
use std::fmt;
use wireloom_core::{Network, Registry};

/// Largest number of combinations of choices.
const MAX_COMBINATIONS: usize = 10_000;
/// Distance from its range, relative to it, at which a value of the file is still in it: round-off of units.
const ROUND_OFF: f64 = 1e-9;

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

/// Refuses what an optimisation cannot vary or minimise.
pub(crate) fn refuse(optimise: &Optimise, text: &str, network: &Network, registry: &Registry) -> Vec<Fault> {
    let variables = optimise.variables.iter().filter_map(|variable| {
        let fault = |message: String, help: String| Some(Fault { span: variable.span.clone(), message, help });
        let key = &variable.key;
        let (from, to) = match &variable.choice {
            Choice::Between { from, to, .. } => (*from, *to),
            Choice::Values(_) => {
                let Fault { message, help, .. } = record::value_at(text, key).err()?;
                return fault(message, help);
            }
        };
        let number = match number_at(text, key, registry) {
            Ok(number) => number,
            Err(Fault { message, help, .. }) => return fault(message, help),
        };
        let room = ROUND_OFF * (to - from);
        if !(from - room..=to + room).contains(&number.value) {
            let own = format!("{} {}", number.value, number.unit);
            let message = format!("the range of `{key}` excludes its own value, {}", own.trim_end());
            let help = format!("the file's own value is the first start: it must lie between {from} and {to} (SI)");
            return fault(message, help);
        }
        None
    });
    let terms = optimise.terms.iter().filter_map(|term| {
        let Minimised::Requirement(name) = &term.of else { return None };
        if network.requirements.iter().any(|requirement| requirement.name == *name) {
            return None;
        }
        let known = ["length", "mass", "worst margin"].into_iter();
        let known = known.chain(network.requirements.iter().map(|requirement| requirement.name.as_str()));
        let message = format!("there is no requirement `{name}` to minimise");
        Some(Fault { span: term.span.clone(), message, help: did_you_mean(name, known) })
    });
    let counts = optimise.variables.iter().map(|variable| match &variable.choice {
        Choice::Values(values) => values.len(),
        Choice::Between { .. } => 1,
    });
    let combinations = counts.fold(1_usize, usize::saturating_mul);
    let many = (combinations > MAX_COMBINATIONS).then(|| Fault {
        span: optimise.span.clone(),
        message: format!("its lists of values have {combinations} combinations"),
        help: format!("at most {MAX_COMBINATIONS} are possible"),
    });
    variables.chain(terms).chain(many).collect()
}

/// Values to try before the work begins, so that the reader finds mistakes: every choice, and for every range the file's
/// own value in the unit of the range.
pub(crate) fn trials<'o>(
    optimise: &'o Optimise,
    text: &str,
    registry: &Registry,
) -> impl Iterator<Item = (&'o Variable, Setting)> {
    let all = optimise.variables.iter().flat_map(|variable| {
        let values = match &variable.choice {
            Choice::Values(values) => values.clone(),
            Choice::Between { unit, .. } => {
                let own = number_at(text, &variable.key, registry).ok();
                own.map(|own| Value::number(own.value, unit)).into_iter().collect()
            }
        };
        values.into_iter().map(move |value| (variable, Setting::new(&variable.key, &value.text)))
    });
    all.collect::<Vec<_>>().into_iter()
}

/// Faults of a trial, at the place of its key in the optimisation.
pub(crate) fn placed(variable: &Variable, trial: &Setting, faults: Vec<Fault>) -> Vec<Fault> {
    let place = |fault: Fault| Fault {
        span: variable.span.clone(),
        message: format!("with `{}` = {}: {}", variable.key, trial.value, fault.message),
        help: fault.help,
    };
    faults.into_iter().take(1).map(place).collect()
}
