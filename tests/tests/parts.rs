//! Sweeps in parts, written by several processes: equal to the table of one process, whatever happens to them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Instant;
use tempfile::TempDir;
use wireloom::export::table::read;
use wireloom_tests::cables::hanging;
use wireloom_tests::program;

const MANY: &str = r#"
[sweep]
method = "latin-hypercube"
samples = 640
seed = 5
[sweep.vary]
"branches.cable.length" = { mean = "1 m", deviation = "20 mm" }
"constraints.plug-B.position.0" = { from = 0.5, to = 0.7 }
"sections.cable.bending_stiffness" = { values = [0.01, "12000 N mm^2"] }
"#;

/// A folder with a scenario.
fn place(sweep: &str) -> TempDir {
    let place = tempfile::tempdir().expect("a folder");
    fs::write(place.path().join("s.toml"), hanging("cable", 12, sweep)).expect("written");
    place
}

fn command(place: &TempDir, arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command.arg("sweep").args(arguments).current_dir(place.path()).env("RAYON_NUM_THREADS", "1");
    command
}

/// Exit code, and all that was said.
fn run(place: &TempDir, arguments: &[&str]) -> (i32, String) {
    let Output { status, stdout, stderr } = command(place, arguments).output().expect("it runs");
    let said = format!("{}{}", String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    (status.code().unwrap_or(-1), said)
}

fn table(place: &TempDir, folder: &str) -> Vec<u8> {
    fs::read(place.path().join(folder).join("points.parquet")).expect("a table")
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).map(|all| all.map(|entry| entry.expect("an entry").file_name()).collect());
    let names: Vec<std::ffi::OsString> = entries.unwrap_or_default();
    names.into_iter().map(|name| name.to_string_lossy().into_owned()).collect()
}

#[test]
fn parts_of_several_processes_have_the_bytes_of_the_table_of_one() {
    let place = place(MANY);
    assert_eq!(run(&place, &["s.toml", "--out", "alone"]).0, 0);
    let ranges = ["600..640", "280..600", "0..280", "280..600"];
    let workers = ranges.map(|range| {
        command(&place, &["s.toml", "--points", range, "--into", "parts"])
            .stdout(Stdio::null())
            .spawn()
            .expect("started")
    });
    for mut worker in workers {
        assert!(worker.wait().expect("it ends").success(), "a range that another one computes too does no harm");
    }
    let (code, said) = run(&place, &["status", "parts"]);
    assert!(code == 0 && said.contains("done        640 (100.0 %) in 3 parts"), "{said}");
    assert!(said.contains("points/s") && said.contains("complete: wireloom sweep compact parts"), "{said}");
    let (code, said) = run(&place, &["compact", "parts"]);
    assert!(code == 0 && said.contains("wrote parts/points.parquet: 640 points"), "{said}");
    assert!(table(&place, "alone") == table(&place, "parts"), "the bytes differ");
    let (code, said) = run(&place, &["s.toml", "--into", "parts"]);
    assert!(code == 0 && said.contains("all points are in parts already"), "{said}");
}

#[test]
fn processes_that_are_killed_at_random_lose_no_row_and_double_none() {
    let place = place(MANY);
    let started = Instant::now();
    assert_eq!(run(&place, &["s.toml", "--out", "alone"]).0, 0);
    // A part takes about a sixteenth of the sweep: most processes are killed within their first.
    let part = started.elapsed() / 16;
    let mut random = fastrand::Rng::with_seed(1);
    let start = || {
        let mut command = command(&place, &["s.toml", "--into", "parts", "--each", "40"]);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("started")
    };
    let (mut workers, mut kills) = ([start(), start()], 0);
    let parts = place.path().join("parts/parts");
    // Of 16 parts at most 12, so that work is left.
    while kills < 30 && names(&parts).len() < 12 {
        std::thread::sleep(part.mul_f64(random.f64()));
        let worker = &mut workers[random.usize(..2)];
        worker.kill().expect("killed");
        kills += usize::from(!worker.wait().expect("it ends").success());
        *worker = start();
    }
    for mut worker in workers {
        worker.kill().expect("killed");
        worker.wait().expect("it ends");
    }
    assert!(kills > 3, "{kills} kills");
    let (code, said) = run(&place, &["s.toml", "--into", "parts"]);
    assert_eq!(code, 0, "{said}");
    assert_eq!(run(&place, &["compact", "parts", "--quiet"]), (0, String::new()));
    assert!(table(&place, "alone") == table(&place, "parts"), "the bytes differ after {kills} kills");
}

#[test]
fn ranges_that_cut_a_chain_and_other_bad_input_are_refused_with_what_would_be_right() {
    let place = place(MANY);
    for (arguments, expected) in [
        (&["s.toml", "--points", "10..100", "--into", "p"][..], "0..120 would be right"),
        (&["s.toml", "--points", "600..2000", "--into", "p"], "the sweep has the points 0..640"),
        (&["s.toml", "--points", "40..40", "--into", "p"], "has no points"),
        (&["s.toml", "--points", "40", "--into", "p"], "write 0..64, where 64 does not count"),
        (&["s.toml", "--points", "0..40"], "--into <DIR|URL>"),
        (&["s.toml", "--into", "p", "--out", "o"], "cannot be used with"),
        (&["s.toml", "--into", "p", "--columns", "forc"], "there is no column `forc`; did you mean `force`?"),
        (&["s.toml", "--into", "ftp://host/p"], "give a folder"),
        (&["status", "nowhere"], "nowhere has no sweep.json"),
        (&["compact", "nowhere"], "nowhere has no sweep.json"),
    ] {
        let (code, said) = run(&place, arguments);
        assert!(code == 1 && said.contains(expected), "{arguments:?}: {code}: {said}");
    }
    assert_eq!(names(place.path()), ["s.toml"], "nothing was written");
    let swept = hanging("cable", 12, &MANY.replace("seed = 5", "swept = \"40 mm\""));
    fs::write(place.path().join("t.toml"), swept).expect("written");
    let (code, said) = run(&place, &["t.toml", "--into", "p"]);
    assert!(code == 1 && said.contains("leave out `swept`"), "{said}");
    assert_eq!(run(&place, &["s.toml", "--points", "40..80", "--into", "p"]).0, 0);
    let (code, said) = run(&place, &["compact", "p"]);
    assert!(code == 1 && said.contains("no part has the points 0..40, 80..640"), "{said}");
    let (code, said) = run(&place, &["status", "p"]);
    assert!(code == 2 && said.contains("missing     600 (0..40, 80..640)"), "{said}");
    fs::write(place.path().join("t.toml"), hanging("cable", 12, &MANY.replace("640", "600"))).expect("written");
    let (code, said) = run(&place, &["t.toml", "--into", "p"]);
    assert!(code == 1 && said.contains("p has the parts of another sweep"), "{said}");
    let part = place.path().join("p/parts").join(&names(&place.path().join("p/parts"))[0]);
    fs::write(&part, "PAR1").expect("written");
    let (code, said) = run(&place, &["status", "p"]);
    assert!(code == 2 && said.contains("damaged     parts/0000000040-0000000080-"), "{said}");
}

#[test]
fn points_that_failed_are_told_by_reason() {
    let place = place(
        "[sweep.vary]\n\"branches.cable.length\" = { values = [\"1 m\", -1, 1.2] }\n\
         \"name\" = { values = [\"x\", \"y\"] }\n",
    );
    let (code, said) = run(&place, &["s.toml", "--into", "p"]);
    assert!(code == 0 && said.contains("6 points, 0..6; 2 did not converge"), "{said}");
    let (code, said) = run(&place, &["status", "p"]);
    assert!(code == 0 && said.contains("refused     2") && said.contains("`length` = -1 is too small"), "{said}");
    assert_eq!(run(&place, &["compact", "p"]).0, 0);
    let page = Command::new(program()).args(["report", "p"]).current_dir(place.path()).output().expect("it runs");
    assert!(page.status.success() && place.path().join("p/report.html").exists(), "{page:?}");
}

#[test]
fn ten_columns_take_at_most_a_hundred_bytes_a_row() {
    let place = place(MANY);
    let columns = "branches.cable.length,constraints.plug-B.position.0,sections.cable.bending_stiffness,verdict,\
                   margin,min_bend_radius,max_force,energy.total,force.plug-A,moment.plug-B";
    let (code, said) = run(&place, &["s.toml", "--into", "p", "--columns", columns]);
    assert_eq!(code, 0, "{said}");
    assert_eq!(run(&place, &["compact", "p", "--quiet"]).0, 0);
    let table = table(&place, "p");
    let size = table.len() as f64 / 640.0;
    let read = read(table).expect("a table");
    let names: Vec<&str> = read.columns.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!((names.len(), names[0], read.rows()), (13, "point", 640), "{names:?}");
    assert!(size < 100.0, "{size} bytes a row");
    // A report of a table without the columns it would show.
    let page = Command::new(program()).args(["report", "p"]).current_dir(place.path()).output().expect("it runs");
    assert!(page.status.success(), "{page:?}");
}
