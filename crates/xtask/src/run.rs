//! Runs other programs in the repository.

use std::io::{self, BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Instant;

/// Root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("crates/xtask lies in the repository")
}

/// Target directory of cargo.
pub fn target() -> PathBuf {
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

/// A program with its arguments, to be run at the root of the repository.
pub fn command(program: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(root());
    command
}

/// Runs a step; prints its purpose and its duration.
pub fn step(why: &str, command: &mut Command) -> Result<(), String> {
    report(why, command, |command| Ok((command.status()?, String::new())))
}

/// Builds the program and all libraries as `cargo test --workspace` has them: with one test among the targets all
/// crates have the same features, so that none is compiled twice.
pub fn as_tested(why: &str) -> Result<(), String> {
    let build = ["build", "--quiet", "--workspace", "--lib", "--bin", "wireloom", "--test", "header"];
    step(why, &mut command("cargo", &build))
}

/// Runs a step of tests. Their failures are printed again at the end: a log may be cut to its last lines.
pub fn tests(why: &str, command: &mut Command) -> Result<(), String> {
    report(why, command, |command| {
        let mut child = command.stdout(Stdio::piped()).spawn()?;
        let failures = failures(BufReader::new(child.stdout.take().expect("a pipe")), &mut io::stdout())?;
        Ok((child.wait()?, failures))
    })
}

/// Copies what tests print, and returns the beginning of what each failed test said.
fn failures(printed: impl BufRead, out: &mut impl Write) -> io::Result<String> {
    const LINES: usize = 30;
    let (mut failures, mut lines) = (String::new(), None);
    for line in printed.split(b'\n') {
        let line = line?;
        let line = String::from_utf8_lossy(&line);
        writeln!(out, "{line}")?;
        if line == "failures:" || (lines.is_some() && line.starts_with("---- ")) {
            lines = Some(0);
        } else if line.starts_with("test result: ") {
            lines = None;
        }
        if let Some(lines) = lines.as_mut().filter(|lines| **lines < LINES) {
            *lines += 1;
            failures += &format!("{line}\n");
        }
    }
    Ok(failures)
}

fn report(
    why: &str,
    command: &mut Command,
    carry_out: impl FnOnce(&mut Command) -> io::Result<(ExitStatus, String)>,
) -> Result<(), String> {
    println!("\n== {why}\n   {}", words(command));
    let clock = Instant::now();
    let ended = carry_out(command);
    let (status, failures) = ended.map_err(|error| format!("{} cannot be run: {error}", words(command)))?;
    if !status.success() {
        return Err(format!("\n{failures}failed: {why}\n   {} ({status})", words(command)));
    }
    println!("   {:.0} s", clock.elapsed().as_secs_f64());
    Ok(())
}

/// Whether a program succeeds; its output is discarded.
pub fn works(command: &mut Command) -> bool {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok_and(|s| s.success())
}

fn words(command: &Command) -> String {
    let program = std::iter::once(command.get_program()).chain(command.get_args());
    program.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    #[test]
    fn failures_are_repeated_without_their_long_ends() {
        let printed = format!("ok\nfailures:\n\n---- one ----\n{}\n---- two ----\nwhy\n", "line\n".repeat(40));
        let printed = printed + "test result: FAILED. 2 failed\n\nrunning 0 tests\n";
        let mut copied = vec![];
        let repeated = super::failures(printed.as_bytes(), &mut copied).expect("lines");
        assert_eq!(copied, printed.as_bytes());
        let (one, two) = repeated.split_once("---- two ----\n").expect("both");
        assert_eq!((one.matches("line\n").count(), two), (29, "why\n"));
        assert!(!repeated.contains("ok\n") && !repeated.contains("running"));
    }
}
