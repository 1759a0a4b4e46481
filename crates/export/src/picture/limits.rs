//! Limits of tension, compression, strain and reach that are not kept, by branch.

use crate::local::Local;
use wireloom_core::equilibrium::{BranchResult, RequirementResult};
use wireloom_core::requirement::{Bound, Measure, Verdict};

/// Strain from which a cable is drawn as overstretched where a span is too short for it: the 0.2 % proof strain of
/// copper. Wires that were stretched farther stay longer.
const PROOF_STRAIN: f64 = 0.002;

/// Limits that fail somewhere; a piece of a branch may exceed them or not.
pub struct Limits<'a> {
    /// Branch, or all; measure and limit.
    list: Vec<(Option<&'a str>, Measure, f64)>,
}

impl<'a> Limits<'a> {
    /// Those of the lines of the sheet that fail.
    pub fn of(open: &[&'a RequirementResult]) -> Self {
        let limit = |line: &&'a RequirementResult| {
            let of = match line.measure {
                Measure::Tension | Measure::Compression | Measure::Strain => Some(line.place.branch.as_deref()?),
                // A span that is too short pulls at whatever continues it.
                Measure::Reach => return Some((None, Measure::Strain, PROOF_STRAIN)),
                _ => return None,
            };
            Some((of, line.measure, line.limit))
        };
        let failed = open.iter().filter(|line| line.verdict == Verdict::Fail && line.bound == Bound::Max);
        Self { list: failed.filter_map(limit).collect() }
    }

    /// Whether a branch exceeds one of them at node `i`.
    pub fn are_exceeded(&self, branch: &BranchResult, i: usize) -> bool {
        let own = |of: &Option<&str>| of.is_none_or(|name| name == branch.name);
        let mut own = self.list.iter().filter(|(of, ..)| own(of)).peekable();
        if own.peek().is_none() {
            return false;
        }
        let tension = Local::at(branch, i).tension;
        own.any(|(_, measure, limit)| {
            let value = match measure {
                Measure::Compression => -tension,
                Measure::Strain => branch.strain_at(i),
                _ => tension,
            };
            value > *limit
        })
    }

    /// Whether any branch exceeds one of them anywhere.
    pub fn show(&self, branches: &[BranchResult]) -> bool {
        branches.iter().any(|branch| (0..branch.s.len()).any(|i| self.are_exceeded(branch, i)))
    }
}
