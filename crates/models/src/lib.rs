//! Built-in rods, joints and constraints.
