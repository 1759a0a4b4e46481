// A rod that remembers: beside the stiffness of its section it has one element of friction in bending, as
// `[sections.x.friction]` has them: a spring of stiffness k that slips where its moment reaches M; z is what has slipped.
//     V = (EI |e|^2 + GJ e3^2)/2 + k |e - z'|^2/2 + M |z' - z|
// With another CASE than 0 it does one thing wrong.
#include "wireloom_plugin.h"
#include <math.h>
#include <stdlib.h>

#ifndef CASE
#define CASE 0
#endif

typedef struct { double elastic[3], stiffness, limit; } Rod;

static int32_t create(const WireloomKind *kind, const WireloomRodSpec *spec, void **instance,
                      WireloomRodDescription *description, WireloomText *message) {
    (void)kind, (void)message;
    Rod *rod = malloc(sizeof *rod);
    const double *ei = spec->bending_stiffness;
    *rod = (Rod){{ei[0], ei[1], spec->torsion_stiffness}, spec->values[0].value[0], spec->values[1].value[0]};
    description->has_bend = CASE != 3;
    description->has_stretch = CASE == 3;
    description->has_hessian = 1;
    description->thread_safe = 1;
    description->memory_count = CASE == 2 ? 5000 : 2;
    *instance = rod;
    return WIRELOOM_STATUS_OK;
}

static void destroy(void *instance) { free(instance); }

// Writes what slips in this increment, and whether it does.
static int slips(const Rod *rod, const double *e, const double *z, double *slip) {
    const double d[2] = {e[0] - z[0], e[1] - z[1]}, size = hypot(d[0], d[1]), limit = rod->limit / rod->stiffness;
    for (int i = 0; i < 2; i++) slip[i] = size > limit ? d[i] * (1.0 - limit / size) : 0.0;
    return size > limit * (1.0 + 1e-12);
}

static int32_t bend(const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
    (void)message;
    const Rod *rod = instance;
    for (uint32_t k = 0; k < out->count; k++) {
        const double *e = strains + 3 * k, *z = out->memory + 2 * k;
        double slip[2];
        const int is_slipping = slips(rod, e, z, slip);
        const double d[2] = {e[0] - z[0], e[1] - z[1]}, size = hypot(d[0], d[1]);
        double energy = 0.5 * rod->elastic[2] * e[2] * e[2] + rod->limit * hypot(slip[0], slip[1]);
        for (int i = 0; i < 2; i++) {
            const double spring = d[i] - slip[i];
            energy += 0.5 * (rod->elastic[i] * e[i] * e[i] + rod->stiffness * spring * spring);
            if (out->gradient) out->gradient[3 * k + i] = rod->elastic[i] * e[i] + rod->stiffness * spring;
        }
        if (out->energy) out->energy[k] = energy;
        if (out->gradient) out->gradient[3 * k + 2] = rod->elastic[2] * e[2];
        for (int i = 0; out->hessian && i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                double own = (i == j) * rod->elastic[i];
                if (i < 2 && j < 2 && !is_slipping) own += (i == j) * rod->stiffness;
                if (i < 2 && j < 2 && is_slipping) own += rod->limit / size * ((i == j) - d[i] * d[j] / (size * size));
                out->hessian[9 * k + 3 * i + j] = own;
            }
        }
    }
    return WIRELOOM_STATUS_OK;
}

static int32_t stretch(const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
    (void)instance, (void)strains, (void)out, (void)message;
    return WIRELOOM_STATUS_ERROR;
}

static int32_t commit(const void *instance, const double *strains, WireloomRodCommit *committed, WireloomText *message) {
    (void)message;
    const Rod *rod = instance;
    for (uint32_t k = 0; k < committed->count; k++) {
        double *z = committed->memory + 2 * k, slip[2];
        if (!slips(rod, strains + 3 * k, z, slip)) continue;
        for (int i = 0; i < 2; i++) z[i] += (CASE == 6 ? 2.0 : 1.0) * slip[i];
        committed->dissipated[k] = (CASE == 5 ? -1.0 : 1.0) * rod->limit * hypot(slip[0], slip[1]);
    }
    if (CASE == 4) committed->memory[1] = NAN;
    if (CASE == 7) committed->memory[2 * committed->count] = 0.0;
    if (CASE == 8) committed->dissipated[0] = 1e-3;
    return WIRELOOM_STATUS_OK;
}

static const WireloomRodKind functions = {
    .size = sizeof functions,
    .create = create,
    .destroy = destroy,
    .stretch = stretch,
    .bend = bend,
    .commit = CASE == 1 ? NULL : commit,
};

#define POSITIVE WIRELOOM_FORM_NUMBER, .presence = WIRELOOM_PRESENCE_REQUIRED, .minimum_excluded = 1, .maximum = INFINITY

static const WireloomParameter parameters[] = {
    {.name = "slip_stiffness", .doc = "k", .form = POSITIVE, .quantity = WIRELOOM_QUANTITY_BENDING_STIFFNESS},
    {.name = "slip_moment", .doc = "M", .form = POSITIVE, .quantity = WIRELOOM_QUANTITY_MOMENT},
};

static const WireloomKind kind = {
    .family = WIRELOOM_FAMILY_ROD,
    .name = "slipping",
    .doc = "its wires slip on each other",
    .parameter_count = 2,
    .parameter_stride = sizeof parameters[0],
    .parameters = parameters,
    .rod = &functions,
};

static const WireloomKinds all = {.size = sizeof all, .count = 1, .stride = sizeof kind, .first = &kind};

static const WireloomKinds *kinds(WireloomText *message) {
    (void)message;
    return &all;
}

WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = WIRELOOM_MAGIC,
    .size = sizeof wireloom_plugin,
    .abi_major = WIRELOOM_ABI_MAJOR,
    .abi_minor = WIRELOOM_ABI_MINOR,
    .name = "slipping",
    .version = "0.0.1",
    .doc = "makes rods that remember",
    .kinds = kinds,
};
