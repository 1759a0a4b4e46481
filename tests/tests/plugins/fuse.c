// A spring to a point that tells the tension of the cable before and behind it, remembers the largest one behind it, and
// has an event where that is above a limit.
#include "wireloom_plugin.h"
#include <stdlib.h>

typedef struct { double stiffness, limit; } Fuse;

static const double none[] = {0.0};

static int32_t create(const WireloomKind *kind, const WireloomConstraintSpec *spec, void **instance,
                      WireloomDescription *description, WireloomText *message) {
    (void)kind, (void)message;
    Fuse *fuse = malloc(sizeof *fuse);
    *fuse = (Fuse){spec->values[0].value[0], spec->values[1].value[0]};
    *instance = fuse;
    description->shape = WIRELOOM_SHAPE_POTENTIAL;
    description->thread_safe = description->has_gradient = description->has_hessian = 1;
    description->memory_count = 1;
    description->memory = none;
    return WIRELOOM_STATUS_OK;
}

static void destroy(void *instance) { free(instance); }

static int32_t evaluate(const void *instance, const WireloomSituation *at, WireloomEvaluation *out, WireloomText *message) {
    (void)message;
    if (at->tensions) return WIRELOOM_STATUS_ERROR;
    const double stiffness = ((const Fuse *)instance)->stiffness;
    if (out->energy) *out->energy = 0.0;
    for (int i = 0; i < 6; i++) {
        const double d = i < 3 ? at->stations[0].position[i] - at->targets[0].position[i] : 0.0;
        if (out->energy) *out->energy += 0.5 * stiffness * d * d;
        if (out->gradient) out->gradient[i] = stiffness * d;
        for (int j = 0; out->hessian && j < 6; j++) out->hessian[6 * i + j] = (i == j && i < 3) * stiffness;
    }
    return WIRELOOM_STATUS_OK;
}

static int32_t commit(const void *instance, const WireloomSituation *at, double *memory, WireloomText *message) {
    (void)instance, (void)message;
    if (at->tensions[1] > memory[0]) memory[0] = at->tensions[1];
    return WIRELOOM_STATUS_OK;
}

static int32_t report(const void *instance, const WireloomSituation *at, double *values, WireloomText *message) {
    (void)message;
    values[0] = at->tensions[0];
    values[1] = at->tensions[1];
    values[2] = at->memory[0];
    if (at->tensions[1] > ((const Fuse *)instance)->limit) values[3] = at->tensions[1];
    return WIRELOOM_STATUS_OK;
}

static const WireloomOutput outputs[] = {
    {.name = "before", .doc = "tension before it", .quantity = WIRELOOM_QUANTITY_FORCE},
    {.name = "behind", .doc = "tension behind it", .quantity = WIRELOOM_QUANTITY_FORCE},
    {.name = "largest", .doc = "largest one behind it so far", .quantity = WIRELOOM_QUANTITY_FORCE},
    {.name = "overloaded", .doc = "the cable pulls too much", .quantity = WIRELOOM_QUANTITY_FORCE, .event = 1},
};

static const WireloomConstraintKind functions = {
    .size = sizeof functions,
    .stations_min = 1,
    .stations_max = 1,
    .create = create,
    .destroy = destroy,
    .evaluate = evaluate,
    .commit = commit,
    .output_count = 4,
    .output_stride = sizeof outputs[0],
    .outputs = outputs,
    .report = report,
};

static const WireloomParameter parameters[] = {
    {.name = "stiffness", .doc = "of the spring", .form = WIRELOOM_FORM_NUMBER,
     .quantity = WIRELOOM_QUANTITY_FORCE_PER_LENGTH, .presence = WIRELOOM_PRESENCE_REQUIRED, .maximum = 1e9},
    {.name = "limit", .doc = "of the tension", .form = WIRELOOM_FORM_NUMBER, .quantity = WIRELOOM_QUANTITY_FORCE,
     .presence = WIRELOOM_PRESENCE_REQUIRED, .maximum = 1e9},
};

static const WireloomKind fuse = {
    .family = WIRELOOM_FAMILY_CONSTRAINT,
    .name = "fuse",
    .doc = "a spring that tells the tension of the cable",
    .parameter_count = 2,
    .parameter_stride = sizeof parameters[0],
    .parameters = parameters,
    .constraint = &functions,
};

static const WireloomKinds all = {.size = sizeof all, .count = 1, .stride = sizeof fuse, .first = &fuse};

static const WireloomKinds *kinds(WireloomText *message) {
    (void)message;
    return &all;
}

WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = WIRELOOM_MAGIC,
    .size = sizeof wireloom_plugin,
    .abi_major = WIRELOOM_ABI_MAJOR,
    .abi_minor = WIRELOOM_ABI_MINOR,
    .name = "fuse",
    .version = "1.0.0",
    .doc = "for tests",
    .kinds = kinds,
};
