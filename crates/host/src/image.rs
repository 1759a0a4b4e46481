//! Private copies of libraries. The bytes that are hashed are those that run: whatever happens to the file after it was
//! read, the loader does not see it.

use crate::error::Reason;
use crate::find::open_regular_file;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Largest library that is read, bytes: far above the size of any real one.
const LARGEST: u64 = 1 << 30;

/// The copies of this process, by the SHA-256 of their bytes: a library that is loaded again is the same one.
static COPIES: Mutex<BTreeMap<String, PathBuf>> = Mutex::new(BTreeMap::new());

/// Path of a private copy of a library, which stays as long as the process, and the SHA-256 of its bytes, hexadecimal.
pub fn copy(file: &Path) -> Result<(PathBuf, String), Reason> {
    let mut bytes = vec![];
    open_regular_file(file, LARGEST)
        .and_then(|file| file.take(LARGEST).read_to_end(&mut bytes))
        .map_err(Reason::Unreadable)?;
    let hash = format!("{:x}", Sha256::digest(&bytes));
    let mut copies = COPIES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(path) = copies.get(&hash) {
        return Ok((path.clone(), hash));
    }
    let path = store(&bytes).map_err(Reason::NoCopy)?;
    copies.insert(hash.clone(), path.clone());
    Ok((path, hash))
}

/// Stores the bytes in memory that nobody can change any more.
#[cfg(target_os = "linux")]
fn store(bytes: &[u8]) -> io::Result<PathBuf> {
    use std::io::Write;
    use std::os::fd::{AsRawFd, FromRawFd};
    // SAFETY: the name is a string, and the flags are known; a descriptor that is returned belongs to nobody else.
    let mut file = unsafe {
        match libc::memfd_create(c"wireloom-plugin".as_ptr(), libc::MFD_CLOEXEC | libc::MFD_ALLOW_SEALING) {
            -1 => return Err(io::Error::last_os_error()),
            descriptor => File::from_raw_fd(descriptor),
        }
    };
    file.write_all(bytes)?;
    let seals = libc::F_SEAL_SHRINK | libc::F_SEAL_GROW | libc::F_SEAL_WRITE | libc::F_SEAL_SEAL;
    // SAFETY: the descriptor is open, and the command takes an integer.
    if unsafe { libc::fcntl(file.as_raw_fd(), libc::F_ADD_SEALS, seals) } == -1 {
        return Err(io::Error::last_os_error());
    }
    let path = PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()));
    // It stays open: the loader knows a library by this path.
    std::mem::forget(file);
    Ok(path)
}

/// Stores the bytes in a file of its own, in the folder for temporary files.
#[cfg(not(target_os = "linux"))]
fn store(bytes: &[u8]) -> io::Result<PathBuf> {
    use std::io::Write;
    let (folder, process) = (std::env::temp_dir(), std::process::id());
    for number in 0_u32.. {
        let path = folder.join(format!("wireloom-plugin-{process}-{number}{}", std::env::consts::DLL_SUFFIX));
        match File::create_new(&path) {
            Ok(mut file) => return file.write_all(bytes).map(|()| path),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}
