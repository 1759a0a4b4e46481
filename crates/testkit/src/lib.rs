//! Conformance suites, derivative checks and closed forms.

pub mod closed_forms;
pub mod conformance;
