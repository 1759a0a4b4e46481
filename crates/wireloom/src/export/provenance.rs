//! Provenance of a result.

use sha2::{Digest, Sha256};
use wireloom_export::json::{Provenance, options};
use wireloom_scenario::{Scenario, Setting};

/// Provenance of a result. `program`: name and version. `texts`: names and texts of the scenario and of all files it
/// names. `hashed`: names and SHA-256 of files that are not text. `settings`: values that replaced those of the text.
pub fn provenance(
    program: &str,
    scenario: &Scenario,
    texts: &[(String, String)],
    hashed: &[(String, String)],
    settings: &[Setting],
) -> Provenance {
    let minimiser = &scenario.minimiser;
    Provenance {
        program: program.to_owned(),
        files: texts
            .iter()
            .map(|(name, text)| (name.clone(), sha256(text.as_bytes())))
            .chain(hashed.iter().cloned())
            .collect(),
        set: settings.iter().map(|setting| format!("{} = {}", setting.key, setting.value)).collect(),
        seed: scenario.sweep.as_ref().map(|sweep| sweep.seed),
        rods: kinds(scenario.branches.iter().map(|branch| &branch.rod)),
        joints: kinds(scenario.joints.iter().map(|joint| &joint.model)),
        constraints: kinds(scenario.constraints.iter().map(|constraint| &constraint.kind)),
        minimiser: options(&minimiser.kind, &minimiser.stop, &minimiser.parameters),
    }
}

/// Distinct kinds, sorted.
fn kinds<'a>(all: impl Iterator<Item = &'a String>) -> Vec<String> {
    let mut kinds: Vec<String> = all.cloned().collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

/// SHA-256 of bytes, in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    format!("{:x}", Sha256::digest(bytes))
}

#[cfg(test)]
mod tests {
    #[test]
    fn hashes_are_those_of_sha256sum() {
        assert_eq!(super::sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }
}
