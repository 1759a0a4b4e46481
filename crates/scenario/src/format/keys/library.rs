//! The library: sections, wires, coverings, materials, types of fixings, and files with them.

use super::constraints::{FRICTION, HOLD, INSERTION_FORCE, MAX_MOMENT, PULL_OUT_FORCE, SLIDE};
use super::identities::{COLOUR, DESCRIPTION, PART, SUPPLIER};
use crate::format::form::{Family, Form, Key, Keys, may, must, unless, with};
use crate::format::limits::{
    ANY, DIAMETER, FRACTION, HARDENING, MAX_COUNT, NON_NEGATIVE, POISSON, POSITIVE, POSITIVE_FRACTION, STIFF_RATIO,
};
use wireloom_core::Quantity;

/// A section: measured, or made of wires, or both; measured values take precedence over the rule.
pub(crate) const SECTION: Keys = Keys {
    what: "section",
    keys: &[
        may(
            "wires",
            Form::Tables(&SECTION_WIRES),
            "its wires; values that are not given follow from them by the rule of the library",
        ),
        with(
            "wires",
            "covering",
            Form::NamesOrTables(&COVERED),
            "coverings of the wires, from the inside: a name of the library, a table with type and share, or a list of \
             them",
        ),
        with(
            "wires",
            "cohesion",
            Form::Number(Quantity::Dimensionless, FRACTION),
            "cohesion of wires and coverings, from 0 (they slide) to 1 (bonded); default that of the coverings, and in \
             bending 0 if `friction` says how they stick",
        ),
        with(
            "wires",
            "packing",
            Form::Number(Quantity::Dimensionless, POSITIVE_FRACTION),
            "fraction of the bundle's circle that its wires fill; default 0.75",
        ),
        unless(&["wires"], "diameter", Form::Number(Quantity::Length, DIAMETER), "outer diameter"),
        unless(
            &["wires"],
            "linear_density",
            Form::Number(Quantity::LinearDensity, NON_NEGATIVE),
            "mass per unstressed length",
        ),
        unless(&["wires", "axial_curve"], "axial_stiffness", Form::Number(Quantity::Force, POSITIVE), "EA"),
        may(
            "axial_curve",
            Form::Curve([Quantity::Dimensionless, Quantity::Force], 3),
            "measured axial force over strain, in place of axial_stiffness: points [strain, force] in which both \
             increase, some of tension, and of compression where that differs; it passes through the origin",
        ),
        may(
            "compression_stiffness",
            Form::Number(Quantity::Force, POSITIVE),
            "EA in compression, where that is less than in tension: straps and strings; default that in tension",
        ),
        may(
            "shear_stiffness",
            Form::OneOrTwo(Quantity::Force, POSITIVE),
            "GA, or [GA1, GA2] along d1 and d2; default EA/2.6, that is GA = EA/(2(1 + ν)) with ν = 0.3",
        ),
        unless(
            &["wires", "bending_curve"],
            "bending_stiffness",
            Form::OneOrTwo(Quantity::BendingStiffness, POSITIVE),
            "EI, or [EI1, EI2] about d1 and d2",
        ),
        may(
            "bending_curve",
            Form::Curve([Quantity::Curvature, Quantity::Moment], 3),
            "measured moment over curvature, alike in all directions, in place of bending_stiffness: points \
             [curvature, moment] in which both increase, from the origin on",
        ),
        unless(
            &["wires"],
            "torsion_stiffness",
            Form::Number(Quantity::BendingStiffness, POSITIVE),
            "GJ; never derived from the bending stiffness",
        ),
        may(
            "coupling_stiffness",
            Form::Vector(Quantity::BendingStiffness),
            "[C12, C13, C23] of C in m = C (κ − κ°), which couples bending about d1 with that about d2, bending about \
             d1 with twist, and bending about d2 with twist: for flat cables that lie askew in their frame; default 0; \
             for rod = \"cosserat\"",
        ),
        may(
            "min_bend_radius",
            Form::Number(Quantity::Length, POSITIVE),
            "smallest bend radius allowed; smaller ones are reported",
        ),
        may(
            "min_bend_radius_moving",
            Form::Number(Quantity::Length, POSITIVE),
            "smallest bend radius allowed while the branch moves (dynamic)",
        ),
        may(
            "max_tension",
            Form::Number(Quantity::Force, POSITIVE),
            "largest tension allowed; default of wires: the tension that breaks the first conductor",
        ),
        may(
            "max_torsion",
            Form::Number(Quantity::Curvature, POSITIVE),
            "largest twist per length allowed, either way, such as \"180 deg/m\" or \"0.5 turns/m\"",
        ),
        may(
            "thermal_expansion",
            Form::Number(Quantity::ThermalExpansion, ANY),
            "strain along the cable per change of temperature, such as \"17 ppm/K\"; default 0. Moisture acts alike: \
             give its strain as that of a temperature",
        ),
        may(
            "thermal_curvature",
            Form::Vector(Quantity::ThermalCurvature),
            "curvature about d1 and d2, and twist about d3, per change of temperature: layers that expand differently; \
             default 0",
        ),
        may(
            "friction",
            Form::Table(&SECTION_FRICTION),
            "friction within it, beside the elastic stiffness: its wires slip, and what is bent keeps a set",
        ),
        may(
            "set",
            Form::Table(&SECTION_SET),
            "bends, or twists, beyond a limit are permanent; in bending it needs one bending stiffness",
        ),
        may(
            "creep",
            Form::Table(&SECTION_CREEP),
            "creep within it, beside the elastic stiffness: moments relax in the `duration` of steps, and what was \
             held bent keeps a set for a time",
        ),
        PART,
        DESCRIPTION,
        SUPPLIER,
        COLOUR,
    ],
};

/// Creep within a section.
pub(crate) const SECTION_CREEP: Keys = Keys {
    what: "creep",
    keys: &[
        may(
            "bending",
            Form::Tables(&CREEP_ELEMENT),
            "elements in bending, in parallel to bending_stiffness and to each other; alike about d1 and d2",
        ),
        may(
            "torsion",
            Form::Tables(&CREEP_ELEMENT),
            "elements in torsion, in parallel to torsion_stiffness and to each other",
        ),
    ],
};

/// Element of creep: a spring in series with a dashpot.
pub(crate) const CREEP_ELEMENT: Keys = Keys {
    what: "element",
    keys: &[
        must("stiffness", Form::Number(Quantity::BendingStiffness, POSITIVE), "stiffness that it adds at once"),
        must(
            "time",
            Form::Number(Quantity::Time, POSITIVE),
            "time in which its moment falls to 1/e while the bend is held, such as \"30 min\"",
        ),
    ],
};

/// Friction within a section.
pub(crate) const SECTION_FRICTION: Keys = Keys {
    what: "friction",
    keys: &[
        may(
            "slip_moment",
            Form::Number(Quantity::Moment, POSITIVE),
            "bending moment at which it slips when it is bent from straight: the kink of a measured moment over \
             curvature; with stiff_ratio in place of `bending`",
        ),
        with(
            "slip_moment",
            "stiff_ratio",
            Form::Number(Quantity::Dimensionless, STIFF_RATIO),
            "bending stiffness before it slips, over that after, which is bending_stiffness",
        ),
        may(
            "bending",
            Form::Tables(&FRICTION_ELEMENT),
            "elements in bending, in parallel to bending_stiffness and to each other; alike about d1 and d2",
        ),
        may(
            "torsion",
            Form::Tables(&FRICTION_ELEMENT),
            "elements in torsion, in parallel to torsion_stiffness and to each other",
        ),
    ],
};

/// Permanent bends and twists.
pub(crate) const SECTION_SET: Keys = Keys {
    what: "set",
    keys: &[
        unless(
            &["yield_twist"],
            "yield_curvature",
            Form::Number(Quantity::Curvature, POSITIVE),
            "curvature beyond which bends are permanent, such as \"12 1/m\"",
        ),
        unless(
            &["yield_twist"],
            "hardening",
            Form::Number(Quantity::Dimensionless, HARDENING),
            "bending stiffness beyond it as a fraction of bending_stiffness",
        ),
        may(
            "yield_twist",
            Form::Number(Quantity::Curvature, POSITIVE),
            "twist per length beyond which twists are permanent, such as \"2 turns/m\"",
        ),
        with(
            "yield_twist",
            "torsion_hardening",
            Form::Number(Quantity::Dimensionless, HARDENING),
            "torsion stiffness beyond it as a fraction of torsion_stiffness",
        ),
    ],
};

/// Element of friction: a spring in series with a slider.
pub(crate) const FRICTION_ELEMENT: Keys = Keys {
    what: "element",
    keys: &[
        must("stiffness", Form::Number(Quantity::BendingStiffness, POSITIVE), "stiffness that it adds while it sticks"),
        must("moment", Form::Number(Quantity::Moment, POSITIVE), "moment at which it slips, and which it then keeps"),
    ],
};

/// Wires of one type in a section.
pub(crate) const SECTION_WIRES: Keys = Keys {
    what: "wires",
    keys: &[
        must("type", Form::Name, "a wire of the library, such as \"FLRY-B 0.5\""),
        may("count", Form::Count(1, MAX_COUNT), "number of wires; default 1"),
    ],
};

/// A covering over a part of a branch.
pub(crate) const COVERED: Keys = Keys {
    what: "covering",
    keys: &[
        must("type", Form::Name, "a covering of the library, such as \"pvc tape, half lap\""),
        may(
            "share",
            Form::Number(Quantity::Dimensionless, POSITIVE_FRACTION),
            "fraction of the branch that it covers; default 1",
        ),
    ],
};

const LIKE: Key = may("like", Form::Name, "another one of the library, from which values that are not given are taken");
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
        unless(&["like"], "strands", Form::Count(1, MAX_COUNT), "strands of its conductor"),
        unless(&["like"], "strand", Form::Number(Quantity::Length, DIAMETER), "diameter of a strand"),
        may("conductor", Form::Name, "material of the conductor; default \"copper\""),
        may(
            "conductor_diameter",
            Form::Number(Quantity::Length, DIAMETER),
            "diameter of the conductor; default that of strands that fill 0.75 of it",
        ),
        unless(
            &["like"],
            "layers",
            Form::Tables(&LAYER),
            "layers over the conductor, from the inside: insulation, shield, jacket",
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
        must("diameter", Form::Number(Quantity::Length, DIAMETER), "outer diameter"),
        may(
            "fill",
            Form::Number(Quantity::Dimensionless, POSITIVE_FRACTION),
            "fraction of the ring that is filled; default 1",
        ),
        may("strand", Form::Number(Quantity::Length, DIAMETER), "diameter of its strands, if it is a braid"),
    ],
};

/// A covering of the library.
pub(crate) const COVERING: Keys = Keys {
    what: "covering",
    keys: &[
        LIKE,
        unless(&["like"], "material", Form::Name, "a material of the library, such as \"pvc\""),
        unless(
            &["like"],
            "thickness",
            Form::Number(Quantity::Length, DIAMETER),
            "thickness of the wall, or of a layer of a tape",
        ),
        may("layers", Form::Count(1, 100), "number of layers on each other; 2 for half lap; default 1"),
        may(
            "wrap",
            Form::Flag,
            "true: wound or braided, so that turns may slide on each other; default false: a closed tube",
        ),
        may(
            "coverage",
            Form::Number(Quantity::Dimensionless, POSITIVE_FRACTION),
            "fraction of the surface that it covers, such as 0.3 for a spaced tape; default 1",
        ),
        may(
            "inner_diameter",
            Form::Number(Quantity::Length, DIAMETER),
            "inner diameter of a tube; left out, the tube is as wide as its contents",
        ),
        may(
            "outer_diameter",
            Form::Number(Quantity::Length, DIAMETER),
            "outer diameter of a corrugated tube, over the crests; default inner diameter and wall",
        ),
        may(
            "bending_share",
            Form::Number(Quantity::Dimensionless, FRACTION),
            "fraction of a plain wall's stiffness in bending and stretch that corrugation or laps leave; default 1",
        ),
        may(
            "torsion_share",
            Form::Number(Quantity::Dimensionless, FRACTION),
            "fraction of a plain wall's stiffness in torsion that a slit or laps leave; default 1",
        ),
        may(
            "cohesion",
            Form::Number(Quantity::Dimensionless, FRACTION),
            "cohesion of the wires under it, from 0 (they slide) to 1 (bonded); default 0.05, as without it",
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
        may(
            "strength",
            Form::Number(Quantity::Pressure, POSITIVE),
            "tensile strength, for conductors: it gives the largest tension of a bundle",
        ),
    ],
};

pub(super) const MATERIALS: Key =
    may("materials", Form::Named(&MATERIAL), "materials, by name, in addition to the library or in its place");
pub(super) const WIRE_TYPES: Key =
    may("wires", Form::Named(&WIRE), "types of wires, by name, in addition to the library or in its place");
pub(super) const COVERINGS: Key =
    may("coverings", Form::Named(&COVERING), "types of coverings, by name, in addition to the library or in its place");

pub(super) const FIXING_TYPES: Key =
    may("fixings", Form::Named(&FIXING_TYPE), "types of fixings, by name, in addition to the library or in its place");

/// A type of fixing.
pub(crate) const FIXING_TYPE: Keys = Keys {
    what: "fixing type",
    keys: &[
        may("doc", Form::Name, "short description"),
        may(
            "parts",
            Form::Names,
            "part numbers of this type, * for any text and ? for one character, such as [\"8K0 971 *\"]; spaces do not \
             count. A constraint whose `part` fits is of this type, unless its `kind` names another type",
        ),
        may(
            "kind",
            Form::Kind(Family::Constraint, Some("collar")),
            "the kind of constraint that it is, whose parameters it may set; default \"collar\"",
        ),
        may(
            "needs",
            Form::Words(&["tangent", "up", "orientation", "rail", "free_axis"]),
            "keys that every constraint of this type must give",
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

/// Files with further wires, coverings, materials and types of fixings.
pub(crate) const LIBRARY: Keys = Keys {
    what: "library",
    keys: &[must(
        "files",
        Form::Names,
        "TOML files with wires, coverings, materials and types of fixings, from the folder of the scenario",
    )],
};
