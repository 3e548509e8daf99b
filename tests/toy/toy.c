/* A small unit whose every answer is exact in binary: x' = gain u, y = mode u. It is written against
 * the bare standard, so that the master is tested on a unit that Ulna's own code did not make. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { GAIN, MODE, U, X, Y, FLAG, NOT_FLAG, COUNT, NEXT_COUNT, SIZE, RAMP, LARGEST = 8 };

typedef struct Toy {
    double gain, u[3], x[3];
    int32_t count;
    int64_t mode;
    uint64_t size;
    bool flag;
    void *environment, *logger;
} Toy;

static void toy_start(Toy *toy)
{
    void *environment = toy->environment, *logger = toy->logger;
    *toy = (Toy){.gain = 1.0, .mode = 1, .size = 2, .environment = environment, .logger = logger};
}

static bool toy_step(Toy *toy, double step)
{
    for (int i = 0; i < 3; i++) {
        if (!isfinite(toy->u[i])) return false;
        toy->x[i] += step * toy->gain * toy->u[i];
    }
    return true;
}

#if FMI_VERSION == 2
#include "fmi2Functions.h"
#define THE(c) Toy *toy = c
typedef fmi2Status Status;
#define NAME(suffix) fmi2##suffix
#define INSTANCE fmi2Component

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type kind, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    Toy *toy = calloc(1, sizeof *toy);
    toy->environment = functions->componentEnvironment;
    toy->logger = (void *)functions->logger;
    toy_start(toy);
    return toy;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d, fmi2Boolean e, fmi2Real f)
{
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean final)
{
    THE(c);
    if (toy_step(toy, step)) return fmi2OK;
    ((fmi2CallbackLogger)toy->logger)(toy->environment, "toy", fmi2Error, "logStatusError", "u is %s at %d of %g s",
                                      "not finite", 100, time);
    return fmi2Error;
}

fmi2Status fmi2GetReal(fmi2Component c, const unsigned *r, size_t n, double *v)
{
    THE(c);
    for (size_t i = 0; i < n; i++)
        v[i] = r[i] == GAIN ? toy->gain : r[i] < 20 ? toy->u[r[i] - 10] : r[i] < 30 ? toy->x[r[i] - 20]
             : (double)toy->mode * toy->u[r[i] - 30];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const unsigned *r, size_t n, const double *v)
{
    THE(c);
    for (size_t i = 0; i < n; i++)
        if (r[i] == GAIN) toy->gain = v[i];
        else toy->u[r[i] - 10] = v[i];
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const unsigned *r, size_t n, int *v)
{
    THE(c);
    for (size_t i = 0; i < n; i++) v[i] = r[i] == MODE ? (int)toy->mode : toy->count + (r[i] == NEXT_COUNT);
    return fmi2OK;
}

fmi2Status fmi2SetInteger(fmi2Component c, const unsigned *r, size_t n, const int *v)
{
    THE(c);
    for (size_t i = 0; i < n; i++)
        if (r[i] == MODE) toy->mode = v[i];
        else toy->count = v[i];
    return fmi2OK;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const unsigned *r, size_t n, int *v)
{
    THE(c);
    for (size_t i = 0; i < n; i++) v[i] = toy->flag != (r[i] == NOT_FLAG);
    return fmi2OK;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const unsigned *r, size_t n, const int *v)
{
    THE(c);
    if (n) toy->flag = v[0];
    return fmi2OK;
}
#define GetState fmi2GetFMUstate
#define SetState fmi2SetFMUstate
#define FreeState fmi2FreeFMUstate
#define StateSize fmi2SerializedFMUstateSize
#define Serialize fmi2SerializeFMUstate
#define Deserialize fmi2DeSerializeFMUstate
#else
#include "fmi3Functions.h"
#define THE(c) Toy *toy = c
typedef fmi3Status Status;
#define NAME(suffix) fmi3##suffix
#define INSTANCE fmi3Instance

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference *references, size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update)
{
    Toy *toy = calloc(1, sizeof *toy);
    toy->environment = environment;
    toy->logger = (void *)logger;
    toy_start(toy);
    return toy;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, double b, double d, fmi3Boolean e, double f)
{
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, double time, double step, fmi3Boolean final, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, double *last)
{
    THE(c);
    *event = *early = false;
    *terminate = toy->x[0] >= 1000.0;
    *last = time + step;
    if (toy_step(toy, step)) return fmi3OK;
    ((fmi3LogMessageCallback)toy->logger)(toy->environment, fmi3Error, "logStatusError", "u is not finite");
    return fmi3Error;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const unsigned *r, size_t n, double *v, size_t count)
{
    THE(c);
    for (size_t i = 0; i < n; i++) {
        size_t length = r[i] == GAIN ? 1 : r[i] == RAMP ? toy->size : 3;
        for (size_t k = 0; k < length; k++)
            *v++ = r[i] == GAIN ? toy->gain : r[i] == U ? toy->u[k] : r[i] == X ? toy->x[k]
                 : r[i] == RAMP ? (double)k : (double)toy->mode * toy->u[k];
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const unsigned *r, size_t n, const double *v, size_t count)
{
    THE(c);
    for (size_t i = 0; i < n; i++) {
        if (r[i] == GAIN) toy->gain = *v++;
        else for (int k = 0; k < 3; k++) toy->u[k] = *v++;
    }
    return fmi3OK;
}

fmi3Status fmi3GetInt32(fmi3Instance c, const unsigned *r, size_t n, int32_t *v, size_t count)
{
    for (size_t i = 0; i < n; i++) v[i] = ((Toy *)c)->count + (r[i] == NEXT_COUNT);
    return fmi3OK;
}

fmi3Status fmi3SetInt32(fmi3Instance c, const unsigned *r, size_t n, const int32_t *v, size_t count)
{
    if (n) ((Toy *)c)->count = v[0];
    return fmi3OK;
}

fmi3Status fmi3GetInt64(fmi3Instance c, const unsigned *r, size_t n, int64_t *v, size_t count)
{
    if (n) v[0] = ((Toy *)c)->mode;
    return fmi3OK;
}

fmi3Status fmi3SetInt64(fmi3Instance c, const unsigned *r, size_t n, const int64_t *v, size_t count)
{
    if (n) ((Toy *)c)->mode = v[0];
    return fmi3OK;
}

fmi3Status fmi3GetUInt64(fmi3Instance c, const unsigned *r, size_t n, uint64_t *v, size_t count)
{
    if (n) v[0] = ((Toy *)c)->size;
    return fmi3OK;
}

fmi3Status fmi3SetUInt64(fmi3Instance c, const unsigned *r, size_t n, const uint64_t *v, size_t count)
{
    if (!n || v[0] > LARGEST) return fmi3Error;
    ((Toy *)c)->size = v[0];
    return fmi3OK;
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const unsigned *r, size_t n, bool *v, size_t count)
{
    for (size_t i = 0; i < n; i++) v[i] = ((Toy *)c)->flag != (r[i] == NOT_FLAG);
    return fmi3OK;
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const unsigned *r, size_t n, const bool *v, size_t count)
{
    if (n) ((Toy *)c)->flag = v[0];
    return fmi3OK;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return fmi3OK; }
#define GetState fmi3GetFMUState
#define SetState fmi3SetFMUState
#define FreeState fmi3FreeFMUState
#define StateSize fmi3SerializedFMUStateSize
#define Serialize fmi3SerializeFMUState
#define Deserialize fmi3DeserializeFMUState
#endif

void NAME(FreeInstance)(INSTANCE c) { free(c); }
Status NAME(ExitInitializationMode)(INSTANCE c) { return 0; }
Status NAME(Terminate)(INSTANCE c) { return 0; }

#if FMI_VERSION == 2
Status NAME(EnterInitializationMode)(INSTANCE c) { return 0; }
#endif

Status NAME(Reset)(INSTANCE c)
{
    toy_start(c);
    return 0;
}

Status GetState(INSTANCE c, void **state)
{
    if (*state == NULL) *state = malloc(sizeof(Toy));
    memcpy(*state, c, sizeof(Toy));
    return 0;
}

Status SetState(INSTANCE c, void *state)
{
    memcpy(c, state, offsetof(Toy, environment));
    return 0;
}

Status FreeState(INSTANCE c, void **state)
{
    free(*state);
    *state = NULL;
    return 0;
}

Status StateSize(INSTANCE c, void *state, size_t *size)
{
    *size = offsetof(Toy, environment);
    return 0;
}

Status Serialize(INSTANCE c, void *state, NAME(Byte) *bytes, size_t size)
{
    memcpy(bytes, state, size);
    return 0;
}

Status Deserialize(INSTANCE c, const NAME(Byte) *bytes, size_t size, void **state)
{
    *state = calloc(1, sizeof(Toy));
    memcpy(*state, bytes, size);
    return 0;
}
