//! `wireloom plugin new`: a folder with a plugin, ready to be built.

use crate::failure::{Failure, Outcome};
use crate::files::folder;
use std::io::Write;
use std::path::{Path, PathBuf};
use wireloom::plugins::{HEADER, file_name};

/// Path of the sources of this program when it was built.
const SOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

const RUST: &[(&str, &str)] = &[
    ("Cargo.toml", include_str!("../../templates/rust/Cargo.toml.txt")),
    ("src/lib.rs", include_str!("../../templates/rust/lib.rs.txt")),
    ("tests/closed_form.rs", include_str!("../../templates/rust/closed_form.rs.txt")),
    ("README.md", include_str!("../../templates/rust/README.md.txt")),
    ("{{name}}.toml", include_str!("../../templates/scenario.toml.txt")),
];

const C: &[(&str, &str)] = &[
    ("{{name}}.c", include_str!("../../templates/c/plugin.c.txt")),
    ("test.c", include_str!("../../templates/c/test.c.txt")),
    ("Makefile", include_str!("../../templates/c/Makefile.txt")),
    ("README.md", include_str!("../../templates/c/README.md.txt")),
    ("{{name}}.toml", include_str!("../../templates/scenario.toml.txt")),
    ("wireloom_plugin.h", HEADER_PLACE),
];

/// Placeholder for the header.
const HEADER_PLACE: &str = "{{header}}";

/// Makes the folder `name`.
pub fn new(name: &str, c: bool, sources: Option<&Path>, out: &mut dyn Write) -> Result<Outcome, Failure> {
    let letters = name.starts_with(|first: char| first.is_ascii_lowercase());
    if !letters || !name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-') || name == "test" {
        return Err(Failure::Input(format!(
            "\"{name}\" is no name for a plugin: take lower case letters, digits and hyphens, a letter first, \
             such as my-spring"
        )));
    }
    if wireloom::registry().constraint(name).is_some() {
        return Err(Failure::Input(format!("a kind `{name}` is built in: take another name")));
    }
    let sources = if c { PathBuf::new() } else { found(sources)? };
    let place = Path::new(name);
    if place.exists() {
        return Err(Failure::Input(format!("there is a `{name}` already: take another name, or remove it")));
    }
    let (files, library, load) = if c {
        (C, format!("{name}{}", std::env::consts::DLL_SUFFIX), name.to_owned())
    } else {
        (RUST, file_name(name), format!("target/release/{name}"))
    };
    let fill = |text: &str| {
        text.replace(HEADER_PLACE, HEADER)
            .replace("{{name}}", name)
            .replace("{{ident}}", &name.replace('-', "_"))
            .replace("{{library}}", &library)
            .replace("{{load}}", &load)
            .replace("{{sources}}", &sources.display().to_string().replace('\\', "/"))
    };
    for (file, text) in files {
        folder::write(&place.join(fill(file)), |out| out.write_all(fill(text).as_bytes()))?;
    }
    let build = if c { "make" } else { "cargo build --release" };
    let built = if c { library } else { format!("target/release/{library}") };
    let mut print = || {
        writeln!(out, "made {name}/; next:\n")?;
        writeln!(out, "  cd {name}\n  {build}\n  wireloom plugin check {built}")?;
        writeln!(out, "  wireloom run {name}.toml --allow-plugin {built}")
    };
    print().map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}

/// The sources of this program.
fn found(given: Option<&Path>) -> Result<PathBuf, Failure> {
    let folder = given.unwrap_or(Path::new(SOURCES));
    match folder.canonicalize() {
        Ok(folder) if folder.join("crates/plugin/Cargo.toml").is_file() => Ok(folder),
        _ => Err(Failure::Input(format!(
            "the sources of this program are not in {}: give their folder with --sources DIR, or make a plugin in C \
             with --c, which needs none",
            folder.display()
        ))),
    }
}
