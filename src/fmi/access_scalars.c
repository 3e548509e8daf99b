/* Getting and setting single elements, for FMI 2, where a value reference stands for one. */
#include "instance.h"

#include <string.h>

static Status set_element(Instance *instance, const char *call, const Variable *variable, uint32_t element, double value)
{
    Status status = check_settable(instance, call, variable);
    if (status == STATUS_OK) {
        status = check_value(instance, variable, element, value);
    }
    if (status != STATUS_OK) {
        return status;
    }
    char *place = instance->values + variable->offset + element * element_size[variable->type];
    switch ((ValueType)variable->type) {
    case FLOAT64: memcpy(place, &value, sizeof value); break;
    case FLOAT32: memcpy(place, &(float){(float)value}, sizeof(float)); break;
    case INT32: memcpy(place, &(int32_t){(int32_t)value}, sizeof(int32_t)); break;
    case UINT64: memcpy(place, &(uint64_t){(uint64_t)value}, sizeof(uint64_t)); break;
    case ENUMERATION: memcpy(place, &(int64_t){(int64_t)value}, sizeof(int64_t)); break;
    case BOOLEAN: memcpy(place, &(bool){value > 0.5}, sizeof(bool)); break;
    case CLOCK:
    case BINARY:
    case VALUE_TYPES: break;
    }
    instance->unprepared |= variable->causality != INPUT;
    instance_touch(instance);
    return STATUS_OK;
}

/* The element that a value reference stands for, of the wanted type; NULL after saying why not. */
static const Variable *scalar(Instance *instance, const char *call, uint32_t reference, ValueType type,
                              uint32_t *element)
{
    const Variable *variable = instance_find(instance, call, reference, false);
    if (!variable) {
        return NULL;
    }
    bool integer = type == INT32 && (variable->type == ENUMERATION || variable->type == UINT64);
    if ((variable->type != type && !integer) || !is_field(variable)) {
        report(&instance->log, STATUS_ERROR, "%s: %s is of type %s", call, variable->name, type_names[variable->type]);
        return NULL;
    }
    *element = reference - variable->reference;
    return variable;
}

static Status get_scalar(Instance *instance, const char *call, uint32_t reference, ValueType type, double *value)
{
    uint32_t element;
    const Variable *variable = scalar(instance, call, reference, type, &element);
    if (!variable) {
        return STATUS_ERROR;
    }
    Status status = instance_ready_to_read(instance, call, variable);
    if (status == STATUS_OK) {
        *value = element_as_double(instance, variable, element);
    }
    return status;
}

static Status set_scalar(Instance *instance, const char *call, uint32_t reference, ValueType type, double value)
{
    uint32_t element;
    const Variable *variable = scalar(instance, call, reference, type, &element);
    return variable ? set_element(instance, call, variable, element, value) : STATUS_ERROR;
}
