//! Differences of outputs at two equilibria nearby, one for a smaller and one for a larger value of a parameter.

use super::answer::{Derivative, NoAnswer, Parameter, Source};
use super::outputs::{Asked, Catalogue, Measured};
use wireloom_core::Network;
use wireloom_core::conditions::Partner;
use wireloom_scenario::{Scenario, Setting};
use wireloom_solve::steps::nearby::Neighbourhood;

/// Step of a parameter as a fraction of its size: the error of a central difference is about the square of it.
const STEP: f64 = 1e-4;
/// Step of a parameter that is zero, SI, before it is known how far it moves the harness.
const STEP_FROM_ZERO: f64 = 1e-6;
/// Largest step of such a parameter, SI.
const LARGEST_FROM_ZERO: f64 = 1e-2;
/// Distance that a step should move the harness: move relative to the longest branch, or turn (rad). Higher-order
/// terms grow with its square times EA L²/EI, differences of forces are round-off of EA over it.
pub(super) const MOVES: f64 = 2e-4;
/// Distance from which on a step is made smaller.
const FAR: f64 = 1e-3;
/// Distance up to which a step is made larger.
const NEAR: f64 = 5e-5;
/// Largest step of a parameter that hardly moves the harness, as a fraction of its size.
const LARGEST_STEP: f64 = 3e-4;
/// Number of times that a step is changed.
const STEP_CHANGES: usize = 3;
/// Factor on a step at which no equilibrium was found.
const CUT: f64 = 1.0 / 30.0;
/// Factor on the step of a second pair of differences.
const CLOSER: f64 = 0.25;
/// Difference of the derivatives to both sides, relative to the larger one, up to which one pair of differences is
/// enough: the error of their mean is about the square of it.
const AGREE: f64 = 5e-4;
/// Difference of the means of two pairs, relative to the larger derivative, of a smooth function.
const SMOOTH: f64 = 1e-2;
/// Ratio of the differences of the derivatives to both sides of the closer pair and of the first one, for a smooth
/// function: [`CLOSER`], with room for higher orders.
const SHRINKS: [f64; 2] = [0.15, 0.4];

/// The neighbourhood of an equilibrium.
pub(super) trait Around {
    /// Results with another value of a parameter, or why there are none.
    ///
    /// # Errors
    /// If it was stopped.
    fn at(&mut self, parameter: &Parameter, value: f64) -> Result<Result<Measured, String>, NoAnswer>;

    /// Name of a branch and what it touches at a contact point.
    fn words(&self, touching: (u32, Partner)) -> String;
}

/// The neighbourhood by any number of a scenario.
pub(super) struct OfScenario<'a, 'n> {
    pub source: &'a Source<'a>,
    pub scenario: &'a Scenario,
    pub catalogue: &'a Catalogue,
    /// Changes the requirements of every network that is built of the scenario.
    pub requirements: fn(&mut Network),
    pub neighbourhood: Neighbourhood<'n>,
    /// Whether requirements are asked for.
    pub sheet: bool,
}

/// Results with a smaller and a larger value of a parameter, or why there are none.
type Pair = [Result<Measured, String>; 2];

impl Around for OfScenario<'_, '_> {
    fn at(&mut self, parameter: &Parameter, value: f64) -> Result<Result<Measured, String>, NoAnswer> {
        let Source { text, files, registry, monitor } = self.source;
        if monitor.is_stopped() {
            return Err(NoAnswer::Stopped);
        }
        let built = crate::load_with_settings(text, &[Setting::number(&parameter.key, value)], *files, registry)
            .and_then(|(mut scenario, built)| {
                let built = if scenario.keep_mesh_of(self.scenario) { scenario.build(registry)? } else { built };
                Ok((scenario, built))
            });
        let (scenario, mut built) = match built {
            Ok(built) => built,
            Err(faults) => {
                let first = faults.first().map_or("", |fault| fault.message.as_str());
                return Ok(Err(format!("{value} is refused: {first}")));
            }
        };
        (self.requirements)(&mut built.network);
        let found = self.neighbourhood.find(&built.network, &built.schedule, built.minimiser.as_mut(), self.sheet);
        Ok(match found {
            Ok(near) => Ok(self.catalogue.measured(&scenario, &built.network, near)),
            Err(reason) => Err(reason.to_string()),
        })
    }

    fn words(&self, touching: (u32, Partner)) -> String {
        self.neighbourhood.words(touching)
    }
}

/// Derivatives of all outputs by a parameter.
pub(super) fn derivatives(
    around: &mut dyn Around,
    parameter: &Parameter,
    here: &Measured,
    outputs: &[Asked],
) -> Result<Vec<Derivative>, NoAnswer> {
    let (mut h, mut first) = suitable_step(around, parameter)?;
    let mut closer = None;
    if let [Ok(_), Err(_)] | [Err(_), Ok(_)] = first {
        // What one side alone did not find may lie nearer.
        let nearer = both_sides(around, parameter, CLOSER * h)?;
        if nearer.iter().all(Result::is_ok) {
            (h, first) = (CLOSER * h, nearer);
        } else {
            closer = Some(nearer);
        }
    }
    let mut all = Vec::with_capacity(outputs.len());
    for asked in outputs {
        let Some(value) = asked.value else {
            let reason = Some("it has no value here".to_owned());
            all.push(Derivative { reason, ..Derivative::default() });
            continue;
        };
        let one = Differences::new(asked, value, h, &first);
        if one.agree(asked) && !differs(&first, &asked.name) {
            all.push(Derivative { value: one.central(), ..Derivative::default() });
            continue;
        }
        // Curvature shrinks with the step; a kink does not.
        let pair = match &closer {
            Some(pair) => pair,
            None => closer.insert(both_sides(around, parameter, CLOSER * h)?),
        };
        let two = Differences::new(asked, value, CLOSER * h, pair);
        // A closer pair alone shows nothing: it may be between two kinks.
        let smooth = two.are_curved(&one, asked);
        // Of both pairs, without the error of second order (Richardson).
        let extrapolated = || Some((two.central()? - CLOSER * CLOSER * one.central()?) / (1.0 - CLOSER * CLOSER));
        all.push(if smooth && !differs(pair, &asked.name) {
            Derivative { value: extrapolated(), ..Derivative::default() }
        } else {
            Derivative { value: None, sides: two.sides, reason: Some(reason(around, here, pair, &asked.name)) }
        });
    }
    Ok(all)
}

/// A step that moves the harness neither too far nor too little, and the results of both sides.
fn suitable_step(around: &mut dyn Around, parameter: &Parameter) -> Result<(f64, Pair), NoAnswer> {
    let scale = parameter.scale;
    let largest = if scale > 0.0 { LARGEST_STEP * scale } else { LARGEST_FROM_ZERO };
    let mut h = if scale > 0.0 { STEP * scale } else { STEP_FROM_ZERO };
    let mut pair = both_sides(around, parameter, h)?;
    for _ in 0..STEP_CHANGES {
        let distances = pair.iter().flatten().map(|measured| measured.near.distance);
        let next = match distances.reduce(f64::max) {
            None => CUT * h,
            Some(distance) if distance > FAR => h * MOVES / distance,
            Some(distance) if distance > 0.0 && distance < NEAR => (h * MOVES / distance).min(largest),
            Some(_) => break,
        };
        if next == h {
            break;
        }
        h = next;
        pair = both_sides(around, parameter, h)?;
    }
    Ok((h, pair))
}

/// Results of both sides.
fn both_sides(around: &mut dyn Around, parameter: &Parameter, h: f64) -> Result<Pair, NoAnswer> {
    Ok([around.at(parameter, parameter.value - h)?, around.at(parameter, parameter.value + h)?])
}

/// Why an output has no derivative.
fn reason(around: &dyn Around, here: &Measured, pair: &Pair, name: &str) -> String {
    let [below, above] = match pair {
        [Err(reason), Err(_)] => return reason.clone(),
        [Err(reason), Ok(_)] => return format!("towards smaller values: {reason}"),
        [Ok(_), Err(reason)] => return format!("towards larger values: {reason}"),
        [Ok(below), Ok(above)] => [below, above],
    };
    let touching = [&below.near.touching, &here.near.touching, &above.near.touching];
    let changes = touching[0].symmetric_difference(touching[2]);
    if let Some(changed) = changes.chain(touching[0].symmetric_difference(touching[1])).next() {
        return format!("contact changes here, between {}", around.words(*changed));
    }
    if below.value(name).is_none() || above.value(name).is_none() {
        return "it has no value on one side".to_owned();
    }
    match (below.place(name), above.place(name)) {
        (Some(one), Some(other)) if below.is_elsewhere(one, other) => {
            format!("the worst place changes here: {one}, or {other}")
        }
        _ => "its slopes to both sides differ".to_owned(),
    }
}

/// Whether different points touch, or another place is the worst, on the two sides.
fn differs(pair: &Pair, name: &str) -> bool {
    let [Ok(below), Ok(above)] = pair else { return true };
    let elsewhere = match (below.place(name), above.place(name)) {
        (Some(one), Some(other)) => below.is_elsewhere(one, other),
        (one, other) => one.is_some() != other.is_some(),
    };
    elsewhere || below.near.touching != above.near.touching
}

/// Differences of an output to both sides.
struct Differences {
    h: f64,
    sides: [Option<f64>; 2],
}

impl Differences {
    fn new(asked: &Asked, value: f64, h: f64, [below, above]: &Pair) -> Self {
        let at = |side: &Result<Measured, String>| side.as_ref().ok().and_then(|measured| measured.value(&asked.name));
        Self { h, sides: [at(below).map(|below| (value - below) / h), at(above).map(|above| (above - value) / h)] }
    }

    /// The central difference.
    fn central(&self) -> Option<f64> {
        let [below, above] = self.sides;
        Some(0.5 * (below? + above?))
    }

    /// Difference of both, and the larger one.
    fn gap(&self) -> Option<(f64, f64)> {
        let [below, above] = self.sides;
        let (below, above) = (below?, above?);
        Some(((above - below).abs(), above.abs().max(below.abs())))
    }

    /// Whether they agree so well that the central difference is exact.
    fn agree(&self, asked: &Asked) -> bool {
        self.gap().is_some_and(|(gap, larger)| gap <= AGREE * larger + 4.0 * asked.noise / self.h)
    }

    /// Whether they differ as curvature makes them, beside those of a larger step: in proportion to the step, with the
    /// same central difference.
    fn are_curved(&self, wider: &Differences, asked: &Asked) -> bool {
        let (Some((gap, _)), Some((wide, larger))) = (self.gap(), wider.gap()) else { return false };
        let (Some(one), Some(other)) = (self.central(), wider.central()) else { return false };
        let noise = 4.0 * asked.noise / self.h;
        let [least, most] = SHRINKS;
        least * wide - noise <= gap
            && gap <= most * wide + noise
            && (one - other).abs() <= SMOOTH * larger.max(wide) + noise
    }
}
