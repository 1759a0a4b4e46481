//! The scenario's file, as the studio writes it: what another program has written there is not replaced unasked.

use crate::failure::Failure;
use crate::files::{folder, load};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use wireloom::session::Refusal;
use wireloom_studio::{Storage, StoreError};

/// Name that is proposed where a name cannot be that of a file.
const DEFAULT_NAME: &str = "harness.toml";
/// Longest name of a file, bytes.
const LONGEST_NAME: usize = 120;

/// Most files of one name with numbers.
const MAX_ALIKE: usize = 1000;

/// The scenario's file.
struct OnDisk {
    path: PathBuf,
    /// Where it lies: the path that the user has named may be a link, which stays one.
    place: PathBuf,
    /// Its text as this program read or wrote it last.
    known: String,
    /// The text of another program that pages have been told of.
    told: Option<String>,
    /// Whether nothing was written yet, and what is there is of others.
    is_new: bool,
}

/// The scenario's file, shared by the sessions of it.
#[derive(Clone)]
pub struct FileStorage(Arc<Mutex<OnDisk>>);

impl FileStorage {
    /// The file at `path`, which holds `text`.
    pub fn new(path: &Path, text: &str) -> Self {
        let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let (path, known) = (path.to_owned(), text.to_owned());
        Self(Arc::new(Mutex::new(OnDisk { path, place, known, told: None, is_new: false })))
    }

    /// A file of a folder that is written when it is stored first, under this name or another one.
    pub fn new_in(folder: &Path, name: &str) -> Self {
        let path = beside(&folder.join(DEFAULT_NAME), name).unwrap_or_else(|_| folder.join(DEFAULT_NAME));
        let place = path.clone();
        Self(Arc::new(Mutex::new(OnDisk { path, place, known: String::new(), told: None, is_new: true })))
    }

    /// Its path, also where it is not written yet.
    pub fn path(&self) -> PathBuf {
        self.disk().path.clone()
    }

    /// Its path, if there is a file.
    pub fn file(&self) -> Option<PathBuf> {
        let disk = self.disk();
        (!disk.is_new).then(|| disk.path.clone())
    }

    /// Name of the file, if another program has changed it since it was read, written or told of.
    pub fn changed_outside(&self) -> Option<String> {
        let mut disk = self.disk();
        if disk.is_new {
            return None;
        }
        let text = load::text(&disk.place).ok()?;
        if text == disk.known {
            disk.told = None;
            return None;
        }
        if disk.told.as_ref() == Some(&text) {
            return None;
        }
        disk.told = Some(text);
        Some(disk.name())
    }

    /// Stores a file that the scenario is to name, in its folder. Returns its name: `panel-2.stl` where there is a
    /// `panel.stl` with other content.
    ///
    /// # Errors
    /// If the scenario has no file yet, the name is none of a file, or the system refuses.
    pub fn store_beside(&self, name: &str, bytes: &[u8]) -> Result<String, Refusal> {
        let path = self.file().ok_or_else(|| no_file_yet("save it first: the file is stored beside it"))?;
        let (stem, ending) = name.rsplit_once('.').unwrap_or((name, ""));
        if !is_plain(name) || stem.is_empty() || ending.is_empty() {
            let help = "give it a name without a folder, with an ending, such as \"panel.stl\"";
            return Err(Refusal::new(format!("{name:?} is no name for a file beside the scenario"), help));
        }
        let names = std::iter::once(name.to_owned()).chain((2..MAX_ALIKE).map(|k| format!("{stem}-{k}.{ending}")));
        for name in names {
            let place = path.with_file_name(&name);
            let there = place.symlink_metadata();
            if there.as_ref().is_ok_and(|there| there.is_file()) && load::bytes(&place).is_ok_and(|own| own == bytes) {
                return Ok(name);
            }
            if there.is_ok() {
                continue;
            }
            let written = folder::write(&place, |out| out.write_all(bytes).and_then(|()| out.sync()));
            let refused = |failure: Failure| Refusal::new(failure.to_string(), "put the file there by hand");
            return written.map(|()| name).map_err(refused);
        }
        Err(Refusal::new(format!("there are too many other files like {name:?}"), "rename it, or remove some of them"))
    }

    fn disk(&self) -> MutexGuard<'_, OnDisk> {
        // No critical section leaves it half changed.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl OnDisk {
    fn name(&self) -> String {
        self.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }

    /// Writes the file as a whole: after a crash it has the old or the new text.
    fn write(&mut self, text: &str) -> Result<String, StoreError> {
        let written = folder::write(&self.place, |out| out.write_all(text.as_bytes()).and_then(|()| out.sync()));
        written.map_err(|failure| {
            let message = failure.to_string();
            StoreError::Refused(Refusal::new(message, "save it under another name, or download a copy"))
        })?;
        self.known = text.to_owned();
        self.told = None;
        Ok(self.name())
    }
}

/// Whether a name is that of a file within a folder, and of one that is listed.
fn is_plain(name: &str) -> bool {
    let within = !name.contains(['/', '\\', ':', '\0']) && !name.starts_with('.');
    within && name.len() <= LONGEST_NAME && name.trim() == name
}

/// The path of another file of the same folder.
fn beside(path: &Path, name: &str) -> Result<PathBuf, Refusal> {
    if !is_plain(name) || name.strip_suffix(".toml").is_none_or(str::is_empty) {
        let message = format!("{name:?} is no name for the file of a scenario");
        return Err(Refusal::new(message, "give a name without a folder that ends in .toml, such as \"harness.toml\""));
    }
    Ok(path.with_file_name(name))
}

fn no_file_yet(help: &str) -> Refusal {
    Refusal::new("this scenario has no file yet", help)
}

impl Storage for FileStorage {
    fn is_new(&self) -> bool {
        self.disk().is_new
    }

    fn store(&mut self, text: &str, name: Option<&str>, replace: bool) -> Result<String, StoreError> {
        let mut disk = self.disk();
        if disk.is_new && name.is_none() {
            return Err(StoreError::Refused(no_file_yet("give it a name")));
        }
        let Some(name) = name.filter(|name| disk.is_new || *name != disk.name()) else {
            let changed = match load::text(&disk.place) {
                Ok(there) => {
                    let changed = there != disk.known && there != text;
                    if changed {
                        // The answer tells it: told once more, the page would put that in place of its question.
                        disk.told = Some(there);
                    }
                    changed
                }
                // It was removed: then it is written anew. What cannot be read is not replaced unasked.
                Err(_) => disk.place.exists(),
            };
            if changed && !replace {
                return Err(StoreError::Changed { name: disk.name() });
            }
            return disk.write(text);
        };
        let path = beside(&disk.path, name).map_err(StoreError::Refused)?;
        if path.exists() && !replace {
            return Err(StoreError::Exists { name: name.to_owned() });
        }
        let mut other = OnDisk { place: path.clone(), path, known: String::new(), told: None, is_new: false };
        let written = other.write(text)?;
        *disk = other;
        Ok(written)
    }

    fn read(&self) -> Result<String, Refusal> {
        let disk = self.disk();
        if disk.is_new {
            return Err(no_file_yet("save it first"));
        }
        let text = load::text(&disk.place);
        text.map_err(|failure| Refusal::new(failure.to_string(), "save the scenario to write it anew"))
    }

    fn taken(&mut self, text: &str) {
        let mut disk = self.disk();
        disk.known = text.to_owned();
        disk.told = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn what_another_program_has_written_is_not_replaced_unasked() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("y.toml");
        let there = |path: &Path| fs::read_to_string(path).expect("a file");
        fs::write(&path, "a = 1").expect("written");
        let mut storage = FileStorage::new(&path, "a = 1");
        assert_eq!(storage.store("a = 2", None, false).as_deref(), Ok("y.toml"));
        assert_eq!((there(&path).as_str(), storage.changed_outside()), ("a = 2", None));
        fs::write(&path, "a = 3").expect("written");
        assert_eq!(storage.changed_outside().as_deref(), Some("y.toml"));
        assert_eq!(storage.changed_outside(), None, "once is enough");
        let conflict = Err(StoreError::Changed { name: "y.toml".to_owned() });
        assert_eq!(storage.store("a = 4", None, false), conflict);
        assert_eq!(there(&path), "a = 3");
        assert_eq!(storage.store("a = 4", None, true).as_deref(), Ok("y.toml"));
        fs::write(&path, "a = 5").expect("written");
        assert_eq!(storage.read().as_deref(), Ok("a = 5"));
        assert_eq!(storage.store("a = 6", None, false), conflict, "it was read, and may have been refused");
        assert_eq!(storage.changed_outside(), None, "the conflict has told it");
        storage.taken("a = 5");
        assert_eq!(storage.store("a = 6", None, false).as_deref(), Ok("y.toml"), "it was taken in between");
        fs::remove_file(&path).expect("removed");
        assert_eq!(storage.store("a = 7", None, false).as_deref(), Ok("y.toml"), "nothing is replaced");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1, "no partial file is left");
    }

    #[test]
    fn another_name_stays_in_the_folder_and_replaces_nothing_unasked() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("y.toml");
        fs::write(&path, "a = 1").expect("written");
        fs::write(folder.path().join("z.toml"), "b = 1").expect("written");
        let mut storage = FileStorage::new(&path, "a = 1");
        for name in
            ["../z.toml", "/etc/z.toml", ".toml", ".z.toml", "z", "z.tom", "c:z.toml", " z.toml", "a\\z.toml", ""]
        {
            let refused = storage.store("a = 2", Some(name), true);
            assert!(matches!(refused, Err(StoreError::Refused(_))), "{name}: {refused:?}");
        }
        let exists = Err(StoreError::Exists { name: "z.toml".to_owned() });
        assert_eq!(storage.store("a = 2", Some("z.toml"), false), exists);
        assert_eq!(storage.store("a = 2", Some("w.toml"), false).as_deref(), Ok("w.toml"));
        assert_eq!(storage.path(), folder.path().join("w.toml"), "it is the file from now on");
        assert_eq!(storage.store("a = 3", None, false).as_deref(), Ok("w.toml"));
        let texts = ["y.toml", "w.toml"].map(|name| fs::read_to_string(folder.path().join(name)).expect("a file"));
        assert_eq!(texts, ["a = 1", "a = 3"]);
    }

    /// A scenario that was dropped on the page would have replaced a file of the same name.
    #[test]
    fn a_scenario_without_a_file_replaces_none_and_has_one_after_it_is_saved() {
        let folder = tempfile::tempdir().expect("a folder");
        let there = folder.path().join("y.toml");
        fs::write(&there, "a = 1").expect("written");
        let mut storage = FileStorage::new_in(folder.path(), "y.toml");
        assert!(storage.is_new() && storage.file().is_none() && storage.changed_outside().is_none());
        assert!(storage.read().is_err() && matches!(storage.store("a = 2", None, true), Err(StoreError::Refused(_))));
        let exists = Err(StoreError::Exists { name: "y.toml".to_owned() });
        assert_eq!(storage.store("a = 2", Some("y.toml"), false), exists);
        assert_eq!(fs::read_to_string(&there).expect("a file"), "a = 1");
        assert_eq!(storage.store("a = 2", Some("z.toml"), false).as_deref(), Ok("z.toml"));
        assert_eq!((storage.is_new(), storage.file()), (false, Some(folder.path().join("z.toml"))));
        assert_eq!(storage.store("a = 3", None, false).as_deref(), Ok("z.toml"));
        for name in ["../y.toml", "y.kbl", "", "a/b.toml"] {
            assert_eq!(FileStorage::new_in(folder.path(), name).path(), folder.path().join(DEFAULT_NAME), "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().expect("a folder");
        let (path, link) = (folder.path().join("y.toml"), folder.path().join("link.toml"));
        fs::write(&path, "a = 1").expect("written");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).expect("set");
        std::os::unix::fs::symlink(&path, &link).expect("a link");
        let mut storage = FileStorage::new(&link, "a = 1");
        assert_eq!(storage.store("a = 2", None, false).as_deref(), Ok("link.toml"));
        assert!(fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!(fs::read_to_string(&path).expect("a file"), "a = 2");
        assert_eq!(fs::metadata(&path).expect("there").permissions().mode() & 0o777, 0o640);
    }

    /// What was read and compared was where the link led then, and what was replaced where it had led before.
    #[cfg(unix)]
    #[test]
    fn a_link_that_is_set_anew_replaces_nothing_unasked() {
        let folder = tempfile::tempdir().expect("a folder");
        let [one, two, link] = ["one.toml", "two.toml", "link.toml"].map(|name| folder.path().join(name));
        fs::write(&one, "a = 1").expect("written");
        fs::write(&two, "a = 2").expect("written");
        std::os::unix::fs::symlink(&one, &link).expect("a link");
        let mut storage = FileStorage::new(&link, "a = 1");
        fs::remove_file(&link).expect("removed");
        std::os::unix::fs::symlink(&two, &link).expect("a link");
        assert_eq!(storage.read().as_deref(), Ok("a = 1"), "the file that is open");
        fs::write(&one, "a = 3").expect("written");
        assert_eq!(storage.store("a = 4", None, false), Err(StoreError::Changed { name: "link.toml".to_owned() }));
        assert_eq!([&one, &two].map(|path| fs::read_to_string(path).expect("a file")), ["a = 3", "a = 2"]);
    }

    #[test]
    fn files_of_obstacles_lie_beside_the_scenario_and_replace_no_others() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join("y.toml");
        fs::write(&path, "a = 1").expect("written");
        let storage = FileStorage::new(&path, "a = 1");
        let store = |name: &str, bytes: &[u8]| storage.store_beside(name, bytes).map_err(|refusal| refusal.message);
        assert_eq!(store("panel.stl", b"one").as_deref(), Ok("panel.stl"));
        assert_eq!(store("panel.stl", b"one").as_deref(), Ok("panel.stl"), "it is there already");
        assert_eq!(store("panel.stl", b"two").as_deref(), Ok("panel-2.stl"));
        assert_eq!(fs::read(place.path().join("panel.stl")).expect("there"), b"one");
        assert_eq!(fs::read(place.path().join("panel-2.stl")).expect("there"), b"two");
        for name in ["", ".stl", "../panel.stl", "a/b.stl", "c:x.stl", "stl", "panel.stl ", &"x".repeat(200)] {
            assert!(store(name, b"x").is_err_and(|said| said.contains("is no name")), "{name}");
        }
        let new = FileStorage::new_in(place.path(), "new.toml");
        assert!(new.store_beside("panel.stl", b"x").is_err_and(|said| said.help.contains("save it first")));
        assert_eq!(fs::read_dir(place.path()).expect("there").count(), 3);
    }

    /// The text went to where a link led, out of the folder.
    #[cfg(unix)]
    #[test]
    fn another_name_that_is_a_link_is_refused() {
        let place = tempfile::tempdir().expect("a folder");
        let (folder, outside) = (place.path().join("inner"), place.path().join("outside.toml"));
        fs::create_dir(&folder).expect("made");
        fs::write(&outside, "mine").expect("written");
        fs::write(folder.join("y.toml"), "a = 1").expect("written");
        std::os::unix::fs::symlink(&outside, folder.join("z.toml")).expect("a link");
        std::os::unix::fs::symlink(&outside, folder.join("y.toml.partial")).expect("a link");
        let mut storage = FileStorage::new(&folder.join("y.toml"), "a = 1");
        let refused = storage.store("a = 2", Some("z.toml"), true);
        assert!(format!("{refused:?}").contains("it is a link"), "{refused:?}");
        assert_eq!(storage.store("a = 2", None, false).as_deref(), Ok("y.toml"), "it is the file still");
        assert_eq!(fs::read_to_string(&outside).expect("there"), "mine");
    }
}
