//! Failures, and the Python exceptions that they become. The classes are in `python/wireloom/_errors.py`.

use pyo3::call::PyCallArgs;
use pyo3::exceptions::{PyKeyError, PyOSError, PyPermissionError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use std::io;
use std::path::Path;
use wireloom::scenario::fault::{refusal, safe};
use wireloom::scenario::{Fault, Places};

/// Why something could not be done.
#[derive(Debug)]
pub enum Failure {
    /// A scenario with faults: its name, text and faults.
    Refused { name: String, text: String, faults: Vec<Fault> },
    /// A key of a scenario that does not exist.
    Key(Fault),
    /// A file that could not be read or written.
    Io(io::Error),
    /// A file that is not what it should be.
    Result(String),
    /// A sweep in parts that could not be written or read.
    Dataset(wireloom_dataset::Error),
    /// A request that cannot be fulfilled, and what to do instead.
    Request(String, String),
    /// The same in one text.
    Question(String),
    /// A question that has no answer.
    NoAnswer(String),
    /// A part of the harness that failed during a computation.
    Part(String),
    /// A session that was closed, or that broke.
    Closed,
    /// A panic.
    Internal(String),
}

impl Failure {
    /// A failed operation on a file.
    pub fn io(what: &str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let what = format!("cannot {what} {}", path.display());
        move |error| Self::Io(io::Error::new(error.kind(), format!("{what}: {error}")))
    }
}

impl From<wireloom_dataset::Error> for Failure {
    fn from(error: wireloom_dataset::Error) -> Self {
        Self::Dataset(error)
    }
}

/// The module of the exceptions.
static ERRORS: PyOnceLock<Py<PyModule>> = PyOnceLock::new();

/// An item of `wireloom._errors`.
pub fn class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let module = ERRORS.get_or_try_init(py, || Ok::<_, PyErr>(py.import("wireloom._errors")?.unbind()))?;
    module.bind(py).getattr(name)
}

/// An exception of `wireloom._errors`.
fn exception<'py>(py: Python<'py>, name: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    class(py, name).and_then(|class| class.call1(arguments)).map_or_else(|error| error, PyErr::from_value)
}

/// The diagnostics of a text's faults, as a list of `wireloom.Diagnostic`.
pub fn diagnostics<'py>(py: Python<'py>, name: &str, text: &str, faults: &[Fault]) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let (diagnostic, places) = (class(py, "Diagnostic")?, Places::of(text));
    let one = |Fault { span, message, help }: &Fault| {
        let (line, column) = places.position(span.start);
        diagnostic.call1((name, line, column, safe(message), safe(help)))
    };
    faults.iter().map(one).collect()
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| match failure {
            Failure::Refused { name, text, faults } => {
                let words = refusal(&name, &text, &faults);
                match diagnostics(py, &name, &text, &faults) {
                    Ok(all) => exception(py, "ScenarioError", (words.trim_end(), all)),
                    Err(error) => error,
                }
            }
            Failure::Key(fault) => PyKeyError::new_err(format!("{}; {}", safe(&fault.message), safe(&fault.help))),
            Failure::Io(error) if error.kind() == io::ErrorKind::InvalidInput => {
                PyValueError::new_err(error.to_string())
            }
            Failure::Io(error) => error.into(),
            Failure::Result(words) => exception(py, "ResultError", (words,)),
            Failure::Dataset(error) => {
                use wireloom_dataset::Error::{Damaged, Denied, Foreign, NoSweep, Other, Store, System};
                let words = safe(&error.to_string());
                match error {
                    Other { .. } | NoSweep { .. } | Foreign { .. } | Damaged { .. } => {
                        exception(py, "ResultError", (words,))
                    }
                    Denied { .. } => PyPermissionError::new_err(words),
                    Store { .. } | System { .. } => PyOSError::new_err(words),
                    _ => exception(py, "RequestError", (words,)),
                }
            }
            Failure::Request(message, help) => {
                exception(py, "RequestError", (format!("{}; {}", safe(&message), safe(&help)),))
            }
            Failure::Question(words) => exception(py, "RequestError", (safe(&words),)),
            Failure::NoAnswer(words) => exception(py, "NoAnswerError", (safe(&words),)),
            Failure::Part(words) => exception(py, "PartError", (safe(&words),)),
            Failure::Closed => exception(py, "ClosedError", ("the session is closed: open another one",)),
            Failure::Internal(words) => {
                let words = format!("{}: a fault of wireloom, not of the input; please report it", safe(&words));
                exception(py, "InternalError", (words,))
            }
        })
    }
}

/// The exception for an interrupted run, which is kept in it.
pub fn interrupted(py: Python<'_>, run: Bound<'_, PyAny>) -> PyErr {
    exception(py, "Interrupted", (run,))
}
