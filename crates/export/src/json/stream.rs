//! Steps one by one: a result of many increments is never twice in memory.

use super::convert::{Apart, fill};
use super::document::Step;
use super::values::FieldsFile;
use crate::fields::BranchFields;
use serde::Deserialize;
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, Error, SeqAccess, Visitor};
use serde::ser::{Serialize, Serializer};
use std::fmt;
use std::io::{self, BufReader, Read};
use wireloom_core::equilibrium::StepResult;

/// The list of steps as it is written; `apart`: checksums of their node fields, where those are in another file.
pub struct Written<'a> {
    pub steps: &'a [StepResult],
    pub apart: Option<&'a [String]>,
}

impl Serialize for Written<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let hash = |k: usize| self.apart.and_then(|hashes| hashes.get(k)).map(String::as_str);
        serializer.collect_seq(self.steps.iter().enumerate().map(|(k, step)| Step::of(step, hash(k))))
    }
}

/// Reader of node fields that are in another file: equilibrium, number of them, and what is known of the fields.
pub type Fields<'a> = &'a mut dyn FnMut(usize, usize, &Apart) -> io::Result<Vec<BranchFields>>;

/// Reader where no other file was given.
pub fn not_given(_: usize, _: usize, _: &Apart) -> io::Result<Vec<BranchFields>> {
    Err(invalid(format!("the fields of its nodes are in `{}`, which was not given", crate::fields::FILE)))
}

/// Whether the fields of a result are in another file, which each of its equilibria must say as the result does.
pub fn is_apart(fields: Option<FieldsFile>, all: bool, none: bool) -> io::Result<bool> {
    match fields {
        None if none => Ok(false),
        Some(_) if all => Ok(true),
        None => Err(invalid("missing field `fields`, beside `fields_sha256` of steps".to_owned())),
        Some(_) => Err(invalid("missing field `fields_sha256` of a step, beside `fields`".to_owned())),
    }
}

/// Collector of the steps while they are read.
pub trait Collect: Default {
    /// The vectors of a branch that not every reader needs.
    type Vectors: DeserializeOwned;

    /// Takes the next step; an error says why it cannot be one.
    fn take(&mut self, step: Step<Self::Vectors>) -> Result<(), String>;
}

/// All steps, and what is known of node fields that are in another file.
#[derive(Default)]
pub struct All {
    pub steps: Vec<StepResult>,
    pub apart: Vec<Option<Apart>>,
}

impl Collect for All {
    type Vectors = Vec<super::values::Vector3>;

    fn take(&mut self, step: Step) -> Result<(), String> {
        self.apart.push(step.apart()?);
        self.steps.push(step.result()?);
        Ok(())
    }
}

impl All {
    /// Reads the node fields.
    pub fn filled(mut self, fields: Option<FieldsFile>, read: Fields<'_>) -> io::Result<Vec<StepResult>> {
        let all = self.apart.iter().all(Option::is_some);
        is_apart(fields, all, self.apart.iter().all(Option::is_none))?;
        let count = self.steps.len();
        for (k, (step, apart)) in self.steps.iter_mut().zip(&self.apart).enumerate() {
            if let Some(apart) = apart {
                fill(step, read(k, count, apart)?);
            }
        }
        Ok(self.steps)
    }
}

/// The list of steps as it is read.
pub struct Collected<C>(pub C);

impl<'de, C: Collect> Deserialize<'de> for Collected<C> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Every<C>(C);
        impl<'de, C: Collect> Visitor<'de> for Every<C> {
            type Value = C;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of steps")
            }
            fn visit_seq<A: SeqAccess<'de>>(mut self, mut list: A) -> Result<C, A::Error> {
                while list.next_element_seed(One(&mut self.0))?.is_some() {}
                Ok(self.0)
            }
        }
        deserializer.deserialize_seq(Every(C::default())).map(Self)
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
    let value = serde_path_to_error::deserialize(&mut json).map_err(|error| explained(error, ""))?;
    json.end()?;
    Ok(value)
}

/// `steps[0].branches.trunk: missing field "d1"`. The file is one long line: the path says more than line and column.
/// `at`: the path of what was read.
pub fn explained(error: serde_path_to_error::Error<serde_json::Error>, at: &str) -> io::Error {
    let path = error.path().to_string();
    let error = error.into_inner();
    if !error.is_data() {
        return error.into();
    }
    let text = error.to_string();
    let message = text.strip_suffix(&format!(" at line {} column {}", error.line(), error.column())).unwrap_or(&text);
    let message = match message.split_once(", expected") {
        Some((unknown, _)) if unknown.starts_with("unknown field") => {
            format!("{unknown}, which another version of this program may have written")
        }
        _ => message.to_owned(),
    };
    let parts = [at, path.as_str()].into_iter().filter(|part| !part.is_empty() && *part != ".");
    let path = parts.collect::<Vec<_>>().join(".");
    invalid(if path.is_empty() { message } else { format!("{path}: {message}") })
}

/// An error of what is no result.
pub fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}
