//! What a run leaves in its folder while it goes, so that it can be taken up again after an interruption, a kill or a crash.
//!
//! | in `DIR/.wireloom/` | what |
//! | --- | --- |
//! | `origin.json` | which scenario, with the hashes of all files it was made from, and which program |
//! | `results/NNNNNN` | the ends of steps (or increments) that belong to the result, one file each, written as soon as they are there |
//! | `swept/NNNNNN` | nodes of all branches at the start (0) and after every increment, where what they sweep is asked for |
//! | `standing` | the last checkpoint, and what was seen up to it |
//!
//! Every file appears whole or not at all, and a checkpoint only after what it builds on is safe on the disk. All go when the run has
//! come to its end. `DIR/.wireloom/files` ([`crate::folder`]) stays.

use crate::arguments::RunArguments;
use crate::extremes::Extremes;
use crate::failure::Failure;
use crate::folder::{self, Folder, OWN};
use crate::load::Loaded;
use crate::plugins;
use crate::results::PROGRAM;
use crate::swept::Lines;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use wireloom::core::StepResult;
use wireloom::core::equilibrium::Library;
use wireloom::export::json::Provenance;
use wireloom::export::vtk::SeriesFile;
use wireloom::scenario::Setting;
use wireloom::solve::checkpoint::{Checkpoint, Resumed};

/// Changes with what the files mean.
const FORMAT: u32 = 4;
const ORIGIN: &str = "origin.json";
const RESULTS: &str = "results";
const SWEPT: &str = "swept";
const STANDING: &str = "standing";
/// Checkpoints nearer to each other are not worth their writing.
const PAUSE: Duration = Duration::from_millis(100);

/// What a run was made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Origin {
    format: u32,
    program: String,
    /// The scenario's file.
    pub file: PathBuf,
    /// What was set beside it: keys and values.
    settings: Vec<(String, String)>,
    /// Whether a report was asked for beside the scenario's own wishes.
    pub report: bool,
    /// Name of the scenario.
    pub scenario: String,
    /// What results say of all this.
    pub provenance: Provenance,
    /// The plugins it uses.
    pub plugins: Vec<Library>,
}

impl Origin {
    /// Of a scenario that was just read.
    pub fn new(file: &Path, arguments: &RunArguments, loaded: &Loaded) -> Result<Self, Failure> {
        Ok(Self {
            format: FORMAT,
            program: PROGRAM.to_owned(),
            file: std::path::absolute(file).map_err(Failure::io("find", file))?,
            settings: loaded.settings.iter().map(|set| (set.key.clone(), set.value.clone())).collect(),
            report: arguments.report,
            scenario: loaded.scenario.name.clone(),
            provenance: loaded.provenance(),
            plugins: loaded.plugins.iter().map(plugins::record).collect(),
        })
    }

    /// Of the run that was interrupted in this folder.
    pub fn read(folder: &Path) -> Result<Self, Failure> {
        let path = folder.join(OWN).join(ORIGIN);
        let bytes = match fs::read(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let place = folder.display();
                return Err(Failure::Input(format!(
                    "nothing to resume in {place}: no run was interrupted there, or it has come to its end since"
                )));
            }
            other => other.map_err(Failure::io("read", &path))?,
        };
        let origin: Self = serde_json::from_slice(&bytes).map_err(|error| unreadable(&path, &error))?;
        if (origin.format, origin.program.as_str()) != (FORMAT, PROGRAM) {
            return Err(Failure::Input(format!(
                "the run in {} was begun by {} and cannot be resumed by {}: run the scenario anew",
                folder.display(),
                origin.program,
                PROGRAM
            )));
        }
        Ok(origin)
    }

    /// What was set beside the scenario.
    pub fn settings(&self) -> Vec<Setting> {
        self.settings.iter().map(|(key, value)| Setting::new(key, value)).collect()
    }

    /// Makes sure that the scenario and its plugins still are what they were.
    pub fn check(&self, loaded: &Loaded) -> Result<(), Failure> {
        let hashes =
            |plugins: Vec<Library>| plugins.into_iter().map(|plugin| (plugin.name, plugin.hash)).collect::<Vec<_>>();
        let now = hashes(loaded.plugins.iter().map(plugins::record).collect());
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
                "{name} has changed since the run was interrupted: it cannot be resumed; undo the change, or run the scenario anew"
            ))),
        }
    }
}

fn unreadable(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Input(format!("{} cannot be understood ({error}): run the scenario anew", path.display()))
}

/// Where a run stands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// For the step driver; `None` before the first.
    pub checkpoint: Option<Checkpoint>,
    /// Seen so far.
    pub extremes: Extremes,
    /// Written so far.
    pub series: Vec<SeriesFile>,
    /// Increments so far.
    pub increments: usize,
}

/// Keeps a run as it goes.
pub struct Keeper {
    folder: PathBuf,
    kept: usize,
    unsafe_yet: Vec<PathBuf>,
    last: Option<Instant>,
}

impl Keeper {
    /// Begins a run.
    pub fn begin(folder: &Folder, origin: &Origin) -> Result<Self, Failure> {
        let keeper = Self { folder: folder.path().join(OWN), kept: 0, unsafe_yet: vec![], last: None };
        keeper.clear()?;
        folder::write(&keeper.folder.join(ORIGIN), |out| {
            serde_json::to_writer_pretty(&mut *out, origin)?;
            out.flush()?;
            out.get_ref().sync_all()
        })?;
        Ok(keeper)
    }

    /// Goes on with a run; what had been computed of it comes back.
    pub fn resume(folder: &Folder) -> Result<(Self, Standing, Option<Resumed>), Failure> {
        let mut keeper = Self { folder: folder.path().join(OWN), kept: 0, unsafe_yet: vec![], last: None };
        let path = keeper.folder.join(STANDING);
        if !path.exists() {
            return Ok((keeper, Standing::default(), None));
        }
        let mut standing: Standing = decode(&path)?;
        let Some(checkpoint) = standing.checkpoint.take() else { return Ok((keeper, standing, None)) };
        keeper.kept = checkpoint.kept();
        let steps = (1..=keeper.kept).map(|k| decode(&keeper.result(k))).collect::<Result<Vec<StepResult>, _>>()?;
        Ok((keeper, standing, Some(Resumed { checkpoint, steps })))
    }

    /// What a run that a plugin ended has left: the ends that belong to the result.
    pub fn salvage(folder: &Path) -> Result<Vec<StepResult>, Failure> {
        let keeper = Self { folder: folder.join(OWN), kept: 0, unsafe_yet: vec![], last: None };
        (1..).map(|k| keeper.result(k)).take_while(|path| path.exists()).map(|path| decode(&path)).collect()
    }

    fn result(&self, k: usize) -> PathBuf {
        self.folder.join(RESULTS).join(format!("{k:06}"))
    }

    /// Keeps an end that belongs to the result.
    pub fn keep(&mut self, end: &StepResult) -> Result<(), Failure> {
        self.kept += 1;
        let path = self.result(self.kept);
        folder::write(&path, |out| encode(end, out))?;
        self.unsafe_yet.push(path);
        Ok(())
    }

    fn line(&self, increment: usize) -> PathBuf {
        self.folder.join(SWEPT).join(format!("{increment:06}"))
    }

    /// Keeps where the nodes are after an increment.
    pub fn keep_lines(&mut self, increment: usize, lines: &Lines) -> Result<(), Failure> {
        let path = self.line(increment);
        folder::write(&path, |out| encode(lines, out))?;
        self.unsafe_yet.push(path);
        Ok(())
    }

    /// Where the nodes were at the start and after so many increments, as far as that was kept.
    pub fn lines(&self, increments: usize) -> impl Iterator<Item = Result<Lines, Failure>> {
        (0..=increments).map(|k| self.line(k)).filter(|path| path.exists()).map(|path| decode(&path))
    }

    /// Whether it is time to keep a checkpoint.
    pub fn is_due(&self) -> bool {
        self.last.is_none_or(|last| last.elapsed() > PAUSE)
    }

    /// Keeps a checkpoint, after all results before it.
    pub fn stand(&mut self, standing: &Standing) -> Result<(), Failure> {
        for path in self.unsafe_yet.drain(..) {
            File::open(&path).and_then(|file| file.sync_all()).map_err(Failure::io("write", &path))?;
        }
        folder::write(&self.folder.join(STANDING), |out| {
            encode(standing, out)?;
            out.flush()?;
            out.get_ref().sync_all()
        })?;
        self.last = Some(Instant::now());
        Ok(())
    }

    /// The run has come to its end.
    pub fn clear(&self) -> Result<(), Failure> {
        let gone = |result: io::Result<()>| match result {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        };
        // The checkpoint goes first: without it nothing is built on the rest.
        for name in [STANDING, ORIGIN] {
            let path = self.folder.join(name);
            gone(fs::remove_file(&path)).map_err(Failure::io("remove", &path))?;
        }
        for name in [RESULTS, SWEPT] {
            let path = self.folder.join(name);
            gone(fs::remove_dir_all(&path)).map_err(Failure::io("remove", &path))?;
        }
        Ok(())
    }
}

/// Writes a value in the form of these files.
pub fn encode(value: &impl Serialize, out: &mut impl Write) -> io::Result<()> {
    out.write_all(&postcard::to_stdvec(value).map_err(io::Error::other)?)
}

/// Reads a value back.
pub fn decode<T: for<'a> Deserialize<'a>>(path: &Path) -> Result<T, Failure> {
    let bytes = fs::read(path).map_err(Failure::io("read", path))?;
    postcard::from_bytes(&bytes).map_err(|error| unreadable(path, &error))
}
