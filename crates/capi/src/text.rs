//! Texts, and the bytes of files, that the library hands over.

use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode};
use crate::{handles, pointers};
use std::ffi::c_char;

/// What the handle is called.
const WHAT: &str = "text";

/// A text, or the bytes of a file.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomText {
    /// 0: none.
    pub id: u64,
}

/// What the handle stands for: the bytes with a 0 at their end.
struct Kept(Vec<u8>);

/// Hands a text over to the caller.
pub fn hand_over(mut text: Vec<u8>, place: *mut WireloomText) -> Result<(), Failure> {
    text.push(0);
    pointers::put(place, "text", WireloomText { id: handles::new(Kept(text)) })
}

/// The bytes with a 0 after the last one, valid until it is freed, and their number without that 0. A text is UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_text_get(
    text: WireloomText,
    bytes: *mut *const c_char,
    length: *mut usize,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = handles::get::<Kept>(text.id, WHAT)?;
        pointers::place(bytes, "bytes")?;
        pointers::put(length, "length", kept.0.len() - 1)?;
        pointers::put(bytes, "bytes", kept.0.as_ptr().cast())
    })
}

/// Frees a text.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_text_free(text: WireloomText) -> WireloomCode {
    call(std::ptr::null_mut(), || handles::free::<Kept>(text.id, WHAT))
}
