/* UltrasonicSensor: rays, one or a cone of them; what other simulators do. */

/* Where along the ray the ball begins, INFINITY if the ray does not meet it from outside. */
static double ray_to_ball(Vector origin, Vector direction, Vector center, double radius)
{
    Vector offset = subtract(origin, center);
    double along = dot(offset, direction);
    double inside = dot(offset, offset) - radius * radius;
    double square = along * along - inside;
    return along < 0.0 && inside > 0.0 && square >= 0.0 ? -along - sqrt(square) : INFINITY;
}

/* The same for the wall of the capsule, between its caps: the problem in the cross-section. */
static double ray_to_wall(Vector origin, Vector direction, const Target *target)
{
    Vector whole = subtract(target->end, target->start);
    double square = dot(whole, whole);
    if (!(square > 0.0)) {
        return INFINITY;
    }
    Vector offset = subtract(origin, target->start);
    Vector flat_offset = add_scaled(offset, -dot(offset, whole) / square, whole);
    Vector flat = add_scaled(direction, -dot(direction, whole) / square, whole);
    double sine = norm(flat);
    if (!(sine > 0.0)) {
        return INFINITY;
    }
    double distance = ray_to_ball(flat_offset, scale(1.0 / sine, flat), vector(0.0, 0.0, 0.0), target->radius) / sine;
    double share = dot(add_scaled(offset, distance, direction), whole) / square;
    return share >= 0.0 && share <= 1.0 ? distance : INFINITY;
}

static double ray_to_target(Vector origin, Vector direction, const Target *target)
{
    Vector nearest = axis_point(target, nearest_share(target, origin));
    if (norm(subtract(origin, nearest)) <= target->radius) {
        return INFINITY; /* blind from within */
    }
    double start = ray_to_ball(origin, direction, target->start, target->radius);
    double end = ray_to_ball(origin, direction, target->end, target->radius);
    return lesser(ray_to_wall(origin, direction, target), lesser(start, end));
}

static double ray_to_plane(const Surroundings *around, Vector direction)
{
    double descent = -dot(around->plane_normal, direction);
    double height = dot(around->plane_normal, subtract(around->middle, around->plane_point));
    return around->plane && descent > 0.0 ? height / descent : INFINITY;
}

/* Between the slabs of the box; INFINITY from within. */
static double ray_to_box(Vector origin, Vector direction, const Box *box)
{
    double enter = -INFINITY, leave = INFINITY;
    Vector offset = subtract(origin, box->center);
    for (int i = 0; i < AXES; i++) {
        double place = dot(offset, box->axis[i]), slope = dot(direction, box->axis[i]);
        if (slope == 0.0 && fabs(place) > box->half[i]) {
            return INFINITY;
        }
        /* parallel and between: from -infinity to infinity */
        double first = (-box->half[i] - place) / slope, second = (box->half[i] - place) / slope;
        enter = greater(enter, lesser(first, second));
        leave = lesser(leave, greater(first, second));
    }
    return enter > 0.0 && enter <= leave ? enter : INFINITY;
}

static double ray_length(const Surroundings *around, Vector direction)
{
    double length = ray_to_plane(around, direction);
    if (around->box_present) {
        length = lesser(length, ray_to_box(around->middle, direction, &around->box));
    }
    for (int i = 0; i < around->targets; i++) {
        length = lesser(length, ray_to_target(around->middle, direction, &around->target[i]));
    }
    return length;
}

/* The point of the box nearest to another. */
static Vector nearest_of_box(const Box *box, Vector from)
{
    Vector offset = subtract(from, box->center), nearest = box->center;
    for (int i = 0; i < AXES; i++) {
        double place = lesser(greater(dot(offset, box->axis[i]), -box->half[i]), box->half[i]);
        nearest = add_scaled(nearest, place, box->axis[i]);
    }
    return nearest;
}

enum { RINGS = 2, SPOKES = 12 }; /* rays of the cone, besides those straight at the targets */

/* The ray towards a point, if it lies in the cone. */
static double length_within(const Surroundings *around, Vector towards, double cosine)
{
    Vector offset = subtract(towards, around->middle);
    double far = norm(offset);
    bool within = dot(offset, around->pair.axis) >= cosine * far && far > 0.0;
    return within ? ray_length(around, scale(1.0 / far, offset)) : INFINITY;
}

/* The least of the rays to what is nearest on each target and of those in rings about the axis. */
static double cone_length(const UltrasonicSensor *sensor, const Surroundings *around)
{
    Rotation turn = rotation(sensor->orientation);
    double half = 0.5 * sensor->field_of_view, cosine = cos(half);
    double length = ray_length(around, turn.x);
    length = lesser(length, length_within(around, subtract(around->middle, around->plane_normal), cosine));
    if (around->box_present) {
        length = lesser(length, length_within(around, nearest_of_box(&around->box, around->middle), cosine));
    }
    for (int i = 0; i < around->targets; i++) {
        const Target *target = &around->target[i];
        Vector center = axis_point(target, nearest_share(target, around->middle));
        length = lesser(length, length_within(around, center, cosine));
    }
    for (int i = 0; i < RINGS * SPOKES; i++) {
        double off = half * (i / SPOKES + 1) / (double)RINGS, about = 2.0 * PI * (i % SPOKES) / (double)SPOKES;
        Vector side = add(scale(cos(about), turn.y), scale(sin(about), turn.z));
        length = lesser(length, ray_length(around, add(scale(cos(off), turn.x), scale(sin(off), side))));
    }
    return length;
}

/* What a ray hits at some distance is reported as a plane that faces the sensor there. */
static Echo echo_of_ray(const UltrasonicSensor *sensor, double distance)
{
    if (!isfinite(distance)) {
        return silence;
    }
    double time = time_of_distance(distance, sensor->speed_of_sound, sensor->baseline);
    return plain_echo(time, facing_amplitude(sensor->speed_of_sound * time, sensor->absorption));
}
