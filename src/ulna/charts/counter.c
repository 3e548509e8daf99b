/* Counts calls: built together with a unit's sources by -finstrument-functions, which calls these at each function's
 * start and end. COUNTED lists the functions that count, and the right-hand sides in each: {function, number}, ... */
#include "fmu.c"

/* hidden, since the C library has empty ones of these names, which would be found first */
#define HOOK __attribute__((no_instrument_function, visibility("hidden")))

double evaluations;

HOOK void __cyg_profile_func_enter(void *function, void *caller);
HOOK void __cyg_profile_func_exit(void *function, void *caller);

void __cyg_profile_func_enter(void *function, void *caller)
{
    static const struct {
        void (*function)(void);
        double worth;
    } counted[] = {COUNTED};
    (void)caller;
    for (unsigned i = 0; i < sizeof counted / sizeof counted[0]; i++) {
        evaluations += (void *)counted[i].function == function ? counted[i].worth : 0.0;
    }
}

void __cyg_profile_func_exit(void *function, void *caller)
{
    (void)function;
    (void)caller;
}
