//! Pointers of the caller: read and written only after what can be checked has been.
//!
//! The rest is what the caller promises by the header: that a pointer which is not null points to what its type says,
//! and that so many values are there as are counted.

use crate::failure::{Failure, WireloomCode};
use std::ffi::{CStr, c_char};

/// A struct of the caller, which the library reads or fills.
///
/// # Safety
/// It is `repr(C)`, and its first member is its size, a `usize` that the caller has set.
pub unsafe trait SizedStruct: Copy {}

fn null(what: &str) -> Failure {
    Failure::new(WireloomCode::NullPointer, format!("`{what}` is null"), "give a pointer")
}

fn check<T>(pointer: *const T, what: &str) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(null(what));
    }
    if !pointer.is_aligned() {
        return Err(Failure::new(WireloomCode::BadSize, format!("`{what}` is not aligned"), "give an aligned pointer"));
    }
    Ok(())
}

/// A text that ends with a 0.
pub fn text<'a>(pointer: *const c_char, what: &str) -> Result<&'a str, Failure> {
    check(pointer, what)?;
    // SAFETY: it is not null, and the caller's texts end with a 0.
    utf8(unsafe { CStr::from_ptr(pointer) }.to_bytes(), what)
}

/// The same, or nothing for a null pointer.
pub fn text_if_given<'a>(pointer: *const c_char, what: &str) -> Result<Option<&'a str>, Failure> {
    if pointer.is_null() { Ok(None) } else { text(pointer, what).map(Some) }
}

/// A text of so many bytes.
pub fn text_of_length<'a>(pointer: *const c_char, length: usize, what: &str) -> Result<&'a str, Failure> {
    utf8(list(pointer.cast::<u8>(), length, what)?, what)
}

/// Bytes as text.
pub fn utf8<'a>(bytes: &'a [u8], what: &str) -> Result<&'a str, Failure> {
    str::from_utf8(bytes).map_err(|error| {
        let message = format!("`{what}` is not UTF-8 (byte {})", error.valid_up_to());
        Failure::new(WireloomCode::NotUtf8, message, "give UTF-8 text")
    })
}

/// So many values; a pointer to none may be null.
pub fn list<'a, T: Copy>(pointer: *const T, count: usize, what: &str) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer, what)?;
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| isize::try_from(bytes).is_err()) {
        return Err(Failure::new(
            WireloomCode::BadSize,
            format!("`{what}`: {count} are too many"),
            "give their number",
        ));
    }
    // SAFETY: it is aligned and not null, the size is that of an object, and the caller says that so many are there.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Texts that end with a 0.
pub fn texts(pointer: *const *const c_char, count: usize, what: &str) -> Result<Vec<String>, Failure> {
    list(pointer, count, what)?.iter().map(|one| Ok(text(*one, what)?.to_owned())).collect()
}

/// Numbers of a vector or a quaternion; nothing for a null pointer.
pub fn numbers_if_given<const N: usize>(pointer: *const f64, what: &str) -> Result<Option<[f64; N]>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    let numbers: [f64; N] = list(pointer, N, what)?.try_into().map_err(|_| null(what))?;
    if numbers.iter().all(|x| x.is_finite()) {
        Ok(Some(numbers))
    } else {
        Err(Failure::value(format!("`{what}` = {numbers:?} is not finite"), "give finite numbers"))
    }
}

/// A struct of the caller; nothing for a null pointer.
pub fn given<T: SizedStruct>(pointer: *const T, what: &str) -> Result<Option<T>, Failure> {
    if pointer.is_null() {
        return Ok(None);
    }
    check_size(pointer, what)?;
    // SAFETY: it is aligned and not null, and its size is what the caller says.
    Ok(Some(unsafe { pointer.read() }))
}

fn check_size<T: SizedStruct>(pointer: *const T, what: &str) -> Result<(), Failure> {
    check(pointer, what)?;
    // SAFETY: it is aligned and not null, and begins with its size.
    let size = unsafe { pointer.cast::<usize>().read() };
    if size == size_of::<T>() {
        return Ok(());
    }
    let message = format!("`{what}`: its member `size` is {size}, not {}", size_of::<T>());
    Err(Failure::new(WireloomCode::BadSize, message, "set `size` to the sizeof of the struct"))
}

/// Refuses an error that cannot be filled; a null pointer is none.
pub fn fillable<T: SizedStruct>(error: *mut T) -> Result<(), Failure> {
    if error.is_null() { Ok(()) } else { check_size(error, "error") }
}

/// Fills a struct of the caller.
pub fn fill<T: SizedStruct>(pointer: *mut T, what: &str, value: T) -> Result<(), Failure> {
    check_size(pointer, what)?;
    // SAFETY: it is aligned and not null, and the caller's struct has the size of this one.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Refuses a place that cannot be written.
pub fn place<T>(pointer: *mut T, what: &str) -> Result<(), Failure> {
    check(pointer, what)
}

/// Writes a value to a place of the caller.
pub fn put<T: Copy>(pointer: *mut T, what: &str, value: T) -> Result<(), Failure> {
    check(pointer, what)?;
    // SAFETY: it is aligned and not null, and is a place of the caller for such a value.
    unsafe { pointer.write(value) };
    Ok(())
}
