// Carries out the scenario of its argument, and prints energies, the arrays of branches, constraints and requirements as
// the bits that they are. The test compares them with those of the Rust library.

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <wireloom.h>

static WireloomError error = {.size = sizeof error};

#define DO(call)                                                                          \
    do {                                                                                  \
        if ((call) != WIRELOOM_CODE_OK) {                                                 \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, error.message);            \
            return 1;                                                                     \
        }                                                                                 \
    } while (0)

static void bits(const char *name, const double *values, size_t count) {
    printf("%s", name);
    for (size_t k = 0; k < count; k++) {
        uint64_t own;
        memcpy(&own, &values[k], sizeof own);
        printf(" %016" PRIx64, own);
    }
    printf("\n");
}

static int on_progress(void *user, const WireloomProgress *progress) {
    size_t *calls = user;
    *calls += progress->increment <= progress->increment_count;
    return 0;
}

static int step_of(WireloomResult result, size_t index) {
    WireloomStep step = {.size = sizeof step};
    DO(wireloom_result_step(result, index, &step, &error));
    printf("step %s %zu of %zu stable %d\n", step.name, step.increment, step.increment_count, step.stable);
    const WireloomEnergy e = step.energy;
    const double energy[] = {e.total,   e.stretch, e.shear, e.bend,      e.twist,
                             e.gravity, e.load,    e.joint, e.constraint};
    bits("energy", energy, 9);
    for (size_t k = 0; k < step.branch_count; k++) {
        WireloomBranch branch = {.size = sizeof branch};
        DO(wireloom_result_branch(result, index, k, &branch, &error));
        size_t n = branch.node_count, found;
        printf("branch %s\n", branch.name);
        bits("s", branch.s, n);
        bits("position", branch.position, 3 * n);
        bits("d1", branch.d1, 3 * n);
        bits("d3", branch.d3, 3 * n);
        bits("force", branch.force, 3 * n);
        bits("moment", branch.moment, 3 * n);
        bits("bend_radius", branch.bend_radius, n);
        for (size_t part = 0; part < branch.section_count; part++) {
            WireloomSection own = {.size = sizeof own};
            DO(wireloom_result_section(result, index, k, part, &own, &error));
            const double values[] = {own.from, own.to, own.diameter, own.bend_radius_limit, own.axial_stiffness};
            bits(own.name, values, 5);
        }
        DO(wireloom_result_find(result, index, WIRELOOM_FAMILY_BRANCH, branch.name, &found, &error));
        if (found != k) {
            return 1;
        }
    }
    for (size_t k = 0; k < step.constraint_count; k++) {
        WireloomConstraint own = {.size = sizeof own};
        DO(wireloom_result_constraint(result, index, k, &own, &error));
        printf("constraint %s %s\n", own.name, own.kind);
        bits("force", own.force, 3);
        bits("moment", own.moment, 3);
        bits("orientation", own.orientation, 4);
    }
    return 0;
}

int main(int count, char **arguments) {
    WireloomScenario scenario;
    WireloomResult result;
    size_t calls = 0;
    DO(wireloom_scenario_read(arguments[count - 1], &scenario, &error));
    const WireloomRunOptions options = {.size = sizeof options, .on_progress = on_progress, .user = &calls};
    DO(wireloom_run(scenario, &options, &result, &error));
    DO(wireloom_scenario_free(scenario));
    WireloomSummary summary = {.size = sizeof summary};
    DO(wireloom_result_get(result, &summary, &error));
    printf("%s status %d verdict %d after %zu increments\n", summary.scenario, summary.status, summary.verdict, calls);
    for (size_t k = 0; k < summary.step_count; k++) {
        if (step_of(result, k)) {
            return 1;
        }
    }
    for (size_t k = 0; k < summary.event_count; k++) {
        WireloomEvent own = {.size = sizeof own};
        DO(wireloom_result_event(result, k, &own, &error));
        printf("event %s at %s from %s %zu: %s\n", own.kind, own.place.words, own.first.step, own.first.increment,
               own.message);
    }
    for (size_t k = 0; k < summary.requirement_count; k++) {
        WireloomRequirement own = {.size = sizeof own};
        DO(wireloom_result_requirement(result, k, &own, &error));
        printf("requirement %s verdict %d at %s\n", own.name, own.verdict, own.place.words);
        bits("worst", &own.worst, 1);
        bits("limit", &own.limit, 1);
    }
    DO(wireloom_result_free(result));
    return 0;
}
