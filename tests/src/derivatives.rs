//! Derivatives of results by numbers of a scenario, and differences of whole runs to hold them against.
#![allow(clippy::missing_panics_doc, reason = "a scenario of a test that is refused ends the test")]

use wireloom::scenario::{NoFiles, Setting, number_at};
use wireloom::sensitivity::{NoAnswer, Question, Sensitivities, Source, Study};
use wireloom::{Built, Control, Registry, Status};

/// Step of the differences of whole runs, as a fraction of the size of the parameter: their error is of fourth order.
const STEP: f64 = 5e-4;
/// Such a step for a parameter that is zero, SI.
const STEP_FROM_ZERO: f64 = 1e-4;

/// Derivatives of a scenario that names no other files.
///
/// # Errors
/// Those of [`Study::answer`].
pub fn derivatives(
    text: &str,
    registry: &Registry,
    of: &[&str],
    by: &[&str],
    step: Option<&str>,
) -> Result<Sensitivities, NoAnswer> {
    let [of, by] = [of, by].map(|names| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>());
    Study::new(Source::new(text, &NoFiles, registry))?.answer(&Question { of: &of, by: &by, step })
}

/// Largest error of derivatives, against differences of whole runs with a parameter changed by ±h and ±2h: relative to
/// the derivative or, where that is small, to the output over the parameter. Outputs as `read` takes them from a run.
/// With the name of what has it.
#[track_caller]
pub fn largest_error(
    text: &str,
    registry: &Registry,
    of: &[&str],
    by: &[&str],
    read: impl Fn(&wireloom::StepResult, &str) -> f64,
) -> (f64, String) {
    let found = derivatives(text, registry, of, by, None).unwrap_or_else(|none| panic!("{none}"));
    let (_, built) = wireloom::load(text, registry).expect("no faults");
    let fixed = fixed(&built);
    let mut worst = (0.0, String::new());
    for (k, parameter) in found.parameters.iter().enumerate() {
        let scale = number_at(text, &parameter.key, registry).expect("a number").scale;
        let h = if scale > 0.0 { STEP * scale } else { STEP_FROM_ZERO };
        let ends = [-2.0, -1.0, 1.0, 2.0].map(|step| {
            let changed = Setting::number(&parameter.key, parameter.value + step * h);
            let settings: Vec<Setting> = fixed.iter().cloned().chain([changed]).collect();
            let loaded = wireloom::load_with_settings(text, &settings, &NoFiles, registry);
            let (_, built) = loaded.unwrap_or_else(|faults| panic!("{}: {faults:?}", parameter.key));
            let run = wireloom::run(built, &mut |_, _| Control::Continue);
            assert_eq!(run.status(), Status::Converged, "{}", parameter.key);
            run.steps.last().expect("a step").clone()
        });
        for output in &found.outputs {
            let at = |k: usize| read(&ends[k], &output.name);
            let expected = (8.0 * (at(2) - at(1)) - (at(3) - at(0))) / (12.0 * h);
            let derivative = &output.by[k];
            let what = format!("{} by {}: {derivative:?}, not {expected:e}", output.name, parameter.key);
            let value = derivative.value.unwrap_or_else(|| panic!("{what}"));
            let size = at(1).abs() / if scale > 0.0 { scale } else { 1.0 };
            let error = (value - expected).abs() / expected.abs().max(size);
            if error > worst.0 || error.is_nan() {
                worst = (error, what);
            }
        }
    }
    worst
}

/// Settings for runs with the same mesh, whatever the lengths are, and with forces balanced to round-off.
pub fn fixed(built: &Built) -> Vec<Setting> {
    let branches = built.network.branches.iter();
    let segments = branches.map(|branch| {
        let key = format!("branches.{}.segments", wireloom::scenario::adjust::quoted(&branch.name));
        Setting::new(key, branch.rod.mesh().segments().to_string())
    });
    segments.chain([Setting::new("minimiser.force_tolerance", "1e-11")]).collect()
}
