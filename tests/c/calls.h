/* Calls with arguments that suit the unit under test, the same in both versions of the standard. */
#ifndef ULNA_TEST_CALLS_H
#define ULNA_TEST_CALLS_H

#include "check.h"
#include "pick.h"

static int set_time(Slave *slave)
{
    return slave_set_time(slave, 0.0);
}

static int set_states(Slave *slave)
{
    double states[MAX_STATES];
    for (size_t i = 0; i < MAX_STATES; i++) {
        states[i] = 0.5;
    }
    return slave_set_states(slave, states, subject()->state_count);
}

static int get_states(Slave *slave)
{
    double states[MAX_STATES];
    return slave_get_states(slave, states, subject()->state_count);
}

static int get_derivatives(Slave *slave)
{
    double states[MAX_STATES];
    return slave_get_derivatives(slave, states, subject()->state_count);
}

static int do_step(Slave *slave)
{
    return slave_step(slave, 0.0, 0.01);
}

static int get_output(Slave *slave)
{
    double values[MAX_ELEMENTS];
    return slave_get(slave, pick(FLOAT64, OUTPUT, -1), values);
}

static int set_input(Slave *slave)
{
    double values[MAX_ELEMENTS] = {0};
    return slave_set(slave, pick(FLOAT64, INPUT, CONTINUOUS), values);
}

static int set_fixed_parameter(Slave *slave)
{
    double values[MAX_ELEMENTS];
    const Variable *parameter = pick(FLOAT64, PARAMETER, FIXED);
    int status = slave_get(slave, parameter, values);
    return status == OK ? slave_set(slave, parameter, values) : status;
}

#endif
