// A session with everything that it can do; its text is then carried out, and must end in the same equilibrium. Then
// checks, sensitivities and cancelled runs.

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <wireloom.h>

static WireloomError error = {.size = sizeof error};

#define DO(call)                                                                          \
    do {                                                                                  \
        if ((call) != WIRELOOM_CODE_OK) {                                                 \
            fprintf(stderr, "%s:%d: %s; %s\n", __FILE__, __LINE__, error.message,         \
                    error.suggestion);                                                    \
            return 1;                                                                     \
        }                                                                                 \
    } while (0)

#define HOLDS(condition)                                                                  \
    do {                                                                                  \
        if (!(condition)) {                                                               \
            fprintf(stderr, "%s:%d: not %s (%s)\n", __FILE__, __LINE__, #condition,       \
                    error.message);                                                       \
            return 1;                                                                     \
        }                                                                                 \
    } while (0)

// Whether the last equilibria of two results have the same positions, to a fraction of the length of each branch.
static int same(WireloomResult one, WireloomResult other, double tolerance) {
    WireloomSummary ones = {.size = sizeof ones}, others = {.size = sizeof others};
    DO(wireloom_result_get(one, &ones, &error));
    DO(wireloom_result_get(other, &others, &error));
    HOLDS(others.status == WIRELOOM_STATUS_CONVERGED);
    for (size_t k = 0; k < 3; k++) {
        WireloomBranch a = {.size = sizeof a}, b = {.size = sizeof b};
        DO(wireloom_result_branch(one, ones.step_count - 1, k, &a, &error));
        DO(wireloom_result_branch(other, others.step_count - 1, k, &b, &error));
        HOLDS(a.node_count == b.node_count);
        double most = 0;
        for (size_t i = 0; i < 3 * a.node_count; i++) {
            most = fmax(most, fabs(a.position[i] - b.position[i]));
        }
        printf("%s: %g m apart\n", a.name, most);
        HOLDS(most <= tolerance * a.s[a.node_count - 1]);
    }
    return 0;
}

// A flat box, moved by the host.
static int add_box(WireloomScenario scenario) {
    const double corners[] = {-.05, -.05, -.01, .05, -.05, -.01, .05, .05, -.01, -.05, .05, -.01,
                              -.05, -.05, .01,  .05, -.05, .01,  .05, .05, .01,  -.05, .05, .01};
    const uint32_t triangles[] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                  1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
    WireloomBody box = {.size = sizeof box,
                        .name = "box",
                        .corners = corners,
                        .corner_count = 8,
                        .triangles = triangles,
                        .triangle_count = 12,
                        .position = {0.5, 0, -0.4},
                        .orientation = {1, 0, 0, 0},
                        .min_clearance = NAN};
    DO(wireloom_scenario_add_body(scenario, &box, &error));
    HOLDS(wireloom_scenario_add_body(scenario, &box, &error) == WIRELOOM_CODE_BAD_VALUE);
    HOLDS(wireloom_scenario_add_file(scenario, "box.obj", NULL, 0, &error) == WIRELOOM_CODE_BAD_VALUE);
    // A name that the text has, and a file of the host.
    const char *text = "schema = 1\n[[obstacles]]\nname = \"box\"\nmesh = \"other.obj\"";
    WireloomScenario other;
    DO(wireloom_scenario_new(text, strlen(text), NULL, &other, &error));
    HOLDS(wireloom_scenario_add_body(other, &box, &error) == WIRELOOM_CODE_BAD_VALUE);
    box.name = "other";
    HOLDS(wireloom_scenario_add_body(other, &box, &error) == WIRELOOM_CODE_BAD_VALUE);
    box.name = "own";
    DO(wireloom_scenario_add_file(other, "own.obj", NULL, 0, &error));
    HOLDS(wireloom_scenario_add_body(other, &box, &error) == WIRELOOM_CODE_BAD_VALUE);
    return wireloom_scenario_free(other);
}

// Carries out what a session saves, with the box of its scenario.
static int replay(WireloomSession session, WireloomScenario scenario, WireloomResult *run) {
    WireloomText text, box;
    WireloomScenario saved;
    const char *toml, *obj;
    size_t length, size;
    DO(wireloom_session_text(session, &text, &error));
    DO(wireloom_text_get(text, &toml, &length, &error));
    HOLDS(strlen(toml) == length);
    DO(wireloom_scenario_new(toml, length, NULL, &saved, &error));
    DO(wireloom_scenario_file(scenario, "box.obj", &box, &error));
    DO(wireloom_text_get(box, &obj, &size, &error));
    DO(wireloom_scenario_add_file(saved, "box.obj", (const uint8_t *)obj, size, &error));
    DO(wireloom_text_free(box));
    DO(wireloom_text_free(text));
    DO(wireloom_run(saved, NULL, run, &error));
    return wireloom_scenario_free(saved);
}

static int drag(WireloomScenario scenario) {
    WireloomSession session;
    WireloomText text;
    WireloomResult before, now, run;
    const char *toml;
    size_t length;
    DO(wireloom_session_open(scenario, (WireloomCancel){0}, &session, &error));
    DO(wireloom_session_result(session, &before, &error));
    // What fails ends no motion, so one undo takes both parts back.
    double to[] = {0.85, -0.25, 0};
    const double nowhere[] = {1e9, 0, 0};
    for (int k = 0; k < 2; k++) {
        to[0] -= 0.005;
        DO(wireloom_session_move(session, "plug-C", to, NULL, &error));
        HOLDS(wireloom_session_hold(session, "nobody", 0.1, "hand", &error) == WIRELOOM_CODE_NOT_FOUND);
        HOLDS(wireloom_session_hold(session, "trunk", 0.1, "plug-A", &error) == WIRELOOM_CODE_REFUSED);
        HOLDS(wireloom_session_release(session, "nobody", &error) == WIRELOOM_CODE_NOT_FOUND);
        HOLDS(wireloom_session_move(session, "nobody", to, NULL, &error) == WIRELOOM_CODE_NOT_FOUND);
        HOLDS(wireloom_session_move_body(session, "nobody", to, NULL, &error) == WIRELOOM_CODE_NOT_FOUND);
        HOLDS(wireloom_session_move_body(session, "box", nowhere, NULL, &error) == WIRELOOM_CODE_BAD_VALUE);
        HOLDS(wireloom_session_move_body(session, "box", NULL, NULL, &error) == WIRELOOM_CODE_BAD_VALUE);
        HOLDS(wireloom_session_set(session, "nothing.there", "1", &error) == WIRELOOM_CODE_NOT_FOUND);
    }
    DO(wireloom_session_undo(session, &error));
    DO(wireloom_session_result(session, &now, &error));
    if (same(before, now, 0)) {
        return 1;
    }
    DO(wireloom_result_free(now));
    HOLDS(wireloom_session_undo(session, &error) == WIRELOOM_CODE_REQUEST);
    to[0] = 0.85;
    for (int k = 0; k < 5; k++) {
        to[0] -= 0.01;
        DO(wireloom_session_move(session, "plug-C", to, NULL, &error));
    }
    const double turned[] = {0.5, 0.5, 0.5, 0.55};
    DO(wireloom_session_move(session, "plug-C", NULL, turned, &error));
    HOLDS(wireloom_session_move(session, "plug-D", to, NULL, &error) == WIRELOOM_CODE_NOT_FOUND);
    HOLDS(strstr(error.suggestion, "plug-") != NULL);
    const double against[] = {0.5, 0.02, -0.1}, tilted[] = {1, 0.02, 0, 0};
    DO(wireloom_session_move_body(session, "box", against, tilted, &error));
    DO(wireloom_session_result(session, &now, &error));
    WireloomBodyState body = {.size = sizeof body};
    size_t index;
    DO(wireloom_result_find(now, 0, WIRELOOM_FAMILY_BODY, "box", &index, &error));
    DO(wireloom_result_body(now, 0, index, &body, &error));
    HOLDS(body.contact_force > 0 && body.contact_count > 0 && body.position[2] == -0.1);
    if (replay(session, scenario, &run) || same(now, run, 0)) {
        return 1;
    }
    DO(wireloom_result_free(run));
    DO(wireloom_result_free(now));
    DO(wireloom_session_hold(session, "trunk", 0.45, "hand", &error));
    const double up[] = {0.45, 0.02, 0.03};
    DO(wireloom_session_move(session, "hand", up, NULL, &error));
    DO(wireloom_session_release(session, "clip-1", &error));
    DO(wireloom_session_undo(session, &error));
    DO(wireloom_session_release(session, "hand", &error));
    DO(wireloom_session_result(session, &now, &error));
    DO(wireloom_session_text(session, &text, &error));
    DO(wireloom_text_get(text, &toml, &length, &error));
    HOLDS(strstr(toml, "name = \"drag plug-C\"") != NULL && strstr(toml, "obstacle = \"box\"") != NULL);
    HOLDS(strstr(toml, "release hand") != NULL && strstr(toml, "release clip-1") == NULL);
    DO(wireloom_text_free(text));
    // A grasp gives the cable another node, so the bits may differ.
    if (replay(session, scenario, &run) || same(now, run, 1e-9)) {
        return 1;
    }

    // Another model of the joint: all is carried out again.
    DO(wireloom_session_set(session, "joints.J.model", "\"fused\"", &error));
    HOLDS(wireloom_session_set(session, "joints.K.model", "\"fused\"", &error) == WIRELOOM_CODE_NOT_FOUND);
    HOLDS(wireloom_session_set(session, "joints.J.model", "fused", &error) == WIRELOOM_CODE_BAD_VALUE);
    HOLDS(wireloom_session_set(session, "joints.J.model", "\"glued\"", &error) == WIRELOOM_CODE_REFUSED);
    for (int k = 0; k < 6; k++) {
        DO(wireloom_session_undo(session, &error));
    }
    HOLDS(wireloom_session_undo(session, &error) == WIRELOOM_CODE_REQUEST);
    DO(wireloom_result_free(now));
    DO(wireloom_session_result(session, &now, &error));
    DO(wireloom_session_free(session));
    if (same(before, now, 0)) {
        return 1;
    }
    DO(wireloom_result_free(before));
    DO(wireloom_result_free(now));
    return wireloom_result_free(run);
}

// A door on its hinge: its plug goes along its arc.
static int drive(const char *path) {
    WireloomScenario scenario;
    WireloomSession session;
    WireloomResult now;
    size_t index;
    WireloomConstraint plug = {.size = sizeof plug};
    DO(wireloom_scenario_read(path, &scenario, &error));
    DO(wireloom_session_open(scenario, (WireloomCancel){0}, &session, &error));
    DO(wireloom_scenario_free(scenario));
    const double aside[] = {0.4, 0, 0.1}, angle = 1;
    for (int k = 0; k < 2; k++) {
        HOLDS(wireloom_session_drive(session, "hinges", angle, &error) == WIRELOOM_CODE_NOT_FOUND);
        HOLDS(strstr(error.suggestion, "hinge") != NULL);
        HOLDS(wireloom_session_drive(session, "hinge", NAN, &error) == WIRELOOM_CODE_BAD_VALUE);
        HOLDS(wireloom_session_drive(session, "hinge", 1.5, &error) == WIRELOOM_CODE_REFUSED);
        HOLDS(wireloom_session_move_body(session, "door panel", aside, NULL, &error) == WIRELOOM_CODE_REQUEST);
        HOLDS(wireloom_session_set(session, "plugins.load", "[\"own.so\"]", &error) == WIRELOOM_CODE_REFUSED);
        HOLDS(strstr(error.message, "\"own.so\" is not loaded") != NULL && error.line > 0);
        if (k == 0) {
            DO(wireloom_session_drive(session, "front door/hinge", angle, &error));
        }
        DO(wireloom_session_result(session, &now, &error));
        DO(wireloom_result_find(now, 0, WIRELOOM_FAMILY_CONSTRAINT, "door plug", &index, &error));
        DO(wireloom_result_constraint(now, 0, index, &plug, &error));
        // The hinge is at 0.1, 0; as drawn the plug is at 0.3, -0.02.
        const double x = 0.1 + 0.2 * cos(angle) + 0.02 * sin(angle), y = 0.2 * sin(angle) - 0.02 * cos(angle);
        HOLDS(fabs(plug.position[0] - x) < 1e-9 && fabs(plug.position[1] - y) < 1e-9);
        DO(wireloom_result_free(now));
    }
    DO(wireloom_session_undo(session, &error));
    HOLDS(wireloom_session_undo(session, &error) == WIRELOOM_CODE_REQUEST);
    return wireloom_session_free(session);
}

static int check(WireloomScenario scenario) {
    WireloomDiagnostics diagnostics;
    WireloomDiagnostic one = {.size = sizeof one};
    size_t count;
    DO(wireloom_scenario_set(scenario, "branches.left.length", "\"40 kg\"", &error));
    DO(wireloom_scenario_check(scenario, &diagnostics, &count, &error));
    HOLDS(count == 1);
    DO(wireloom_diagnostics_get(diagnostics, 0, &one, &error));
    printf("%u:%u: %s\n  help: %s\n", one.line, one.column, one.message, one.suggestion);
    HOLDS(one.severity == WIRELOOM_SEVERITY_ERROR && one.line == 35 && one.column == 10);
    WireloomResult result;
    HOLDS(wireloom_run(scenario, NULL, &result, &error) == WIRELOOM_CODE_REFUSED);
    HOLDS(error.line == one.line && error.column == one.column && strcmp(error.message, one.message) == 0);
    DO(wireloom_diagnostics_free(diagnostics));
    // Told without control characters.
    DO(wireloom_scenario_set(scenario, "branches.left.length", "0.4", &error));
    DO(wireloom_scenario_set(scenario, "branches.left.section", "\"\\u001b[2J\"", &error));
    DO(wireloom_scenario_check(scenario, &diagnostics, &count, &error));
    DO(wireloom_diagnostics_get(diagnostics, 0, &one, &error));
    HOLDS(strchr(one.message, 27) == NULL && strstr(one.message, "U+001B") != NULL);
    DO(wireloom_diagnostics_free(diagnostics));
    DO(wireloom_scenario_set(scenario, "branches.left.section", "\"arm\"", &error));
    DO(wireloom_scenario_check(scenario, &diagnostics, &count, &error));
    for (size_t k = 0; k < count; k++) {
        DO(wireloom_diagnostics_get(diagnostics, k, &one, &error));
        HOLDS(one.severity == WIRELOOM_SEVERITY_NOTE);
    }
    return wireloom_diagnostics_free(diagnostics);
}

// Scenarios that cannot be read.
static int refused(void) {
    WireloomScenario scenario;
    WireloomResult result;
    HOLDS(wireloom_scenario_read("nothing.toml", &scenario, &error) == WIRELOOM_CODE_SYSTEM);
    const char *texts[] = {"schema = ", "schema = 1\n[plugins]\nload = [\"own.so\"]\n"};
    const char *words[] = {"this is not TOML", "\"own.so\" is not loaded"};
    for (size_t k = 0; k < 2; k++) {
        DO(wireloom_scenario_new(texts[k], strlen(texts[k]), NULL, &scenario, &error));
        HOLDS(wireloom_run(scenario, NULL, &result, &error) == WIRELOOM_CODE_REFUSED);
        HOLDS(strstr(error.message, words[k]) != NULL && error.line == (k == 0 ? 1 : 3));
        const WireloomCode set = wireloom_scenario_set(scenario, "name", "1", &error);
        HOLDS(set == (k == 0 ? WIRELOOM_CODE_REFUSED : WIRELOOM_CODE_OK));
        HOLDS(k == 0 || wireloom_scenario_set(scenario, "name", "[1, null]", &error) == WIRELOOM_CODE_BAD_VALUE);
        HOLDS(k == 0 || wireloom_scenario_set(scenario, "nothing.there", "1", &error) == WIRELOOM_CODE_NOT_FOUND);
        DO(wireloom_scenario_free(scenario));
    }
    return 0;
}

static int derivatives(WireloomScenario scenario) {
    const char *of[] = {"force.plug-B"}, *by[] = {"branches.left.length", "branches.trunk.length"};
    WireloomQuestion question = {.size = sizeof question, .of = of, .of_count = 1, .by = by, .by_count = 2};
    WireloomSensitivities found;
    DO(wireloom_sensitivities_new(scenario, &question, &found, &error));
    WireloomAnswer answer = {.size = sizeof answer};
    DO(wireloom_sensitivities_get(found, &answer, &error));
    HOLDS(answer.output_count == 1 && answer.parameter_count == 2 && strcmp(answer.step, "plug C") == 0);
    WireloomOutput output = {.size = sizeof output};
    DO(wireloom_sensitivities_output(found, 0, &output, &error));
    for (size_t k = 0; k < 2; k++) {
        WireloomParameter parameter = {.size = sizeof parameter};
        WireloomDerivative derivative = {.size = sizeof derivative};
        DO(wireloom_sensitivities_parameter(found, k, &parameter, &error));
        DO(wireloom_sensitivities_derivative(found, 0, k, &derivative, &error));
        HOLDS(isfinite(derivative.value) && derivative.reason == NULL);
        printf("%s by %s: %.6g %s/%s\n", output.name, parameter.key, derivative.value, output.unit, parameter.unit);
    }
    HOLDS(wireloom_sensitivities_derivative(found, 0, 2, NULL, &error) == WIRELOOM_CODE_NOT_FOUND);
    DO(wireloom_sensitivities_free(found));
    by[1] = "branches.tronk.length";
    HOLDS(wireloom_sensitivities_new(scenario, &question, &found, &error) == WIRELOOM_CODE_NOT_FOUND);
    return 0;
}

static int stop_at_five(void *user, const WireloomProgress *progress) {
    if (progress->increment == 5) {
        return wireloom_cancel_request(*(WireloomCancel *)user, NULL);
    }
    return 0;
}

static int cancel(WireloomScenario scenario) {
    WireloomCancel cancel;
    WireloomResult result;
    WireloomSession session;
    DO(wireloom_cancel_new(&cancel, &error));
    WireloomRunOptions options = {
        .size = sizeof options, .on_progress = stop_at_five, .user = &cancel, .cancel = cancel};
    DO(wireloom_run(scenario, &options, &result, &error));
    WireloomSummary summary = {.size = sizeof summary};
    DO(wireloom_result_get(result, &summary, &error));
    HOLDS(summary.status == WIRELOOM_STATUS_INTERRUPTED);
    HOLDS(wireloom_session_open(scenario, cancel, &session, &error) == WIRELOOM_CODE_CANCELLED);
    DO(wireloom_cancel_reset(cancel, &error));
    DO(wireloom_session_open(scenario, cancel, &session, &error));
    // What is cancelled before it has begun ends no motion.
    const double one[] = {0.845, -0.25, 0}, two[] = {0.84, -0.25, 0}, other[] = {0.845, 0.25, 0};
    DO(wireloom_session_move(session, "plug-C", one, NULL, &error));
    DO(wireloom_cancel_request(cancel, &error));
    HOLDS(wireloom_session_move(session, "plug-B", other, NULL, &error) == WIRELOOM_CODE_CANCELLED);
    DO(wireloom_cancel_reset(cancel, &error));
    DO(wireloom_session_move(session, "plug-C", two, NULL, &error));
    DO(wireloom_session_undo(session, &error));
    HOLDS(wireloom_session_undo(session, &error) == WIRELOOM_CODE_REQUEST);
    DO(wireloom_cancel_free(cancel));
    DO(wireloom_result_free(result));
    return wireloom_session_free(session);
}

int main(int count, char **arguments) {
    WireloomScenario scenario;
    DO(wireloom_scenario_read(arguments[count - 1], &scenario, &error));
    if (refused() || check(scenario) || derivatives(scenario) || cancel(scenario) || add_box(scenario) ||
        drag(scenario) || drive(arguments[count - 2])) {
        return 1;
    }
    DO(wireloom_scenario_free(scenario));
    HOLDS(wireloom_scenario_free(scenario) == WIRELOOM_CODE_BAD_HANDLE);
    return 0;
}
