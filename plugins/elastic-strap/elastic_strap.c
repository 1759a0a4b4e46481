/* `elastic-strap`: a rubber strap between two stations, or a station and a hook. README.md lists the parameters. */

#include "wireloom_plugin.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* A strap: it pulls with k (d - l) if the distance d of its ends exceeds its free length l, and not otherwise. */
typedef struct Strap {
    double stiffness;  /* k, N/m */
    double length;     /* free length, m; below 0: the distance of its ends when it is added */
    double slack;      /* additional length, m */
    double pretension; /* force when it is added, N, if the length is not given */
} Strap;

/* The parameters, in the order of their declaration. */
enum { STIFFNESS, LENGTH, SLACK, PRETENSION };

/* The outputs, in the order of their declaration. */
enum { ELONGATION, TENSION };

static int32_t create(const WireloomKind *kind, const WireloomConstraintSpec *spec, void **instance,
                      WireloomDescription *description, WireloomText *message) {
    (void)kind;
    const WireloomValue *value = spec->values;
    if (value[SLACK].value[0] > 0.0 && value[PRETENSION].value[0] > 0.0) {
        snprintf(message->data, message->capacity, "slack and pretension exclude each other: give one of them");
        return WIRELOOM_STATUS_ERROR;
    }
    if (value[LENGTH].given && value[PRETENSION].value[0] > 0.0) {
        snprintf(message->data, message->capacity, "the free length determines the force: leave pretension out");
        return WIRELOOM_STATUS_ERROR;
    }
    Strap *strap = malloc(sizeof *strap);
    if (strap == NULL) {
        snprintf(message->data, message->capacity, "no memory is left");
        return WIRELOOM_STATUS_ERROR;
    }
    strap->stiffness = value[STIFFNESS].value[0];
    strap->length = value[LENGTH].given ? value[LENGTH].value[0] : -1.0;
    /* One end: the hook is the target, and the default length is 0. */
    if (strap->length < 0.0 && spec->station_count == 1) strap->length = 0.0;
    strap->slack = value[SLACK].value[0];
    strap->pretension = value[PRETENSION].value[0];
    *instance = strap;
    description->shape = WIRELOOM_SHAPE_POTENTIAL;
    description->objective = 1;
    description->thread_safe = 1;
    description->has_gradient = 1;
    description->has_hessian = 1;
    return WIRELOOM_STATUS_OK;
}

static void destroy(void *instance) { free(instance); }

static double difference(const WireloomPose *to, const WireloomPose *from, double d[3]) {
    double square = 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = to->position[i] - from->position[i];
        square += d[i] * d[i];
    }
    return sqrt(square);
}

/* Distance d of the ends less the free length l, m; n: the direction of the strap, zero where its ends meet. */
static double elongation(const Strap *strap, const WireloomSituation *at, double *length, double *d, double n[3]) {
    double apart[3];
    *d = difference(at->station_count == 2 ? &at->stations[1] : &at->targets[0], &at->stations[0], apart);
    *length = strap->length;
    if (*length < 0.0) {
        double unused[3];
        *length = difference(&at->targets[1], &at->targets[0], unused) - strap->pretension / strap->stiffness;
        if (*length < 0.0) *length = 0.0;
    }
    *length += strap->slack;
    for (int i = 0; i < 3; i++) n[i] = *d > 0.0 ? apart[i] / *d : 0.0;
    return *d - *length;
}

/* E = k/2 (d - l)^2 where d > l; with n the direction of the strap dE/dx = -+k (d - l) n, and the second derivative is
   +-k (n n' + (1 - l/d) (I - n n')). A station has six variables, x and the turn. */
static int32_t evaluate(const void *instance, const WireloomSituation *at, WireloomEvaluation *out,
                        WireloomText *message) {
    (void)message;
    const Strap *strap = instance;
    const uint32_t m = at->station_count;
    double n[3], length, d;
    const double drawn = elongation(strap, at, &length, &d, n);
    const double k = drawn > 0.0 ? strap->stiffness : 0.0;
    /* NaN is passed on; a comparison would hide it. */
    if (out->energy) *out->energy = isnan(drawn) ? drawn : 0.5 * k * drawn * drawn;
    if (out->gradient) {
        for (uint32_t i = 0; i < 6 * m; i++) {
            const double sign = i < 6 ? -1.0 : 1.0;
            out->gradient[i] = i % 6 < 3 ? (isnan(drawn) ? drawn : sign * k * drawn * n[i % 6]) : 0.0;
        }
    }
    if (out->hessian) {
        for (uint32_t row = 0; row < 6 * m; row++) {
            for (uint32_t column = 0; column < 6 * m; column++) {
                const uint32_t i = row % 6, j = column % 6;
                double value = 0.0;
                if (i < 3 && j < 3 && k > 0.0) {
                    const double sign = row / 6 == column / 6 ? 1.0 : -1.0;
                    const double across = d > 0.0 ? 1.0 - length / d : 1.0;
                    value = sign * k * (n[i] * n[j] + across * ((i == j) - n[i] * n[j]));
                }
                out->hessian[6 * m * row + column] = value;
            }
        }
    }
    return WIRELOOM_STATUS_OK;
}

static int32_t report(const void *instance, const WireloomSituation *at, double *values, WireloomText *message) {
    (void)message;
    const Strap *strap = instance;
    double n[3], length, d;
    values[ELONGATION] = elongation(strap, at, &length, &d, n);
    values[TENSION] = values[ELONGATION] > 0.0 ? strap->stiffness * values[ELONGATION] : 0.0;
    return WIRELOOM_STATUS_OK;
}

static const WireloomParameter parameters[] = {
    [STIFFNESS] = {.name = "stiffness",
                   .doc = "of the drawn strap",
                   .form = WIRELOOM_FORM_NUMBER,
                   .quantity = WIRELOOM_QUANTITY_FORCE_PER_LENGTH,
                   .presence = WIRELOOM_PRESENCE_REQUIRED,
                   .minimum_excluded = 1,
                   .maximum = INFINITY},
    [LENGTH] = {.name = "length",
                .doc = "free length; left out, the distance at which it is put on (of a hook: none)",
                .form = WIRELOOM_FORM_NUMBER,
                .quantity = WIRELOOM_QUANTITY_LENGTH,
                .presence = WIRELOOM_PRESENCE_OPTIONAL,
                .maximum = INFINITY},
    [SLACK] = {.name = "slack",
               .doc = "how much longer than that it is",
               .form = WIRELOOM_FORM_NUMBER,
               .quantity = WIRELOOM_QUANTITY_LENGTH,
               .presence = WIRELOOM_PRESENCE_DEFAULT,
               .maximum = INFINITY},
    [PRETENSION] = {.name = "pretension",
                    .doc = "how strongly it pulls as it is put on",
                    .form = WIRELOOM_FORM_NUMBER,
                    .quantity = WIRELOOM_QUANTITY_FORCE,
                    .presence = WIRELOOM_PRESENCE_DEFAULT,
                    .maximum = INFINITY},
};

static const WireloomOutput outputs[] = {
    [ELONGATION] = {.name = "elongation",
                    .doc = "distance of the ends beyond the free length; below 0 where the strap is slack",
                    .quantity = WIRELOOM_QUANTITY_LENGTH},
    [TENSION] = {.name = "tension", .doc = "force of the strap", .quantity = WIRELOOM_QUANTITY_FORCE},
};

static const WireloomConstraintKind functions = {
    .size = sizeof functions,
    .stations_min = 1,
    .stations_max = 2,
    .create = create,
    .destroy = destroy,
    .evaluate = evaluate,
    .output_count = sizeof outputs / sizeof outputs[0],
    .output_stride = sizeof outputs[0],
    .outputs = outputs,
    .report = report,
};

static const WireloomKind kinds[] = {
    {.family = WIRELOOM_FAMILY_CONSTRAINT,
     .name = "elastic-strap",
     .doc = "a rubber strap between two places of the harness, or from one to a hook: it pulls, and never pushes",
     .parameter_count = sizeof parameters / sizeof parameters[0],
     .parameter_stride = sizeof parameters[0],
     .parameters = parameters,
     .constraint = &functions},
};

static const WireloomKinds list = {.size = sizeof list, .count = 1, .stride = sizeof kinds[0], .first = kinds};

static const WireloomKinds *list_kinds(WireloomText *message) {
    (void)message;
    return &list;
}

WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = WIRELOOM_MAGIC,
    .size = sizeof wireloom_plugin,
    .abi_major = WIRELOOM_ABI_MAJOR,
    .abi_minor = WIRELOOM_ABI_MINOR,
    .name = "elastic-strap",
    .version = "0.1.0",
    .doc = "a rubber strap",
    .kinds = list_kinds,
};
