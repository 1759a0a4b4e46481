//! Plugins as their users and their authors meet them: made, built, checked, run, and misbehaving in every way we could
//! think of.

use libtest_mimic::{Arguments, Failed, Trial};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use tempfile::TempDir;
use wireloom_tests::{program, root};

#[path = "plugins/callable.rs"]
mod callable;
#[path = "plugins/check.rs"]
mod check;
#[path = "plugins/earlier.rs"]
mod earlier;
#[path = "plugins/hostile.rs"]
mod hostile;
#[path = "plugins/joint.rs"]
mod joint;
#[path = "plugins/newcomer.rs"]
mod newcomer;
#[path = "plugins/real.rs"]
mod real;
#[path = "plugins/rod.rs"]
mod rod;
#[path = "plugins/sweeps.rs"]
mod sweeps;
#[path = "plugins/trust.rs"]
mod trust;
#[path = "plugins/zig.rs"]
mod zig;

type Checked = Result<(), Failed>;

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    let compiler = Command::new(compiler()).arg("--version").output().is_ok();
    let mut trials = vec![];
    let groups = [
        real::trials(),
        joint::trials(),
        rod::trials(),
        callable::trials(),
        trust::trials(),
        newcomer::trials(),
        check::trials(),
        earlier::trials(),
        hostile::trials(),
        sweeps::trials(),
    ];
    for (name, check) in groups.into_iter().flatten() {
        let reason = if compiler { "" } else { " (ignored: no C compiler, `cc` or what CC names)" };
        trials.push(Trial::test(format!("{name}{reason}"), check).with_ignored_flag(!compiler));
    }
    trials.push(zig::trial());
    libtest_mimic::run(&arguments, trials).exit_code()
}

/// A test, by name.
type Named = (String, Box<dyn FnOnce() -> Checked + Send>);

fn named(name: &str, check: fn() -> Checked) -> Named {
    (name.to_owned(), Box::new(check))
}

fn compiler() -> std::ffi::OsString {
    std::env::var_os("CC").unwrap_or_else(|| "cc".into())
}

/// Compiles a plugin in C.
fn compile(source: &Path, library: &Path, more: &[&str]) -> Checked {
    let done = Command::new(compiler())
        .args(["-std=gnu11", "-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-fvisibility=hidden", "-I"])
        .arg(root().join("crates/abi/include"))
        .args(more)
        .arg("-o")
        .arg(library)
        .arg(source)
        .arg("-lm")
        .output()?;
    if done.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&done.stderr).into_owned().into()) }
}

/// Compiles a plugin in C++.
fn compile_cpp(source: &Path, library: &Path, more: &[&str]) -> Checked {
    let done = Command::new(std::env::var_os("CXX").unwrap_or_else(|| "c++".into()))
        .args(["-std=c++20", "-O1", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-fvisibility=hidden", "-I"])
        .arg(root().join("crates/abi/include"))
        .args(more)
        .arg("-o")
        .arg(library)
        .arg(source)
        .output()?;
    if done.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&done.stderr).into_owned().into()) }
}

/// The library of a plugin in Rust, built with the profile of the tests.
fn library(package: &str) -> PathBuf {
    program().with_file_name(format!(
        "{}{}{}",
        std::env::consts::DLL_PREFIX,
        package.replace('-', "_"),
        std::env::consts::DLL_SUFFIX
    ))
}

/// The strap, which is in C.
fn strap(folder: &Path) -> Result<PathBuf, Failed> {
    let library = folder.join("libelastic_strap.so");
    compile(&root().join("plugins/elastic-strap/elastic_strap.c"), &library, &[])?;
    Ok(library)
}

/// A folder to work in.
struct Place(TempDir);

/// End of a program.
#[derive(Debug)]
struct Ended {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Place {
    fn new() -> Result<Self, Failed> {
        Ok(Self(tempfile::tempdir()?))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The program, in this folder, with an empty search path.
    fn wireloom(&self, arguments: &[&str]) -> Result<Ended, Failed> {
        self.wireloom_with(arguments, None)
    }

    fn wireloom_with(&self, arguments: &[&str], search: Option<&Path>) -> Result<Ended, Failed> {
        let mut command = Command::new(program());
        command.args(arguments).current_dir(self.0.path()).env_remove("WIRELOOM_PLUGINS").env("HOME", self.0.path());
        if let Some(folder) = search {
            command.env("WIRELOOM_PLUGINS", folder);
        }
        let output = command.output()?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Ok(Ended { code: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) })
    }

    fn json(&self, name: &str) -> Result<Value, Failed> {
        Ok(serde_json::from_str(&fs::read_to_string(self.path(name))?)?)
    }
}

impl Ended {
    fn expect(self, code: i32) -> Result<Self, Failed> {
        if self.code == Some(code) { Ok(self) } else { Err(format!("expected exit code {code}: {self:#?}").into()) }
    }

    fn says(&self, words: &[&str]) -> Checked {
        let missing: Vec<_> = words.iter().filter(|words| !self.err.contains(**words)).collect();
        if missing.is_empty() { Ok(()) } else { Err(format!("it does not say {missing:?}: {self:#?}").into()) }
    }
}

fn ensure(holds: bool, otherwise: impl std::fmt::Debug) -> Checked {
    if holds { Ok(()) } else { Err(format!("{otherwise:#?}").into()) }
}

/// A number of a JSON document.
fn number(value: &Value, pointer: &str) -> f64 {
    value.pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no number at {pointer} of {value:#}"))
}

fn near(what: &str, got: f64, want: f64, tolerance: f64) -> Checked {
    ensure((got - want).abs() <= tolerance * want.abs(), format!("{what}: {got:e} instead of {want:e}"))
}
