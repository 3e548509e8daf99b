#include "run.h"

#include "check.h"

#include <math.h>
#include <string.h>

enum { STREAM_BYTES = 1 << 17 };

static const double steps_in_turn[] = {0.01, 0.025, 0.005}; /* s; no two alike, none a divisor of a ping's period */

uint64_t random_bits(uint64_t *random)
{
    *random ^= *random << 13;
    *random ^= *random >> 7;
    *random ^= *random << 17;
    return *random;
}

double random_fraction(uint64_t *random)
{
    return (double)(random_bits(random) >> 11) * 0x1p-53;
}

void random_values(uint64_t *random, const Variable *variable, double *values)
{
    double low = fmax(variable->minimum, variable->type == UINT64 ? 0.0 : -1.0), high = fmin(variable->maximum, low + 2.0);
    for (uint32_t k = 0; k < variable->count; k++) {
        double value = low + (high - low) * random_fraction(random);
        if (variable->quaternion) {
            value = (k ? 0.0 : 1.0) + 0.2 * (random_fraction(random) - 0.5);
        } else if (variable->type == BOOLEAN || variable->type == CLOCK) {
            value = (double)(random_bits(random) >> 63);
        } else if (variable->type == INT32 && variable->size_of) {
            value = 0.0; /* of one vertex, the only one there is at the start */
        } else if (variable->type != FLOAT64 && variable->type != FLOAT32) {
            value = floor(value);
        } else if (fabs(value) < 0.001) {
            value = 0.0; /* a period is 0 or at least 1 ms */
        }
        values[k] = value;
    }
}

bool is_readable(const Variable *variable)
{
    return variable->causality != MEMORY && variable->group != STREAM && variable->type != CLOCK && slave_has(variable);
}

static void digest_bytes(Run *run, const void *bytes, size_t size)
{
    const unsigned char *next = bytes;
    for (size_t i = 0; i < size; i++) {
        run->digest = (run->digest ^ next[i]) * 1099511628211ULL; /* FNV-1a */
    }
}

static void expect_ok(Run *run, int status)
{
    run->failures += status != OK;
}

static void set_inputs(Run *run)
{
    const Subject *unit = subject();
    for (size_t i = 0; i < unit->variable_count; i++) {
        const Variable *variable = &unit->variables[i];
        bool discrete = variable->variability == DISCRETE;
        if (variable->causality == INPUT && is_readable(variable) && !(discrete && run->slave->kind == MODEL_EXCHANGE)) {
            double values[MAX_ELEMENTS];
            random_values(&run->random, variable, values);
            expect_ok(run, slave_set(run->slave, variable, values));
        }
    }
}

static void read_all(Run *run)
{
    static _Thread_local char stream[STREAM_BYTES];
    const Subject *unit = subject();
    for (size_t i = 0; i < unit->variable_count; i++) {
        const Variable *variable = &unit->variables[i];
        double values[MAX_ELEMENTS] = {0};
        if (is_readable(variable)) {
            expect_ok(run, slave_get(run->slave, variable, values));
            digest_bytes(run, values, variable->count * sizeof *values);
        } else if (variable->group == STREAM) {
            digest_bytes(run, stream, slave_get_stream(run->slave, variable, stream, sizeof stream));
        }
    }
}

/* Explicit Euler: what it computes does not matter, that it is the same does. */
static void integrate(Run *run, double step)
{
    double states[MAX_STATES], slopes[MAX_STATES];
    size_t count = subject()->state_count;
    expect_ok(run, slave_get_states(run->slave, states, count));
    expect_ok(run, slave_get_derivatives(run->slave, slopes, count));
    for (size_t i = 0; i < count; i++) {
        states[i] += step * slopes[i];
    }
    expect_ok(run, slave_set_time(run->slave, run->time + step));
    expect_ok(run, slave_set_states(run->slave, states, count));
    expect_ok(run, slave_complete_step(run->slave));
}

Run run_from(Slave *slave, double time, uint64_t seed)
{
    return (Run){.slave = slave, .time = time, .random = seed * 2654435761U + 1U, .digest = 14695981039346656037ULL};
}

void run_step(Run *run)
{
    double step = steps_in_turn[random_bits(&run->random) % 3];
    set_inputs(run);
    if (run->slave->kind == MODEL_EXCHANGE) {
        integrate(run, step);
    } else {
        expect_ok(run, slave_step(run->slave, run->time, step));
    }
    run->time += step;
    read_all(run);
}

uint64_t run_steps(Slave *slave, double time, uint64_t seed, size_t steps)
{
    Run run = run_from(slave, time, seed);
    for (size_t i = 0; i < steps; i++) {
        run_step(&run);
    }
    CHECK(run.failures == 0, "%zu calls of a good run fail: %s", run.failures, slave->log.text);
    return run.digest;
}

uint64_t run_life(Slave *slave, uint64_t seed, size_t steps)
{
    slave_start(slave);
    uint64_t digest = run_steps(slave, 0.0, seed, steps);
    CHECK(slave_terminate(slave) == OK, "terminate: %s", slave->log.text);
    return digest;
}

uint64_t run_new(Kind kind, uint64_t seed, size_t steps)
{
    Slave slave;
    slave_open(&slave, kind);
    uint64_t digest = run_life(&slave, seed, steps);
    slave_close(&slave);
    return digest;
}
