/* Calls in any order with any arguments: never a crash, and after a reset as good as new. */
#include "check.h"
#include "run.h"
#include "tests.h"

#include <math.h>

enum { LIVES = 30, CALLS = 150 };

static size_t random_below(uint64_t *random, size_t count)
{
    return (size_t)(random_bits(random) >> 33) % count;
}

static double random_from_pool(uint64_t *random)
{
    static const double pool[] = {0.0,  -0.0, 1.0,  -1.0, 0.5,       1e-9,      1e-300, 1e9,      -1e9,
                                  1e308, -1e308, 3.0, 7.0, INFINITY, -INFINITY, NAN,    5e-324};
    return pool[random_below(random, sizeof pool / sizeof *pool)];
}

static int set_anything(Slave *slave, uint64_t *random)
{
    const Variable *variable = &subject()->variables[random_below(random, subject()->variable_count)];
    double values[MAX_ELEMENTS];
    if (variable->group == STREAM) {
        return OK;
    }
    random_values(random, variable, values);
    bool tiny_steps = variable->minimum > 0.0 && variable->minimum < 1e-3; /* would cost a billion of them */
    for (uint32_t k = 0; k < variable->count; k++) {
        if (tiny_steps) {
            values[k] = random_below(random, 2) ? NAN : fmax(values[k], 0.001);
        } else if (variable->type == FLOAT64 && random_below(random, 4) == 0) {
            values[k] = random_from_pool(random);
        } else if (variable->type == ENUMERATION || variable->type == INT32) {
            values[k] = (double)random_below(random, 8);
        }
    }
    return slave_set(slave, variable, values);
}

static int get_anything(Slave *slave, uint64_t *random)
{
    const Variable *variable = &subject()->variables[random_below(random, subject()->variable_count)];
    double values[MAX_ELEMENTS];
    return variable->group == STREAM ? OK : slave_get(slave, variable, values);
}

static int step_somehow(Slave *slave, double *time, uint64_t *random)
{
    static const double sizes[] = {0.01, 0.02, 0.003, 1e-9, 1e-300, 0.0, -1.0, INFINITY, NAN};
    double size = sizes[random_below(random, sizeof sizes / sizeof *sizes)];
    double point = random_below(random, 8) ? *time : random_from_pool(random);
    int status = slave_step(slave, point, size);
    *time += status == OK ? size : 0.0;
    return status;
}

static int move_state(Slave *slave, void **state, double *time, double *saved_time, uint64_t *random)
{
    if (random_below(random, 2)) {
        *saved_time = *time;
        return slave_save(slave, state);
    }
    int status = slave_restore(slave, *state);
    *time = status == OK ? *saved_time : *time;
    return status;
}

static void live_at_random(Kind kind, uint64_t *random, uint64_t digest, size_t *successes)
{
    Slave slave;
    void *state = NULL;
    double time = 0.0, saved_time = 0.0;
    slave_open(&slave, kind);
    if (random_below(random, 4)) {
        slave_start(&slave);
    }
    for (int i = 0; i < CALLS; i++) {
        int status = OK;
        size_t lines = slave.log.lines;
        switch (random_below(random, 8)) {
        case 0:
        case 1: status = step_somehow(&slave, &time, random); break;
        case 2:
        case 3: status = set_anything(&slave, random); break;
        case 4:
        case 5: status = get_anything(&slave, random); break;
        case 6: status = move_state(&slave, &state, &time, &saved_time, random); break;
        default: status = random_below(random, 8) ? OK : calls[random_below(random, call_count)].make(&slave); break;
        }
        CHECK(status == OK || slave.log.lines > lines, "an error without a word");
        *successes += status == OK;
    }
    CHECK(slave_reset(&slave) == OK && run_life(&slave, 1, 5) == digest, "kind %d: not usable after reset", (int)kind);
    slave_release(&slave, &state);
    slave_close(&slave);
}

void test_random_calls(void)
{
    uint64_t random = 20240229;
    for (unsigned kind = CO_SIMULATION; kind < ANY_KIND; kind *= 2) {
        if (slave_kinds() & kind) {
            uint64_t digest = run_new((Kind)kind, 1, 5);
            size_t successes = 0;
            for (int i = 0; i < LIVES; i++) {
                live_at_random((Kind)kind, &random, digest, &successes);
            }
            CHECK(successes > LIVES * CALLS / 4, "kind %d: only %zu calls succeed, too few to reach far", (int)kind, successes);
        }
    }
}
