//! What lengths and places do to each requirement, where its worst value is.

use super::{NoAnswer, Source, Study};
use std::collections::BTreeMap;
use wireloom_core::Status;
use wireloom_core::equilibrium::{KeySensitivity, RequirementSensitivity, Run};
use wireloom_scenario::{lengths_and_places, number_at};

/// Derivatives that are noise, as a fraction of the largest one of their requirement.
const NOISE: f64 = 1e-6;

/// Adds to a run what [`of_requirements`] finds, or a note why there is nothing.
pub fn add_sensitivities(run: &mut Run, source: Source<'_>) {
    match of_requirements(source, run) {
        Ok(found) => run.sensitivities = found,
        Err(none) => run.notes.push(format!("sensitivities of the requirements are not known: {none}")),
    }
}

/// Derivatives of the worst value of each requirement of a run by the lengths of branches and the places of
/// constraints, also those that steps move them to, as far as the scenario's text holds them. The scenario is carried
/// out once more. Empty where the run did not converge.
///
/// # Errors
/// Faults of the scenario; a run that was stopped, or whose parts cannot continue.
pub fn of_requirements(source: Source<'_>, run: &Run) -> Result<Vec<RequirementSensitivity>, NoAnswer> {
    if run.status() != Status::Converged {
        return Ok(Vec::new());
    }
    let mut keys = lengths_and_places(&source.text).map_err(|fault| NoAnswer::Faults(vec![fault]))?;
    keys.retain(|key| number_at(&source.text, key, source.registry).is_ok());
    if keys.is_empty() {
        return Ok(Vec::new());
    }
    let mut study = Study::new(source)?;
    let parameters = study.parameters(&keys)?;
    // Lines in the order of the sheet, together where they are at their worst in the same increment.
    let names: Vec<String> = study.network().requirements.iter().map(|own| own.name.clone()).collect();
    let mut moments: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    let mut found = Vec::with_capacity(names.len());
    for (k, (line, name)) in run.requirements.iter().zip(&names).enumerate() {
        let own = RequirementSensitivity { requirement: name.clone(), ..RequirementSensitivity::default() };
        found.push(match &line.moment {
            None => RequirementSensitivity { reason: Some("nothing was checked".to_owned()), ..own },
            Some(moment) if moment.increment == 0 => {
                let reason = "its worst value is at the start, before the first increment";
                RequirementSensitivity { step: moment.step.clone(), reason: Some(reason.to_owned()), ..own }
            }
            Some(moment) => {
                moments.entry((moment.step_index, moment.increment)).or_default().push(k);
                RequirementSensitivity { step: moment.step.clone(), increment: moment.increment, ..own }
            }
        });
    }
    for ((step, increment), lines) in moments {
        study.run_to(step)?;
        let of: Vec<String> = lines.iter().map(|&k| names[k].clone()).collect();
        let answer = match study.derivatives((step, increment), &of, &parameters) {
            Ok(answer) => answer,
            Err(none @ (NoAnswer::NotConverged { .. } | NoAnswer::NotDifferentiable { .. })) => {
                lines.iter().for_each(|&k| found[k].reason = Some(none.to_string()));
                continue;
            }
            Err(none) => return Err(none),
        };
        for (k, output) in lines.into_iter().zip(answer.outputs) {
            found[k].unit = output.unit;
            // On the way through the increment it is no value of the equilibrium at its end.
            let none = || output.value.is_none().then(|| "it has no finite value there".to_owned());
            if let Some(reason) = output.remark.or_else(none) {
                found[k].reason = Some(reason);
                continue;
            }
            let known = parameters.iter().zip(output.by).map(|(parameter, own)| KeySensitivity {
                key: parameter.key.clone(),
                derivative: own.value,
                sides: own.value.is_none().then_some(own.sides),
                reason: own.reason,
            });
            let mut by: Vec<KeySensitivity> = known.collect();
            by.sort_by(|a, b| b.size().total_cmp(&a.size()));
            let least = NOISE * by[0].size();
            by.retain(|own| own.size() > least || own.reason.is_some());
            found[k].by = by;
            found[k].keeps_history = answer.keeps_history;
        }
    }
    Ok(found)
}
