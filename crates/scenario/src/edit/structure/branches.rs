//! Branches that are added.

use super::entries::{append, each_attachment, is, list, refused, word};
use super::lengths::metres;
use crate::edit::record::{self, inline, on_lines, rotation};
use crate::fault::{Fault, did_you_mean};
use std::collections::BTreeSet;
use toml_edit::{DocumentMut, Item, TableLike, Value};
use wireloom_core::Vector;

/// An arm of a joint.
pub(super) fn arm(branch: &str, direction: [f64; 3], up: [f64; 3]) -> Value {
    let entries = [("branch", branch.into()), ("direction", record::list(&direction)), ("up", record::list(&up))];
    Value::InlineTable(inline(entries))
}

/// Adds a joint at which a second branch continues the first one.
pub(super) fn add_joint(text: &str, document: &mut DocumentMut, name: &str, arms: [&str; 2]) -> Result<(), Fault> {
    let [first, second] = arms;
    let up = [0.0, 0.0, 1.0];
    let arms = [arm(first, [-1.0, 0.0, 0.0], up), arm(second, [1.0, 0.0, 0.0], up)];
    append(text, document, "joints", inline([("name", name.into()), ("arms", on_lines(arms.into_iter()).into())]))
}

/// Adds an arm for a new branch to a joint, pointing away from the others.
pub(super) fn add_arm(text: &str, document: &mut DocumentMut, joint: &str, branch: &str) -> Result<(), Fault> {
    let branches = list(document.as_table_mut(), "branches");
    let begin_here = branches.iter().filter(|own| is(**own, "from", joint)).filter_map(|own| word(*own, "name"));
    let begin_here: BTreeSet<String> = begin_here.map(str::to_owned).collect();
    let joints = list(document.as_table_mut(), "joints");
    let there: BTreeSet<String> = joints.iter().filter_map(|own| Some(word(*own, "name")?.to_owned())).collect();
    let own = joints.into_iter().find(|own| is(*own, "name", joint));
    let own = own.ok_or_else(|| {
        let help = did_you_mean(joint, there.iter().map(String::as_str));
        refused(text, format!("there is no joint \"{joint}\" in the text"), &help)
    })?;
    let mut directions = Vec::new();
    for arm in list(own, "arms") {
        let branch = word(arm, "branch").unwrap_or_default();
        directions.push(out_of_joint(arm, begin_here.contains(branch)).ok_or_else(|| {
            let message = format!("arm \"{branch}\" of joint \"{joint}\" has no direction that can be read");
            refused(text, message, "give it direction and up, or orientation, in numbers")
        })?);
    }
    let sum = directions.iter().fold([0.0; 3], |sum, d| [0, 1, 2].map(|i| sum[i] + d[i]));
    // Opposite to the others; across the first one, where they balance.
    let away = unit(sum.map(|x| -x)).filter(|_| sum.iter().map(|x| x * x).sum::<f64>() > 0.01);
    let direction = away.or_else(|| directions.first().map(|first| across(*first))).unwrap_or([1.0, 0.0, 0.0]);
    let up = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let flat = |up: &[f64; 3]| up.iter().zip(direction).map(|(a, b)| a * b).sum::<f64>().abs() < 0.9;
    let up = up.into_iter().find(flat).unwrap_or([0.0, 0.0, 1.0]);
    let arm = arm(branch, direction.map(|x| (x * 1e6).round() / 1e6 + 0.0), up);
    match own.get_mut("arms") {
        Some(Item::Value(Value::Array(arms))) => {
            let decor = arms.iter().last().map(|value| value.decor().clone());
            arms.push(arm);
            if let (Some(decor), Some(value)) = (decor, arms.iter_mut().last()) {
                *value.decor_mut() = decor;
            }
        }
        Some(Item::ArrayOfTables(tables)) => {
            if let Value::InlineTable(arm) = arm {
                tables.push(arm.into_table());
            }
        }
        _ => return Err(refused(text, format!("joint \"{joint}\" has no list of arms"), "write arms = [ … ]")),
    }
    Ok(())
}

/// The direction of an arm out of its joint, given by `direction` or by `orientation`.
fn out_of_joint(arm: &dyn TableLike, starts_here: bool) -> Option<[f64; 3]> {
    if let Some(direction) = numbers(arm.get("direction")) {
        return unit(direction);
    }
    let along: Vector = rotation(numbers(arm.get("orientation"))?)? * Vector::z();
    Some(if starts_here { along.into() } else { (-along).into() })
}

/// A list of so many numbers.
fn numbers<const N: usize>(item: Option<&Item>) -> Option<[f64; N]> {
    let list = item?.as_array()?.iter();
    let all: Option<Vec<f64>> = list.map(|x| x.as_float().or_else(|| Some(x.as_integer()? as f64))).collect();
    all?.try_into().ok()
}

/// A unit vector; `None` of one that is zero.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (norm > 0.0).then(|| v.map(|x| x / norm))
}

/// A direction across another one, in the plane of x and y if it can be.
fn across([x, y, _]: [f64; 3]) -> [f64; 3] {
    unit([-y, x, 0.0]).unwrap_or([1.0, 0.0, 0.0])
}

/// A free end becomes a joint: a new branch continues the one that ends there.
pub(super) fn end_becomes_joint(text: &str, document: &mut DocumentMut, end: &str, branch: &str) -> Result<(), Fault> {
    let mut copy = document.clone();
    let branches = list(copy.as_table_mut(), "branches");
    let there: Vec<&str> = branches
        .iter()
        .filter(|own| is(**own, "from", end) || is(**own, "to", end))
        .filter_map(|own| word(*own, "name"))
        .collect();
    let [other] = there.as_slice() else {
        let message = format!("\"{end}\" is no free end: {} branches end there", there.len());
        return Err(refused(text, message, "name a vertex with one branch"));
    };
    add_joint(text, document, end, [other, branch])?;
    each_attachment(document.as_table_mut(), "end", end, "joint");
    Ok(())
}

/// The longest segment that a new branch may have: as fine as the finest branch; none where [mesh] decides.
pub(super) fn spacing(document: &mut DocumentMut) -> Option<Value> {
    let of = |own: &dyn TableLike| {
        let length = metres(own.get("length"))?;
        let counted = own.get("segments").and_then(Item::as_integer).map(|count| length / count.max(1) as f64);
        counted.or_else(|| metres(own.get("max_segment")))
    };
    if document.get("mesh").and_then(Item::as_table_like).is_some_and(|mesh| mesh.contains_key("accuracy")) {
        return None;
    }
    let finest = list(document.as_table_mut(), "branches").iter().filter_map(|own| of(*own)).reduce(f64::min);
    Some(Value::from(format!("{} mm", (finest.unwrap_or(0.01) * 1e6).round() / 1e3)))
}
