//! A finished run as pages receive it.

use base64::Engine as _;
use std::io::Read;
use wireloom::result::Verdict;
use wireloom::{Control, Run, Status};
use wireloom_studio::frame::decode;
use wireloom_studio::protocol::{Scene, Timeline};
use wireloom_studio::replay::{Recorder, Replay};
use wireloom_studio::scene;

/// A cable with a clip and an end that moves in two steps; its name contains the end of a script element.
const TEXT: &str = r#"
schema = 1
name = "cable </script><script>alert(1)</script>"
[sections.cable]
diameter = "6 mm"
linear_density = "50 g/m"
axial_stiffness = 1e4
bending_stiffness = 0.01
torsion_stiffness = 0.008
min_bend_radius = "500 mm"
[[branches]]
name = "cable"
from = "A"
to = "B"
section = "cable"
length = "1 m"
segments = 40
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
[[obstacles]]
name = "floor"
shape = "plane"
position = [0, 0, "-900 mm"]
normal = [0, 0, 1]
[[steps]]
name = "out"
increments = 4
[[steps.move]]
constraint = "plug-B"
position = ["700 mm", 0, 0]
[[steps]]
name = "back"
increments = 3
[[steps.move]]
constraint = "plug-B"
position = ["500 mm", 0, 0]
"#;

fn recorded() -> (Replay, Run) {
    let (_, built) = wireloom::load(TEXT, &wireloom::registry()).expect("no faults");
    let mut recorder = Recorder::new(scene::of(&built.schedule, "wireloom 1", &built.network));
    let run = wireloom::run(built, &mut |_, end| {
        recorder.record(end);
        Control::Continue
    });
    assert_eq!(run.status(), Status::Converged);
    (recorder.finish(&run), run)
}

#[test]
fn every_increment_is_a_frame_and_ends_are_those_of_the_run() {
    let (replay, run) = recorded();
    let Timeline { frames, steps, events } = replay.timeline();
    assert_eq!((*frames as usize, replay.frames().len()), (7, 7));
    let steps: Vec<_> = steps.iter().map(|step| (step.name.as_str(), step.first, step.frames, step.planned)).collect();
    assert_eq!(steps, [("out", 0, 4, 4), ("back", 4, 3, 3)]);
    let mut iterations = 0;
    for (k, bytes) in replay.frames().iter().enumerate() {
        let (header, nodes) = decode(bytes).expect("a frame");
        assert_eq!((header.frame as usize, nodes.len()), (k, 41));
        assert_eq!(header.increment as usize, if k < 4 { k + 1 } else { k - 3 });
        iterations += header.iterations as usize;
    }
    // The work of increments adds up to that of the steps.
    assert_eq!(iterations, run.steps.iter().map(|end| end.minimiser.iterations).sum::<usize>());
    for (end, frame) in run.steps.iter().zip([3, 6]) {
        let (header, nodes) = decode(&replay.frames()[frame]).expect("a frame");
        assert_eq!((header.step.as_str(), header.status.as_str()), (end.name.as_str(), "converged"));
        assert_eq!(header.constraints[1].force, <[f64; 3]>::from(end.constraints[1].force));
        let cable = &end.branches[0];
        for (i, node) in nodes.iter().enumerate() {
            let d3 = cable.frame[i] * wireloom::geometry::Vector::z();
            let torque = cable.moment[i].dot(&d3);
            let bend = (cable.moment[i].norm_squared() - torque * torque).max(0.0).sqrt();
            let expected = [
                cable.position[i].x,
                cable.position[i].z,
                cable.s[i],
                1.0 / cable.bend_radius[i],
                cable.force[i].dot(&d3),
                bend,
                torque,
                cable.tension_at(i) / cable.axial_stiffness,
                0.5 * cable.diameter / cable.bend_radius[i],
            ];
            let found = [0, 2, 6, 7, 8, 9, 10, 11, 12].map(|column| node[column]);
            for (expected, found) in expected.iter().zip(found) {
                // f32 has seven digits; a bending moment near 0 has fewer after the subtraction above.
                assert!((expected - f64::from(found)).abs() < 1e-6 * (1.0 + expected.abs()), "{expected} {found}");
            }
            assert_eq!(node[13], 0.0, "it keeps no set");
            assert!(node[14].is_nan(), "clearance is unknown");
        }
    }
    assert_eq!(events.len(), run.events.len());
    let tight = events.iter().find(|event| event.kind == "bend-radius").expect("it bends more tightly than 0.5 m");
    let at = tight.position.expect("it happened somewhere");
    let worst = run.events.iter().find(|event| event.kind.word() == "bend-radius").expect("the same");
    assert!((tight.frame, worst.first.increment) == (0, 1) && (0.0..0.8).contains(&at[0]), "{tight:?}");
}

#[test]
fn the_sheet_of_a_run_leads_to_frames_and_is_no_solver_status() {
    let (replay, run) = recorded();
    let sheet = replay.sheet();
    assert_eq!((sheet.verdict.as_str(), sheet.status.as_str()), ("fail", "converged"));
    assert_eq!((sheet.verdict.as_str(), sheet.done, sheet.steps), (run.verdict().word(), 2, 2));
    assert_eq!(sheet.lines.len(), run.requirements.len());
    let first = &sheet.lines[0];
    assert_eq!((first.measure.as_str(), first.verdict.as_str(), first.bound.as_str()), ("bend_radius", "fail", "min"));
    let worst = run.requirements.iter().find(|line| line.verdict == Verdict::Fail).expect("it bends too tightly");
    assert_eq!((first.worst, first.limit, first.margin), (worst.worst, 0.5, worst.margin()));
    // The worst of the run is the worst violation of its frame.
    let frame = first.frame.expect("a frame") as usize;
    let (header, _) = decode(&replay.frames()[frame]).expect("a frame");
    assert_eq!((Some(&header.step), Some(header.increment)), (first.step.as_ref(), first.increment));
    let here = header.violations.iter().find(|own| own.name == first.name).expect("it is violated there");
    assert_eq!((Some(here.value), &here.place), (first.worst, &first.place));
}

/// Only sheets were kept once, and a frame did not say what is wrong in it.
#[test]
fn every_frame_says_what_is_violated_in_it_from_the_first_one_on() {
    let (replay, _) = recorded();
    for bytes in replay.frames() {
        let (header, nodes) = decode(bytes).expect("a frame");
        let tightest = nodes.iter().map(|node| 1.0 / node[7]).fold(f32::INFINITY, f32::min);
        let violation = header.violations.iter().find(|own| own.measure == "bend_radius").expect("bent too tightly");
        assert!((violation.value as f32 / tightest - 1.0).abs() < 1e-6, "{violation:?} {tightest}");
    }
}

#[test]
fn a_scene_tells_what_there_is() {
    let (replay, _) = recorded();
    let scene = replay.scene();
    assert!(!scene.live);
    assert_eq!((scene.branches[0].nodes, scene.branches[0].bend_radius_limit), (41, Some(0.5)));
    let place = scene.constraints[1].place.as_ref().expect("at an end");
    assert_eq!((place.0.as_str(), scene.constraints[1].moves, scene.constraints[1].turns), ("cable", true, true));
    assert!((place.1 - 1.0).abs() < 1e-12);
    let floor = &scene.obstacles[0];
    assert!(floor.corners.len() >= 12 && floor.triangles.iter().all(|k| 3 * (*k as usize) < floor.corners.len()));
}

#[test]
fn a_page_holds_a_run_and_names_stay_names() {
    let (replay, _) = recorded();
    let template = "<html><script type=\"application/json\" id=\"replay\">null</script><script>go()</script></html>";
    let page = replay.page(template);
    assert_eq!(page.matches("<script").count(), 2);
    assert_eq!(page.matches("alert").count(), 0);
    let packed = page.split("id=\"replay\">\"").nth(1).and_then(|rest| rest.split('"').next()).expect("a string");
    let packed = base64::engine::general_purpose::STANDARD.decode(packed).expect("base64");
    let mut bytes = Vec::new();
    flate2::read::GzDecoder::new(packed.as_slice()).read_to_end(&mut bytes).expect("gzip");
    let mut parts = Vec::new();
    let mut rest = bytes.as_slice();
    while let Some((length, more)) = rest.split_first_chunk::<4>() {
        let (part, more) = more.split_at(u32::from_le_bytes(*length) as usize);
        assert_eq!(part.len() % 4, 0, "numbers stand where machines read them at once");
        parts.push(part);
        rest = more;
    }
    #[derive(serde::Deserialize)]
    struct Head {
        scene: Scene,
        timeline: Timeline,
    }
    let head: Head = serde_json::from_slice(parts[0]).expect("the head");
    assert_eq!((&head.scene, &head.timeline), (replay.scene(), replay.timeline()));
    assert_eq!(parts[1..], replay.frames().iter().map(Vec::as_slice).collect::<Vec<_>>());
}
