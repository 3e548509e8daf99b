/* The unit under test through FMI 2.0. */
#include "fmi2Functions.h"

#include "check.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void receive(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                    fmi2String format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    (void)name;
    record_line(environment, (int)status, category, text);
}

unsigned slave_kinds(void)
{
    return CO_SIMULATION | (subject()->state_count ? (unsigned)MODEL_EXCHANGE : 0U);
}

void slave_open_as(Slave *slave, Kind kind, const char *name, const char *token)
{
    *slave = (Slave){.kind = kind};
    fmi2CallbackFunctions functions = {receive, calloc, free, NULL, &slave->log};
    slave->instance = fmi2Instantiate(name, kind == MODEL_EXCHANGE ? fmi2ModelExchange : fmi2CoSimulation, token, NULL,
                                      &functions, fmi2False, fmi2False);
}

void slave_close(Slave *slave)
{
    fmi2FreeInstance(slave->instance);
}

int slave_enter_initialization(Slave *slave, double start, const double *stop)
{
    fmi2Status status = fmi2SetupExperiment(slave->instance, fmi2False, 0.0, start, stop != NULL, stop ? *stop : 0.0);
    return (int)(status == fmi2OK ? fmi2EnterInitializationMode(slave->instance) : status);
}

int slave_exit_initialization(Slave *slave)
{
    return (int)fmi2ExitInitializationMode(slave->instance);
}

int slave_enter_continuous_time(Slave *slave)
{
    if (slave->kind != MODEL_EXCHANGE) {
        return OK;
    }
    fmi2EventInfo info;
    fmi2Status status = fmi2NewDiscreteStates(slave->instance, &info);
    return (int)(status == fmi2OK ? fmi2EnterContinuousTimeMode(slave->instance) : status);
}

int slave_enter_configuration(Slave *slave)
{
    (void)slave;
    return ERROR;
}

int slave_exit_configuration(Slave *slave)
{
    (void)slave;
    return ERROR;
}

int slave_terminate(Slave *slave)
{
    return (int)fmi2Terminate(slave->instance);
}

int slave_reset(Slave *slave)
{
    return (int)fmi2Reset(slave->instance);
}

bool slave_has(const Variable *variable)
{
    return is_field(variable) && variable->type != CLOCK;
}

static void list_references(const Variable *variable, fmi2ValueReference *references)
{
    for (uint32_t k = 0; k < variable->count; k++) {
        references[k] = variable->reference + k;
    }
}

int slave_get(Slave *slave, const Variable *variable, double *values)
{
    fmi2ValueReference references[MAX_ELEMENTS];
    fmi2Integer integers[MAX_ELEMENTS];
    list_references(variable, references);
    if (variable->type == FLOAT64) {
        return (int)fmi2GetReal(slave->instance, references, variable->count, values);
    }
    bool boolean = variable->type == BOOLEAN;
    fmi2Status status = (boolean ? fmi2GetBoolean : fmi2GetInteger)(slave->instance, references, variable->count, integers);
    for (uint32_t k = 0; status == fmi2OK && k < variable->count; k++) {
        values[k] = integers[k];
    }
    return (int)status;
}

int slave_set(Slave *slave, const Variable *variable, const double *values)
{
    fmi2ValueReference references[MAX_ELEMENTS];
    fmi2Integer integers[MAX_ELEMENTS];
    list_references(variable, references);
    if (variable->type == FLOAT64) {
        return (int)fmi2SetReal(slave->instance, references, variable->count, values);
    }
    for (uint32_t k = 0; k < variable->count; k++) {
        integers[k] = (fmi2Integer)values[k];
    }
    bool boolean = variable->type == BOOLEAN;
    return (int)(boolean ? fmi2SetBoolean : fmi2SetInteger)(slave->instance, references, variable->count, integers);
}

/* FMI 2 does not show them. */
size_t slave_get_stream(Slave *slave, const Variable *variable, void *bytes, size_t size)
{
    (void)slave;
    (void)variable;
    (void)bytes;
    (void)size;
    return 0;
}

int slave_step(Slave *slave, double point, double size)
{
    return (int)fmi2DoStep(slave->instance, point, size, fmi2True);
}

int slave_set_time(Slave *slave, double time)
{
    return (int)fmi2SetTime(slave->instance, time);
}

int slave_get_states(Slave *slave, double *states, size_t count)
{
    return (int)fmi2GetContinuousStates(slave->instance, states, count);
}

int slave_set_states(Slave *slave, const double *states, size_t count)
{
    return (int)fmi2SetContinuousStates(slave->instance, states, count);
}

int slave_get_derivatives(Slave *slave, double *derivatives, size_t count)
{
    return (int)fmi2GetDerivatives(slave->instance, derivatives, count);
}

int slave_complete_step(Slave *slave)
{
    fmi2Boolean event, terminate;
    return (int)fmi2CompletedIntegratorStep(slave->instance, fmi2True, &event, &terminate);
}

int slave_save(Slave *slave, void **state)
{
    return (int)fmi2GetFMUstate(slave->instance, state);
}

int slave_restore(Slave *slave, void *state)
{
    return (int)fmi2SetFMUstate(slave->instance, state);
}

int slave_release(Slave *slave, void **state)
{
    return (int)fmi2FreeFMUstate(slave->instance, state);
}

int slave_serialized_size(Slave *slave, void *state, size_t *size)
{
    return (int)fmi2SerializedFMUstateSize(slave->instance, state, size);
}

int slave_serialize(Slave *slave, void *state, char *bytes, size_t size)
{
    return (int)fmi2SerializeFMUstate(slave->instance, state, bytes, size);
}

int slave_deserialize(Slave *slave, const char *bytes, size_t size, void **state)
{
    return (int)fmi2DeSerializeFMUstate(slave->instance, bytes, size, state);
}

int slave_directional(Slave *slave, const Variable *unknown, const Variable *known, double *result)
{
    fmi2ValueReference unknowns[MAX_ELEMENTS], knowns[MAX_ELEMENTS];
    double seed[MAX_ELEMENTS];
    list_references(unknown, unknowns);
    list_references(known, knowns);
    for (uint32_t k = 0; k < known->count; k++) {
        seed[k] = 1.0;
    }
    return (int)fmi2GetDirectionalDerivative(slave->instance, unknowns, unknown->count, knowns, known->count, seed, result);
}
