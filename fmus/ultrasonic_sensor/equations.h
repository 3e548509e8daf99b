/* UltrasonicSensor: the air, the device, and the distance that belongs to a time.
 *
 *   distance  d = sqrt((c t / 2)^2 - (b / 2)^2)    of a plane that faces the pair, b apart
 *
 * The class notes' x = v/t has the unit 1/s^2; the way is v t, and it is walked twice.
 */
#ifndef ULTRASONIC_SENSOR_EQUATIONS_H
#define ULTRASONIC_SENSOR_EQUATIONS_H

#include "vector.h"
#include "variables.h"

#include "paths.h"

#define STANDARD_PRESSURE 101325.0 /* Pa */
#define CARBON_DIOXIDE 400e-6      /* mole fraction */
#define NO_ECHO_LEVEL (-200.0)     /* dB; below every threshold */

/* Mole fraction of water vapour; Davis, Metrologia 29 (1992) 67, as Cramer uses it. */
static inline real vapour_fraction(real temperature, real humidity, real pressure)
{
    real celsius = temperature - 273.15;
    real saturation = exp((1.2378847e-5 * temperature - 1.9121316e-2) * temperature + 33.93711047
                          - 6.3431645e3 / temperature);
    real enhancement = 1.00062 + 3.14e-8 * pressure + 5.6e-7 * celsius * celsius;
    return humidity * enhancement * saturation / pressure;
}

/* Cramer, J. Acoust. Soc. Am. 93 (1993) 2510, equation 15 with table III; fitted for 0 to 30 C. */
static inline real speed_of_sound_in_air(real temperature, real humidity, real pressure)
{
    const real p = pressure, carbon = CARBON_DIOXIDE;
    real t = temperature - 273.15;
    real water = vapour_fraction(temperature, humidity, pressure);
    return 331.5024 + (0.603055 - 0.000528 * t) * t
        + (51.471935 + (0.1495874 - 0.000782 * t) * t) * water
        + (-1.82e-7 + (3.73e-8 - 2.93e-10 * t) * t) * p
        + (-85.20931 + (-0.228525 + 5.91e-5 * t) * t) * carbon
        - 2.835149 * water * water - 2.15e-13 * p * p + 29.179762 * carbon * carbon
        + 0.000486 * water * p * carbon;
}

/* Decibels per metre; ISO 9613-1:1993, equations 3 to 5, B.2 and B.3. */
static inline real absorption_of_air(real temperature, real humidity, real pressure, real frequency)
{
    real ratio = temperature / 293.15;
    real atmospheres = pressure / STANDARD_PRESSURE;
    real saturation = exp(log(10.0) * (4.6151 - 6.8346 * pow(273.16 / temperature, 1.261)));
    real h = 100.0 * humidity * saturation / atmospheres; /* molar concentration of water vapour, % */
    real oxygen = atmospheres * (24.0 + 4.04e4 * h * (0.02 + h) / (0.391 + h));
    real nitrogen = atmospheres * (9.0 + 280.0 * h * exp(-4.170 * (pow(ratio, -1.0 / 3.0) - 1.0))) / sqrt(ratio);
    real f2 = frequency * frequency;
    real relaxation = 0.01275 * exp(-2239.1 / temperature) / (oxygen + f2 / oxygen)
        + 0.1068 * exp(-3352.0 / temperature) / (nitrogen + f2 / nitrogen);
    return 8.686 * f2 * (1.84e-11 * sqrt(ratio) / atmospheres + pow(ratio, -2.5) * relaxation);
}

/* From the path's time to the distance of a plane facing the pair, and back. */
static inline real distance_of_time(real time, real speed, real baseline)
{
    return 0.5 * sqrt((speed * time) * (speed * time) - baseline * baseline);
}

static inline real time_of_distance(real distance, real speed, real baseline)
{
    return sqrt(4.0 * distance * distance + baseline * baseline) / speed;
}

/* The burst: transmitter and receiver are each a resonator whose response falls to a half, -6 dB,
 * `bandwidth` / 2 off its frequency; their envelopes answer with exp(-t / ring_time). */
static inline real ring_time_of(real bandwidth)
{
    real edge = PI * bandwidth;
    return sqrt(3.0 / (edge * edge));
}

/* When the envelope of a burst `length` ring times long is highest, in ring times. */
static inline real burst_peak_time(real length)
{
    return length / (1.0 - exp(-length));
}

/* How high it then is; 1 is what an endless burst reaches. */
static inline real burst_peak(real length)
{
    return (exp(length) - 1.0) * exp(-burst_peak_time(length));
}

/* How high it is when the burst ends. */
static inline real burst_height(real length)
{
    return 1.0 - (1.0 + length) * exp(-length);
}

/* Where a burst of this sensor comes from. */
static inline void ultrasonic_sensor_burst(UltrasonicSensor *sensor)
{
    Rotation turn = rotation(sensor->orientation);
    sensor->burst_position = add_scaled(sensor->position, 0.5 * sensor->baseline, turn.y);
    sensor->burst_axis = turn.x;
    sensor->burst_velocity = sensor->velocity;
}

/* The longer of two times. */
static inline real longer(real a, real b)
{
    return 0.5 * (a + b + sqrt((a - b) * (a - b)));
}

static inline void ultrasonic_sensor_initialize(UltrasonicSensor *sensor)
{
    real sound = speed_of_sound_in_air(sensor->temperature, sensor->humidity, sensor->pressure);
    sensor->speed_of_sound = sound;
    sensor->absorption = absorption_of_air(sensor->temperature, sensor->humidity, sensor->pressure, sensor->frequency);
    sensor->threshold_amplitude = exp(sensor->threshold / DECIBEL_PER_NEPER);
    sensor->wave_number = 2.0 * PI * sensor->frequency / sound;
    sensor->ring_time = ring_time_of(sensor->bandwidth);
    sensor->burst_length = sensor->burst_periods / (sensor->frequency * sensor->ring_time);
    sensor->peak_time = burst_peak_time(sensor->burst_length);
    sensor->peak = burst_peak(sensor->burst_length);
    sensor->burst_height = burst_height(sensor->burst_length);
    sensor->nearest_time = time_of_distance(sensor->minimum_range, sound, sensor->baseline);
    sensor->farthest_time = time_of_distance(sensor->maximum_range, sound, sensor->baseline);
    /* the last echo that counts is at its loudest within a burst and a peak time */
    real last = sensor->farthest_time + (sensor->burst_length + sensor->peak_time) * sensor->ring_time;
    sensor->burst_start = sensor->time + sensor->trigger_latency;
    sensor->burst_period = sensor->period;
    sensor->burst_rest = sensor->period - sensor->trigger_latency - longer(sensor->time_out, last);
    sensor->distance = sensor->maximum_range;
    sensor->level = NO_ECHO_LEVEL;
    sensor->start_time = sensor->time;
    sensor->position_time = sensor->time;
    sensor->sphere_center_time = sensor->time;
    sensor->foreign_1_position_time = sensor->time;
    sensor->foreign_2_position_time = sensor->time;
    sensor->foreign_3_position_time = sensor->time;
}

#endif
