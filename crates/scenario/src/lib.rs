//! TOML text to checked scenario to network.
//!
//! [`parse`] reads a scenario file and refuses it with all its faults at once, each at its place;
//! [`Scenario::build`] makes the network, the schedule and the minimiser from what it read; [`schema()`] writes the format down as a
//! JSON Schema, [`explain`] in words. What a file may say stands in one set of tables (`keys.rs`), by which all go.
//!
//! The road of a file: `document` (with `library`, `catalogue`, `sections`, `joints`, `fixings`, `sequence`) reads entries through `reader` and
//! resolves names; [`bundle`] makes sections of wires; `mesh` and `build` make the parts; `conflicts` and `freedoms` judge the whole.
//! [`record`] writes into a text what was done by hand.
//!
//! Beyond the format of the design page: a branch may have `path = [[x, y, z], …]`, the drawn centre line from
//! `from` to `to` in world coordinates (m), which serves as a start for its shape and for nothing else.

pub mod adjust;
mod build;
pub mod bundle;
mod catalogue;
mod conflicts;
mod document;
pub mod explain;
mod fault;
mod files;
mod fixings;
mod freedoms;
mod joints;
mod keys;
mod kinds;
mod library;
mod mesh;
mod obstacles;
mod operations;
mod placement;
mod plugins;
mod poses;
mod reader;
pub mod record;
mod scenario;
mod schema;
mod sections;
mod sequence;
pub mod settings;
pub mod sweep;
mod timeline;
mod units;

pub use build::Built;
pub use fault::{Fault, Places, render};
pub use files::{Files, NoFiles};
pub use keys::MANY as MOST_SEGMENTS;
pub use library::{shipped_coverings, shipped_wires};
pub use plugins::{Plugins, plugins};
pub use scenario::{
    Arm, At, Body, Branch, ByRule, Constraint, Division, Facing, Joint, Load, Minimiser, Output, Scenario, Spans,
    Stretch,
};
pub use schema::schema;
pub use settings::Setting;
pub use units::unit_of;

use std::ops::Range;
use toml::de::DeTable;
use wireloom_core::Registry;

/// A place in a text, bytes.
pub type Span = Range<usize>;

/// Syntax errors shown: those that follow are mostly echoes of the first ones.
const SYNTAX_ERRORS: usize = 3;

/// Reads and checks a scenario that names no other files; the kinds it names are looked up in `registry`.
///
/// # Errors
/// See [`parse_with_files`].
pub fn parse(text: &str, registry: &Registry) -> Result<Scenario, Vec<Fault>> {
    parse_with_files(text, &NoFiles, registry)
}

/// Reads and checks a scenario; the kinds it names are looked up in `registry`, the files it names in `files`.
///
/// # Errors
/// All faults, in the order of the text. Where the text is no TOML, these are the first few syntax errors. Whether
/// the harness is held, and by constraints that agree, is judged only where all names lead somewhere. A fault of another
/// file stands where the scenario names that file.
pub fn parse_with_files(text: &str, files: &dyn Files, registry: &Registry) -> Result<Scenario, Vec<Fault>> {
    parse_with_settings(text, &[], files, registry)
}

/// Reads and checks a scenario in which `settings` take the place of what it says.
///
/// # Errors
/// See [`parse_with_files`]. Faults of what is set have places after the end of the text: see [`settings::apart`].
pub fn parse_with_settings(
    text: &str,
    settings: &[Setting],
    files: &dyn Files,
    registry: &Registry,
) -> Result<Scenario, Vec<Fault>> {
    build_with_settings(text, settings, files, registry).map(|(scenario, _)| scenario)
}

/// The same, with what a run needs: it is built in order to be checked.
///
/// # Errors
/// See [`parse_with_settings`].
pub fn build_with_settings(
    text: &str,
    settings: &[Setting],
    files: &dyn Files,
    registry: &Registry,
) -> Result<(Scenario, Built), Vec<Fault>> {
    let whole_text = format!("{text}\n{}", settings::lines(settings));
    let mut table = toml_table(&whole_text[..text.len()])?;
    let reader = reader::Reader::new(&whole_text, files, registry);
    let unset = settings::put(table.get_mut(), &whole_text, text.len(), settings, registry);
    if !unset.is_empty() {
        return Err(unset);
    }
    let (scenario, whole) = document::read(&reader, table.get_ref());
    let mut built = None;
    if whole {
        match scenario.build(registry) {
            Err(faults) => reader.faults(faults),
            Ok(own) => {
                reader.faults(conflicts::refuse_misplaced(&scenario, &own.network));
                reader.faults(conflicts::refuse_contradictions(&scenario, &own.network));
                let unheld = freedoms::refuse_unheld(&scenario, &own.network);
                // Of a constraint that has broken down it is not known what it holds.
                let broken = broken_down(&scenario, &own.network);
                reader.faults(if broken.is_empty() { unheld } else { broken });
                built = Some(own);
            }
        }
    }
    let faults = reader.finish();
    let Some(built) = built.filter(|_| faults.is_empty()) else { return Err(faults) };
    // What a sweep sets is tried once, or a slip would be found only after all its points have failed.
    if let (Some(sweep), []) = (&scenario.sweep, settings) {
        parse_with_settings(text, &sweep.settings(0), files, registry)
            .map_err(|faults| sweep::placed(sweep, text, faults))?;
    }
    Ok((scenario, built))
}

/// Constraints that broke down as they were asked what they hold.
fn broken_down(scenario: &Scenario, network: &wireloom_core::Network) -> Vec<Fault> {
    let fixings = scenario.constraints.iter().zip(&network.fixings);
    let faults = fixings.filter_map(|(own, fixing)| {
        let message = format!("constraint \"{}\": {}", own.name, fixing.constraint.fault()?);
        let help = format!("the fault is that of the kind \"{}\", not of the scenario", own.kind);
        Some(Fault { span: own.spans.of(Some("kind")), message, help })
    });
    faults.collect()
}

/// The text as a table, with the places of its values.
fn toml_table(text: &str) -> Result<toml::Spanned<DeTable<'_>>, Vec<Fault>> {
    let (table, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Ok(table);
    }
    let mut faults: Vec<Fault> = errors.iter().map(|error| syntax_fault(text, error)).collect();
    faults.sort_by_key(|fault| fault.span.start);
    faults.truncate(SYNTAX_ERRORS);
    Err(faults)
}

fn syntax_fault(text: &str, error: &toml::de::Error) -> Fault {
    Fault {
        span: error.span().unwrap_or(text.len()..text.len()),
        message: format!("this is no TOML: {}", error.message()),
        help: "see https://toml.io; the faults after this one may be echoes of it".to_owned(),
    }
}
