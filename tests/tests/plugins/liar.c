/* A plugin for `plugin check`: CASE says what is right or wrong about it (see check.rs). */

#define _GNU_SOURCE
#include "wireloom_plugin.h"
#include <fenv.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Shape of the potential around the target, k N/m or N: sharp hyperbola sqrt(r^2 + EPSILON^2), cone r, or r^2 / 2. */
#ifndef EPSILON
#define EPSILON 1e-4
#endif
#define SHARP (CASE == 1)
#define CONE (CASE == 2)
/* A cone as an equation, with its curvature; beside a spring; and with the curvature of the spring for both. */
#define BOTH (CASE == 4 || CASE == 13)
#define EQUATION (CASE == 3 || BOTH)

static int32_t create(const WireloomKind *kind, const WireloomConstraintSpec *spec, void **instance,
                      WireloomDescription *description, WireloomText *message) {
    (void)kind, (void)spec, (void)message;
    static const double memory = 0.0;
    static const double scale = 1.0;
    *instance = calloc(1, 16);
    description->shape = BOTH       ? WIRELOOM_SHAPE_POTENTIAL_AND_EQUATIONS
                         : EQUATION ? WIRELOOM_SHAPE_EQUATIONS
                                    : WIRELOOM_SHAPE_POTENTIAL;
    description->objective = !EQUATION;
    description->residual_count = EQUATION;
    description->scales = &scale;
    description->has_gradient = 1;
    description->has_hessian = CASE != 10;
    description->memory_count = CASE == 12 || CASE == 23;
    description->memory = &memory;
#if CASE == 25
    memset(description + 1, 7, 8);
#endif
    return WIRELOOM_STATUS_OK;
}

static void destroy(void *instance) { free(instance); }

static int32_t evaluate(const void *instance, const WireloomSituation *at, WireloomEvaluation *out,
                        WireloomText *message) {
    (void)instance, (void)message;
    double d[3], square = 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = at->stations[0].position[i] - at->targets[0].position[i];
        square += d[i] * d[i];
    }
#if CASE == 30
    fesetround(FE_TOWARDZERO);
#elif CASE == 32
    if (square > 0.5) _exit(0);
#endif
#if EQUATION
    /* c = sqrt(x^2 + y^2) - z / 2. */
    const double r = hypot(d[0], d[1]);
    if (out->residuals) out->residuals[0] = r - 0.5 * d[2];
    if (out->jacobian) {
        /* At its apex a cone has any slope between those around. */
        const double s = r > 0.0 ? 1.0 / r : 0.0, j[6] = {s * d[0], s * d[1], -0.5, 0.0, 0.0, 0.0};
        memcpy(out->jacobian, j, sizeof j);
    }
    if (out->hessian && out->weights && CASE != 13) {
        const double w = r > 0.0 ? out->weights[0] / (r * r * r) : 0.0;
        memset(out->hessian, 0, 36 * sizeof(double));
        out->hessian[0] = w * d[1] * d[1];
        out->hessian[1] = out->hessian[6] = -w * d[0] * d[1];
        out->hessian[7] = w * d[0] * d[0];
        return WIRELOOM_STATUS_OK;
    }
    if (!BOTH) return WIRELOOM_STATUS_OK;
#endif
    /* E = k f(r), dE/dd = k g d, d2E/dd2 = k (g I + h d d'). */
    const double size = SHARP ? sqrt(square + EPSILON * EPSILON) : sqrt(square);
    const double f = SHARP || CONE ? size : 0.5 * square;
    const double g = !(SHARP || CONE) ? 1.0 : size > 0.0 ? 1.0 / size : 0.0;
    const double h = !(SHARP || CONE) ? 0.0 : size > 0.0 ? -1.0 / (size * size * size) : 0.0;
    const double k = 3.0;
    double lie = CASE == 10 ? 2.0 : CASE == 11 ? 1.01 : 1.0;
    if (CASE == 12 && at->memory[0] > 0.0) lie = 7.0;
    if (out->energy) *out->energy = k * f;
    if (out->energy && CASE == 20) out->energy[1] = 1.0;
    if (out->gradient) {
        for (int i = 0; i < 6; i++) out->gradient[i] = i < 3 ? lie * k * g * d[i] : 0.0;
        if (CASE == 21) out->gradient[6] = 0.0;
    }
    if (out->hessian) {
        for (int i = 0; i < 36; i++) {
            const int row = i / 6, column = i % 6;
            out->hessian[i] =
                row < 3 && column < 3 ? (CASE == 12 ? 1.0 : lie) * k * ((row == column) * g + h * d[row] * d[column]) : 0.0;
        }
        if (CASE == 22) out->hessian[36] = 0.0;
        if (CASE == 26) out->hessian[-1] = 0.0;
    }
    return WIRELOOM_STATUS_OK;
}

static int32_t commit(const void *instance, const WireloomSituation *at, double *memory, WireloomText *message) {
    (void)instance, (void)at, (void)message;
    if (CASE == 12) memory[0] = 1.0;
    if (CASE == 23) memory[1] = 1.0;
    return WIRELOOM_STATUS_OK;
}

static int32_t report(const void *instance, const WireloomSituation *at, double *values, WireloomText *message) {
    (void)instance, (void)at, (void)message;
    values[0] = 1.0;
    if (CASE == 24) values[1] = 1.0;
    return WIRELOOM_STATUS_OK;
}

static const WireloomOutput outputs[] = {{.name = "one", .doc = "of one", .quantity = WIRELOOM_QUANTITY_LENGTH}};

static const WireloomConstraintKind functions = {
    .size = sizeof functions, .stations_min = 1, .stations_max = 1,
    .create = create, .destroy = destroy, .evaluate = evaluate, .commit = commit,
    .output_count = CASE == 24, .output_stride = sizeof outputs[0], .outputs = outputs, .report = report,
};

static const WireloomKind kinds[] = {
    {.family = WIRELOOM_FAMILY_CONSTRAINT, .name = "liar", .doc = "may lie", .constraint = &functions},
};

static const WireloomKinds list = {.size = sizeof list, .count = 1, .stride = sizeof kinds[0], .first = kinds};

static const WireloomKinds *list_kinds(WireloomText *message) {
    (void)message;
#if CASE == 31
    fesetround(FE_UPWARD);
#endif
    return &list;
}

WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = WIRELOOM_MAGIC, .size = sizeof wireloom_plugin,
    .abi_major = WIRELOOM_ABI_MAJOR, .abi_minor = WIRELOOM_ABI_MINOR,
    .name = "liar", .version = "0.0.1", .doc = "may lie", .kinds = list_kinds,
};
