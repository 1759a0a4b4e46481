// Ten thousand calls with null pointers, handles that were freed or never were, wrong sizes, names that do not exist,
// texts that are not UTF-8, numbers that are not finite. The test builds it with the address sanitizer.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <wireloom.h>

static uint64_t seed = 20261124;

static uint64_t next(uint64_t below) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (seed >> 33) % below;
}

// Kinds of handles.
enum {
    OF_WireloomScenario,
    OF_WireloomResult,
    OF_WireloomSession,
    OF_WireloomCancel,
    OF_WireloomDiagnostics,
    OF_WireloomText,
    OF_WireloomSensitivities,
    FREED,
    KINDS
};

// A good handle of each kind, or 0, and one that was freed.
static uint64_t handles[KINDS];

// Good ones most of the time, else one of another kind, or of nothing.
static uint64_t handle(int kind) {
    switch (next(8)) {
        case 0:
            return next(2) ? next(1000) : ((uint64_t)next(1u << 31) << 32) | next(1u << 31);
        case 1:
        case 2:
            return handles[next(KINDS)];
        default:
            return handles[kind];
    }
}

static const char *name(void) {
    static const char *const names[] = {"trunk",  "plug-C", "clip-1",   "nobody",           "",
                                        "\xff\xfe", "J",      "joints.J.model", "[[", "branches.left.length"};
    return next(8) ? names[next(10)] : NULL;
}

static const double *numbers(void) {
    static double values[4];
    for (int k = 0; k < 4; k++) {
        const double odd[] = {NAN, INFINITY, -1e308, 0, 0.8, 5e-324};
        values[k] = odd[next(6)];
    }
    return next(4) ? values : NULL;
}

static size_t number(void) {
    const size_t odd[] = {0, 0, 0, 1, 2, SIZE_MAX, SIZE_MAX / 2, (size_t)1 << 60};
    return odd[next(8)];
}

// A struct of the caller with a size that is right, or is not.
static void *out(size_t size) {
    static _Alignas(16) unsigned char memory[8192];
    memset(memory, (int)next(256), sizeof memory);
    const size_t odd[] = {size, size, size, size, 0, size - 1, SIZE_MAX};
    memcpy(memory, &odd[next(7)], sizeof(size_t));
    switch (next(8)) {
        case 0:
            return NULL;
        case 1:
            return memory + 3;
        default:
            return memory;
    }
}

// A place for a handle, or none.
static void *place(void) {
    static uint64_t one;
    return next(4) ? &one : NULL;
}

#define H(type) ((type){handle(OF_##type)})
#define OUT(type) out(sizeof(type))

static WireloomCode one_call(void) {
    static WireloomError own;
    own.size = next(16) ? sizeof own : number();
    WireloomError *error = next(4) ? &own : NULL;
    if (next(32) == 0) {
        error = (WireloomError *)((char *)&own + 4);
    }
    static const char *text;
    static size_t length;
    switch (next(44)) {
        case 0:
            return wireloom_scenario_new(name(), next(2) ? 0 : 1, name(), next(2) ? NULL : place(), error);
        case 1:
            return wireloom_scenario_new(NULL, number(), name(), place(), error);
        case 2:
            return wireloom_scenario_read(name(), place(), error);
        case 3:
            return wireloom_scenario_add_file(H(WireloomScenario), name(), NULL, number(), error);
        case 4:
            return wireloom_scenario_add_body(H(WireloomScenario), NULL, error);
        case 5: {
            static const double corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, NAN};
            static const uint32_t triangles[] = {0, 1, 2, 3, 4000000000u, 0};
            WireloomBody body = {.size = next(2) ? sizeof body : number(),
                                 .name = name(),
                                 .corners = next(4) ? corners : NULL,
                                 .corner_count = next(5),
                                 .triangles = next(4) ? triangles : NULL,
                                 .triangle_count = next(3),
                                 .min_clearance = next(2) ? NAN : INFINITY};
            const double *given = numbers();
            if (given != NULL) {
                memcpy(body.position, given, sizeof body.position);
                memcpy(body.orientation, given, sizeof body.orientation);
            }
            return wireloom_scenario_add_body(H(WireloomScenario), &body, error);
        }
        case 6:
            return wireloom_scenario_set(H(WireloomScenario), name(), name(), error);
        case 7:
            return wireloom_scenario_text(H(WireloomScenario), place(), error);
        case 8:
            return wireloom_scenario_file(H(WireloomScenario), name(), place(), error);
        case 9:
            return wireloom_scenario_check(H(WireloomScenario), place(), place(), error);
        case 10:
            return wireloom_diagnostics_get(H(WireloomDiagnostics), number(), OUT(WireloomDiagnostic), error);
        case 11:
            return wireloom_text_get(H(WireloomText), next(2) ? &text : NULL, next(2) ? &length : NULL, error);
        case 12:
            return wireloom_cancel_request(H(WireloomCancel), error);
        case 13:
            return wireloom_cancel_reset(H(WireloomCancel), error);
        case 14:
            return wireloom_run(H(WireloomScenario), OUT(WireloomRunOptions), NULL, error);
        case 15:
            return wireloom_result_get(H(WireloomResult), OUT(WireloomSummary), error);
        case 16:
            return wireloom_result_note(H(WireloomResult), number(), next(2) ? &text : NULL, error);
        case 17:
            return wireloom_result_step(H(WireloomResult), number(), OUT(WireloomStep), error);
        case 18:
            return wireloom_result_find(H(WireloomResult), number(), (uint32_t)next(8), name(), place(), error);
        case 19:
            return wireloom_result_branch(H(WireloomResult), number(), number(), OUT(WireloomBranch), error);
        case 20:
            return wireloom_result_constraint(H(WireloomResult), number(), number(), OUT(WireloomConstraint), error);
        case 21:
            return wireloom_result_joint(H(WireloomResult), number(), number(), OUT(WireloomPlace), error);
        case 22:
            return wireloom_result_marker(H(WireloomResult), number(), number(), OUT(WireloomPlace), error);
        case 23:
            return wireloom_result_body(H(WireloomResult), number(), number(), OUT(WireloomBodyState), error);
        case 24:
            return wireloom_result_event(H(WireloomResult), number(), OUT(WireloomEvent), error);
        case 25:
            return wireloom_result_requirement(H(WireloomResult), number(), OUT(WireloomRequirement), error);
        case 26:
            return wireloom_session_open(H(WireloomScenario), H(WireloomCancel), NULL, error);
        case 27:
            return wireloom_session_result(H(WireloomSession), NULL, error);
        case 28:
        case 29:
            return wireloom_session_move(H(WireloomSession), name(), numbers(), numbers(), error);
        case 30:
            return wireloom_session_hold(H(WireloomSession), name(), next(2) ? NAN : -1, name(), error);
        case 31:
            return wireloom_session_release(H(WireloomSession), next(2) ? "nobody" : NULL, error);
        case 32:
            return wireloom_session_move_body(H(WireloomSession), name(), numbers(), numbers(), error);
        case 33:
            return wireloom_session_set(H(WireloomSession), "nothing.there", name(), error);
        case 34:
            return wireloom_session_text(H(WireloomSession), place(), error);
        case 35:
            return wireloom_sensitivities_new(H(WireloomScenario), OUT(WireloomQuestion), NULL, error);
        case 36:
            return wireloom_sensitivities_get(H(WireloomSensitivities), OUT(WireloomAnswer), error);
        case 37:
            return wireloom_sensitivities_parameter(H(WireloomSensitivities), number(), OUT(WireloomParameter), error);
        case 38:
            return wireloom_sensitivities_output(H(WireloomSensitivities), number(), OUT(WireloomOutput), error);
        case 39:
            return wireloom_sensitivities_derivative(H(WireloomSensitivities), number(), number(),
                                                     OUT(WireloomDerivative), error);
        case 40:
            return wireloom_diagnostics_free(H(WireloomDiagnostics));
        case 41:
            return wireloom_text_free(H(WireloomText));
        case 42:
            return wireloom_sensitivities_free(H(WireloomSensitivities));
        default:
            return next(2) ? wireloom_cancel_new(NULL, error) : wireloom_session_undo(H(WireloomSession), error);
    }
}

int main(int count, char **arguments) {
    WireloomScenario scenario, freed;
    WireloomResult result;
    WireloomSession session;
    WireloomCancel cancel;
    WireloomDiagnostics diagnostics;
    WireloomText text;
    size_t found;
    const char *path = arguments[count - 1];
    if (wireloom_scenario_read(path, &scenario, NULL) || wireloom_scenario_read(path, &freed, NULL) ||
        wireloom_run(scenario, NULL, &result, NULL) || wireloom_cancel_new(&cancel, NULL) ||
        wireloom_session_open(scenario, (WireloomCancel){0}, &session, NULL) ||
        wireloom_scenario_check(scenario, &diagnostics, &found, NULL) ||
        wireloom_scenario_text(scenario, &text, NULL) || wireloom_scenario_free(freed)) {
        return 1;
    }
    handles[OF_WireloomScenario] = scenario.id;
    handles[OF_WireloomResult] = result.id;
    handles[OF_WireloomSession] = session.id;
    handles[OF_WireloomCancel] = cancel.id;
    handles[OF_WireloomDiagnostics] = diagnostics.id;
    handles[OF_WireloomText] = text.id;
    handles[FREED] = freed.id;
    size_t codes[16] = {0};
    for (int k = 0; k < 10000; k++) {
        int code = one_call();
        if (code < 0 || code > 15 || code == WIRELOOM_CODE_INTERNAL || code == WIRELOOM_CODE_CLOSED) {
            fprintf(stderr, "call %d: code %d\n", k, code);
            return 1;
        }
        codes[code]++;
    }
    for (int code = 0; code < 16; code++) {
        printf("code %d: %zu\n", code, codes[code]);
    }
    // In the wrong order, and once too often.
    const int wrong = wireloom_scenario_free(scenario) || wireloom_session_free(session) ||
                      wireloom_result_free(result) || wireloom_cancel_free(cancel) ||
                      wireloom_result_free(result) != WIRELOOM_CODE_BAD_HANDLE ||
                      wireloom_session_free((WireloomSession){0});
    return wrong;
}
