/* FMI 2.0: the functions of model exchange and of co-simulation. */
#include "fmi2Functions.h"

#include "instance.h"

#include <string.h>

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    REQUIRE(c);
    return (fmi2Status)instance_change_mode(instance, __func__, EVENT | CONTINUOUS_TIME, EVENT);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *fmi2eventInfo)
{
    REQUIRE(c);
    ALLOW(EVENT)
    if (!fmi2eventInfo) {
        return (fmi2Status)instance_refuse(instance, __func__, "fmi2eventInfo is NULL");
    }
    EventInfo info = {0};
    Status status = instance_update_discrete_states(instance, &info);
    memset(fmi2eventInfo, 0, sizeof *fmi2eventInfo);
    fmi2eventInfo->nextEventTimeDefined = info.next_event_defined;
    fmi2eventInfo->nextEventTime = info.next_event_time;
    return (fmi2Status)status;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    REQUIRE(c);
    return (fmi2Status)instance_change_mode(instance, __func__, EVENT | CONTINUOUS_TIME, CONTINUOUS_TIME);
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    REQUIRE(c);
    (void)noSetFMUStatePriorToCurrentPoint;
    ALLOW(CONTINUOUS_TIME)
    if (!enterEventMode || !terminateSimulation) {
        return (fmi2Status)instance_refuse(instance, __func__, "an argument is NULL");
    }
    *enterEventMode = fmi2False;
    *terminateSimulation = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    REQUIRE(c);
    ALLOW(EVENT | CONTINUOUS_TIME)
    return (fmi2Status)instance_move_time(instance, time);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    REQUIRE(c);
    ALLOW(CONTINUOUS_TIME)
    return (fmi2Status)instance_set_states(instance, x, nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    REQUIRE(c);
    ALLOW(EVENT | CONTINUOUS_TIME | TERMINATED)
    return (fmi2Status)instance_get_states(instance, derivatives, nx, true);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    REQUIRE(c);
    (void)eventIndicators;
    return ni ? (fmi2Status)instance_refuse(instance, __func__, "the unit has no event indicators") : fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    REQUIRE(c);
    ALLOW(EVENT | CONTINUOUS_TIME | TERMINATED)
    return (fmi2Status)instance_get_states(instance, x, nx, false);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    REQUIRE(c);
    ALLOW(INSTANTIATED | EVENT | CONTINUOUS_TIME | TERMINATED)
    return (fmi2Status)instance_get_nominals(instance, x_nominal, nx);
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[],
                                       const fmi2Real value[])
{
    REQUIRE(c);
    Status status = check_arrays(instance, __func__, vr, value, nvr);
    if (status == STATUS_OK) {
        status = check_arrays(instance, __func__, order, value, nvr);
    }
    for (size_t i = 0; status == STATUS_OK && i < nvr; i++) {
        uint32_t element;
        const Variable *variable = scalar(instance, __func__, vr[i], FLOAT64, &element);
        if (!variable) {
            return fmi2Error;
        }
        if (order[i] != 1 || variable->rate == NO_VARIABLE) {
            return (fmi2Status)report(&instance->log, STATUS_ERROR,
                                      "%s: derivative %d of %s is not taken; allowed: derivative 1 of inputs with a _rate",
                                      __func__, order[i], variable->name);
        }
        status = set_element(instance, __func__, &unit.variables[variable->rate], element, value[i]);
    }
    return (fmi2Status)status;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer order[],
                                        fmi2Real value[])
{
    REQUIRE(c);
    (void)vr;
    (void)nvr;
    (void)order;
    (void)value;
    return (fmi2Status)instance_refuse(instance, __func__, "the unit gives no derivatives of outputs (maxOutputDerivativeOrder is 0)");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    REQUIRE(c);
    (void)noSetFMUStatePriorToCurrentPoint;
    ALLOW(STEP)
    StepResult result = {0};
    return (fmi2Status)instance_step(instance, currentCommunicationPoint, communicationStepSize, &result);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    REQUIRE(c);
    return (fmi2Status)instance_refuse(instance, __func__, "no step is under way: steps are not asynchronous");
}

static fmi2Status no_status(fmi2Component c, const char *call)
{
    REQUIRE(c);
    return (fmi2Status)instance_refuse(instance, call, "no such status: steps are not asynchronous");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    (void)s;
    (void)value;
    return no_status(c, __func__);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    REQUIRE(c);
    if (s != fmi2LastSuccessfulTime || !value) {
        return no_status(c, __func__);
    }
    *value = instance->last_time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    (void)s;
    (void)value;
    return no_status(c, __func__);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    if (!c || s != fmi2Terminated || !value) {
        return no_status(c, __func__);
    }
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    (void)s;
    (void)value;
    return no_status(c, __func__);
}
