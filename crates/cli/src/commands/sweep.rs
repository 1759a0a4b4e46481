//! `wireloom sweep`: a scenario over many values, to a table.
//!
//! | in `DIR/` | content |
//! | --- | --- |
//! | `points.parquet` | a row for each point, written when all are done |
//! | `.wireloom/sweep/origin` | the scenario, until the sweep ends |
//! | `.wireloom/sweep/NNNNNN` | chains of points that are done, until the sweep ends |

use crate::arguments::SweepArguments;
use crate::failure::{Failure, Outcome};
use crate::files::folder::Folder;
use crate::files::load::{self, Beside};
use crate::files::own::Own;
use crate::files::saved::{decode, encode, present};
use crate::plugin::load::record;
use crate::plugin::trust::Trust;
use crate::print::progress::Bar;
use crate::print::table::Columns;
use crate::print::text::{counted, printable};
use crate::program::PROGRAM;
use crate::{interrupt, size};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::sync::Arc;
use wireloom::export::table;
use wireloom::export::table::{Column, FILE, Row, Table};
use wireloom::result::Library;
use wireloom::scenario::Setting;
use wireloom::sweep::{Points, header};

const PARTS: &str = "sweep";
const ORIGIN: &str = "sweep/origin";
/// Help where a part is damaged.
const HELP: &str = "remove it, and the same command goes on";
/// Version of the files; changes with their meaning.
const FORMAT: u32 = 5;
/// Messages of refused points that are shown.
const REFUSALS: usize = 3;

/// Origin of a sweep.
#[derive(PartialEq, Serialize, Deserialize)]
struct Origin {
    format: u32,
    program: String,
    minimiser: Option<String>,
    texts: Vec<(String, String)>,
    plugins: Vec<Library>,
}

/// Carries out a sweep, or goes on with it where it was interrupted.
pub fn sweep(arguments: &SweepArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let trust = Trust::to_run(&arguments.allowed).for_batches();
    let file = &arguments.file;
    let bar = Bar::new(format!("reading {}", file.display()), !arguments.quiet);
    let minimiser: Vec<Setting> = arguments.minimiser.iter().map(|kind| Setting::minimiser(kind)).collect();
    let loaded = load::scenario(file, &minimiser, &trust)?;
    size::estimate(&loaded.built.network, 1)?;
    let Some(sweep) = &loaded.scenario.sweep else {
        let help = "add one, such as\n[sweep.vary]\n\
                    \"branches.NAME.length\" = { from = \"400 mm\", to = \"500 mm\", count = 11 }";
        return Err(Failure::Input(format!("{} has no [sweep]: {help}", file.display())));
    };
    let origin = Origin {
        format: FORMAT,
        program: PROGRAM.to_owned(),
        minimiser: arguments.minimiser.clone(),
        texts: loaded.texts.clone(),
        plugins: loaded.plugins.iter().map(record).collect(),
    };
    let mut folder = Folder::of_results(arguments.out.as_deref(), file)?;
    let place = folder.path().to_path_buf();
    let parts = Parts::begin(&mut folder, &origin)?;
    let points = Points {
        text: &loaded.texts[0].1,
        files: &Beside::of(file),
        minimiser: arguments.minimiser.as_deref(),
        registry: &loaded.registry,
        batch: (loaded.scenario.minimiser.kind == "gpu").then(|| trust.batch()),
        sweep,
        header: header(sweep, &loaded.built.network),
    };
    let chains = points.chains();
    let to_do = parts.to_do(chains.len())?;
    let left: usize = to_do.iter().map(|k| chains[*k].len()).sum();
    if left < sweep.points && !arguments.quiet {
        writeln!(out, "going on after {} points", sweep.points - left).map_err(Failure::standard_output)?;
        out.flush().map_err(Failure::standard_output)?;
    }
    bar.count(&loaded.scenario.name, "points", sweep.points, sweep.points - left);
    interrupt::listen();
    points.compute(&to_do, interrupt::monitor(), &|| bar.one(), |k, rows| parts.keep(k, &rows))?;
    if interrupt::asked() {
        drop(bar);
        let words = format!("interrupted; the same command goes on, from {}", place.display());
        writeln!(out, "{words}").map_err(Failure::standard_output)?;
        return Ok(Outcome::NotConverged);
    }
    let mut rows = vec![];
    for k in 0..chains.len() {
        rows.append(&mut parts.read(k)?);
    }
    let notes = [
        ("program", PROGRAM.to_owned()),
        ("scenario", loaded.scenario.name.clone()),
        ("text", loaded.texts[0].1.clone()),
    ];
    let table = Table::of(&points.header, &rows, notes.map(|(key, text)| (format!("wireloom.{key}"), text)).to_vec());
    bar.say(format!("writing {FILE}"));
    folder.write(FILE, |out| table::write(&table, out))?;
    parts.clear()?;
    drop(bar);
    if !arguments.quiet {
        print(&rows, &table, out).map_err(Failure::standard_output)?;
        writeln!(out, "wrote {}", place.join(FILE).display()).map_err(Failure::standard_output)?;
    }
    Ok(Outcome::Done)
}

/// Number of points by status, and ranges of results.
fn print(rows: &[Row], table: &Table, out: &mut dyn Write) -> io::Result<()> {
    let mut counts: Vec<(&str, usize)> = vec![];
    for row in rows {
        match counts.iter_mut().find(|(status, _)| *status == row.status) {
            Some((_, n)) => *n += 1,
            None => counts.push((&row.status, 1)),
        }
    }
    counts.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
    let words: Vec<String> = counts.iter().map(|(status, n)| format!("{n} {status}")).collect();
    writeln!(out, "{}: {}\n", counted(rows.len(), "point", "points"), words.join(", "))?;
    if let Some(Column::Numbers(polish)) = table.column("polish") {
        match polish.iter().flatten().filter(|polish| **polish > 0.0).count() {
            0 => {}
            polished => writeln!(out, "{polished} of them finished on the CPU, to the same tolerance\n")?,
        }
    }
    let mut columns = Columns::new(["result", ">minimum", ">mean", ">maximum"]);
    for (name, unit) in [("energy.total", "J"), ("bend_radius", "m"), ("force", "N")] {
        let Some(Column::Numbers(numbers)) = table.column(name) else { continue };
        let numbers: Vec<f64> = numbers.iter().flatten().copied().collect();
        if numbers.is_empty() {
            continue;
        }
        let (least, greatest) =
            numbers.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
        let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
        let cell = |number: f64| format!("{number:.5}");
        columns.row([format!("{name} [{unit}]"), cell(least), cell(mean), cell(greatest)]);
    }
    columns.print(out)?;
    let refused = rows.iter().enumerate().filter_map(|(k, row)| Some((k, row.message.as_ref()?)));
    for (k, message) in refused.take(REFUSALS) {
        writeln!(out, "point {k} refused: {}", printable(message))?;
    }
    Ok(())
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
            parts.clear()?;
            let bytes = serde_json::to_vec(origin)
                .map_err(|error| Failure::io("write", &parts.0.path(ORIGIN))(error.into()))?;
            parts.0.keep(ORIGIN, &bytes, false)?;
        }
        Ok(parts)
    }

    fn keep(&self, chain: usize, rows: &[Row]) -> Result<(), Failure> {
        encode(&self.0, &part(chain), &rows, false)
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

fn part(chain: usize) -> String {
    format!("{PARTS}/{chain:06}")
}
