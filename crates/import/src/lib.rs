//! Harness files of other formats to scenarios.
