//! The short part of the hunt (`cargo xtask hunt`): random harnesses with fixed seeds, each judged by what a user sees of it.

use rayon::prelude::*;
use wireloom_tests::hunt::generate::generate;
use wireloom_tests::hunt::judge::{Judged, judge};

/// Share of harnesses that must converge: they are wilder than those that people make, and what does not converge must say so.
const CONVERGED: f64 = 0.82;

fn hunt(seeds: std::ops::Range<u64>, quick: bool) {
    let judged: Vec<(u64, Judged)> = seeds.into_par_iter().map(|seed| (seed, judge(&generate(seed), quick))).collect();
    let mut found = Vec::new();
    for (seed, judged) in &judged {
        found.extend(judged.refused.iter().map(|why| format!("seed {seed} is refused: {why}")));
        found.extend(judged.faults.iter().map(|f| format!("seed {seed}: {} {}: {}", f.said, f.kind, f.words)));
    }
    assert!(found.is_empty(), "{found:#?}");
    let converged = judged.iter().filter(|(_, judged)| judged.converged).count();
    assert!(converged as f64 >= CONVERGED * judged.len() as f64, "only {converged} of {} converged", judged.len());
}

#[test]
fn random_harnesses_are_in_balance_as_a_whole_and_in_every_part() {
    hunt(400..600, true);
}

#[test]
fn random_harnesses_are_where_they_are_however_they_are_said() {
    hunt(600..620, false);
}
