//! Requirements divided into their parts: a requirement on several parts of a harness, or on both ends of a cable, has
//! a kink where another place becomes its worst. By parts each place has a constraint of its own.

use crate::sensitivity::tell_apart;
use wireloom_core::Network;
use wireloom_core::requirement::{Measure, Part, Requirement};

/// Between the name of a requirement and that of its part.
const SEPARATOR: char = '\u{1f}';

/// Divides the requirements of a network: one for each part, of what varies along a cable, or from span to span, one
/// for each half of it.
pub(super) fn divide(network: &mut Network) {
    tell_apart(network);
    let whole = std::mem::take(&mut network.requirements);
    let divided = whole.into_iter().flat_map(|requirement| {
        let mut parts: Vec<Part> = requirement.of.iter().flat_map(|part| halves(&requirement, part, network)).collect();
        if parts.len() < 2 {
            return vec![requirement];
        }
        let named = parts.drain(..).enumerate().map(|(k, part)| Requirement {
            name: format!("{}{SEPARATOR}{}", requirement.name, k + 1),
            of: vec![part],
            ..requirement.clone()
        });
        named.collect()
    });
    let divided = divided.collect();
    network.requirements = divided;
}

fn halves(requirement: &Requirement, part: &Part, network: &Network) -> Vec<Part> {
    let along = matches!(
        requirement.measure,
        Measure::BendRadius
            | Measure::Tension
            | Measure::Compression
            | Measure::Strain
            | Measure::Torsion
            | Measure::Reach
    );
    match *part {
        Part::Branch { branch, from, to } if along => {
            // Between two nodes, so that no node is on both sides of round-off.
            let lengths = &network.branches[branch].rod.mesh().rest_lengths;
            let half = lengths.len() / 2;
            let middle = lengths[..half].iter().sum::<f64>() + 0.5 * lengths[half];
            if middle <= from || middle >= to {
                return vec![*part];
            }
            vec![Part::Branch { branch, from, to: middle }, Part::Branch { branch, from: middle, to }]
        }
        other => vec![other],
    }
}

/// Name of the requirement that was divided.
pub(super) fn whole(name: &str) -> &str {
    name.split(SEPARATOR).next().unwrap_or(name)
}
