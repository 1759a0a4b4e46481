//! Catches panics: none leaves the plugin.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::Once;
use wireloom_abi::{STATUS_ERROR, STATUS_OK, STATUS_PANIC, Text};

thread_local! {
    /// Message and location of the current panic of this thread.
    static MESSAGE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Installs a panic hook that stores the message instead of printing it; the program reports it. The hook belongs to
/// this library's own copy of the standard library.
pub fn install_hook() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        set_hook(Box::new(|panic| {
            let text = panic.payload_as_str().unwrap_or("a panic without words");
            let place = panic.location().map(|at| format!(" ({}:{})", at.file(), at.line())).unwrap_or_default();
            MESSAGE.with_borrow_mut(|all| *all = format!("{text}{place}"));
        }));
    });
}

/// Runs `work`; returns its status, and writes the reason of a failure to `message`.
///
/// # Safety
/// `message` is null, or a valid text buffer.
pub unsafe fn catch_panics(message: *mut Text, work: impl FnOnce() -> Result<(), String>) -> i32 {
    let (status, text) = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(())) => return STATUS_OK,
        Ok(Err(text)) => (STATUS_ERROR, text),
        Err(payload) => {
            // Dropping it could panic again.
            std::mem::forget(payload);
            (STATUS_PANIC, MESSAGE.take())
        }
    };
    // SAFETY: as the caller promises.
    unsafe { write(message, &text) };
    status
}

/// Writes as many whole characters as fit, and a terminating zero.
///
/// # Safety
/// As for [`catch_panics`].
unsafe fn write(message: *mut Text, content: &str) {
    // SAFETY: null, or as the caller promises.
    let Some(text) = (unsafe { message.as_ref() }) else { return };
    let Some(limit) = text.capacity.checked_sub(1).filter(|_| !text.data.is_null()) else { return };
    let content = content.split('\0').next().unwrap_or_default();
    let length = content.floor_char_boundary(limit);
    // SAFETY: `length < capacity` bytes fit, and the zero after them.
    unsafe {
        std::ptr::copy_nonoverlapping(content.as_ptr(), text.data.cast(), length);
        text.data.add(length).write(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(capacity: usize, work: impl FnOnce() -> Result<(), String>) -> (i32, Vec<u8>) {
        let mut buffer = vec![7_u8; 16];
        let mut text = Text { data: buffer.as_mut_ptr().cast(), capacity };
        // SAFETY: the buffer is as large as every capacity used here.
        let status = unsafe { catch_panics(&mut text, work) };
        (status, buffer)
    }

    #[test]
    fn a_message_fits_its_room_and_ends() {
        let (status, buffer) = written(6, || Err("größer".into()));
        assert_eq!((status, &buffer[..6]), (STATUS_ERROR, "grö\0\x07".as_bytes()));
        let (status, buffer) = written(0, || Err("words".into()));
        assert_eq!((status, buffer[0]), (STATUS_ERROR, 7));
        assert_eq!(written(16, || Ok(())), (STATUS_OK, vec![7; 16]));
    }

    #[test]
    fn a_panic_is_a_status() {
        assert_eq!(written(16, || panic!("no")).0, STATUS_PANIC);
    }
}
