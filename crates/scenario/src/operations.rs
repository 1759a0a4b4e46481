//! Step operations: the tables of a step that do something.
//!
//! Each operation has a file of its own with its table of keys and its reader, and one entry in [`OPERATIONS`]. The
//! format (and with it the schema and `wireloom explain`) and the reader of steps iterate over that list.

mod add;
mod carry;
mod clip;
pub(crate) mod context;
pub(crate) mod drive;
mod grasp;
mod load;
mod mate;
mod moves;
mod operation;
mod temperature;

pub(crate) use add::ADD;
pub(crate) use carry::CARRY;
pub(crate) use drive::DRIVE;
pub(crate) use grasp::GRASP;
pub(crate) use moves::MOVE;
pub(crate) use operation::{Begins, StepOperation};

use clip::CLIP;
use load::LOAD;
use mate::MATE;
use temperature::TEMPERATURE;

/// All step operations, in the order in which a step carries them out: constraints begin in this order, too.
pub(crate) const OPERATIONS: [&StepOperation; 9] =
    [&ADD, &GRASP, &MOVE, &CARRY, &MATE, &CLIP, &DRIVE, &LOAD, &TEMPERATURE];
