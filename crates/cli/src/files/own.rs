//! The program's own folder `.wireloom` in a folder of results. Every part ends with a checksum of its bytes and its
//! name, so that damaged or foreign files are found.

use crate::failure::Failure;
use crate::files::place::Place;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Its name in the folder.
pub const OWN: &str = ".wireloom";
/// Help where a part of an interrupted run is damaged.
pub const ANEW: &str = "run the scenario anew";
/// Digits of a SHA-256, in hexadecimal.
const DIGITS: usize = 64;

/// The opened folder.
pub struct Own {
    place: Place,
    path: PathBuf,
}

impl Own {
    /// That of the folder at `path`, which is opened as `results`; made where it is missing.
    pub fn make(results: &Place, path: &Path) -> io::Result<Self> {
        Ok(Self { place: results.make(OWN)?, path: path.join(OWN) })
    }

    /// That of the folder at `path`, to read in it.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let attempt = || Place::open(path)?.below(OWN);
        let path = path.join(OWN);
        let place = attempt().map_err(Failure::io("read", &path))?;
        Ok(Self { place, path })
    }

    /// The opened folder itself.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Path of a part, for messages.
    pub fn path(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Writes a part; `safe`: on the disk when this returns.
    pub fn keep(&self, name: &str, bytes: &[u8], safe: bool) -> Result<(), Failure> {
        let sum = checksum(bytes, name);
        let kept = self.place.write(name, &self.place, |out| {
            out.write_all(bytes)?;
            out.write_all(sum.as_bytes())?;
            if safe { out.sync() } else { Ok(()) }
        });
        kept.map(|_| ()).map_err(Failure::io("write", &self.path(name)))
    }

    /// Makes sure that a part is safe on the disk.
    pub fn make_safe(&self, name: &str) -> Result<(), Failure> {
        self.place.file(name).and_then(|file| file.sync_all()).map_err(Failure::io("write", &self.path(name)))
    }

    /// A part as it was kept; `None` where there is none.
    ///
    /// # Errors
    /// A part that cannot be read, or is damaged; `help`: what to do about it.
    pub fn part(&self, name: &str, help: &str) -> Result<Option<Vec<u8>>, Failure> {
        let Some(mut bytes) = self.place.bytes(name).map_err(Failure::io("read", &self.path(name)))? else {
            return Ok(None);
        };
        let sum = bytes.split_off(bytes.len().saturating_sub(DIGITS));
        if sum != checksum(&bytes, name).as_bytes() {
            return Err(damaged(&self.path(name), help));
        }
        Ok(Some(bytes))
    }

    /// Removes parts, and folders of parts.
    pub fn remove(&self, parts: &[&str], folders: &[&str]) -> Result<(), Failure> {
        for name in parts {
            self.place.remove(name).map_err(Failure::io("remove", &self.path(name)))?;
        }
        for name in folders {
            self.place.remove_folder(name).map_err(Failure::io("remove", &self.path(name)))?;
        }
        Ok(())
    }
}

/// A file that has changed since it was written; `help`: what to do about it.
pub fn damaged(path: &Path, help: &str) -> Failure {
    let reason = format!("it is damaged: its checksum has changed since it was written; {help}");
    Failure::io("use", path)(io::Error::new(ErrorKind::InvalidData, reason))
}

/// Checksum of a part and its name, so that parts cannot be exchanged.
fn checksum(bytes: &[u8], name: &str) -> String {
    wireloom::export::sha256(&[bytes, name.as_bytes()].concat())
}
