//! STEP files (ISO 10303-21) as surroundings of a harness: the triangles of their solids, with names, colours and
//! placements.
//!
//! Open CASCADE reads the file, in a process of its own: `read.py`, which Python runs with the package
//! `cadquery-ocp-novtk`. What it has read is kept in a cache by its content. [`Reader::read`] gives an [`Assembly`],
//! [`Assembly::bodies`] its solids in their places, each with a name of its own.

mod assembly;
mod cache;
mod error;
mod message;
mod process;
mod reader;
mod text;

pub use assembly::{Assembly, Bodies, Body, Mesh, Part, Place, Solid};
pub use error::{REQUIRED, StepError};
pub use reader::{PYTHON, Reader};
