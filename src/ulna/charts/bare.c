/* The closed form of the free body by itself, without the FMU around it: the same sources, the same flags. */
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

/* Seconds for `count` attitudes `step` apart, set up once; states are inertia, orientation and momentum, 10 numbers. */
double time_bare(const double *states, double step, long count)
{
    Vector inertia = {states[0], states[1], states[2]};
    Quaternion q = {states[3], states[4], states[5], states[6]};
    Vector momentum = {states[7], states[8], states[9]};
    FreeMotion motion = free_motion_setup(inertia, q, momentum);
    Quaternion (*volatile attitude)(const FreeMotion *, double) = free_motion_attitude; /* a call, not inlined */
    double start = now();
    for (long k = 1; k <= count; k++) {
        q = attitude(&motion, (double)k * step);
        sink = q.w + q.x + q.y + q.z;
    }
    return now() - start;
}
