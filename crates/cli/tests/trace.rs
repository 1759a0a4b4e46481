//! The trace of the solver: `-v`, `-vv` and `--trace`.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// `scenarios/first.toml`.
fn first() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/first.toml")
}

/// Runs it with these arguments, results in `out`.
fn run(out: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wireloom"));
    command.arg("run").arg(first()).arg("--out").arg(out).args(arguments);
    let ended = command.output().expect("the program");
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    ended
}

/// `result.json` without times.
fn result(out: &Path) -> Value {
    let text = std::fs::read_to_string(out.join("result.json")).expect("a result");
    let mut result: Value = serde_json::from_str(&text).expect("JSON");
    for step in result["steps"].as_array_mut().expect("steps") {
        step["minimiser"]["seconds"] = Value::Null;
    }
    result
}

fn iterations(result: &Value) -> u64 {
    let steps = result["steps"].as_array().expect("steps").iter();
    steps.map(|step| step["minimiser"]["iterations"].as_u64().expect("a count")).sum()
}

#[test]
fn a_trace_changes_no_result_and_has_every_iteration() {
    let place = tempfile::tempdir().expect("a folder");
    let (plain, traced, file) =
        (place.path().join("plain"), place.path().join("traced"), place.path().join("a/t.jsonl"));
    let without = run(&plain, &[]);
    assert_eq!(String::from_utf8_lossy(&without.stderr), "");
    let with = run(&traced, &["-vv", "--trace", file.to_str().expect("UTF-8")]);
    let result = result(&plain);
    assert_eq!(result.to_string(), self::result(&traced).to_string());
    assert_eq!(std::fs::read(plain.join("picture.svg")).ok(), std::fs::read(traced.join("picture.svg")).ok());

    let text = std::fs::read_to_string(&file).expect("a trace");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let of = |target: &str| lines.iter().filter(|line| line["target"] == target).collect::<Vec<_>>();
    let all = of("wireloom::iteration");
    assert_eq!(all.len() as u64, iterations(&result));
    for line in &all {
        for field in ["iteration", "energy", "residual", "step", "shift", "contacts", "factorisations"] {
            assert!(line["fields"].get(field).is_some(), "{line}");
        }
        assert!(line["in"]["step"]["name"].is_string() && line["in"]["increment"]["index"].is_u64(), "{line}");
    }
    assert_eq!(of("wireloom::increment").len(), 40);
    let spans = |what: &str| lines.iter().filter(|line| line["span"] == what).count();
    assert_eq!(spans("new"), spans("close"));
    let last: Vec<&str> = all.iter().filter_map(|line| line["in"]["step"]["name"].as_str()).collect();
    assert_eq!((last.first(), last.last()), (Some(&"plug B"), Some(&"plug C")));
    let said = String::from_utf8_lossy(&with.stdout).into_owned();
    assert!(said.contains("t.jsonl: the trace of the solver"), "{said}");

    let table = String::from_utf8(with.stderr).expect("text");
    let header: Vec<&str> =
        table.lines().find(|line| line.contains("iter")).expect("a header").split_whitespace().collect();
    assert_eq!(header, ["iter", "energy", "[J]", "residual", "step", "shift", "contacts", "factor"]);
    let rows = table
        .lines()
        .filter(|line| line.split_whitespace().count() == 7 && line.trim().starts_with(|c: char| c.is_ascii_digit()));
    assert_eq!(rows.count() as u64, iterations(&result));
    assert!(table.contains("step `plug C`, increment 20"), "{table}");
}

#[test]
fn a_line_for_each_increment_is_brief() {
    let place = tempfile::tempdir().expect("a folder");
    let ended = run(&place.path().join("out"), &["-v"]);
    let table = String::from_utf8(ended.stderr).expect("text");
    let rows = table.lines().filter(|line| line.contains("converged"));
    assert_eq!(rows.count(), 40, "{table}");
    assert!(table.lines().all(|line| line.chars().count() < 100), "{table}");
}

#[test]
fn a_trace_that_cannot_be_written_is_reported_before_the_run() {
    let place = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(env!("CARGO_BIN_EXE_wireloom"));
    let ended =
        command.arg("run").arg(first()).arg("--out").arg(place.path().join("out")).arg("--trace").arg(place.path());
    let ended = ended.output().expect("the program");
    assert_eq!(ended.status.code(), Some(3), "{}", String::from_utf8_lossy(&ended.stderr));
    assert!(!place.path().join("out/result.json").exists());
}
