//! Optimisations: keys that cannot be varied, ranges that exclude their start, and requirements that are unknown
//! or can have no value are refused.

use super::timeline::never_acts;
use crate::edit::number::number_at;
use crate::edit::record;
use crate::fault::{Fault, did_you_mean};
use crate::optimise::{Choice, Minimised, Optimise, Variable};
use crate::scenario::Scenario;
use crate::settings::Setting;
use crate::sweep::Value;
use wireloom_core::requirement::{Origin, Requirement, Severity};
use wireloom_core::{Network, Registry};

/// Largest number of combinations of choices.
const MAX_COMBINATIONS: usize = 10_000;
/// Distance from its range, relative to it, at which a value of the file is still in it: round-off of units.
const ROUND_OFF: f64 = 1e-9;

/// Refuses what an optimisation cannot vary or minimise.
pub(crate) fn refuse(
    optimise: &Optimise,
    text: &str,
    (scenario, network): (&Scenario, &Network),
    registry: &Registry,
) -> Vec<Fault> {
    let variables = optimise.variables.iter().filter_map(|variable| {
        let fault = |message: String, help: String| Some(Fault { span: variable.span.clone(), message, help });
        let key = &variable.key;
        let (from, to) = match &variable.choice {
            Choice::Between { from, to, .. } => (*from, *to),
            Choice::Values(_) => {
                let Fault { message, help, .. } = record::value_at(text, key).err()?;
                return fault(message, help);
            }
        };
        let number = match number_at(text, key, registry) {
            Ok(number) => number,
            Err(Fault { message, help, .. }) => return fault(message, help),
        };
        let room = ROUND_OFF * (to - from);
        if !(from - room..=to + room).contains(&number.value) {
            let own = format!("{} {}", number.value, number.unit);
            let message = format!("the range of `{key}` excludes its own value, {}", own.trim_end());
            let help = format!("the file's own value is the first start: it must lie between {from} and {to} (SI)");
            return fault(message, help);
        }
        None
    });
    let terms = optimise.terms.iter().filter_map(|term| {
        let fault = |message: String, help: String| Some(Fault { span: term.span.clone(), message, help });
        let name = match &term.of {
            Minimised::Requirement(name) => name,
            Minimised::WorstMargin => {
                let counts = |own: &Requirement| own.severity == Severity::Must && own.origin != Origin::Always;
                if network.requirements.iter().any(counts) {
                    return None;
                }
                let message = "there is no requirement that must be kept, so no worst margin".to_owned();
                return fault(message, "add [[requirements]], or limits of sections or fixings".to_owned());
            }
            Minimised::Length | Minimised::Mass => return None,
        };
        let names = network.requirement_names();
        if let Some(own) = names.iter().position(|own| own == name).map(|k| &network.requirements[k]) {
            let all = (0..scenario.steps.len().max(1)).collect();
            let why = never_acts(scenario, own, own.steps.as_ref().unwrap_or(&all))?;
            return fault(why, "name another requirement, or other steps of it".to_owned());
        }
        let limits = network.requirements.iter().zip(&names).filter(|(own, _)| own.name == *name);
        let limits: Vec<String> = limits.map(|(_, distinct)| format!("\"{distinct}\"")).collect();
        if !limits.is_empty() {
            let message = format!("`{name}` is the name of {} requirements", limits.len());
            return fault(message, format!("name one of them: {}", limits.join(", ")));
        }
        let known = ["length", "mass", "worst margin"].into_iter().chain(names.iter().map(String::as_str));
        fault(format!("there is no requirement `{name}` to minimise"), did_you_mean(name, known))
    });
    let counts = optimise.variables.iter().map(|variable| match &variable.choice {
        Choice::Values(values) => values.len(),
        Choice::Between { .. } => 1,
    });
    let combinations = counts.fold(1_usize, usize::saturating_mul);
    let many = (combinations > MAX_COMBINATIONS).then(|| Fault {
        span: optimise.span.clone(),
        message: format!("its lists of values have {combinations} combinations"),
        help: format!("at most {MAX_COMBINATIONS} are possible"),
    });
    variables.chain(terms).chain(many).collect()
}

/// Values to try before the work begins, so that the reader finds mistakes: every choice, and for every range the
/// file's own value in the unit of the range.
pub(crate) fn trials<'o>(
    optimise: &'o Optimise,
    text: &str,
    registry: &Registry,
) -> impl Iterator<Item = (&'o Variable, Setting)> {
    let all = optimise.variables.iter().flat_map(|variable| {
        let values = match &variable.choice {
            Choice::Values(values) => values.clone(),
            Choice::Between { unit, .. } => {
                let own = number_at(text, &variable.key, registry).ok();
                own.map(|own| Value::number(own.value, unit)).into_iter().collect()
            }
        };
        values.into_iter().map(move |value| (variable, Setting::new(&variable.key, &value.text)))
    });
    all.collect::<Vec<_>>().into_iter()
}

/// Faults of a trial, at the place of its key in the optimisation.
pub(crate) fn placed(variable: &Variable, trial: &Setting, faults: Vec<Fault>) -> Vec<Fault> {
    let place = |fault: Fault| Fault {
        span: variable.span.clone(),
        message: format!("with `{}` = {}: {}", variable.key, trial.value, fault.message),
        help: fault.help,
    };
    faults.into_iter().take(1).map(place).collect()
}
