//! Messages of the start page, on which a session is opened, and what an import has found.

use super::{Place, TextFault};
use serde::{Deserialize, Serialize};
#[cfg(test)]
use ts_rs::TS;

/// What a page can open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct StartPage {
    /// Name and version of the program.
    pub program: String,
    /// The folder in which the program was started: paths begin there, and what has no file is saved there.
    pub folder: String,
    /// Files that were open, the newest first.
    pub recent: Vec<Recent>,
    /// Examples that are part of the program.
    pub examples: Vec<Example>,
    /// Drafts of sessions without a file, the newest first.
    pub drafts: Vec<OfferedDraft>,
    /// Largest file that a page may give to be imported, bytes. A larger one is opened by its path.
    pub largest_import: u32,
}

/// A draft of an earlier session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct OfferedDraft {
    /// Its number, as long as this server runs.
    pub number: u32,
    /// Time of storage (RFC 3339).
    pub written: String,
}

/// A file or folder that was open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Recent {
    /// Its path.
    pub path: String,
    /// When it was opened last (RFC 3339), if that is known.
    pub opened: Option<String>,
    /// Whether it is not there any more.
    pub gone: bool,
}

/// An example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Example {
    /// Name of its file.
    pub name: String,
    /// What it shows.
    pub title: String,
}

/// What is opened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "is", rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub enum Opening {
    /// A scenario, or the folder of a finished run.
    Path {
        /// Its path.
        path: String,
    },
    /// An example.
    Example {
        /// Its name.
        name: String,
    },
    /// A new harness: one cable between two connectors.
    New,
    /// A scenario without a file here.
    Text {
        /// Name that is proposed for its file.
        name: String,
        /// Its text.
        text: String,
    },
    /// A harness that is imported from KBL.
    Kbl {
        /// The file.
        file: ImportFile,
        /// Names of the modules that are taken; none: all of them.
        modules: Option<Vec<String>>,
        /// Longest segment, m; none: as an accuracy of 2 % needs them.
        spacing: Option<f64>,
        /// Where the harness is.
        arrangement: Arranged,
    },
}

/// A file that is imported.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(tag = "from", rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub enum ImportFile {
    /// A file of this machine.
    Path {
        /// Its path.
        path: String,
    },
    /// A file that was given to the page.
    Text {
        /// Its name.
        name: String,
        /// Its text.
        text: String,
    },
}

/// Where an imported harness is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub enum Arranged {
    /// In the vehicle, as drawn.
    Installed,
    /// Flat on a formboard.
    Board,
    /// From the board into the vehicle, step by step.
    Assembly,
}

/// Modules and variants of a KBL file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Contents {
    /// Name of the file.
    pub name: String,
    /// Its modules.
    pub modules: Vec<Module>,
    /// Its variants: name, and names of modules.
    pub variants: Vec<(String, Vec<String>)>,
}

/// A module of a KBL file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Module {
    /// Its name.
    pub name: String,
    /// Its description.
    pub description: Option<String>,
    /// Code of the option that asks for it.
    pub option_code: Option<String>,
    /// Number of its parts.
    pub parts: u32,
}

/// Why nothing was opened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct NotOpened {
    /// The reason.
    pub message: String,
    /// What would be right; may be empty.
    pub help: String,
    /// Faults of the text.
    pub faults: Vec<TextFault>,
}

/// What an import has found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Imported {
    /// Name of the file.
    pub name: String,
    /// Irregularities of the file and their treatment.
    pub findings: Vec<Finding>,
    /// What became of the elements of the file, by kind.
    pub usage: Vec<Used>,
}

/// An irregularity of an imported file, and its treatment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Finding {
    /// One sentence or two.
    pub what: String,
    /// The places.
    pub items: Vec<FindingItem>,
    /// The place of the element that the sentence names; none if there are items.
    pub place: Option<Place>,
}

/// A place of a finding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct FindingItem {
    /// The place in words, with ids of the file.
    pub words: String,
    /// Where it is in the harness, if it is a part of that.
    pub place: Option<Place>,
}

/// What became of the elements of one kind: their numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(TS))]
#[serde(rename_all = "snake_case")]
pub struct Used {
    /// Name of the element.
    pub kind: String,
    /// In the file.
    pub total: u32,
    /// The computation depends on them.
    pub used: u32,
    /// Named in the scenario, without effect.
    pub kept: u32,
    /// Of other modules.
    pub left_out: u32,
    /// Not read.
    pub not_read: u32,
}
