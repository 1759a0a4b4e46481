//! Developer commands, such as `cargo xtask test`. No dependencies, so that it builds in a second.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command for developers talks to them")]

mod capi;
mod compare;
mod freecad;
mod hunt;
mod package;
mod peer;
mod readme;
mod run;
mod test;
mod tools;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask COMMAND

  test     all checks that a change must pass: format, lints, docs, tests, licences; installs the tools for them
  hunt     checks the results of random harnesses; minimises failures and saves them in target/hunt (hunt --help)
  package  packs the Python package as a wheel, installs it into the target folder, and runs its tests
  freecad  packs the Python package, and tests the FreeCAD workbench with it; installs FreeCAD
  capi [--debug] [FOLDER]
           builds the C library and installs it, with its headers, into a folder (target/capi)
  readme   updates the output of commands in README.md, and its picture
  reality  updates scenarios/measured/reality.md, where cables are held against measurements, and its pictures
  compare-commits A B
           builds two commits, measures them in turn, and says for each case of bench whether B is faster or slower
  peer     the drag step of bench beside Exudyn, in one run; installs Exudyn
  help     this text
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match arguments.as_slice() {
        ["test"] => test::test(),
        ["hunt", options @ ..] => hunt::hunt(options),
        ["compare-commits", arguments @ ..] => compare::compare(arguments),
        ["peer"] => peer::peer(),
        ["package"] => package::package(),
        ["freecad"] => freecad::freecad(),
        ["capi", arguments @ ..] => capi::install(arguments),
        ["readme"] => readme::readme(),
        ["reality"] => readme::reality(),
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
