//! The unknowns of a fit: numbers of the scenario, as θ in which their deviations are alike.

use super::least_squares::Prior;
use nalgebra::DVector;
use wireloom_core::{Registry, Value};
use wireloom_scenario::record::{value_at, with_json, with_value};
use wireloom_scenario::{ByRule, Fault, Scenario, number_at};

/// Units of quantities that are positive, and uncertain by a factor.
const OF_FACTORS: [&str; 8] = ["N m²", "N", "N/m", "N m", "N m/rad", "kg/m", "kg", "Pa"];
/// Keys of other numbers that are positive.
const POSITIVE: [&str; 5] = ["length", "diameter", "radius", "thickness", "yield_curvature"];
/// Units of stiffness and of the moment at which an element slips.
const STIFF: [&str; 5] = ["N m²", "N", "N/m", "N m", "N m/rad"];
/// Factor to both sides of the start that an unknown may reach, if it has no other bounds.
const LARGEST_FACTOR: f64 = 1e4;
/// The same for numbers that are no factors, in units of their scale.
const LARGEST_MOVE: f64 = 30.0;
/// Factor that is one deviation of a weak prior.
const WEAK_FACTOR: f64 = 10.0;
/// The same for numbers that are no factors, in units of their scale.
const WEAK_MOVE: f64 = 10.0;
/// Largest distance of other starts from the start of a stiffness: a factor of ten.
const SPREAD_FACTOR: f64 = 10.0;
/// The same for a curvature, in units of its scale: radians over the longest branch.
const SPREAD_TURN: f64 = 2.0;
/// The same in deviations of the prior.
const SPREAD_PRIOR: f64 = 2.0;
/// Deviations of the rule for sections of wires, relative: `library/README.md` of the crate `scenario`, "Uncertainty".
/// Bending and torsion are known to a factor of two.
const OF_RULE: [(&str, f64); 5] = [
    ("bending_stiffness", std::f64::consts::LN_2),
    ("torsion_stiffness", std::f64::consts::LN_2),
    ("linear_density", 0.1),
    ("axial_stiffness", 0.1),
    ("diameter", 0.08),
];

/// What is known of an unknown before the fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Knowledge {
    /// What the user gave.
    Given,
    /// The rule for sections of wires.
    Rule,
    /// Hardly anything: it only keeps an unknown that no point depends on where it is.
    Weak,
}

impl Knowledge {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Knowledge::Given => "given",
            Knowledge::Rule => "rule of the wires",
            Knowledge::Weak => "weak",
        }
    }
}

/// An unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Path to its key.
    pub key: String,
    /// SI unit.
    pub unit: String,
    /// Value at the start, SI.
    pub start: f64,
    /// Whether θ is its logarithm; otherwise θ is the value over [`Self::scale`].
    pub logarithm: bool,
    /// Size of a change that matters, SI: where θ is the logarithm, the value itself.
    pub scale: f64,
    /// Bounds, SI.
    pub bounds: [f64; 2],
    /// Prior value and deviation, SI.
    pub prior: [f64; 2],
    /// What the prior is.
    pub knowledge: Knowledge,
}

impl Unknown {
    /// θ of a value.
    pub fn theta(&self, value: f64) -> f64 {
        if self.logarithm { value.ln() } else { value / self.scale }
    }

    /// The value at θ.
    pub fn value(&self, theta: f64) -> f64 {
        if self.logarithm { theta.exp() } else { theta * self.scale }
    }

    /// Derivative of the value by θ.
    pub fn slope(&self, theta: f64) -> f64 {
        if self.logarithm { theta.exp() } else { self.scale }
    }

    /// Bounds of θ.
    pub fn theta_bounds(&self) -> [f64; 2] {
        self.bounds.map(|bound| if self.logarithm && bound <= 0.0 { f64::NEG_INFINITY } else { self.theta(bound) })
    }

    /// The prior of θ number `i`.
    pub fn prior(&self, i: usize) -> Prior {
        let [value, deviation] = self.prior;
        Prior { terms: vec![(i, 1.0)], value: self.theta(value), deviation: deviation / self.slope(self.theta(value)) }
    }

    /// Largest distance of other starts from its own, in θ; 0 for numbers that are known well enough, such as lengths.
    pub fn spread(&self) -> f64 {
        let widest = match self.is_stiffness() {
            true => SPREAD_FACTOR.ln(),
            false if self.unit == "1/m" => SPREAD_TURN,
            false => 0.0,
        };
        widest.min(SPREAD_PRIOR * self.prior(0).deviation)
    }

    /// Whether it is a stiffness, or the moment or force at which something slips.
    pub fn is_stiffness(&self) -> bool {
        self.logarithm && STIFF.contains(&&*self.unit)
    }
}

/// What the user says of the unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wishes<'a> {
    /// Keys to fit.
    pub fit: &'a [String],
    /// Keys with prior values and deviations, SI.
    pub priors: &'a [(String, [f64; 2])],
    /// Keys with bounds, SI.
    pub bounds: &'a [(String, [f64; 2])],
    /// Lists of keys whose neighbours differ by this deviation, SI.
    pub smooth: &'a [(Vec<String>, f64)],
}

/// The unknowns, and the text in which each of them is written out.
pub fn unknowns(
    text: &str,
    scenario: &Scenario,
    registry: &Registry,
    wishes: Wishes<'_>,
) -> Result<(Vec<Unknown>, String), String> {
    if wishes.fit.is_empty() {
        return Err("no key to fit: name keys that hold a number, such as sections.cable.bending_stiffness".to_owned());
    }
    let longest = scenario.branches.iter().map(|branch| branch.length).fold(0.0, f64::max);
    let mut text = text.to_owned();
    let mut all: Vec<Unknown> = Vec::with_capacity(wishes.fit.len());
    for key in wishes.fit {
        if all.iter().any(|other| other.key == *key) {
            return Err(format!("`{key}` is named twice"));
        }
        let by_rule = value_by_rule(scenario, key);
        if let (Err(_), Some((value, _))) = (number_at(&text, key, registry), by_rule) {
            text = with_value(&text, key, &Value::Number(value), registry).map_err(in_words)?;
        }
        text = with_rest_curvature(text, scenario, key, registry).map_err(in_words)?;
        let number = number_at(&text, key, registry).map_err(in_words)?;
        let last = key.rsplit('.').find(|part| part.parse::<usize>().is_err()).unwrap_or_default();
        let is_factor = OF_FACTORS.contains(&&*number.unit) && last != "coupling_stiffness";
        let positive = is_factor || POSITIVE.contains(&last);
        let logarithm = positive && number.value > 0.0;
        // A length matters by a tenth of the longest branch, a curvature by one radian over it.
        let natural = match &*number.unit {
            "m" => 0.1 * longest,
            "1/m" => 1.0 / longest,
            "rad" | "" => 1.0,
            _ if number.scale > 0.0 => number.scale,
            _ => 1.0,
        };
        let (start, scale) = (number.value, if logarithm { number.value } else { natural });
        let (bounds, weak) = if logarithm {
            ([start / LARGEST_FACTOR, start * LARGEST_FACTOR], WEAK_FACTOR.ln() * start)
        } else {
            ([start - LARGEST_MOVE * scale, start + LARGEST_MOVE * scale], WEAK_MOVE * scale)
        };
        let (prior, knowledge) = match by_rule.filter(|_| logarithm) {
            Some((value, relative)) => ([value, relative * value], Knowledge::Rule),
            None => ([start, weak], Knowledge::Weak),
        };
        let (key, unit) = (key.clone(), number.unit);
        all.push(Unknown { key, unit, start, logarithm, scale, bounds, prior, knowledge });
    }
    for (key, [value, deviation]) in wishes.priors {
        let own = named(&mut all, key, "a prior")?;
        if !(deviation.is_finite() && *deviation > 0.0 && value.is_finite()) {
            return Err(format!(
                "the prior of `{key}`, {value} with deviation {deviation}: the deviation must be above 0"
            ));
        }
        if own.logarithm && *value <= 0.0 {
            return Err(format!(
                "the prior of `{key}` is {value}: it must be above 0, as the value of the scenario is"
            ));
        }
        (own.prior, own.knowledge) = ([*value, *deviation], Knowledge::Given);
    }
    for (key, [low, high]) in wishes.bounds {
        let own = named(&mut all, key, "bounds")?;
        if !(low < high && low.is_finite() && high.is_finite()) {
            return Err(format!("the bounds of `{key}`, {low} and {high}: the first must be below the second"));
        }
        if !(*low..=*high).contains(&own.start) {
            let Unknown { start, unit, .. } = own;
            return Err(format!(
                "the bounds of `{key}`, {low} and {high}, exclude its start in the scenario, {start} {unit}"
            ));
        }
        own.bounds = [*low, *high];
    }
    Ok((all, text))
}

/// The text with the values of the unknowns at θ; comments stay.
///
/// # Errors
/// If a value cannot be written.
pub fn with_values(
    text: &str,
    unknowns: &[Unknown],
    theta: &DVector<f64>,
    registry: &Registry,
) -> Result<String, String> {
    let mut text = text.to_owned();
    for (unknown, theta) in unknowns.iter().zip(theta) {
        let value = Value::Number(unknown.value(*theta));
        text = with_value(&text, &unknown.key, &value, registry).map_err(|fault| fault.message)?;
    }
    Ok(text)
}

/// The priors that hold neighbours to each other.
pub fn smoothness(all: &[Unknown], smooth: &[(Vec<String>, f64)]) -> Result<Vec<Prior>, String> {
    let mut priors = Vec::new();
    for (keys, deviation) in smooth {
        if !(deviation.is_finite() && *deviation > 0.0) || keys.len() < 2 {
            let message = "smoothness needs two keys or more, and a deviation of neighbours above 0";
            return Err(format!("{message}: {} with {deviation}", keys.join(",")));
        }
        for pair in keys.windows(2) {
            let index = |key: &String| {
                let found = all.iter().position(|own| own.key == *key);
                found.ok_or_else(|| format!("smoothness is asked for `{key}`, which is not fitted"))
            };
            let [one, other] = [index(&pair[0])?, index(&pair[1])?];
            let difference = |i: usize, sign: f64| (i, sign * all[i].slope(all[i].theta(all[i].start)));
            let terms = vec![difference(other, 1.0), difference(one, -1.0)];
            // The difference of logarithms is that of the values at the start.
            priors.push(Prior { terms, value: 0.0, deviation: *deviation });
        }
    }
    Ok(priors)
}

/// The text in which the rest curvature that a key names is written out: left out, it is zero.
fn with_rest_curvature(text: String, scenario: &Scenario, key: &str, registry: &Registry) -> Result<String, Fault> {
    let list = key.rsplit_once('.').filter(|(list, _)| list.ends_with(".curvature")).map(|(list, _)| list);
    let is_of = |list: &str, branch: &str| {
        let own = list.strip_prefix("branches.").and_then(|rest| rest.strip_suffix(".curvature"));
        own.is_some_and(|own| own.trim_matches(['"', '\'']) == branch)
    };
    match list {
        Some(list)
            if scenario.branches.iter().any(|branch| is_of(list, &branch.name)) && value_at(&text, list).is_err() =>
        {
            with_json(&text, list, &serde_json::json!([0.0, 0.0, 0.0]), registry)
        }
        _ => Ok(text),
    }
}

fn named<'a>(all: &'a mut [Unknown], key: &str, what: &str) -> Result<&'a mut Unknown, String> {
    let found = all.iter_mut().find(|own| own.key == key);
    found.ok_or_else(|| format!("{what} for `{key}`, which is not fitted"))
}

fn in_words(Fault { message, help, .. }: Fault) -> String {
    format!("{message}: {help}")
}

/// Value of a section's key by the rule of its wires, and its relative deviation.
fn value_by_rule(scenario: &Scenario, key: &str) -> Option<(f64, f64)> {
    let rest = key.strip_prefix("sections.")?;
    let (section, name) = rest.rsplit_once('.')?;
    let (_, deviation) = OF_RULE.into_iter().find(|(own, _)| *own == name)?;
    let named = |own: &&ByRule| scenario.sections[own.section].name == section.trim_matches(['"', '\'']);
    let ByRule { bundle, .. } = scenario.by_rule.iter().find(named)?;
    let value = match name {
        "bending_stiffness" => bundle.bending.taken,
        "torsion_stiffness" => bundle.torsion.taken,
        "linear_density" => bundle.linear_density,
        "axial_stiffness" => bundle.axial_stiffness,
        _ => bundle.diameter,
    };
    Some((value, deviation))
}
