/* A plugin that does one thing wrong: which one, CASE says (see hostile.rs, where the words are that each must bring). CASE 0 does nothing wrong. */

#define _GNU_SOURCE
#include "wireloom_plugin.h"
#include <dlfcn.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>


/* Increments that have ended. */
static int ended = 0;

__attribute__((constructor)) static void loaded(void) {
#if defined(TELLTALE)
    FILE *file = fopen("telltale", "w");
    if (file) fclose(file);
#endif
#if CASE == 50
    raise(SIGSEGV);
#elif CASE == 51
    _Exit(0);
#elif CASE == 52
    for (;;) usleep(1000);
#endif
}

/* What a crash is made of. */
static inline void crash(void) { *(volatile int *)16 = 1; }

static inline double deeper(volatile double *from) {
    volatile double here[512];
    here[0] = *from + 1.0;
    return here[0] > 0.0 ? deeper(here) + here[1] : 0.0;
}

static int32_t create(const WireloomKind *kind, const WireloomConstraintSpec *spec, void **instance,
                      WireloomDescription *description, WireloomText *message) {
    (void)kind;
    (void)spec;
    (void)message;
#if CASE == 30
    snprintf(message->data, message->capacity, "I will not, since it is Saturday");
    return WIRELOOM_STATUS_ERROR;
#elif CASE == 31
    return 77;
#elif CASE == 32
    return WIRELOOM_STATUS_OK;
#elif CASE == 34
    crash();
#elif CASE == 35
    exit(0);
#elif CASE == 36
    for (;;) usleep(1000);
#endif
    static const double memory = CASE == 70 ? NAN : 0.0;
    *instance = calloc(1, 16);
#if CASE == 33
    return WIRELOOM_STATUS_OK;
#endif
    description->shape = CASE == 71 ? 99 : CASE == 72 ? WIRELOOM_SHAPE_EQUATIONS : WIRELOOM_SHAPE_POTENTIAL;
    description->objective = 1;
    description->has_gradient = 1;
    description->has_hessian = CASE == 61 ? 0 : 1;
    description->memory_count = CASE == 73 ? 4000000000u : 1;
    description->memory = CASE == 74 ? (const double *)8 : &memory;
#if CASE >= 75 && CASE <= 77
    description->shape = WIRELOOM_SHAPE_PRESCRIBED;
    description->hold.position = CASE == 75 ? 0 : 1;
    description->hold.rail_count = CASE == 76 ? 5 : 0;
    description->hold.rotation = CASE == 77 ? 12 : WIRELOOM_ROTATION_FREE;
#endif
    return WIRELOOM_STATUS_OK;
}

static void destroy(void *instance) {
#if CASE == 60
    if (ended) crash();
#endif
    free(instance);
}

static int32_t evaluate(const void *instance, const WireloomSituation *at, WireloomEvaluation *out,
                        WireloomText *message) {
    (void)instance;
    (void)message;
#if CASE == 37
    if (ended) crash();
#elif CASE == 38
    if (ended) for (;;) usleep(1000);
#elif CASE == 39
    if (ended) abort();
#elif CASE == 40
    if (ended) exit(0);
#elif CASE == 41
    volatile double depth = 0.0;
    if (ended) return deeper(&depth) > 0.0;
#elif CASE == 42
    if (ended) {
        snprintf(message->data, message->capacity, "the table has no entry for this");
        return WIRELOOM_STATUS_ERROR;
    }
#elif CASE == 43
    if (ended) return -5;
#elif CASE == 44
    if (ended) {
        memset(message->data, 'x', message->capacity);
        return WIRELOOM_STATUS_ERROR;
    }
#elif CASE == 101
    if (ended) _exit(0);
#elif CASE == 102
    if (ended) {
        volatile char *small = malloc(24);
        for (int i = 0; i < 1 << 16; i++) small[i] = -1;
    }
#elif CASE == 49
    if (ended) dlclose(dlopen("./libhostile.so", RTLD_NOW)), dlclose(dlopen("./libhostile.so", RTLD_NOW));
#endif
#if defined(OTHER)
    const double k = 2.0;
#else
    const double k = 1.0;
#endif
    double d[3], energy = 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = at->stations[0].position[i] - at->targets[0].position[i];
        energy += 0.5 * k * d[i] * d[i];
    }
    if (out->energy) *out->energy = CASE == 45 && ended ? NAN : energy;
    if (out->gradient && !(CASE == 46 && ended)) {
        for (int i = 0; i < 6; i++) out->gradient[i] = i < 3 ? k * d[i] : 0.0;
    }
    if (out->hessian) {
        for (int i = 0; i < 36; i++) out->hessian[i] = i / 6 == i % 6 && i % 6 < 3 ? k : 0.0;
        if (CASE == 47 && ended) out->hessian[7] = INFINITY;
    }
    return WIRELOOM_STATUS_OK;
}

static int32_t target(const void *instance, const WireloomPose *base, double progress, WireloomPose *to,
                      WireloomText *message) {
    (void)instance;
    (void)progress;
    (void)message;
    *to = *base;
    if (CASE == 65) to->position[1] = NAN;
    if (CASE == 66) to->orientation[0] = 7.0;
    return WIRELOOM_STATUS_OK;
}

static int32_t commit(const void *instance, const WireloomSituation *at, double *memory, WireloomText *message) {
    (void)instance;
    (void)at;
    (void)message;
    ended++;
    memory[0] += 1.0;
    if (CASE == 48) memory[0] = NAN;
    return WIRELOOM_STATUS_OK;
}

static int32_t report(const void *instance, const WireloomSituation *at, double *values, WireloomText *message) {
    (void)instance;
    (void)at;
    (void)message;
    values[0] = CASE == 67 ? NAN : 1.0;
    if (CASE != 68) values[1] = 2.0;
    return WIRELOOM_STATUS_OK;
}

static const WireloomOutput outputs[] = {
    {.name = "first", .doc = "of two", .quantity = CASE == 56 ? 99 : WIRELOOM_QUANTITY_LENGTH},
    {.name = CASE == 55 ? "first" : "second", .doc = "of two", .quantity = WIRELOOM_QUANTITY_FORCE},
};

static const char *const words[] = {"a", "b"};

static const WireloomParameter parameters[] = {
    {.name = CASE == 20 ? "no name" : "one",
     .doc = "of two",
     .form = CASE == 21 ? 17 : WIRELOOM_FORM_NUMBER,
     .quantity = CASE == 22 ? 99 : WIRELOOM_QUANTITY_LENGTH,
     .presence = CASE == 23 ? 5 : WIRELOOM_PRESENCE_DEFAULT,
     .minimum = CASE == 24 ? NAN : 0.0,
     .maximum = 1.0,
     .default_value = {CASE == 25 ? 7.0 : 0.5}},
    {.name = CASE == 26 ? "one" : "other",
     .doc = CASE == 27 ? NULL : "of two",
     .form = WIRELOOM_FORM_CHOICE,
     .presence = WIRELOOM_PRESENCE_DEFAULT,
     .choices = CASE == 28 ? NULL : words,
     .choice_count = CASE == 29 ? 0 : 2},
};

static const WireloomConstraintKind functions = {
    /* Outputs came with ABI 1.3; a plugin that was built before has a shorter table. */
    .size = CASE == 12 ? 8 : CASE == 63 ? offsetof(WireloomConstraintKind, output_count) : sizeof functions,
    .stations_min = CASE == 13 ? 3 : 1,
    .stations_max = CASE == 14 ? 1000000 : 1,
    .span = CASE == 15 ? 3 : 0,
    .create = CASE == 16 ? NULL : create,
    .destroy = CASE == 17 ? NULL : destroy,
    .evaluate = CASE == 18 ? NULL : evaluate,
    .target = CASE == 65 || CASE == 66 ? target : NULL,
    .commit = commit,
    .output_count = CASE == 53 ? 100000 : (CASE >= 54 && CASE <= 57) || CASE == 64 || CASE == 67 || CASE == 68 ? 2 : 0,
    .output_stride = CASE == 57 ? 8 : sizeof outputs[0],
    .outputs = outputs,
    .report = CASE == 54 ? NULL : report,
};

#define KIND(kind_name)                                                        \
    {                                                                          \
        .family = CASE == 8 ? 4 : WIRELOOM_FAMILY_CONSTRAINT,                  \
        .name = kind_name, .doc = "does something wrong",                      \
        .parameter_count = CASE == 19 ? 100000 : 2,                            \
        .parameter_stride = CASE == 11 ? 3 : sizeof parameters[0],             \
        .parameters = parameters, .constraint = CASE == 9 ? NULL : &functions, \
    }

static const WireloomKind kinds[] = {
    KIND(CASE == 5 ? "" : CASE == 6 ? "collar" : CASE == 7 ? "gr\xfc\xdf" : "hostile"),
    KIND(CASE == 10 ? "hostile" : "another"),
};

static const WireloomKinds list = {
    .size = CASE == 80 ? 4 : sizeof list,
    .count = CASE == 81 ? 4000000000u : CASE == 82 ? 0 : 2,
    .stride = CASE == 83 ? 8 : CASE == 84 ? 4000000000u : sizeof kinds[0],
    .first = CASE == 85 ? NULL : CASE == 86 ? (const WireloomKind *)((const char *)kinds + 3) : kinds,
};

static const WireloomKinds *list_kinds(WireloomText *message) {
    (void)message;
#if CASE == 87
    snprintf(message->data, message->capacity, "the licence server does not answer");
    return NULL;
#elif CASE == 88
    return (const WireloomKinds *)24;
#elif CASE == 89
    crash();
#endif
    return &list;
}

static int32_t note(const char *kind, const void *instance, uint32_t index, WireloomText *text) {
    (void)kind;
    (void)instance;
    snprintf(text->data, text->capacity, "mind the gap");
    return index == 0 ? WIRELOOM_STATUS_OK : WIRELOOM_STATUS_ERROR;
}

static const void *get_extension(const char *id) {
    static const WireloomNotes notes = {.size = sizeof notes, .note = note};
    if (strcmp(id, "wireloom.draft.notes/1") != 0) return NULL;
    return CASE == 98 ? (const void *)1 : &notes;
}

static const char endless[8192] = {[0 ... 8191] = 'a'};

/* An entry as it might have been in a minor version before this one, had there been one: without what came last. */
#if CASE == 90
#define ENTRY_SIZE offsetof(WireloomEntry, get_extension)
#elif CASE == 91
#define ENTRY_SIZE 4000000000u
#else
#define ENTRY_SIZE sizeof(WireloomEntry)
#endif

#if defined(OTHER)
#define VERSION "0.0.2"
#else
#define VERSION "0.0.1"
#endif

#if CASE == 1
WIRELOOM_EXPORT const int another_name;
const int another_name = sizeof endless;
const void *const used[] = {&list_kinds, &get_extension};
#else
WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = CASE == 2 ? 0x1122334455667788 : WIRELOOM_MAGIC,
    .size = ENTRY_SIZE,
    .abi_major = CASE == 3 ? 2 : WIRELOOM_ABI_MAJOR,
    .abi_minor = CASE == 4 ? 900 : CASE == 63 ? 2 : WIRELOOM_ABI_MINOR,
    .name = CASE == 92 ? NULL : CASE == 93 ? endless : CASE == 94 ? "two words" : "hostile",
    .version = CASE == 95 ? NULL : VERSION,
    .doc = CASE == 96 ? "\xff\xfe" : "does something wrong",
    .kinds = CASE == 97 ? NULL : list_kinds,
    .get_extension = CASE == 62 || CASE == 98 ? get_extension : NULL,
};
#endif
