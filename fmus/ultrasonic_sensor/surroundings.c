/* UltrasonicSensor: what a ping meets, as it is at the emission. */
#include "equations.h"
#include "phasor.h"

typedef struct Echo {
    double time;      /* from the emission to its arrival, INFINITY for none */
    Phasor strength;  /* at its loudest, without Doppler, with the phase of its carrier at the arrival */
    double amplitude; /* its modulus; 1 is a level of 0 dB */
    double there, back; /* (x / 2)^2 of the beam on both ways */
    double doppler;   /* by how many parts it comes faster than the burst left */
    bool foreign;     /* of another sensor's burst */
} Echo;

static const Vector at_rest = {0.0, 0.0, 0.0};
static const Echo silence = {.time = INFINITY};

/* One at rest and on the axis of the beams. */
static Echo plain_echo(double time, double amplitude)
{
    return (Echo){.time = time, .strength = {amplitude, 0.0}, .amplitude = amplitude};
}

enum { MOST_ECHOES = 96, MOST_LATE = 8, LATE_NUMBERS = 6 }; /* those of one ping; those that outlive it */

typedef struct Echoes {
    Echo echo[MOST_ECHOES + 1]; /* the last only to be written at */
    int count;
} Echoes;

/* Where the next echo is written: copies would cost as much as its path. */
static Echo *next_echo(Echoes *echoes)
{
    return &echoes->echo[echoes->count];
}

/* Counts what was written there, if it is `heard`. */
static void keep_next(Echoes *echoes, bool heard)
{
    echoes->count += heard && echoes->count < MOST_ECHOES;
}

static void add_echo(Echoes *echoes, Echo echo)
{
    *next_echo(echoes) = echo;
    keep_next(echoes, true);
}

/* Unlike fmin and fmax, no calls: what is compared here is a number. */
static double lesser(double a, double b)
{
    return b < a ? b : a;
}

static double greater(double a, double b)
{
    return b > a ? b : a;
}

/* Newton's next place between low and high, of which what is known at a place moves one there; half way where that would
 * lead out. */
static double next_between(double *low, double *high, double place, double excess, double slope)
{
    *(excess < 0.0 ? low : high) = place;
    double next = slope > 0.0 ? place - excess / slope : *high;
    return next > *low && next < *high ? next : 0.5 * (*low + *high);
}

/* No less than the length, without a root. */
static double most_of(Vector a)
{
    return fabs(a.x) + fabs(a.y) + fabs(a.z);
}

/* A capsule with its axis from start to end, or a sphere where they are equal. */
typedef struct Target {
    Vector start, end, velocity;
    double radius, reflection;
} Target;

enum { MOST_TARGETS = 3, AXES = 3 };

typedef struct Box {
    Vector center, axis[AXES]; /* unit vectors */
    double half[AXES];
    double extent;
} Box;

typedef struct Surroundings {
    Transceiver pair;
    Vector middle; /* of the pair */
    bool plane;    /* present, with the sensor on its visible side */
    Vector plane_point, plane_normal;
    Target target[MOST_TARGETS];
    int targets; /* present */
    bool box_present;
    Box box;
} Surroundings;

static Box box_of(const UltrasonicSensor *sensor)
{
    Rotation turn = rotation(sensor->box_orientation);
    Vector half = scale(0.5, sensor->box_size);
    return (Box){sensor->box_center, {turn.x, turn.y, turn.z}, {half.x, half.y, half.z}, norm(half)};
}

/* Absent without a radius. */
static void add_target(Surroundings *around, Vector start, Vector end, Vector velocity, double radius, double reflection)
{
    if (radius > 0.0) {
        around->target[around->targets++] = (Target){start, end, velocity, radius, reflection};
    }
}

/* Filled in its place: a copy would cost as much as an empty ping. */
static void look_around(const UltrasonicSensor *sensor, double emission, Surroundings *around)
{
    Rotation turn = rotation(sensor->orientation);
    Vector half = scale(0.5 * sensor->baseline, turn.y);
    Vector middle = add_scaled(sensor->position, emission - sensor->position_time, sensor->velocity);
    Vector sphere = add_scaled(sensor->sphere_center, emission - sensor->sphere_center_time,
                               sensor->sphere_velocity);
    around->middle = middle;
    around->pair.transmitter = add(middle, half);
    around->pair.receiver = subtract(middle, half);
    around->pair.axis = turn.x;
    around->pair.receiver_axis = turn.x;
    around->pair.velocity = sensor->velocity;
    around->pair.transmitter_velocity = sensor->velocity;
    around->plane = dot(subtract(middle, sensor->plane_point), sensor->plane_normal) > 0.0;
    around->plane_point = sensor->plane_point;
    around->plane_normal = around->plane ? scale(1.0 / norm(sensor->plane_normal), sensor->plane_normal) : at_rest;
    around->targets = 0;
    add_target(around, sphere, sphere, sensor->sphere_velocity, sensor->sphere_radius, sensor->sphere_reflection);
    add_target(around, sensor->capsule_1_start, sensor->capsule_1_end, at_rest, sensor->capsule_1_radius,
               sensor->capsule_reflection);
    add_target(around, sensor->capsule_2_start, sensor->capsule_2_end, at_rest, sensor->capsule_2_radius,
               sensor->capsule_reflection);
    Vector size = sensor->box_size;
    around->box_present = size.x > 0.0 && size.y > 0.0 && size.z > 0.0;
    if (around->box_present) {
        around->box = box_of(sensor);
    }
}

/* A share of a target's axis, not beyond its ends. */
static double within_axis(double share)
{
    return lesser(greater(share, 0.0), 1.0);
}

/* From start to end, as a share of the whole, the point of the axis nearest to `aim`. */
static double nearest_share(const Target *target, Vector aim)
{
    Vector whole = subtract(target->end, target->start);
    double square = dot(whole, whole);
    return square > 0.0 ? within_axis(dot(subtract(aim, target->start), whole) / square) : 0.0;
}

static Vector axis_point(const Target *target, double share)
{
    return add_scaled(target->start, share, subtract(target->end, target->start));
}
