// A rod of linear laws of stretch and bending, with the stiffnesses of its section. With CASE from 1 to 19 it does one
// thing wrong that a run finds at once; from 30 on its numbers are wrong; with 20 it leaves second derivatives to the
// program.
#include "wireloom_plugin.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef CASE
#define CASE 0
#endif

typedef struct { double stretch[3], bend[3]; } Rod;

static int32_t create(const WireloomKind *kind, const WireloomRodSpec *spec, void **instance,
                      WireloomRodDescription *description, WireloomText *message) {
    (void)kind;
    if (CASE == 1) return WIRELOOM_STATUS_OK;
    if (CASE == 16 || spec->length > 100.0) {
        strncpy(message->data, "it is too long", message->capacity - 1);
        return WIRELOOM_STATUS_ERROR;
    }
    Rod *rod = malloc(sizeof *rod);
    memcpy(rod->stretch, spec->shear_stiffness, sizeof spec->shear_stiffness);
    rod->stretch[2] = spec->axial_stiffness;
    memcpy(rod->bend, spec->bending_stiffness, sizeof spec->bending_stiffness);
    rod->bend[2] = spec->torsion_stiffness;
    description->has_stretch = description->has_bend = CASE != 2;
    description->has_hessian = CASE != 20;
    description->thread_safe = 1;
    if (CASE == 17) memset(description + 1, 7, 8);
    *instance = rod;
    return WIRELOOM_STATUS_OK;
}

static void destroy(void *instance) { free(instance); }

static int32_t respond(const double *stiffness, const double *strains, WireloomRodResponse *out) {
    const double lie = CASE == 30 ? 2.0 : CASE == 31 ? 0.0 : 1.0;
    const double second = CASE == 32 ? 1.5 : lie;
    for (uint32_t k = 0; k < out->count; k++) {
        const double *e = strains + 3 * k;
        double energy = 0.0;
        for (int i = 0; i < 3; i++) {
            energy += 0.5 * stiffness[i] * e[i] * e[i];
            if (CASE == 33 && i == 0) energy += 1e-3 * stiffness[i] * e[i] * e[i] * e[i];
            if (out->gradient) out->gradient[3 * k + i] = lie * stiffness[i] * e[i];
            if (CASE == 33 && i == 0 && out->gradient) out->gradient[3 * k] += 3e-3 * stiffness[i] * e[i] * e[i];
            for (int j = 0; out->hessian && j < 3; j++) {
                out->hessian[9 * k + 3 * i + j] = (i == j) * second * stiffness[i];
                if (CASE == 34 && i < j) out->hessian[9 * k + 3 * i + j] = 0.1 * stiffness[i];
            }
        }
        if (CASE == 35) energy += 1e-3;
        if (out->energy && CASE != 8) out->energy[k] = energy;
    }
    if (out->gradient && CASE == 4) out->gradient[3 * out->count - 1] = NAN;
    if (out->gradient && CASE == 14) out->gradient[3 * out->count] = 0.0;
    if (out->hessian && CASE == 15) out->hessian[-1] = 0.0;
    return WIRELOOM_STATUS_OK;
}

static int32_t stretch(const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
    (void)message;
    return respond(((const Rod *)instance)->stretch, strains, out);
}

static int32_t bend(const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
    (void)message;
    if (CASE == 5) return -3;
    if (CASE == 6) for (;;) usleep(1000);
    if (CASE == 7) *(volatile int *)16 = 1;
    return respond(((const Rod *)instance)->bend, strains, out);
}

static const WireloomRodKind functions = {
    .size = CASE == 9 ? 8 : sizeof functions,
    .create = create,
    .destroy = CASE == 10 ? NULL : destroy,
    .stretch = stretch,
    .bend = CASE == 3 ? NULL : bend,
};

static const WireloomParameter parameters[] = {
    {.name = "tightness", .doc = "of nothing", .form = WIRELOOM_FORM_NUMBER,
     .quantity = WIRELOOM_QUANTITY_DIMENSIONLESS, .presence = WIRELOOM_PRESENCE_OPTIONAL, .minimum = 0.0, .maximum = 1.0},
};

static const WireloomKind kind = {
    .family = CASE == 11 ? 4 : WIRELOOM_FAMILY_ROD,
    .name = CASE == 12 ? "kirchhoff" : "straight-laws",
    .doc = "the laws of its section",
    .parameter_count = 1,
    .parameter_stride = sizeof parameters[0],
    .parameters = parameters,
    .rod = CASE == 13 ? NULL : &functions,
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
    .name = "rodder",
    .version = "0.0.1",
    .doc = "makes rods",
    .kinds = kinds,
};
