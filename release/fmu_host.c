/* Loads the library of a valve's FMU (FMI 3.0), moves its OP up and down, and prints the stem position (VP) of each step.

   fmu_host LIBRARY INSTANTIATION-TOKEN RESOURCES */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#ifdef _WIN32
#include <windows.h>
#define OPEN(path) LoadLibraryA(path)
#define FIND(library, name) ((void *)GetProcAddress(library, name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) dlsym(library, name)
#endif

typedef const char *(*Version)(void);
typedef void *(*Instantiate)(const char *, const char *, const char *, bool, bool, bool, bool, const uint32_t *, size_t, void *,
                             void (*)(void *, int, const char *, const char *), void *);
typedef int (*Enter)(void *, bool, double, double, bool, double);
typedef int (*Plain)(void *);
typedef int (*Number)(void *, const uint32_t *, size_t, double *, size_t);
typedef int (*Step)(void *, double, double, bool, bool *, bool *, bool *, double *);
typedef void (*Free)(void *);

static void said(void *environment, int status, const char *category, const char *message) {
    (void)environment;
    fprintf(stderr, "%d %s: %s\n", status, category, message);
}

int main(int count, char **words) {
    if (count != 4) return 2;
    void *library = (void *)OPEN(words[1]);
    if (!library) return 3;
    Version version = (Version)FIND(library, "fmi3GetVersion");
    Instantiate instantiate = (Instantiate)FIND(library, "fmi3InstantiateCoSimulation");
    Enter enter = (Enter)FIND(library, "fmi3EnterInitializationMode");
    Plain leave = (Plain)FIND(library, "fmi3ExitInitializationMode"), end = (Plain)FIND(library, "fmi3Terminate");
    Number set = (Number)FIND(library, "fmi3SetFloat64"), get = (Number)FIND(library, "fmi3GetFloat64");
    Step step = (Step)FIND(library, "fmi3DoStep");
    Free release = (Free)FIND(library, "fmi3FreeInstance");
    if (!version || !instantiate || !enter || !leave || !end || !set || !get || !step || !release) return 4;
    printf("FMI %s\n", version());
    void *valve = instantiate("valve", words[2], words[3], false, false, false, false, NULL, 0, NULL, said, NULL);
    if (!valve || enter(valve, false, 0, 0, false, 0) || leave(valve)) return 5;
    const uint32_t op = 1, vp = 2;
    for (int k = 0; k < 400; k++) {
        bool event, over, early;
        double value = 50 + 0.2 * (k % 100 < 50 ? k % 50 : 50 - k % 50), last;
        if (set(valve, &op, 1, &value, 1) || step(valve, 0.1 * k, 0.1, false, &event, &over, &early, &last)) return 6;
        if (get(valve, &vp, 1, &value, 1)) return 7;
        printf("%.17g\n", value);
    }
    int code = end(valve);
    release(valve);
    return code;
}
