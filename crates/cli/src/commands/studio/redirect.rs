//! Opens a secret address in the browser. Every user of a machine can see command lines, so the browser opens a file
//! that only its user can read and that redirects to the address.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::PathBuf;
use tempfile::TempDir;

/// A file that redirects to an address; it is removed when this is dropped.
pub struct Redirect {
    file: PathBuf,
    _folder: TempDir,
}

impl Redirect {
    /// To an address without special characters of HTML.
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

    /// Opens it in the browser.
    ///
    /// # Errors
    /// Where no browser is found.
    pub fn open(&self) -> io::Result<()> {
        open::that_detached(&self.file)
    }
}
