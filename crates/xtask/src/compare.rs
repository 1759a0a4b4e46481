//! `cargo xtask compare-commits A B`: whether B is faster or slower than A on this machine, case by case.
//!
//! Both programs are built in one work tree, so that they hold the same paths, and run in turn: A B, B A, A B, …
//! ([`paired`] says how the times are judged). Counts of work do not depend on the machine: they are compared as they
//! are.

mod json;
mod paired;

use crate::run::{command, step, target};
use json::Json;
use paired::{Comparison, ERROR, least_pairs};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Instant;

const HELP: &str = "\
cargo xtask compare-commits A B [--pairs N] [-- OPTIONS]

  A, B       commits, as git names them: B is measured against A
  --pairs N  how often both programs are run (default 12, at least 10)
  OPTIONS    of `wireloom bench` instead of those that keep it short, such as --harness FILE.kbl
";

/// Fewest pairs: fewer tell little.
const FEWEST: usize = 10;
/// Options that keep `bench` short: the times of a sweep and of textbook minimisers need no more.
const SHORT: [&str; 4] = ["--points", "200", "--iterations", "200"];
/// Whole runs of the program, each so often in each pair. The shortest counts: other work on the machine only adds.
const REPEATED: usize = 5;
/// Scenarios that are run as users run them, next to the start of the program.
const SCENARIOS: [&str; 4] =
    ["first.toml", "contact/capstan.toml", "analytic/ring_pulley.toml", "assembly/workbench.toml"];
/// Endings of the names of figures in the document of `bench`: times, and counts of work.
const TIMES: [&str; 2] = ["seconds", "seconds_per_step"];
const COUNTS: [&str; 7] = [
    "iterations",
    "iterations_per_step",
    "evaluations_per_step",
    "factorisations_per_step",
    "increments",
    "contacts",
    "failures",
];

/// What is asked for.
struct Wish<'w> {
    commits: [&'w str; 2],
    pairs: usize,
    options: Vec<&'w str>,
}

/// A program to be measured.
struct Program {
    commit: String,
    /// Folder with the program, and with the scenarios of its commit.
    folder: PathBuf,
}

/// Figures of a run: name and value.
type Figures = Vec<(String, f64)>;

/// Builds both commits, measures them in pairs and prints what differs.
pub fn compare(arguments: &[&str]) -> Result<(), String> {
    if let ["--help" | "-h"] = arguments {
        print!("{HELP}");
        return Ok(());
    }
    let wish = read(arguments)?;
    let programs = [program(wish.commits[0])?, program(wish.commits[1])?];
    let (mut times, mut counts): (Vec<[Figures; 2]>, _) = (vec![], [vec![], vec![]]);
    for pair in 0..wish.pairs {
        let clock = Instant::now();
        let mut order = [0, 1];
        order.rotate_left(pair % 2);
        let mut found = walls(&programs, order)?;
        for which in order {
            let (measured, counted) = bench(&programs[which], &wish.options)?;
            found[which].extend(measured);
            counts[which] = counted;
        }
        times.push(found);
        println!("pair {} of {}: {:.0} s", pair + 1, wish.pairs, clock.elapsed().as_secs_f64());
    }
    report(&programs, &times, &counts);
    Ok(())
}

fn read<'w>(arguments: &[&'w str]) -> Result<Wish<'w>, String> {
    let (own, options) = match arguments.iter().position(|word| *word == "--") {
        Some(k) => (&arguments[..k], arguments[k + 1..].to_vec()),
        None => (arguments, SHORT.to_vec()),
    };
    let (commits, pairs) = match own {
        [a, b] => ([*a, *b], Some(12)),
        [a, b, "--pairs", n] | ["--pairs", n, a, b] => ([*a, *b], n.parse().ok()),
        _ => return Err(HELP.to_owned()),
    };
    let pairs = pairs.filter(|n| (FEWEST..=1_000).contains(n));
    let pairs = pairs.ok_or_else(|| format!("--pairs takes a number from {FEWEST} to 1000\n\n{HELP}"))?;
    if commits.iter().any(|commit| commit.starts_with('-')) {
        return Err(HELP.to_owned());
    }
    Ok(Wish { commits, pairs, options })
}

/// The release build of a commit; built unless that has been done before.
fn program(name: &str) -> Result<Program, String> {
    let commit = git(&["rev-parse", "--verify", "--quiet", &format!("{name}^{{commit}}")])
        .map_err(|_| format!("{name} names no commit of this repository"))?;
    let all = target().join("compare");
    let folder = all.join(&commit);
    let program = folder.join("wireloom").with_extension(std::env::consts::EXE_EXTENSION);
    if !program.is_file() {
        let tree = all.join("tree");
        let path = tree.to_string_lossy();
        if tree.is_dir() {
            let mut checkout = command("git", &["-C", &path, "checkout", "--quiet", "--detach", "--force", &commit]);
            step(&format!("the sources of {name}"), &mut checkout)?;
        } else {
            git(&["worktree", "prune"])?;
            let add = ["worktree", "add", "--quiet", "--detach", &path, &commit];
            step(&format!("the sources of {name} into a work tree"), &mut command("git", &add))?;
        }
        let built = all.join("build");
        let mut build = command("cargo", &["build", "--quiet", "--release", "--locked", "--package", "wireloom-cli"]);
        build.current_dir(&tree).env("CARGO_TARGET_DIR", &built).env("CARGO_INCREMENTAL", "0");
        step(&format!("release build of {name} (minutes, the first time)"), &mut build)?;
        let failed = |error| format!("{} cannot be made: {error}", folder.display());
        for scenario in SCENARIOS {
            let copy = folder.join("scenarios").join(scenario);
            std::fs::create_dir_all(copy.parent().unwrap_or(&folder)).map_err(failed)?;
            std::fs::copy(tree.join("scenarios").join(scenario), &copy)
                .map_err(|error| format!("scenarios/{scenario} of {name}: {error}"))?;
        }
        // Last: the program is there only if all is.
        std::fs::copy(built.join("release").join(program.file_name().unwrap_or_default()), &program).map_err(failed)?;
    }
    Ok(Program { commit, folder })
}

fn git(arguments: &[&str]) -> Result<String, String> {
    let ended = command("git", arguments).output().map_err(|error| format!("git cannot be run: {error}"))?;
    match ended.status.success() {
        true => Ok(String::from_utf8_lossy(&ended.stdout).trim().to_owned()),
        false => Err(format!("git {}: {}", arguments.join(" "), String::from_utf8_lossy(&ended.stderr))),
    }
}

impl Program {
    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(self.folder.join("wireloom"));
        command.args(arguments).current_dir(&self.folder).stdin(Stdio::null());
        command
    }

    /// Wall time of a whole run, s.
    fn wall(&self, arguments: &[&str]) -> Result<f64, String> {
        let mut command = self.command(arguments);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        let clock = Instant::now();
        let status = command.status().map_err(|error| format!("{} cannot be run: {error}", self.commit))?;
        let seconds = clock.elapsed().as_secs_f64();
        match status.success() {
            true => Ok(seconds),
            false => Err(format!("{}: wireloom {} failed ({status})", self.commit, arguments.join(" "))),
        }
    }
}

/// Wall times of whole runs of both programs, which take turns at every run.
fn walls(programs: &[Program; 2], order: [usize; 2]) -> Result<[Figures; 2], String> {
    let mut all = [vec![], vec![]];
    let scenarios = SCENARIOS.map(|scenario| format!("scenarios/{scenario}"));
    let runs = scenarios.iter().map(|path| ["run", path.as_str(), "--out", "out"].to_vec());
    for arguments in std::iter::once(vec!["--version"]).chain(runs) {
        let mut times = [vec![], vec![]];
        for _ in 0..REPEATED {
            for which in order {
                times[which].push(programs[which].wall(&arguments)?);
            }
        }
        let name = format!("wireloom {}", arguments[..arguments.len().min(2)].join(" "));
        for (all, times) in all.iter_mut().zip(times) {
            all.push((name.clone(), times.into_iter().fold(f64::INFINITY, f64::min)));
        }
    }
    Ok(all)
}

/// Times and counts that `wireloom bench` prints.
fn bench(program: &Program, options: &[&str]) -> Result<(Figures, Figures), String> {
    let arguments = [&["bench", "--json"], options].concat();
    let ended = program.command(&arguments).stderr(Stdio::inherit()).output();
    let ended = ended.map_err(|error| format!("{} cannot be run: {error}", program.commit))?;
    // Exit code 2: something did not converge, which the counts show.
    if !matches!(ended.status.code(), Some(0 | 2)) {
        return Err(format!("{}: wireloom {} failed ({})", program.commit, arguments.join(" "), ended.status));
    }
    Ok(figures_of(&Json::parse(&String::from_utf8_lossy(&ended.stdout))?))
}

/// Times and counts of a document of `bench`.
fn figures_of(document: &Json) -> (Figures, Figures) {
    let (mut times, mut counts) = (vec![], vec![]);
    if let Json::Table(entries) = document {
        // Starts of the program are measured by `walls`, in turn.
        for (key, value) in entries.iter().filter(|(key, _)| key != "starts") {
            figures(key, value, &mut times, &mut counts);
        }
    }
    (times, counts)
}

/// Collects times and counts, named by the words, the segments and the nodes beside them.
fn figures(name: &str, value: &Json, times: &mut Figures, counts: &mut Figures) {
    match value {
        Json::List(entries) => entries.iter().for_each(|entry| figures(name, entry, times, counts)),
        Json::Table(entries) => {
            let sizes = ["segments", "nodes"].iter().filter_map(|key| Some(value.get(key)?.number()?.to_string()));
            let words = ["case", "minimiser", "preconditioner"].iter().filter_map(|key| value.get(key)?.text());
            let mut words: Vec<String> = words.map(str::to_owned).collect();
            if words.is_empty() {
                words.push(name.to_owned());
            }
            let own = words.join(" ");
            let name = words.into_iter().chain(sizes).collect::<Vec<_>>().join(" ");
            let converged = value.get("failures").and_then(Json::number).is_none_or(|failures| failures == 0.0);
            for (key, value) in entries {
                match value.number() {
                    // How long something takes that does not end well tells nothing.
                    Some(time) if TIMES.contains(&key.as_str()) && converged && time > 0.0 => {
                        times.push((name.clone(), time))
                    }
                    Some(count) if COUNTS.contains(&key.as_str()) => counts.push((format!("{name}: {key}"), count)),
                    Some(_) => {}
                    None => figures(&format!("{own} {key}"), value, times, counts),
                }
            }
        }
        Json::Word | Json::Number(_) | Json::Text(_) => {}
    }
}

/// Prints the verdict on each case that both programs have, then the counts that differ.
fn report(programs: &[Program; 2], times: &[[Figures; 2]], counts: &[Figures; 2]) {
    let of = |figures: &Figures, name: &str| figures.iter().find(|(other, _)| other == name).map(|(_, value)| *value);
    let names = times[0][0].iter().map(|(name, _)| name.as_str());
    let cases: Vec<(&str, Vec<[f64; 2]>)> = names
        .filter_map(|name| {
            let pairs = times.iter().map(|[a, b]| Some([of(a, name)?, of(b, name)?]));
            Some((name, pairs.collect::<Option<_>>()?))
        })
        .collect();
    println!("\nA = {}\nB = {}\n{} pairs", programs[0].commit, programs[1].commit, times.len());
    println!(
        "B / A: estimate of Hodges and Lehmann, and the interval of the signed-rank test of Wilcoxon.\nWith a \
         probability of {:.0} % all intervals hold, and no case of equally fast programs is called faster or slower.\n",
        1e2 * (1.0 - ERROR)
    );
    let least = least_pairs(cases.len());
    if times.len() < least {
        println!("{} cases need at least --pairs {least} for any verdict.\n", cases.len());
    }
    let width = cases.iter().map(|(name, _)| name.len()).max().unwrap_or_default();
    println!("{:width$} {:>12} {:>12} {:>7}  {:14}  B is", "case", "A", "B", "B / A", "interval");
    for (name, pairs) in &cases {
        let median = |which: usize| {
            let mut all: Vec<f64> = pairs.iter().map(|pair| pair[which]).collect();
            all.sort_by(f64::total_cmp);
            format!("{:.3} ms", 1e3 * all[all.len() / 2])
        };
        let told = Comparison::new(pairs, cases.len());
        let [low, high] = told.interval;
        let (a, b, verdict) = (median(0), median(1), told.verdict().words());
        println!("{name:width$} {a:>12} {b:>12} {:>7.3}  {low:.3} to {high:.3}  {verdict}", told.ratio);
    }
    let differing: Vec<String> = counts[0]
        .iter()
        .filter_map(|(name, a)| of(&counts[1], name).filter(|b| b != a).map(|b| format!("  {name}: {a} → {b}")))
        .collect();
    match differing.is_empty() {
        true => println!("\nBoth do the same work: all counts of `bench` are equal."),
        false => println!("\nCounts of `bench` that differ, A → B:\n{}", differing.join("\n")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_named_by_what_stands_beside_them() {
        let document = r#"{ "version": "0.1.0", "starts": [{ "case": "start", "seconds": 0.1 }],
            "cases": [{ "case": "drag", "segments": 100, "seconds_per_step": 1e-3, "seconds_out": 2.0, "failures": 0,
                        "iterations_per_step": 2.4 }],
            "minimisers": [{ "minimiser": "lbfgs", "preconditioner": "none", "seconds_per_step": 1.0, "failures": 2 }],
            "contact": { "nodes": 7, "touching": { "seconds": 0.5, "contacts": 600 } } }"#;
        let (times, counts) = figures_of(&Json::parse(document).expect("JSON"));
        let names = |figures: &Figures| figures.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&times), ["drag 100", "contact touching"]);
        let all = ["drag 100: failures", "drag 100: iterations_per_step", "lbfgs none: failures"];
        assert_eq!(names(&counts), [&all[..], &["contact touching: contacts"]].concat());
    }

    #[test]
    fn options_are_read() {
        let wish = read(&["main", "HEAD", "--pairs", "20", "--", "--points", "5"]).map(|w| (w.pairs, w.options.len()));
        assert_eq!(wish, Ok((20, 2)));
        assert_eq!(read(&["a", "b"]).map(|wish| (wish.pairs, wish.options.len())), Ok((12, 4)));
        for wrong in [&["a"][..], &["a", "b", "c"], &["a", "--pairs"], &["a", "b", "--pairs", "9"]] {
            assert!(read(wrong).is_err(), "{wrong:?}");
        }
    }
}
