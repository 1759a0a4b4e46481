//! TOML text to checked scenario to network.
//!
//! [`parse`] reads a scenario file and refuses it with all its faults at once, each at its place;
//! [`Scenario::build`] makes the network, the schedule and the minimiser from it; [`schema()`] writes the format as a
//! JSON Schema, [`explain`] in words.
//!
//! | folder | contents |
//! | --- | --- |
//! | `format` | tables of keys, units, limits; schema and explanations derived from them |
//! | `operations` | step operations: one file each, with its keys and its reader |
//! | `read` | text to document: values, names, references, entry by entry |
//! | `build` | mesh, placement, network |
//! | `check` | contradicting constraints, parts that nothing holds |
//! | `edit` | values that replace those of the text, steps and values written into the text |
//!
//! The data types lie beside them: [`Scenario`] and its parts, [`sweep`], [`settings`], [`Fault`]; [`bundle`] is the rule
//! for sections made of wires.

mod attachment;
mod build;
pub mod bundle;
mod check;
mod edit;
mod fault;
mod format;
mod operations;
mod output;
mod read;
mod scenario;
pub mod settings;
mod span;
pub mod sweep;

pub use attachment::{At, Stretch};
pub use build::network::Built;
pub use edit::{adjust, record};
pub use fault::{Fault, Places, render};
pub use format::explain;
pub use format::limits::MAX_COUNT as MAX_SEGMENTS;
pub use format::schema::schema;
pub use format::units::unit_of;
pub use output::Output;
pub use read::files::{Files, NoFiles};
pub use read::library::{shipped_coverings, shipped_wires};
pub use read::plugins::{Plugins, plugins};
pub use scenario::{Arm, Body, Branch, ByRule, Constraint, Division, Facing, Joint, Load, Minimiser, Scenario};
pub use settings::Setting;
pub use span::{Span, Spans};

use check::{conflicts, freedoms};
use read::{document, reader, toml_text};
use wireloom_core::Registry;

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
    let mut table = toml_text::table(&whole_text[..text.len()])?;
    let reader = reader::Reader::new(&whole_text, files, registry);
    let unset = edit::apply::put(table.get_mut(), &whole_text, text.len(), settings, registry);
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
    let constraints = scenario.constraints.iter().zip(&network.constraints);
    let faults = constraints.filter_map(|(own, constraint)| {
        let message = format!("constraint \"{}\": {}", own.name, constraint.model.fault()?);
        let help = format!("the fault is that of the kind \"{}\", not of the scenario", own.kind);
        Some(Fault { span: own.spans.of(Some("kind")), message, help })
    });
    faults.collect()
}
