//! The folder of a run's results. Files appear in it whole or not at all, and those of an earlier run are removed
//! before a new one begins: `.wireloom/files` lists them. One process at a time writes in it.

use crate::failure::Failure;
use crate::files::own::{ANEW, OWN, Own, damaged};
use crate::files::place::{Pending, Place, Writer};
use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wireloom::export::catalogue;

/// Parent of the folders of results that the user has not named.
const OUT: &str = "out";
const LIST: &str = "files";
/// Locked by the process that writes in the folder; the system unlocks it when the process ends.
const LOCK: &str = "lock";
/// Size of a trial file before the work begins, bytes.
const TRIAL: usize = 1 << 16;
/// Help where the list of files is damaged.
const HELP: &str = "remove the folder, or give another one with --out";

/// A folder that this process alone writes to.
pub struct Folder {
    path: PathBuf,
    place: Place,
    own: Arc<Own>,
    written: Written,
    list: File,
    _lock: File,
}

/// Files that were written: names in the folder, and SHA-256 in hexadecimal digits.
pub type Written = BTreeMap<String, String>;

impl Folder {
    /// The folder for the results of a scenario's file: the one that the user has named, or `out/first` for
    /// `scenarios/first.toml`.
    pub fn of_results(named: Option<&Path>, file: &Path) -> Result<Self, Failure> {
        match named {
            Some(path) => Self::create(path),
            None => Self::create_default(OUT, &file.file_stem().unwrap_or_default().to_string_lossy()),
        }
    }

    /// Makes the folder that the user has named, where it is missing, and makes sure that files can be written in it.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let opened = fs::create_dir_all(path).and_then(|()| Place::open(path));
        Self::of(opened.map_err(Failure::io("make the folder", path))?, path)
    }

    /// The same in `parent/name` of the current folder, which the user has not named: links are not followed.
    pub fn create_default(parent: &str, name: &str) -> Result<Self, Failure> {
        let path = Path::new(parent).join(name);
        let opened = Place::open(Path::new("")).and_then(|here| here.make(parent)?.make(name));
        Self::of(opened.map_err(Failure::io("make the folder", &path))?, &path)
    }

    fn of(place: Place, path: &Path) -> Result<Self, Failure> {
        let failed = || Failure::io("write in the folder", path);
        let folders: Vec<&str> = [OWN].into_iter().chain(catalogue::folders()).collect();
        if let Some(link) = place.link(&folders).map_err(failed())? {
            let reason =
                format!("`{link}` in it is a link, which may lead anywhere: remove it, or give another folder");
            return Err(failed()(io::Error::new(ErrorKind::InvalidInput, reason)));
        }
        let own = Own::make(&place, path).map_err(failed())?;
        let lock = own.place().lock_file(LOCK).map_err(failed())?;
        lock.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => {
                let reason = "another process is writing its results there: \
                              wait until it has ended, or give another folder with --out";
                failed()(io::Error::new(ErrorKind::ResourceBusy, reason))
            }
            TryLockError::Error(error) => Failure::io("lock the folder", path)(error),
        })?;
        own.place().remove_partials(None).map_err(failed())?;
        let trial = own.place().write("trial", own.place(), |out| out.write_all(&[0; TRIAL]));
        trial.and_then(|_| own.place().remove("trial")).map_err(failed())?;
        let written = written(&own)?;
        let list = new_list(&own, &written)?;
        Ok(Self { path: path.to_path_buf(), place, own: Arc::new(own), written, list, _lock: lock })
    }

    /// Checks that this number of bytes fits on the disk, as far as the system tells.
    pub fn has_room(&self, bytes: u64) -> Result<(), Failure> {
        match fs4::available_space(&self.path) {
            Ok(free) if free < bytes => {
                let short = format!("the results take at least {} MB, {} MB are free", bytes >> 20, free >> 20);
                Err(Failure::io("write in the folder", &self.path)(io::Error::new(ErrorKind::StorageFull, short)))
            }
            // Where the system does not tell, the work begins.
            _ => Ok(()),
        }
    }

    /// Removes the files of an earlier run, so that they are not taken for this one's.
    pub fn clear(&mut self) -> Result<(), Failure> {
        for name in std::mem::take(&mut self.written).keys() {
            self.place.remove(name).map_err(Failure::io("remove", &self.path.join(name)))?;
        }
        self.list = new_list(&self.own, &Written::new())?;
        Ok(())
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The program's own folder in it.
    pub fn own(&self) -> &Arc<Own> {
        &self.own
    }

    /// Names of the files written.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.written.keys().map(String::as_str)
    }

    /// Checks that a file is unchanged since it was written.
    pub fn check(&self, name: &str) -> Result<(), Failure> {
        let path = self.path.join(name);
        let now =
            self.place.bytes(name).map_err(Failure::io("read", &path))?.map(|bytes| wireloom::export::sha256(&bytes));
        match (now, self.written.get(name)) {
            (Some(now), Some(then)) if now == *then => Ok(()),
            _ => Err(damaged(&path, ANEW)),
        }
    }

    /// Writes a file (`name` may lead into folders below): under another name first, renamed when it is complete.
    pub fn write(&mut self, name: &str, content: impl FnOnce(&mut Writer) -> io::Result<()>) -> Result<(), Failure> {
        let path = self.path.join(name);
        let Self { place, own, written, list, .. } = self;
        // A partial file that a kill leaves lies where the next run removes it.
        let attempt = place.write(name, own.place(), |out| {
            content(out)?;
            let hash = out.hash();
            if written.get(name) != Some(&hash) {
                append(list, name, &hash)?;
                written.insert(name.to_owned(), hash);
            }
            Ok(())
        });
        attempt.map(|_| ()).map_err(Failure::io("write", &path))
    }
}

/// Writes a file that the user has named: under another name first, renamed when it is complete.
pub fn write(path: &Path, content: impl FnOnce(&mut Writer) -> io::Result<()>) -> Result<(), Failure> {
    let (pending, mut writer) = begin(path)?;
    let written = content(&mut writer).and_then(|()| pending.finish(writer));
    written.map(|_| ()).map_err(Failure::io("write", path))
}

/// Begins a file that the user has named; it goes unless [`Pending::finish`] gives it that name.
pub fn begin(path: &Path) -> Result<(Pending, Writer), Failure> {
    let attempt = || {
        let folder = path.parent().unwrap_or(Path::new(""));
        let no_name = || io::Error::new(ErrorKind::InvalidInput, "it does not end with the name of a file, in UTF-8");
        let name = path.file_name().and_then(OsStr::to_str).ok_or_else(no_name)?;
        fs::create_dir_all(folder)?;
        let place = Place::open(folder)?;
        // An earlier attempt's remains do no harm if they stay.
        let _ = place.remove_partials(Some(name));
        place.begin(name, &place)
    };
    attempt().map_err(Failure::io("write", path))
}

/// Adds a line to the list: all of it or nothing.
fn append(list: &mut File, name: &str, hash: &str) -> io::Result<()> {
    let before = list.stream_position()?;
    list.write_all(line(name, hash).as_bytes()).inspect_err(|_| {
        let _ = list.set_len(before).and_then(|()| list.seek(SeekFrom::Start(before)));
    })
}

/// Checksum of the file, its name, checksum of the line.
fn line(name: &str, hash: &str) -> String {
    let line = format!("{hash} {name}");
    format!("{line}\t{}\n", wireloom::export::sha256(line.as_bytes()))
}

/// Starts a new list.
fn new_list(own: &Own, written: &Written) -> Result<File, Failure> {
    let lines: String = written.iter().map(|(name, hash)| line(name, hash)).collect();
    let list = own.place().write(LIST, own.place(), |out| out.write_all(lines.as_bytes()));
    list.map_err(Failure::io("write", &own.path(LIST)))
}

/// Files of a folder, by its list. Of a file that was written more than once, the last line counts.
pub fn written(own: &Own) -> Result<Written, Failure> {
    let bytes = own.place().bytes(LIST).map_err(Failure::io("read", &own.path(LIST)))?.unwrap_or_default();
    let damaged = || damaged(&own.path(LIST), HELP);
    let text = String::from_utf8(bytes).map_err(|_| damaged())?;
    let mut all = Written::new();
    for own_line in text.split_inclusive('\n') {
        let (hash, rest) = own_line.split_once(' ').ok_or_else(damaged)?;
        let (name, _) = rest.split_once('\t').ok_or_else(damaged)?;
        if line(name, hash) != own_line {
            return Err(damaged());
        }
        all.insert(name.to_owned(), hash.to_owned());
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(path: &Path) -> Folder {
        Folder::create(path).expect("a folder to write in")
    }

    fn names(path: &Path) -> Vec<String> {
        let entries = fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").file_name());
        let mut names: Vec<String> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_that_fails_leaves_nothing() {
        let place = tempfile::tempdir().expect("a folder");
        let mut folder = made(&place.path().join("a/b"));
        folder.write("x/y.txt", |file| file.write_all(b"whole")).expect("written");
        let failed = folder.write("x/y.txt", |file| file.write_all(b"half").and(Err(io::Error::other("no"))));
        assert!(failed.is_err());
        assert_eq!(names(folder.path()), [OWN, "x"]);
        assert_eq!(names(&folder.path().join("x")), ["y.txt"]);
        assert_eq!(names(&folder.path().join(OWN)), [LIST, LOCK]);
        assert_eq!(fs::read_to_string(folder.path().join("x/y.txt")).unwrap(), "whole");
    }

    #[test]
    fn what_finds_no_room_is_said_before_the_work() {
        let place = tempfile::tempdir().expect("a folder");
        let folder = made(place.path());
        assert!(folder.has_room(1).is_ok());
        let failure = folder.has_room(u64::MAX / 2).expect_err("nobody has so much");
        assert!(failure.to_string().contains("the results take at least"), "{failure}");
    }

    #[test]
    fn what_an_earlier_run_left_goes_and_nothing_else() {
        let place = tempfile::tempdir().expect("a folder");
        let out = place.path().join("out");
        let mut first = made(&out);
        for name in ["result.json", "csv/1/a.csv", "vtk/0001.vtp"] {
            first.write(name, |file| file.write_all(b"old")).expect("written");
        }
        drop(first);
        fs::write(out.join("vtk/mine.txt"), "mine").unwrap();
        let mut second = made(&out);
        second.clear().expect("cleared");
        assert_eq!(second.names().count(), 0);
        assert_eq!((names(&out), names(&out.join("vtk"))), (vec![OWN.into(), "vtk".into()], vec!["mine.txt".into()]));
        drop(second);
        assert_eq!(made(&out).names().count(), 0);
    }

    /// A forged list, with correct checksums.
    #[test]
    fn a_list_that_names_what_lies_elsewhere_removes_nothing() {
        for name in ["../outside", "/outside", "folder/../../outside", "folder"] {
            let place = tempfile::tempdir().expect("a folder");
            fs::write(place.path().join("outside"), "mine").unwrap();
            let out = place.path().join("out");
            drop(made(&out));
            fs::create_dir(out.join("folder")).unwrap();
            fs::write(out.join(OWN).join(LIST), line(name, "0")).unwrap();
            assert!(made(&out).clear().is_err(), "{name}");
            assert!(place.path().join("outside").exists() && out.join("folder").exists(), "{name}");
        }
    }

    #[test]
    fn a_list_with_a_flipped_bit_is_damaged() {
        let place = tempfile::tempdir().expect("a folder");
        let mut folder = made(place.path());
        for name in ["result.json", "vtk/0001.vtp"] {
            folder.write(name, |file| file.write_all(b"old")).expect("written");
        }
        let (list, own) = (place.path().join(OWN).join(LIST), folder.own());
        let bytes = fs::read(&list).unwrap();
        for k in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[k] ^= 1 << (k % 8);
            fs::write(&list, flipped).unwrap();
            let failure = written(own).expect_err("damaged").to_string();
            assert!(failure.contains("files: it is damaged"), "byte {k}: {failure}");
        }
    }

    #[test]
    fn a_list_without_room_for_a_line_keeps_what_it_has() {
        let place = tempfile::tempdir().expect("a folder");
        let path = place.path().join(LIST);
        fs::write(&path, line("a", "0")).unwrap();
        // Not writable: as on a full disk, nothing is added.
        let mut list = File::open(&path).unwrap();
        list.seek(SeekFrom::End(0)).unwrap();
        assert!(append(&mut list, "b", "1").is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), line("a", "0"));
    }
}
