/* UltrasonicSensor: where a round body mirrors the sound. */
enum {
    MOST_REFINEMENTS = 30, /* at rest one or two will do, at half the speed of sound all */
    MOST_SIDES = 3,        /* the wall and a cap, and where rounding cannot tell once more */
};

#define CLOSE_AIM 1e-6 /* of the leg: an error e in the aim costs e^2 of it, 1 pm a metre */

/* Within 8 % of the length, without a root. */
static double about_length(Vector a)
{
    return 0.52 * greater(fabs(a.x), greater(fabs(a.y), fabs(a.z))) + 0.4 * most_of(a);
}

/* Where the normal of a mirror at rest aims; `length` is about that of the offset. */
static Aim aim_of(const Sight *sight, double length)
{
    Aim aim = aim_at(*sight, first_aim(*sight, length));
    double low = -1.0, high = 1.0;
    for (int i = 0; i < MOST_REFINEMENTS; i++) {
        double close = CLOSE_AIM * (aim.reach - sight->radius);
        if (aim.change * aim.change * sight->half <= close * close) {
            break;
        }
        aim = aim_at(*sight, next_between(&low, &high, aim.place, -aim.change, 1.0));
    }
    return aim;
}

/* The plane that touches a target. */
typedef struct Touch {
    Vector point, normal;
    double share; /* of the target's axis, where it touches */
} Touch;

static bool on_wall(double share)
{
    return share > 0.0 && share < 1.0;
}

/* Of a target at rest, where it mirrors: on its wall or on a cap, as the middle of the pair lies; or as the aim that
 * this leads to lies after all. */
static Touch touch(const Target *target, Vector transmitter, Vector receiver)
{
    Vector whole = subtract(target->end, target->start), half = scale(0.5, subtract(receiver, transmitter));
    Vector middle = add(transmitter, half);
    double square = dot(whole, whole), middle_share = 0.0, slide = 0.0;
    if (square > 0.0) {
        double unit = 1.0 / square;
        middle_share = unit * dot(subtract(middle, target->start), whole);
        slide = unit * dot(half, whole);
    }
    double share = middle_share;
    Vector center, normal;
    for (int i = 0; i < MOST_SIDES; i++) {
        bool wall = on_wall(share);
        double foot = wall ? middle_share : within_axis(share);
        center = axis_point(target, foot);
        Vector offset = subtract(middle, center), across = add_scaled(half, wall ? -slide : 0.0, whole);
        Sight sight = {dot(offset, offset), dot(offset, across), dot(across, across), target->radius};
        Aim aim = aim_of(&sight, about_length(offset));
        normal = scale(1.0 / aim.reach, add_scaled(offset, aim.place, across));
        share = middle_share + aim.place * slide;
        if (wall ? on_wall(share) : within_axis(share) == foot) {
            break;
        }
    }
    return (Touch){add_scaled(center, target->radius, normal), normal, within_axis(share)};
}

/* There and back from the middle of the pair. */
static double about_time(const Target *target, const Transceiver *pair, double speed)
{
    Vector middle = scale(0.5, add(pair->transmitter, pair->receiver));
    return 2.0 / speed * (norm(subtract(middle, axis_point(target, nearest_share(target, middle)))) - target->radius);
}

/* By a target at rest; its share of the target's axis is written. The receiver is aimed at where it hears the echo. */
static Path resting_path(const Target *target, const Transceiver *pair, double speed, double *share)
{
    double ear = most_of(pair->velocity), late = ear > 0.0 ? about_time(target, pair, speed) : 0.0;
    Path path = {0};
    for (int i = 0; i < MOST_REFINEMENTS; i++) {
        Touch plane = touch(target, pair->transmitter, add_scaled(pair->receiver, late, pair->velocity));
        path = plane_path(pair, plane.point, plane.normal, speed);
        *share = plane.share;
        if (fabs(path.time - late) * ear <= CLOSE_AIM * path.first) {
            break;
        }
        late = path.time;
    }
    return path;
}

/* By a ball that moves. */
static Path moving_path(Ball ball, const Transceiver *pair, double speed)
{
    Vector line = subtract(pair->receiver, pair->transmitter), half = scale(0.5, line);
    Vector offset = subtract(add(pair->transmitter, half), ball.center);
    Sight sight = {dot(offset, offset), dot(offset, half), dot(half, half), ball.radius};
    Aim aim = aim_of(&sight, about_length(offset));
    Path path = {.time = 2.0 * (aim.reach - ball.radius) / speed, .share = 0.5 + 0.5 * aim.place};
    path.bounce_time = path.share * path.time;
    double baseline = most_of(line), drift = most_of(ball.velocity), ear = most_of(pair->velocity);
    for (int i = 0; i < MOST_REFINEMENTS; i++) {
        Path next = ball_path_refined(pair, path, ball, speed);
        next.share = lesser(greater(next.share, 0.0), 1.0);
        double moved = fabs(next.share - path.share) * baseline + fabs(next.bounce_time - path.bounce_time) * drift
            + fabs(next.time - path.time) * ear;
        path = next;
        if (moved <= CLOSE_AIM * path.first) {
            break;
        }
    }
    return path;
}

/* By a target; where along its axis that is. Of all targets the sphere alone may move. */
static Path target_path(const Target *target, const Transceiver *pair, double speed, double *share)
{
    if (most_of(target->velocity) > 0.0) {
        *share = 0.0;
        return moving_path((Ball){target->start, target->velocity, target->radius}, pair, speed);
    }
    return resting_path(target, pair, speed, share);
}
