//! Wireloom: scenario text in, equilibria out.
