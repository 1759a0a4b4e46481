// Loads the library of its second argument, opens a session, and unloads it: its threads live on, and so must its code.

#include <dlfcn.h>
#include <stdio.h>
#include <string.h>
#include <wireloom.h>

// A function of the library; ISO C has no cast from a pointer to data.
#define LOAD(function)                                                                    \
    do {                                                                                  \
        void *found = dlsym(library, "wireloom_" #function);                              \
        memcpy(&function, &found, sizeof found);                                          \
        if (found == NULL) {                                                              \
            fprintf(stderr, "no " #function "\n");                                        \
            return 1;                                                                     \
        }                                                                                 \
    } while (0)

int main(int count, char **arguments) {
    __typeof__(&wireloom_scenario_read) scenario_read;
    __typeof__(&wireloom_session_open) session_open;
    __typeof__(&wireloom_session_move) session_move;
    void *library = dlopen(arguments[count - 1], RTLD_NOW);
    if (library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    LOAD(scenario_read);
    LOAD(session_open);
    LOAD(session_move);
    WireloomScenario scenario = {0};
    WireloomSession session = {0};
    const double to[] = {0.84, -0.25, 0};
    return scenario_read(arguments[1], &scenario, NULL) ||
           session_open(scenario, (WireloomCancel){0}, &session, NULL) || dlclose(library) ||
           session_move(session, "plug-C", to, NULL, NULL);
}
