//! The page of a comparison.

use crate::samples::{broken, run, y_harness};
use base64::Engine;
use wireloom_core::StepResult;
use wireloom_export::comparison::{Case, Comparison, convergence};
use wireloom_export::ending::Ending;
use wireloom_export::report::{ComparisonPage, write_comparison};

fn page(steps: Vec<StepResult>, alike: bool) -> String {
    let case = |(k, step)| Case { name: format!("<{k}>"), ending: Ending::of(&run("y", vec![step])).unwrap() };
    let cases: Vec<Case> = steps.into_iter().enumerate().map(case).collect();
    let comparison = Comparison::of(&cases, Some(0), 1e-3);
    let meshes: Vec<(usize, &Ending)> = cases.iter().enumerate().map(|(k, case)| (10 << k, &case.ending)).collect();
    let trends = convergence(&meshes);
    let compared = ComparisonPage {
        title: "a & b",
        cases: &cases,
        comparison: &comparison,
        trends: &trends,
        alike,
        program: "wireloom",
        machine: "a machine",
        written: "today",
    };
    let mut bytes = Vec::new();
    write_comparison(&compared, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn tells_what_is_different_and_needs_no_other_file() {
    let mut other = y_harness();
    other.branches[1].position.iter_mut().for_each(|x| x.z += 0.25);
    other.constraints[0].force.x += 2.0;
    let text = page(vec![y_harness(), y_harness(), other], true);
    assert!(text.contains("a &amp; b") && text.contains("&lt;2&gt;") && !text.contains("<2>"));
    assert!(text.contains("250.0000") && text.contains("2.0000"), "the distance and the force");
    assert!(text.contains("depends on the steps before") && text.contains("id=\"convergence\""));
    assert!(!text.contains("src=\"http") && !text.contains("href=\"http"));
    assert!(
        text.find("<summary>left").unwrap() < text.find("<summary>trunk").unwrap(),
        "what moves farthest comes first"
    );
    assert!(!page(vec![y_harness(), y_harness()], false).contains("id=\"equilibria\""));
}

#[test]
fn what_cannot_be_drawn_is_left_out() {
    let text = page(vec![y_harness(), broken()], true);
    let encoded = text.split("base64,").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let svg = String::from_utf8(base64::engine::general_purpose::STANDARD.decode(encoded).unwrap()).unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let shapes = document.descendants().filter(|node| node.attribute("class") == Some("shape"));
    // Three views of two results of four branches.
    assert_eq!(shapes.count(), 3 * 2 * 4);
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    assert!(text.contains("</html>"));
}
