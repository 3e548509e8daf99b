/* UltrasonicSensor: a path by a point of a surface, and what comes back along one. */
/* The path by a given surface point; what moves is taken where it is at the reception. */
INLINED Path path_by(const Transceiver *pair, Vector point, Vector normal, double time, double speed)
{
    Path path = {.point = point, .normal = normal};
    Vector leg = subtract(point, pair->transmitter);
    Vector back = subtract(add_scaled(pair->receiver, time, pair->velocity), point);
    path.first = norm(leg);
    path.second = norm(back);
    path.incident = scale(1.0 / path.first, leg);
    path.reflected = scale(1.0 / path.second, back);
    path.time = (path.first + path.second) / speed;
    path.bounce_time = path.first / speed;
    return path;
}

/* Writes the echo of a path by a target of some velocity; false where the sensor cannot hear it. */
static bool hear_path(const UltrasonicSensor *sensor, const Transceiver *pair, const Path *path, double spread,
                      Vector velocity, double reflection, Echo *echo)
{
    bool in_front = dot(path->incident, pair->axis) > 0.0 && dot(path->reflected, pair->receiver_axis) < 0.0;
    /* a plane between transmitter and receiver has its mirror point behind one of them */
    bool outside = dot(path->incident, path->normal) < 0.0 && dot(path->reflected, path->normal) > 0.0
        && path->first > 0.0 && path->second > 0.0;
    if (!in_front || !outside || !(reflection > 0.0)) {
        return false;
    }
    double amplitude = path_amplitude(pair, *path, spread, reflection, sensor->wave_number, sensor->absorption);
    double there = beam_argument(path->incident, pair->axis, sensor->wave_number);
    double back = beam_argument(path->reflected, pair->receiver_axis, sensor->wave_number);
    double doppler = doppler_of(pair, *path, velocity, sensor->speed_of_sound);
    *echo = (Echo){.time = path->time,
                   .strength = {amplitude, 0.0},
                   .amplitude = fabs(amplitude),
                   .there = there,
                   .back = back,
                   .doppler = doppler};
    return isfinite(path->time);
}
