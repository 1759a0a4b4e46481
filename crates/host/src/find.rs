//! Locations of plugins.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::ffi::OsStr;
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Folders whose libraries the user trusts, in order.
#[derive(Clone, Debug, Default)]
pub struct SearchPath(pub Vec<PathBuf>);

impl SearchPath {
    /// Parses a search path in the system's notation.
    pub fn of(path: &OsStr) -> Self {
        Self(std::env::split_paths(path).filter(|folder| !folder.as_os_str().is_empty()).collect())
    }

    /// All libraries in the folders, sorted within each.
    ///
    /// # Errors
    /// The first folder that cannot be read, with the reason.
    pub fn libraries(&self) -> Result<Vec<PathBuf>, (PathBuf, std::io::Error)> {
        let mut all = vec![];
        for folder in &self.0 {
            let entries = std::fs::read_dir(folder).and_then(|entries| entries.collect::<Result<Vec<_>, _>>());
            let entries = entries.map_err(|error| (folder.clone(), error))?;
            let mut here: Vec<PathBuf> =
                entries.into_iter().map(|entry| entry.path()).filter(|path| is_library(path)).collect();
            here.sort();
            all.append(&mut here);
        }
        Ok(all)
    }

    /// The library of the plugin `name`, in the first folder that has one.
    pub fn find(&self, name: &str) -> Option<PathBuf> {
        self.0.iter().find_map(|folder| resolve(&folder.join(name)))
    }

    /// Whether a file lies in one of the folders.
    pub fn contains(&self, file: &Path) -> bool {
        let folder = file.canonicalize().ok().and_then(|file| Some(file.parent()?.to_owned()));
        folder.is_some_and(|folder| self.0.iter().any(|own| own.canonicalize().is_ok_and(|own| own == folder)))
    }
}

fn is_library(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().ends_with(DLL_SUFFIX)) && path.is_file()
}

/// Opens a regular file for reading. A device or a pipe is refused: it may have no end, or block the reader forever.
///
/// # Errors
/// An error of the system; or the file is not regular, or larger than `most` bytes.
pub fn open_regular_file(path: &Path, most: u64) -> std::io::Result<File> {
    // Checked before opening: opening a pipe blocks until another process writes to it.
    let there = std::fs::metadata(path)?;
    let refused = |reason: String| Err(std::io::Error::new(ErrorKind::InvalidInput, reason));
    if there.is_dir() {
        return refused("it is a folder, not a file".to_owned());
    }
    if !there.is_file() {
        return refused("it is a device, a pipe or a socket, not a plain file".to_owned());
    }
    if there.len() > most {
        return refused(format!("it has {} MB, and at most {} MB are read", there.len() >> 20, most >> 20));
    }
    File::open(path)
}

/// File name of a plugin's library as cargo names it on this system: `libcable_tie.so` for `cable-tie`.
pub fn file_name(name: &str) -> String {
    format!("{DLL_PREFIX}{}{DLL_SUFFIX}", name.replace('-', "_"))
}

/// The file itself; or, if the path ends in a plugin's name, the library of that name in its folder.
pub fn resolve(path: &Path) -> Option<PathBuf> {
    if path.is_file() {
        return Some(path.to_owned());
    }
    let name = path.file_name()?.to_string_lossy().into_owned();
    let plain = format!("{name}{DLL_SUFFIX}");
    [file_name(&name), plain].iter().map(|file| path.with_file_name(file)).find(|file| file.is_file())
}
