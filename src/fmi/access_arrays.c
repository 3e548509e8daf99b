/* Getting and setting whole variables, for FMI 3: one loop over the table for every type. */
#include "instance.h"

#include <math.h>
#include <string.h>

/* The kind of access that all of a get or set shares, found wanting or not before the first value moves. */
static Status check_variable(Instance *instance, const char *call, const Variable *variable, ValueType type, size_t left)
{
    if (variable->type != type) {
        return report(&instance->log, STATUS_ERROR, "%s: %s is of type %s", call, variable->name, type_names[variable->type]);
    }
    size_t needed = element_count(instance, variable);
    if (needed > left) {
        return report(&instance->log, STATUS_ERROR, "%s: %s has %zu elements, but only %zu values are left in the array given",
                      call, variable->name, needed, left);
    }
    return STATUS_OK;
}

static Status left_over(Instance *instance, const char *call, size_t left)
{
    if (!left) {
        return STATUS_OK;
    }
    return report(&instance->log, STATUS_ERROR, "%s: the array given has %zu values more than the variables have elements",
                  call, left);
}

/* Where the elements of a variable lie that is no stream. */
static char *variable_place(const Instance *instance, const Variable *variable)
{
    size_t place = variable->offset;
    if (variable->size_of) {
        place = unit.array(instance->values, (size_t)(variable - unit.variables));
    }
    return instance->values + place;
}

static Status instance_get(Instance *instance, const char *call, ValueType type, const uint32_t references[], size_t count,
                           void *values, size_t value_count)
{
    char *destination = values;
    size_t left = value_count;
    Status status = check_arrays(instance, call, references, values, count);
    for (size_t i = 0; status == STATUS_OK && i < count; i++) {
        const Variable *variable = instance_find(instance, call, references[i], true);
        if (!variable) {
            return STATUS_ERROR;
        }
        status = check_variable(instance, call, variable, type, left);
        if (status == STATUS_OK) {
            status = instance_ready_to_read(instance, call, variable);
        }
        if (status == STATUS_OK) {
            size_t elements = element_count(instance, variable);
            size_t bytes = elements * element_size[type];
            if (variable->group == STREAM) {
                unit.stream(instance->values, instance->workspace, (size_t)(variable - unit.variables), destination);
            } else {
                memcpy(destination, variable_place(instance, variable), bytes);
            }
            destination += bytes;
            left -= elements;
        }
    }
    return status == STATUS_OK ? left_over(instance, call, left) : status;
}

/* The arrays that a structural parameter sizes get their room, and start anew where it changes. */
static Status set_structural(Instance *instance, const Variable *variable, const char *source)
{
    char before[sizeof(uint64_t)];
    char *place = instance->values + variable->offset;
    size_t size = element_size[variable->type];
    memcpy(before, place, size);
    memcpy(place, source, size);
    Status status = instance_fit_values(instance, values_size(instance->values));
    if (status != STATUS_OK) {
        memcpy(place, before, size);
    } else if (memcmp(before, source, size) != 0) {
        instance_clear_arrays(instance);
    }
    return status;
}

/* Whether all are finite: without a branch, since a mesh has many. */
static bool are_finite(const char *source, size_t elements)
{
    uint32_t infinite = 0;
    for (size_t k = 0; k < elements; k++) {
        uint32_t bits;
        memcpy(&bits, source + k * sizeof bits, sizeof bits);
        infinite |= (bits & 0x7F800000U) == 0x7F800000U;
    }
    return !infinite;
}

/* Names the first element that is not within the limits. */
static Status check_elements(Instance *instance, const Variable *variable, const char *source, size_t elements)
{
    bool unlimited = isinf(variable->minimum) && isinf(variable->maximum);
    if (variable->type == BOOLEAN || (variable->type == FLOAT32 && unlimited && are_finite(source, elements))) {
        return STATUS_OK;
    }
    Status status = STATUS_OK;
    for (uint32_t k = 0; status == STATUS_OK && k < elements; k++) {
        status = check_value(instance, variable, k, value_at(variable->type, source + k * element_size[variable->type]));
    }
    return status;
}

static Status set_elements(Instance *instance, const char *call, const Variable *variable, const char *source,
                           size_t elements)
{
    Status status = check_settable(instance, call, variable);
    if (status == STATUS_OK) {
        status = check_elements(instance, variable, source, elements);
    }
    if (status == STATUS_OK && variable->causality == STRUCTURAL_PARAMETER) {
        status = set_structural(instance, variable, source);
    }
    if (status == STATUS_OK) {
        char *place = variable_place(instance, variable);
        memcpy(place, source, elements * element_size[variable->type]);
        for (size_t k = 0; variable->type == BOOLEAN && k < elements; k++) {
            place[k] = place[k] != 0; /* any other byte is no bool */
        }
        instance->unprepared |= variable->causality != INPUT;
        instance_touch(instance);
    }
    return status;
}

static Status instance_set(Instance *instance, const char *call, ValueType type, const uint32_t references[], size_t count,
                           const void *values, size_t value_count)
{
    const char *source = values;
    size_t left = value_count;
    Status status = check_arrays(instance, call, references, values, count);
    for (size_t i = 0; status == STATUS_OK && i < count; i++) {
        const Variable *variable = instance_find(instance, call, references[i], true);
        if (!variable) {
            return STATUS_ERROR;
        }
        status = check_variable(instance, call, variable, type, left);
        if (status == STATUS_OK) {
            size_t elements = element_count(instance, variable);
            status = set_elements(instance, call, variable, source, elements);
            source += elements * element_size[type];
            left -= elements;
        }
    }
    return status == STATUS_OK ? left_over(instance, call, left) : status;
}

static Status instance_get_binary(Instance *instance, const char *call, const uint32_t references[], size_t count,
                                  size_t sizes[], const uint8_t *values[], size_t value_count)
{
    size_t total = 0;
    Status status = check_arrays(instance, call, references, values, count);
    if (status == STATUS_OK && count && (!sizes || value_count != count)) {
        return instance_refuse(instance, call, "the arrays given have another number of values than there are references");
    }
    for (size_t i = 0; status == STATUS_OK && i < count; i++) {
        const Variable *variable = instance_find(instance, call, references[i], true);
        if (!variable) {
            return STATUS_ERROR;
        }
        status = check_variable(instance, call, variable, BINARY, SIZE_MAX);
        if (status == STATUS_OK) {
            status = instance_ready_to_read(instance, call, variable);
            sizes[i] = element_count(instance, variable);
            total += sizes[i];
        }
    }
    if (status == STATUS_OK && total > instance->binary_size) {
        return instance_refuse(instance, call, "each variable can be read once in a call");
    }
    char *place = instance->binary;
    for (size_t i = 0; status == STATUS_OK && i < count; i++) {
        unit.stream(instance->values, instance->workspace, unit.variable_of[references[i]], place);
        values[i] = (const uint8_t *)place;
        place += sizes[i];
    }
    return status;
}

/* Refuses them all, since none is an input. */
static Status instance_set_binary(Instance *instance, const char *call, const uint32_t references[], size_t count,
                                  const void *values)
{
    Status status = check_arrays(instance, call, references, values, count);
    for (size_t i = 0; status == STATUS_OK && i < count; i++) {
        const Variable *variable = instance_find(instance, call, references[i], true);
        status = variable ? check_variable(instance, call, variable, BINARY, SIZE_MAX) : STATUS_ERROR;
        status = status == STATUS_OK ? check_settable(instance, call, variable) : status;
    }
    return status;
}
