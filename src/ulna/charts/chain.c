/* A chain of units in C: each takes what the one before put out, steps, and is read. What a macro step costs at least. */
#include <stdbool.h>
#include <stddef.h>

typedef int (*Move2)(void *unit, const unsigned *references, size_t count, double *values);
typedef int (*Step2)(void *unit, double time, double step, int final);
typedef int (*Move3)(void *unit, const unsigned *references, size_t count, double *values, size_t size);
typedef int (*Step3)(void *unit, double time, double step, bool final, bool *event, bool *terminate, bool *early,
                     double *last);

/* The worst status of `steps` macro steps from `first` times `length` on; `value` is what the first unit takes, and then
 * what the last one puts out. The units are of one FMU, with one input and one output. */
int chain2(Move2 set, Step2 step, Move2 get, void *const *units, long count, unsigned input, unsigned output,
           double length, long first, long steps, double *value)
{
    int worst = 0;
    double taken = *value;
    for (long n = first; n < first + steps; n++) {
        *value = taken;
        for (long k = 0; k < count; k++) {
            int statuses[] = {set(units[k], &input, 1, value), step(units[k], (double)n * length, length, 1),
                              get(units[k], &output, 1, value)};
            for (int s = 0; s < 3; s++) {
                worst = statuses[s] > worst ? statuses[s] : worst;
            }
        }
    }
    return worst;
}

int chain3(Move3 set, Step3 step, Move3 get, void *const *units, long count, unsigned input, unsigned output,
           double length, long first, long steps, double *value)
{
    int worst = 0;
    double taken = *value, last;
    bool event, terminate, early;
    for (long n = first; n < first + steps; n++) {
        *value = taken;
        for (long k = 0; k < count; k++) {
            int statuses[] = {set(units[k], &input, 1, value, 1),
                              step(units[k], (double)n * length, length, true, &event, &terminate, &early, &last),
                              get(units[k], &output, 1, value, 1)};
            for (int s = 0; s < 3; s++) {
                worst = statuses[s] > worst ? statuses[s] : worst;
            }
        }
    }
    return worst;
}
