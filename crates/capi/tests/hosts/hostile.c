// Ten thousand calls with null pointers, handles that were freed or never were, wrong sizes, names that do not exist,
// texts that are not UTF-8, numbers that are not finite; and good ones in between, so that every function succeeds, too.
// What they give is read to its end. The test builds it once more with the address sanitizer.

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <wireloom.h>

// All functions but wireloom_version.
#define FUNCTIONS(F)                                                                      \
    F(scenario_new) F(scenario_read) F(scenario_add_file) F(scenario_add_body)            \
    F(scenario_set) F(scenario_text) F(scenario_file) F(scenario_check)                   \
    F(scenario_free) F(diagnostics_get) F(diagnostics_free) F(text_get) F(text_free)      \
    F(cancel_new) F(cancel_request) F(cancel_reset) F(cancel_free) F(run) F(result_get)   \
    F(result_note) F(result_step) F(result_find) F(result_branch) F(result_constraint)    \
    F(result_joint) F(result_marker) F(result_body) F(result_event) F(result_section)     \
    F(result_requirement) F(result_free) F(session_open) F(session_result)                \
    F(session_move) F(session_hold) F(session_release) F(session_drive)                   \
    F(session_move_body) F(session_set) F(session_undo) F(session_text) F(session_free)   \
    F(sensitivities_new) F(sensitivities_get) F(sensitivities_parameter)                  \
    F(sensitivities_output) F(sensitivities_derivative) F(sensitivities_free)

#define F(name) DO_##name,
enum { FUNCTIONS(F) FUNCTION_COUNT };
#undef F
#define F(name) "wireloom_" #name,
static const char *const functions[] = {FUNCTIONS(F)};
#undef F

// The function that was called last; how often each one succeeded; how often each code came.
static int last;
static size_t succeeded[FUNCTION_COUNT], codes[16];

static int noted(int code) {
    if (code < 0 || code > 15 || code == WIRELOOM_CODE_INTERNAL || code == WIRELOOM_CODE_CLOSED) {
        fprintf(stderr, "%s: code %d\n", functions[last], code);
        exit(1);
    }
    codes[code]++;
    succeeded[last] += code == WIRELOOM_CODE_OK;
    return code;
}

#define CALL(name, ...) (last = DO_##name, noted(wireloom_##name(__VA_ARGS__)))

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

// A good handle of each kind, and one that was freed.
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

// A good handle one time in sixteen: for what takes long, or what has to be made anew.
static uint64_t seldom(int kind) {
    return next(16) ? handles[next(2) ? (kind + 1) % KINDS : FREED] : handles[kind];
}

static const char *name(void) {
    static const char *const names[] = {"trunk", "plug-C", "clip-1", "nobody", "", "\xff\xfe", "J", "joints.J.model",
                                        "[[", "branches.left.length", "box", "box.obj", "middle"};
    return next(8) ? names[next(13)] : NULL;
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
#define SELDOM(type) ((type){seldom(OF_##type)})
#define OUT(type) out(sizeof(type))

// Everything that was read, so that nothing of it is left out.
static volatile double all;

static void word(const char *text) {
    all += text == NULL ? 0 : (double)strlen(text);
}

static void list(const double *values, size_t count) {
    for (size_t k = 0; k < count; k++) {
        all += isfinite(values[k]) ? values[k] : 0;
    }
}

static void where(WireloomWhere place) {
    word(place.words);
    word(place.constraint);
    word(place.body);
    word(place.branch);
    word(place.other_branch);
}

static const char *path;

// A flat box whose triangles face inward, so that there is a remark.
static int add_box(WireloomScenario scenario) {
    const double corners[] = {-.05, -.05, -.01, .05, -.05, -.01, .05, .05, -.01, -.05, .05, -.01,
                              -.05, -.05, .01,  .05, -.05, .01,  .05, .05, .01,  -.05, .05, .01};
    const uint32_t triangles[] = {0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6, 0, 5, 1, 0, 4, 5,
                                  1, 6, 2, 1, 5, 6, 2, 7, 3, 2, 6, 7, 3, 4, 0, 3, 7, 4};
    const WireloomBody box = {.size = sizeof box,
                              .name = "box",
                              .corners = corners,
                              .corner_count = 8,
                              .triangles = triangles,
                              .triangle_count = 12,
                              .position = {0.5, 0, -0.4},
                              .orientation = {1, 0, 0, 0},
                              .min_clearance = NAN};
    return CALL(scenario_add_body, scenario, &box, NULL);
}

// The scenario of the argument with a box, a marker, a joint that can be driven, and a limit that it does not keep, so
// that there is an event.
static int made(WireloomScenario *scenario) {
    static const char more[] =
        "\n[[markers]]\nname = \"middle\"\nat = { branch = \"trunk\", s = \"300 mm\" }\n"
        "[[mechanisms]]\nname = \"lift\"\n"
        "joints = [{ name = \"slide\", kind = \"prismatic\", between = [\"ground\", \"table\"], axis = [0, 0, 1] }]\n";
    WireloomScenario plain = {0};
    WireloomText text = {0};
    const char *toml = NULL;
    size_t length = 0;
    if (CALL(scenario_read, path, &plain, NULL) || CALL(scenario_text, plain, &text, NULL) ||
        CALL(text_get, text, &toml, &length, NULL)) {
        return 1;
    }
    char *longer = malloc(length + sizeof more);
    memcpy(longer, toml, length);
    memcpy(longer + length, more, sizeof more);
    const int wrong = CALL(scenario_new, longer, length + sizeof more - 1, NULL, scenario, NULL);
    free(longer);
    return wrong || CALL(text_free, text) || CALL(scenario_free, plain) || add_box(*scenario) ||
           CALL(scenario_set, *scenario, "sections.trunk.min_bend_radius", "0.4", NULL);
}

// Of which the other handles are made; no hostile call changes it.
static WireloomScenario clean;

// Makes a good handle of a kind; returns whether that failed.
static int renewed(int kind) {
    WireloomScenario scenario = {0};
    WireloomResult result = {0};
    WireloomSession session = {0};
    WireloomCancel cancel = {0};
    WireloomDiagnostics diagnostics = {0};
    WireloomText text = {0};
    WireloomSensitivities sensitivities = {0};
    const char *of[] = {"force.plug-B"}, *by[] = {"branches.left.length"};
    const WireloomQuestion question = {.size = sizeof question, .of = of, .of_count = 1, .by = by, .by_count = 1};
    size_t found;
    int wrong = 0;
    switch (kind) {
        case OF_WireloomScenario:
            wrong = made(&scenario);
            handles[kind] = scenario.id;
            break;
        case OF_WireloomResult:
            wrong = CALL(run, clean, NULL, &result, NULL);
            handles[kind] = result.id;
            break;
        case OF_WireloomSession:
            wrong = CALL(session_open, clean, (WireloomCancel){0}, &session, NULL);
            handles[kind] = session.id;
            break;
        case OF_WireloomCancel:
            wrong = CALL(cancel_new, &cancel, NULL);
            handles[kind] = cancel.id;
            break;
        case OF_WireloomDiagnostics:
            // A length that cannot be, so that there is a diagnostic.
            wrong = made(&scenario) || CALL(scenario_set, scenario, "branches.left.length", "\"40 kg\"", NULL) ||
                    CALL(scenario_check, scenario, &diagnostics, &found, NULL) || found == 0 ||
                    CALL(scenario_free, scenario);
            handles[kind] = diagnostics.id;
            break;
        case OF_WireloomText:
            wrong = CALL(scenario_text, clean, &text, NULL);
            handles[kind] = text.id;
            break;
        case OF_WireloomSensitivities:
            wrong = CALL(sensitivities_new, clean, &question, &sensitivities, NULL);
            handles[kind] = sensitivities.id;
            break;
        default:
            wrong = made(&scenario) || CALL(scenario_free, scenario);
            handles[kind] = scenario.id;
            break;
    }
    return wrong;
}

// Calls a function; returns whether a handle that it freed could not be made anew.
static int one_call(void) {
    static WireloomError own;
    own.size = next(16) ? sizeof own : number();
    WireloomError *error = next(4) ? &own : NULL;
    if (next(32) == 0) {
        error = (WireloomError *)((char *)&own + 4);
    }
    static const char *text;
    static size_t length;
    const double reach[] = {0.85 - 0.001 * (double)next(20), -0.25, 0};
    const double aside[] = {0.5, 0, -0.4 - 0.01 * (double)next(10)};
    switch (next(55)) {
        case 0:
            CALL(scenario_new, name(), next(2) ? 0 : 1, name(), next(2) ? NULL : place(), error);
            break;
        case 1:
            CALL(scenario_new, NULL, number(), name(), place(), error);
            break;
        case 2:
            CALL(scenario_read, next(2) ? path : name(), place(), error);
            break;
        case 3:
            CALL(scenario_add_file, H(WireloomScenario), name(), NULL, number(), error);
            break;
        case 4:
            CALL(scenario_add_body, H(WireloomScenario), NULL, error);
            break;
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
            CALL(scenario_add_body, H(WireloomScenario), &body, error);
            break;
        }
        case 6:
            CALL(scenario_set, H(WireloomScenario), next(2) ? "branches.left.length" : name(),
                next(2) ? "0.4" : name(), error);
            break;
        case 7:
            CALL(scenario_text, H(WireloomScenario), place(), error);
            break;
        case 8:
            CALL(scenario_file, H(WireloomScenario), name(), place(), error);
            break;
        case 9:
            CALL(scenario_check, H(WireloomScenario), place(), place(), error);
            break;
        case 10:
            return !CALL(scenario_free, SELDOM(WireloomScenario)) && renewed(OF_WireloomScenario);
        case 11: {
            WireloomDiagnostic *one = OUT(WireloomDiagnostic);
            if (CALL(diagnostics_get, H(WireloomDiagnostics), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->message);
                word(one->suggestion);
            }
            break;
        }
        case 12:
            return !CALL(diagnostics_free, H(WireloomDiagnostics)) && renewed(OF_WireloomDiagnostics);
        case 13:
            if (CALL(text_get, H(WireloomText), next(2) ? &text : NULL, next(2) ? &length : NULL, error) == 0) {
                all += (double)(strlen(text) - length);
            }
            break;
        case 14:
            return !CALL(text_free, H(WireloomText)) && renewed(OF_WireloomText);
        case 15:
            CALL(cancel_new, place(), error);
            break;
        case 16:
            CALL(cancel_request, H(WireloomCancel), error);
            break;
        case 17:
            CALL(cancel_reset, H(WireloomCancel), error);
            break;
        case 18:
            return !CALL(cancel_free, H(WireloomCancel)) && renewed(OF_WireloomCancel);
        case 19:
            CALL(run, H(WireloomScenario), OUT(WireloomRunOptions), NULL, error);
            break;
        case 20: {
            WireloomSummary *one = OUT(WireloomSummary);
            if (CALL(result_get, H(WireloomResult), one, error) == WIRELOOM_CODE_OK) {
                word(one->scenario);
                word(one->fault);
            }
            break;
        }
        case 21:
            if (CALL(result_note, H(WireloomResult), number(), next(2) ? &text : NULL, error) == WIRELOOM_CODE_OK) {
                word(text);
            }
            break;
        case 22: {
            WireloomStep *one = OUT(WireloomStep);
            if (CALL(result_step, H(WireloomResult), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->name);
                word(one->bend_branch);
                word(one->minimiser);
            }
            break;
        }
        case 23:
            CALL(result_find, H(WireloomResult), number(), next(2) ? WIRELOOM_FAMILY_BRANCH : (uint32_t)next(8),
                 next(2) ? "trunk" : name(), place(), error);
            break;
        case 24: {
            WireloomBranch *one = OUT(WireloomBranch);
            if (CALL(result_branch, H(WireloomResult), number(), number(), one, error) == WIRELOOM_CODE_OK) {
                const size_t nodes = one->node_count;
                const double *const vectors[] = {one->position, one->d1, one->d2, one->d3, one->force, one->moment};
                for (size_t k = 0; k < 6; k++) {
                    list(vectors[k], 3 * nodes);
                }
                list(one->s, nodes);
                list(one->bend_radius, nodes);
                word(one->name);
            }
            break;
        }
        case 25: {
            WireloomConstraint *one = OUT(WireloomConstraint);
            if (CALL(result_constraint, H(WireloomResult), number(), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->name);
                word(one->kind);
            }
            break;
        }
        case 26: {
            WireloomPlace *one = OUT(WireloomPlace);
            if (CALL(result_joint, H(WireloomResult), number(), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->name);
            }
            break;
        }
        case 27: {
            WireloomPlace *one = OUT(WireloomPlace);
            if (CALL(result_marker, H(WireloomResult), number(), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->name);
            }
            break;
        }
        case 28: {
            WireloomBodyState *one = OUT(WireloomBodyState);
            if (CALL(result_body, H(WireloomResult), number(), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->name);
            }
            break;
        }
        case 29: {
            WireloomEvent *one = OUT(WireloomEvent);
            if (CALL(result_event, H(WireloomResult), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->kind);
                word(one->message);
                word(one->unit);
                where(one->place);
                word(one->first.step);
                word(one->worst.step);
                word(one->last.step);
            }
            break;
        }
        case 30: {
            WireloomRequirement *one = OUT(WireloomRequirement);
            if (CALL(result_requirement, H(WireloomResult), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->name);
                word(one->quantity);
                word(one->unit);
                word(one->moment.step);
                where(one->place);
                word(one->origin);
                word(one->because);
                word(one->reason);
            }
            break;
        }
        case 31:
            return !CALL(result_free, SELDOM(WireloomResult)) && renewed(OF_WireloomResult);
        case 32:
            CALL(session_open, H(WireloomScenario), H(WireloomCancel), NULL, error);
            break;
        case 33:
            CALL(session_result, H(WireloomSession), place(), error);
            break;
        case 34:
            CALL(session_move, H(WireloomSession), name(), numbers(), numbers(), error);
            break;
        case 35:
            CALL(session_move, H(WireloomSession), "plug-C", reach, NULL, error);
            break;
        case 36:
            CALL(session_hold, H(WireloomSession), name(), next(2) ? NAN : -1, name(), error);
            break;
        case 37:
            CALL(session_hold, SELDOM(WireloomSession), "trunk", 0.45, "hand", error);
            break;
        case 38:
            CALL(session_release, H(WireloomSession), next(4) ? "hand" : next(2) ? "nobody" : NULL, error);
            break;
        case 39:
            CALL(session_move_body, H(WireloomSession), name(), numbers(), numbers(), error);
            break;
        case 40:
            CALL(session_move_body, SELDOM(WireloomSession), "box", aside, NULL, error);
            break;
        case 41:
            CALL(session_set, H(WireloomSession), "nothing.there", name(), error);
            break;
        case 42:
            CALL(session_set, SELDOM(WireloomSession), "branches.left.length", "0.401", error);
            break;
        case 43:
            CALL(session_text, H(WireloomSession), place(), error);
            break;
        case 44:
            CALL(session_undo, H(WireloomSession), error);
            break;
        case 45:
            return !CALL(session_free, SELDOM(WireloomSession)) && renewed(OF_WireloomSession);
        case 46:
            CALL(sensitivities_new, H(WireloomScenario), OUT(WireloomQuestion), NULL, error);
            break;
        case 47: {
            WireloomAnswer *one = OUT(WireloomAnswer);
            if (CALL(sensitivities_get, H(WireloomSensitivities), one, error) == WIRELOOM_CODE_OK) {
                word(one->step);
            }
            break;
        }
        case 48: {
            WireloomParameter *one = OUT(WireloomParameter);
            if (CALL(sensitivities_parameter, H(WireloomSensitivities), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->key);
                word(one->unit);
            }
            break;
        }
        case 49: {
            WireloomOutput *one = OUT(WireloomOutput);
            if (CALL(sensitivities_output, H(WireloomSensitivities), number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->name);
                word(one->unit);
                word(one->remark);
            }
            break;
        }
        case 50: {
            WireloomDerivative *one = OUT(WireloomDerivative);
            const size_t output = next(2) ? 0 : number(), parameter = next(2) ? 0 : number();
            if (CALL(sensitivities_derivative, H(WireloomSensitivities), output, parameter, one, error) == 0) {
                word(one->reason);
            }
            break;
        }
        case 51:
            return !CALL(sensitivities_free, SELDOM(WireloomSensitivities)) && renewed(OF_WireloomSensitivities);
        case 52:
            CALL(session_drive, H(WireloomSession), name(), next(2) ? NAN : 1e308, error);
            break;
        case 53:
            CALL(session_drive, SELDOM(WireloomSession), "slide", next(2) ? INFINITY : 0.01, error);
            break;
        case 54: {
            WireloomSection *one = OUT(WireloomSection);
            const size_t branch = next(2) ? 0 : number();
            if (CALL(result_section, H(WireloomResult), number(), branch, number(), one, error) == WIRELOOM_CODE_OK) {
                word(one->name);
            }
            break;
        }
    }
    return 0;
}

int main(int count, char **arguments) {
    path = arguments[count - 1];
    int wrong = made(&clean);
    for (int kind = 0; kind < KINDS; kind++) {
        wrong = wrong || renewed(kind);
    }
    for (int k = 0; k < 10000; k++) {
        wrong = wrong || one_call();
    }
    if (wrong) {
        fprintf(stderr, "%s failed where it must not\n", functions[last]);
        return 1;
    }
    // In the wrong order, and once too often.
    wrong = CALL(scenario_free, clean) || CALL(session_free, (WireloomSession){handles[OF_WireloomSession]}) ||
            CALL(result_free, (WireloomResult){handles[OF_WireloomResult]}) ||
            CALL(result_free, (WireloomResult){handles[OF_WireloomResult]}) != WIRELOOM_CODE_BAD_HANDLE ||
            CALL(session_free, (WireloomSession){0});
    for (int k = 0; k < FUNCTION_COUNT; k++) {
        printf("%s: %zu\n", functions[k], succeeded[k]);
        if (succeeded[k] == 0) {
            fprintf(stderr, "%s never succeeded\n", functions[k]);
            wrong = 1;
        }
    }
    for (int code = 0; code < 16; code++) {
        printf("code %d: %zu\n", code, codes[code]);
        if (code <= WIRELOOM_CODE_BAD_VALUE && codes[code] == 0) {
            fprintf(stderr, "code %d never came\n", code);
            wrong = 1;
        }
    }
    return wrong;
}
