//! Conformance suites, derivative checks, closed forms, and constraints of every shape to try them on.

pub mod closed_forms;
pub mod conformance;
pub mod constraints;
