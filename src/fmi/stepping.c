/* Time in co-simulation: a step, the events inside it, and when it ends early. */
#include "instance.h"

#include <math.h>
#include <string.h>

/* Times closer than this are one: far below any step, far above the round-off of a sum of steps. */
static double same_time(double time)
{
    return 1e-12 * (1.0 + fabs(time));
}

static double next_event(const Instance *instance)
{
    return unit.next_event ? unit.next_event(instance->values) : INFINITY;
}

static bool event_is_due(const Instance *instance, double by)
{
    return unit.next_event && unit.next_event(instance->values) <= by;
}

/* Handles all events that are due; each moves the unit's next event onwards. */
static void handle_events(Instance *instance)
{
    double now = instance_time(instance);
    while (event_is_due(instance, now + same_time(now))) {
        report_event(&instance->log, "event at %.9g s", now);
        unit.event(instance->values);
        instance->stale = UINT32_MAX;
    }
    if (unit.deactivate_clocks) {
        unit.deactivate_clocks(instance->values);
    }
}

/* A step that would never end, for all one can wait. */
enum { MOST_EVENTS = 10000000 };

static Status check_step(Instance *instance, double point, double size)
{
    double now = instance_time(instance);
    /* importers add up steps: some thousand roundings are no mistake, a thousandth of a step is */
    double tolerance = 1e-9 * (1.0 + fabs(now));
    if (!isfinite(size) || !(size > 0.0)) {
        return report(&instance->log, STATUS_ERROR, "communicationStepSize = %g s; allowed range: greater than 0, finite", size);
    }
    if (!isfinite(point) || fabs(point - now) > tolerance) {
        return report(&instance->log, STATUS_ERROR, "currentCommunicationPoint = %.17g s, but the unit is at %.17g s", point,
                      now);
    }
    if (point + size > instance->stop_time + tolerance) {
        return report(&instance->log, STATUS_ERROR, "the step from %g s by %g s ends after stopTime = %g s", point, size,
                      instance->stop_time);
    }
    return STATUS_OK;
}

/* Says which state is no finite number, if one is none: their sum may overflow where they do not. */
static Status name_infinite_state(Instance *instance, double size)
{
    for (size_t i = 0; i < unit.state_variables; i++) {
        const Variable *variable = &unit.variables[unit.states[i]];
        const double *elements = (const double *)(const void *)(instance->values + variable->offset);
        for (uint32_t k = 0; k < variable->count; k++) {
            if (!isfinite(elements[k])) {
                char name[96];
                instance->mode = FAILED;
                return report(&instance->log, STATUS_ERROR,
                              "%s is not finite at %g s, after a step of %g s: the step is too long for the solver or the "
                              "inputs are too large",
                              element_name(variable, k, name, sizeof name), instance_time(instance), size);
            }
        }
    }
    return STATUS_OK;
}

/* A step too long for its solver ends in infinities: better said where it happens. */
static Status check_states_finite(Instance *instance, double size)
{
    bool finite = !unit.state_sum || isfinite(unit.state_sum(instance->values));
    return finite ? STATUS_OK : name_infinite_state(instance, size);
}

static Status advance(Instance *instance, double to)
{
    double size = to - instance_time(instance);
    Status status = STATUS_OK;
    if (size > 0.0) {
        status = unit.step(instance->values, size, &instance->log);
        instance->stale = UINT32_MAX;
    }
    instance_set_time(instance, to);
    if (status > STATUS_WARNING) {
        instance->mode = FAILED;
        return status;
    }
    Status finite = check_states_finite(instance, size);
    return finite == STATUS_OK ? status : finite;
}

static Status instance_step(Instance *instance, double point, double size, StepResult *result)
{
    double end = point + size;
    Status status = check_step(instance, point, size);
    if (status == STATUS_OK) {
        status = instance_refresh(instance, 0);
    }
    if (status != STATUS_OK) {
        result->last_time = instance_time(instance);
        return status;
    }
    bool stop_at_events = instance->event_mode_used && instance->early_return_allowed;
    int events = 0;
    instance_set_time(instance, point);
    handle_events(instance);
    double event = next_event(instance);
    while (unit.next_event && status <= STATUS_WARNING && event < end - same_time(end)) {
        status = advance(instance, event);
        if (stop_at_events) {
            result->event_needed = true;
            result->early_return = true;
            result->last_time = instance->last_time = event;
            return status;
        }
        handle_events(instance);
        event = next_event(instance);
        if (++events == MOST_EVENTS) {
            instance->mode = FAILED;
            return report(&instance->log, STATUS_ERROR, "communicationStepSize = %g s has more than %d events", size,
                          MOST_EVENTS);
        }
    }
    if (status <= STATUS_WARNING) {
        status = advance(instance, end);
    }
    result->event_needed = instance->event_mode_used && event <= end + same_time(end);
    result->last_time = instance->last_time = instance_time(instance);
    return status;
}

static Status instance_update_discrete_states(Instance *instance, EventInfo *info)
{
    Status status = instance_refresh(instance, 0);
    if (status == STATUS_OK) {
        handle_events(instance);
        info->next_event_time = next_event(instance);
        info->next_event_defined = isfinite(info->next_event_time);
    }
    return status;
}
