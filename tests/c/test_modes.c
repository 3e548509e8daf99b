/* Every call in every mode: it works where the standard allows it; elsewhere it is an error that names
 * the call and the mode, changes nothing, and leaves an instance that can be reset and used. */
#include "check.h"
#include "run.h"
#include "tests.h"

#include <stdio.h>

static const char *name_of(Mode mode)
{
    switch (mode) {
    case INSTANTIATED: return "Instantiated";
    case CONFIGURATION: return "Configuration Mode";
    case INITIALIZATION: return "Initialization Mode";
    case EVENT: return "Event Mode";
    case CONTINUOUS_TIME: return "Continuous-Time Mode";
    case STEP: return "Step Mode";
    case TERMINATED: return "Terminated";
    case ANY_MODE: break;
    }
    return "?";
}

/* Goes on from a mode as if nothing had been called. */
static bool goes_on(Slave *slave, Mode mode)
{
    switch (mode) {
    case INSTANTIATED: return slave_enter_initialization(slave, 0.0, NULL) == OK;
    case INITIALIZATION: return slave_exit_initialization(slave) == OK;
    case EVENT: return slave_enter_continuous_time(slave) == OK;
    case CONTINUOUS_TIME: return slave_complete_step(slave) == OK;
    case STEP: return slave_step(slave, 0.0, 0.01) == OK;
    default: return true;
    }
}

static void check_call(const Call *call, Kind kind, Mode mode, uint64_t digest)
{
    Slave slave;
    char what[128];
    snprintf(what, sizeof what, "%s in %s, kind %d", call->name, name_of(mode), (int)kind);
    slave_open(&slave, kind);
    if (slave_reach(&slave, mode)) {
        slave.log = (LogRecord){0};
        int status = call->make(&slave);
        if (call->allowed & mode) {
            CHECK(status == OK && slave.log.lines == 0, "%s: %s", what, slave.log.text);
        } else if (call->allowed == 0) {
            CHECK_REFUSED(&slave, status, what, call->name);
        } else {
            CHECK_REFUSED(&slave, status, what, call->name, name_of(mode));
        }
        if (call->refused & mode) {
            CHECK(goes_on(&slave, mode), "%s: the mode changed: %s", what, slave.log.text);
            CHECK(slave_reset(&slave) == OK && run_life(&slave, 1, 2) == digest, "%s: not usable after reset", what);
        }
    }
    slave_close(&slave);
}

void test_modes(void)
{
    for (unsigned kind = CO_SIMULATION; kind < ANY_KIND; kind *= 2) {
        uint64_t digest = slave_kinds() & kind ? run_new((Kind)kind, 1, 2) : 0;
        for (size_t i = 0; i < call_count; i++) {
            for (unsigned mode = INSTANTIATED; mode <= TERMINATED; mode *= 2) {
                if (slave_kinds() & calls[i].kinds & kind && (calls[i].allowed | calls[i].refused) & mode) {
                    check_call(&calls[i], (Kind)kind, (Mode)mode, digest);
                }
            }
        }
    }
}
