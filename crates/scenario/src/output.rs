//! The table `[output]`: its values, its keys and its reader, all from one list.

use crate::format::form::{Form, Key, Keys, may};
use crate::format::limits::POSITIVE;
use crate::read::entry::Entry;
use wireloom_core::Quantity;

/// Defines [`Output`], [`OUTPUT`] and [`read`] from a list of flags: documentation, name, default, text of the key.
macro_rules! output {
    ($($(#[$doc:meta])* $name:ident = $default:literal, $text:literal;)*) => {
        /// Output besides the result.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Output {
            $($(#[$doc])* pub $name: bool,)*
            /// The space that the harness sweeps, as glTF, from a grid with cells of this size, m.
            pub swept: Option<f64>,
        }

        impl Default for Output {
            fn default() -> Self {
                Self { $($name: $default,)* swept: None }
            }
        }

        impl Output {
            /// Whether the key of `[output]` is set.
            pub fn asks_for(&self, key: &str) -> bool {
                match key {
                    $(stringify!($name) => self.$name,)*
                    "swept" => self.swept.is_some(),
                    _ => false,
                }
            }
        }

        /// The keys of `[output]`.
        pub(crate) const OUTPUT: Keys = Keys {
            what: "output",
            keys: &[
                $(may(stringify!($name), Form::Flag, concat!($text, "; default ", $default)),)*
                SWEPT,
            ],
        };

        /// Reads `[output]`.
        pub(crate) fn read(entry: &Entry<'_>) -> Output {
            Output {
                $($name: entry.flag(stringify!($name)).unwrap_or($default),)*
                swept: entry.number(SWEPT.name),
            }
        }
    };
}

output! {
    /// Every increment, not only the last of each step.
    increments = false, "keep every increment, not only the last of each step";
    /// The branches as CSV.
    csv = false, "write the branches as CSV";
    /// The shape as VTK.
    vtk = false, "write the shape as VTK";
    /// A picture of the shape.
    picture = true, "write a picture of the shape";
    /// The smallest distance of every branch to every obstacle and every other branch.
    clearance = false, "find how near every branch comes to every obstacle and every other branch";
    /// The whole run as one HTML page.
    report = false, "write the whole run as one HTML page";
    /// Harness and obstacles at the end of each step as glTF.
    gltf = false, "write harness, constraints and obstacles at the end of each step as scenes of harness.glb";
}

const SWEPT: Key = may(
    "swept",
    Form::Number(Quantity::Length, POSITIVE),
    "write the space that the harness sweeps over all increments as a closed mesh, swept.glb, from a grid with cells \
     of this size: half of a cable's radius gives its surface to an eighth of that; default: it is not written",
);
