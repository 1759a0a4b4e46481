//! Why a plugin is not loaded.

use std::path::{Path, PathBuf};

/// A plugin that is not loaded, and why.
#[derive(Debug, thiserror::Error)]
#[error("plugin {}: {reason}", file.display())]
pub struct LoadError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it.
    pub reason: Reason,
}

impl LoadError {
    pub(crate) fn new(file: &Path) -> impl Fn(Reason) -> Self {
        let file = file.to_owned();
        move |reason| Self { file: file.clone(), reason }
    }
}

/// What is wrong with a plugin.
#[derive(Debug, thiserror::Error)]
pub enum Reason {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(std::io::Error),
    /// The system's loader refuses it; in its words.
    #[error("is no library that this system can load: {0}")]
    NotALibrary(String),
    /// It does not export what plugins export.
    #[error("exports no `wireloom_plugin`: it is a library, but not a plugin of this program")]
    NoEntry,
    /// What it exports does not begin as it should.
    #[error(
        "its `wireloom_plugin` begins with {found:#018x} instead of {:#018x}, the letters WIRELOOM",
        wireloom_abi::MAGIC
    )]
    Magic {
        /// The first eight bytes.
        found: u64,
    },
    /// Another version of the ABI.
    #[error("is built for ABI {}.{}, this program speaks ABI {}.{}", plugin.0, plugin.1, program.0, program.1)]
    Version {
        /// Major and minor version of the plugin.
        plugin: (u32, u32),
        /// Those of the program.
        program: (u32, u32),
    },
    /// A struct is smaller than it has ever been.
    #[error("its {what} says it has {size} bytes; ABI 1.0 has {least}")]
    TooSmall {
        /// Which struct.
        what: String,
        /// Bytes it says.
        size: u32,
        /// Bytes it must have at least.
        least: u32,
    },
    /// A pointer that is null, or cannot point to what it should.
    #[error("{what} is {value}")]
    Pointer {
        /// Which pointer.
        what: String,
        /// `null`, or what it is.
        value: String,
    },
    /// A text that is none.
    #[error("{what} {problem}")]
    Text {
        /// Which text.
        what: String,
        /// What is wrong with it.
        problem: String,
    },
    /// `kinds` failed; in its words.
    #[error("could not list its kinds: {0}")]
    Kinds(String),
    /// A number out of its range.
    #[error("{what} is {value}; {right}")]
    Value {
        /// Which number.
        what: String,
        /// The number.
        value: String,
        /// What would be right.
        right: String,
    },
    /// Two of a name within the plugin.
    #[error("{what} stands there twice")]
    Duplicate {
        /// What.
        what: String,
    },
    /// A kind of this name is there already.
    #[error("its kind `{kind}` is there already, from {owner}")]
    KindTaken {
        /// The kind.
        kind: String,
        /// Whose it is.
        owner: String,
    },
    /// A plugin of this name is there already.
    #[error("is named `{name}`, as is {}", other.display())]
    NameTaken {
        /// The name.
        name: String,
        /// The other's file.
        other: PathBuf,
    },
}

impl Reason {
    /// What would be right.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Unreadable(_) => "give the path of a plugin's library, or the name of one in the search path",
            Self::NotALibrary(_) => {
                "build it for this system, as a shared library (Rust: crate-type = [\"cdylib\"]; C: cc -shared -fPIC)"
            }
            Self::NoEntry | Self::Magic { .. } => {
                "in Rust, `wireloom_plugin::export!` makes the entry; in C, WIRELOOM_EXPORT const WireloomEntry wireloom_plugin"
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
