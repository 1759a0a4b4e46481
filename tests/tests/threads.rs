//! Results do not depend on the number of threads.

use serde_json::Value;
use std::fs;
use std::process::Command;
use wireloom_tests::{program, root};

/// `result.json` of a scenario, computed by so many threads, without the times.
fn result(scenario: &str, threads: usize) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("scenario.toml");
    fs::write(&file, scenario).expect("room on the disk");
    let out = folder.path().join("out");
    let run = Command::new(program())
        .args(["run", file.to_str().expect("a path"), "--out", out.to_str().expect("a path")])
        .env("RAYON_NUM_THREADS", threads.to_string())
        .output()
        .expect("the program runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let mut result: Value =
        serde_json::from_slice(&fs::read(out.join("result.json")).expect("a result")).expect("JSON");
    for step in result["steps"].as_array_mut().expect("steps") {
        let minimiser = step["minimiser"].as_object_mut().expect("what the minimiser did");
        minimiser.remove("seconds").expect("a time");
    }
    result
}

#[test]
fn a_large_harness_ends_in_the_same_bits_on_any_number_of_threads() {
    let text = fs::read_to_string(root().join("scenarios/branches/sixteen_arms.toml")).expect("a scenario");
    let coarse = "max_segment = \"10 mm\"";
    assert!(text.contains(coarse));
    let fine = text.replace(coarse, "max_segment = \"1 mm\"");
    same_on_any_number_of_threads(&fine);
    // Arms that slip on a hub under their weight.
    let joint = "[[joints]]\nname = \"J\"\n";
    assert!(fine.contains(joint));
    let hub = "model = \"compliant-hub\"\nbending_stiffness = 0.1\ntorsion_stiffness = 0.1\n\
               friction = { bending = [{ stiffness = 0.1, moment = 0.001 }] }\n";
    let alone = same_on_any_number_of_threads(&fine.replace(joint, &format!("{joint}{hub}")));
    let arms = alone["steps"][0]["joints"]["J"]["friction"].as_object().expect("friction");
    assert!(arms.values().any(|arm| arm["dissipated_in_all"].as_f64() > Some(1e-5)), "{arms:?}");
}

/// The result on one thread.
fn same_on_any_number_of_threads(fine: &str) -> Value {
    let alone = result(fine, 1);
    let nodes: usize = alone["steps"][0]["branches"]
        .as_object()
        .expect("branches")
        .values()
        .map(|branch| branch["s"].as_array().expect("arc lengths").len())
        .sum();
    assert!(nodes > 2048, "large enough to be shared among threads: {nodes}");
    for threads in [2, 5] {
        assert!(result(fine, threads) == alone, "{threads} threads");
    }
    alone
}
