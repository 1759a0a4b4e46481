//! Conformance suites, derivative checks, closed forms, the laws of parts, and constraints of every shape to try them on.

pub mod closed_forms;
pub mod conformance;
pub mod constraints;
pub mod laws;
