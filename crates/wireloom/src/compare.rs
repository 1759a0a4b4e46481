//! Comparison of runs: whether they ended in the same equilibrium, what differs, and why.
//!
//! ```
//! use wireloom::Control;
//!
//! let text = std::fs::read_to_string("../../scenarios/first.toml")?;
//! let registry = wireloom::registry();
//! let run = |text: &str| {
//!     let (_, built) = wireloom::load(text, &registry).expect("no faults");
//!     wireloom::run(built, &mut |_, _| Control::Continue)
//! };
//! let finer = text.replace("max_segment = \"10 mm\"", "max_segment = \"8 mm\"");
//! let comparison = wireloom::compare::runs(&[("as it is", &run(&text)), ("finer", &run(&finer))], 1e-3);
//! assert_eq!(comparison.expect("both came to an equilibrium").groups.len(), 1);
//! # Ok::<(), std::io::Error>(())
//! ```

use wireloom_core::equilibrium::Run;

pub use wireloom_export::comparison::{
    BranchDifference, Case, Comparison, ConstraintDifference, Difference, Forces, Group, Part, Reason, Trend, Way,
    convergence, forces,
};
pub use wireloom_export::ending::{BranchEnd, Closed, ConstraintEnd, Ending};

/// Compares runs with the first one. Shapes nearer to each other than `tolerance` (m) are the same. `None` if there are
/// no runs, or one of them came to no equilibrium.
pub fn runs(runs: &[(&str, &Run)], tolerance: f64) -> Option<Comparison> {
    let case = |(name, run): &(&str, &Run)| Some(Case { name: (*name).to_owned(), ending: Ending::of(run)? });
    let cases = runs.iter().map(case).collect::<Option<Vec<Case>>>()?;
    (!cases.is_empty()).then(|| Comparison::of(&cases, Some(0), tolerance))
}
