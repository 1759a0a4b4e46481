//! The compute shaders of the GPU minimiser: WGSL stages, a CPU twin of each, and the plan by which they eliminate.
//!
//! The crate knows no graphics API. [`harness`] is the description in f64 that everything is made of, [`plan`] orders the variables and
//! writes down once which block gathers what, [`memory`] lays numbers out as the stages want them, [`twin`] is every
//! stage as a Rust function, laid beside the WGSL of the same name.
//!
//! | word | meaning |
//! | --- | --- |
//! | stage | one compute shader; many invocations, none of which writes what another one reads or writes |
//! | variable | a point or a frame: three numbers of a step; numbered in elimination order |
//! | variant | one harness of a batch: same graph, other numbers |
//! | task | a range of variables that one invocation eliminates in order; tasks of a level are independent |
//! | cycle | the dispatches that are encoded again and again; each variant's phase says which of them do anything |
//!
//! # A cycle
//!
//! Everything that an iteration decides is decided on the device, so a host encodes many cycles and reads back once. Each
//! variant goes its own way through [`offsets::Phase`]:
//!
//! | phase | stages | then |
//! | --- | --- | --- |
//! | linearise | `linearise_*`, then as refactor | |
//! | refactor | `gather_matrix`, `gather_right_hand_side`, `factorise` by levels, `inspect` | solve; where a pivot is negative refactor with a larger shift, in the next cycle |
//! | descend | `load_gradient` instead of all these (gradient method) | as solve |
//! | solve | `solve_forward`, `solve_backward` by levels, `measure_step`, `begin_search` | combine |
//! | combine | `combine`, then as search | |
//! | search | `retract`, `measure_*`, `gather_gradient`, `measure_state`, `weigh` | settle, or judge where the points are in balance |
//! | settle | the matrix of the points alone, `settle`, `measure_*` and so on | judge |
//! | judge | `judge` | linearise, descend, search with a shorter step, or done |
//!
//! # Precision
//!
//! All stages exist in f32 and f64; rotations need sums, products, quotients and square roots alone. In both, positions are sums of two numbers
//! (a value and its carry), so edges do not suffer from the round-off of coordinates. So are rest lengths, the places of
//! constraints, and the products that make the strain (`shared/exact.wgsl`), which is the small difference of an edge and a frame's axis: taken as it
//! comes it would be certain to 6e-8 only, a force of 6e-8 EA, a thousandth of the weight of a cable. So frames may be what f32 holds of them, and points settle
//! about them to all digits. What is left, seen in f64, is a relative residual of 3e-5 to 3e-4 on the reference cases; 9e-3 where a joint has offsets, whose
//! turns are not taken to twice the digits: good for a picture, and one or two iterations of `newton` from a result.

pub mod cost;
pub mod elimination;
pub mod harness;
pub mod layout;
pub mod memory;
mod order;
pub mod plan;
pub mod reference;

/// The number type of a permutation: all stages exist in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Real {
    /// Single precision.
    F32,
    /// Double precision, where the device has it.
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

/// How stages use what is bound to them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// A uniform.
    Uniform,
    /// Storage that is read.
    Read,
    /// Storage that is read and written.
    ReadWrite,
}

/// Something that stages are bound to, in group 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Its number.
    pub place: u32,
    /// Its name in the shaders.
    pub name: &'static str,
    /// How it is used.
    pub access: Access,
}

/// A struct as the shaders lay it out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Its name in the shaders.
    pub name: &'static str,
    /// Bytes.
    pub size: u32,
    /// Name and offset in bytes of every member.
    pub members: &'static [(&'static str, u32)],
}

include!(concat!(env!("OUT_DIR"), "/stages.rs"));
