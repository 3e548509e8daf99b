// The air, the paths of the sound and their levels: each function of equations.h by its own name.

static Transceiver transceiver(Lift &lift)
{
    Vector transmitter = lift.symbols<Vector>("transmitter"), receiver = lift.symbols<Vector>("receiver");
    Vector axis = lift.symbols<Vector>("axis"), receiver_axis = lift.symbols<Vector>("receiver_axis");
    return {transmitter, receiver, axis, receiver_axis, lift.symbols<Vector>("velocity")};
}

static void save_path(Lift &lift, Path path, const char *name)
{
    lift.output("time", path.time);
    lift.output("first", path.first);
    lift.output("second", path.second);
    lift.output("bounce_time", path.bounce_time);
    lift.output("share", path.share);
    lift.output("point", path.point);
    lift.output("normal", path.normal);
    lift.output("incident", path.incident);
    lift.output("reflected", path.reflected);
    lift.save(name);
}

static void lift_paths()
{
    Lift plane;
    Transceiver pair = transceiver(plane);
    Vector point = plane.symbols<Vector>("plane_point");
    Vector normal = plane.symbols<Vector>("normal");
    save_path(plane, plane_path(&pair, point, normal, plane.symbols<Real>("speed")), "plane_path");

    Lift refined;
    pair = transceiver(refined);
    Ball ball = {refined.symbols<Vector>("ball_center"), refined.symbols<Vector>("ball_velocity"),
                 refined.symbols<Real>("ball_radius")};
    Path before = {};
    before.time = refined.symbols<Real>("path_time");
    before.share = refined.symbols<Real>("path_share");
    before.bounce_time = refined.symbols<Real>("path_bounce_time");
    save_path(refined, ball_path_refined(&pair, before, ball, refined.symbols<Real>("speed")), "ball_path_refined");
}

static Sight sight_of(Lift &lift)
{
    Real offset = lift.symbols<Real>("sight_offset"), product = lift.symbols<Real>("sight_product");
    return {offset, product, lift.symbols<Real>("sight_half"), lift.symbols<Real>("ball_radius")};
}

static void lift_aim()
{
    lift_function("first_aim", [](Lift &lift) {
        Sight sight = sight_of(lift);
        return first_aim(sight, lift.symbols<Real>("length"));
    });
    Lift lift;
    Sight sight = sight_of(lift);
    Aim aim = aim_at(sight, lift.symbols<Real>("aim_place"));
    lift.output("place", aim.place);
    lift.output("reach", aim.reach);
    lift.output("change", aim.change);
    lift.save("aim_at");
}

static Path legs(Lift &lift)
{
    Path path = {};
    path.first = lift.symbols<Real>("first");
    path.second = lift.symbols<Real>("second");
    path.incident = lift.symbols<Vector>("incident");
    path.reflected = lift.symbols<Vector>("reflected");
    path.normal = lift.symbols<Vector>("normal");
    return path;
}

static void save_curvature(Lift &lift, Curvature curvature, const char *name)
{
    lift.output("trace", curvature.trace);
    lift.output("determinant", curvature.determinant);
    lift.output("along", curvature.along);
    lift.save(name);
}

static void lift_curvatures()
{
    Lift sphere;
    Path path = legs(sphere);
    save_curvature(sphere, sphere_curvature(path, sphere.symbols<Real>("ball_radius")), "sphere_curvature");

    Lift cylinder;
    path = legs(cylinder);
    Vector axis = cylinder.symbols<Vector>("cylinder_axis");
    save_curvature(cylinder, cylinder_curvature(path, axis, cylinder.symbols<Real>("ball_radius")),
                   "cylinder_curvature");
}

static Curvature mirror(Lift &lift)
{
    return {lift.symbols<Real>("trace"), lift.symbols<Real>("determinant"), lift.symbols<Real>("along")};
}

static void lift_amplitudes()
{
    lift_function("spreading_square", [](Lift &lift) {
        Path path = legs(lift);
        return spreading_square(path, mirror(lift));
    });
    lift_function("left_by_air", [](Lift &lift) {
        Real length = lift.symbols<Real>("length");
        return left_by_air(length, lift.symbols<Real>("absorption_per_metre"));
    });
    lift_function("path_amplitude", [](Lift &lift) {
        Path path = legs(lift);
        Transceiver pair = {};
        pair.axis = lift.symbols<Vector>("axis");
        pair.receiver_axis = lift.symbols<Vector>("receiver_axis");
        Real spread = lift.symbols<Real>("spread"), reflection = lift.symbols<Real>("reflection");
        Real wave_number = lift.symbols<Real>("sound_wave_number");
        Real absorption = lift.symbols<Real>("absorption_per_metre");
        return path_amplitude(&pair, path, spread, reflection, wave_number, absorption);
    });
    lift_function("doppler_of", [](Lift &lift) {
        Path path = legs(lift);
        Transceiver pair = {};
        pair.velocity = lift.symbols<Vector>("velocity");
        pair.transmitter_velocity = lift.symbols<Vector>("transmitter_velocity");
        return doppler_of(&pair, path, lift.symbols<Vector>("ball_velocity"), lift.symbols<Real>("speed"));
    });
    lift_function("piston_directivity",
                  [](Lift &lift) { return piston_directivity(lift.symbols<Real>("half_argument_squared")); });
    lift_function("piston_dispersion",
                  [](Lift &lift) { return piston_dispersion(lift.symbols<Real>("half_argument_squared")); });
    lift_function("beam_argument", [](Lift &lift) {
        Vector direction = lift.symbols<Vector>("incident"), axis = lift.symbols<Vector>("axis");
        return beam_argument(direction, axis, lift.symbols<Real>("sound_wave_number"));
    });
    lift_function("facing_amplitude", [](Lift &lift) {
        Real length = lift.symbols<Real>("length");
        return facing_amplitude(length, lift.symbols<Real>("absorption_per_metre"));
    });
}

static void lift_air()
{
    lift_function("vapour_fraction", [](Lift &lift) {
        Real temperature = lift.symbols<Real>("temperature");
        Real humidity = lift.symbols<Real>("humidity");
        return vapour_fraction(temperature, humidity, lift.symbols<Real>("pressure"));
    });
    lift_function("speed_of_sound_in_air", [](Lift &lift) {
        Real temperature = lift.symbols<Real>("temperature");
        Real humidity = lift.symbols<Real>("humidity");
        return speed_of_sound_in_air(temperature, humidity, lift.symbols<Real>("pressure"));
    });
    lift_function("absorption_of_air", [](Lift &lift) {
        Real temperature = lift.symbols<Real>("temperature");
        Real humidity = lift.symbols<Real>("humidity");
        Real pressure = lift.symbols<Real>("pressure");
        return absorption_of_air(temperature, humidity, pressure, lift.symbols<Real>("frequency"));
    });
}

static void lift_times()
{
    lift_function("distance_of_time", [](Lift &lift) {
        Real time = lift.symbols<Real>("time_of_flight");
        Real speed = lift.symbols<Real>("speed");
        return distance_of_time(time, speed, lift.symbols<Real>("baseline"));
    });
    lift_function("time_of_distance", [](Lift &lift) {
        Real range = lift.symbols<Real>("range");
        Real speed = lift.symbols<Real>("speed");
        return time_of_distance(range, speed, lift.symbols<Real>("baseline"));
    });
    lift_function("longer", [](Lift &lift) { return longer(lift.symbols<Real>("range"), lift.symbols<Real>("length")); });
    lift_function("arrival_time", [](Lift &lift) {
        Vector offset = lift.symbols<Vector>("offset");
        Vector velocity = lift.symbols<Vector>("velocity");
        return arrival_time(offset, velocity, lift.symbols<Real>("speed"));
    });
}

static void lift_burst()
{
    lift_function("ring_time_of", [](Lift &lift) { return ring_time_of(lift.symbols<Real>("bandwidth")); });
    lift_function("burst_peak_time", [](Lift &lift) { return burst_peak_time(lift.symbols<Real>("length_of_burst")); });
    lift_function("burst_peak", [](Lift &lift) { return burst_peak(lift.symbols<Real>("length_of_burst")); });
    lift_function("burst_height", [](Lift &lift) { return burst_height(lift.symbols<Real>("length_of_burst")); });
}

static void lift_functions()
{
    lift_burst();
    lift_paths();
    lift_aim();
    lift_curvatures();
    lift_amplitudes();
    lift_air();
    lift_times();
}
