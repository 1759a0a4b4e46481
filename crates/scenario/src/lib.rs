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
//! The data types lie beside them: [`Scenario`] and its parts, [`sweep`], [`optimise`], [`settings`], [`Fault`];
//! [`bundle`] is the rule for sections made of wires.

mod attachment;
mod build;
pub mod bundle;
mod check;
mod edit;
pub mod fault;
mod format;
mod operations;
pub mod optimise;
mod output;
mod read;
mod scenario;
pub mod settings;
mod span;
pub mod sweep;

pub use attachment::{At, Stretch};
pub use build::network::Built;
pub use edit::number::{Number, lengths_and_places, number_at, value_for};
pub use edit::{adjust, flat, record, structure};
pub use fault::{Fault, Places, render};
pub use format::explain;
pub use format::limits::MAX_COUNT as MAX_SEGMENTS;
pub use format::schema::schema;
pub use format::units::{quantity_in, unit_of};
pub use output::{Fields, Output};
pub use read::files::{Files, NoFiles};
pub use read::library::{shipped_coverings, shipped_fixings, shipped_wires};
pub use read::plugins::{Plugins, plugins};
pub use scenario::{
    Arm, Body, Branch, ByRule, Constraint, Division, Facing, Joint, Load, Minimiser, Required, Scenario, SectionPart,
};
pub use settings::Setting;
pub use span::{Span, Spans};

use check::{conflicts, freedoms, laws, limits, temperature};
use read::{document, reader, toml_text};
use wireloom_core::Registry;

/// Reads and checks a scenario that names no other files. `registry`: the known kinds.
///
/// # Errors
/// See [`parse_with_files`].
pub fn parse(text: &str, registry: &Registry) -> Result<Scenario, Vec<Fault>> {
    parse_with_files(text, &NoFiles, registry)
}

/// Reads and checks a scenario. `files`: the files that it may name; `registry`: the known kinds.
///
/// # Errors
/// All faults, in the order of the text; only the first few syntax errors if the text is not TOML. Contradictions
/// between constraints and parts that nothing holds are checked only if all names refer to something. A fault of
/// another file has the place where the scenario names that file.
pub fn parse_with_files(text: &str, files: &dyn Files, registry: &Registry) -> Result<Scenario, Vec<Fault>> {
    parse_with_settings(text, &[], files, registry)
}

/// Reads and checks a scenario in which `settings` replace values of the text.
///
/// # Errors
/// See [`parse_with_files`]. Faults of settings have places after the end of the text: see [`settings::apart`].
pub fn parse_with_settings(
    text: &str,
    settings: &[Setting],
    files: &dyn Files,
    registry: &Registry,
) -> Result<Scenario, Vec<Fault>> {
    build_with_settings(text, settings, files, registry).map(|(scenario, _)| scenario)
}

/// Reads, checks and builds a scenario in which `settings` replace values of the text. Some checks need the built
/// parts.
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
                reader.faults(limits::refuse_contradictions(&scenario, &own.network));
                reader.faults(conflicts::refuse_misplaced(&scenario, &own.network));
                reader.faults(laws::refuse_without_effect(&scenario, &own.network));
                reader.faults(temperature::refuse_without_effect(&scenario, &own.network));
                reader.faults(conflicts::refuse_contradictions(&scenario, &own.network));
                let unheld = freedoms::refuse_unheld(&scenario, &own.network);
                // It is not known what a constraint holds after its plugin has failed.
                let broken = broken_down(&scenario, &own.network);
                reader.faults(if broken.is_empty() { unheld } else { broken });
                if let (Some(optimise), []) = (&scenario.optimise, settings) {
                    reader.faults(check::optimise::refuse(optimise, text, (&scenario, &own.network), registry));
                }
                built = Some(own);
            }
        }
    }
    let faults = reader.finish();
    let Some(built) = built.filter(|_| faults.is_empty()) else { return Err(faults) };
    // Points of a sweep are tried here; otherwise a mistake would be found only after all points have failed.
    if let (Some(sweep), []) = (&scenario.sweep, settings) {
        for k in sweep.trials() {
            parse_with_settings(text, &sweep.settings(k), files, registry)
                .map_err(|faults| sweep::placed(sweep, k, text, faults))?;
        }
    }
    // So is what an optimisation chooses from, and the units of its ranges.
    if let (Some(optimise), []) = (&scenario.optimise, settings) {
        for (variable, trial) in check::optimise::trials(optimise, text, registry) {
            parse_with_settings(text, std::slice::from_ref(&trial), files, registry)
                .map_err(|faults| check::optimise::placed(variable, &trial, faults))?;
        }
    }
    Ok((scenario, built))
}

/// Faults of constraints that failed during the checks.
fn broken_down(scenario: &Scenario, network: &wireloom_core::Network) -> Vec<Fault> {
    let constraints = scenario.constraints.iter().zip(&network.constraints);
    let faults = constraints.filter_map(|(own, constraint)| {
        let message = format!("constraint \"{}\": {}", own.name, constraint.model.fault()?);
        let help = format!("this is a fault of the kind \"{}\", not of the scenario", own.kind);
        Some(Fault { span: own.spans.of(Some("kind")), message, help })
    });
    faults.collect()
}
