//! The check of a scenario.

use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode, place};
use crate::pointers::{self, SizedStruct};
use crate::scenario::{WireloomScenario, source};
use crate::words::Words;
use crate::{handles, worker};
use std::ffi::c_char;
use wireloom::scenario::fault::safe;
use wireloom::scenario::{Fault, Places};

/// What the handle is called.
const WHAT: &str = "diagnostics";

/// What a check found.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomDiagnostics {
    /// 0: none.
    pub id: u64,
}

/// Severity of a diagnostic.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireloomSeverity {
    /// The scenario is refused.
    Error = 1,
    /// A remark on a scenario that is not refused.
    Note = 2,
}

/// A diagnostic. Its texts are valid until the diagnostics are freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomDiagnostic {
    /// sizeof(WireloomDiagnostic), set by the caller.
    pub size: usize,
    /// Its severity.
    pub severity: WireloomSeverity,
    /// Line in the scenario's text, from 1; 0: no place.
    pub line: u32,
    /// Column, characters from 1; 0: no place.
    pub column: u32,
    /// What is wrong, with the value.
    pub message: *const c_char,
    /// What would be right; may be empty.
    pub suggestion: *const c_char,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomDiagnostic {}

struct One {
    severity: WireloomSeverity,
    place: (u32, u32),
    message: String,
    suggestion: String,
}

/// What the handle stands for.
struct Kept {
    all: Vec<One>,
    words: Words,
}

/// Checks a scenario: all its faults, or the remarks on one that can be carried out. `count`: their number.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_scenario_check(
    scenario: WireloomScenario,
    diagnostics: *mut WireloomDiagnostics,
    count: *mut usize,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let source = source(scenario)?;
        pointers::place(diagnostics, "diagnostics")?;
        pointers::place(count, "count")?;
        let all = worker::computed(|| {
            let places = Places::of(&source.text);
            Ok(match source.load(&wireloom::registry()) {
                Ok((_, built)) => {
                    let note = |note: String| One {
                        severity: WireloomSeverity::Note,
                        place: (0, 0),
                        message: safe(&note),
                        suggestion: String::new(),
                    };
                    built.notes.into_iter().map(note).collect()
                }
                Err(faults) => {
                    let one = |fault: Fault| One {
                        severity: WireloomSeverity::Error,
                        place: place(&places, &fault),
                        message: safe(&fault.message),
                        suggestion: safe(&fault.help),
                    };
                    faults.into_iter().map(one).collect::<Vec<_>>()
                }
            })
        })?;
        pointers::put(count, "count", all.len())?;
        let id = handles::new(Kept { all, words: Words::default() });
        pointers::put(diagnostics, "diagnostics", WireloomDiagnostics { id })
    })
}

/// One of the diagnostics, from 0.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_diagnostics_get(
    diagnostics: WireloomDiagnostics,
    index: usize,
    diagnostic: *mut WireloomDiagnostic,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = handles::get::<Kept>(diagnostics.id, WHAT)?;
        let Some(One { severity, place: (line, column), message, suggestion }) = kept.all.get(index) else {
            return Err(Failure::no_index("diagnostic", index, kept.all.len()));
        };
        let value = WireloomDiagnostic {
            size: size_of::<WireloomDiagnostic>(),
            severity: *severity,
            line: *line,
            column: *column,
            message: kept.words.of(message),
            suggestion: kept.words.of(suggestion),
        };
        pointers::fill(diagnostic, "diagnostic", value)
    })
}

/// Frees diagnostics.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_diagnostics_free(diagnostics: WireloomDiagnostics) -> WireloomCode {
    call(std::ptr::null_mut(), || handles::free::<Kept>(diagnostics.id, WHAT))
}
