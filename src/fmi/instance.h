/* One instance of a unit, whatever the version of the standard: its life, its values, its log. */
#ifndef ULNA_INSTANCE_H
#define ULNA_INSTANCE_H

#include "unit.h"

typedef enum Kind { CO_SIMULATION = 1, MODEL_EXCHANGE = 2 } Kind;

/* The states of the standard's state machine, as bits, so that a call can allow several. */
typedef enum Mode {
    INSTANTIATED = 1,
    CONFIGURATION = 2,
    INITIALIZATION = 4,
    EVENT = 8,
    CONTINUOUS_TIME = 16,
    STEP = 32,
    RECONFIGURATION = 64,
    TERMINATED = 128,
    FAILED = 256 /* after a step that went wrong: reset it, restore a state, or free it */
} Mode;

enum { MODE_TEXT = 256 }; /* room for the names of all modes */

enum { LOG_ERRORS = 1, LOG_WARNINGS = 2, LOG_EVENTS = 4, LOG_ALL = 7 };

struct Log {
    void (*send)(const Log *log, Status status, const char *category, const char *message);
    void (*callback)(void); /* the importer's function, cast back to its type by `send` */
    void *environment;
    char *instance_name;
    unsigned categories;
};

typedef struct Instance {
    Log log;
    Kind kind;
    Mode mode;
    bool event_mode_used, early_return_allowed;
    bool unchecked;       /* something was set since the last check */
    bool unprepared;      /* a parameter was set since the workspace was made */
    uint32_t stale;       /* groups to be computed before the next read, as bits */
    double start_time, stop_time; /* stop_time is infinite when none is given */
    double last_time;     /* where the last step ended */
    size_t workspace_size;
    void *workspace;
    double *by_reference; /* three vectors of reference_count: values, seed, sensitivity */
    char *values;         /* the unit's struct, and behind it the arrays that structural parameters size */
    size_t values_room;   /* bytes */
    bool reads_binary;    /* FMI 3: room for Binary variables is made with the workspace */
    char *binary;         /* what the last read of them gave, the reader's until the next */
    size_t binary_size;
    char *resources;      /* a folder that ends in a separator, or "" */
} Instance;

typedef struct StepResult {
    double last_time;
    bool event_needed, early_return;
} StepResult;

typedef struct EventInfo {
    bool next_event_defined;
    double next_event_time;
} EventInfo;

/* life_cycle.c */
static Instance *instance_create(Kind kind, const char *name, const char *token, const char *resources, Log log);
static void instance_free(Instance *instance);
static Status instance_reset(Instance *instance);
static Status instance_set_logging(Instance *instance, bool on, size_t count, const char *const categories[]);
static void list_modes(unsigned modes, char text[MODE_TEXT]);
static Status instance_allows(Instance *instance, const char *call, unsigned modes);
static Status instance_change_mode(Instance *instance, const char *call, unsigned from, Mode to);
static Status instance_set_experiment(Instance *instance, bool stop_defined, double start_time, double stop_time);
static Status instance_exit_initialization(Instance *instance, const char *call);
static Status instance_refresh(Instance *instance, uint32_t groups);
static Status instance_prepare(Instance *instance);
static void instance_touch(Instance *instance);
static size_t values_size(const char *values);
static Status instance_fit_values(Instance *instance, size_t size);
static void instance_clear_arrays(Instance *instance);
static double instance_time(const Instance *instance);
static void instance_set_time(Instance *instance, double time);
static Status instance_move_time(Instance *instance, double time);
static Status instance_refuse(Instance *instance, const char *call, const char *reason);

/* resources.c */
static char *resource_folder(const char *location);
static bool resource_is_there(const char *folder, const char *name);

/* access.c */
static const Variable *instance_find(Instance *instance, const char *call, uint32_t reference, bool whole);
static Status instance_ready_to_read(Instance *instance, const char *call, const Variable *variable);
static Status instance_get_states(Instance *instance, double *states, size_t count, bool derivatives);
static Status instance_set_states(Instance *instance, const double *states, size_t count);
static Status instance_get_nominals(Instance *instance, double *nominals, size_t count);
static size_t element_count(const Instance *instance, const Variable *variable);
static double element_as_double(const Instance *instance, const Variable *variable, uint32_t element);
static const char *element_name(const Variable *variable, uint32_t element, char *text, size_t size);

/* state.c */
typedef struct SavedState SavedState;
static Status instance_save(Instance *instance, SavedState **saved);
static Status instance_restore(Instance *instance, const SavedState *saved);
static size_t instance_saved_size(const SavedState *saved);
static Status instance_serialize(Instance *instance, const SavedState *saved, void *bytes, size_t size);
static Status instance_deserialize(Instance *instance, const void *bytes, size_t size, SavedState **saved);

/* stepping.c */
static Status instance_step(Instance *instance, double point, double size, StepResult *result);
static Status instance_update_discrete_states(Instance *instance, EventInfo *info);

/* sensitivity.c */
typedef struct References {
    const uint32_t *list;
    size_t count;
    bool whole; /* a reference stands for all elements of its variable (FMI 3) */
} References;
static Status instance_directional_derivative(Instance *instance, const char *call, References unknowns, References knowns,
                                              const double *seed, size_t seed_count, double *result, size_t result_count);

#endif
