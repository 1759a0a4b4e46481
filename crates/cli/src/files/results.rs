//! The files of a run: those of all formats of the [`catalogue`](wireloom::export::catalogue) that the scenario's
//! `[output]` asks for.

use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::program::{PROGRAM, machine, now};
use std::sync::Arc;
use wireloom::export::catalogue::FORMATS;
use wireloom::export::format::{Ended, Format, Increment, Surroundings};
use wireloom::export::json::Provenance;
use wireloom::harness::Surface;
use wireloom::result::Identities;
use wireloom::scenario::{Built, Output};
use wireloom::session::Progress;
use wireloom::{Run, StepResult};

/// The file of the fields of nodes.
pub use wireloom::export::fields::FILE as FIELDS;
/// The file of the whole run.
pub use wireloom::export::json::FILE as RESULT;

/// Writer of the files that `[output]` asks for.
pub struct Results {
    folder: Folder,
    output: Output,
    texts: Vec<(String, String)>,
    provenance: Provenance,
    surroundings: Surroundings,
    identities: Arc<Identities>,
    times: Vec<f64>,
}

/// The formats that are asked for, and those that are always written.
pub fn asked(output: &Output) -> impl Iterator<Item = &'static dyn Format> {
    FORMATS.iter().copied().filter(|format| format.key().is_none_or(|key| output.asks_for(key)))
}

impl Results {
    /// Into this folder; `texts`: those of the scenario; `times`: those of the increments written before an
    /// interruption.
    pub fn new(
        folder: Folder,
        output: Output,
        texts: Vec<(String, String)>,
        provenance: Provenance,
        surroundings: Surroundings,
        identities: Arc<Identities>,
        times: Vec<f64>,
    ) -> Self {
        Self { folder, output, texts, provenance, surroundings, identities, times }
    }

    /// Times of the increments so far, in steps.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Writes the files of an increment as soon as it has ended, so that an interruption does not lose them.
    pub fn increment(&mut self, progress: &Progress, end: &StepResult) -> Result<(), Failure> {
        let Self { folder, output, surroundings, identities, times, .. } = self;
        let ended = Increment { number: times.len() + 1, end, surroundings, identities };
        for file in asked(output).flat_map(|format| format.at_increment(&ended)) {
            let name = file.name.clone();
            folder.write(&name, |out| file.write(out))?;
        }
        times.push(progress.step_index as f64 + progress.increment as f64 / progress.increments as f64);
        Ok(())
    }

    /// Writes the files of the whole run; `swept`: the space that the harness went through.
    pub fn finish(&mut self, run: &Run, swept: Option<&Surface>) -> Result<(), Failure> {
        let Self { folder, output, texts, provenance, surroundings, times, .. } = self;
        let (machine, written) = (machine(), now());
        let ended = Ended {
            run,
            provenance,
            texts,
            surroundings,
            times,
            swept,
            fields_apart: output.asks_for("fields"),
            program: PROGRAM,
            machine: &machine,
            written: &written,
        };
        for format in asked(output) {
            for file in format.at_end(&ended) {
                let name = file.name.clone();
                folder.write(&name, |out| file.write(out))?;
            }
        }
        Ok(())
    }

    /// `out/first: result.json, picture.svg`, with no more than a few names.
    pub fn words(&self) -> String {
        let (below, names): (Vec<&str>, Vec<&str>) = self.folder.names().partition(|name| name.contains('/'));
        let more = match below.len() {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        format!("{}: {}{more}", self.folder.path().display(), names.join(", "))
    }
}

/// Makes sure that the files of this number of increments still are what was written, before more are added to them.
pub fn check(folder: &Folder, output: &Output, built: &Built, increments: usize) -> Result<(), Failure> {
    let surroundings = Surroundings::of_run(built.network.obstacles.clone(), &built.schedule);
    for (number, format) in (1..=increments).flat_map(|number| asked(output).map(move |format| (number, format))) {
        format.increment_names(number, &surroundings).iter().try_for_each(|name| folder.check(name))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use wireloom::scenario::schema;

    /// Keys of `[output]` that are no formats.
    const SETTINGS: [&str; 3] = ["increments", "clearance", "sensitivities"];

    /// A scenario with these lines in its `[output]`.
    fn output(lines: &str) -> Output {
        let text = format!(
            "schema = 1\n[sections.c]\ndiameter = 0.01\nlinear_density = 0.1\naxial_stiffness = 1e4\n\
             bending_stiffness = 0.01\ntorsion_stiffness = 0.01\n[[branches]]\nname = \"a\"\nfrom = \"A\"\nto = \"B\"\n\
             section = \"c\"\nlength = 1.0\nsegments = 4\n[[constraints]]\nname = \"plug\"\nkind = \"connector\"\n\
             at = {{ end = \"A\" }}\nposition = [0, 0, 0]\ntangent = [1, 0, 0]\nup = [0, 0, 1]\n\
             [output]\npicture = false\n{lines}"
        );
        wireloom::load(&text, &wireloom::registry()).expect("a scenario").0.output
    }

    #[test]
    fn the_catalogue_has_the_keys_of_scenarios() {
        let schema = schema(&wireloom::registry());
        let keys = schema.pointer("/properties/output/properties").and_then(|keys| keys.as_object()).expect("keys");
        let mut known: Vec<&str> = keys.keys().map(String::as_str).filter(|key| !SETTINGS.contains(key)).collect();
        let mut written: Vec<&str> = FORMATS.iter().filter_map(|format| format.key()).collect();
        known.sort_unstable();
        written.sort_unstable();
        assert_eq!(written, known);
    }

    #[test]
    fn a_key_asks_for_its_format_alone() {
        let always: Vec<_> = asked(&output("")).map(|format| format.key()).collect();
        assert_eq!(always, [None]);
        for key in FORMATS.iter().filter_map(|format| format.key()) {
            let line = match key {
                "picture" => continue,
                "swept" => "swept = 0.01".to_owned(),
                "fields" => "fields = \"arrow\"".to_owned(),
                flag => format!("{flag} = true"),
            };
            let keys: Vec<_> = asked(&output(&line)).filter_map(|format| format.key()).collect();
            assert_eq!(keys, [key]);
        }
    }
}
