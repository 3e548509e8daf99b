/* The unit's step with the solver exact by itself, without the FMI around it, and the attitude in closed form by
 * itself, without the rest of the step: the same sources, the same flags. */
#define _POSIX_C_SOURCE 199309L
#include <time.h>

#include "fmu.c"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Where results go, so that no call is left out. */
volatile double sink;

/* A free body; `states` are inertia, orientation and momentum, 10 numbers. */
static RigidBody free_body(const double *states)
{
    RigidBody body = start_values;
    body.solver = RIGID_BODY_SOLVER_EXACT;
    body.gravity = vector(0.0, 0.0, 0.0);
    body.inertia = vector(states[0], states[1], states[2]);
    body.orientation = quaternion(states[3], states[4], states[5], states[6]);
    body.angular_momentum = vector(states[7], states[8], states[9]);
    return body;
}

/* Seconds for `count` steps of the unit's own function. */
double time_bare(const double *states, double step, long count)
{
    RigidBody body = free_body(states);
    Log silent = {0};
    Status (*volatile advance)(RigidBody *, double, Log *) = rigid_body_step; /* a call, not inlined */
    double start = now();
    for (long k = 0; k < count; k++) {
        body.time = (double)k * step;
        advance(&body, step, &silent);
    }
    double taken = now() - start;
    sink = body.orientation.w;
    return taken;
}

/* Seconds for the attitude alone at `count` times a step apart. */
double time_attitude(const double *states, double step, long count)
{
    RigidBody body = free_body(states);
    FreeMotion motion = free_motion_setup(body.inertia, body.orientation, body.angular_momentum);
    Quaternion (*volatile attitude)(const FreeMotion *, double) = free_motion_attitude;
    double start = now();
    for (long k = 0; k < count; k++) {
        body.orientation = attitude(&motion, (double)k * step);
    }
    double taken = now() - start;
    sink = body.orientation.w;
    return taken;
}
