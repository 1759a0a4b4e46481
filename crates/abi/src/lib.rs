//! Binary interface between Wireloom and a plugin: plain C structs, no Rust types.
//!
//! `include/wireloom_plugin.h` is generated from this file (`WIRELOOM_HEADER=write cargo test -p wireloom-abi`); a test
//! checks that it is current.
//!
//! A plugin is a shared library that exports one data symbol, `wireloom_plugin`, of type [`Entry`]. No function of a
//! library is called before magic, size and version of its entry have been checked. [`Entry::kinds`] lists its kinds
//! without creating any instance.
//!
//! # Compatibility guarantee
//!
//! Within a major version no field changes its offset, type or meaning; structs and constants are only appended to. A
//! plugin built for minor version m is loaded by every program of the same major version with minor version m or later.
//! A program refuses another major version or a later minor version, and prints both.
//!
//! Every struct states its size as its writer knows it (an array of structs: the size of an element, the stride). The
//! reader takes a field beyond that size as zero; the writer does not write it. So a plugin must set the sizes with
//! `sizeof`, and must check sizes before it reads fields that are newer than the first minor version it supports.
//!
//! Not guaranteed: [`draft`]; the order and number of calls, and the calling threads, except where a function states
//! them.
//!
//! # Rules for both sides
//!
//! - Strings are UTF-8 and zero-terminated. Strings and arrays that a plugin gives live as long as its library; those
//!   it receives live until the call returns.
//! - Outputs are allocated by the program and hold NaN before the call: everything requested must be written. An
//!   instance's memory is freed by its `destroy`. Neither side frees memory of the other.
//! - No unwinding or jump crosses the boundary: a panic or exception ends inside the plugin, as [`STATUS_PANIC`].
//! - Libraries are never unloaded before the process ends.
//! - SI units throughout; angles in radians; unit quaternions `w, x, y, z`; matrices row by row.
//! - Derivatives are taken along `x + δ` and `q ∘ exp(θ)`, θ in the body frame of the station or arm.

#![no_std]
#![allow(unsafe_code, reason = "descriptors hold pointers, and are shared all the same: they are never written to")]

use core::ffi::{c_char, c_void};

pub mod draft;
mod rod;

pub use rod::{RodCommit, RodDescription, RodKind, RodResponse, RodSpec};

/// `include/wireloom_plugin.h`: the same interface in C.
pub static HEADER: &str = include_str!("../include/wireloom_plugin.h");

/// `include/wireloom_plugin.hpp`: classes in C++ on top of it, from which no exception escapes.
pub static HEADER_CPP: &str = include_str!("../include/wireloom_plugin.hpp");

/// First field of every [`Entry`]: the letters `WIRELOOM`, as a little-endian number.
pub const MAGIC: u64 = 0x4d4f_4f4c_4552_4957;
/// Major version of this ABI: programs and plugins of different major versions are incompatible.
pub const ABI_MAJOR: u32 = 1;
/// Minor version of this ABI, incremented with every addition. 1: joint models. 2: joints that couple the ends of their
/// arms, length of an arm. 3: outputs of constraints. 4: quantities of motion and temperature. 5: joints that are
/// compliant hubs, springs of their arms. 6: memory of joints. 7: laws of rods. 8: memory of rods, energies, areas.
/// 9: events of constraints, tensions at their stations.
pub const ABI_MINOR: u32 = 9;

/// Success.
pub const STATUS_OK: i32 = 0;
/// Failure; the message gives the reason.
pub const STATUS_ERROR: i32 = 1;
/// The plugin panicked; the message gives the reason.
pub const STATUS_PANIC: i32 = 2;

/// [`Kind::family`]: a constraint.
pub const FAMILY_CONSTRAINT: i32 = 1;
/// [`Kind::family`]: a joint model.
pub const FAMILY_JOINT: i32 = 2;
/// [`Kind::family`]: the constitutive laws of a rod. Since ABI 1.7.
pub const FAMILY_ROD: i32 = 3;

/// [`Parameter::form`]: one number.
pub const FORM_NUMBER: i32 = 1;
/// [`Parameter::form`]: three numbers.
pub const FORM_VECTOR: i32 = 2;
/// [`Parameter::form`]: a whole number.
pub const FORM_COUNT: i32 = 3;
/// [`Parameter::form`]: true (1) or false (0).
pub const FORM_FLAG: i32 = 4;
/// [`Parameter::form`]: the index of one of the `choices`.
pub const FORM_CHOICE: i32 = 5;

/// [`Parameter::presence`]: the key is required.
pub const PRESENCE_REQUIRED: i32 = 0;
/// [`Parameter::presence`]: the key is optional and has no default.
pub const PRESENCE_OPTIONAL: i32 = 1;
/// [`Parameter::presence`]: the key is optional; its default is `default_value`.
pub const PRESENCE_DEFAULT: i32 = 2;

/// [`Parameter::quantity`]: dimensionless.
pub const QUANTITY_DIMENSIONLESS: i32 = 0;
/// [`Parameter::quantity`]: in m.
pub const QUANTITY_LENGTH: i32 = 1;
/// [`Parameter::quantity`]: in kg.
pub const QUANTITY_MASS: i32 = 2;
/// [`Parameter::quantity`]: in kg/m.
pub const QUANTITY_LINEAR_DENSITY: i32 = 3;
/// [`Parameter::quantity`]: in N.
pub const QUANTITY_FORCE: i32 = 4;
/// [`Parameter::quantity`]: in N m.
pub const QUANTITY_MOMENT: i32 = 5;
/// [`Parameter::quantity`]: in N/m.
pub const QUANTITY_FORCE_PER_LENGTH: i32 = 6;
/// [`Parameter::quantity`]: in N m/rad.
pub const QUANTITY_MOMENT_PER_ANGLE: i32 = 7;
/// [`Parameter::quantity`]: in N m².
pub const QUANTITY_BENDING_STIFFNESS: i32 = 8;
/// [`Parameter::quantity`]: in 1/m.
pub const QUANTITY_CURVATURE: i32 = 9;
/// [`Parameter::quantity`]: in rad.
pub const QUANTITY_ANGLE: i32 = 10;
/// [`Parameter::quantity`]: in m/s².
pub const QUANTITY_ACCELERATION: i32 = 11;
/// [`Parameter::quantity`]: in Pa.
pub const QUANTITY_PRESSURE: i32 = 12;
/// [`Parameter::quantity`]: in kg/m³.
pub const QUANTITY_DENSITY: i32 = 13;
/// [`Parameter::quantity`]: in m/s.
pub const QUANTITY_VELOCITY: i32 = 14;
/// [`Parameter::quantity`]: in K.
pub const QUANTITY_TEMPERATURE: i32 = 15;
/// [`Parameter::quantity`]: in 1/K.
pub const QUANTITY_THERMAL_EXPANSION: i32 = 16;
/// [`Parameter::quantity`]: in 1/(m K).
pub const QUANTITY_THERMAL_CURVATURE: i32 = 17;
/// [`Parameter::quantity`]: in rad/s.
pub const QUANTITY_ANGULAR_SPEED: i32 = 18;
/// [`Parameter::quantity`]: in s.
pub const QUANTITY_TIME: i32 = 19;
/// [`Parameter::quantity`]: in J. Since ABI 1.8.
pub const QUANTITY_ENERGY: i32 = 20;
/// [`Parameter::quantity`]: in m². Since ABI 1.8.
pub const QUANTITY_AREA: i32 = 21;

/// [`Description::shape`]: some of the six degrees of freedom of the only station are prescribed.
pub const SHAPE_PRESCRIBED: i32 = 1;
/// [`Description::shape`]: an energy.
pub const SHAPE_POTENTIAL: i32 = 2;
/// [`Description::shape`]: equations `c = 0` and inequalities `c ≤ 0`, which the program enforces.
pub const SHAPE_EQUATIONS: i32 = 3;
/// [`Description::shape`]: an energy, and equations and inequalities beside it. Since ABI 1.7.
pub const SHAPE_POTENTIAL_AND_EQUATIONS: i32 = 4;

/// [`Hold::rotation`]: all rotations are free.
pub const ROTATION_FREE: i32 = 0;
/// [`Hold::rotation`]: d3 is prescribed; rotation about it is free.
pub const ROTATION_TANGENT: i32 = 1;
/// [`Hold::rotation`]: rotation about d3 is prevented; d3 is free.
pub const ROTATION_TWIST: i32 = 2;
/// [`Hold::rotation`]: all rotations are prescribed.
pub const ROTATION_ALL: i32 = 3;
/// [`Hold::rotation`]: only rotation about `axis` is free.
pub const ROTATION_HINGE: i32 = 4;

/// [`ConstraintSpec::hold`]: the point.
pub const HOLD_POSITION: i32 = 1;
/// [`ConstraintSpec::hold`]: d3.
pub const HOLD_TANGENT: i32 = 2;
/// [`ConstraintSpec::hold`]: rotation about d3.
pub const HOLD_TWIST: i32 = 4;

/// [`JointDescription::mounting`]: the arms share one point, and an energy couples the frames of their segments there.
pub const MOUNTING_POINT: i32 = 1;
/// [`JointDescription::mounting`]: a hub with a pose, which carries the ends of its arms rigidly; no energy.
pub const MOUNTING_POSE: i32 = 2;
/// [`JointDescription::mounting`]: the arms share one point; the energy couples the frames that their ends have there.
pub const MOUNTING_STATIONS: i32 = 3;
/// [`JointDescription::mounting`]: a hub with a pose, to which the end points of its arms are fixed; the energy couples
/// the frames that the ends have there and, behind them, the frame of the hub.
pub const MOUNTING_COMPLIANT_HUB: i32 = 4;

/// Buffer for a message of the plugin: at most `capacity` bytes, including the terminating zero.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Text {
    /// The first byte.
    pub data: *mut c_char,
    /// Size of the buffer, bytes.
    pub capacity: usize,
}

/// The exported symbol `wireloom_plugin`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// [`MAGIC`].
    pub magic: u64,
    /// Size of this struct, bytes.
    pub size: u32,
    /// [`ABI_MAJOR`] that the plugin was built with.
    pub abi_major: u32,
    /// [`ABI_MINOR`] that the plugin was built with.
    pub abi_minor: u32,
    /// Zero.
    pub reserved: u32,
    /// Name of the plugin: letters, digits and hyphens.
    pub name: *const c_char,
    /// Version of the plugin, such as `1.0.2`.
    pub version: *const c_char,
    /// One-line description.
    pub doc: *const c_char,
    /// Lists the kinds; called once, before any instance is created. Returns null and writes a message on failure.
    pub kinds: Option<unsafe extern "C" fn(message: *mut Text) -> *const Kinds>,
    /// Extension of an id, such as those of [`draft`]; returns null for unknown ids. May itself be null.
    pub get_extension: Option<unsafe extern "C" fn(id: *const c_char) -> *const c_void>,
}

// SAFETY: an entry is never written to, and what it points to lives as long as the library.
unsafe impl Sync for Entry {}

/// All kinds of a plugin. Lives, with all it points to, as long as the library.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Kinds {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Number of kinds.
    pub count: u32,
    /// Size of a [`Kind`], bytes.
    pub stride: u32,
    /// Zero.
    pub reserved: u32,
    /// The first kind.
    pub first: *const Kind,
}

// SAFETY: descriptors are never written to, and what they point to lives as long as the library.
unsafe impl Sync for Kinds {}

/// A kind that scenarios can use.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// `FAMILY_…`.
    pub family: i32,
    /// Number of parameters.
    pub parameter_count: u32,
    /// Size of a [`Parameter`], bytes.
    pub parameter_stride: u32,
    /// Zero.
    pub reserved: u32,
    /// Name in scenarios.
    pub name: *const c_char,
    /// One-line description.
    pub doc: *const c_char,
    /// The first parameter.
    pub parameters: *const Parameter,
    /// Its functions, if it is a constraint.
    pub constraint: *const ConstraintKind,
    /// Its functions, if it is a joint model.
    pub joint: *const JointKind,
    /// Its functions, if it is a rod. Since ABI 1.7.
    pub rod: *const RodKind,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for Kind {}

/// A declared parameter of a kind: a key of scenario files.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Key in the scenario.
    pub name: *const c_char,
    /// One-line description.
    pub doc: *const c_char,
    /// `FORM_…`.
    pub form: i32,
    /// `QUANTITY_…`, for numbers and vectors.
    pub quantity: i32,
    /// `PRESENCE_…`.
    pub presence: i32,
    /// Whether a number must be strictly greater than `minimum` (0 or 1).
    pub minimum_excluded: i32,
    /// Smallest value of a number or count.
    pub minimum: f64,
    /// Largest value of a number; `INFINITY` for no limit.
    pub maximum: f64,
    /// Default value; in the first entry, except for vectors.
    pub default_value: [f64; 3],
    /// The choices, as texts.
    pub choices: *const *const c_char,
    /// Number of choices.
    pub choice_count: u32,
    /// Zero.
    pub reserved: u32,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for Parameter {}

/// The value of a parameter, checked against its declaration.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value {
    /// The number, vector, count, flag or index of the choice; in the first entry, except for vectors.
    pub value: [f64; 3],
    /// Whether the value is given (0 or 1).
    pub given: i32,
    /// Zero.
    pub reserved: u32,
}

/// Position and orientation.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position, m, world.
    pub position: [f64; 3],
    /// Unit quaternion `w, x, y, z`; its columns are d1, d2, d3; d3 is the tangent.
    pub orientation: [f64; 4],
}

/// Functions of a constraint kind.
///
/// Threads: `create` and `destroy` may be called from any thread, for different instances concurrently. All other
/// functions receive the instance as `const`; they are called concurrently for one instance only if its [`Description`]
/// sets `thread_safe`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ConstraintKind {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Smallest number of stations.
    pub stations_min: u32,
    /// Largest number of stations.
    pub stations_max: u32,
    /// Whether it uses a span of nodes: 0 never, 1 if one is given, 2 always.
    pub span: u32,
    /// Creates an instance and describes it. `description` comes with its size set and all else zero.
    pub create: Option<
        unsafe extern "C" fn(
            kind: *const Kind,
            spec: *const ConstraintSpec,
            instance: *mut *mut c_void,
            description: *mut Description,
            message: *mut Text,
        ) -> i32,
    >,
    /// Destroys an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Values and derivatives. May be null only if all instances are prescribed.
    pub evaluate: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            situation: *const Situation,
            evaluation: *mut Evaluation,
            message: *mut Text,
        ) -> i32,
    >,
    /// Target of one station: from the scenario's target now (`base`) to the target at `progress` of the step. Null:
    /// the target does not move.
    pub target: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            base: *const Pose,
            progress: f64,
            target: *mut Pose,
            message: *mut Text,
        ) -> i32,
    >,
    /// Called once when an increment has converged: updates `memory` (`Description::memory_count` numbers, initially
    /// those of `situation`). Null: the memory does not change.
    pub commit: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            situation: *const Situation,
            memory: *mut f64,
            message: *mut Text,
        ) -> i32,
    >,
    /// Number of outputs. Since ABI 1.3.
    pub output_count: u32,
    /// Size of an [`Output`], bytes.
    pub output_stride: u32,
    /// The first output.
    pub outputs: *const Output,
    /// Writes the `values` of all outputs, in their order, at an equilibrium, before `commit`; an event that does not
    /// happen is left NaN. May be null only if there are no outputs.
    pub report: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            situation: *const Situation,
            values: *mut f64,
            message: *mut Text,
        ) -> i32,
    >,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for ConstraintKind {}

/// A declared output of a constraint kind: a quantity that results report at each equilibrium, and that can be a column
/// of a sweep. Since ABI 1.3.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// Name in results: letters, digits, hyphens and underscores.
    pub name: *const c_char,
    /// One-line description.
    pub doc: *const c_char,
    /// `QUANTITY_…`, in SI units.
    pub quantity: i32,
    /// Zero.
    pub reserved: u32,
    /// Whether it is an event (0 or 1), such as that a clip has opened: it has a value only at the equilibria where it
    /// happens, and the run logs it. Since ABI 1.9.
    pub event: i32,
    /// Zero. Since ABI 1.9.
    pub reserved_last: u32,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for Output {}

/// A station that a constraint acts on.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Name of its branch; null if the station is a joint.
    pub branch: *const c_char,
    /// Arc length, m.
    pub arc_length: f64,
    /// Diameter of the cable, m.
    pub diameter: f64,
}

/// Part of a branch that a constraint acts along.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Its branch.
    pub branch: *const c_char,
    /// Arc length of its beginning, m.
    pub begins: f64,
    /// Arc length of its end, m.
    pub ends: f64,
    /// Diameter of the cable, m.
    pub diameter: f64,
}

/// A constraint as the scenario specifies it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ConstraintSpec {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Number of stations.
    pub station_count: u32,
    /// Size of a [`Station`], bytes.
    pub station_stride: u32,
    /// Number of values: as many as the kind has parameters.
    pub value_count: u32,
    /// Name in the scenario.
    pub name: *const c_char,
    /// The stations.
    pub stations: *const Station,
    /// The span; null if the scenario gives none.
    pub span: *const Span,
    /// The values, in the order of the kind's parameters; each has the size of [`Value`].
    pub values: *const Value,
    /// Whether the scenario gives a tangent (0 or 1).
    pub tangent_given: i32,
    /// Whether the scenario gives the direction of d1, or a whole orientation (0 or 1).
    pub up_given: i32,
    /// Degrees of freedom that the scenario lists, a sum of `HOLD_…`; 0 if it lists none.
    pub hold: i32,
    /// Whether `free_axis` is given (0 or 1).
    pub free_axis_given: i32,
    /// Unit vector, world: the only axis about which rotation is free.
    pub free_axis: [f64; 3],
    /// World directions along which the held point may move.
    pub rails: [[f64; 3]; 2],
    /// Number of rails.
    pub rail_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// Description of an instance. Written by `create`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Description {
    /// Size of this struct, bytes, as the program knows it.
    pub size: u32,
    /// `SHAPE_…`.
    pub shape: i32,
    /// Whether its stations need frames, because it exerts moments or depends on orientations (0 or 1). If prescribed,
    /// this follows from `hold`.
    pub needs_frames: i32,
    /// Whether energy or residuals are invariant under a rigid motion of stations and targets together (0 or 1).
    pub objective: i32,
    /// Whether one instance may be evaluated from several threads concurrently (0 or 1).
    pub thread_safe: i32,
    /// Whether `evaluate` writes gradients (Jacobians). If not, the program differentiates numerically and reports it.
    pub has_gradient: i32,
    /// Whether `evaluate` writes Hessians. If not, the program differentiates numerically and reports it.
    pub has_hessian: i32,
    /// Number of values remembered from increment to increment. The program stores them: it may repeat an increment, or
    /// resume later.
    pub memory_count: u32,
    /// Initial values of the memory; live until `destroy`.
    pub memory: *const f64,
    /// Number of residuals of the stations, if there are equations.
    pub residual_count: u32,
    /// Number of residuals of each node of the span; the same for every node.
    pub node_residual_count: u32,
    /// For each residual of the stations, then for each of a node: inequality (1) or equation (0). Lives until
    /// `destroy`. Null: all are equations.
    pub inequalities: *const i32,
    /// Scale of each residual: 1 for metres or radians. Lives until `destroy`. Null: 1.
    pub scales: *const f64,
    /// Prescribed freedoms, for `SHAPE_PRESCRIBED`.
    pub hold: Hold,
}

/// Degrees of freedom of a station that are prescribed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Whether the position is prescribed (0 or 1).
    pub position: i32,
    /// `ROTATION_…`.
    pub rotation: i32,
    /// World axis of a hinge, unit vector.
    pub axis: [f64; 3],
    /// World directions, orthonormal, along which the held point may still move.
    pub rails: [[f64; 3]; 2],
    /// Number of rails.
    pub rail_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// Current state of the stations, the span and the memory.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Situation {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Number of stations.
    pub station_count: u32,
    /// Number of nodes of the span.
    pub span_count: u32,
    /// Number of values in the memory.
    pub memory_count: u32,
    /// Poses of the stations. Orientations are valid only if frames are needed.
    pub stations: *const Pose,
    /// Target poses of the stations.
    pub targets: *const Pose,
    /// Positions of the nodes of the span, m, three numbers each.
    pub span: *const f64,
    /// Rest length assigned to each node of the span, m.
    pub span_lengths: *const f64,
    /// Values of the memory.
    pub memory: *const f64,
    /// Progress of the step, 0 to 1.
    pub progress: f64,
    /// Tension of the cable before and behind each station, by its arc length, N, two numbers each; 0 at a joint and
    /// beyond the end of a branch. Known in `report` and `commit` alone, else null. Since ABI 1.9.
    pub tensions: *const f64,
}

/// Outputs; null outputs are not requested. With `m` stations, `k` nodes in the span, `r` residuals of the stations and
/// `p` of each node. A station has six variables: `x`, then θ. A node has three: `x`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Energy, J: one number.
    pub energy: *mut f64,
    /// Derivative of the energy with respect to the stations' variables, N and N m: `6 m` numbers. It is minus the
    /// force and moment on the harness.
    pub gradient: *mut f64,
    /// Derivative of the energy with respect to the nodes, N: `3 k` numbers.
    pub span_gradient: *mut f64,
    /// Second derivative of the energy with respect to the stations' variables: `6 m × 6 m` numbers, symmetric. Of
    /// equations, which is asked for where `weights` are given: Σ w c″.
    pub hessian: *mut f64,
    /// Second derivative of the energy with respect to each node; nodes are not coupled: `k` times `3 × 3` numbers. Of
    /// equations: Σ w c″.
    pub span_hessian: *mut f64,
    /// Residuals: `r` of the stations, then `p` of each node; satisfied if 0 (equations) or ≤ 0 (inequalities).
    pub residuals: *mut f64,
    /// Derivatives of the stations' residuals: `r × 6 m` numbers.
    pub jacobian: *mut f64,
    /// Derivatives of the nodes' residuals, each with respect to its own node: `k` times `p × 3` numbers.
    pub span_jacobian: *mut f64,
    /// Weights w, one per residual; given if a Hessian of equations is requested.
    pub weights: *const f64,
}

/// Functions of a joint model. Threads: as for [`ConstraintKind`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointKind {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Creates an instance and describes it. `description` comes with its size set and all else zero.
    pub create: Option<
        unsafe extern "C" fn(
            kind: *const Kind,
            spec: *const JointSpec,
            instance: *mut *mut c_void,
            description: *mut JointDescription,
            message: *mut Text,
        ) -> i32,
    >,
    /// Destroys an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Energy and derivatives for frames of the arms: `w, x, y, z` of each, in the order of the arms; that of a
    /// compliant hub is the last. May be null only if all instances are rigid hubs.
    pub evaluate: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            frames: *const f64,
            evaluation: *mut JointEvaluation,
            message: *mut Text,
        ) -> i32,
    >,
    /// Called once when an increment has converged, with the frames at its end, as many as `evaluate` gets: updates
    /// `memory` (`JointDescription::memory_count` numbers, initially those at the start of the increment), so that the
    /// derivatives stay those that they were, and a second call changes no bit. Null: the memory does not change. Since
    /// ABI 1.6.
    pub commit: Option<
        unsafe extern "C" fn(instance: *const c_void, frames: *const f64, memory: *mut f64, message: *mut Text) -> i32,
    >,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for JointKind {}

/// One arm of a joint.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Arm {
    /// Name of its branch.
    pub branch: *const c_char,
    /// Whether the branch starts here: its d3 then points away from the joint (0 or 1).
    pub starts_here: i32,
    /// Zero.
    pub reserved: u32,
    /// Rest frame of the branch (d3 from its start to its end) at the joint, in the joint's frame: `w, x, y, z`.
    pub rest: [f64; 4],
    /// Position of the arm's end, in the joint's frame, m.
    pub offset: [f64; 3],
    /// Rest curvature of its branch about d1, d2, d3, 1/m.
    pub curvature: [f64; 3],
    /// Rest length of its segment at the joint, m.
    pub segment_length: f64,
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
    /// Unstressed length of its branch, m.
    pub length: f64,
    /// Stiffness of the spring that holds it to a compliant hub, about d1 and d2, N m/rad; 0: not given.
    pub spring_bending: [f64; 2],
    /// Likewise about d3.
    pub spring_torsion: f64,
}

/// Fraction of the wires of one arm that continues in another.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireShare {
    /// Index of the first arm.
    pub from: u32,
    /// Index of the second arm.
    pub to: u32,
    /// Fraction of the wires of the first arm, 0 to 1.
    pub share: f64,
}

/// A joint as the scenario specifies it.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointSpec {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Number of arms, at least two.
    pub arm_count: u32,
    /// Size of an [`Arm`], bytes.
    pub arm_stride: u32,
    /// Number of wire shares; 0 if the scenario has no wire table.
    pub wire_count: u32,
    /// Name in the scenario.
    pub name: *const c_char,
    /// The arms.
    pub arms: *const Arm,
    /// The wire shares; each has the size of [`WireShare`].
    pub wires: *const WireShare,
    /// The values, in the order of the kind's parameters; each has the size of [`Value`].
    pub values: *const Value,
    /// Number of values: as many as the kind has parameters.
    pub value_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// Description of an instance of a joint model. Written by `create`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointDescription {
    /// Size of this struct, bytes, as the program knows it.
    pub size: u32,
    /// `MOUNTING_…`.
    pub mounting: i32,
    /// Whether one instance may be evaluated from several threads concurrently (0 or 1).
    pub thread_safe: i32,
    /// Whether `evaluate` writes gradients. If not, the program differentiates numerically and reports it.
    pub has_gradient: i32,
    /// Whether `evaluate` writes Hessians. If not, the program differentiates numerically and reports it.
    pub has_hessian: i32,
    /// Zero.
    pub reserved: u32,
    /// Initial values of the memory, those at rest; live until `destroy`. Since ABI 1.6.
    pub memory: *const f64,
    /// Number of values in the memory.
    pub memory_count: u32,
    /// Zero.
    pub reserved_too: u32,
}

/// Outputs for a joint of `k` frames: those of its arms, and of a compliant hub; null outputs are not requested. The
/// energy is nonnegative, 0 at the rest directions, and invariant under a common rotation of all frames.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointEvaluation {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Number of frames k.
    pub arm_count: u32,
    /// Energy, J: one number.
    pub energy: *mut f64,
    /// Derivative of the energy with respect to θ of each frame, N m: `3 k` numbers.
    pub gradient: *mut f64,
    /// Second derivative: `3 k × 3 k` numbers, symmetric.
    pub hessian: *mut f64,
    /// Values of the memory, which the energy may depend on. Since ABI 1.6.
    pub memory: *const f64,
}
