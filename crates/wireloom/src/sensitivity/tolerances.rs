//! How tolerances of parameters spread outputs.

use super::Study;
use super::answer::{NoAnswer, Output, Parameter, Sensitivities, Source, Spread, Tolerance};
use wireloom_core::Value;
use wireloom_scenario::record::with_value;
use wireloom_scenario::sweep::Range;

/// Variance by curvature, relative to the whole, from which on an output is told to be curved.
const CURVED: f64 = 0.1;
/// Difference between the effect of a tolerance and what the derivative says of it, relative to the larger one, from
/// which on it is told.
const OTHER_THAN_DERIVATIVE: f64 = 0.15;
/// Effect, relative to the standard deviation by all, below which it does not matter.
const SMALL: f64 = 0.1;

/// An output in a run.
#[derive(Clone, Copy)]
struct Point {
    value: f64,
    /// Distance from the limit of a requirement; below 0 beyond it.
    gap: Option<f64>,
}

/// All outputs in a run, or why there are none.
type Points = Result<Vec<Option<Point>>, String>;

impl Study<'_> {
    /// How the scenario's sweep spreads the number at a key.
    pub(super) fn tolerance(&self, key: &str) -> Option<Tolerance> {
        let axis = self.scenario.sweep.iter().flat_map(|sweep| &sweep.axes).find(|axis| axis.key == key)?;
        let tolerance = match axis.range {
            Range::Values(_) => return None,
            Range::Uniform { from, to, .. } => {
                Tolerance { mean: 0.5 * (from + to), deviation: (to - from) / 12.0_f64.sqrt(), is_uniform: true }
            }
            Range::Normal { mean, deviation, .. } => Tolerance { mean, deviation, is_uniform: false },
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
        let axes = self.scenario.sweep.iter().flat_map(|sweep| &sweep.axes).map(|axis| &axis.key);
        let in_it = |key: &&String| found.parameters.iter().any(|own| own.key == **key && own.tolerance.is_some());
        found.tolerances_left_out = axes.filter(|key| !in_it(key)).cloned().collect();
        let here = self.points(&found.outputs, step);
        let names: Vec<String> = found.outputs.iter().map(|output| output.name.clone()).collect();
        let mut runs = Vec::with_capacity(found.parameters.len());
        for parameter in &found.parameters {
            let Some(Tolerance { mean, deviation, .. }) = parameter.tolerance else {
                runs.push(None);
                continue;
            };
            let middle = if mean == parameter.value {
                Ok(here.clone())
            } else {
                self.changed(&parameter.key, mean, step, &names)?
            };
            runs.push(Some([
                self.changed(&parameter.key, mean - deviation, step, &names)?,
                middle,
                self.changed(&parameter.key, mean + deviation, step, &names)?,
            ]));
        }
        for (k, (output, here)) in found.outputs.iter_mut().zip(here).enumerate() {
            output.spread = here.and_then(|here| spread(output, here, k, &found.parameters, &runs));
        }
        Ok(found)
    }

    /// Values of outputs at the end of a step, with their distances from limits.
    fn points(&self, outputs: &[Output], step: usize) -> Vec<Option<Point>> {
        let lines = &self.ends[step + 1].requirements;
        let point = |output: &Output| {
            let line = lines.iter().find(|line| line.name == output.name);
            let value = output.value?;
            Some(Point { value, gap: line.map(|line| line.bound.gap(value, line.limit)) })
        };
        outputs.iter().map(point).collect()
    }

    /// Outputs at the end of a step of the scenario with another number at a key.
    fn changed(&self, key: &str, to: f64, step: usize, names: &[String]) -> Result<Points, NoAnswer> {
        let refused = |message: &str| Ok(Err(format!("{key} = {to}: {message}")));
        let text = match with_value(&self.source.text, key, &Value::Number(to), self.source.registry) {
            Ok(text) => text,
            Err(fault) => return refused(&fault.message),
        };
        let source = Source { text: text.into(), ..self.source.clone() };
        let found = Study::on_mesh_of(source, &self.scenario).and_then(|mut other| {
            other.start_near(&self.network, &self.ends[0].checkpoint);
            other.run_to(step)?;
            let found = other.derivatives((step, other.steps[step].increments), names, &[])?;
            Ok(other.points(&found.outputs, step))
        });
        match found {
            Ok(points) => Ok(Ok(points)),
            Err(none @ (NoAnswer::Stopped | NoAnswer::Part(_))) => Err(none),
            Err(NoAnswer::Faults(faults)) => refused(faults.first().map_or("", |fault| fault.message.as_str())),
            Err(none) => refused(&none.to_string()),
        }
    }
}

/// A parabola through a quantity at −σ, 0 and σ from the mean of a parameter, in units of σ.
struct Parabola {
    middle: f64,
    slope: f64,
    bend: f64,
}

impl Parabola {
    fn new([below, middle, above]: [f64; 3]) -> Self {
        Self { middle, slope: 0.5 * (above - below), bend: 0.5 * (above - middle + (below - middle)) }
    }

    /// The mean, and the standard deviation that the tolerance makes, with the sign of the slope.
    fn moments(&self, tolerance: &Tolerance) -> (f64, f64) {
        (self.middle + self.bend, self.slope.hypot(self.bend * bend_factor(tolerance)).copysign(self.slope))
    }
}

/// Standard deviation of z², with z of mean 0 and variance 1.
fn bend_factor(tolerance: &Tolerance) -> f64 {
    if tolerance.is_uniform { 0.8_f64.sqrt() } else { 2.0_f64.sqrt() }
}

/// How an output is spread, of which this is the number; `runs`: one standard deviation below the mean, at it and above
/// it, for each parameter with a tolerance.
fn spread(
    output: &Output,
    here: Point,
    number: usize,
    parameters: &[Parameter],
    runs: &[Option<[Points; 3]>],
) -> Option<Spread> {
    let mut spread = Spread { mean: here.value, ..Spread::default() };
    // Mean and variance of the distance from the limit.
    let mut gap = here.gap.map(|gap| (gap, 0.0));
    let (mut curved, mut others) = (0.0, Vec::new());
    for ((parameter, derivative), runs) in parameters.iter().zip(&output.by).zip(runs) {
        let (Some(tolerance), Some(runs)) = (&parameter.tolerance, runs) else {
            spread.parts.push(0.0);
            continue;
        };
        let key = &parameter.key;
        let by_slope = derivative.value.map(|slope| slope * tolerance.deviation);
        let at = |run: &Points| run.as_ref().ok().and_then(|points| points[number]);
        let parabola = match runs.each_ref().map(at) {
            [Some(below), Some(middle), Some(above)] => {
                let points = [below, middle, above];
                gap = gap.zip(here.gap).and_then(|((mean, variance), own)| {
                    let [below, middle, above] = points.map(|point| point.gap);
                    let (moved, part) = Parabola::new([below?, middle?, above?]).moments(tolerance);
                    Some((mean + moved - own, variance + part * part))
                });
                Parabola::new(points.map(|point| point.value))
            }
            _ => {
                let why = runs.iter().find_map(|run| run.as_ref().err());
                let why =
                    why.cloned().unwrap_or_else(|| format!("{key}: it has no value at its mean or on one side of it"));
                spread.remark.get_or_insert(why);
                gap = None;
                let slope = by_slope?;
                let from_value = (tolerance.mean - parameter.value) / tolerance.deviation;
                Parabola { middle: here.value + slope * from_value, slope, bend: 0.0 }
            }
        };
        let apart = by_slope.is_some_and(|by_slope| {
            (by_slope - parabola.slope).abs() > OTHER_THAN_DERIVATIVE * by_slope.abs().max(parabola.slope.abs())
        });
        let (moved, part) = parabola.moments(tolerance);
        if apart {
            others.push((key, parabola.slope.abs().max(by_slope.unwrap_or(0.0).abs())));
        }
        curved += (parabola.bend * bend_factor(tolerance)).powi(2);
        spread.mean += moved - here.value;
        spread.parts.push(part);
    }
    let variance: f64 = spread.parts.iter().map(|part| part * part).sum();
    spread.deviation = variance.sqrt();
    if curved > CURVED * variance {
        spread.remark.get_or_insert_with(|| "it is curved within the tolerances".to_owned());
    }
    if let Some((key, _)) = others.iter().find(|(_, effect)| *effect > SMALL * spread.deviation) {
        spread.remark.get_or_insert_with(|| format!("within its tolerance {key} does other than its derivative says"));
    }
    // A worst value that is elsewhere on the path is another one than this.
    let to_limit = gap.filter(|_| output.remark.is_none()).map(|(mean, variance)| mean / variance.sqrt());
    spread.deviations_to_limit = to_limit.filter(|deviations| deviations.is_finite());
    Some(spread)
}
