/* FMI 3.0: the life of an instance, its states and derivatives; names and types translated, nothing more. */
#include "fmi3Functions.h"

#include "instance.h"

#include <stdlib.h>

static void send_fmi3(const Log *log, Status status, const char *category, const char *message)
{
    fmi3LogMessageCallback logger = (fmi3LogMessageCallback)log->callback;
    logger(log->environment, (fmi3Status)status, category, message);
}

/* Every call needs an instance; without one there is no logger to say so. */
#define REQUIRE(handle)       \
    if (!(handle)) {          \
        return fmi3Error;     \
    }                         \
    Instance *self = (handle)

/* Ends the call in the modes where the standard forbids it. */
#define ALLOW(modes)                                                        \
    if (instance_allows(self, __func__, (unsigned)(modes)) != STATUS_OK) {  \
        return fmi3Error;                                                   \
    }

#define REQUIRE_POINTER(pointer)                                                    \
    if (!(pointer)) {                                                               \
        return (fmi3Status)instance_refuse(self, __func__, #pointer " is NULL");    \
    }

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

static Instance *instantiate(Kind kind, fmi3String name, fmi3String token, fmi3String resources, bool logging,
                             fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger)
{
    Log log = {
        .send = send_fmi3,
        .callback = (void (*)(void))logger,
        .environment = environment,
        .categories = logging ? LOG_ALL : LOG_ERRORS | LOG_WARNINGS,
    };
    Instance *instance = instance_create(kind, name, token, resources, log);
    if (instance) {
        instance->reads_binary = true;
    }
    return instance;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                          fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment, fmi3LogMessageCallback logMessage)
{
    (void)visible;
    if (!unit.state_count) {
        if (logMessage) {
            logMessage(instanceEnvironment, fmi3Error, "logStatusError",
                       "the unit has no continuous states: it is for co-simulation only");
        }
        return NULL;
    }
    return instantiate(MODEL_EXCHANGE, instanceName, instantiationToken, resourcePath, loggingOn, instanceEnvironment,
                       logMessage);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
                                         fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
                                         fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)visible;
    (void)requiredIntermediateVariables;
    (void)nRequiredIntermediateVariables;
    (void)intermediateUpdate;
    Instance *self = instantiate(CO_SIMULATION, instanceName, instantiationToken, resourcePath, loggingOn,
                                 instanceEnvironment, logMessage);
    if (self) {
        self->event_mode_used = eventModeUsed;
        self->early_return_allowed = earlyReturnAllowed;
    }
    return self;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    instance_free(instance);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories, const fmi3String categories[])
{
    REQUIRE(instance);
    return (fmi3Status)instance_set_logging(self, loggingOn, nCategories, categories);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    REQUIRE(instance);
    (void)toleranceDefined;
    (void)tolerance;
    ALLOW(INSTANTIATED)
    Status status = instance_set_experiment(self, stopTimeDefined, startTime, stopTime);
    return status == STATUS_OK ? (fmi3Status)instance_change_mode(self, __func__, INSTANTIATED, INITIALIZATION)
                               : (fmi3Status)status;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    REQUIRE(instance);
    return (fmi3Status)instance_exit_initialization(self, __func__);
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    REQUIRE(instance);
    return (fmi3Status)instance_change_mode(self, __func__, EVENT | CONTINUOUS_TIME | STEP, TERMINATED);
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    REQUIRE(instance);
    return (fmi3Status)instance_reset(self);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    REQUIRE(instance);
    return (fmi3Status)instance_change_mode(self, __func__, INSTANTIATED, CONFIGURATION);
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    REQUIRE(instance);
    return (fmi3Status)instance_change_mode(self, __func__, CONFIGURATION, INSTANTIATED);
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference valueReference, size_t *nDependencies)
{
    REQUIRE(instance);
    (void)valueReference;
    (void)nDependencies;
    return (fmi3Status)instance_refuse(self, __func__, "dependencies are those of modelDescription.xml");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[],
                                       size_t nDependencies)
{
    REQUIRE(instance);
    (void)dependent;
    (void)elementIndicesOfDependent;
    (void)independents;
    (void)elementIndicesOfIndependents;
    (void)dependencyKinds;
    (void)nDependencies;
    return (fmi3Status)instance_refuse(self, __func__, "dependencies are those of modelDescription.xml");
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    REQUIRE(instance);
    REQUIRE_POINTER(FMUState)
    return (fmi3Status)instance_save(self, (SavedState **)FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    REQUIRE(instance);
    REQUIRE_POINTER(FMUState)
    return (fmi3Status)instance_restore(self, FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    (void)instance;
    if (FMUState) {
        free(*FMUState);
        *FMUState = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    REQUIRE(instance);
    REQUIRE_POINTER(FMUState)
    REQUIRE_POINTER(size)
    *size = instance_saved_size(FMUState);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[], size_t size)
{
    REQUIRE(instance);
    REQUIRE_POINTER(FMUState)
    REQUIRE_POINTER(serializedState)
    return (fmi3Status)instance_serialize(self, FMUState, serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size, fmi3FMUState *FMUState)
{
    REQUIRE(instance);
    REQUIRE_POINTER(FMUState)
    REQUIRE_POINTER(serializedState)
    return (fmi3Status)instance_deserialize(self, serializedState, size, (SavedState **)FMUState);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                        const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                        size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    REQUIRE(instance);
    ALLOW(INITIALIZATION | EVENT | CONTINUOUS_TIME | STEP | TERMINATED)
    REQUIRE_POINTER(seed)
    REQUIRE_POINTER(sensitivity)
    References outputs = {unknowns, nUnknowns, true};
    References inputs = {knowns, nKnowns, true};
    return (fmi3Status)instance_directional_derivative(self, __func__, outputs, inputs, seed, nSeed, sensitivity, nSensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity)
{
    REQUIRE(instance);
    ALLOW(INITIALIZATION | EVENT | CONTINUOUS_TIME | STEP | TERMINATED)
    REQUIRE_POINTER(seed)
    REQUIRE_POINTER(sensitivity)
    References outputs = {unknowns, nUnknowns, true};
    References inputs = {knowns, nKnowns, true};
    return (fmi3Status)instance_adjoint_derivative(self, __func__, outputs, inputs, seed, nSeed, sensitivity, nSensitivity);
}
