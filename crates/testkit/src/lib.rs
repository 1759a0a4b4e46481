//! Conformance suites, derivative checks and closed forms.
