/* UltrasonicSensor: the bursts of other sensors, straight from there and by one target.
 *
 * Another sensor tells of its periodic bursts, start + k period, once and for all, so that they are known
 * however long a step is; other bursts are told when they are known. All sensors have the same burst.
 */
enum { FOREIGN = 3 };

#define NO_BURST (-1e9) /* s, the start of burst_times and of its like: long ago */
#define SHORTEST_PERIOD 0.001 /* s; the air is not silent sooner, and each ping costs an event */
#define LONGEST_WAY 0.1 /* s, 34 m: more than 75 dB below a wall at 1 m */

/* What is known of another sensor. */
typedef struct Foreign {
    double start, period, rest;
    const double *times;
    Vector position, axis, velocity;
    double position_time;
} Foreign;

static Foreign foreign_sensor(const UltrasonicSensor *sensor, int number)
{
    if (number == 0) {
        return (Foreign){sensor->foreign_1_start,    sensor->foreign_1_period,   sensor->foreign_1_rest,
                         sensor->foreign_1_times,    sensor->foreign_1_position, sensor->foreign_1_axis,
                         sensor->foreign_1_velocity, sensor->foreign_1_position_time};
    }
    if (number == 1) {
        return (Foreign){sensor->foreign_2_start,    sensor->foreign_2_period,   sensor->foreign_2_rest,
                         sensor->foreign_2_times,    sensor->foreign_2_position, sensor->foreign_2_axis,
                         sensor->foreign_2_velocity, sensor->foreign_2_position_time};
    }
    return (Foreign){sensor->foreign_3_start,    sensor->foreign_3_period,   sensor->foreign_3_rest,
                     sensor->foreign_3_times,    sensor->foreign_3_position, sensor->foreign_3_axis,
                     sensor->foreign_3_velocity, sensor->foreign_3_position_time};
}

static Status check_foreign(const UltrasonicSensor *sensor, double sound, Log *log)
{
    for (int i = 0; i < FOREIGN; i++) {
        Foreign foreign = foreign_sensor(sensor, i);
        if (foreign.period > 0.0 && foreign.period < SHORTEST_PERIOD) {
            return report(log, STATUS_ERROR, "foreign_%d_period = %g s; allowed range: 0 (no periodic bursts) or at least %g s",
                          i + 1, foreign.period, SHORTEST_PERIOD);
        }
        if (norm(foreign.velocity) >= sound) {
            return report(log, STATUS_ERROR, "foreign_%d_velocity = %g m/s in length; allowed range: below the speed of sound "
                          "(%g m/s)", i + 1, norm(foreign.velocity), sound);
        }
    }
    return STATUS_OK;
}

/* Whether another sensor has told of any burst. */
static bool foreign_told(const UltrasonicSensor *sensor)
{
    double period = greater(greater(sensor->foreign_1_period, sensor->foreign_2_period), sensor->foreign_3_period);
    double latest = greater(sensor->foreign_1_times[0], sensor->foreign_1_times[1]);
    latest = greater(latest, greater(sensor->foreign_2_times[0], sensor->foreign_2_times[1]));
    latest = greater(latest, greater(sensor->foreign_3_times[0], sensor->foreign_3_times[1]));
    return period > 0.0 || latest > NO_BURST;
}

/* Whether the others tell of other bursts than when the ping in flight was computed. */
static bool foreign_news(const UltrasonicSensor *sensor)
{
    if (!foreign_told(sensor)) {
        return false;
    }
    bool news = false;
    for (int i = 0; i < FOREIGN; i++) {
        Foreign foreign = foreign_sensor(sensor, i);
        const double *seen = &sensor->foreign_seen[5 * i];
        news |= foreign.start != seen[0] || foreign.period != seen[1] || foreign.rest != seen[2]
            || foreign.times[0] != seen[3] || foreign.times[1] != seen[4];
    }
    return news;
}

static void see_foreign(UltrasonicSensor *sensor)
{
    if (!foreign_told(sensor)) {
        return;
    }
    for (int i = 0; i < FOREIGN; i++) {
        Foreign foreign = foreign_sensor(sensor, i);
        const double now[5] = {foreign.start, foreign.period, foreign.rest, foreign.times[0], foreign.times[1]};
        memcpy(&sensor->foreign_seen[5 * i], now, sizeof now);
    }
}

/* Straight from the transmitter to the receiver; false where it is not heard. */
static bool hear_directly(const UltrasonicSensor *sensor, const Surroundings *around, Echo *echo)
{
    const Transceiver *pair = &around->pair;
    double speed = sensor->speed_of_sound, k = sensor->wave_number;
    Vector offset = subtract(pair->receiver, pair->transmitter);
    double time = arrival_time(offset, pair->velocity, speed), way = speed * time;
    if (!(way > 0.0)) {
        return false;
    }
    Vector leg = scale(1.0 / way, add_scaled(offset, time, pair->velocity));
    bool facing = dot(leg, pair->axis) > 0.0 && dot(leg, pair->receiver_axis) < 0.0;
    if (!facing) {
        return false;
    }
    double there = beam_argument(leg, pair->axis, k), back = beam_argument(leg, pair->receiver_axis, k);
    double amplitude =
        facing_amplitude(way, sensor->absorption) * piston_directivity(there) * piston_directivity(back);
    Path path = {.incident = leg, .reflected = leg};
    *echo = (Echo){.time = time,
                   .strength = {amplitude, 0.0},
                   .amplitude = fabs(amplitude),
                   .there = there,
                   .back = back,
                   .doppler = doppler_of(pair, path, at_rest, speed)};
    Leg open = {pair->transmitter, leg, way, 0.0, 0.0, 1.0 / speed};
    Phasor left = passed_by_all(around, &open, PLANE, k);
    if (left.re != 1.0 || left.im != 0.0) {
        weigh(echo, left);
    }
    return true;
}

/* How long after its arrival an echo may still ring above the threshold, in s: t - ln(1 + t) passes its margin,
 * and 5 nepers more, before m + sqrt(2 m). */
static double ringing(const UltrasonicSensor *sensor, Echo echo)
{
    double margin = log(greater(echo.amplitude / sensor->threshold_amplitude, 1.0)) + 5.0;
    return sensor->ring_time * (sensor->burst_length + margin + sqrt(2.0 * margin));
}

/* One burst, `sent` by another, for a ping of `emission`. */
static void add_foreign_burst(const UltrasonicSensor *sensor, const Foreign *foreign, double sent, double emission,
                              Echoes *echoes)
{
    double length = norm(foreign->axis);
    if (!(length > 0.0)) {
        return; /* it looks nowhere */
    }
    Surroundings around;
    look_around(sensor, sent, &around);
    around.pair.transmitter = add_scaled(foreign->position, sent - foreign->position_time, foreign->velocity);
    around.pair.axis = scale(1.0 / length, foreign->axis);
    around.pair.transmitter_velocity = foreign->velocity;
    Vector height = subtract(around.pair.transmitter, around.plane_point);
    if (around.plane && dot(height, around.plane_normal) <= 0.0) {
        return; /* it is behind the wall */
    }
    Echoes heard;
    heard.count = 0;
    keep_next(&heard, hear_directly(sensor, &around, next_echo(&heard)));
    if (around.plane) {
        keep_next(&heard, hear_plane(sensor, &around, &around.pair, next_echo(&heard)));
    }
    add_echoes_of_targets(sensor, &around, &around.pair, 1.0, &heard);
    for (int i = 0; i < heard.count; i++) {
        Echo echo = heard.echo[i];
        echo.time += sent - emission;
        echo.foreign = true;
        if (echo.time <= sensor->farthest_time && echo.time + ringing(sensor, echo) > 0.0) {
            add_echo(echoes, echo);
        }
    }
}

/* All bursts of others that a ping may hear. */
static void add_foreign(const UltrasonicSensor *sensor, double emission, Echoes *echoes)
{
    if (!foreign_told(sensor)) {
        return;
    }
    double first = emission - LONGEST_WAY, last = emission + sensor->farthest_time;
    for (int i = 0; i < FOREIGN; i++) {
        Foreign foreign = foreign_sensor(sensor, i);
        for (int k = 0; k < 2; k++) {
            if (foreign.times[k] >= first && foreign.times[k] <= last) {
                add_foreign_burst(sensor, &foreign, foreign.times[k], emission, echoes);
            }
        }
        if (!(foreign.period > 0.0 && foreign.rest >= 0.0)) {
            continue;
        }
        double number = greater(ceil((first - foreign.start) / foreign.period), 0.0);
        int most = (int)((last - first) / foreign.period) + 1;
        for (int k = 0; k <= most; k++) {
            double sent = foreign.start + (number + k) * foreign.period; /* a product, as the other sensor has it */
            if (sent >= first && sent <= last) {
                add_foreign_burst(sensor, &foreign, sent, emission, echoes);
            }
        }
    }
}
