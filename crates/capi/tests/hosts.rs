//! Programs in C and C++ that use the library as it is installed, compiled here.

use libtest_mimic::{Arguments, Failed, Trial};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};
use std::sync::OnceLock;
use wireloom::geometry::{Vector, columns};
use wireloom::session::drag::quaternion;
use wireloom::{Control, Run, StepResult};

type Check = fn() -> Result<(), Failed>;

/// Checks, and what each of them needs.
const CHECKS: [(&str, Check, &[Need]); 10] = [
    ("the example of the README prints where its harness ends", example, &[Need::C]),
    ("C reads the numbers of the Rust library, to the bit", numbers, &[Need::C]),
    ("what a session saves is carried out to where it ended", session, &[Need::C]),
    ("threads use sessions of their own, and one together", threads, &[Need::C]),
    ("a host unloads the library, whose threads live on", unload, &[Need::C]),
    ("hostile calls get error codes", hostile, &[Need::C]),
    ("hostile calls touch no memory that is not theirs", sanitized, &[Need::C, Need::AddressSanitizer]),
    ("a plug is dragged from C++", drag, &[Need::Cpp]),
    ("CMake finds the library", cmake, &[Need::C, Need::Cpp, Need::Program("cmake")]),
    ("the shared library has the functions of the list alone, with their versions", symbols, &[Need::Program("nm")]),
];

/// What a check needs of the system.
#[derive(Clone, Copy)]
enum Need {
    /// A compiler of C, and pkg-config.
    C,
    /// A compiler of C++, and pkg-config.
    Cpp,
    /// A compiler with the address sanitizer, whose programs run.
    AddressSanitizer,
    Program(&'static str),
}

impl Need {
    /// What of it the system lacks.
    fn missing(self) -> Option<String> {
        let program = |name: &str| (!runs(name)).then(|| format!("no `{name}`"));
        match self {
            Self::C => program(&compiler("c")).or_else(|| program("pkg-config")),
            Self::Cpp => program(&compiler("cpp")).or_else(|| program("pkg-config")),
            Self::AddressSanitizer => {
                (!has_sanitizer()).then(|| format!("`{} -fsanitize=address` makes no program that runs", compiler("c")))
            }
            Self::Program(name) => program(name),
        }
    }
}

fn main() -> ExitCode {
    let trials = CHECKS.iter().map(|&(name, check, needed)| {
        let elsewhere = || "the library is installed on Linux only so far".to_owned();
        let reason = needed.iter().find_map(|need| need.missing());
        match reason.or_else(|| (!cfg!(target_os = "linux")).then(elsewhere)) {
            None => Trial::test(name, check),
            Some(reason) => Trial::test(format!("{name} (ignored: {reason})"), || Ok(())).with_ignored_flag(true),
        }
    });
    libtest_mimic::run(&Arguments::from_args(), trials.collect()).exit_code()
}

/// The compiler of files with an extension; that of C links the library, too.
fn compiler(extension: &str) -> String {
    let (variable, usual) = if extension == "cpp" { ("CXX", "c++") } else { ("CC", "cc") };
    std::env::var(variable).unwrap_or_else(|_| usual.to_owned())
}

/// Whether an empty program can be compiled with the address sanitizer, and runs.
fn has_sanitizer() -> bool {
    let source = scratch().join("empty.c");
    let program = scratch().join("empty");
    let written = std::fs::write(&source, "int main(void) { return 0; }\n");
    let mut compile = Command::new(compiler("c"));
    compile.arg("-fsanitize=address").arg(&source).arg("-o").arg(&program);
    written.is_ok() && done(&mut compile).is_ok() && done(&mut Command::new(&program)).is_ok()
}

/// Folder of what is built for the tests.
fn scratch() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

fn runs(program: &str) -> bool {
    let mut asked = Command::new(program);
    asked.arg("--version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    asked.status().is_ok_and(|status| status.success())
}

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn root() -> &'static Path {
    here().ancestors().nth(2).expect("crates/capi lies in the repository")
}

fn scenario() -> PathBuf {
    root().join("scenarios/first.toml")
}

/// Folder into which the library, built with the profile of the tests, is installed.
fn installed() -> Result<&'static Path, Failed> {
    static INSTALLED: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    let folder = INSTALLED.get_or_init(|| {
        let test = std::env::current_exe().expect("a test knows where it is");
        let profile = test.ancestors().nth(2).expect("tests lie in <profile>/deps");
        let folder = scratch().join("capi");
        let mut install = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        install.args(["run", "--quiet", "--package", "xtask", "--", "capi"]).arg(&folder);
        if !profile.ends_with("release") {
            install.arg("--debug");
        }
        install.current_dir(root()).env("CARGO_TARGET_DIR", profile.parent().expect("the target folder"));
        done(&mut install)
            .map(|_| folder)
            .map_err(|failed| failed.message().unwrap_or("it cannot be installed").to_owned())
    });
    folder.as_deref().map_err(|message| message.into())
}

/// A program that loads the library installed here, and no other one.
fn host(program: &Path) -> Result<Command, Failed> {
    let mut host = Command::new(program);
    host.env("LD_LIBRARY_PATH", installed()?.join("lib"));
    Ok(host)
}

/// What a program prints, if it succeeds.
fn done(command: &mut Command) -> Result<String, Failed> {
    let out = command.output().map_err(|error| format!("{command:?}: {error}"))?;
    let printed = String::from_utf8_lossy(&out.stdout).into_owned();
    if out.status.success() {
        return Ok(printed);
    }
    let said = String::from_utf8_lossy(&out.stderr);
    Err(format!("{command:?} ({}):\n{printed}{said}", out.status).into())
}

/// A program of `tests/hosts`, compiled as pkg-config says; `options` are those of the compiler.
fn compiled(source: &str, options: &[&str]) -> Result<Command, Failed> {
    let library = installed()?.join("lib");
    let mut asked = Command::new("pkg-config");
    asked.args(["--cflags", "--libs", "wireloom"]).env("PKG_CONFIG_PATH", library.join("pkgconfig"));
    let flags = done(&mut asked)?;
    let program = scratch().join(format!("host-{source}{}", options.concat()));
    let (_, extension) = source.rsplit_once('.').expect("a source has an extension");
    let standard = if extension == "cpp" { "-std=c++17" } else { "-std=c11" };
    let mut compile = Command::new(compiler(extension));
    compile.args([standard, "-O1", "-g", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror"]).args(options);
    compile.arg(here().join("tests/hosts").join(source)).arg("-o").arg(&program).args(flags.split_whitespace());
    done(compile.arg("-lm"))?;
    host(&program)
}

fn example() -> Result<(), Failed> {
    let printed = done(compiled("example.c", &[])?.current_dir(root()))?;
    let readme = std::fs::read_to_string(here().join("README.md"))?;
    let source = std::fs::read_to_string(here().join("tests/hosts/example.c"))?;
    let blocks: Vec<&str> = readme.split("```").skip(1).step_by(2).collect();
    if !blocks.iter().any(|block| block.strip_prefix("c\n") == Some(&source)) {
        return Err("README.md does not have tests/hosts/example.c as it is".into());
    }
    let shown = blocks.iter().find_map(|block| block.strip_prefix("text\n"));
    if shown != Some(&printed) {
        return Err(format!("README.md shows {shown:?}, and the example prints {printed:?}").into());
    }
    Ok(())
}

fn bits(name: &str, numbers: impl IntoIterator<Item = f64>, lines: &mut String) {
    lines.push_str(name);
    numbers.into_iter().for_each(|x| write!(lines, " {:016x}", x.to_bits()).expect("a string"));
    lines.push('\n');
}

/// The lines that `numbers.c` prints.
fn lines(run: &Run, increments: usize) -> String {
    let (status, verdict) = (run.status() as i32, ["pass", "fail", "unresolved", "not checked"]);
    let number = |word: &str| verdict.iter().position(|known| *known == word).expect("a verdict");
    let verdict = number(run.verdict().word());
    let mut all = format!("{} status {status} verdict {verdict} after {increments} increments\n", run.scenario);
    for step in &run.steps {
        let StepResult { name, increment, increments, energy, .. } = step;
        let stable = step.stable.map_or(-1, i32::from);
        writeln!(all, "step {name} {increment} of {increments} stable {stable}").expect("a string");
        let e = energy;
        let parts = [e.stretch, e.shear, e.bend, e.twist, e.gravity, e.load, e.joint, e.constraint];
        bits("energy", std::iter::once(e.total()).chain(parts), &mut all);
        for branch in &step.branches {
            writeln!(all, "branch {}", branch.name).expect("a string");
            let vectors = |name, list: &[Vector], all: &mut String| {
                bits(name, list.iter().flat_map(|v| [v.x, v.y, v.z]), all);
            };
            let director = |k: usize| branch.frame.iter().map(|frame| columns(frame)[k]).collect::<Vec<_>>();
            bits("s", branch.s.iter().copied(), &mut all);
            vectors("position", &branch.position, &mut all);
            vectors("d1", &director(0), &mut all);
            vectors("d3", &director(2), &mut all);
            vectors("force", &branch.force, &mut all);
            vectors("moment", &branch.moment, &mut all);
            bits("bend_radius", branch.bend_radius.iter().copied(), &mut all);
            for own in &branch.sections {
                let limit = own.bend_radius_limit.unwrap_or(f64::NAN);
                bits(&own.section, [own.from, own.to, own.diameter, limit, own.axial_stiffness], &mut all);
            }
        }
        for own in &step.constraints {
            writeln!(all, "constraint {} {}", own.name, own.kind).expect("a string");
            bits("force", own.force.iter().copied(), &mut all);
            bits("moment", own.moment.iter().copied(), &mut all);
            bits("orientation", quaternion(&own.orientation), &mut all);
        }
    }
    for event in &run.events {
        let (kind, first) = (event.kind.word(), &event.first);
        let (step, increment) = (&first.step, first.increment);
        writeln!(all, "event {kind} at {} from {step} {increment}: {}", event.place, event.message).expect("a string");
    }
    for own in &run.requirements {
        let verdict = number(own.verdict.word());
        writeln!(all, "requirement {} verdict {verdict} at {}", own.name, own.place).expect("a string");
        bits("worst", [own.worst.unwrap_or(f64::NAN)], &mut all);
        bits("limit", [own.limit], &mut all);
    }
    all
}

fn numbers() -> Result<(), Failed> {
    for scenario in [scenario(), root().join("scenarios/branches/tube_on_a_branch.toml")] {
        same_numbers(&scenario)?;
    }
    Ok(())
}

fn same_numbers(scenario: &Path) -> Result<(), Failed> {
    let printed = done(compiled("numbers.c", &[])?.arg(scenario))?;
    let text = std::fs::read_to_string(scenario)?;
    let (_, built) = wireloom::load(&text, &wireloom::registry()).map_err(|faults| format!("{faults:?}"))?;
    let mut increments = 0;
    let run = wireloom::run(built, &mut |_, _| {
        increments += 1;
        Control::Continue
    });
    let wanted = lines(&run, increments);
    let differs = printed.lines().zip(wanted.lines()).find(|(is, wanted)| is != wanted);
    if printed == wanted { Ok(()) } else { Err(format!("differs: {differs:?}").into()) }
}

fn session() -> Result<(), Failed> {
    let door = root().join("scenarios/mechanisms/door.toml");
    done(compiled("session.c", &[])?.arg(door).arg(scenario())).map(|printed| print(&printed))
}

fn threads() -> Result<(), Failed> {
    done(compiled("threads.c", &["-pthread"])?.arg(scenario())).map(|printed| print(&printed))
}

fn unload() -> Result<(), Failed> {
    // Not linked with the library: it has none of its functions.
    let mut host = compiled("unload.c", &["-pthread", "-Wl,--as-needed"])?;
    done(host.arg(scenario()).arg(installed()?.join("lib/libwireloom.so"))).map(|printed| print(&printed))
}

fn hostile() -> Result<(), Failed> {
    abused(&[])
}

fn sanitized() -> Result<(), Failed> {
    abused(&["-fsanitize=address"])
}

/// The first scenario with another section along a part of its trunk.
fn of_parts() -> Result<PathBuf, Failed> {
    let text = std::fs::read_to_string(scenario())?;
    let (own, part) = ("section = \"trunk\"\n", "sections = [{ section = \"arm\", from = 0.1, to = 0.3 }]\n");
    let file = scratch().join("of-parts.toml");
    std::fs::write(&file, text.replacen(own, &[own, part].concat(), 1))?;
    Ok(file)
}

/// Every function was called, and has succeeded at least once.
fn abused(options: &[&str]) -> Result<(), Failed> {
    // Handles that nobody frees are no fault of the library.
    let printed = done(compiled("hostile.c", options)?.env("ASAN_OPTIONS", "detect_leaks=0").arg(of_parts()?))?;
    print(&printed);
    let called: BTreeSet<&str> =
        printed.lines().filter_map(|line| line.split_once(": ")).map(|(name, _)| name).collect();
    let map = std::fs::read_to_string(here().join("wireloom.map"))?;
    let listed = map.lines().filter_map(|line| line.trim().strip_suffix(';')).filter(|f| f.starts_with("wireloom_"));
    let missing: Vec<&str> = listed.filter(|name| *name != "wireloom_version" && !called.contains(name)).collect();
    if missing.is_empty() { Ok(()) } else { Err(format!("hostile.c does not call {missing:?}").into()) }
}

fn drag() -> Result<(), Failed> {
    done(compiled("drag.cpp", &[])?.arg(scenario())).map(|printed| print(&printed))
}

fn cmake() -> Result<(), Failed> {
    let build = scratch().join("cmake");
    // What it found before is not asked again.
    if build.exists() {
        std::fs::remove_dir_all(&build)?;
    }
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(here().join("tests/hosts")).arg("-B").arg(&build);
    done(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", installed()?.display())))?;
    done(Command::new("cmake").arg("--build").arg(&build))?;
    done(host(&build.join("example"))?.current_dir(root()))?;
    done(host(&build.join("drag"))?.arg(scenario())).map(|printed| print(&printed))
}

fn symbols() -> Result<(), Failed> {
    let mut asked = Command::new("nm");
    asked.args(["-D", "--defined-only", "--with-symbol-versions"]).arg(installed()?.join("lib/libwireloom.so"));
    let shown = done(&mut asked)?;
    let shown: BTreeSet<&str> = shown.lines().filter_map(|line| line.split_whitespace().nth(2)).collect();
    let map = std::fs::read_to_string(here().join("wireloom.map"))?;
    let (mut wanted, mut version) = (BTreeSet::new(), "");
    for line in map.lines().map(str::trim) {
        if let Some(begins) = line.strip_suffix(" {") {
            version = begins;
            wanted.insert(version.to_owned());
        } else if let Some(function) = line.strip_suffix(';').filter(|own| own.starts_with("wireloom_")) {
            wanted.insert(format!("{function}@@{version}"));
        }
    }
    if shown.iter().eq(&wanted) { Ok(()) } else { Err(format!("{shown:?}, not {wanted:?}").into()) }
}

#[expect(clippy::print_stdout, reason = "figures for those who run the tests")]
fn print(text: &str) {
    print!("{text}");
}
