//! A finished run, as a page.

use crate::failure::Failure;
use crate::files::envelope;
use crate::files::folder;
use crate::files::own::{ANEW, Own};
use crate::files::page::SCENE;
use crate::files::place::Place;
use crate::files::results::{FIELDS, RESULT};
use std::io;
use std::path::Path;
use wireloom::export::json;
use wireloom_studio::PAGE;
use wireloom_studio::protocol::Scene;
use wireloom_studio::replay::Recorder;
use wireloom_studio::server::{Content, Site};

/// A page for the run whose results lie in a folder.
pub fn finished(path: &Path, envelope: Option<Vec<u8>>) -> Result<Site, Failure> {
    let no_result = |error: io::Error| match error.kind() {
        io::ErrorKind::InvalidData | io::ErrorKind::UnexpectedEof => Failure::Input(format!(
            "{} holds no result of this version of `wireloom run`: {error}; run the scenario anew",
            path.display()
        )),
        _ => Failure::io("read", path)(error),
    };
    let place = Place::open(path).map_err(Failure::io("read", path))?;
    if !place.has(RESULT) && envelope::exists(path) {
        return Err(Failure::Input(format!(
            "{} holds a sweep: open its scenario, with its envelope: wireloom studio FILE --envelope {0}",
            path.display()
        )));
    }
    let result = place.file(RESULT).map_err(Failure::io("read", &path.join(RESULT)))?;
    let run = json::read_run_with(result, || place.file(FIELDS)).map_err(no_result)?;
    let own = Own::open(path)?;
    let absent = || Failure::io("read", &own.path(SCENE))(io::ErrorKind::NotFound.into());
    let bytes = own.part(SCENE, ANEW)?.ok_or_else(absent)?;
    let scene: Scene = serde_json::from_slice(&bytes).map_err(|error| no_result(error.into()))?;
    let mut recorder = Recorder::new(Scene {
        exports: folder::written(&own)?.into_keys().collect(),
        envelope: envelope.is_some(),
        ..scene
    });
    run.steps.iter().for_each(|end| recorder.record(end));
    let replay = recorder.finish(&run);
    let names = replay.scene().exports.clone();
    let file = move |name: &str| names.iter().any(|known| known == name).then(|| place.bytes(name).ok().flatten())?;
    Ok(Site { page: replay.page(PAGE), content: Content::Finished(Box::new(file)), envelope })
}
