/* UltrasonicSensor: the echo of each target by its mirror point. */
#define LAST_END 3.5   /* Fresnel's u from which a round end changes an echo by less than .003 */

/* The strip's or capsule's end as seen from a mirror point. */
typedef struct End {
    double slope, bend; /* first and second derivative of the path's length along the mirror, at the end */
    double length;      /* of the path by the end */
    double beams;       /* of both ways */
    double rise;        /* 1/m, of their logarithm, outward */
} End;

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

static bool hear_plane(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair, Echo *echo)
{
    Path path = plane_path(pair, around->plane_point, around->plane_normal, sensor->speed_of_sound);
    double spread = path.first + path.second;
    return hear_path(sensor, pair, &path, spread, at_rest, sensor->plane_reflection, echo)
        && (alone(around, PLANE) || hear_shaded(sensor, around, pair, PLANE, &path, spread, echo));
}

/* The path by a given surface point; what moves is taken where it is at the reception. */
static Path path_by(const Transceiver *pair, Vector point, Vector normal, double time, double speed)
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

/* Second derivative of the path's length along a straight line of the mirror. */
static double straight_bend(const Path *path, Vector along)
{
    double first = dot(path->incident, along), second = dot(path->reflected, along);
    return (1.0 - first * first) / path->first + (1.0 - second * second) / path->second;
}

static double beams_of(double there, double back)
{
    return piston_directivity(there) * piston_directivity(back);
}

/* Derivative, along the unit vector `along`, of the logarithm of a piston's amplitude on a way of `length` that meets
 * the surface along `direction`: (ln 2 J1(x) / x)' = -J2 / J1 x'. */
static double rise_of_beam(Vector direction, Vector axis, double length, double argument, Vector along,
                           double wave_number)
{
    double half = 0.5 * wave_number * PISTON_RADIUS, ahead = dot(direction, axis);
    double turn = (dot(along, axis) - ahead * dot(along, direction)) / length;
    return argument > 0.0 ? piston_dispersion(argument) / argument * half * half * ahead * turn : 0.0;
}

/* Where the wall of a capsule ends, `outward` along its axis, and its cap begins. */
static End end_of_wall(const UltrasonicSensor *sensor, const Transceiver *pair, const Path *mirror, Vector end,
                       Vector outward, double radius)
{
    double k = sensor->wave_number;
    Vector across = add_scaled(mirror->normal, -dot(mirror->normal, outward), outward);
    Vector normal = scale(1.0 / norm(across), across);
    Path path = path_by(pair, add_scaled(end, radius, normal), normal, mirror->time, sensor->speed_of_sound);
    double slope = dot(subtract(path.incident, path.reflected), outward);
    double lit = dot(subtract(path.reflected, path.incident), normal);
    Vector back = scale(-1.0, path.reflected);
    double argument = beam_argument(path.incident, pair->axis, k);
    double argument_back = beam_argument(back, pair->receiver_axis, k);
    double rise = rise_of_beam(path.incident, pair->axis, path.first, argument, outward, k);
    double rise_back = rise_of_beam(back, pair->receiver_axis, path.second, argument_back, outward, k);
    return (End){.slope = lit > 0.0 ? slope : INFINITY,
                 .bend = straight_bend(&path, outward),
                 .length = path.first + path.second,
                 .beams = beams_of(argument, argument_back),
                 .rise = rise + rise_back};
}

/* What lies beyond an end on a side bent by `bend`, in shares of an endless line bent by `unit`. With the amplitude
 * 1 + rise s along it,
 *     integral of (1 + rise s) exp(-i k (L' s + L'' s^2 / 2)) = (1 - rise L' / L'') e + rise / (i k L'') */
static Phasor tail_of_side(End end, double rise, double bend, double unit, double wave_number)
{
    double slope = fabs(end.slope), share = sqrt(unit / bend);
    Phasor tail = end_of_mirror(slope * sqrt(wave_number / (PI * bend)));
    double kept = share * (1.0 - rise * slope / bend), risen = 0.5 * share * rise / sqrt(PI * wave_number * bend);
    return (Phasor){kept * tail.re + risen, kept * tail.im - risen};
}

/* What the far side of an end, bent by `far_bend`, is in place of the near side, and without the beams. Both leave the
 * end at the same slope, so that far from the mirror point they cancel. */
static Phasor beyond(End end, double rise, double near_bend, double far_bend, double length, double wave_number)
{
    Phasor far = tail_of_side(end, rise, far_bend, near_bend, wave_number);
    Phasor near = tail_of_side(end, rise, near_bend, near_bend, wave_number);
    return phasor_product(phasor_sum(far, -1.0, near), phasor_at(-wave_number * (end.length - length)));
}

/* Whether an end, the square of its distance from the mirror point given, may change the echo. Quick and on the safe
 * side: the slope there is at least 2 away / hypot(leg, away); as an end's 1 / u is taken back by what lies beyond,
 * 1 / u^3 is left, in shares of the mirror bent by `near_bend`. */
static bool end_counts(double away_square, double leg, double near_bend, double cap_bend, double wave_number)
{
    double last = LAST_END * LAST_END * PI * cap_bend * (leg * leg + away_square), u = 4.0 * away_square * wave_number;
    return u * u * u * cap_bend <= last * last * last * near_bend;
}

/* A capsule's wall goes over into its caps: near there both make the echo. */
static void blend(const UltrasonicSensor *sensor, const Transceiver *pair, const Target *target, const Path *mirror,
                  double share, Echo *echo)
{
    Vector whole = subtract(target->end, target->start);
    double square = dot(whole, whole), k = sensor->wave_number;
    double round = dot(subtract(mirror->reflected, mirror->incident), mirror->normal) / target->radius;
    double leg = greater(mirror->first, mirror->second), wall_bend = 2.0 / lesser(mirror->first, mirror->second);
    double cap_bend = wall_bend + round, nearest = lesser(share, 1.0 - share);
    if (!end_counts(nearest * nearest * square, leg, wall_bend, cap_bend, k)) {
        return;
    }
    double size = sqrt(square), length = mirror->first + mirror->second;
    Phasor ends = {0.0, 0.0};
    bool changed = false;
    for (int side = 0; side < 2; side++) {
        bool on_cap = share == (double)side;
        double away = side == 0 ? share * size : (1.0 - share) * size;
        if (!on_cap && (share == 0.0 || share == 1.0)) {
            continue; /* the far cap of a capsule whose near one answers */
        }
        if (!end_counts(away * away, leg, on_cap ? cap_bend : wall_bend, cap_bend, k)) {
            continue;
        }
        Vector outward = scale(side == 0 ? -1.0 / size : 1.0 / size, whole);
        Vector center = side == 0 ? target->start : target->end;
        End end = end_of_wall(sensor, pair, mirror, center, outward, target->radius);
        if (isfinite(end.slope)) {
            double cap = end.bend + round;
            Phasor change = on_cap ? beyond(end, -end.rise, cap, end.bend, length, k)
                                   : beyond(end, end.rise, end.bend, cap, length, k);
            ends = phasor_sum(ends, end.beams, change);
            changed = true;
        }
    }
    if (changed) {
        Phasor mirror_point = {1.0, 0.0};
        weigh(echo, phasor_sum(mirror_point, 1.0 / beams_of(echo->there, echo->back), ends));
    }
}

static bool hear_target(const UltrasonicSensor *sensor, const Surroundings *around, int number, const Transceiver *pair,
                        Echo *echo)
{
    const Target *target = &around->target[number];
    Vector whole = subtract(target->end, target->start);
    double square = dot(whole, whole), share;
    Path path = target_path(target, pair, sensor->speed_of_sound, &share);
    /* a solid plane hides what lies behind it */
    if (around->plane && dot(subtract(path.point, around->plane_point), around->plane_normal) < 0.0) {
        return false;
    }
    Curvature mirror = sphere_curvature(path, target->radius);
    if (share > 0.0 && share < 1.0) {
        mirror = cylinder_curvature(path, scale(1.0 / sqrt(square), whole), target->radius);
    }
    double spread = sqrt(spreading_square(path, mirror));
    bool heard = hear_path(sensor, pair, &path, spread, target->velocity, target->reflection, echo)
        && (alone(around, number) || hear_shaded(sensor, around, pair, number, &path, spread, echo));
    if (heard && square > 0.0) {
        blend(sensor, pair, target, &path, share, echo);
    }
    return heard;
}

/* A part of what a strip between -half and half reflects: its mirror point, if it has it, or an end. */
typedef struct Part {
    double place;
    double sign; /* of an end: -1 where it takes from the mirror point's echo, 1 where it is all there is; else 0 */
} Part;

enum { MOST_PARTS = 3 };

static int parts_of_strip(double mirror, double half, Part parts[MOST_PARTS])
{
    int count = 0;
    if (fabs(mirror) < half) {
        parts[count++] = (Part){mirror, 0.0};
    }
    parts[count++] = (Part){-half, mirror > -half ? -1.0 : 1.0};
    parts[count++] = (Part){half, mirror < half ? -1.0 : 1.0};
    return count;
}

/* Of a side bent by `bend` that meets the sound at `slope`. */
static Phasor part_weight(double slope, double bend, double sign, double wave_number)
{
    return sign == 0.0 ? (Phasor){1.0, 0.0} : scaled(sign, end_of_mirror(fabs(slope) * sqrt(wave_number / (PI * bend))));
}

#define FAINT_PART 1e-6 /* of the plane's power */

/* The echo by a point of a face where its sides along `a` and `b` have their mirror point or end. */
static bool hear_part(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair,
                      const Path *path, Vector a, Vector b, double sign_a, double sign_b, Echo *echo)
{
    double near = 1.0 / path->first, far = 1.0 / path->second, k = sensor->wave_number;
    double there_a = dot(path->incident, a), there_b = dot(path->incident, b);
    double back_a = dot(path->reflected, a), back_b = dot(path->reflected, b);
    double bend_a = (1.0 - there_a * there_a) * near + (1.0 - back_a * back_a) * far;
    double bend_b = (1.0 - there_b * there_b) * near + (1.0 - back_b * back_b) * far;
    Phasor weight = phasor_product(part_weight(there_a - back_a, bend_a, sign_a, k),
                                   part_weight(there_b - back_b, bend_b, sign_b, k));
    /* Kirchhoff's obliquity over the size of the zone that answers; 1 at the mirror point */
    double oblique = 0.5 * dot(subtract(path->reflected, path->incident), path->normal);
    weight = scaled(oblique * (near + far) / sqrt(bend_a * bend_b), weight);
    double power = square_of(weight), spread = path->first + path->second;
    if (power < FAINT_PART || !hear_path(sensor, pair, path, spread, at_rest, sensor->box_reflection, echo)) {
        return false;
    }
    echo->strength = scaled(echo->strength.re, weight);
    echo->amplitude *= sqrt(power);
    return alone(around, BOX) || hear_shaded(sensor, around, pair, BOX, path, spread, echo);
}

/* A face as a bounded plane: its mirror point, its edges and its corners, each where and when it is. */
static void add_face(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair, int across,
                     double side, Echoes *echoes)
{
    const Box *box = &around->box;
    int first = (across + 1) % AXES, second = (across + 2) % AXES;
    Vector a = box->axis[first], b = box->axis[second];
    Vector normal = scale(side, box->axis[across]);
    Vector foot = add_scaled(box->center, box->half[across], normal);
    bool seen = dot(subtract(pair->transmitter, foot), normal) > 0.0 && dot(subtract(pair->receiver, foot), normal) > 0.0;
    if (!seen) {
        return;
    }
    Path mirror = plane_path(pair, foot, normal, sensor->speed_of_sound);
    Vector offset = subtract(mirror.point, foot);
    Part along_a[MOST_PARTS], along_b[MOST_PARTS];
    int count_a = parts_of_strip(dot(offset, a), box->half[first], along_a);
    int count_b = parts_of_strip(dot(offset, b), box->half[second], along_b);
    for (int i = 0; i < count_a * count_b; i++) {
        Part at_a = along_a[i % count_a], at_b = along_b[i / count_a];
        Vector point = add_scaled(add_scaled(foot, at_a.place, a), at_b.place, b);
        bool hidden = around->plane && dot(subtract(point, around->plane_point), around->plane_normal) < 0.0;
        if (!hidden) {
            Path path = path_by(pair, point, normal, mirror.time, sensor->speed_of_sound);
            keep_next(echoes, hear_part(sensor, around, pair, &path, a, b, at_a.sign, at_b.sign, next_echo(echoes)));
        }
    }
}

/* By one pair: the sensor's own, or with one of the two mirrored at the ground. */
static void add_echoes_of_targets(const UltrasonicSensor *sensor, const Surroundings *around, const Transceiver *pair,
                                  double bounce, Echoes *echoes)
{
    int before = echoes->count;
    for (int i = 0; i < around->targets; i++) {
        keep_next(echoes, hear_target(sensor, around, i, pair, next_echo(echoes)));
    }
    for (int face = 0; face < 2 * AXES && around->box_present; face++) {
        add_face(sensor, around, pair, face / 2, face % 2 ? 1.0 : -1.0, echoes);
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
