/* FMI 3.0: the functions of clocks and scheduled execution. No unit has a clock yet. */
#include "fmi3Functions.h"

#include "instance.h"

static fmi3Status no_clock(Instance *instance, const char *call, size_t count)
{
    if (!instance) {
        return fmi3Error;
    }
    return count ? (fmi3Status)instance_refuse(instance, call, "the unit has no clocks") : fmi3OK;
}

#define NO_CLOCK_FUNCTION(NAME, ...)                                                                              \
    fmi3Status NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,    \
                    __VA_ARGS__)                                                                                  \
    {                                                                                                             \
        (void)valueReferences;                                                                                    \
        (void)first;                                                                                              \
        return no_clock(instance, #NAME, nValueReferences);                                                       \
    }

#define NO_CLOCK_FUNCTION_OF_TWO(NAME, ...)                                                                       \
    fmi3Status NAME(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,    \
                    __VA_ARGS__)                                                                                  \
    {                                                                                                             \
        (void)valueReferences;                                                                                    \
        (void)first;                                                                                              \
        (void)second;                                                                                             \
        return no_clock(instance, #NAME, nValueReferences);                                                       \
    }

NO_CLOCK_FUNCTION(fmi3GetClock, fmi3Clock first[])
NO_CLOCK_FUNCTION(fmi3SetClock, const fmi3Clock first[])
NO_CLOCK_FUNCTION(fmi3GetShiftDecimal, fmi3Float64 first[])
NO_CLOCK_FUNCTION(fmi3SetShiftDecimal, const fmi3Float64 first[])
NO_CLOCK_FUNCTION(fmi3SetIntervalDecimal, const fmi3Float64 first[])
NO_CLOCK_FUNCTION_OF_TWO(fmi3GetShiftFraction, fmi3UInt64 first[], fmi3UInt64 second[])
NO_CLOCK_FUNCTION_OF_TWO(fmi3SetShiftFraction, const fmi3UInt64 first[], const fmi3UInt64 second[])
NO_CLOCK_FUNCTION_OF_TWO(fmi3SetIntervalFraction, const fmi3UInt64 first[], const fmi3UInt64 second[])
NO_CLOCK_FUNCTION_OF_TWO(fmi3GetIntervalDecimal, fmi3Float64 first[], fmi3IntervalQualifier second[])

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                   fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    (void)valueReferences;
    (void)counters;
    (void)resolutions;
    (void)qualifiers;
    return no_clock(instance, "fmi3GetIntervalFraction", nValueReferences);
}

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
        logMessage(instanceEnvironment, fmi3Error, "logStatusError", "the unit has no clocks: scheduled execution is not supported");
    }
    return NULL;
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference, fmi3Float64 activationTime)
{
    (void)clockReference;
    (void)activationTime;
    return no_clock(instance, "fmi3ActivateModelPartition", 1);
}
