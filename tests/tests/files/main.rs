//! Files that a stranger supplies, folders that runs share, disks that fail: with real processes.

#![cfg(unix)]

mod inputs;
mod kept;
mod links;
mod trouble;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use wireloom_tests::cables::hanging;

/// A cable between two plugs, one of which is moved in so many increments.
fn cable(increments: usize, more: &str) -> String {
    let draw = "move = [{ constraint = \"plug-B\", position = [0.8, 0.1, 0] }]";
    hanging("cable", 20, &format!("[[steps]]\nname = \"draw\"\nincrements = {increments}\n{draw}\n{more}\n"))
}

const SWEEP: &str = "[sweep.vary]\n\"branches.cable.length\" = { from = 0.9, to = 1.1, count = 200 }\n";

/// All files below a folder, in order: names and bytes.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let (mut open, mut files) = (vec![folder.to_owned()], vec![]);
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).expect("a folder") {
            let entry = entry.expect("an entry");
            if entry.file_type().expect("a type").is_dir() {
                open.push(entry.path());
            } else {
                files.push((entry.path(), fs::read(entry.path()).expect("bytes")));
            }
        }
    }
    files.sort();
    files
}

/// A copy of a folder. It shares its files with the first, since the program replaces files and never changes them.
fn copy(from: &Path, to: &Path) {
    for (file, _) in files(from) {
        let target = to.join(file.strip_prefix(from).expect("below it"));
        fs::create_dir_all(target.parent().expect("a folder")).expect("a folder");
        fs::hard_link(file, target).expect("a link");
    }
}

/// A named pipe, at which a reader waits for ever.
fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo").success());
}
