//! What crosses the boundary between Wireloom and a plugin: plain C structs, no Rust types.
//!
//! `include/wireloom_plugin.h` is made from this file (`WIRELOOM_HEADER=write cargo test -p wireloom-abi`); a test holds it to be current.
//!
//! A plugin is a shared library that exports one data symbol, `wireloom_plugin`, of type [`Entry`]. Nothing of a library is called
//! before magic, size and version of its entry have been checked. [`Entry::kinds`] lists what it has, without making anything.
//!
//! # What is promised
//!
//! Within a major version: no field changes its place, type or meaning; structs and constants grow at the end only; a plugin
//! built against minor version m is loaded by every program of the same major version whose minor version is m or later. A program
//! refuses another major version, and a later minor one, and prints both.
//!
//! Every struct tells its size (an array of structs: that of its elements, the stride), as whoever wrote it knew it. A field beyond that size is taken
//! as zero, or is not written. So a plugin must fill in the sizes with `sizeof`, and must look at sizes before it reads what came
//! with a later minor version than the first it supports.
//!
//! Not promised: what [`draft`] has; the order of calls, their number, and from which thread they come, beyond what is written at each.
//!
//! # Rules for both sides
//!
//! - Strings are UTF-8 and end with a zero byte. Those that a plugin gives live as long as its library; those it is given,
//!   until the call returns. So do all arrays.
//! - Outputs are allocated by the program and hold not-a-number before the call: what is asked for must be written. What an
//!   instance owns is freed by its `destroy`. No memory is freed by the other side.
//! - Nothing unwinds or jumps across the boundary: a panic or exception ends inside the plugin, as [`STATUS_PANIC`].
//! - Libraries are never unloaded before the process ends.
//! - SI units throughout; angles in radians; quaternions `w, x, y, z` of length one; matrices by rows.
//! - Derivatives are taken along `x + δ` and `q ∘ exp(θ)`, θ in the body frame of the station or arm.

#![no_std]
#![allow(unsafe_code, reason = "descriptors hold pointers, and are shared all the same: they are never written to")]

use core::ffi::{c_char, c_void};

pub mod draft;

/// `include/wireloom_plugin.h`: all of this in C.
pub static HEADER: &str = include_str!("../include/wireloom_plugin.h");

/// First field of every [`Entry`]: the letters `WIRELOOM`, as a little-endian number.
pub const MAGIC: u64 = 0x4d4f_4f4c_4552_4957;
/// Version of this ABI: programs and plugins of different major versions do not fit.
pub const ABI_MAJOR: u32 = 1;
/// Version of this ABI: grows with every addition. 1: joint models. 2: joints that couple the ends of their arms, length of an arm.
pub const ABI_MINOR: u32 = 2;

/// Done.
pub const STATUS_OK: i32 = 0;
/// Not done; the message says why.
pub const STATUS_ERROR: i32 = 1;
/// The plugin panicked; the message says how.
pub const STATUS_PANIC: i32 = 2;

/// [`Kind::family`]: a constraint.
pub const FAMILY_CONSTRAINT: i32 = 1;
/// [`Kind::family`]: a joint model.
pub const FAMILY_JOINT: i32 = 2;

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

/// [`Parameter::presence`]: the key must be given.
pub const PRESENCE_REQUIRED: i32 = 0;
/// [`Parameter::presence`]: the key may be left out, and then has no value.
pub const PRESENCE_OPTIONAL: i32 = 1;
/// [`Parameter::presence`]: the key may be left out, and then has the `default_value`.
pub const PRESENCE_DEFAULT: i32 = 2;

/// [`Parameter::quantity`]: a pure number.
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

/// [`Description::shape`]: some of the six freedoms of the only station are given.
pub const SHAPE_PRESCRIBED: i32 = 1;
/// [`Description::shape`]: an energy.
pub const SHAPE_POTENTIAL: i32 = 2;
/// [`Description::shape`]: equations `c = 0` and inequalities `c ≤ 0`, which the program enforces.
pub const SHAPE_EQUATIONS: i32 = 3;

/// [`Hold::rotation`]: all rotations are free.
pub const ROTATION_FREE: i32 = 0;
/// [`Hold::rotation`]: d3 is given, turning about it is free.
pub const ROTATION_TANGENT: i32 = 1;
/// [`Hold::rotation`]: turning about d3 is not possible, d3 is free.
pub const ROTATION_TWIST: i32 = 2;
/// [`Hold::rotation`]: all rotations are given.
pub const ROTATION_ALL: i32 = 3;
/// [`Hold::rotation`]: only turning about `axis` is free.
pub const ROTATION_HINGE: i32 = 4;

/// [`ConstraintSpec::hold`]: the point.
pub const HOLD_POSITION: i32 = 1;
/// [`ConstraintSpec::hold`]: d3.
pub const HOLD_TANGENT: i32 = 2;
/// [`ConstraintSpec::hold`]: turning about d3.
pub const HOLD_TWIST: i32 = 4;

/// [`JointDescription::mounting`]: the arms share one point, and an energy couples the frames of their segments there.
pub const MOUNTING_POINT: i32 = 1;
/// [`JointDescription::mounting`]: the joint is a hub with a pose that carries the ends of its arms rigidly; it has no energy.
pub const MOUNTING_POSE: i32 = 2;
/// [`JointDescription::mounting`]: the arms share one point; the energy couples the frames that their ends have there.
pub const MOUNTING_STATIONS: i32 = 3;

/// Where a plugin writes words: at most `capacity` bytes, the zero at the end among them.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Text {
    /// The first byte.
    pub data: *mut c_char,
    /// Bytes that there is room for.
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
    /// One line: what it is for.
    pub doc: *const c_char,
    /// What it has; called once, before anything is made. Null: it has nothing, and the message says why.
    pub kinds: Option<unsafe extern "C" fn(message: *mut Text) -> *const Kinds>,
    /// Extras by name, such as those of [`draft`]; null for what the plugin does not know. May itself be null.
    pub get_extension: Option<unsafe extern "C" fn(id: *const c_char) -> *const c_void>,
}

// SAFETY: an entry is never written to, and what it points to lives as long as the library.
unsafe impl Sync for Entry {}

/// What a plugin has. Lives, with all it points to, as long as the library.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Kinds {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Kinds.
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

/// A kind that scenarios may name.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// `FAMILY_…`.
    pub family: i32,
    /// Parameters.
    pub parameter_count: u32,
    /// Size of a [`Parameter`], bytes.
    pub parameter_stride: u32,
    /// Zero.
    pub reserved: u32,
    /// Name in scenarios.
    pub name: *const c_char,
    /// One line: what it is for.
    pub doc: *const c_char,
    /// The first parameter.
    pub parameters: *const Parameter,
    /// Its functions, where it is a constraint.
    pub constraint: *const ConstraintKind,
    /// Its functions, where it is a joint model.
    pub joint: *const JointKind,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for Kind {}

/// A declared parameter of a kind: a key of scenario files.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Key in the scenario.
    pub name: *const c_char,
    /// One line: what it is for.
    pub doc: *const c_char,
    /// `FORM_…`.
    pub form: i32,
    /// `QUANTITY_…`, for numbers and vectors.
    pub quantity: i32,
    /// `PRESENCE_…`.
    pub presence: i32,
    /// Whether a number must be greater than `minimum`, not only as great (0 or 1).
    pub minimum_excluded: i32,
    /// Least value of a number or count.
    pub minimum: f64,
    /// Greatest value of a number; `INFINITY` for none.
    pub maximum: f64,
    /// Value where the key is left out; in the first entry but for vectors.
    pub default_value: [f64; 3],
    /// The words of a choice.
    pub choices: *const *const c_char,
    /// How many words.
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
    /// The number, vector, count, flag or index of the choice; in the first entry but for vectors.
    pub value: [f64; 3],
    /// Whether there is one (0 or 1).
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

/// The functions of a constraint kind.
///
/// Threads: `create` and `destroy` may be called from any thread, for different instances at a time. All other functions get an instance as
/// `const`; the same one from several threads at a time only if the [`Description`] says `thread_safe`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ConstraintKind {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Least number of stations it acts on.
    pub stations_min: u32,
    /// Greatest number of stations it acts on.
    pub stations_max: u32,
    /// Whether it acts on a span of nodes: 0 never, 1 where one is given, 2 always.
    pub span: u32,
    /// Makes an instance and describes it. `description` comes with its size and zeroes.
    pub create: Option<
        unsafe extern "C" fn(
            kind: *const Kind,
            spec: *const ConstraintSpec,
            instance: *mut *mut c_void,
            description: *mut Description,
            message: *mut Text,
        ) -> i32,
    >,
    /// Frees an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Values and derivatives. Left out only where all instances are prescribed.
    pub evaluate: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            situation: *const Situation,
            evaluation: *mut Evaluation,
            message: *mut Text,
        ) -> i32,
    >,
    /// Moves the target of one station: from where the scenario has it now (`base`) to where it is, `progress` through the step. Left out: it stays.
    pub target: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            base: *const Pose,
            progress: f64,
            target: *mut Pose,
            message: *mut Text,
        ) -> i32,
    >,
    /// Called once when an increment has converged: brings `memory` (`Description::memory_count` numbers) from what `situation` has to what
    /// holds from now on. Left out: memory stays.
    pub commit: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            situation: *const Situation,
            memory: *mut f64,
            message: *mut Text,
        ) -> i32,
    >,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for ConstraintKind {}

/// A place that a constraint acts on.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Its branch; null: it is a joint.
    pub branch: *const c_char,
    /// Arc length, m.
    pub arc_length: f64,
    /// Diameter of the cable, m.
    pub diameter: f64,
}

/// A stretch of a branch that a constraint acts along.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Its branch.
    pub branch: *const c_char,
    /// Arc length where it begins, m.
    pub begins: f64,
    /// Arc length where it ends, m.
    pub ends: f64,
    /// Diameter of the cable, m.
    pub diameter: f64,
}

/// What the scenario says of a constraint.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct ConstraintSpec {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Stations it acts on.
    pub station_count: u32,
    /// Size of a [`Station`], bytes.
    pub station_stride: u32,
    /// Values, as many as the kind has parameters.
    pub value_count: u32,
    /// Name in the scenario.
    pub name: *const c_char,
    /// The stations.
    pub stations: *const Station,
    /// The span it acts along; null where the scenario gives none.
    pub span: *const Span,
    /// The values, in the order of the kind's parameters; each has [`Value`]'s size.
    pub values: *const Value,
    /// Whether the scenario gives a tangent (0 or 1).
    pub tangent_given: i32,
    /// Whether the scenario gives the direction of d1, or a whole orientation (0 or 1).
    pub up_given: i32,
    /// The freedoms that the scenario spells out, a sum of `HOLD_…`; 0: it does not.
    pub hold: i32,
    /// Whether there is a `free_axis` (0 or 1).
    pub free_axis_given: i32,
    /// World axis about which alone turning is free; of length one.
    pub free_axis: [f64; 3],
    /// World directions along which the held point may move.
    pub rails: [[f64; 3]; 2],
    /// How many.
    pub rail_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// What an instance is. Written by `create`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Description {
    /// Size of this struct, bytes, as the program knows it.
    pub size: u32,
    /// `SHAPE_…`.
    pub shape: i32,
    /// Whether its stations need frames: it exerts moments, or looks at orientations (0 or 1). Prescribed: follows from `hold`.
    pub needs_frames: i32,
    /// Whether energy or residuals stay the same when stations and targets undergo the same rigid motion (0 or 1).
    pub objective: i32,
    /// Whether one instance may be evaluated from several threads at a time (0 or 1).
    pub thread_safe: i32,
    /// Whether `evaluate` writes gradients (Jacobians). If not, the program differentiates numerically, and says so.
    pub has_gradient: i32,
    /// Whether `evaluate` writes Hessians. If not, the program differentiates numerically, and says so.
    pub has_hessian: i32,
    /// Numbers it remembers from increment to increment. The program keeps them: it may take an increment back, or go on another day.
    pub memory_count: u32,
    /// What they are at first; lives until `destroy`.
    pub memory: *const f64,
    /// Residuals of the stations, where it is `SHAPE_EQUATIONS`.
    pub residual_count: u32,
    /// Residuals of each node of the span; every node has the same.
    pub node_residual_count: u32,
    /// For each residual of the stations, then each of a node, whether it is an inequality (1) or an equation (0); lives until `destroy`. Null: all
    /// are equations.
    pub inequalities: *const i32,
    /// For each of them, what counts as one: 1 for metres or radians. Lives until `destroy`. Null: 1.
    pub scales: *const f64,
    /// What it prescribes, where it is `SHAPE_PRESCRIBED`.
    pub hold: Hold,
}

/// Which freedoms of a station are given.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Whether the position is given (0 or 1).
    pub position: i32,
    /// `ROTATION_…`.
    pub rotation: i32,
    /// World axis of a hinge, of length one.
    pub axis: [f64; 3],
    /// World directions, orthonormal, along which the held point may move all the same.
    pub rails: [[f64; 3]; 2],
    /// How many.
    pub rail_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// Where the harness is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Situation {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Stations.
    pub station_count: u32,
    /// Nodes of the span.
    pub span_count: u32,
    /// Numbers remembered.
    pub memory_count: u32,
    /// Poses of the stations. Orientations mean something only where frames are needed.
    pub stations: *const Pose,
    /// Where the scenario wants the stations.
    pub targets: *const Pose,
    /// Positions of the nodes of the span, m, three numbers each.
    pub span: *const f64,
    /// Rest length that each node of the span carries, m.
    pub span_lengths: *const f64,
    /// What is remembered.
    pub memory: *const f64,
    /// How far the step has come, 0 to 1.
    pub progress: f64,
}

/// Where the values go: what is null is not asked for. Of `m` stations, `k` nodes in the span, `r` residuals of the stations and `p` of each node.
/// A station has six variables: `x`, then θ. A node has three: `x`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Energy, J: one number.
    pub energy: *mut f64,
    /// Derivative of the energy by the stations' variables, N and N m: `6 m` numbers. What pulls the harness along +x is a derivative along −x.
    pub gradient: *mut f64,
    /// Derivative of the energy by the nodes, N: `3 k` numbers.
    pub span_gradient: *mut f64,
    /// Second derivative of the energy by the stations' variables: `6 m × 6 m` numbers, symmetric. Of equations: Σ w c″.
    pub hessian: *mut f64,
    /// Second derivative of the energy by each node, which do not couple: `k` times `3 × 3` numbers. Of equations: Σ w c″.
    pub span_hessian: *mut f64,
    /// Residuals: `r` of the stations, then `p` of each node; met where they are 0 (equations) or not above 0 (inequalities).
    pub residuals: *mut f64,
    /// Derivatives of the stations' residuals: `r × 6 m` numbers.
    pub jacobian: *mut f64,
    /// Derivatives of the nodes' residuals, each by its own node: `k` times `p × 3` numbers.
    pub span_jacobian: *mut f64,
    /// w, one for each residual; given where a Hessian of equations is asked for.
    pub weights: *const f64,
}

/// The functions of a joint model. Threads: as for [`ConstraintKind`].
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointKind {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Zero.
    pub reserved: u32,
    /// Makes an instance and describes it. `description` comes with its size and zeroes.
    pub create: Option<
        unsafe extern "C" fn(
            kind: *const Kind,
            spec: *const JointSpec,
            instance: *mut *mut c_void,
            description: *mut JointDescription,
            message: *mut Text,
        ) -> i32,
    >,
    /// Frees an instance.
    pub destroy: Option<unsafe extern "C" fn(instance: *mut c_void)>,
    /// Energy and derivatives for frames of the arms: `w, x, y, z` of each, in the order of the arms. Left out only where all instances are hubs.
    pub evaluate: Option<
        unsafe extern "C" fn(
            instance: *const c_void,
            frames: *const f64,
            evaluation: *mut JointEvaluation,
            message: *mut Text,
        ) -> i32,
    >,
}

// SAFETY: as for `Kinds`.
unsafe impl Sync for JointKind {}

/// One arm of a joint.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Arm {
    /// Its branch.
    pub branch: *const c_char,
    /// Whether the branch starts here: its d3 then points out of the joint (0 or 1).
    pub starts_here: i32,
    /// Zero.
    pub reserved: u32,
    /// Rest frame of the branch (d3 from its start to its end) at the joint, in the joint's frame: `w, x, y, z`.
    pub rest: [f64; 4],
    /// Where the arm leaves, in the joint's frame, m.
    pub offset: [f64; 3],
    /// Rest curvature of its branch about d1, d2, d3, 1/m.
    pub curvature: [f64; 3],
    /// Rest length of its segment at the joint, m.
    pub segment_length: f64,
    /// Diameter, m.
    pub diameter: f64,
    /// kg/m.
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
}

/// Which share of the wires of one arm passes to another.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WireShare {
    /// Index of the first arm.
    pub from: u32,
    /// Index of the second arm.
    pub to: u32,
    /// Share of the wires of the first arm, 0 to 1.
    pub share: f64,
}

/// What the scenario says of a joint.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointSpec {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Arms, two at least.
    pub arm_count: u32,
    /// Size of an [`Arm`], bytes.
    pub arm_stride: u32,
    /// Wire shares; none: the scenario has no table of them.
    pub wire_count: u32,
    /// Name in the scenario.
    pub name: *const c_char,
    /// The arms.
    pub arms: *const Arm,
    /// The wire shares; each has [`WireShare`]'s size.
    pub wires: *const WireShare,
    /// The values, in the order of the kind's parameters; each has [`Value`]'s size.
    pub values: *const Value,
    /// Values, as many as the kind has parameters.
    pub value_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// What an instance of a joint model is. Written by `create`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JointDescription {
    /// Size of this struct, bytes, as the program knows it.
    pub size: u32,
    /// `MOUNTING_…`.
    pub mounting: i32,
    /// Whether one instance may be evaluated from several threads at a time (0 or 1).
    pub thread_safe: i32,
    /// Whether `evaluate` writes gradients. If not, the program differentiates numerically, and says so.
    pub has_gradient: i32,
    /// Whether `evaluate` writes Hessians. If not, the program differentiates numerically, and says so.
    pub has_hessian: i32,
    /// Zero.
    pub reserved: u32,
}

/// Where the values of a joint of `k` arms go: what is null is not asked for. The energy is 0 or more, 0 at the rest directions, and does not change when
/// all frames turn together.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointEvaluation {
    /// Size of this struct, bytes.
    pub size: u32,
    /// Arms.
    pub arm_count: u32,
    /// Energy, J: one number.
    pub energy: *mut f64,
    /// Derivative of the energy by θ of each arm, N m: `3 k` numbers.
    pub gradient: *mut f64,
    /// Second derivative: `3 k × 3 k` numbers, symmetric.
    pub hessian: *mut f64,
}
