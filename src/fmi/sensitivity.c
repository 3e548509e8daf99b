/* Directional and adjoint derivatives, exact to rounding: the unit's equations on complex numbers. */
#include "instance.h"

#include <string.h>

static bool differentiable(const Instance *instance, const Variable *variable, bool unknown)
{
    if (variable->type != FLOAT64 || !is_field(variable)) {
        return false;
    }
    if (unknown) {
        return variable->causality == OUTPUT || variable->causality == LOCAL;
    }
    /* what a workspace holds of the parameters is not differentiated */
    bool initial = instance->mode == INITIALIZATION && variable->causality == PARAMETER && !unit.workspace_size;
    bool tunable = variable->causality == PARAMETER && variable->variability == TUNABLE;
    return variable->causality == INPUT || variable->state || initial || tunable;
}

/* The elements that a list of references stands for, counted, and the groups that compute them. */
static Status check_references(Instance *instance, const char *call, References list, bool unknown, size_t expected,
                               uint32_t *groups)
{
    size_t total = 0;
    if (list.count && !list.list) {
        return instance_refuse(instance, call, "an array is NULL");
    }
    for (size_t i = 0; i < list.count; i++) {
        const Variable *variable = instance_find(instance, call, list.list[i], list.whole);
        if (!variable) {
            return STATUS_ERROR;
        }
        if (!differentiable(instance, variable, unknown)) {
            return report(&instance->log, STATUS_ERROR, "%s: %s cannot be %s of a derivative now", call, variable->name,
                          unknown ? "the unknown" : "the known");
        }
        if (variable->group < unit.group_count) {
            *groups |= 1U << variable->group;
        }
        total += list.whole ? variable->count : 1;
    }
    if (total != expected) {
        return report(&instance->log, STATUS_ERROR, "%s: the variables have %zu elements, the array given has %zu", call, total,
                      expected);
    }
    return STATUS_OK;
}

static uint32_t elements_of(References list, size_t i)
{
    return list.whole ? unit.variables[unit.variable_of[list.list[i]]].count : 1;
}

static void load_values(Instance *instance)
{
    double *values = instance->by_reference;
    for (size_t i = 0; i < unit.variable_count; i++) {
        const Variable *variable = &unit.variables[i];
        for (uint32_t k = 0; is_field(variable) && k < variable->count; k++) {
            values[variable->reference + k] = element_as_double(instance, variable, k);
        }
    }
}

static Status prepare_derivatives(Instance *instance, const char *call, References unknowns, size_t unknown_count,
                                  References knowns, size_t known_count, uint32_t *groups)
{
    *groups = 0;
    if (!unit.directional) {
        return instance_refuse(instance, call, "this unit has no continuous outputs to differentiate");
    }
    Status status = check_references(instance, call, unknowns, true, unknown_count, groups);
    if (status == STATUS_OK) {
        status = check_references(instance, call, knowns, false, known_count, groups);
    }
    if (status == STATUS_OK) {
        status = instance_refresh(instance, 0);
    }
    if (status == STATUS_OK) {
        load_values(instance);
    }
    return status;
}

static void differentiate(Instance *instance, uint32_t groups)
{
    double *values = instance->by_reference;
    unit.directional(values, instance->workspace, instance->mode == INITIALIZATION, groups, values + unit.reference_count,
                     values + 2 * unit.reference_count);
}

static Status instance_directional_derivative(Instance *instance, const char *call, References unknowns, References knowns,
                                              const double *seed, size_t seed_count, double *result, size_t result_count)
{
    uint32_t groups;
    Status status = prepare_derivatives(instance, call, unknowns, result_count, knowns, seed_count, &groups);
    if (status != STATUS_OK) {
        return status;
    }
    double *direction = instance->by_reference + unit.reference_count;
    const double *sensitivity = direction + unit.reference_count;
    memset(direction, 0, unit.reference_count * sizeof(double));
    for (size_t i = 0, next = 0; i < knowns.count; i++) {
        for (uint32_t k = 0; k < elements_of(knowns, i); k++) {
            direction[knowns.list[i] + k] = seed[next++];
        }
    }
    differentiate(instance, groups);
    for (size_t i = 0, next = 0; i < unknowns.count; i++) {
        for (uint32_t k = 0; k < elements_of(unknowns, i); k++) {
            result[next++] = sensitivity[unknowns.list[i] + k];
        }
    }
    return STATUS_OK;
}
