/* Runs the test that is named, on the unit that this program was built for. */
#include "check.h"
#include "tests.h"

#include <stdio.h>
#include <string.h>

static const struct {
    const char *name;
    void (*run)(void);
} tests[] = {
    {"life_cycle", test_life_cycle}, {"modes", test_modes},   {"values", test_values},
    {"time", test_time},             {"arguments", test_arguments}, {"states", test_states},
    {"arrays", test_arrays},         {"memory", test_memory},         {"threads", test_threads}, {"random_calls", test_random_calls},
};

int main(int argc, char **argv)
{
    describe_subject();
    for (size_t i = 0; argc == 2 && i < sizeof tests / sizeof *tests; i++) {
        if (strcmp(argv[1], tests[i].name) == 0) {
            tests[i].run();
            printf("%s of %s: %zu failures\n", tests[i].name, subject()->name, failure_count());
            return failure_count() != 0;
        }
    }
    fprintf(stderr, "usage: %s TEST, one of:", argv[0]);
    for (size_t i = 0; i < sizeof tests / sizeof *tests; i++) {
        fprintf(stderr, " %s", tests[i].name);
    }
    fputc('\n', stderr);
    return 2;
}
