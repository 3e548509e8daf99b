/* Instances in several threads: the same bits in each, so nothing is shared. */
#include "check.h"
#include "run.h"
#include "tests.h"

#include <pthread.h>

enum { THREADS = 4, LIVES = 5, STEPS = 40 };

typedef struct Work {
    Kind kind;
    uint64_t digests[LIVES];
} Work;

static void *live(void *argument)
{
    Work *work = argument;
    for (int i = 0; i < LIVES; i++) {
        work->digests[i] = run_new(work->kind, (uint64_t)i, STEPS);
    }
    return NULL;
}

static void check_threads(Kind kind)
{
    pthread_t threads[THREADS];
    Work work[THREADS] = {{0}}, alone = {.kind = kind};
    live(&alone);
    for (int i = 0; i < THREADS; i++) {
        work[i].kind = kind;
        CHECK(pthread_create(&threads[i], NULL, live, &work[i]) == 0, "no thread %d", i);
    }
    for (int i = 0; i < THREADS; i++) {
        pthread_join(threads[i], NULL);
        for (int k = 0; k < LIVES; k++) {
            CHECK(work[i].digests[k] == alone.digests[k], "kind %d: life %d in thread %d gives other bits", (int)kind, k, i);
        }
    }
}

void test_threads(void)
{
    for (unsigned kind = CO_SIMULATION; kind < ANY_KIND; kind *= 2) {
        if (slave_kinds() & kind) {
            check_threads((Kind)kind);
        }
    }
}
