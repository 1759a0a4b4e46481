//! A session of a scenario: opened, its drafts kept, its results exported.

use super::fence::{Fence, NoFile};
use super::memory::{Draft, Memory};
use super::storage::FileStorage;
use crate::arguments::Allowed;
use crate::failure::Failure;
use crate::files::load;
use crate::plugin::load::load as load_plugins;
use crate::plugin::trust::Trust;
use crate::print::diagnostics;
use crate::program::{PROGRAM, machine, now};
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wireloom::export::json::Provenance;
use wireloom_studio::exports::{self, ExportInfo};
use wireloom_studio::server::{Backend, DraftOffer, Live};
use wireloom_studio::{SessionFiles, SessionInput, Studio};

/// The state that is kept of the scenario or folder; none, and why, where another studio has it open, or where it
/// cannot be kept: the session works without.
pub fn remember(what: &Path) -> (Option<Memory>, Option<Failure>) {
    match Memory::of(what) {
        Ok(Some(memory)) => (Some(memory), None),
        Ok(None) => {
            let message = format!("another studio has {} open: this one keeps no draft", what.display());
            (None, Some(Failure::Input(message)))
        }
        Err(error) => (None, Some(Failure::io("keep drafts of", what)(error))),
    }
}

/// A session of the scenario in a file.
pub fn of_file(path: &Path, allowed: &Allowed, memory: Option<Memory>) -> Result<Live, Failure> {
    let text = load::text(path)?;
    let opener = Opener { allowed: allowed.clone(), storage: FileStorage::new(path, &text) };
    let studio = opener.open(&text, false)?;
    let draft = memory.as_ref().and_then(|memory| memory.remembered().draft.clone());
    let offer = draft.filter(|draft| draft.text != text).map(|Draft { text, written }| DraftOffer { text, written });
    Ok(Live::new(studio, offer, Box::new(AtHand { opener, memory: memory.map(Mutex::new) })))
}

/// A session of a text that has no file yet: it is saved in `folder`. `unsaved`: whether the text is nowhere else.
/// `memory` gives the state that is kept meanwhile, once the text has turned out to be valid.
pub fn of_text(
    text: &str,
    (folder, name): (&Path, &str),
    allowed: &Allowed,
    unsaved: bool,
    memory: impl FnOnce() -> Option<Memory>,
) -> Result<Live, Failure> {
    let opener = Opener { allowed: allowed.clone(), storage: FileStorage::new_in(folder, name) };
    let studio = opener.open(text, unsaved)?;
    Ok(Live::new(studio, None, Box::new(AtHand { opener, memory: memory().map(Mutex::new) })))
}

/// Opens sessions of one scenario.
struct Opener {
    allowed: Allowed,
    storage: FileStorage,
}

impl Opener {
    /// Opens the text of the file, or one in its place that is not saved.
    fn open(&self, text: &str, unsaved: bool) -> Result<Studio, Failure> {
        // Another one since the scenario was saved under another name.
        let path = self.storage.path();
        let trust = Trust::to_run(&self.allowed);
        let mut registry = trust.registry();
        load_plugins(&path, text, &trust, &mut registry)?;
        let fence = self.storage.file().map(|file| Fence::of(&file));
        let files: Arc<dyn SessionFiles> = match &fence {
            Some(fence) => Arc::new(fence.clone()),
            None => Arc::new(NoFile),
        };
        let opened = SessionInput {
            text: text.to_owned(),
            name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            files,
            registry,
            unsaved,
            storage: Some(Box::new(self.storage.clone())),
        };
        let studio = wireloom_studio::open(opened)
            .map_err(|faults| Failure::Refused(vec![load::refusal(&path, text.to_owned(), faults)]))?;
        if let Some(fence) = fence {
            fence.close();
        }
        Ok(studio)
    }

    /// Provenance of the results of a text; and all texts.
    fn origin(&self, text: &str) -> Option<(Provenance, Vec<(String, String)>)> {
        let loaded =
            load::scenario_of(&self.storage.path(), text.to_owned(), &[], &Trust::to_run(&self.allowed)).ok()?;
        Some((loaded.provenance(), loaded.texts))
    }
}

/// The state of the scenario's file, if that has another path since it was saved under another name; `open`: that of
/// a path, unless another studio has it. It has the port of this session, where its pages are open.
///
/// # Errors
/// If drafts cannot be kept there; those of the file of before are none of the new file.
fn follow(memory: &mut Memory, path: &Path, open: impl FnOnce(&Path) -> io::Result<Option<Memory>>) -> io::Result<()> {
    let path = match path.canonicalize() {
        // It was removed: its draft stays where it is.
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        path => path?,
    };
    if path == memory.remembered().scenario {
        return Ok(());
    }
    let other = open(&path)?;
    let port = memory.remembered().port;
    memory.change(|known| known.draft = None)?;
    let Some(mut other) = other else { return Err(io::Error::other("another studio has it open")) };
    other.change(|known| (known.port, known.opened) = (port, Some(now())))?;
    *memory = other;
    Ok(())
}

/// Services for the server: drafts, sessions, exports.
struct AtHand {
    opener: Opener,
    /// None where another studio has this scenario open.
    memory: Option<Mutex<Memory>>,
}

impl AtHand {
    /// The state of the scenario's present file, and whether it can be kept.
    fn memory(&self) -> Option<(MutexGuard<'_, Memory>, io::Result<()>)> {
        let mut memory = self.memory.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner);
        let followed = self.opener.storage.file().map_or(Ok(()), |file| follow(&mut memory, &file, Memory::of));
        Some((memory, followed))
    }
}

impl Backend for AtHand {
    fn keep(&self, draft: Option<&str>) {
        let draft = draft.map(|text| Draft { text: text.to_owned(), written: now() });
        let Some((mut memory, followed)) = self.memory() else { return };
        if let Err(error) = followed {
            let failure = Failure::Io { what: "cannot keep drafts of the new file".to_owned(), source: error };
            diagnostics::show(&failure, &mut io::stderr());
            return;
        }
        if let Err(error) = memory.change(|known| known.draft = draft) {
            let failure = Failure::Io { what: "cannot keep the draft".to_owned(), source: error };
            diagnostics::show(&failure, &mut io::stderr());
        }
    }

    fn open(&self, draft: &str) -> Result<Studio, String> {
        self.opener.open(draft, true).map_err(|failure| failure.to_string())
    }

    fn changed_outside(&self) -> Option<String> {
        // Asked at intervals: a new name is noticed even if there is no draft. A fault is told when there is one.
        drop(self.memory());
        self.opener.storage.changed_outside()
    }

    fn export(&self, studio: &Studio, name: &str) -> Option<Vec<u8>> {
        let outcome = studio.result()?;
        let (provenance, texts) = self.opener.origin(&studio.text()?)?;
        let made = ExportInfo {
            provenance: &provenance,
            texts: &texts,
            program: PROGRAM,
            machine: &machine(),
            written: &now(),
        };
        exports::make(&outcome.run, &outcome.obstacles, name, &made)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use wireloom_studio::Storage;

    const CABLE: &str = "schema = 1\n[sections.s]\ndiameter = 0.008\nlinear_density = 0.1\naxial_stiffness = 1e4\n\
                         bending_stiffness = 0.01\ntorsion_stiffness = 0.01\n[[branches]]\nname = \"b\"\nfrom = \"A\"\n\
                         to = \"B\"\nsection = \"s\"\nlength = 1\nsegments = 4\n[[constraints]]\nname = \"c\"\n\
                         kind = \"connector\"\nat = { end = \"A\" }\n";

    /// Results and refusals named the file of before.
    #[test]
    fn after_a_scenario_is_saved_under_another_name_it_is_that_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("y.toml");
        fs::write(&path, CABLE).expect("written");
        let mut opener = Opener { allowed: Allowed::default(), storage: FileStorage::new(&path, CABLE) };
        assert_eq!(opener.storage.store(CABLE, Some("z.toml"), false).as_deref(), Ok("z.toml"));
        let (_, texts) = opener.origin(CABLE).expect("no faults");
        assert_eq!(texts[0].0, "z.toml");
        let Err(Failure::Refused(refused)) = opener.open("schema = ", true) else { panic!() };
        assert!(refused[0].file.ends_with("z.toml"), "{}", refused[0].file);
    }

    /// The next session of the new file had another port, and open pages did not find it.
    #[test]
    fn the_port_of_a_session_is_that_of_the_file_that_it_was_saved_as() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().canonicalize().expect("there");
        let of = |path: &Path| Memory::within(&place.join("states"), path.to_owned());
        let [old, new] = ["y.toml", "z.toml"].map(|name| place.join(name));
        fs::write(&new, "").expect("written");
        let mut memory = of(&old).expect("readable").expect("free");
        let draft = Some(Draft { text: "a = 1".to_owned(), written: now() });
        memory.change(|known| (known.port, known.draft) = (Some(7), draft)).expect("written");
        follow(&mut memory, &new, of).expect("readable");
        let kept = memory.remembered();
        assert_eq!((kept.scenario.as_path(), kept.port, &kept.draft), (new.as_path(), Some(7), &None));
        assert_eq!(of(&old).expect("readable").expect("free again").remembered().draft, None);
    }

    /// The draft of the new file was offered as that of the old one.
    #[test]
    fn a_file_that_another_studio_has_open_leaves_no_draft_with_the_one_before() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().canonicalize().expect("there");
        let [old, new] = ["y.toml", "z.toml"].map(|name| place.join(name));
        fs::write(&new, "").expect("written");
        let mut memory = Memory::within(&place.join("states"), old.clone()).expect("readable").expect("free");
        let draft = Draft { text: "a = 1".to_owned(), written: now() };
        memory.change(|known| known.draft = Some(draft.clone())).expect("written");
        follow(&mut memory, &old, |_| panic!("it was removed")).expect("its draft is kept");
        assert!(memory.remembered().draft.is_some());
        let refused = follow(&mut memory, &new, |_| Ok(None)).expect_err("no drafts are kept");
        assert!(refused.to_string().contains("another studio"), "{refused}");
        assert_eq!((memory.remembered().scenario.as_path(), &memory.remembered().draft), (old.as_path(), &None));
    }
}
