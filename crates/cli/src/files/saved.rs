//! The record of a run in its folder, from which it is resumed after an interruption, a kill or a crash.
//!
//! | in `DIR/.wireloom/` | content |
//! | --- | --- |
//! | `origin` | scenario and program, with the hashes of all files |
//! | `results/NNNNNN` | equilibria that belong to the result, one file each, written as soon as they are found |
//! | `swept/NNNNNN` | nodes of all branches at the start (0) and after every increment, for the swept space |
//! | `standing` | the last checkpoint, and extremes and times up to it |
//!
//! Every file appears whole or not at all and has a checksum ([`crate::files::own`]), and a checkpoint appears only
//! after everything it depends on is on the disk. The first one is kept 100 ms after the run began: shorter runs do not
//! wait for the disk. All are removed when the run has ended. `DIR/.wireloom/files`
//! ([`crate::files::folder`]) stays.

use crate::arguments::RunArguments;
use crate::extremes::Extremes;
use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::files::load::Loaded;
use crate::files::own::{ANEW, OWN, Own};
use crate::plugin::load::record;
use crate::program::PROGRAM;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use wireloom::StepResult;
use wireloom::export::json::Provenance;
use wireloom::geometry::Vector;
use wireloom::result::{Identities, Library};
use wireloom::scenario::Setting;
use wireloom::session::{Checkpoint, Resumed};

/// Version of the files; changes with their meaning.
const FORMAT: u32 = 15;
const ORIGIN: &str = "origin";
const RESULTS: &str = "results";
const SWEPT: &str = "swept";
const STANDING: &str = "standing";
/// Shortest time between checkpoints.
const PAUSE: Duration = Duration::from_millis(100);

/// Positions of the nodes of each branch, m.
pub type Lines = Vec<Vec<Vector>>;

/// Origin of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    format: u32,
    program: String,
    /// The scenario's file.
    pub file: PathBuf,
    /// Settings on the command line: keys and values.
    settings: Vec<(String, String)>,
    /// Whether the command line asks for a report.
    pub report: bool,
    /// Name of the scenario.
    pub scenario: String,
    /// Provenance of its results.
    pub provenance: Provenance,
    /// The plugins it uses.
    pub plugins: Vec<Library>,
    /// Part numbers and the like.
    pub identities: Identities,
}

impl Origin {
    /// The origin of a scenario that was just read.
    pub fn new(file: &Path, arguments: &RunArguments, loaded: &Loaded) -> Result<Self, Failure> {
        Ok(Self {
            format: FORMAT,
            program: PROGRAM.to_owned(),
            file: std::path::absolute(file).map_err(Failure::io("find", file))?,
            settings: loaded.settings.iter().map(|set| (set.key.clone(), set.value.clone())).collect(),
            report: arguments.report,
            scenario: loaded.scenario.name.clone(),
            provenance: loaded.provenance(),
            plugins: loaded.plugins.iter().map(record).collect(),
            identities: loaded.scenario.identities.clone(),
        })
    }

    /// The origin of the run that was interrupted in this folder.
    pub fn read(folder: &Folder) -> Result<Self, Failure> {
        let Some(bytes) = folder.own().part(ORIGIN, ANEW)? else { return Err(nothing_to_resume(folder.path())) };
        let origin: Self =
            serde_json::from_slice(&bytes).map_err(|error| unreadable(&folder.own().path(ORIGIN), &error))?;
        if (origin.format, origin.program.as_str()) != (FORMAT, PROGRAM) {
            return Err(Failure::Input(format!(
                "the run in {} was begun by {} and cannot be resumed by {}: run the scenario anew",
                folder.path().display(),
                origin.program,
                PROGRAM
            )));
        }
        Ok(origin)
    }

    /// Settings on the command line.
    pub fn settings(&self) -> Vec<Setting> {
        self.settings.iter().map(|(key, value)| Setting::new(key, value)).collect()
    }

    /// Checks that the scenario and its plugins are unchanged.
    pub fn check(&self, loaded: &Loaded) -> Result<(), Failure> {
        let hashes =
            |plugins: Vec<Library>| plugins.into_iter().map(|plugin| (plugin.name, plugin.hash)).collect::<Vec<_>>();
        let now = hashes(loaded.plugins.iter().map(record).collect());
        if let Some((name, _)) = hashes(self.plugins.clone()).iter().zip(&now).find(|(a, b)| a != b).map(|(a, _)| a) {
            return Err(Failure::Input(format!(
                "plugin `{name}` has changed since the run was interrupted: it cannot be resumed; run the scenario anew"
            )));
        }
        let (then, now) = (&self.provenance.files, loaded.provenance().files);
        let gone = then.iter().find(|(name, hash)| now.get(*name) != Some(hash));
        let come = now.iter().find(|(name, hash)| then.get(*name) != Some(hash));
        match gone.or(come) {
            None => Ok(()),
            Some((name, _)) => Err(Failure::Input(format!(
                "{name} has changed since the run was interrupted: it cannot be resumed; \
                 undo the change, or run the scenario anew"
            ))),
        }
    }
}

/// The folder of a run to be resumed. A folder without one is not touched.
pub fn interrupted(path: &Path) -> Result<Folder, Failure> {
    if path.join(OWN).join(ORIGIN).exists() { Folder::create(path) } else { Err(nothing_to_resume(path)) }
}

fn nothing_to_resume(folder: &Path) -> Failure {
    let place = folder.display();
    Failure::Input(format!("nothing to resume in {place}: no run was interrupted there, or it has ended since"))
}

fn unreadable(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Input(format!("{} cannot be read ({error}): run the scenario anew", path.display()))
}

/// State of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// Checkpoint of the step driver; `None` before the first.
    pub checkpoint: Option<Checkpoint>,
    /// Extremes so far.
    pub extremes: Extremes,
    /// Times of the increments so far, in steps.
    pub times: Vec<f64>,
}

/// Writer and reader of the record of a run.
pub struct Keeper {
    own: Arc<Own>,
    kept: usize,
    /// Files that the next checkpoint makes safe on the disk first.
    unsafe_yet: Vec<String>,
    /// When the last checkpoint was kept, or the run began; `None` if it was resumed just now.
    last: Option<Instant>,
}

impl Keeper {
    fn of(folder: &Folder) -> Self {
        Self { own: Arc::clone(folder.own()), kept: 0, unsafe_yet: vec![], last: None }
    }

    /// Begins a run.
    pub fn begin(folder: &Folder, origin: &Origin) -> Result<Self, Failure> {
        // What can be repeated in so short a time needs no checkpoint.
        let mut keeper = Self { last: Some(Instant::now()), ..Self::of(folder) };
        keeper.clear()?;
        let bytes = serde_json::to_vec_pretty(origin)
            .map_err(|error| Failure::io("write", &keeper.own.path(ORIGIN))(error.into()))?;
        keeper.own.keep(ORIGIN, &bytes, false)?;
        keeper.unsafe_yet.push(ORIGIN.to_owned());
        Ok(keeper)
    }

    /// Resumes a run; returns everything computed so far.
    pub fn resume(folder: &Folder) -> Result<(Self, Standing, Option<Resumed>), Failure> {
        let mut keeper = Self::of(folder);
        let Some(mut standing) = decode::<Standing>(&keeper.own, STANDING, ANEW)? else {
            return Ok((keeper, Standing::default(), None));
        };
        // Damage is reported before the work goes on.
        if keeper.own.place().has(&line(0)) {
            keeper.lines(standing.times.len()).try_for_each(|lines| lines.map(|_| ()))?;
        }
        let Some(checkpoint) = standing.checkpoint.take() else { return Ok((keeper, standing, None)) };
        keeper.kept = checkpoint.kept();
        let steps = (1..=keeper.kept).map(|k| present(&keeper.own, &result(k), ANEW));
        let steps = steps.collect::<Result<Vec<StepResult>, _>>()?;
        Ok((keeper, standing, Some(Resumed { checkpoint, steps })))
    }

    /// Equilibria of a run that a plugin has crashed, as far as they belong to the result, and its last checkpoint.
    pub fn salvage(folder: &Folder) -> Result<(Vec<StepResult>, Option<Checkpoint>), Failure> {
        let ends = (1..).map(|k| decode(folder.own(), &result(k), ANEW).transpose());
        let ends = ends.map_while(|end| end).collect::<Result<_, _>>()?;
        let standing = decode::<Standing>(folder.own(), STANDING, ANEW)?;
        Ok((ends, standing.and_then(|standing| standing.checkpoint)))
    }

    /// Keeps an equilibrium that belongs to the result.
    pub fn keep(&mut self, end: &StepResult) -> Result<(), Failure> {
        self.kept += 1;
        let name = result(self.kept);
        encode(&self.own, &name, end, false)?;
        self.unsafe_yet.push(name);
        Ok(())
    }

    /// Keeps the positions of nodes after an increment.
    pub fn keep_lines(&mut self, increment: usize, lines: &Lines) -> Result<(), Failure> {
        let name = line(increment);
        encode(&self.own, &name, lines, false)?;
        self.unsafe_yet.push(name);
        Ok(())
    }

    /// Positions of nodes at the start and after each of these increments; empty where there is no start.
    pub fn lines(&self, increments: usize) -> impl Iterator<Item = Result<Lines, Failure>> {
        let started = increments > 0 || self.own.place().has(&line(0));
        (0..=increments).filter(move |_| started).map(|k| present(&self.own, &line(k), ANEW))
    }

    /// Whether it is time to keep a checkpoint.
    pub fn is_due(&self) -> bool {
        self.last.is_none_or(|last| last.elapsed() > PAUSE)
    }

    /// Keeps a checkpoint, after all results before it.
    pub fn stand(&mut self, standing: &Standing) -> Result<(), Failure> {
        for name in self.unsafe_yet.drain(..) {
            self.own.make_safe(&name)?;
        }
        encode(&self.own, STANDING, standing, true)?;
        self.last = Some(Instant::now());
        Ok(())
    }

    /// Removes the record of a run that has ended.
    pub fn clear(&self) -> Result<(), Failure> {
        // The checkpoint goes first: without it the rest is not read.
        self.own.remove(&[STANDING, ORIGIN], &[RESULTS, SWEPT])
    }
}

/// Name of an equilibrium that belongs to the result.
fn result(k: usize) -> String {
    format!("{RESULTS}/{k:06}")
}

/// Name of the positions of nodes after an increment.
fn line(increment: usize) -> String {
    format!("{SWEPT}/{increment:06}")
}

/// Writes a value; `safe`: on the disk when this returns.
pub fn encode(own: &Own, name: &str, value: &impl Serialize, safe: bool) -> Result<(), Failure> {
    let bytes = postcard::to_stdvec(value).map_err(io::Error::other).map_err(Failure::io("write", &own.path(name)))?;
    own.keep(name, &bytes, safe)
}

/// Reads a value back, if it is there; `help`: what to do where it is damaged.
pub fn decode<T: for<'a> Deserialize<'a>>(own: &Own, name: &str, help: &str) -> Result<Option<T>, Failure> {
    let Some(bytes) = own.part(name, help)? else { return Ok(None) };
    postcard::from_bytes(&bytes).map(Some).map_err(|error| unreadable(&own.path(name), &error))
}

/// Reads a value back that must be there.
pub fn present<T: for<'a> Deserialize<'a>>(own: &Own, name: &str, help: &str) -> Result<T, Failure> {
    decode(own, name, help)?.ok_or_else(|| Failure::io("read", &own.path(name))(io::ErrorKind::NotFound.into()))
}
