//! The README's commands do what it says: every `console` block is run, and prints what stands there.
//!
//! Numbers may differ by a percent or in their last digit, times and what is printed as `4e-11` in any way; spaces and
//! lines of tables stretch. With `WIRELOOM_README=write` the output is written into the README instead.

use std::fs;
use std::path::Path;
use std::process::Command;
use wireloom_tests::{cargo, program, root};

/// Relative difference of numbers that counts as none: another system's mathematics library moves the last digits.
const TOLERANCE: f64 = 0.01;
const TIMES: [&str; 4] = ["µs", "ms", "s", "min"];

/// A `$ command` and what stands below it.
struct Example {
    command: String,
    /// Lines of the README that hold the output.
    lines: std::ops::Range<usize>,
}

fn examples(readme: &[String]) -> Vec<Example> {
    let mut examples: Vec<Example> = vec![];
    let mut inside = false;
    for (k, line) in readme.iter().enumerate() {
        if line.starts_with("```") {
            inside = line == "```console";
        } else if let Some(command) = line.strip_prefix("$ ").filter(|_| inside) {
            examples.push(Example { command: command.to_owned(), lines: k + 1..k + 1 });
        } else if let Some(example) = examples.last_mut().filter(|_| inside) {
            example.lines.end = k + 1;
        }
    }
    examples
}

/// Output of a command, run in `folder`; `None` for known commands that are not run here.
fn printed(command: &str, folder: &Path) -> Option<String> {
    let words: Vec<&str> = command.split_whitespace().collect();
    let arguments = match words.as_slice() {
        ["cargo", "run", "--release", "--", rest @ ..] | ["wireloom", rest @ ..] => rest,
        // It runs this very test: here it is enough that there is such a command.
        ["cargo", "xtask", name] => {
            let help = cargo().args(["xtask", "help"]).output().expect("cargo runs");
            let help = String::from_utf8_lossy(&help.stdout).into_owned();
            assert!(help.contains(&format!("\n  {name} ")), "no `{command}` in\n{help}");
            return None;
        }
        _ => panic!("the README has a command that no test knows how to run: {command}"),
    };
    let output = Command::new(program()).args(arguments).current_dir(folder).output().expect("the program runs");
    assert!(output.status.success(), "{command}: {}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).expect("UTF-8").trim_end().to_owned())
}

/// The words of an output, without what may differ at will.
fn words(output: &str) -> Vec<String> {
    let mut words: Vec<String> = vec![];
    for word in output.split_whitespace() {
        let word = if word.chars().all(|c| c == '─') { "─" } else { word };
        match words.last_mut() {
            Some(last) if TIMES.contains(&word) && last.parse::<f64>().is_ok() => *last = "TIME".to_owned(),
            _ if word.contains("e-") && word.parse::<f64>().is_ok() => words.push("SMALL".to_owned()),
            _ => words.push(word.to_owned()),
        }
    }
    words
}

fn same(a: &str, b: &str) -> bool {
    let (Ok(x), Ok(y)) = (a.parse::<f64>(), b.parse::<f64>()) else { return a == b };
    let digits = a.split_once('.').map_or(0, |(_, fraction)| fraction.len() as i32);
    (x - y).abs() <= TOLERANCE * x.abs().max(y.abs()) + 1.01 * 10f64.powi(-digits)
}

#[test]
fn commands_print_what_the_readme_shows() {
    let path = root().join("README.md");
    let mut readme: Vec<String> = fs::read_to_string(&path).expect("README.md").lines().map(str::to_owned).collect();
    let place = tempfile::tempdir().expect("a folder");
    fs::create_dir(place.path().join("scenarios")).expect("a folder");
    for entry in fs::read_dir(root().join("scenarios")).expect("scenarios/") {
        let file = entry.expect("an entry").path();
        if file.is_file() {
            fs::copy(&file, place.path().join("scenarios").join(file.file_name().expect("a name"))).expect("a copy");
        }
    }
    let examples = examples(&readme);
    assert!(
        examples.iter().any(|example| example.command.contains("scenarios/first.toml")),
        "the main command is gone"
    );
    let write = std::env::var("WIRELOOM_README").is_ok_and(|word| word == "write");
    // From the end, so that lines keep their numbers while others are replaced.
    let outputs: Vec<_> = examples.iter().map(|example| printed(&example.command, place.path())).collect();
    for (example, output) in examples.iter().zip(outputs).rev() {
        let Some(output) = output else { continue };
        if write {
            readme.splice(example.lines.clone(), output.lines().map(str::to_owned));
            continue;
        }
        let shown = readme[example.lines.clone()].join("\n");
        let (expected, found) = (words(&shown), words(&output));
        let agree = expected.len() == found.len() && expected.iter().zip(&found).all(|(a, b)| same(a, b));
        assert!(agree, "`{}` prints\n{output}\nbut the README shows\n{shown}\n(cargo xtask readme)", example.command);
    }
    if write {
        fs::write(&path, readme.join("\n") + "\n").expect("README.md can be written");
    }
}

#[test]
fn links_lead_to_files() {
    for readme in ["README.md", "crates/README.md"] {
        let path = root().join(readme);
        let text = fs::read_to_string(&path).expect("a README");
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap_or_default();
            let there = link.contains("://") || path.parent().expect("a folder").join(file).exists();
            assert!(there, "{readme}: {link} leads nowhere");
        }
    }
}

#[test]
fn what_may_differ_is_forgiven_and_nothing_else() {
    let shown = "step  time\n────\nplug B  10.7 ms  4e-11  97.8  20\n";
    let agrees = |other: &str| {
        let (a, b) = (words(shown), words(other));
        a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| same(a, b))
    };
    assert!(agrees("step   time\n──────\nplug B   1.2 s   3e-9   97.9   20\n"));
    assert!(!agrees("step   time\n──────\nplug B   1.2 s   3e-9   99.9   20\n"));
    assert!(!agrees("step   time\n──────\nplug C   1.2 s   3e-9   97.8   20\n"));
    assert!(!agrees("step   time\n──────\nplug B   1.2 s   3e-9   97.8\n"));
}
