//! What the handle of a result stands for.

use crate::failure::Failure;
use crate::words::Words;
use crate::{handles, pointers};
use std::sync::{Arc, OnceLock};
use wireloom::geometry::{Vector, columns};
use wireloom::result::BranchResult;
use wireloom::{Run, StepResult};

/// What the handle is called.
pub(super) const WHAT: &str = "result";

/// A result: that of a run, or of a session at one moment.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct WireloomResult {
    /// 0: none.
    pub id: u64,
}

/// d1, d2 and d3 at the nodes of a branch.
pub(super) type Directors = [Vec<Vector>; 3];

pub(super) struct Kept {
    pub run: Run,
    pub words: Words,
    /// Of each branch of each step, once they are asked for: results keep quaternions.
    directors: Vec<Vec<OnceLock<Directors>>>,
}

impl Kept {
    /// An equilibrium.
    pub fn step(&self, index: usize) -> Result<&StepResult, Failure> {
        self.run.steps.get(index).ok_or_else(|| Failure::no_index("step", index, self.run.steps.len()))
    }

    /// The directors of a branch that there is.
    pub fn directors(&self, step: usize, branch: usize) -> &Directors {
        let frames = &self.run.steps[step].branches[branch].frame;
        self.directors[step][branch].get_or_init(|| {
            let mut all = [const { Vec::new() }; 3];
            for own in frames.iter().map(columns) {
                all.iter_mut().zip(own).for_each(|(list, d)| list.push(d));
            }
            all
        })
    }
}

/// The result of a handle.
pub(super) fn get(result: WireloomResult) -> Result<Arc<Kept>, Failure> {
    handles::get(result.id, WHAT)
}

/// Hands a result over to the caller.
pub fn hand_over(run: Run, place: *mut WireloomResult) -> Result<(), Failure> {
    let none = |_: &BranchResult| OnceLock::new();
    let directors = run.steps.iter().map(|step| step.branches.iter().map(none).collect()).collect();
    let kept = Kept { run, words: Words::default(), directors };
    pointers::put(place, "result", WireloomResult { id: handles::new(kept) })
}
