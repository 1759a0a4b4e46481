//! An output format: the files it makes of a run, and when. [`crate::catalogue`] lists all formats.

use crate::json::Provenance;
use std::io::{self, Write};
use wireloom_core::equilibrium::{Run, StepResult};
use wireloom_core::identity::Identities;
use wireloom_core::obstacle::{Obstacle, Surface};
use wireloom_core::steps::Schedule;

/// An output format. Names of files lead into folders below that of the results, with `/`.
pub trait Format: Sync {
    /// Its key in the scenario's `[output]`; `None`: written always.
    fn key(&self) -> Option<&'static str>;

    /// Its files; words in capitals stand for names and numbers.
    fn files(&self) -> &'static [&'static str];

    /// Media type of the files, for browsers.
    fn media_type(&self) -> &'static str;

    /// Bytes that a node takes in the files of an increment, or less.
    fn bytes_per_node(&self) -> usize {
        0
    }

    /// Files that are written as soon as an increment has ended; their names are [`Self::increment_names`].
    fn at_increment<'a>(&self, _ended: &'a Increment<'a>) -> Vec<File<'a>> {
        vec![]
    }

    /// Names of the files of increment `number`, from 1.
    fn increment_names(&self, _number: usize, _surroundings: &Surroundings) -> Vec<String> {
        vec![]
    }

    /// Files that are written when the run has ended.
    fn at_end<'a>(&self, ended: &'a Ended<'a>) -> Vec<File<'a>>;

    /// Names of the files that a session offers of the equilibrium at hand, of a harness with these branches.
    fn offered(&self, _branches: &[&str], _surroundings: bool) -> Vec<String> {
        vec![]
    }

    /// The files that a session offers; there is an equilibrium.
    fn at_hand<'a>(&self, _ended: &'a Ended<'a>) -> Vec<File<'a>> {
        vec![]
    }
}

/// A file that can be written.
pub struct File<'a> {
    /// Its name.
    pub name: String,
    content: Content<'a>,
}

type Content<'a> = Box<dyn FnOnce(&mut dyn Write) -> io::Result<()> + 'a>;

impl<'a> File<'a> {
    /// A file of this name with what `content` writes.
    pub fn new(name: impl Into<String>, content: impl FnOnce(&mut dyn Write) -> io::Result<()> + 'a) -> Self {
        Self { name: name.into(), content: Box::new(content) }
    }

    /// Writes it.
    ///
    /// # Errors
    /// Those of `out`; `InvalidInput` where the vectors of a branch differ in length.
    pub fn write(self, out: &mut dyn Write) -> io::Result<()> {
        (self.content)(out)
    }
}

/// An increment that has ended.
pub struct Increment<'a> {
    /// Counted over the whole run, from 1.
    pub number: usize,
    /// Its equilibrium.
    pub end: &'a StepResult,
    /// The obstacles.
    pub surroundings: &'a Surroundings,
    /// Part numbers and the like.
    pub identities: &'a Identities,
}

/// A run that has ended, or has come so far.
pub struct Ended<'a> {
    /// The run.
    pub run: &'a Run,
    /// Origin of the run.
    pub provenance: &'a Provenance,
    /// Names and texts: of the scenario, then of the files it names.
    pub texts: &'a [(String, String)],
    /// The obstacles.
    pub surroundings: &'a Surroundings,
    /// Time of every increment, in steps: the first step ends at 1.
    pub times: &'a [f64],
    /// The space that the harness went through, where it was asked for.
    pub swept: Option<&'a Surface>,
    /// Whether the fields of nodes are in a file beside `result.json`: see [`fields`](crate::fields).
    #[cfg(feature = "arrow")]
    pub fields_apart: bool,
    /// Program and version.
    pub program: &'a str,
    /// The machine.
    pub machine: &'a str,
    /// Day and time.
    pub written: &'a str,
}

impl Ended<'_> {
    /// The last increment of every step.
    pub fn ends(&self) -> Vec<&StepResult> {
        ends(self.run)
    }
}

/// The last increment that was kept of every step.
pub fn ends(run: &Run) -> Vec<&StepResult> {
    let goes_on = |k: usize, end: &StepResult| {
        run.steps.get(k + 1).is_some_and(|next| next.name == end.name && next.increment > end.increment)
    };
    run.steps.iter().enumerate().filter(|(k, end)| !goes_on(*k, end)).map(|(_, end)| end).collect()
}

/// The obstacles of a harness, and which of them move.
#[derive(Clone, Debug)]
pub struct Surroundings {
    obstacles: Vec<Obstacle>,
    moves: Vec<bool>,
}

/// Size of an unbounded obstacle where it is drawn, m.
const DRAWN: f64 = 10.0;

impl Surroundings {
    /// `moves`: whether an obstacle moves, by its index.
    pub fn new(obstacles: Vec<Obstacle>, moves: impl Fn(usize) -> bool) -> Self {
        Self { moves: (0..obstacles.len()).map(moves).collect(), obstacles }
    }

    /// Those of a run: an obstacle moves where a step moves it, or may move where it is mounted on a mechanism.
    pub fn of_run(obstacles: Vec<Obstacle>, schedule: &Schedule) -> Self {
        let moved: Vec<usize> =
            schedule.steps.iter().flat_map(|step| &step.obstacle_moves).map(|motion| motion.obstacle).collect();
        let mounted: Vec<bool> = obstacles.iter().map(|own| own.mount.is_some()).collect();
        Self::new(obstacles, |k| mounted[k] || moved.contains(&k))
    }

    /// The obstacles, in the order of the scenario.
    pub fn obstacles(&self) -> &[Obstacle] {
        &self.obstacles
    }

    /// Whether an obstacle moves (`true`) or stands still (`false`).
    pub fn any(&self, moving: bool) -> bool {
        self.moves.contains(&moving)
    }

    /// Surfaces of those that move, or of the others, at their poses in `end`; each with its index.
    pub fn surfaces(&self, end: &StepResult, moving: bool) -> Vec<(usize, Surface)> {
        (0..self.obstacles.len()).filter(|k| self.moves[*k] == moving).map(|k| self.surface(k, end)).collect()
    }

    /// Surfaces of all, likewise.
    pub fn all_surfaces(&self, end: &StepResult) -> Vec<(usize, Surface)> {
        (0..self.obstacles.len()).map(|k| self.surface(k, end)).collect()
    }

    fn surface(&self, k: usize, end: &StepResult) -> (usize, Surface) {
        let pose = end.obstacles[k].pose;
        let mut surface = self.obstacles[k].shape.surface(DRAWN);
        surface.corners.iter_mut().for_each(|x| *x = pose.position + pose.orientation * *x);
        (k, surface)
    }
}
