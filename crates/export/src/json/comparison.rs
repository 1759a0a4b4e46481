//! A comparison of several results as JSON, for programs.
//!
//! | key | content |
//! | --- | --- |
//! | `reference` | name of the result that the others are compared with |
//! | `tolerance` | distance of shapes that are the same, m |
//! | `results` | of each its last equilibrium and its sheet |
//! | `differences` | of each from the reference |
//! | `forces` | of each constraint the largest `force` (N), the `result` that has it, and those `of` all results |
//! | `groups` | `results` that ended in the same equilibrium, and `reasons` why it is not that of the reference |
//!
//! The group of a reference that did not converge has that as its reason.
//!
//! A result has its `name`, `status`, `verdict`, `requirements` (as in `result.json`), `stable`, `energy` (J),
//! `min_bend_radius` (`branch`, `s` and `value`, m), `iterations` and `seconds`. A difference has the `name` of the
//! result, the `energy` above that of the reference (J), by name the `branches` (`largest` distance at `s`, `mean`
//! distance, m) and the `constraints` (`force`, N; `moment`, N m; `position`, m; `outputs` of plugins above those
//! of the reference, SI), and `unmatched`, what only one of the two has.

use super::document::Requirement;
use super::values::SCHEMA;
use crate::comparison::{Case, Comparison, Difference, Group, forces};
use serde_json::{Value, json};
use std::io::{self, Write};

/// Writes a comparison.
///
/// # Errors
/// Those of `out`.
pub fn write_comparison(cases: &[Case], comparison: &Comparison, out: &mut impl Write) -> io::Result<()> {
    let name = |k: usize| cases[k].name.as_str();
    let results = cases.iter().map(case).collect::<io::Result<Vec<Value>>>()?;
    let differences = comparison.differences.iter().enumerate().map(|(k, own)| difference(name(k), own));
    let group = |Group { cases, reasons }: &Group| {
        let reasons: Vec<String> = reasons.iter().map(ToString::to_string).collect();
        json!({ "results": cases.iter().map(|k| name(*k)).collect::<Vec<_>>(), "reasons": reasons })
    };
    let forces = forces(cases).into_iter().map(|own| {
        let acting = own.of.iter().enumerate().filter_map(|(k, force)| Some((name(k).to_owned(), json!((*force)?))));
        json!({
            "constraint": own.constraint,
            "result": name(own.largest),
            "force": own.most(),
            "of": acting.collect::<serde_json::Map<_, _>>(),
        })
    });
    let document = json!({
        "schema": SCHEMA,
        "reference": name(comparison.reference),
        "tolerance": comparison.tolerance,
        "results": results,
        "differences": differences.collect::<Vec<Value>>(),
        "forces": forces.collect::<Vec<Value>>(),
        "groups": comparison.groups.iter().map(group).collect::<Vec<Value>>(),
    });
    serde_json::to_writer_pretty(&mut *out, &document)?;
    out.write_all(b"\n")
}

fn case(Case { name, ending }: &Case) -> io::Result<Value> {
    let requirements = ending
        .requirements
        .iter()
        .map(|line| serde_json::to_value(Requirement::of(line)))
        .collect::<Result<Vec<_>, _>>()?;
    let tightest = ending.tightest().map(|(branch, s, radius)| json!({ "branch": branch, "s": s, "value": radius }));
    Ok(json!({
        "name": name,
        "status": ending.status,
        "verdict": ending.verdict.word(),
        "requirements": requirements,
        "stable": ending.stable,
        "energy": ending.energy.total(),
        "min_bend_radius": tightest,
        "iterations": ending.iterations,
        "seconds": ending.seconds,
    }))
}

fn difference(name: &str, difference: &Difference) -> Value {
    let branches = difference.branches.iter().map(|branch| {
        let own = json!({ "largest": branch.largest, "s": branch.s, "mean": branch.mean });
        (branch.name.clone(), own)
    });
    let constraints = difference.constraints.iter().map(|constraint| {
        let mut own = json!({
            "force": constraint.force, "moment": constraint.moment, "position": constraint.position,
        });
        if !constraint.outputs.is_empty() {
            own["outputs"] = constraint.outputs.iter().map(|(name, value)| (name.clone(), json!(value))).collect();
        }
        (constraint.name.clone(), own)
    });
    json!({
        "name": name,
        "energy": difference.energy,
        "branches": branches.collect::<serde_json::Map<_, _>>(),
        "constraints": constraints.collect::<serde_json::Map<_, _>>(),
        "unmatched": difference.unmatched,
    })
}
