//! Failures, and the codes of the interface.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use wireloom::scenario::{Fault, Places};

/// What a function returns. Every value but WIRELOOM_CODE_OK is a failure, which has changed nothing but what the
/// function says.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireloomCode {
    /// Done.
    Ok = 0,
    /// A pointer is null that must not be.
    NullPointer = 1,
    /// The member `size` of a struct, or a count, is wrong; or a pointer is not aligned.
    BadSize = 2,
    /// A handle that was freed, or is one of something else.
    BadHandle = 3,
    /// A text is not UTF-8.
    NotUtf8 = 4,
    /// A name or an index that does not exist.
    NotFound = 5,
    /// An invalid value, such as NaN or a quaternion of zero length.
    BadValue = 6,
    /// The scenario has faults; the error has the first one.
    Refused = 7,
    /// What was asked cannot be done now, such as a motion to where there is no equilibrium.
    Request = 8,
    /// It was cancelled.
    Cancelled = 9,
    /// A part of the harness failed.
    Part = 10,
    /// A question that has no answer, such as derivatives of a run that does not converge.
    NoAnswer = 11,
    /// The session ended by an internal error. Free it.
    Closed = 12,
    /// The system refused something, such as a thread.
    System = 13,
    /// An error of the library, not of its input; please report it.
    Internal = 14,
}

/// Why a function failed.
#[derive(Debug)]
pub struct Failure {
    pub code: WireloomCode,
    /// Line and column in the scenario's text, from 1; (0, 0): none.
    pub place: (u32, u32),
    pub message: String,
    pub suggestion: String,
}

impl Failure {
    pub fn new(code: WireloomCode, message: impl Into<String>, suggestion: impl Into<String>) -> Self {
        Self { code, place: (0, 0), message: message.into(), suggestion: suggestion.into() }
    }

    /// An invalid value.
    pub fn value(message: impl Into<String>, suggestion: impl Into<String>) -> Self {
        Self::new(WireloomCode::BadValue, message, suggestion)
    }

    /// A name or index that does not exist.
    pub fn not_found(message: impl Into<String>, suggestion: impl Into<String>) -> Self {
        Self::new(WireloomCode::NotFound, message, suggestion)
    }

    /// An index that does not exist.
    pub fn no_index(what: &str, index: usize, count: usize) -> Self {
        let help = if count == 0 { "there is none".to_owned() } else { format!("they go from 0 to {}", count - 1) };
        Self::not_found(format!("there is no {what} {index}"), help)
    }

    /// A fault of a text, with this code.
    pub fn of_fault(code: WireloomCode, text: &str, fault: &Fault) -> Self {
        Self { place: place(&Places::of(text), fault), ..Self::new(code, &fault.message, &fault.help) }
    }

    /// The first fault of a scenario.
    pub fn refused(text: &str, faults: &[Fault]) -> Self {
        match faults.first() {
            Some(fault) => Self::of_fault(WireloomCode::Refused, text, fault),
            None => Self::new(WireloomCode::Refused, "the scenario is refused", ""),
        }
    }

    pub fn internal(message: impl Into<String>) -> Self {
        Self::new(WireloomCode::Internal, message, "this is an error of the library; please report it")
    }

    /// Whether it is an error of the library.
    pub fn is_internal(&self) -> bool {
        self.code == WireloomCode::Internal
    }
}

/// Line and column of a fault.
pub fn place(places: &Places<'_>, fault: &Fault) -> (u32, u32) {
    let (line, column) = places.position(fault.span.start);
    (count(line), count(column))
}

/// A number of things as C has it.
pub fn count(n: usize) -> u32 {
    u32::try_from(n).unwrap_or(u32::MAX)
}

/// The words of a panic.
pub fn words(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "panic".to_owned())
}

/// The result of `work`, or that of its panic.
pub fn caught<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(Failure::internal(words(&*panic))))
}
