//! Results that are read again.

use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn wireloom(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_wireloom")).args(arguments).output().expect("the program")
}

/// A result with a missing field, or one of another version of the program, is refused with the file and the path of
/// the field.
#[test]
fn a_result_that_cannot_be_read_is_refused_with_file_and_field() {
    let place = tempfile::tempdir().expect("a folder");
    let (out, changed) = (place.path().join("out"), place.path().join("changed.json"));
    let (out, changed) = (out.to_str().expect("UTF-8"), changed.to_str().expect("UTF-8"));
    let first = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/first.toml");
    assert!(wireloom(&["run", first.to_str().expect("UTF-8"), "--out", out, "-q"]).status.success());
    let text = std::fs::read_to_string(format!("{out}/result.json")).expect("a result");
    let refused = |change: &dyn Fn(&mut Value), message: &str| {
        let mut result: Value = serde_json::from_str(&text).expect("JSON");
        change(&mut result);
        std::fs::write(changed, result.to_string()).expect("written");
        let ended = wireloom(&["compare", out, changed]);
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(
            (ended.status.code(), said.contains(message), said.contains("changed.json")),
            (Some(1), true, true),
            "{said}"
        );
    };
    let trunk = |result: &mut Value| result["steps"][1]["branches"]["trunk"].take();
    refused(
        &|result| {
            let mut branch = trunk(result);
            branch.as_object_mut().expect("a branch").remove("force");
            result["steps"][1]["branches"]["trunk"] = branch;
        },
        "steps[1].branches.trunk: missing field `force`",
    );
    refused(
        &|result| result["steps"][0]["colour"] = "red".into(),
        "steps[0].colour: unknown field `colour`, which another version of this program may have written",
    );
}
