//! Files that runs keep in their folder: one process at a time writes there, and damaged files are refused.

use crate::{SWEEP, cable, copy, files};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;
use wireloom_tests::place::{PATIENCE, Place, ended, kill};

#[test]
fn two_runs_in_one_folder_at_once_are_refused_and_the_first_goes_on() {
    let place = Place::new(&cable(20_000, "[output]\nvtk = true\n"));
    place.file("w.toml", cable(1, SWEEP));
    let first = place.begun(&["run", "s.toml", "--out", "o", "-q"], "o/vtk/0003.vtp");
    let number = first.id().to_string();
    for second in [&["run", "s.toml", "--out", "o"][..], &["run", "--resume", "o"], &["sweep", "w.toml", "--out", "o"]]
    {
        place.run(second).says(3, &["cannot write in the folder o: another process is writing its results there"]);
    }
    assert!(std::process::Command::new("kill").args(["-INT", &number]).status().expect("kill").success());
    let first = ended(first);
    first.says(2, &[]);
    let kept = place.result("o")["steps"][0]["increment"].as_u64().expect("an increment");
    let series = fs::read_dir(place.path("o/vtk")).expect("a folder").count() as u64;
    assert_eq!(series, kept, "the others have taken nothing away");
}

#[test]
fn two_sweeps_in_one_folder_at_once_are_refused_and_a_killed_one_leaves_it_free() {
    let place = Place::new(&cable(1, &SWEEP.replace("200", "20000")));
    place.file("short.toml", cable(1, SWEEP));
    let first = place.begun(&["sweep", "s.toml", "--out", "o", "-q"], "o/.wireloom/sweep/origin");
    place.run(&["sweep", "short.toml", "--out", "o"]).says(3, &["another process is writing its results there"]);
    kill(first);
    place.run(&["sweep", "short.toml", "--out", "o", "-q"]).says(0, &[]);
}

#[test]
fn partial_files_of_killed_runs_go_with_the_next_one() {
    let place = Place::new(&cable(1, ""));
    let kbl = wireloom_tests::root().join("crates/import/tests/small.kbl");
    let import = ["import", "kbl", kbl.to_str().expect("UTF-8"), "-o", "new/i.toml"];
    let partials = [
        "o/.wireloom/.result.json.4711.partial",
        "o/.wireloom/.000001.0123456789abcdef.partial",
        "new/.i.toml.0123456789abcdef.partial",
    ];
    let others =
        ["o/.mine.txt.0123456789abcdef.partial", "new/.j.toml.0123456789abcdef.partial", "new/.i.toml.mine.partial"];
    for name in partials.iter().chain(&others) {
        place.file(name, "half");
    }
    place.run(&["run", "s.toml", "--out", "o", "-q"]).says(0, &[]);
    place.run(&import).says(0, &[]);
    assert!(partials.iter().all(|name| !place.path(name).exists()));
    assert!(others.iter().all(|name| place.path(name).exists()), "what is not ours stays");
    // One that is being written now.
    let busy = fs::File::create(place.path("new/.i.toml.0123456789abcdef.partial")).expect("a file");
    busy.lock().expect("locked");
    place.run(&import).says(0, &[]);
    assert!(place.path("new/.i.toml.0123456789abcdef.partial").exists());
}

/// Files of every folder in which bits are flipped, and bits of each besides the first and the last.
const FILES: usize = 6;
const FLIPS: usize = 5;

/// Flips bits of files below `kept`, one at a time, in a copy of it, and hands over each copy's name and which file it
/// was.
fn flipped(place: &Place, kept: &Path, mut each: impl FnMut(&str, &str)) {
    let mut random = fastrand::Rng::with_seed(17);
    let mut all = files(kept);
    // What was only begun is removed, whatever is in it.
    all.retain(|(file, bytes)| !bytes.is_empty() && file.extension().is_none_or(|kind| kind != "partial"));
    random.shuffle(&mut all);
    let (mut taken, mut seen) = (BTreeMap::<PathBuf, usize>::new(), 0);
    for (file, bytes) in all {
        let of_folder = taken.entry(file.parent().expect("a folder").to_owned()).or_default();
        *of_folder += 1;
        if *of_folder > FILES {
            continue;
        }
        let name = file.strip_prefix(kept).expect("below it").to_str().expect("UTF-8").to_owned();
        let between = (0..FLIPS).map(|_| random.usize(0..8 * bytes.len()));
        for bit in [0, 8 * bytes.len() - 1].into_iter().chain(between) {
            let copied = format!("copy-{seen}");
            copy(kept, &place.path(&copied));
            let mut changed = bytes.clone();
            changed[bit / 8] ^= 1 << (bit % 8);
            let path = place.path(&copied).join(&name);
            fs::remove_file(&path).expect("removed");
            fs::write(path, changed).expect("written");
            each(&copied, &name);
            fs::remove_dir_all(place.path(&copied)).expect("removed");
            seen += 1;
        }
    }
    assert!(seen > 3 * FLIPS, "{seen} flips");
}

#[test]
fn a_flipped_bit_in_what_a_run_has_kept_is_never_taken_for_data() {
    let place =
        Place::new(&cable(400, "[output]\nvtk = true\nincrements = true\nswept = \"20 mm\"\npicture = false\n"));
    place.run(&["run", "s.toml", "--out", "whole", "-q"]).says(0, &[]);
    // Killed after a checkpoint on the way: some files are older than it, some are younger.
    let stamp = |name: &str| fs::metadata(place.path(name)).and_then(|data| data.modified()).ok();
    let begin = || place.begun(&["run", "s.toml", "--out", "kept", "-q"], "kept/vtk/0008.vtp");
    let mut child = begin();
    let began = Instant::now();
    while stamp("kept/.wireloom/standing") <= stamp("kept/vtk/0008.vtp") {
        assert!(began.elapsed() < PATIENCE, "no checkpoint");
        if child.try_wait().expect("a state").is_some() {
            // On a busy machine it may be over before anybody has looked.
            fs::remove_dir_all(place.path("kept")).expect("removed");
            child = begin();
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    kill(child);
    assert!(place.path("kept/.wireloom/origin").exists(), "the run is too short");
    let (mut refused, mut same) = (0, 0);
    flipped(&place, &place.path("kept"), |copied, name| {
        let ended = place.run(&["run", "--resume", copied, "-q"]);
        if ended.code == Some(0) {
            // Files that are younger than the checkpoint are written anew.
            assert!(place.result(copied) == place.result("whole"), "{name}: other numbers");
            let (now, whole) = (files(&place.path(copied)), files(&place.path("whole")));
            for ((file, now), (other, whole)) in now.iter().zip(&whole) {
                assert_eq!(file.file_name(), other.file_name(), "{name}: other files");
                // Times, and their hash.
                let differs = file.ends_with("result.json") || file.ends_with(".wireloom/files");
                assert!(now == whole || differs, "{name}: {} is another one", file.display());
            }
            same += 1;
        } else {
            ended.says(3, &[&format!("cannot use {copied}/{name}: it is damaged")]);
            refused += 1;
        }
    });
    assert!(refused > 60 && same > 5, "{refused} refused, {same} the same");
}

#[test]
fn a_flipped_bit_in_what_a_sweep_has_kept_is_never_taken_for_data() {
    let place = Place::new(&cable(1, &SWEEP.replace("200", "2000")));
    place.run(&["sweep", "s.toml", "--out", "whole", "-q"]).says(0, &[]);
    kill(place.begun(&["sweep", "s.toml", "--out", "kept", "-q"], "kept/.wireloom/sweep/000002"));
    flipped(&place, &place.path("kept"), |copied, name| {
        let damaged = place.run(&["sweep", "s.toml", "--out", copied, "-q"]);
        damaged.says(3, &[&format!("cannot use {copied}/{name}: it is damaged"), "remove it"]);
    });
    // As it says.
    let part = place.path("kept/.wireloom/sweep/000002");
    let mut bytes = fs::read(&part).expect("bytes");
    bytes[3] ^= 1;
    fs::write(&part, bytes).expect("written");
    place.run(&["sweep", "s.toml", "--out", "kept", "-q"]).says(3, &["kept/.wireloom/sweep/000002"]);
    fs::remove_file(part).expect("removed");
    place.run(&["sweep", "s.toml", "--out", "kept", "-q"]).says(0, &[]);
    let table = |folder: &str| fs::read(place.path(folder).join("points.parquet")).expect("a table");
    assert!(table("kept") == table("whole"));
}
