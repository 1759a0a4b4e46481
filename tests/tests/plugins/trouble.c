/* A spring that crashes, hangs or ends the process if it has certain stiffnesses, and is harmless otherwise. */

#define _GNU_SOURCE
#include "wireloom_plugin.h"
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static int32_t create(const WireloomKind *kind, const WireloomConstraintSpec *spec, void **instance,
                      WireloomDescription *description, WireloomText *message) {
    (void)kind;
    (void)message;
    double *stiffness = malloc(sizeof *stiffness);
    *stiffness = spec->values[0].value[0];
    *instance = stiffness;
    description->shape = WIRELOOM_SHAPE_POTENTIAL;
    description->objective = 1;
    description->has_gradient = 1;
    description->has_hessian = 1;
    return WIRELOOM_STATUS_OK;
}

static void destroy(void *instance) { free(instance); }

static int32_t evaluate(const void *instance, const WireloomSituation *at, WireloomEvaluation *out,
                        WireloomText *message) {
    (void)message;
    const double k = *(const double *)instance;
    /* Standard output also carries what the process tells the sweep. */
    printf("a line and a half\nof a plugin");
    fflush(stdout);
    switch (lround(k)) {
    case 7: *(volatile int *)16 = 1; break;
    case 20: for (;;) usleep(1000);
    case 21: abort();
    case 40: exit(0);
    case 45: raise(SIGKILL); break;
    case 101: return WIRELOOM_STATUS_ERROR;
    }
    double d[3], energy = k == 100.0 ? NAN : 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = at->stations[0].position[i] - at->targets[0].position[i];
        energy += 0.5 * k * d[i] * d[i];
    }
    if (out->energy) *out->energy = energy;
    for (int i = 0; i < 6 && out->gradient; i++) out->gradient[i] = i < 3 ? k * d[i] : 0.0;
    for (int i = 0; i < 36 && out->hessian; i++) out->hessian[i] = i / 6 == i % 6 && i % 6 < 3 ? k : 0.0;
    return WIRELOOM_STATUS_OK;
}

static const WireloomParameter parameters[] = {
    {.name = "stiffness",
     .doc = "of the spring",
     .form = WIRELOOM_FORM_NUMBER,
     .quantity = WIRELOOM_QUANTITY_FORCE_PER_LENGTH,
     .presence = WIRELOOM_PRESENCE_REQUIRED,
     .maximum = INFINITY},
};

static const WireloomConstraintKind functions = {
    .size = sizeof functions, .stations_min = 1, .stations_max = 1,
    .create = create, .destroy = destroy, .evaluate = evaluate,
};

static const WireloomKind kinds[] = {
    {.family = WIRELOOM_FAMILY_CONSTRAINT, .name = "trouble", .doc = "a spring that means trouble",
     .parameter_count = 1, .parameter_stride = sizeof parameters[0], .parameters = parameters, .constraint = &functions},
};

static const WireloomKinds list = {.size = sizeof list, .count = 1, .stride = sizeof kinds[0], .first = kinds};

static const WireloomKinds *list_kinds(WireloomText *message) {
    (void)message;
    return &list;
}

WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = WIRELOOM_MAGIC, .size = sizeof wireloom_plugin,
    .abi_major = WIRELOOM_ABI_MAJOR, .abi_minor = WIRELOOM_ABI_MINOR,
    .name = "trouble", .version = "0.0.1", .doc = "means trouble", .kinds = list_kinds,
};
