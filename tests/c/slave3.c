/* The unit under test through FMI 3.0. */
#include "fmi3Functions.h"

#include "check.h"

#include <string.h>

static void receive(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message)
{
    record_line(environment, (int)status, category, message);
}

unsigned slave_kinds(void)
{
    return CO_SIMULATION | CO_SIMULATION_WITH_EVENT_MODE | (subject()->state_count ? (unsigned)MODEL_EXCHANGE : 0U);
}

void slave_open_as(Slave *slave, Kind kind, const char *name, const char *token)
{
    *slave = (Slave){.kind = kind};
    if (kind == MODEL_EXCHANGE) {
        slave->instance = fmi3InstantiateModelExchange(name, token, NULL, false, false, &slave->log, receive);
    } else {
        bool events = kind == CO_SIMULATION_WITH_EVENT_MODE;
        slave->instance = fmi3InstantiateCoSimulation(name, token, NULL, false, false, events, events, NULL, 0, &slave->log,
                                                      receive, NULL);
    }
}

void slave_close(Slave *slave)
{
    fmi3FreeInstance(slave->instance);
}

int slave_enter_initialization(Slave *slave, double start, const double *stop)
{
    return (int)fmi3EnterInitializationMode(slave->instance, false, 0.0, start, stop != NULL, stop ? *stop : 0.0);
}

int slave_exit_initialization(Slave *slave)
{
    return (int)fmi3ExitInitializationMode(slave->instance);
}

int slave_enter_continuous_time(Slave *slave)
{
    if (slave->kind == CO_SIMULATION) {
        return OK;
    }
    fmi3Status status = fmi3UpdateDiscreteStates(slave->instance, NULL, NULL, NULL, NULL, NULL, NULL);
    if (status != fmi3OK) {
        return (int)status;
    }
    return (int)(slave->kind == MODEL_EXCHANGE ? fmi3EnterContinuousTimeMode : fmi3EnterStepMode)(slave->instance);
}

int slave_enter_configuration(Slave *slave)
{
    return (int)fmi3EnterConfigurationMode(slave->instance);
}

int slave_exit_configuration(Slave *slave)
{
    return (int)fmi3ExitConfigurationMode(slave->instance);
}

int slave_terminate(Slave *slave)
{
    return (int)fmi3Terminate(slave->instance);
}

int slave_reset(Slave *slave)
{
    return (int)fmi3Reset(slave->instance);
}

bool slave_has(const Variable *variable)
{
    (void)variable;
    return true;
}

static int move_clock(Slave *slave, const Variable *variable, double *value, bool set)
{
    fmi3Clock clock = set && *value > 0.0;
    fmi3Status status = set ? fmi3SetClock(slave->instance, &variable->reference, 1, &clock)
                            : fmi3GetClock(slave->instance, &variable->reference, 1, &clock);
    *value = clock;
    return (int)status;
}

/* One variable of a type that is no double, there and back through doubles. */
#define GET(TYPE)                                                                                                    \
    {                                                                                                                \
        fmi3##TYPE typed[MAX_ELEMENTS];                                                                              \
        fmi3Status status = fmi3Get##TYPE(slave->instance, &variable->reference, 1, typed, variable->count);         \
        for (uint32_t k = 0; status == fmi3OK && k < variable->count; k++) {                                         \
            values[k] = (double)typed[k];                                                                            \
        }                                                                                                            \
        return (int)status;                                                                                          \
    }

static int move_binary(Slave *slave, const Variable *variable, bool set)
{
    size_t size = 0;
    fmi3Binary place = NULL;
    return set ? (int)fmi3SetBinary(slave->instance, &variable->reference, 1, &size, &place, 1)
               : (int)fmi3GetBinary(slave->instance, &variable->reference, 1, &size, &place, 1);
}

#define SET(TYPE)                                                                                                    \
    {                                                                                                                \
        fmi3##TYPE typed[MAX_ELEMENTS];                                                                              \
        for (uint32_t k = 0; k < variable->count; k++) {                                                             \
            typed[k] = (fmi3##TYPE)values[k];                                                                        \
        }                                                                                                            \
        return (int)fmi3Set##TYPE(slave->instance, &variable->reference, 1, typed, variable->count);                 \
    }

int slave_get(Slave *slave, const Variable *variable, double *values)
{
    switch ((ValueType)variable->type) {
    case FLOAT64: return (int)fmi3GetFloat64(slave->instance, &variable->reference, 1, values, variable->count);
    case FLOAT32: GET(Float32)
    case INT32: GET(Int32)
    case UINT64: GET(UInt64)
    case BOOLEAN: GET(Boolean)
    case ENUMERATION: GET(Int64)
    case BINARY: return move_binary(slave, variable, false);
    case CLOCK: return move_clock(slave, variable, values, false);
    case VALUE_TYPES: break;
    }
    return ERROR;
}

int slave_set(Slave *slave, const Variable *variable, const double *values)
{
    switch ((ValueType)variable->type) {
    case FLOAT64: return (int)fmi3SetFloat64(slave->instance, &variable->reference, 1, values, variable->count);
    case FLOAT32: SET(Float32)
    case INT32: SET(Int32)
    case UINT64: SET(UInt64)
    case BOOLEAN: SET(Boolean)
    case ENUMERATION: SET(Int64)
    case BINARY: return move_binary(slave, variable, true);
    case CLOCK: return move_clock(slave, variable, &(double){values[0]}, true);
    case VALUE_TYPES: break;
    }
    return ERROR;
}

static size_t stream_elements(Slave *slave, const Variable *variable)
{
    const Subject *unit = subject();
    for (size_t i = 0; i < unit->variable_count; i++) {
        if (unit->variables[i].causality == STRUCTURAL_PARAMETER && unit->variables[i].offset == variable->size_of) {
            double extent = 0.0;
            CHECK(slave_get(slave, &unit->variables[i], &extent) == OK, "%s", slave->log.text);
            return variable->count * (size_t)extent;
        }
    }
    return variable->count;
}

size_t slave_get_stream(Slave *slave, const Variable *variable, void *bytes, size_t size)
{
    size_t count = stream_elements(slave, variable);
    if (variable->type == BINARY) {
        size_t given = 0;
        fmi3Binary place = NULL;
        CHECK(count <= size, "%s has %zu bytes", variable->name, count);
        CHECK(fmi3GetBinary(slave->instance, &variable->reference, 1, &given, &place, 1) == fmi3OK, "%s", slave->log.text);
        CHECK(given == count, "%s has %zu bytes, not %zu", variable->name, given, count);
        memcpy(bytes, place, count);
        return count;
    }
    bool integers = variable->type == INT32;
    size_t needed = count * (integers ? sizeof(fmi3Int32) : sizeof(fmi3Float32));
    CHECK(needed <= size, "%s has %zu bytes", variable->name, needed);
    CHECK(integers || variable->type == FLOAT32, "%s has a type that no stream had before", variable->name);
    fmi3Status status = integers ? fmi3GetInt32(slave->instance, &variable->reference, 1, bytes, count)
                                 : fmi3GetFloat32(slave->instance, &variable->reference, 1, bytes, count);
    CHECK(status == fmi3OK, "%s: %s", variable->name, slave->log.text);
    return needed;
}

static fmi3Status handle_event(Slave *slave)
{
    fmi3Status status = fmi3EnterEventMode(slave->instance);
    if (status == fmi3OK) {
        status = fmi3UpdateDiscreteStates(slave->instance, NULL, NULL, NULL, NULL, NULL, NULL);
    }
    return status == fmi3OK ? fmi3EnterStepMode(slave->instance) : status;
}

int slave_step(Slave *slave, double point, double size)
{
    double end = point + size;
    fmi3Boolean event = false, terminate = false, early = false;
    fmi3Status status;
    do {
        status = fmi3DoStep(slave->instance, point, size, true, &event, &terminate, &early, &point);
        if (status == fmi3OK && event) {
            status = handle_event(slave);
        }
        size = end - point;
    } while (status == fmi3OK && early);
    return (int)status;
}

int slave_set_time(Slave *slave, double time)
{
    return (int)fmi3SetTime(slave->instance, time);
}

int slave_get_states(Slave *slave, double *states, size_t count)
{
    return (int)fmi3GetContinuousStates(slave->instance, states, count);
}

int slave_set_states(Slave *slave, const double *states, size_t count)
{
    return (int)fmi3SetContinuousStates(slave->instance, states, count);
}

int slave_get_derivatives(Slave *slave, double *derivatives, size_t count)
{
    return (int)fmi3GetContinuousStateDerivatives(slave->instance, derivatives, count);
}

int slave_complete_step(Slave *slave)
{
    fmi3Boolean event, terminate;
    return (int)fmi3CompletedIntegratorStep(slave->instance, true, &event, &terminate);
}

int slave_save(Slave *slave, void **state)
{
    return (int)fmi3GetFMUState(slave->instance, state);
}

int slave_restore(Slave *slave, void *state)
{
    return (int)fmi3SetFMUState(slave->instance, state);
}

int slave_release(Slave *slave, void **state)
{
    return (int)fmi3FreeFMUState(slave->instance, state);
}

int slave_serialized_size(Slave *slave, void *state, size_t *size)
{
    return (int)fmi3SerializedFMUStateSize(slave->instance, state, size);
}

int slave_serialize(Slave *slave, void *state, char *bytes, size_t size)
{
    return (int)fmi3SerializeFMUState(slave->instance, state, (fmi3Byte *)bytes, size);
}

int slave_deserialize(Slave *slave, const char *bytes, size_t size, void **state)
{
    return (int)fmi3DeserializeFMUState(slave->instance, (const fmi3Byte *)bytes, size, state);
}

int slave_directional(Slave *slave, const Variable *unknown, const Variable *known, double *result)
{
    double seed[MAX_ELEMENTS];
    for (uint32_t k = 0; k < known->count; k++) {
        seed[k] = 1.0;
    }
    return (int)fmi3GetDirectionalDerivative(slave->instance, &unknown->reference, 1, &known->reference, 1, seed,
                                             known->count, result, unknown->count);
}
