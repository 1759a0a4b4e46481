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
            /// Where the fields of nodes are written.
            pub fields: Fields,
        }

        impl Default for Output {
            fn default() -> Self {
                Self { $($name: $default,)* swept: None, fields: Fields::Json }
            }
        }

        impl Output {
            /// Whether the key of `[output]` is set.
            pub fn asks_for(&self, key: &str) -> bool {
                match key {
                    $(stringify!($name) => self.$name,)*
                    "swept" => self.swept.is_some(),
                    "fields" => self.fields == Fields::Arrow,
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
                FIELDS,
            ],
        };

        /// Reads `[output]`.
        pub(crate) fn read(entry: &Entry<'_>) -> Output {
            Output {
                $($name: entry.flag(stringify!($name)).unwrap_or($default),)*
                swept: entry.number(SWEPT.name),
                fields: match entry.choice(FIELDS.name) {
                    Some("arrow") => Fields::Arrow,
                    _ => Fields::Json,
                },
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
    /// What lengths and places do to each requirement.
    sensitivities = false, "find what each length and place does to the worst value of each requirement";
    /// Harness and obstacles at the end of each step as glTF.
    gltf = false, "write harness, constraints and obstacles at the end of each step as scenes of harness.glb";
}

/// Where the fields of nodes (positions, directors, forces, moments) are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fields {
    /// In `result.json`.
    #[default]
    Json,
    /// In `fields.arrow` beside it.
    Arrow,
}

const FIELDS: Key = may(
    "fields",
    Form::Choice(&["json", "arrow"]),
    "where positions, directors, forces and moments at nodes are written: \"json\", in result.json, however large it \
     becomes; \"arrow\", in fields.arrow beside it, which has 150 bytes for each node and equilibrium instead of some \
     380, and which pandas, Polars, DuckDB and others read; default \"json\"",
);

const SWEPT: Key = may(
    "swept",
    Form::Number(Quantity::Length, POSITIVE),
    "write the space that the harness sweeps over all increments as a closed mesh, swept.glb, from a grid with cells \
     of this size: half of a cable's radius gives its surface to an eighth of that; default: it is not written",
);
