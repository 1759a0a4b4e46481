//! KBL (VDA 4964) to a scenario.
//!
//! | KBL | scenario |
//! | --- | --- |
//! | `Node` | vertex; with two or more segments a joint (`cosserat`) whose arms leave it as drawn |
//! | `Segment` | branch from `Start_node` to `End_node`, its drawn centre line as `path` |
//! | `Routing`, `General_wire_occurrence`, `Core_occurrence` | wires of a branch, wires from arm to arm of a joint |
//! | `General_wire`, `Wire_protection` | types of wires and coverings, like those of the library; sections of wires |
//! | `Referenced_components` of an end node | a `connector` that holds the end; a splice stays free |
//! | `Fixing_assignment`, `Placement` of its fixing | a `collar` where the fixing is drawn, along its channel (`V`) |
//! | `Tolerance_indication` of a `Dimension_specification` of one segment, or of a default | a `[sweep]` in comments |
//! | `Module`, `Harness_configuration` | parts that [`Options::selection`] leaves out, and segments without wires |
//! | part numbers, `Description`, `Company_name`, colours | `part`, `description`, `supplier`, `colour` |
//! | other occurrences: protections, plugs, seals, splices, … | `[[components]]`, which do not act |
//! | `Connection`, its `Signal_name`, cavities, terminals, seals | `[[connections]]` |
//! | `Mass_information` of housings and terminals | a dead load at the end |
//! | XML ids of segments and of assignments of fixings | `kbl` of branches and clips, for [`export`] |
//!
//! **Length.** `Physical_length` where a file gives it (it is the length the harness is built to), else
//! `Virtual_length` (that of the drawn curve), else the arc length of the curve itself. The files at hand have
//! `Virtual_length` only; it agrees with the arc length of the drawn curve to a few parts in 10⁵.
//!
//! **Units.** Every value refers to a `Unit` of its file. Coordinates have none in KBL; they are millimetres by the
//! recommendation, and a file whose curves and lengths disagree about that is reported.
//!
//! **Frames.** Every branch carries one untwisted (rotation-minimising) frame field along its drawn centre line. Joint
//! arms and connectors take their orientations from it, so that the harness as drawn is free of twist.
//!
//! **Board.** The harness flat below the vehicle ([`wireloom_formboard`]), built there: joints have the angles of the
//! board at rest. Elastic pegs bear its weight; the board itself bears nothing.
//!
//! **Assembly.** Hands at joints move the harness from the board to the vehicle. Then one connector or clip after the
//! other is moved to its seat, outward from the connector of the heaviest branch; a hand is released when everything
//! beyond it is installed. At the end every connector is released to turn freely and is then mated again, which
//! removes whole turns of twist that depend on the order.

pub mod export;
mod fit;
mod reader;

pub use crate::error::ImportError;
pub use crate::findings::Finding;
pub use crate::options::{
    Arrangement, Contents, ElementPlace, Imported, Module, Options, Order, Selection, Source, Variant, WireRun,
};
pub use crate::usage::Usage;

use crate::scenario;

/// Turns the text of a KBL file into a scenario.
///
/// # Errors
/// [`ImportError`] where the text is not XML or not KBL, a number cannot be read, an id is given twice, or nodes and
/// segments do not make a harness, or one that is too large. What a harness can do without (curves, wires, coverings,
/// fixings) is never an error: it is replaced by a stated rule and reported in [`Imported::findings`].
pub fn import(text: &str, options: &Options) -> Result<Imported, ImportError> {
    scenario::make(options, |findings| reader::read(text, &options.selection, findings))
}

/// The modules and variants of a KBL file, for [`Options::selection`].
///
/// # Errors
/// Where the text is not XML or not KBL.
pub fn contents(text: &str) -> Result<Contents, ImportError> {
    reader::contents(text)
}
