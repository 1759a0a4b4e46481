//! Results whose equilibria are read when they are asked for.

use super::convert::{Apart, fill};
use super::document::{Document, Step};
use super::stream::{explained, invalid, is_apart};
use crate::fields::{BranchFields, Reader};
use serde::Deserialize;
use serde::de::Deserializer;
use serde_json::value::RawValue;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use wireloom_core::Run;
use wireloom_core::equilibrium::StepResult;

/// A result of which everything but its equilibria was read. These are read one by one, from `result.json` and from the
/// file with the fields of their nodes, if there is one.
pub struct Opened<R> {
    /// The run, without equilibria.
    pub run: Run,
    result: R,
    steps: Vec<Range<u64>>,
    fields: Option<Reader<R>>,
}

/// The steps as text.
struct Texts<'a>(Vec<&'a RawValue>);

impl<'de: 'a, 'a> Deserialize<'de> for Texts<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self)
    }
}

impl<R: Read + Seek> Opened<R> {
    /// Opens a `result.json`; `fields` opens the file with the fields of its nodes, where they are in one.
    ///
    /// # Errors
    /// Those of `result` and `fields`; `InvalidData`, with the path of the field, where it is no result.
    pub fn open(mut result: R, fields: impl FnOnce() -> io::Result<R>) -> io::Result<Self> {
        let mut text = String::new();
        result.read_to_string(&mut text)?;
        let mut json = serde_json::Deserializer::from_str(&text);
        let document: Document<Texts<'_>> =
            serde_path_to_error::deserialize(&mut json).map_err(|error| explained(error, ""))?;
        json.end()?;
        let start = text.as_ptr() as usize;
        let place = |step: &&RawValue| {
            let from = (step.get().as_ptr() as usize - start) as u64;
            from..from + step.get().len() as u64
        };
        let steps: Vec<Range<u64>> = document.steps.0.iter().map(place).collect();
        let fields = match document.fields {
            Some(_) => Some(open(fields()?, steps.len())?),
            None => None,
        };
        let run = document.run(|_| vec![]).map_err(invalid)?;
        Ok(Self { run, result, steps, fields })
    }

    /// Number of equilibria.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Whether the fields of nodes are in another file.
    pub fn has_fields_apart(&self) -> bool {
        self.fields.is_some()
    }

    /// Reads equilibrium `k`; `None` where there is none.
    ///
    /// # Errors
    /// Those of the files; `InvalidData`, with the path of the field, where it is not what was written.
    pub fn step(&mut self, k: usize) -> io::Result<Option<StepResult>> {
        let Some(place) = self.steps.get(k) else { return Ok(None) };
        let mut text = vec![0; (place.end - place.start) as usize];
        self.result.seek(SeekFrom::Start(place.start))?;
        self.result.read_exact(&mut text)?;
        let mut json = serde_json::Deserializer::from_slice(&text);
        let at = format!("steps[{k}]");
        let step: Step = serde_path_to_error::deserialize(&mut json).map_err(|error| explained(error, &at))?;
        let refused = |message: String| invalid(format!("{at}: {message}"));
        let apart = step.apart().map_err(refused)?;
        let mut step = step.result().map_err(refused)?;
        match (&mut self.fields, apart) {
            (None, None) => {}
            (Some(fields), Some(Apart { nodes, hash })) => fill(&mut step, fields.read(k, &nodes, &hash)?),
            (fields, apart) => {
                let named = fields.is_some().then_some(super::values::FieldsFile);
                is_apart(named, apart.is_some(), apart.is_none())?;
            }
        }
        Ok(Some(step))
    }
}

/// Opens the file of fields of this number of equilibria.
fn open<F: Read + Seek>(input: F, equilibria: usize) -> io::Result<Reader<F>> {
    let reader = Reader::open(input)?;
    if reader.len() == equilibria {
        return Ok(reader);
    }
    let (file, has) = (crate::fields::FILE, reader.len());
    Err(invalid(format!("{file} has {has} equilibria, result.json has {equilibria}: they are of different runs")))
}

/// A reader of node fields that opens their file when the first are asked for.
pub fn reader<F: Read + Seek>(
    fields: impl FnOnce() -> io::Result<F>,
) -> impl FnMut(usize, usize, &Apart) -> io::Result<Vec<BranchFields>> {
    let (mut fields, mut opened) = (Some(fields), None);
    move |k, count, apart| {
        if let Some(fields) = fields.take() {
            opened = Some(open(fields()?, count)?);
        }
        let reader = opened.as_mut().ok_or_else(|| invalid(format!("{} is unreadable", crate::fields::FILE)))?;
        reader.read(k, &apart.nodes, &apart.hash)
    }
}
