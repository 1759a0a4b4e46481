//! The folder of a run's results. Files appear in it whole or not at all.

use crate::failure::Failure;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A folder that can be written to.
pub struct Folder {
    path: PathBuf,
    /// Files written, in order, relative to the folder.
    pub written: Vec<String>,
}

impl Folder {
    /// Makes the folder where it is missing, and makes sure that files can be written in it.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        fs::create_dir_all(path).map_err(Failure::io("make the folder", path))?;
        let trial = partial(&path.join("trial"));
        File::create(&trial).and_then(|_| fs::remove_file(&trial)).map_err(Failure::io("write in the folder", path))?;
        Ok(Self { path: path.to_path_buf(), written: vec![] })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file (`name` may lead into folders below): under another name first, renamed when it is complete.
    pub fn write(
        &mut self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let path = self.path.join(name);
        write(&path, content)?;
        self.written.push(name.to_owned());
        Ok(())
    }
}

/// Writes a file under another name first and renames it when it is complete.
pub fn write(path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), Failure> {
    let partial = partial(path);
    let attempt = || {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut file = BufWriter::new(File::create(&partial)?);
        content(&mut file)?;
        file.into_inner().map_err(io::IntoInnerError::into_error)?.flush()?;
        fs::rename(&partial, path)
    };
    attempt().map_err(|error| {
        let _ = fs::remove_file(&partial);
        Failure::io("write", path)(error)
    })
}

/// A name beside `path` that no other process uses.
fn partial(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.partial", std::process::id()));
    path.with_file_name(name)
}

/// A name of the scenario as a name of a file: letters, digits, `-`, `_` and `.`; anything else becomes `_`.
/// Among `taken` it gets a number, also where only the case of letters differs.
pub fn file_name(name: &str, taken: &mut Vec<String>) -> String {
    let mut plain: String =
        name.chars().map(|c| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' }).collect();
    if plain.trim_matches('.').is_empty() {
        plain = format!("_{plain}");
    }
    let mut unique = plain.clone();
    let mut k = 2;
    while taken.contains(&unique.to_lowercase()) {
        unique = format!("{plain}-{k}");
        k += 1;
    }
    taken.push(unique.to_lowercase());
    unique
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn file_names_are_safe_and_differ() {
        let mut taken = vec![];
        let mut name = |text| file_name(text, &mut taken);
        assert_eq!(name("plug B"), "plug_B");
        assert_eq!(name("plug/B"), "plug_B-2");
        assert_eq!(name("PLUG_B"), "PLUG_B-3");
        assert_eq!(name(".."), "_..");
        assert_eq!(name(""), "_");
        assert_eq!(name("Größe-2.5"), "Größe-2.5");
    }

    #[test]
    fn a_file_that_fails_leaves_nothing() {
        let place = tempfile::tempdir().expect("a folder");
        let mut folder = Folder::create(&place.path().join("a/b")).expect("made");
        folder.write("x/y.txt", |file| file.write_all(b"whole")).expect("written");
        let failed = folder.write("x/y.txt", |file| file.write_all(b"half").and(Err(io::Error::other("no"))));
        assert!(failed.is_err());
        let names = |path: &Path| -> Vec<_> { fs::read_dir(path).unwrap().map(|e| e.unwrap().file_name()).collect() };
        assert_eq!(names(folder.path()), ["x"]);
        assert_eq!(names(&folder.path().join("x")), ["y.txt"]);
        assert_eq!(fs::read_to_string(folder.path().join("x/y.txt")).unwrap(), "whole");
    }
}
