/* Getting and setting whole variables, for FMI 3: one loop over the table for every type. */
#include "instance.h"

#include <string.h>

static size_t element_count(const Instance *instance, const Variable *variable)
{
    uint64_t extent = 1;
    if (variable->size_of) {
        memcpy(&extent, instance->values + variable->size_of, sizeof extent);
    }
    return variable->count * (size_t)extent;
}

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
                memcpy(destination, instance->values + variable->offset, bytes);
            }
            destination += bytes;
            left -= elements;
        }
    }
    return status == STATUS_OK ? left_over(instance, call, left) : status;
}

static Status set_elements(Instance *instance, const char *call, const Variable *variable, const char *source,
                           size_t elements)
{
    Status status = check_settable(instance, call, variable);
    size_t size = element_size[variable->type];
    char *place = instance->values + variable->offset;
    for (uint32_t k = 0; status == STATUS_OK && variable->type != BOOLEAN && k < elements; k++) {
        status = check_value(instance, variable, k, value_at(variable->type, source + k * size));
    }
    if (status == STATUS_OK) {
        memcpy(place, source, elements * size);
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
