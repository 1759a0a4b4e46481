//! Extensions that may still change and have no compatibility guarantee. Their ids contain `draft`; a draft that
//! becomes stable gets another id.

use crate::Text;
use core::ffi::{c_char, c_void};

/// Id of [`Notes`].
pub const EXTENSION_NOTES: &core::ffi::CStr = c"wireloom.draft.notes/1";

/// Notes for the engineer on an instance: for example, that a strap is slack when it is added.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Notes {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Writes note number `index`, from 0, of an instance of the kind; an error if there is none.
    pub note:
        Option<unsafe extern "C" fn(kind: *const c_char, instance: *const c_void, index: u32, note: *mut Text) -> i32>,
}

// SAFETY: an extension is never written to.
unsafe impl Sync for Notes {}
