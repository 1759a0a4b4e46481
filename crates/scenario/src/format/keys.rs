//! The tables of keys: one for each kind of entry.

pub(crate) mod constraints;
mod harness;
pub(crate) mod identities;
mod library;
pub(crate) mod mechanisms;
mod optimise;
mod requirements;
mod run;
mod steps;
mod surroundings;
mod sweep;
#[cfg(test)]
mod tests;

pub(crate) use constraints::{CONSTRAINT, LOAD};
pub(crate) use harness::{ARM, BRANCH, JOINT};
pub(crate) use library::{FIXING_TYPE, LIBRARY_FILE, SECTION};
pub(crate) use requirements::{MARKER, REQUIREMENT};
pub(crate) use run::MINIMISER;
pub(crate) use surroundings::OBSTACLE;

use super::form::{Form, Keys, may, must};
use crate::output::OUTPUT;
use identities::{COMPONENT, CONNECTION, KBL_FILE};
use library::{COVERINGS, FIXING_TYPES, LIBRARY, MATERIALS, WIRE_TYPES};
use mechanisms::MECHANISM;
use optimise::OPTIMISE;
use run::{INITIAL, MESH, PLUGINS, ROTATION};
use steps::STEP;
use surroundings::CONTACT;
use sweep::SWEEP;
use wireloom_core::Quantity;

/// A whole scenario.
pub(crate) const SCENARIO: Keys = Keys {
    what: "scenario",
    keys: &[
        must("schema", Form::Version, "version of the format; 1 is the only one so far"),
        may("name", Form::Name, "name of the scenario, for results; default \"harness\""),
        may("gravity", Form::Vector(Quantity::Acceleration), "gravity at the beginning; default [0, 0, -9.81]"),
        may(
            "acceleration",
            Form::Vector(Quantity::Acceleration),
            "acceleration of the car at the beginning, to which everything is fixed: it acts as gravity against it; \
             default 0",
        ),
        may("rotation", Form::Table(&ROTATION), "rotation of the axes in which everything is described: a rotor's"),
        must("sections", Form::Named(&SECTION), "sections of branches, by name"),
        MATERIALS,
        WIRE_TYPES,
        COVERINGS,
        FIXING_TYPES,
        may("library", Form::Table(&LIBRARY), "files with further wires, coverings, materials and types of fixings"),
        may(
            "catalogue",
            Form::Name,
            "a file of types of fixings with their part numbers, from the folder of the scenario; as one of [library] \
             files. Part numbers of constraints that no type has are noted",
        ),
        must("branches", Form::Tables(&BRANCH), "the branches of the harness; their ends name the vertices"),
        may("joints", Form::Tables(&JOINT), "joints of branches: one for every vertex of two or more branches"),
        may("constraints", Form::Tables(&CONSTRAINT), "constraints that hold the harness from the beginning"),
        may("mesh", Form::Table(&MESH), "a mesh that is made as fine as the harness needs it"),
        may("loads", Form::Tables(&LOAD), "forces and moments, forces along branches, wind and water"),
        may("initial", Form::Table(&INITIAL), "pose of the rest shape at the start; left out, a start is found"),
        may("minimiser", Form::Table(&MINIMISER), "the minimiser that finds equilibria"),
        may("steps", Form::Tables(&STEP), "assembly operations, in order; left out, the scenario is one equilibrium"),
        may("output", Form::Table(&OUTPUT), "output besides the result"),
        may("plugins", Form::Table(&PLUGINS), "plugins with further kinds"),
        may("obstacles", Form::Tables(&OBSTACLE), "bodies that the harness may touch but not enter"),
        may(
            "mechanisms",
            Form::Tables(&MECHANISM),
            "what moves by joints: doors, linkages, robots; parts are mounted on it",
        ),
        may("contact", Form::Table(&CONTACT), "contact of cables with each other and with the obstacles"),
        may("requirements", Form::Tables(&REQUIREMENT), "limits that the harness must keep at every increment"),
        may("markers", Form::Tables(&MARKER), "named material points, whose positions every result reports"),
        may(
            "components",
            Form::Tables(&COMPONENT),
            "components of the harness that are listed and do not act: protections, cavity plugs, splices, relays",
        ),
        may(
            "kbl",
            Form::Table(&KBL_FILE),
            "the KBL file from which `wireloom import kbl` made the scenario; `wireloom export kbl` writes results \
             back into it",
        ),
        may("connections", Form::Tables(&CONNECTION), "electrical connections: wires with their signals and cavities"),
        may("sweep", Form::Table(&SWEEP), "values over which `wireloom sweep` runs the scenario"),
        may("optimise", Form::Table(&OPTIMISE), "what `wireloom optimise` chooses, and to what end"),
    ],
};
