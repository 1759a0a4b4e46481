//! Outcomes and failures of commands, and their exit codes.

use std::io;
use std::path::Path;
use wireloom::result::PartFault;
use wireloom::scenario::Fault;

/// Exit code for refused input.
pub const REFUSED: u8 = 1;
/// Exit code for a run that did not converge.
const NOT_CONVERGED: u8 = 2;
/// Exit code for a file or folder that could not be read or written, for a constraint or a plugin that failed, and for
/// a program that is missing.
const IO: u8 = 3;
/// Exit code for a harness that does not meet its requirements.
const NOT_MET: u8 = 4;

/// A command that did its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Everything succeeded.
    Done,
    /// Everything is written, but not every increment converged.
    NotConverged,
    /// Everything converged, but a requirement that must be kept fails or is unresolved.
    NotMet,
}

impl Outcome {
    /// The exit code.
    pub fn code(self) -> u8 {
        match self {
            Outcome::Done => 0,
            Outcome::NotConverged => NOT_CONVERGED,
            Outcome::NotMet => NOT_MET,
        }
    }
}

/// A scenario that was refused.
#[derive(Debug)]
pub struct Refusal {
    /// The file, as the user named it.
    pub file: String,
    /// Its text.
    pub text: String,
    /// Its faults.
    pub faults: Vec<Fault>,
}

/// Failure of a command.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Scenarios with faults.
    #[error("{} refused", .0.iter().map(|r| r.file.as_str()).collect::<Vec<_>>().join(", "))]
    Refused(Vec<Refusal>),
    /// Several of these.
    #[error("{} faults", .0.len())]
    Several(Vec<Failure>),
    /// Other input that cannot be used.
    #[error("{0}")]
    Input(String),
    /// A constraint or joint failed; everything before is written.
    #[error("{0}")]
    Part(PartFault),
    /// A plugin failed outside of a run, or violates its contract.
    #[error("{0}")]
    Plugin(String),
    /// A sweep in parts could not be written or read.
    #[error("{0}")]
    Dataset(wireloom_dataset::Error),
    /// Another program that is needed is missing.
    #[error("{0}")]
    Missing(String),
    /// Reading or writing failed.
    #[error("{what}: {source}")]
    Io {
        /// The operation and the file.
        what: String,
        /// The system's reason.
        source: io::Error,
    },
}

impl Failure {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Several(all) => all.iter().map(Failure::code).max().unwrap_or(REFUSED),
            Failure::Refused(_) | Failure::Input(_) => REFUSED,
            Failure::Dataset(error) if error.is_refusal() => REFUSED,
            Failure::Dataset(_) | Failure::Io { .. } | Failure::Missing(_) | Failure::Part(_) | Failure::Plugin(_) => {
                IO
            }
        }
    }

    /// A failed operation on a file or folder.
    pub fn io(what: &str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let what = format!("cannot {what} {}", path.display());
        move |source| Self::Io { what, source }
    }

    /// A failed operation on the network or on this program itself.
    pub fn system(what: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |source| Self::Io { what: format!("cannot {what}"), source }
    }

    /// Standard output failed.
    pub fn standard_output(source: io::Error) -> Self {
        Self::Io { what: "cannot write to standard output".into(), source }
    }
}
