//! Origin of a result.

use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;
use wireloom_core::{Parameters, Stop, Value};

/// Origin of a result: program, files and settings, from which it can be made again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Program and version.
    pub program: String,
    /// The scenario and the files it names, by name, with the SHA-256 of each in hexadecimal digits.
    pub files: BTreeMap<String, String>,
    /// Settings on the command line, as `key = value`.
    pub set: Vec<String>,
    /// Seed of the scenario's sweep.
    #[serde(deserialize_with = "super::values::nullable")]
    pub seed: Option<u64>,
    /// Kinds of rods.
    pub rods: Vec<String>,
    /// Kinds of joints.
    pub joints: Vec<String>,
    /// Kinds of constraints.
    pub constraints: Vec<String>,
    /// Kind and options of the minimiser, in the order of their names; see [`options`].
    pub minimiser: BTreeMap<String, serde_json::Value>,
}

/// Kind and options of a minimiser: when it stops, and its parameters, SI units.
// The order of a `serde_json::Map` depends on the features with which others use that crate.
pub fn options(kind: &str, stop: &Stop, parameters: &Parameters) -> BTreeMap<String, serde_json::Value> {
    let plain = |value: &Value| match value {
        Value::Number(number) => json!(number),
        Value::Vector(v) => json!([v.x, v.y, v.z]),
        Value::Count(count) => json!(count),
        Value::Flag(flag) => json!(flag),
        Value::Word(word) => json!(word),
    };
    let mut options = BTreeMap::new();
    options.insert("kind".to_owned(), json!(kind));
    options.insert("force_tolerance".to_owned(), json!(stop.force_tolerance));
    options.insert("max_iterations".to_owned(), json!(stop.max_iterations));
    options.extend(parameters.0.iter().map(|(name, value)| (name.clone(), plain(value))));
    options
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tests of this crate use `serde_json` with another order of maps than the program.
    #[test]
    fn the_bytes_of_options_do_not_depend_on_features_of_other_crates() {
        let stop = Stop { force_tolerance: 1e-6, max_iterations: 200 };
        let text = serde_json::to_string(&options("newton", &stop, &Parameters::default()));
        let wanted = r#"{"force_tolerance":1e-6,"kind":"newton","max_iterations":200}"#;
        assert_eq!(text.ok().as_deref(), Some(wanted));
    }
}
