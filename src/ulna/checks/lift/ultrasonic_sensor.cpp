// The air, the paths of the sound and their levels: each function of equations.h by its own name.

static Transceiver transceiver(Lift &lift)
{
    return {lift.symbols<Vector>("transmitter"), lift.symbols<Vector>("receiver"), lift.symbols<Vector>("axis"),
            lift.symbols<Vector>("velocity")};
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
                 refined.symbols<Vector>("ball_slide"), refined.symbols<Real>("ball_radius")};
    Path before = {};
    before.time = refined.symbols<Real>("path_time");
    before.share = refined.symbols<Real>("path_share");
    before.bounce_time = refined.symbols<Real>("path_bounce_time");
    save_path(refined, ball_path_refined(&pair, before, ball, refined.symbols<Real>("speed")), "ball_path_refined");
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

static void lift_levels()
{
    lift_function("spreading_power", [](Lift &lift) {
        Path path = legs(lift);
        return spreading_power(path, mirror(lift));
    });
    lift_function("path_level", [](Lift &lift) {
        Path path = legs(lift);
        Transceiver pair = {};
        pair.axis = lift.symbols<Vector>("axis");
        Real wave_number = lift.symbols<Real>("wave_number");
        return path_level(&pair, path, mirror(lift), wave_number, lift.symbols<Real>("absorption_per_metre"));
    });
    lift_function("piston_directivity",
                  [](Lift &lift) { return piston_directivity(lift.symbols<Real>("half_argument_squared")); });
    lift_function("facing_level", [](Lift &lift) {
        Real length = lift.symbols<Real>("length");
        return facing_level(length, lift.symbols<Real>("absorption_per_metre"));
    });
}

static void lift_air()
{
    lift_function("vapour_fraction", [](Lift &lift) {
        Real temperature = lift.symbols<Real>("temperature");
        return vapour_fraction(temperature, lift.symbols<Real>("humidity"));
    });
    lift_function("speed_of_sound_in_air", [](Lift &lift) {
        Real temperature = lift.symbols<Real>("temperature");
        return speed_of_sound_in_air(temperature, lift.symbols<Real>("humidity"));
    });
    lift_function("absorption_of_air", [](Lift &lift) {
        Real temperature = lift.symbols<Real>("temperature");
        Real humidity = lift.symbols<Real>("humidity");
        return absorption_of_air(temperature, humidity, lift.symbols<Real>("frequency"));
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
    lift_function("arrival_time", [](Lift &lift) {
        Vector offset = lift.symbols<Vector>("offset");
        Vector velocity = lift.symbols<Vector>("velocity");
        return arrival_time(offset, velocity, lift.symbols<Real>("speed"));
    });
}

static void lift_functions()
{
    lift_paths();
    lift_curvatures();
    lift_levels();
    lift_air();
    lift_times();
}
