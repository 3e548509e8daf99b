/* UltrasonicSensor: what a ping hears, on each step of the ladder of fidelity. */

/* A ray knows no ringing: one from the blind zone, or from beyond the range, does not count. */
static bool counts(const UltrasonicSensor *sensor, Echo echo)
{
    return echo.time >= sensor->nearest_time && echo.time <= sensor->farthest_time;
}

static Detection hear_ray(const UltrasonicSensor *sensor, const Surroundings *around)
{
    bool cone = sensor->fidelity == ULTRASONIC_SENSOR_FIDELITY_CONE;
    Echo echo = echo_of_ray(sensor, cone ? cone_length(sensor, around) : ray_length(around, around->pair.axis));
    return counts(sensor, echo) ? (Detection){echo.time, echo} : (Detection){INFINITY, silence};
}

/* What earlier pings left in the air. */
static void add_late(const UltrasonicSensor *sensor, double emission, Echoes *echoes)
{
    for (int i = 0; i < sensor->late_count; i++) {
        if (sensor->late_time[i] > emission) {
            double time = sensor->late_time[i] - emission;
            add_echo(echoes, (Echo){.time = time, .level = sensor->late_level[i], .phase = sensor->late_phase[i]});
        }
    }
}

/* What this ping leaves; the phase of its carrier is that at the arrival, whoever hears it. */
static void keep_late(UltrasonicSensor *sensor, const Echoes *echoes, double emission, double end)
{
    sensor->late_count = 0;
    for (int i = 0; i < echoes->count && sensor->late_count < MOST_LATE; i++) {
        if (echoes->echo[i].time > end) {
            sensor->late_time[sensor->late_count] = emission + echoes->echo[i].time;
            sensor->late_level[sensor->late_count] = echoes->echo[i].level;
            sensor->late_phase[sensor->late_count] = echoes->echo[i].phase;
            sensor->late_count++;
        }
    }
}

/* What the receiver hears of its own transmitter: straight along the baseline. */
static void add_coupling(const UltrasonicSensor *sensor, const Transceiver *pair, Echoes *echoes)
{
    if (sensor->coupling > NO_ECHO_LEVEL) {
        Vector offset = subtract(pair->receiver, pair->transmitter);
        double time = arrival_time(offset, pair->velocity, sensor->speed_of_sound);
        add_echo(echoes, (Echo){.time = time, .level = sensor->coupling});
    }
}

/* Puts those that arrive in time first; returns how many. */
static int those_in_time(const UltrasonicSensor *sensor, Echoes *echoes)
{
    int place = 0;
    for (int i = 0; i < echoes->count; i++) {
        Echo echo = echoes->echo[i];
        if (echo.time <= sensor->farthest_time) {
            echoes->echo[i] = echoes->echo[place];
            echoes->echo[place++] = echo;
        }
    }
    return place;
}

static Detection hear_echoes(UltrasonicSensor *sensor, const Surroundings *around, double emission)
{
    Echoes echoes;
    echoes.count = 0;
    specular_echoes(sensor, around, &echoes);
    add_coupling(sensor, &around->pair, &echoes);
    add_late(sensor, emission, &echoes);
    Detection found = detect(sensor, echoes.echo, those_in_time(sensor, &echoes));
    keep_late(sensor, &echoes, emission, lesser(found.crossing, sensor->farthest_time));
    return found;
}

static Detection first_echo(UltrasonicSensor *sensor, double emission)
{
    Surroundings around = surroundings_at(sensor, emission);
    bool specular = sensor->fidelity == ULTRASONIC_SENSOR_FIDELITY_SPECULAR;
    return specular ? hear_echoes(sensor, &around, emission) : hear_ray(sensor, &around);
}
