//! Origin of a result.

use serde::{Deserialize, Serialize};
use serde_json::{Map, json};
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
    /// Kind and options of the minimiser; see [`options`].
    pub minimiser: Map<String, serde_json::Value>,
}

/// Kind and options of a minimiser: when it stops, and its parameters, SI units.
pub fn options(kind: &str, stop: &Stop, parameters: &Parameters) -> Map<String, serde_json::Value> {
    let plain = |value: &Value| match value {
        Value::Number(number) => json!(number),
        Value::Vector(v) => json!([v.x, v.y, v.z]),
        Value::Count(count) => json!(count),
        Value::Flag(flag) => json!(flag),
        Value::Word(word) => json!(word),
    };
    let mut options = Map::new();
    options.insert("kind".to_owned(), json!(kind));
    options.insert("force_tolerance".to_owned(), json!(stop.force_tolerance));
    options.insert("max_iterations".to_owned(), json!(stop.max_iterations));
    options.extend(parameters.0.iter().map(|(name, value)| (name.clone(), plain(value))));
    options
}
