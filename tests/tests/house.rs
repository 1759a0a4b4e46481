//! Rules of the workspace (see `crates/README.md`), checked against `cargo metadata` and the sources.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use wireloom_tests::imports::rings;
use wireloom_tests::{cargo, root};

/// Every crate of the workspace, and the crates of the workspace that it may depend on.
const ARROWS: &[(&str, &[&str])] = &[
    ("abi", &[]),
    ("core", &[]),
    ("shaders", &[]),
    ("models", &["core"]),
    ("shapes", &["core"]),
    ("solve", &["core"]),
    ("step", &["core"]),
    ("gpu", &["core", "shaders"]),
    ("scenario", &["core"]),
    ("formboard", &[]),
    ("import", &["core", "formboard", "scenario"]),
    ("export", &["core"]),
    ("plugin", &["core", "abi"]),
    ("host", &["core", "abi", "models"]),
    ("cable-tie", &["plugin"]),
    ("hinge-guide", &["plugin"]),
    ("softening-bundle", &["plugin"]),
    ("testkit", &["core"]),
    (
        "wireloom",
        &[
            "core",
            "models",
            "shapes",
            "step",
            "solve",
            "gpu",
            "scenario",
            "formboard",
            "import",
            "export",
            "host",
            "testkit",
        ],
    ),
    ("studio", &["wireloom"]),
    ("dataset", &["wireloom"]),
    ("cli", &["wireloom", "studio", "dataset"]),
    ("python", &["wireloom", "studio", "dataset"]),
    ("capi", &["wireloom"]),
    ("xtask", &[]),
    ("tests", &["wireloom"]),
];

/// Crates that any crate may also use in its own tests.
const FOR_TESTS: &[&str] = &["core", "testkit", "models", "shapes", "scenario", "solve"];

/// Crates from outside (a `*` ends a prefix) that one crate of the workspace alone may name.
const ONE_NAMES: &[(&str, &str)] = &[
    ("toml", "scenario"),
    ("toml_edit", "scenario"),
    ("parry*", "shapes"),
    ("wgpu*", "gpu"),
    ("libloading", "host"),
    ("parquet", "export"),
    ("dxf", "formboard"),
    ("pdf-writer", "formboard"),
    ("cap-*", "cli"),
    ("clap", "cli"),
    ("comfy-table", "cli"),
    ("ctrlc", "cli"),
    ("indicatif", "cli"),
    ("miette", "cli"),
    ("object_store", "dataset"),
    ("pyo3", "python"),
];

/// Crates that may contain `unsafe`.
const UNSAFE: &[&str] = &["abi", "plugin", "host", "gpu", "capi"];
/// Crates that may print.
const PRINT: &[&str] = &["cli", "xtask"];
/// Modules that reach out of the program: files, networks, the environment, other programs.
const OUTSIDE: &[&str] = &["std::fs", "std::net", "std::env", "std::process"];
/// Crates that may reach out.
const REACH_OUT: &[&str] = &["cli", "python", "capi", "xtask", "host", "studio", "dataset", "step"];
/// A file that is longer has more than one topic.
const LINES: usize = 900;
/// Most characters of a line.
const COLUMNS: usize = 120;
/// Rings of imports that may be: crate, files, reason.
const RINGS: &[(&str, &[&str], &str)] = &[];

/// `core` for `wireloom-core`.
fn short(package: &str) -> &str {
    package.strip_prefix("wireloom-").unwrap_or(package)
}

/// The packages of the workspace as cargo sees them.
fn packages() -> Vec<Value> {
    let out =
        cargo().args(["metadata", "--format-version", "1", "--no-deps", "--offline"]).output().expect("cargo runs");
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let metadata: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    metadata["packages"].as_array().expect("packages").clone()
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_else(|| panic!("no `{key}` in {value}"))
}

/// Names of what a package depends on; `tests`: in its tests only, or else in what others use of it.
fn dependencies(package: &Value, tests: bool) -> Vec<&str> {
    let all = package["dependencies"].as_array().expect("dependencies");
    all.iter().filter(|d| (d["kind"] == "dev") == tests).map(|d| text(d, "name")).collect()
}

fn allowed(crate_: &str) -> Option<&'static [&'static str]> {
    ARROWS.iter().find(|(from, _)| *from == crate_).map(|(_, to)| *to)
}

/// All Rust files below a folder.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// `(crate, file, text)` of every file in `crates/*/src`, `plugins/*/src` and `shaders/src`.
fn library_sources() -> Vec<(String, PathBuf, String)> {
    let mut all = vec![];
    let entries = ["crates", "plugins"].map(|folder| fs::read_dir(root().join(folder)).expect("a folder"));
    let folders = entries.into_iter().flatten().map(|entry| entry.expect("an entry").path());
    for folder in folders.chain([root().join("shaders")]) {
        let mut files = vec![];
        sources(&folder.join("src"), &mut files);
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        all.extend(files.into_iter().map(|file| {
            let text = fs::read_to_string(&file).expect("UTF-8");
            (name.clone(), file, text)
        }));
    }
    assert!(all.len() > 20, "the sources were not found");
    all
}

/// The text without comments that fill the rest of a line; line numbers stay.
fn without_comments(text: &str) -> String {
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Lines for which `found` holds, as `file:line`.
fn places(file: &Path, text: &str, found: impl Fn(&str) -> bool) -> Vec<String> {
    let lines = text.lines().enumerate().filter(|(_, line)| found(line));
    lines.map(|(k, _)| format!("{}:{}", file.strip_prefix(root()).unwrap_or(file).display(), k + 1)).collect()
}

fn has_word(line: &str, word: &str) -> bool {
    line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|found| found == word)
}

#[test]
fn arrows_are_as_drawn() {
    let packages = packages();
    let members: BTreeSet<&str> = packages.iter().map(|package| text(package, "name")).collect();
    let mut faults = vec![];
    for package in &packages {
        let name = short(text(package, "name"));
        let Some(allowed) = allowed(name) else {
            faults.push(format!("{name}: not in the table of arrows"));
            continue;
        };
        for (tests, more) in [(false, &[][..]), (true, FOR_TESTS)] {
            for to in dependencies(package, tests).into_iter().filter(|to| members.contains(to)).map(short) {
                if !allowed.contains(&to) && !more.contains(&to) {
                    faults.push(format!("{name} → {to}{}", if tests { " (tests)" } else { "" }));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn crates_live_where_their_names_say() {
    for package in packages() {
        let name = short(text(&package, "name"));
        let manifest = Path::new(text(&package, "manifest_path"));
        let folder = manifest.parent().and_then(Path::file_name).expect("a folder");
        assert_eq!(folder, name, "{}", manifest.display());
    }
}

#[test]
fn some_crates_are_named_by_one_crate_alone() {
    let mut faults = vec![];
    for package in &packages() {
        let name = short(text(package, "name"));
        for to in dependencies(package, false) {
            for (outside, owner) in ONE_NAMES {
                let meant = outside.strip_suffix('*').map_or(to == *outside, |prefix| to.starts_with(prefix));
                if meant && name != *owner {
                    faults.push(format!("{name} names {to}, which is for {owner} alone"));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn the_readme_of_the_crates_draws_the_same_arrows() {
    let readme = fs::read_to_string(root().join("crates/README.md")).expect("crates/README.md");
    let block = readme.split("```text").nth(1).and_then(|rest| rest.split("```").next()).expect("a block of arrows");
    let mut drawn: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in block.lines().filter(|line| line.contains('→')) {
        let (name, rest) = line.split_once('→').expect("an arrow");
        let to = rest.trim_start().split("  ").next().unwrap_or_default();
        let to = match to {
            "–" => BTreeSet::new(),
            "all of the above" => drawn.keys().cloned().collect(),
            list => list.split(", ").map(str::to_owned).collect(),
        };
        drawn.insert(name.trim().trim_end_matches('/').to_owned(), to);
    }
    let packages = packages();
    let there: BTreeSet<&str> = packages.iter().map(|package| short(text(package, "name"))).collect();
    let table: BTreeMap<String, BTreeSet<String>> = ARROWS
        .iter()
        .filter(|(from, _)| there.contains(from) && *from != "tests")
        .map(|(from, to)| {
            let to = to.iter().filter(|to| there.contains(**to)).map(|to| (*to).to_owned());
            ((*from).to_owned(), to.collect())
        })
        .collect();
    assert_eq!(drawn, table);
}

#[test]
fn every_crate_takes_the_lints_of_the_workspace() {
    for package in packages() {
        let manifest = text(&package, "manifest_path");
        let content = fs::read_to_string(manifest).expect("a manifest");
        assert!(content.contains("[lints]\nworkspace = true\n"), "{manifest}");
    }
}

#[test]
fn unsafe_stands_only_where_it_may() {
    let mut faults = vec![];
    for (name, file, text) in library_sources() {
        if !UNSAFE.contains(&name.as_str()) {
            faults.extend(places(&file, &without_comments(&text), |line| has_word(line, "unsafe")));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn libraries_do_not_print() {
    let mut faults = vec![];
    let printing = ["println!", "print!", "eprintln!", "eprint!", "dbg!", "stdout()", "stderr()"];
    for (name, file, text) in library_sources() {
        if !PRINT.contains(&name.as_str()) {
            let prints = |line: &str| printing.iter().any(|word| line.contains(word));
            faults.extend(places(&file, &without_comments(&text), prints));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn libraries_reach_for_nothing_outside() {
    let mut faults = vec![];
    for (name, file, text) in library_sources() {
        if !REACH_OUT.contains(&name.as_str()) {
            let reaches = |line: &str| OUTSIDE.iter().any(|path| line.contains(path));
            faults.extend(places(&file, &without_comments(&text), reaches));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn every_exception_to_a_lint_has_a_reason() {
    let mut files = vec![];
    for folder in ["crates", "shaders", "tests"] {
        sources(&root().join(folder), &mut files);
    }
    let mut faults = vec![];
    for file in files {
        let text = without_comments(&fs::read_to_string(&file).expect("UTF-8"));
        for opening in ["[allow(", "[expect("] {
            for (start, _) in text.match_indices(opening).filter(|(at, _)| text[..*at].ends_with(['#', '!'])) {
                let attribute = text[start..].split(")]").next().unwrap_or_default();
                if !attribute.contains("reason = ") {
                    let line = text[..start].lines().count();
                    faults.push(format!("{}:{line}", file.strip_prefix(root()).unwrap_or(&file).display()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

#[test]
fn files_are_short_enough_to_be_read() {
    let long: Vec<String> = library_sources()
        .into_iter()
        .map(|(_, file, text)| (text.lines().count(), file))
        .filter(|(lines, _)| *lines > LINES)
        .map(|(lines, file)| format!("{}: {lines} lines", file.display()))
        .collect();
    assert!(long.is_empty(), "{long:#?}");
}

#[test]
fn no_line_is_too_long() {
    let mut files = vec![];
    for folder in ["crates", "plugins", "shaders", "tests"] {
        sources(&root().join(folder), &mut files);
    }
    let long: Vec<String> = files
        .iter()
        .flat_map(|file| {
            let text = fs::read_to_string(file).expect("UTF-8");
            places(file, &text, |line| line.chars().count() > COLUMNS)
        })
        .collect();
    assert!(long.is_empty(), "{} lines: {long:#?}", long.len());
}

#[test]
fn no_files_of_a_crate_import_each_other_in_a_ring() {
    let mut faults = vec![];
    for package in packages() {
        let name = short(text(&package, "name"));
        let manifest = Path::new(text(&package, "manifest_path"));
        for ring in rings(&manifest.with_file_name("src")) {
            let allowed = |(of, files, _): &(&str, &[&str], &str)| *of == name && ring == *files;
            if !RINGS.iter().any(allowed) {
                faults.push(format!("{name}: {}", ring.join(", ")));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
