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

// Its functions are given it.
struct WireloomKind;

// First field of every `Entry`: the letters `WIRELOOM`, as a little-endian number.
#define WIRELOOM_MAGIC 5570758453079722327

// Version of this ABI: programs and plugins of different major versions do not fit.
#define WIRELOOM_ABI_MAJOR 1

// Version of this ABI: grows with every addition. 1: joint models. 2: joints that couple the ends of their arms, length of an arm.
#define WIRELOOM_ABI_MINOR 2

// Done.
#define WIRELOOM_STATUS_OK 0

// Not done; the message says why.
#define WIRELOOM_STATUS_ERROR 1

// The plugin panicked; the message says how.
#define WIRELOOM_STATUS_PANIC 2

// `Kind::family`: a constraint.
#define WIRELOOM_FAMILY_CONSTRAINT 1

// `Kind::family`: a joint model.
#define WIRELOOM_FAMILY_JOINT 2

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

// `Parameter::presence`: the key must be given.
#define WIRELOOM_PRESENCE_REQUIRED 0

// `Parameter::presence`: the key may be left out, and then has no value.
#define WIRELOOM_PRESENCE_OPTIONAL 1

// `Parameter::presence`: the key may be left out, and then has the `default_value`.
#define WIRELOOM_PRESENCE_DEFAULT 2

// `Parameter::quantity`: a pure number.
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

// `Description::shape`: some of the six freedoms of the only station are given.
#define WIRELOOM_SHAPE_PRESCRIBED 1

// `Description::shape`: an energy.
#define WIRELOOM_SHAPE_POTENTIAL 2

// `Description::shape`: equations `c = 0` and inequalities `c ≤ 0`, which the program enforces.
#define WIRELOOM_SHAPE_EQUATIONS 3

// `Hold::rotation`: all rotations are free.
#define WIRELOOM_ROTATION_FREE 0

// `Hold::rotation`: d3 is given, turning about it is free.
#define WIRELOOM_ROTATION_TANGENT 1

// `Hold::rotation`: turning about d3 is not possible, d3 is free.
#define WIRELOOM_ROTATION_TWIST 2

// `Hold::rotation`: all rotations are given.
#define WIRELOOM_ROTATION_ALL 3

// `Hold::rotation`: only turning about `axis` is free.
#define WIRELOOM_ROTATION_HINGE 4

// `ConstraintSpec::hold`: the point.
#define WIRELOOM_HOLD_POSITION 1

// `ConstraintSpec::hold`: d3.
#define WIRELOOM_HOLD_TANGENT 2

// `ConstraintSpec::hold`: turning about d3.
#define WIRELOOM_HOLD_TWIST 4

// `JointDescription::mounting`: the arms share one point, and an energy couples the frames of their segments there.
#define WIRELOOM_MOUNTING_POINT 1

// `JointDescription::mounting`: the joint is a hub with a pose that carries the ends of its arms rigidly; it has no energy.
#define WIRELOOM_MOUNTING_POSE 2

// `JointDescription::mounting`: the arms share one point; the energy couples the frames that their ends have there.
#define WIRELOOM_MOUNTING_STATIONS 3

// Where a plugin writes words: at most `capacity` bytes, the zero at the end among them.
typedef struct WireloomText {
    // The first byte.
    char *data;
    // Bytes that there is room for.
    size_t capacity;
} WireloomText;

// A declared parameter of a kind: a key of scenario files.
typedef struct WireloomParameter {
    // Key in the scenario.
    const char *name;
    // One line: what it is for.
    const char *doc;
    // `FORM_…`.
    int32_t form;
    // `QUANTITY_…`, for numbers and vectors.
    int32_t quantity;
    // `PRESENCE_…`.
    int32_t presence;
    // Whether a number must be greater than `minimum`, not only as great (0 or 1).
    int32_t minimum_excluded;
    // Least value of a number or count.
    double minimum;
    // Greatest value of a number; `INFINITY` for none.
    double maximum;
    // Value where the key is left out; in the first entry but for vectors.
    double default_value[3];
    // The words of a choice.
    const char *const *choices;
    // How many words.
    uint32_t choice_count;
    // Zero.
    uint32_t reserved;
} WireloomParameter;

// A place that a constraint acts on.
typedef struct WireloomStation {
    // Its branch; null: it is a joint.
    const char *branch;
    // Arc length, m.
    double arc_length;
    // Diameter of the cable, m.
    double diameter;
} WireloomStation;

// A stretch of a branch that a constraint acts along.
typedef struct WireloomSpan {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Its branch.
    const char *branch;
    // Arc length where it begins, m.
    double begins;
    // Arc length where it ends, m.
    double ends;
    // Diameter of the cable, m.
    double diameter;
} WireloomSpan;

// The value of a parameter, checked against its declaration.
typedef struct WireloomValue {
    // The number, vector, count, flag or index of the choice; in the first entry but for vectors.
    double value[3];
    // Whether there is one (0 or 1).
    int32_t given;
    // Zero.
    uint32_t reserved;
} WireloomValue;

// What the scenario says of a constraint.
typedef struct WireloomConstraintSpec {
    // Size of this struct, bytes.
    uint32_t size;
    // Stations it acts on.
    uint32_t station_count;
    // Size of a `Station`, bytes.
    uint32_t station_stride;
    // Values, as many as the kind has parameters.
    uint32_t value_count;
    // Name in the scenario.
    const char *name;
    // The stations.
    const struct WireloomStation *stations;
    // The span it acts along; null where the scenario gives none.
    const struct WireloomSpan *span;
    // The values, in the order of the kind's parameters; each has `Value`'s size.
    const struct WireloomValue *values;
    // Whether the scenario gives a tangent (0 or 1).
    int32_t tangent_given;
    // Whether the scenario gives the direction of d1, or a whole orientation (0 or 1).
    int32_t up_given;
    // The freedoms that the scenario spells out, a sum of `HOLD_…`; 0: it does not.
    int32_t hold;
    // Whether there is a `free_axis` (0 or 1).
    int32_t free_axis_given;
    // World axis about which alone turning is free; of length one.
    double free_axis[3];
    // World directions along which the held point may move.
    double rails[2][3];
    // How many.
    uint32_t rail_count;
    // Zero.
    uint32_t reserved;
} WireloomConstraintSpec;

// Which freedoms of a station are given.
typedef struct WireloomHold {
    // Whether the position is given (0 or 1).
    int32_t position;
    // `ROTATION_…`.
    int32_t rotation;
    // World axis of a hinge, of length one.
    double axis[3];
    // World directions, orthonormal, along which the held point may move all the same.
    double rails[2][3];
    // How many.
    uint32_t rail_count;
    // Zero.
    uint32_t reserved;
} WireloomHold;

// What an instance is. Written by `create`.
typedef struct WireloomDescription {
    // Size of this struct, bytes, as the program knows it.
    uint32_t size;
    // `SHAPE_…`.
    int32_t shape;
    // Whether its stations need frames: it exerts moments, or looks at orientations (0 or 1). Prescribed: follows from `hold`.
    int32_t needs_frames;
    // Whether energy or residuals stay the same when stations and targets undergo the same rigid motion (0 or 1).
    int32_t objective;
    // Whether one instance may be evaluated from several threads at a time (0 or 1).
    int32_t thread_safe;
    // Whether `evaluate` writes gradients (Jacobians). If not, the program differentiates numerically, and says so.
    int32_t has_gradient;
    // Whether `evaluate` writes Hessians. If not, the program differentiates numerically, and says so.
    int32_t has_hessian;
    // Numbers it remembers from increment to increment. The program keeps them: it may take an increment back, or go on another day.
    uint32_t memory_count;
    // What they are at first; lives until `destroy`.
    const double *memory;
    // Residuals of the stations, where it is `SHAPE_EQUATIONS`.
    uint32_t residual_count;
    // Residuals of each node of the span; every node has the same.
    uint32_t node_residual_count;
    // For each residual of the stations, then each of a node, whether it is an inequality (1) or an equation (0); lives until `destroy`. Null: all
    // are equations.
    const int32_t *inequalities;
    // For each of them, what counts as one: 1 for metres or radians. Lives until `destroy`. Null: 1.
    const double *scales;
    // What it prescribes, where it is `SHAPE_PRESCRIBED`.
    struct WireloomHold hold;
} WireloomDescription;

// Position and orientation.
typedef struct WireloomPose {
    // Position, m, world.
    double position[3];
    // Unit quaternion `w, x, y, z`; its columns are d1, d2, d3; d3 is the tangent.
    double orientation[4];
} WireloomPose;

// Where the harness is.
typedef struct WireloomSituation {
    // Size of this struct, bytes.
    uint32_t size;
    // Stations.
    uint32_t station_count;
    // Nodes of the span.
    uint32_t span_count;
    // Numbers remembered.
    uint32_t memory_count;
    // Poses of the stations. Orientations mean something only where frames are needed.
    const struct WireloomPose *stations;
    // Where the scenario wants the stations.
    const struct WireloomPose *targets;
    // Positions of the nodes of the span, m, three numbers each.
    const double *span;
    // Rest length that each node of the span carries, m.
    const double *span_lengths;
    // What is remembered.
    const double *memory;
    // How far the step has come, 0 to 1.
    double progress;
} WireloomSituation;

// Where the values go: what is null is not asked for. Of `m` stations, `k` nodes in the span, `r` residuals of the stations and `p` of each node.
// A station has six variables: `x`, then θ. A node has three: `x`.
typedef struct WireloomEvaluation {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Energy, J: one number.
    double *energy;
    // Derivative of the energy by the stations' variables, N and N m: `6 m` numbers. What pulls the harness along +x is a derivative along −x.
    double *gradient;
    // Derivative of the energy by the nodes, N: `3 k` numbers.
    double *span_gradient;
    // Second derivative of the energy by the stations' variables: `6 m × 6 m` numbers, symmetric. Of equations: Σ w c″.
    double *hessian;
    // Second derivative of the energy by each node, which do not couple: `k` times `3 × 3` numbers. Of equations: Σ w c″.
    double *span_hessian;
    // Residuals: `r` of the stations, then `p` of each node; met where they are 0 (equations) or not above 0 (inequalities).
    double *residuals;
    // Derivatives of the stations' residuals: `r × 6 m` numbers.
    double *jacobian;
    // Derivatives of the nodes' residuals, each by its own node: `k` times `p × 3` numbers.
    double *span_jacobian;
    // w, one for each residual; given where a Hessian of equations is asked for.
    const double *weights;
} WireloomEvaluation;

// The functions of a constraint kind.
//
// Threads: `create` and `destroy` may be called from any thread, for different instances at a time. All other functions get an instance as
// `const`; the same one from several threads at a time only if the `Description` says `thread_safe`.
typedef struct WireloomConstraintKind {
    // Size of this struct, bytes.
    uint32_t size;
    // Least number of stations it acts on.
    uint32_t stations_min;
    // Greatest number of stations it acts on.
    uint32_t stations_max;
    // Whether it acts on a span of nodes: 0 never, 1 where one is given, 2 always.
    uint32_t span;
    // Makes an instance and describes it. `description` comes with its size and zeroes.
    int32_t (*create)(const struct WireloomKind *kind,
                      const struct WireloomConstraintSpec *spec,
                      void **instance,
                      struct WireloomDescription *description,
                      struct WireloomText *message);
    // Frees an instance.
    void (*destroy)(void *instance);
    // Values and derivatives. Left out only where all instances are prescribed.
    int32_t (*evaluate)(const void *instance,
                        const struct WireloomSituation *situation,
                        struct WireloomEvaluation *evaluation,
                        struct WireloomText *message);
    // Moves the target of one station: from where the scenario has it now (`base`) to where it is, `progress` through the step. Left out: it stays.
    int32_t (*target)(const void *instance,
                      const struct WireloomPose *base,
                      double progress,
                      struct WireloomPose *target,
                      struct WireloomText *message);
    // Called once when an increment has converged: brings `memory` (`Description::memory_count` numbers) from what `situation` has to what
    // holds from now on. Left out: memory stays.
    int32_t (*commit)(const void *instance,
                      const struct WireloomSituation *situation,
                      double *memory,
                      struct WireloomText *message);
} WireloomConstraintKind;

// One arm of a joint.
typedef struct WireloomArm {
    // Its branch.
    const char *branch;
    // Whether the branch starts here: its d3 then points out of the joint (0 or 1).
    int32_t starts_here;
    // Zero.
    uint32_t reserved;
    // Rest frame of the branch (d3 from its start to its end) at the joint, in the joint's frame: `w, x, y, z`.
    double rest[4];
    // Where the arm leaves, in the joint's frame, m.
    double offset[3];
    // Rest curvature of its branch about d1, d2, d3, 1/m.
    double curvature[3];
    // Rest length of its segment at the joint, m.
    double segment_length;
    // Diameter, m.
    double diameter;
    // kg/m.
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
} WireloomArm;

// Which share of the wires of one arm passes to another.
typedef struct WireloomWireShare {
    // Index of the first arm.
    uint32_t from;
    // Index of the second arm.
    uint32_t to;
    // Share of the wires of the first arm, 0 to 1.
    double share;
} WireloomWireShare;

// What the scenario says of a joint.
typedef struct WireloomJointSpec {
    // Size of this struct, bytes.
    uint32_t size;
    // Arms, two at least.
    uint32_t arm_count;
    // Size of an `Arm`, bytes.
    uint32_t arm_stride;
    // Wire shares; none: the scenario has no table of them.
    uint32_t wire_count;
    // Name in the scenario.
    const char *name;
    // The arms.
    const struct WireloomArm *arms;
    // The wire shares; each has `WireShare`'s size.
    const struct WireloomWireShare *wires;
    // The values, in the order of the kind's parameters; each has `Value`'s size.
    const struct WireloomValue *values;
    // Values, as many as the kind has parameters.
    uint32_t value_count;
    // Zero.
    uint32_t reserved;
} WireloomJointSpec;

// What an instance of a joint model is. Written by `create`.
typedef struct WireloomJointDescription {
    // Size of this struct, bytes, as the program knows it.
    uint32_t size;
    // `MOUNTING_…`.
    int32_t mounting;
    // Whether one instance may be evaluated from several threads at a time (0 or 1).
    int32_t thread_safe;
    // Whether `evaluate` writes gradients. If not, the program differentiates numerically, and says so.
    int32_t has_gradient;
    // Whether `evaluate` writes Hessians. If not, the program differentiates numerically, and says so.
    int32_t has_hessian;
    // Zero.
    uint32_t reserved;
} WireloomJointDescription;

// Where the values of a joint of `k` arms go: what is null is not asked for. The energy is 0 or more, 0 at the rest directions, and does not change when
// all frames turn together.
typedef struct WireloomJointEvaluation {
    // Size of this struct, bytes.
    uint32_t size;
    // Arms.
    uint32_t arm_count;
    // Energy, J: one number.
    double *energy;
    // Derivative of the energy by θ of each arm, N m: `3 k` numbers.
    double *gradient;
    // Second derivative: `3 k × 3 k` numbers, symmetric.
    double *hessian;
} WireloomJointEvaluation;

// The functions of a joint model. Threads: as for `ConstraintKind`.
typedef struct WireloomJointKind {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Makes an instance and describes it. `description` comes with its size and zeroes.
    int32_t (*create)(const struct WireloomKind *kind,
                      const struct WireloomJointSpec *spec,
                      void **instance,
                      struct WireloomJointDescription *description,
                      struct WireloomText *message);
    // Frees an instance.
    void (*destroy)(void *instance);
    // Energy and derivatives for frames of the arms: `w, x, y, z` of each, in the order of the arms. Left out only where all instances are hubs.
    int32_t (*evaluate)(const void *instance,
                        const double *frames,
                        struct WireloomJointEvaluation *evaluation,
                        struct WireloomText *message);
} WireloomJointKind;

// A kind that scenarios may name.
typedef struct WireloomKind {
    // `FAMILY_…`.
    int32_t family;
    // Parameters.
    uint32_t parameter_count;
    // Size of a `Parameter`, bytes.
    uint32_t parameter_stride;
    // Zero.
    uint32_t reserved;
    // Name in scenarios.
    const char *name;
    // One line: what it is for.
    const char *doc;
    // The first parameter.
    const struct WireloomParameter *parameters;
    // Its functions, where it is a constraint.
    const struct WireloomConstraintKind *constraint;
    // Its functions, where it is a joint model.
    const struct WireloomJointKind *joint;
} WireloomKind;

// What a plugin has. Lives, with all it points to, as long as the library.
typedef struct WireloomKinds {
    // Size of this struct, bytes.
    uint32_t size;
    // Kinds.
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
    // One line: what it is for.
    const char *doc;
    // What it has; called once, before anything is made. Null: it has nothing, and the message says why.
    const struct WireloomKinds *(*kinds)(struct WireloomText *message);
    // Extras by name, such as those of `draft`; null for what the plugin does not know. May itself be null.
    const void *(*get_extension)(const char *id);
} WireloomEntry;

// What an engineer should know about an instance: that a strap hangs loose as it is put on, say.
typedef struct WireloomNotes {
    // Size of this struct, bytes.
    uint32_t size;
    // Zero.
    uint32_t reserved;
    // Writes the note of this index, from 0, of an instance of the kind; an error where there is none.
    int32_t (*note)(const char *kind, const void *instance, uint32_t index, struct WireloomText *note);
} WireloomNotes;

#endif  /* WIRELOOM_PLUGIN_H */
