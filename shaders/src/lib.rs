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

pub mod cost;
pub mod elimination;
pub mod harness;
pub mod memory;
mod order;
pub mod places;
pub mod plan;
pub mod twin;

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
