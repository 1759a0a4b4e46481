//! Signals to the program while it works: within an increment, a point of a sweep, a comparison; and what it says of
//! itself meanwhile.
#![cfg(unix)]

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command};
use std::time::{Duration, Instant};
use wireloom_tests::cables::hanging;
use wireloom_tests::place::{PATIENCE, Place};

/// The program ends within 2 s of a signal, writing included; this is for machines that have a lot of other work.
const LIMIT: Duration = Duration::from_secs(10);

/// Steps in which the end of a cable is drawn along a way; `drawn` is one increment, which passes through every point
/// of `way.csv`.
const STEPS: &str = r#"
[[steps]]
name = "aside"
increments = 3
move = [{ constraint = "plug-B", position = ["600 mm", "50 mm", 0] }]
[[steps]]
name = "drawn"
carry = [{ what = ["plug-B"], path = "way.csv" }]
"#;
/// Segments of the cable.
const SEGMENTS: usize = 200;

/// Points of a path that takes longer than any test waits.
const ENDLESS: usize = 200_000;

/// A folder with this scenario and a way through so many points.
fn place(points: usize, more: &str) -> Place {
    let place = Place::new(&hanging("drawn", SEGMENTS, &format!("{STEPS}{more}")));
    let mut way = "t,x,y,z\n".to_owned();
    for k in 0..=points {
        let t = k as f64 / points as f64;
        // Round in a small circle, which it never leaves.
        let angle = 0.02 * k as f64;
        way += &format!("{t},{},{},0\n", 0.55 + 0.05 * angle.cos(), 0.05 + 0.05 * angle.sin());
    }
    place.file("way.csv", way);
    place
}

fn start(place: &Place, arguments: &[&str]) -> Child {
    place.command(arguments).spawn().expect("the program runs")
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
        let place = place(ENDLESS, "");
        let child = start(&place, &["run", "s.toml", "--out", "o"]);
        let first = place.path("o/.wireloom/results/000001");
        wait_until("the first step never ended", || first.exists());
        std::thread::sleep(Duration::from_millis(300));
        let (code, out) = end(child, signal);
        assert_eq!(code, Some(2), "{out}");
        assert!(
            out.contains("status:  interrupted (drawn: ") && out.contains("`wireloom run --resume o` resumes the run"),
            "{out}"
        );
        let result = place.result("o");
        let steps: Vec<_> =
            result["steps"].as_array().expect("a list").iter().map(|step| step["name"].as_str()).collect();
        assert_eq!((result["status"].as_str(), steps), (Some("interrupted"), vec![Some("aside")]));
        assert!(place.path("o/.wireloom/origin").exists(), "it can be resumed");
    }
}

/// The trial runs for the mesh of an accuracy take as long as the run itself.
#[test]
fn a_signal_while_the_mesh_is_found_ends_the_run_in_words() {
    let place = place(ENDLESS, "\n[mesh]\naccuracy = \"1 %\"\n");
    let text = fs::read_to_string(place.path("s.toml")).expect("text");
    let line = format!("segments = {SEGMENTS}\n");
    assert!(text.contains(&line), "{text}");
    fs::write(place.path("s.toml"), text.replace(&line, "")).expect("written");
    let mut child = start(&place, &["run", "s.toml", "--out", "o"]);
    let mut said = BufReader::new(child.stderr.take().expect("piped")).lines();
    let found = said.find(|line| line.as_ref().is_ok_and(|line| line.contains("finding the mesh")));
    found.expect("it says so").expect("text");
    let (code, out) = end(child, "-INT");
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("status:  interrupted") && out.contains("`wireloom run --resume o` resumes the run"), "{out}");
}

#[test]
fn a_run_interrupted_within_an_increment_goes_on_to_the_same_bytes() {
    let place = place(400, "");
    let whole = start(&place, &["run", "s.toml", "--out", "whole"]).wait_with_output().expect("ended");
    assert_eq!(whole.status.code(), Some(0), "{}", String::from_utf8_lossy(&whole.stderr));
    let child = start(&place, &["run", "s.toml", "--out", "o"]);
    let first = place.path("o/.wireloom/results/000001");
    wait_until("the first step never ended", || first.exists());
    assert_eq!(end(child, "-TERM").0, Some(2));
    assert_eq!(place.result("o")["steps"].as_array().map(Vec::len), Some(1), "what was not done is no part of it");
    let resumed = start(&place, &["run", "--resume", "o"]).wait_with_output().expect("ended");
    assert_eq!(resumed.status.code(), Some(0));
    assert!(place.result("o") == place.result("whole"));
}

/// Progress is reported without a terminal, too, unless `--quiet` is given.
#[test]
fn a_run_is_not_silent_for_long() {
    let place = place(ENDLESS, "");
    let mut silent = start(&place, &["run", "s.toml", "--out", "silent", "--quiet"]);
    let mut child = start(&place, &["run", "s.toml", "--out", "o"]);
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
    let place = place(ENDLESS, "");
    fs::write(place.path("quick.toml"), hanging("drawn", SEGMENTS, "")).expect("written");
    let mut child = start(&place, &["compare", "quick.toml", "s.toml", "quick.toml"]);
    let mut said = BufReader::new(child.stderr.take().expect("piped")).lines();
    // It is at the second one.
    said.find(|line| line.as_ref().is_ok_and(|line| line.contains("of 4 increments")))
        .expect("it says so")
        .expect("text");
    let (code, out) = end(child, "-INT");
    assert_eq!(code, Some(2), "{out}");
    assert!(out.starts_with("interrupted: 1 of 3 runs are complete") && out.contains("converged"), "{out}");
    // Before anything is done there is nothing to be shown.
    let mut child = start(&place, &["compare", "s.toml", "quick.toml"]);
    let mut said = BufReader::new(child.stderr.take().expect("piped")).lines();
    said.find(|line| line.as_ref().is_ok_and(|line| line.contains("of 4 increments")))
        .expect("it says so")
        .expect("text");
    let (code, out) = end(child, "-TERM");
    assert_eq!((code, out.trim_end()), (Some(2), "interrupted: 0 of 2 runs are complete"));
}

#[test]
fn a_sweep_that_is_interrupted_within_a_point_ends_with_code_2() {
    let vary = "\n[sweep.vary]\n\"branches.cable.length\" = { from = \"1 m\", to = \"1.01 m\", count = 2 }\n";
    let place = place(ENDLESS, vary);
    let mut child = start(&place, &["sweep", "s.toml", "--out", "o"]);
    let mut said = BufReader::new(child.stderr.take().expect("piped")).lines();
    let line = said.find(|line| line.as_ref().is_ok_and(|line| line.contains("of 2 points")));
    assert!(line.expect("it says so").expect("text").contains(" iterations"));
    let (code, out) = end(child, "-TERM");
    assert_eq!(code, Some(2), "{out}");
    assert!(out.contains("interrupted; the same command goes on, from o"), "{out}");
}
