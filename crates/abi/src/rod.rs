//! Rods of plugins.

use crate::{Kind, Text, Value};
use core::ffi::{c_char, c_void};

/// Functions of a rod: the constitutive laws of a branch. The program does the kinematics: positions and frames,
/// temperature, rest shape, derivatives along all of these. The energy of a branch is
///
/// `E = sum over its segments of l W(gamma) + sum over its couplings of lambda V(kappa)`
///
/// with the strain gamma of a segment (shear along d1 and d2, then stretch; dimensionless, without what temperature
/// does) and the curvature kappa of a coupling beyond that at rest (bending about d1 and d2, then twist; 1/m). W and V
/// are energies per length, J/m. They are 0, with derivatives 0, at the strain 0, and never negative; a change of sign
/// of the first component changes nothing (a branch that is run from its other end has such strains); W is convex.
/// Their second derivatives at 0 should be near the stiffnesses that the section states. The law of bending and twist
/// may remember, all 0 at first: V is then the energy of an increment for the memory at its start, stored at its end or
/// dissipated on the way; `commit` alone changes it, after convergence (since ABI 1.8). Threads: as for
/// `ConstraintKind`. Since ABI 1.7.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RodKind {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Creates an instance, for one branch, and describes it. `description` comes with its size set and all else zero.
    pub create: Option<
        unsafe extern "C" fn(
            kind: *const Kind,
            spec: *const RodSpec,
            instance: *mut *mut c_void,
            description: *mut RodDescription,
            message: *mut Text,
        ) -> i32,
    >,
    /// Destroys an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// The law W of stretch and shear, for the strains of all segments of the branch in one call: `response.count`
    /// times three numbers, all finite. May be null only if no instance has `has_stretch`.
    pub stretch: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            strains: *const f64,
            response: *mut RodResponse,
            message: *mut Text,
        ) -> i32,
    >,
    /// Likewise the law V of bending and twist, for the curvatures of all couplings, 1/m. May be null only if no
    /// instance has `has_bend`.
    pub bend: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            strains: *const f64,
            response: *mut RodResponse,
            message: *mut Text,
        ) -> i32,
    >,
    /// Updates the memory to the curvatures that end an increment, as `bend` gets them: with it and no duration `bend`
    /// gives the same moments, and a second call changes nothing. Null only without `memory_count`. Since ABI 1.8.
    pub commit: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            strains: *const f64,
            committed: *mut RodCommit,
            message: *mut Text,
        ) -> i32,
    >,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for RodKind {}

/// A branch as the scenario specifies it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RodSpec {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Number of values: as many as the kind has parameters.
    pub value_count: u32,
    /// Name of the branch.
    pub name: *const c_char,
    /// The values, in the order of the kind's parameters; each has the size of [`Value`].
    pub values: *const Value,
    /// Unstressed length, m.
    pub length: f64,
    /// Rest curvature about d1, d2, d3, 1/m. The curvatures that the law gets are those beyond it.
    pub curvature: [f64; 3],
    /// Diameter, m.
    pub diameter: f64,
    /// Linear density, kg/m.
    pub linear_density: f64,
    /// EA, N.
    pub axial_stiffness: f64,
    /// GA along d1 and d2, N.
    pub shear_stiffness: [f64; 2],
    /// EI about d1 and d2, N m².
    pub bending_stiffness: [f64; 2],
    /// GJ, N m².
    pub torsion_stiffness: f64,
}

/// Description of an instance of a rod. Written by `create`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RodDescription {
    /// Size of this struct, bytes, as the program knows it.
    pub size: u32,
    /// Whether it has a law of stretch and shear (0 or 1). If not, EA and GA of the section hold.
    pub has_stretch: i32,
    /// Whether it has a law of bending and twist (0 or 1). If not, EI and GJ of the section hold.
    pub has_bend: i32,
    /// Whether its laws write Hessians. If not, the program differentiates numerically and reports it.
    pub has_hessian: i32,
    /// Whether one instance may be evaluated from several threads concurrently (0 or 1).
    pub thread_safe: i32,
    /// Number of state variables of each coupling, at most 1000. Since ABI 1.8.
    pub memory_count: u32,
}

/// Outputs of a law for `n` strains; null outputs are not requested.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RodResponse {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Number of strains n.
    pub count: u32,
    /// Energy per length at each strain, J/m: `n` numbers.
    pub energy: *mut f64,
    /// Its derivative: forces (N) or moments (N m), `3 n` numbers.
    pub gradient: *mut f64,
    /// Its second derivative (N or N m²): `n` times `3 × 3` numbers, each symmetric.
    pub hessian: *mut f64,
    /// Memory at the start of the increment, if there is any: `n` times `memory_count` numbers. Since ABI 1.8.
    pub memory: *const f64,
    /// Time that the increment takes, s. Since ABI 1.8.
    pub duration: f64,
}

/// What `n` couplings remember, for `commit`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RodCommit {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Number of couplings n.
    pub count: u32,
    /// `n` times `memory_count` numbers: on entry those at the start of the increment, on return those at its end.
    pub memory: *mut f64,
    /// Energy per length dissipated in the increment, J/m, never negative: `n` numbers, 0 on entry.
    pub dissipated: *mut f64,
    /// Time that the increment took, s.
    pub duration: f64,
}
