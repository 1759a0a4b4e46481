#include <stdio.h>
#include <wireloom.h>

int main(void) {
    WireloomError error = {.size = sizeof error};
    WireloomScenario scenario = {0};
    WireloomResult result = {0};
    WireloomBranch trunk = {.size = sizeof trunk};
    if (wireloom_scenario_read("scenarios/first.toml", &scenario, &error) ||
        wireloom_run(scenario, NULL, &result, &error) || wireloom_result_branch(result, 1, 0, &trunk, &error)) {
        fprintf(stderr, "%u:%u: %s; %s\n", error.line, error.column, error.message, error.suggestion);
        return 1;
    }
    const double *end = trunk.position + 3 * (trunk.node_count - 1);
    printf("%s ends at x = %.3f m, z = %.3f m\n", trunk.name, end[0], end[2]);
    return wireloom_result_free(result) || wireloom_scenario_free(scenario);
}
