//! The header matches this crate, and so does the list of the functions.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Begins the header.
const HEAD: &str = "\
// Wireloom: the assembly of branched cables, computed. Made from crates/capi; do not edit.
//
// Every function that can fail returns a WireloomCode, and fills its WireloomError unless that pointer is null; those
// that free handles have none. Handles are numbers; 0 is none. A handle that was freed, or is of something else, is an
// error. What a handle was made of may be freed before it. Strings are UTF-8 and end with a 0. Everything is in SI
// units. All functions may be called from any thread at the same time. README.md says more.";

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn header() -> PathBuf {
    here().join("include/wireloom.h")
}

fn generated() -> String {
    let mut config = cbindgen::Config {
        language: cbindgen::Language::C,
        include_guard: Some("WIRELOOM_H".into()),
        no_includes: true,
        sys_includes: vec!["stddef.h".into(), "stdint.h".into()],
        cpp_compat: true,
        documentation_style: cbindgen::DocumentationStyle::C99,
        style: cbindgen::Style::Both,
        usize_is_size_t: true,
        line_length: 120,
        tab_width: 4,
        header: Some(HEAD.into()),
        ..cbindgen::Config::default()
    };
    config.enumeration.rename_variants = cbindgen::RenameRule::QualifiedScreamingSnakeCase;
    // Functions take it as a number, because any number may come.
    config.export.include.push("WireloomFamily".into());
    // It follows the modules.
    let builder = cbindgen::Builder::new().with_config(config).with_src(here().join("src/lib.rs"));
    let mut text = vec![];
    builder.generate().expect("C can say all of it").write(&mut text);
    String::from_utf8(text).expect("UTF-8")
}

#[test]
fn the_header_is_current() {
    let want = generated();
    if std::env::var("WIRELOOM_HEADER").is_ok_and(|wish| wish == "write") {
        fs::write(header(), &want).expect("the header can be written");
    }
    let is = fs::read_to_string(header()).unwrap_or_default();
    assert!(is == want, "write it anew: WIRELOOM_HEADER=write cargo test -p wireloom-capi --test header");
}

/// Names of the functions in a folder of sources.
fn functions(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            functions(&path, found);
            continue;
        }
        let text = fs::read_to_string(&path).expect("a source");
        let names = text.lines().filter_map(|line| line.strip_prefix("pub extern \"C\" fn ")?.split('(').next());
        found.extend(names.map(str::to_owned));
    }
}

/// The list is the version script of the shared library. What a version has listed stays.
#[test]
fn the_functions_are_those_of_the_list_and_of_the_header() {
    let mut found = BTreeSet::new();
    functions(&here().join("src"), &mut found);
    let map = fs::read_to_string(here().join("wireloom.map")).expect("the list");
    let listed = map.lines().filter_map(|line| line.trim().strip_suffix(';')).filter(|f| f.starts_with("wireloom_"));
    assert_eq!(found, listed.map(str::to_owned).collect(), "wireloom.map");
    let header = generated();
    let once = |name: &&String| header.matches(&format!("{name}(")).count() == 1;
    let wrong: Vec<&String> = found.iter().filter(|name| !once(name)).collect();
    assert!(wrong.is_empty(), "not declared once in the header: {wrong:?}");
}
