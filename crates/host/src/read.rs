//! Reads structs and texts of a plugin, and checks whatever can be checked.

use crate::error::Reason;
use std::ffi::{CStr, c_char};

/// Longest text, bytes. A text without a terminating zero before that is invalid.
const LONGEST: usize = 4096;

/// Upper limit for the size of a struct of any version, bytes.
const LARGEST: u32 = 65536;

/// A C struct to which later versions append fields; all-zero bytes are a valid value.
///
/// # Safety
/// All-zero bytes are valid for the whole struct and for any of its last fields.
pub unsafe trait Extensible: Copy {
    /// Its size in ABI 1.0, bytes.
    const MIN_SIZE: usize;
}

macro_rules! extensible {
    ($($name:ty: $least:expr),+ $(,)?) => {$(
        // SAFETY: integers, pointers and optional functions.
        unsafe impl Extensible for $name {
            const MIN_SIZE: usize = if cfg!(target_pointer_width = "64") { $least } else { size_of::<$name>() };
        }
    )+};
}

// Sizes in ABI 1.0, or in the first version that has them, for pointers of eight bytes. Appending a field must not
// change them.
extensible! {
    wireloom_abi::Entry: 64,
    wireloom_abi::Kinds: 24,
    wireloom_abi::Kind: 48,
    wireloom_abi::Parameter: 88,
    wireloom_abi::ConstraintKind: 56,
    wireloom_abi::Output: 24,
    wireloom_abi::JointKind: 32,
    wireloom_abi::RodKind: 40,
    wireloom_abi::draft::Notes: 16,
}

/// Refuses null, misaligned and very small pointers.
pub fn pointer<T>(what: &str, pointer: *const T) -> Result<(), Reason> {
    let value = if pointer.is_null() {
        "null".to_owned()
    } else if !pointer.is_aligned() || (pointer as usize) < 4096 {
        format!("{pointer:p}, which is not a valid address")
    } else {
        return Ok(());
    };
    Err(Reason::Pointer { what: what.to_owned(), value })
}

/// Reads the struct at `from`, whose stated size is `size`; missing fields at the end are zero.
///
/// # Safety
/// `from` is null, or points to `size` bytes.
pub unsafe fn read_struct<T: Extensible>(what: &str, from: *const T, size: u32) -> Result<T, Reason> {
    pointer(what, from)?;
    if (size as usize) < T::MIN_SIZE {
        return Err(Reason::TooSmall { what: what.to_owned(), size, least: T::MIN_SIZE as u32 });
    }
    if size > LARGEST {
        return Err(Reason::Value {
            what: format!("the size of its {what}"),
            value: size.to_string(),
            right: format!("no struct has more than {LARGEST} bytes"),
        });
    }
    let mut whole = std::mem::MaybeUninit::<T>::zeroed();
    // SAFETY: `size` bytes are readable as the caller promises, at most the size of `whole` is written, and zeros are
    // valid.
    unsafe {
        std::ptr::copy_nonoverlapping(from.cast::<u8>(), whole.as_mut_ptr().cast(), size_of::<T>().min(size as usize));
        Ok(whole.assume_init())
    }
}

/// Reads an array of structs with the given count and stride.
///
/// # Safety
/// `first` is null, or points to `count * stride` bytes.
pub unsafe fn array<T: Extensible>(
    what: &str,
    first: *const T,
    count: u32,
    stride: u32,
    most: u32,
) -> Result<Vec<T>, Reason> {
    if count == 0 {
        return Ok(vec![]);
    }
    if count > most {
        return Err(Reason::Value {
            what: format!("its number of {what}"),
            value: count.to_string(),
            right: format!("at most {most} are allowed"),
        });
    }
    pointer(&format!("its array of {what}"), first)?;
    let one = |k: u32| {
        // SAFETY: as the caller promises.
        unsafe { read_struct(&format!("array of {what}"), first.byte_add(k as usize * stride as usize), stride) }
    };
    (0..count).map(one).collect()
}

/// Reads a zero-terminated UTF-8 text.
///
/// # Safety
/// `text` is null, or readable up to a zero byte or for [`LONGEST`] bytes.
pub unsafe fn text(what: &str, text: *const c_char) -> Result<String, Reason> {
    pointer(what, text)?;
    let wrong = |problem: &str| Reason::Text { what: what.to_owned(), problem: problem.to_owned() };
    // SAFETY: as the caller promises.
    let length = (0..LONGEST).find(|at| unsafe { text.add(*at).read() } == 0);
    let length = length.ok_or_else(|| wrong("has no end: its zero byte is missing"))?;
    // SAFETY: that many bytes were just read.
    let bytes = unsafe { std::slice::from_raw_parts(text.cast::<u8>(), length) };
    let words = std::str::from_utf8(bytes).map_err(|_| wrong("is not UTF-8"))?;
    Ok(words.to_owned())
}

/// Reads a name: letters, digits, hyphens and underscores.
///
/// # Safety
/// As for [`text`].
pub unsafe fn name(what: &str, words: *const c_char) -> Result<String, Reason> {
    // SAFETY: as the caller promises.
    let name = unsafe { text(what, words) }?;
    let problem = if name.is_empty() {
        "is empty".to_owned()
    } else if name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_') {
        return Ok(name);
    } else {
        format!("is {name:?}: names have letters, digits, `-` and `_`")
    };
    Err(Reason::Text { what: what.to_owned(), problem })
}

/// Buffer for a message that a plugin writes, with a guard behind it.
#[repr(C)]
pub struct Message {
    buffer: [u8; 512],
    behind: [u8; 64],
}

/// What stands behind the buffer as long as nobody writes there.
const UNTOUCHED: u8 = 0xa5;

impl Message {
    pub fn new() -> Self {
        Self { buffer: [0; 512], behind: [UNTOUCHED; 64] }
    }

    /// Whether something was written behind the buffer.
    pub fn is_overrun(&self) -> bool {
        self.buffer[511] != 0 || self.behind != [UNTOUCHED; 64]
    }

    /// The buffer as C sees it.
    pub fn text(&mut self) -> wireloom_abi::Text {
        // The last byte always remains zero.
        wireloom_abi::Text { data: (&raw mut *self).cast(), capacity: self.buffer.len() - 1 }
    }

    /// The text that was written.
    pub fn words(&self) -> String {
        let words = CStr::from_bytes_until_nul(&self.buffer).unwrap_or_default().to_string_lossy();
        if words.is_empty() { "no message".to_owned() } else { words.into_owned() }
    }
}
