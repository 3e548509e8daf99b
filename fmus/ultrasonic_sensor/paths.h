/* UltrasonicSensor: the paths of the sound and what is left of it.
 *
 *   time      c t = |S - T| + |R - S|        T transmitter, S mirror point, R receiver, each where
 *                                            it is when the sound is there
 *   amplitude spreading, two-way piston directivity, reflection, absorption
 */
#ifndef ULTRASONIC_SENSOR_PATHS_H
#define ULTRASONIC_SENSOR_PATHS_H

#include "vector.h"

#define PI 3.14159265358979323846
#define DECIBEL_PER_NEPER 8.685889638065036553 /* 20 / ln 10 */
#define PISTON_RADIUS 6.57e-3                  /* m; 55 degrees wide at -6 dB each way, 40 kHz: -12 dB there and back */

/* Transmitter and receiver at the emission; the receiver moves on. */
typedef struct Transceiver {
    Vector transmitter, receiver;
    Vector axis;          /* unit, where the transmitter looks */
    Vector receiver_axis; /* unit, where the receiver looks: elsewhere where it is an image */
    Vector velocity;      /* of the receiver */
    Vector transmitter_velocity;
} Transceiver;

/* Transmitter, target, receiver. */
typedef struct Path {
    Vector point;               /* of the target, where the sound meets it */
    Vector normal;              /* unit, out of the target at that point */
    Vector incident, reflected; /* unit, directions of travel */
    real first, second;         /* lengths of the two legs */
    real time;                  /* from emission to reception */
    real share;                 /* weight of the receiver in the point that the normal aims at */
    real bounce_time;           /* from emission to the bounce */
} Path;

typedef struct Ball {
    Vector center; /* at the emission */
    Vector velocity;
    real radius;
} Ball;

/* Curvature of a target at the mirror point: the trace and the determinant of its shape operator,
 * and its value along the incident direction laid into the surface. */
typedef struct Curvature {
    real trace, determinant, along;
} Curvature;

/* How long sound needs to reach a point at `offset` that moves with `velocity`, slower than sound:
 * |offset + velocity t| = c t. */
static inline real arrival_time(Vector offset, Vector velocity, real speed)
{
    real approach = dot(offset, velocity);
    real margin = speed * speed - dot(velocity, velocity);
    return (1.0 / margin) * (approach + sqrt(approach * approach + margin * dot(offset, offset)));
}

/* The mirror path by a plane at rest: straight from the image of the transmitter. `normal` is a
 * unit vector. */
static inline Path plane_path(const Transceiver *pair, Vector plane_point, Vector normal, real speed)
{
    real height = dot(normal, subtract(pair->transmitter, plane_point));
    Vector image = add_scaled(pair->transmitter, -2.0 * height, normal);
    Vector offset = subtract(pair->receiver, image);
    Path path;
    path.time = arrival_time(offset, pair->velocity, speed);
    Vector way = add_scaled(offset, path.time, pair->velocity);
    real climb = dot(way, normal), length = speed * path.time;
    path.share = height / climb;
    path.reflected = scale(1.0 / length, way);
    path.incident = add_scaled(path.reflected, -2.0 * climb / length, normal);
    path.normal = normal;
    path.first = path.share * length;
    path.second = length - path.first;
    path.point = add_scaled(pair->transmitter, path.first, path.incident);
    path.bounce_time = path.share * path.time;
    return path;
}

/* Transmitter and receiver about the centre of a ball at rest: with o from there to the middle of the two and l half
 * the line between them, o o, o l, l l. About the axis of a cylinder, of what of them is across it. */
typedef struct Sight {
    real offset, product, half;
    real radius;
} Sight;

/* Where the normal of a round mirror aims: at o + place l, -1 the transmitter, 1 the receiver. */
typedef struct Aim {
    real place;
    real reach;  /* |o + place l| */
    real change; /* of the place that Newton's method takes next, 0 at the mirror point */
} Aim;

/* Alhazen's problem. The two are as high above the plane that touches at the mirror point as the parts into which the
 * normal divides their line are long, 1 + place and 1 - place:
 *     o l (1 + place^2) + place (o o + l l - radius reach) = 0 */
static inline Aim aim_at(Sight sight, real place)
{
    Aim aim;
    real turned = sight.product + place * sight.half;
    aim.place = place;
    aim.reach = sqrt(sight.offset + place * (sight.product + turned));
    real whole = sight.offset + sight.half - sight.radius * aim.reach;
    real excess = sight.product * (1.0 + place * place) + place * whole;
    real slope = (2.0 * place * sight.product + whole) * aim.reach - sight.radius * place * turned; /* times reach */
    aim.change = -excess * aim.reach / slope;
    return aim;
}

/* Newton's step from 0, with Heron's root of o o from a rough `length`. */
static inline real first_aim(Sight sight, real length)
{
    return -2.0 * length * sight.product
        / (2.0 * length * (sight.offset + sight.half) - sight.radius * (sight.offset + length * length));
}

/* The point between transmitter and receiver that the normal at the mirror point aims at. */
static inline Vector path_aim(const Transceiver *pair, Path path)
{
    Vector receiver = add_scaled(pair->receiver, path.time, pair->velocity);
    return add(scale(1.0 - path.share, pair->transmitter), scale(path.share, receiver));
}

/* One refinement of the path by a ball that moves with u. Fermat: the time is stationary where
 *     n  ~  d2 / (c - d2 u)  -  d1 / (c - d1 u)          d1 incident, d2 reflected,
 * the law of reflection at a moving mirror. With the legs r1 and r2 this says that n aims at the
 * mean of transmitter and receiver, weighed with 1 / (r (c - d u)). An error e in that mean leaves
 * an error of order e^2 in the time. */
static inline Path ball_path_refined(const Transceiver *pair, Path path, Ball ball, real speed)
{
    Vector outward = subtract(path_aim(pair, path), add_scaled(ball.center, path.bounce_time, ball.velocity));
    real reach = norm(outward);
    Path next;
    next.normal = scale(1.0 / reach, outward);

    Vector surface = add_scaled(ball.center, ball.radius, next.normal);
    Vector leg = subtract(surface, pair->transmitter);
    next.bounce_time = arrival_time(leg, ball.velocity, speed);
    next.point = add_scaled(surface, next.bounce_time, ball.velocity);
    next.first = speed * next.bounce_time;
    next.incident = scale(1.0 / next.first, add_scaled(leg, next.bounce_time, ball.velocity));

    Vector back = subtract(add_scaled(pair->receiver, next.bounce_time, pair->velocity), next.point);
    real return_time = arrival_time(back, pair->velocity, speed);
    next.time = next.bounce_time + return_time;
    next.second = speed * return_time;
    next.reflected = scale(1.0 / next.second, add_scaled(back, return_time, pair->velocity));

    real first = next.first * (speed - dot(next.incident, ball.velocity));
    real second = next.second * (speed - dot(next.reflected, ball.velocity));
    real fixed_point = first / (first + second);
    /* Newton's step needs the slope of that fixed point; of a target at rest, which is near enough */
    Vector pair_line = subtract(pair->receiver, pair->transmitter);
    Vector turn = add_scaled(pair_line, -dot(pair_line, next.normal), next.normal);
    Vector shift = scale(ball.radius / reach, turn); /* of the mirror point */
    Vector stretch = add(scale(next.second, next.incident), scale(next.first, next.reflected));
    real whole = next.first + next.second;
    real slope = dot(stretch, shift) / (whole * whole);
    next.share = path.share + (fixed_point - path.share) / (1.0 - slope);
    return next;
}

/* By how many parts an echo comes faster than the burst left, Doppler: from the two legs,
 *     dt_emission / dt_reception = (c - d1.u) / (c - d1.v1) (c - d2.v2) / (c - d2.u)
 * with u of the target, v1 of the transmitter, v2 of the receiver. */
static inline real doppler_of(const Transceiver *pair, Path path, Vector velocity, real speed)
{
    real met = (speed - dot(path.incident, velocity)) * (speed - dot(path.reflected, pair->velocity));
    real sent = (speed - dot(path.incident, pair->transmitter_velocity)) * (speed - dot(path.reflected, velocity));
    return (met - sent) / sent;
}

static inline Curvature sphere_curvature(Path path, real radius)
{
    real cosine = dot(path.reflected, path.normal), bend = 1.0 / radius;
    Curvature round = {2.0 * bend, bend * bend, bend * (1.0 - cosine * cosine)};
    return round;
}

/* `axis` is the unit vector along the cylinder. */
static inline Curvature cylinder_curvature(Path path, Vector axis, real radius)
{
    real cosine = dot(path.reflected, path.normal), bend = 1.0 / radius;
    real lengthwise = dot(path.incident, axis);
    Curvature round = {bend, 0.0, bend * (1.0 - cosine * cosine - lengthwise * lengthwise)};
    return round;
}

/* The square of the way that would spread the sound as much by a plane: det((r1 + r2) 1 + r1 r2 M), M the
 * curvature that the mirror adds to the wavefront; Deschamps, Proc. IEEE 60 (1972) 1022. */
static inline real spreading_square(Path path, Curvature mirror)
{
    real cosine = dot(path.reflected, path.normal);
    real whole = path.first + path.second;
    real product = path.first * path.second;
    real trace = 2.0 * (mirror.trace * cosine + mirror.along / cosine);
    return whole * whole + whole * product * trace + 4.0 * product * product * mirror.determinant;
}

/* By what four terms of the piston's series multiply, from the one in (x/2)^2k on. */
static inline double four_terms(int k)
{
    const double a = k + 1.0, b = k + 2.0, c = k + 3.0, d = k + 4.0;
    return 1.0 / (a * b * b * c * c * d * d * (d + 1.0));
}

/* 2 J1(x) / x, amplitude of a piston in a baffle, from (x/2)^2 by its power series, in four chains that a processor
 * follows side by side. 20 terms leave less than 1e-14 for x up to 8; the largest x, at 60 kHz, -20 C and 90
 * degrees, is 7.8. */
static inline real piston_directivity(real half_argument_squared)
{
    const real h = half_argument_squared, square = h * h, fourth = square * square;
    real chain[4] = {1.0, 1.0, 1.0, 1.0};
    for (int k = 12; k >= 0; k -= 4) {
        for (int i = 0; i < 4; i++) {
            chain[i] = 1.0 + fourth * four_terms(k + i) * chain[i];
        }
    }
    return chain[0] - (1.0 / 2.0) * h * chain[1] + square * ((1.0 / 12.0) * chain[2] - (1.0 / 144.0) * h * chain[3]);
}

/* (x / 2)^2 of the piston for a way along `direction`. */
static inline real beam_argument(Vector direction, Vector axis, real wave_number)
{
    real half = 0.5 * wave_number * PISTON_RADIUS;
    real ahead = dot(direction, axis);
    return half * half * (1.0 - ahead * ahead);
}

/* By how many parts the beam falls where the frequency rises by one: x J2(x) / J1(x), by its continued
 * fraction 4 h / (4 - 4 h / (6 - ...)) from within; seven parts leave less than 1e-5 up to the first zero
 * of the beam. */
static inline real piston_dispersion(real half_argument_squared)
{
    real square = 4.0 * half_argument_squared;
    real above = 16.0, below = 1.0;
    for (int k = 7; k > 1; k--) {
        real next = 2.0 * k * above - square * below;
        below = above;
        above = next;
    }
    return square * below / above;
}

/* What a way through the air leaves of an amplitude; `absorption` in dB/m. */
static inline real left_by_air(real length, real absorption)
{
    return exp((-1.0 / DECIBEL_PER_NEPER) * absorption * length);
}

/* In air without loss, relative to a plane that faces the sensor at 1 m, below 0 where the beams turn the phase over.
 * `spread` is the way that would spread the sound as much by a plane, `reflection` the share of the amplitude that the
 * target gives back. */
static inline real lossless_amplitude(const Transceiver *pair, Path path, real spread, real reflection,
                                      real wave_number)
{
    real there = piston_directivity(beam_argument(path.incident, pair->axis, wave_number));
    real back = piston_directivity(beam_argument(path.reflected, pair->receiver_axis, wave_number));
    return there * back * reflection * (2.0 / spread);
}

/* The same in air that takes its share. */
static inline real path_amplitude(const Transceiver *pair, Path path, real spread, real reflection, real wave_number,
                                  real absorption)
{
    real air = left_by_air(path.first + path.second, absorption);
    return air * lossless_amplitude(pair, path, spread, reflection, wave_number);
}

/* That of a plane that faces the sensor, without the beam. */
static inline real facing_amplitude(real length, real absorption)
{
    return 2.0 / length * left_by_air(length, absorption);
}

#endif
