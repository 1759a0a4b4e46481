//! Opens a secret address in the browser. Command lines can be seen by every user of a machine, so the browser is given a file that its user
//! alone can read, and which leads to the address.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::PathBuf;
use tempfile::TempDir;

/// A file that leads to an address; it goes when this is dropped.
pub struct Redirect {
    file: PathBuf,
    _folder: TempDir,
}

impl Redirect {
    /// To an address without characters that mean something in HTML.
    ///
    /// # Errors
    /// Those of the system.
    pub fn to(address: &str) -> io::Result<Self> {
        let mut builder = tempfile::Builder::new();
        builder.prefix("wireloom-");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        let folder = builder.tempdir()?;
        let file = folder.path().join("studio.html");
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let page = format!(
            "<!doctype html><meta charset=\"utf-8\"><meta name=\"referrer\" content=\"no-referrer\">\
             <meta http-equiv=\"refresh\" content=\"0; url={address}\"><title>Wireloom studio</title>\
             <p>Here is the <a href=\"{address}\">studio</a>.\n"
        );
        options.open(&file)?.write_all(page.as_bytes())?;
        Ok(Self { file, _folder: folder })
    }

    /// Has the system open it.
    ///
    /// # Errors
    /// Where there is nothing to open it with.
    pub fn open(&self) -> io::Result<()> {
        open::that_detached(&self.file)
    }
}
