//! A run before it begins: its scenario, folder and record.

use crate::arguments::{RunArguments, values};
use crate::failure::Failure;
use crate::files::envelope;
use crate::files::folder::Folder;
use crate::files::load::{self, Loaded};
use crate::files::results;
use crate::files::saved::{self, Keeper, Origin, Standing};
use crate::plugin::trust::Trust;
use crate::print::progress::Bar;
use crate::size::{self, increments};
use std::path::{Path, PathBuf};
use wireloom::scenario::{Scenario, Setting};
use wireloom::session::Resumed;

/// Bytes that a node takes in `result.json` and in the record for `--resume`, or less.
const BYTES_KEPT: usize = 350;
/// Likewise with `fields = "arrow"`.
const BYTES_APART: usize = 260;
/// Likewise in the record of an increment for the swept space.
const BYTES_SWEPT: usize = 24;

/// A run that is ready to begin.
pub struct Job {
    /// The scenario's file.
    pub file: PathBuf,
    pub loaded: Loaded,
    /// Memory and time of a large harness, in words.
    pub size: Option<String>,
    pub folder: Folder,
    pub keeper: Keeper,
    pub standing: Standing,
    pub resumed: Option<Resumed>,
}

impl Job {
    /// Reads the scenario, empties the folder of results and begins a record.
    pub fn begin(arguments: &RunArguments, trust: &Trust, bar: &Bar) -> Result<Self, Failure> {
        let file = arguments.file.as_deref().unwrap_or(Path::new(""));
        let mut loaded = load::scenario(file, &settings(file, arguments, trust)?, trust)?.with_mesh(bar)?;
        loaded.scenario.output.report |= arguments.report;
        // A harness that does not fit is refused before the results of an earlier run are removed.
        let size = size::estimate(&loaded.built.network, increments(&loaded.built))?;
        let mut folder = Folder::of_results(arguments.out.as_deref(), file)?;
        folder.clear()?;
        envelope::remove(folder.own())?;
        folder.has_room(bytes(&loaded))?;
        let origin = Origin::new(file, arguments, &loaded)?;
        let keeper = Keeper::begin(&folder, &origin)?;
        let file = file.to_owned();
        Ok(Self { file, loaded, size, folder, keeper, standing: Standing::default(), resumed: None })
    }

    /// Reads the record of an interrupted run, and its scenario again.
    pub fn resume(place: &Path, trust: &Trust, bar: &Bar) -> Result<Self, Failure> {
        let folder = saved::interrupted(place)?;
        let origin = Origin::read(&folder)?;
        let mut loaded = load::scenario(&origin.file, &origin.settings(), trust)?.with_mesh(bar)?;
        loaded.scenario.output.report |= origin.report;
        origin.check(&loaded)?;
        let size = size::estimate(&loaded.built.network, increments(&loaded.built))?;
        let (keeper, standing, resumed) = Keeper::resume(&folder)?;
        results::check(&folder, &loaded.scenario.output, &loaded.built, standing.times.len())?;
        if resumed.as_ref().is_some_and(|resumed| !resumed.checkpoint.fits(&loaded.built.network)) {
            return Err(Failure::Input(format!(
                "the run in {} was begun by another build of this program: run the scenario anew",
                place.display()
            )));
        }
        Ok(Self { file: origin.file, loaded, size, folder, keeper, standing, resumed })
    }
}

/// Settings of the command line: a point of the sweep, a minimiser, keys.
fn settings(file: &Path, arguments: &RunArguments, trust: &Trust) -> Result<Vec<Setting>, Failure> {
    let mut settings = vec![];
    if let Some(k) = arguments.point {
        let scenario = load::scenario(file, &[], trust)?.scenario;
        let points = scenario.sweep.as_ref().map_or(0, |sweep| sweep.points);
        match &scenario.sweep {
            Some(sweep) if k < points => settings = sweep.settings(k),
            Some(_) => {
                return Err(Failure::Input(format!("there is no point {k}: the sweep has points 0 to {}", points - 1)));
            }
            None => return Err(Failure::Input(format!("{} has no [sweep], so it has no point {k}", file.display()))),
        }
    }
    settings.extend(arguments.minimiser.as_deref().map(Setting::minimiser));
    for set in &arguments.set {
        settings.push(values::setting(set)?);
    }
    Ok(settings)
}

/// Lower bound of the size of the results, bytes.
fn bytes(loaded: &Loaded) -> u64 {
    let Loaded { scenario: Scenario { output, .. }, built, .. } = loaded;
    let all = increments(built);
    let kept = if output.increments {
        all
    } else {
        built.schedule.steps.iter().map(|step| step.parts.max(1)).sum::<usize>().max(1)
    };
    let series: usize = results::asked(output).map(|format| all * format.bytes_per_node()).sum();
    let node = if output.asks_for("fields") { BYTES_APART } else { BYTES_KEPT };
    let swept = if output.swept.is_some() { all } else { 0 };
    (built.network.points * (kept * node + series + swept * BYTES_SWEPT)) as u64
}
