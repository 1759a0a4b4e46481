// Wireloom: the assembly of branched cables, computed. Made from crates/capi; do not edit.
//
// Every function that can fail returns a WireloomCode, and fills its WireloomError unless that pointer is null; those
// that free handles have none. Handles are numbers; 0 is none. A handle that was freed, or is of something else, is an
// error. What a handle was made of may be freed before it. Strings are UTF-8 and end with a 0. Everything is in SI
// units. All functions may be called from any thread at the same time. README.md says more.

#ifndef WIRELOOM_H
#define WIRELOOM_H

#include <stddef.h>
#include <stdint.h>

// What a function returns. Every value but WIRELOOM_CODE_OK is a failure, which has changed nothing but what the
// function says.
enum WireloomCode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Done.
    WIRELOOM_CODE_OK = 0,
    // A pointer is null that must not be.
    WIRELOOM_CODE_NULL_POINTER = 1,
    // The member `size` of a struct, or a count, is wrong; or a pointer is not aligned.
    WIRELOOM_CODE_BAD_SIZE = 2,
    // A handle that was freed, or is one of something else.
    WIRELOOM_CODE_BAD_HANDLE = 3,
    // A text is not UTF-8.
    WIRELOOM_CODE_NOT_UTF8 = 4,
    // A name or an index that does not exist.
    WIRELOOM_CODE_NOT_FOUND = 5,
    // An invalid value, such as NaN or a quaternion of zero length.
    WIRELOOM_CODE_BAD_VALUE = 6,
    // The scenario has faults; the error has the first one.
    WIRELOOM_CODE_REFUSED = 7,
    // What was asked cannot be done now, such as a motion to where there is no equilibrium.
    WIRELOOM_CODE_REQUEST = 8,
    // It was cancelled.
    WIRELOOM_CODE_CANCELLED = 9,
    // A part of the harness failed.
    WIRELOOM_CODE_PART = 10,
    // A question that has no answer, such as derivatives of a run that does not converge.
    WIRELOOM_CODE_NO_ANSWER = 11,
    // The session ended by an internal error. Free it.
    WIRELOOM_CODE_CLOSED = 12,
    // The system refused something, such as a thread.
    WIRELOOM_CODE_SYSTEM = 13,
    // An error of the library, not of its input; please report it.
    WIRELOOM_CODE_INTERNAL = 14,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum WireloomCode WireloomCode;
#else
typedef int32_t WireloomCode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Severity of a diagnostic.
enum WireloomSeverity
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // The scenario is refused.
    WIRELOOM_SEVERITY_ERROR = 1,
    // A remark on a scenario that is not refused.
    WIRELOOM_SEVERITY_NOTE = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum WireloomSeverity WireloomSeverity;
#else
typedef int32_t WireloomSeverity;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// How well the equations of a run, a step or an increment are solved.
enum WireloomStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Forces and moments are in equilibrium.
    WIRELOOM_STATUS_CONVERGED = 0,
    // No further progress is possible in double precision.
    WIRELOOM_STATUS_STALLED = 1,
    // The iteration limit was reached.
    WIRELOOM_STATUS_ITERATION_LIMIT = 2,
    // No step lowers the energy, numbers are not finite, or a part failed.
    WIRELOOM_STATUS_FAILED = 3,
    // It was cancelled.
    WIRELOOM_STATUS_INTERRUPTED = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum WireloomStatus WireloomStatus;
#else
typedef int32_t WireloomStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Whether a requirement, or the whole harness, is acceptable.
enum WireloomVerdict
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Kept in every increment.
    WIRELOOM_VERDICT_PASS = 0,
    // Not kept.
    WIRELOOM_VERDICT_FAIL = 1,
    // It cannot be decided.
    WIRELOOM_VERDICT_UNRESOLVED = 2,
    // Nothing was there to check it on.
    WIRELOOM_VERDICT_NOT_CHECKED = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum WireloomVerdict WireloomVerdict;
#else
typedef int32_t WireloomVerdict;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Families of named parts, for wireloom_result_find.
enum WireloomFamily
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    // Branches.
    WIRELOOM_FAMILY_BRANCH = 1,
    // Constraints that act.
    WIRELOOM_FAMILY_CONSTRAINT = 2,
    // Joints.
    WIRELOOM_FAMILY_JOINT = 3,
    // Bodies of the surroundings.
    WIRELOOM_FAMILY_BODY = 4,
    // Markers.
    WIRELOOM_FAMILY_MARKER = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum WireloomFamily WireloomFamily;
#else
typedef uint32_t WireloomFamily;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A text, or the bytes of a file.
typedef struct WireloomText {
    // 0: none.
    uint64_t id;
} WireloomText;

// What a failed function says: `WireloomError error = {sizeof error};`. Longer texts are cut off. A function that
// succeeds leaves it as it is.
typedef struct WireloomError {
    // sizeof(WireloomError), set by the caller.
    size_t size;
    // The code that the function returned.
    WireloomCode code;
    // Line in the scenario's text, from 1; 0: no place.
    uint32_t line;
    // Column, characters from 1; 0: no place.
    uint32_t column;
    // What is wrong.
    char message[1024];
    // What to do about it; may be empty.
    char suggestion[512];
} WireloomError;

// A scenario: a text and its files. Other handles that were made of it do not change with it.
typedef struct WireloomScenario {
    // 0: none.
    uint64_t id;
} WireloomScenario;

// A body of the surroundings, with the triangles of its surface.
typedef struct WireloomBody {
    // sizeof(WireloomBody), set by the caller.
    size_t size;
    // Its name, which no other body has.
    const char *name;
    // Corners, m, in the axes of the body: three numbers for each.
    const double *corners;
    // Number of corners.
    size_t corner_count;
    // Triangles: three indices of corners for each, from 0, counter-clockwise as seen from outside. The surface is
    // closed.
    const uint32_t *triangles;
    // Number of triangles.
    size_t triangle_count;
    // Its position at the start, m.
    double position[3];
    // Its orientation at the start: quaternion w, x, y, z of any length but zero.
    double orientation[4];
    // Coefficient of Coulomb friction; 0 is smooth.
    double friction;
    // Required clearance of cables, m; NaN: none.
    double min_clearance;
} WireloomBody;

// What a check found.
typedef struct WireloomDiagnostics {
    // 0: none.
    uint64_t id;
} WireloomDiagnostics;

// A diagnostic. Its texts are valid until the diagnostics are freed.
typedef struct WireloomDiagnostic {
    // sizeof(WireloomDiagnostic), set by the caller.
    size_t size;
    // Its severity.
    WireloomSeverity severity;
    // Line in the scenario's text, from 1; 0: no place.
    uint32_t line;
    // Column, characters from 1; 0: no place.
    uint32_t column;
    // What is wrong, with the value.
    const char *message;
    // What would be right; may be empty.
    const char *suggestion;
} WireloomDiagnostic;

// A handle that cancels the computations which were given it, from any thread.
typedef struct WireloomCancel {
    // 0: none; what is given it cannot be cancelled.
    uint64_t id;
} WireloomCancel;

// How far a run has come.
typedef struct WireloomProgress {
    // sizeof(WireloomProgress) of the library.
    size_t size;
    // Name of the step, valid during the call.
    const char *step;
    // Index of the step, from 0.
    size_t step_index;
    // Number of steps.
    size_t step_count;
    // Number of the increment that has ended, from 1.
    size_t increment;
    // Increments of the step.
    size_t increment_count;
} WireloomProgress;

// A function of the host that is called at the end of every increment, in the thread that called wireloom_run. The
// run ends if it does not return 0. It must return: no exception, no longjmp.
typedef int (*WireloomOnProgress)(void *user, const struct WireloomProgress *progress);

// What a run may be given: `WireloomRunOptions options = {sizeof options};`.
typedef struct WireloomRunOptions {
    // sizeof(WireloomRunOptions), set by the caller.
    size_t size;
    // Called at the end of every increment; may be null.
    WireloomOnProgress on_progress;
    // Handed to `on_progress`.
    void *user;
    // Cancels the run, from any thread; {0}: nothing does.
    struct WireloomCancel cancel;
} WireloomRunOptions;

// A result: that of a run, or of a session at one moment.
typedef struct WireloomResult {
    // 0: none.
    uint64_t id;
} WireloomResult;

// A result as a whole. Its texts are valid until the result is freed.
typedef struct WireloomSummary {
    // sizeof(WireloomSummary), set by the caller.
    size_t size;
    // Name of the scenario.
    const char *scenario;
    // How well its equations are solved.
    WireloomStatus status;
    // Whether the harness keeps its requirements.
    WireloomVerdict verdict;
    // What ended the run early: a part that failed; null where none did.
    const char *fault;
    // Equilibria: the last increment of each step, or all of them if `[output] increments = true`. Of a session: one.
    size_t step_count;
    // Events.
    size_t event_count;
    // Requirements.
    size_t requirement_count;
    // Remarks on the harness.
    size_t note_count;
} WireloomSummary;

// A branch of an equilibrium. Arrays have a value, or the three components of a vector (x, y, z, world axes), for each
// node; they and the name are valid until the result is freed.
typedef struct WireloomBranch {
    // sizeof(WireloomBranch), set by the caller.
    size_t size;
    // Name.
    const char *name;
    // Number of nodes.
    size_t node_count;
    // Unstressed arc length, m.
    const double *s;
    // Position of the centre line, m: 3 numbers for each node.
    const double *position;
    // Director d1 of the cross-section: 3 numbers for each node.
    const double *d1;
    // Director d2.
    const double *d2;
    // Director d3, along the cable.
    const double *d3;
    // Internal force that the part with larger s exerts on the part with smaller s, N: 3 numbers for each node.
    const double *force;
    // Internal moment, N m: 3 numbers for each node.
    const double *moment;
    // Bend radius, m; infinite where it is straight.
    const double *bend_radius;
    // Diameter, m; the greatest one where the section changes.
    double diameter;
    // Smallest bend radius allowed, m; the greatest one where the section changes; NaN: no limit.
    double bend_radius_limit;
    // Axial stiffness EA, N, at the start.
    double axial_stiffness;
    // Total material twist, turns.
    double twist_turns;
    // Estimated discretisation error of positions, m; NaN: no estimate.
    double position_error;
    // That of internal forces, N; NaN: no estimate.
    double force_error;
    // That of internal moments, N m; NaN: no estimate.
    double moment_error;
    // The least bend radius may be smaller by so much, m; NaN: no estimate.
    double bend_radius_error;
    // Number of parts with a section of their own; 0 where the section does not change.
    size_t section_count;
} WireloomBranch;

// A part of a branch with a section of its own.
typedef struct WireloomSection {
    // sizeof(WireloomSection), set by the caller.
    size_t size;
    // Name of the section; valid until the result is freed.
    const char *name;
    // Arc length where the part begins, m.
    double from;
    // Arc length where it ends, m.
    double to;
    // Diameter, m.
    double diameter;
    // Smallest bend radius allowed, m; NaN: no limit.
    double bend_radius_limit;
    // Axial stiffness EA, N.
    double axial_stiffness;
} WireloomSection;

// A constraint that acts: connector, clip, handle. Its texts are valid until the result is freed.
typedef struct WireloomConstraint {
    // sizeof(WireloomConstraint), set by the caller.
    size_t size;
    // Name.
    const char *name;
    // Kind.
    const char *kind;
    // Held point, m.
    double position[3];
    // Frame at the held point: unit quaternion w, x, y, z.
    double orientation[4];
    // Force on the harness, N, world axes.
    double force[3];
    // Moment on the harness about the held point, N m, world axes.
    double moment[3];
} WireloomConstraint;

// A joint, or a marker, which has no orientation of its own (1, 0, 0, 0). Its name is valid until the result is freed.
typedef struct WireloomPlace {
    // sizeof(WireloomPlace), set by the caller.
    size_t size;
    // Name.
    const char *name;
    // Position, m.
    double position[3];
    // Orientation: unit quaternion w, x, y, z.
    double orientation[4];
} WireloomPlace;

// A body of the surroundings, and what it does to the harness. Its name is valid until the result is freed.
typedef struct WireloomBodyState {
    // sizeof(WireloomBodyState), set by the caller.
    size_t size;
    // Name.
    const char *name;
    // Position, m.
    double position[3];
    // Orientation: unit quaternion w, x, y, z.
    double orientation[4];
    // Force on the harness, N, world axes.
    double force[3];
    // Moment on the harness about the position of the body, N m, world axes.
    double moment[3];
    // Sum of the sizes of its contact forces, N.
    double contact_force;
    // Number of contact points with a force.
    size_t contact_count;
    // Largest depth of a contact point in the body, m.
    double depth;
} WireloomBodyState;

// A part of the harness. Its texts are valid until the result is freed.
typedef struct WireloomWhere {
    // The place in words, such as "branch `trunk` at s = 310.0 mm".
    const char *words;
    // Name of the constraint; null: none.
    const char *constraint;
    // Name of the body; null: none.
    const char *body;
    // Name of the branch; null: none.
    const char *branch;
    // Arc length on the branch, m; NaN: none.
    double s;
    // Name of the other branch, where two meet; null: none.
    const char *other_branch;
    // Arc length on the other branch, m; NaN: none.
    double other_s;
} WireloomWhere;

// An increment of a run. Its text is valid until the result is freed.
typedef struct WireloomMoment {
    // Name of the step; null: no increment.
    const char *step;
    // Index of the step, from 0.
    size_t step_index;
    // Number of the increment, from 1; 0: while the initial equilibrium was being found.
    size_t increment;
} WireloomMoment;

// An event: a condition over consecutive increments. Its texts are valid until the result is freed.
typedef struct WireloomEvent {
    // sizeof(WireloomEvent), set by the caller.
    size_t size;
    // Kind, such as "bend-radius" or "jump".
    const char *kind;
    // One sentence about the worst increment.
    const char *message;
    // Place.
    struct WireloomWhere place;
    // First increment.
    struct WireloomMoment first;
    // Worst increment.
    struct WireloomMoment worst;
    // Last increment.
    struct WireloomMoment last;
    // Number of increments.
    size_t increment_count;
    // Worst value, in `unit`; NaN: none.
    double value;
    // Its limit; NaN: none.
    double limit;
    // SI unit of both; empty where there is none.
    const char *unit;
    // 1 if it demands a correction, 0 if it is information only.
    int32_t is_trouble;
} WireloomEvent;

// A requirement with its verdict. Its texts are valid until the result is freed.
typedef struct WireloomRequirement {
    // sizeof(WireloomRequirement), set by the caller.
    size_t size;
    // Name.
    const char *name;
    // What it limits, such as "bend_radius".
    const char *quantity;
    // SI unit; empty for a pure number.
    const char *unit;
    // 1 if the harness is not acceptable where it fails, 0 if it is only reported.
    int32_t is_must;
    // Verdict.
    WireloomVerdict verdict;
    // Worst value over all increments; NaN: nothing was checked.
    double worst;
    // Limit.
    double limit;
    // 1 if the value must not be smaller than the limit, 0 if it must not be larger.
    int32_t is_minimum;
    // Distance of the worst value from the limit, relative to it; negative where it fails; NaN: none.
    double margin;
    // Estimated discretisation error of the worst value; NaN: none.
    double error;
    // Increment of the worst value.
    struct WireloomMoment moment;
    // Place of the worst value.
    struct WireloomWhere place;
    // Where it comes from: "scenario", "section", "constraint", "obstacle" or "always".
    const char *origin;
    // Why the scenario asks for it; null: not said.
    const char *because;
    // Why it is unresolved or not checked, or what the worst value leaves out; null: nothing to say.
    const char *reason;
} WireloomRequirement;

// Energy by effect, J.
typedef struct WireloomEnergy {
    // The sum.
    double total;
    // Stretch of the branches.
    double stretch;
    // Shear of the branches.
    double shear;
    // Bending of the branches.
    double bend;
    // Twist of the branches.
    double twist;
    // Gravity.
    double gravity;
    // Dead forces.
    double load;
    // Joints.
    double joint;
    // Constraints, contact and friction.
    double constraint;
} WireloomEnergy;

// The equilibrium at the end of an increment. Its texts are valid until the result is freed.
typedef struct WireloomStep {
    // sizeof(WireloomStep), set by the caller.
    size_t size;
    // Name of the step.
    const char *name;
    // Number of the increment, from 1; 0: the initial equilibrium.
    size_t increment;
    // Increments of the step.
    size_t increment_count;
    // How well its equations are solved.
    WireloomStatus status;
    // Whether the equilibrium is stable: 1, 0, or -1 where that cannot be decided.
    int32_t stable;
    // Its energy.
    struct WireloomEnergy energy;
    // Name of the branch with the critical bend: the one nearest to its limit, or of least radius; null: all straight.
    const char *bend_branch;
    // Arc length of that bend, m; NaN: all straight.
    double bend_s;
    // Its radius, m; infinite: all straight.
    double bend_radius;
    // Smallest radius allowed there, m; NaN: no limit.
    double bend_radius_limit;
    // Branches.
    size_t branch_count;
    // Constraints that act.
    size_t constraint_count;
    // Joints.
    size_t joint_count;
    // Bodies of the surroundings.
    size_t body_count;
    // Markers.
    size_t marker_count;
    // Kind of the minimiser.
    const char *minimiser;
    // Its iterations, over all increments of the step so far.
    size_t iterations;
    // Its factorisations.
    size_t factorisations;
    // Its time, s.
    double seconds;
    // Largest residual force or moment, relative to its scale.
    double force_residual;
} WireloomStep;

// A harness that is moved by hand, each time to a new equilibrium, while the scenario is recorded: a run of its text
// ends in the same equilibrium. Calls from several threads are carried out one after the other.
typedef struct WireloomSession {
    // 0: none.
    uint64_t id;
} WireloomSession;

// What is asked. Names and lists may be null, with a count of 0.
typedef struct WireloomQuestion {
    // sizeof(WireloomQuestion), set by the caller.
    size_t size;
    // Outputs, such as "force.plug-B" or the name of a requirement; none: all requirements.
    const char *const *of;
    // Number of outputs.
    size_t of_count;
    // Keys with numbers, such as "branches.left.length"; none: those that the scenario's sweep varies.
    const char *const *by;
    // Number of keys.
    size_t by_count;
    // Name of the step at whose end; null: the last one.
    const char *step;
    // Cancels the work; {0}: nothing does.
    struct WireloomCancel cancel;
} WireloomQuestion;

// Derivatives at the end of a step.
typedef struct WireloomSensitivities {
    // 0: none.
    uint64_t id;
} WireloomSensitivities;

// An answer as a whole. Its text is valid until the sensitivities are freed.
typedef struct WireloomAnswer {
    // sizeof(WireloomAnswer), set by the caller.
    size_t size;
    // Name of the step.
    const char *step;
    // Number of the increment, from 1.
    size_t increment;
    // 1 if friction or parts that remember have a history, which is kept as it is.
    int32_t keeps_history;
    // Number of parameters, in the order of the question.
    size_t parameter_count;
    // Number of outputs.
    size_t output_count;
} WireloomAnswer;

// A parameter. Its texts are valid until the sensitivities are freed.
typedef struct WireloomParameter {
    // sizeof(WireloomParameter), set by the caller.
    size_t size;
    // Its key.
    const char *key;
    // Its value, SI.
    double value;
    // SI unit; empty for pure numbers.
    const char *unit;
} WireloomParameter;

// An output. Its texts are valid until the sensitivities are freed.
typedef struct WireloomOutput {
    // sizeof(WireloomOutput), set by the caller.
    size_t size;
    // Its name.
    const char *name;
    // SI unit; empty for pure numbers.
    const char *unit;
    // Its value; NaN: none.
    double value;
    // A remark; null: none.
    const char *remark;
    // Standard deviation by the tolerances of the scenario's sweep; NaN: none.
    double deviation;
} WireloomOutput;

// A derivative, SI. Its text is valid until the sensitivities are freed.
typedef struct WireloomDerivative {
    // sizeof(WireloomDerivative), set by the caller.
    size_t size;
    // Its value; NaN where it is not differentiable.
    double value;
    // Where it is not: the derivative towards smaller values of the parameter; NaN: not known.
    double towards_smaller;
    // That towards larger values; NaN: not known.
    double towards_larger;
    // Why there is no derivative; null where there is one.
    const char *reason;
} WireloomDerivative;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Version of the library, such as "0.1.0".
const char *wireloom_version(void);

// The bytes with a 0 after the last one, valid until it is freed, and their number without that 0. A text is UTF-8.
WireloomCode wireloom_text_get(struct WireloomText text,
                               const char **bytes,
                               size_t *length,
                               struct WireloomError *error);

// Frees a text.
WireloomCode wireloom_text_free(struct WireloomText text);

// Makes a scenario of a text, which is not checked yet.
//
// `text` has `length` bytes, in UTF-8, without a 0 at the end. `folder` is that of the files which the text names; a
// null pointer: it names no files but those that are added. A relative one is relative to where the host is now.
// wireloom_scenario_read does the same with a file.
WireloomCode wireloom_scenario_new(const char *text,
                                   size_t length,
                                   const char *folder,
                                   struct WireloomScenario *scenario,
                                   struct WireloomError *error);

// Makes a scenario of a file, which is not checked yet. The files that it names are looked for beside it.
WireloomCode wireloom_scenario_read(const char *path, struct WireloomScenario *scenario, struct WireloomError *error);

// Adds a file that the text may name. It goes before one of that name in the folder, and replaces one that was added
// before; the surface of a body it does not.
WireloomCode wireloom_scenario_add_file(struct WireloomScenario scenario,
                                        const char *name,
                                        const uint8_t *bytes,
                                        size_t count,
                                        struct WireloomError *error);

// Adds a body of the surroundings: an entry of `[[obstacles]]` at the end of the text. Its surface is a file that the
// scenario keeps. The text and the scenario have no body or file of that name yet.
WireloomCode wireloom_scenario_add_body(struct WireloomScenario scenario,
                                        const struct WireloomBody *body,
                                        struct WireloomError *error);

// Sets the value of a key, such as "branches.left.length" or "joints.J.model", to a value in JSON, such as "0.41",
// "\"410 mm\"" or "\"fused\"". Comments of the text stay. WIRELOOM_CODE_NOT_FOUND: there is no such key;
// WIRELOOM_CODE_BAD_VALUE: it is not JSON, or has a null; WIRELOOM_CODE_REFUSED: the text is not TOML.
WireloomCode wireloom_scenario_set(struct WireloomScenario scenario,
                                   const char *key,
                                   const char *json,
                                   struct WireloomError *error);

// The text, as it is now.
WireloomCode wireloom_scenario_text(struct WireloomScenario scenario,
                                    struct WireloomText *text,
                                    struct WireloomError *error);

// The bytes of a file that the scenario keeps: one that was added, or "NAME.obj" with the surface of the body NAME. A
// text that is saved needs them beside it.
WireloomCode wireloom_scenario_file(struct WireloomScenario scenario,
                                    const char *name,
                                    struct WireloomText *bytes,
                                    struct WireloomError *error);

// Frees a scenario. What was made of it stays.
WireloomCode wireloom_scenario_free(struct WireloomScenario scenario);

// Checks a scenario: all its faults, or the remarks on one that can be carried out. `count`: their number.
WireloomCode wireloom_scenario_check(struct WireloomScenario scenario,
                                     struct WireloomDiagnostics *diagnostics,
                                     size_t *count,
                                     struct WireloomError *error);

// One of the diagnostics, from 0.
WireloomCode wireloom_diagnostics_get(struct WireloomDiagnostics diagnostics,
                                      size_t index,
                                      struct WireloomDiagnostic *diagnostic,
                                      struct WireloomError *error);

// Frees diagnostics.
WireloomCode wireloom_diagnostics_free(struct WireloomDiagnostics diagnostics);

// Makes a cancel handle.
WireloomCode wireloom_cancel_new(struct WireloomCancel *cancel, struct WireloomError *error);

// Cancels what is computed with this handle, now and later. It ends within an iteration: a run with a result whose
// status is WIRELOOM_STATUS_INTERRUPTED, everything else with WIRELOOM_CODE_CANCELLED.
WireloomCode wireloom_cancel_request(struct WireloomCancel cancel, struct WireloomError *error);

// Takes the request back, so that the handle can be used again.
WireloomCode wireloom_cancel_reset(struct WireloomCancel cancel, struct WireloomError *error);

// Frees a cancel handle; what uses it goes on.
WireloomCode wireloom_cancel_free(struct WireloomCancel cancel);

// Carries a scenario out. `options` may be null.
//
// A run that does not converge, or that is cancelled, is a result, too: see the status in wireloom_result_get, which
// is WIRELOOM_STATUS_INTERRUPTED after a cancellation. A scenario with faults is refused.
WireloomCode wireloom_run(struct WireloomScenario scenario,
                          const struct WireloomRunOptions *options,
                          struct WireloomResult *result,
                          struct WireloomError *error);

// A result as a whole.
WireloomCode wireloom_result_get(struct WireloomResult result,
                                 struct WireloomSummary *summary,
                                 struct WireloomError *error);

// One of the remarks, from 0; valid until the result is freed.
WireloomCode wireloom_result_note(struct WireloomResult result,
                                  size_t index,
                                  const char **note,
                                  struct WireloomError *error);

// Frees a result, with all texts and arrays that were read from it.
WireloomCode wireloom_result_free(struct WireloomResult result);

// A branch of an equilibrium, from 0, in the order of the scenario.
WireloomCode wireloom_result_branch(struct WireloomResult result,
                                    size_t step,
                                    size_t index,
                                    struct WireloomBranch *branch,
                                    struct WireloomError *error);

// A part of a branch with a section of its own, from 0, in the order of arc length; a branch whose section does not
// change has none.
WireloomCode wireloom_result_section(struct WireloomResult result,
                                     size_t step,
                                     size_t branch,
                                     size_t index,
                                     struct WireloomSection *section,
                                     struct WireloomError *error);

// A constraint that acts, from 0.
WireloomCode wireloom_result_constraint(struct WireloomResult result,
                                        size_t step,
                                        size_t index,
                                        struct WireloomConstraint *constraint,
                                        struct WireloomError *error);

// A joint, from 0.
WireloomCode wireloom_result_joint(struct WireloomResult result,
                                   size_t step,
                                   size_t index,
                                   struct WireloomPlace *joint,
                                   struct WireloomError *error);

// A marker, from 0.
WireloomCode wireloom_result_marker(struct WireloomResult result,
                                    size_t step,
                                    size_t index,
                                    struct WireloomPlace *marker,
                                    struct WireloomError *error);

// A body, from 0.
WireloomCode wireloom_result_body(struct WireloomResult result,
                                  size_t step,
                                  size_t index,
                                  struct WireloomBodyState *body,
                                  struct WireloomError *error);

// An event, from 0, in the order in which they began.
WireloomCode wireloom_result_event(struct WireloomResult result,
                                   size_t index,
                                   struct WireloomEvent *event,
                                   struct WireloomError *error);

// A requirement, from 0.
WireloomCode wireloom_result_requirement(struct WireloomResult result,
                                         size_t index,
                                         struct WireloomRequirement *requirement,
                                         struct WireloomError *error);

// One of the equilibria, from 0.
WireloomCode wireloom_result_step(struct WireloomResult result,
                                  size_t index,
                                  struct WireloomStep *step,
                                  struct WireloomError *error);

// Index of a part of an equilibrium by its name; `family`: a WireloomFamily.
WireloomCode wireloom_result_find(struct WireloomResult result,
                                  size_t step,
                                  uint32_t family,
                                  const char *name,
                                  size_t *index,
                                  struct WireloomError *error);

// Opens a session: finds the initial equilibrium and carries out the steps of the scenario. `cancel` cancels this and
// what the session does later; {0}: nothing does.
WireloomCode wireloom_session_open(struct WireloomScenario scenario,
                                   struct WireloomCancel cancel,
                                   struct WireloomSession *session,
                                   struct WireloomError *error);

// The current equilibrium: a result of one step, with the events and requirements so far.
WireloomCode wireloom_session_result(struct WireloomSession session,
                                     struct WireloomResult *result,
                                     struct WireloomError *error);

// Moves a constraint that acts to a pose, in as many increments as the way needs.
//
// `position`: three numbers, m; null: where it is. `orientation`: a quaternion w, x, y, z of any length but zero;
// null: as it is. Motions of one constraint that follow each other are one step of the scenario, and are undone
// together. A motion that fails on the way stays at the last equilibrium before.
WireloomCode wireloom_session_move(struct WireloomSession session,
                                   const char *constraint,
                                   const double *position,
                                   const double *orientation,
                                   struct WireloomError *error);

// Takes hold of the cable where it is, at the node of a branch nearest to the arc length `s` (m), with a new handle of
// this name, which can then be moved and released.
WireloomCode wireloom_session_hold(struct WireloomSession session,
                                   const char *branch,
                                   double s,
                                   const char *handle,
                                   struct WireloomError *error);

// Releases a constraint that acts.
WireloomCode wireloom_session_release(struct WireloomSession session,
                                      const char *constraint,
                                      struct WireloomError *error);

// Drives a joint of a mechanism, MECHANISM/JOINT or JOINT, to a value in rad or m, along its arc.
WireloomCode wireloom_session_drive(struct WireloomSession session,
                                    const char *joint,
                                    double value,
                                    struct WireloomError *error);

// Moves a body of the surroundings to a pose, in as many increments as the way needs; `position` and `orientation` as
// in wireloom_session_move.
WireloomCode wireloom_session_move_body(struct WireloomSession session,
                                        const char *body,
                                        const double *position,
                                        const double *orientation,
                                        struct WireloomError *error);

// Sets the value of a key as wireloom_scenario_set does, and carries out all steps again, with those by hand. So a
// joint gets another model: "joints.J.model", "\"fused\"".
WireloomCode wireloom_session_set(struct WireloomSession session,
                                  const char *key,
                                  const char *json,
                                  struct WireloomError *error);

// Takes the last operation back, up to 100 of them.
WireloomCode wireloom_session_undo(struct WireloomSession session, struct WireloomError *error);

// The scenario as TOML, with all that was done by hand as its steps.
WireloomCode wireloom_session_text(struct WireloomSession session,
                                   struct WireloomText *text,
                                   struct WireloomError *error);

// Frees a session.
WireloomCode wireloom_session_free(struct WireloomSession session);

// Carries a scenario out up to the end of a step, and differentiates outputs there by numbers of the scenario.
WireloomCode wireloom_sensitivities_new(struct WireloomScenario scenario,
                                        const struct WireloomQuestion *question,
                                        struct WireloomSensitivities *sensitivities,
                                        struct WireloomError *error);

// An answer as a whole.
WireloomCode wireloom_sensitivities_get(struct WireloomSensitivities sensitivities,
                                        struct WireloomAnswer *answer,
                                        struct WireloomError *error);

// A parameter, from 0.
WireloomCode wireloom_sensitivities_parameter(struct WireloomSensitivities sensitivities,
                                              size_t index,
                                              struct WireloomParameter *parameter,
                                              struct WireloomError *error);

// An output, from 0.
WireloomCode wireloom_sensitivities_output(struct WireloomSensitivities sensitivities,
                                           size_t index,
                                           struct WireloomOutput *output,
                                           struct WireloomError *error);

// The derivative of an output by a parameter, both from 0.
WireloomCode wireloom_sensitivities_derivative(struct WireloomSensitivities sensitivities,
                                               size_t output,
                                               size_t parameter,
                                               struct WireloomDerivative *derivative,
                                               struct WireloomError *error);

// Frees sensitivities.
WireloomCode wireloom_sensitivities_free(struct WireloomSensitivities sensitivities);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* WIRELOOM_H */
