//! Texts that C reads for as long as a handle lives.

use std::collections::HashMap;
use std::ffi::{CString, c_char};
use std::sync::{Mutex, PoisonError};

/// Texts with a 0 at the end; none is dropped before all are.
#[derive(Default)]
pub struct Words(Mutex<HashMap<String, CString>>);

impl Words {
    /// The same text for C.
    pub fn of(&self, text: &str) -> *const c_char {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = all.get(text) {
            return known.as_ptr();
        }
        // A 0 within a name would end it.
        let own = CString::new(text.replace('\0', "\u{fffd}")).unwrap_or_default();
        // Its bytes stay where they are when the table grows.
        all.entry(text.to_owned()).or_insert(own).as_ptr()
    }

    /// The same; null for none.
    pub fn of_option(&self, text: Option<&str>) -> *const c_char {
        text.map_or(std::ptr::null(), |text| self.of(text))
    }
}
