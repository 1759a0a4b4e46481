// The header of ABI 1.0, without its comments.
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
struct WireloomKind;
#define WIRELOOM_MAGIC 5570758453079722327
#define WIRELOOM_ABI_MAJOR 1
#define WIRELOOM_ABI_MINOR 0
#define WIRELOOM_STATUS_OK 0
#define WIRELOOM_STATUS_ERROR 1
#define WIRELOOM_STATUS_PANIC 2
#define WIRELOOM_FAMILY_CONSTRAINT 1
#define WIRELOOM_FORM_NUMBER 1
#define WIRELOOM_FORM_VECTOR 2
#define WIRELOOM_FORM_COUNT 3
#define WIRELOOM_FORM_FLAG 4
#define WIRELOOM_FORM_CHOICE 5
#define WIRELOOM_PRESENCE_REQUIRED 0
#define WIRELOOM_PRESENCE_OPTIONAL 1
#define WIRELOOM_PRESENCE_DEFAULT 2
#define WIRELOOM_QUANTITY_DIMENSIONLESS 0
#define WIRELOOM_QUANTITY_LENGTH 1
#define WIRELOOM_QUANTITY_MASS 2
#define WIRELOOM_QUANTITY_LINEAR_DENSITY 3
#define WIRELOOM_QUANTITY_FORCE 4
#define WIRELOOM_QUANTITY_MOMENT 5
#define WIRELOOM_QUANTITY_FORCE_PER_LENGTH 6
#define WIRELOOM_QUANTITY_MOMENT_PER_ANGLE 7
#define WIRELOOM_QUANTITY_BENDING_STIFFNESS 8
#define WIRELOOM_QUANTITY_CURVATURE 9
#define WIRELOOM_QUANTITY_ANGLE 10
#define WIRELOOM_QUANTITY_ACCELERATION 11
#define WIRELOOM_QUANTITY_PRESSURE 12
#define WIRELOOM_QUANTITY_DENSITY 13
#define WIRELOOM_SHAPE_PRESCRIBED 1
#define WIRELOOM_SHAPE_POTENTIAL 2
#define WIRELOOM_SHAPE_EQUATIONS 3
#define WIRELOOM_ROTATION_FREE 0
#define WIRELOOM_ROTATION_TANGENT 1
#define WIRELOOM_ROTATION_TWIST 2
#define WIRELOOM_ROTATION_ALL 3
#define WIRELOOM_ROTATION_HINGE 4
#define WIRELOOM_HOLD_POSITION 1
#define WIRELOOM_HOLD_TANGENT 2
#define WIRELOOM_HOLD_TWIST 4
typedef struct WireloomText {
    char *data;
    size_t capacity;
} WireloomText;
typedef struct WireloomParameter {
    const char *name;
    const char *doc;
    int32_t form;
    int32_t quantity;
    int32_t presence;
    int32_t minimum_excluded;
    double minimum;
    double maximum;
    double default_value[3];
    const char *const *choices;
    uint32_t choice_count;
    uint32_t reserved;
} WireloomParameter;
typedef struct WireloomStation {
    const char *branch;
    double arc_length;
    double diameter;
} WireloomStation;
typedef struct WireloomSpan {
    uint32_t size;
    uint32_t reserved;
    const char *branch;
    double begins;
    double ends;
    double diameter;
} WireloomSpan;
typedef struct WireloomValue {
    double value[3];
    int32_t given;
    uint32_t reserved;
} WireloomValue;
typedef struct WireloomConstraintSpec {
    uint32_t size;
    uint32_t station_count;
    uint32_t station_stride;
    uint32_t value_count;
    const char *name;
    const struct WireloomStation *stations;
    const struct WireloomSpan *span;
    const struct WireloomValue *values;
    int32_t tangent_given;
    int32_t up_given;
    int32_t hold;
    int32_t free_axis_given;
    double free_axis[3];
    double rails[2][3];
    uint32_t rail_count;
    uint32_t reserved;
} WireloomConstraintSpec;
typedef struct WireloomHold {
    int32_t position;
    int32_t rotation;
    double axis[3];
    double rails[2][3];
    uint32_t rail_count;
    uint32_t reserved;
} WireloomHold;
typedef struct WireloomDescription {
    uint32_t size;
    int32_t shape;
    int32_t needs_frames;
    int32_t objective;
    int32_t thread_safe;
    int32_t has_gradient;
    int32_t has_hessian;
    uint32_t memory_count;
    const double *memory;
    uint32_t residual_count;
    uint32_t node_residual_count;
    const int32_t *inequalities;
    const double *scales;
    struct WireloomHold hold;
} WireloomDescription;
typedef struct WireloomPose {
    double position[3];
    double orientation[4];
} WireloomPose;
typedef struct WireloomSituation {
    uint32_t size;
    uint32_t station_count;
    uint32_t span_count;
    uint32_t memory_count;
    const struct WireloomPose *stations;
    const struct WireloomPose *targets;
    const double *span;
    const double *span_lengths;
    const double *memory;
    double progress;
} WireloomSituation;
typedef struct WireloomEvaluation {
    uint32_t size;
    uint32_t reserved;
    double *energy;
    double *gradient;
    double *span_gradient;
    double *hessian;
    double *span_hessian;
    double *residuals;
    double *jacobian;
    double *span_jacobian;
    const double *weights;
} WireloomEvaluation;
typedef struct WireloomConstraintKind {
    uint32_t size;
    uint32_t stations_min;
    uint32_t stations_max;
    uint32_t span;
    int32_t (*create)(const struct WireloomKind *kind,
                      const struct WireloomConstraintSpec *spec,
                      void **instance,
                      struct WireloomDescription *description,
                      struct WireloomText *message);
    void (*destroy)(void *instance);
    int32_t (*evaluate)(const void *instance,
                        const struct WireloomSituation *situation,
                        struct WireloomEvaluation *evaluation,
                        struct WireloomText *message);
    int32_t (*target)(const void *instance,
                      const struct WireloomPose *base,
                      double progress,
                      struct WireloomPose *target,
                      struct WireloomText *message);
    int32_t (*commit)(const void *instance,
                      const struct WireloomSituation *situation,
                      double *memory,
                      struct WireloomText *message);
} WireloomConstraintKind;
typedef struct WireloomKind {
    int32_t family;
    uint32_t parameter_count;
    uint32_t parameter_stride;
    uint32_t reserved;
    const char *name;
    const char *doc;
    const struct WireloomParameter *parameters;
    const struct WireloomConstraintKind *constraint;
} WireloomKind;
typedef struct WireloomKinds {
    uint32_t size;
    uint32_t count;
    uint32_t stride;
    uint32_t reserved;
    const struct WireloomKind *first;
} WireloomKinds;
typedef struct WireloomEntry {
    uint64_t magic;
    uint32_t size;
    uint32_t abi_major;
    uint32_t abi_minor;
    uint32_t reserved;
    const char *name;
    const char *version;
    const char *doc;
    const struct WireloomKinds *(*kinds)(struct WireloomText *message);
    const void *(*get_extension)(const char *id);
} WireloomEntry;
typedef struct WireloomNotes {
    uint32_t size;
    uint32_t reserved;
    int32_t (*note)(const char *kind, const void *instance, uint32_t index, struct WireloomText *note);
} WireloomNotes;
#endif
