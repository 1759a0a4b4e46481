//! Files that the texts of a session may name. Its first text comes from the user's file and may name any; texts that
//! pages send may name those, and files within the scenario's folder.

use super::storage::FileStorage;
use crate::files::load::Beside;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use wireloom::scenario::Files;
use wireloom_studio::SessionFiles;

/// Files of a session; clones share what is known.
#[derive(Clone)]
pub struct Fence {
    beside: Arc<Beside>,
    /// The scenario's file.
    path: PathBuf,
    named: Arc<Mutex<Named>>,
}

/// Files that were named so far.
#[derive(Default)]
struct Named {
    paths: BTreeSet<String>,
    /// Whether further ones must lie within the folder.
    closed: bool,
}

impl Fence {
    /// The files of the scenario at `path`, all of them until the fence is closed.
    pub fn of(path: &Path) -> Self {
        Self { beside: Arc::new(Beside::of(path)), path: path.to_owned(), named: Arc::default() }
    }

    /// From now on only files that are known, or lie within the folder.
    pub fn close(&self) {
        self.named().closed = true;
    }

    fn named(&self) -> MutexGuard<'_, Named> {
        // No critical section leaves it half changed.
        self.named.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn pass(&self, path: &str) -> Result<(), String> {
        let mut named = self.named();
        if !named.closed {
            named.paths.insert(path.to_owned());
            return Ok(());
        }
        if named.paths.contains(path) || self.is_within(path) {
            return Ok(());
        }
        Err("it is not in the scenario's folder; name it in the file and start `wireloom studio` anew".to_owned())
    }

    /// Whether a path leads to a file within the folder, links followed, or to none.
    fn is_within(&self, path: &str) -> bool {
        let plain = Path::new(path).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let inside = || match (folder.join(path).canonicalize(), folder.canonicalize()) {
            (Ok(file), Ok(folder)) => file.starts_with(folder),
            // There is no such file: what reads it says so.
            (Err(_), _) => true,
            (_, Err(_)) => false,
        };
        plain && inside()
    }
}

impl Files for Fence {
    fn read(&self, path: &str) -> Result<String, String> {
        self.pass(path)?;
        self.beside.read(path)
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.pass(path)?;
        self.beside.bytes(path)
    }
}

impl SessionFiles for Fence {
    fn anew(&self) -> Arc<dyn SessionFiles> {
        Arc::new(Self { beside: Arc::new(Beside::of(&self.path)), ..self.clone() })
    }
}

/// Files of a scenario that is opened from no file: none, and those of its folder once it is saved.
pub struct OnceSaved {
    storage: FileStorage,
    fence: OnceLock<Fence>,
}

impl OnceSaved {
    /// Those of the scenario that is saved there.
    pub fn of(storage: FileStorage) -> Self {
        Self { storage, fence: OnceLock::new() }
    }

    fn fence(&self) -> Result<&Fence, String> {
        if let Some(fence) = self.fence.get() {
            return Ok(fence);
        }
        let file = self.storage.file().ok_or(
            "this scenario is not saved yet, so no files are found beside it; save it first or, if it is a file \
             already, open it by its path",
        )?;
        Ok(self.fence.get_or_init(|| {
            let fence = Fence::of(&file);
            fence.close();
            fence
        }))
    }
}

impl Files for OnceSaved {
    fn read(&self, path: &str) -> Result<String, String> {
        self.fence()?.read(path)
    }

    fn bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.fence()?.bytes(path)
    }
}

impl SessionFiles for OnceSaved {
    fn anew(&self) -> Arc<dyn SessionFiles> {
        Arc::new(Self::of(self.storage.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use wireloom_studio::Storage;

    /// What had been read once stayed for the whole session.
    #[test]
    fn files_that_are_read_anew_are_as_they_are_now() {
        let place = tempfile::tempdir().expect("a folder");
        let file = place.path().join("more.toml");
        fs::write(&file, "old").expect("written");
        let fence = Fence::of(&place.path().join("y.toml"));
        assert_eq!(fence.read("more.toml").as_deref(), Ok("old"));
        fence.close();
        fs::write(&file, "new").expect("written");
        assert_eq!(fence.read("more.toml").as_deref(), Ok("old"), "a run has one text of it");
        let anew = fence.anew();
        assert_eq!(anew.read("more.toml").as_deref(), Ok("new"));
        assert!(anew.read("../more.toml").is_err_and(|said| said.contains("scenario's folder")));
    }

    #[test]
    fn texts_of_pages_name_files_of_the_folder_and_those_that_the_file_has_named() {
        let place = tempfile::tempdir().expect("a folder");
        let inner = place.path().join("inner");
        fs::create_dir(&inner).expect("made");
        for (name, text) in [("out.toml", "o"), ("secret.toml", "s"), ("inner/in.toml", "i"), ("inner/y.toml", "y")] {
            fs::write(place.path().join(name), text).expect("written");
        }
        let fence = Fence::of(&inner.join("y.toml"));
        assert_eq!(fence.read("../out.toml").as_deref(), Ok("o"), "the user's own file names it");
        fence.close();
        assert_eq!(fence.read("../out.toml").as_deref(), Ok("o"));
        assert_eq!(fence.read("in.toml").as_deref(), Ok("i"));
        let secret = place.path().join("secret.toml");
        for path in ["../secret.toml", "./../secret.toml", "in/../../secret.toml", secret.to_str().expect("UTF-8")] {
            assert!(fence.read(path).is_err_and(|said| said.contains("scenario's folder")), "{path}");
            assert!(fence.bytes(path).is_err(), "{path}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(&secret, inner.join("link.toml")).expect("a link");
            assert!(fence.read("link.toml").is_err_and(|said| said.contains("scenario's folder")));
        }
        assert!(fence.read("none.toml").is_err_and(|said| !said.contains("scenario's folder")));
    }

    /// They were refused with "open it by its path", which a session cannot do.
    #[test]
    fn a_scenario_without_a_file_has_the_files_beside_it_once_it_is_saved() {
        let place = tempfile::tempdir().expect("a folder");
        let inner = place.path().join("inner");
        fs::create_dir(&inner).expect("made");
        for (name, text) in [("secret.toml", "s"), ("inner/box.stl", "old")] {
            fs::write(place.path().join(name), text).expect("written");
        }
        let mut storage = FileStorage::new_in(&inner, "y.toml");
        let files = OnceSaved::of(storage.clone());
        assert!(files.bytes("box.stl").is_err_and(|said| said.contains("save it first")));
        assert_eq!(storage.store("a = 1", Some("mine.toml"), false).as_deref(), Ok("mine.toml"));
        assert_eq!(files.bytes("box.stl").as_deref(), Ok(b"old".as_slice()));
        assert_eq!(files.read("mine.toml").as_deref(), Ok("a = 1"));
        assert!(files.read("../secret.toml").is_err_and(|said| said.contains("scenario's folder")));
        assert_eq!(storage.store("a = 2", None, false).as_deref(), Ok("mine.toml"));
        assert_eq!(files.read("mine.toml").as_deref(), Ok("a = 1"), "a run has one text of it");
        assert_eq!(files.anew().read("mine.toml").as_deref(), Ok("a = 2"));
    }
}
