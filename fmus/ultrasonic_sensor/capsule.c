/* UltrasonicSensor: the echo of a round body, and of the ends of a capsule's wall. */
#define LAST_END 3.5 /* Fresnel's u from which a round end changes an echo by less than .003 */

/* The end of a capsule's wall as seen from a mirror point. */
typedef struct End {
    double slope, bend; /* first and second derivative of the path's length along the mirror, at the end */
    double length;      /* of the path by the end */
    double beams;       /* of both ways */
    double rise;        /* 1/m, of their logarithm, outward */
} End;

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
    return phasor_product(phasor_sum(far, -1.0, near), turned_back(wave_number / (2.0 * PI) * (end.length - length)));
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
    if (behind_plane(around, path.point)) {
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
