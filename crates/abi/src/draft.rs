//! Extensions that may still change: no promise is made about them. Their ids say `draft`; a draft that becomes part of the
//! promise gets another id.

use crate::Text;
use core::ffi::{c_char, c_void};

/// Id of [`Notes`].
pub const EXTENSION_NOTES: &core::ffi::CStr = c"wireloom.draft.notes/1";

/// What an engineer should know about an instance: that a strap hangs loose as it is put on, say.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Notes {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Writes the note of this index, from 0, of an instance of the kind; an error where there is none.
    pub note:
        Option<unsafe extern "C" fn(kind: *const c_char, instance: *const c_void, index: u32, note: *mut Text) -> i32>,
}

// SAFETY: an extension is never written to.
unsafe impl Sync for Notes {}
