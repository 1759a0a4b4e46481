//! The hunt as a command: see `wireloom_tests::hunt`. `cargo xtask hunt` runs it.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command for developers talks to them")]

use rayon::prelude::*;
use std::collections::BTreeMap;
use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use wireloom_tests::hunt::check::{Checked, Fault, check};
use wireloom_tests::hunt::generate::generate;
use wireloom_tests::hunt::shrink::shrink;

const HELP: &str = "cargo xtask hunt [--minutes N] [--cases N] [--seed S] [--quick]
  --minutes N  no new harness is begun after so many minutes; default 10
  --cases N    so many harnesses at most; default as many as there is time for
  --seed S     of the first harness; the next ones have S + 1, S + 2, ...; default 0
  --quick      check a single run of each only";

/// Time limit of shrinking, for each find.
const SHRINKING: Duration = Duration::from_secs(60);
/// Finds of a kind that are shrunk and saved; more are counted.
const SAVED: usize = 8;
/// A harness that takes longer is told of.
const LONG: Duration = Duration::from_secs(20);

#[derive(Default)]
struct Tally {
    cases: usize,
    refused: usize,
    converged: usize,
    too_coarse: usize,
    stable: usize,
    others: BTreeMap<&'static str, usize>,
    lost: BTreeMap<&'static str, usize>,
    found: BTreeMap<String, usize>,
    refusals: Vec<String>,
}

impl Tally {
    fn add(&mut self, checked: &Checked) {
        self.cases += 1;
        self.refused += usize::from(checked.refused.is_some());
        self.converged += usize::from(checked.converged);
        self.too_coarse += usize::from(checked.too_coarse);
        self.stable += usize::from(checked.stable);
        checked.others.iter().for_each(|what| *self.others.entry(what).or_default() += 1);
        checked.lost.iter().for_each(|what| *self.lost.entry(what).or_default() += 1);
        first_of_each(checked).into_iter().for_each(|fault| *self.found.entry(label(fault)).or_default() += 1);
        if self.refusals.len() < 3 {
            self.refusals.extend(checked.refused.clone());
        }
    }
}

fn main() -> ExitCode {
    let (mut minutes, mut cases, mut first, mut quick) = (10.0, u64::MAX, 0, false);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut number = || arguments.next().and_then(|n| n.parse::<f64>().ok());
        match (argument.as_str(), &mut number) {
            ("--quick", _) => quick = true,
            ("--minutes", number) => minutes = number().unwrap_or(minutes),
            ("--cases", number) => cases = number().map_or(cases, |n| n as u64),
            ("--seed", number) => first = number().map_or(first, |n| n as u64),
            _ => {
                eprintln!("{HELP}");
                return ExitCode::FAILURE;
            }
        }
    }
    let folder = wireloom_tests::root().join("target/hunt");
    if let Err(error) = std::fs::create_dir_all(&folder) {
        eprintln!("{}: {error}", folder.display());
        return ExitCode::FAILURE;
    }
    let clock = Instant::now();
    let limit = Duration::from_secs_f64(60.0 * minutes);
    let tally = Mutex::new(Tally::default());
    let next = AtomicU64::new(0);
    (0..rayon::current_num_threads()).into_par_iter().for_each(|_| {
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= cases || clock.elapsed() > limit {
                return;
            }
            let seed = first + k;
            let scene = generate(seed);
            let began = Instant::now();
            let checked = check(&scene, quick);
            if began.elapsed() > LONG {
                println!("seed {seed} took {:.0} s", began.elapsed().as_secs_f64());
            }
            tally.lock().expect("no panic").add(&checked);
            for fault in first_of_each(&checked) {
                println!("seed {seed}: {}: {}", label(fault), fault.words);
                let many = tally.lock().expect("no panic").found[&label(fault)];
                if many <= SAVED {
                    save(&folder, seed, &shrink(fault, quick, SHRINKING));
                }
            }
        }
    });
    let tally = tally.into_inner().expect("no panic");
    let Tally { cases, refused, converged, too_coarse, stable, others, lost, found, refusals } = &tally;
    println!(
        "{cases} harnesses in {:.0} s: {refused} refused, {too_coarse} told that their mesh is too coarse; of the \
         others {converged} converged \
         ({:.2} %), {stable} of them stable",
        clock.elapsed().as_secs_f64(),
        100.0 * *converged as f64 / (*cases - *refused - *too_coarse).max(1) as f64
    );
    refusals.iter().for_each(|why| println!("refused: {why}"));
    println!("another equilibrium: {others:?}\nnot converged when said otherwise: {lost:?}\nfound: {found:?}");
    if found.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The first thing that is wrong with the scene, and with each of its variants: others often follow from it.
fn first_of_each(checked: &Checked) -> Vec<&Fault> {
    let mut firsts: Vec<&Fault> = Vec::new();
    for fault in &checked.faults {
        if !firsts.iter().any(|other| other.said == fault.said) {
            firsts.push(fault);
        }
    }
    firsts
}

/// Label of a fault: change of the scene, and kind.
fn label(fault: &Fault) -> String {
    if fault.said.is_empty() { fault.kind.to_owned() } else { format!("{}: {}", fault.said, fault.kind) }
}

/// Writes a find as a scenario that says in its first lines what is wrong.
fn save(folder: &std::path::Path, seed: u64, fault: &Fault) {
    let path = folder.join(format!("{}-{seed}.toml", label(fault).replace([' ', '\'', ':'], "-")));
    let words = fault.words.replace('\n', "\n# ");
    let text = format!("# {}: {words}\n# Seed {seed}.\n{}", label(fault), fault.scene.text());
    if let Err(error) = std::fs::write(&path, text) {
        eprintln!("{}: {error}", path.display());
    } else {
        println!("  saved as {}", path.display());
    }
}
