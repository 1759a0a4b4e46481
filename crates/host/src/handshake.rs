//! Opens a library, and looks at its entry before anything in it is called.

use crate::call::into_plugin;
use crate::describe::{self, Described};
use crate::error::Reason;
use crate::read::{self, Message};
use crate::site_of;
use sha2::{Digest, Sha256};
use std::error::Error;
use std::path::Path;
use wireloom_abi::{ABI_MAJOR, ABI_MINOR, Entry, MAGIC};

/// A library that is a plugin.
pub struct Opened {
    pub name: String,
    pub version: String,
    pub doc: String,
    pub hash: String,
    pub abi: (u32, u32),
    pub kinds: Vec<Described>,
}

/// Opens, checks, lists.
pub fn open(file: &Path) -> Result<Opened, Reason> {
    let bytes = std::fs::read(file).map_err(Reason::Unreadable)?;
    let hash = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    // A path without a folder would be looked for elsewhere.
    let file = std::path::absolute(file).map_err(Reason::Unreadable)?;
    let site = site_of(&file);
    // SAFETY: what a library does as it is loaded is its own affair: whoever names it trusts it.
    let library = into_plugin(&site, c"the library's own start", || unsafe { libloading::Library::new(&file) });
    let library = library.map_err(|error| Reason::NotALibrary(words(&error)))?;
    // SAFETY: a symbol of this name is an entry, which begins with its magic; everything else is looked at only after that.
    let entry: *const Entry =
        *unsafe { library.get::<*const Entry>("wireloom_plugin") }.map_err(|_| Reason::NoEntry)?;
    // Objects made by the library may live as long as the process.
    std::mem::forget(library);
    // SAFETY: an entry, as far as can be known.
    let entry = unsafe { check(entry, (ABI_MAJOR, ABI_MINOR)) }?;
    // SAFETY: likewise; versions and sizes fit.
    unsafe {
        let name = read::name("the name of the plugin", entry.name)?;
        let version = read::text("its version", entry.version)?;
        let doc = read::text("its doc", entry.doc)?;
        let kinds =
            entry.kinds.ok_or_else(|| Reason::Pointer { what: "its function `kinds`".into(), value: "null".into() })?;
        let mut message = Message::new();
        let mut text = message.text();
        let list = into_plugin(&site, c"kinds", || kinds(&mut text));
        if list.is_null() {
            return Err(Reason::Kinds(message.words()));
        }
        let kinds = describe::kinds(list)?;
        Ok(Opened { name, version, doc, hash, abi: (entry.abi_major, entry.abi_minor), kinds })
    }
}

/// Whether plugin and program understand each other.
///
/// # Safety
/// `entry` points to an entry, or to something that begins with other bytes than one.
unsafe fn check(entry: *const Entry, program: (u32, u32)) -> Result<Entry, Reason> {
    read::pointer("the symbol `wireloom_plugin`", entry)?;
    // SAFETY: the magic stands first; size and versions stand behind it in every version.
    unsafe {
        let found = (*entry).magic;
        if found != MAGIC {
            return Err(Reason::Magic { found });
        }
        let plugin = ((*entry).abi_major, (*entry).abi_minor);
        if plugin.0 != program.0 || plugin.1 > program.1 {
            return Err(Reason::Version { plugin, program });
        }
        read::prefix("entry", entry, (*entry).size)
    }
}

/// An error and its reasons: the loader's own words stand in the last.
fn words(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut next = error.source();
    while let Some(reason) = next {
        words = reason.to_string();
        next = reason.source();
    }
    words
}
