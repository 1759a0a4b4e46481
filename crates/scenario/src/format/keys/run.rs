//! Settings of a run: the start, the minimiser, plugins.

use super::constraints::{ORIENTATION, TANGENT, UP};
use crate::format::form::{Family, Form, Keys, may, must};
use crate::format::limits::{ACCURACY, ANY, MAX_COUNT, SECONDS, TOLERANCE};
use wireloom_core::Quantity;

/// Plugins.
pub(super) const PLUGINS: Keys = Keys {
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
            "time limit of one call of a plugin, in seconds; default 10",
        ),
    ],
};

/// The mesh.
pub(super) const MESH: Keys = Keys {
    what: "mesh",
    keys: &[must(
        "accuracy",
        Form::Number(Quantity::Dimensionless, ACCURACY),
        "largest discretisation error of bend radii, relative to them; branches without `segments` get a mesh for it",
    )],
};

/// Axes that rotate.
pub(super) const ROTATION: Keys = Keys {
    what: "rotation",
    keys: &[
        may("point", Form::Vector(Quantity::Length), "a point of the axis; default the origin"),
        must("axis", Form::Direction, "direction of the axis"),
        may("speed", Form::Number(Quantity::AngularSpeed, ANY), "speed at the beginning; default 0"),
    ],
};

/// Pose of the rest shape.
pub(super) const INITIAL: Keys = Keys {
    what: "initial",
    keys: &[
        must("branch", Form::Name, "the branch whose start has this pose"),
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
        may("kind", Form::Kind(Family::Minimiser, Some("newton")), "its kind; default \"newton\""),
        may(
            "force_tolerance",
            Form::Number(Quantity::Dimensionless, TOLERANCE),
            "largest residual force relative to the load scale; moments likewise; default 1e-6",
        ),
        may("max_iterations", Form::Count(1, MAX_COUNT), "largest number of iterations of an increment; default 200"),
    ],
};
