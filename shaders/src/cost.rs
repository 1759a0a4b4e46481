//! Cost model of a cycle of Newton's method on a device, for comparison with measurements.
//!
//! A cycle is a list of dispatches, each of which waits for the previous one. With v variants it takes about
//!
//! ```text
//! t = Σ over dispatches max(t0, v n b / B)        + v w 4 / B for looked-up words, if they do not stay in the caches
//! ```
//!
//! t0: time of an almost empty dispatch (2 to 5 µs on a GPU, with the preceding barrier); n: numbers of a variant that
//! are read and written ([`Traffic::numbers`]); b: bytes per number; B: memory bandwidth; w: looked-up words. A single
//! harness is limited by the number of dispatches, a batch by the numbers. All variants look up the same words at the
//! same time, so these come from the caches. Arithmetic is ignored: a product of the factorisation reads 27 numbers for
//! 54 multiplications and additions. A GPU whose f64 rate is a tenth of its f32 rate or less is limited by arithmetic
//! instead.
//!
//! The model ignores latency: a task of the factorisation processes its blocks in sequence. [`Traffic::walk`] counts
//! them along the longest task of each level. At about 0.5 µs each (two dependent reads) they cost as much as the
//! dispatches. This is why leaves are small: 8 variables for one harness.
//!
//! Measured on an NVIDIA H100 (80 GB HBM3, driver 580.159.04) in f64 with `cargo bench -p wireloom-gpu`, beside
//! `newton` on one core of the same machine (Xeon); medians:
//!
//! | drag step of 5 mm | dispatches | walk | cycles | of a cycle, model | measured | step in all | `newton` | ratio |
//! | --- | --- | --- | --- | --- | --- | --- | --- | --- |
//! | 1,000 segments, leaf 8 | 84 | 1420 | 3 | 1.0 ms | 1.5 ms | 4.7 ms | 2.0 ms | 0.4 |
//! | 10,000 segments, leaf 8 | 105 | 1899 | 7 | 1.3 ms | 2.5 ms | 19 ms | 34 ms | 1.8 |
//! | 100,000 segments, leaf 8 | 126 | 2297 | 7 | 2.1 ms | 4.4 ms | 59 ms | 542 ms | 9.1 |
//! | 4,096 variants of 3 × 60 segments | 45 | 1840 | 4 | 2.4 ms | 4.4 ms | 39 to 47 ms | 1.9 s | 41 to 54 |
//!
//! The batch in f32, down to a residual of 1e-4: 19 ms, 83 times as fast as one core, or 218 thousand variants a second
//! with about 150 W of the card. Of the step in all, the upload takes 18 ms of the last row and 24 ms of the third: the
//! submissions alone are 15 times and 66 to 100 times as fast as the core.

use crate::Stage;
use crate::elimination::Elimination;
use crate::plan::{Dispatch, Plan, sizes};

/// Memory traffic of a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Number of dispatches.
    pub dispatches: u64,
    /// Numbers read and written per variant.
    pub numbers: u64,
    /// Number of blocks that the longest task of each level processes in sequence, in both factorisations: an
    /// invocation waits for each.
    pub walk: u64,
}

/// Numbers of a variable that a part reads: value and compensation of a point, value of a frame.
const POINT: u64 = 6;
const FRAME: u64 = 4;

impl Plan {
    /// Traffic of a whole cycle, including condensation.
    pub fn traffic(&self) -> Traffic {
        let newton = self.cycle().iter().filter(|dispatch| dispatch.stage != Stage::LoadGradient);
        let numbers = newton.map(|dispatch| self.numbers_of(dispatch)).sum();
        let walk = [&self.elimination, &self.condensation].map(|elimination| {
            let levels = elimination.levels.iter();
            let longest = |level: &std::ops::Range<u32>| {
                level.clone().map(|task| walk(elimination, task as usize)).max().unwrap_or(0)
            };
            levels.map(longest).sum::<u64>()
        });
        Traffic { dispatches: self.cycle().len() as u64, numbers, walk: walk.iter().sum() }
    }

    /// Numbers that a dispatch reads and writes per variant, without the few numbers of motions and holds.
    pub fn numbers_of(&self, dispatch: &Dispatch) -> u64 {
        let p = &self.offsets;
        let condensation =
            dispatch.range.slot == 2 || dispatch.range.phases == 1 << crate::layout::Phase::Condense as u32;
        let elimination = if condensation { &self.condensation } else { &self.elimination };
        let tasks = || dispatch.range.first as usize..(dispatch.range.first + dispatch.range.count) as usize;
        let count = u64::from(dispatch.range.count);
        let parts = u64::from(self.part_count());
        let variables = u64::from(p.variables);
        let part = u64::from(sizes::PART);
        match dispatch.stage {
            Stage::EvaluateSegments => count * (u64::from(sizes::SEGMENT) + 2 * POINT + FRAME + 16),
            Stage::LineariseSegments => count * (u64::from(sizes::SEGMENT) + 2 * POINT + FRAME + part),
            Stage::EvaluateStationSegments => count * (u64::from(sizes::STATION_SEGMENT) + 2 * POINT + 3 * FRAME + 22),
            Stage::LineariseStationSegments => {
                count * (u64::from(sizes::STATION_SEGMENT) + 2 * POINT + 3 * FRAME + u64::from(sizes::STATION_PART))
            }
            Stage::EvaluateCouplings => count * (u64::from(sizes::COUPLING) + 2 * FRAME + 7),
            Stage::LineariseCouplings => count * (u64::from(sizes::COUPLING) + 2 * FRAME + part),
            Stage::EvaluateSprings => count * (u64::from(sizes::SPRING) + POINT + FRAME + 16),
            Stage::LineariseSprings => count * (u64::from(sizes::SPRING) + POINT + FRAME + part),
            Stage::AssembleMatrix => 9 * (count + u64::from(self.sources_of_blocks[usize::from(condensation)])),
            Stage::AssembleRightHandSide | Stage::AssembleGradient => 6 * count + 3 * u64::from(self.sources_of_forces),
            Stage::Factorise => tasks().map(|task| factor(elimination, task)).sum(),
            Stage::SolveForward => tasks().map(|task| forward(elimination, task)).sum(),
            Stage::SolveBackward => tasks().map(|task| backward(elimination, task)).sum(),
            Stage::SumStep => 9 * variables + 4 * count,
            Stage::CombineDirections => 6 * count,
            Stage::LoadGradient => 6 * count,
            Stage::SumState => parts + 9 * variables + 3 * count,
            Stage::Retract => (3 + 2 * u64::from(sizes::STATE)) * count,
            Stage::CondensePoints => (3 + 2 * u64::from(sizes::STATE)) * count,
            Stage::PackShape | Stage::Unpack => 2 * count,
            Stage::CheckInertia | Stage::CheckPointsInertia => 1,
            Stage::SumPartials => 7 * u64::from(p.chunks + p.totals),
            Stage::BeginLineSearch => 4 * u64::from(p.totals),
            Stage::RecordTrial | Stage::AcceptStep => 3 * u64::from(p.totals),
        }
    }
}

/// Instructions of a task, as `[flags, adds, products]`; `head`: number of words before the adds, with `flags` at this
/// position.
fn each(words: &[u32], head: usize, product: usize, mut see: impl FnMut(u32, u64, u64)) {
    let mut at = 0;
    while at < words.len() {
        let (adds, products) = (words[at + head - 2] as usize, words[at + head - 1] as usize);
        see(words[at + 1], adds as u64, products as u64);
        at += head + adds + product * products;
    }
}

fn factor(elimination: &Elimination, task: usize) -> u64 {
    let words = elimination.factor.of(task);
    let children = words[0] as usize;
    let mut numbers = 1 + children as u64;
    each(&words[1 + children..], 4, 3, |flags, adds, products| {
        let update = flags & crate::elimination::UPDATE != 0;
        numbers += 9 * (adds + 3 * products + if update { 1 } else { 2 });
    });
    numbers
}

/// Number of blocks that a task of the factorisation reads in sequence.
fn walk(elimination: &Elimination, task: usize) -> u64 {
    let words = elimination.factor.of(task);
    let mut blocks = 0;
    each(&words[1 + words[0] as usize..], 4, 3, |_, adds, products| blocks += 1 + adds + 3 * products);
    blocks
}

fn forward(elimination: &Elimination, task: usize) -> u64 {
    let mut numbers = 0;
    each(elimination.forward.of(task), 5, 2, |flags, adds, products| {
        let update = flags & crate::elimination::UPDATE != 0;
        numbers += 3 * adds + 12 * products + if update { 3 } else { 15 };
    });
    numbers
}

fn backward(elimination: &Elimination, task: usize) -> u64 {
    let rows = elimination.tasks[task].clone().map(|column| elimination.rows[column as usize].len() as u64);
    rows.map(|rows| 12 * rows + 15).sum()
}
