/* FMI 3.0: the functions of model exchange and of co-simulation. */
#include "fmi3Functions.h"

#include "instance.h"

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    REQUIRE(instance);
    if (self->kind == CO_SIMULATION && !self->event_mode_used) {
        return (fmi3Status)instance_refuse(self, __func__, "the instance was made with eventModeUsed = false");
    }
    return (fmi3Status)instance_change_mode(self, __func__, CONTINUOUS_TIME | STEP, EVENT);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    REQUIRE(instance);
    ALLOW(INITIALIZATION | EVENT)
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime)
{
    REQUIRE(instance);
    ALLOW(EVENT)
    EventInfo info = {0};
    Status status = instance_update_discrete_states(self, &info);
    fmi3Boolean *flags[] = {discreteStatesNeedUpdate, terminateSimulation, nominalsOfContinuousStatesChanged,
                            valuesOfContinuousStatesChanged};
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
        if (flags[i]) {
            *flags[i] = false;
        }
    }
    if (nextEventTimeDefined) {
        *nextEventTimeDefined = info.next_event_defined;
    }
    if (nextEventTime) {
        *nextEventTime = info.next_event_time;
    }
    return (fmi3Status)status;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    REQUIRE(instance);
    if (self->kind != MODEL_EXCHANGE) {
        return (fmi3Status)instance_refuse(self, __func__, "the instance is for co-simulation");
    }
    return (fmi3Status)instance_change_mode(self, __func__, EVENT, CONTINUOUS_TIME);
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode, fmi3Boolean *terminateSimulation)
{
    REQUIRE(instance);
    (void)noSetFMUStatePriorToCurrentPoint;
    ALLOW(CONTINUOUS_TIME)
    REQUIRE_POINTER(enterEventMode)
    REQUIRE_POINTER(terminateSimulation)
    *enterEventMode = false;
    *terminateSimulation = false;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    REQUIRE(instance);
    ALLOW(CONTINUOUS_TIME)
    return (fmi3Status)instance_move_time(self, time);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    REQUIRE(instance);
    ALLOW(CONTINUOUS_TIME)
    return (fmi3Status)instance_set_states(self, continuousStates, nContinuousStates);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t nContinuousStates)
{
    REQUIRE(instance);
    ALLOW(INITIALIZATION | EVENT | CONTINUOUS_TIME | TERMINATED)
    return (fmi3Status)instance_get_states(self, derivatives, nContinuousStates, true);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[], size_t nContinuousStates)
{
    REQUIRE(instance);
    ALLOW(INITIALIZATION | EVENT | CONTINUOUS_TIME | TERMINATED)
    return (fmi3Status)instance_get_states(self, continuousStates, nContinuousStates, false);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t nContinuousStates)
{
    REQUIRE(instance);
    ALLOW(INITIALIZATION | EVENT | CONTINUOUS_TIME | TERMINATED)
    return (fmi3Status)instance_get_nominals(self, nominals, nContinuousStates);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[], size_t nEventIndicators)
{
    REQUIRE(instance);
    (void)eventIndicators;
    return nEventIndicators ? (fmi3Status)instance_refuse(self, __func__, "the unit has no event indicators") : fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    REQUIRE(instance);
    REQUIRE_POINTER(nEventIndicators)
    *nEventIndicators = 0;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    REQUIRE(instance);
    REQUIRE_POINTER(nContinuousStates)
    *nContinuousStates = unit.state_count;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    REQUIRE(instance);
    if (self->kind != CO_SIMULATION) {
        return (fmi3Status)instance_refuse(self, __func__, "the instance is for model exchange");
    }
    return (fmi3Status)instance_change_mode(self, __func__, EVENT, STEP);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
{
    REQUIRE(instance);
    (void)valueReferences;
    (void)nValueReferences;
    (void)orders;
    (void)values;
    (void)nValues;
    return (fmi3Status)instance_refuse(self, __func__, "the unit gives no derivatives of outputs (maxOutputDerivativeOrder is 0)");
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    REQUIRE(instance);
    (void)noSetFMUStatePriorToCurrentPoint;
    ALLOW(STEP)
    StepResult result = {.last_time = instance_time(self)};
    Status status = instance_step(self, currentCommunicationPoint, communicationStepSize, &result);
    if (eventHandlingNeeded) {
        *eventHandlingNeeded = result.event_needed;
    }
    if (terminateSimulation) {
        *terminateSimulation = false;
    }
    if (earlyReturn) {
        *earlyReturn = result.early_return;
    }
    if (lastSuccessfulTime) {
        *lastSuccessfulTime = result.last_time;
    }
    return (fmi3Status)status;
}
