//! Working copies with planted links: nothing outside of the folder of the results is written or removed.

use crate::{SWEEP, cable, files, pipe};
use std::fs;
use wireloom_tests::place::Place;

/// Content of a file that must not change.
const SECRET: &str = "export PATH\n";

/// A folder with a file that must stay as it is; where `list` is, a list of files that was written by hand.
fn with_home(scenario: &str) -> Place {
    let place = Place::new(scenario);
    for name in ["home/.bashrc", "home/key.txt", "home/000001", "home/files", "home/results/000001"] {
        place.file(name, SECRET);
    }
    place
}

/// Nothing has come, gone or changed at home.
#[track_caller]
fn untouched(place: &Place) {
    let all = files(&place.path("home"));
    let names: Vec<_> = all.iter().map(|(file, _)| file.strip_prefix(place.path("home")).expect("below")).collect();
    let expected = [".bashrc", "000001", "files", "key.txt", "results/000001"];
    assert_eq!(names, expected.map(std::path::Path::new));
    assert!(all.iter().all(|(_, bytes)| bytes == SECRET.as_bytes()));
}

#[test]
fn planted_links_in_the_folder_lead_no_run_and_no_sweep_out_of_it() {
    let output = "[output]\nvtk = true\ncsv = true\nswept = \"10 mm\"\n";
    let planted = [
        (".wireloom", "home"),
        (".wireloom/files", "home/.bashrc"),
        (".wireloom/lock", "home/new"),
        (".wireloom/origin", "home/.bashrc"),
        (".wireloom/results", "home"),
        (".wireloom/results/000001", "home/.bashrc"),
        (".wireloom/swept", "home"),
        (".wireloom/sweep", "home"),
        (".wireloom/.standing.4711.partial", "home/.bashrc"),
        ("vtk", "home"),
        ("csv", "home"),
        ("csv/1-draw", "home"),
        ("result.json", "home/.bashrc"),
        ("points.parquet", "home/.bashrc"),
    ];
    for (name, target) in planted {
        for (command, scenario) in [("run", cable(2, output)), ("sweep", cable(1, SWEEP))] {
            let place = with_home(&scenario);
            place.link(&format!("o/{name}"), target);
            let ended = place.run(&[command, "s.toml", "--out", "o"]);
            ended.says(3, &["cannot write in the folder o", &format!("`{name}` in it is a link")]);
            untouched(&place);
        }
    }
}

/// Without a given folder its name comes from the scenario's author.
#[test]
fn a_default_folder_that_is_a_link_is_not_followed() {
    for (link, target) in [("out", "home"), ("out/s", "home")] {
        let place = with_home(&cable(1, ""));
        place.link(link, target);
        place.run(&["run", "s.toml"]).says(3, &["cannot make the folder out/s: it is a link"]);
        untouched(&place);
        // Who means it says so.
        place.run(&["run", "s.toml", "--out", "out/s"]).says(0, &[]);
    }
    let place = with_home(&cable(1, ""));
    place.file("...toml", cable(1, ""));
    place.run(&["run", "...toml"]).says(3, &["`..` is no name of a file in a folder"]);
}

#[test]
fn a_list_of_files_removes_nothing_through_a_link() {
    let place = with_home(&cable(1, ""));
    place.run(&["run", "s.toml", "--out", "o", "-q"]).says(0, &[]);
    let line = format!("{} home/key.txt", wireloom::export::sha256(SECRET.as_bytes()));
    let list = place.text("o/.wireloom/files") + &format!("{line}\t{}\n", wireloom::export::sha256(line.as_bytes()));
    place.file("o/.wireloom/files", list);
    place.link("o/home", "home");
    place.run(&["run", "s.toml", "--out", "o"]).says(3, &["`home` in it is a link"]);
    untouched(&place);
    // A list like this is believed only as far as the folder goes.
    fs::remove_file(place.path("o/home")).expect("removed");
    place.file("o/home/key.txt", "inside");
    place.run(&["run", "s.toml", "--out", "o", "-q"]).says(0, &[]);
    assert!(!place.path("o/home").exists());
    untouched(&place);
}

#[test]
fn what_a_hard_link_shares_is_not_written_to() {
    let place = with_home(&cable(2, "[output]\nvtk = true\n"));
    for name in [".wireloom/files", ".wireloom/lock", ".wireloom/scene", "result.json", "vtk/0001.vtp"] {
        let path = place.path("o").join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        // An empty list is a list.
        let target = if name.ends_with("files") { place.file("empty", "") } else { place.path("home/.bashrc") };
        fs::hard_link(target, path).expect("a link");
    }
    place.run(&["run", "s.toml", "--out", "o", "-q"]).says(0, &[]);
    assert_eq!(place.text("empty"), "");
    untouched(&place);
}

#[test]
fn files_that_the_user_names_are_not_written_through_links_or_into_devices() {
    let kbl = wireloom_tests::root().join("crates/import/tests/small.kbl");
    let kbl = kbl.to_str().expect("UTF-8");
    let place = with_home(&cable(1, ""));
    place.file("w.toml", cable(1, SWEEP));
    place.run(&["sweep", "w.toml", "--out", "w", "-q"]).says(0, &[]);
    for (kind, left) in [("link", SECRET), ("pipe", "")] {
        let target = place.path("target");
        if kind == "link" {
            place.link("target", "home/.bashrc")
        } else {
            pipe(&target)
        }
        let commands: [&[&str]; 4] = [
            &["import", "kbl", kbl, "-o", "target"],
            &["run", "s.toml", "--out", "o", "-q", "--page", "target"],
            &["report", "w", "-o", "target"],
            &["compare", "s.toml", "--segments", "10,20", "--report", "target", "-q"],
        ];
        for command in commands {
            place.run(command).says(3, &["cannot write target: it is a"]);
            let kept = fs::symlink_metadata(&target).expect("still there").file_type();
            assert_eq!((kept.is_symlink(), kept.is_file()), (!left.is_empty(), false), "{command:?}");
            untouched(&place);
        }
        fs::remove_file(target).expect("removed");
    }
    // What a page of the studio may ask for is not looked for behind a link either.
    place.link("o/away", "home");
    let line = format!("{} away/key.txt", wireloom::export::sha256(SECRET.as_bytes()));
    let list = place.text("o/.wireloom/files") + &format!("{line}\t{}\n", wireloom::export::sha256(line.as_bytes()));
    place.file("o/.wireloom/files", list);
    place.run(&["compare", "o", "o"]).says(0, &[]);
}
