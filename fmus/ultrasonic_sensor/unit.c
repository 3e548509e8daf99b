/* UltrasonicSensor: the checks, the pings and their times. */
#include "unit.h"
#include "surroundings.c"

#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <string.h>

#include "rays.c"
#include "fresnel.c"
#include "shading.c"
#include "mirror.c"
#include "reflection.c"
#include "capsule.c"
#include "box.c"
#include "specular.c"
#include "doppler.c"
#include "envelope.c"
#include "sum.c"
#include "surface.c"
#include "mesh.c"
#include "mesh_checks.c"
#include "bins.c"
#include "foreign.c"
#include "echo.c"

#define DEVICE_SPEED (0.01 / 58e-6) /* m/s of echo width: the sheet's 58 us a centimetre */

static Status ultrasonic_sensor_check(const UltrasonicSensor *sensor, Log *log)
{
    if (sensor->period > 0.0 && sensor->period < SHORTEST_PERIOD) {
        return report(log, STATUS_ERROR, "period = %g s; allowed range: 0 (pings by trigger only) or at least %g s",
                      sensor->period, SHORTEST_PERIOD);
    }
    if (sensor->minimum_range >= sensor->maximum_range) {
        return report(log, STATUS_ERROR, "minimum_range = %g m; allowed range: below maximum_range (%g m)",
                      sensor->minimum_range, sensor->maximum_range);
    }
    double sound = speed_of_sound_in_air(sensor->temperature, sensor->humidity, sensor->pressure);
    double flight = time_of_distance(sensor->maximum_range, sound, sensor->baseline);
    if (sensor->time_out > 0.0 && sensor->time_out < flight) {
        return report(log, STATUS_ERROR,
                      "time_out = %g s; allowed range: 0 (the flight to maximum_range) or at least that flight (%g s)",
                      sensor->time_out, flight);
    }
    if (norm(sensor->velocity) >= sound || norm(sensor->sphere_velocity) >= sound) {
        return report(log, STATUS_ERROR,
                      "velocity = %g m/s, sphere_velocity = %g m/s in length; allowed range: below the speed of sound "
                      "(%g m/s)", norm(sensor->velocity), norm(sensor->sphere_velocity), sound);
    }
    Status status = check_foreign(sensor, sound, log);
    return status == STATUS_OK ? check_surface(sensor, log) : status;
}

/* An input belongs to the time at which it took its value; from there it moves with its velocity. */
static void notice_change(double time, Vector input, Vector *seen, double *since)
{
    if (memcmp(&input, seen, sizeof input) != 0) {
        *seen = input;
        *since = time;
    }
}

static void notice_foreign(UltrasonicSensor *sensor)
{
    notice_change(sensor->time, sensor->foreign_1_position, &sensor->foreign_1_position_seen,
                  &sensor->foreign_1_position_time);
    notice_change(sensor->time, sensor->foreign_2_position, &sensor->foreign_2_position_seen,
                  &sensor->foreign_2_position_time);
    notice_change(sensor->time, sensor->foreign_3_position, &sensor->foreign_3_position_seen,
                  &sensor->foreign_3_position_time);
}

static void notice_inputs(UltrasonicSensor *sensor)
{
    notice_change(sensor->time, sensor->position, &sensor->position_seen, &sensor->position_time);
    notice_change(sensor->time, sensor->sphere_center, &sensor->sphere_center_seen, &sensor->sphere_center_time);
    if (foreign_told(sensor)) {
        notice_foreign(sensor);
    }
}

static bool trigger_rises(const UltrasonicSensor *sensor)
{
    return sensor->trigger_clock || (sensor->trigger && !sensor->trigger_before);
}

/* Whether the burst of the ping, or its end, is due. Its own time counts, which `time` may miss by a rounding, and where
 * the clock of the echo ticks by what an importer's time is off. */
static bool is_due(const UltrasonicSensor *sensor)
{
    double rounding = (sensor->echo_clock ? 1e-9 : 1e-12) * (1.0 + fabs(sensor->time));
    double next = sensor->waiting ? sensor->emission_time : sensor->finish_time;
    return (sensor->waiting || sensor->in_flight) && next <= sensor->time + rounding;
}

/* A product, not a sum of steps: no drift. */
static double ping_time(const UltrasonicSensor *sensor, uint64_t ping)
{
    return sensor->period > 0.0 ? sensor->start_time + (double)ping * sensor->period : INFINITY;
}

/* Of the same ping, the burst. */
static double burst_time(const UltrasonicSensor *sensor, uint64_t ping)
{
    return (sensor->start_time + sensor->trigger_latency) + (double)ping * sensor->period;
}

/* The bits of seed and counter well mixed: the finalizer of SplitMix64, Steele et al. 2014. */
static uint64_t mixed(uint64_t bits)
{
    bits += UINT64_C(0x9E3779B97F4A7C15);
    bits = (bits ^ (bits >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    bits = (bits ^ (bits >> 27)) * UINT64_C(0x94D049BB133111EB);
    return bits ^ (bits >> 31);
}

/* In (0, 1). */
static double uniform(uint64_t bits)
{
    return ((double)(bits >> 11) + 0.5) * 0x1p-53;
}

/* A standard normal number that depends on seed and counter alone; Box and Muller 1958. */
static double normal_number(int32_t seed, int32_t counter)
{
    uint64_t first = mixed(mixed((uint64_t)(uint32_t)seed) ^ (uint64_t)(uint32_t)counter);
    uint64_t second = mixed(first);
    return sqrt(-2.0 * log(uniform(first))) * cos(2.0 * PI * uniform(second));
}

/* What is reported of a distance. */
static double reported_distance(const UltrasonicSensor *sensor, double distance, double error)
{
    double step = sensor->resolution, read = greater(0.0, distance + error);
    return step > 0.0 ? step * rounded(read * (1.0 / step)) : read;
}

static void pend_echo(UltrasonicSensor *sensor, Detection found)
{
    double speed = sensor->speed_of_sound;
    double error = sensor->noise > 0.0 ? sensor->noise * normal_number(sensor->seed, sensor->sequence) : 0.0;
    sensor->pending_flight = greater(found.echo.time, 0.0);
    sensor->pending_width = greater(found.crossing - sensor->echo_start, 0.0);
    /* sound that went straight from transmitter to receiver comes from no distance */
    bool reflected = speed * found.echo.time > sensor->baseline;
    double distance = reflected ? distance_of_time(found.echo.time, speed, sensor->baseline) : 0.0;
    sensor->pending_distance = reported_distance(sensor, distance, error);
    sensor->pending_device = reported_distance(sensor, DEVICE_SPEED * sensor->pending_width, error);
}

static void pend_silence(UltrasonicSensor *sensor, double end)
{
    sensor->pending_flight = end;
    sensor->pending_width = end;
    sensor->pending_distance = sensor->maximum_range;
    sensor->pending_device = DEVICE_SPEED * end;
}

/* Others know of the regular bursts by their start and period. */
static void await_burst(UltrasonicSensor *sensor, double emission, bool regular)
{
    sensor->waiting = true;
    sensor->emission_time = emission;
    sensor->burst_times[1] = regular ? NO_BURST : emission;
}

/* How the ping in flight will end; anew where another burst becomes known. */
static void compute_ping(UltrasonicSensor *sensor)
{
    double emission = sensor->emission_time;
    see_foreign(sensor);
    Detection found = first_echo(sensor, emission);
    double time_out = sensor->time_out > 0.0 ? sensor->time_out : sensor->farthest_time;
    sensor->pending_valid = isfinite(found.crossing);
    sensor->pending_level = sensor->pending_valid ? DECIBEL_PER_NEPER * log(found.echo.amplitude) : NO_ECHO_LEVEL;
    if (sensor->pending_valid) {
        pend_echo(sensor, found);
    } else {
        pend_silence(sensor, time_out);
    }
    sensor->finish_time = emission + (sensor->pending_valid ? found.crossing : time_out);
}

static void emit_burst(UltrasonicSensor *sensor)
{
    sensor->waiting = false;
    sensor->in_flight = true;
    if (sensor->burst_times[1] != NO_BURST) {
        sensor->burst_times[0] = sensor->emission_time;
        sensor->burst_times[1] = NO_BURST;
    }
    take_left(sensor, sensor->emission_time);
    compute_ping(sensor);
}

/* The periodic pings that fell into the flight are lost. */
static void finish_ping(UltrasonicSensor *sensor)
{
    sensor->distance = sensor->pending_distance;
    sensor->device_distance = sensor->pending_device;
    sensor->time_of_flight = sensor->pending_flight;
    sensor->echo_width = sensor->pending_width;
    sensor->valid = sensor->pending_valid;
    sensor->level = sensor->pending_level;
    sensor->sequence = sensor->sequence < INT32_MAX ? sensor->sequence + 1 : 0;
    sensor->in_flight = false;
    while (ping_time(sensor, sensor->next_ping) < sensor->finish_time) {
        sensor->next_ping++;
    }
    if (sensor->period > 0.0 && sensor->burst_rest < 0.0) {
        sensor->burst_times[1] = burst_time(sensor, sensor->next_ping);
    }
}

static double ultrasonic_sensor_next_event(const UltrasonicSensor *sensor)
{
    if (trigger_rises(sensor) || is_due(sensor) || (sensor->in_flight && foreign_news(sensor))) {
        return sensor->time;
    }
    if (sensor->waiting) {
        return sensor->emission_time;
    }
    return sensor->in_flight ? sensor->finish_time : ping_time(sensor, sensor->next_ping);
}

/* One event at a time, the earliest. A trigger while a ping waits or flies is lost. */
static void ultrasonic_sensor_event(UltrasonicSensor *sensor)
{
    bool waiting = sensor->waiting, busy = waiting || sensor->in_flight, due = is_due(sensor);
    notice_inputs(sensor);
    if (sensor->in_flight && foreign_news(sensor)) {
        compute_ping(sensor);
    } else if (trigger_rises(sensor) && !due) {
        sensor->trigger_before |= sensor->trigger;
        sensor->trigger_clock = false;
        if (!busy) {
            await_burst(sensor, sensor->time + sensor->trigger_latency, false);
        }
    } else if (waiting) {
        emit_burst(sensor);
    } else if (busy) {
        finish_ping(sensor);
    } else {
        await_burst(sensor, burst_time(sensor, sensor->next_ping), sensor->burst_rest >= 0.0);
        sensor->next_ping++;
        if (is_due(sensor)) {
            emit_burst(sensor);
        }
    }
}

/* Of the clock of the echo: when the ping in flight ends. */
static double ultrasonic_sensor_clock_time(const UltrasonicSensor *sensor, size_t clock)
{
    (void)clock;
    return sensor->in_flight ? sensor->finish_time : INFINITY;
}

/* Nothing happens between events but the passing of time. */
static Status ultrasonic_sensor_step(UltrasonicSensor *sensor, double step, Log *log)
{
    notice_inputs(sensor);
    sensor->trigger_before = sensor->trigger;
    (void)step;
    (void)log;
    return STATUS_OK;
}
