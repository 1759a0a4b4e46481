// Sessions in threads of their own end in the same equilibria, one session may be used by all of them, and of two
// threads that free the same handle one does.

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
    WireloomSession session;
    WireloomResult result;
    WireloomBranch branch = {.size = sizeof branch};
    int wrong = wireloom_session_open(scenario, (WireloomCancel){0}, &session, NULL) != WIRELOOM_CODE_OK;
    for (int move = 1; move <= MOVES; move++) {
        const double to[] = {0.85 - 0.002 * move, -0.25, 0};
        wrong |= wireloom_session_move(session, "plug-C", to, NULL, NULL) != WIRELOOM_CODE_OK;
        wrong |= wireloom_session_move(shared, k % 2 ? "plug-C" : "plug-B", to, NULL, NULL) == WIRELOOM_CODE_CLOSED;
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

int main(int count, char **arguments) {
    pthread_t threads[THREADS];
    int wrong = wireloom_scenario_read(arguments[count - 1], &scenario, NULL) ||
                wireloom_session_open(scenario, (WireloomCancel){0}, &shared, NULL) ||
                wireloom_session_result(shared, &once, NULL);
    for (int k = 0; k < THREADS; k++) {
        wrong |= pthread_create(&threads[k], NULL, work, &failed[k]);
    }
    int frees = 0;
    for (int k = 0; k < THREADS; k++) {
        pthread_join(threads[k], NULL);
        frees += freed[k];
        wrong |= failed[k] || memcmp(ends[0], ends[k], sizeof ends[k]) != 0;
    }
    printf("%d of %d threads freed the handle\n", frees, THREADS);
    return wrong || frees != 1 || wireloom_session_free(shared) || wireloom_scenario_free(scenario);
}
