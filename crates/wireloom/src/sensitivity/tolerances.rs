//! How tolerances of parameters spread outputs.

use super::Study;
use super::answer::{NoAnswer, Output, Parameter, Sensitivities, Source, Spread, Tolerance};
use wireloom_core::Value;
use wireloom_core::requirement::Bound;
use wireloom_scenario::record::with_value;
use wireloom_scenario::sweep::Range;

/// Variance by curvature, relative to that of what is in proportion, from which on an output is curved: its standard
/// deviation is then some 5 % larger.
const CURVED: f64 = 0.1;

/// Values of all outputs in a run, or why there are none.
type Values = Result<Vec<Option<f64>>, String>;

impl Study<'_> {
    /// How the scenario's sweep spreads the number at a key.
    pub(super) fn tolerance(&self, key: &str) -> Option<Tolerance> {
        let axis = self.scenario.sweep.iter().flat_map(|sweep| &sweep.axes).find(|axis| axis.key == key)?;
        let tolerance = match axis.range {
            Range::Values(_) => return None,
            Range::Uniform { from, to, .. } => {
                Tolerance { mean: 0.5 * (from + to), deviation: (to - from) / 12.0_f64.sqrt() }
            }
            Range::Normal { mean, deviation, .. } => Tolerance { mean, deviation },
        };
        (tolerance.deviation > 0.0).then_some(tolerance)
    }

    /// The answer at the end of a step, with what tolerances do.
    ///
    /// # Errors
    /// If it was stopped, or a part failed.
    pub(super) fn with_spreads(&self, mut found: Sensitivities, step: usize) -> Result<Sensitivities, NoAnswer> {
        if found.parameters.iter().all(|parameter| parameter.tolerance.is_none()) {
            return Ok(found);
        }
        let names: Vec<String> = found.outputs.iter().map(|output| output.name.clone()).collect();
        let mut runs = Vec::with_capacity(found.parameters.len());
        for parameter in &found.parameters {
            runs.push(match parameter.tolerance {
                Some(Tolerance { deviation, .. }) => Some([
                    self.values(parameter, -deviation, step, &names)?,
                    self.values(parameter, deviation, step, &names)?,
                ]),
                None => None,
            });
        }
        for (k, output) in found.outputs.iter_mut().enumerate() {
            let line = self.ends[step + 1].requirements.iter().find(|line| line.name == output.name);
            let limit = line.map(|line| (line.bound, line.limit));
            output.spread = spread(output, k, &found.parameters, &runs, limit);
        }
        Ok(found)
    }

    /// Outputs at the end of a step of the scenario with another value of a parameter.
    fn values(&self, parameter: &Parameter, more: f64, step: usize, names: &[String]) -> Result<Values, NoAnswer> {
        let value = Value::Number(parameter.value + more);
        let refused = |message: &str| Ok(Err(format!("{} = {}: {message}", parameter.key, parameter.value + more)));
        let text = match with_value(&self.source.text, &parameter.key, &value, self.source.registry) {
            Ok(text) => text,
            Err(fault) => return refused(&fault.message),
        };
        let source = Source { text: text.into(), ..self.source.clone() };
        let found = Study::on_mesh_of(source, &self.scenario).and_then(|mut other| {
            (self.requirements)(&mut other.network);
            other.start_near(&self.network, &self.ends[0].checkpoint);
            other.run_to(step)?;
            other.derivatives((step, other.steps[step].increments), names, &[])
        });
        match found {
            Ok(found) => Ok(Ok(found.outputs.into_iter().map(|output| output.value).collect())),
            Err(none @ (NoAnswer::Stopped | NoAnswer::Part(_))) => Err(none),
            Err(NoAnswer::Faults(faults)) => refused(faults.first().map_or("", |fault| fault.message.as_str())),
            Err(none) => refused(&none.to_string()),
        }
    }
}

/// How an output is spread, of which this is the number; `runs`: below and above, for each parameter with a tolerance.
fn spread(
    output: &Output,
    number: usize,
    parameters: &[Parameter],
    runs: &[Option<[Values; 2]>],
    limit: Option<(Bound, f64)>,
) -> Option<Spread> {
    let value = output.value?;
    let mut spread = Spread { mean: value, ..Spread::default() };
    let mut curvature = 0.0;
    for ((parameter, derivative), runs) in parameters.iter().zip(&output.by).zip(runs) {
        let (Some(Tolerance { mean, deviation }), Some([below, above])) = (parameter.tolerance, runs) else {
            spread.parts.push(0.0);
            continue;
        };
        let at = |run: &Values| run.as_ref().ok().and_then(|values| values[number]);
        let part = match at(below).zip(at(above)) {
            Some((below, above)) => {
                let bent = 0.5 * (above - value + (below - value));
                curvature += 2.0 * bent * bent;
                spread.mean += bent;
                0.5 * (above - below)
            }
            None => {
                let why = [below, above].into_iter().find_map(|run| run.as_ref().err());
                let why = why.cloned().unwrap_or_else(|| format!("{}: it has no value on one side", parameter.key));
                spread.remark.get_or_insert(why);
                derivative.value? * deviation
            }
        };
        spread.mean += derivative.value.unwrap_or(part / deviation) * (mean - parameter.value);
        spread.parts.push(part);
    }
    let variance: f64 = spread.parts.iter().map(|part| part * part).sum();
    spread.deviation = variance.sqrt();
    if curvature > CURVED * variance {
        spread.remark.get_or_insert_with(|| "it is curved within the tolerances".to_owned());
    }
    let to_limit = limit.map(|(bound, limit)| bound.gap(spread.mean, limit) / spread.deviation);
    spread.deviations_to_limit = to_limit.filter(|deviations| deviations.is_finite());
    Some(spread)
}
