// Plugins for Wireloom: what crosses the boundary. Made from crates/abi; do not edit.
//
// A plugin defines one symbol, WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = { ... };
// The rules (strings, memory, threads, versions) and a guide stand in crates/plugin/README.md.

#ifndef WIRELOOM_PLUGIN_H
#define WIRELOOM_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#if defined(__cplusplus)
#define WIRELOOM_C extern "C"
#else
#define WIRELOOM_C
#endif
#if defined(_WIN32)
#define WIRELOOM_EXPORT WIRELOOM_C __declspec(dllexport)
#else
#define WIRELOOM_EXPORT WIRELOOM_C __attribute__((visibility("default")))
#endif

// Its functions receive it.
struct WireloomKind;

// First field of every `Entry`: the letters `WIRELOOM`, as a little-endian number.
#define WIRELOOM_MAGIC 5570758453079722327

// Major version of this ABI: programs and plugins of different major versions are incompatible.
#define WIRELOOM_ABI_MAJOR 1

// Minor version of this ABI, incremented with every addition. 1: joint models. 2: joints that couple the ends of their
// arms, length of an arm. 3: outputs of constraints. 4: quantities of motion and temperature. 5: joints that are
// compliant hubs, springs of their arms. 6: memory of joints. 7: laws of rods. 8: memory of rods, energies, areas.
#define WIRELOOM_ABI_MINOR 8

// Success.
#define WIRELOOM_STATUS_OK 0

// Failure; the message gives the reason.
#define WIRELOOM_STATUS_ERROR 1

// The plugin panicked; the message gives the reason.
#define WIRELOOM_STATUS_PANIC 2

// `Kind::family`: a constraint.
#define WIRELOOM_FAMILY_CONSTRAINT 1

// `Kind::family`: a joint model.
#define WIRELOOM_FAMILY_JOINT 2

// `Kind::family`: the constitutive laws of a rod. Since ABI 1.7.
#define WIRELOOM_FAMILY_ROD 3

// `Parameter::form`: one number.
#define WIRELOOM_FORM_NUMBER 1

// `Parameter::form`: three numbers.
#define WIRELOOM_FORM_VECTOR 2

// `Parameter::form`: a whole number.
#define WIRELOOM_FORM_COUNT 3

// `Parameter::form`: true (1) or false (0).
#define WIRELOOM_FORM_FLAG 4

// `Parameter::form`: the index of one of the `choices`.
#define WIRELOOM_FORM_CHOICE 5

// `Parameter::presence`: the key is required.
#define WIRELOOM_PRESENCE_REQUIRED 0

// `Parameter::presence`: the key is optional and has no default.
#define WIRELOOM_PRESENCE_OPTIONAL 1

// `Parameter::presence`: the key is optional; its default is `default_value`.
#define WIRELOOM_PRESENCE_DEFAULT 2

// `Parameter::quantity`: dimensionless.
#define WIRELOOM_QUANTITY_DIMENSIONLESS 0

// `Parameter::quantity`: in m.
#define WIRELOOM_QUANTITY_LENGTH 1

// `Parameter::quantity`: in kg.
#define WIRELOOM_QUANTITY_MASS 2

// `Parameter::quantity`: in kg/m.
#define WIRELOOM_QUANTITY_LINEAR_DENSITY 3

// `Parameter::quantity`: in N.
#define WIRELOOM_QUANTITY_FORCE 4

// `Parameter::quantity`: in N m.
#define WIRELOOM_QUANTITY_MOMENT 5

// `Parameter::quantity`: in N/m.
#define WIRELOOM_QUANTITY_FORCE_PER_LENGTH 6

// `Parameter::quantity`: in N m/rad.
#define WIRELOOM_QUANTITY_MOMENT_PER_ANGLE 7

// `Parameter::quantity`: in N m².
#define WIRELOOM_QUANTITY_BENDING_STIFFNESS 8

// `Parameter::quantity`: in 1/m.
#define WIRELOOM_QUANTITY_CURVATURE 9

// `Parameter::quantity`: in rad.
#define WIRELOOM_QUANTITY_ANGLE 10

// `Parameter::quantity`: in m/s².
#define WIRELOOM_QUANTITY_ACCELERATION 11

// `Parameter::quantity`: in Pa.
#define WIRELOOM_QUANTITY_PRESSURE 12

// `Parameter::quantity`: in kg/m³.
#define WIRELOOM_QUANTITY_DENSITY 13

// `Parameter::quantity`: in m/s.
#define WIRELOOM_QUANTITY_VELOCITY 14

// `Parameter::quantity`: in K.
#define WIRELOOM_QUANTITY_TEMPERATURE 15

// `Parameter::quantity`: in 1/K.
#define WIRELOOM_QUANTITY_THERMAL_EXPANSION 16

// `Parameter::quantity`: in 1/(m K).
#define WIRELOOM_QUANTITY_THERMAL_CURVATURE 17

// `Parameter::quantity`: in rad/s.
#define WIRELOOM_QUANTITY_ANGULAR_SPEED 18

// `Parameter::quantity`: in s.
#define WIRELOOM_QUANTITY_TIME 19

// `Parameter::quantity`: in J. Since ABI 1.8.
#define WIRELOOM_QUANTITY_ENERGY 20

// `Parameter::quantity`: in m². Since ABI 1.8.
#define WIRELOOM_QUANTITY_AREA 21

// `Description::shape`: some of the six degrees of freedom of the only station are prescribed.
#define WIRELOOM_SHAPE_PRESCRIBED 1

// `Description::shape`: an energy.
#define WIRELOOM_SHAPE_POTENTIAL 2

// `Description::shape`: equations `c = 0` and inequalities `c ≤ 0`, which the program enforces.
#define WIRELOOM_SHAPE_EQUATIONS 3

// `Description::shape`: an energy, and equations and inequalities beside it. Since ABI 1.7.
#define WIRELOOM_SHAPE_POTENTIAL_AND_EQUATIONS 4

// `Hold::rotation`: all rotations are free.
#define WIRELOOM_ROTATION_FREE 0

// `Hold::rotation`: d3 is prescribed; rotation about it is free.
#define WIRELOOM_ROTATION_TANGENT 1

// `Hold::rotation`: rotation about d3 is prevented; d3 is free.
#define WIRELOOM_ROTATION_TWIST 2

// `Hold::rotation`: all rotations are prescribed.
#define WIRELOOM_ROTATION_ALL 3

// `Hold::rotation`: only rotation about `axis` is free.
#define WIRELOOM_ROTATION_HINGE 4

// `ConstraintSpec::hold`: the point.
#define WIRELOOM_HOLD_POSITION 1

// `ConstraintSpec::hold`: d3.
#define WIRELOOM_HOLD_TANGENT 2

// `ConstraintSpec::hold`: rotation about d3.
#define WIRELOOM_HOLD_TWIST 4

// `JointDescription::mounting`: the arms share one point, and an energy couples the frames of their segments there.
#define WIRELOOM_MOUNTING_POINT 1

// `JointDescription::mounting`: a hub with a pose, which carries the ends of its arms rigidly; no energy.
#define WIRELOOM_MOUNTING_POSE 2

// `JointDescription::mounting`: the arms share one point; the energy couples the frames that their ends have there.
#define WIRELOOM_MOUNTING_STATIONS 3

// `JointDescription::mounting`: a hub with a pose, to which the end points of its arms are fixed; the energy couples
// the frames that the ends have there and, behind them, the frame of the hub.
#define WIRELOOM_MOUNTING_COMPLIANT_HUB 4

// Buffer for a message of the plugin: at most `capacity` bytes, including the terminating zero.
typedef struct WireloomText {
    // The first byte.
    char *data;
    // Size of the buffer, bytes.
    size_t capacity;
} WireloomText;

// A declared parameter of a kind: a key of scenario files.
typedef struct WireloomParameter {
    // Key in the scenario.
    const char *name;
    // One-line description.
    const char *doc;
    // `FORM_…`.
    int32_t form;
    // `QUANTITY_…`, for numbers and vectors.
    int32_t quantity;
    // `PRESENCE_…`.
    int32_t presence;
    // Whether a number must be strictly greater than `minimum` (0 or 1).
    int32_t minimum_excluded;
    // Smallest value of a number or count.
    double minimum;
    // Largest value of a number; `INFINITY` for no limit.
    double maximum;
    // Default value; in the first entry, except for vectors.
    double default_value[3];
    // The choices, as texts.
    const char *const *choices;
    // Number of choices.
    uint32_t choice_count;
    // Zero.
    uint32_t reserved;
} WireloomParameter;

// A station that a constraint acts on.
typedef struct WireloomStation {
    // Name of its branch; null if the station is a joint.
    const char *branch;
    // Arc length, m.
    double arc_length;
    // Diameter of the cable, m.
    double diameter;
} WireloomStation;

// Part of a branch that a constraint acts along.
typedef struct WireloomSpan {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Its branch.
    const char *branch;
    // Arc length of its beginning, m.
    double begins;
    // Arc length of its end, m.
    double ends;
    // Diameter of the cable, m.
    double diameter;
} WireloomSpan;

// The value of a parameter, checked against its declaration.
typedef struct WireloomValue {
    // The number, vector, count, flag or index of the choice; in the first entry, except for vectors.
    double value[3];
    // Whether the value is given (0 or 1).
    int32_t given;
    // Zero.
    uint32_t reserved;
} WireloomValue;

// A constraint as the scenario specifies it.
typedef struct WireloomConstraintSpec {
    // Size of this struct, bytes.
    uint32_t size;
    // Number of stations.
    uint32_t station_count;
    // Size of a `Station`, bytes.
    uint32_t station_stride;
    // Number of values: as many as the kind has parameters.
    uint32_t value_count;
    // Name in the scenario.
    const char *name;
    // The stations.
    const struct WireloomStation *stations;
    // The span; null if the scenario gives none.
    const struct WireloomSpan *span;
    // The values, in the order of the kind's parameters; each has the size of `Value`.
    const struct WireloomValue *values;
    // Whether the scenario gives a tangent (0 or 1).
    int32_t tangent_given;
    // Whether the scenario gives the direction of d1, or a whole orientation (0 or 1).
    int32_t up_given;
    // Degrees of freedom that the scenario lists, a sum of `HOLD_…`; 0 if it lists none.
    int32_t hold;
    // Whether `free_axis` is given (0 or 1).
    int32_t free_axis_given;
    // Unit vector, world: the only axis about which rotation is free.
    double free_axis[3];
    // World directions along which the held point may move.
    double rails[2][3];
    // Number of rails.
    uint32_t rail_count;
    // Zero.
    uint32_t reserved;
} WireloomConstraintSpec;

// Degrees of freedom of a station that are prescribed.
typedef struct WireloomHold {
    // Whether the position is prescribed (0 or 1).
    int32_t position;
    // `ROTATION_…`.
    int32_t rotation;
    // World axis of a hinge, unit vector.
    double axis[3];
    // World directions, orthonormal, along which the held point may still move.
    double rails[2][3];
    // Number of rails.
    uint32_t rail_count;
    // Zero.
    uint32_t reserved;
} WireloomHold;

// Description of an instance. Written by `create`.
typedef struct WireloomDescription {
    // Size of this struct, bytes, as the program knows it.
    uint32_t size;
    // `SHAPE_…`.
    int32_t shape;
    // Whether its stations need frames, because it exerts moments or depends on orientations (0 or 1). If prescribed,
    // this follows from `hold`.
    int32_t needs_frames;
    // Whether energy or residuals are invariant under a rigid motion of stations and targets together (0 or 1).
    int32_t objective;
    // Whether one instance may be evaluated from several threads concurrently (0 or 1).
    int32_t thread_safe;
    // Whether `evaluate` writes gradients (Jacobians). If not, the program differentiates numerically and reports it.
    int32_t has_gradient;
    // Whether `evaluate` writes Hessians. If not, the program differentiates numerically and reports it.
    int32_t has_hessian;
    // Number of values remembered from increment to increment. The program stores them: it may repeat an increment, or
    // resume later.
    uint32_t memory_count;
    // Initial values of the memory; live until `destroy`.
    const double *memory;
    // Number of residuals of the stations, if there are equations.
    uint32_t residual_count;
    // Number of residuals of each node of the span; the same for every node.
    uint32_t node_residual_count;
    // For each residual of the stations, then for each of a node: inequality (1) or equation (0). Lives until
    // `destroy`. Null: all are equations.
    const int32_t *inequalities;
    // Scale of each residual: 1 for metres or radians. Lives until `destroy`. Null: 1.
    const double *scales;
    // Prescribed freedoms, for `SHAPE_PRESCRIBED`.
    struct WireloomHold hold;
} WireloomDescription;

// Position and orientation.
typedef struct WireloomPose {
    // Position, m, world.
    double position[3];
    // Unit quaternion `w, x, y, z`; its columns are d1, d2, d3; d3 is the tangent.
    double orientation[4];
} WireloomPose;

// Current state of the stations, the span and the memory.
typedef struct WireloomSituation {
    // Size of this struct, bytes.
    uint32_t size;
    // Number of stations.
    uint32_t station_count;
    // Number of nodes of the span.
    uint32_t span_count;
    // Number of values in the memory.
    uint32_t memory_count;
    // Poses of the stations. Orientations are valid only if frames are needed.
    const struct WireloomPose *stations;
    // Target poses of the stations.
    const struct WireloomPose *targets;
    // Positions of the nodes of the span, m, three numbers each.
    const double *span;
    // Rest length assigned to each node of the span, m.
    const double *span_lengths;
    // Values of the memory.
    const double *memory;
    // Progress of the step, 0 to 1.
    double progress;
} WireloomSituation;

// Outputs; null outputs are not requested. With `m` stations, `k` nodes in the span, `r` residuals of the stations and
// `p` of each node. A station has six variables: `x`, then θ. A node has three: `x`.
typedef struct WireloomEvaluation {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Energy, J: one number.
    double *energy;
    // Derivative of the energy with respect to the stations' variables, N and N m: `6 m` numbers. It is minus the
    // force and moment on the harness.
    double *gradient;
    // Derivative of the energy with respect to the nodes, N: `3 k` numbers.
    double *span_gradient;
    // Second derivative of the energy with respect to the stations' variables: `6 m × 6 m` numbers, symmetric. Of
    // equations, which is asked for where `weights` are given: Σ w c″.
    double *hessian;
    // Second derivative of the energy with respect to each node; nodes are not coupled: `k` times `3 × 3` numbers. Of
    // equations: Σ w c″.
    double *span_hessian;
    // Residuals: `r` of the stations, then `p` of each node; satisfied if 0 (equations) or ≤ 0 (inequalities).
    double *residuals;
    // Derivatives of the stations' residuals: `r × 6 m` numbers.
    double *jacobian;
    // Derivatives of the nodes' residuals, each with respect to its own node: `k` times `p × 3` numbers.
    double *span_jacobian;
    // Weights w, one per residual; given if a Hessian of equations is requested.
    const double *weights;
} WireloomEvaluation;

// A declared output of a constraint kind: a quantity that results report at each equilibrium, and that can be a column
// of a sweep. Since ABI 1.3.
typedef struct WireloomOutput {
    // Name in results: letters, digits, hyphens and underscores.
    const char *name;
    // One-line description.
    const char *doc;
    // `QUANTITY_…`, in SI units.
    int32_t quantity;
    // Zero.
    uint32_t reserved;
} WireloomOutput;

// Functions of a constraint kind.
//
// Threads: `create` and `destroy` may be called from any thread, for different instances concurrently. All other
// functions receive the instance as `const`; they are called concurrently for one instance only if its `Description`
// sets `thread_safe`.
typedef struct WireloomConstraintKind {
    // Size of this struct, bytes.
    uint32_t size;
    // Smallest number of stations.
    uint32_t stations_min;
    // Largest number of stations.
    uint32_t stations_max;
    // Whether it uses a span of nodes: 0 never, 1 if one is given, 2 always.
    uint32_t span;
    // Creates an instance and describes it. `description` comes with its size set and all else zero.
    int32_t (*create)(const struct WireloomKind *kind,
                      const struct WireloomConstraintSpec *spec,
                      void **instance,
                      struct WireloomDescription *description,
                      struct WireloomText *message);
    // Destroys an instance.
    void (*destroy)(void *instance);
    // Values and derivatives. May be null only if all instances are prescribed.
    int32_t (*evaluate)(const void *instance,
                        const struct WireloomSituation *situation,
                        struct WireloomEvaluation *evaluation,
                        struct WireloomText *message);
    // Target of one station: from the scenario's target now (`base`) to the target at `progress` of the step. Null:
    // the target does not move.
    int32_t (*target)(const void *instance,
                      const struct WireloomPose *base,
                      double progress,
                      struct WireloomPose *target,
                      struct WireloomText *message);
    // Called once when an increment has converged: updates `memory` (`Description::memory_count` numbers, initially
    // those of `situation`). Null: the memory does not change.
    int32_t (*commit)(const void *instance,
                      const struct WireloomSituation *situation,
                      double *memory,
                      struct WireloomText *message);
    // Number of outputs. Since ABI 1.3.
    uint32_t output_count;
    // Size of an `Output`, bytes.
    uint32_t output_stride;
    // The first output.
    const struct WireloomOutput *outputs;
    // Writes the `values` of all outputs, in their order, at an equilibrium, before `commit`. May be null only if
    // there are no outputs.
    int32_t (*report)(const void *instance,
                      const struct WireloomSituation *situation,
                      double *values,
                      struct WireloomText *message);
} WireloomConstraintKind;

// One arm of a joint.
typedef struct WireloomArm {
    // Name of its branch.
    const char *branch;
    // Whether the branch starts here: its d3 then points away from the joint (0 or 1).
    int32_t starts_here;
    // Zero.
    uint32_t reserved;
    // Rest frame of the branch (d3 from its start to its end) at the joint, in the joint's frame: `w, x, y, z`.
    double rest[4];
    // Position of the arm's end, in the joint's frame, m.
    double offset[3];
    // Rest curvature of its branch about d1, d2, d3, 1/m.
    double curvature[3];
    // Rest length of its segment at the joint, m.
    double segment_length;
    // Diameter, m.
    double diameter;
    // Linear density, kg/m.
    double linear_density;
    // EA, N.
    double axial_stiffness;
    // GA along d1 and d2, N.
    double shear_stiffness[2];
    // EI about d1 and d2, N m².
    double bending_stiffness[2];
    // GJ, N m².
    double torsion_stiffness;
    // Unstressed length of its branch, m.
    double length;
    // Stiffness of the spring that holds it to a compliant hub, about d1 and d2, N m/rad; 0: not given.
    double spring_bending[2];
    // Likewise about d3.
    double spring_torsion;
} WireloomArm;

// Fraction of the wires of one arm that continues in another.
typedef struct WireloomWireShare {
    // Index of the first arm.
    uint32_t from;
    // Index of the second arm.
    uint32_t to;
    // Fraction of the wires of the first arm, 0 to 1.
    double share;
} WireloomWireShare;

// A joint as the scenario specifies it.
typedef struct WireloomJointSpec {
    // Size of this struct, bytes.
    uint32_t size;
    // Number of arms, at least two.
    uint32_t arm_count;
    // Size of an `Arm`, bytes.
    uint32_t arm_stride;
    // Number of wire shares; 0 if the scenario has no wire table.
    uint32_t wire_count;
    // Name in the scenario.
    const char *name;
    // The arms.
    const struct WireloomArm *arms;
    // The wire shares; each has the size of `WireShare`.
    const struct WireloomWireShare *wires;
    // The values, in the order of the kind's parameters; each has the size of `Value`.
    const struct WireloomValue *values;
    // Number of values: as many as the kind has parameters.
    uint32_t value_count;
    // Zero.
    uint32_t reserved;
} WireloomJointSpec;

// Description of an instance of a joint model. Written by `create`.
typedef struct WireloomJointDescription {
    // Size of this struct, bytes, as the program knows it.
    uint32_t size;
    // `MOUNTING_…`.
    int32_t mounting;
    // Whether one instance may be evaluated from several threads concurrently (0 or 1).
    int32_t thread_safe;
    // Whether `evaluate` writes gradients. If not, the program differentiates numerically and reports it.
    int32_t has_gradient;
    // Whether `evaluate` writes Hessians. If not, the program differentiates numerically and reports it.
    int32_t has_hessian;
    // Zero.
    uint32_t reserved;
    // Initial values of the memory, those at rest; live until `destroy`. Since ABI 1.6.
    const double *memory;
    // Number of values in the memory.
    uint32_t memory_count;
    // Zero.
    uint32_t reserved_too;
} WireloomJointDescription;

// Outputs for a joint of `k` frames: those of its arms, and of a compliant hub; null outputs are not requested. The
// energy is nonnegative, 0 at the rest directions, and invariant under a common rotation of all frames.
typedef struct WireloomJointEvaluation {
    // Size of this struct, bytes.
    uint32_t size;
    // Number of frames k.
    uint32_t arm_count;
    // Energy, J: one number.
    double *energy;
    // Derivative of the energy with respect to θ of each frame, N m: `3 k` numbers.
    double *gradient;
    // Second derivative: `3 k × 3 k` numbers, symmetric.
    double *hessian;
    // Values of the memory, which the energy may depend on. Since ABI 1.6.
    const double *memory;
} WireloomJointEvaluation;

// Functions of a joint model. Threads: as for `ConstraintKind`.
typedef struct WireloomJointKind {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Creates an instance and describes it. `description` comes with its size set and all else zero.
    int32_t (*create)(const struct WireloomKind *kind,
                      const struct WireloomJointSpec *spec,
                      void **instance,
                      struct WireloomJointDescription *description,
                      struct WireloomText *message);
    // Destroys an instance.
    void (*destroy)(void *instance);
    // Energy and derivatives for frames of the arms: `w, x, y, z` of each, in the order of the arms; that of a
    // compliant hub is the last. May be null only if all instances are rigid hubs.
    int32_t (*evaluate)(const void *instance,
                        const double *frames,
                        struct WireloomJointEvaluation *evaluation,
                        struct WireloomText *message);
    // Called once when an increment has converged, with the frames at its end, as many as `evaluate` gets: updates
    // `memory` (`JointDescription::memory_count` numbers, initially those at the start of the increment), so that the
    // derivatives stay those that they were, and a second call changes no bit. Null: the memory does not change. Since
    // ABI 1.6.
    int32_t (*commit)(const void *instance, const double *frames, double *memory, struct WireloomText *message);
} WireloomJointKind;

// A branch as the scenario specifies it.
typedef struct WireloomRodSpec {
    // Size of this struct, bytes.
    uint32_t size;
    // Number of values: as many as the kind has parameters.
    uint32_t value_count;
    // Name of the branch.
    const char *name;
    // The values, in the order of the kind's parameters; each has the size of `Value`.
    const struct WireloomValue *values;
    // Unstressed length, m.
    double length;
    // Rest curvature about d1, d2, d3, 1/m. The curvatures that the law gets are those beyond it.
    double curvature[3];
    // Diameter, m.
    double diameter;
    // Linear density, kg/m.
    double linear_density;
    // EA, N.
    double axial_stiffness;
    // GA along d1 and d2, N.
    double shear_stiffness[2];
    // EI about d1 and d2, N m².
    double bending_stiffness[2];
    // GJ, N m².
    double torsion_stiffness;
} WireloomRodSpec;

// Description of an instance of a rod. Written by `create`.
typedef struct WireloomRodDescription {
    // Size of this struct, bytes, as the program knows it.
    uint32_t size;
    // Whether it has a law of stretch and shear (0 or 1). If not, EA and GA of the section hold.
    int32_t has_stretch;
    // Whether it has a law of bending and twist (0 or 1). If not, EI and GJ of the section hold.
    int32_t has_bend;
    // Whether its laws write Hessians. If not, the program differentiates numerically and reports it.
    int32_t has_hessian;
    // Whether one instance may be evaluated from several threads concurrently (0 or 1).
    int32_t thread_safe;
    // Number of state variables of each coupling, at most 1000. Since ABI 1.8.
    uint32_t memory_count;
} WireloomRodDescription;

// Outputs of a law for `n` strains; null outputs are not requested.
typedef struct WireloomRodResponse {
    // Size of this struct, bytes.
    uint32_t size;
    // Number of strains n.
    uint32_t count;
    // Energy per length at each strain, J/m: `n` numbers.
    double *energy;
    // Its derivative: forces (N) or moments (N m), `3 n` numbers.
    double *gradient;
    // Its second derivative (N or N m²): `n` times `3 × 3` numbers, each symmetric.
    double *hessian;
    // Memory at the start of the increment, if there is any: `n` times `memory_count` numbers. Since ABI 1.8.
    const double *memory;
    // Time that the increment takes, s. Since ABI 1.8.
    double duration;
} WireloomRodResponse;

// What `n` couplings remember, for `commit`.
typedef struct WireloomRodCommit {
    // Size of this struct, bytes.
    uint32_t size;
    // Number of couplings n.
    uint32_t count;
    // `n` times `memory_count` numbers: on entry those at the start of the increment, on return those at its end.
    double *memory;
    // Energy per length dissipated in the increment, J/m, never negative: `n` numbers, 0 on entry.
    double *dissipated;
    // Time that the increment took, s.
    double duration;
} WireloomRodCommit;

// Functions of a rod: the constitutive laws of a branch. The program does the kinematics: positions and frames,
// temperature, rest shape, derivatives along all of these. The energy of a branch is
//
// `E = sum over its segments of l W(gamma) + sum over its couplings of lambda V(kappa)`
//
// with the strain gamma of a segment (shear along d1 and d2, then stretch; dimensionless, without what temperature
// does) and the curvature kappa of a coupling beyond that at rest (bending about d1 and d2, then twist; 1/m). W and V
// are energies per length, J/m. They are 0, with derivatives 0, at the strain 0, and never negative; a change of sign
// of the first component changes nothing (a branch that is run from its other end has such strains); W is convex.
// Their second derivatives at 0 should be near the stiffnesses that the section states. The law of bending and twist
// may remember, all 0 at first: V is then the energy of an increment for the memory at its start, stored at its end or
// dissipated on the way; `commit` alone changes it, after convergence (since ABI 1.8). Threads: as for
// `ConstraintKind`. Since ABI 1.7.
typedef struct WireloomRodKind {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Creates an instance, for one branch, and describes it. `description` comes with its size set and all else zero.
    int32_t (*create)(const struct WireloomKind *kind,
                      const struct WireloomRodSpec *spec,
                      void **instance,
                      struct WireloomRodDescription *description,
                      struct WireloomText *message);
    // Destroys an instance.
    void (*destroy)(void *instance);
    // The law W of stretch and shear, for the strains of all segments of the branch in one call: `response.count`
    // times three numbers, all finite. May be null only if no instance has `has_stretch`.
    int32_t (*stretch)(const void *instance,
                       const double *strains,
                       struct WireloomRodResponse *response,
                       struct WireloomText *message);
    // Likewise the law V of bending and twist, for the curvatures of all couplings, 1/m. May be null only if no
    // instance has `has_bend`.
    int32_t (*bend)(const void *instance,
                    const double *strains,
                    struct WireloomRodResponse *response,
                    struct WireloomText *message);
    // Updates the memory to the curvatures that end an increment, as `bend` gets them: with it and no duration `bend`
    // gives the same moments, and a second call changes nothing. Null only without `memory_count`. Since ABI 1.8.
    int32_t (*commit)(const void *instance,
                      const double *strains,
                      struct WireloomRodCommit *committed,
                      struct WireloomText *message);
} WireloomRodKind;

// A kind that scenarios can use.
typedef struct WireloomKind {
    // `FAMILY_…`.
    int32_t family;
    // Number of parameters.
    uint32_t parameter_count;
    // Size of a `Parameter`, bytes.
    uint32_t parameter_stride;
    // Zero.
    uint32_t reserved;
    // Name in scenarios.
    const char *name;
    // One-line description.
    const char *doc;
    // The first parameter.
    const struct WireloomParameter *parameters;
    // Its functions, if it is a constraint.
    const struct WireloomConstraintKind *constraint;
    // Its functions, if it is a joint model.
    const struct WireloomJointKind *joint;
    // Its functions, if it is a rod. Since ABI 1.7.
    const struct WireloomRodKind *rod;
} WireloomKind;

// All kinds of a plugin. Lives, with all it points to, as long as the library.
typedef struct WireloomKinds {
    // Size of this struct, bytes.
    uint32_t size;
    // Number of kinds.
    uint32_t count;
    // Size of a `Kind`, bytes.
    uint32_t stride;
    // Zero.
    uint32_t reserved;
    // The first kind.
    const struct WireloomKind *first;
} WireloomKinds;

// The exported symbol `wireloom_plugin`.
typedef struct WireloomEntry {
    // `MAGIC`.
    uint64_t magic;
    // Size of this struct, bytes.
    uint32_t size;
    // `ABI_MAJOR` that the plugin was built with.
    uint32_t abi_major;
    // `ABI_MINOR` that the plugin was built with.
    uint32_t abi_minor;
    // Zero.
    uint32_t reserved;
    // Name of the plugin: letters, digits and hyphens.
    const char *name;
    // Version of the plugin, such as `1.0.2`.
    const char *version;
    // One-line description.
    const char *doc;
    // Lists the kinds; called once, before any instance is created. Returns null and writes a message on failure.
    const struct WireloomKinds *(*kinds)(struct WireloomText *message);
    // Extension of an id, such as those of `draft`; returns null for unknown ids. May itself be null.
    const void *(*get_extension)(const char *id);
} WireloomEntry;

// Notes for the engineer on an instance: for example, that a strap is slack when it is added.
typedef struct WireloomNotes {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Writes note number `index`, from 0, of an instance of the kind; an error if there is none.
    int32_t (*note)(const char *kind, const void *instance, uint32_t index, struct WireloomText *note);
} WireloomNotes;

#endif  /* WIRELOOM_PLUGIN_H */
