/* Times C functions in loops, with nothing but C between the calls. The functions come as pointers,
 * so that whatever is loaded can be timed by the same loop and the same clock. */
#define _POSIX_C_SOURCE 199309L
#include <stdbool.h>
#include <time.h>

typedef int (*DoStep)(void *instance, double time, double step, bool final, bool *event, bool *terminate, bool *early,
                      double *last);
typedef int (*SetState)(void *instance, void *state);
typedef void (*Advance)(const void *model, void *data);

/* Processor time of this thread: what others do on the machine in the meantime does not count. */
static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds of `repeats` runs, each of `count` communication steps from a saved state; -1 where a step fails. */
static double runs(DoStep do_step, SetState set_state, void *instance, void *state, double step, long count, long repeats)
{
    bool event, terminate, early;
    double last, start = now();
    int worst = 0;
    for (long i = 0; i < repeats; i++) {
        int status = set_state(instance, state);
        worst = status > worst ? status : worst;
        for (long k = 0; k < count; k++) {
            status = do_step(instance, (double)k * step, step, true, &event, &terminate, &early, &last);
            worst = status > worst ? status : worst;
        }
    }
    return worst > 1 ? -1.0 : now() - start;
}

/* Mean seconds of a run, without what it takes to go back to the saved state. */
double time_steps(DoStep do_step, SetState set_state, void *instance, void *state, double step, long count, long repeats)
{
    double restoring = runs(do_step, set_state, instance, state, step, 0, repeats);
    double running = runs(do_step, set_state, instance, state, step, count, repeats);
    return running < 0.0 ? running : (running - restoring) / (double)repeats;
}

/* Seconds for `count` calls of a function such as MuJoCo's mj_step. */
double time_advances(Advance advance, const void *model, void *data, long count)
{
    double start = now();
    for (long k = 0; k < count; k++) {
        advance(model, data);
    }
    return now() - start;
}
