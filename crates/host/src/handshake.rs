//! Opens a private copy of a library and checks its entry before any of its functions is called.

use crate::call::{CallSite, call_plugin};
use crate::describe::{self, KindDescription};
use crate::error::Reason;
use crate::image;
use crate::read::{self, Message};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use wireloom_abi::draft::{EXTENSION_NOTES, Notes};
use wireloom_abi::{ABI_MAJOR, ABI_MINOR, Entry, MAGIC};

/// A library that has been checked to be a plugin.
pub struct Opened {
    pub name: String,
    pub version: String,
    pub doc: String,
    pub hash: String,
    pub abi: (u32, u32),
    pub kinds: Vec<KindDescription>,
    pub notes: Option<Notes>,
}

/// Opens a library, checks its entry and lists its kinds.
pub fn open(file: &Path) -> Result<Opened, Reason> {
    let (copy, hash) = image::copy(file)?;
    let file = std::path::absolute(file).map_err(Reason::Unreadable)?;
    let site = CallSite::new(&format!("plugin {}", file.display()));
    // SAFETY: a library runs code of its own while it is loaded; the user who names it trusts it.
    let library = call_plugin(&site, c"initialisation of the library", || unsafe { libloading::Library::new(&copy) });
    // The user knows the file by its own name.
    let names = [copy.display().to_string(), file.display().to_string()];
    let library = library.map_err(|error| Reason::NotALibrary(words(&error).replace(&names[0], &names[1])))?;
    // SAFETY: a symbol of this name is an entry and begins with its magic; nothing else is read before that is checked.
    let entry: *const Entry =
        *unsafe { library.get::<*const Entry>("wireloom_plugin") }.map_err(|_| Reason::NoEntry)?;
    // The library is never unloaded: its objects may live as long as the process.
    std::mem::forget(library);
    // SAFETY: the symbol is an entry, as far as can be checked.
    let entry = unsafe { check(entry, (ABI_MAJOR, ABI_MINOR)) }?;
    // SAFETY: as above; versions and sizes match.
    unsafe {
        let name = read::name("the name of the plugin", entry.name)?;
        let version = read::text("its version", entry.version)?;
        let doc = read::text("its doc", entry.doc)?;
        let kinds =
            entry.kinds.ok_or_else(|| Reason::Pointer { what: "its function `kinds`".into(), value: "null".into() })?;
        let mut message = Message::new();
        let mut text = message.text();
        let list = call_plugin(&site, c"kinds", || kinds(&mut text));
        if list.is_null() {
            return Err(Reason::Kinds(message.words()));
        }
        let kinds = describe::kinds(list)?;
        let notes = notes(&entry, &site)?;
        Ok(Opened { name, version, doc, hash, abi: (entry.abi_major, entry.abi_minor), kinds, notes })
    }
}

/// The extension `Notes`, if the plugin has it.
///
/// # Safety
/// `entry` is the checked entry of a plugin.
unsafe fn notes(entry: &Entry, site: &Arc<CallSite>) -> Result<Option<Notes>, Reason> {
    let Some(get) = entry.get_extension else { return Ok(None) };
    // SAFETY: as the caller promises; an extension of this id has this type, and its size is its first field.
    unsafe {
        let found: *const Notes = call_plugin(site, c"get_extension", || get(EXTENSION_NOTES.as_ptr())).cast();
        if found.is_null() {
            return Ok(None);
        }
        let what = format!("extension `{}`", EXTENSION_NOTES.to_string_lossy());
        read::pointer(&format!("its {what}"), found)?;
        read::read_struct(&what, found, (*found).size).map(Some)
    }
}

/// Checks magic, version and size of an entry.
///
/// # Safety
/// `entry` points to an entry, or to something that begins with other bytes than an entry.
unsafe fn check(entry: *const Entry, program: (u32, u32)) -> Result<Entry, Reason> {
    read::pointer("the symbol `wireloom_plugin`", entry)?;
    // SAFETY: the magic comes first; size and versions follow it in every version of the ABI.
    unsafe {
        let found = (*entry).magic;
        if found != MAGIC {
            return Err(Reason::Magic { found });
        }
        let plugin = ((*entry).abi_major, (*entry).abi_minor);
        if plugin.0 != program.0 || plugin.1 > program.1 {
            return Err(Reason::Version { plugin, program });
        }
        read::read_struct("entry", entry, (*entry).size)
    }
}

/// The innermost cause of an error: the message of the system's loader.
fn words(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut next = error.source();
    while let Some(reason) = next {
        words = reason.to_string();
        next = reason.source();
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ptr::null;

    const ENTRY: Entry = Entry {
        magic: MAGIC,
        size: size_of::<Entry>() as u32,
        abi_major: 1,
        abi_minor: 0,
        reserved: 0,
        name: c"old".as_ptr(),
        version: null(),
        doc: null(),
        kinds: None,
        get_extension: None,
    };

    fn checked(entry: &Entry, program: (u32, u32)) -> Result<Entry, Reason> {
        // SAFETY: it is an entry.
        unsafe { check(entry, program) }
    }

    #[test]
    fn a_plugin_of_an_earlier_minor_version_is_taken_and_one_of_a_later_is_not() {
        assert!(checked(&ENTRY, (1, 0)).is_ok_and(|entry| entry.name == ENTRY.name));
        assert!(checked(&ENTRY, (1, 7)).is_ok());
        for (plugin, program) in [((1, 8), (1, 7)), ((2, 0), (1, 7)), ((1, 7), (2, 0))] {
            let entry = Entry { abi_major: plugin.0, abi_minor: plugin.1, ..ENTRY };
            let refused = checked(&entry, program).expect_err("it does not fit");
            let versions = [format!("ABI {}.{}", plugin.0, plugin.1), format!("ABI {}.{}", program.0, program.1)];
            assert!(versions.iter().all(|words| refused.to_string().contains(words)), "{refused}");
        }
    }

    #[test]
    fn what_an_earlier_version_did_not_have_is_zero() {
        /// The table of functions in a later version, with one more function.
        #[repr(C)]
        #[derive(Clone, Copy)]
        struct NewerTable {
            known: wireloom_abi::ConstraintKind,
            more: Option<extern "C" fn()>,
        }
        // SAFETY: integers and functions that may be absent.
        unsafe impl read::Extensible for NewerTable {
            const MIN_SIZE: usize = <wireloom_abi::ConstraintKind as read::Extensible>::MIN_SIZE;
        }
        extern "C" fn never() {}
        // SAFETY: zeroes are valid.
        let mut here: NewerTable = unsafe { std::mem::zeroed() };
        here.known.stations_max = 3;
        // Bytes behind an older, shorter struct must not be read as a function.
        here.more = Some(never);
        for (size, more) in [(size_of::<wireloom_abi::ConstraintKind>(), false), (size_of::<NewerTable>(), true)] {
            // SAFETY: the struct has that many bytes.
            let read = unsafe { read::read_struct("table", &raw const here, size as u32) }.expect("long enough");
            assert_eq!((read.known.stations_max, read.more.is_some()), (3, more));
        }
        // SAFETY: as above.
        assert!(unsafe { read::read_struct("table", &raw const here, 40) }.is_err());
    }
}
