//! A folder that was opened once. Names in it lead neither out of it nor through links; files in it appear whole or
//! not at all.

use cap_fs_ext::{DirExt, FollowSymlinks, OpenOptionsFollowExt};
use cap_std::ambient_authority;
use cap_std::fs::{Dir, FileType, OpenOptions};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Component, Path};

/// Ends the name of a file that is not complete yet.
const PARTIAL: &str = ".partial";

/// An opened folder. Names have `/` between their parts, on every system.
pub struct Place(Dir);

impl Place {
    /// The folder at `path`, which the user has named: links on the way to it are followed.
    pub fn open(path: &Path) -> io::Result<Self> {
        let path = if path == Path::new("") { Path::new(".") } else { path };
        Dir::open_ambient_dir(path, ambient_authority()).map(Self)
    }

    /// A folder in this one, made where it is missing.
    pub fn make(&self, name: &str) -> io::Result<Self> {
        part(name)?;
        match self.0.create_dir(name) {
            Err(error) if error.kind() != ErrorKind::AlreadyExists => Err(error),
            _ => self.below(name),
        }
    }

    /// A folder in this one.
    pub fn below(&self, name: &str) -> io::Result<Self> {
        part(name)?;
        refuse_link(self.0.symlink_metadata(name)?.file_type())?;
        // If it becomes a link after that, the system refuses it.
        self.0.open_dir_nofollow(name).map(Self)
    }

    /// The folder that a file is in, and the file's name there; `make`: folders on the way that are missing.
    fn holder<'a>(&self, name: &'a str, make: bool) -> io::Result<(Self, &'a str)> {
        let mut holder = Self(self.0.try_clone()?);
        let mut rest = name;
        while let Some((folder, more)) = rest.split_once('/') {
            holder = if make { holder.make(folder)? } else { holder.below(folder)? };
            rest = more;
        }
        part(rest)?;
        Ok((holder, rest))
    }

    /// Opens a plain file to read it.
    pub fn file(&self, name: &str) -> io::Result<File> {
        let (holder, name) = self.holder(name, false)?;
        refuse_all_but_files(holder.0.symlink_metadata(name)?.file_type())?;
        let mut options = OpenOptions::new();
        options.read(true).follow(FollowSymlinks::No);
        Ok(holder.0.open_with(name, &options)?.into_std())
    }

    /// Opens a plain file for the process to lock, made where it is missing.
    pub fn lock_file(&self, name: &str) -> io::Result<File> {
        part(name)?;
        match self.0.symlink_metadata(name) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            Err(_) => {}
            Ok(there) => refuse_all_but_files(there.file_type())?,
        }
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).follow(FollowSymlinks::No);
        Ok(self.0.open_with(name, &options)?.into_std())
    }

    /// The bytes of a plain file; `None` where there is none.
    pub fn bytes(&self, name: &str) -> io::Result<Option<Vec<u8>>> {
        let mut bytes = vec![];
        match self.file(name) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            file => file?.read_to_end(&mut bytes).map(|_| Some(bytes)),
        }
    }

    /// Whether a file or folder of this name exists.
    pub fn has(&self, name: &str) -> bool {
        self.holder(name, false).is_ok_and(|(holder, name)| holder.0.symlink_metadata(name).is_ok())
    }

    /// Writes a file under a random name in `partials` first, and renames it when it is complete. A file that it
    /// replaces leaves it its permissions. Returns the file, still open.
    pub fn write(
        &self,
        name: &str,
        partials: &Self,
        content: impl FnOnce(&mut Writer) -> io::Result<()>,
    ) -> io::Result<File> {
        let (pending, mut writer) = self.begin(name, partials)?;
        content(&mut writer)?;
        pending.finish(writer)
    }

    /// Begins such a file; it goes unless [`Pending::finish`] renames it.
    pub fn begin(&self, name: &str, partials: &Self) -> io::Result<(Pending, Writer)> {
        let (holder, name) = self.holder(name, true)?;
        let replaced = match holder.0.symlink_metadata(name) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            Err(_) => None,
            Ok(there) => {
                refuse_all_but_files(there.file_type())?;
                Some(there.permissions())
            }
        };
        let partials = Self(partials.0.try_clone()?);
        let partial = format!(".{name}.{:016x}{PARTIAL}", fastrand::u64(..));
        let mut options = OpenOptions::new();
        options.write(true).create_new(true).follow(FollowSymlinks::No);
        let file = partials.0.open_with(&partial, &options)?;
        let pending = Pending { holder, name: name.to_owned(), partials, partial: Some(partial) };
        if let Some(permissions) = replaced {
            file.set_permissions(permissions)?;
        }
        let file = file.into_std();
        // Shows that it is being written; where files cannot be locked, partial files are never removed.
        let _ = file.lock();
        let writer = Writer { out: BufWriter::new(file), hash: Sha256::new() };
        Ok((pending, writer))
    }

    /// Removes a plain file, if it is there, and the folders on the way to it that this leaves empty.
    pub fn remove(&self, name: &str) -> io::Result<()> {
        let attempt = || {
            let (holder, file) = self.holder(name, false)?;
            refuse_all_but_files(holder.0.symlink_metadata(file)?.file_type())?;
            holder.0.remove_file(file)
        };
        match attempt() {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let mut folder = name;
        while let Some((above, _)) = folder.rsplit_once('/') {
            folder = above;
            let Ok((holder, last)) = self.holder(folder, false) else { continue };
            if holder.0.remove_dir(last).is_err() {
                break;
            }
        }
        Ok(())
    }

    /// Removes a folder of plain files, if it is there.
    pub fn remove_folder(&self, name: &str) -> io::Result<()> {
        let folder = match self.below(name) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            folder => folder?,
        };
        for file in folder.names()? {
            folder.remove(&file)?;
        }
        self.0.remove_dir(name)
    }

    /// Removes partial files of writers that were killed: of all files, or of the one of this name. Files that are
    /// being written stay.
    pub fn remove_partials(&self, of: Option<&str>) -> io::Result<()> {
        for name in self.names()? {
            let target = name.strip_prefix('.').and_then(|name| name.strip_suffix(PARTIAL)).and_then(|name| {
                let (target, number) = name.rsplit_once('.')?;
                number.bytes().all(|digit| digit.is_ascii_hexdigit()).then_some(target)
            });
            if target.is_none_or(|target| of.is_some_and(|of| of != target)) {
                continue;
            }
            if self.file(&name).is_ok_and(|file| file.try_lock().is_ok()) {
                self.remove(&name)?;
            }
        }
        Ok(())
    }

    /// Names in the folder, as far as they are UTF-8, as all names of this program are.
    fn names(&self) -> io::Result<Vec<String>> {
        let names = self.0.entries()?.map(|entry| Ok(entry?.file_name().into_string().ok()));
        names.filter_map(io::Result::transpose).collect()
    }

    /// The first link in this folder, in those of these names in it, and below them; its name.
    pub fn link(&self, folders: &[&str]) -> io::Result<Option<String>> {
        let mut below = vec![];
        for entry in self.0.entries()? {
            let entry = entry?;
            let (kind, name) = (entry.file_type()?, entry.file_name().to_string_lossy().into_owned());
            if kind.is_symlink() {
                return Ok(Some(name));
            }
            if kind.is_dir() && (folders.is_empty() || folders.contains(&name.as_str())) {
                below.push(name);
            }
        }
        for name in below {
            if let Some(link) = self.below(&name)?.link(&[])? {
                return Ok(Some(format!("{name}/{link}")));
            }
        }
        Ok(None)
    }
}

/// Refuses a part of a name that leads out of the folder.
fn part(name: &str) -> io::Result<()> {
    let mut parts = Path::new(name).components();
    match (parts.next(), parts.next()) {
        (Some(Component::Normal(only)), None) if only == name => Ok(()),
        _ => Err(io::Error::new(ErrorKind::InvalidInput, format!("`{name}` is no name of a file in a folder"))),
    }
}

fn refuse_link(kind: FileType) -> io::Result<()> {
    if kind.is_symlink() {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is a link, and this program follows none here"));
    }
    Ok(())
}

fn refuse_all_but_files(kind: FileType) -> io::Result<()> {
    refuse_link(kind)?;
    if kind.is_file() {
        return Ok(());
    }
    let what = if kind.is_dir() { "a folder" } else { "a device, a pipe or a socket" };
    Err(io::Error::new(ErrorKind::InvalidInput, format!("it is {what}, not a plain file")))
}

/// A file under a temporary name, which is removed when this is dropped.
pub struct Pending {
    holder: Place,
    name: String,
    partials: Place,
    partial: Option<String>,
}

impl Pending {
    /// Gives a complete file its name. Returns it, still open.
    pub fn finish(mut self, writer: Writer) -> io::Result<File> {
        let file = writer.out.into_inner().map_err(io::IntoInnerError::into_error)?;
        if let Some(partial) = &self.partial {
            self.partials.0.rename(partial, &self.holder.0, &self.name)?;
        }
        self.partial = None;
        Ok(file)
    }
}

impl Drop for Pending {
    fn drop(&mut self) {
        if let Some(partial) = &self.partial {
            let _ = self.partials.0.remove_file(partial);
        }
    }
}

/// A file that is being written.
pub struct Writer {
    out: BufWriter<File>,
    hash: Sha256,
}

impl Writer {
    /// Writes everything so far to the disk.
    pub fn sync(&mut self) -> io::Result<()> {
        self.out.flush()?;
        self.out.get_ref().sync_all()
    }

    /// SHA-256 of everything so far, in hexadecimal digits.
    pub fn hash(&self) -> String {
        format!("{:x}", self.hash.clone().finalize())
    }
}

impl Write for Writer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
