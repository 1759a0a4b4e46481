// Sessions in threads of their own end in the same equilibria. One session is used by all of them, and a run of what it
// saves ends where it ended. Of the threads that free the same handle one does.

#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <wireloom.h>

enum { THREADS = 4, MOVES = 10 };

static WireloomScenario scenario;
static WireloomSession shared;
static WireloomResult once;
static double ends[THREADS][3];
static int failed[THREADS], freed[THREADS];

static void *work(void *own) {
    const size_t k = (size_t)((int *)own - failed);
    WireloomSession session = {0};
    WireloomResult result = {0};
    WireloomBranch branch = {.size = sizeof branch};
    int wrong = wireloom_session_open(scenario, (WireloomCancel){0}, &session, NULL) != WIRELOOM_CODE_OK;
    for (int move = 1; move <= MOVES; move++) {
        const double x = 0.85 - 0.002 * move, to[] = {x, -0.25, 0};
        wrong |= wireloom_session_move(session, "plug-C", to, NULL, NULL) != WIRELOOM_CODE_OK;
        // Two threads move one plug, and two the other.
        const double sharing[] = {x, k % 2 ? -0.25 : 0.25, 0.002 * (double)k};
        wrong |= wireloom_session_move(shared, k % 2 ? "plug-C" : "plug-B", sharing, NULL, NULL) != WIRELOOM_CODE_OK;
    }
    wrong |= wireloom_session_result(session, &result, NULL) != WIRELOOM_CODE_OK;
    wrong |= wireloom_session_free(session) != WIRELOOM_CODE_OK;
    wrong |= wireloom_result_branch(result, 0, 2, &branch, NULL) != WIRELOOM_CODE_OK;
    if (!wrong) {
        memcpy(ends[k], branch.position + 3 * (branch.node_count / 2), sizeof ends[k]);
    }
    freed[k] = wireloom_result_free(once) == WIRELOOM_CODE_OK;
    failed[k] = wrong || wireloom_result_free(result) != WIRELOOM_CODE_OK;
    return NULL;
}

// Whether a run of what the shared session saves ends where it ended.
static int replays(void) {
    WireloomText text = {0};
    WireloomScenario saved = {0};
    WireloomResult now = {0}, run = {0};
    WireloomSummary summary = {.size = sizeof summary};
    const char *toml = NULL;
    size_t length = 0;
    if (wireloom_session_result(shared, &now, NULL) || wireloom_session_text(shared, &text, NULL) ||
        wireloom_text_get(text, &toml, &length, NULL) || wireloom_scenario_new(toml, length, NULL, &saved, NULL) ||
        wireloom_run(saved, NULL, &run, NULL) || wireloom_result_get(run, &summary, NULL)) {
        return 0;
    }
    for (size_t k = 0; k < 3; k++) {
        WireloomBranch a = {.size = sizeof a}, b = {.size = sizeof b};
        if (wireloom_result_branch(now, 0, k, &a, NULL) ||
            wireloom_result_branch(run, summary.step_count - 1, k, &b, NULL) || a.node_count != b.node_count ||
            memcmp(a.position, b.position, 3 * a.node_count * sizeof(double)) != 0) {
            return 0;
        }
    }
    return !wireloom_result_free(now) && !wireloom_result_free(run) && !wireloom_text_free(text) &&
           !wireloom_scenario_free(saved);
}

int main(int count, char **arguments) {
    pthread_t threads[THREADS];
    if (wireloom_scenario_read(arguments[count - 1], &scenario, NULL) ||
        wireloom_session_open(scenario, (WireloomCancel){0}, &shared, NULL) ||
        wireloom_session_result(shared, &once, NULL)) {
        return 1;
    }
    for (int k = 0; k < THREADS; k++) {
        if (pthread_create(&threads[k], NULL, work, &failed[k]) != 0) {
            return 1;
        }
    }
    int wrong = 0, frees = 0;
    for (int k = 0; k < THREADS; k++) {
        wrong |= pthread_join(threads[k], NULL);
        frees += freed[k];
        wrong |= failed[k] || memcmp(ends[0], ends[k], sizeof ends[k]) != 0;
    }
    printf("%d of %d threads freed the handle\n", frees, THREADS);
    return wrong || frees != 1 || !replays() || wireloom_session_free(shared) || wireloom_scenario_free(scenario);
}
