//! A tolerance study of many points: a Y harness of three branches of 60 segments, whose lengths and whose clip's
//! places vary.

use crate::sweep::tubes::Stations;
use crate::sweep::{Points, header};
use std::convert::Infallible;
use std::sync::Mutex;
use std::time::Instant;
use wireloom_core::{Monitor, Registry, Status};
use wireloom_gpu::batch::Batch;
use wireloom_scenario::{NoFiles, Setting};

/// Scenario with fewer points.
const SCENARIO: &str = include_str!("../../../../scenarios/sweeps/y_tolerances.toml");

/// Outcome of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct MonteCarlo {
    /// Points in all.
    pub points: usize,
    /// Statuses and their numbers; together they are all points.
    pub statuses: Vec<(String, usize)>,
    /// Threads that share them.
    pub threads: usize,
    /// All in all, s.
    pub seconds: f64,
}

impl MonteCarlo {
    /// Number of points that converged.
    pub fn converged(&self) -> usize {
        self.statuses.iter().filter(|(status, _)| status == Status::Converged.word()).map(|(_, n)| n).sum()
    }
}

/// So many points at random, on all cores; with `gpu` as minimiser in batches (see [`Points::batch`]).
///
/// # Panics
/// If the scenario that is built in is at fault, or there are no points.
pub fn monte_carlo(points: usize, minimiser: Option<&str>, batch: Option<&Batch>, registry: &Registry) -> MonteCarlo {
    let settings = [Setting::new("sweep.method", "random"), Setting::new("sweep.samples", points.to_string())];
    let loaded = crate::load_with_settings(SCENARIO, &settings, &NoFiles, registry);
    let (scenario, built) =
        loaded.map_err(|faults| wireloom_scenario::render(SCENARIO, &faults)).expect("a sound scenario");
    let sweep = scenario.sweep.as_ref().expect("it has a sweep");
    let header = header(sweep, &built.network);
    let stations = Stations::of(&built.network, &built.schedule);
    let all = Points { text: SCENARIO, files: &NoFiles, minimiser, registry, batch, sweep, header, stations };
    let clock = Instant::now();
    let statuses: Mutex<Vec<(String, usize)>> = Mutex::default();
    let chains: Vec<usize> = (0..all.chain_count()).collect();
    let kept = all.compute(&chains, &Monitor::default(), &|| (), |_, chain| {
        let mut statuses = statuses.lock().expect("no thread panics while it holds the lock");
        for row in chain.rows {
            match statuses.iter_mut().find(|(status, _)| *status == row.status) {
                Some((_, n)) => *n += 1,
                None => statuses.push((row.status, 1)),
            }
        }
        Ok::<(), Infallible>(())
    });
    kept.unwrap_or_else(|never| match never {});
    let mut statuses = statuses.into_inner().expect("no thread panics while it holds the lock");
    statuses.sort();
    let seconds = clock.elapsed().as_secs_f64();
    MonteCarlo { points, statuses, threads: rayon::current_num_threads(), seconds }
}
