/* Wrong times and steps: refused with a line that tells the right one. */
#include "check.h"
#include "run.h"
#include "tests.h"

#include <math.h>

static void check_steps(Kind kind)
{
    static const double wrong_sizes[] = {0.0, -0.0, -0.01, -1e300, NAN, INFINITY, -INFINITY};
    static const double wrong_points[] = {0.51, 0.49, -0.5, 1e300, NAN, INFINITY, -INFINITY};
    const double stop = 1.0;
    Slave slave, twin;
    slave_open(&slave, kind);
    slave_enter_initialization(&slave, 0.5, &stop);
    slave_exit_initialization(&slave);
    slave_enter_continuous_time(&slave);
    for (size_t i = 0; i < sizeof wrong_sizes / sizeof *wrong_sizes; i++) {
        CHECK_REFUSED(&slave, slave_step(&slave, 0.5, wrong_sizes[i]), "wrong size", "communicationStepSize",
                      "allowed range: greater than 0");
    }
    for (size_t i = 0; i < sizeof wrong_points / sizeof *wrong_points; i++) {
        CHECK_REFUSED(&slave, slave_step(&slave, wrong_points[i], 0.01), "wrong point", "currentCommunicationPoint", "0.5 s");
    }
    CHECK_REFUSED(&slave, slave_step(&slave, 0.5, 0.51), "past the end", "stopTime = 1 s");
    CHECK_REFUSED(&slave, slave_step(&slave, 0.5, 1e300), "past the end", "stopTime = 1 s");

    /* none of them moved it */
    slave_open(&twin, kind);
    slave_enter_initialization(&twin, 0.5, &stop);
    slave_exit_initialization(&twin);
    slave_enter_continuous_time(&twin);
    CHECK(run_steps(&slave, 0.5, 1, 10) == run_steps(&twin, 0.5, 1, 10), "kind %d: a refused step left a trace", (int)kind);
    slave_close(&twin);

    CHECK(slave_reset(&slave) == OK && slave_enter_initialization(&slave, 0.5, &stop) == OK, "%s", slave.log.text);
    slave_exit_initialization(&slave);
    slave_enter_continuous_time(&slave);
    double time = 0.5;
    for (int i = 0; i < 5000; i++) {
        CHECK(slave_step(&slave, time, 1e-4) == OK, "a sum of steps that rounds off the stop time: %s", slave.log.text);
        time += 1e-4;
    }
    CHECK_REFUSED(&slave, slave_step(&slave, time, 1e-4), "past the end", "stopTime = 1 s");
    slave_close(&slave);
}

static void check_experiments(Kind kind)
{
    static const double wrong_starts[] = {NAN, INFINITY, -INFINITY};
    static const double wrong_stops[] = {NAN, 0.9, -INFINITY};
    Slave slave;
    slave_open(&slave, kind);
    for (size_t i = 0; i < 3; i++) {
        CHECK_REFUSED(&slave, slave_enter_initialization(&slave, wrong_starts[i], NULL), "wrong start", "startTime");
        CHECK_REFUSED(&slave, slave_enter_initialization(&slave, 1.0, &wrong_stops[i]), "wrong stop", "stopTime",
                      "at least startTime = 1 s");
    }
    CHECK(run_life(&slave, 1, 5) == run_new(kind, 1, 5), "kind %d: a refused experiment left a trace", (int)kind);
    slave_close(&slave);
}

/* A step that ends in infinities is an error that names the state; then only a reset or a state helps. */
static void check_overflow(void)
{
    Slave slave;
    void *state = NULL;
    slave_open(&slave, CO_SIMULATION);
    slave_start(&slave);
    CHECK(slave_save(&slave, &state) == OK, "%s", slave.log.text);
    for (int again = 0; again < 2; again++) {
        for (size_t i = 0; i < subject()->variable_count; i++) {
            const Variable *variable = &subject()->variables[i];
            if (variable->causality == INPUT && variable->type == FLOAT64 && !variable->quaternion) {
                CHECK(slave_set(&slave, variable, (double[]){1e308, 1e308, 1e308}) == OK, "%s", slave.log.text);
            }
        }
        CHECK_REFUSED(&slave, slave_step(&slave, 0.0, 10.0), "overflow", "is not finite at 10 s");
        CHECK_REFUSED(&slave, slave_step(&slave, 10.0, 0.01), "after the overflow", "DoStep", "Failed");
        CHECK_REFUSED(&slave, slave_terminate(&slave), "after the overflow", "Terminate", "Failed");
        if (again) {
            CHECK(slave_reset(&slave) == OK, "%s", slave.log.text);
            slave_start(&slave);
        } else {
            CHECK(slave_restore(&slave, state) == OK, "%s", slave.log.text);
        }
        CHECK(run_steps(&slave, 0.0, 1, 5) == run_new(CO_SIMULATION, 1, 5), "not usable after the overflow");
        CHECK(slave_reset(&slave) == OK, "%s", slave.log.text);
        slave_start(&slave);
    }
    slave_release(&slave, &state);
    slave_close(&slave);
}

static void check_integrator(void)
{
    static const double wrong[] = {NAN, INFINITY, -INFINITY};
    size_t count = subject()->state_count;
    double states[MAX_STATES + 1] = {0};
    Slave slave;
    slave_open(&slave, MODEL_EXCHANGE);
    slave_start(&slave);
    CHECK(slave_get_states(&slave, states, count) == OK, "%s", slave.log.text);
    CHECK_REFUSED(&slave, slave_get_states(&slave, states, count + 1), "too many", "continuous states");
    CHECK_REFUSED(&slave, slave_get_derivatives(&slave, states, count - 1), "too few", "continuous states");
    CHECK_REFUSED(&slave, slave_set_states(&slave, states, count + 1), "too many", "continuous states");
    CHECK_REFUSED(&slave, slave_set_states(&slave, NULL, count), "NULL", "continuous states", "NULL");
    CHECK_REFUSED(&slave, slave_get_states(&slave, NULL, count), "NULL", "continuous states", "NULL");
    CHECK_REFUSED(&slave, slave_get_derivatives(&slave, NULL, count), "NULL", "derivatives", "NULL");
    for (size_t i = 0; i < 3; i++) {
        CHECK_REFUSED(&slave, slave_set_time(&slave, wrong[i]), "wrong time", "time");
        for (size_t k = 0; k < count; k++) {
            double right = states[k];
            states[k] = wrong[i];
            CHECK_REFUSED(&slave, slave_set_states(&slave, states, count), "wrong state", "allowed range");
            states[k] = right;
        }
    }
    CHECK(slave_set_time(&slave, 0.0) == OK && slave_set_states(&slave, states, count) == OK, "%s", slave.log.text);
    CHECK(run_steps(&slave, 0.0, 1, 5) == run_new(MODEL_EXCHANGE, 1, 5), "a refused state left a trace");
    slave_close(&slave);
}

void test_time(void)
{
    check_steps(CO_SIMULATION);
    check_experiments(CO_SIMULATION);
    if (slave_kinds() & CO_SIMULATION_WITH_EVENT_MODE) {
        check_steps(CO_SIMULATION_WITH_EVENT_MODE);
    }
    if (slave_kinds() & MODEL_EXCHANGE) {
        check_experiments(MODEL_EXCHANGE);
        check_overflow();
        check_integrator();
    }
}
