//! Tables by Arrow's PyCapsule interface, which pandas, polars, pyarrow and DuckDB read without a copy.

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{ArrayRef, Float64Array, RecordBatch, RecordBatchIterator, StringArray, UInt64Array};
use arrow_schema::ffi::FFI_ArrowSchema;
use arrow_schema::{ArrowError, Schema};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::sync::Arc;
use wireloom::Run;
use wireloom::result::{Event, EventPlace, Moment, RequirementResult};

/// Columns by name; empty ones where nothing applies are there, too.
type Columns = Vec<(String, ArrayRef)>;

fn words<'a>(name: &str, values: impl Iterator<Item = Option<&'a str>>) -> (String, ArrayRef) {
    (name.to_owned(), Arc::new(values.collect::<StringArray>()))
}

fn numbers(name: &str, values: impl Iterator<Item = Option<f64>>) -> (String, ArrayRef) {
    (name.to_owned(), Arc::new(values.collect::<Float64Array>()))
}

fn counts(name: &str, values: impl Iterator<Item = Option<usize>>) -> (String, ArrayRef) {
    (name.to_owned(), Arc::new(values.map(|n| n.map(|n| n as u64)).collect::<UInt64Array>()))
}

/// Step, its index from 0, and increment from 1.
fn moments<'a>(prefix: &str, of: impl Iterator<Item = Option<&'a Moment>> + Clone) -> Columns {
    vec![
        words(&format!("{prefix}step"), of.clone().map(|at| Some(at?.step.as_str()))),
        counts(&format!("{prefix}step_index"), of.clone().map(|at| Some(at?.step_index))),
        counts(&format!("{prefix}increment"), of.map(|at| Some(at?.increment))),
    ]
}

fn places<'a>(of: impl Iterator<Item = &'a EventPlace> + Clone) -> Columns {
    vec![
        words("constraint", of.clone().map(|place| place.constraint.as_deref())),
        words("obstacle", of.clone().map(|place| place.obstacle.as_deref())),
        words("branch", of.clone().map(|place| place.branch.as_deref())),
        numbers("s", of.clone().map(|place| place.s)),
        words("other_branch", of.clone().map(|place| place.other_branch.as_deref())),
        numbers("other_s", of.map(|place| place.other_s)),
    ]
}

/// A table of a result.
#[pyclass(frozen, module = "wireloom._wireloom")]
pub struct Table(RecordBatch);

fn failed(error: ArrowError) -> PyErr {
    PyValueError::new_err(format!("no table: {error}"))
}

impl Table {
    fn of(columns: Columns) -> PyResult<Self> {
        let batch = RecordBatch::try_from_iter_with_nullable(columns.into_iter().map(|(name, own)| (name, own, true)));
        batch.map(Self).map_err(failed)
    }

    /// The events of a run.
    pub fn events(run: &Run) -> PyResult<Self> {
        let all = run.events.iter();
        let mut columns = vec![words("kind", all.clone().map(|own| Some(own.kind.word())))];
        columns.extend(places(all.clone().map(|own| &own.place)));
        let moment =
            |prefix, of: fn(&Event) -> &Moment| moments(prefix, run.events.iter().map(move |own| Some(of(own))));
        columns.extend(moment("first_", |own| &own.first));
        columns.extend(moment("worst_", |own| &own.worst));
        columns.extend(moment("last_", |own| &own.last));
        columns.push(counts("increments", all.clone().map(|own| Some(own.increments))));
        columns.push(numbers("value", all.clone().map(|own| own.value)));
        columns.push(numbers("limit", all.clone().map(|own| own.limit)));
        columns.push(words("message", all.map(|own| Some(own.message.as_str()))));
        Self::of(columns)
    }

    /// The requirements of a run.
    pub fn requirements(run: &Run) -> PyResult<Self> {
        let all = run.requirements.iter();
        let word = |name, of: fn(&RequirementResult) -> Option<&str>| words(name, run.requirements.iter().map(of));
        let number = |name, of: fn(&RequirementResult) -> Option<f64>| numbers(name, run.requirements.iter().map(of));
        let mut columns = vec![
            word("name", |own| Some(&own.name)),
            word("quantity", |own| Some(own.measure.word())),
            word("unit", |own| Some(own.measure.unit())),
            word("severity", |own| Some(own.severity.word())),
            word("verdict", |own| Some(own.verdict.word())),
            number("worst", |own| own.worst),
            number("limit", |own| Some(own.limit)),
            word("bound", |own| Some(own.bound.word())),
            number("margin", RequirementResult::margin),
            number("error", |own| own.error),
        ];
        columns.extend(moments("", all.clone().map(|own| own.moment.as_ref())));
        columns.extend(places(all.map(|own| &own.place)));
        columns.push(word("origin", |own| Some(own.origin.word())));
        columns.push(word("because", |own| own.because.as_deref()));
        columns.push(word("reason", |own| own.reason.as_deref()));
        Self::of(columns)
    }
}

#[pymethods]
impl Table {
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        let schema: &Schema = self.0.schema_ref();
        let schema = FFI_ArrowSchema::try_from(schema).map_err(failed)?;
        PyCapsule::new_with_value(py, schema, c"arrow_schema")
    }

    /// Another schema may be asked for; the interface lets the producer ignore that.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        drop(requested_schema);
        let batches = RecordBatchIterator::new([Ok(self.0.clone())], self.0.schema());
        let stream = FFI_ArrowArrayStream::new(Box::new(batches));
        PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
    }
}
