/* FMI 2.0: names and types translated, nothing more. */
#include "fmi2Functions.h"

#include "instance.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void send_fmi2(const Log *log, Status status, const char *category, const char *message)
{
    fmi2CallbackLogger logger = (fmi2CallbackLogger)log->callback;
    logger(log->environment, log->instance_name, (fmi2Status)status, category, "%s", message);
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID, fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean loggingOn)
{
    (void)visible;
    if (!functions) {
        return NULL;
    }
    Log log = {
        .send = send_fmi2,
        .callback = (void (*)(void))functions->logger,
        .environment = functions->componentEnvironment,
        .instance_name = (char *)(uintptr_t)(instanceName ? instanceName : unit.name),
        .categories = loggingOn ? LOG_ALL : LOG_ERRORS | LOG_WARNINGS,
    };
    if (fmuType != fmi2CoSimulation && fmuType != fmi2ModelExchange) {
        report(&log, STATUS_ERROR, "fmuType = %d; allowed range: fmi2ModelExchange, fmi2CoSimulation", (int)fmuType);
        return NULL;
    }
    if (fmuType == fmi2ModelExchange && !unit.state_count) {
        report(&log, STATUS_ERROR, "%s has no continuous states: it is for co-simulation only", unit.name);
        return NULL;
    }
    Kind kind = fmuType == fmi2CoSimulation ? CO_SIMULATION : MODEL_EXCHANGE;
    return instance_create(kind, instanceName, fmuGUID, fmuResourceLocation, log);
}

void fmi2FreeInstance(fmi2Component c)
{
    instance_free(c);
}

/* Every call below needs an instance; without one there is no logger to say so. */
#define REQUIRE(c)            \
    if (!(c)) {               \
        return fmi2Error;     \
    }                         \
    Instance *instance = (c)

/* Ends the call in the modes where the standard forbids it. */
#define ALLOW(modes)                                                            \
    if (instance_allows(instance, __func__, (unsigned)(modes)) != STATUS_OK) {  \
        return fmi2Error;                                                       \
    }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories, const fmi2String categories[])
{
    REQUIRE(c);
    return (fmi2Status)instance_set_logging(instance, loggingOn, nCategories, categories);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    REQUIRE(c);
    (void)toleranceDefined;
    (void)tolerance;
    ALLOW(INSTANTIATED)
    return (fmi2Status)instance_set_experiment(instance, stopTimeDefined, startTime, stopTime);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    REQUIRE(c);
    instance_touch(instance);
    return (fmi2Status)instance_change_mode(instance, __func__, INSTANTIATED, INITIALIZATION);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    REQUIRE(c);
    return (fmi2Status)instance_exit_initialization(instance, __func__);
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    REQUIRE(c);
    return (fmi2Status)instance_change_mode(instance, __func__, EVENT | CONTINUOUS_TIME | STEP, TERMINATED);
}

fmi2Status fmi2Reset(fmi2Component c)
{
    REQUIRE(c);
    return (fmi2Status)instance_reset(instance);
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    REQUIRE(c);
    Status status = check_arrays(instance, __func__, vr, value, nvr);
    for (size_t i = 0; status == STATUS_OK && i < nvr; i++) {
        status = get_scalar(instance, __func__, vr[i], FLOAT64, &value[i]);
    }
    return (fmi2Status)status;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[])
{
    REQUIRE(c);
    Status status = check_arrays(instance, __func__, vr, value, nvr);
    for (size_t i = 0; status == STATUS_OK && i < nvr; i++) {
        double number = 0.0;
        status = get_scalar(instance, __func__, vr[i], INT32, &number);
        value[i] = (fmi2Integer)number;
    }
    return (fmi2Status)status;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[])
{
    REQUIRE(c);
    Status status = check_arrays(instance, __func__, vr, value, nvr);
    for (size_t i = 0; status == STATUS_OK && i < nvr; i++) {
        double number = 0.0;
        status = get_scalar(instance, __func__, vr[i], BOOLEAN, &number);
        value[i] = number > 0.5 ? fmi2True : fmi2False;
    }
    return (fmi2Status)status;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    REQUIRE(c);
    Status status = check_arrays(instance, __func__, vr, value, nvr);
    for (size_t i = 0; status == STATUS_OK && i < nvr; i++) {
        status = set_scalar(instance, __func__, vr[i], FLOAT64, value[i]);
    }
    return (fmi2Status)status;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[])
{
    REQUIRE(c);
    Status status = check_arrays(instance, __func__, vr, value, nvr);
    for (size_t i = 0; status == STATUS_OK && i < nvr; i++) {
        status = set_scalar(instance, __func__, vr[i], INT32, (double)value[i]);
    }
    return (fmi2Status)status;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[])
{
    REQUIRE(c);
    Status status = check_arrays(instance, __func__, vr, value, nvr);
    for (size_t i = 0; status == STATUS_OK && i < nvr; i++) {
        status = set_scalar(instance, __func__, vr[i], BOOLEAN, value[i] ? 1.0 : 0.0);
    }
    return (fmi2Status)status;
}

static fmi2Status no_strings(Instance *instance, const char *call, size_t count)
{
    return count ? (fmi2Status)instance_refuse(instance, call, "the unit has no variables of type String") : fmi2OK;
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[])
{
    REQUIRE(c);
    (void)vr;
    (void)value;
    return no_strings(instance, __func__, nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[])
{
    REQUIRE(c);
    (void)vr;
    (void)value;
    return no_strings(instance, __func__, nvr);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    REQUIRE(c);
    if (!FMUstate) {
        return (fmi2Status)instance_refuse(instance, __func__, "FMUstate is NULL");
    }
    return (fmi2Status)instance_save(instance, (SavedState **)FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    REQUIRE(c);
    if (!FMUstate) {
        return (fmi2Status)instance_refuse(instance, __func__, "FMUstate is NULL");
    }
    return (fmi2Status)instance_restore(instance, FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    (void)c;
    if (FMUstate) {
        free(*FMUstate);
        *FMUstate = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    REQUIRE(c);
    if (!FMUstate || !size) {
        return (fmi2Status)instance_refuse(instance, __func__, "an argument is NULL");
    }
    *size = instance_saved_size(FMUstate);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    REQUIRE(c);
    if (!FMUstate || !serializedState) {
        return (fmi2Status)instance_refuse(instance, __func__, "an argument is NULL");
    }
    return (fmi2Status)instance_serialize(instance, FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size, fmi2FMUstate *FMUstate)
{
    REQUIRE(c);
    if (!FMUstate || !serializedState) {
        return (fmi2Status)instance_refuse(instance, __func__, "an argument is NULL");
    }
    return (fmi2Status)instance_deserialize(instance, serializedState, size, (SavedState **)FMUstate);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[])
{
    REQUIRE(c);
    ALLOW(INITIALIZATION | EVENT | CONTINUOUS_TIME | STEP | TERMINATED)
    if (!dvKnown || !dvUnknown) {
        return (fmi2Status)instance_refuse(instance, __func__, "an array is NULL");
    }
    References unknowns = {vUnknown_ref, nUnknown, false};
    References knowns = {vKnown_ref, nKnown, false};
    return (fmi2Status)instance_directional_derivative(instance, __func__, unknowns, knowns, dvKnown, nKnown, dvUnknown,
                                                       nUnknown);
}
