//! Steps one by one: a result of many increments is never twice in memory.

use super::document::Step;
use serde::Deserialize;
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use std::fmt;
use std::io::{self, BufReader, Read};
use wireloom_core::equilibrium::StepResult;

/// The list of steps as it is written.
pub struct Written<'a>(pub &'a [StepResult]);

impl Serialize for Written<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(Step::of))
    }
}

/// Collector of the steps while they are read.
pub trait Collect: Default {
    /// The vectors of a branch that not every reader needs.
    type Vectors: DeserializeOwned;

    /// Takes the next step; an error says why it cannot be one.
    fn take(&mut self, step: Step<Self::Vectors>) -> Result<(), String>;
}

impl Collect for Vec<StepResult> {
    type Vectors = Vec<super::values::Vector3>;

    fn take(&mut self, step: Step) -> Result<(), String> {
        self.push(step.result()?);
        Ok(())
    }
}

/// The list of steps as it is read.
pub struct Collected<C>(pub C);

impl<'de, C: Collect> Deserialize<'de> for Collected<C> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct All<C>(C);
        impl<'de, C: Collect> Visitor<'de> for All<C> {
            type Value = C;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of steps")
            }
            fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<C, A::Error> {
                while list.next_element_seed(One(&mut self.0))?.is_some() {}
                Ok(self.0)
            }
        }
        deserializer.deserialize_seq(All(C::default())).map(Self)
    }
}

/// One step, taken where its index is known to errors.
struct One<'a, C>(&'a mut C);

impl<'de, C: Collect> DeserializeSeed<'de> for One<'_, C> {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        self.0.take(Step::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

/// Reads one JSON value and nothing behind it.
///
/// # Errors
/// Those of `input`; `UnexpectedEof` where it ends too early; `InvalidData` with the path of the field.
pub fn parse<T: DeserializeOwned>(input: impl Read) -> io::Result<T> {
    let mut json = serde_json::Deserializer::from_reader(BufReader::new(input));
    let value = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let path = error.path().to_string();
        let error = error.into_inner();
        if error.is_data() { invalid(explained(&path, &error)) } else { error.into() }
    })?;
    json.end()?;
    Ok(value)
}

/// `steps[0].branches.trunk: missing field "d1"`. The file is one long line: the path says more than line and column.
fn explained(path: &str, error: &serde_json::Error) -> String {
    let text = error.to_string();
    let message = text.strip_suffix(&format!(" at line {} column {}", error.line(), error.column())).unwrap_or(&text);
    let message = match message.split_once(", expected") {
        Some((unknown, _)) if unknown.starts_with("unknown field") => {
            format!("{unknown}, which another version of this program may have written")
        }
        _ => message.to_owned(),
    };
    if path == "." { message } else { format!("{path}: {message}") }
}

/// An error of what is no result.
pub fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}
