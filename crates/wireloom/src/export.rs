//! Writers of results: JSON, CSV, VTK, glTF, pictures, reports, tables. All of them write to any [`std::io::Write`].
//!
//! ```
//! use wireloom::{Control, export};
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let (scenario, built) = wireloom::load(&text, &wireloom::registry()).expect("no faults");
//! let run = wireloom::run(built, &mut |_, _| Control::Continue);
//!
//! let texts = [("first.toml".to_owned(), text)];
//! let provenance = export::provenance("my program 1.0", &scenario, &texts, &[], &[]);
//! let (mut json, mut table) = (Vec::new(), Vec::new());
//! export::json::write(&run, &provenance, &mut json)?;
//! export::csv::write(&run.steps[0].branches[0], &mut table)?;
//! let again = export::json::read_run(json.as_slice())?;
//! assert!(again.steps[0].branches[0].position == run.steps[0].branches[0].position, "read back bit by bit");
//! # Ok::<(), std::io::Error>(())
//! ```

mod provenance;

pub use provenance::{provenance, sha256};
pub use wireloom_export::names::file_name;
pub use wireloom_export::{catalogue, csv, fields, format, gltf, json, picture, report, sheet, table, vtk};
