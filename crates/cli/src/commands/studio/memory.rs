//! State that the studio keeps of a scenario between sessions: its port, so that open pages notice a new session, the
//! unsaved drafts, and when it was opened. One file for each scenario, readable by its user alone, in the folder that
//! the system has for states of programs: `$XDG_STATE_HOME/wireloom` (by default `~/.local/state/wireloom`), on Windows
//! `%LOCALAPPDATA%\wireloom`. The start page has a file for each folder in which it was started, with the drafts of
//! sessions that have no file yet.

use serde::{Deserialize, Serialize};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// The state that is kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Remembered {
    /// The scenario's file, the folder of a finished run, or that of a start page.
    pub scenario: PathBuf,
    /// When it was opened last (RFC 3339).
    #[serde(default)]
    pub opened: Option<String>,
    /// Port of the last session.
    pub port: Option<u16>,
    /// The unsaved draft of the session that has it open, or of the last one.
    pub draft: Option<Draft>,
    /// Those of sessions before it that nobody has restored or discarded, the oldest first.
    #[serde(default)]
    pub earlier: Vec<Draft>,
}

/// Most drafts of earlier sessions that are kept; then the oldest ones go.
const MAX_EARLIER: usize = 50;

impl Remembered {
    /// A session begins, with a text that its user has saved, or whose only copy, `unsaved`, is its own draft from now
    /// on. The draft of the last session stays beside it, unless it is the same text.
    pub fn begin(&mut self, text: &str, unsaved: Option<Draft>) {
        self.set_aside();
        self.earlier.retain(|draft| draft.text != text);
        self.draft = unsaved;
    }

    /// Makes the draft of the last session one of the earlier ones.
    pub fn set_aside(&mut self) {
        let Some(draft) = self.draft.take() else { return };
        self.earlier.retain(|own| own.text != draft.text);
        self.earlier.push(draft);
        let over = self.earlier.len().saturating_sub(MAX_EARLIER);
        self.earlier.drain(..over);
    }
}

/// A draft.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Draft {
    /// Its text.
    pub text: String,
    /// When it was kept.
    pub written: String,
}

/// Names of the files for scenarios and finished runs, and of those for start pages, begin so.
const SCENARIO: &str = "studio-";
const START_PAGE: &str = "start-";
/// Most files that a start page lists.
const MAX_RECENT: usize = 20;

/// A scenario or a finished run that was open.
#[derive(Debug, PartialEq, Deserialize)]
pub struct Recent {
    /// Its file or folder.
    pub scenario: PathBuf,
    /// When it was opened last (RFC 3339); unknown if that was by an earlier version of the program.
    #[serde(default)]
    pub opened: Option<String>,
}

/// Scenarios and finished runs that were open, the newest first.
pub fn recent() -> Vec<Recent> {
    folder().map(|folder| recent_within(&folder)).unwrap_or_default()
}

/// The same in a folder of states.
fn recent_within(folder: &Path) -> Vec<Recent> {
    let files = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let is_state = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with(SCENARIO) && name.ends_with(".json")
    };
    // A file that cannot be parsed counts as missing.
    let read = |path: PathBuf| serde_json::from_slice(&fs::read(path).ok()?).ok();
    let mut all: Vec<Recent> = files.filter(is_state).filter_map(read).collect();
    all.sort_by(|a, b| b.opened.cmp(&a.opened).then_with(|| a.scenario.cmp(&b.scenario)));
    all.truncate(MAX_RECENT);
    all
}

/// The file of one scenario, locked by this process.
pub struct Memory {
    path: PathBuf,
    remembered: Remembered,
    /// Locked as long as it is open.
    _lock: File,
}

impl Memory {
    /// That of the scenario at `path`; `None` where another process has locked it.
    ///
    /// # Errors
    /// Those of the system.
    pub fn of(path: &Path) -> io::Result<Option<Self>> {
        Self::within(&existing_folder()?, path.canonicalize()?)
    }

    /// That of the start page in a folder; `None` where another process has locked it.
    ///
    /// # Errors
    /// Those of the system.
    pub fn of_start_page(folder: &Path) -> io::Result<Option<Self>> {
        Self::named(START_PAGE, &existing_folder()?, folder.canonicalize()?)
    }

    /// That of a scenario, in a folder of states.
    pub(super) fn within(folder: &Path, scenario: PathBuf) -> io::Result<Option<Self>> {
        Self::named(SCENARIO, folder, scenario)
    }

    fn named(prefix: &str, folder: &Path, scenario: PathBuf) -> io::Result<Option<Self>> {
        make_folder(folder)?;
        let hash = wireloom::export::sha256(scenario.as_os_str().as_encoded_bytes());
        let path = folder.join(format!("{prefix}{}.json", &hash[..16]));
        let lock = for_the_user_alone(&path.with_extension("lock"), false)?;
        if lock.try_lock().is_err() {
            return Ok(None);
        }
        // A file that cannot be parsed counts as missing.
        let known = fs::read(&path).ok().and_then(|bytes| serde_json::from_slice::<Remembered>(&bytes).ok());
        let known = known.filter(|known| known.scenario == scenario);
        let remembered = known.unwrap_or(Remembered { scenario, ..Remembered::default() });
        Ok(Some(Self { path, remembered, _lock: lock }))
    }

    /// The state that is kept.
    pub fn remembered(&self) -> &Remembered {
        &self.remembered
    }

    /// Changes the state and writes it.
    ///
    /// # Errors
    /// Those of the system.
    pub fn change(&mut self, change: impl FnOnce(&mut Remembered)) -> io::Result<()> {
        change(&mut self.remembered);
        let text = serde_json::to_vec(&self.remembered)?;
        let partial = self.path.with_extension("partial");
        // A kill may have left one: it is replaced.
        let _ = fs::remove_file(&partial);
        let mut file = for_the_user_alone(&partial, true)?;
        file.write_all(&text)?;
        file.sync_all()?;
        fs::rename(&partial, &self.path)
    }
}

fn existing_folder() -> io::Result<PathBuf> {
    folder().ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "there is no home folder"))
}

/// Folder of states.
fn folder() -> Option<PathBuf> {
    let named = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let of_system = if cfg!(windows) {
        named("LOCALAPPDATA")
    } else {
        named("XDG_STATE_HOME").or_else(|| std::env::home_dir().map(|home| home.join(".local/state")))
    };
    of_system.map(|folder| folder.join("wireloom"))
}

fn make_folder(folder: &Path) -> io::Result<()> {
    let mut builder = fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(folder)
}

/// Opens a file that only its user may read; `new`: it must not exist.
fn for_the_user_alone(path: &Path, new: bool) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).create_new(new).truncate(false);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_process_remembers_a_scenario_and_the_next_one_knows_it() {
        let place = tempfile::tempdir().expect("a folder");
        let open = || Memory::within(place.path(), "/a/b.toml".into()).expect("readable");
        let mut first = open().expect("nobody else has it");
        let draft = Draft { text: "a = 1".repeat(100), written: "now".into() };
        first.change(|known| known.draft = Some(draft)).expect("written");
        first.change(|known| (known.port, known.draft) = (Some(7), None)).expect("written");
        assert!(open().is_none(), "the first has it in its hands");
        let kept = first.remembered().clone();
        drop(first);
        assert_eq!(open().expect("free again").remembered(), &kept);
        let other = Memory::within(place.path(), "/a/c.toml".into()).expect("readable").expect("another scenario");
        assert_eq!(other.remembered().port, None);
        #[cfg(unix)]
        for file in fs::read_dir(place.path()).unwrap() {
            let mode = std::os::unix::fs::PermissionsExt::mode(&file.unwrap().metadata().unwrap().permissions());
            assert_eq!(mode & 0o077, 0, "nobody else may read it");
        }
    }

    /// The draft of a session replaced that of the one before, or was not kept.
    #[test]
    fn every_session_has_a_draft_of_its_own_beside_those_before() {
        let draft = |text: &str| Draft { text: text.to_owned(), written: "now".into() };
        let texts = |known: &Remembered| known.earlier.iter().map(|own| own.text.clone()).collect::<Vec<_>>();
        let mut known = Remembered { draft: Some(draft("first")), ..Remembered::default() };
        known.begin("file", None);
        assert_eq!((texts(&known), &known.draft), (vec!["first".to_owned()], &None));
        known.draft = Some(draft("second"));
        known.begin("file", None);
        known.draft = Some(draft("first"));
        known.begin("file", Some(draft("file")));
        assert_eq!(texts(&known), ["second", "first"], "equal ones once, the newest last");
        known.begin("second", None);
        assert_eq!(texts(&known), ["first", "file"], "what was saved is no draft");
        for k in 0..2 * MAX_EARLIER {
            known.draft = Some(draft(&k.to_string()));
            known.set_aside();
        }
        assert_eq!(known.earlier.len(), MAX_EARLIER);
        let old = r#"{"scenario":"/a.toml","port":7,"draft":{"text":"a","written":"now"}}"#;
        let old: Remembered = serde_json::from_str(old).expect("of an earlier version");
        assert_eq!((old.draft, old.earlier), (Some(draft("a")), Vec::new()));
    }

    #[test]
    fn files_that_were_open_are_listed_with_the_newest_first_and_start_pages_are_not() {
        let place = tempfile::tempdir().expect("a folder");
        for (name, opened) in [("a", Some("2026-01-01T00:00:00Z")), ("b", None), ("c", Some("2026-01-02T00:00:00Z"))] {
            let memory = Memory::within(place.path(), format!("/{name}.toml").into()).expect("readable");
            let opened = opened.map(str::to_owned);
            memory.expect("free").change(|known| known.opened = opened).expect("written");
        }
        let start = Memory::named(START_PAGE, place.path(), "/".into()).expect("readable");
        start.expect("free").change(|known| known.port = Some(7)).expect("written");
        fs::write(place.path().join("studio-0.json"), "half").expect("written");
        let listed = recent_within(place.path());
        let listed: Vec<&str> = listed.iter().filter_map(|recent| recent.scenario.to_str()).collect();
        assert_eq!(listed, ["/c.toml", "/a.toml", "/b.toml"]);
        assert!(recent_within(&place.path().join("none")).is_empty());
    }
}
