//! Scenario texts: reading and checking, explaining the format, replacing values, writing steps back.
//!
//! [`load`](crate::load) checks and builds; this module is for programs that show faults, read what a scenario asks
//! for, or edit its text.
//!
//! ```
//! use wireloom::scenario::{NoFiles, Setting, render};
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let registry = wireloom::registry();
//! let longer = [Setting::new("branches.trunk.length", "620 mm")];
//! match wireloom::load_with_settings(&text, &longer, &NoFiles, &registry) {
//!     Ok((scenario, _)) => println!("{} with {} branches", scenario.name, scenario.branches.len()),
//!     Err(faults) => panic!("{}", render(&text, &faults)),
//! }
//! # Ok::<(), std::io::Error>(())
//! ```

pub use wireloom_scenario::{
    Arm, At, Body, Branch, Built, Constraint, Division, Facing, Fault, Files, Joint, Load, MAX_SEGMENTS, Minimiser,
    NoFiles, Number, Output, Places, Plugins, Scenario, Setting, Span, Stretch, number_at, parse, parse_with_files,
    plugins, quantity_in, render, schema, shipped_coverings, shipped_fixings, shipped_wires, unit_of, value_for,
};
pub use wireloom_scenario::{adjust, bundle, explain, fault, optimise, record, settings, structure};
