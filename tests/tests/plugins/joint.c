// A joint model for two arms: a bend-twist spring between them, with the stiffness of the arms over the mean of their segments at the joint. With CASE
// from 1 to 15 it does one thing wrong; with CASE 20 it is a compliant hub, with springs between arms and hub, and with
// CASE 21 also with an element of friction in bending between them: it remembers how far each arm has slipped.
#include "wireloom_plugin.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef CASE
#define CASE 0
#endif
#define IS_HUB (CASE == 20 || CASE == 21)

// Of the element of friction, N m/rad and N m.
static const double element = 0.2, limit = 0.01;
static const double no_slips[32];

typedef struct { double rest[16][4], stiffness[3], springs[16][3]; uint32_t arms; } Joint;

static void product(const double a[4], const double b[4], double c[4]) {
    c[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    c[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    c[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    c[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

static void inverse(const double a[4], double c[4]) {
    c[0] = a[0];
    for (int i = 1; i < 4; i++) c[i] = -a[i];
}

static int32_t create(const WireloomKind *kind, const WireloomJointSpec *spec, void **instance,
                      WireloomJointDescription *description, WireloomText *message) {
    (void)kind;
    if (IS_HUB ? spec->arm_count > 16 : spec->arm_count != 2) {
        strncpy(message->data, "it joins two arms, not more", message->capacity - 1);
        return WIRELOOM_STATUS_ERROR;
    }
    Joint *joint = malloc(sizeof *joint);
    const WireloomArm *first = spec->arms;
    const WireloomArm *second = (const WireloomArm *)((const char *)spec->arms + spec->arm_stride);
    const double length = 0.5 * (first->segment_length + second->segment_length);
    joint->stiffness[0] = first->bending_stiffness[0] / length;
    joint->stiffness[1] = first->bending_stiffness[1] / length;
    joint->stiffness[2] = first->torsion_stiffness / length;
    for (uint32_t a = 0; a < spec->arm_count; a++) {
        const WireloomArm *arm = (const WireloomArm *)((const char *)spec->arms + a * spec->arm_stride);
        memcpy(joint->rest[a], arm->rest, sizeof arm->rest);
        memcpy(joint->springs[a], arm->spring_bending, sizeof arm->spring_bending);
        joint->springs[a][2] = arm->spring_torsion;
    }
    description->mounting = CASE == 1    ? 0
                            : CASE == 2  ? 7
                            : IS_HUB     ? WIRELOOM_MOUNTING_COMPLIANT_HUB
                                         : WIRELOOM_MOUNTING_POINT;
    description->thread_safe = 1;
    if (CASE == 21) {
        description->memory = no_slips;
        description->memory_count = 2 * spec->arm_count;
    }
    joint->arms = spec->arm_count;
    *instance = CASE == 3 ? NULL : joint;
    return WIRELOOM_STATUS_OK;
}

static void destroy(void *instance) { free(instance); }

// The rotation vector of a quaternion.
static void angles(const double q[4], double phi[3]) {
    const double length = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double sign = q[0] < 0 ? -1 : 1;
    const double factor = length > 1e-12 ? sign * 2 * atan2(length, sign * q[0]) / length : sign * 2;
    for (int i = 0; i < 3; i++) phi[i] = factor * q[i + 1];
}

// phi . C phi / 2
static double spring(const double phi[3], const double stiffness[3]) {
    double energy = 0;
    for (int i = 0; i < 3; i++) energy += 0.5 * stiffness[i] * phi[i] * phi[i];
    return energy;
}

// phi = log(q^-1 h r) of an arm and its hub h.
static void of_arm(const Joint *joint, const double *frames, uint32_t arm, double phi[3]) {
    double back[4], rest[4], all[4];
    inverse(frames + 4 * arm, back);
    product(frames + 4 * joint->arms, joint->rest[arm], rest);
    product(back, rest, all);
    angles(all, phi);
}

// What the element stores and dissipates from the slips p on: k d^2/2, or M d - M^2/2k beyond its limit.
static double friction(const double phi[3], const double *p) {
    const double d = hypot(phi[0] - p[0], phi[1] - p[1]);
    return d > limit / element ? limit * d - 0.5 * limit * limit / element : 0.5 * element * d * d;
}

static int32_t commit(const void *instance, const double *frames, double *memory, WireloomText *message) {
    (void)message;
    const Joint *joint = instance;
    for (uint32_t a = 0; a < joint->arms; a++) {
        double phi[3], *p = memory + 2 * a;
        of_arm(joint, frames, a, phi);
        const double x = phi[0] - p[0], y = phi[1] - p[1], d = hypot(x, y), stays = limit / element;
        // Above round-off, so that a second call changes nothing.
        if (d > stays * (1 + 1e-10)) {
            p[0] += x * (1 - stays / d);
            p[1] += y * (1 - stays / d);
        }
    }
    return WIRELOOM_STATUS_OK;
}

// phi = log(q0^-1 q1 r1^-1 r0); of a hub that of each arm.
static int32_t evaluate(const void *instance, const double *frames, WireloomJointEvaluation *evaluation,
                        WireloomText *message) {
    (void)message;
    const Joint *joint = instance;
    double back[4], turn[4], rest[4], all[4], phi[3];
    if (IS_HUB) {
        double energy = 0;
        for (uint32_t a = 0; a < joint->arms; a++) {
            of_arm(joint, frames, a, phi);
            energy += spring(phi, joint->springs[a]);
            if (CASE == 21) energy += friction(phi, evaluation->memory + 2 * a);
        }
        *evaluation->energy = energy;
        return WIRELOOM_STATUS_OK;
    }
    inverse(frames, back);
    product(back, frames + 4, turn);
    inverse(joint->rest[1], back);
    product(back, joint->rest[0], rest);
    product(turn, rest, all);
    angles(all, phi);
    double energy = spring(phi, joint->stiffness);
    if (CASE == 4) energy = NAN;
    if (CASE == 5) return -3;
    if (CASE == 6) for (;;) usleep(1000);
    if (CASE == 7) *(volatile int *)16 = 1;
    if (evaluation->energy && CASE != 8) *evaluation->energy = energy;
    return WIRELOOM_STATUS_OK;
}

static const WireloomJointKind functions = {
    .size = CASE == 9 ? 8 : sizeof functions,
    .create = create,
    .destroy = CASE == 10 ? NULL : destroy,
    .evaluate = CASE == 11 ? NULL : evaluate,
    .commit = CASE == 21 ? commit : NULL,
};

static const WireloomKind kind = {
    .family = CASE == 12 ? 4 : WIRELOOM_FAMILY_JOINT,
    .name = CASE == 13 ? "fused" : "two-arm-spring",
    .doc = "a spring between two arms",
    .joint = CASE == 14 ? NULL : &functions,
};

static const WireloomKinds all = {
    .size = sizeof all,
    .count = 1,
    // ABI 1.0 had no joints; with CASE 22 it is a plugin of ABI 1.6, which had no rods.
    .stride = CASE == 15 ? offsetof(WireloomKind, joint) : CASE == 22 ? offsetof(WireloomKind, rod) : sizeof kind,
    .first = &kind,
};

static const WireloomKinds *kinds(WireloomText *message) {
    (void)message;
    return &all;
}

WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {
    .magic = WIRELOOM_MAGIC,
    .size = sizeof wireloom_plugin,
    .abi_major = WIRELOOM_ABI_MAJOR,
    .abi_minor = CASE == 22 ? 6 : WIRELOOM_ABI_MINOR,
    .name = "joiner",
    .version = "0.0.1",
    .doc = "joins",
    .kinds = kinds,
};
