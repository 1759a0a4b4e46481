//! `result.json`: the whole run, for programs.
//!
//! Branches, joints and constraints are objects keyed by name, in the order of the scenario. Numbers have
//! all the digits needed to read the same double back. Numbers that are not finite (the bend radius of a straight
//! piece; anything after a failure) are `null`.
//!
//! `plugins` names the libraries that brought kinds of their own: name, version, file, and SHA-256 of the file as
//! `hash`. Without any, the key is not there.
//!
//! A branch has its `diameter`, the smallest bend radius allowed (`bend_radius_limit`) and its axial stiffness EA
//! beside its lists of values at nodes; with an axial law also the axial `strain`, which is otherwise the tension over
//! EA. Where its section changes along it, it has the `strain`, too, and `sections`: of each part its `section`, its
//! place (`from`, `to`, m) and the same three values; those of the branch are then the greatest diameter and limit,
//! and EA at its start. If its section slips, yields or creeps it has `friction`: at each node the `set`
//! (curvature about d1 and d2 and twist about d3, beyond those at rest, that would remain without the moment there,
//! 1/m), and the energy `dissipated` in the increment and, as `dissipated_in_all`, since the start (J). The
//! `energy` of a step is what is stored. Where arms slip on their hub, a joint has `friction`, by the branches of these
//! arms: `starts_here`, whether the branch starts there, the `set` (turn of the arm from its rest direction that would
//! remain if nothing exerted a moment on it, about d1, d2 and d3 of the branch, rad), and the energies.
//!
//! `deviation` of a branch with a drawn line: `median`, `max` (m), `s` of the largest and, where that exceeds the
//! diameter, its `cause`: `kind` "held elsewhere" (`constraint`), "few constraints" (`between`, `free_length`, `room`,
//! m) or "free end" (`from`, `free_length`). `drawn_start` compares the end of the run with the equilibrium from the
//! drawn lines. `sensitivities`, which `[output]` asks for, has the derivatives of each requirement's worst value by
//! lengths and places, the largest first: `key`, and `derivative` or both `sides` and the `reason`; `keeps_history`
//! where what a key does to the path is left out. `identities` has `parts`, `components` and `connections`;
//! `cross_sections`, of each section of wires in use its `wires` (`type`, `count`, `diameter`), `wires_diameter`, and
//! `coverings` from the inside (`name`, `share`, `inner`, `outer`; m); and `kbl` where the scenario was imported:
//! `file`, its `sha256`, and `elements`, of which each has `of` and `name`, and the `id` in that file.
//!
//! `provenance` names program, files (with their SHA-256), values set beside them, kinds of rods, joints, constraints
//! and minimiser with all its options, and the seed of a sweep's point. With the same provenance comes the same
//! result.
//!
//! `events` lists the events of all increments, those included that are not kept. An event that goes on over
//! consecutive increments is listed once:
//!
//! | key | meaning |
//! | --- | --- |
//! | `kind` | [`EventKind::word`](wireloom_core::EventKind::word) |
//! | `place` | `fixing` (a constraint), `obstacle` or `branch` (with `s`, m); empty: the harness |
//! | `first`, `worst`, `last` | `step`, `step_index` (from 0) and `increment` (from 1; 0: while the start was found) |
//! | `increments` | number of increments with this event |
//! | `value`, `limit` | the worst value and its limit, in SI units; null where there is none |
//! | `message` | a sentence for people, of the worst increment |
//!
//! `clearance` is there where it was asked for, or required of an obstacle: for every pair of a branch and an
//! `obstacle`, or an `other` branch, the smallest `distance` from surface to surface over all increments (m; negative
//! where they overlap), at `s` of the branch, whose centre line is at `position` there, and `other_s` of the other;
//! `at` is the increment; `required` is the distance asked for. An obstacle of a step has its `position` and
//! `orientation`, the `force` and the `moment` (about its position) that it exerts on the harness, `contact_force`, the
//! sum of the sizes of its contact forces, the number of `contacts`, and the `depth` of the deepest one.
//!
//! A constraint that acts on several stations has `stations`, each with `position`, `force` and `moment`; one that
//! acts along a span has `span`: `branch`, `from`, `to`, the total `force` on it, the `largest` on one node, and
//! `largest_at`, its arc length. `fault` is there only where a part ended the run: `constraint`, `joint` or
//! `minimiser` with its name, `kind`, `step`, `increment` and `message`.
//!
//! With `[output] fields = "arrow"` the lists of branches are in another file, which `fields` names: see
//! [`fields`](crate::fields).
//!
//! The types of `document` are the form, for writing and for reading; `convert` leads from and to [`Run`]. Readers
//! refuse a field that is missing or not known, and name it with its path; within `identities` those that are not known
//! are left out.

mod comparison;
mod convert;
mod document;
mod ending;
#[cfg(feature = "arrow")]
mod opened;
mod provenance;
mod stream;
mod values;

pub use comparison::write_comparison;
#[cfg(feature = "arrow")]
pub use opened::Opened;
pub use provenance::{Provenance, options};
pub use values::SCHEMA;

use crate::ending::Ending;
use crate::format::{Ended, File, Format};
use document::{Document, Requirement, Sheet};
use std::io::{self, BufWriter, Read, Write};
use stream::{All, Collected, Written};
use wireloom_core::Run;

/// Status, verdict and requirements of a run, as they are in `result.json`.
///
/// # Errors
/// None that is known: numbers that are not finite are null.
pub(crate) fn sheet(run: &Run) -> io::Result<serde_json::Value> {
    let lines = run.requirements.iter().map(|line| serde_json::to_value(Requirement::of(line)));
    let requirements = lines.collect::<Result<Vec<_>, _>>()?;
    Ok(serde_json::json!({
        "status": run.status().word(),
        "verdict": run.verdict().word(),
        "requirements": requirements,
    }))
}

/// Writes `run` as one JSON object and a line feed.
///
/// # Errors
/// Those of `out`.
pub fn write(run: &Run, provenance: &Provenance, out: &mut impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let steps = Written { steps: &run.steps, apart: None };
    serde_json::to_writer(&mut out, &Document::of(run, provenance, None, steps))?;
    out.write_all(b"\n")?;
    out.flush()
}

/// Writes `run` without the fields of its nodes, which [`fields::write`](crate::fields::write) writes to another file.
///
/// # Errors
/// Those of `out`; `InvalidInput` where the lists of a branch differ in length.
#[cfg(feature = "arrow")]
pub fn write_without_fields(run: &Run, provenance: &Provenance, out: &mut impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let hashes = crate::fields::hashes(run)?;
    let steps = Written { steps: &run.steps, apart: Some(&hashes) };
    serde_json::to_writer(&mut out, &Document::of(run, provenance, Some(values::FieldsFile), steps))?;
    out.write_all(b"\n")?;
    out.flush()
}

/// Writes the sheet of `run` as one JSON object and a line feed: the keys of `result.json` up to `requirements`.
///
/// # Errors
/// Those of `out`.
pub fn write_sheet(run: &Run, out: &mut impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    serde_json::to_writer_pretty(&mut out, &Sheet::of(run))?;
    out.write_all(b"\n")?;
    out.flush()
}

/// Reads the run of a `result.json`. Numbers are those that were written, frames up to round-off, since d3 and d1 are
/// written of them; null is read as NaN, for a bend radius as infinity.
///
/// # Errors
/// Those of `input`; `InvalidData`, with the path of the field, where it is no result, or where the fields of its nodes
/// are in another file: see [`read_run_with`].
pub fn read_run(input: impl Read) -> io::Result<Run> {
    run_of(input, &mut stream::not_given)
}

/// Reads the last equilibrium of a `result.json` and the work of all steps; `None` where it has no steps. Shapes of
/// earlier steps are dropped as they are read.
///
/// # Errors
/// Those of [`read_run`].
pub fn read(input: impl Read) -> io::Result<Option<Ending>> {
    ending::ending(stream::parse(input)?, &mut stream::not_given)
}

/// Reads the run of a `result.json` as [`read_run`] does; `fields` opens the file with the fields of its nodes, where
/// they are in one.
///
/// # Errors
/// Those of `input` and `fields`; `InvalidData` where one of them is no result, or where they do not belong together.
#[cfg(feature = "arrow")]
pub fn read_run_with<F: Read + io::Seek>(input: impl Read, fields: impl FnOnce() -> io::Result<F>) -> io::Result<Run> {
    run_of(input, &mut opened::reader(fields))
}

/// Reads the last equilibrium as [`read`] does; `fields`: see [`read_run_with`].
///
/// # Errors
/// Those of [`read_run_with`].
#[cfg(feature = "arrow")]
pub fn read_with<F: Read + io::Seek>(
    input: impl Read,
    fields: impl FnOnce() -> io::Result<F>,
) -> io::Result<Option<Ending>> {
    ending::ending(stream::parse(input)?, &mut opened::reader(fields))
}

fn run_of(input: impl Read, fields: stream::Fields<'_>) -> io::Result<Run> {
    let mut document: Document<Collected<All>> = stream::parse(input)?;
    let steps = std::mem::take(&mut document.steps.0).filled(document.fields, fields)?;
    document.run(|_| steps).map_err(stream::invalid)
}

/// The format `result.json`.
pub struct Json;

/// Its file.
pub const FILE: &str = "result.json";

impl Format for Json {
    fn key(&self) -> Option<&'static str> {
        None
    }

    fn files(&self) -> &'static [&'static str] {
        &[FILE]
    }

    fn media_type(&self) -> &'static str {
        "application/json"
    }

    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        #[cfg(feature = "arrow")]
        if ended.fields_apart {
            return vec![File::new(FILE, |mut out| write_without_fields(ended.run, ended.provenance, &mut out))];
        }
        vec![File::new(FILE, |mut out| write(ended.run, ended.provenance, &mut out))]
    }

    fn offered(&self, _: &[&str], _: bool) -> Vec<String> {
        vec![FILE.to_owned()]
    }

    fn at_hand<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>> {
        self.at_end(ended)
    }
}
