//! What is refused, and with which words: the files of `scenarios/refused`, each beside the messages expected.

mod common;

use std::path::{Path, PathBuf};
use wireloom_scenario::{Files, parse_with_files, render};

fn files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/refused");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    files
}

/// The files beside them.
struct Beside;

impl Files for Beside {
    fn read(&self, path: &str) -> Result<String, String> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenarios/refused");
        std::fs::read_to_string(folder.join(path)).map_err(|error| error.to_string())
    }
}

#[test]
fn every_file_is_refused_in_the_words_expected() {
    let registry = common::registry();
    let files = files();
    assert!(files.len() > 30, "only {} files", files.len());
    let mut wrong = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        let expected = std::fs::read_to_string(file.with_extension("expected")).unwrap_or_default();
        let found =
            parse_with_files(&text, &Beside, &registry).err().map(|faults| render(&text, &faults)).unwrap_or_default();
        if found != expected || found.is_empty() {
            wrong.push(format!("{}\n--- expected\n{expected}--- found\n{found}", file.display()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
