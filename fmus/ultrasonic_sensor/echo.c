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
        const double *late = &sensor->late[LATE_NUMBERS * i];
        Phasor strength = {late[1], late[2]};
        double amplitude = sqrt(square_of(strength));
        add_echo(echoes, (Echo){late[0] - emission, strength, amplitude, late[3], late[4], late[5], false});
    }
}

/* What this ping leaves; the phase of its carrier is that at the arrival, whoever hears it. */
static void keep_left(UltrasonicSensor *sensor, const Echoes *echoes, double emission, double end)
{
    sensor->left_count = 0;
    for (int i = 0; i < echoes->count && sensor->left_count < MOST_LATE; i++) {
        if (echoes->echo[i].time > end && !echoes->echo[i].foreign) {
            Echo echo = echoes->echo[i];
            const double numbers[LATE_NUMBERS] = {emission + echo.time, echo.strength.re, echo.strength.im,
                                                  echo.there,           echo.back,        echo.doppler};
            memcpy(&sensor->left[LATE_NUMBERS * sensor->left_count++], numbers, sizeof numbers);
        }
    }
}

/* When a burst leaves, what the last ping left and has not arrived yet is late. */
static void take_left(UltrasonicSensor *sensor, double emission)
{
    sensor->late_count = 0;
    for (int i = 0; i < sensor->left_count; i++) {
        const double *left = &sensor->left[LATE_NUMBERS * i];
        if (left[0] > emission) {
            memcpy(&sensor->late[LATE_NUMBERS * sensor->late_count++], left, LATE_NUMBERS * sizeof *left);
        }
    }
}

/* What the receiver hears of its own transmitter: straight along the baseline. */
static void add_coupling(const UltrasonicSensor *sensor, const Transceiver *pair, Echoes *echoes)
{
    if (sensor->coupling > NO_ECHO_LEVEL) {
        Vector offset = subtract(pair->receiver, pair->transmitter);
        double time = arrival_time(offset, pair->velocity, sensor->speed_of_sound);
        add_echo(echoes, plain_echo(time, exp(sensor->coupling / DECIBEL_PER_NEPER)));
    }
}

/* Puts those that arrive in time first; returns how many. */
static int those_in_time(const UltrasonicSensor *sensor, Echoes *echoes)
{
    int place = 0;
    while (place < echoes->count && echoes->echo[place].time <= sensor->farthest_time) {
        place++;
    }
    for (int i = place + 1; i < echoes->count; i++) {
        Echo echo = echoes->echo[i];
        if (echo.time <= sensor->farthest_time) {
            echoes->echo[i] = echoes->echo[place];
            echoes->echo[place++] = echo;
        }
    }
    return place;
}

#define CLOSE_ECHOES 0.02 /* m, one way */

/* Whether two echoes come so close together that their places on the mesh matter. */
static bool close_together(const UltrasonicSensor *sensor, const Echoes *echoes)
{
    for (int i = 0; i < echoes->count; i++) {
        for (int j = 0; j < i; j++) {
            double apart = echoes->echo[i].time - echoes->echo[j].time;
            if (fabs(apart) * sensor->speed_of_sound <= 2.0 * CLOSE_ECHOES) {
                return true;
            }
        }
    }
    return false;
}

/* Whether the mesh is to be heard, in place of the capsules. */
static bool hears_mesh(const UltrasonicSensor *sensor, const Echoes *echoes, Mesh *mesh)
{
    if (sensor->fidelity < ULTRASONIC_SENSOR_FIDELITY_SURFACE || !mesh_of(sensor, mesh)) {
        return false;
    }
    bool capsules = sensor->capsule_1_radius > 0.0 || sensor->capsule_2_radius > 0.0;
    return sensor->fidelity == ULTRASONIC_SENSOR_FIDELITY_SURFACE || !capsules || close_together(sensor, echoes);
}

/* The same surroundings without the capsules: of the targets, the sphere is the first. */
static Surroundings without_capsules(const UltrasonicSensor *sensor, const Surroundings *around)
{
    Surroundings rest = *around;
    rest.targets = sensor->sphere_radius > 0.0 ? 1 : 0;
    return rest;
}

static Detection hear_echoes(UltrasonicSensor *sensor, const Surroundings *around, double emission)
{
    Echoes echoes;
    Mesh mesh;
    echoes.count = 0;
    specular_echoes(sensor, around, &echoes);
    bool meshed = hears_mesh(sensor, &echoes, &mesh);
    if (meshed) {
        Surroundings rest = without_capsules(sensor, around);
        echoes.count = 0;
        specular_echoes(sensor, &rest, &echoes);
    }
    add_coupling(sensor, &around->pair, &echoes);
    add_late(sensor, emission, &echoes);
    add_foreign(sensor, emission, &echoes);
    int count = those_in_time(sensor, &echoes);
    Detection found = meshed ? detect_with_mesh(sensor, around, &mesh, echoes.echo, count)
                             : detect(sensor, echoes.echo, count);
    keep_left(sensor, &echoes, emission, lesser(found.crossing, sensor->farthest_time));
    return found;
}

static Detection first_echo(UltrasonicSensor *sensor, double emission)
{
    Surroundings around;
    look_around(sensor, emission, &around);
    bool rays = sensor->fidelity < ULTRASONIC_SENSOR_FIDELITY_SPECULAR;
    return rays ? hear_ray(sensor, &around) : hear_echoes(sensor, &around, emission);
}
