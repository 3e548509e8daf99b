/* From instantiation to the end: modes, initialization, and when what is computed again. */
#include "instance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct {
    Mode mode;
    const char *name;
} mode_names[] = {
    {INSTANTIATED, "Instantiated"},
    {CONFIGURATION, "Configuration Mode"},
    {INITIALIZATION, "Initialization Mode"},
    {EVENT, "Event Mode"},
    {CONTINUOUS_TIME, "Continuous-Time Mode"},
    {STEP, "Step Mode"},
    {RECONFIGURATION, "Reconfiguration Mode"},
    {TERMINATED, "Terminated"},
    {FAILED, "Failed"},
};

enum { MODE_NAMES = sizeof mode_names / sizeof *mode_names };

static void list_modes(unsigned modes, char text[MODE_TEXT])
{
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < MODE_NAMES; i++) {
        if ((modes & mode_names[i].mode) && used < MODE_TEXT) {
            int n = snprintf(text + used, MODE_TEXT - used, "%s%s", used ? ", " : "", mode_names[i].name);
            used += n > 0 ? (size_t)n : 0;
        }
    }
}

static Status refuse_mode(Instance *instance, const char *call, unsigned modes)
{
    char now[MODE_TEXT], allowed[MODE_TEXT];
    list_modes(instance->mode, now);
    list_modes(modes, allowed);
    return report(&instance->log, STATUS_ERROR, "%s is not allowed in %s; allowed in: %s", call, now, allowed);
}

static Status instance_allows(Instance *instance, const char *call, unsigned modes)
{
    return instance->mode & modes ? STATUS_OK : refuse_mode(instance, call, modes);
}

static Status instance_change_mode(Instance *instance, const char *call, unsigned from, Mode to)
{
    Status status = instance_allows(instance, call, from);
    if (status == STATUS_OK) {
        instance->mode = to;
    }
    return status;
}

static Status instance_refuse(Instance *instance, const char *call, const char *reason)
{
    return report(&instance->log, STATUS_ERROR, "%s: %s", call, reason);
}

static double instance_time(const Instance *instance)
{
    double time;
    memcpy(&time, instance->values, sizeof time);
    return time;
}

static void instance_set_time(Instance *instance, double time)
{
    memcpy(instance->values, &time, sizeof time);
}

static Status instance_move_time(Instance *instance, double time)
{
    if (!isfinite(time)) {
        return report(&instance->log, STATUS_ERROR, "time = %g s is not finite", time);
    }
    instance_set_time(instance, time);
    instance->stale = UINT32_MAX;
    return STATUS_OK;
}

/* Bytes of the struct and of the arrays behind it. */
static size_t values_size(const char *values)
{
    return unit.array ? unit.array(values, unit.variable_count) : unit.size;
}

/* Room for so many bytes of values; what is there stays. */
static Status instance_fit_values(Instance *instance, size_t size)
{
    if (size > instance->values_room) {
        char *values = realloc(instance->values, size);
        if (!values) {
            return report(&instance->log, STATUS_ERROR, "out of memory: %zu bytes", size);
        }
        instance->values = values;
        instance->values_room = size;
    }
    return STATUS_OK;
}

/* The arrays behind the struct at their start values, for which there is room. */
static void instance_clear_arrays(Instance *instance)
{
    memset(instance->values + unit.size, 0, values_size(instance->values) - unit.size);
}

/* Everything computed is out of date. */
static void instance_touch(Instance *instance)
{
    instance->stale = UINT32_MAX;
    instance->unchecked = true;
}

static Status instance_to_start(Instance *instance)
{
    memcpy(instance->values, unit.start, unit.size);
    instance->mode = INSTANTIATED;
    instance->start_time = 0.0;
    instance->stop_time = INFINITY;
    instance->unprepared = true;
    instance_touch(instance);
    Status status = unit.start_from ? unit.start_from(instance->values, instance->resources, &instance->log) : STATUS_OK;
    if (status == STATUS_OK) {
        status = instance_fit_values(instance, values_size(instance->values));
    }
    if (status == STATUS_OK) {
        instance_clear_arrays(instance);
    }
    return status;
}

/* A token is the unit's own, followed by "+" and a name where the FMU needs a file of that name among its resources.
 * Returns the name, "" where there is none, or NULL for another unit's token. */
static const char *needed_resource(const char *token)
{
    size_t size = strlen(unit.token);
    if (!token || strncmp(token, unit.token, size) != 0) {
        return NULL;
    }
    return !token[size] ? "" : token[size] == '+' && unit.start_from ? token + size + 1 : NULL;
}

static Instance *instance_create(Kind kind, const char *name, const char *token, const char *resources, Log log)
{
    const char *needed = needed_resource(token);
    if (!needed) {
        report(&log, STATUS_ERROR, "%s: the instantiation token %s is not this unit's %s", unit.name,
               token ? token : "(none)", unit.token);
        return NULL;
    }
    if (!name || !*name) {
        report(&log, STATUS_ERROR, "%s: the instance has no name", unit.name);
        return NULL;
    }
    Instance *instance = calloc(1, sizeof *instance);
    if (!instance) {
        report(&log, STATUS_ERROR, "%s: out of memory", unit.name);
        return NULL;
    }
    instance->log = log;
    instance->kind = kind;
    instance->values = calloc(1, unit.size);
    instance->values_room = unit.size;
    instance->resources = resource_folder(resources);
    instance->by_reference = calloc(3 * unit.reference_count, sizeof(double));
    instance->log.instance_name = calloc(1, strlen(name) + 1);
    if (!instance->values || !instance->by_reference || !instance->resources || !instance->log.instance_name) {
        report(&log, STATUS_ERROR, "%s: out of memory", unit.name);
        instance_free(instance);
        return NULL;
    }
    memcpy(instance->log.instance_name, name, strlen(name) + 1);
    if (*needed && !resource_is_there(instance->resources, needed)) {
        report(&instance->log, STATUS_ERROR,
               "%s: this FMU needs %s among its resources, which is not in the folder '%s' that the importer gave; allowed: "
               "the FMU's folder resources", unit.name, needed, instance->resources);
        instance_free(instance);
        return NULL;
    }
    if (instance_to_start(instance) != STATUS_OK) {
        instance_free(instance);
        return NULL;
    }
    return instance;
}

static void instance_free(Instance *instance)
{
    if (instance) {
        free(instance->workspace);
        free(instance->values);
        free(instance->by_reference);
        free(instance->resources);
        free(instance->binary);
        free(instance->log.instance_name);
        free(instance);
    }
}

static Status instance_reset(Instance *instance)
{
    return instance_to_start(instance);
}

static Status instance_set_logging(Instance *instance, bool on, size_t count, const char *const categories[])
{
    static const struct {
        const char *name;
        unsigned bits;
    } known[] = {
        {"logStatusError", LOG_ERRORS},
        {"logStatusWarning", LOG_WARNINGS},
        {"logEvents", LOG_EVENTS},
        {"logAll", LOG_ALL},
    };
    unsigned chosen = 0;
    for (size_t i = 0; i < count; i++) {
        unsigned bits = 0;
        for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
            if (categories && categories[i] && strcmp(categories[i], known[k].name) == 0) {
                bits = known[k].bits;
            }
        }
        if (!bits) {
            return report(&instance->log, STATUS_ERROR,
                          "log category %s is unknown; known: logStatusError, logStatusWarning, logEvents, logAll",
                          categories && categories[i] ? categories[i] : "(null)");
        }
        chosen |= bits;
    }
    /* errors and warnings are said in any case: to be silent about them helps nobody */
    instance->log.categories = LOG_ERRORS | LOG_WARNINGS | (on ? (count ? chosen : LOG_ALL) : 0U);
    return STATUS_OK;
}

static Status instance_set_experiment(Instance *instance, bool stop_defined, double start_time, double stop_time)
{
    if (!isfinite(start_time)) {
        return report(&instance->log, STATUS_ERROR, "startTime = %g s is not finite", start_time);
    }
    if (stop_defined && (isnan(stop_time) || stop_time < start_time)) {
        return report(&instance->log, STATUS_ERROR, "stopTime = %g s; allowed range: at least startTime = %g s",
                      stop_time, start_time);
    }
    instance->start_time = start_time;
    instance->stop_time = stop_defined ? stop_time : INFINITY;
    instance->last_time = start_time;
    instance_set_time(instance, start_time);
    instance_touch(instance);
    return STATUS_OK;
}

/* Norms of quaternions, then what the unit itself asks. */
static Status check_values(Instance *instance)
{
    for (size_t i = 0; i < unit.variable_count; i++) {
        const Variable *variable = &unit.variables[i];
        if (!variable->quaternion || variable->causality == LOCAL || (variable->state && instance->mode & INITIALIZATION)) {
            continue;
        }
        double q[4];
        memcpy(q, instance->values + variable->offset, sizeof q);
        double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        if (!(length >= 0.5 && length <= 2.0)) {
            return report(&instance->log, STATUS_ERROR,
                          "%s has norm %g; allowed range: 0.5 to 2, since it stands for a unit quaternion", variable->name,
                          length);
        }
    }
    return unit.check(instance->values, &instance->log);
}

/* Room for all Binary variables, which readers are lent. */
static Status reserve_binary(Instance *instance)
{
    size_t size = 0;
    for (size_t i = 0; instance->reads_binary && i < unit.variable_count; i++) {
        size += unit.variables[i].type == BINARY ? element_count(instance, &unit.variables[i]) : 0;
    }
    if (size != instance->binary_size) {
        free(instance->binary);
        instance->binary_size = 0;
        instance->binary = malloc(size);
        if (!instance->binary) {
            return report(&instance->log, STATUS_ERROR, "out of memory: %zu bytes", size);
        }
        instance->binary_size = size;
    }
    return STATUS_OK;
}

/* Memory that follows from the parameters; made when they have changed, never in a step. */
static Status instance_prepare(Instance *instance)
{
    if (!unit.workspace_size || !instance->unprepared) {
        return STATUS_OK;
    }
    size_t size = unit.workspace_size(instance->values);
    if (size != instance->workspace_size) {
        free(instance->workspace);
        instance->workspace_size = 0;
        instance->workspace = malloc(size);
        if (!instance->workspace) {
            return report(&instance->log, STATUS_ERROR, "out of memory: %zu bytes", size);
        }
        instance->workspace_size = size;
    }
    Status status = reserve_binary(instance);
    if (status == STATUS_OK) {
        status = unit.prepare(instance->values, instance->resources, instance->workspace, &instance->log);
    }
    instance->unprepared = status != STATUS_OK;
    return status;
}

static Status check_and_evaluate(Instance *instance, uint32_t groups)
{
    if (instance->unchecked) {
        Status status = check_values(instance);
        if (status == STATUS_OK) {
            status = instance_prepare(instance);
        }
        if (status != STATUS_OK) {
            return status;
        }
        if (instance->mode == INITIALIZATION) {
            unit.initialize(instance->values);
        }
        instance->unchecked = false;
    }
    uint32_t due = groups & instance->stale;
    for (size_t group = 0; due && group < unit.group_count; group++) {
        if (due & (1U << group)) {
            unit.evaluate[group](instance->values, instance->workspace);
        }
    }
    instance->stale &= ~groups;
    return STATUS_OK;
}

/* Brings the given groups up to date. */
static Status instance_refresh(Instance *instance, uint32_t groups)
{
    return instance->unchecked || (groups & instance->stale) ? check_and_evaluate(instance, groups) : STATUS_OK;
}

static Status instance_exit_initialization(Instance *instance, const char *call)
{
    Status status = instance_allows(instance, call, INITIALIZATION);
    if (status == STATUS_OK) {
        status = instance_refresh(instance, 0);
    }
    if (status == STATUS_OK) {
        bool events_first = instance->kind == MODEL_EXCHANGE || instance->event_mode_used;
        instance->mode = events_first ? EVENT : STEP;
    }
    return status;
}
