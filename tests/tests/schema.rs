//! Output of `wireloom schema`, read by an independent validator as an editor would: it accepts every scenario there
//! is, and finds the faults of those that are refused for their form.

use boon::{Compiler, Schemas};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use wireloom_tests::{program, root};

/// All scenarios below a folder but for those that are refused; not what stands beside them (expected values, library
/// files).
fn scenarios(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && !path.ends_with("refused") {
            found.extend(scenarios(&path));
        } else if path.extension().is_some_and(|e| e == "toml") && json(&path)["schema"] == 1 {
            found.push(path);
        }
    }
    found
}

/// A TOML file as JSON: what a language server hands to its validator.
fn json(path: &Path) -> Value {
    let text = std::fs::read_to_string(path).expect("a file");
    let table: toml::Table = text.parse().unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    serde_json::to_value(table).expect("no numbers that JSON lacks")
}

#[test]
fn editors_that_use_the_schema_take_what_the_program_takes() {
    let printed = Command::new(program()).arg("schema").output().expect("the program runs");
    let schema: Value = serde_json::from_slice(&printed.stdout).expect("JSON");
    let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
    compiler.add_resource("scenario.json", schema).expect("a resource");
    let compiled = compiler.compile("scenario.json", &mut schemas).unwrap_or_else(|error| panic!("{error:#}"));
    let judge = |path: &Path| schemas.validate(&json(path), compiled).map_err(|error| format!("{error:#}"));

    let good = scenarios(&root().join("scenarios"));
    assert!(good.len() > 25, "{} scenarios", good.len());
    for path in good {
        judge(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    for name in ["unknown-keys", "wrong-types", "not-positive", "missing-keys", "wrong-operations", "hopeless-numbers"]
    {
        let path = root().join("scenarios/refused").join(name).with_extension("toml");
        assert!(judge(&path).is_err(), "{name} is seen while it is typed");
    }
}
