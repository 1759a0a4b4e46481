//! Developer commands, such as `cargo xtask test`. No dependencies, so that it builds in a second.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command for developers talks to them")]

mod hunt;
mod readme;
mod run;
mod test;
mod tools;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask COMMAND

  test     all that must hold before a change goes in: form, lints, docs, tests, licences; installs what that needs
  hunt     random harnesses, each judged by what a user sees of it; what is wrong is made small and saved in target/hunt (hunt --help)
  readme   writes what the README's commands print into README.md, and the picture beside it
  help     this
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match arguments.as_slice() {
        ["test"] => test::test(),
        ["hunt", options @ ..] => hunt::hunt(options),
        ["readme"] => readme::readme(),
        ["help" | "--help" | "-h"] => {
            print!("{HELP}");
            Ok(())
        }
        _ => Err(HELP.to_owned()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}
