/* UltrasonicSensor: which echo comes first, on each step of the ladder of fidelity. */
#include "equations.h"

#include <math.h>

#define REFINEMENTS 5 /* of a mirror point; README.md says how exact this is */
#define PI 3.14159265358979323846

typedef struct Echo {
    double time; /* from emission to reception, INFINITY for none */
    double level;
} Echo;

static const Echo silence = {INFINITY, NO_ECHO_LEVEL};

/* A capsule with its axis from start to end, or a sphere where they are equal; absent without a
 * radius. */
typedef struct Target {
    Vector start, end, velocity;
    double radius;
} Target;

enum { TARGETS = 3 };

/* What a ping meets, as it is at the emission. */
typedef struct Surroundings {
    Transceiver pair;
    Vector middle; /* of the pair */
    bool plane; /* present, with the sensor on its visible side */
    Vector plane_point, plane_normal;
    Target target[TARGETS];
} Surroundings;

static Surroundings surroundings_at(const UltrasonicSensor *sensor, double emission)
{
    Surroundings around;
    Vector half = rotate(sensor->orientation, vector(0.0, 0.5 * sensor->baseline, 0.0));
    Vector middle = add_scaled(sensor->position, emission - sensor->position_time, sensor->velocity);
    Vector sphere = add_scaled(sensor->sphere_center, emission - sensor->sphere_center_time,
                               sensor->sphere_velocity);
    Vector rest = vector(0.0, 0.0, 0.0);
    around.middle = middle;
    around.pair.transmitter = add(middle, half);
    around.pair.receiver = subtract(middle, half);
    around.pair.axis = rotate(sensor->orientation, vector(1.0, 0.0, 0.0));
    around.pair.velocity = sensor->velocity;
    around.plane = dot(subtract(middle, sensor->plane_point), sensor->plane_normal) > 0.0;
    around.plane_point = sensor->plane_point;
    around.plane_normal = around.plane ? scale(1.0 / norm(sensor->plane_normal), sensor->plane_normal) : rest;
    around.target[0] = (Target){sphere, sphere, sensor->sphere_velocity, sensor->sphere_radius};
    around.target[1] = (Target){sensor->capsule_1_start, sensor->capsule_1_end, rest, sensor->capsule_1_radius};
    around.target[2] = (Target){sensor->capsule_2_start, sensor->capsule_2_end, rest, sensor->capsule_2_radius};
    return around;
}

/* From start to end, as a share of the whole, the point of the axis nearest to `aim`. */
static double nearest_share(const Target *target, Vector aim)
{
    Vector whole = subtract(target->end, target->start);
    double square = dot(whole, whole);
    double share = square > 0.0 ? dot(subtract(aim, target->start), whole) / square : 0.0;
    return fmin(fmax(share, 0.0), 1.0);
}

/* Between the caps. */
static bool on_wall(double share)
{
    return share > 0.0 && share < 1.0;
}

static Vector axis_point(const Target *target, double share)
{
    return add_scaled(target->start, share, subtract(target->end, target->start));
}

/* The loudness of a path, or silence where the sensor cannot hear it. */
static Echo echo_of_path(const UltrasonicSensor *sensor, const Transceiver *pair, Path path, Curvature mirror)
{
    bool in_front = dot(path.incident, pair->axis) > 0.0 && dot(path.reflected, pair->axis) < 0.0;
    bool outside = dot(path.incident, path.normal) < 0.0 && dot(path.reflected, path.normal) > 0.0;
    if (!in_front || !outside) {
        return silence;
    }
    double wave_number = 2.0 * PI * sensor->frequency / sensor->speed_of_sound;
    Echo echo = {path.time, path_level(pair, path, mirror, wave_number, sensor->absorption)};
    return echo.level >= sensor->threshold ? echo : silence;
}

static Echo specular_plane(const UltrasonicSensor *sensor, const Surroundings *around)
{
    const Transceiver *pair = &around->pair;
    Path path = plane_path(pair, around->plane_point, around->plane_normal, sensor->speed_of_sound);
    return echo_of_path(sensor, pair, path, plane_curvature());
}

/* On the axis of the capsule the centre of the touching ball is nearest to where the normal aims. */
static Echo specular_target(const UltrasonicSensor *sensor, const Surroundings *around, const Target *target)
{
    const Transceiver *pair = &around->pair;
    Vector whole = subtract(target->end, target->start);
    Vector slide = vector(0.0, 0.0, 0.0);
    if (dot(whole, whole) > 0.0) {
        slide = scale(dot(subtract(pair->receiver, pair->transmitter), whole) / dot(whole, whole), whole);
    }
    double share = nearest_share(target, around->middle);
    Ball ball = {axis_point(target, share), target->velocity, slide, target->radius};
    Path path = ball_path_guess(pair, ball, sensor->speed_of_sound);
    for (int i = 0; i < REFINEMENTS; i++) {
        share = nearest_share(target, path_aim(pair, path));
        ball.center = axis_point(target, share);
        path = ball_path_refined(pair, path, ball, sensor->speed_of_sound);
    }
    /* a solid plane hides what lies behind it */
    if (around->plane && dot(subtract(path.point, around->plane_point), around->plane_normal) < 0.0) {
        return silence;
    }
    Curvature mirror = sphere_curvature(path, target->radius);
    if (on_wall(share)) {
        mirror = cylinder_curvature(path, scale(1.0 / norm(whole), whole), target->radius);
    }
    return echo_of_path(sensor, pair, path, mirror);
}

/* Where along the ray the ball begins, INFINITY if the ray does not meet it from outside. */
static double ray_to_ball(Vector origin, Vector direction, Vector center, double radius)
{
    Vector offset = subtract(origin, center);
    double along = dot(offset, direction);
    double inside = dot(offset, offset) - radius * radius;
    double square = along * along - inside;
    return along < 0.0 && inside > 0.0 && square >= 0.0 ? -along - sqrt(square) : INFINITY;
}

/* The same for the wall of the capsule, between its caps: the problem in the cross-section. */
static double ray_to_wall(Vector origin, Vector direction, const Target *target)
{
    Vector whole = subtract(target->end, target->start);
    double square = dot(whole, whole);
    if (!(square > 0.0)) {
        return INFINITY;
    }
    Vector offset = subtract(origin, target->start);
    Vector flat_offset = add_scaled(offset, -dot(offset, whole) / square, whole);
    Vector flat = add_scaled(direction, -dot(direction, whole) / square, whole);
    double sine = norm(flat);
    if (!(sine > 0.0)) {
        return INFINITY;
    }
    double distance = ray_to_ball(flat_offset, scale(1.0 / sine, flat), vector(0.0, 0.0, 0.0), target->radius) / sine;
    double share = dot(add_scaled(offset, distance, direction), whole) / square;
    return share >= 0.0 && share <= 1.0 ? distance : INFINITY;
}

static double ray_to_target(Vector origin, Vector direction, const Target *target)
{
    Vector nearest = axis_point(target, nearest_share(target, origin));
    if (norm(subtract(origin, nearest)) <= target->radius) {
        return INFINITY; /* blind from within */
    }
    double start = ray_to_ball(origin, direction, target->start, target->radius);
    double end = ray_to_ball(origin, direction, target->end, target->radius);
    return fmin(ray_to_wall(origin, direction, target), fmin(start, end));
}

static double ray_to_plane(Vector origin, Vector direction, Vector point, Vector normal)
{
    double descent = -dot(normal, direction);
    return descent > 0.0 ? dot(normal, subtract(origin, point)) / descent : INFINITY;
}

/* What a ray hits at some distance is reported as a plane that faces the sensor there. */
static Echo echo_of_ray(const UltrasonicSensor *sensor, double distance)
{
    if (!isfinite(distance)) {
        return silence;
    }
    double time = time_of_distance(distance, sensor->speed_of_sound, sensor->baseline);
    return (Echo){time, facing_level(sensor->speed_of_sound * time, sensor->absorption)};
}

static Echo ray_plane(const UltrasonicSensor *sensor, const Surroundings *around)
{
    return echo_of_ray(sensor, ray_to_plane(around->middle, around->pair.axis, around->plane_point,
                                            around->plane_normal));
}

static Echo ray_target(const UltrasonicSensor *sensor, const Surroundings *around, const Target *target)
{
    return echo_of_ray(sensor, ray_to_target(around->middle, around->pair.axis, target));
}

/* One rung of the ladder: the echo of the plane and that of any other target. */
typedef struct Rung {
    Echo (*plane)(const UltrasonicSensor *sensor, const Surroundings *around);
    Echo (*target)(const UltrasonicSensor *sensor, const Surroundings *around, const Target *target);
} Rung;

static Rung ultrasonic_sensor_rung(int64_t fidelity)
{
    switch ((UltrasonicSensorFidelityKind)fidelity) {
    case ULTRASONIC_SENSOR_FIDELITY_RAY: return (Rung){ray_plane, ray_target};
    case ULTRASONIC_SENSOR_FIDELITY_SPECULAR: break;
    }
    return (Rung){specular_plane, specular_target};
}

/* The earlier of two echoes; one from the blind zone or after the time-out does not count. A plane
 * between transmitter and receiver gives c t < b, which is in the blind zone. */
static Echo earlier(const UltrasonicSensor *sensor, Echo best, Echo other)
{
    double nearest = time_of_distance(sensor->minimum_range, sensor->speed_of_sound, sensor->baseline);
    double farthest = time_of_distance(sensor->maximum_range, sensor->speed_of_sound, sensor->baseline);
    bool counts = other.time >= nearest && other.time <= farthest;
    return counts && other.time < best.time ? other : best;
}

static Echo first_echo(const UltrasonicSensor *sensor, double emission)
{
    Rung rung = ultrasonic_sensor_rung(sensor->fidelity);
    Surroundings around = surroundings_at(sensor, emission);
    Echo first = around.plane ? earlier(sensor, silence, rung.plane(sensor, &around)) : silence;
    for (int i = 0; i < TARGETS; i++) {
        if (around.target[i].radius > 0.0) {
            first = earlier(sensor, first, rung.target(sensor, &around, &around.target[i]));
        }
    }
    return first;
}
