//! Conformance suites, derivative checks, closed forms, balance of a result, laws of parts, and constraints of every
//! shape for tests.

pub mod balance;
pub mod closed_forms;
pub mod conformance;
pub mod constraints;
pub mod fuzz;
pub mod laws;
