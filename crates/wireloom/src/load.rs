//! From a scenario's text to a harness that can be run.

mod start;
pub(crate) mod targets;

use wireloom_core::Registry;
use wireloom_scenario::{Built, Fault, Files, NoFiles, Scenario, Setting};

/// Faults of a scenario's text that names no other files; empty if it can be run.
///
/// ```
/// let text = std::fs::read_to_string("../../scenarios/first.toml")?;
/// let registry = wireloom::registry();
/// assert!(wireloom::check(&text, &registry).is_empty());
///
/// let wrong = text.replace("length = \"600 mm\"", "length = \"600 kg\"");
/// let faults = wireloom::check(&wrong, &registry);
/// let (line, column) = faults[0].position(&wrong);
/// println!("{line}:{column}: {}\nhelp: {}", faults[0].message, faults[0].help);
/// # assert_eq!(faults.len(), 1, "{faults:?}");
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn check(text: &str, registry: &Registry) -> Vec<Fault> {
    load(text, registry).err().unwrap_or_default()
}

/// Checks and builds a scenario from a text that names no other files.
///
/// # Errors
/// All faults of the text at once, each with its place.
pub fn load(text: &str, registry: &Registry) -> Result<(Scenario, Built), Vec<Fault>> {
    load_with_files(text, &NoFiles, registry)
}

/// Checks and builds a scenario; the files it names are read through `files`.
///
/// # Errors
/// All faults of the text at once, each with its place.
pub fn load_with_files(text: &str, files: &dyn Files, registry: &Registry) -> Result<(Scenario, Built), Vec<Fault>> {
    load_with_settings(text, &[], files, registry)
}

/// Checks and builds a scenario in which `settings` replace values of its text.
///
/// # Errors
/// All faults at once; those of settings have places after the end of the text: see
/// [`scenario::settings::apart`](wireloom_scenario::settings::apart).
pub fn load_with_settings(
    text: &str,
    settings: &[Setting],
    files: &dyn Files,
    registry: &Registry,
) -> Result<(Scenario, Built), Vec<Fault>> {
    let (scenario, built) = wireloom_scenario::build_with_settings(text, settings, files, registry)?;
    let faults: Vec<Fault> =
        start::refuse_inside(&scenario, &built).into_iter().chain(targets::refuse_inside(&scenario, &built)).collect();
    if faults.is_empty() { Ok((scenario, built)) } else { Err(faults) }
}
