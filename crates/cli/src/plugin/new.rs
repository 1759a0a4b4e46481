//! `wireloom plugin new`: a folder with a plugin, ready to be built.

use crate::arguments::PluginKind;
use crate::failure::{Failure, Outcome};
use crate::files::folder;
use std::io::Write;
use std::path::{Path, PathBuf};
use wireloom::plugins::{HEADER, HEADER_CPP, file_name};

/// Path of the sources of this program when it was built.
const SOURCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// Language of a plugin.
#[derive(Clone, Copy, PartialEq)]
pub enum Language {
    Rust,
    C,
    Cpp,
}

/// What the templates of a kind have in common.
struct Template {
    /// What the plugin adds, as the documentation says it.
    what: &'static str,
    /// Rows of the table of parameters.
    parameters: &'static str,
    /// What the scenario shows.
    shows: &'static str,
    scenario: &'static str,
    /// Sources in Rust, C and C++.
    sources: [&'static str; 3],
}

/// The row of a stiffness.
macro_rules! stiffness {
    () => {
        "| `stiffness` | N/m | of the spring; above 0 |"
    };
}

/// The templates in `templates/` of one kind.
macro_rules! template {
    ($kind:literal, $what:expr, $parameters:expr, $shows:expr) => {
        Template {
            what: $what,
            parameters: $parameters,
            shows: $shows,
            scenario: include_str!(concat!("../../templates/scenarios/", $kind, ".toml.txt")),
            sources: [
                include_str!(concat!("../../templates/rust/", $kind, ".rs.txt")),
                include_str!(concat!("../../templates/c/", $kind, ".c.txt")),
                include_str!(concat!("../../templates/cpp/", $kind, ".cpp.txt")),
            ],
        }
    };
}

const CONSTRAINT: Template = template!(
    "constraint",
    "a constraint of the kind `{{name}}`, a spring that pulls a station to its target",
    stiffness!(),
    "a cable hangs from the spring, which its weight draws out by `m g / k` = 2.4525 mm"
);
const EQUATION: Template = template!(
    "equation",
    "a constraint of the kind `{{name}}`, a rigid link between a station and its target",
    "| `length` | m | of the link; above 0 |",
    "a cable is drawn taut from the link, whose end is 50 mm below its target"
);
const MEMORY: Template = template!(
    "memory",
    "a constraint of the kind `{{name}}`, a spring between a station and its target that yields, and remembers it",
    concat!(stiffness!(), "\n| `strength` | N | force at which the spring yields; above 0 |"),
    "a cable is drawn down by 20 mm, and the spring yields at 1 N"
);
const JOINT: Template = template!(
    "joint",
    "the joint model `{{name}}`, whose arms are held by springs",
    "| `stiffness` | N m/rad | of the spring between each pair of arms; above 0 |",
    "a cantilever with the joint half way sinks by `F L³ / 3 E I + F (L/2)² / k` = 10.417 mm"
);

const ROD: Template = template!(
    "rod",
    "the rod `{{name}}`, a bundle that bends more easily the more it is bent",
    concat!(
        "| `loose_share` | | share of the bending stiffness that is left in tight bends; above 0, at most 1 |\n",
        "| `slip_curvature` | 1/m | curvature about which the wires come loose; above 0 |"
    ),
    "a moment at its end bends a cable to an arc of the curvature 4 1/m"
);

/// Files of a plugin in Rust, besides its source and its scenario.
const RUST: &[(&str, &str)] = &[
    ("Cargo.toml", include_str!("../../templates/rust/Cargo.toml.txt")),
    ("README.md", include_str!("../../templates/rust/README.md.txt")),
];
/// Likewise in C.
const C: &[(&str, &str)] = &[
    ("Makefile", include_str!("../../templates/c/Makefile.txt")),
    ("README.md", include_str!("../../templates/c/README.md.txt")),
    ("wireloom_plugin.h", HEADER_PLACE),
];
/// Likewise in C++.
const CPP: &[(&str, &str)] = &[
    ("Makefile", include_str!("../../templates/cpp/Makefile.txt")),
    ("README.md", include_str!("../../templates/cpp/README.md.txt")),
    ("wireloom_plugin.h", HEADER_PLACE),
    ("wireloom_plugin.hpp", HEADER_CPP_PLACE),
];

/// Placeholders for the headers.
const HEADER_PLACE: &str = "{{header}}";
const HEADER_CPP_PLACE: &str = "{{header-cpp}}";

/// Makes the folder `name`.
pub fn new(
    name: &str,
    kind: PluginKind,
    language: Language,
    sources: Option<&Path>,
    out: &mut dyn Write,
) -> Result<Outcome, Failure> {
    let letters = name.starts_with(|first: char| first.is_ascii_lowercase());
    if !letters || !name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-') || name == "test" {
        return Err(Failure::Input(format!(
            "\"{name}\" is no name for a plugin: take lower case letters, digits and hyphens, a letter first, \
             such as my-spring"
        )));
    }
    let built_in = wireloom::registry();
    if built_in.constraint(name).is_some() || built_in.joint(name).is_some() || built_in.rod(name).is_some() {
        return Err(Failure::Input(format!("a kind `{name}` is built in: take another name")));
    }
    let sources = if language == Language::Rust { found(sources)? } else { PathBuf::new() };
    let place = Path::new(name);
    if place.exists() {
        return Err(Failure::Input(format!("there is a `{name}` already: take another name, or remove it")));
    }
    let template = match kind {
        PluginKind::Constraint => CONSTRAINT,
        PluginKind::Equation => EQUATION,
        PluginKind::Memory => MEMORY,
        PluginKind::Joint => JOINT,
        PluginKind::Rod => ROD,
    };
    let beside = format!("{name}{}", std::env::consts::DLL_SUFFIX);
    let (files, source, library, load, build) = match language {
        Language::Rust => {
            (RUST, "src/lib.rs", file_name(name), format!("target/release/{name}"), "cargo build --release")
        }
        Language::C => (C, "{{name}}.c", beside, name.to_owned(), "make"),
        Language::Cpp => (CPP, "{{name}}.cpp", beside, name.to_owned(), "make"),
    };
    let fill = |text: &str| {
        text.replace(HEADER_PLACE, HEADER)
            .replace(HEADER_CPP_PLACE, HEADER_CPP)
            .replace("{{what}}", template.what)
            .replace("{{parameters}}", template.parameters)
            .replace("{{shows}}", template.shows)
            .replace("{{name}}", name)
            .replace("{{ident}}", &name.replace('-', "_"))
            .replace("{{library}}", &library)
            .replace("{{load}}", &load)
            .replace("{{sources}}", &sources.display().to_string().replace('\\', "/"))
    };
    let own = [(source, template.sources[language as usize]), ("{{name}}.toml", template.scenario)];
    for (file, text) in files.iter().copied().chain(own).chain(unit_test(kind, language)) {
        folder::write(&place.join(fill(file)), |out| out.write_all(fill(text).as_bytes()))?;
    }
    let built = if language == Language::Rust { format!("target/release/{library}") } else { library };
    let mut print = || {
        writeln!(out, "made {name}/; next:\n")?;
        writeln!(out, "  cd {name}\n  {build}\n  wireloom plugin check {built}")?;
        writeln!(out, "  wireloom run {name}.toml --allow-plugin {built}")
    };
    print().map_err(Failure::standard_output)?;
    Ok(Outcome::Done)
}

/// A test of the spring against what the books say, where there is one.
fn unit_test(kind: PluginKind, language: Language) -> Option<(&'static str, &'static str)> {
    match (kind, language) {
        (PluginKind::Constraint, Language::Rust) => {
            Some(("tests/closed_form.rs", include_str!("../../templates/rust/closed_form.rs.txt")))
        }
        (PluginKind::Constraint, Language::C) => Some(("test.c", include_str!("../../templates/c/test.c.txt"))),
        _ => None,
    }
}

/// The sources of this program.
fn found(given: Option<&Path>) -> Result<PathBuf, Failure> {
    let folder = given.unwrap_or(Path::new(SOURCES));
    match folder.canonicalize() {
        Ok(folder) if folder.join("crates/plugin/Cargo.toml").is_file() => Ok(folder),
        _ => Err(Failure::Input(format!(
            "the sources of this program are not in {}: give their folder with --sources DIR, or make a plugin in C \
             with --c or in C++ with --cpp, which need none",
            folder.display()
        ))),
    }
}
