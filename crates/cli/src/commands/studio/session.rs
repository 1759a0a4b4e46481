//! A session of a scenario: opened, its drafts kept, its results exported.

use super::fence::{Fence, OnceSaved};
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
use wireloom::session::Refusal;
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
    Ok(live(studio, &text, false, opener, memory))
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
    Ok(live(studio, text, unsaved, opener, memory()))
}

/// The session of a text, which offers the drafts of earlier ones. `unsaved`: whether the text is nowhere else.
fn live(studio: Studio, text: &str, unsaved: bool, opener: Opener, mut memory: Option<Memory>) -> Live {
    if let Some(memory) = &mut memory {
        let own = unsaved.then(|| Draft { text: text.to_owned(), written: now() });
        if let Err(error) = memory.change(|known| known.begin(text, own)) {
            cannot("keep the draft", error);
        }
    }
    let earlier = memory.as_ref().map_or(&[][..], |memory| &memory.remembered().earlier).iter().rev();
    let offer = |Draft { text, written }: &Draft| DraftOffer { text: text.clone(), written: written.clone() };
    let offers = earlier.map(offer).collect();
    let kept = memory.map(|memory| Mutex::new(Kept { memory, has_moved: false }));
    Live::new(studio, offers, Box::new(AtHand { opener, kept }))
}

/// Tells on the terminal what the system refuses.
pub fn cannot(what: &str, source: io::Error) {
    let failure = Failure::Io { what: format!("cannot {what}"), source };
    diagnostics::show(&failure, &mut io::stderr());
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
            None => Arc::new(OnceSaved::of(self.storage.clone())),
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

/// The state that is kept of a scenario.
struct Kept {
    memory: Memory,
    /// Whether that is the state of another file than the session began with.
    has_moved: bool,
}

impl Kept {
    /// Goes to the state of the scenario's file, if that has another path since it was saved under another name;
    /// `open`: that of a path, unless another studio has it. It has the port of this session, where its pages are open.
    ///
    /// # Errors
    /// If drafts cannot be kept there; those of the file of before are none of the new file.
    fn follow(&mut self, path: &Path, open: impl FnOnce(&Path) -> io::Result<Option<Memory>>) -> io::Result<()> {
        let path = match path.canonicalize() {
            // It was removed: its draft stays where it is.
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            path => path?,
        };
        if path == self.memory.remembered().scenario {
            return Ok(());
        }
        let other = open(&path)?;
        let port = self.memory.remembered().port;
        // Those of earlier sessions stay for the next one.
        self.memory.change(|known| known.draft = None)?;
        let Some(mut other) = other else { return Err(io::Error::other("another studio has it open")) };
        other.change(|known| {
            known.set_aside();
            (known.port, known.opened) = (port, Some(now()));
        })?;
        *self = Self { memory: other, has_moved: true };
        Ok(())
    }
}

/// Services for the server: drafts, sessions, exports.
struct AtHand {
    opener: Opener,
    /// None where another studio has this scenario open.
    kept: Option<Mutex<Kept>>,
}

impl AtHand {
    /// The state of the scenario's present file, and whether it can be kept.
    fn kept(&self) -> Option<(MutexGuard<'_, Kept>, io::Result<()>)> {
        let mut kept = self.kept.as_ref()?.lock().unwrap_or_else(PoisonError::into_inner);
        let followed = self.opener.storage.file().map_or(Ok(()), |file| kept.follow(&file, Memory::of));
        Some((kept, followed))
    }
}

impl Backend for AtHand {
    fn keep(&self, draft: Option<&str>) {
        let draft = draft.map(|text| Draft { text: text.to_owned(), written: now() });
        let Some((mut kept, followed)) = self.kept() else { return };
        if let Err(error) = followed {
            return cannot("keep drafts of the new file", error);
        }
        if let Err(error) = kept.memory.change(|known| known.draft = draft) {
            cannot("keep the draft", error);
        }
    }

    fn discard(&self, draft: &str) {
        let Some((mut kept, _)) = self.kept() else { return };
        if let Err(error) = kept.memory.change(|known| known.earlier.retain(|own| own.text != draft)) {
            cannot("delete the draft", error);
        }
    }

    fn open(&self, draft: &str) -> Result<Studio, String> {
        self.opener.open(draft, true).map_err(|failure| failure.to_string())
    }

    fn still_offers(&self) -> bool {
        self.kept().is_some_and(|(kept, followed)| followed.is_ok() && !kept.has_moved)
    }

    fn store_beside(&self, name: &str, bytes: &[u8]) -> Result<String, Refusal> {
        self.opener.storage.store_beside(name, bytes)
    }

    fn changed_outside(&self) -> Option<String> {
        // Asked at intervals: a new name is noticed even if there is no draft. A fault is told when there is one.
        drop(self.kept());
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
    use crate::commands::studio::memory::Remembered;
    use std::fs;
    use std::net::TcpListener;
    use std::time::{Duration, Instant};
    use wireloom_studio::Storage;
    use wireloom_studio::server::{Content, Server, Site, Token};

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
        let mut kept = Kept { memory: of(&old).expect("readable").expect("free"), has_moved: false };
        let draft = Some(Draft { text: "a = 1".to_owned(), written: now() });
        kept.memory.change(|known| (known.port, known.draft) = (Some(7), draft)).expect("written");
        kept.follow(&new, of).expect("readable");
        let kept = kept.memory.remembered();
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
        let memory = Memory::within(&place.join("states"), old.clone()).expect("readable").expect("free");
        let mut kept = Kept { memory, has_moved: false };
        let draft = Draft { text: "a = 1".to_owned(), written: now() };
        kept.memory.change(|known| known.draft = Some(draft.clone())).expect("written");
        kept.follow(&old, |_| panic!("it was removed")).expect("its draft is kept");
        assert!(kept.memory.remembered().draft.is_some());
        let refused = kept.follow(&new, |_| Ok(None)).expect_err("no drafts are kept");
        assert!(refused.to_string().contains("another studio"), "{refused}");
        let kept = kept.memory.remembered();
        assert_eq!((kept.scenario.as_path(), &kept.draft), (old.as_path(), &None));
    }

    /// An imported harness, which is unsaved, replaced the draft at the first interval; then it was not kept itself.
    #[test]
    fn a_draft_that_nobody_has_answered_stays_beside_that_of_another_text_without_a_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().canonicalize().expect("there");
        let kept = || Memory::within(&place.join("states"), place.clone()).expect("readable").expect("free");
        let draft = Draft { text: CABLE.replace("length = 1", "length = 2"), written: now() };
        let mut memory = kept();
        memory.change(|known| known.draft = Some(draft.clone())).expect("written");
        let live = of_text(CABLE, (&place, "y.toml"), &Allowed::default(), true, || Some(memory)).expect("no faults");
        let studio = live.now();
        let began = Instant::now();
        while studio.draft().is_none() {
            assert!(began.elapsed() < Duration::from_secs(60), "it is unsaved");
            std::thread::sleep(Duration::from_millis(5));
        }
        let site = Site { page: String::new(), content: Content::Live(live), envelope: None };
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let token = Token::random().expect("random numbers");
        let server = Server::start(listener, "127.0.0.1", token, site).expect("started");
        assert!(server.stop(), "it keeps the draft at the end, too");
        let kept = kept();
        let Remembered { draft: own, earlier, .. } = kept.remembered();
        assert_eq!((own.as_ref().map(|own| own.text.as_str()), earlier), (Some(CABLE), &vec![draft]));
    }

    /// To save the session under a name deleted it.
    #[test]
    fn a_draft_that_nobody_has_answered_stays_where_it_is_when_the_session_is_saved() {
        let folder = tempfile::tempdir().expect("a folder");
        let place = folder.path().canonicalize().expect("there");
        let of = |path: &Path| Memory::within(&place.join("states"), path.to_owned());
        let new = place.join("mine.toml");
        fs::write(&new, "").expect("written");
        let mut kept = Kept { memory: of(&place).expect("readable").expect("free"), has_moved: false };
        let [earlier, own] = ["a = 1", "a = 2"].map(|text| Draft { text: text.to_owned(), written: now() });
        kept.memory.change(|known| known.draft = Some(earlier.clone())).expect("written");
        kept.memory.change(|known| known.begin("a = 0", Some(own))).expect("written");
        kept.follow(&new, of).expect("readable");
        assert_eq!((kept.memory.remembered().scenario.as_path(), kept.has_moved), (new.as_path(), true));
        let memory = of(&place).expect("readable").expect("free again");
        assert_eq!((&memory.remembered().draft, &memory.remembered().earlier), (&None, &vec![earlier]));
    }
}
