//! Conformance suites, derivative checks, closed forms, the balance of a result, the laws of parts, and constraints of every shape to try them on.

pub mod balance;
pub mod closed_forms;
pub mod conformance;
pub mod constraints;
pub mod fuzz;
pub mod laws;
