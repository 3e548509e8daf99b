/* FMI 3.0: the functions of clocks; scheduled execution is refused. */
#include "fmi3Functions.h"

#include "instance.h"

#include <math.h>
#include <string.h>

/* Of intervals as fractions, per second: as in the model description, finer than the rounding of a time. */
#define CLOCK_RESOLUTION 0x1p50
#define LONGEST_FRACTION 0x1p13 /* s, far from where the counter would overflow */

/* As far as an importer's time may be off: that of check_step in stepping.c. */
#define CLOCK_TOLERANCE 1e-9

static const Variable *find_clock(Instance *instance, const char *call, uint32_t reference)
{
    const Variable *variable = instance_find(instance, call, reference, true);
    if (variable && variable->type != CLOCK) {
        report(&instance->log, STATUS_ERROR, "%s: %s is of type %s", call, variable->name, type_names[variable->type]);
        return NULL;
    }
    return variable;
}

static Status refuse_clock(Instance *instance, const char *call, const Variable *clock, const char *reason)
{
    return report(&instance->log, STATUS_ERROR, "%s: %s %s", call, clock->name, reason);
}

/* What is remembered of a countdown clock: when it ticks, and the interval that was told last, below 0 for none. */
static double *told_of(Instance *instance, const Variable *clock, size_t which)
{
    return (double *)(void *)(instance->values + clock[which].offset);
}

enum { TICK = 1, INTERVAL = 2 };

/* A countdown clock ticks when the unit says, or said when it was asked: it may have gone on by itself since. */
static Status check_tick(Instance *instance, const char *call, const Variable *clock)
{
    double now = instance_time(instance), tolerance = CLOCK_TOLERANCE * (1.0 + fabs(now));
    double due = unit.clock_time(instance->values, (size_t)(clock - unit.variables));
    if (fabs(now - due) <= tolerance || fabs(now - *told_of(instance, clock, TICK)) <= tolerance) {
        return STATUS_OK;
    }
    if (!isfinite(due)) {
        return report(&instance->log, STATUS_ERROR, "%s: %s is set at %.17g s, where no tick of it is due", call, clock->name,
                      now);
    }
    return report(&instance->log, STATUS_ERROR, "%s: %s is set at %.17g s; allowed: at %.17g s", call, clock->name, now, due);
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[])
{
    REQUIRE(instance);
    ALLOW(EVENT)
    Status status = check_arrays(self, __func__, valueReferences, values, nValueReferences);
    for (size_t i = 0; status == STATUS_OK && i < nValueReferences; i++) {
        const Variable *clock = find_clock(self, __func__, valueReferences[i]);
        if (!clock) {
            return fmi3Error;
        }
        values[i] = self->values[clock->offset] != 0;
    }
    return (fmi3Status)status;
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[])
{
    REQUIRE(instance);
    ALLOW(EVENT)
    Status status = check_arrays(self, __func__, valueReferences, values, nValueReferences);
    for (size_t i = 0; status == STATUS_OK && i < nValueReferences; i++) {
        const Variable *clock = find_clock(self, __func__, valueReferences[i]);
        status = clock ? check_settable(self, __func__, clock) : STATUS_ERROR;
        if (status == STATUS_OK && clock->countdown && values[i]) {
            status = check_tick(self, __func__, clock);
        }
        if (status == STATUS_OK) {
            self->values[clock->offset] = values[i];
        }
    }
    return (fmi3Status)status;
}

/* The interval of a countdown clock from now on: told once, then repeated while it holds. */
static Status next_interval(Instance *instance, const char *call, uint32_t reference, double *interval,
                            fmi3IntervalQualifier *qualifier)
{
    const Variable *clock = find_clock(instance, call, reference);
    if (!clock) {
        return STATUS_ERROR;
    }
    if (!clock->countdown) {
        return refuse_clock(instance, call, clock, "is triggered: it has no interval");
    }
    double due = unit.clock_time(instance->values, (size_t)(clock - unit.variables));
    double *tick = told_of(instance, clock, TICK), *told = told_of(instance, clock, INTERVAL);
    if (!isfinite(due)) {
        *told = -1.0;
        *qualifier = fmi3IntervalNotYetKnown;
    } else if (*told >= 0.0 && *tick == due) {
        *qualifier = fmi3IntervalUnchanged;
    } else {
        *tick = due;
        *told = fmax(due - instance_time(instance), 0.0);
        *qualifier = fmi3IntervalChanged;
    }
    *interval = *told;
    return STATUS_OK;
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                  fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    REQUIRE(instance);
    ALLOW(INITIALIZATION | EVENT)
    Status status = check_arrays(self, __func__, valueReferences, intervals, nValueReferences);
    status = status == STATUS_OK ? check_arrays(self, __func__, valueReferences, qualifiers, nValueReferences) : status;
    for (size_t i = 0; status == STATUS_OK && i < nValueReferences; i++) {
        status = next_interval(self, __func__, valueReferences[i], &intervals[i], &qualifiers[i]);
    }
    return (fmi3Status)status;
}

static Status as_fraction(Instance *instance, const char *call, double interval, fmi3UInt64 *counter, fmi3UInt64 *resolution)
{
    if (interval > LONGEST_FRACTION) {
        return report(&instance->log, STATUS_ERROR, "%s: an interval of %g s is too long for a fraction; allowed: %g s; "
                      "fmi3GetIntervalDecimal gives it", call, interval, LONGEST_FRACTION);
    }
    *counter = (fmi3UInt64)fmax(nearbyint(interval * CLOCK_RESOLUTION), 0.0);
    *resolution = (fmi3UInt64)CLOCK_RESOLUTION;
    return STATUS_OK;
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                   fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    REQUIRE(instance);
    ALLOW(INITIALIZATION | EVENT)
    Status status = check_arrays(self, __func__, valueReferences, counters, nValueReferences);
    status = status == STATUS_OK ? check_arrays(self, __func__, resolutions, qualifiers, nValueReferences) : status;
    for (size_t i = 0; status == STATUS_OK && i < nValueReferences; i++) {
        double interval;
        status = next_interval(self, __func__, valueReferences[i], &interval, &qualifiers[i]);
        if (status == STATUS_OK) {
            status = as_fraction(self, __func__, interval, &counters[i], &resolutions[i]);
        }
    }
    return (fmi3Status)status;
}

/* What the standard allows for periodic clocks only. */
static fmi3Status refuse_periodic(Instance *instance, const char *call, const fmi3ValueReference *references, size_t count)
{
    if (!instance) {
        return fmi3Error;
    }
    Status status = check_arrays(instance, call, references, references, count);
    if (status == STATUS_OK && count) {
        const Variable *clock = find_clock(instance, call, references[0]);
        status = clock ? refuse_clock(instance, call, clock, "is not periodic") : STATUS_ERROR;
    }
    return (fmi3Status)status;
}

#define PERIODIC_ONLY(NAME, TYPE)                                                                                 \
    fmi3Status NAME##Decimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],                    \
                             size_t nValueReferences, TYPE fmi3Float64 decimals[])                                 \
    {                                                                                                             \
        (void)decimals;                                                                                           \
        return refuse_periodic(instance, #NAME "Decimal", valueReferences, nValueReferences);                     \
    }                                                                                                             \
    fmi3Status NAME##Fraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],                   \
                              size_t nValueReferences, TYPE fmi3UInt64 counters[], TYPE fmi3UInt64 resolutions[])  \
    {                                                                                                             \
        (void)counters;                                                                                           \
        (void)resolutions;                                                                                        \
        return refuse_periodic(instance, #NAME "Fraction", valueReferences, nValueReferences);                    \
    }

PERIODIC_ONLY(fmi3GetShift, )
PERIODIC_ONLY(fmi3SetShift, const)
PERIODIC_ONLY(fmi3SetInterval, const)

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                               fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage,
                                               fmi3ClockUpdateCallback clockUpdate, fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    (void)instanceName;
    (void)instantiationToken;
    (void)resourcePath;
    (void)visible;
    (void)loggingOn;
    (void)clockUpdate;
    (void)lockPreemption;
    (void)unlockPreemption;
    if (logMessage) {
        logMessage(instanceEnvironment, fmi3Error, "logStatusError", "scheduled execution is not supported");
    }
    return NULL;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference, fmi3Float64 activationTime)
{
    REQUIRE(instance);
    (void)clockReference;
    (void)activationTime;
    return (fmi3Status)instance_refuse(self, __func__, "scheduled execution is not supported");
}
