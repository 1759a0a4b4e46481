//! Sweeps in parts: a range of points that any machine computes, what is there of all of them, and one table of them.

use crate::failure::Failure;
use crate::files::PROGRAM;
use crate::source::{Held, Loaded, Source};
use crate::worker::{guarded, interruptible};
use pyo3::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use wireloom::gpu::SharedDevice;
use wireloom::scenario::fault::Fault;
use wireloom::session::Monitor;
use wireloom::sweep::tubes::Stations;
use wireloom::sweep::{Points, Row, Sweep, header, on_threads};
use wireloom_dataset::{Dataset, Manifest, Origin, Status};

/// Most threads of a part: more than any machine has cores.
const THREADS: usize = 1024;

/// A sweep, and where its parts go.
#[derive(Clone, FromPyObject)]
pub struct Task {
    /// Its scenario.
    #[pyo3(item(0))]
    source: Source,
    /// The files that came with it from another machine.
    #[pyo3(item(1))]
    files: Option<Held>,
    /// Folder or URL.
    #[pyo3(item(2))]
    place: String,
    /// Chosen columns; `None`: all.
    #[pyo3(item(3))]
    columns: Option<Vec<String>>,
}

impl Task {
    /// Reads the scenario and joins its dataset.
    fn with<T>(&self, work: impl FnOnce(&Points<'_>, &Dataset) -> Result<T, Failure>) -> Result<T, Failure> {
        let devices = SharedDevice::for_single_runs(None).for_batches();
        let registry = wireloom::registry_on(devices.clone(), &Monitor::default());
        let Loaded { scenario, built, registry, texts, hashed, files } =
            self.source.load_on(registry, self.files.clone())?;
        let sweep: &Sweep = scenario.sweep.as_ref().ok_or_else(|| {
            let help = "add [sweep.vary] with the keys that vary".to_owned();
            self.fault("the scenario has no [sweep]", help)
        })?;
        if sweep.swept.is_some() {
            let help = "leave out `swept`, or carry it out with the command line".to_owned();
            return Err(self.fault("a sweep in parts has no swept space", help));
        }
        let points = Points {
            text: &self.source.text,
            files: &files,
            minimiser: None,
            registry: &registry,
            batch: (scenario.minimiser.kind == "gpu").then(|| devices.batch()),
            sweep,
            header: header(sweep, &built.network),
            stations: Stations::of(&built.network, &built.schedule),
        };
        let file = Path::new(&self.source.name).file_name().unwrap_or_default().to_string_lossy();
        let notes = points.notes(PROGRAM, &scenario.name, &file, &[]);
        let origin = Origin { program: PROGRAM, minimiser: None, texts: &texts, hashed: &hashed, plugins: &[], notes };
        let manifest = Manifest::of(origin, &scenario.name, &points, &built.network, self.columns.as_deref())?;
        work(&points, &Dataset::begin(&self.place, manifest)?)
    }

    /// A refusal of the scenario as a whole.
    fn fault(&self, message: &str, help: String) -> Failure {
        let Source { text, name, .. } = self.source.clone();
        let span = text.len()..text.len();
        Failure::Refused { name, text, faults: vec![Fault { span, message: message.to_owned(), help }] }
    }

    /// Computes the part with these points and writes it, unless it is there: its bytes, the number of points that did
    /// not converge, and whether it was there.
    fn part(&self, range: &Range<usize>, threads: usize, monitor: &Monitor) -> Result<(usize, usize, bool), Failure> {
        self.with(|points, dataset| {
            let chains = points.chains_of(range.clone());
            let chains: Vec<usize> = chains.map_err(|fault| Failure::Request(fault.fault(), fault.help()))?.collect();
            if dataset.has(range)? {
                return Ok((0, 0, true));
            }
            let rows: Mutex<BTreeMap<usize, Vec<Row>>> = Mutex::default();
            let compute = || {
                points.compute(&chains, monitor, &|| (), |k, chain| {
                    rows.lock().unwrap_or_else(PoisonError::into_inner).insert(k, chain.rows);
                    Ok::<(), std::convert::Infallible>(())
                })
            };
            on_threads(threads, compute).map_err(Failure::Io)?.unwrap_or_else(|never| match never {});
            let rows: Vec<Vec<Row>> = rows.into_inner().unwrap_or_else(PoisonError::into_inner).into_values().collect();
            // What was stopped is not written.
            if rows.len() < chains.len() {
                return Ok((0, 0, false));
            }
            let written = dataset.write(range, &points.header, &rows)?;
            Ok((written.bytes, written.failed, written.known))
        })
    }
}

/// The files that a scenario names, to go with it to another machine.
#[pyfunction]
pub fn sweep_files(py: Python<'_>, source: Source) -> PyResult<Held> {
    guarded(py, || source.load()?.files.all().map_err(Failure::Result))
}

/// Begins a sweep in parts, or joins it: number of points, and ranges that no part has, in pieces of about `size`
/// points.
#[pyfunction]
pub fn sweep_begin(py: Python<'_>, task: Task, size: usize) -> PyResult<(usize, Vec<(usize, usize)>)> {
    guarded(py, || {
        task.with(|points, dataset| {
            let pieces = dataset.pieces(&dataset.missing()?, size);
            let pieces = pieces.into_iter().map(|range| (range.start, range.end)).collect();
            Ok((points.sweep.points, pieces))
        })
    })
}

/// Computes the part with these points on some threads: its bytes, the number of points that did not converge, and
/// whether it was there already. Ctrl-C stops it; then nothing is written.
#[pyfunction]
pub fn sweep_part(
    py: Python<'_>,
    task: Task,
    first: usize,
    end: usize,
    threads: usize,
) -> PyResult<(usize, usize, bool)> {
    if !(1..=THREADS).contains(&threads) {
        let message = format!("a part is computed on 1 to {THREADS} threads, not on {threads}");
        return Err(Failure::Request(message, "give the number of cores".to_owned()).into());
    }
    interruptible(py, move |monitor| task.part(&(first..end), threads, monitor))
}

type Failed = (String, usize, Vec<(String, usize)>);
type There = (usize, usize, usize, u64, Vec<(usize, usize)>);

/// Points in all, points that parts have, parts, their bytes, ranges that are missing; points that did not converge, by
/// status and reason; points a second; damaged parts and why; foreign objects; and whether the table is written.
#[pyfunction]
#[expect(clippy::type_complexity, reason = "fields of a class, which Python names")]
pub fn sweep_status(
    py: Python<'_>,
    place: String,
) -> PyResult<(There, Vec<Failed>, Option<f64>, Vec<(String, String)>, Vec<String>, bool)> {
    guarded(py, || {
        let dataset = Dataset::open(&place)?;
        let Status { done, parts, bytes, missing, failed, throughput, damaged, foreign, compacted } =
            dataset.status()?;
        let missing = missing.into_iter().map(|range| (range.start, range.end)).collect();
        let failed = failed.into_iter().map(|all| (all.status, all.points, all.reasons)).collect();
        let there = (dataset.manifest().points, done, parts, bytes, missing);
        Ok((there, failed, throughput, damaged, foreign, compacted))
    })
}

/// Writes one table of all parts: its name, rows, columns and bytes.
#[pyfunction]
pub fn sweep_compact(py: Python<'_>, place: String) -> PyResult<(String, usize, usize, u64)> {
    guarded(py, || {
        let table = Dataset::open(&place)?.compact(&|_| ())?;
        Ok((table.name, table.rows, table.columns, table.bytes))
    })
}
