/* A point mass that hangs on its anchor by a spring and a damper of its own, for FMI 3.0, written against the bare
 * standard. Within a step the anchor is where it was set, at rest there as far as its place goes: what many a
 * vendor's unit does. It so creates energy where it is coupled; what a master's watch must find. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

enum { SUB_STEPS = 16 };

typedef struct Sprung {
    double mass, stiffness, damping, gravity[3], initial_position[3], initial_velocity[3];
    double anchor_position[3], anchor_velocity[3], position[3], velocity[3];
    double anchor_force[3], kinetic_energy, potential_energy, dissipation, acceleration[3];
} Sprung;

/* By value reference: where, and how many. */
static const struct { size_t offset, count; } PLACES[] = {
    {offsetof(Sprung, mass), 1},
    {offsetof(Sprung, stiffness), 1},
    {offsetof(Sprung, damping), 1},
    {offsetof(Sprung, gravity), 3},
    {offsetof(Sprung, initial_position), 3},
    {offsetof(Sprung, initial_velocity), 3},
    {offsetof(Sprung, anchor_position), 3},
    {offsetof(Sprung, anchor_velocity), 3},
    {offsetof(Sprung, position), 3},
    {offsetof(Sprung, velocity), 3},
    {offsetof(Sprung, anchor_force), 3},
    {offsetof(Sprung, kinetic_energy), 1},
    {offsetof(Sprung, potential_energy), 1},
    {offsetof(Sprung, dissipation), 1},
    {offsetof(Sprung, velocity), 3},
    {offsetof(Sprung, acceleration), 3},
};

static double force(const Sprung *s, int i, double x, double v)
{
    return s->stiffness * (x - s->anchor_position[i]) + s->damping * (v - s->anchor_velocity[i]);
}

static double acceleration(const Sprung *s, int i, double x, double v)
{
    return s->gravity[i] - force(s, i, x, v) / s->mass;
}

static void evaluate(Sprung *s)
{
    s->kinetic_energy = s->potential_energy = s->dissipation = 0.0;
    for (int i = 0; i < 3; i++) {
        double stretch = s->position[i] - s->anchor_position[i], rate = s->velocity[i] - s->anchor_velocity[i];
        s->anchor_force[i] = force(s, i, s->position[i], s->velocity[i]);
        s->acceleration[i] = acceleration(s, i, s->position[i], s->velocity[i]);
        s->kinetic_energy += s->mass * s->velocity[i] * s->velocity[i] / 2;
        s->potential_energy += s->stiffness * stretch * stretch / 2 - s->mass * s->gravity[i] * s->position[i];
        s->dissipation += s->damping * rate * rate;
    }
}

static void advance(Sprung *s, double h)
{
    for (int i = 0; i < 3; i++) {
        double x = s->position[i], v = s->velocity[i];
        double a1 = acceleration(s, i, x, v);
        double v2 = v + h / 2 * a1, a2 = acceleration(s, i, x + h / 2 * v, v2);
        double v3 = v + h / 2 * a2, a3 = acceleration(s, i, x + h / 2 * v2, v3);
        double v4 = v + h * a3, a4 = acceleration(s, i, x + h * v3, v4);
        s->position[i] = x + h / 6 * (v + 2 * v2 + 2 * v3 + v4);
        s->velocity[i] = v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
}

static void start(Sprung *s)
{
    *s = (Sprung){.mass = 1.0, .stiffness = 1.0};
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference *references, size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback logger,
                                         fmi3IntermediateUpdateCallback update)
{
    Sprung *s = malloc(sizeof *s);
    if (s) start(s);
    return s;
}

void fmi3FreeInstance(fmi3Instance c) { free(c); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, double b, double d, fmi3Boolean e, double f)
{
    Sprung *s = c;
    memcpy(s->position, s->initial_position, sizeof s->position);
    memcpy(s->velocity, s->initial_velocity, sizeof s->velocity);
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return fmi3OK; }

fmi3Status fmi3Reset(fmi3Instance c)
{
    start(c);
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance c, double time, double step, fmi3Boolean final, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, double *last)
{
    for (int n = 0; n < SUB_STEPS; n++) advance(c, step / SUB_STEPS);
    *event = *terminate = *early = false;
    *last = time + step;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const unsigned *r, size_t n, double *v, size_t count)
{
    evaluate(c);
    for (size_t i = 0; i < n; v += PLACES[r[i++]].count)
        memcpy(v, (char *)c + PLACES[r[i]].offset, PLACES[r[i]].count * sizeof *v);
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const unsigned *r, size_t n, const double *v, size_t count)
{
    for (size_t i = 0; i < n; v += PLACES[r[i++]].count)
        memcpy((char *)c + PLACES[r[i]].offset, v, PLACES[r[i]].count * sizeof *v);
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance c, void **state)
{
    if (*state == NULL) *state = malloc(sizeof(Sprung));
    memcpy(*state, c, sizeof(Sprung));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, void *state)
{
    memcpy(c, state, sizeof(Sprung));
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, void **state)
{
    free(*state);
    *state = NULL;
    return fmi3OK;
}
