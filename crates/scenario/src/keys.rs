//! The format: one table of keys for each kind of entry. The reader, the check for unknown keys and the JSON
//! Schema all go by these tables.

use wireloom_core::Quantity;

/// Limits of a number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bound {
    /// Least value.
    pub minimum: f64,
    /// Whether the least value itself is barred.
    pub exclusive: bool,
    /// Greatest value.
    pub maximum: f64,
}

/// Any finite number.
pub(crate) const ANY: Bound = Bound { minimum: f64::NEG_INFINITY, exclusive: false, maximum: f64::INFINITY };
/// Above zero.
pub(crate) const POSITIVE: Bound = Bound { minimum: 0.0, exclusive: true, maximum: f64::INFINITY };
/// Zero or above.
pub(crate) const NON_NEGATIVE: Bound = Bound { minimum: 0.0, exclusive: false, maximum: f64::INFINITY };
/// Above zero, at most one.
pub(crate) const PART: Bound = Bound { minimum: 0.0, exclusive: true, maximum: 1.0 };
/// Poisson's ratio of what is not unusual.
const POISSON: Bound = Bound { minimum: 0.0, exclusive: false, maximum: 0.5 };
/// Between zero and one.
pub(crate) const SHARE: Bound = Bound { minimum: 0.0, exclusive: false, maximum: 1.0 };

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
}

impl Family {
    /// The word for one of its kinds.
    pub fn word(self) -> &'static str {
        match self {
            Family::Rod => "rod",
            Family::Joint => "joint model",
            Family::Constraint => "constraint kind",
            Family::Minimiser => "minimiser",
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
    /// Some of these words.
    Words(&'static [&'static str]),
    /// A table.
    Table(&'static Keys),
    /// A list of tables.
    Tables(&'static Keys),
    /// A table of tables, by name.
    Named(&'static Keys),
    /// A name, a table, or a list of them; a name stands for a table that has nothing but it.
    NamesOrTables(&'static Keys),
    /// Planned, and refused by name until it is there.
    NotYet,
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

/// The most segments of a harness, increments of a step or iterations that are taken for meant.
pub(crate) const MANY: usize = 1_000_000;

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
        may("plugins", Form::NotYet, "libraries with further kinds"),
        may("obstacles", Form::NotYet, "what the harness may touch"),
        may("sweep", Form::NotYet, "values to run the scenario over"),
    ],
};

/// A section: measured, or made of wires, or both; what is measured goes before the rule.
pub(crate) const SECTION: Keys = Keys {
    what: "section",
    keys: &[
        may(
            "wires",
            Form::Tables(&SECTION_WIRES),
            "the wires in it; what is not given beside them follows from them by the rule of the library",
        ),
        with(
            "wires",
            "covering",
            Form::NamesOrTables(&COVERED),
            "what lies around the wires, inside out: a name of the library, a table with type and share, or a list of them",
        ),
        with(
            "wires",
            "cohesion",
            Form::Number(Quantity::Dimensionless, SHARE),
            "how much wires and coverings stick together, from 0 (they slide) to 1 (glued); default that of the coverings",
        ),
        with(
            "wires",
            "packing",
            Form::Number(Quantity::Dimensionless, PART),
            "share of the bundle's circle that its wires fill; default 0.75",
        ),
        unless("wires", "diameter", Form::Number(Quantity::Length, POSITIVE), "outer diameter"),
        unless(
            "wires",
            "linear_density",
            Form::Number(Quantity::LinearDensity, NON_NEGATIVE),
            "mass per unstressed length",
        ),
        unless("wires", "axial_stiffness", Form::Number(Quantity::Force, POSITIVE), "EA"),
        may(
            "shear_stiffness",
            Form::OneOrTwo(Quantity::Force, POSITIVE),
            "GA, or [GA1, GA2] along d1 and d2; default EA/2.6, that is GA = EA/(2(1 + ν)) with ν = 0.3",
        ),
        unless(
            "wires",
            "bending_stiffness",
            Form::OneOrTwo(Quantity::BendingStiffness, POSITIVE),
            "EI, or [EI1, EI2] about d1 and d2",
        ),
        unless(
            "wires",
            "torsion_stiffness",
            Form::Number(Quantity::BendingStiffness, POSITIVE),
            "GJ; never derived from the bending stiffness",
        ),
        may(
            "min_bend_radius",
            Form::Number(Quantity::Length, POSITIVE),
            "smallest bend radius allowed; reported against",
        ),
    ],
};

/// Wires of one type in a section.
pub(crate) const SECTION_WIRES: Keys = Keys {
    what: "wires",
    keys: &[
        must("type", Form::Name, "a wire of the library, such as \"FLRY-B 0.5\""),
        may("count", Form::Count(1, MANY), "how many; default 1"),
    ],
};

/// A covering over a part of a branch.
pub(crate) const COVERED: Keys = Keys {
    what: "covering",
    keys: &[
        must("type", Form::Name, "a covering of the library, such as \"pvc tape, half lap\""),
        may("share", Form::Number(Quantity::Dimensionless, PART), "share of the branch that it covers; default 1"),
    ],
};

const LIKE: Key = may("like", Form::Name, "another one of the library, from which it has what is not given here");
const LINEAR_DENSITY: Key = may(
    "linear_density",
    Form::Number(Quantity::LinearDensity, NON_NEGATIVE),
    "measured mass per length; default by the rule",
);
const AXIAL_STIFFNESS: Key =
    may("axial_stiffness", Form::Number(Quantity::Force, NON_NEGATIVE), "measured EA; default by the rule");
const BENDING_STIFFNESS: Key = may(
    "bending_stiffness",
    Form::Number(Quantity::BendingStiffness, NON_NEGATIVE),
    "measured EI; default by the rule",
);
const TORSION_STIFFNESS: Key = may(
    "torsion_stiffness",
    Form::Number(Quantity::BendingStiffness, NON_NEGATIVE),
    "measured GJ; default by the rule",
);
const MIN_BEND_RADIUS: Key = may(
    "min_bend_radius",
    Form::Number(Quantity::Length, POSITIVE),
    "smallest bend radius allowed; of wires by default four diameters",
);

/// A wire of the library.
pub(crate) const WIRE: Keys = Keys {
    what: "wire",
    keys: &[
        LIKE,
        unless("like", "strands", Form::Count(1, MANY), "strands of its conductor"),
        unless("like", "strand", Form::Number(Quantity::Length, POSITIVE), "diameter of a strand"),
        may("conductor", Form::Name, "material of the conductor; default \"copper\""),
        may(
            "conductor_diameter",
            Form::Number(Quantity::Length, POSITIVE),
            "diameter of the conductor; default that of strands that fill 0.75 of it",
        ),
        unless(
            "like",
            "layers",
            Form::Tables(&LAYER),
            "what lies over the conductor, inside out: insulation, shield, jacket",
        ),
        LINEAR_DENSITY,
        AXIAL_STIFFNESS,
        BENDING_STIFFNESS,
        TORSION_STIFFNESS,
        MIN_BEND_RADIUS,
    ],
};

/// A layer of a wire.
pub(crate) const LAYER: Keys = Keys {
    what: "layer",
    keys: &[
        must("material", Form::Name, "a material of the library, such as \"pvc\""),
        must("diameter", Form::Number(Quantity::Length, POSITIVE), "outer diameter"),
        may("fill", Form::Number(Quantity::Dimensionless, PART), "share of the ring that is filled; default 1"),
        may("strand", Form::Number(Quantity::Length, POSITIVE), "diameter of its strands, where it is a braid"),
    ],
};

/// A covering of the library.
pub(crate) const COVERING: Keys = Keys {
    what: "covering",
    keys: &[
        LIKE,
        unless("like", "material", Form::Name, "a material of the library, such as \"pvc\""),
        unless("like", "thickness", Form::Number(Quantity::Length, POSITIVE), "wall; of a tape one layer"),
        may("layers", Form::Count(1, 100), "layers that lie on each other; 2 for half lap; default 1"),
        may(
            "wrap",
            Form::Flag,
            "wound or braided, so that turns may slide on each other; default false: a closed tube",
        ),
        may(
            "coverage",
            Form::Number(Quantity::Dimensionless, PART),
            "share of the surface that it covers, such as 0.3 for a spaced tape; default 1",
        ),
        may(
            "inner_diameter",
            Form::Number(Quantity::Length, POSITIVE),
            "of a tube; left out, it lies on what it covers",
        ),
        may(
            "outer_diameter",
            Form::Number(Quantity::Length, POSITIVE),
            "of a corrugated tube, over the crests; default inner diameter and wall",
        ),
        may(
            "bending_share",
            Form::Number(Quantity::Dimensionless, SHARE),
            "what corrugation or laps leave of a plain wall's stiffness in bending and stretch; default 1",
        ),
        may(
            "torsion_share",
            Form::Number(Quantity::Dimensionless, SHARE),
            "what a slit or laps leave of a plain wall's stiffness in torsion; default 1",
        ),
        may(
            "cohesion",
            Form::Number(Quantity::Dimensionless, SHARE),
            "how much it makes wires stick together, from 0 (they slide) to 1 (glued); default 0.05, as without it",
        ),
        LINEAR_DENSITY,
        AXIAL_STIFFNESS,
        BENDING_STIFFNESS,
        TORSION_STIFFNESS,
        may("min_bend_radius", Form::Number(Quantity::Length, POSITIVE), "smallest bend radius it allows"),
    ],
};

/// A material of the library.
pub(crate) const MATERIAL: Keys = Keys {
    what: "material",
    keys: &[
        must("modulus", Form::Number(Quantity::Pressure, POSITIVE), "Young's modulus at small strains"),
        must("poisson", Form::Number(Quantity::Dimensionless, POISSON), "Poisson's ratio"),
        must("density", Form::Number(Quantity::Density, NON_NEGATIVE), "density"),
    ],
};

const MATERIALS: Key =
    may("materials", Form::Named(&MATERIAL), "materials, by name, beside those of the library or in their place");
const WIRE_TYPES: Key =
    may("wires", Form::Named(&WIRE), "types of wires, by name, beside those of the library or in their place");
const COVERINGS: Key = may(
    "coverings",
    Form::Named(&COVERING),
    "types of coverings, by name, beside those of the library or in their place",
);

const FIXING_TYPES: Key = may(
    "fixings",
    Form::Named(&FIXING_TYPE),
    "types of fixings, by name, beside those of the library or in their place",
);

/// A type of fixing.
pub(crate) const FIXING_TYPE: Keys = Keys {
    what: "fixing type",
    keys: &[
        may("doc", Form::Name, "what it is, in a few words"),
        may(
            "kind",
            Form::Kind(Family::Constraint, Some("collar")),
            "the built-in kind that it is at heart, whose parameters it may set; default \"collar\"",
        ),
        may(
            "needs",
            Form::Words(&["tangent", "up", "orientation", "rail", "free_axis"]),
            "keys that every constraint of the type must give",
        ),
        HOLD,
        SLIDE,
        FRICTION,
        PULL_OUT_FORCE,
        MAX_MOMENT,
        INSERTION_FORCE,
    ],
};

/// A file of wires, coverings, materials and types of fixings.
pub(crate) const LIBRARY_FILE: Keys = Keys { what: "library", keys: &[MATERIALS, WIRE_TYPES, COVERINGS, FIXING_TYPES] };

/// Where further wires, coverings, materials and types of fixings are.
pub(crate) const LIBRARY: Keys = Keys {
    what: "library",
    keys: &[must(
        "files",
        Form::Names,
        "TOML files with wires, coverings, materials and types of fixings, from the folder of the scenario",
    )],
};

/// A branch.
pub(crate) const BRANCH: Keys = Keys {
    what: "branch",
    keys: &[
        must("name", Form::Name, "its name"),
        must("from", Form::Name, "vertex where it begins"),
        must("to", Form::Name, "vertex where it ends"),
        must("section", Form::Name, "name of its section"),
        must("length", Form::Number(Quantity::Length, POSITIVE), "unstressed length"),
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
    Form::Number(Quantity::Dimensionless, NON_NEGATIVE),
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

/// A constraint.
pub(crate) const CONSTRAINT: Keys = Keys {
    what: "constraint",
    keys: &[
        NAME,
        must("kind", Form::Kind(Family::Constraint, None), "what it is, such as \"connector\" or \"edge-clip\""),
        PLACE,
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
        may("factor", Form::Number(Quantity::Dimensionless, ANY), "factor at the beginning; default 1"),
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

/// The minimiser.
pub(crate) const MINIMISER: Keys = Keys {
    what: "minimiser",
    keys: &[
        may("kind", Form::Kind(Family::Minimiser, Some("newton")), "which one; default \"newton\""),
        may(
            "force_tolerance",
            Form::Number(Quantity::Dimensionless, POSITIVE),
            "largest residual force relative to the load scale, moments likewise; default 1e-6",
        ),
        may("max_iterations", Form::Count(1, MANY), "iterations allowed for each increment; default 200"),
    ],
};

/// An assembly operation.
pub(crate) const STEP: Keys = Keys {
    what: "step",
    keys: &[
        may("name", Form::Name, "its name; default \"step N\""),
        may("increments", Form::Count(1, MANY), "in how many parts it is carried out; default 1"),
        may("gravity", Form::Vector(Quantity::Acceleration), "gravity reached at its end"),
        may("release", Form::Names, "constraints that let go when this step begins"),
        may("grasp", Form::Tables(&GRASP), "hands that take hold of the cable where it is when this step begins"),
        may("add", Form::Tables(&CONSTRAINT), "constraints that begin with this step"),
        may("move", Form::Tables(&MOVE), "motions of constraints, one by one"),
        may("carry", Form::Tables(&CARRY), "motions of hands or connectors that are carried together"),
        may("mate", Form::Tables(&MATE), "connectors that are brought before their seats and pushed home"),
        may("clip", Form::Tables(&CLIP), "clips that close around the cable and bring it to their seats"),
        may("load", Form::Tables(&FACTOR), "load factors reached at its end"),
        may("wait", Form::Flag, "true: nothing is done but to let the harness come to rest; default false"),
    ],
};

/// A hand that takes hold.
pub(crate) const GRASP: Keys = Keys {
    what: "grasp",
    keys: &[
        NAME,
        may("kind", Form::Kind(Family::Constraint, Some("handle")), "what takes hold; default \"handle\""),
        PLACE,
        HOLD,
        FREE_AXIS,
        RAIL,
        PULL_OUT_FORCE,
        MAX_MOMENT,
    ],
};

/// Things that are carried together.
pub(crate) const CARRY: Keys = Keys {
    what: "carry",
    keys: &[
        must("what", Form::Names, "constraints that move together, as one rigid body; the way is that of the first"),
        may(
            "about",
            Form::Table(&ABOUT),
            "the way is that of a point and frame of the body, here when the step begins, instead of the first",
        ),
        unless("path", "keyframes", Form::Tables(&KEYFRAME), "the way"),
        may(
            "path",
            Form::Name,
            "instead of keyframes: a CSV file of poses, from the folder of the scenario; columns t, x, y, z and, all or none, qw, qx, qy, qz; lengths in m or as in x [mm]; t from the step's beginning to its end",
        ),
        may("timing", Form::Tables(&TIMING), "those that begin later, or are done sooner, than the step"),
    ],
};

/// Where a body is when it begins to be carried.
pub(crate) const ABOUT: Keys = Keys {
    what: "about",
    keys: &[
        must("position", Form::Vector(Quantity::Length), "a point of the body"),
        may("tangent", Form::Direction, "with up: its frame, d3; default the world's axes"),
        may("up", Form::Direction, "with tangent: its frame, d1"),
        ORIENTATION,
    ],
};

/// A place on the way.
pub(crate) const KEYFRAME: Keys = Keys {
    what: "keyframe",
    keys: &[
        must(
            "at",
            Form::Number(Quantity::Dimensionless, SHARE),
            "share of the step at which it is passed; one at 0 says where the body counts as being as the step begins",
        ),
        may("position", Form::Vector(Quantity::Length), "position; left out, it is on the way between those beside it"),
        TANGENT,
        UP,
        ORIENTATION,
    ],
};

/// When something that is carried moves.
pub(crate) const TIMING: Keys = Keys {
    what: "timing",
    keys: &[
        must("what", Form::Name, "name of the constraint"),
        may(
            "delay",
            Form::Number(Quantity::Dimensionless, SHARE),
            "share of the step after which it begins to move; default 0",
        ),
        may(
            "share",
            Form::Number(Quantity::Dimensionless, Bound { exclusive: true, ..SHARE }),
            "share of the step over which it moves; default what is left of it",
        ),
    ],
};

/// A connector that is pushed home.
pub(crate) const MATE: Keys = Keys {
    what: "mate",
    keys: &[
        may("constraint", Form::Name, "name of the constraint, where it acts already; either this, or name and at"),
        may("name", Form::Name, "name of a constraint that begins with this step, where the cable is"),
        may("kind", Form::Kind(Family::Constraint, Some("connector")), "its kind; default \"connector\""),
        may("at", Form::Table(&AT), "where it attaches"),
        must("position", Form::Vector(Quantity::Length), "its seat"),
        TANGENT,
        UP,
        ORIENTATION,
        may("direction", Form::Direction, "where it is pushed; default out of the end of the branch along tangent"),
        may(
            "approach",
            Form::Number(Quantity::Length, POSITIVE),
            "how far before its seat the push begins; default 30 mm",
        ),
        may(
            "max_insertion_force",
            Form::Number(Quantity::Force, POSITIVE),
            "largest force that a hand may push with; reported against",
        ),
        HOLD,
        PULL_OUT_FORCE,
        MAX_MOMENT,
        INSERTION_FORCE,
    ],
};

/// A clip that closes.
pub(crate) const CLIP: Keys = Keys {
    what: "clip",
    keys: &[
        NAME,
        may("kind", Form::Kind(Family::Constraint, Some("collar")), "what it is; default \"collar\""),
        must(
            "at",
            Form::Table(&AT),
            "where it closes: branch and s, or branch alone for the place that is nearest to it when the step begins",
        ),
        must("position", Form::Vector(Quantity::Length), "its seat"),
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

/// Motion of a constraint.
pub(crate) const MOVE: Keys = Keys {
    what: "move",
    keys: &[
        must("constraint", Form::Name, "name of the constraint"),
        may("position", Form::Vector(Quantity::Length), "position reached at the end"),
        may("via", Form::Points(1), "points passed on the way, at equal shares of the step"),
        TANGENT,
        UP,
        ORIENTATION,
        may(
            "turns",
            Form::Number(Quantity::Dimensionless, ANY),
            "then turned about the tangent by so many turns, spread over the increments",
        ),
    ],
};

/// A load factor reached by a step.
pub(crate) const FACTOR: Keys = Keys {
    what: "load",
    keys: &[
        must("load", Form::Name, "name of the load"),
        must("factor", Form::Number(Quantity::Dimensionless, ANY), "factor reached at the end of the step"),
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
        may("report", Form::Flag, "write the whole run as one HTML page; default false"),
    ],
};
