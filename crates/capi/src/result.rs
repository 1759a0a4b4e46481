//! Results: of runs, and of sessions at one moment.

mod branch;
mod kept;
mod parts;
mod sheet;
mod step;

pub use kept::{WireloomResult, hand_over};

use crate::call::{WireloomError, call};
use crate::failure::{Failure, WireloomCode};
use crate::handles;
use crate::pointers::{self, SizedStruct};
use kept::{Kept, WHAT, get};
use std::ffi::c_char;
use wireloom::Status;
use wireloom::result::Verdict;

/// How well the equations of a run, a step or an increment are solved.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireloomStatus {
    /// Forces and moments are in equilibrium.
    Converged = 0,
    /// No further progress is possible in double precision.
    Stalled = 1,
    /// The iteration limit was reached.
    IterationLimit = 2,
    /// No step lowers the energy, numbers are not finite, or a part failed.
    Failed = 3,
    /// It was cancelled.
    Interrupted = 4,
}

/// Whether a requirement, or the whole harness, is acceptable.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireloomVerdict {
    /// Kept in every increment.
    Pass = 0,
    /// Not kept.
    Fail = 1,
    /// It cannot be decided.
    Unresolved = 2,
    /// Nothing was there to check it on.
    NotChecked = 3,
}

/// The status as C has it.
fn status(status: Status) -> WireloomStatus {
    match status {
        Status::Converged => WireloomStatus::Converged,
        Status::Stalled => WireloomStatus::Stalled,
        Status::IterationLimit => WireloomStatus::IterationLimit,
        Status::Failed => WireloomStatus::Failed,
        Status::Interrupted => WireloomStatus::Interrupted,
    }
}

/// The verdict as C has it.
fn verdict(verdict: Verdict) -> WireloomVerdict {
    match verdict {
        Verdict::Pass => WireloomVerdict::Pass,
        Verdict::Fail => WireloomVerdict::Fail,
        Verdict::Unresolved => WireloomVerdict::Unresolved,
        Verdict::NotChecked => WireloomVerdict::NotChecked,
    }
}

/// A result as a whole. Its texts are valid until the result is freed.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomSummary {
    /// sizeof(WireloomSummary), set by the caller.
    pub size: usize,
    /// Name of the scenario.
    pub scenario: *const c_char,
    /// How well its equations are solved.
    pub status: WireloomStatus,
    /// Whether the harness keeps its requirements.
    pub verdict: WireloomVerdict,
    /// What ended the run early: a part that failed; null where none did.
    pub fault: *const c_char,
    /// Equilibria: the last increment of each step, or all of them if `[output] increments = true`. Of a session: one.
    pub step_count: usize,
    /// Events.
    pub event_count: usize,
    /// Requirements.
    pub requirement_count: usize,
    /// Remarks on the harness.
    pub note_count: usize,
}

// SAFETY: it is a struct of C that begins with its size.
unsafe impl SizedStruct for WireloomSummary {}

/// A result as a whole.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_get(
    result: WireloomResult,
    summary: *mut WireloomSummary,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let run = &kept.run;
        let fault = run.fault().map(ToString::to_string);
        let value = WireloomSummary {
            size: size_of::<WireloomSummary>(),
            scenario: kept.words.of(&run.scenario),
            status: status(run.status()),
            verdict: verdict(run.verdict()),
            fault: kept.words.of_option(fault.as_deref()),
            step_count: run.steps.len(),
            event_count: run.events.len(),
            requirement_count: run.requirements.len(),
            note_count: run.notes.len(),
        };
        pointers::fill(summary, "summary", value)
    })
}

/// One of the remarks, from 0; valid until the result is freed.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_note(
    result: WireloomResult,
    index: usize,
    note: *mut *const c_char,
    error: *mut WireloomError,
) -> WireloomCode {
    call(error, || {
        let kept = get(result)?;
        let own = kept.run.notes.get(index).ok_or_else(|| Failure::no_index("note", index, kept.run.notes.len()))?;
        pointers::put(note, "note", kept.words.of(own))
    })
}

/// Frees a result, with all texts and arrays that were read from it.
#[unsafe(no_mangle)]
pub extern "C" fn wireloom_result_free(result: WireloomResult) -> WireloomCode {
    call(std::ptr::null_mut(), || handles::free::<Kept>(result.id, WHAT))
}
