//! The frame of every function of the interface: what failed goes into the caller's error, and no panic gets out.

use crate::failure::{Failure, WireloomCode, caught};
use crate::pointers::{self, SizedStruct};
use std::ffi::c_char;
use wireloom::scenario::fault::safe;

/// What a failed function says: `WireloomError error = {sizeof error};`. Longer texts are cut off. A function that
/// succeeds leaves it as it is.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomError {
    /// sizeof(WireloomError), set by the caller.
    pub size: usize,
    /// The code that the function returned.
    pub code: WireloomCode,
    /// Line in the scenario's text, from 1; 0: no place.
    pub line: u32,
    /// Column, characters from 1; 0: no place.
    pub column: u32,
    /// What is wrong.
    pub message: [c_char; 1024],
    /// What to do about it; may be empty.
    pub suggestion: [c_char; 512],
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomError {}

fn written(failure: &Failure) -> WireloomError {
    let mut error = WireloomError {
        size: size_of::<WireloomError>(),
        code: failure.code,
        line: failure.place.0,
        column: failure.place.1,
        message: [0; 1024],
        suggestion: [0; 512],
    };
    copy(&safe(&failure.message), &mut error.message);
    copy(&safe(&failure.suggestion), &mut error.suggestion);
    error
}

/// As much of a text as fits, with a 0 at the end.
fn copy(text: &str, into: &mut [c_char]) {
    let fits = text.floor_char_boundary(into.len() - 1);
    for (to, from) in into.iter_mut().zip(text[..fits].bytes()) {
        *to = c_char::from_ne_bytes([from]);
    }
}

/// Carries out a function of the interface: no panic leaves it, and `error`, unless it is null, says why it failed.
pub fn call(error: *mut WireloomError, work: impl FnOnce() -> Result<(), Failure>) -> WireloomCode {
    let done = pointers::fillable(error).and_then(|()| caught(work));
    let Err(failure) = done else { return WireloomCode::Ok };
    // An error that cannot be filled is what has failed; then the code alone has to do.
    let _ = caught(|| if error.is_null() { Ok(()) } else { pointers::fill(error, "error", written(&failure)) });
    failure.code
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    #[test]
    fn a_panic_becomes_a_code_and_its_words() {
        let mut error = WireloomError { size: size_of::<WireloomError>(), ..written(&Failure::internal("")) };
        assert_eq!(call(&raw mut error, || panic!("a panic for tests")), WireloomCode::Internal);
        // SAFETY: it has been filled with a text that ends with a 0.
        let message = unsafe { CStr::from_ptr(error.message.as_ptr()) };
        assert_eq!((error.code, message), (WireloomCode::Internal, c"a panic for tests"));
        assert_eq!(call(std::ptr::null_mut(), || panic!("another one")), WireloomCode::Internal);
    }

    #[test]
    fn long_messages_are_cut_off_between_characters() {
        let error = written(&Failure::value("µ".repeat(1000), "µ".repeat(1000)));
        // SAFETY: both are texts that end with a 0.
        let texts = unsafe { [CStr::from_ptr(error.message.as_ptr()), CStr::from_ptr(error.suggestion.as_ptr())] };
        assert_eq!(texts.map(|text| text.to_str().map(str::len)), [Ok(1022), Ok(510)]);
    }
}
