//! What is there of a dataset, what is missing, and how fast it grows.

use crate::error::Error;
use crate::manifest::MANIFEST;
use crate::part::Failures;
use crate::{Dataset, Part};
use std::ops::Range;
use wireloom::export::table::FILE;

/// Time before the last part in which the throughput is measured, s.
const WINDOW: f64 = 600.0;

/// The state of a dataset.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// Points that parts have.
    pub done: usize,
    /// Number of parts.
    pub parts: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Ranges of points that no part has.
    pub missing: Vec<Range<usize>>,
    /// Points that did not converge, by status.
    pub failed: Vec<Failed>,
    /// Points a second over the ten minutes before the last part; `None`: there is no part.
    pub throughput: Option<f64>,
    /// Names of parts that are damaged, and why.
    pub damaged: Vec<(String, String)>,
    /// Names of objects beside the parts that are none of this sweep.
    pub foreign: Vec<String>,
    /// Whether the table of all points is written.
    pub compacted: bool,
}

/// Points that did not converge.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failed {
    /// Their status.
    pub status: String,
    /// Number of points.
    pub points: usize,
    /// Reasons and their numbers, the most frequent first; an empty one is that of all others.
    pub reasons: Vec<(String, usize)>,
}

impl Dataset {
    /// What is there. Reads the ends of all parts, not their rows.
    ///
    /// # Errors
    /// The store cannot be used.
    pub fn status(&self) -> Result<Status, Error> {
        let mut listing = self.listing()?;
        let (mut damaged, mut failures) = (Vec::new(), Failures::default());
        let mut sound = Vec::new();
        for part in std::mem::take(&mut listing.parts) {
            match self.head(&part) {
                Ok(head) => sound.push((part, head)),
                Err(Error::Damaged { name, reason, .. }) => damaged.push((name, reason)),
                Err(error) => return Err(error),
            }
        }
        let (parts, heads): (Vec<Part>, Vec<_>) = sound.into_iter().unzip();
        listing.parts = parts;
        let missing = listing.missing(self.manifest.points);
        // Points that two parts have count once: those parts that add any are asked.
        let cover: Vec<usize> = listing.cover().iter().map(|(part, _)| part.range.start).collect();
        let mut counted = usize::MAX;
        for (part, head) in listing.parts.iter().zip(&heads) {
            if cover.contains(&part.range.start) && counted != part.range.start {
                counted = part.range.start;
                failures.add_part(head);
            }
        }
        let done = self.manifest.points - missing.iter().map(Range::len).sum::<usize>();
        let bytes = listing.parts.iter().map(|part| part.object.size).sum();
        let begun = self.store.list()?.into_iter().find(|object| object.name == MANIFEST).map(|object| object.time);
        Ok(Status {
            done,
            parts: listing.parts.len(),
            bytes,
            missing,
            failed: failures.0.into_iter().map(Failed::of).collect(),
            throughput: throughput(&listing.parts, begun.unwrap_or_default()),
            damaged,
            foreign: listing.foreign,
            compacted: self.store.has(FILE)?,
        })
    }
}

impl Failed {
    fn of((status, reasons): (String, std::collections::BTreeMap<String, usize>)) -> Self {
        let points = reasons.values().sum();
        let mut reasons: Vec<(String, usize)> = reasons.into_iter().collect();
        reasons.sort_by_key(|(reason, points)| (reason.is_empty(), usize::MAX - points));
        Self { status, points, reasons }
    }
}

/// Points a second in the time before the last part; `begun`: when the sweep began.
fn throughput(parts: &[Part], begun: f64) -> Option<f64> {
    let last = parts.iter().map(|part| part.object.time).reduce(f64::max)?;
    let from = begun.max(last - WINDOW);
    let points: usize = parts.iter().filter(|part| part.object.time > from).map(|part| part.range.len()).sum();
    (last > from).then(|| points as f64 / (last - from))
}
