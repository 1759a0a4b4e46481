//! Identities: part numbers and the like, components that do not act, and electrical connections.

use crate::format::form::{Form, Key, Keys, may, must, with};
use crate::format::limits::NON_NEGATIVE;
use wireloom_core::Quantity;

pub(crate) const NAME: Key = must("name", Form::Name, "its name");
pub(crate) const PART: Key = may("part", Form::Name, "part number, such as \"8K0 971 824\"");
pub(crate) const DESCRIPTION: Key = may("description", Form::Name, "what the parts list calls it");
pub(crate) const SUPPLIER: Key = may("supplier", Form::Name, "company that supplies it");
pub(crate) const COLOUR: Key = may("colour", Form::Name, "its colour, in the words of the drawing");

pub(crate) const KBL: Key = may("kbl", Form::Name, "id of the element of the KBL file that it was imported from");

/// The KBL file of an import.
pub(crate) const KBL_FILE: Keys = Keys {
    what: "KBL file",
    keys: &[
        must("file", Form::Name, "its name"),
        must("sha256", Form::Name, "SHA-256 of its bytes, in hexadecimal digits"),
    ],
};

/// A component that does not act.
pub(crate) const COMPONENT: Keys = Keys {
    what: "component",
    keys: &[
        NAME,
        may("kind", Form::Name, "what it is, such as \"cavity plug\""),
        PART,
        DESCRIPTION,
        SUPPLIER,
        COLOUR,
        may("connector", Form::Name, "the constraint or component that it belongs to, such as a connector"),
        with("connector", "cavity", Form::Name, "cavity of that connector"),
        may("vertex", Form::Name, "joint or end where it sits"),
        may("branch", Form::Name, "branch where it sits"),
        with(
            "branch",
            "from",
            Form::Number(Quantity::Length, NON_NEGATIVE),
            "arc length where it begins; default the start of the branch",
        ),
        with(
            "branch",
            "to",
            Form::Number(Quantity::Length, NON_NEGATIVE),
            "arc length where it ends; default the end of the branch",
        ),
    ],
};

/// An end of a wire.
pub(crate) const WIRE_END: Keys = Keys {
    what: "end",
    keys: &[
        may("connector", Form::Name, "the constraint or component in which it ends: a connector, a splice, a terminal"),
        with("connector", "cavity", Form::Name, "cavity of that connector"),
        may("terminal", Form::Name, "part number of its terminal"),
        may("seal", Form::Name, "part number of its seal"),
    ],
};

/// An electrical connection.
pub(crate) const CONNECTION: Keys = Keys {
    what: "connection",
    keys: &[
        NAME,
        may("signal", Form::Name, "its signal"),
        may("wire", Form::Name, "number of the wire, or name of the core"),
        PART,
        DESCRIPTION,
        SUPPLIER,
        COLOUR,
        may("ends", Form::Tables(&WIRE_END), "its ends: connector, cavity, terminal and seal"),
        may("branches", Form::Names, "branches through which it runs, in order; results give the sum of their lengths"),
    ],
};
