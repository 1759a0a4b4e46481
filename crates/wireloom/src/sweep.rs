//! Sweeps: one scenario with many values.
//!
//! ```
//! use wireloom::scenario::NoFiles;
//! use wireloom::sweep::Cell;
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?
//!     + "[sweep.vary]\n\"branches.trunk.length\" = { from = \"590 mm\", to = \"610 mm\", count = 3 }\n";
//! let (header, rows) = wireloom::sweep::run(&text, &NoFiles, &wireloom::registry()).expect("no faults");
//! let force = header.numbers().iter().position(|name| name == "force").expect("a column");
//! for row in &rows {
//!     if let Cell::Number(length) = row.values[0] {
//!         println!("trunk of {length} m: {}, largest force {:?} N", row.status, row.numbers[force]);
//!     }
//! }
//! # assert_eq!(rows.len(), 3);
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! [`run`] computes all points at once. [`Points`] computes them in parts, for programs that keep what is done of a
//! long sweep.
//!
//! # Chains
//!
//! Points are computed in *chains*: blocks of consecutive points that depend on nothing outside. The first point of a
//! chain has a cold start, as a run of it alone has. Each other point has a warm start: the balanced start of the
//! nearest point of the chain that is done. That saves laying the harness out and finding its initial equilibrium; its
//! steps are carried out in full. A warm start must lead to the same equilibrium as a cold one, so:
//!
//! - it must be near: found, and nothing turned far on the way ([`wireloom_solve::start_near`]);
//! - the last point of a chain is started cold, too, and both starts must be the same.
//!
//! If either fails, the equilibrium depends on the way, and all points of the chain are started cold. So points between
//! the ends of a chain have the equilibrium that both ends have. Not detected: a single point between them at which a
//! cold start would find another equilibrium.
//!
//! The chains follow from the number of points alone. So rows are the same to the last bit for any number of threads,
//! and wherever an interrupted sweep was resumed. With the minimiser `gpu` many chains go to the device together, one
//! variant each.

mod outputs;

use rayon::prelude::*;
use std::convert::Infallible;
use std::ops::Range;
#[cfg(feature = "gpu")]
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use wireloom_core::equilibrium::StepResult;
use wireloom_core::{Monitor, Network, Registry, Status};
use wireloom_export::ending::Ending;
use wireloom_scenario::sweep::{Axis, Value};
use wireloom_scenario::{Built, Fault, Files};
use wireloom_solve::steps::checkpoint::{Checkpoint, Observer, Resumed};
use wireloom_solve::{Control, Progress};

pub use wireloom_export::table::{Cell, Header, Row};
#[cfg(feature = "gpu")]
pub use wireloom_gpu::batch::Batch;
pub use wireloom_scenario::sweep::Sweep;

/// Stand-in for the batch of harnesses on a device: without the feature `gpu` there is none.
#[cfg(not(feature = "gpu"))]
#[derive(Clone, Copy, Debug)]
pub enum Batch {}

/// Most points of a chain: the work that is lost on each core if the process is killed. One of them is computed twice.
const LONGEST: usize = 32;
/// Most points of a chain where chains go to a device together: short ones, so that there are many.
const LONGEST_TOGETHER: usize = 4;
/// Most chains that go together: each has a thread, which mostly waits.
#[cfg(feature = "gpu")]
const TOGETHER: usize = 4096;
/// Fewest chains, so that all cores have work.
const CHAINS: usize = 16;

/// Points of a sweep, to be computed in parts.
pub struct Points<'a> {
    /// The scenario's text.
    pub text: &'a str,
    /// The files it names.
    pub files: &'a (dyn Files + Sync),
    /// Kind of minimiser for all points; `None`: as the text says.
    pub minimiser: Option<&'a str>,
    /// The kinds.
    pub registry: &'a Registry,
    /// For the minimiser `gpu`: the batch of the registry's devices, which brings the harnesses of many chains to the
    /// device together.
    pub batch: Option<&'a Batch>,
    /// The sweep of the scenario.
    pub sweep: &'a Sweep,
    /// Names of the columns.
    pub header: Header,
}

/// Computes all points of the sweep of a scenario, on all cores. Returns the names of the columns and one row a point.
///
/// # Errors
/// All faults of the text at once; a text without `[sweep]` is one. A point whose values are refused is a row with its
/// status.
pub fn run(text: &str, files: &(dyn Files + Sync), registry: &Registry) -> Result<(Header, Vec<Row>), Vec<Fault>> {
    let (scenario, built) = crate::load_with_files(text, files, registry)?;
    let Some(sweep) = &scenario.sweep else {
        let message = "the scenario has no [sweep]".to_owned();
        let help = "add [sweep.vary] with the keys that vary".to_owned();
        return Err(vec![Fault { span: text.len()..text.len(), message, help }]);
    };
    let header = header(sweep, &built.network);
    let points = Points { text, files, minimiser: None, registry, batch: None, sweep, header };
    let chains: Vec<usize> = (0..points.chains().len()).collect();
    let done = Mutex::new(Vec::new());
    let kept = points.compute(&chains, &Monitor::default(), &|| (), |chain, rows| {
        done.lock().unwrap_or_else(PoisonError::into_inner).push((chain, rows));
        Ok::<(), Infallible>(())
    });
    kept.unwrap_or_else(|never| match never {});
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_unstable_by_key(|(chain, _)| *chain);
    Ok((points.header, done.into_iter().flat_map(|(_, rows)| rows).collect()))
}

/// Names of the columns of a sweep over this harness.
pub fn header(sweep: &Sweep, network: &Network) -> Header {
    let mut constraints: Vec<String> = Vec::new();
    // A name may be taken again when a constraint has let go.
    for constraint in &network.constraints {
        if !constraints.contains(&constraint.name) {
            constraints.push(constraint.name.clone());
        }
    }
    Header {
        keys: sweep.axes.iter().map(|axis| axis.key.clone()).collect(),
        branches: network.branches.iter().map(|branch| branch.name.clone()).collect(),
        constraints,
        outputs: sweep.outputs.iter().flat_map(outputs::columns).collect(),
    }
}

/// A point that was computed.
struct Point {
    row: Row,
    /// Balanced start, for warm starts of other points.
    start: Option<Start>,
}

/// The balanced start of a point.
struct Start {
    network: Network,
    checkpoint: Checkpoint,
}

/// Start of a point.
#[derive(Clone, Copy)]
enum Began<'s> {
    /// Cold start, as in a run of it alone.
    Afresh,
    /// Warm start, from the start of another point.
    Near(&'s Start),
}

impl Points<'_> {
    /// Chains: ranges of consecutive points.
    pub fn chains(&self) -> Vec<Range<usize>> {
        let points = self.sweep.points;
        let longest = if self.batch.is_some() { LONGEST_TOGETHER } else { LONGEST };
        let length = (points / CHAINS).clamp(1, longest);
        (0..points).step_by(length).map(|first| first..(first + length).min(points)).collect()
    }

    /// Computes chains, given by their indices in [`Self::chains`], on all cores until `monitor` is told to stop.
    /// `keep` is called with the rows of each chain that is done, `done` for each point.
    ///
    /// # Errors
    /// The first one of `keep`.
    pub fn compute<E: Send>(
        &self,
        chains: &[usize],
        monitor: &Monitor,
        done: &(dyn Fn() + Sync),
        keep: impl Fn(usize, Vec<Row>) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        let all = self.chains();
        let chain = |&k: &usize| match self.chain(all[k].clone(), monitor, done) {
            Some(rows) => keep(k, rows),
            None => Ok(()),
        };
        match self.batch {
            // One at a time: which thread takes which makes no difference.
            None => chains.par_iter().with_max_len(1).try_for_each(chain),
            #[cfg(feature = "gpu")]
            Some(batch) => together(batch, chains, chain),
            #[cfg(not(feature = "gpu"))]
            Some(batch) => match *batch {},
        }
    }

    /// Rows of a chain; `None` if it was stopped.
    fn chain(&self, points: Range<usize>, monitor: &Monitor, done: &(dyn Fn() + Sync)) -> Option<Vec<Row>> {
        let mut told = 0;
        let rows = match self.near_each_other(points.clone(), monitor, &mut || {
            told += 1;
            done();
        }) {
            Some(rows) => rows,
            None => {
                let afresh = |k| Some(self.point(k, Began::Afresh, monitor)?.row);
                points.clone().map(afresh).collect::<Option<Vec<Row>>>()?
            }
        };
        points.skip(told).for_each(|_| done());
        Some(rows)
    }

    /// Rows of a chain with warm starts; `None` if cold starts are needed, or it was stopped.
    fn near_each_other(&self, points: Range<usize>, monitor: &Monitor, done: &mut dyn FnMut()) -> Option<Vec<Row>> {
        let places: Vec<Vec<f64>> = points.clone().map(|k| self.sweep.place(k)).collect();
        let distance =
            |a: usize, b: usize| -> f64 { places[a].iter().zip(&places[b]).map(|(a, b)| (a - b) * (a - b)).sum() };
        let mut all: Vec<Option<Point>> = points.clone().map(|_| None).collect();
        let mut last = None;
        loop {
            let has_start = |i: &usize| all[*i].as_ref().is_some_and(|point| point.start.is_some());
            let (starts, left): (Vec<usize>, Vec<usize>) =
                ((0..all.len()).filter(has_start).collect(), (0..all.len()).filter(|i| all[*i].is_none()).collect());
            let pairs = left.iter().flat_map(|i| starts.iter().map(move |near| (*i, *near)));
            // The first of equals.
            let nearest = pairs.min_by(|a, b| distance(a.0, a.1).total_cmp(&distance(b.0, b.1)));
            let (i, from) = match (nearest, left.first()) {
                (Some((i, near)), _) => {
                    last = Some(i);
                    (i, all[near].as_ref().and_then(|point| point.start.as_ref()).map_or(Began::Afresh, Began::Near))
                }
                (None, Some(&first)) => (first, Began::Afresh),
                (None, None) => break,
            };
            all[i] = Some(self.point(points.start + i, from, monitor)?);
            done();
        }
        let mut all: Vec<Point> = all.into_iter().flatten().collect();
        if let Some(i) = last {
            let afresh = self.point(points.start + i, Began::Afresh, monitor)?;
            let same = match (&afresh.start, &all[i].start) {
                (Some(one), Some(other)) => one.checkpoint.is_same_state(&other.checkpoint, &one.network),
                (None, None) => true,
                _ => false,
            };
            if !same {
                return None;
            }
            all[i] = afresh;
        }
        Some(all.into_iter().map(|point| point.row).collect())
    }

    /// Computes a point; `None` if it has no start near that of the other point, or was stopped.
    fn point(&self, k: usize, from: Began<'_>, monitor: &Monitor) -> Option<Point> {
        if monitor.is_stopped() {
            return None;
        }
        let cell = |(axis, value): (&Axis, Value)| match value.number {
            Some(number) if axis.range.is_numeric() => Cell::Number(number),
            _ => Cell::Word(value.word().to_owned()),
        };
        let values: Vec<Cell> = self.sweep.axes.iter().zip(self.sweep.point(k)).map(cell).collect();
        let mut settings = self.sweep.settings(k);
        settings.extend(self.minimiser.map(wireloom_scenario::Setting::minimiser));
        let (scenario, built) = match crate::load_with_settings(self.text, &settings, self.files, self.registry) {
            Ok(loaded) => loaded,
            Err(faults) => {
                return Some(Point { row: self.header.refused(values, said(&faults)), start: None });
            }
        };
        let Built { network, coarse, schedule, mut minimiser, stop: when, .. } = built;
        let resumed = match from {
            Began::Afresh => None,
            Began::Near(Start { network: other, checkpoint }) => {
                let near = (other, checkpoint);
                let checkpoint =
                    wireloom_solve::start_near(&network, minimiser.as_mut(), &when, &schedule, near, monitor)?;
                Some(Resumed { checkpoint, steps: Vec::new() })
            }
        };
        let mut watching = Watching { monitor, start: None };
        let minimiser = minimiser.as_mut();
        let run =
            wireloom_solve::carry_out(&network, coarse.as_ref(), minimiser, &when, &schedule, resumed, &mut watching);
        if run.status == Status::Interrupted {
            return None;
        }
        // Why a run ended before its time.
        let message = run.fault.as_ref().map(|fault| fault.message.clone());
        let row = match (Ending::of(&run), run.steps.last()) {
            (Some(ending), Some(end)) => {
                // Where they are measured may vary.
                let outputs = scenario.sweep.iter().flat_map(|sweep| &sweep.outputs);
                let outputs = outputs.flat_map(|output| outputs::values(output, &ending, end)).collect();
                self.header.row(values, &ending, outputs)
            }
            _ => Row { status: run.status.word().to_owned(), ..self.header.refused(values, String::new()) },
        };
        let start = watching.start.filter(Checkpoint::is_balanced_start);
        let start = start.map(|checkpoint| Start { network, checkpoint });
        Some(Point { row: Row { message, ..row }, start })
    }
}

#[cfg(feature = "gpu")]
/// Works on chains in own threads, which meet on the device. Not in those of rayon: a thread of rayon that waits may
/// have to do another's work first. The first error ends it.
fn together<E: Send>(batch: &Batch, chains: &[usize], work: impl Fn(&usize) -> Result<(), E> + Sync) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let failed: Mutex<Option<E>> = Mutex::new(None);
    let failed_yet = || failed.lock().unwrap_or_else(PoisonError::into_inner);
    std::thread::scope(|scope| {
        for _ in 0..chains.len().min(TOGETHER) {
            scope.spawn(|| {
                let _member = batch.join();
                while let Some(chain) = chains.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if failed_yet().is_some() {
                        return;
                    }
                    if let Err(error) = work(chain) {
                        failed_yet().get_or_insert(error);
                        return;
                    }
                }
            });
        }
    });
    failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
}

/// Keeps the first checkpoint.
struct Watching<'s> {
    monitor: &'s Monitor,
    start: Option<Checkpoint>,
}

impl Observer for Watching<'_> {
    fn increment(&mut self, _: &Progress, _: &StepResult, _: bool) -> Control {
        Control::Continue
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.start.get_or_insert_with(|| checkpoint.clone());
    }

    fn monitor(&self) -> Monitor {
        self.monitor.clone()
    }
}

fn said(faults: &[Fault]) -> String {
    faults.iter().map(|fault| fault.message.as_str()).collect::<Vec<_>>().join("; ")
}
