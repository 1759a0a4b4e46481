// Loads the library of its second argument in a thread that ends, computes, and unloads it. Threads of the library live
// on, and so must its code.

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <wireloom.h>

static char **paths;
static void *library;
static __typeof__(&wireloom_version) version;
static __typeof__(&wireloom_scenario_read) scenario_read;
static __typeof__(&wireloom_session_open) session_open;
static __typeof__(&wireloom_session_free) session_free;

// Finds a function; ISO C has no cast from a pointer to data.
static int find(const char *name, void *function) {
    void *found = dlsym(library, name);
    memcpy(function, &found, sizeof found);
    return found == NULL;
}

static void *work(void *failed) {
    WireloomScenario scenario = {0};
    WireloomSession session = {0};
    library = dlopen(paths[1], RTLD_NOW);
    *(int *)failed = library == NULL || find("wireloom_version", &version) ||
                     find("wireloom_scenario_read", &scenario_read) || find("wireloom_session_open", &session_open) ||
                     find("wireloom_session_free", &session_free) || scenario_read(paths[0], &scenario, NULL) ||
                     session_open(scenario, (WireloomCancel){0}, &session, NULL) || session_free(session);
    return NULL;
}

int main(int count, char **arguments) {
    pthread_t thread;
    int failed = 1;
    paths = arguments + count - 2;
    if (pthread_create(&thread, NULL, work, &failed) || pthread_join(thread, NULL) || failed || dlclose(library)) {
        return 1;
    }
    printf("version %s is still there\n", version());
    return 0;
}
