//! Files that have no end, or keep their reader waiting: refused at once.

use crate::{cable, pipe};
use std::fs::File;
use wireloom_tests::place::Place;

/// Bytes. A file of this size that has no blocks: it costs nothing but to who reads it.
fn large(place: &Place, name: &str, megabytes: u64) {
    File::create(place.path(name)).and_then(|file| file.set_len(megabytes << 20)).expect("a sparse file");
}

/// Paths that are not plain files, and the message for each.
fn odd(place: &Place) -> [(String, &'static str); 4] {
    pipe(&place.path("pipe"));
    large(place, "large", 1100);
    let named = |name: &str| place.path(name).to_str().expect("UTF-8").to_owned();
    [
        (named("pipe"), "it is a device, a pipe or a socket, not a plain file"),
        ("/dev/zero".to_owned(), "it is a device, a pipe or a socket, not a plain file"),
        (named("."), "it is a folder, not a file"),
        (named("large"), "it has 1100 MB, and at most"),
    ]
}

#[test]
fn a_device_a_pipe_or_a_giant_in_place_of_a_scenario_is_refused_at_once() {
    let place = Place::new("");
    for (file, words) in odd(&place) {
        for command in ["check", "run", "sweep"] {
            place.run(&[command, &file]).says(1, &[&format!("cannot read {file}: {words}")]);
        }
        place.run(&["import", "kbl", &file]).says(1, &[words]);
        place.run(&["bench", "--harness", &file]).says(1, &[words]);
        place.run(&["plugin", "check", &file]).says(1, &[words]);
        place.run(&["models", "--allow-plugin", &file]).says(1, &[words]);
    }
}

#[test]
fn a_device_or_a_pipe_in_place_of_results_is_refused_at_once() {
    let place = Place::new("");
    for (file, words) in odd(&place).into_iter().take(2) {
        place.run(&["compare", &file, &file]).says(1, &[words]);
        place.run(&["report", &file]).says(1, &[words]);
        place.run(&["studio", &file, "--no-open"]).says(1, &[words]);
    }
    for name in ["result.json", "points.parquet"] {
        pipe(&place.path(name));
    }
    place.run(&["compare", ".", "."]).says(1, &["not a plain file"]);
    place.run(&["report", "."]).says(1, &["not a plain file"]);
    place.run(&["studio", ".", "--no-open"]).says(3, &["not a plain file"]);
}

#[test]
fn a_device_a_pipe_or_a_giant_that_a_scenario_names_is_refused_at_once() {
    let place = Place::new("");
    for (file, words) in odd(&place) {
        let named = [
            ("mesh", format!("[[obstacles]]\nname = \"body\"\nmesh = \"{file}\"\n")),
            ("wires", format!("[library]\nfiles = [\"{file}\"]\n")),
            ("path", format!("[[steps]]\nname = \"way\"\ncarry = [{{ what = [\"plug-B\"], path = \"{file}\" }}]\n")),
        ];
        for (what, more) in named {
            place.file("s.toml", cable(1, &more));
            for command in ["check", "run"] {
                place.run(&[command, "s.toml"]).says(1, &["s.toml:", &format!("cannot read \"{file}\": {words}")]);
            }
            assert!(!place.path("out").exists(), "{what}: work was begun");
        }
        place.file("s.toml", format!("plugins = {{ load = [\"{file}\"] }}\n{}", cable(1, "")));
        let ended = place.run(&["run", "s.toml", "--allow-plugin", &file]);
        ended.says(1, &["s.toml:1:"]);
    }
}

#[test]
fn check_says_the_faults_of_every_file_whatever_is_wrong_with_one() {
    let place = Place::new(&cable(1, ""));
    place.file("bytes.toml", b"schema = 1\nname = \"\xff\"\n");
    place.file("faulty.toml", "schema = 1\nname = 7\n");
    pipe(&place.path("pipe.toml"));
    let faults = ["bytes.toml:2: not UTF-8 text", "cannot read pipe.toml: ", "faulty.toml:2:8: "];
    let ended = place.run(&["check", "bytes.toml", "pipe.toml", "faulty.toml", "s.toml"]);
    ended.says(1, &faults);
    assert!(ended.out.starts_with("s.toml: OK ("), "{ended:#?}");
    // One that cannot be read at all counts most.
    let ended = place.run(&["check", "absent.toml", "faulty.toml", "s.toml"]);
    ended.says(3, &["cannot read absent.toml: ", "faulty.toml:2:8: "]);
    assert!(ended.out.starts_with("s.toml: OK ("), "{ended:#?}");
}
