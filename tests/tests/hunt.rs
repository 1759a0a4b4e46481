//! The short part of the hunt (`cargo xtask hunt`): random harnesses with fixed seeds, each checked by what a user sees
//! of it.

use rayon::prelude::*;
use wireloom_tests::hunt::check::{Checked, check};
use wireloom_tests::hunt::generate::generate;

/// Share of harnesses that must converge, of those that are not told to have too coarse a mesh: they are wilder than
/// those that people make.
const CONVERGED: f64 = 0.97;
/// Share of harnesses that may be told so.
const TOO_COARSE: f64 = 0.16;

fn hunt(seeds: std::ops::Range<u64>, quick: bool) -> Vec<(u64, Checked)> {
    let checked: Vec<(u64, Checked)> =
        seeds.into_par_iter().map(|seed| (seed, check(&generate(seed), quick))).collect();
    let mut found = Vec::new();
    for (seed, checked) in &checked {
        found.extend(checked.refused.iter().map(|why| format!("seed {seed} is refused: {why}")));
        found.extend(checked.faults.iter().map(|f| format!("seed {seed}: {} {}: {}", f.said, f.kind, f.words)));
    }
    assert!(found.is_empty(), "{found:#?}");
    checked
}

#[test]
fn random_harnesses_are_in_balance_as_a_whole_and_in_every_part() {
    let checked = hunt(400..600, true);
    let converged = checked.iter().filter(|(_, checked)| checked.converged).count();
    let too_coarse = checked.iter().filter(|(_, checked)| checked.too_coarse).count();
    assert!(too_coarse as f64 <= TOO_COARSE * checked.len() as f64, "{too_coarse} are told to be too coarse");
    let others = checked.len() - too_coarse;
    assert!(converged as f64 >= CONVERGED * others as f64, "only {converged} of {others} converged");
}

#[test]
fn random_harnesses_are_where_they_are_however_they_are_said() {
    hunt(600..620, false);
}
