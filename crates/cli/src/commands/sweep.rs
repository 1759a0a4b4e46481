//! `wireloom sweep`: a scenario over many values, to a table.
//!
//! | in `DIR/` | content |
//! | --- | --- |
//! | `points.parquet` | a row for each point, written when all are done |
//! | `points.csv` | the same, where it is asked for |
//! | `swept.glb` | the space that the harness sweeps at all points, where the scenario asks for it |
//! | `swept-tubes.glb` | tubes around each branch that hold it in a share of the points, likewise |
//! | `.wireloom/envelope` | both for the studio |
//! | `.wireloom/sweep/origin` | the scenario, until the sweep ends |
//! | `.wireloom/sweep/NNNNNN` | chains of points that are done, until the sweep ends |
//! | `.wireloom/sweep/NNNNNN-swept` | the space swept in a chain, likewise |
//! | `.wireloom/sweep/NNNNNN-lines` | centre lines of the points of a chain, likewise |
//!
//! With `--into` parts are written instead ([`wireloom_dataset`]).

mod dataset;
mod into;
mod job;
mod pool;
pub mod process;

use crate::arguments::{SweepArguments, SweepTask};
use crate::failure::{Failure, Outcome};
use crate::files::envelope;
use crate::files::folder::Folder;
use crate::files::own::Own;
use crate::files::saved::{decode, encode, present};
use crate::messages::Computed;
use crate::print::points;
use crate::print::progress::Bar;
use crate::{interrupt, messages};
use job::{Job, Origin};
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use wireloom::export::gltf;
use wireloom::export::table::statistics::{is_needed, keys};
use wireloom::export::table::{FILE, Grouped, Layout, Row, Table, write_csv};
use wireloom::harness::Surface;
use wireloom::shapes::swept::Envelope;
use wireloom::sweep::Points;

const PARTS: &str = "sweep";
const ORIGIN: &str = "sweep/origin";
/// Help where a part is damaged.
const HELP: &str = "remove it, and the same command goes on";
/// Name of the table as text.
const CSV: &str = "points.csv";
/// Name of the mesh of the swept space.
const MESH: &str = "swept.glb";
/// Name of the tubes of the tolerance envelope.
const TUBES: &str = "swept-tubes.glb";

/// Carries out a sweep, or what is to be done with one in parts.
pub fn sweep(arguments: &SweepArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    match (&arguments.task, &arguments.file, &arguments.into) {
        (Some(SweepTask::Status { place }), ..) => dataset::status(place, out),
        (Some(SweepTask::Compact { place, quiet }), ..) => dataset::compact(place, *quiet, out),
        (None, Some(file), Some(place)) => into::into(arguments, file, place, out),
        (None, Some(file), None) => whole(arguments, file, out),
        (None, None, _) => Err(Failure::Input("no scenario is given".to_owned())),
    }
}

/// Carries out a sweep, or goes on with it where it was interrupted.
fn whole(arguments: &SweepArguments, file: &Path, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let bar = Bar::new(format!("reading {}", file.display()), !arguments.quiet);
    let job = Job::read(file, arguments.minimiser.as_deref(), &arguments.allowed)?;
    let (loaded, sweep, points) = (&job.loaded, job.sweep(), job.points());
    let mut folder = Folder::of_results(arguments.out.as_deref(), file)?;
    let place = folder.path().to_path_buf();
    let parts = Parts::begin(&mut folder, &job.origin)?;
    let chains = points.chain_count();
    let to_do = parts.to_do(chains)?;
    let left: usize = to_do.iter().map(|k| points.points_of(*k).len()).sum();
    if left < sweep.points && !arguments.quiet {
        writeln!(out, "going on after {} points", sweep.points - left).map_err(Failure::standard_output)?;
        out.flush().map_err(Failure::standard_output)?;
    }
    bar.count(&loaded.scenario.name, "points", sweep.points, sweep.points - left);
    interrupt::listen();
    let done = || bar.one();
    pool::compute((&job, &points), arguments, &to_do, &done, |k, chain| parts.keep(k, &chain))?;
    if interrupt::asked() {
        drop(bar);
        let words = format!("interrupted; the same command goes on, from {}", place.display());
        writeln!(out, "{words}").map_err(Failure::standard_output)?;
        return Ok(Outcome::NotConverged);
    }
    bar.say(format!("writing {FILE}"));
    let mut layout = Layout::new(&points.header);
    for k in 0..chains {
        layout.add(&parts.read(k)?);
    }
    let notes = job.notes(&points, layout.requirements());
    let tables = Tables { layout: &layout, parts: &parts, points: &points };
    let mut brief = Table { columns: vec![], notes: notes.clone() };
    folder.write(FILE, |out| {
        let empty = Table { notes, ..layout.table(0, &[]) };
        let shown: Vec<String> = keys(&empty).into_iter().map(str::to_owned).collect();
        let mut file = Grouped::begin(&empty, out)?;
        tables.each(|table| {
            file.add(table.clone())?;
            brief.append(table.with_columns(|name| is_shown(name) || shown.iter().any(|key| key == name)));
            Ok(())
        })?;
        file.finish()
    })?;
    let mut written = vec![FILE];
    if arguments.csv {
        folder.write(CSV, |mut out| {
            let mut heading = true;
            tables.each(|table| write_csv(&table, std::mem::take(&mut heading), &mut out))
        })?;
        written.push(CSV);
    }
    let (mut remark, mut left_out) = (None, None);
    if let Some(cell) = sweep.swept {
        bar.say(format!("writing {MESH}"));
        let surface = parts.swept(chains, cell)?;
        match &surface {
            Some(surface) => {
                folder.write(MESH, |mut out| gltf::write_surface("swept", surface, &mut out))?;
                written.push(MESH);
            }
            None => remark = Some(format!("{MESH} is not written: cells of {cell} m take too much memory")),
        }
        bar.say(format!("writing {TUBES}"));
        let tubes = points.stations.tubes(chains, |k| present(&parts.0, &lines(k), HELP))?;
        folder.write(TUBES, |mut out| gltf::write_tubes(&tubes, &mut out))?;
        left_out = outside_of_tubes(&tubes, brief.rows());
        written.push(TUBES);
        envelope::keep(&parts.0, &tubes, &surface.unwrap_or_default())?;
    }
    parts.clear()?;
    drop(bar);
    if !arguments.quiet {
        let mut print = || {
            points::print(&brief, file, out)?;
            for remark in remark.iter().chain(&left_out) {
                writeln!(out, "{remark}")?;
            }
            let written = written.iter().map(|name| place.join(name).display().to_string()).collect::<Vec<_>>();
            writeln!(out, "wrote {}", written.join(", "))
        };
        print().map_err(Failure::standard_output)?;
    }
    Ok(Outcome::Done)
}

/// Says how many points the tubes leave out, as they came to no equilibrium at the end of a step.
fn outside_of_tubes(tubes: &[gltf::Tube], points: usize) -> Option<String> {
    let steps = tubes.chunk_by(|a, b| a.step == b.step).map(|step| &step[0]).filter(|tube| tube.points < points);
    let steps: Vec<String> = steps.map(|tube| format!("{} of {points} in step `{}`", tube.points, tube.step)).collect();
    if tubes.is_empty() {
        return Some(format!("{TUBES} has no tubes: no point came to an equilibrium"));
    }
    let words = || format!("{TUBES} holds only points that came to an equilibrium: {}", steps.join(", "));
    (!steps.is_empty()).then(words)
}

/// Columns that the summary on the terminal needs, besides the keys.
fn is_shown(column: &str) -> bool {
    is_needed(column)
        || points::RANGES.iter().any(|(name, _)| *name == column)
        || matches!(column, "polish" | "message")
}

/// The table, chain by chain, so that not all of it is in memory.
struct Tables<'p> {
    layout: &'p Layout<'p>,
    parts: &'p Parts,
    points: &'p Points<'p>,
}

impl Tables<'_> {
    fn each(&self, mut write: impl FnMut(Table) -> io::Result<()>) -> io::Result<()> {
        for k in 0..self.points.chain_count() {
            let rows = self.parts.read(k).map_err(|failure| io::Error::other(failure.to_string()))?;
            write(self.layout.table(self.points.points_of(k).start, &rows))?;
        }
        Ok(())
    }
}

/// Chains of a sweep that are done.
struct Parts(Arc<Own>);

impl Parts {
    /// Resumes the same sweep; begins a new one otherwise.
    fn begin(folder: &mut Folder, origin: &Origin) -> Result<Self, Failure> {
        let parts = Self(Arc::clone(folder.own()));
        let known = parts.0.part(ORIGIN, HELP)?.and_then(|bytes| serde_json::from_slice::<Origin>(&bytes).ok());
        if known.as_ref() != Some(origin) {
            folder.clear()?;
            envelope::remove(&parts.0)?;
            parts.clear()?;
            let bytes = serde_json::to_vec(origin)
                .map_err(|error| Failure::io("write", &parts.0.path(ORIGIN))(error.into()))?;
            parts.0.keep(ORIGIN, &bytes, false)?;
        }
        Ok(parts)
    }

    fn keep(&self, number: usize, chain: &Computed) -> Result<(), Failure> {
        // The rows come last: with them the chain is done.
        if let Some(blocks) = &chain.swept {
            encode(&self.0, &format!("{}-swept", part(number)), blocks, false)?;
            encode(&self.0, &lines(number), &chain.lines, false)?;
        }
        encode(&self.0, &part(number), &chain.rows, false)
    }

    /// The surface of the space swept in all chains; `None`: that takes too much memory.
    fn swept(&self, chains: usize, cell: f64) -> Result<Option<Surface>, Failure> {
        let mut envelope = Envelope::new(cell, &[]);
        for k in 0..chains {
            let name = format!("{}-swept", part(k));
            let Some(blocks) = present::<Option<messages::Blocks>>(&self.0, &name, HELP)? else {
                return Ok(None);
            };
            for (place, phi) in &blocks {
                if envelope.add_block(*place, phi).is_err() {
                    return Ok(None);
                }
            }
        }
        Ok(Some(envelope.surface()))
    }

    /// Chains that are not done. Damage is reported before the work begins.
    fn to_do(&self, chains: usize) -> Result<Vec<usize>, Failure> {
        let known = |k: usize| Ok((k, decode::<Vec<Row>>(&self.0, &part(k), HELP)?.is_some()));
        let known = (0..chains).map(known).collect::<Result<Vec<_>, Failure>>()?;
        Ok(known.into_iter().filter(|(_, done)| !done).map(|(k, _)| k).collect())
    }

    /// The rows of a chain that is done.
    fn read(&self, chain: usize) -> Result<Vec<Row>, Failure> {
        present(&self.0, &part(chain), HELP)
    }

    fn clear(&self) -> Result<(), Failure> {
        self.0.remove(&[], &[PARTS])
    }
}

/// Name of the centre lines of a chain.
fn lines(chain: usize) -> String {
    format!("{}-lines", part(chain))
}

fn part(chain: usize) -> String {
    format!("{PARTS}/{chain:06}")
}
