//! The picture: well-formed, complete, the same every time. Every sample is also left in the folder
//! `CARGO_TARGET_TMPDIR`, to be looked at.

use crate::samples::{
    among_obstacles, big_harness, branch, broken, cube, failing, planar, requirement, step, straight, v, y_harness,
};
use wireloom_core::equilibrium::{SpanResult, StationResult};
use wireloom_core::requirement::Measure;
use wireloom_core::{EventPlace, Status, StepResult};
use wireloom_export::picture::{Drawing, write};

fn drawn(step: &StepResult, title: &str, file: &str) -> String {
    let mut bytes = Vec::new();
    write(&Drawing::new(step, &[], title), &mut bytes).unwrap();
    std::fs::write(format!("{}/{file}.svg", env!("CARGO_TARGET_TMPDIR")), &bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    inspect(&text);
    text
}

/// Well-formed, and every number of every element within the page.
fn inspect(text: &str) {
    let document = roxmltree::Document::parse(text).unwrap();
    let attributes = document.descendants().flat_map(|node| node.attributes());
    assert!(attributes.map(|a| a.value()).all(|v| !v.contains("NaN") && !v.contains("inf")), "numbers that are none");
    for node in document.descendants().filter(|node| node.has_tag_name("text")) {
        let at = |key: &str| node.attribute(key).unwrap().parse::<f64>().unwrap();
        assert!((0.0..=1188.0).contains(&at("x")) && (0.0..=840.0).contains(&at("y")), "{node:?}");
    }
}

/// Elements of a class in one view.
fn count(text: &str, view: &str, class: &str) -> usize {
    let document = roxmltree::Document::parse(text).unwrap();
    let view = document.descendants().find(|node| node.attribute("id") == Some(view)).unwrap();
    view.descendants().filter(|node| node.attribute("class") == Some(class)).count()
}

fn words(text: &str) -> Vec<String> {
    let document = roxmltree::Document::parse(text).unwrap();
    document.descendants().filter(|n| n.has_tag_name("text")).map(|n| n.text().unwrap_or("").to_string()).collect()
}

/// A tie is a line between its stations, a span a rim of its branch.
#[test]
fn what_acts_on_several_places_is_drawn_between_them() {
    let mut step = y_harness();
    let positions = [step.constraints[1].position, step.constraints[2].position, step.constraints[3].position];
    let station = |position| StationResult { position, force: v(0.0, 0.0, 1.0), moment: v(0.0, 0.0, 0.0) };
    step.constraints[1].stations = positions.map(station).into();
    let s = &step.branches[0].s;
    step.constraints[4].span = Some(SpanResult {
        branch: "trunk".into(),
        range: (s[20], s[40]),
        force: v(0.0, 0.0, 2.0),
        largest: v(0.0, 0.0, 1.0),
        largest_at: s[20],
    });
    let text = drawn(&step, "ties", "ties");
    for view in ["front", "side", "above"] {
        assert_eq!((count(&text, view, "tie"), count(&text, view, "span")), (1, 1), "{view}");
    }
    let document = roxmltree::Document::parse(&text).unwrap();
    let of = |class: &str| document.descendants().find(|node| node.attribute("class") == Some(class)).unwrap();
    let points = |class: &str| of(class).attribute("points").unwrap().split(' ').count();
    assert_eq!((points("tie"), points("span")), (3, 21));
}

#[test]
fn a_y_harness() {
    let mut step = y_harness();
    (step.name, step.increment, step.increments) = ("plug B".into(), 40, 40);
    let text = drawn(&step, "y-harness", "y");
    for view in ["front", "side", "above"] {
        assert_eq!(count(&text, view, "constraint connector"), 2);
        assert_eq!(count(&text, view, "constraint collar"), 1);
        assert_eq!(count(&text, view, "constraint handle"), 1);
        assert_eq!(count(&text, view, "constraint other"), 1);
        assert_eq!(count(&text, view, "joint"), 1);
        assert_eq!(count(&text, view, "tightest"), 1);
        assert_eq!(count(&text, view, "label"), 7, "{view}: every name found a place");
        assert!(count(&text, view, "piece") > 20);
    }
    let words = words(&text);
    for expected in ["y-harness", "step “plug B”, increment 40 of 40  ·  converged  ·  stable", "clip-1", "x [mm]"]
    {
        assert!(words.iter().any(|word| word == expected), "{expected}: {words:?}");
    }
    // The table of the constraints: the largest force first.
    let row = words.iter().position(|word| word == "constraint").unwrap();
    assert_eq!(words[row..row + 6], ["constraint", "N", "N m", "hand", "7.25", "0.0100"]);
    assert!(words.iter().any(|word| word.contains("below the limit of 45.0 mm")), "{words:?}");
}

#[test]
fn equal_input_gives_equal_bytes() {
    assert_eq!(drawn(&big_harness(), "big", "big"), drawn(&big_harness(), "big", "big"));
}

#[test]
fn a_big_harness_is_not_buried_in_names() {
    let text = drawn(&big_harness(), "big", "big");
    for view in ["front", "side", "above"] {
        assert_eq!(count(&text, view, "joint"), 30);
        assert_eq!(count(&text, view, "constraint connector"), 90);
        let names = count(&text, view, "label");
        assert!((8..=13).contains(&names), "{view}: {names} names");
    }
}

#[test]
fn straight_and_planar_harnesses() {
    for axis in 0..3 {
        let text = drawn(&straight(axis), "straight cable", &format!("straight-{axis}"));
        assert_eq!(count(&text, "front", "constraint connector"), 2);
        assert!(words(&text).contains(&"straight everywhere".to_string()));
    }
    let text = drawn(&planar(), "planar", "planar");
    assert!(words(&text).iter().any(|word| word.contains("no limit given")));
    assert!(!words(&text).iter().any(|word| word.contains("too tight")));
}

#[test]
fn sizes_from_a_hair_to_a_ship() {
    for (file, size) in [("tiny", 1e-4), ("huge", 400.0)] {
        let helix = move |t: f64| v((9.0 * t).cos(), (9.0 * t).sin(), t) * size;
        let text =
            drawn(&step(vec![branch("helix", 0.02 * size, Some(0.9 * size), 300, helix)], vec![], vec![]), file, file);
        assert!(count(&text, "above", "piece") > 10);
    }
}

#[test]
fn names_are_escaped_and_long_ones_cut() {
    let mut step = y_harness();
    step.name = "<&\"'> ".repeat(60);
    step.status = Status::IterationLimit;
    step.constraints[0].name = "a connector whose name somebody thought about for a very long time".into();
    step.branches[2].name = "x\u{1}<y>".into();
    let title = "a <title> & \"more\" ".repeat(20);
    let text = drawn(&step, &title, "names");
    assert!(words(&text).iter().any(|word| word.starts_with("a <title> & \"more\"") && word.ends_with('…')));
    assert!(words(&text).iter().any(|word| word == "magnet <north> & \"south\""));
}

#[test]
fn degenerate_input_is_drawn_as_far_as_it_goes() {
    let text = drawn(&broken(), "broken", "broken");
    assert!(words(&text).iter().any(|word| word.contains("points without a finite position")), "{:?}", words(&text));
    let mut empty = step(vec![], vec![], vec![]);
    drawn(&empty, "", "empty");
    empty.min_bend_radius = y_harness().min_bend_radius;
    drawn(&empty, "", "empty");
    let point = step(vec![branch("point", 0.0, None, 3, |_| v(1.0, 2.0, 3.0))], vec![], vec![]);
    drawn(&point, "point", "point");
    let mut short = y_harness();
    short.branches[0].force.pop();
    assert_eq!(
        write(&Drawing::new(&short, &[], ""), &mut Vec::new()).unwrap_err().kind(),
        std::io::ErrorKind::InvalidInput
    );
}

/// A body is drawn in every view, within the frame, behind the branches; of a hundred thousand triangles no more than
/// can be seen.
#[test]
fn obstacles_lie_behind_the_branches() {
    let end = among_obstacles().steps.remove(0);
    let picture = |n: u32| {
        let mut bytes = Vec::new();
        write(&Drawing::new(&end, &[cube(n)], "among obstacles"), &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    };
    let (coarse, fine) = (picture(1), picture(130));
    std::fs::write(format!("{}/obstacles.svg", env!("CARGO_TARGET_TMPDIR")), &fine).unwrap();
    inspect(&fine);
    assert!(coarse.contains("<title>a &lt;cube&gt;</title>"));
    for view in ["front", "side", "above"] {
        assert_eq!((count(&coarse, view, "obstacle"), count(&fine, view, "obstacle")), (1, 1));
        let part = &coarse[coarse.find(&format!("id=\"{view}\"")).unwrap()..];
        assert!(part.find("class=\"obstacles\"").unwrap() < part.find("class=\"branches\"").unwrap());
        // Of a cube one face is seen: two triangles, four edges.
        let drawn = &part[part.find("class=\"obstacle\"").unwrap()..];
        let path = |k: usize| drawn.split("<path d=\"").nth(k).unwrap().split('"').next().unwrap();
        assert_eq!((path(1).matches('Z').count(), path(2).matches('M').count()), (2, 4), "{view}: {}", path(2));
    }
    assert!(fine.len() < 400_000, "{} bytes", fine.len());
}

/// Where a requirement fails or is unresolved there is a symbol with its name, value and limit; verdict and status
/// stand beside the headline.
#[test]
fn what_fails_is_marked_and_named() {
    let run = failing();
    let of_run = |of_step| {
        let drawing = Drawing { run: Some(&run), of_step, ..Drawing::new(&run.steps[0], &[], "failing") };
        let mut bytes = Vec::new();
        write(&drawing, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    };
    let text = of_run(None);
    std::fs::write(format!("{}/failing.svg", env!("CARGO_TARGET_TMPDIR")), &text).unwrap();
    inspect(&text);
    for view in ["front", "side", "above"] {
        assert_eq!(count(&text, view, "requirement fail"), 3, "{view}");
        assert_eq!(count(&text, view, "requirement unresolved"), 1, "{view}");
        // The tightest bend is the one that fails.
        assert_eq!(count(&text, view, "tightest"), 0, "{view}");
    }
    let words = words(&text);
    for expected in [
        "verdict: FAIL",
        "run: converged",
        "wire, bend radius: 14.4 mm, at least 45 mm",
        "gap: 6.20 mm, at least 6 mm",
        "fails",
    ] {
        assert!(words.iter().any(|word| word == expected), "{expected}: {words:?}");
    }
    // The pull of the trunk is 1.5 N and more, its limit 1.4 N: all of it, and nothing else.
    let strained = text.matches("stroke=\"#c2149a\"").count();
    assert!(strained > 0 && words.iter().any(|word| word == "pulled or pressed beyond its limit"), "{strained}");
    assert_eq!(count(&of_run(Some(1)), "front", "requirement fail"), 0, "the requirements of another step");
}

/// A cable pulled to three times its length is straight, and had the colour of what is straight and well.
#[test]
fn an_overstretched_cable_has_not_the_colour_of_a_straight_one() {
    let mut end = straight(0);
    let plain = drawn(&end, "straight", "straight-0");
    assert!(plain.contains("#1f5aa6") && !plain.contains("#c2149a"));
    for force in &mut end.branches[0].force {
        *force = v(2e4, 0.0, 0.0);
    }
    let mut run = crate::samples::run("stretched", vec![end]);
    run.requirements =
        vec![requirement("spans are long enough", Measure::Reach, [3.0, 1.0], EventPlace::branch("cable", 0.6))];
    let mut bytes = Vec::new();
    write(&Drawing { run: Some(&run), ..Drawing::new(&run.steps[0], &[], "stretched") }, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    std::fs::write(format!("{}/stretched.svg", env!("CARGO_TARGET_TMPDIR")), &text).unwrap();
    inspect(&text);
    let views = text.split("class=\"legend\"").next().unwrap();
    assert!(views.contains("class=\"piece\"") && views.contains("#c2149a") && !views.contains("stroke=\"#1f5aa6\""));
    assert!(
        words(&text).iter().any(|word| word == "spans are long enough: 300 %, at most 100 %"),
        "{:?}",
        words(&text)
    );
}
