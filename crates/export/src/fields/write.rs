//! Writer of `fields.arrow`.

use super::{FILE, failed, item, schema};
use crate::format::{Ended, File, Format};
use arrow_array::types::Int32Type;
use arrow_array::{ArrayRef, DictionaryArray, FixedSizeListArray, Float64Array, Int32Array, RecordBatch, StringArray};
use arrow_array::{UInt32Array, builder::BooleanBufferBuilder};
use arrow_ipc::writer::FileWriter;
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::io::{self, BufWriter, Write};
use std::sync::Arc;
use wireloom_core::Vector;
use wireloom_core::equilibrium::{BranchResult, Run, StepResult};
use wireloom_core::rotation::columns;

/// The format `fields.arrow`.
pub struct Fields;

impl Format for Fields {
    fn key(&self) -> Option<&'static str> {
        Some("fields")
    }

    fn files(&self) -> &'static [&'static str] {
        &[FILE]
    }

    fn media_type(&self) -> &'static str {
        "application/vnd.apache.arrow.file"
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        vec![File::new(FILE, |out| write(ended.run, out))]
    }
}

/// Writes the node fields of all equilibria of `run`.
///
/// # Errors
/// Those of `out`; `InvalidInput` where the lists of a branch differ in length.
pub fn write(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 20, out);
    batches(run, &mut out)?;
    out.flush()
}

/// SHA-256 of the part of each equilibrium in the file that [`write`] writes.
pub(crate) fn hashes(run: &Run) -> io::Result<Vec<String>> {
    batches(run, io::sink())
}

/// Writes the file; returns the SHA-256 of each part of it: from the end of a record batch to the end of the next.
fn batches(run: &Run, out: impl Write) -> io::Result<Vec<String>> {
    let any = |has: fn(&BranchResult) -> bool| run.steps.iter().flat_map(|step| &step.branches).any(has);
    let optional = [any(|branch| branch.friction.is_some()), any(|branch| branch.strain.is_some())];
    let schema = Arc::new(schema(&run.scenario, optional));
    let steps = Names::of(run.steps.iter().map(|step| step.name.as_str()));
    let branches = Names::of(run.steps.iter().flat_map(|step| &step.branches).map(|branch| branch.name.as_str()));
    let mut writer = FileWriter::try_new(Hashing { out, hash: Sha256::new() }, &schema).map_err(failed)?;
    let mut hashes = Vec::with_capacity(run.steps.len());
    for step in &run.steps {
        let batch = RecordBatch::try_new(schema.clone(), arrays(step, optional, &steps, &branches)?).map_err(failed)?;
        writer.write(&batch).map_err(failed)?;
        // What was written since the batch before, or since the start of the file.
        hashes.push(format!("{:x}", writer.get_mut().hash.finalize_reset()));
    }
    writer.finish().map_err(failed)?;
    Ok(hashes)
}

/// A writer that hashes what goes through it.
struct Hashing<W> {
    out: W,
    hash: Sha256,
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Names, each once, and the index of each.
struct Names<'a> {
    values: ArrayRef,
    index: HashMap<&'a str, i32>,
}

impl<'a> Names<'a> {
    fn of(names: impl Iterator<Item = &'a str>) -> Self {
        let (mut all, mut index) = (vec![], HashMap::new());
        for name in names {
            index.entry(name).or_insert_with(|| {
                all.push(name);
                i32::try_from(all.len() - 1).unwrap_or(i32::MAX)
            });
        }
        Self { values: Arc::new(StringArray::from(all)), index }
    }

    fn array(&self, names: impl Iterator<Item = &'a str>) -> io::Result<ArrayRef> {
        let keys: Int32Array = names.map(|name| self.index.get(name).copied()).collect();
        let array = DictionaryArray::<Int32Type>::try_new(keys, self.values.clone());
        Ok(Arc::new(array.map_err(failed)?))
    }
}

/// The columns of an equilibrium.
fn arrays<'a>(
    step: &'a StepResult,
    [has_set, has_strain]: [bool; 2],
    steps: &Names<'a>,
    branches: &Names<'a>,
) -> io::Result<Vec<ArrayRef>> {
    let own = &step.branches;
    own.iter().try_for_each(same_lengths)?;
    let rows: usize = own.iter().map(|branch| branch.s.len()).sum();
    let increment = u32::try_from(step.increment).unwrap_or(u32::MAX);
    let of_rows = own.iter().flat_map(|branch| std::iter::repeat_n(branch.name.as_str(), branch.s.len()));
    let director = |k: usize| vectors(own.iter().flat_map(|b| &b.frame).map(move |frame| columns(frame)[k]));
    let mut all = vec![
        steps.array(std::iter::repeat_n(step.name.as_str(), rows))?,
        Arc::new(UInt32Array::from(vec![increment; rows])),
        branches.array(of_rows)?,
        numbers(own.iter().flat_map(|branch| &branch.s)),
        vectors(own.iter().flat_map(|branch| &branch.position).copied())?,
        director(2)?,
        director(0)?,
        vectors(own.iter().flat_map(|branch| &branch.force).copied())?,
        vectors(own.iter().flat_map(|branch| &branch.moment).copied())?,
        numbers(own.iter().flat_map(|branch| &branch.bend_radius)),
    ];
    if has_set {
        all.push(set(own, rows)?);
    }
    if has_strain {
        all.push(strain(own));
    }
    Ok(all)
}

fn same_lengths(branch: &BranchResult) -> io::Result<()> {
    let set = branch.friction.as_ref().map_or(branch.s.len(), |friction| friction.set.len());
    let strain = branch.strain.as_ref().map_or(branch.s.len(), Vec::len);
    let lengths = [
        strain,
        branch.position.len(),
        branch.frame.len(),
        branch.force.len(),
        branch.moment.len(),
        branch.bend_radius.len(),
        set,
    ];
    if lengths.iter().all(|length| *length == branch.s.len()) {
        return Ok(());
    }
    let message = format!("the lists of branch \"{}\" differ in length", branch.name);
    Err(io::Error::new(io::ErrorKind::InvalidInput, message))
}

fn numbers<'a>(values: impl Iterator<Item = &'a f64>) -> ArrayRef {
    Arc::new(Float64Array::from_iter_values(values.copied()))
}

fn vectors(values: impl Iterator<Item = Vector>) -> io::Result<ArrayRef> {
    let numbers = Float64Array::from_iter_values(values.flat_map(<[f64; 3]>::from));
    Ok(Arc::new(FixedSizeListArray::try_new(item(), 3, Arc::new(numbers), None).map_err(failed)?))
}

/// The set of each node, null for branches without friction.
fn set(branches: &[BranchResult], rows: usize) -> io::Result<ArrayRef> {
    let (mut numbers, mut valid) = (Vec::with_capacity(3 * rows), BooleanBufferBuilder::new(rows));
    for branch in branches {
        match &branch.friction {
            Some(friction) => numbers.extend(friction.set.iter().flat_map(|v| <[f64; 3]>::from(*v))),
            None => numbers.resize(numbers.len() + 3 * branch.s.len(), 0.0),
        }
        valid.append_n(branch.s.len(), branch.friction.is_some());
    }
    let numbers = Arc::new(Float64Array::from(numbers));
    let list = FixedSizeListArray::try_new(item(), 3, numbers, Some(valid.finish().into()));
    Ok(Arc::new(list.map_err(failed)?))
}

/// The strain of each node, null for branches whose axial law is linear.
fn strain(branches: &[BranchResult]) -> ArrayRef {
    let of_branch = |branch: &BranchResult| match &branch.strain {
        Some(strain) => strain.iter().copied().map(Some).collect(),
        None => vec![None; branch.s.len()],
    };
    Arc::new(branches.iter().flat_map(of_branch).collect::<Float64Array>())
}
