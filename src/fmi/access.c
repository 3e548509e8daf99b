/* Getting and setting variables: one loop over the table for every type. */
#include "instance.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const size_t element_size[VALUE_TYPES] = {
    [FLOAT64] = sizeof(double),  [FLOAT32] = sizeof(float), [INT32] = sizeof(int32_t),
    [UINT64] = sizeof(uint64_t), [BOOLEAN] = sizeof(bool),  [ENUMERATION] = sizeof(int64_t),
    [BINARY] = 1,                [CLOCK] = sizeof(bool),
};

static const char *const type_names[VALUE_TYPES] = {
    [FLOAT64] = "Float64", [FLOAT32] = "Float32", [INT32] = "Int32",
    [UINT64] = "UInt64",   [BOOLEAN] = "Boolean", [ENUMERATION] = "Enumeration",
    [BINARY] = "Binary",   [CLOCK] = "Clock",
};

/* The variable of a value reference; `whole` where the reference must be that of a first element. */
static const Variable *instance_find(Instance *instance, const char *call, uint32_t reference, bool whole)
{
    if (reference < unit.reference_count) {
        const Variable *variable = &unit.variables[unit.variable_of[reference]];
        if (variable->causality != MEMORY && (!whole || variable->reference == reference)) {
            return variable;
        }
    }
    report(&instance->log, STATUS_ERROR, "%s: unknown value reference %u; allowed range: those in modelDescription.xml",
           call, (unsigned)reference);
    return NULL;
}

static const char *element_name(const Variable *variable, uint32_t element, char *text, size_t size)
{
    if (variable->count == 1 && !variable->size_of) {
        return variable->name;
    }
    snprintf(text, size, "%s[%u]", variable->name, (unsigned)element + 1);
    return text;
}

static double value_at(uint8_t type, const char *place)
{
    union {
        double float64;
        float float32;
        int32_t int32;
        uint64_t uint64;
        int64_t int64;
        bool boolean;
    } value;
    memcpy(&value, place, element_size[type]);
    switch ((ValueType)type) {
    case FLOAT64: return value.float64;
    case FLOAT32: return (double)value.float32;
    case INT32: return (double)value.int32;
    case UINT64: return (double)value.uint64;
    case ENUMERATION: return (double)value.int64;
    case CLOCK:
    case BOOLEAN: return value.boolean ? 1.0 : 0.0;
    case BINARY:
    case VALUE_TYPES: break;
    }
    return NAN;
}

static double element_as_double(const Instance *instance, const Variable *variable, uint32_t element)
{
    return value_at(variable->type, instance->values + variable->offset + element * element_size[variable->type]);
}

static size_t element_count(const Instance *instance, const Variable *variable)
{
    uint64_t extent = 1;
    if (variable->size_of) {
        memcpy(&extent, instance->values + variable->size_of, sizeof extent);
    }
    return variable->count * (size_t)extent;
}

static bool computed(const Variable *variable)
{
    return variable->causality == OUTPUT || variable->causality == LOCAL;
}

/* Makes sure that what is read has been computed. */
static Status instance_ready_to_read(Instance *instance, const char *call, const Variable *variable)
{
    if (!computed(variable) || variable->variability == CONSTANT) {
        return STATUS_OK;
    }
    if (instance->mode & (INSTANTIATED | CONFIGURATION)) {
        return instance_allows(instance, call, INITIALIZATION | EVENT | CONTINUOUS_TIME | STEP | RECONFIGURATION | TERMINATED);
    }
    if (variable->group == NO_GROUP || variable->group == STREAM) {
        return instance->mode == INITIALIZATION || variable->group == STREAM ? instance_refresh(instance, 0) : STATUS_OK;
    }
    return instance_refresh(instance, 1U << variable->group);
}

static Status check_arrays(Instance *instance, const char *call, const void *references, const void *values, size_t count)
{
    return count && (!references || !values) ? instance_refuse(instance, call, "an array is NULL") : STATUS_OK;
}

/* The modes in which an importer may set a variable; none where the unit computes it. */
static unsigned settable_modes(const Variable *variable)
{
    switch ((Causality)variable->causality) {
    case STRUCTURAL_PARAMETER: return CONFIGURATION;
    case PARAMETER: return INSTANTIATED | INITIALIZATION | (variable->variability == TUNABLE ? EVENT | STEP : 0U);
    case INPUT: return INSTANTIATED | INITIALIZATION | EVENT | CONTINUOUS_TIME | STEP;
    case INDEPENDENT:
    case OUTPUT:
    case LOCAL:
    case MEMORY: break;
    }
    return 0;
}

static Status check_settable(Instance *instance, const char *call, const Variable *variable)
{
    unsigned modes = settable_modes(variable);
    if (instance->mode & modes) {
        return STATUS_OK;
    }
    if (!modes) {
        return report(&instance->log, STATUS_ERROR, "%s: %s is computed by the unit: it cannot be set", call,
                      variable->name);
    }
    char now[MODE_TEXT], allowed[MODE_TEXT];
    list_modes(instance->mode, now);
    list_modes(modes, allowed);
    return report(&instance->log, STATUS_ERROR, "%s: %s cannot be set in %s; allowed in: %s", call, variable->name, now,
                  allowed);
}

static Status check_value(Instance *instance, const Variable *variable, uint32_t element, double value)
{
    if (value >= variable->minimum && value <= variable->maximum && isfinite(value)) {
        return STATUS_OK;
    }
    char name[96], range[96] = "any finite value";
    bool low = isfinite(variable->minimum), high = isfinite(variable->maximum);
    if (low && high) {
        snprintf(range, sizeof range, "%.10g to %.10g", variable->minimum, variable->maximum);
    } else if (low) {
        snprintf(range, sizeof range, "at least %.10g", variable->minimum);
    } else if (high) {
        snprintf(range, sizeof range, "at most %.10g", variable->maximum);
    }
    return report(&instance->log, STATUS_ERROR, "%s = %.10g %s; allowed range: %s",
                  element_name(variable, element, name, sizeof name), value, variable->unit, range);
}

static Status check_state_count(Instance *instance, const char *what, size_t count, const double *values)
{
    if (count != unit.state_count) {
        return report(&instance->log, STATUS_ERROR, "%s: an array of %zu was given; the unit has %zu continuous states", what,
                      count, unit.state_count);
    }
    return count && !values ? report(&instance->log, STATUS_ERROR, "%s: the array is NULL", what) : STATUS_OK;
}

static Status instance_get_states(Instance *instance, double *states, size_t count, bool derivatives)
{
    Status status = check_state_count(instance, derivatives ? "derivatives" : "continuous states", count, states);
    size_t next = 0;
    for (size_t i = 0; status == STATUS_OK && i < unit.state_variables; i++) {
        const Variable *variable = &unit.variables[unit.states[i] + (derivatives ? 1 : 0)];
        status = instance_ready_to_read(instance, "reading states", variable);
        memcpy(states + next, instance->values + variable->offset, variable->count * sizeof(double));
        next += variable->count;
    }
    return status;
}

static Status instance_set_states(Instance *instance, const double *states, size_t count)
{
    Status status = check_state_count(instance, "continuous states", count, states);
    const double *next = states;
    for (size_t i = 0; status == STATUS_OK && i < unit.state_variables; i++) {
        const Variable *variable = &unit.variables[unit.states[i]];
        for (uint32_t k = 0; status == STATUS_OK && k < variable->count; k++) {
            status = check_value(instance, variable, k, next[k]);
        }
        if (status == STATUS_OK) {
            memcpy(instance->values + variable->offset, next, variable->count * sizeof(double));
            next += variable->count;
        }
    }
    instance_touch(instance);
    return status;
}

static Status instance_get_nominals(Instance *instance, double *nominals, size_t count)
{
    Status status = check_state_count(instance, "nominals", count, nominals);
    size_t next = 0;
    for (size_t i = 0; status == STATUS_OK && i < unit.state_variables; i++) {
        const Variable *variable = &unit.variables[unit.states[i]];
        for (uint32_t k = 0; k < variable->count; k++) {
            nominals[next++] = variable->nominal;
        }
    }
    return status;
}
