#include <stdio.h>
#include <wireloom.h>

int main(int count, char **arguments) {
    WireloomError error = {.size = sizeof error};
    WireloomScenario scenario = {0};
    WireloomResult result = {0};
    if (wireloom_scenario_read(count > 1 ? arguments[1] : "", &scenario, &error) ||
        wireloom_run(scenario, NULL, &result, &error)) {
        fprintf(stderr, "%u:%u: %s\n", error.line, error.column, error.message);
        return 1;
    }
    WireloomSummary summary = {.size = sizeof summary};
    wireloom_result_get(result, &summary, NULL);
    for (size_t step = 0; step < summary.step_count; step++) {
        WireloomBranch trunk = {.size = sizeof trunk};
        wireloom_result_branch(result, step, 0, &trunk, NULL);
        const double *end = trunk.position + 3 * (trunk.node_count - 1);
        printf("%s ends at %.3f %.3f %.3f m\n", trunk.name, end[0], end[1], end[2]);
    }
    wireloom_result_free(result);
    wireloom_scenario_free(scenario);
    return 0;
}
