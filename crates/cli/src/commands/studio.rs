//! `wireloom studio`: a session in the browser, or a finished run in it.

mod fence;
mod memory;
mod redirect;
mod storage;

use crate::arguments::{Allowed, StudioArguments};
use crate::failure::{Failure, Outcome};
use crate::files::envelope;
use crate::files::folder;
use crate::files::load;
use crate::files::own::{ANEW, Own};
use crate::files::page::SCENE;
use crate::files::place::Place;
use crate::files::results::{FIELDS, RESULT};
use crate::interrupt;
use crate::plugin::load::load as load_plugins;
use crate::plugin::trust::Trust;
use crate::print::diagnostics;
use crate::program::{PROGRAM, machine, now};
use fence::Fence;
use memory::{Draft, Memory, Remembered};
use redirect::Redirect;
use std::io::{self, Write};
use std::net::{IpAddr, TcpListener, ToSocketAddrs};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use storage::FileStorage;
use wireloom::export::json;
use wireloom::export::json::Provenance;
use wireloom_studio::exports::{self, ExportInfo};
use wireloom_studio::protocol::Scene;
use wireloom_studio::replay::Recorder;
use wireloom_studio::server::{Backend, Content, DraftOffer, Live, Server, Site, Token};
use wireloom_studio::{PAGE, SessionInput, Studio};

/// Serves the page until a signal to stop.
pub fn studio(arguments: &StudioArguments, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let what = &arguments.what;
    let envelope = arguments.envelope.as_deref().map(envelope::read).transpose()?;
    let mut memory = remember(what)?;
    let known = memory.as_ref().map(|memory| memory.remembered().clone()).unwrap_or_default();
    let (listener, token) = address(arguments, &known)?;
    let address = listener.local_addr().map_err(Failure::system("listen"))?;
    if let Some(memory) = &mut memory {
        let kept = memory.change(|known| {
            known.port = Some(address.port());
        });
        kept.map_err(Failure::io("remember the address of", what))?;
    }
    let site =
        if what.is_dir() { finished(what, envelope)? } else { session(arguments, memory, known.draft, envelope)? };
    let server = Server::start(listener, &arguments.host, token.clone(), site).map_err(Failure::system("serve"))?;
    let host = if address.ip().is_unspecified() { "127.0.0.1".to_owned() } else { shown(address.ip()) };
    let page = format!("http://{host}:{}/?token={}", address.port(), token.digits());
    let say = |out: &mut dyn Write| {
        if !address.ip().is_loopback() {
            writeln!(
                out,
                "WARNING: this listens at {address}: anyone who can reach this machine and knows or overhears the \
                 token (nothing is encrypted) can use the session",
            )?;
        }
        writeln!(out, "{page}")?;
        writeln!(out, "Ctrl-C ends it")?;
        out.flush()
    };
    // From now on Ctrl-C ends the session.
    interrupt::listen();
    say(out).map_err(Failure::standard_output)?;
    let mut redirect = None;
    if !arguments.no_open {
        match Redirect::to(&page).and_then(|made| made.open().map(|()| made)) {
            // Browsers are slow: it stays until the session ends.
            Ok(made) => redirect = Some(made),
            Err(error) => writeln!(out, "no browser could be opened ({error}): open that address in one")
                .and_then(|()| out.flush())
                .map_err(Failure::standard_output)?,
        }
    }
    interrupt::wait();
    let ended = server.stop();
    drop(redirect);
    if !ended {
        out.flush().map_err(Failure::standard_output)?;
        interrupt::leave(0);
    }
    Ok(Outcome::Done)
}

/// An address as part of an URL.
fn shown(address: IpAddr) -> String {
    match address {
        IpAddr::V4(address) => address.to_string(),
        IpAddr::V6(address) => format!("[{address}]"),
    }
}

/// The state that is kept of the scenario or folder; none where another studio has it open, or where it cannot be
/// kept.
fn remember(what: &Path) -> Result<Option<Memory>, Failure> {
    // Nothing is kept of a file that does not exist.
    if !what.is_dir() {
        load::open(what)?;
    }
    let memory = Memory::of(what).map_err(Failure::io("keep drafts of", what));
    let (memory, lack) = match memory {
        Ok(None) => {
            (None, Some(Failure::Input(format!("another studio has {} open: this one keeps no draft", what.display()))))
        }
        Ok(memory) => (memory, None),
        // The session works without.
        Err(failure) => (None, Some(failure)),
    };
    if let Some(lack) = lack {
        diagnostics::show(&lack, &mut io::stderr());
    }
    Ok(memory)
}

/// The address, by default that of the last session, so that open pages notice the new one; and the token of pages.
fn address(arguments: &StudioArguments, known: &Remembered) -> Result<(TcpListener, Token), Failure> {
    let refused = |error: io::Error| {
        Failure::Input(format!("cannot listen at {}: {error}; give another --host or --port", arguments.host))
    };
    let bind = |port: u16| {
        let places = (arguments.host.as_str(), port).to_socket_addrs()?;
        TcpListener::bind(places.collect::<Vec<_>>().as_slice())
    };
    let wanted = arguments.port.or(known.port).unwrap_or(0);
    let listener = match bind(wanted) {
        Ok(listener) => listener,
        // Another program uses it.
        Err(_) if arguments.port.is_none() => bind(0).map_err(refused)?,
        Err(error) => return Err(refused(error)),
    };
    Ok((listener, Token::random().map_err(|error| Failure::Input(format!("there are no random numbers: {error}")))?))
}

/// A page for the run whose results lie in a folder.
fn finished(path: &Path, envelope: Option<Vec<u8>>) -> Result<Site, Failure> {
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

/// A session of the scenario in a file.
fn session(
    arguments: &StudioArguments,
    memory: Option<Memory>,
    draft: Option<Draft>,
    envelope: Option<Vec<u8>>,
) -> Result<Site, Failure> {
    let path = &arguments.what;
    let text = load::text(path)?;
    let storage = FileStorage::new(path, &text);
    let opener = Opener { allowed: arguments.allowed.clone(), storage };
    let studio = opener.open(&text, false)?;
    let offer = draft.filter(|draft| draft.text != text).map(|Draft { text, written }| DraftOffer { text, written });
    let desk = AtHand { opener, memory: memory.map(Mutex::new) };
    let content = Content::Live(Live::new(studio, offer, Box::new(desk)));
    Ok(Site { page: PAGE.to_owned(), content, envelope })
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
        let files = Fence::of(&path);
        let opened = SessionInput {
            text: text.to_owned(),
            name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            files: Arc::new(files.clone()),
            registry,
            unsaved,
            storage: Some(Box::new(self.storage.clone())),
        };
        let studio = wireloom_studio::open(opened)
            .map_err(|faults| Failure::Refused(vec![load::refusal(&path, text.to_owned(), faults)]))?;
        files.close();
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
    other.change(|known| known.port = port)?;
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
        let followed = follow(&mut memory, &self.opener.storage.path(), Memory::of);
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
