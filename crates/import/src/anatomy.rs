//! The wires that the arms of a joint have in common.

use super::document::Document;
use super::findings::Findings;
use super::harness::CommonWires;
use super::segments::{Incidence, Laid};
use std::collections::{HashMap, HashSet};
use wireloom_scenario::bundle::Bundle;

/// K: ratio of the bending stiffness of a bundle to that of its separate wires.
fn bundle_factor(bundle: &Bundle) -> f64 {
    bundle.bending.taken / bundle.wires_bending
}

/// The pairs of arms that share wires; `stiffness` is EI of the document's wires, N m².
///
/// `C_ab = min(K_a, K_b) Σ_{wires in a and b} EI`: the arm with the smaller bundle factor K is named first, and
/// its fraction is `Σ_{common} EI / Σ_{a} EI`. A wire found in k > 2 arms gives each of its pairs 1/(k − 1).
/// Empty if the wires of some arm are not known.
pub(super) fn common_wires(
    document: &Document,
    stiffness: &[f64],
    laid: &[Laid],
    node: usize,
    arms: &[Incidence],
    findings: &mut Findings,
) -> Vec<CommonWires> {
    let id = &document.nodes[node].id;
    let through: Vec<&Vec<usize>> = arms.iter().map(|arm| &document.segments[arm.segment].wires).collect();
    if through.iter().any(|wires| wires.is_empty()) {
        findings.add_to("an arm of these joints has no routed wires; their anatomy is the default", id);
        return Vec::new();
    }
    let mut arms_of: HashMap<usize, usize> = HashMap::new();
    for wire in through.iter().flat_map(|wires| wires.iter()) {
        *arms_of.entry(*wire).or_default() += 1;
    }
    let mut of_node = |what: &str, wanted: fn(usize) -> bool| {
        let mut found: Vec<usize> = arms_of.iter().filter(|(_, arms)| wanted(**arms)).map(|(wire, _)| *wire).collect();
        found.sort_unstable();
        for wire in found {
            findings.add_to(format!("wires {what}"), format!("{id} {}", document.wires[wire].id));
        }
    };
    of_node("end inside joints, where nothing holds them", |arms| arms == 1);
    of_node("run through more than two arms of a joint; divided evenly among the pairs", |arms| arms > 2);

    let sets: Vec<HashSet<&usize>> = through.iter().map(|wires| wires.iter().collect()).collect();
    let mut shares = Vec::new();
    for a in 0..arms.len() {
        let mut alone = true;
        for (b, set) in sets.iter().enumerate() {
            let common: Vec<usize> = through[a].iter().filter(|wire| set.contains(wire)).copied().collect();
            if a == b || common.is_empty() {
                continue;
            }
            alone = false;
            let factors = [a, b].map(|arm| bundle_factor(laid[arms[arm].segment].at_end(arms[arm].starts)));
            // Once for each pair, from the arm with the smaller factor (the earlier one where they are equal).
            if factors[0] > factors[1] || (factors[0] == factors[1] && a > b) {
                continue;
            }
            let passing: f64 = common.iter().map(|&wire| stiffness[wire] / (arms_of[&wire] - 1) as f64).sum();
            let all: f64 = through[a].iter().map(|&wire| stiffness[wire]).sum();
            shares.push(CommonWires { first: a, second: b, fraction: (passing / all).min(1.0), wires: common.len() });
        }
        if alone {
            findings.add_to(
                "arms have no wire in common with another arm of their joint; the joint is a hinge for them",
                format!("{id} {}", document.segments[arms[a].segment].id),
            );
        }
    }
    shares
}
