//! Conformance suites for own parts, and damaged input for own readers.
//!
//! ```
//! use wireloom::testing::conformance::joint::CHECKS;
//!
//! for (name, _) in CHECKS {
//!     println!("a joint is tested for: {name}");
//! }
//! ```

pub use wireloom_testkit::{closed_forms, conformance, fuzz};
