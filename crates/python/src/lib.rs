//! The compiled part of the Python package `wireloom`: its module `wireloom._wireloom`, which only the package itself
//! uses. What users see, with its documentation, is in `python/wireloom`.
//!
//! | file | contents |
//! | --- | --- |
//! | `source` | a scenario's text and the files beside it; checks and edits of the text |
//! | `worker` | computations in a thread of their own, which Ctrl-C stops and whose panics become exceptions |
//! | `run` | runs and their files |
//! | `files` | the files of a run that `[output]` asks for |
//! | `result` | handles of equilibria and branches; arrays of NumPy that are views of the result's memory |
//! | `table` | events and requirements as tables of Arrow |
//! | `sweep` | parts of sweeps, and what is there of them |
//! | `parts` | constraints and joint models written in Python |
//! | `study` | derivatives, identification, optimisation |
//! | `session` | a harness that is moved by hand |
//! | `failure` | exceptions |

mod failure;
mod files;
mod parts;
mod result;
mod run;
mod session;
mod source;
mod study;
mod sweep;
mod table;
mod worker;

/// The module.
#[pyo3::pymodule]
mod _wireloom {
    #[pymodule_export]
    use crate::parts::check_part;
    #[pymodule_export]
    use crate::result::{Branch, Constraint, Field, Step};
    #[pymodule_export]
    use crate::run::{Run, open, run};
    #[pymodule_export]
    use crate::session::Session;
    #[pymodule_export]
    use crate::source::{check, read, value_at, with_value};
    #[pymodule_export]
    use crate::study::{identify, optimise, sensitivities};
    #[pymodule_export]
    use crate::sweep::{sweep_begin, sweep_compact, sweep_files, sweep_part, sweep_status};
    #[pymodule_export]
    use crate::table::Table;
    #[pymodule_export]
    use crate::worker::panic_for_tests;
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
