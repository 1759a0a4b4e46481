//! The folder of a run's results. Files appear in it whole or not at all, and those of an earlier run go before a new one begins:
//! `.wireloom/files` lists what was written.

use crate::failure::Failure;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Component, Path, PathBuf};

/// What the program keeps in the folder for itself.
pub const OWN: &str = ".wireloom";
const LIST: &str = "files";
/// The system must find room for so much before the work begins, bytes.
const TRIAL: usize = 1 << 16;

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
        let attempt = File::create(&trial).and_then(|mut file| {
            file.write_all(&[0; TRIAL])?;
            file.sync_all()
        });
        let removed = fs::remove_file(&trial);
        attempt.and(removed).map_err(Failure::io("write in the folder", path))?;
        Ok(Self { path: path.to_path_buf(), written: written(path)? })
    }

    /// Makes sure that so many bytes find room on the disk, as far as the system tells.
    pub fn has_room(&self, bytes: u64) -> Result<(), Failure> {
        match fs4::available_space(&self.path) {
            Ok(free) if free < bytes => {
                let short = format!("the results take at least {} MB, {} MB are free", bytes >> 20, free >> 20);
                Err(Failure::io("write in the folder", &self.path)(io::Error::new(io::ErrorKind::StorageFull, short)))
            }
            // Where the system does not tell, the work is begun.
            _ => Ok(()),
        }
    }

    /// Removes what an earlier run has written, so that nobody takes it for this one's.
    pub fn clear(&mut self) -> Result<(), Failure> {
        for name in std::mem::take(&mut self.written) {
            let path = self.path.join(&name);
            match fs::remove_file(&path) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(Failure::io("remove", &path)(error));
                }
                _ => {}
            }
            // A folder that this leaves empty goes, too.
            for folder in Path::new(&name).ancestors().skip(1).filter(|folder| *folder != Path::new("")) {
                let _ = fs::remove_dir(self.path.join(folder));
            }
        }
        write(&self.path.join(OWN).join(LIST), |_| Ok(()))
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
        if !self.written.iter().any(|written| written == name) {
            let list = self.path.join(OWN).join(LIST);
            let mut open =
                OpenOptions::new().create(true).append(true).open(&list).map_err(Failure::io("write", &list))?;
            writeln!(open, "{name}").map_err(Failure::io("write", &list))?;
            self.written.push(name.to_owned());
        }
        // What a kill leaves half written lies where the run cleans up when it is done.
        let own = self.path.join(OWN).join(path.file_name().unwrap_or_default());
        write_by(&partial(&own), &path, content)
    }
}

/// What was written in a folder: names of files below it.
pub fn written(folder: &Path) -> Result<Vec<String>, Failure> {
    let list = folder.join(OWN).join(LIST);
    let names = match fs::read_to_string(&list) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
        other => other.map_err(Failure::io("read", &list))?,
    };
    // Only names that this program gives; the list may have been edited.
    let inside = |name: &&str| Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
    Ok(names.lines().filter(inside).map(str::to_owned).collect())
}

/// Writes a file under another name first and renames it when it is complete.
pub fn write(path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> Result<(), Failure> {
    write_by(&partial(path), path, content)
}

/// The same by a given name on the same disk.
fn write_by(
    partial: &Path,
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), Failure> {
    let attempt = || {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let mut file = BufWriter::new(File::create(partial)?);
        content(&mut file)?;
        file.into_inner().map_err(io::IntoInnerError::into_error)?.flush()?;
        fs::rename(partial, path)
    };
    attempt().map_err(|error| {
        let _ = fs::remove_file(partial);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_fails_leaves_nothing() {
        let place = tempfile::tempdir().expect("a folder");
        let mut folder = Folder::create(&place.path().join("a/b")).expect("made");
        folder.clear().expect("nothing to clear");
        folder.write("x/y.txt", |file| file.write_all(b"whole")).expect("written");
        let failed = folder.write("x/y.txt", |file| file.write_all(b"half").and(Err(io::Error::other("no"))));
        assert!(failed.is_err());
        let names = |path: &Path| -> Vec<_> { fs::read_dir(path).unwrap().map(|e| e.unwrap().file_name()).collect() };
        let mut top = names(folder.path());
        top.sort();
        assert_eq!(top, [OWN, "x"]);
        assert_eq!(names(&folder.path().join("x")), ["y.txt"]);
        assert_eq!(fs::read_to_string(folder.path().join("x/y.txt")).unwrap(), "whole");
    }

    #[test]
    fn what_finds_no_room_is_said_before_the_work() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = Folder::create(place.path()).expect("there");
        assert!(folder.has_room(1).is_ok());
        let failure = folder.has_room(u64::MAX / 2).expect_err("nobody has so much");
        assert!(failure.to_string().contains("the results take at least"), "{failure}");
    }

    #[test]
    fn what_an_earlier_run_left_goes_and_nothing_else() {
        let place = tempfile::tempdir().expect("a folder");
        let out = place.path().join("out");
        let mut first = Folder::create(&out).expect("made");
        first.clear().expect("nothing to clear");
        for name in ["result.json", "csv/1/a.csv", "vtk/0001.vtp"] {
            first.write(name, |file| file.write_all(b"old")).expect("written");
        }
        fs::write(out.join("vtk/mine.txt"), "mine").unwrap();
        fs::write(place.path().join("outside"), "mine").unwrap();
        let list = out.join(OWN).join(LIST);
        fs::write(&list, fs::read_to_string(&list).unwrap() + "../outside\n").unwrap();
        let mut second = Folder::create(&out).expect("there");
        second.clear().expect("cleared");
        assert!(second.written.is_empty());
        assert!(!out.join("result.json").exists() && !out.join("csv").exists() && !out.join("vtk/0001.vtp").exists());
        assert!(out.join("vtk/mine.txt").exists() && place.path().join("outside").exists());
    }
}
