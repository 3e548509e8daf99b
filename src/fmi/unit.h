/* The contract of a unit: what a folder in fmus/ gives, and what src/fmi/ does with it.
 *
 * A unit is a plain struct of values, generated from its unit.toml, and a few functions on it.
 * Everything that the FMI standard asks besides (life cycle, access, limits, logging, saved
 * states, model exchange, events) is done once, in this folder, from the table of variables.
 *
 * The generator joins the functions below to the `Unit` at the end by their names, for a unit
 * RigidBody in fmus/rigid_body:
 *
 *   equations.h (on `real`; no branch, no state of its own)
 *     void rigid_body_initialize(RigidBody *)       start of states from the parameters
 *     void rigid_body_GROUP(RigidBody *)            computes the variables of one group; the
 *                                                   groups `derivatives` and `outputs` are the
 *                                                   usual ones
 *   unit.c (on double)
 *     Status rigid_body_check(const RigidBody *, Log *)        what limits alone cannot say; runs
 *                                                   before initialization ends, each step and the
 *                                                   first read after a change
 *     Status rigid_body_step(RigidBody *, double step, Log *)  from `time` to `time + step`; the
 *                                                   caller moves `time`
 *   where unit.toml says `events = true`
 *     double sensor_next_event(const Sensor *)      time of the next event, INFINITY for none
 *     void sensor_event(Sensor *)                   handles the event that is due, so that the next one is
 *                                                   another; `time` may miss its time by a rounding
 *   where there are clocks, they are fields that are true while the clock is active, until all events of
 *   that time are handled; of a countdown clock
 *     double sensor_clock_time(const Sensor *, size_t clock)  when it ticks, INFINITY where that is not known
 *   where unit.toml names a `workspace`: memory that follows from the parameters alone, and is
 *   therefore no part of a saved state; groups and streams then take it as a second argument
 *     size_t skin_workspace_size(const Skin *)
 *     Status skin_prepare(const Skin *, const char *resources, void *workspace, Log *)
 *   where unit.toml says `resources = true`: start values that a file among the resources gives, at
 *   instantiation and reset; `resources` is a folder that ends in a separator, or "" if there is none
 *     Status skin_start(Skin *, const char *resources, Log *)
 *   where an input has a structural parameter among its dimensions, it lies behind the struct, in the
 *   same block; variables.h then has
 *     static const float *skin_NAME(const Skin *)   its elements; zero, until they are set
 *   where a variable is a `stream`: computed straight into the reader's memory
 *     void skin_stream(const Skin *, const void *workspace, size_t variable, void *destination)
 */
#ifndef ULNA_UNIT_H
#define ULNA_UNIT_H

#include "variable.h"

/* The numbers are those of fmi2Status and fmi3Status. */
typedef enum Status { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR, STATUS_FATAL } Status;

/* Where a unit says what is wrong. */
typedef struct Log Log;

/* Sends one line to the importer's logger and returns `status`. */
static Status report(Log *log, Status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

typedef struct Unit {
    const char *name;               /* model identifier */
    const char *token;              /* instantiation token; "+" and a file's name may follow: see life_cycle.c */
    const Variable *variables;
    size_t variable_count;
    const uint16_t *variable_of;    /* value reference -> index of its variable */
    size_t reference_count;
    const uint16_t *states;         /* indices of the variables that are continuous states */
    size_t state_variables;
    size_t state_count;             /* continuous states, scalars */
    size_t size;                    /* bytes of the struct, without the arrays behind it */
    const void *start;              /* the struct at its start values */
    size_t group_count;
    void (*const *evaluate)(void *values, const void *workspace);
    void (*initialize)(void *values);
    Status (*check)(const void *values, Log *log);
    Status (*step)(void *values, double step, Log *log);
    double (*state_sum)(const void *values); /* of all states: finite only where each of them is */
    double (*next_event)(const void *values);
    void (*event)(void *values);
    void (*deactivate_clocks)(void *values);
    double (*clock_time)(const void *values, size_t clock);
    size_t (*array)(const void *values, size_t variable); /* where it lies; of variable_count, where all end */
    size_t (*workspace_size)(const void *values);
    Status (*prepare)(const void *values, const char *resources, void *workspace, Log *log);
    Status (*start_from)(void *values, const char *resources, Log *log);
    void (*stream)(const void *values, const void *workspace, size_t variable, void *destination);
    void (*directional)(const double *values, const void *workspace, bool initializing, uint32_t groups,
                        const double *seed, double *sensitivity); /* all by value reference */
} Unit;

#endif
