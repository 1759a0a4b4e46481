//! Wireloom: the assembly of branched cables, computed. Scenario text in, equilibria out.
//!
//! [`load`] checks a scenario's text and builds its harness; [`run`] carries out its steps and returns the equilibria.
//!
//! ```
//! use wireloom::{Control, Status};
//!
//! let text = r#"
//! schema = 1
//! name = "cable"
//! [sections.cable]
//! diameter = "6 mm"
//! linear_density = "50 g/m"
//! axial_stiffness = 1e4
//! bending_stiffness = 0.01
//! torsion_stiffness = 0.008
//! [[branches]]
//! name = "cable"
//! from = "A"
//! to = "B"
//! section = "cable"
//! length = "1 m"
//! segments = 40
//! [[constraints]]
//! name = "plug-A"
//! kind = "connector"
//! at = { end = "A" }
//! position = [0, 0, 0]
//! tangent = [1, 0, 0]
//! up = [0, 0, 1]
//! [[constraints]]
//! name = "plug-B"
//! kind = "connector"
//! at = { end = "B" }
//! position = ["600 mm", 0, 0]
//! tangent = [1, 0, 0]
//! up = [0, 0, 1]
//! "#;
//! let registry = wireloom::registry();
//! let (_, built) = wireloom::load(text, &registry).expect("no faults");
//! let run = wireloom::run(built, &mut |_, _| Control::Continue);
//! assert_eq!(run.status(), Status::Converged);
//! let cable = &run.steps[0].branches[0];
//! assert!(cable.position[20].z < -0.34, "it sags");
//! ```
//!
//! | to | use |
//! | --- | --- |
//! | check a scenario and list its faults | [`check`], [`load`], [`scenario`] |
//! | carry out its steps | [`run`], [`run_observed`] |
//! | observe, stop and resume a run, or drive a harness interactively | [`session`] |
//! | read shapes, forces, events | [`result`] |
//! | vary values over many runs | [`sweep`] |
//! | differentiate results by numbers of the scenario | [`sensitivity`] |
//! | identify numbers of the scenario from measured points | [`identify`](mod@identify) |
//! | choose numbers and words so that an objective is smallest | [`optimise`] |
//! | tell whether runs ended in the same equilibrium | [`compare`] |
//! | write JSON, CSV, VTK, glTF, pictures, reports | [`export`] |
//! | lay a harness on a formboard, with drawings | `formboard` |
//! | make scenarios from KBL files, and write results back into them | `import`, `kbl` |
//! | add own rods, joints, constraints, minimisers | [`parts`], [`geometry`] |
//! | look into the harness that is computed | [`harness`], [`shapes`] |
//!
//! # Features
//!
//! None is on by default.
//!
//! | feature | adds |
//! | --- | --- |
//! | `formboard` | module `formboard`: the harness flat, drawn as SVG, DXF and PDF (dxf, pdf-writer) |
//! | `gpu` | module `gpu` and the minimiser of this name (wgpu) |
//! | `kbl` | modules `import`: KBL files to scenarios, and `kbl`: results back into them (roxmltree) |
//! | `parquet` | `export::table::Writer` and `read` (parquet) |
//! | `plugins` | module `plugins`: constraints and joints out of dynamic libraries (libloading) |
//! | `step` | module `step`: surroundings out of STEP files, which Python reads with Open CASCADE |
//! | `testing` | module `testing`: conformance suites for own parts |
//! | `bench` | module `bench`: timings of the machine at hand; turns on `gpu` and `kbl` |
//! | `full` | all of these |

#[cfg(feature = "bench")]
pub mod bench;
pub mod compare;
mod drawn_start;
pub mod export;
#[cfg(feature = "formboard")]
pub mod formboard;
pub mod geometry;
#[cfg(feature = "gpu")]
pub mod gpu;
mod halton;
pub mod harness;
pub mod identify;
#[cfg(feature = "kbl")]
pub mod import;
#[cfg(feature = "kbl")]
pub mod kbl;
mod load;
pub mod mesh;
pub mod optimise;
pub mod parts;
#[cfg(feature = "plugins")]
pub mod plugins;
mod registry;
pub mod result;
mod run;
pub mod scenario;
pub mod sensitivity;
pub mod session;
pub mod shapes;
#[cfg(feature = "step")]
pub mod step;
pub mod sweep;
#[cfg(feature = "testing")]
pub mod testing;

pub use drawn_start::compare_with_drawn_start;
pub use load::{check, load, load_with_files, load_with_settings};
pub use registry::registry;
#[cfg(feature = "gpu")]
pub use registry::registry_on;
pub use run::{run, run_observed};

pub use wireloom_core::equilibrium::{Run, StepResult};
pub use wireloom_core::{Registry, Status};
pub use wireloom_scenario::{Built, Fault, Scenario};
pub use wireloom_solve::Control;
