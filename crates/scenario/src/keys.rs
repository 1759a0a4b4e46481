//! The format: one table of keys for each kind of entry. The reader, the check for unknown keys and the JSON
//! Schema all go by these tables.

mod library;
#[cfg(test)]
mod limits;
mod steps;
mod sweep;

use crate::units::{self, plain};
use library::{COVERINGS, FIXING_TYPES, LIBRARY, MATERIALS, WIRE_TYPES};
pub(crate) use library::{FIXING_TYPE, LIBRARY_FILE, SECTION};
pub(crate) use steps::CLIP;
use steps::STEP;
use sweep::SWEEP;
use wireloom_core::Quantity;

/// Limits of a number. Those of what it measures hold besides: see [`Bound::of`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bound {
    /// Least value.
    pub minimum: f64,
    /// Whether the least value itself is barred.
    pub exclusive: bool,
    /// Greatest value.
    pub maximum: f64,
}

impl Bound {
    /// These limits for a quantity: what is physically implausible is beyond them.
    pub fn of(self, quantity: Quantity) -> Self {
        let units::Words { smallest, largest, .. } = units::words(quantity);
        let maximum = self.maximum.min(largest);
        if self.exclusive && self.minimum == 0.0 {
            return Self { minimum: smallest, exclusive: false, maximum };
        }
        Self { minimum: self.minimum.max(-largest), maximum, ..self }
    }

    /// `from 1e-10 to 100000 m`, of limits that are those [`of`](Bound::of) the quantity.
    pub fn words(self, quantity: Quantity) -> String {
        let (least, greatest, unit) = (plain(self.minimum), plain(self.maximum), units::words(quantity).unit);
        let from = if self.exclusive { "above" } else { "from" };
        format!("{from} {least} to {greatest} {unit}").trim_end().to_owned()
    }
}

/// Between these, both included.
const fn within(minimum: f64, maximum: f64) -> Bound {
    Bound { minimum, exclusive: false, maximum }
}

/// Any number.
pub(crate) const ANY: Bound = within(f64::NEG_INFINITY, f64::INFINITY);
/// Above zero.
pub(crate) const POSITIVE: Bound = Bound { minimum: 0.0, exclusive: true, maximum: f64::INFINITY };
/// Zero or above.
pub(crate) const NON_NEGATIVE: Bound = within(0.0, f64::INFINITY);
/// Above zero, at most one.
pub(crate) const PART: Bound = Bound { maximum: 1.0, ..POSITIVE };
/// Poisson's ratio of what is not unusual.
const POISSON: Bound = within(0.0, 0.5);
/// Between zero and one.
pub(crate) const SHARE: Bound = within(0.0, 1.0);
/// Across a cable, a wire or a layer, m: a kilometre-wide harness may have cables of some ten metres, none has more.
const DIAMETER: Bound = Bound { maximum: 1e3, ..POSITIVE };
/// Along a branch, m: the longest cables that are laid in one piece.
const SPAN_LENGTH: Bound = Bound { maximum: 1e5, ..POSITIVE };
/// Coefficients of friction: more than this holds fast.
const FRICTION_COEFFICIENT: Bound = within(0.0, 1e3);
/// Turns about a tangent in one step, either way: each takes several equilibria.
const TURNS: Bound = within(-1e3, 1e3);
/// Factors of loads.
const LOAD_FACTOR: Bound = within(-1e9, 1e9);
/// Residual force relative to the load scale. Below is the round-off of forces that almost cancel; above, what is called balanced is
/// visibly not.
const TOLERANCE: Bound = within(1e-15, 1e-2);
/// How long a call may take, s: a millisecond to a day.
const SECONDS: Bound = within(1e-3, 86400.0);

/// What is looked up by name in the registry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// Rods.
    Rod,
    /// Joint models.
    Joint,
    /// Constraints.
    Constraint,
    /// Minimisers.
    Minimiser,
    /// Shapes of obstacles.
    Shape,
}

impl Family {
    /// The word for one of its kinds.
    pub fn word(self) -> &'static str {
        match self {
            Family::Rod => "rod",
            Family::Joint => "joint model",
            Family::Constraint => "constraint kind",
            Family::Minimiser => "minimiser",
            Family::Shape => "shape",
        }
    }
}

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form {
    /// The version of the format.
    Version,
    /// A string that is not empty: a new name, or that of something.
    Name,
    /// A list of such strings.
    Names,
    /// Name of a kind of the registry, and the one taken where the key is left out.
    Kind(Family, Option<&'static str>),
    /// A number.
    Number(Quantity, Bound),
    /// A number, or two.
    OneOrTwo(Quantity, Bound),
    /// Three numbers.
    Vector(Quantity),
    /// Three numbers that are not all zero, of any length.
    Direction,
    /// A quaternion `[w, x, y, z]` of any length but zero.
    Orientation,
    /// A list of points, m, at least so many.
    Points(usize),
    /// One or two directions.
    Directions,
    /// A whole number between these.
    Count(usize, usize),
    /// true or false.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// A number of any quantity, or a string with a unit.
    Quantity,
    /// A list of values of any kind.
    Values,
    /// Some of these words.
    Words(&'static [&'static str]),
    /// A table.
    Table(&'static Keys),
    /// A list of tables.
    Tables(&'static Keys),
    /// A table, or a list of them.
    OneOrMoreTables(&'static Keys),
    /// A table of tables, by name.
    Named(&'static Keys),
    /// A name, a table, or a list of them; a name stands for a table that has nothing but it.
    NamesOrTables(&'static Keys),
}

impl Form {
    /// What each of its numbers measures, and between what it must be.
    pub fn bound(&self) -> Option<(Quantity, Bound)> {
        let (quantity, bound) = match *self {
            Form::Number(quantity, bound) | Form::OneOrTwo(quantity, bound) => (quantity, bound),
            Form::Vector(quantity) => (quantity, ANY),
            Form::Points(_) => (Quantity::Length, ANY),
            _ => return None,
        };
        Some((quantity, bound.of(quantity)))
    }
}

/// Whether a key must be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Need {
    /// It must.
    Must,
    /// It may be left out.
    May,
    /// It must, unless this key is given.
    Unless(&'static str),
    /// It may be left out, and means nothing without this key.
    With(&'static str),
}

/// A key of an entry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it holds.
    pub form: Form,
    /// Whether it must be given.
    pub need: Need,
    /// What it is for.
    pub doc: &'static str,
}

/// The keys of an entry.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Keys {
    /// Word for such an entry.
    pub what: &'static str,
    /// The keys.
    pub keys: &'static [Key],
}

impl Keys {
    /// The key of this name.
    pub fn get(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The key that names the entry's kind, whose parameters are keys of the entry too.
    pub fn kind(&self) -> Option<(&'static str, Family, Option<&'static str>)> {
        self.keys.iter().find_map(|key| match key.form {
            Form::Kind(family, default) => Some((key.name, family, default)),
            _ => None,
        })
    }
}

const fn must(name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::Must, doc }
}

const fn may(name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::May, doc }
}

const fn unless(other: &'static str, name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::Unless(other), doc }
}

const fn with(other: &'static str, name: &'static str, form: Form, doc: &'static str) -> Key {
    Key { name, form, need: Need::With(other), doc }
}

/// The most segments of a harness or iterations that are taken for meant.
pub const MANY: usize = 1_000_000;
/// The most increments of a step: each is an equilibrium, and a thousand of them take a second at best.
const INCREMENTS: usize = 100_000;

/// A whole scenario.
pub(crate) const SCENARIO: Keys = Keys {
    what: "scenario",
    keys: &[
        must("schema", Form::Version, "version of the format; 1 is the only one so far"),
        may("name", Form::Name, "name of the scenario, for results; default \"harness\""),
        may("gravity", Form::Vector(Quantity::Acceleration), "gravity at the beginning; default [0, 0, -9.81]"),
        must("sections", Form::Named(&SECTION), "what branches are made of, by name"),
        MATERIALS,
        WIRE_TYPES,
        COVERINGS,
        FIXING_TYPES,
        may("library", Form::Table(&LIBRARY), "files with further wires, coverings, materials and types of fixings"),
        must("branches", Form::Tables(&BRANCH), "the branches of the harness; vertices come into being by being named"),
        may(
            "joints",
            Form::Tables(&JOINT),
            "what holds branches together: one for every vertex of two or more branches",
        ),
        may("constraints", Form::Tables(&CONSTRAINT), "what holds the harness from the beginning"),
        may("loads", Form::Tables(&LOAD), "dead loads"),
        may("initial", Form::Table(&INITIAL), "start from the rest shape, laid here; left out, a start is found"),
        may("minimiser", Form::Table(&MINIMISER), "how equilibria are found"),
        may("steps", Form::Tables(&STEP), "assembly operations, in order; left out, the scenario is one equilibrium"),
        may("output", Form::Table(&OUTPUT), "what is written besides the result"),
        may("plugins", Form::Table(&PLUGINS), "libraries with further kinds"),
        may("obstacles", Form::Tables(&OBSTACLE), "bodies that the harness may touch but not enter"),
        may("contact", Form::Table(&CONTACT), "how cables meet each other and the obstacles"),
        may("sweep", Form::Table(&SWEEP), "values to run the scenario over, with `wireloom sweep`"),
    ],
};

/// Plugins.
const PLUGINS: Keys = Keys {
    what: "plugins",
    keys: &[
        must(
            "load",
            Form::Names,
            "names of plugins in the search path, or paths of libraries from the scenario's folder",
        ),
        may(
            "time_limit",
            Form::Number(Quantity::Dimensionless, SECONDS),
            "how long one call of a plugin may take, in seconds; default 10",
        ),
    ],
};

/// A branch.
pub(crate) const BRANCH: Keys = Keys {
    what: "branch",
    keys: &[
        must("name", Form::Name, "its name"),
        must("from", Form::Name, "vertex where it begins"),
        must("to", Form::Name, "vertex where it ends"),
        must("section", Form::Name, "name of its section"),
        must("length", Form::Number(Quantity::Length, SPAN_LENGTH), "unstressed length"),
        may("segments", Form::Count(1, MANY), "how many segments it is divided into; either this or max_segment"),
        may("max_segment", Form::Number(Quantity::Length, POSITIVE), "longest segment; either this or segments"),
        may("rod", Form::Kind(Family::Rod, Some("cosserat")), "which rod it is; default \"cosserat\""),
        may(
            "curvature",
            Form::Vector(Quantity::Curvature),
            "rest curvature about d1 and d2 and rest twist about d3; default straight",
        ),
        may(
            "path",
            Form::Points(2),
            "drawn centre line from `from` to `to`, world coordinates: a start for the shape, nothing more",
        ),
    ],
};

/// A joint.
pub(crate) const JOINT: Keys = Keys {
    what: "joint",
    keys: &[
        must("name", Form::Name, "the vertex where it sits"),
        may("model", Form::Kind(Family::Joint, Some("cosserat")), "which model it is; default \"cosserat\""),
        must("arms", Form::Tables(&ARM), "one entry for every branch that ends here"),
        may("wires", Form::Tables(&WIRES), "which wires run through; default: by stiffness"),
        may("mass", Form::Number(Quantity::Mass, NON_NEGATIVE), "mass; default 0"),
    ],
};

/// An arm of a joint.
pub(crate) const ARM: Keys = Keys {
    what: "arm",
    keys: &[
        must("branch", Form::Name, "name of its branch"),
        may("direction", Form::Direction, "points out of the joint along the arm, in the joint's frame"),
        may("up", Form::Direction, "d1 of the branch in the joint's frame; projected where it is not orthogonal"),
        may(
            "orientation",
            Form::Orientation,
            "instead of direction and up: frame of the branch (d3 `from → to`) in the joint's frame",
        ),
        may(
            "offset",
            Form::Vector(Quantity::Length),
            "where the arm leaves, in the joint's frame; for models with a body",
        ),
    ],
};

/// An entry of a joint's anatomy.
pub(crate) const WIRES: Keys = Keys {
    what: "wires",
    keys: &[
        must("between", Form::Names, "two arms, by branch"),
        must(
            "share",
            Form::Number(Quantity::Dimensionless, SHARE),
            "share of the first arm's wires that passes to the second",
        ),
    ],
};

/// Where something attaches.
pub(crate) const AT: Keys = Keys {
    what: "at",
    keys: &[
        may("end", Form::Name, "a free end, by vertex"),
        may("joint", Form::Name, "a joint, by vertex"),
        may("branch", Form::Name, "a branch, with s"),
        may("s", Form::Number(Quantity::Length, ANY), "unstressed arc length along the branch"),
    ],
};

const TANGENT: Key = may("tangent", Form::Direction, "direction of d3: along the branch, from `from` to `to`");
const UP: Key =
    may("up", Form::Direction, "direction of d1; with tangent it fixes the twist; projected where not orthogonal");
const ORIENTATION: Key = may("orientation", Form::Orientation, "instead of tangent and up: the whole frame");

const NAME: Key = must("name", Form::Name, "its name");
const PLACE: Key = must("at", Form::Table(&AT), "where it attaches");
const HOLD: Key = may(
    "hold",
    Form::Words(&["position", "tangent", "twist"]),
    "the freedoms it holds, instead of those its kind holds",
);
const FREE_AXIS: Key = may("free_axis", Form::Direction, "world axis about which alone it may turn: a hinge");
const RAIL: Key =
    may("rail", Form::Directions, "one or two world directions along which the held point may move freely");
const SLIDE: Key = may(
    "slide",
    Form::Flag,
    "whether the cable may run through: a ring or, with the tangent held, a sleeve; default false",
);
const FRICTION: Key = may(
    "friction",
    Form::Number(Quantity::Dimensionless, FRICTION_COEFFICIENT),
    "where the cable runs through: axial force it takes, per force across, before the cable slips; default 0",
);
const PULL_OUT_FORCE: Key = may(
    "pull_out_force",
    Form::Number(Quantity::Force, POSITIVE),
    "largest force it takes before it comes off; reported against",
);
const MAX_MOMENT: Key =
    may("max_moment", Form::Number(Quantity::Moment, POSITIVE), "largest moment it takes; reported against");
const INSERTION_FORCE: Key =
    may("insertion_force", Form::Number(Quantity::Force, POSITIVE), "force it takes to push it home");

/// A part of a branch.
pub(crate) const SPAN: Keys = Keys {
    what: "span",
    keys: &[
        must("branch", Form::Name, "the branch"),
        may("from", Form::Number(Quantity::Length, ANY), "arc length where it begins; default 0"),
        may("to", Form::Number(Quantity::Length, ANY), "arc length where it ends; default the end of the branch"),
    ],
};

/// A constraint.
pub(crate) const CONSTRAINT: Keys = Keys {
    what: "constraint",
    keys: &[
        NAME,
        must("kind", Form::Kind(Family::Constraint, None), "what it is, such as \"connector\" or \"edge-clip\""),
        unless(
            "span",
            "at",
            Form::OneOrMoreTables(&AT),
            "where it attaches; a list, for kinds that take several places",
        ),
        may("span", Form::Table(&SPAN), "the part of a branch along which it acts, for kinds that act along one"),
        may("position", Form::Vector(Quantity::Length), "where it holds; left out: where the cable is when it begins"),
        TANGENT,
        UP,
        ORIENTATION,
        HOLD,
        FREE_AXIS,
        RAIL,
        SLIDE,
        FRICTION,
        PULL_OUT_FORCE,
        MAX_MOMENT,
        INSERTION_FORCE,
    ],
};

/// A dead load.
pub(crate) const LOAD: Keys = Keys {
    what: "load",
    keys: &[
        must("name", Form::Name, "its name"),
        must("at", Form::Table(&AT), "where it acts"),
        may("force", Form::Vector(Quantity::Force), "force in world axes; default 0"),
        may("moment", Form::Vector(Quantity::Moment), "moment in world axes; default 0"),
        may("factor", Form::Number(Quantity::Dimensionless, LOAD_FACTOR), "factor at the beginning; default 1"),
    ],
};

/// Where the rest shape is laid.
pub(crate) const INITIAL: Keys = Keys {
    what: "initial",
    keys: &[
        must("branch", Form::Name, "the branch whose start is laid here"),
        may("position", Form::Vector(Quantity::Length), "position of its start; default the origin"),
        TANGENT,
        UP,
        ORIENTATION,
    ],
};

/// A body that the harness may touch.
pub(crate) const OBSTACLE: Keys = Keys {
    what: "obstacle",
    keys: &[
        NAME,
        may("shape", Form::Kind(Family::Shape, Some("mesh")), "what it is; default \"mesh\""),
        may("mesh", Form::Name, "a file with its surface, from the folder of the scenario: STL, OBJ, PLY, glTF or GLB"),
        with(
            "mesh",
            "scale",
            Form::Number(Quantity::Dimensionless, POSITIVE),
            "length of a unit of the file in m: 0.001 for a file in millimetres; default 1",
        ),
        may("position", Form::Vector(Quantity::Length), "where its origin is; default the world's"),
        may(
            "tangent",
            Form::Direction,
            "direction of its third axis, such as that of a cylinder; default the world's z",
        ),
        may("up", Form::Direction, "with tangent: direction of its first axis; projected where not orthogonal"),
        may("orientation", Form::Orientation, "instead of tangent and up: its axes; default the world's"),
        may(
            "friction",
            Form::Number(Quantity::Dimensionless, FRICTION_COEFFICIENT),
            "coefficient of Coulomb friction: force along its surface, per force across, before a cable slips; default 0",
        ),
        may(
            "min_clearance",
            Form::Number(Quantity::Length, NON_NEGATIVE),
            "least distance from the surface of a cable to its own; reported against",
        ),
    ],
};

/// How things meet.
const CONTACT: Keys = Keys {
    what: "contact",
    keys: &[
        may("cables", Form::Flag, "whether cables touch each other, and themselves; default false"),
        with(
            "cables",
            "friction",
            Form::Number(Quantity::Dimensionless, FRICTION_COEFFICIENT),
            "coefficient of Coulomb friction of cables on each other, and on themselves; default 0: they are smooth",
        ),
        may(
            "resolve",
            Form::Flag,
            "true: a harness that begins within an obstacle is pushed out first; default false: it is refused",
        ),
    ],
};

/// The minimiser.
pub(crate) const MINIMISER: Keys = Keys {
    what: "minimiser",
    keys: &[
        may("kind", Form::Kind(Family::Minimiser, Some("newton")), "which one; default \"newton\""),
        may(
            "force_tolerance",
            Form::Number(Quantity::Dimensionless, TOLERANCE),
            "largest residual force relative to the load scale, moments likewise; default 1e-6",
        ),
        may("max_iterations", Form::Count(1, MANY), "iterations allowed for each increment; default 200"),
    ],
};

/// What is written.
pub(crate) const OUTPUT: Keys = Keys {
    what: "output",
    keys: &[
        may("increments", Form::Flag, "keep every increment, not only the last of each step; default false"),
        may("csv", Form::Flag, "write the branches as CSV; default false"),
        may("vtk", Form::Flag, "write the shape as VTK; default false"),
        may("picture", Form::Flag, "write a picture of the shape; default true"),
        may(
            "clearance",
            Form::Flag,
            "find how near every branch comes to every obstacle and every other branch; default false",
        ),
        may("report", Form::Flag, "write the whole run as one HTML page; default false"),
        may(
            "gltf",
            Form::Flag,
            "write the harness with its fixings and obstacles at the end of each step as harness.glb, a scene each; default false",
        ),
        may(
            "swept",
            Form::Number(Quantity::Length, POSITIVE),
            "write the space that the harness goes through over all increments as a closed mesh, swept.glb, from a grid with cells of \
             this size: half of a cable's radius gives its surface to an eighth of that; default: it is not written",
        ),
    ],
};
