//! The space that the harness goes through: the nodes after each increment, and the surface around all of them at the
//! end.

use crate::failure::Failure;
use crate::files::saved::{Keeper, Lines};
use std::ops::Range;
use wireloom::StepResult;
use wireloom::harness::Surface;
use wireloom::scenario::{Built, Output};
use wireloom::session::{Checkpoint, Monitor};
use wireloom::shapes::swept::Envelope;

/// The surface that is asked for.
pub struct Swept {
    /// Size of the grid's cells, m.
    cell: f64,
    /// For each branch, its points in a state and the radius of each segment, m.
    branches: Vec<(Range<usize>, Vec<f64>)>,
}

impl Swept {
    /// Swept volume, if the scenario asks for it; `None` otherwise.
    pub fn of(output: &Output, built: &Built) -> Option<Self> {
        let branches = built.network.branches.iter().map(|b| (b.points.clone(), b.radii()));
        output.swept.map(|cell| Self { cell, branches: branches.collect() })
    }

    /// The harness before anything has happened.
    pub fn at_start(&self, checkpoint: &Checkpoint) -> Lines {
        self.branches.iter().map(|(points, _)| checkpoint.points()[points.clone()].to_vec()).collect()
    }

    /// The harness at the end of an increment.
    pub fn at(end: &StepResult) -> Lines {
        end.branches.iter().map(|branch| branch.position.clone()).collect()
    }

    /// The surface around all states up to this increment, and the size of its cells, m: doubled until they fit into
    /// memory. `None` where the run is to stop.
    pub fn surface(
        &self,
        keeper: &Keeper,
        increments: usize,
        monitor: &Monitor,
    ) -> Result<Option<(Surface, f64)>, Failure> {
        let radii: Vec<Vec<f64>> = self.branches.iter().map(|(_, radii)| radii.clone()).collect();
        let mut cell = self.cell;
        'coarser: loop {
            let mut envelope = Envelope::new(cell, &radii);
            for lines in keeper.lines(increments) {
                if monitor.is_stopped() {
                    return Ok(None);
                }
                if envelope.sweep(&lines?).is_err() {
                    cell *= 2.0;
                    continue 'coarser;
                }
            }
            return Ok(Some((envelope.surface(), cell)));
        }
    }

    /// Remark where the cells are larger than asked for.
    pub fn remark(&self, cell: f64) -> Option<String> {
        let (asked, taken) = (1e3 * self.cell, 1e3 * cell);
        (cell > self.cell)
            .then(|| format!("swept.glb has cells of {taken} mm: with {asked} mm it would have taken too much memory"))
    }
}
