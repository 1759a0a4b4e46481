//! Datasets: sweeps in parts, which any number of processes and machines write into one folder or object store.
//!
//! | object | content |
//! | --- | --- |
//! | `sweep.json` | what is swept: hash of program, scenario, files and plugins; number of points; columns |
//! | `parts/FIRST-END-HASH.parquet` | the points from FIRST up to END, which does not count |
//! | `points.parquet` | all points, sorted, written by [`Dataset::compact`] |
//!
//! Every row follows from the scenario and the number of its point alone, so a part has the same bytes wherever, and
//! however often, it is computed. Its name follows from the same, and objects are created only where there is none of
//! that name: two workers that compute the same range, or one that tries again, do no harm. There is no lock, no
//! database and no process that must stay alive; what is missing follows from the names of the parts.
//!
//! | file | contents |
//! | --- | --- |
//! | `store` | objects in a folder or a cloud; only user of `object_store` |
//! | `manifest` | what is swept, and the names of parts |
//! | `part` | a part as a Parquet file, and how it is checked |
//! | `status` | what is there, what is missing, how fast it grows |
//! | `compact` | one table of all parts |
//! | `error` | why something cannot be done, and what would be right |

mod compact;
mod error;
mod manifest;
mod part;
mod status;
mod store;

pub use compact::Compacted;
pub use error::{Error, words};
pub use manifest::{Manifest, Origin};
pub use part::Written;
pub use status::{Failed, Status};

use manifest::MANIFEST;
use std::ops::Range;
use store::Store;

/// Points of a part where nothing else is asked for: a few seconds of work for a small harness.
pub const POINTS: usize = 1024;

/// The parts of one sweep.
pub struct Dataset {
    store: Store,
    manifest: Manifest,
}

impl Dataset {
    /// Begins a dataset in a folder or at a URL, or joins the one of the same sweep that is there.
    ///
    /// # Errors
    /// The store cannot be used, or has another sweep.
    pub fn begin(place: &str, manifest: Manifest) -> Result<Self, Error> {
        let store = Store::open(place, true)?;
        // Mostly it is there: reading it is cheaper than trying to write it.
        let begun = !store.has(MANIFEST)? && store.create(MANIFEST, manifest.to_bytes())?;
        if !begun {
            let there = Manifest::read(&store)?;
            if there.hash != manifest.hash {
                return Err(there.differs(&manifest, place));
            }
        }
        Ok(Self { store, manifest })
    }

    /// Opens the dataset that is there.
    ///
    /// # Errors
    /// The store cannot be used, or has none.
    pub fn open(place: &str) -> Result<Self, Error> {
        let store = Store::open(place, false)?;
        let manifest = Manifest::read(&store)?;
        Ok(Self { store, manifest })
    }

    /// What is swept.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The folder or the URL.
    pub fn place(&self) -> &str {
        self.store.place()
    }

    /// The ranges of points that no part has.
    ///
    /// # Errors
    /// The store cannot be used.
    pub fn missing(&self) -> Result<Vec<Range<usize>>, Error> {
        Ok(self.listing()?.missing(self.manifest.points))
    }

    /// Ranges of at most `size` points, whole chains, that make up these ranges.
    pub fn pieces(&self, ranges: &[Range<usize>], size: usize) -> Vec<Range<usize>> {
        let size = size.clamp(1, self.manifest.points).next_multiple_of(self.manifest.chain);
        let pieces = |range: &Range<usize>| {
            let end = range.end;
            range.clone().step_by(size).map(move |first| first..(first + size).min(end))
        };
        ranges.iter().flat_map(pieces).collect()
    }

    /// Whether a part has all points of a range.
    ///
    /// # Errors
    /// The store cannot be used.
    pub fn has(&self, range: &Range<usize>) -> Result<bool, Error> {
        self.store.has(&self.manifest.part(range))
    }

    /// The objects that are there.
    fn listing(&self) -> Result<Listing, Error> {
        let mut listing = Listing::default();
        for object in self.store.list()? {
            match self.manifest.range_of(&object.name) {
                Some(range) => listing.parts.push(Part { range, object }),
                None if object.name.starts_with(manifest::PARTS) => listing.foreign.push(object.name),
                None => {}
            }
        }
        // Of parts that begin together the longest comes first.
        listing.parts.sort_by_key(|part| (part.range.start, usize::MAX - part.range.end));
        Ok(listing)
    }
}

/// A part that is there.
struct Part {
    range: Range<usize>,
    object: store::Object,
}

/// What is in a store.
#[derive(Default)]
struct Listing {
    /// Parts of this sweep, sorted.
    parts: Vec<Part>,
    /// Names of other objects beside them.
    foreign: Vec<String>,
}

impl Listing {
    fn missing(&self, points: usize) -> Vec<Range<usize>> {
        let mut missing = Vec::new();
        let mut end = 0;
        for Part { range, .. } in &self.parts {
            if range.start > end {
                missing.push(end..range.start);
            }
            end = end.max(range.end);
        }
        if end < points {
            missing.push(end..points);
        }
        missing
    }

    /// The parts that together have every point, and the first point that is taken of each.
    fn cover(&self) -> Vec<(&Part, usize)> {
        let mut end = 0;
        let mut cover = Vec::new();
        for part in self.parts.iter().filter(|part| part.range.start < part.range.end) {
            if part.range.end > end {
                cover.push((part, end.max(part.range.start)));
                end = part.range.end;
            }
        }
        cover
    }
}
