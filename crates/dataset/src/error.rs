//! Why something cannot be done with a dataset, and what would be right.

use std::ops::Range;

/// Failure of an operation on a dataset.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A place that is no folder and no URL of a store that this program knows.
    #[error("{place} cannot be written to: {reason}; give a folder, {known}")]
    Place {
        /// What was given.
        place: String,
        /// What is wrong with it.
        reason: String,
        /// What else may be given.
        known: &'static str,
    },
    /// A place without a dataset.
    #[error("{place} has no sweep.json: give the folder or URL that `wireloom sweep FILE --into` was given")]
    NoSweep {
        /// The place.
        place: String,
    },
    /// A dataset of another sweep.
    #[error("{place} has the parts of another sweep: {difference}; give another folder or URL")]
    Other {
        /// The place.
        place: String,
        /// What differs.
        difference: String,
    },
    /// Objects beside the parts that are none of this sweep.
    #[error(
        "{place} has {} that are no parts of this sweep (of another version of program, scenario, file or plugin?), \
         such as {}; move them away",
        .names.len(), .names.first().map_or("", String::as_str)
    )]
    Foreign {
        /// The place.
        place: String,
        /// Names of the objects.
        names: Vec<String>,
    },
    /// Points that no part has.
    #[error("{place} is not complete: no part has the points {}; compute them: wireloom sweep FILE --into {place}",
        words(.ranges))]
    Missing {
        /// The place.
        place: String,
        /// Their ranges.
        ranges: Vec<Range<usize>>,
    },
    /// A part that is not as it was written.
    #[error("{name} is damaged: {reason}; remove it, and compute the points {}..{} again", .range.start, .range.end)]
    Damaged {
        /// Its name.
        name: String,
        /// What is wrong with it.
        reason: String,
        /// Its points.
        range: Range<usize>,
    },
    /// A column that there is not.
    #[error("there is no column `{name}`; {help}")]
    Column {
        /// Its name.
        name: String,
        /// Names that there are.
        help: String,
    },
    /// The rights are missing.
    #[error("{place}: no right to {what}: {source}; {help}")]
    Denied {
        /// The place.
        place: String,
        /// The operation.
        what: String,
        /// The reason of the store.
        source: Box<object_store::Error>,
        /// What would be right.
        help: &'static str,
    },
    /// The store failed.
    #[error("{place}: cannot {what}: {source}")]
    Store {
        /// The place.
        place: String,
        /// The operation.
        what: String,
        /// The reason of the store.
        source: Box<object_store::Error>,
    },
    /// The system failed.
    #[error("{place}: cannot {what}: {source}")]
    System {
        /// The place.
        place: String,
        /// The operation.
        what: String,
        /// Its reason.
        source: std::io::Error,
    },
}

impl Error {
    /// Whether the request was wrong, rather than the store or what is in it.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Place { .. } | Self::NoSweep { .. } | Self::Other { .. } | Self::Column { .. } => true,
            Self::Foreign { .. } | Self::Missing { .. } => true,
            Self::Damaged { .. } | Self::Denied { .. } | Self::Store { .. } | Self::System { .. } => false,
        }
    }
}

/// Words for ranges: the first few of them.
pub fn words(ranges: &[Range<usize>]) -> String {
    const SHOWN: usize = 5;
    let shown: Vec<String> = ranges.iter().take(SHOWN).map(|range| format!("{}..{}", range.start, range.end)).collect();
    let more = ranges.len().saturating_sub(SHOWN);
    let rest = if more > 0 { format!(" and {more} more ranges") } else { String::new() };
    format!("{}{rest}", shown.join(", "))
}
