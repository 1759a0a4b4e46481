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
//! variant each. And any range of whole chains ([`Points::chains_of`]) can be computed by another process, on another
//! machine.
//!
//! # Points without a result
//!
//! A point whose values are refused, that takes longer than the time limit of the sweep, or at which the program panics
//! is a row with that status and the reason; the others are not touched. Only the time limit depends on the machine.
//!
//! Native code of a plugin can end the process, or never return. A program that loads plugins therefore computes the
//! chains in other processes, with [`Points::chain_without`]: it tells there which points no process has survived.

mod deadline;
pub(crate) mod outputs;
mod ranges;
pub mod tubes;

use deadline::Deadlines;
use outputs::Recorder;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::io;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
#[cfg(feature = "gpu")]
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use tubes::{Lines, Stations};
use wireloom_core::equilibrium::StepResult;
use wireloom_core::network::Branch;
use wireloom_core::requirement::Measure;
use wireloom_core::{Monitor, Network, Registry, Status, Vector};
use wireloom_export::ending::Ending;
use wireloom_export::table::{Computed, Extremes, REFUSED, statistics};
use wireloom_scenario::sweep::{Axis, Output, Value};
use wireloom_scenario::{Built, Fault, Files};
use wireloom_shapes::swept::{Envelope, TooFine};
use wireloom_solve::steps::checkpoint::{Checkpoint, Observer, Resumed};
use wireloom_solve::{Control, Progress};

pub use ranges::NotWhole;
pub use wireloom_export::gltf::Tube;
pub use wireloom_export::table::{CRASHED, Cell, Header, Row, TIME_LIMIT};
#[cfg(feature = "gpu")]
pub use wireloom_gpu::batch::Batch;
pub use wireloom_scenario::sweep::Sweep;

/// Stand-in for the batch of harnesses on a device: without the feature `gpu` there is none.
#[cfg(not(feature = "gpu"))]
#[derive(Clone, Copy, Debug)]
pub enum Batch {}

/// Most points of a chain: the work that is lost on each core if the process is killed. One of them is computed twice.
const LONGEST: usize = 64;
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
    /// Stations of the tubes of its tolerance envelope.
    pub stations: Stations,
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
    let stations = Stations::of(&built.network, &built.schedule);
    let points = Points { text, files, minimiser: None, registry, batch: None, sweep, header, stations };
    let chains: Vec<usize> = (0..points.chain_count()).collect();
    let done = Mutex::new(Vec::new());
    let kept = points.compute(&chains, &Monitor::default(), &|| (), |chain, computed| {
        done.lock().unwrap_or_else(PoisonError::into_inner).push((chain, computed.rows));
        Ok::<(), Infallible>(())
    });
    kept.unwrap_or_else(|never| match never {});
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_unstable_by_key(|(chain, _)| *chain);
    Ok((points.header, done.into_iter().flat_map(|(_, rows)| rows).collect()))
}

/// Names of the columns of a sweep over this harness.
pub fn header(sweep: &Sweep, network: &Network) -> Header {
    let keys = sweep.axes.iter().map(|axis| (axis.key.clone(), axis.range.is_numeric())).collect();
    header_of(keys, &sweep.outputs, network)
}

/// Names of the columns for these keys and outputs.
pub(crate) fn header_of(keys: Vec<(String, bool)>, outputs: &[Output], network: &Network) -> Header {
    let mut constraints: Vec<String> = Vec::new();
    // A name may be taken again when a constraint has let go.
    for constraint in &network.constraints {
        if !constraints.contains(&constraint.name) {
            constraints.push(constraint.name.clone());
        }
    }
    Header {
        keys,
        branches: network.branches.iter().map(|branch| branch.name.clone()).collect(),
        constraints,
        outputs: outputs.iter().flat_map(outputs::columns).collect(),
    }
}

/// Points of a chain that are not computed, because the process that tried ended at them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Without {
    /// Whether all points have cold starts: a process ended at a warm one.
    pub cold: bool,
    /// Points at whose cold start a process ended, with their status and the reason.
    pub points: BTreeMap<usize, (String, String)>,
}

/// Work on the points of a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Work {
    /// A point begins, with a cold start or with a warm one.
    Begins {
        /// Number of the point.
        point: usize,
        /// Whether its start is cold.
        cold: bool,
    },
    /// A point is done. Each point is counted once, also if the chain is computed again.
    Done,
}

/// A chain that was computed.
pub struct Chain {
    /// Its rows.
    pub rows: Vec<Row>,
    /// Space that the harness sweeps at its points, if the sweep asks for it.
    pub swept: Option<Result<Envelope, TooFine>>,
    /// Centre lines of each of its points, if the sweep asks for the space swept.
    pub lines: Vec<Lines>,
}

/// What all points of a chain have in common.
struct Job<'j> {
    deadlines: &'j Deadlines<'j>,
    without: &'j Without,
    watched: &'j dyn Fn(Work),
}

/// A point that was computed.
struct Point {
    row: Row,
    /// Its centre lines, if the sweep asks for the space swept.
    lines: Lines,
    /// Balanced start, for warm starts of other points.
    start: Option<Start>,
}

/// Number of threads on which [`Points::compute`] works.
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// Does work for which [`Points::compute`] and all that it calls have this many threads, instead of one for each core.
///
/// # Errors
/// The threads cannot be started.
pub fn on_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> io::Result<R> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(io::Error::other)?;
    Ok(pool.install(work))
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
    /// Number of points of a chain; the last one may be shorter.
    pub fn chain_length(&self) -> usize {
        let longest = if self.batch.is_some() { LONGEST_TOGETHER } else { LONGEST };
        (self.sweep.points / CHAINS).clamp(1, longest)
    }

    /// Number of chains.
    pub fn chain_count(&self) -> usize {
        self.sweep.points.div_ceil(self.chain_length())
    }

    /// The points of a chain, by its index.
    pub fn points_of(&self, chain: usize) -> Range<usize> {
        let first = chain * self.chain_length();
        first..(first + self.chain_length()).min(self.sweep.points)
    }

    /// The chains, by their indices, that a range of points is made of.
    ///
    /// # Errors
    /// It is not made of whole chains.
    pub fn chains_of(&self, points: Range<usize>) -> Result<Range<usize>, NotWhole> {
        ranges::chains(points, self.chain_length(), self.sweep.points)
    }

    /// Metadata of the table of its points; `program`: name and version of the program, `file`: name of the scenario's
    /// file, `requirements`: those that its points have.
    pub fn notes(
        &self,
        program: &str,
        scenario: &str,
        file: &str,
        requirements: &[(String, Measure)],
    ) -> Vec<(String, String)> {
        let crossed: Vec<&str> = self.sweep.axes[..self.sweep.crossed].iter().map(|axis| axis.key.as_str()).collect();
        let notes = [
            ("wireloom.program", program),
            ("wireloom.scenario", scenario),
            ("wireloom.text", self.text),
            (statistics::FILE, file),
            (statistics::METHOD, self.sweep.method.word()),
            (statistics::CROSSED, &crossed.join("\n")),
            (statistics::REQUIREMENTS, &statistics::requirement_lines(requirements)),
        ];
        notes.map(|(key, text)| (key.to_owned(), text.to_owned())).to_vec()
    }

    /// Computes chains, given by their indices, on all cores until `monitor` is told to stop. `keep` is called with
    /// each chain that is done, `done` for each point.
    ///
    /// # Errors
    /// The first one of `keep`.
    pub fn compute<E: Send>(
        &self,
        chains: &[usize],
        monitor: &Monitor,
        done: &(dyn Fn() + Sync),
        keep: impl Fn(usize, Chain) -> Result<(), E> + Sync,
    ) -> Result<(), E> {
        let deadlines = Deadlines::new(self.sweep.time_limit, monitor);
        let without = Without::default();
        let watched = |work: Work| {
            if work == Work::Done {
                done()
            }
        };
        let chain = |&k: &usize| match self
            .chain(self.points_of(k), &Job { deadlines: &deadlines, without: &without, watched: &watched })
        {
            Some(computed) => keep(k, computed),
            None => Ok(()),
        };
        deadlines.watch(|| match self.batch {
            // One at a time: which thread takes which makes no difference.
            None => chains.par_iter().with_max_len(1).try_for_each(chain),
            #[cfg(feature = "gpu")]
            Some(batch) => together(batch, chains, chain),
            #[cfg(not(feature = "gpu"))]
            Some(batch) => match *batch {},
        })
    }

    /// Computes one chain, given by its index, on this thread, without some points. `watched` is called as the work
    /// goes on. `None`: `monitor` has stopped it.
    pub fn chain_without(
        &self,
        chain: usize,
        without: &Without,
        monitor: &Monitor,
        watched: &dyn Fn(Work),
    ) -> Option<Chain> {
        let deadlines = Deadlines::new(self.sweep.time_limit, monitor);
        deadlines.watch(|| self.chain(self.points_of(chain), &Job { deadlines: &deadlines, without, watched }))
    }

    /// A chain; `None` if it was stopped.
    fn chain(&self, points: Range<usize>, job: &Job<'_>) -> Option<Chain> {
        let mut done = 0;
        let warm = if job.without.cold { None } else { self.near_each_other(points.clone(), job, &mut done) };
        let chain = match warm {
            Some(chain) => chain,
            None => {
                let mut swept = self.nothing_swept();
                let mut afresh = |k| self.point(k, Began::Afresh, job, &mut swept);
                let all = points.clone().map(|k| afresh(k).map(|Point { row, lines, .. }| (row, lines)));
                let (rows, lines) = all.collect::<Option<(Vec<Row>, Vec<Lines>)>>()?;
                Chain { rows, swept, lines }
            }
        };
        points.skip(done).for_each(|_| (job.watched)(Work::Done));
        Some(chain)
    }

    /// The space that nothing has been in, if the sweep asks for it.
    fn nothing_swept(&self) -> Option<Result<Envelope, TooFine>> {
        self.sweep.swept.map(|cell| Ok(Envelope::new(cell, &[])))
    }

    /// A chain with warm starts; `None` if cold starts are needed, or it was stopped. `done` counts the points that are
    /// done.
    fn near_each_other(&self, points: Range<usize>, job: &Job<'_>, done: &mut usize) -> Option<Chain> {
        let places: Vec<Vec<f64>> = points.clone().map(|k| self.sweep.place(k)).collect();
        let distance =
            |a: usize, b: usize| -> f64 { places[a].iter().zip(&places[b]).map(|(a, b)| (a - b) * (a - b)).sum() };
        let mut all: Vec<Option<Point>> = points.clone().map(|_| None).collect();
        let mut swept = self.nothing_swept();
        let mut last = None;
        // Of each point the distance of the nearest one that has a start, and its index; the first of equals.
        let mut nearest = vec![(f64::INFINITY, usize::MAX); all.len()];
        let left = |all: &[Option<Point>]| (0..all.len()).filter(|i| all[*i].is_none()).collect::<Vec<_>>();
        while let Some(i) = left(&all).into_iter().min_by(|a, b| nearest[*a].0.total_cmp(&nearest[*b].0)) {
            let start = all.get(nearest[i].1).and_then(|near| near.as_ref()?.start.as_ref());
            if start.is_some() {
                last = Some(i);
            }
            let point = self.point(points.start + i, start.map_or(Began::Afresh, Began::Near), job, &mut swept)?;
            let has_start = point.start.is_some();
            all[i] = Some(point);
            for j in left(&all).into_iter().filter(|_| has_start) {
                let (known, index) = nearest[j];
                let own = distance(i, j);
                if own < known || (own == known && i < index) {
                    nearest[j] = (own, i);
                }
            }
            *done += 1;
            (job.watched)(Work::Done);
        }
        let mut all: Vec<Point> = all.into_iter().flatten().collect();
        if let Some(i) = last {
            let afresh = self.point(points.start + i, Began::Afresh, job, &mut swept)?;
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
        let (rows, lines) = all.into_iter().map(|Point { row, lines, .. }| (row, lines)).unzip();
        Some(Chain { rows, swept, lines })
    }

    /// Computes a point; `None` if it has no start near that of the other point, or was stopped.
    fn point(
        &self,
        k: usize,
        from: Began<'_>,
        job: &Job<'_>,
        swept: &mut Option<Result<Envelope, TooFine>>,
    ) -> Option<Point> {
        if job.deadlines.is_stopped() {
            return None;
        }
        let cell = |(axis, value): (&Axis, Option<Value>)| match value {
            Some(Value { number: Some(number), .. }) if axis.range.is_numeric() => Cell::Number(number),
            Some(value) => Cell::Word(value.word().to_owned()),
            None => Cell::Empty,
        };
        let values: Vec<Cell> = self.sweep.axes.iter().zip(self.sweep.point(k)).map(cell).collect();
        if let Some((status, reason)) = job.without.points.get(&k) {
            let row = self.header.without_result(values, status, Some(reason.clone()));
            return Some(Point { row, lines: Lines::new(), start: None });
        }
        (job.watched)(Work::Begins { point: k, cold: matches!(from, Began::Afresh) });
        let deadline = job.deadlines.begin();
        let attempt = AssertUnwindSafe(|| self.carry_out(k, from, values.clone(), &deadline.monitor, swept));
        let (status, reason) = match catch_unwind(attempt) {
            Ok(Attempt::Done(point)) => return Some(*point),
            Ok(Attempt::NoStart) => return None,
            Ok(Attempt::Stopped(_)) if job.deadlines.is_stopped() => return None,
            Ok(Attempt::Stopped(at)) => {
                let limit = self.sweep.time_limit.unwrap_or_default();
                let at = at.map_or("while its start was being found".to_owned(), |at| {
                    format!("after increment {} of {} of step `{}`", at.increment, at.increments, at.step)
                });
                (TIME_LIMIT, format!("not done within {limit} s: it was ended {at}"))
            }
            Err(panic) => (CRASHED, format!("the program failed at this point: {}", panic_words(panic.as_ref()))),
        };
        // What a start from another point leads to does not count against it.
        matches!(from, Began::Afresh).then(|| self.without_result(values, status, Some(reason)))
    }

    /// A point that has no result.
    fn without_result(&self, values: Vec<Cell>, status: &str, reason: Option<String>) -> Point {
        Point { row: self.header.without_result(values, status, reason), lines: Lines::new(), start: None }
    }

    /// The attempt to compute a point.
    fn carry_out(
        &self,
        k: usize,
        from: Began<'_>,
        values: Vec<Cell>,
        monitor: &Monitor,
        swept: &mut Option<Result<Envelope, TooFine>>,
    ) -> Attempt {
        let mut settings = self.sweep.settings(k);
        settings.extend(self.minimiser.map(wireloom_scenario::Setting::minimiser));
        let loaded = crate::load_with_settings(self.text, &settings, self.files, self.registry)
            .and_then(|(scenario, built)| crate::mesh::by_accuracy(scenario, built, self.registry, monitor));
        let (scenario, built) = match loaded {
            Ok(loaded) => loaded,
            Err(faults) => {
                return Attempt::Done(Box::new(self.without_result(values, REFUSED, Some(said(&faults)))));
            }
        };
        let Built { network, coarse, schedule, mut minimiser, stop: when, .. } = built;
        let resumed = match from {
            Began::Afresh => None,
            Began::Near(Start { network: other, checkpoint }) => {
                let near = (other, checkpoint);
                let start = wireloom_solve::start_near(&network, minimiser.as_mut(), &when, &schedule, near, monitor);
                let Some(checkpoint) = start else { return Attempt::NoStart };
                Some(Resumed { checkpoint, steps: Vec::new() })
            }
        };
        // Where outputs are measured may vary.
        let outputs = scenario.sweep.as_ref().map_or(&[][..], |sweep| &sweep.outputs);
        if let Some(Ok(swept)) = swept {
            swept.begin(&network.branches.iter().map(Branch::radii).collect::<Vec<_>>());
        }
        let mut watching = Watching {
            monitor,
            network: &network,
            start: None,
            at: None,
            recorder: Recorder::new(outputs),
            extremes: Extremes::default(),
            lines: Lines::new(),
            stations: &self.stations,
            swept,
        };
        let minimiser = minimiser.as_mut();
        let run =
            wireloom_solve::carry_out(&network, coarse.as_ref(), minimiser, &when, &schedule, resumed, &mut watching);
        let Watching { start, at, recorder, extremes, lines, .. } = watching;
        if run.status() == Status::Interrupted {
            return Attempt::Stopped(at);
        }
        // Why a run ended before its time.
        let message = run.fault().map(|fault| fault.message.clone());
        let row = match (Ending::of(&run), run.steps.last()) {
            (Some(ending), Some(end)) => {
                let outputs = recorder.finish(&network, end);
                let verdict = Some((run.verdict(), &run.requirements[..]));
                let row = self.header.row(values, &ending, Computed { extremes, outputs, verdict });
                Row { message, ..row }
            }
            _ => self.header.without_result(values, run.status().word(), message),
        };
        let start = start.filter(Checkpoint::is_balanced_start);
        let start = start.map(|checkpoint| Start { network, checkpoint });
        Attempt::Done(Box::new(Point { row, lines, start }))
    }
}

/// How the attempt to compute a point ended.
enum Attempt {
    Done(Box<Point>),
    /// It has no start near that of the other point.
    NoStart,
    /// It was stopped, after this increment.
    Stopped(Option<Progress>),
}

/// Message of a panic.
fn panic_words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "it did not say why".to_owned())
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

/// Keeps the first checkpoint, and what is measured at each increment.
struct Watching<'s> {
    monitor: &'s Monitor,
    network: &'s Network,
    start: Option<Checkpoint>,
    /// The last increment.
    at: Option<Progress>,
    recorder: Recorder<'s>,
    extremes: Extremes,
    lines: Lines,
    stations: &'s Stations,
    swept: &'s mut Option<Result<Envelope, TooFine>>,
}

impl Watching<'_> {
    /// The harness goes on to these positions of its nodes.
    fn sweep(&mut self, lines: &[Vec<Vector>]) {
        if let Some(swept) = self.swept
            && let Ok(envelope) = swept
            && let Err(too_fine) = envelope.sweep(lines)
        {
            *swept = Err(too_fine);
        }
    }
}

impl Observer for Watching<'_> {
    fn increment(&mut self, progress: &Progress, end: &StepResult, _: bool) -> Control {
        self.at = Some(progress.clone());
        self.extremes.add(end);
        self.recorder.add(self.network, progress, end);
        if self.swept.is_some() {
            let lines: Vec<Vec<Vector>> = end.branches.iter().map(|branch| branch.position.clone()).collect();
            self.sweep(&lines);
            self.lines.resize(progress.steps, Vec::new());
            if progress.increment == progress.increments && end.status == Status::Converged {
                self.lines[progress.step_index] = self.stations.at(end);
            }
        }
        Control::Continue
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        if self.start.is_none() {
            self.start = Some(checkpoint.clone());
            let branches = self.network.branches.iter();
            let lines: Vec<_> = branches.map(|branch| checkpoint.points()[branch.points.clone()].to_vec()).collect();
            self.sweep(&lines);
        }
    }

    fn monitor(&self) -> Monitor {
        self.monitor.clone()
    }
}

fn said(faults: &[Fault]) -> String {
    faults.iter().map(|fault| fault.message.as_str()).collect::<Vec<_>>().join("; ")
}
