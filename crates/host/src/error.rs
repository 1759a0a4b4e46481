//! Errors of loading a plugin.

use std::path::{Path, PathBuf};

/// A plugin that was not loaded, and why.
#[derive(Debug, thiserror::Error)]
#[error("plugin {}: {reason}", file.display())]
pub struct LoadError {
    /// The file.
    pub file: PathBuf,
    /// The reason.
    pub reason: Reason,
}

impl LoadError {
    pub(crate) fn new(file: &Path) -> impl Fn(Reason) -> Self {
        let file = file.to_owned();
        move |reason| Self { file: file.clone(), reason }
    }
}

/// Reason why a plugin is not loaded.
#[derive(Debug, thiserror::Error)]
pub enum Reason {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(std::io::Error),
    /// There is no room for a private copy of it.
    #[error("cannot be copied: {0}")]
    NoCopy(std::io::Error),
    /// The system's loader refuses the file; its message.
    #[error("is not a library that this system can load: {0}")]
    NotALibrary(String),
    /// The library does not export the entry.
    #[error("exports no `wireloom_plugin`: it is a library, but not a plugin of this program")]
    NoEntry,
    /// The exported entry does not begin with the magic number.
    #[error(
        "its `wireloom_plugin` begins with {found:#018x} instead of {:#018x}, the letters WIRELOOM",
        wireloom_abi::MAGIC
    )]
    Magic {
        /// Its first eight bytes.
        found: u64,
    },
    /// Built for an incompatible version of the ABI.
    #[error("is built for ABI {}.{}, this program speaks ABI {}.{}", plugin.0, plugin.1, program.0, program.1)]
    Version {
        /// Major and minor version of the plugin.
        plugin: (u32, u32),
        /// Major and minor version of the program.
        program: (u32, u32),
    },
    /// A struct is smaller than in ABI 1.0.
    #[error("its {what} says it has {size} bytes; ABI 1.0 has {least}")]
    TooSmall {
        /// Name of the struct.
        what: String,
        /// Its size as it states, bytes.
        size: u32,
        /// Smallest size, bytes.
        least: u32,
    },
    /// A pointer that is null or invalid.
    #[error("{what} is {value}")]
    Pointer {
        /// Name of the pointer.
        what: String,
        /// `null`, or its value.
        value: String,
    },
    /// An invalid text.
    #[error("{what} {problem}")]
    Text {
        /// Name of the text.
        what: String,
        /// The problem.
        problem: String,
    },
    /// `kinds` failed; its message.
    #[error("could not list its kinds: {0}")]
    Kinds(String),
    /// A number out of its range.
    #[error("{what} is {value}; {right}")]
    Value {
        /// Name of the number.
        what: String,
        /// The number.
        value: String,
        /// The allowed values.
        right: String,
    },
    /// A name that occurs twice within the plugin.
    #[error("{what} occurs twice")]
    Duplicate {
        /// The duplicate item.
        what: String,
    },
    /// The registry already has a kind of this name.
    #[error("its kind `{kind}` already exists, from {owner}")]
    KindTaken {
        /// The kind.
        kind: String,
        /// The owner of that kind.
        owner: String,
    },
    /// A plugin of this name is already loaded.
    #[error("is named `{name}`, as is {}", other.display())]
    NameTaken {
        /// The name.
        name: String,
        /// File of the loaded plugin.
        other: PathBuf,
    },
}

impl Reason {
    /// A hint how to correct it.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Unreadable(_) => "give the path of a plugin's library, or the name of one in the search path",
            Self::NoCopy(_) => "a plugin runs from a private copy of its file: make room in memory",
            Self::NotALibrary(_) => {
                "build it for this system, as a shared library (Rust: crate-type = [\"cdylib\"]; C: cc -shared -fPIC)"
            }
            Self::NoEntry | Self::Magic { .. } => {
                "in Rust, `wireloom_plugin::export!` makes the entry; \
                 in C, WIRELOOM_EXPORT const WireloomEntry wireloom_plugin"
            }
            Self::Version { plugin, program } if plugin.0 == program.0 => "take a later version of this program",
            Self::Version { plugin, program } if plugin.0 > program.0 => {
                "take a later version of this program, or build the plugin for this one"
            }
            Self::Version { .. } => "build the plugin anew, against this program's version of the ABI",
            Self::NameTaken { .. } => "load one of the two",
            Self::KindTaken { .. } => "rename the kind, or load only one of the two",
            _ => "this is for the plugin's author: `wireloom plugin check FILE` tells more",
        }
    }
}
