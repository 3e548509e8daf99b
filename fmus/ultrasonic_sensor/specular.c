/* UltrasonicSensor: the echo of each target by its mirror point. */
static bool hear_plane(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair, Echo *echo)
{
    Path path = plane_path(pair, around->plane_point, around->plane_normal, sensor->speed_of_sound);
    double spread = path.first + path.second;
    return hear_path(sensor, pair, &path, spread, at_rest, sensor->plane_reflection, echo)
        && (alone(around, PLANE) || hear_shaded(sensor, around, pair, PLANE, &path, spread, echo));
}

/* By one pair: the sensor's own, or with one of the two mirrored at the ground. */
static void add_echoes_of_targets(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair,
                                  double bounce, Echoes *echoes)
{
    int before = echoes->count;
    for (int i = 0; i < around->targets; i++) {
        keep_next(echoes, hear_target(sensor, around, i, pair, next_echo(echoes)));
    }
    if (around->box_present) {
        add_box(sensor, around, pair, echoes);
    }
    for (int i = before; i < echoes->count && bounce != 1.0; i++) {
        weigh(&echoes->echo[i], (Phasor){bounce, 0.0});
    }
}

/* One bounce at the ground, on the way to a target or from it: image transmitter, image receiver. Returns how many
 * pairs there are, two or none. */
static int mirrored_pairs(const UltrasonicSensor *sensor, const Surroundings *around, Transceiver pairs[2])
{
    if (!(around->plane && sensor->multipath && sensor->plane_reflection > 0.0)) {
        return 0;
    }
    Transceiver there = around->pair, back = around->pair;
    there.transmitter = mirrored(around, there.transmitter);
    there.axis = turned_over(around, there.axis);
    there.transmitter_velocity = turned_over(around, there.transmitter_velocity);
    back.receiver = mirrored(around, back.receiver);
    back.receiver_axis = turned_over(around, back.receiver_axis);
    back.velocity = turned_over(around, back.velocity);
    pairs[0] = there;
    pairs[1] = back;
    return 2;
}

static void add_multipath(const UltrasonicSensor *sensor, const Surroundings *around, Echoes *echoes)
{
    Transceiver pairs[2];
    int count = mirrored_pairs(sensor, around, pairs);
    for (int i = 0; i < count; i++) {
        add_echoes_of_targets(sensor, around, &pairs[i], sensor->plane_reflection, echoes);
    }
}

static void specular_echoes(const UltrasonicSensor *sensor, const Surroundings *around, Echoes *echoes)
{
    if (around->plane) {
        keep_next(echoes, hear_plane(sensor, around, &around->pair, next_echo(echoes)));
    }
    add_echoes_of_targets(sensor, around, &around->pair, 1.0, echoes);
    add_multipath(sensor, around, echoes);
}
