//! Interrupted runs: whatever stops one, it goes on to the same bits.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use wireloom::session::{Checkpoint, Monitor, Observer, Progress, Resumed};
use wireloom::{Control, Run, StepResult};
use wireloom_tests::cables::{branch, built, connector, section};
use wireloom_tests::place::Place;
use wireloom_tests::root;

/// A cable that is drawn through a smooth ring and a rough one, lifted and let go; more than one checkpoint in each
/// step.
const COLLARS: &str = r#"
[[constraints]]
name = "smooth"
kind = "collar"
at = { branch = "cable", s = 0.5 }
hold = ["position"]
slide = true
position = [0.4, 0, 0]
[[constraints]]
name = "rough"
kind = "collar"
at = { branch = "cable", s = 1.0 }
hold = ["position"]
slide = true
friction = 0.2
position = [0.8, 0, 0]
"#;
const STEPS: &str = r#"
[[steps]]
name = "draw"
increments = INCREMENTS
move = [{ constraint = "plug-B", position = [1.3, 0.1, 0.1] }]
[[steps]]
name = "turn"
increments = INCREMENTS
move = [
  { constraint = "plug-B", position = [1.1, 0.2, 0], turns = 0.5 },
  { constraint = "smooth", position = [0.4, 0, 0.2] },
]
[[steps]]
name = "let go"
increments = INCREMENTS
release = ["smooth"]
gravity = [0, -3, -9]
"#;

fn rings(segments: usize, increments: usize) -> String {
    [
        "schema = 1\nname = \"rings\"\n",
        &section("cable"),
        "min_bend_radius = \"60 mm\"\n",
        &branch("cable", ["A", "B"], "cable", 1.5, segments),
        &connector("plug-A", "A", [0.0, 0.0, 0.0]),
        COLLARS,
        &connector("plug-B", "B", [1.1, 0.0, 0.0]),
        &STEPS.replace("INCREMENTS", &increments.to_string()),
    ]
    .concat()
}

/// Keeps everything.
#[derive(Default)]
struct Keep {
    checkpoints: Vec<Vec<u8>>,
    steps: Vec<StepResult>,
}

impl Observer for Keep {
    fn increment(&mut self, _: &Progress, end: &StepResult, kept: bool) -> Control {
        if kept {
            self.steps.push(end.clone());
        }
        Control::Continue
    }

    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.checkpoints.push(postcard::to_stdvec(checkpoint).expect("bytes"));
    }
}

fn without_times(mut run: Run) -> Run {
    run.steps.iter_mut().for_each(|step| step.minimiser.seconds = 0.0);
    run
}

/// From every checkpoint of a run to its end: the same bits.
fn goes_on_from_every_checkpoint(text: &str) -> Run {
    let mut keep = Keep::default();
    let whole = without_times(wireloom::run_observed(built(text), None, &mut keep));
    for bytes in &keep.checkpoints {
        let checkpoint: Checkpoint = postcard::from_bytes(bytes).expect("a checkpoint");
        let built = built(text);
        assert!(checkpoint.fits(&built.network));
        let steps = keep.steps[..checkpoint.kept()].to_vec();
        let mut ignored = Keep::default();
        let run = wireloom::run_observed(built, Some(Resumed { checkpoint, steps }), &mut ignored);
        // What is printed has every digit, and tells −0 from 0.
        assert!(format!("{:?}", without_times(run)) == format!("{whole:?}"), "{}", whole.scenario);
    }
    whole
}

#[test]
fn sliding_cables_go_on_from_every_checkpoint() {
    let whole = goes_on_from_every_checkpoint(&rings(60, 25));
    assert_eq!(whole.status().word(), "converged");
    assert!(!whole.events.is_empty(), "something happened on the way");
}

#[test]
fn cables_that_rub_go_on_from_every_checkpoint() {
    let path = root().join("scenarios/contact/dragged_across.toml");
    let whole = goes_on_from_every_checkpoint(&fs::read_to_string(path).expect("a text"));
    assert_eq!(whole.status().word(), "converged");
}

/// Large multipliers act across gaps there: what the search for contacts knew of earlier states made the difference.
#[test]
fn a_rod_that_buckles_in_a_tube_goes_on_from_every_checkpoint() {
    let path = root().join("scenarios/contact/rod_in_tube.toml");
    let whole = goes_on_from_every_checkpoint(&fs::read_to_string(path).expect("a text"));
    assert_eq!(whole.status().word(), "converged");
}

#[test]
fn all_scenarios_go_on_from_every_checkpoint() {
    let mut seen = 0;
    for folder in ["analytic", "branches", "assembly", "mechanisms"] {
        let Ok(entries) = fs::read_dir(root().join("scenarios").join(folder)) else { continue };
        for path in entries.map(|entry| entry.expect("an entry").path()) {
            let name = path.to_string_lossy();
            if name.ends_with(".toml") && !name.ends_with(".expected.toml") {
                let text = fs::read_to_string(&path).expect("a text");
                if wireloom::load(&text, &wireloom::registry()).is_ok() {
                    goes_on_from_every_checkpoint(&text);
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 15, "{seen} scenarios");
}

/// A run that is stopped, by a thread of its own, after so many iterations; keeps the last checkpoint.
struct Stopped {
    monitor: Monitor,
    keep: Keep,
}

impl Observer for Stopped {
    fn increment(&mut self, progress: &Progress, end: &StepResult, kept: bool) -> Control {
        self.keep.increment(progress, end, kept)
    }
    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.keep.checkpoint(checkpoint);
    }
    fn monitor(&self) -> Monitor {
        self.monitor.clone()
    }
}

fn stopped_after(text: &str, iterations: u64) -> (Run, Keep) {
    let monitor = Monitor::default();
    let mut stopped = Stopped { monitor: monitor.clone(), keep: Keep::default() };
    let over = AtomicBool::new(false);
    let run = std::thread::scope(|scope| {
        scope.spawn(|| {
            while !over.load(Ordering::Relaxed) && monitor.seen().0 < iterations {
                std::hint::spin_loop();
            }
            monitor.stop();
        });
        let run = wireloom::run_observed(built(text), None, &mut stopped);
        over.store(true, Ordering::Relaxed);
        run
    });
    (run, stopped.keep)
}

/// A run that is stopped while the start is being found has no results, and says so.
#[test]
fn a_start_can_be_interrupted() {
    let (run, keep) = stopped_after(&rings(60, 1), 2);
    assert_eq!((run.status().word(), run.steps.len(), keep.checkpoints.len()), ("interrupted", 0, 0));
}

/// Wherever a run is stopped, within an increment too, it ends there and then; what was not done is no part of the
/// result, and from the last checkpoint it goes on to the same bits.
#[test]
fn an_increment_that_was_interrupted_is_no_part_of_the_result() {
    let text = rings(60, 6);
    let monitor = Monitor::default();
    let mut watched = Stopped { monitor: monitor.clone(), keep: Keep::default() };
    let whole = without_times(wireloom::run_observed(built(&text), None, &mut watched));
    let all = monitor.seen().0;
    let (mut within, rounds) = (0, 24);
    for round in 0..rounds {
        let (run, keep) = stopped_after(&text, all * round / rounds);
        if run.status().word() != "interrupted" {
            // It was faster than the thread that was to stop it.
            continue;
        }
        let ends: Vec<_> = run.steps.iter().map(|end| (&end.name, end.increment, end.status)).collect();
        assert!(run.steps.iter().all(|end| end.status.word() != "interrupted"), "{ends:?}");
        let Some(bytes) = keep.checkpoints.last() else { continue };
        within += 1;
        let checkpoint: Checkpoint = postcard::from_bytes(bytes).expect("a checkpoint");
        let steps = keep.steps[..checkpoint.kept()].to_vec();
        let resumed = Some(Resumed { checkpoint, steps });
        let run = without_times(wireloom::run_observed(built(&text), resumed, &mut Keep::default()));
        assert!(format!("{run:?}") == format!("{whole:?}"), "stopped in round {round}");
    }
    assert!(within > rounds / 4, "only {within} of {rounds} were stopped on the way");
}

#[test]
fn a_checkpoint_of_another_network_does_not_fit() {
    let mut keep = Keep::default();
    wireloom::run_observed(built(&rings(60, 1)), None, &mut keep);
    let checkpoint: Checkpoint = postcard::from_bytes(&keep.checkpoints[0]).expect("a checkpoint");
    assert!(!checkpoint.fits(&built(&rings(61, 1)).network));
}

/// Names and bytes of the VTK files.
fn series(place: &Place, folder: &str) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(place.path(folder).join("vtk")).expect("a folder");
    let mut files: Vec<_> = entries
        .map(|entry| {
            let path = entry.expect("an entry").path();
            (path.file_name().expect("a name").to_string_lossy().into_owned(), fs::read(&path).expect("bytes"))
        })
        .collect();
    files.sort();
    files
}

fn stamp(path: &Path) -> Option<std::time::SystemTime> {
    fs::metadata(path).and_then(|data| data.modified()).ok()
}

/// Killed twenty times, each time after a checkpoint more and a moment of random length, and once before there was any.
#[test]
fn killed_at_twenty_moments_the_result_is_the_same() {
    let scenario = rings(400, 400) + "[output]\nincrements = true\nvtk = true\nswept = \"6 mm\"\n";
    let place = Place::new(&scenario);
    let whole = place.run(&["run", "s.toml", "--out", "whole", "-q"]);
    assert_eq!((whole.code, whole.out.as_str(), whole.err.as_str()), (Some(0), "", ""));
    let mut random = fastrand::Rng::with_seed(20);
    let standing = place.path("o/.wireloom/standing");
    let mut kills = 0;
    for round in 0..=20 {
        let arguments: &[&str] = if round == 0 { &["run", "s.toml", "--out", "o"] } else { &["run", "--resume", "o"] };
        let before = stamp(&standing);
        let mut child = place.command(arguments).stdout(Stdio::null()).spawn().expect("the program runs");
        let began = Instant::now();
        // The first one is killed where it happens to be, as soon as there is something to resume.
        let origin = place.path("o/.wireloom/origin");
        let waits = || if round > 0 { stamp(&standing) == before } else { !origin.exists() };
        while waits() && child.try_wait().expect("a state").is_none() {
            assert!(began.elapsed() < Duration::from_secs(60), "no checkpoint");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_micros(random.u64(0..60_000)));
        child.kill().expect("killed");
        kills += i32::from(!child.wait().expect("ended").success());
    }
    assert!(kills >= 15, "the run is too short: {kills} kills");
    if place.path("o/.wireloom/origin").exists() {
        let rest = place.run(&["run", "--resume", "o", "-q"]);
        assert_eq!((rest.code, rest.err.as_str()), (Some(0), ""), "{}", rest.out);
    }
    assert!(place.result("o") == place.result("whole"));
    assert!(series(&place, "o") == series(&place, "whole"));
    for file in ["harness.pvd", "swept.glb"] {
        assert!(
            fs::read(place.path("o").join(file)).unwrap() == fs::read(place.path("whole").join(file)).unwrap(),
            "{file}"
        );
    }
    assert!(!standing.exists(), "nothing is left to resume");
    let left =
        fs::read_dir(place.path("o/.wireloom")).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    let mut left: Vec<String> = left.map(|name| name.to_string_lossy().into_owned()).collect();
    left.sort();
    assert_eq!(left, ["files", "lock", "scene"], "no kill leaves anything behind");
}

#[test]
fn what_cannot_be_resumed_is_refused_with_the_reason() {
    let place = Place::new(&rings(400, 150));
    place.run(&["run", "--resume", "nowhere"]).says(1, &["nothing to resume in nowhere"]);
    for wrong in [&["run", "s.toml", "--resume", "o"][..], &["run", "--resume", "o", "--minimiser", "newton"]] {
        assert_eq!(place.run(wrong).code, Some(1));
    }
    let mut child = place.command(&["run", "s.toml", "--out", "o"]).stdout(Stdio::null()).spawn().expect("runs");
    while !place.path("o/.wireloom/standing").exists() {
        assert!(child.try_wait().expect("a state").is_none(), "the run is too short");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    fs::write(place.path("s.toml"), rings(400, 151)).expect("written");
    place.run(&["run", "--resume", "o"]).says(1, &["s.toml has changed since the run was interrupted"]);
    fs::write(place.path("s.toml"), rings(400, 150)).expect("written");
    let standing = place.path("o/.wireloom/standing");
    let bytes = fs::read(&standing).expect("bytes");
    fs::write(&standing, &bytes[..bytes.len() / 2]).expect("written");
    place.run(&["run", "--resume", "o"]).says(3, &["o/.wireloom/standing: it is damaged"]);
    // A new run in the same folder begins anew, and leaves nothing of the old one.
    fs::write(place.path("s.toml"), rings(20, 1)).expect("written");
    assert_eq!(place.run(&["run", "s.toml", "--out", "o"]).code, Some(0));
    assert!(!standing.exists() && place.run(&["run", "--resume", "o"]).code == Some(1));
}
