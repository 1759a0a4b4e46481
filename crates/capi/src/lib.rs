//! The C library `libwireloom`: Wireloom for programs in C, C++ and what can call C. The header is
//! `include/wireloom.h`, made of this crate; `README.md` says how to build and use it.
//!
//! | file | contents |
//! | --- | --- |
//! | `call` | the frame of every function: errors out, no panic out |
//! | `failure` | codes and failures |
//! | `pointers` | pointers of the caller, checked before use |
//! | `handles` | the table of handles |
//! | `words`, `text` | texts that C reads, for as long as a handle lives |
//! | `worker` | computing threads |
//! | `scenario`, `files`, `check` | scenarios, the files they name, their diagnostics |
//! | `cancel`, `run` | runs, their progress and their end |
//! | `result` | arrays of results |
//! | `session` | a harness that is moved by hand |
//! | `sensitivities` | derivatives |

#![expect(unsafe_code, reason = "functions of C have unmangled names, and take pointers")]

// The header follows this order.
mod call;
mod failure;
mod handles;
mod pointers;
mod text;
mod words;
mod worker;

mod files;
mod scenario;

mod check;

mod cancel;
mod run;

mod result;

mod session;

mod sensitivities;

use std::ffi::c_char;

/// Version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
