//! Results back into the KBL files that their scenarios were imported from.
//!
//! What is written, and what keeps its bytes: see
//! [`import::kbl::export`](crate::import::kbl::export).
//!
//! ```
//! use wireloom::Control;
//! use wireloom::import::kbl::{Options, Source, import};
//! use wireloom::{export::sha256, kbl};
//!
//! let text = std::fs::read_to_string("../import/tests/small.kbl")?;
//! let file = Source { name: "small.kbl".into(), sha256: sha256(text.as_bytes()) };
//! let imported = import(&text, &Options { file: Some(file), ..Options::default() })?;
//! let (_, built) = wireloom::load(&imported.scenario, &wireloom::registry()).expect("no faults");
//! let run = wireloom::run(built, &mut |_, _| Control::Continue);
//! let written = kbl::export(&text, &run, 1e-4)?;
//! assert!(written.segments.iter().all(|segment| segment.curve.is_none_or(|curve| curve.distance <= 1e-4)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use wireloom_import::kbl::export::{CentreCurve, ExportError, Exported, Moved, Segment, Shifted};

use crate::export::sha256;
use std::collections::{BTreeSet, HashMap};
use wireloom_core::Vector;
use wireloom_core::equilibrium::{BranchResult, Run};
use wireloom_core::identity::{Identified, KblFile};
use wireloom_core::status::Status;
use wireloom_export::curve::Curve;
use wireloom_import::kbl::export::{Branch, Computed, Held};

/// Why a result was not written into a KBL file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotExported {
    /// The run is no equilibrium.
    #[error("the run did not converge ({}): its shapes are not those of the harness", .0.word())]
    NotConverged(Status),
    /// The run has no equilibrium.
    #[error("the run has no equilibrium")]
    Empty,
    /// The scenario was not imported from a KBL file.
    #[error(
        "its scenario names no KBL file in [kbl]: import the file with `wireloom import kbl`, and run that scenario"
    )]
    NoFile,
    /// The file is not the one that the scenario was imported from.
    #[error(
        "it is not `{file}` as the scenario was imported from it: its SHA-256 is {found}, the scenario has \
         {expected}{}",
        unknown(.segments)
    )]
    OtherFile {
        /// Name of the file that the scenario was imported from.
        file: String,
        /// Its hash.
        expected: String,
        /// The hash of the file that was given.
        found: String,
        /// Ids of segments of the scenario that it does not name.
        segments: Vec<String>,
    },
    /// What the result has is nothing that the file can say.
    #[error(transparent)]
    Export(#[from] ExportError),
}

fn unknown(segments: &[String]) -> String {
    match segments {
        [] => String::new(),
        _ => format!(", and it has no segments `{}`", segments.join("`, `")),
    }
}

/// Writes the last equilibrium of a run into the text of its KBL file; `tolerance`: largest distance of the centre
/// curves from the computed lines, m.
///
/// # Errors
/// [`NotExported`] where the run did not converge, the file is another one, or KBL cannot say what the result has.
pub fn export(text: &str, run: &Run, tolerance: f64) -> Result<Exported, NotExported> {
    if run.status() != Status::Converged {
        return Err(NotExported::NotConverged(run.status()));
    }
    let end = run.steps.last().ok_or(NotExported::Empty)?;
    let file = run.identities.kbl.as_ref().ok_or(NotExported::NoFile)?;
    check(text, file)?;
    let of = |wanted: Identified| file.elements.iter().filter(move |element| element.of == wanted);
    let segments: HashMap<&str, &str> =
        of(Identified::Branch).map(|element| (element.name.as_str(), element.id.as_str())).collect();
    let tangents: Vec<Vec<Vector>> =
        (end.branches.iter()).map(|branch| branch.frame.iter().map(|frame| frame * Vector::z()).collect()).collect();
    let branches = end.branches.iter().zip(&tangents);
    let branches = branches.map(|(own, tangents)| branch(own, tangents, segments.get(own.name.as_str()).copied()));
    let fixings = of(Identified::Constraint).filter_map(|element| {
        let own = end.constraints.iter().find(|own| own.name == element.name)?;
        Some(Held {
            name: element.name.clone(),
            assignment: element.id.clone(),
            position: own.position,
            tangent: own.orientation * Vector::z(),
            slides: own.slide.as_ref().map(|slide| (slide.branch.clone(), slide.arc_length)),
        })
    });
    let computed = Computed { branches: branches.collect(), fixings: fixings.collect() };
    Ok(wireloom_import::kbl::export::export(text, &computed, tolerance)?)
}

/// Refuses a text that is not that of the file.
fn check(text: &str, file: &KblFile) -> Result<(), NotExported> {
    let found = sha256(text.as_bytes());
    if found == file.sha256 {
        return Ok(());
    }
    let is_there = |id: &str| ['"', '\''].iter().any(|quote| text.contains(&format!("{quote}{id}{quote}")));
    let segments = file.elements.iter().filter(|element| element.of == Identified::Branch && !is_there(&element.id));
    let segments: BTreeSet<&String> = segments.map(|element| &element.id).collect();
    Err(NotExported::OtherFile {
        file: file.file.clone(),
        expected: file.sha256.clone(),
        found,
        segments: segments.into_iter().cloned().collect(),
    })
}

/// A branch of the result; one whose lists are no curve has no finite points, which is refused by its name.
fn branch<'a>(own: &'a BranchResult, tangents: &'a [Vector], segment: Option<&str>) -> Branch<'a> {
    let curve = Curve::of(&own.s, &own.position, tangents);
    let ends = [own.frame.first(), own.frame.last()];
    let sides = own.sides.iter().flat_map(|sides| sides.bend_radius);
    Branch {
        name: own.name.clone(),
        segment: segment.map(str::to_owned),
        s: &own.s,
        at: Box::new(move |f| curve.as_ref().map_or_else(|| Vector::repeat(f64::NAN), |curve| curve.at(f))),
        frames: ends.map(|frame| frame.copied().unwrap_or_default()),
        bend_radius: own.bend_radius.iter().copied().chain(sides).fold(f64::INFINITY, f64::min),
    }
}
