/* The unit under test through its FMI functions: one face for both versions of the standard. */
#ifndef ULNA_TEST_SLAVE_H
#define ULNA_TEST_SLAVE_H

#include "subject.h"

enum { OK = 0, ERROR = 3 }; /* fmi2Status, fmi3Status */
enum { MAX_ELEMENTS = 64, MAX_STATES = 64 };

typedef enum Kind { CO_SIMULATION = 1, CO_SIMULATION_WITH_EVENT_MODE = 2, MODEL_EXCHANGE = 4, ANY_KIND = 7 } Kind;

/* The kinds that the unit and the version have, as bits. */
unsigned slave_kinds(void);

typedef struct LogRecord {
    size_t lines;
    int status;
    char category[64];
    char text[1024]; /* the last line */
} LogRecord;

typedef struct Slave {
    void *instance; /* NULL when it could not be made */
    Kind kind;
    LogRecord log;
} Slave;

void record_line(LogRecord *log, int status, const char *category, const char *text);

/* An instance, not yet initialized; a Slave must not move while it is open. */
void slave_open(Slave *slave, Kind kind);
void slave_open_as(Slave *slave, Kind kind, const char *name, const char *token);
void slave_close(Slave *slave);
int slave_enter_initialization(Slave *slave, double start, const double *stop);
int slave_exit_initialization(Slave *slave);

/* From where initialization ends to where time goes on. */
int slave_enter_continuous_time(Slave *slave);

/* An error where the version has no such mode. */
int slave_enter_configuration(Slave *slave);
int slave_exit_configuration(Slave *slave);
int slave_terminate(Slave *slave);
int slave_reset(Slave *slave);

/* Initialized and ready to run: in Step Mode, or in Continuous-Time Mode. */
void slave_start(Slave *slave);

/* Whether the version shows it: FMI 2 no stream, no clock, and no array that a structural parameter sizes. */
bool slave_has(const Variable *variable);

/* All elements of a variable that is no stream, as doubles. */
int slave_get(Slave *slave, const Variable *variable, double *values);
int slave_set(Slave *slave, const Variable *variable, const double *values);

/* The bytes of a stream; how many were written: none in FMI 2. */
size_t slave_get_stream(Slave *slave, const Variable *variable, void *bytes, size_t size);

/* With event mode: through all early returns, each event handled in Event Mode. */
int slave_step(Slave *slave, double point, double size);
int slave_set_time(Slave *slave, double time);
int slave_get_states(Slave *slave, double *states, size_t count);
int slave_set_states(Slave *slave, const double *states, size_t count);
int slave_get_derivatives(Slave *slave, double *derivatives, size_t count);
int slave_complete_step(Slave *slave);

int slave_save(Slave *slave, void **state);
int slave_restore(Slave *slave, void *state);
int slave_release(Slave *slave, void **state);
int slave_serialized_size(Slave *slave, void *state, size_t *size);
int slave_serialize(Slave *slave, void *state, char *bytes, size_t size);
int slave_deserialize(Slave *slave, const char *bytes, size_t size, void **state);

/* The sum of derivatives of an unknown by all elements of a known. */
int slave_directional(Slave *slave, const Variable *unknown, const Variable *known, double *result);

/* A call of the standard, with where it is allowed and where it is refused; neither: not looked at. */
typedef struct Call {
    const char *name;
    int (*make)(Slave *slave);
    unsigned kinds;
    unsigned allowed, refused; /* modes, as bits */
} Call;

typedef enum Mode {
    INSTANTIATED = 1,
    CONFIGURATION = 2,
    INITIALIZATION = 4,
    EVENT = 8,
    CONTINUOUS_TIME = 16,
    STEP = 32,
    TERMINATED = 64,
    ANY_MODE = 127
} Mode;

extern const Call calls[];
extern const size_t call_count;

/* Brings a new instance there; false where the version or the kind has no such mode. */
bool slave_reach(Slave *slave, Mode mode);

/* Wrong arguments that only one version knows: arrays of wrong size, NULL arguments. */
void check_version_arguments(void);

#endif
