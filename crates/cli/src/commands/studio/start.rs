//! The start page: recent files, examples, a new harness, files that are given to the page.

use super::memory::{self, Draft, Memory, Remembered};
use super::{finished, session};
use crate::arguments::Allowed;
use crate::commands::import::{ACCURACY, source};
use crate::failure::{Failure, Refusal};
use crate::files::load;
use crate::print::diagnostics;
use crate::program::{PROGRAM, now};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use wireloom::import::kbl::{self, Arrangement, Options, Selection};
use wireloom_studio::protocol::{
    Arranged, Contents, Example, ImportFile, Module, NotOpened, Notice, OfferedDraft, Opening, Recent, StartPage,
};
use wireloom_studio::server::{Content, Live, Site, Start, Starter, not_opened};
use wireloom_studio::{MAX_FILE, PAGE, imported};

/// Name that is proposed for the file of a new harness.
const NEW_NAME: &str = "new-harness.toml";
/// The text of a new harness.
const NEW: &str = include_str!("new.toml");
/// Name that is proposed for the file of a draft.
const DRAFT_NAME: &str = "harness.toml";

/// Examples that are part of the program: what they show, and their file in `scenarios/`.
macro_rules! examples {
    ($($title:literal: $folder:literal $name:literal,)*) => {
        [$(($title, $name, include_str!(concat!("../../../../../scenarios/", $folder, $name)))),*]
    };
}
const EXAMPLES: &[(&str, &str, &str)] = &examples! {
    "A Y harness is plugged in, one arm after the other": "" "first.toml",
    "Hands carry a harness, mate a plug and let go": "assembly/" "workbench.toml",
    "A door opens, and its harness goes along": "mechanisms/" "door.toml",
    "A harness is let down on boxes": "contact/" "y_on_boxes.toml",
    "Heat, braking and wind in an engine bay": "branches/" "engine_bay.toml",
    "A bundle whose wires slip keeps a part of its bend": "branches/" "keeps_a_set.toml",
};

/// The start page of a folder; `port`: where it is served; `memory`: the state that is kept of it.
pub fn site(folder: PathBuf, allowed: &Allowed, port: u16, memory: Option<Memory>) -> Site {
    let mut memory = memory;
    if let Some(memory) = &mut memory
        && let Err(error) = memory.change(Remembered::set_aside)
    {
        session::cannot("keep the draft", error);
    }
    let starter = AtHand { folder, allowed: allowed.clone(), port, memory: Mutex::new(memory) };
    let content = Content::Start(Start::new(Box::new(starter)));
    Site { page: PAGE.to_owned(), content, envelope: None }
}

/// Opens what the page asks for.
struct AtHand {
    folder: PathBuf,
    allowed: Allowed,
    port: u16,
    /// That of the start page, until a session without a file takes it over; none where another studio has it.
    memory: Mutex<Option<Memory>>,
}

impl AtHand {
    fn memory(&self) -> MutexGuard<'_, Option<Memory>> {
        // No critical section leaves it half changed.
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A scenario or a finished run, as on the command line.
    fn path(&self, path: &str) -> Result<Site, Failure> {
        let path = self.folder.join(path);
        if path.is_dir() {
            let site = finished::finished(&path, None)?;
            // It is listed as a recent one.
            let _ = self.remember(&path);
            return Ok(site);
        }
        // Nothing is kept of a file that does not exist.
        load::open(&path)?;
        let (memory, lack) = self.remember(&path);
        let live = session::of_file(&path, &self.allowed, memory)?;
        // The draft of this page stays for the next one.
        *self.memory() = None;
        let told = lack.map(|lack| Notice::Refused { message: lack.to_string(), help: String::new() });
        Ok(page(live.telling(told.into_iter().collect())))
    }

    /// The state of a scenario or folder that is opened here, and why there is none.
    fn remember(&self, path: &Path) -> (Option<Memory>, Option<Failure>) {
        let (mut memory, mut lack) = session::remember(path);
        if let Some(memory) = &mut memory {
            let kept = memory.change(|known| (known.port, known.opened) = (Some(self.port), Some(now())));
            lack = kept.err().map(Failure::io("remember the address of", path));
        }
        if let Some(lack) = &lack {
            diagnostics::show(lack, &mut io::stderr());
        }
        (memory, lack)
    }

    /// A session without a file.
    fn text(&self, text: &str, name: &str, unsaved: bool) -> Result<Live, Failure> {
        session::of_text(text, (&self.folder, name), &self.allowed, unsaved, || self.memory().take())
    }

    /// The name and the text of a file to be imported.
    fn file(&self, file: &ImportFile) -> Result<(String, String), Failure> {
        match file {
            ImportFile::Text { name, text } => Ok((name.clone(), text.clone())),
            ImportFile::Path { path } => {
                let path = self.folder.join(path);
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                Ok((name, load::text(&path)?))
            }
        }
    }

    fn modules(&self, file: &ImportFile) -> Result<Contents, Failure> {
        let (name, text) = self.file(file)?;
        let found = kbl::contents(&text).map_err(|error| not_imported(&name, &error))?;
        let module = |module: kbl::Module| Module {
            name: module.name,
            description: module.description,
            option_code: module.option_code,
            parts: u32::try_from(module.parts).unwrap_or(u32::MAX),
        };
        let modules = found.modules.into_iter().map(module).collect();
        let variants = found.variants.into_iter().map(|variant| (variant.name, variant.modules)).collect();
        Ok(Contents { name, modules, variants })
    }

    fn import(
        &self,
        file: &ImportFile,
        modules: Option<Vec<String>>,
        spacing: Option<f64>,
        arrangement: Arranged,
    ) -> Result<Live, Failure> {
        let (name, text) = self.file(file)?;
        let options = Options {
            max_segment: spacing.unwrap_or(Options::default().max_segment),
            accuracy: spacing.is_none().then_some(ACCURACY),
            arrangement: match arrangement {
                Arranged::Installed => Arrangement::Installed,
                Arranged::Board => Arrangement::Board,
                Arranged::Assembly => Arrangement::Assembly,
            },
            selection: modules.map_or(Selection::All, Selection::Modules),
            file: Some(source(Path::new(&name), &text)),
            ..Options::default()
        };
        let made = kbl::import(&text, &options).map_err(|error| not_imported(&name, &error))?;
        let target = Path::new(&name).with_extension("toml");
        let live = self.text(&made.scenario, &target.to_string_lossy(), true)?;
        Ok(live.telling(vec![Notice::Imported(imported::of(&made, &name))]))
    }
}

fn not_imported(name: &str, error: &kbl::ImportError) -> Failure {
    Failure::Input(format!("{name} cannot be imported: {error}"))
}

/// The site of a session.
fn page(live: Live) -> Site {
    Site { page: PAGE.to_owned(), content: Content::Live(live), envelope: None }
}

/// A failure as the page shows it.
fn told(failure: Failure) -> NotOpened {
    match failure {
        Failure::Refused(refusals) => match refusals.first() {
            Some(Refusal { file, text, faults }) => {
                // The folder of a text that has no file yet says nothing.
                let name = Path::new(file).file_name().unwrap_or_default().to_string_lossy();
                not_opened(format!("{name} has faults: nothing was opened"), "", text, faults)
            }
            None => not_opened("it was refused", "", "", &[]),
        },
        other => not_opened(other.to_string(), "", "", &[]),
    }
}

impl Starter for AtHand {
    fn page(&self) -> StartPage {
        let example =
            |(title, name, _): &(&str, &str, &str)| Example { name: name.to_string(), title: title.to_string() };
        let recent = |known: memory::Recent| {
            // Other paths cannot be sent back.
            let path = known.scenario.to_str()?.to_owned();
            Some(Recent { path, opened: known.opened, gone: !known.scenario.exists() })
        };
        let memory = self.memory();
        let earlier = memory.as_ref().map_or(&[][..], |memory| &memory.remembered().earlier);
        let offered = |(number, draft): (u32, &Draft)| OfferedDraft { number, written: draft.written.clone() };
        let mut drafts: Vec<OfferedDraft> = (0..).zip(earlier).map(offered).collect();
        drafts.reverse();
        StartPage {
            program: PROGRAM.to_owned(),
            folder: self.folder.display().to_string(),
            recent: memory::recent().into_iter().filter_map(recent).collect(),
            examples: EXAMPLES.iter().map(example).collect(),
            drafts,
            largest_import: u32::try_from(MAX_FILE).unwrap_or(u32::MAX),
        }
    }

    fn contents(&self, file: &ImportFile) -> Result<Contents, NotOpened> {
        self.modules(file).map_err(told)
    }

    fn open(&self, what: Opening) -> Result<Site, NotOpened> {
        let live = match what {
            Opening::Path { path } => return self.path(&path).map_err(told),
            Opening::Example { name } => {
                let known = EXAMPLES.iter().find(|(_, known, _)| *known == name);
                let (_, name, text) = known.ok_or_else(|| {
                    not_opened(format!("there is no example {name:?}"), "open one of those listed", "", &[])
                })?;
                self.text(text, name, false)
            }
            Opening::New => self.text(NEW, NEW_NAME, false),
            Opening::Text { name, text } => self.text(&text, &name, false),
            Opening::Kbl { file, modules, spacing, arrangement } => self.import(&file, modules, spacing, arrangement),
        };
        live.map(page).map_err(told)
    }

    fn restore(&self, number: u32) -> Result<Site, NotOpened> {
        let draft = self.memory().as_ref().and_then(|memory| memory.remembered().earlier.get(number as usize).cloned());
        let draft = draft.ok_or_else(|| {
            not_opened("there is no such draft any more", "another page has accepted or discarded it", "", &[])
        })?;
        self.text(&draft.text, DRAFT_NAME, true).map(page).map_err(told)
    }

    fn discard(&self, number: u32) {
        let forget = |known: &mut Remembered| {
            if (number as usize) < known.earlier.len() {
                known.earlier.remove(number as usize);
            }
        };
        if let Some(memory) = &mut *self.memory()
            && let Err(error) = memory.change(forget)
        {
            session::cannot("delete the draft", error);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn starter(folder: &Path) -> AtHand {
        AtHand { folder: folder.to_owned(), allowed: Allowed::default(), port: 0, memory: Mutex::new(None) }
    }

    fn refused(starter: &AtHand, what: Opening) -> NotOpened {
        starter.open(what).err().expect("it is refused")
    }

    #[test]
    fn examples_and_the_new_harness_need_no_files_and_no_plugins() {
        let folder = tempfile::tempdir().expect("a folder");
        let names: Vec<String> = starter(folder.path()).page().examples.into_iter().map(|own| own.name).collect();
        assert!(names.len() >= 4);
        for what in names.into_iter().map(|name| Opening::Example { name }).chain([Opening::New]) {
            let opened = starter(folder.path()).open(what.clone());
            assert!(opened.is_ok(), "{what:?}: {:?}", opened.err());
        }
        let none = refused(&starter(folder.path()), Opening::Example { name: "../first.toml".into() });
        assert!(none.message.contains("there is no example"), "{none:?}");
    }

    #[test]
    fn texts_with_faults_and_texts_that_name_files_are_refused_with_their_places() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("box.stl"), "solid").expect("written");
        let starter = starter(folder.path());
        let text = |text: String| Opening::Text { name: "y.toml".into(), text };
        let bad = refused(&starter, text("schema = 1\nname = 7\n".into()));
        assert!(bad.message.contains("y.toml has faults") && bad.faults.iter().any(|own| own.line == 2), "{bad:?}");
        let mesh = format!("{NEW}\n[[obstacles]]\nname = \"box\"\nmesh = \"box.stl\"\n");
        let mesh = refused(&starter, text(mesh));
        assert!(mesh.faults.iter().any(|fault| fault.message.contains("open it by its path")), "{mesh:?}");
        std::fs::write(folder.path().join("tie.so"), "").expect("written");
        let plugin = refused(&starter, text(format!("{NEW}\n[plugins]\nload = [\"tie.so\"]\n")));
        assert!(plugin.faults.iter().any(|fault| fault.help.contains("--allow-plugin")), "{plugin:?}");
    }

    #[test]
    fn paths_that_lead_to_nothing_or_to_no_text_are_refused_in_words() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("latin.toml"), b"name = \"\xe4\"").expect("written");
        let starter = starter(folder.path());
        let path = |path: &str| refused(&starter, Opening::Path { path: path.into() }).message;
        assert!(path("none.toml").contains("cannot read"), "{}", path("none.toml"));
        assert!(path("latin.toml").contains("not UTF-8"), "{}", path("latin.toml"));
        assert!(path(".").contains("cannot read"), "{}", path("."));
    }

    #[test]
    fn what_is_no_kbl_is_refused_and_modules_are_those_of_the_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let starter = starter(folder.path());
        let file = |text: &str| ImportFile::Text { name: "small.kbl".into(), text: text.into() };
        for text in ["", "schema = 1", "<a/>", "<a>"] {
            let no = starter.contents(&file(text)).expect_err("no KBL");
            assert!(no.message.starts_with("small.kbl cannot be imported"), "{no:?}");
        }
        let small = include_str!("../../../../import/tests/small.kbl");
        assert_eq!(starter.contents(&file(small)).expect("KBL").modules, []);
        let open = |spacing| {
            let (file, arrangement) = (file(small), Arranged::Installed);
            starter.open(Opening::Kbl { file, modules: None, spacing, arrangement })
        };
        assert!(open(Some(0.01)).is_ok() && open(Some(-1.0)).is_err() && open(Some(f64::NAN)).is_err());
    }
}
