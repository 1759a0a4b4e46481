// One of each family that the header knows, whichever ABI it is of: a spring to a point, a hub that carries its arms,
// and a rod that bends as its section says.
#include "wireloom_plugin.h"
#include <stdlib.h>
#include <string.h>

static void destroy(void *instance) { free(instance); }

static int32_t create_spring(const WireloomKind *kind, const WireloomConstraintSpec *spec, void **instance,
                             WireloomDescription *description, WireloomText *message) {
    (void)kind, (void)message;
    double *stiffness = malloc(sizeof *stiffness);
    *stiffness = spec->values[0].value[0];
    *instance = stiffness;
    description->shape = WIRELOOM_SHAPE_POTENTIAL;
    description->thread_safe = description->has_gradient = description->has_hessian = 1;
    return WIRELOOM_STATUS_OK;
}

static int32_t evaluate_spring(const void *instance, const WireloomSituation *at, WireloomEvaluation *out,
                               WireloomText *message) {
    (void)message;
    const double stiffness = *(const double *)instance;
    if (out->energy) *out->energy = 0.0;
    for (int i = 0; i < 6; i++) {
        const double d = i < 3 ? at->stations[0].position[i] - at->targets[0].position[i] : 0.0;
        if (out->energy) *out->energy += 0.5 * stiffness * d * d;
        if (out->gradient) out->gradient[i] = stiffness * d;
        for (int j = 0; out->hessian && j < 6; j++) out->hessian[6 * i + j] = (i == j && i < 3) * stiffness;
    }
    return WIRELOOM_STATUS_OK;
}

#if WIRELOOM_ABI_MINOR >= 3
static int32_t report_spring(const void *instance, const WireloomSituation *at, double *values, WireloomText *message) {
    (void)message;
    for (int i = 0; i < 2; i++)
        values[i] = *(const double *)instance * (at->targets[0].position[i] - at->stations[0].position[i]);
    return WIRELOOM_STATUS_OK;
}

static const WireloomOutput pulls[] = {
    {.name = "x", .doc = "pull along x", .quantity = WIRELOOM_QUANTITY_FORCE},
    {.name = "y", .doc = "pull along y", .quantity = WIRELOOM_QUANTITY_FORCE},
};
#endif

static const WireloomConstraintKind spring = {
    .size = sizeof spring,
    .stations_min = 1,
    .stations_max = 1,
    .create = create_spring,
    .destroy = destroy,
    .evaluate = evaluate_spring,
#if WIRELOOM_ABI_MINOR >= 3
    .output_count = 2,
    .output_stride = sizeof pulls[0],
    .outputs = pulls,
    .report = report_spring,
#endif
};

static const WireloomParameter stiffness[] = {
    {.name = "stiffness", .doc = "k", .form = WIRELOOM_FORM_NUMBER, .quantity = WIRELOOM_QUANTITY_FORCE_PER_LENGTH,
     .presence = WIRELOOM_PRESENCE_REQUIRED, .maximum = 1e9},
};

#if WIRELOOM_ABI_MINOR >= 1
static int32_t create_hub(const WireloomKind *kind, const WireloomJointSpec *spec, void **instance,
                          WireloomJointDescription *description, WireloomText *message) {
    (void)kind, (void)spec, (void)message;
    *instance = malloc(1);
    description->mounting = WIRELOOM_MOUNTING_POSE;
    description->thread_safe = 1;
    return WIRELOOM_STATUS_OK;
}

static const WireloomJointKind hub = {.size = sizeof hub, .create = create_hub, .destroy = destroy};
#endif

#if WIRELOOM_ABI_MINOR >= 7
static int32_t create_rod(const WireloomKind *kind, const WireloomRodSpec *spec, void **instance,
                          WireloomRodDescription *description, WireloomText *message) {
    (void)kind, (void)message;
    double *stiffness = malloc(3 * sizeof *stiffness);
    memcpy(stiffness, spec->bending_stiffness, sizeof spec->bending_stiffness);
    stiffness[2] = spec->torsion_stiffness;
    *instance = stiffness;
    description->has_bend = description->has_hessian = description->thread_safe = 1;
    return WIRELOOM_STATUS_OK;
}

static int32_t bend(const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
    (void)message;
    const double *stiffness = instance;
    for (uint32_t k = 0; k < out->count; k++) {
        if (out->energy) out->energy[k] = 0.0;
        for (int i = 0; i < 3; i++) {
            const double e = strains[3 * k + i];
            if (out->energy) out->energy[k] += 0.5 * stiffness[i] * e * e;
            if (out->gradient) out->gradient[3 * k + i] = stiffness[i] * e;
            for (int j = 0; out->hessian && j < 3; j++) out->hessian[9 * k + 3 * i + j] = (i == j) * stiffness[i];
        }
    }
    return WIRELOOM_STATUS_OK;
}

static const WireloomRodKind rod = {.size = sizeof rod, .create = create_rod, .destroy = destroy, .bend = bend};
#endif

static const WireloomKind some[] = {
    {.family = WIRELOOM_FAMILY_CONSTRAINT, .name = "earlier-spring", .doc = "a spring to a point", .parameter_count = 1,
     .parameter_stride = sizeof stiffness[0], .parameters = stiffness, .constraint = &spring},
#if WIRELOOM_ABI_MINOR >= 1
    {.family = WIRELOOM_FAMILY_JOINT, .name = "earlier-hub", .doc = "a hub", .joint = &hub},
#endif
#if WIRELOOM_ABI_MINOR >= 7
    {.family = WIRELOOM_FAMILY_ROD, .name = "earlier-rod", .doc = "a rod", .rod = &rod},
#endif
};

static const WireloomKinds all = {
    .size = sizeof all, .count = sizeof some / sizeof some[0], .stride = sizeof some[0], .first = some};

static const WireloomKinds *kinds(WireloomText *message) {
    (void)message;
    return &all;
}

WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = WIRELOOM_MAGIC,
    .size = sizeof wireloom_plugin,
    .abi_major = WIRELOOM_ABI_MAJOR,
    .abi_minor = WIRELOOM_ABI_MINOR,
    .name = "earlier",
    .version = "0.0.1",
    .doc = "one of each family",
    .kinds = kinds,
};
