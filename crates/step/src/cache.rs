//! Cache of what was read, by the content of the file: the bytes of it, the deflection and the reader decide the name.

use crate::error::{CACHE, CACHE_AT_HOME, StepError};
use sha2::{Digest, Sha256};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Length of a SHA-256.
const HASH: usize = 32;

/// A folder with what was read. It may be deleted at any time.
#[derive(Clone, Debug)]
pub(crate) struct Cache(pub PathBuf);

impl Cache {
    /// The one that the environment names, or that in the user's home.
    pub fn from_environment() -> Option<Self> {
        let named = std::env::var_os(CACHE).filter(|folder| !folder.is_empty()).map(PathBuf::from);
        named.or_else(|| Some(std::env::home_dir()?.join(CACHE_AT_HOME))).map(Self)
    }

    fn path(&self, key: &str) -> PathBuf {
        self.0.join(format!("{key}.step-triangles"))
    }

    /// What is kept under a key; `None`: nothing, or it is damaged.
    pub fn get(&self, key: &str) -> Result<Option<Vec<u8>>, StepError> {
        let path = self.path(key);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(StepError::Io { what: "read", path, source }),
        };
        let whole = bytes.split_at_checked(HASH).filter(|(hash, content)| Sha256::digest(content)[..] == **hash);
        Ok(whole.map(|(_, content)| content.to_vec()))
    }

    /// Keeps content under a key: under another name first, so that no other process sees a part of it.
    pub fn put(&self, key: &str, content: &[u8]) -> Result<(), StepError> {
        let path = self.path(key);
        let write = || {
            fs::create_dir_all(&self.0)?;
            let mut file = tempfile::NamedTempFile::new_in(&self.0)?;
            file.write_all(&Sha256::digest(content))?;
            file.write_all(content)?;
            file.persist(&path).map(|_| ()).map_err(|error| error.error)
        };
        write().map_err(|source| StepError::Io { what: "write", path: path.clone(), source })
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.0
    }
}

/// Key of what a reader makes of a file.
pub(crate) fn key(reader: &[&str], deflection: f64, bytes: &[u8]) -> String {
    let mut hash = Sha256::new();
    // Lengths first, so that no two inputs run together to the same bytes.
    for part in reader.iter().map(|part| part.as_bytes()).chain([&deflection.to_bits().to_le_bytes()[..], bytes]) {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_key_depends_on_the_file_the_deflection_and_the_reader() {
        let keys = [
            key(&["a", "b"], 0.1, b"file"),
            key(&["ab", ""], 0.1, b"file"),
            key(&["a", "c"], 0.1, b"file"),
            key(&["a", "b"], 0.2, b"file"),
            key(&["a", "b"], 0.1, b"File"),
        ];
        let different: std::collections::BTreeSet<&String> = keys.iter().collect();
        assert_eq!(different.len(), keys.len());
    }

    #[test]
    fn what_is_damaged_is_not_there() {
        let folder = tempfile::tempdir().expect("a folder");
        let cache = Cache(folder.path().join("new"));
        assert!(matches!(cache.get("k"), Ok(None)));
        cache.put("k", b"content").expect("it is written");
        assert_eq!(cache.get("k").expect("it is read").as_deref(), Some(&b"content"[..]));
        let path = cache.path("k");
        let mut bytes = fs::read(&path).expect("a file");
        *bytes.last_mut().expect("a byte") ^= 1;
        fs::write(&path, &bytes).expect("it is written");
        assert!(matches!(cache.get("k"), Ok(None)));
        fs::write(&path, b"short").expect("it is written");
        assert!(matches!(cache.get("k"), Ok(None)));
    }
}
