//! Compute shaders of the GPU minimiser: WGSL stages, and the plan of the elimination. The feature `reference` adds a
//! CPU reference of every stage, for tests.
//!
//! The crate uses no graphics API. [`harness`] is the description in f64, [`plan`] orders the variables and lists the
//! sums of every block, [`memory`] arranges the numbers for the stages, and `reference` implements every stage in Rust,
//! in files of the same names.
//!
//! | term | meaning |
//! | --- | --- |
//! | stage | a compute shader; no invocation writes data that another one reads or writes |
//! | variable | a point or a frame: three numbers of a step; numbered in elimination order |
//! | variant | one harness of a batch: same graph, other numbers |
//! | task | a range of variables that one invocation eliminates in order; tasks of a level are independent |
//! | cycle | the dispatches that are submitted repeatedly; the phase of each variant selects those that process it |
//!
//! # A cycle
//!
//! All decisions of an iteration are made on the device, so the host submits many cycles and reads back once. Each
//! variant passes through its own sequence of [`layout::Phase`]:
//!
//! | phase | stages | then |
//! | --- | --- | --- |
//! | linearise | `linearise_*`, then as refactor | |
//! | refactor | `assemble_matrix`, `assemble_right_hand_side`, `factorise` by levels, `check_inertia` | solve, or (1) |
//! | descend | `load_gradient` instead of all these (gradient method) | as solve |
//! | solve | `solve_forward`, `solve_backward` by levels, `sum_step`, `begin_line_search` | combine |
//! | combine | `combine_directions`, then as search | |
//! | search | `retract`, `evaluate_*`, `assemble_gradient`, `sum_state`, `record_trial` | condense, or (2) accept |
//! | condense | the matrix of the points alone, `condense_points`, `evaluate_*` and so on | accept |
//! | accept | `accept_step` | linearise, descend, search with a shorter step, or done |
//!
//! (1) With a negative pivot refactor with a larger shift, in the next cycle. (2) If the points are in equilibrium.
//!
//! # Precision
//!
//! All stages exist in f32 and f64; rotations need only sums, products, quotients and square roots. Positions are sums
//! of two numbers (value and compensation), so edges do not suffer from the round-off of coordinates. So are rest
//! lengths, target positions, and the products of the strain (`shared/exact.wgsl`). The strain is a small difference
//! between an edge and a frame's axis. In plain f32 its error would be 6e-8, which is a force of 6e-8 EA, or a
//! thousandth of the weight of a cable. So frames can have f32 accuracy, and condensed points are exact for these
//! frames. The remaining relative residual, computed in f64, is 3e-5 to 3e-4 for the reference cases, and 9e-3 for
//! joints with offsets, whose rotations have single accuracy. That is sufficient for a picture, and one or two
//! iterations of `newton` from a result.

pub mod cost;
pub mod elimination;
pub mod harness;
pub mod layout;
pub mod memory;
mod order;
pub mod plan;
#[cfg(any(test, feature = "reference"))]
pub mod reference;

/// Number type of the shaders: all stages exist in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Real {
    /// Single precision.
    F32,
    /// Double precision, if the device supports it.
    F64,
}

impl Real {
    /// Bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Access of stages to a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Uniform buffer.
    Uniform,
    /// Read-only storage.
    Read,
    /// Read-write storage.
    ReadWrite,
}

/// A binding of the stages, in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Its number.
    pub place: u32,
    /// Its name in the shaders.
    pub name: &'static str,
    /// Its access.
    pub access: Access,
}

/// Layout of a struct in the shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Its name in the shaders.
    pub name: &'static str,
    /// Size, bytes.
    pub size: u32,
    /// Name and offset in bytes of every member.
    pub members: &'static [(&'static str, u32)],
}

include!(concat!(env!("OUT_DIR"), "/stages.rs"));
