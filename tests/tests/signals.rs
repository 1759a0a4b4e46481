//! Signals to the program while it works: within an increment, a point of a sweep, a comparison; and what it says of itself meanwhile.
#![cfg(unix)]

use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use wireloom_tests::program;

/// The program ends within 2 s of a signal, writing included; this is for machines that have a lot of other work.
const LIMIT: Duration = Duration::from_secs(10);
/// Longer than the program takes to get anywhere, on any machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// A cable whose end is drawn along a way; `drawn` is one increment, which passes through every point of `way.csv`.
const DRAWN: &str = r#"
schema = 1
name = "drawn"
[sections.cable]
diameter = "6 mm"
linear_density = "50 g/m"
axial_stiffness = 1e4
bending_stiffness = 0.01
torsion_stiffness = 0.008
[[branches]]
name = "cable"
from = "A"
to = "B"
section = "cable"
length = "1 m"
segments = 200
[[constraints]]
name = "plug-A"
kind = "connector"
at = { end = "A" }
position = [0, 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[constraints]]
name = "plug-B"
kind = "connector"
at = { end = "B" }
position = ["600 mm", 0, 0]
tangent = [1, 0, 0]
up = [0, 0, 1]
[[steps]]
name = "aside"
increments = 3
move = [{ constraint = "plug-B", position = ["600 mm", "50 mm", 0] }]
[[steps]]
name = "drawn"
carry = [{ what = ["plug-B"], path = "way.csv" }]
"#;

/// What is done while nobody is patient enough for it to end.
const ENDLESS: usize = 200_000;

struct Place(tempfile::TempDir);

impl Place {
    /// With a way through so many points.
    fn new(points: usize, more: &str) -> Self {
        let place = Self(tempfile::tempdir().expect("a folder"));
        let mut way = "t,x,y,z\n".to_owned();
        for k in 0..=points {
            let t = k as f64 / points as f64;
            // Round in a small circle, which it never leaves.
            let angle = 0.02 * k as f64;
            way += &format!("{t},{},{},0\n", 0.55 + 0.05 * angle.cos(), 0.05 + 0.05 * angle.sin());
        }
        fs::write(place.path("way.csv"), way).expect("written");
        fs::write(place.path("s.toml"), format!("{DRAWN}{more}")).expect("written");
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn start(&self, arguments: &[&str]) -> Child {
        let mut command = Command::new(program());
        command.args(arguments).current_dir(self.0.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command.spawn().expect("the program runs")
    }

    /// The result in a folder without what depends on the clock.
    fn result(&self, folder: &str) -> Value {
        let text = fs::read_to_string(self.path(folder).join("result.json")).expect("a result");
        let mut result: Value = serde_json::from_str(&text).expect("JSON");
        for step in result["steps"].as_array_mut().expect("a list") {
            step["minimiser"]["seconds"] = Value::Null;
        }
        result
    }
}

fn wait_until(what: &str, mut there: impl FnMut() -> bool) {
    let began = Instant::now();
    while !there() {
        assert!(began.elapsed() < PATIENCE, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Sends a signal; gives the exit code, and what it said on standard output.
fn end(mut child: Child, signal: &str) -> (Option<i32>, String) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([signal, &id]).status().is_ok_and(|status| status.success()));
    let began = Instant::now();
    while child.try_wait().expect("a state").is_none() {
        if began.elapsed() > LIMIT {
            let _ = child.kill();
            panic!("{signal} was not heard for {LIMIT:?}");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut out = String::new();
    child.stdout.take().expect("piped").read_to_string(&mut out).expect("text");
    (child.wait().expect("ended").code(), out)
}

#[test]
fn a_signal_within_an_increment_ends_the_run_and_keeps_what_is_done() {
    for signal in ["-INT", "-TERM"] {
        let place = Place::new(ENDLESS, "");
        let child = place.start(&["run", "s.toml", "--out", "o"]);
        let first = place.path("o/.wireloom/results/000001");
        wait_until("the first step never ended", || first.exists());
        std::thread::sleep(Duration::from_millis(300));
        let (code, out) = end(child, signal);
        assert_eq!(code, Some(2), "{out}");
        assert!(out.contains("drawn: interrupted") && out.contains("`wireloom run --resume o` goes on"), "{out}");
        let result = place.result("o");
        let steps: Vec<_> =
            result["steps"].as_array().expect("a list").iter().map(|step| step["name"].as_str()).collect();
        assert_eq!((result["status"].as_str(), steps), (Some("interrupted"), vec![Some("aside")]));
        assert!(place.path("o/.wireloom/standing").exists(), "there is a checkpoint");
    }
}

#[test]
fn a_run_interrupted_within_an_increment_goes_on_to_the_same_bytes() {
    let place = Place::new(400, "");
    let whole = place.start(&["run", "s.toml", "--out", "whole"]).wait_with_output().expect("ended");
    assert_eq!(whole.status.code(), Some(0), "{}", String::from_utf8_lossy(&whole.stderr));
    let child = place.start(&["run", "s.toml", "--out", "o"]);
    let first = place.path("o/.wireloom/results/000001");
    wait_until("the first step never ended", || first.exists());
    assert_eq!(end(child, "-TERM").0, Some(2));
    assert_eq!(place.result("o")["steps"].as_array().map(Vec::len), Some(1), "what was not done is no part of it");
    let resumed = place.start(&["run", "--resume", "o"]).wait_with_output().expect("ended");
    assert_eq!(resumed.status.code(), Some(0));
    assert!(place.result("o") == place.result("whole"));
}

/// Nobody is left in silence, where there is no terminal either; but for those who want it.
#[test]
fn a_run_is_not_silent_for_long() {
    let place = Place::new(ENDLESS, "");
    let mut silent = place.start(&["run", "s.toml", "--out", "silent", "--quiet"]);
    let mut child = place.start(&["run", "s.toml", "--out", "o"]);
    let mut said = BufReader::new(child.stderr.take().expect("piped")).lines();
    let began = Instant::now();
    let told = |line: &String| line.contains("of 4 increments") && line.contains(" iterations, residual ");
    assert!(said.by_ref().map(|line| line.expect("text")).any(|line| told(&line)));
    assert!(began.elapsed() < PATIENCE);
    assert_eq!(end(child, "-TERM").0, Some(2));
    let mut words = String::new();
    let mut err = silent.stderr.take().expect("piped");
    assert_eq!(end(silent, "-TERM"), (Some(2), String::new()));
    err.read_to_string(&mut words).expect("text");
    assert_eq!(words, "");
}

#[test]
fn a_comparison_that_is_interrupted_ends_with_code_2_and_what_is_done() {
    let place = Place::new(ENDLESS, "");
    let quick = DRAWN.split("[[steps]]").next().expect("what comes before the steps");
    fs::write(place.path("quick.toml"), quick).expect("written");
    let mut child = place.start(&["compare", "quick.toml", "s.toml", "quick.toml"]);
    let mut said = BufReader::new(child.stderr.take().expect("piped")).lines();
    // It is at the second one.
    said.find(|line| line.as_ref().is_ok_and(|line| line.contains("of 4 increments")))
        .expect("it says so")
        .expect("text");
    let (code, out) = end(child, "-INT");
    assert_eq!(code, Some(2), "{out}");
    assert!(out.starts_with("interrupted: 1 of 3 runs came to their ends") && out.contains("converged"), "{out}");
    // Before anything is done there is nothing to be shown.
    let mut child = place.start(&["compare", "s.toml", "quick.toml"]);
    let mut said = BufReader::new(child.stderr.take().expect("piped")).lines();
    said.find(|line| line.as_ref().is_ok_and(|line| line.contains("of 4 increments")))
        .expect("it says so")
        .expect("text");
    let (code, out) = end(child, "-TERM");
    assert_eq!((code, out.trim_end()), (Some(2), "interrupted: 0 of 2 runs came to their ends"));
}

#[test]
fn a_sweep_that_is_interrupted_within_a_point_ends_with_code_2() {
    let vary = "\n[sweep.vary]\n\"branches.cable.length\" = { from = \"1 m\", to = \"1.01 m\", count = 2 }\n";
    let place = Place::new(ENDLESS, vary);
    let mut child = place.start(&["sweep", "s.toml", "--out", "o"]);
    let mut said = BufReader::new(child.stderr.take().expect("piped")).lines();
    let line = said.find(|line| line.as_ref().is_ok_and(|line| line.contains("of 2 points")));
    assert!(line.expect("it says so").expect("text").contains(" iterations"));
    let (code, out) = end(child, "-TERM");
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("interrupted; the same command goes on, from o"), "{out}");
}
