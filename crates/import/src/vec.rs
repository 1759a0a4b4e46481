//! VEC (VDA 4968), versions 1.2 to 2.2, to a scenario.
//!
//! | VEC | scenario |
//! | --- | --- |
//! | `TopologyNode`, placed by the `GeometryNode3D` that stands for it | vertex; with two or more segments a joint |
//! | `TopologySegment`, drawn by its `GeometrySegment3D` | branch from `StartNode` to `EndNode` |
//! | `Routing` of a `WireElementReference` | wires of a branch, wires from arm to arm of a joint |
//! | `WireElementSpecification`, `CoreSpecification`, `MassInformation` of the part | types of wires |
//! | `OnWayPlacement` of a `WireProtectionRole`, with its specification | coverings, by their class and description |
//! | `OnPointPlacement` at a node | a `connector` that holds the end; a `SpliceTerminalRole` stays free |
//! | `OnPointPlacement` of a fixing, mounted to a hole, an edge, a bolt | a `collar` that holds the cable in place |
//! | likewise of a grommet or a cable duct | a `collar` with a rail, along which the cable slides |
//! | `MinBendRadiusStatic`, `BendRadius` of tubes | `min_bend_radius` of wires, coverings and sections |
//! | `MinBendRadiusDynamic` | `min_bend_radius_moving` of sections |
//! | `Tolerance` of lengths of segments, `DefaultDimension` | a `[sweep]` in comments |
//! | `PartStructureSpecification` of a `Module` or `Variant` | parts that [`Options::selection`] leaves out |
//! | `PartVersion`, colours | `part`, `description`, `supplier`, `colour` |
//! | other `PartOccurrence`s | `[[components]]`, which do not act |
//! | `WireElementReference`s, `ContactPoint`s, `Signal`s | `[[connections]]` |
//!
//! **Geometry.** Curves are NURBS with knots and weights of their own. The points of a building block have its unit,
//! and its place in the `HarnessGeometrySpecification3D` that is no formboard. A file without 3D geometry says how
//! long its segments are, not where they lie: it becomes a harness on a board ([`Arrangement::Board`]), and nothing
//! else.
//!
//! **Length.** That of the class `Adapted` where a segment has one (it is the length the harness is built to), else
//! that of the class `Designed` (that of the drawn curve).
//!
//! **Variants.** Expressions of `VariantConfiguration`s are not evaluated: all elements that they control are taken.
//!
//! Everything else is as with [`kbl`](crate::kbl). Nothing is written back into the file.

mod element;
mod places;
mod reader;

use crate::kbl::{Contents, ImportError, Imported, Options};
use crate::scenario;

#[cfg(doc)]
use crate::kbl::Arrangement;

/// Turns the text of a VEC file into a scenario.
///
/// # Errors
/// As [`kbl::import`](crate::kbl::import); and where a file without 3D geometry is not to lie on a board.
pub fn import(text: &str, options: &Options) -> Result<Imported, ImportError> {
    scenario::make(options, |findings| reader::read(text, options, findings))
}

/// The modules and variants of a VEC file, for [`Options::selection`].
///
/// # Errors
/// Where the text is not XML or not VEC.
pub fn contents(text: &str) -> Result<Contents, ImportError> {
    reader::contents(text)
}
