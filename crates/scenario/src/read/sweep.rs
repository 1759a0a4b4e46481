//! Reads sweeps.

use super::entry::Entry;
use super::names::Names;
use super::sweep_outputs;
use crate::fault::did_you_mean;
use crate::format::units;
use crate::span::Span;
use crate::sweep::{
    Axis, Condition, Design, MAX_LISTED, MAX_POINTS, MAX_SOBOL_KEYS, Method, Output, Range, Sweep, Value,
};
use toml::Spanned;
use toml::de::DeValue;
use wireloom_core::steps::Step;

/// Reads a sweep; `None` if it is faulty.
pub(crate) fn sweep(entry: &Entry<'_>, names: &Names<'_>, steps: &[Step]) -> Option<Sweep> {
    let before = entry.reader.fault_count();
    let method = match entry.choice("method").unwrap_or("grid") {
        "zip" => Method::Zip,
        "random" => Method::Random,
        "latin-hypercube" => Method::LatinHypercube,
        "sobol" => Method::Sobol,
        _ => Method::Grid,
    };
    let sampled = matches!(method, Method::Random | Method::LatinHypercube | Method::Sobol);
    let samples = entry.count("samples");
    if sampled && !entry.has("samples") {
        entry.fault_at("method", "a random sweep has no `samples`", "add the number of points: samples = 1000");
    }
    if !sampled && entry.has("samples") {
        entry.fault_at(
            "samples",
            "the number of points of this sweep follows from its lists",
            "leave out `samples`, or choose method = \"random\"",
        );
    }
    let seed = entry.count("seed").unwrap_or(0) as u64;
    let (crossed, varied) = (entry.named_entries("cross"), entry.named_entries("vary"));
    let mut axes: Vec<Axis> = crossed.iter().filter_map(|(key, varied)| axis(key, varied, false)).collect();
    axes.extend(varied.iter().filter_map(|(key, varied)| axis(key, varied, sampled)));
    if varied.is_empty() && entry.has("vary") {
        entry.fault_at(
            "vary",
            "no key varies",
            "add a key, such as \"branches.left.length\" = { from = 0.4, to = 0.5 }",
        );
    }
    for (key, varied) in &varied {
        if crossed.iter().any(|(other, _)| other == key) {
            varied.fault_here(format!("`{key}` is in `cross` and in `vary`"), "leave it in one of them");
        }
    }
    let measured = entry.named_entries("outputs");
    let outputs: Vec<Output> =
        measured.iter().filter_map(|(name, entry)| sweep_outputs::output(name, entry, names, steps)).collect();
    let (time_limit, swept) = (entry.number("time_limit"), entry.number("swept"));
    if entry.reader.fault_count() > before || varied.is_empty() {
        return None;
    }
    conditions(crossed.iter().chain(&varied), &mut axes)?;
    let crossed = crossed.len();
    let counts: Vec<usize> = axes.iter().map(|axis| axis.range.count()).collect();
    let product =
        |counts: &[usize]| counts.iter().try_fold(1_usize, |all, n| all.checked_mul(*n)).unwrap_or(usize::MAX);
    let samples = match method {
        Method::Grid => product(&counts[crossed..]),
        Method::Zip => {
            if let Some(k) = (crossed..counts.len()).find(|k| counts[*k] != counts[crossed]) {
                let [one, other] = [k, crossed].map(|k| format!("`{}` has {} values", axes[k].key, counts[k]));
                let help = "keys that vary together have as many values each";
                entry.reader.fault(axes[k].span.clone(), format!("{one}, {other}"), help);
                return None;
            }
            counts[crossed]
        }
        _ => samples.unwrap_or(1),
    };
    let whole = product(&counts[..crossed]).saturating_mul(samples);
    let conditional = axes.iter().any(|axis| !axis.when.is_empty());
    let (most, kind) = if conditional { (MAX_LISTED, " with `when`") } else { (MAX_POINTS, "") };
    if whole > most {
        entry.fault_here(format!("this sweep has {whole} points"), format!("at most {most} are possible{kind}"));
        return None;
    }
    if method == Method::Sobol && axes.len() - crossed > MAX_SOBOL_KEYS {
        entry.fault_here(
            format!("this sweep varies {} keys", axes.len() - crossed),
            format!("at most {MAX_SOBOL_KEYS} are possible with sobol"),
        );
        return None;
    }
    let design = Design { method, seed, axes, crossed, samples, whole };
    let mut sweep = Sweep::new(design);
    (sweep.outputs, sweep.time_limit, sweep.swept) = (outputs, time_limit, swept);
    Some(sweep)
}

/// Reads the conditions under which keys vary; `None`, with a fault, if they refer to nothing.
fn conditions<'e, 'a: 'e>(
    entries: impl Iterator<Item = &'e (&'a str, Entry<'a>)> + Clone,
    axes: &mut [Axis],
) -> Option<()> {
    let mut whole = Some(());
    let mut fault = |entry: &Entry<'_>, span: Span, message: String, help: String| {
        entry.reader.fault(span, message, help);
        whole = None;
    };
    let conditional: Vec<bool> = entries.clone().map(|(_, entry)| entry.has("when")).collect();
    for (k, (key, entry)) in entries.enumerate() {
        let mut when = Vec::new();
        for (other, values, span) in entry.conditions("when") {
            let Some(axis) = axes.iter().position(|axis| axis.key == other) else {
                let help = did_you_mean(other, axes.iter().map(|axis| axis.key.as_str()));
                fault(entry, span, format!("`when` of `{key}`: the sweep does not vary `{other}`"), help);
                continue;
            };
            let Range::Values(listed_values) = &axes[axis].range else {
                let message = format!("`when` of `{key}`: `{other}` has a range, not a list of values");
                fault(entry, span, message, "a condition needs a key with a list of values".to_owned());
                continue;
            };
            let values: Vec<Value> = values.iter().map(|node| listed(entry, node)).collect();
            if let Some(never) = values.iter().find(|value| !listed_values.iter().any(|listed| listed.is(value))) {
                let message = format!("`when` of `{key}`: `{other}` is never {}", never.text);
                let texts: Vec<&str> = listed_values.iter().map(|value| value.text.as_str()).collect();
                fault(entry, span, message, format!("it is one of {}", texts.join(", ")));
                continue;
            }
            if conditional[axis] {
                let message = format!("`when` of `{key}`: `{other}` does not vary everywhere itself");
                fault(entry, span, message, "a condition needs a key without `when`".to_owned());
                continue;
            }
            when.push(Condition { axis, values });
        }
        axes[k].when = when;
    }
    whole
}

fn axis(key: &str, entry: &Entry<'_>, sampled: bool) -> Option<Axis> {
    let given: Vec<&str> =
        ["values", "from", "to", "count", "mean", "deviation"].into_iter().filter(|name| entry.has(name)).collect();
    let range = match &given[..] {
        ["values"] => {
            let values: Vec<Value> = entry.values("values").iter().map(|node| listed(entry, node)).collect();
            if values.is_empty() {
                entry.fault_at("values", format!("`{key}` has no values"), "write a list, such as [0.4, \"500 mm\"]");
                return None;
            }
            Range::Values(values)
        }
        ["from", "to"] | ["from", "to", "count"] => {
            let (unit, [from, to]) = pair(entry, ["from", "to"])?;
            match (sampled, entry.count("count")) {
                (true, None) => Range::Uniform { from, to, unit },
                (false, Some(n)) => {
                    let at = |i: usize| from + (to - from) * i as f64 / (n - 1) as f64;
                    Range::Values((0..n).map(|i| Value::number(at(i), &unit)).collect())
                }
                (true, Some(_)) => {
                    let help = "leave it out, or choose method = \"grid\"";
                    entry.fault_at("count", format!("`count` of `{key}` has no meaning in a random sweep"), help);
                    return None;
                }
                (false, None) => {
                    let help = "add count = 5, or choose a method with samples, such as \"random\"";
                    entry.fault_here(format!("`{key}` has no `count`"), help);
                    return None;
                }
            }
        }
        ["mean", "deviation"] if sampled => {
            let (unit, [mean, deviation]) = pair(entry, ["mean", "deviation"])?;
            if deviation < 0.0 {
                entry.fault_at(
                    "deviation",
                    format!("`deviation` of `{key}` is below zero"),
                    "give a standard deviation",
                );
                return None;
            }
            Range::Normal { mean, deviation, unit }
        }
        ["mean", "deviation"] => {
            entry.fault_here(
                format!("`{key}` has a distribution, but points are not chosen at random"),
                "choose a method with samples, such as \"random\" or \"latin-hypercube\"",
            );
            return None;
        }
        _ => {
            entry.fault_here(
                format!("`{key}` has {}", if given.is_empty() { "no values".to_owned() } else { given.join(", ") }),
                "give either values, or from and to (and count), or mean and deviation",
            );
            return None;
        }
    };
    Some(Axis { key: key.to_owned(), range, when: Vec::new(), span: entry.span.clone() })
}

/// A value of a list, as in the file.
pub(super) fn listed(entry: &Entry<'_>, node: &Spanned<DeValue<'_>>) -> Value {
    let text = entry.reader.text.get(node.span()).unwrap_or_default().to_owned();
    let number = match node.get_ref() {
        DeValue::Integer(integer) => integer.as_str().parse().ok(),
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::String(text) => units::any(text).ok().map(|(value, _)| value),
        _ => None,
    };
    Value { text, number }
}

/// Two numbers of the same unit, in SI.
pub(super) fn pair(entry: &Entry<'_>, names: [&str; 2]) -> Option<(String, [f64; 2])> {
    let read = |name: &str| -> Option<(f64, String)> {
        let node = entry.node(name)?;
        let read = match node.get_ref() {
            DeValue::Integer(integer) => {
                integer.as_str().parse().map(|x| (x, String::new())).map_err(|_| String::new())
            }
            DeValue::Float(float) => float.as_str().parse().map(|x| (x, String::new())).map_err(|_| String::new()),
            DeValue::String(text) => units::any(text),
            _ => Err(String::new()),
        };
        match read {
            Ok((value, unit)) if value.is_finite() => Some((value, unit)),
            Ok(_) | Err(_) => {
                let shown = entry.reader.text.get(node.span()).unwrap_or_default();
                let message = format!("`{name}` = {shown} is not a number");
                entry.fault_at(name, message, "write a number in SI units, or one with a unit such as \"500 mm\"");
                None
            }
        }
    };
    let (first, second) = (read(names[0]), read(names[1]));
    let ((a, unit), (b, other)) = (first?, second?);
    if unit != other {
        let shown = |unit: &str| if unit.is_empty() { "no unit".to_owned() } else { format!("the unit {unit}") };
        let message = format!("`{}` has {}, `{}` has {}", names[0], shown(&unit), names[1], shown(&other));
        entry.fault_at(names[1], message, "give both with a unit of the same quantity, or both without");
        return None;
    }
    Some((unit, [a, b]))
}
